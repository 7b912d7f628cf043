"""Dynamic registration of tools (LTI Dynamic Registration 1.0): the description of the platform, and the check of a tool's request."""

import urllib.parse

from lti_book import demand, is_text
from lti_services import LINE_ITEM, MEMBERS, RESULT, SCORE

CONFIGURATION = "https://purl.imsglobal.org/spec/lti-platform-configuration"
TOOL_CONFIGURATION = "https://purl.imsglobal.org/spec/lti-tool-configuration"


def describe_platform(platform):
    """Returns the OpenID configuration of a platform."""
    names = {"authorization": "auth", "registration": "register", "token": "token"}
    found = {f"{name}_endpoint": f"{platform.url}/{path}" for name, path in names.items()}
    messages = [{"type": "LtiResourceLinkRequest"}, {"type": "LtiDeepLinkingRequest"}]
    variables = ["User.id", "Person.sourcedId"]
    claims = ["iss", "sub", "name", "email"]
    about = {"product_family_code": "stand-in", "version": "1", "messages_supported": messages, "variables": variables}
    found |= {
        "issuer": platform.issuer,
        "jwks_uri": f"{platform.url}/keys",
        "token_endpoint_auth_methods_supported": ["private_key_jwt"],
        "token_endpoint_auth_signing_alg_values_supported": ["RS256"],
        "id_token_signing_alg_values_supported": ["RS256"],
        "scopes_supported": ["openid", LINE_ITEM, f"{LINE_ITEM}.readonly", SCORE, RESULT, MEMBERS],
        "response_types_supported": ["id_token"],
        "subject_types_supported": ["public"],
        "claims_supported": claims,
        CONFIGURATION: about,
    }
    return found


def check_registration(asked):
    """Checks what a tool registers, by LTI Dynamic Registration 1.0."""
    demand(asked.get("application_type") == "web", "application_type")
    demand(asked.get("response_types") == ["id_token"], "response_types")
    demand({"implicit", "client_credentials"} <= set(asked.get("grant_types", [])), "grant_types")
    demand(asked.get("token_endpoint_auth_method") == "private_key_jwt", "token_endpoint_auth_method")
    for name in ("initiate_login_uri", "jwks_uri", "client_name", "scope"):
        demand(is_text(asked.get(name)), f"{name} is required")
    demand(asked.get("redirect_uris") and all(map(is_text, asked["redirect_uris"])), "redirect_uris")
    tool = asked.get(TOOL_CONFIGURATION, {})
    demand(is_text(tool.get("domain")) and is_text(tool.get("target_link_uri")), "domain and target_link_uri")
    demand(tool["domain"] == urllib.parse.urlsplit(tool["target_link_uri"]).netloc, "domain is that of target_link_uri")
    kinds = {"LtiResourceLinkRequest", "LtiDeepLinkingRequest"}
    demand(tool.get("messages") and {message.get("type") for message in tool["messages"]} <= kinds, "messages")
    demand(isinstance(tool.get("claims"), list), "claims")

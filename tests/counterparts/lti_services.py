"""The services of a learning platform for its tools, with lti1p3platform: access tokens, line items, scores, results and members."""

import hashlib
import itertools
import json
import threading
import urllib.parse
import uuid

import jwt
from lti1p3platform.exceptions import LtiException, LtiServiceException
from lti1p3platform.ltiplatform import LTI1P3PlatformConfAbstract
from lti1p3platform.membership import Context
from lti1p3platform.message_launch import LTIAdvantageMessageLaunchAbstract
from lti1p3platform.registration import Registration
from lti1p3platform.request import Request
from lti1p3platform.response import Response
from lti1p3platform.score import UpdateScoreStatus
from lti1p3platform.service_connector import AssignmentsGradesService, NamesRoleProvisioningService
from lti_book import demand, read_item

AGS = "https://purl.imsglobal.org/spec/lti-ags/scope/"
LINE_ITEM, SCORE, RESULT = f"{AGS}lineitem", f"{AGS}score", f"{AGS}result.readonly"
MEMBERS = "https://purl.imsglobal.org/spec/lti-nrps/scope/contextmembership.readonly"
ASSERTION = "urn:ietf:params:oauth:client-assertion-type:jwt-bearer"
CLAIM = "https://purl.imsglobal.org/spec/lti/claim/"
ITEM_TYPE, ITEMS_TYPE, SCORE_TYPE, RESULTS_TYPE, MEMBERS_TYPE = (
    f"application/vnd.ims.{name}+json"
    for name in ("lis.v2.lineitem", "lis.v2.lineitemcontainer", "lis.v1.score", "lis.v2.resultcontainer", "lti-nrps.v2.membershipcontainer")
)
# Longest life of a client assertion, in s.
LONGEST_ASSERTION_S = 300
PAGE = 10
PAGE_OF_MEMBERS = 50
COURSE = "course-1"


class Tool(Registration):
    """The registration of a tool, with the platform's present key."""

    def __init__(self, platform, client_id, launch_url):
        self.platform = platform
        self.set_iss(platform.issuer).set_client_id(client_id).set_deployment_id(f"deployment-{client_id}")
        self.set_launch_url(launch_url).set_deeplink_launch_url(launch_url)

    def get_platform_private_key(self):
        return self.platform.private_key

    def get_platform_public_key(self):
        return self.platform.public_key

    @staticmethod
    def encode_and_sign(payload, private_key, headers=None, expiration=None):
        """Signs an access token; without an id, two of one second would be the same."""
        return Registration.encode_and_sign(payload | {"jti": uuid.uuid4().hex}, private_key, headers, expiration)


class Client(LTI1P3PlatformConfAbstract):
    """The rights of a tool. It signs its messages by published keys, and gets access tokens."""

    def init_platform_config(self, tool, token_url):
        self._registration, self.token_url = tool, token_url
        self.used, self.revoked = set(), set()
        # lti1p3platform keeps the header of a message here between two calls.
        self.lock = threading.Lock()
        # lti1p3platform grants every scope that it knows.
        self.scopes = {LINE_ITEM, f"{LINE_ITEM}.readonly", SCORE, RESULT, MEMBERS}

    def get_registration_by_params(self, **_):
        return self._registration

    def get_tool_public_key(self):
        """Returns the key that a message names; the key set is fetched anew if the key is not in it."""
        try:
            return super().get_tool_public_key()
        except LtiException:
            self._registration.set_tool_key_set(None)
            return super().get_tool_public_key()

    def read_message(self, token):
        """Returns the claims of a message that the tool has signed, which may be used once."""
        try:
            with self.lock:
                claims = self.tool_validate_and_decode(token)
        except (LtiException, jwt.PyJWTError, ValueError) as error:
            raise LtiServiceException(f"the signature: {error!r}", 401) from error
        demand(claims.get("iss") == self._registration.get_client_id(), "iss is the client id", 401)
        demand({"iat", "exp"} <= claims.keys(), "iat and exp are required", 401)
        once = claims.get("jti") or claims.get("nonce")
        demand(once and once not in self.used, f"used before, or not to tell apart: {once}", 401)
        self.used.add(once)
        return claims

    def check_assertion(self, form):
        claims = self.read_message(form.get("client_assertion", ""))
        demand("jti" in claims, "jti is required", 401)
        demand(claims.get("sub") == claims["iss"], "sub is the client id", 401)
        audience = claims.get("aud")
        demand(self.token_url in (audience if isinstance(audience, list) else [audience]), f"another audience: {audience}", 401)
        demand(claims["exp"] - claims["iat"] <= LONGEST_ASSERTION_S, "an assertion that lives too long", 401)

    def grant(self, form):
        """Returns the answer with an access token."""
        demand(form.get("grant_type") == "client_credentials", "grant_type")
        demand(form.get("client_assertion_type") == ASSERTION, "client_assertion_type")
        self.check_assertion(form)
        asked = set(form.get("scope", "").split()) & self.scopes
        demand(asked, f"scope: {form.get('scope')}")
        return self.get_access_token(form | {"scope": " ".join(sorted(asked))})

    def validate_token(self, token, allowed_scopes=None, audience=None):
        """Returns whether a token is valid for one of some scopes."""
        if token_sha256(token) in self.revoked:
            return False
        try:
            is_valid = super().validate_token(token, None, audience)
        except (LtiException, jwt.PyJWTError) as error:
            raise LtiServiceException(f"the access token: {error!r}", 401) from error
        demand(is_valid and super().validate_token(token, allowed_scopes, audience), f"a token without {allowed_scopes}", 403)
        return True

    def revoke(self, token):
        """Lets a token end before its time."""
        self.revoked.add(token_sha256(token))


def token_sha256(token):
    return hashlib.sha256(token.encode()).hexdigest()


def read_unverified(token, claim):
    """Returns a claim of a token whose signature is yet to be verified; None if it cannot be read."""
    try:
        return jwt.decode(token, options={"verify_signature": False}).get(claim)
    except jwt.PyJWTError:
        return None


class Asked(Request):
    """A request as lti1p3platform reads it; the pages of lists are numbers there."""

    def build_metadata(self, request):
        query = {name: int(value) if name in ("page", "limit") else value for name, value in request.query.items()}
        return {
            "method": request.method,
            "get_data": query,
            "form_data": request.form,
            "headers": request.headers,
            "content_type": request.headers.get("Content-Type"),
            "path": request.path,
            "json": request.body,
        }


def cut_page(found, page, limit, most):
    """Returns a page of a list, as lti1p3platform wants it."""
    size = min(limit or most, most)
    demand(page >= 1 and size >= 1, "page and limit are positive")
    return {"content": found[(page - 1) * size : page * size], "has_next": page * size < len(found)}


class Grades(AssignmentsGradesService):
    """Line items, scores and results of a course, with a token for certain scopes."""

    def __init__(self, asked, platform, client, scopes):
        super().__init__(asked, client, f"{platform.url}/items")
        self.platform, self.book, self.scopes = platform, platform.book, scopes

    @property
    def allowed_scopes(self):
        return self.scopes

    def show(self, number):
        return self.book.find_item(number) | {"id": self.platform.item_url(number)}

    def find_lineitems(self, page=1, limit=None, **wanted):
        names = {"resource_link_id": "resourceLinkId", "resource_id": "resourceId", "tag": "tag"}
        demand(wanted.keys() <= names.keys(), f"unknown: {wanted}")
        items = [self.show(number) for number in sorted(self.book.items)]
        found = [item for item in items if all(item.get(names[name]) == value for name, value in wanted.items())]
        return cut_page(found, page, limit, PAGE)

    def find_lineitem(self, line_item_id):
        return self.show(line_item_id)

    def create_lineitem(self, creation_data):
        item = read_item(creation_data)
        demand("id" not in item, "the platform chooses the id")
        demand(item.get("resourceLinkId") in (None, *self.platform.links), f"no such link: {item.get('resourceLinkId')}")
        return self.show(self.book.add_item(item))

    def update_lineitem(self, update_data):
        number, text = update_data["id"], update_data["body"]
        self.book.find_item(number)
        self.book.items[number] = {name: value for name, value in read_item(text).items() if name != "id"}
        return self.show(number)

    def delete_lineitem(self, line_item_id):
        self.book.remove_item(line_item_id)

    def update_score(self, line_item_id, score):
        return self.book.record(line_item_id, score)

    def get_results(self, line_item_id, page=1, limit=None, user_id=None):
        self.book.find_item(line_item_id)
        kept = sorted((user, score) for (number, user), score in self.book.scores.items() if number == line_item_id)
        url = self.platform.item_url(line_item_id, "/results")
        found = [show_result(url, user, score) for user, score in kept if user_id in (None, user)]
        return cut_page(found, page, limit, PAGE_OF_MEMBERS)


def show_result(url, user, score):
    result = {"id": f"{url}#{user}", "userId": user, "scoreOf": url.replace("/results", "")}
    if score.given is None:
        return result
    return result | {"resultScore": float(score.given), "resultMaximum": float(score.maximum)}


class Members(NamesRoleProvisioningService):
    """Names and roles of a course."""

    def __init__(self, asked, platform, client):
        super().__init__(asked, client, platform.members_url())
        self.members = platform.members

    def get_context_by_id(self):
        return Context(COURSE, "N1", "Nursing, first year")

    def is_resource_link_valid(self, context_id, resource_link_id):
        return context_id == COURSE and resource_link_id.startswith("link-")

    def get_member_data_page(self, page=1, limit=None, role=None, since=None, rlid=None):
        found = [dict(member) for member in self.members if role is None or role in member["roles"]]
        return cut_page(found, page, limit, PAGE_OF_MEMBERS)


class Launch(LTIAdvantageMessageLaunchAbstract):
    """A message for a tool."""

    def get_preflight_response(self):
        return self._request

    def render_launch_form(self, launch_data, **_):
        return launch_data


class Services:
    """Answers the requests of tools with a token."""

    def __init__(self, platform):
        self.platform = platform
        # Moodle answers a score with 200, ILIAS with 204, others with 201 or 202.
        self.success = itertools.cycle([200, 201, 202, 204])

    def find_client(self, request):
        """Returns the client of a token, which is not verified yet."""
        client = self.platform.clients.get(read_unverified(request.token(), "sub"))
        demand(client, "no valid access token", 401)
        return client

    def grades(self, request, *scopes):
        asked = Asked(request)
        self.remove_own_query(asked)
        return Grades(asked, self.platform, self.find_client(request), list(scopes))

    def remove_own_query(self, asked):
        """Removes the platform's own query from a request; an address without it leads nowhere."""
        for name, value in self.platform.own_query.items():
            demand(asked.get_data.pop(name, None) == value, f"an address without {name}={value}", 404)

    def items(self, request):
        if request.method == "POST":
            request.expect_type(ITEM_TYPE)
            service = self.grades(request, LINE_ITEM)
            return show(service.handle_resp(service.handle_create_lineitem))
        request.expect_accept(ITEMS_TYPE)
        service = self.grades(request, LINE_ITEM, f"{LINE_ITEM}.readonly")
        return self.show_page(service.handle_resp(service.handle_get_lineitems))

    def item(self, request, number):
        if request.method == "GET":
            request.expect_accept(ITEM_TYPE)
            service = self.grades(request, LINE_ITEM, f"{LINE_ITEM}.readonly")
            return show(service.handle_resp(lambda: service.handle_get_lineitem(line_item_id=number)))
        service = self.grades(request, LINE_ITEM)
        if request.method == "DELETE":
            return show(service.handle_resp(lambda: service.handle_delete_lineitem(number)))
        request.expect_type(ITEM_TYPE)
        service.request.request["json"] = {"body": request.body}
        return show(service.handle_resp(lambda: service.handle_update_lineitem(number)))

    def scores(self, request, number):
        request.expect_type(SCORE_TYPE)
        service = self.grades(request, SCORE)
        response = service.handle_resp(lambda: service.handle_update_score(number))
        if response.message not in (UpdateScoreStatus.SUCCESS.value, UpdateScoreStatus.CREATED.value):
            return show(response)
        code = next(self.success)
        body = {"resultUrl": self.platform.item_url(number, "/results")} if code == 200 else None
        return show(Response(body, code, response.message))

    def results(self, request, number):
        request.expect_accept(RESULTS_TYPE)
        service = self.grades(request, RESULT)
        service.ags.lineitem_url = f"{self.platform.url}/items/{number}"
        return self.show_page(service.handle_resp(lambda: service.handle_get_results(number)))

    def members(self, request):
        request.expect_accept(MEMBERS_TYPE)
        asked = Asked(request)
        asked.get_data.setdefault("limit", PAGE_OF_MEMBERS)
        service = Members(asked, self.platform, self.find_client(request))
        response = service.handle_resp(service.handle_get_members)
        link = response.result.pop("next", None) if response.result else None
        return show(response, link)

    def show_page(self, response):
        """Shows a list; lti1p3platform has the next page's address without the platform's own query."""
        if response.result is None:
            return show(response)
        link = response.result.get("next")
        if link and self.platform.own_query:
            link += "&" + urllib.parse.urlencode(self.platform.own_query)
        response.result = response.result["content"]
        return show(response, link)


def show(response, link=None):
    """Returns a response of lti1p3platform as status, headers and body."""
    headers = {"Content-Type": response.media_type} | ({"Link": f'<{link}>; rel="next"'} if link else {})
    if response.result is None:
        text = "" if response.code < 400 else json.dumps({"error": "invalid_request", "error_description": response.message})
        return response.code, headers, text.encode()
    return response.code, headers, json.dumps(response.result, default=float).encode()

"""A learning platform of LTI 1.3 Advantage, made of lti1p3platform: launches, deep links, line items, scores, members, registration.

    lti_platform.py     serves one until it is ended, and prints its addresses

It keeps a log of everything it receives, a book of scores (`lti_book.py`), and fails as planned (`lti_faults.py`).
"""

import json
import re
import secrets
import threading
import urllib.parse
from dataclasses import dataclass, field

from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import rsa
from lti1p3platform.exceptions import (
    LineItemNotFoundException,
    LtiDeepLinkingResponseException,
    LtiException,
    LtiServiceException,
    PreflightRequestValidationException,
)
from lti1p3platform.oidc_login import OIDCLoginAbstract
from lti1p3platform.registration import Registration
from lti_book import Book, demand, read_item
from lti_faults import Faults
from lti_http import HTML, JSON, refuse, reply, self_posting_page, serve
from lti_registration import TOOL_CONFIGURATION, check_registration, describe_platform
from lti_services import CLAIM, COURSE, Client, Launch, Services, Tool, read_unverified
from service import Browser, expect, free_address

ROLE = "http://purl.imsglobal.org/vocab/lis/v2/membership#"
LEARNER, INSTRUCTOR = f"{ROLE}Learner", f"{ROLE}Instructor"
DEEP_LINK = "https://purl.imsglobal.org/spec/lti-dl/claim/"
# Parameters of each request for a launch (1EdTech Security Framework 1.0, section 5.1.1.2).
REQUEST = {"scope": "openid", "response_type": "id_token", "response_mode": "form_post", "prompt": "none"}
# How lti1p3platform and the reading of a request fail on a bad one.
BAD = (LtiException, LtiDeepLinkingResponseException, PreflightRequestValidationException, ValueError, TypeError, KeyError, AttributeError)
# Endpoint, methods and path.
ROUTES = [
    ("keys", "GET", r"/keys"),
    ("auth", "GET POST", r"/auth"),
    ("token", "POST", r"/token"),
    ("items", "GET POST", r"/items"),
    ("item", "GET PUT DELETE", r"/items/(\d+)"),
    ("scores", "POST", r"/items/(\d+)/scores"),
    ("results", "GET", r"/items/(\d+)/results"),
    ("members", "GET", r"/members"),
    ("deep_link_return", "POST", r"/deep-link-return"),
    ("configuration", "GET", r"/\.well-known/openid-configuration"),
    ("register", "POST", r"/register"),
]


@dataclass
class Received:
    """A request in the log; `status` is 0 where the connection was cut."""

    endpoint: str
    method: str
    target: str
    body: str
    fault: str = ""
    status: int = 0


@dataclass
class Link:
    """A place in the course that leads to the tool."""

    id: str
    title: str
    custom: dict
    item: int | None = None
    target: str | None = None


@dataclass(frozen=True)
class Message:
    """Client, user and link of a launch. A deep linking request has no link, and `data` that the tool returns."""

    client: Client
    user: str
    link: Link | None
    data: str = field(default_factory=lambda: secrets.token_hex(16))


class Login(OIDCLoginAbstract):
    """The address at which a launch begins."""

    def set_lti_message_hint(self, hint):
        self._lti_message_hint = hint

    def get_redirect(self, url):
        return url


def make_key():
    """Returns a new key, private and public, as PEM."""
    key = rsa.generate_private_key(public_exponent=65537, key_size=2048)
    pem, form = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8
    private = key.private_bytes(pem, form, serialization.NoEncryption())
    public = key.public_key().public_bytes(pem, serialization.PublicFormat.SubjectPublicKeyInfo)
    return private.decode(), public.decode()


def make_members(count):
    """Returns members of a course. The first one teaches, every tenth has no address, and every fiftieth has left."""
    members = []
    for number in range(count):
        member = {"user_id": f"user-{number}", "roles": [LEARNER if number else INSTRUCTOR], "status": "Active"}
        member |= {"name": f"Name {number}", "email": f"user-{number}@uni.example", "lis_person_sourcedid": str(2026000 + number)}
        if number % 10 == 9:
            del member["email"]
        if number % 50 == 49:
            member["status"] = "Inactive"
        members.append(member)
    return members


class Platform:
    """A platform with one course. `own_query` is part of the addresses of its line items, such as `{"type": "lti"}`."""

    def __init__(self, people=450, own_query=None):
        self.address = free_address().replace("127.0.0.1", "localhost")
        self.url = self.issuer = f"http://{self.address}"
        self.own_query = own_query or {}
        self.members = make_members(people)
        self.people = {member["user_id"]: member for member in self.members}
        self.book = Book(self.people)
        self.clients, self.links, self.messages, self.offers = {}, {}, {}, set()
        self.faults, self.log, self.ended = Faults(), [], threading.Event()
        self.services = Services(self)
        self.rotate_key()
        serve(self.address, self.handle)

    def rotate_key(self):
        """Replaces the key of the platform: access tokens end, and launches are signed by the new one."""
        self.private_key, self.public_key = make_key()

    def item_url(self, number, rest=""):
        return f"{self.url}/items/{number}{rest}{self.shown_query()}"

    def items_url(self):
        return f"{self.url}/items{self.shown_query()}"

    def members_url(self):
        return f"{self.url}/members"

    def shown_query(self):
        return "?" + urllib.parse.urlencode(self.own_query) if self.own_query else ""

    def add_tool(self, client_id, login_url, launch_url, keys_url):
        """Registers a tool and deploys it."""
        tool = Tool(self, client_id, launch_url).set_oidc_login_url(login_url).set_tool_key_set_url(keys_url)
        self.clients[client_id] = Client(tool=tool, token_url=f"{self.url}/token")
        return self.clients[client_id]

    def add_link(self, title, custom, has_item=True):
        """Adds a link to the course, with a line item unless the tool is to make one."""
        link = Link(f"link-{len(self.links) + 1}", title, custom)
        if has_item:
            link.item = self.book.add_item({"label": title, "scoreMaximum": 100.0, "resourceLinkId": link.id})
        self.links[link.id] = link
        return link

    def begin_launch(self, client, user, link=None):
        """Returns the address at which a user's launch begins; without a link, that of a deep linking request."""
        hint = secrets.token_hex(8)
        self.messages[hint] = Message(client, user, link)
        login = Login(None, client)
        login.set_lti_message_hint(hint)
        if link and link.target:
            login.set_launch_url(link.target)
        return login.initiate_login(user)

    def offer_registration(self, register_url):
        """Returns the address at which a tool registers itself."""
        token = secrets.token_hex(16)
        self.offers.add(token)
        query = {"openid_configuration": f"{self.url}/.well-known/openid-configuration", "registration_token": token}
        return f"{register_url}?{urllib.parse.urlencode(query)}"

    # Endpoints. Each returns status, headers and body.

    def keys(self, _):
        return reply({"keys": [Registration.get_jwk(self.public_key)]})

    def auth(self, request):
        """Confirms the user of a launch: a page that posts a signed message to the tool."""
        asked = request.query | request.form
        message = self.messages.get(asked.get("lti_message_hint"))
        demand(message, "an unknown lti_message_hint")
        demand(REQUEST.items() <= asked.items(), f"the request: {asked}")
        tool = message.client.get_registration()
        demand(asked.get("redirect_uri") == tool.get_launch_url(), f"redirect_uri: {asked.get('redirect_uri')}")
        demand(asked.get("login_hint") == message.user, f"login_hint: {asked.get('login_hint')}")
        launch = Launch(asked, message.client)
        self.fill(launch, message)
        form = launch.lti_launch()
        fields = {"state": form["state"], "id_token": form["id_token"]}
        return 200, {"Content-Type": HTML}, self_posting_page(form["launch_url"], fields).encode()

    def fill(self, launch, message):
        """Writes user, course, link and services into a message."""
        user, link = self.people[message.user], message.link
        launch.set_user_data(message.user, user["roles"], user.get("name"), user.get("email"))
        launch.set_launch_context_claim(COURSE, context_title="Nursing, first year")
        launch.set_extra_claims({f"{CLAIM}lis": {"person_sourcedid": user["lis_person_sourcedid"]}})
        launch.set_ags(self.items_url(), self.item_url(link.item) if link and link.item else None)
        launch.set_nrps(self.members_url())
        if not link:
            launch.set_dl(f"{self.url}/deep-link-return", accept_types={"ltiResourceLink"}, extra_data=message.data)
            return
        launch.set_resource_link_claim(link.id, title=link.title)
        launch.set_custom_parameters_claim(link.custom)
        if link.target:
            launch.set_launch_url(link.target)

    def token(self, request):
        request.expect_type("application/x-www-form-urlencoded")
        client = self.clients.get(read_unverified(request.form.get("client_assertion", ""), "iss"))
        demand(client, "an unknown client", 401)
        return reply(client.grant(request.form))

    def deep_link_return(self, request):
        """Takes the links that a tool returns into the course."""
        token = request.form.get("JWT", "")
        client = self.clients.get(read_unverified(token, "iss"))
        demand(client, "an unknown client", 401)
        claims = client.read_message(token)
        audience = claims.get("aud")
        demand(self.issuer in (audience if isinstance(audience, list) else [audience]), f"another audience: {audience}", 401)
        demand(claims.get("nonce"), "nonce is required", 401)
        tool = client.get_registration()
        demand(claims.get(f"{CLAIM}deployment_id") == tool.get_deployment_id(), "another deployment")
        demand(claims.get(f"{CLAIM}version") == "1.3.0", "another version")
        asked = {message.data for message in self.messages.values() if message.link is None and message.client is client}
        demand(claims.get(f"{DEEP_LINK}data") in asked, "data is not that of a request")
        for item in client.validate_deeplinking_resp({"JWT": token}):
            self.take_link(item, tool)
        return 200, {"Content-Type": HTML}, b"<h1>Added</h1>"

    def take_link(self, content, tool):
        """Adds a link that a tool returned."""
        demand(content["type"] == "ltiResourceLink", f"type: {content['type']}")
        target, custom = content.get("url", tool.get_launch_url()), content.get("custom", {})
        demand(urllib.parse.urlsplit(target).netloc == urllib.parse.urlsplit(tool.get_launch_url()).netloc, f"url: {target}")
        demand(all(isinstance(value, str) for value in custom.values()), f"custom: {custom}")
        title = content.get("title", "Untitled")
        link = self.add_link(title, custom, has_item=False)
        link.target = target
        if "lineItem" in content:
            item = read_item(json.dumps({"label": title} | content["lineItem"]))
            link.item = self.book.add_item(item | {"resourceLinkId": link.id})

    def configuration(self, _):
        return reply(describe_platform(self))

    def register(self, request):
        """Registers a tool that came with the token of an offer."""
        demand(request.token() in self.offers, "an unknown registration token", 401)
        request.expect_type(JSON)
        asked = json.loads(request.body)
        check_registration(asked)
        self.offers.discard(request.token())
        client_id = secrets.token_hex(8)
        launch_url = asked["redirect_uris"][0]
        client = self.add_tool(client_id, asked["initiate_login_uri"], launch_url, asked["jwks_uri"])
        client.scopes &= set(asked["scope"].split())
        deployment = {"deployment_id": client.get_registration().get_deployment_id()}
        tool = asked[TOOL_CONFIGURATION] | deployment
        return reply(asked | {"client_id": client_id, TOOL_CONFIGURATION: tool}, 201)

    # Faults and the log.

    def answer(self, request, endpoint, methods, parts):
        """Returns the answer of an endpoint."""
        try:
            demand(endpoint, "no such address", 404)
            demand(request.method in methods, f"{request.method} is not allowed", 405)
            owner = self.services if endpoint in ("items", "item", "scores", "results", "members") else self
            return getattr(owner, endpoint)(request, *parts)
        except LtiServiceException as error:
            return refuse(error.status_code, error.message)
        except LineItemNotFoundException:
            return refuse(404, "no such line item")
        except BAD as error:
            return refuse(400, repr(error))

    def handle(self, request):
        """Returns the answer to a request, or that of its fault; None to cut the connection."""
        endpoint, methods, parts = find_route(request.path)
        fault = self.faults.take(endpoint)
        entry = Received(endpoint, request.method, request.target, request.body, fault.name if fault else "")
        self.log.append(entry)
        if not fault or fault.is_handled:
            answer = self.answer(request, endpoint, methods, parts)
        if fault:
            answer = self.fail(request, fault)
        entry.status = answer[0] if answer else 0
        return answer

    def fail(self, request, fault):
        fault.act()
        self.ended.wait(fault.stall_s)
        if fault.status == 401 and (client := self.clients.get(read_unverified(request.token(), "sub"))):
            client.revoke(request.token())
        return (fault.status, fault.headers, b"") if fault.status else None

    def received(self, endpoint):
        """Returns the log of an endpoint."""
        return [entry for entry in self.log if entry.endpoint == endpoint]


def find_route(path):
    """Returns name, methods and numbers of an endpoint; an empty name where there is none."""
    for endpoint, methods, pattern in ROUTES:
        if found := re.fullmatch(pattern, path):
            return endpoint, methods.split(), [int(part) for part in found.groups()]
    return "", [], []


def register(service, platform):
    """Registers a service and a platform at each other, and admits the deployment after its first launch; returns the client."""
    url = service.url
    client = platform.add_tool("client-1", f"{url}/lti/login", f"{url}/lti/launch", f"{url}/.well-known/jwks.json")
    own = service.add_platform("Stand-in", platform.issuer, "client-1", platform.url)
    refused = Browser(url).launch(platform.begin_launch(client, "user-1", platform.add_link("Home", {})))
    expect(refused.status == 403 and "code: deployment<" in refused.text, f"{refused.status} {refused.text}")
    service.admit(own, client.get_registration().get_deployment_id())
    return client


def main():
    platform = Platform()
    print(f"issuer {platform.issuer}, keys {platform.url}/keys, authorization {platform.url}/auth, token {platform.url}/token")
    platform.ended.wait()


if __name__ == "__main__":
    main()

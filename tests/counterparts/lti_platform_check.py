"""Checks the learning platform of this folder with a tool that others wrote, PyLTI1p3. Ends with the first error, or with status 0.

    lti_platform_check.py
"""

import json
import threading
import time
import urllib.parse
from datetime import datetime, timedelta, timezone
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import jwt
import requests
from lti_faults import CUT_AFTER, CUT_BEFORE, SERVER_ERROR, TOO_MANY, UNAUTHORIZED, Fault
from lti_platform import DEEP_LINK, REQUEST, Platform, make_key
from lti_registration import TOOL_CONFIGURATION
from lti_services import ASSERTION, ITEMS_TYPE, LINE_ITEM, MEMBERS_TYPE, SCORE, SCORE_TYPE
from pylti1p3.cookie import CookieService
from pylti1p3.deep_link_resource import DeepLinkResource
from pylti1p3.exception import LtiException, LtiServiceException
from pylti1p3.grade import Grade
from pylti1p3.lineitem import LineItem
from pylti1p3.message_launch import MessageLaunch
from pylti1p3.oidc_login import OIDCLogin
from pylti1p3.redirect import Redirect
from pylti1p3.registration import Registration
from pylti1p3.request import Request
from pylti1p3.session import SessionService
from pylti1p3.tool_config import ToolConfDict
from service import expect, find_field, free_address

NOON = datetime(2026, 11, 30, 12, tzinfo=timezone.utc)
CLIENT = "client-1"


class Fields(Request):
    """A request to the tool, with the session of a browser."""

    def __init__(self, fields, session):
        self.fields, self.kept = fields, session

    @property
    def session(self):
        return self.kept

    def is_secure(self):
        return False

    def get_param(self, key):
        return self.fields.get(key)


class Cookies(CookieService):
    def __init__(self):
        self.kept = {}

    def get_cookie(self, name):
        return self.kept.get(name)

    def set_cookie(self, name, value, exp=3600):
        self.kept[name] = value


class Address(Redirect):
    """A redirect that is only read."""

    def __init__(self, url):
        self.url = url

    def do_redirect(self):
        return self.url


class Login(OIDCLogin):
    def get_redirect(self, url):
        return Address(url)


class Message(MessageLaunch):
    def _get_request_param(self, key):
        return self._request.get_param(key)


class Tool:
    """A tool of PyLTI1p3 that publishes its key."""

    def __init__(self, platform):
        self.platform, self.address = platform, free_address()
        self.url = f"http://{self.address}"
        self.private, self.public = make_key()
        self.serve_keys()
        self.client = platform.add_tool(CLIENT, f"{self.url}/login", f"{self.url}/launch", f"{self.url}/keys")
        self.config = self.configure()

    def configure(self):
        platform = self.platform
        urls = {"auth_login_url": f"{platform.url}/auth", "auth_token_url": f"{platform.url}/token", "key_set_url": f"{platform.url}/keys"}
        config = ToolConfDict({platform.issuer: urls | {"client_id": CLIENT, "deployment_ids": [f"deployment-{CLIENT}"]}})
        config.set_private_key(platform.issuer, self.private)
        config.set_public_key(platform.issuer, self.public)
        return config

    def rotate_key(self):
        self.private, self.public = make_key()
        self.config = self.configure()

    def key_set(self):
        return {"keys": [Registration.get_jwk(self.public)]}

    def serve_keys(self):
        tool = self

        class Keys(BaseHTTPRequestHandler):
            def log_message(self, *_):
                pass

            def do_GET(self):
                self.send_response(200)
                self.end_headers()
                self.wfile.write(json.dumps(tool.key_set()).encode())

        host, port = self.address.split(":")
        threading.Thread(target=ThreadingHTTPServer((host, int(port)), Keys).serve_forever, daemon=True).start()

    def launch(self, user, link=None):
        """Launches as a browser would; returns the verified message."""
        begun = urllib.parse.urlsplit(self.platform.begin_launch(self.client, user, link))
        expect(begun.netloc == self.address, begun)
        session, cookies = {}, Cookies()
        first = Fields(dict(urllib.parse.parse_qsl(begun.query)), session)
        asked = Login(first, self.config, SessionService(first), cookies).redirect(f"{self.url}/launch")
        page = requests.get(asked, timeout=5)
        expect(page.status_code == 200 and f'action="{self.url}/launch"' in page.text, page.text)
        second = Fields({name: find_field(page.text, name) for name in ("state", "id_token")}, session)
        return Message(second, self.config, SessionService(second), cookies).validate()

    def assertion(self, **changes):
        """Returns a client assertion; a change to None leaves a claim out."""
        now = int(time.time())
        claims = {"iss": CLIENT, "sub": CLIENT, "aud": f"{self.platform.url}/token", "iat": now, "exp": now + 60}
        claims |= {"jti": str(time.monotonic_ns())} | changes
        claims = {name: value for name, value in claims.items() if value is not None}
        return jwt.encode(claims, self.private, "RS256", {"kid": self.key_set()["keys"][0]["kid"]})

    def ask_token(self, assertion, **changes):
        form = {"grant_type": "client_credentials", "client_assertion_type": ASSERTION, "client_assertion": assertion, "scope": SCORE}
        return requests.post(f"{self.platform.url}/token", form | changes, timeout=5)


def grade(user, given=50.0, seconds=0, **changes):
    """Returns a grade, with its time in seconds after noon."""
    made = Grade().set_user_id(user).set_score_given(given).set_score_maximum(changes.pop("maximum", 100.0))
    made.set_activity_progress("Completed").set_grading_progress("FullyGraded")
    made.set_timestamp(changes.pop("timestamp", (NOON + timedelta(seconds=seconds)).isoformat(timespec="milliseconds")))
    return made.set_extra_claims(changes)


def refused(work, status):
    """Ends the program unless the platform refuses something with a status."""
    try:
        work()
    except LtiServiceException as error:
        expect(error.response.status_code == status, f"{error.response.status_code} {error.response.text}, not {status}")
        return
    expect(False, f"accepted, not {status}")


def check_launch(tool):
    link = tool.platform.add_link("Puncture", {"stylet": "/exercises/one"})
    launch = tool.launch("user-7", link)
    data = launch.get_launch_data()
    expect(launch.is_resource_launch() and data["sub"] == "user-7" and data["name"] == "Name 7", data)
    expect(data["https://purl.imsglobal.org/spec/lti/claim/custom"] == {"stylet": "/exercises/one"}, data)
    expect(data["https://purl.imsglobal.org/spec/lti/claim/resource_link"]["id"] == link.id, data)
    expect(launch.has_ags() and launch.has_nrps() and launch.check_student_access(), data)
    expect(tool.launch("user-0", link).check_teacher_access(), "the first one teaches")
    tool.platform.rotate_key()
    tool.launch("user-7", link)
    check_requests(tool, link)
    return launch, link


def check_requests(tool, link):
    """Checks that a request for a launch is refused if one parameter is wrong."""
    begun = urllib.parse.urlsplit(tool.platform.begin_launch(tool.client, "user-7", link))
    hints = {name: value for name, value in urllib.parse.parse_qsl(begun.query) if name.endswith("_hint")}
    right = REQUEST | hints | {"redirect_uri": f"{tool.url}/launch", "client_id": CLIENT, "state": "s", "nonce": "n"}
    ask = lambda asked: requests.get(f"{tool.platform.url}/auth", asked, timeout=5).status_code  # noqa: E731
    expect(ask(right) == 200, "the right request")
    for name in right:
        expect(ask(right | {name: "" if name in ("state", "nonce") else "another"}) == 400, f"another {name}")


def check_tokens(tool):
    granted = tool.ask_token(tool.assertion())
    expect(granted.status_code == 200 and granted.json()["scope"] == SCORE and granted.json()["expires_in"] == 3600, granted.text)
    used = tool.assertion()
    expect(tool.ask_token(used).status_code == 200 and tool.ask_token(used).status_code == 401, "an assertion twice")
    past = int(time.time()) - 600
    wrong = [{"aud": "https://elsewhere.example"}, {"sub": "client-2"}, {"iss": "client-2"}, {"jti": None, "nonce": "n"}]
    wrong += [{"exp": None}, {"iat": past, "exp": past + 60}, {"exp": past + 3600}]
    for changes in wrong:
        expect(tool.ask_token(tool.assertion(**changes)).status_code == 401, f"an assertion with {changes}")
    right, tool.private = tool.private, make_key()[0]
    expect(tool.ask_token(tool.assertion()).status_code == 401, "an assertion by another key")
    tool.private = right
    expect(tool.ask_token("nonsense").status_code == 401, "no assertion")
    for changes in ({"grant_type": "password"}, {"client_assertion_type": "x"}, {"scope": "openid"}):
        expect(tool.ask_token(tool.assertion(), **changes).status_code == 400, changes)
    tool.rotate_key()
    expect(tool.ask_token(tool.assertion()).status_code == 200, "the tool's new key")


def check_items(tool, launch):
    ags = launch.get_ags()
    for number in range(25):
        wanted = LineItem().set_label(f"Item {number}").set_score_maximum(10).set_resource_id(f"exercise-{number}").set_tag(f"tag-{number}")
        made = ags.find_or_create_lineitem(wanted, "resource_id")
        expect(ags.find_or_create_lineitem(wanted, "tag").get_id() == made.get_id(), "made twice")
    listed = ags.get_lineitems()
    expect(len(listed) == 26 and len({item["id"] for item in listed}) == 26, f"{len(listed)} line items")
    expect(ags.get_lineitem(made.get_id()).get_label() == "Item 24", "a line item by itself")
    token = launch.get_service_connector().get_access_token([LINE_ITEM])
    headers = {"Authorization": f"Bearer {token}", "Accept": ITEMS_TYPE}
    query = tool.platform.own_query | {"resource_id": "exercise-3"}
    found = requests.get(f"{tool.platform.url}/items", query, headers=headers, timeout=5)
    expect([item["resourceId"] for item in found.json()] == ["exercise-3"], found.text)
    expect(len(requests.get(f"{tool.platform.items_url()}", {"limit": 7}, headers=headers, timeout=5).json()) == 7, "limit")
    wrong = requests.get(tool.platform.items_url(), headers=headers | {"Accept": MEMBERS_TYPE}, timeout=5)
    expect(wrong.status_code == 406, wrong.text)
    expect(requests.get(tool.platform.items_url(), headers={"Accept": ITEMS_TYPE}, timeout=5).status_code == 401, "without a token")
    wrong = requests.post(tool.platform.items_url(), "{}", headers=headers | {"Content-Type": "application/json"}, timeout=5)
    expect(wrong.status_code == 415, wrong.text)
    scope = launch.get_service_connector().get_access_token([SCORE])
    wrong = requests.get(tool.platform.items_url(), headers=headers | {"Authorization": f"Bearer {scope}"}, timeout=5)
    expect(wrong.status_code == 403, f"another scope: {wrong.status_code}")
    return made


def check_scores(tool, launch, link, other):
    """Checks which scores are accepted, and that the book has the last of them."""
    ags, book = launch.get_ags(), tool.platform.book
    points = lambda: book.points(link.item, "user-7")  # noqa: E731
    for second in range(4):
        ags.put_grade(grade("user-7", 10.123456 + second, second))
    expect([entry.status for entry in tool.platform.received("scores")] == [200, 201, 202, 204], "statuses")
    expect(abs(points() - 13.123456) < 1e-9, points())
    ags.put_grade(grade("user-7", 9, maximum=12), other)
    expect(book.points(int(other.get_id().split("/")[-1].partition("?")[0]), "user-7") == 7.5, "9 of 12 are 7.5 of 10")
    expect([result["resultScore"] for result in ags.get_grades()] == [13.123456], "results")
    for seconds in (2, 3):
        refused(lambda at=seconds: ags.put_grade(grade("user-7", 60, at)), 409)
    bad = [grade("user-7", 100.000001, 9), grade("user-7", 1.1234567, 9), grade("user-7", 0, 9, maximum=0.0)]
    bad += [grade("user-7", timestamp=text) for text in ("2026-11-30T13:00:00Z", "2026-11-30T13:00:00.000", "2026-13-30T13:00:00.000Z")]
    bad += [grade("user-7", seconds=9, **{name: "Done"}) for name in ("activityProgress", "gradingProgress", "other")]
    late = {"submittedAt": "2026-11-30T23:00:00.000Z"}
    bad += [grade("user-7", seconds=9, submission=late), grade("user-7", seconds=9, scoreMaximum=None)]
    for one in bad:
        refused(lambda wrong=one: ags.put_grade(wrong), 400)
    refused(lambda: ags.put_grade(grade("stranger", 5, 9)), 404)
    expect(abs(points() - 13.123456) < 1e-9 and len(book.accepted) == 5, "a refused score was kept")
    pending = {"scoreGiven": None, "scoreMaximum": None, "gradingProgress": "PendingManual"}
    body = {name: value for name, value in json.loads(grade("user-7", seconds=20, **pending).get_value()).items() if value is not None}
    send(launch, tool.platform.item_url(link.item, "/scores"), body)
    expect(points() is None, "no score while it is pending")
    gone = LineItem({"id": tool.platform.item_url(999)})
    refused(lambda: ags.put_grade(grade("user-7", 5, 9), gone), 404)
    if tool.platform.own_query:
        refused(lambda: ags.put_grade(grade("user-7", 5, 30), LineItem({"id": f"{tool.platform.url}/items/{link.item}"})), 404)


def send(launch, url, body):
    """Sends a score that PyLTI1p3 does not make."""
    connector = launch.get_service_connector()
    connector.make_service_request([SCORE], url, is_post=True, data=json.dumps(body), content_type=SCORE_TYPE)


def check_members(tool, launch):
    before = len(tool.platform.received("members"))
    members = launch.get_nrps().get_members()
    expect(len({member["user_id"] for member in members}) == 450, f"{len(members)} members")
    expect(len(tool.platform.received("members")) - before == 9, "pages of 50")
    expect(sum("email" not in member for member in members) == 45, "members without an address")
    expect({member["status"] for member in members} == {"Active", "Inactive"}, "statuses")


def check_deep_link(tool):
    launch = tool.launch("user-0")
    expect(launch.is_deep_link_launch(), launch.get_launch_data())
    item = LineItem().set_label("Chosen").set_score_maximum(100).set_resource_id("exercise-a")
    chosen = DeepLinkResource().set_url(f"{tool.url}/launch").set_title("Chosen").set_lineitem(item)
    chosen.set_custom_params({"stylet": "/exercises/a"})
    answer = launch.get_deep_link()
    signed = answer.get_response_jwt([chosen])
    url = f"{tool.platform.url}/deep-link-return"
    for changes in ({"aud": "https://elsewhere.example"}, {f"{DEEP_LINK}data": "x"}, {"nonce": None, "jti": "j"}):
        wrong = requests.post(url, {"JWT": answer.encode_jwt(answer.get_message_jwt([chosen]) | changes)}, timeout=5)
        expect(wrong.status_code in (400, 401), f"{changes}: {wrong.status_code}")
    expect(requests.post(url, {"JWT": signed[:-8] + "AAAAAAAA"}, timeout=5).status_code == 401, "another signature")
    added = requests.post(url, {"JWT": signed}, timeout=5)
    expect(added.status_code == 200, added.text)
    expect(requests.post(url, {"JWT": signed}, timeout=5).status_code == 401, "an answer twice")
    link = list(tool.platform.links.values())[-1]
    expect(link.custom == {"stylet": "/exercises/a"} and tool.platform.book.items[link.item]["resourceId"] == "exercise-a", link)
    tool.launch("user-7", link).get_ags().put_grade(grade("user-7", 80))
    expect(tool.platform.book.points(link.item, "user-7") == 80, "a score for the returned link")


def check_faults(tool, launch, link):
    """Checks each fault, and that a request is recorded if only its answer is lost."""
    ags, platform = launch.get_ags(), tool.platform
    ags.put_grade(grade("user-8", 1))
    for fault, status in ((SERVER_ERROR, 500), (TOO_MANY, 429), (UNAUTHORIZED, 401)):
        platform.faults.plan("scores", fault)
        refused(lambda: ags.put_grade(grade("user-8", 2, 2)), status)
    refused(lambda: ags.put_grade(grade("user-8", 2, 2)), 401)
    ags = tool.launch("user-8", link).get_ags()
    for fault, points in ((CUT_BEFORE, 1), (Fault("short stall", stall_s=0.2), 1), (CUT_AFTER, 2)):
        platform.faults.plan("scores", fault)
        try:
            ags.put_grade(grade("user-8", 2, 2))
            expect(False, f"{fault.name}: answered")
        except requests.ConnectionError:
            expect(platform.book.points(link.item, "user-8") == points, fault.name)
    refused(lambda: ags.put_grade(grade("user-8", 2, 2)), 409)
    ags.put_grade(grade("user-8", 3, 3))
    names = ["", "500", "429", "401", "", "cut before", "short stall", "cut after", "", ""]
    expect([entry.fault for entry in platform.received("scores")][-10:] == names, "the log")
    expect(platform.book.points(link.item, "user-8") == 3 and platform.faults.left() == 0, "the last score")


def check_registration(platform):
    """Checks dynamic registration, which PyLTI1p3 does not have."""
    asked = dict(urllib.parse.parse_qsl(urllib.parse.urlsplit(platform.offer_registration("https://tool.example/register")).query))
    found = requests.get(asked["openid_configuration"], timeout=5).json()
    expect(found["issuer"] == platform.issuer and found["jwks_uri"] == f"{platform.url}/keys", found)
    tool = {"domain": "tool.example", "target_link_uri": "https://tool.example/", "claims": ["sub"]}
    tool["messages"] = [{"type": "LtiResourceLinkRequest"}]
    body = {
        "application_type": "web",
        "response_types": ["id_token"],
        "grant_types": ["implicit", "client_credentials"],
        "initiate_login_uri": "https://tool.example/login",
        "redirect_uris": ["https://tool.example/launch"],
        "client_name": "Tool",
        "jwks_uri": "https://tool.example/keys",
        "token_endpoint_auth_method": "private_key_jwt",
        "scope": SCORE,
        TOOL_CONFIGURATION: tool,
    }
    headers = {"Authorization": f"Bearer {asked['registration_token']}"}
    register = lambda body, headers: requests.post(found["registration_endpoint"], json=body, headers=headers, timeout=5)  # noqa: E731
    expect(register(body, {}).status_code == 401, "without the token")
    for name in body:
        expect(register({key: value for key, value in body.items() if key != name}, headers).status_code == 400, f"without {name}")
    done = register(body, headers)
    expect(done.status_code == 201 and done.json()["client_id"] in platform.clients, done.text)
    expect(done.json()[TOOL_CONFIGURATION]["deployment_id"], done.text)
    expect(register(body, headers).status_code == 401, "a token twice")


def main():
    for own_query in (None, {"type": "lti"}):
        tool = Tool(Platform(own_query=own_query))
        launch, link = check_launch(tool)
        check_scores(tool, launch, link, check_items(tool, launch))
        check_members(tool, launch)
        check_deep_link(tool)
        check_faults(tool, launch, link)
        check_tokens(tool)
        check_registration(tool.platform)
        print(f"the platform is as PyLTI1p3 expects it; own query: {own_query}")


if __name__ == "__main__":
    try:
        main()
    except LtiException as error:
        raise SystemExit(f"failed: PyLTI1p3: {error}") from error

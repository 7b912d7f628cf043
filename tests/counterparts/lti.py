"""Launches from Open edX's side of LTI 1.3 (lti-consumer-xblock), and what the service refuses of it.

    lti.py PROGRAM     the service to check
"""

import html
import json
import sys
import threading
import urllib.parse
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import rsa
from django.conf import settings
from service import Browser, Service, expect, free_address

settings.configure(
    PLATFORM_NAME="Open edX",
    LMS_ROOT_URL="https://lms.example.org",
    FEATURES={},
    CACHES={"default": {"BACKEND": "django.core.cache.backends.locmem.LocMemCache"}},
)

from lti_consumer.lti_1p3.consumer import LtiAdvantageConsumer  # noqa: E402  needs the settings

# Another site than the service, which is at 127.0.0.1.
PLATFORM = free_address().replace("127.0.0.1", "localhost")
ISSUER, CLIENT, DEPLOYMENT = "https://lms.example.org", "client-1", "deployment-1"
LOGIN = {"iss": ISSUER, "client_id": CLIENT, "lti_deployment_id": DEPLOYMENT, "login_hint": "7", "lti_message_hint": "hint-9"}
REQUEST = {
    "scope": "openid",
    "response_type": "id_token",
    "response_mode": "form_post",
    "prompt": "none",
    "login_hint": "7",
    "lti_message_hint": "hint-9",
}


class Platform:
    """Serves a course with the service in a frame, the keys of the consumer, and the confirmation of launches."""

    def __init__(self, service):
        self.service = service
        self.consumer = self.make_consumer()
        platform = self

        class Pages(BaseHTTPRequestHandler):
            def log_message(self, *_):
                pass

            def do_GET(self):
                kind, text = platform.page(urllib.parse.urlsplit(self.path))
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(text.encode())))
                self.end_headers()
                self.wfile.write(text.encode())

        host, port = PLATFORM.split(":")
        server = ThreadingHTTPServer((host, int(port)), Pages)
        threading.Thread(target=server.serve_forever, daemon=True).start()

    def page(self, address):
        """Returns media type and text of a page."""
        if address.path == "/keys":
            return "application/json", json.dumps(self.consumer.get_public_keyset())
        if address.path == "/auth":
            form = self.confirm(dict(urllib.parse.parse_qsl(address.query)), "ada")
            fields = "".join(f'<input type="hidden" name="{name}" value="{value}">' for name, value in form.items())
            action = f"{self.service.url}/lti/launch"
            return "text/html", f'<form method="post" action="{action}">{fields}</form><script>document.forms[0].submit()</script>'
        return "text/html", f'<h1>Course</h1><iframe width="700" height="400" src="{html.escape(self.login_address())}"></iframe>'

    def login_address(self):
        """Returns the address at which it initiates a login."""
        login = LOGIN | {"target_link_uri": f"{self.service.url}/lti/launch"}
        return f"{self.service.url}/lti/login?{urllib.parse.urlencode(login)}"

    def make_consumer(self):
        """Makes a consumer with a new key; its id is always the same."""
        key = rsa.generate_private_key(public_exponent=65537, key_size=2048)
        form = serialization.PrivateFormat.TraditionalOpenSSL
        pem = key.private_bytes(serialization.Encoding.PEM, form, serialization.NoEncryption())
        launch = f"{self.service.url}/lti/launch"
        consumer = LtiAdvantageConsumer(
            iss=ISSUER,
            lti_oidc_url=f"{self.service.url}/lti/login",
            lti_launch_url=launch,
            client_id=CLIENT,
            deployment_id=DEPLOYMENT,
            rsa_key=pem.decode(),
            rsa_key_id="key-1",
            redirect_uris=[launch],
            tool_key=None,
        )
        consumer.set_resource_link_claim("link-1", title="Puncture")
        consumer.set_context_claim("course-1", context_title="Nursing, first year")
        consumer.enable_ags(lineitems_url=f"{ISSUER}/items", lineitem_url=f"{ISSUER}/items/1")
        consumer.enable_nrps(f"{ISSUER}/members")
        return consumer

    def begin(self, browser):
        """Initiates a login; returns the request to which the service sends the browser."""
        page = browser.get(self.login_address())
        address = page.headers["Refresh"].removeprefix("0; url=")
        expect(address.startswith(f"http://{PLATFORM}/auth?"), address)
        asked = dict(urllib.parse.parse_qsl(urllib.parse.urlsplit(address).query))
        expect(REQUEST.items() <= asked.items(), address)
        return asked

    def confirm(self, asked, user):
        """Returns the form of a launch."""
        name, address = f"Name of {user}", f"{user}@uni.example"
        self.consumer.set_user_data(user_id=user, role="student", full_name=name, email_address=address)
        return self.consumer.generate_launch_request(asked)

    def launch(self, user, change=dict):
        """Launches in a browser of its own; returns the browser and the page."""
        browser = Browser(self.service.url)
        return browser, browser.open("/lti/launch", change(self.confirm(self.begin(browser), user)))

    def expect_refusal(self, code, change=dict):
        """Ends the program unless a launch is refused for a reason, and nobody is signed in."""
        browser, page = self.launch("eve", change)
        expect(page.status == 403 and f"code: {code}<" in page.text, f"{code}: {page.status} {page.text}")
        expect(not browser.is_signed_in(), f"{code}: signed in")
        print(f"refused: {code}")


def start_both(program):
    """Starts a service and a platform, and registers the platform by its form; returns both and the path of the registration's page."""
    service = Service(program, options=["--allow-plain-http", PLATFORM, "--allow-private-addresses"])
    platform = Platform(service)
    return service, platform, service.add_platform("Open edX", ISSUER, CLIENT, f"http://{PLATFORM}")


def main():
    service, platform, own = start_both(sys.argv[1])
    platform.expect_refusal("deployment")
    service.admit(own, DEPLOYMENT)
    for _ in range(2):
        browser, page = platform.launch("ada")
        expect(page.status == 200 and page.url == f"{service.url}/", f"{page.status} {page.url}")
        expect("Name of ada" in browser.get("/account").text, "another account")
        print("launched: ada")
    expect(service.people() == [("Head", "administrator"), ("Name of ada", "trainee")], f"people: {service.people()}")
    urls = service.rows("SELECT members_url, lineitems_url, lineitem_url FROM platform_contexts JOIN platform_links USING (school_id)")
    expect(urls == [(f"{ISSUER}/members", f"{ISSUER}/items", f"{ISSUER}/items/1")], f"services: {urls}")
    platform.expect_refusal("signature", lambda form: form | {"id_token": form["id_token"].rpartition(".")[0] + "."})
    platform.expect_refusal("malformed", lambda form: {"state": form["state"]})
    platform.expect_refusal("no_flow", lambda form: form | {"state": "unknown"})
    form = platform.confirm(platform.begin(Browser(service.url)), "eve")
    other = Browser(service.url)
    page = other.open("/lti/launch", form)
    expect(page.status == 200 and 'target="_blank"' in page.text, f"another browser: {page.status} {page.text}")
    expect(f"frame-ancestors http://{PLATFORM};" in page.headers["Content-Security-Policy"], "the policy of the page")
    expect(not other.is_signed_in(), "another browser: signed in")
    platform.consumer = platform.make_consumer()
    platform.expect_refusal("signature")


if __name__ == "__main__":
    main()

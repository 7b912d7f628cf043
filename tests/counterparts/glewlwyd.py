"""Sign-in by glewlwyd (an OpenID provider in C), which requires PKCE here.

    glewlwyd.py PROGRAM FOLDER     the service to check, and the folder with the files of Debian's package
"""

import json
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

from service import Browser, Service, expect, free_address, start, wait_for

SECRET = "a-secret-for-a-trial"
PASSWORD = "a password of ada"
SCHEMA = "usr/share/dbconfig-common/data/glewlwyd/install/sqlite3"
SETTINGS = """
port={port}
bind_address="127.0.0.1"
external_url="http://127.0.0.1:{port}"
login_url="login.html"
api_prefix="api"
log_mode="console"
log_level="WARNING"
cookie_secure=0
session_expiration=3600
session_key="GLEWLWYD2_SESSION_ID"
admin_scope="g_admin"
profile_scope="g_profile"
login_api_enabled=true
user_module_path="{package}/usr/lib/glewlwyd/user"
client_module_path="{package}/usr/lib/glewlwyd/client"
user_auth_scheme_module_path="{package}/usr/lib/glewlwyd/scheme"
plugin_module_path="{package}/usr/lib/glewlwyd/plugin"
static_files_path="{pages}"
static_files_mime_types = (
  {{ extension = ".html"; mime_type = "text/html"; compress = 0; }},
  {{ extension = ".css"; mime_type = "text/css"; compress = 0; }},
  {{ extension = ".js"; mime_type = "application/javascript"; compress = 0; }},
  {{ extension = ".json"; mime_type = "application/json"; compress = 0; }},
  {{ extension = ".woff2"; mime_type = "font/woff2"; compress = 0; }}
);
database = {{ type = "sqlite3"; path = "{database}"; }};
"""


class Glewlwyd:
    """A provider with one user, whose issuer is `url`."""

    def __init__(self, package, callback):
        address = free_address()
        self.address, self.base = address, f"http://{address}"
        self.url = f"{self.base}/api/oidc"
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        with sqlite3.connect(self.folder / "glewlwyd.db") as database:
            database.executescript((package / SCHEMA).read_text())
        settings = self.folder / "glewlwyd.conf"
        port, database = address.split(":")[1], self.folder / "glewlwyd.db"
        pages = self.copy_pages(package)
        settings.write_text(SETTINGS.format(package=package, port=port, database=database, pages=pages))
        start([package / "usr/bin/glewlwyd", f"--config-file={settings}"], self.folder)
        wait_for(self.base)
        self.configure(callback)

    def copy_pages(self, package):
        """Copies its pages, with the settings file where they look for it: the package links it to a file below /etc."""
        pages, settings = self.folder / "pages", package / "etc/glewlwyd/config-2.7.json/config.json"
        shutil.copytree(package / "usr/share/glewlwyd/webapp", pages, ignore=shutil.ignore_patterns("config.json"))
        shutil.copy(settings, pages / "config.json")
        return pages

    def call(self, browser, method, path, body):
        """Calls its API with the session of a browser."""
        request = urllib.request.Request(
            f"{self.base}/api{path}", json.dumps(body).encode(), {"Content-Type": "application/json"}, method=method
        )
        try:
            browser.opener.open(request, timeout=30).close()
        except urllib.error.HTTPError as refusal:
            sys.exit(f"glewlwyd refuses {path}: {refusal.status} {refusal.read().decode()}")

    def configure(self, callback):
        """Adds the plug-in for OpenID Connect, the service as client, and a user, as the default administrator."""
        head = Browser(self.base)
        self.call(head, "POST", "/auth/", {"username": "admin", "password": "password"})
        plugin = {"module": "oidc", "name": "oidc", "display_name": "OpenID Connect", "parameters": self.parameters()}
        self.call(head, "POST", "/mod/plugin/", plugin)
        for scope in ["profile", "email"]:
            self.call(head, "POST", "/scope/", {"name": scope, "password_required": True, "scheme": {}})
        client = {
            "client_id": "stylet",
            "name": "Stylet",
            "enabled": True,
            "confidential": True,
            "password": SECRET,
            "redirect_uri": [callback],
            "authorization_type": ["code"],
            "token_endpoint_auth_method": ["client_secret_basic"],
        }
        self.call(head, "POST", "/client/", client)
        scopes = ["openid", "profile", "email"]
        user = {"username": "ada", "name": "Ada", "email": "ada@uni.example", "password": PASSWORD}
        self.call(head, "POST", "/user/", user | {"scope": scopes, "enabled": True})

    def parameters(self):
        key, public = self.folder / "key.pem", self.folder / "public.pem"
        subprocess.run(["openssl", "genrsa", "-out", key, "2048"], check=True, capture_output=True)
        subprocess.run(["openssl", "rsa", "-in", key, "-pubout", "-out", public], check=True, capture_output=True)
        return {
            "iss": self.url,
            "jwt-type": "rsa",
            "jwt-key-size": "256",
            "key": key.read_text(),
            "cert": public.read_text(),
            "access-token-duration": 600,
            "refresh-token-duration": 3600,
            "code-duration": 60,
            "auth-type-code-enabled": True,
            "auth-type-token-enabled": False,
            "auth-type-refresh-enabled": False,
            "pkce-allowed": True,
            "pkce-required": True,
            "pkce-method-plain-allowed": False,
            "name-claim": "mandatory",
            "email-claim": "mandatory",
            "allowed-scope": ["openid", "profile", "email"],
        }

    def sign_in(self, browser):
        """Goes from the sign-in page of the service to the provider and back."""
        page = browser.leave_for_provider()
        expect(page.url.startswith(f"{self.base}/login.html"), f"the provider shows {page.url}")
        asked = dict(urllib.parse.parse_qsl(urllib.parse.urlparse(page.url).query))["callback_url"]
        self.call(browser, "POST", "/auth/", {"username": "ada", "password": PASSWORD})
        self.call(browser, "PUT", "/auth/grant/stylet", {"scope": "openid profile email"})
        return asked, browser.get(f"{asked}&g_continue")


def start_both(program, package):
    """Starts a service and a provider, and adds the provider to the service; returns both."""
    address = free_address()
    provider = Glewlwyd(Path(package), f"http://{address}/sign-in/callback")
    options = ["--allow-plain-http", provider.address, "--allow-private-addresses"]
    service = Service(program, address, options=options)
    service.add_provider(provider.url, SECRET)
    return service, provider


def main():
    service, provider = start_both(sys.argv[1], sys.argv[2])
    for _ in range(2):
        browser = Browser(service.url)
        asked, page = provider.sign_in(browser)
        expect(browser.is_signed_in(), f"ada is not signed in: {page.status} {page.url} {page.text[:300]}")
        expect(service.people() == [("Ada", "trainee"), ("Head", "administrator")], f"people: {service.people()}")
        print("signed in: Ada, trainee")
    plain = re.sub(r"&code_challenge[^&]*", "", asked)
    expect(plain != asked, "the service sends no code challenge")
    refused = browser.get(f"{plain}&g_continue")
    expect("error=invalid_request" in refused.url, f"the provider does not require PKCE: {refused.url}")
    expect(refused.status >= 400, f"the service shows {refused.status} at {refused.url}")
    print("refused: a request without PKCE")


if __name__ == "__main__":
    main()

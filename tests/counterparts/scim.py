"""Another project's compliance checks of SCIM 2.0 (scim2-tester) against a service of its own; prints every check that is no success.

    scim.py web-admin     the program to check
"""

import html
import http.cookiejar
import re
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request

import httpx2
from scim2_client.engines.httpx2 import SyncSCIMClient
from scim2_tester import Status, check_server

PASSWORD = "a long enough password for the directory"


class Browser:
    """A browser that sends forms."""

    def __init__(self, url):
        self.url = url
        self.opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(http.cookiejar.CookieJar()))

    def get(self, path):
        with self.opener.open(self.url + path, timeout=30) as answer:
            return answer.url, answer.read().decode()

    def post(self, path, page, **fields):
        csrf = html.unescape(re.search(r'name="csrf" value="([^"]+)"', page).group(1))
        form = urllib.parse.urlencode({"csrf": csrf, **fields}).encode()
        with self.opener.open(self.url + path, form, timeout=30) as answer:
            return answer.url, answer.read().decode()


def make_token(url, initial):
    """Signs the administrator in, who chooses a password, and makes a token."""
    browser = Browser(url)
    _, page = browser.get("/login")
    where, page = browser.post("/login", page, email="head@uni.example", password=initial)
    browser.post(where.removeprefix(url), page, password=PASSWORD, again=PASSWORD)
    _, page = browser.get("/admin/provisioning")
    _, page = browser.post("/admin/provisioning", page, name="Directory", may_disable_staff="yes", password=PASSWORD)
    return re.search(r'class="link-to-copy">([0-9a-f]+)<', page).group(1)


def wait_for(url):
    for _ in range(300):
        try:
            urllib.request.urlopen(url + "/healthz", timeout=5)
            return
        except (urllib.error.URLError, ConnectionError):
            time.sleep(0.1)
    sys.exit(f"{url} does not answer")


def main():
    program = sys.argv[1]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    url = f"http://{address}"
    with tempfile.TemporaryDirectory() as folder:
        who = ["--email", "head@uni.example", "--name", "Head", "--role", "administrator", "--school", "North"]
        added = subprocess.run([program, "user", "add", "--data-dir", folder, *who], check=True, capture_output=True, text=True)
        initial = re.search(r"password: (\S+)", added.stdout).group(1)
        service = subprocess.Popen(
            [program, "serve", "--data-dir", folder, "--listen", address, "--public-url", url],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            wait_for(url)
            headers = {"Authorization": f"Bearer {make_token(url, initial)}"}
            client = SyncSCIMClient(httpx2.Client(base_url=url + "/scim/v2", headers=headers, timeout=30))
            client.discover()
            results = check_server(client)
        finally:
            service.terminate()
            service.wait()
    # What the service does not offer is skipped: a search over both kinds at once, which is answered with 501.
    failed = [result for result in results if result.status not in (Status.SUCCESS, Status.SKIPPED)]
    for result in failed:
        print(result.status.name, result.title, result.resource_type, result.reason)
    passed = sum(result.status == Status.SUCCESS for result in results)
    print(f"{passed} checks passed")
    sys.exit(1 if failed or passed < 50 else 0)


if __name__ == "__main__":
    main()

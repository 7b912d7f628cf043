"""Shared by the scripts of this folder: a service with a school of its own, and a browser that sends forms."""

import atexit
import html
import http.cookiejar
import os
import re
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

HEAD = "head@uni.example"
PASSWORD = "a long enough password for the directory"


def free_address():
    """Returns a free HOST:PORT of the loopback interface."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{free.getsockname()[1]}"


def wait_for(url):
    """Waits until a server answers, with any status."""
    for _ in range(600):
        try:
            urllib.request.urlopen(url, timeout=5).close()
            return
        except urllib.error.HTTPError:
            return
        except OSError:
            time.sleep(0.1)
    sys.exit(f"{url} does not answer")


def find_field(page, name):
    """Returns the value of a hidden field."""
    return html.unescape(re.search(rf'name="{name}" value="([^"]*)"', page).group(1))


class Answer:
    """A page, after all redirects."""

    def __init__(self, response):
        self.url, self.status, self.headers = response.url, response.status, response.headers
        self.body = response.read()
        self.text = self.body.decode(errors="replace")


class Browser:
    """A browser that sends forms and follows redirects. Paths are those of the service."""

    def __init__(self, url):
        self.url = url
        # As browsers do on the loopback interface: cookies for TLS alone are sent without it.
        policy = http.cookiejar.DefaultCookiePolicy(secure_protocols=("http", "https"))
        jar = http.cookiejar.CookieJar(policy)
        self.opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar))

    def open(self, path, form=None):
        body = form and urllib.parse.urlencode(form).encode()
        try:
            with self.opener.open(urllib.parse.urljoin(self.url, path), body, timeout=60) as response:
                return Answer(response)
        except urllib.error.HTTPError as refusal:
            with refusal:
                return Answer(refusal)

    def get(self, path):
        return self.open(path)

    def post(self, path, page, **fields):
        """Sends a form of the service, with the token of the page that it is on."""
        return self.open(path, {"csrf": find_field(page.text, "csrf"), **fields})

    def is_signed_in(self):
        return not urllib.parse.urlparse(self.get("/").url).path.startswith("/login")

    def launch(self, address):
        """Launches from a learning platform, beginning at an address; returns the page after it, or that of a refusal."""
        begun = self.get(address)
        if "Refresh" not in begun.headers:
            return begun
        confirmed = self.get(begun.headers["Refresh"].removeprefix("0; url="))
        expect(confirmed.status == 200, confirmed.text)
        return self.open("/lti/launch", {name: find_field(confirmed.text, name) for name in ("state", "id_token")})

    def leave_for_provider(self):
        """Presses the only button of a provider; returns the first page there."""
        page = self.get("/login")
        button = re.search(r'action="(/sign-in/[^"]+)"', page.text).group(1)
        left = self.post(button, page, next="/")
        return self.get(left.headers["Refresh"].removeprefix("0; url="))


class Service:
    """A running service on a temporary folder, with a school and its administrator, who is signed in as `head`."""

    def __init__(self, program, address=None, database=None, options=()):
        self.address = address or free_address()
        self.url = f"http://{self.address}"
        self.database = database
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.program = program
        self.place = ["--data-dir", str(self.folder), *(["--database", database] if database else [])]
        who = ["--email", HEAD, "--name", "Head", "--role", "administrator", "--school", "North"]
        initial = re.search(r"password: (\S+)", self.command("user", "add", *who)).group(1)
        self.serving = [program, "serve", *self.place, "--listen", self.address, "--public-url", self.url, *options]
        self.start()
        wait_for(self.url + "/healthz")
        self.head = Browser(self.url)
        page = self.head.post("/login", self.head.get("/login"), email=HEAD, password=initial)
        self.head.post(page.url, page, password=PASSWORD, again=PASSWORD)

    def command(self, *words):
        """Runs an administrative command on the data of the service; returns its output."""
        return subprocess.run([self.program, *words, *self.place], check=True, capture_output=True, text=True).stdout

    def start(self):
        """Starts the service, also after it was killed, without waiting for it."""
        self.process = start(self.serving, self.folder)

    def kill(self):
        """Ends the service without a chance to finish anything."""
        self.process.kill()
        self.process.wait()

    def add_platform(self, name, issuer, client_id, at):
        """Registers a learning platform by its form; returns the path of the registration's page."""
        form = {"name": name, "issuer": issuer, "client_id": client_id, "creates_trainees": "true"}
        form |= {"auth_url": f"{at}/auth", "token_url": f"{at}/token", "keys_url": f"{at}/keys"}
        page = self.head.post("/admin/platforms", self.head.get("/admin/platforms"), **form)
        path = urllib.parse.urlsplit(page.url).path
        expect(re.fullmatch(r"/admin/platforms/[0-9a-f-]{36}", path), f"not registered: {page.status} {page.text}")
        return path

    def admit(self, own, deployment):
        """Admits a deployment at the page of the registration."""
        admitted = self.head.post(f"{own}/admit", self.head.get(own), deployment=deployment)
        expect(admitted.status == 200 and "/admit" not in admitted.text, f"not admitted: {admitted.text}")

    def find_platform(self):
        """Returns the path of the page of the only registration."""
        return re.search(r'href="(/admin/platforms/[0-9a-f-]{36})"', self.head.get("/admin/platforms").text).group(1)

    def make_token(self):
        """Makes a token for a directory that may disable staff."""
        form = {"name": "Directory", "may_disable_staff": "yes", "password": PASSWORD}
        page = self.head.post("/admin/provisioning", self.head.get("/admin/provisioning"), **form)
        return re.search(r'class="link-to-copy">([0-9a-f]+)<', page.text).group(1)

    def add_provider(self, issuer, secret, **changes):
        """Adds a provider by its form, and ends the program if the service refuses it."""
        form = {
            "name": "University",
            "issuer": issuer,
            "client_id": "stylet",
            "client_secret": secret,
            "scopes": "openid profile email",
            "subject_claim": "sub",
            "match_claim": "",
            "addresses_verified": "true",
            "creates": "trainee",
            "role_claim": "",
            "role_map": "",
        }
        page = self.head.post("/admin/sign-in", self.head.get("/admin/sign-in"), **(form | changes))
        if refused := re.search(r'role="alert">([^<]*)<', page.text):
            sys.exit(f"the service refuses the provider: {refused.group(1)}")

    def rows(self, query):
        """Returns the rows of a query, read past the service; from PostgreSQL all values are texts."""
        if self.database:
            command = ["psql", "-X", "-A", "-t", "-F", "\t", self.database, "-c", query]
            read = subprocess.run(command, check=True, capture_output=True, text=True)
            return [tuple(line.split("\t")) for line in read.stdout.splitlines()]
        with sqlite3.connect(f"file:{self.folder}/stylet.db?mode=ro", uri=True) as database:
            return database.execute(query).fetchall()

    def people(self):
        """Returns the name and role of each person."""
        return self.rows("SELECT display_name, role FROM people ORDER BY display_name")

    def refusals(self):
        """Returns how many sign-ins by a provider were refused."""
        return self.rows("SELECT count(*) FROM audit_log WHERE action = 'sign_in.provider_refused'")[0][0]


class Demonstration:
    """A running service with the demonstration, whose people share a password."""

    def __init__(self, program):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.address = free_address()
        self.url = f"http://{self.address}"
        self.program = program
        place = ["--data-dir", str(self.folder)]
        subprocess.run([program, "demo", *place, "--password", PASSWORD], check=True, capture_output=True)
        command = [program, "serve", *place, "--listen", self.address, "--public-url", self.url]
        start(command, self.folder)
        wait_for(self.url + "/healthz")

    def sign_in(self, email):
        browser = Browser(self.url)
        browser.post("/login", browser.get("/login"), email=email, password=PASSWORD)
        expect(browser.is_signed_in(), f"{email} signs in")
        return browser

    def rows(self, query):
        """Returns the rows of a query, read past the service."""
        with sqlite3.connect(f"file:{self.folder}/stylet.db?mode=ro", uri=True) as database:
            return database.execute(query).fetchall()


def start(command, folder, **variables):
    """Starts a process that is ended with this program. Its temporary files are in a folder, its output in a file there."""
    environment = os.environ | {"TMPDIR": str(folder), **variables}
    with open(folder / "log", "a") as output:
        process = subprocess.Popen(command, stdout=output, stderr=output, env=environment)
    atexit.register(stop, process)
    return process


def stop(process):
    """Ends a process, if it still runs."""
    process.terminate()
    process.wait()


# Otherwise this signal would leave the processes behind.
signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))


def expect(condition, what):
    """Ends the program with what is wrong unless a condition holds."""
    if not condition:
        sys.exit(f"failed: {what}")

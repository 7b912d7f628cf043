"""Somebody who speaks HTTP with the service: a browser without JavaScript, or a program with a token."""

import http.client
import html
import itertools
import json
import re
import socket
import time
import urllib.parse
from dataclasses import dataclass, field

PASSWORD = "vier Käse im Wind"
_addresses = itertools.count(2)


def own_address():
    """An address of this machine that nobody had before: brakes go by address."""
    number = next(_addresses)
    return f"127.1.{number // 250}.{number % 250 + 1}"


@dataclass
class Answer:
    status: int
    headers: list
    body: bytes
    seconds: float

    @property
    def text(self):
        return self.body.decode("utf-8", "replace")

    @property
    def json(self):
        return json.loads(self.body)

    def header(self, name):
        found = [value for key, value in self.headers if key.lower() == name.lower()]
        return found[0] if found else ""

    def __str__(self):
        shown = re.sub(r"<[^>]*>|\s+", " ", self.text[:6000])
        return f"{self.status} {' '.join(shown.split())[:300]}"


class CutOff(Exception):
    """The service closed the connection without an answer."""


@dataclass
class Visitor:
    """One person or program at one address, with its cookies."""

    service: object
    token: str = ""
    address: str = field(default_factory=own_address)
    cookies: dict = field(default_factory=dict)
    headers: dict = field(default_factory=dict)
    timeout: float = 300

    def connection(self):
        host, port = self.service.place
        return http.client.HTTPConnection(host, port, timeout=self.timeout, source_address=(self.address, 0))

    def send(self, method, path, body=None, headers=None):
        sent = {**self.headers, **(headers or {})}
        if self.token:
            sent.setdefault("Authorization", f"Bearer {self.token}")
        if self.cookies:
            sent.setdefault("Cookie", "; ".join(f"{key}={value}" for key, value in self.cookies.items()))
        begun = time.monotonic()
        connection = self.connection()
        try:
            answer = self._exchange(connection, (method, path), body, sent)
        except (ConnectionError, http.client.HTTPException, socket.timeout) as error:
            raise CutOff(f"{method} {path}: {error!r}") from error
        finally:
            connection.close()
        answer.seconds = time.monotonic() - begun
        for name, value in answer.headers:
            if name.lower() == "set-cookie":
                key, _, rest = value.partition("=")
                self.cookies[key] = rest.split(";")[0]
        return answer

    @staticmethod
    def _exchange(connection, line, body, headers):
        try:
            connection.request(*line, body=body, headers=headers)
        except (BrokenPipeError, ConnectionResetError):
            # Refused while it was sent: the answer may be there all the same.
            pass
        response = connection.getresponse()
        return Answer(response.status, response.getheaders(), response.read(), 0.0)

    def get(self, path, headers=None):
        return self.send("GET", path, headers=headers)

    def form(self, path, fields, headers=None):
        """A form as it is, without a token of its own."""
        body = urllib.parse.urlencode(fields)
        return self.send("POST", path, body, {"Content-Type": "application/x-www-form-urlencoded", **(headers or {})})

    def csrf(self, page="/account"):
        return csrf_in(self.get(page).text)

    def press(self, path, fields=(), page="/account"):
        """A form as a page of the service would send it."""
        return self.form(path, [("csrf", self.csrf(page)), *(fields.items() if isinstance(fields, dict) else fields)])

    def sign_in(self, email, password=PASSWORD, **more):
        return self.press("/login", {"email": email, "password": password, **more}, page="/login")

    def upload(self, recording, headers=None):
        return self.send("POST", "/api/v1/sessions", recording, {"Content-Type": "application/octet-stream", **(headers or {})})

    def attach(self, path, fields, name, content, page="/account"):
        """A form with a file, as a page of the service would send it."""
        parts = [f'--x\r\nContent-Disposition: form-data; name="{key}"\r\n\r\n{value}\r\n'.encode()
                 for key, value in [("csrf", self.csrf(page)), *fields.items()]]
        head = f'--x\r\nContent-Disposition: form-data; name="{name}"; filename="{name}"\r\n\r\n'.encode()
        body = b"".join([*parts, head, content, b"\r\n--x--\r\n"])
        return self.send("POST", path, body, {"Content-Type": "multipart/form-data; boundary=x"})

    def tus(self, method, path="/api/v1/uploads", body=b"", **headers):
        """A request of tus; `upload_length=7` is the header Upload-Length."""
        named = {key.replace("_", "-"): str(value) for key, value in headers.items()}
        if method == "PATCH":
            named.setdefault("Content-Type", "application/offset+octet-stream")
        return self.send(method, path, body, {"Tus-Resumable": "1.0.0", **named})

    def tell(self, path, document, method="POST"):
        """JSON to the API."""
        return self.send(method, path, json.dumps(document), {"Content-Type": "application/json"})


def csrf_in(page):
    found = re.search(r'name="csrf" value="([^"]+)"', page)
    return html.unescape(found.group(1)) if found else ""


def between(text, start, end):
    """What stands between two strings, first time; empty where they are not there."""
    return text.partition(start)[2].partition(end)[0]

"""A server of HTTP that may answer, or cut the connection."""

import html
import json
import socket
import threading
import urllib.parse
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from lti_book import demand

JSON, HTML = "application/json", "text/html; charset=utf-8"


class Request:
    """A request that was read whole."""

    def __init__(self, handler):
        address = urllib.parse.urlsplit(handler.path)
        self.method, self.target, self.path, self.headers = handler.command, handler.path, address.path, handler.headers
        self.query = dict(urllib.parse.parse_qsl(address.query))
        self.body = handler.rfile.read(int(handler.headers.get("Content-Length", 0))).decode()

    @property
    def form(self):
        return dict(urllib.parse.parse_qsl(self.body)) if self.method == "POST" else {}

    def token(self):
        kind, _, token = self.headers.get("Authorization", "").partition(" ")
        return token if kind.lower() == "bearer" else ""

    def expect_type(self, kind):
        found = self.headers.get("Content-Type", "")
        demand(found.partition(";")[0].strip() == kind, f"Content-Type: {found}, not {kind}", 415)

    def expect_accept(self, kind):
        found = self.headers.get("Accept", "*/*")
        accepted = {part.partition(";")[0].strip() for part in found.split(",")}
        demand(accepted & {kind, "*/*", "application/*"}, f"Accept: {found}, not {kind}", 406)


def reply(document, status=200):
    return status, {"Content-Type": JSON, "Cache-Control": "no-store"}, json.dumps(document, default=float).encode()


def refuse(status, why):
    """Returns a refusal in the form of OAuth 2.0."""
    return reply({"error": "invalid_client" if status == 401 else "invalid_request", "error_description": why}, status)


def self_posting_page(action, fields):
    """Returns a page that posts a form."""
    shown = "".join(f'<input type="hidden" name="{name}" value="{html.escape(value)}">' for name, value in fields.items())
    return f'<form method="post" action="{html.escape(action)}">{shown}</form><script>document.forms[0].submit()</script>'


class Server(ThreadingHTTPServer):
    """Logs nothing about clients that end in the midst of a request."""

    daemon_threads = True
    request_queue_size = 128

    def handle_error(self, *_):
        pass


def serve(address, handle):
    """Serves in threads that end with this program. `handle` returns status, headers and body, or None to cut the connection."""

    class Pages(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"
        disable_nagle_algorithm = True

        def log_message(self, *_):
            pass

        def respond(self):
            answer = handle(Request(self))
            if answer is None:
                self.close_connection = True
                self.connection.shutdown(socket.SHUT_RDWR)
                return
            status, headers, body = answer
            self.send_response(status)
            for name, value in headers.items():
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        do_GET = do_POST = do_PUT = do_DELETE = respond

    host, port = address.split(":")
    threading.Thread(target=Server((host, int(port)), Pages).serve_forever, daemon=True).start()

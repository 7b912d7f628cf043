"""A store that speaks S3, in memory, for as long as whoever has started it keeps standard input open. Prints its address.

A bucket can be told to refuse: GET /-/BUCKET/WAY/N has it refuse its N-th request from now and every later one. WAY says how:
`lost`, nothing is done; `unheard`, it is done and the answer is a refusal all the same; `full`, there is no room. N = 0 ends that. The
answer is how many requests there have been since the last such word. A bucket is made by the first.
"""

import logging
import sys
import threading

from moto.core import DEFAULT_ACCOUNT_ID
from moto.moto_server.werkzeug_app import DomainDispatcherApplication, create_backend_app
from moto.s3.models import s3_backends
from werkzeug.serving import make_server

REFUSALS = {"lost": "403 Forbidden", "unheard": "403 Forbidden", "full": "507 Insufficient Storage"}


class Refusing:
    """Counts the requests of each bucket, and refuses those that are to be refused."""

    def __init__(self, store):
        self.store = store
        self.lock = threading.Lock()
        self.told = {}
        self.counts = {}

    def tell(self, bucket, way, first):
        with self.lock:
            if bucket not in self.told:
                s3_backends[DEFAULT_ACCOUNT_ID]["aws"].create_bucket(bucket, "us-east-1")
            count = self.counts.get(bucket, 0)
            self.counts[bucket], self.told[bucket] = 0, (way, first)
        return str(count).encode()

    def refusal(self, bucket):
        """How this request is refused, if it is."""
        with self.lock:
            self.counts[bucket] = self.counts.get(bucket, 0) + 1
            way, first = self.told.get(bucket, ("lost", 0))
            return way if first and self.counts[bucket] >= first else None

    def __call__(self, environ, start_response):
        parts = environ["PATH_INFO"].strip("/").split("/")
        if parts[0] == "-":
            said = self.tell(parts[1], parts[2], int(parts[3]))
            start_response("200 OK", [("Content-Length", str(len(said)))])
            return [said]
        way = self.refusal(parts[0])
        if way is None:
            return self.store(environ, start_response)
        if way == "unheard":
            b"".join(self.store(environ, lambda *_: None))
        else:
            environ["wsgi.input"].read(int(environ.get("CONTENT_LENGTH") or 0))
        start_response(REFUSALS[way], [("Content-Length", "0")])
        return []


def main():
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    store = Refusing(DomainDispatcherApplication(create_backend_app))
    server = make_server("127.0.0.1", 0, store, threaded=True)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    print(f"http://127.0.0.1:{server.port}", flush=True)
    sys.stdin.read()


main()

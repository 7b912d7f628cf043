"""A learning record store of xAPI for tests, Ralph, which appends to a file. Run by the Python of `lrs-requirements.txt`.

    learning_records.py FOLDER           checks the store, and the validator of statements in the node_modules of FOLDER
    learning_records.py serve FOLDER ADDRESS
"""

import base64
import json
import os
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
import uuid
from pathlib import Path

from service import expect, free_address, start, wait_for

HERE = Path(__file__).resolve().parent
USER, PASSWORD = "stylet", "a password of the store"
FILE = "statements.jsonl"
VERB = "http://adlnet.gov/expapi/verbs/scored"
ACTIVITY = "http://adlnet.gov/expapi/activities/simulation"


class Store:
    """A store that runs in a process of its own and keeps its statements in a folder."""

    def __init__(self, folder, address=None):
        self.folder, self.address = Path(folder), address or free_address()
        self.url = f"http://{self.address}/xAPI"
        self.start()

    def start(self):
        """Starts the store, also after it was ended."""
        self.process = start([sys.executable, __file__, "serve", str(self.folder), self.address], self.folder)
        wait_for(f"http://{self.address}/__heartbeat__")

    def kill(self):
        self.process.kill()
        self.process.wait()

    def statements(self):
        """Returns the stored statements, read from the file."""
        file = self.folder / FILE
        return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []

    def send(self, statements, password=PASSWORD):
        """Posts a statement or a list of them; returns the status."""
        secret = base64.b64encode(f"{USER}:{password}".encode()).decode()
        headers = {"Authorization": f"Basic {secret}", "Content-Type": "application/json", "X-Experience-API-Version": "1.0.3"}
        request = urllib.request.Request(f"{self.url}/statements/", json.dumps(statements).encode(), headers)
        try:
            with urllib.request.urlopen(request, timeout=30) as answer:
                return answer.status
        except urllib.error.HTTPError as refusal:
            with refusal:
                return refusal.code


def write_accounts(folder):
    """Writes the account that may do everything; returns the file."""
    import bcrypt

    # The lowest cost: it guards nothing.
    secret = bcrypt.hashpw(PASSWORD.encode(), bcrypt.gensalt(4)).decode()
    account = {"username": USER, "hash": secret, "scopes": ["all"], "agent": {"mbox": "mailto:stylet@uni.example"}}
    file = folder / "accounts.json"
    file.write_text(json.dumps([account]))
    return file


def serve(folder, address):
    """Serves until the process is ended."""
    settings = {
        "RALPH_APP_DIR": folder,
        "RALPH_AUTH_FILE": write_accounts(folder),
        "RALPH_RUNSERVER_AUTH_BACKENDS": "basic",
        "RALPH_RUNSERVER_BACKEND": "fs",
        "RALPH_BACKENDS__LRS__FS__DEFAULT_DIRECTORY_PATH": folder,
        "RALPH_BACKENDS__LRS__FS__DEFAULT_LRS_FILE": FILE,
    }
    os.environ.update({name: str(value) for name, value in settings.items()})
    # Ralph reads its settings when it is imported.
    import uvicorn
    from ralph.backends.data.base import BaseOperationType
    from ralph.backends.data.fs import FSDataBackend

    # By default it refuses to write to a file that exists.
    FSDataBackend.default_operation_type = BaseOperationType.APPEND
    host, port = address.split(":")
    uvicorn.run("ralph.api:app", host=host, port=int(port), log_level="warning")


def make_statement(points=71.5, **changes):
    """Returns a statement about a score, with an id of its own."""
    account = {"homePage": "https://training.example.org", "name": "p-220f317e8a75"}
    exercise = {"id": "https://training.example.org/exercises/one/revisions/1", "definition": {"type": ACTIVITY, "name": {"en": "One"}}}
    statement = {
        "id": str(uuid.uuid4()),
        "actor": {"objectType": "Agent", "account": account},
        "verb": {"id": VERB, "display": {"en": "scored"}},
        "object": {"objectType": "Activity", **exercise},
        "result": {"score": {"scaled": points / 100, "raw": points, "min": 0, "max": 100}, "duration": "PT61.25S"},
        "timestamp": "2026-11-30T12:00:00.000Z",
    }
    return statement | changes


def check_store(store):
    """Checks the answers on which a sender can rely."""
    known = make_statement()
    expect(store.send(known) == 200, "a new statement")
    expect(store.send(known) == 204, "the same one again")
    expect(store.send(known | {"result": {"success": True}}) == 409, "the same id with another body")
    new = make_statement(80)
    expect(store.send([known, new]) == 200, "a known one and a new one")
    bad = {name: value for name, value in make_statement().items() if name != "verb"}
    expect(store.send([make_statement(), bad]) == 422, "one of them without a verb")
    expect(store.send(make_statement(), "another password") == 401, "another password")
    kept = [statement["id"] for statement in store.statements()]
    expect(kept == [known["id"], new["id"]], f"kept: {kept}")
    store.kill()
    store.start()
    expect(store.send([known, new]) == 204, "both after another start")
    many = [make_statement(number) for number in range(100)]
    begun = time.monotonic()
    for first in range(0, 100, 10):
        expect(store.send(many[first : first + 10]) == 200, "ten new ones")
    print(f"100 statements in tens: {time.monotonic() - begun:.2f} s")
    expect(len(store.statements()) == 102, f"{len(store.statements())} statements")


def judge(folder, statements):
    """Returns how many statements the validator warns of, and whether it ends with success."""
    lines = "".join(json.dumps(statement) + "\n" for statement in statements)
    command = ["node", str(HERE / "statements.mjs"), folder]
    done = subprocess.run(command, input=lines, capture_output=True, text=True, check=False)
    expect(done.stdout, done.stderr)
    return int(done.stdout.split()[0]), done.returncode == 0


def check_validator(folder):
    """Checks that the validator warns of each bad statement and of no good one."""
    good = [make_statement(number) for number in range(5)]
    bad = [
        make_statement(id="1"),
        make_statement(actor={"mbox": "ada@uni.example"}),
        make_statement(verb={"display": {"en": "scored"}}),
        make_statement(result={"score": {"raw": 101, "min": 0, "max": 100}}),
        make_statement(result={"duration": "61 s"}),
        make_statement(timestamp="yesterday"),
        make_statement(more=1),
    ]
    expect(judge(folder, good) == (0, True), "a good statement has a warning")
    for statement in bad:
        expect(judge(folder, [*good, statement]) == (1, False), f"no warning of {statement}")
    expect(judge(folder, []) == (0, False), "no statement at all")


def main():
    if sys.argv[1] == "serve":
        serve(Path(sys.argv[2]), sys.argv[3])
        return
    with tempfile.TemporaryDirectory() as folder:
        store = Store(folder)
        check_store(store)
        store.kill()
    check_validator(sys.argv[1])
    print("the store and the validator are as expected")


if __name__ == "__main__":
    main()

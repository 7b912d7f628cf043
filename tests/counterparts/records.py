"""Statements sent to a learning record store, Ralph, by a service that is killed: each arrives once. A validator judges them first.

    records.py PROGRAM FOLDER STATEMENTS [NUMBER]

PROGRAM is the service to check, FOLDER has the validator in its node_modules, STATEMENTS is a file with one statement on each line, and NUMBER
of them are sent.
"""

import json
import random
import sqlite3
import sys
import tempfile
import time
import uuid
from pathlib import Path

from learning_records import PASSWORD, USER, Store, judge
from service import Service, expect, wait_for

KILLS = 50
PAGE = "/admin/learning-records"
QUEUE = """INSERT INTO statements (store_id, id, school_id, person_id, body, state, next_run_at, made_at)
SELECT r.id, ?, r.school_id, p.id, ?, 'waiting', 0, 0 FROM record_stores r JOIN people p ON p.school_id = r.school_id"""
# Makes failed statements due at once, instead of after minutes.
HASTEN = "UPDATE statements SET next_run_at = 0, tries = 0 WHERE state = 'waiting'"


def set_store(service, store):
    """Enters the store by its form."""
    form = {"endpoint": store.url, "user_name": USER, "password": PASSWORD, "version": "1.0.3", "ground": "A trial"}
    page = service.head.post(PAGE, service.head.get(PAGE), **form)
    expect(page.status == 200 and 'role="alert"' not in page.text, f"{page.status} {page.text}")


def change(service, statement, values):
    """Changes the database past the service."""
    with sqlite3.connect(service.folder / "stylet.db", timeout=60) as database:
        database.executemany(statement, values)


def count_waiting(service):
    return service.rows("SELECT count(*) FROM statements WHERE state = 'waiting'")[0][0]


def kill_while_it_sends(service, draw):
    """Kills the service and starts it again, at random times."""
    for _ in range(KILLS):
        time.sleep(draw.random() * 1.5)
        service.kill()
        service.start()
        wait_for(service.url + "/healthz")
    print(f"killed {KILLS} times; {count_waiting(service)} statements wait", flush=True)


def wait_until_sent(service, seconds):
    end = time.monotonic() + seconds
    while count_waiting(service):
        expect(time.monotonic() < end, f"{count_waiting(service)} statements still wait")
        change(service, HASTEN, [()])
        time.sleep(2)


def check_arrived(service, store, sent):
    """Checks that the store has each statement once, with the body that the service had."""
    states = service.rows("SELECT state, count(*) FROM statements GROUP BY state")
    expect(states == [("sent", len(sent))], f"states: {states}")
    arrived = store.statements()
    expect(sorted(one["id"] for one in arrived) == sorted(sent), f"{len(arrived)} arrived of {len(sent)}")
    for one in arrived:
        # The store adds what it knows: when it was stored, and by whom.
        kept = {name: one[name] for name in sent[one["id"]]}
        expect(kept == sent[one["id"]], f"sent {sent[one['id']]}, kept {kept}")


def main():
    program, folder, file = sys.argv[1:4]
    number = int(sys.argv[4]) if len(sys.argv) > 4 else 1000
    statements = [json.loads(line) for line in Path(file).read_text().split("\n") if line]
    expect(judge(folder, statements) == (0, True), "warnings of the validator")
    print(f"{len(statements)} random statements without a warning", flush=True)
    with tempfile.TemporaryDirectory() as place:
        store = Store(place)
        options = ["--allow-plain-http", store.address, "--allow-private-addresses"]
        service = Service(program, options=options)
        set_store(service, store)
        sent = {one["id"]: one for one in random.Random(1).sample(statements, number)}
        change(service, QUEUE, [(uuid.UUID(one).bytes, json.dumps(body)) for one, body in sent.items()])
        kill_while_it_sends(service, random.Random(1))
        wait_until_sent(service, 60 + number)
        check_arrived(service, store, sent)
        print(f"{number} statements arrived once")
        service.kill()
        store.kill()


if __name__ == "__main__":
    main()

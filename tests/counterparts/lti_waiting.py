"""A hundred thousand entries of grades to be looked at for a learning platform: the times of pages, without and with them.

    lti_waiting.py PROGRAM [--database URL]     the service to check
"""

import argparse
import re
import sqlite3
import subprocess
import time
import uuid

from lti_members import confirm, make_cohort, read_members
from lti_platform import Platform, register
from service import Browser, Service, expect

MEMBERS = 450
# Links of the course; each member has an entry for each of them, without an attempt.
LINKS = 223
REQUESTS = 200
LINK = """INSERT INTO platform_links (id, school_id, platform_id, deployment_id, context_id, resource_link_id, page, lineitem_url, made_at)
SELECT {id}, c.school_id, c.platform_id, c.deployment_id, c.id, '{name}', '/exercises/{name}', '{item}', 0 FROM platform_contexts c"""
GRADES = """INSERT INTO deliveries (id, school_id, kind, platform_id, link_id, person_id, subject, state, next_run_at, made_at)
SELECT {random}, l.school_id, 'ags', l.platform_id, l.id, i.person_id, i.subject, 'waiting', 0, 0
FROM platform_links l JOIN identities i ON i.school_id = l.school_id AND i.kind = 'lti' WHERE l.page LIKE '/exercises/%'"""


def read_arguments():
    parser = argparse.ArgumentParser(prog="lti_waiting.py", description="Measures pages while grades wait.")
    parser.add_argument("program", help="the service to check")
    parser.add_argument("--database", help="PostgreSQL instead of SQLite")
    return parser.parse_args()


def change(service, statements):
    """Changes the database past the service."""
    if service.database:
        subprocess.run(["psql", "-q", "-X", "-1", service.database], input=";".join(statements), text=True, check=True)
        return
    with sqlite3.connect(service.folder / "stylet.db", timeout=60) as database:
        for statement in statements:
            database.execute(statement)


def add_waiting(service, platform):
    """Adds links with a grade of each member; returns the number of grades."""
    shared = bool(service.database)
    links = []
    for number in range(LINKS):
        own = uuid.uuid4()
        name = f"exercise-{number}"
        links.append(LINK.format(id=f"'{own}'" if shared else f"x'{own.hex}'", name=name, item=platform.item_url(1)))
    change(service, [*links, GRADES.format(random="gen_random_uuid()" if shared else "randomblob(16)")])
    return int(service.rows("SELECT count(*) FROM deliveries WHERE state = 'waiting'")[0][0])


def measure(service, paths):
    """Returns p50 and p99 of each page, in ms, from requests to all pages in turn."""
    times = {path: [] for path in paths}
    for _ in range(REQUESTS):
        for path in paths:
            begun = time.perf_counter()
            page = service.head.get(path)
            times[path].append((time.perf_counter() - begun) * 1000)
            expect(page.status == 200, f"{path}: {page.status}")
    return {path: (sorted(took)[len(took) // 2], sorted(took)[len(took) * 99 // 100]) for path, took in times.items()}


def main():
    arguments = read_arguments()
    platform = Platform(people=MEMBERS + 1)
    options = ["--allow-plain-http", platform.address, "--allow-private-addresses"]
    service = Service(arguments.program, database=arguments.database, options=options)
    client = register(service, platform)
    Browser(service.url).launch(platform.begin_launch(client, "user-1", next(iter(platform.links.values()))))
    own = service.find_platform()
    confirm(service, read_members(service, own, make_cohort(service)))
    paths = ["/", "/people", "/cohorts", own, f"{own}/deliveries?state=waiting"]
    before = measure(service, paths)
    waiting = add_waiting(service, platform)
    expect(waiting > 90_000, f"{waiting} grades wait")
    during = measure(service, paths)
    left = int(service.rows("SELECT count(*) FROM deliveries WHERE state = 'waiting'")[0][0])
    print(f"{waiting} entries waited, {left} still do")
    print("| page | p50/ms without | p99/ms without | p50/ms | p99/ms |\n|---|--:|--:|--:|--:|")
    for path in paths:
        figures = " | ".join(f"{value:.1f}" for value in (*before[path], *during[path]))
        print(f"| `{re.sub('[0-9a-f-]{36}', 'ID', path)}` | {figures} |")


if __name__ == "__main__":
    main()

"""Several clients of a directory create, change and disable many people at once, while the times of pages are measured.

    crowd.py PROGRAM [--people N] [--clients N] [--database URL]
"""

import argparse
import collections
import http.client
import json
import statistics
import threading
import time
from concurrent.futures import ThreadPoolExecutor

from service import Service, expect

PAGES = ["/", "/people", "/login"]
# Every so many people are created by two clients at once.
CREATED_TWICE = 20
PATCH = "urn:ietf:params:scim:api:messages:2.0:PatchOp"
USER = "urn:ietf:params:scim:schemas:core:2.0:User"


class Directory:
    """Sends requests with one token, as clients of one directory do, each on a connection of its own."""

    def __init__(self, service):
        self.address, self.token = service.address, service.make_token()
        self.connections = threading.local()
        self.statuses = collections.Counter()
        self.lock = threading.Lock()

    def send(self, method, path, body):
        """Sends a request until it is not answered with 429; returns the status and the answer."""
        while True:
            status, retry_after, answer = self.send_once(method, path, body)
            with self.lock:
                self.statuses[status] += 1
            if status != 429:
                return status, answer
            time.sleep(float(retry_after))

    def send_once(self, method, path, body):
        if not hasattr(self.connections, "own"):
            self.connections.own = http.client.HTTPConnection(self.address, timeout=60)
        headers = {"Authorization": f"Bearer {self.token}", "Content-Type": "application/scim+json"}
        self.connections.own.request(method, f"/scim/v2{path}", json.dumps(body), headers)
        response = self.connections.own.getresponse()
        return response.status, response.headers["Retry-After"], json.loads(response.read())

    def create(self, number):
        name = f"person-{number}@uni.example"
        emails = [{"value": name, "type": "work", "primary": True}]
        body = {"schemas": [USER], "userName": name, "externalId": str(number), "displayName": f"Person {number}"}
        status, answer = self.send("POST", "/Users", body | {"emails": emails})
        return status, answer.get("id")

    def patch(self, person, value):
        body = {"schemas": [PATCH], "Operations": [{"op": "replace", "value": value}]}
        status, _ = self.send("PATCH", f"/Users/{person}", body)
        expect(status == 200, f"a change of {person} is answered with {status}")


class PageTimer:
    """Fetches pages in turn, as the administrator, and notes how long each takes."""

    def __init__(self, service):
        self.browser = service.head
        self.times_ms = {}
        self.ended = threading.Event()

    def measure(self, phase):
        for page in PAGES:
            begun = time.perf_counter()
            answer = self.browser.get(page)
            taken_ms = 1000 * (time.perf_counter() - begun)
            expect(answer.status == 200, f"{page} is answered with {answer.status}")
            self.times_ms.setdefault((page, phase), []).append(taken_ms)

    def measure_until_end(self):
        while not self.ended.wait(0.2):
            self.measure("during")

    def report(self):
        for (page, phase), times_ms in sorted(self.times_ms.items()):
            percentiles = statistics.quantiles(times_ms, n=100, method="inclusive")
            print(f"{page:8} {phase:6} {len(times_ms):5} times: p50 {percentiles[49]:6.1f} ms, p99 {percentiles[98]:6.1f} ms")


def run_phase(name, clients, work, items):
    """Does the work for each item by all clients; returns the results."""
    begun = time.monotonic()
    with ThreadPoolExecutor(clients) as pool:
        results = list(pool.map(work, items))
    took = time.monotonic() - begun
    print(f"{name}: {len(results)} in {took:.0f} s, {len(results) / took:.0f} a second", flush=True)
    return results


def create_people(directory, people, clients):
    """Creates all people; returns their ids."""
    numbers = [number for number in range(people) for _ in range(1 if number % CREATED_TWICE else 2)]
    made = {}
    for number, (status, person) in zip(numbers, run_phase("created", clients, directory.create, numbers)):
        made.setdefault(number, []).append(status)
        made[number, "id"] = person or made.get((number, "id"))
    for number in range(people):
        wanted = [201] if number % CREATED_TWICE else [201, 409]
        expect(sorted(made[number]) == wanted, f"person {number} is answered with {made[number]}")
    return [made[number, "id"] for number in range(people)]


def count(service, query):
    return int(service.rows(f"SELECT count(*) FROM {query}")[0][0])


def check_result(service, people, staff):
    trainees = "people WHERE role = 'trainee'"
    expect(count(service, trainees) == people, f"{count(service, trainees)} people instead of {people}")
    expect(count(service, f"(SELECT DISTINCT email FROM {trainees}) AS emails") == people, "an address is used twice")
    expect(count(service, f"{trainees} AND display_name NOT LIKE 'Changed %'") == 0, "a change is missing")
    expect(count(service, f"{trainees} AND disabled_at IS NULL") == 0, "a person is still active")
    # A creation is logged as an addition and a change of the number, hence the name.
    for entry in ["person.added", "person.changed' AND details LIKE '%\"name\":true%", "person.disabled"]:
        rows = count(service, f"audit_log WHERE actor = 'directory' AND action = '{entry}'")
        expect(rows == people, f"{rows} rows of {entry} in the audit log instead of {people}")
    expect(list_staff(service) == staff, f"the staff {staff} became {list_staff(service)}")


def list_staff(service):
    return service.rows("SELECT email, role, credential_version, disabled_at FROM people WHERE role <> 'trainee'")


def read_arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--people", type=int, default=400)
    parser.add_argument("--clients", type=int, default=8)
    parser.add_argument("--database")
    return parser.parse_args()


def main():
    arguments = read_arguments()
    service = Service(arguments.program, database=arguments.database)
    directory, pages = Directory(service), PageTimer(service)
    staff = list_staff(service)
    for _ in range(50):
        pages.measure("before")
    timer = threading.Thread(target=pages.measure_until_end)
    timer.start()
    try:
        people = create_people(directory, arguments.people, arguments.clients)
        rename = lambda one: directory.patch(one[1], {"displayName": f"Changed {one[0]}"})  # noqa: E731
        run_phase("changed", arguments.clients, rename, enumerate(people))
        run_phase("disabled", arguments.clients, lambda person: directory.patch(person, {"active": False}), people)
    finally:
        pages.ended.set()
        timer.join()
    check_result(service, arguments.people, staff)
    pages.report()
    print("requests:", ", ".join(f"{times} with {status}" for status, times in directory.statuses.most_common()))


if __name__ == "__main__":
    main()

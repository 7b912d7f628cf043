"""Grades sent to a learning platform that fails, by a service that is killed: in the end the platform has the service's own grades.

    grades.py PROGRAM [--database URL]     the service to check
"""

import argparse
import collections
import contextlib
import http.client
import random
import re
import sqlite3
import subprocess
import sys
import threading
import time
from datetime import datetime

from attempts import Station, copy_recording, publish_exercise, read_recordings, wait_until_scored
from lti_faults import ALL, UNAUTHORIZED, Fault
from lti_platform import Platform, register
from service import Browser, Service, expect

# How often each endpoint fails.
ENDPOINTS = {"scores": 0.9, "token": 0.06, "items": 0.04}
# How many of the faults are kills.
KILLS = 0.1
NEAR = 1e-6
# Makes failed deliveries due at once, instead of after minutes, hours and days. Repeated after some seconds.
HASTEN = "UPDATE deliveries SET next_run_at = 0, tries = 0 WHERE state = 'waiting' AND next_run_at > 0"
HASTEN_S = 2
GRADES = """SELECT i.subject, g.score, s.exercise_id FROM grades g
JOIN sessions s ON s.school_id = g.school_id AND s.id = g.session_id
JOIN identities i ON i.school_id = s.school_id AND i.person_id = s.trainee_id WHERE i.kind = 'lti'"""


def read_arguments():
    parser = argparse.ArgumentParser(prog="grades.py", description="Sends grades to a learning platform that fails.")
    parser.add_argument("program", help="the service to check")
    parser.add_argument("--database", help="PostgreSQL instead of SQLite")
    parser.add_argument("--trainees", type=int, default=40, help="number of grades, such as 2000")
    parser.add_argument("--changes", type=int, default=5, help="changes of each grade")
    parser.add_argument("--faults", type=int, default=300, help="number of faults")
    parser.add_argument("--wait", type=int, default=200, help="seconds without any request after which it has failed")
    parser.add_argument("--seed", type=int, default=time.time_ns() % 10**6, help="seed of faults and grades")
    return parser.parse_args()


def persist(work, seconds=120):
    """Returns the page of a request to a service that may be killed meanwhile."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            page = work()
            if page.status < 500:
                return page
            failure = page.status
        except (OSError, http.client.HTTPException) as error:
            failure = error
        time.sleep(0.2)
    sys.exit(f"failed: the service does not answer: {failure}")


class School:
    """A service, a platform with a link to each exercise, and trainees who come through them."""

    def __init__(self, arguments):
        self.draw = random.Random(arguments.seed)
        self.platform = Platform(people=arguments.trainees + 1, own_query={"type": "lti"})
        options = ["--allow-plain-http", self.platform.address, "--allow-private-addresses"]
        self.service = Service(arguments.program, database=arguments.database, options=options)
        self.tapes = read_recordings()
        self.client = register(self.service, self.platform)
        # The first link has a line item. For the others the service makes one.
        pages = [publish_exercise(self.service, tape) for tape in self.tapes]
        self.links = [self.platform.add_link(page, {"stylet": page}, has_item=not number) for number, page in enumerate(pages)]
        self.trainees = {f"user-{number + 1}": number for number in range(arguments.trainees)}
        self.attempts = {}
        self.kills = 0
        self.is_over = threading.Event()

    def tape_of(self, trainee):
        """Returns the recording whose exercise a trainee has; the links are in the same order."""
        number = self.trainees[trainee] % len(self.links)
        return self.links[number], self.tapes[number]

    def launch_everybody(self):
        """Launches every trainee by a link, into an account of their own."""
        for trainee in self.trainees:
            link, _ = self.tape_of(trainee)
            page = launch(self.service, self.platform.begin_launch(self.client, trainee, link))
            expect(page.status == 200 and page.url == self.service.url + link.custom["stylet"], f"{trainee}: {page.status} {page.url}")

    def practise(self):
        """Uploads an attempt of each trainee."""
        query = "SELECT i.subject, p.pseudonym FROM identities i JOIN people p ON p.id = i.person_id WHERE i.kind = 'lti'"
        pseudonyms, station = dict(self.service.rows(query)), Station(self.service)
        expect(pseudonyms.keys() >= self.trainees.keys(), f"accounts: {len(pseudonyms)}")
        for trainee, number in self.trainees.items():
            copy = copy_recording(self.tape_of(trainee)[1], pseudonyms[trainee], number)
            self.attempts[trainee] = copy.session_id
            uploaded = persist(lambda tape=copy: station.upload(tape))
            expect(uploaded.status in (200, 201), f"not uploaded: {uploaded.status} {uploaded.text}")
        wait_until_scored(self.service, len(self.trainees), 60 + len(self.trainees))

    def change(self, trainee):
        """Gives another grade, or takes the given one back."""
        own = f"/sessions/{self.attempts[trainee]}"
        head, draw = self.service.head, self.draw
        page = persist(lambda: head.get(f"{own}/grade"))
        expect(page.status == 200 and page.url.endswith("/grade"), f"{page.url}: {page.status}")
        if "/override/withdraw" in page.text and draw.random() < 0.1:
            answer = persist(lambda: head.post(f"{own}/override/withdraw", page, reason="A mistake"))
        else:
            points = draw.choice([0, 100, draw.randrange(10001) / 100, draw.randrange(1, 12) / 12 * 100, draw.random() * 100])
            form = {"score": repr(float(points)), "result": "passed" if points > 60 else "failed", "reason": "Seen in the room"}
            answer = persist(lambda: head.post(f"{own}/override", page, **form))
        # Killed after the grade was withdrawn, it is sent again and refused.
        expect(answer.status in (200, 409, 422), f"{own}: {answer.status} {answer.text}")

    def change_everybody(self):
        """Changes every grade, in random order. Each time the platform has another key, so that its access tokens end."""
        self.platform.rotate_key()
        for trainee in self.draw.sample(list(self.trainees), len(self.trainees)):
            self.change(trainee)
        print(f"changed every grade; {self.platform.faults.left()} requests are planned", flush=True)

    def plan_faults(self, count):
        """Plans faults and kills, with requests that succeed between them."""
        kills = [Fault("killed before", act=self.kill), Fault("killed after", is_handled=True, act=self.kill)]
        for _ in range(count):
            endpoint = self.draw.choices(list(ENDPOINTS), ENDPOINTS.values())[0]
            fault = self.draw.choice(kills if self.draw.random() < KILLS else ALL)
            if fault is UNAUTHORIZED and endpoint == "token":
                # There it means that the tool is not registered.
                continue
            pause = [None] * self.draw.randrange(2)
            after = [None] if fault is UNAUTHORIZED else []
            self.platform.faults.plan(endpoint, *pause, fault, *after)

    def kill(self):
        """Kills the service in the midst of a request to the platform."""
        self.kills += 1
        self.service.kill()

    def keep_alive(self):
        """Starts the service again whenever it was killed, and makes failed deliveries due."""
        hastened = 0.0
        while not self.is_over.wait(0.2):
            if self.service.process.poll() is not None:
                self.service.start()
            if time.monotonic() > hastened + HASTEN_S:
                self.hasten()
                hastened = time.monotonic()

    def run(self, arguments):
        """Gives grades and changes them, and again for as long as faults are left; the platform has to have them each time."""
        self.practise()
        print("an attempt of each is scored", flush=True)
        expect_deliveries(self.service)
        for _ in range(arguments.changes):
            self.change_everybody()
        wait_until_same(self, arguments.wait)
        for _ in range(arguments.faults):
            if not self.platform.faults.left("scores"):
                break
            self.change_everybody()
            wait_until_same(self, arguments.wait)
        # Requests that are still under way must not change anything.
        time.sleep(3)
        wait_until_same(self, 0).show()

    def hasten(self):
        """Makes deliveries due."""
        if self.service.database:
            subprocess.run(["psql", "-q", "-X", self.service.database, "-c", HASTEN], check=False, capture_output=True)
            return
        with contextlib.suppress(sqlite3.OperationalError), contextlib.closing(open_database(self.service)) as database:
            database.execute(HASTEN)
            database.commit()


def open_database(service):
    return sqlite3.connect(service.folder / "stylet.db", timeout=5)


def expect_deliveries(service):
    """Ends the program unless the service can send grades."""
    try:
        service.rows("SELECT state, last_status, next_run_at FROM deliveries WHERE tries > 0")
    except (sqlite3.OperationalError, subprocess.CalledProcessError) as error:
        sys.exit(f"failed: this service sends no grades: {error}")


def launch(service, address):
    """Launches in a browser of its own; returns the page after it. Waits while the service has too many launches."""
    for _ in range(120):
        page = Browser(service.url).launch(address)
        if page.status != 429:
            return page
        time.sleep(1)
    sys.exit("failed: no more launches are accepted")


class Comparison:
    """The service's grades next to those of the platform."""

    def __init__(self, school):
        self.school, self.book = school, school.platform.book
        self.items = collections.defaultdict(list)
        for number, user in list(self.book.scores):
            self.items[user].append(number)
        self.rows = [self.compare(*row) for row in sorted(school.service.rows(GRADES))]
        self.wrong = [row for row in self.rows if not row[3]]

    def compare(self, subject, own, exercise):
        """Returns a trainee, the grade here, the points at the platform, and whether they are the same."""
        points = [self.book.points(number, subject) for number in self.items[subject]]
        link, tape = self.school.tape_of(subject)
        is_right = link.item in (None, *self.items[subject]) and tape.session["exercise_id"] == exercise
        is_same = len(points) == 1 and points[0] is not None and abs(points[0] - float(own)) <= NEAR
        return subject, float(own), points, is_right and is_same

    def show(self):
        print(f"{len(self.rows)} grades, {len(self.rows) - len(self.wrong)} of them the same at the platform")
        for subject, own, points, is_same in self.wrong[:10] or self.rows[:3]:
            print(f"  {subject}: {own} here, {points} there{'' if is_same else '   DIFFERENT'}")


def wait_until_same(school, seconds):
    """Returns the comparison once the platform has every grade. Ends the program if no request arrives for so long, or a score is refused."""
    received, end = 0, 0.0
    while (found := Comparison(school)).wrong:
        check_refusals(school.platform)
        if len(school.platform.log) > received:
            received, end = len(school.platform.log), time.monotonic() + seconds
        if time.monotonic() > end:
            found.show()
            states = school.service.rows("SELECT state, last_status, count(*) FROM deliveries GROUP BY state, last_status")
            sys.exit(f"failed: {len(found.wrong)} grades differ, and no request has arrived for {seconds} s; deliveries: {states}")
        time.sleep(1)
    return found


def check_refusals(platform):
    """Checks that no score was refused for its form, time or address; returns the answers without a fault, by status."""
    statuses = collections.Counter(entry.status for entry in list(platform.log) if entry.endpoint == "scores" and not entry.fault)
    # 0 is under way. An access token that has ended is still tried (401).
    refused = {status: count for status, count in statuses.items() if status not in (0, 200, 201, 202, 204, 401)}
    expect(not refused, f"the platform refused scores: {refused}")
    return sorted(statuses.items())


def check_requests(school):
    """Checks everything that the platform received, and prints it."""
    platform = school.platform
    received = platform.received("scores")
    print(f"{len(received)} scores received, {len(platform.book.accepted)} accepted; answers without a fault: {check_refusals(platform)}")
    met = collections.Counter(entry.fault for entry in platform.log if entry.fault)
    print(f"{met.total()} faults met: {sorted(met.items())}; {school.kills} kills")
    items = [item for item in platform.book.items.values() if "resourceId" in item]
    expect(len(items) == len(school.links) - 1, f"line items made by the service: {items}")
    check_submissions(school)


def check_submissions(school):
    """Checks that every score of a trainee names the same attempt, by its time and its address."""
    times = collections.defaultdict(set)
    for _, user, score in school.platform.book.accepted:
        submitted = score.body.get("submission", {}).get("submittedAt")
        expect(submitted, f"no time of submission: {score.body}")
        times[user].add(datetime.fromisoformat(submitted))
        expect(school.attempts[user] in score.body.get("comment", ""), f"no address of the attempt: {score.body}")
        expect(not re.search(r"Seen in the room|A mistake|Head", score.body["comment"]), f"words of a teacher: {score.body}")
    expect(all(len(found) == 1 for found in times.values()), "another time of submission after a change")


def main():
    arguments = read_arguments()
    print(f"seed {arguments.seed}", flush=True)
    school = School(arguments)
    school.launch_everybody()
    print(f"{arguments.trainees} trainees launched", flush=True)
    school.plan_faults(arguments.faults)
    guard = threading.Thread(target=school.keep_alive, daemon=True)
    guard.start()
    try:
        school.run(arguments)
    finally:
        school.is_over.set()
        guard.join()
    check_requests(school)


if __name__ == "__main__":
    main()

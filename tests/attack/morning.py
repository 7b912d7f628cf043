"""A morning of mixed load: see tests/attack/morning."""

import argparse
import os
import random
import socket
import sys
import tempfile
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from attacks.bombs import bombs, costly_scene  # noqa: E402
from main import newest  # noqa: E402
from tape import ago  # noqa: E402
from town import Programs, Template, Town, Watch  # noqa: E402
from verdict import NotTried  # noqa: E402
from visitor import CutOff, own_address  # noqa: E402
from world import World  # noqa: E402

# Longest that an honest request may take, in s.
MOST_S = 1.0


def arguments():
    parser = argparse.ArgumentParser(prog="tests/attack/morning", description="Honest work with attacks in between.")
    parser.add_argument("--binary", type=Path, help="web-admin, with stylet beside it")
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--no-attacks", action="store_true", help="the same morning in peace, to compare with")
    parser.add_argument("--exclude", default="", help="attacks to leave out, with commas")
    return parser.parse_args()


class Morning:
    """One town, its honest people, and what they waited for."""

    def __init__(self, world, town):
        self.world, self.town, self.over = world, town, threading.Event()
        self.waits, self.wrong, self.tried, self.lock = {}, [], {}, threading.Lock()
        # Made beforehand: whoever simulates them has another machine.
        self.tapes = [world.recording() for _ in range(6)]
        self.base = world.recording()
        self.small = [data for _, data in bombs(self.base.another(), small=True)]

    def ask(self, kind, expected, work):
        """An honest request, timed."""
        begun = time.monotonic()
        try:
            answer = work()
            right = answer.status in expected
        except CutOff as error:
            answer, right = error, False
        with self.lock:
            self.waits.setdefault(kind, []).append(time.monotonic() - begun)
            if not right:
                self.wrong.append(f"{kind}: {str(answer)[:200]}")

    def pages(self, name, paths):
        browser, draw = self.town.browser(name), random.Random(name)
        while not self.over.wait(draw.random() * 0.6):
            self.ask(f"pages of {name}", (200,), lambda: browser.get(draw.choice(paths)))

    def sign_ins(self):
        draw = random.Random(5)
        while not self.over.wait(2 + draw.random() * 3):
            visitor = self.town.stranger()
            csrf = visitor.csrf("/login")
            fields = {"csrf": csrf, "email": f"{draw.choice(['ben', 'zoe', 'near'])}@example.org", "password": "vier Käse im Wind"}
            self.ask("signing in", (303,), lambda v=visitor, f=fields: v.form("/login", f))

    def uploads(self, name):
        """Attempts as a station would bring them, and then their scores."""
        program, draw = self.town.program(name), random.Random(name)
        while not self.over.wait(3 + draw.random() * 4):
            data = draw.choice(self.tapes).another(started_at=ago(minutes=draw.randrange(5, 600))).write()
            self.ask("uploads", (201,), lambda d=data: program.upload(d))
            self.ask("lists", (200,), lambda: program.get("/api/v1/sessions?limit=20"))

    def honest(self):
        town, cohort = self.town, self.town.cohort("Spring")
        people = ["/", "/account", "/curricula", "/assignments"]
        teacher = ["/", "/cohorts", f"/cohorts/{cohort}", f"/cohorts/{cohort}/progress", "/review", "/drafts"]
        head = ["/admin", "/people", "/progress", "/admin/service"]
        work = [lambda: self.pages("ada", people), lambda: self.pages("teacher", teacher), lambda: self.pages("head", head)]
        return [*work, self.sign_ins, lambda: self.uploads("ben"), lambda: self.uploads("ada")]

    # Attacks, each again and again.

    def bomb(self):
        self.town.program("eve").upload(random.choice(self.small))

    def many_fields(self):
        visitor = self.town.stranger()
        body = f"csrf={visitor.csrf('/login')}" + "&email=a" * 150_000
        visitor.send("POST", "/login", body, {"Content-Type": "application/x-www-form-urlencoded"})

    def guesses(self):
        [self.town.stranger().sign_in(f"x{n}@example.org", "guess") for n in range(10)]

    def half_heads(self):
        held, address = [], own_address()
        for _ in range(100):
            try:
                one = socket.create_connection(self.town.service.place, timeout=2, source_address=(address, 0))
                one.sendall(b"GET /login HTTP/1.1\r\nX-")
                held.append(one)
            except OSError:
                break
        self.over.wait(5)
        [one.close() for one in held]

    def begun_uploads(self):
        [self.town.program("zoe").tus("POST", upload_length=511_000_000) for _ in range(20)]

    def scene(self):
        import hashlib

        scene = costly_scene(self.base.document("scene.toml").decode()).encode()
        tape = self.base.another(scene_sha256=hashlib.sha256(scene).hexdigest()).attach("scene.toml", scene)
        self.town.program("eve").upload(tape.write())

    def preview(self):
        teacher = self.town.browser("colleague")
        page = self.__dict__.setdefault("draft", None) or teacher.press("/drafts", {"exercise": "only", "id": "costly"}).header("location")
        self.draft = page
        scene = costly_scene(self.base.document("scene.toml").decode(), "axisymmetric") + f"\n# {time.monotonic()}\n"
        teacher.press(f"{page}/preview", {"document": self.world.template.exercise.read_text(), "scene": scene})

    def attacks(self, excluded):
        named = {"bomb": 1, "many_fields": 4, "guesses": 5, "half_heads": 6, "begun_uploads": 8, "scene": 60, "preview": 20}
        return [lambda n=name, s=pause: self.again(n, s) for name, pause in named.items() if name not in excluded]

    def again(self, name, pause):
        while not self.over.wait(pause):
            try:
                getattr(self, name)()
            except (CutOff, OSError):
                pass
            with self.lock:
                self.tried[name] = self.tried.get(name, 0) + 1


def quantile(waits, share):
    ordered = sorted(waits)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def report(morning, watched, pid):
    every = [wait for waits in morning.waits.values() for wait in waits]
    print("| honest requests | number | p50/ms | p99/ms | longest/ms |\n|---|---:|---:|---:|---:|")
    for kind, waits in [*sorted(morning.waits.items()), ("all", every)]:
        figures = " | ".join(f"{value * 1e3:.0f}" for value in (quantile(waits, 0.5), quantile(waits, 0.99), max(waits)))
        print(f"| {kind} | {len(waits)} | {figures} |")
    restarts = 0 if morning.town.service.is_running and morning.town.service.child.pid == pid else 1
    print(f"\nattacks: {morning.tried}")
    print(f"restarts: {restarts}; memory: {watched.begun_mb:.0f} MB before, at most {watched.peak_mb:.0f} MB")
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    print(f"answered otherwise than an honest request should be: {len(morning.wrong)} {morning.wrong[:5]}")
    late = sum(wait > MOST_S for wait in every)
    print(f"over {MOST_S:g} s: {late} of {len(every)}")
    return int(bool(restarts or late or morning.wrong))


def main():
    asked = arguments()
    with tempfile.TemporaryDirectory(prefix="stylet-morning-") as folder:
        world = World(Template(Programs(asked.binary.resolve() if asked.binary else newest(), folder)), 1.0)
        town = Town(world.template, name="morning")
        try:
            return spend(Morning(world, town), asked)
        finally:
            town.close()


def spend(morning, asked):
    for name in ("ada", "teacher", "head", "colleague"):
        if morning.town.browser(name).get("/account").status != 200:
            raise NotTried(name)
    pid = morning.town.service.child.pid
    work = morning.honest() + ([] if asked.no_attacks else morning.attacks(asked.exclude.split(",")))
    threads = [threading.Thread(target=one, daemon=True) for one in work]
    with Watch(morning.town.service) as watched:
        [thread.start() for thread in threads]
        time.sleep(asked.minutes * 60)
        morning.over.set()
        [thread.join(30) for thread in threads]
    return report(morning, watched, pid)


if __name__ == "__main__":
    sys.exit(main())

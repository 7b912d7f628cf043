"""Two schools with people, and a service in front of them that attacks may damage: each gets a copy."""

import os
import re
import shutil
import signal
import sqlite3
import subprocess
import threading
import time
from contextlib import closing
from pathlib import Path

from visitor import PASSWORD, Visitor

ROOT = Path(__file__).resolve().parents[2]
# Address, role, school, cohort.
PEOPLE = [
    ("head", "administrator", "North", None),
    ("teacher", "instructor", "North", "Spring"),
    ("near", "instructor", "North", "Spring"),
    ("colleague", "instructor", "North", "Autumn"),
    ("ada", "trainee", "North", "Spring"),
    ("ben", "trainee", "North", "Spring"),
    ("eve", "trainee", "North", "Autumn"),
    ("zoe", "trainee", "North", "Autumn"),
    ("chief", "administrator", "South", None),
    ("guide", "instructor", "South", "Summer"),
    ("sam", "trainee", "South", "Summer"),
]
COURSE = 'id = "one-step"\ntitle = "One step"\n[mastery]\nrule = "passes"\npasses = 1\nof = 1\n[[exercise]]\nfile = "only.toml"\n'


class Programs:
    """The two programs under attack, and a folder for what is made with them."""

    def __init__(self, binary, folder):
        self.binary, self.folder = Path(binary), Path(folder)
        self.stylet_path = self.binary.with_name("stylet")

    def run(self, *arguments, program=None, check=True, **options):
        command = [str(program or self.binary), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, **options)
        if check and done.returncode:
            raise RuntimeError(f"{' '.join(command)}: {done.stdout}{done.stderr}")
        return done

    def stylet(self, *arguments, **options):
        return self.run(*arguments, program=self.stylet_path, **options)


class Template:
    """What every town begins with: made once, copied often."""

    def __init__(self, programs):
        self.programs = programs
        self.data = programs.folder / "template"
        self.tokens, self.pseudonyms = {}, {}
        for name, role, school, cohort in PEOPLE:
            self._add(name, role, school, cohort)
        for school in ("North", "South"):
            programs.run("curricula", "import", "curricula", "--school", school, "--data-dir", self.data)
        programs.run("curricula", "import", self._easy_course(), "--school", "North", "--data-dir", self.data)
        # As if everybody had signed in for the first time and chosen this password: the command line's is good for that alone.
        with sqlite3.connect(self.data / "stylet.db") as database:
            database.execute("UPDATE people SET password_initial_until = NULL")
        database.close()

    def _add(self, name, role, school, cohort):
        words = ["user", "add", "--data-dir", self.data, "--school", school, "--role", role, "--token"]
        words += ["--email", f"{name}@example.org", "--name", name.capitalize(), "--password", PASSWORD]
        said = self.programs.run(*words, *(["--cohort", cohort] if cohort else [])).stdout
        self.tokens[name] = re.search(r"token: (\S+)", said).group(1)
        self.pseudonyms[name] = re.search(r"pseudonym (\S+)", said).group(1)

    def _easy_course(self):
        """A course of one exercise, mastered with one pass."""
        folder = self.programs.folder / "easy"
        (folder / "course").mkdir(parents=True)
        shutil.copytree(ROOT / "curricula/scenes", folder / "scenes")
        text = (ROOT / "curricula/lower-back-basics/1-feel-the-layers.toml").read_text()
        (folder / "course/only.toml").write_text(re.sub(r'(?m)^id = .*$', 'id = "only"', text, count=1))
        (folder / "course/course.toml").write_text(COURSE)
        return folder

    @property
    def exercise(self):
        """The one exercise of the easy course."""
        return self.programs.folder / "easy/course/only.toml"


class Service:
    """`web-admin serve` on a folder."""

    def __init__(self, programs, data, options=(), environment=None, gentle=True):
        self.programs, self.data = programs, Path(data)
        self.options, self.environment = list(options), environment or {}
        if gentle and "--reserve-mb" not in self.options:
            self.options += ["--reserve-mb", "10"]
        if gentle and "--database-reserve-mb" not in self.options:
            self.options += ["--database-reserve-mb", "5"]
        self.log = self.data.with_suffix(".log")
        self.child = None
        self.start()

    def start(self):
        words = [self.programs.binary, "serve", "--listen", "127.0.0.1:0", "--data-dir", self.data, *self.options]
        with self.log.open("a") as log:
            self.child = subprocess.Popen(
                list(map(str, words)), stdout=subprocess.PIPE, stderr=log, text=True, env={**os.environ, **self.environment}
            )
        for line in self.child.stdout:
            found = re.search(r"http://([\d.]+):(\d+)", line)
            if found:
                self.place = (found.group(1), int(found.group(2)))
                return
        raise RuntimeError(f"the service did not start: {self.log.read_text()[-2000:]}")

    def stop(self, how=signal.SIGTERM):
        if self.child and self.child.poll() is None:
            self.child.send_signal(how)
        if self.child:
            self.child.wait(30)

    def restart(self, how=signal.SIGKILL):
        self.stop(how)
        self.start()

    @property
    def is_running(self):
        return self.child.poll() is None

    def memory_mb(self):
        """Memory that is in use now, in MB; 0 once it has ended."""
        try:
            status = Path(f"/proc/{self.child.pid}/status").read_text()
        except OSError:
            return 0.0
        return int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1000 if "VmRSS" in status else 0.0


class Town:
    """A service of its own on a copy of the template."""

    def __init__(self, template, options=(), environment=None, name="town"):
        self.template, self.programs = template, template.programs
        self.data = self.programs.folder / f"{name}-{time.monotonic_ns()}"
        shutil.copytree(template.data, self.data)
        self.service = Service(self.programs, self.data, options, environment)
        self.signed_in = {}

    def stranger(self, **more):
        return Visitor(self.service, **more)

    def program(self, name):
        """Somebody's program, with their token."""
        return Visitor(self.service, token=self.template.tokens[name])

    def browser(self, name):
        """Somebody's browser, signed in."""
        if name not in self.signed_in:
            visitor = Visitor(self.service)
            answer = visitor.sign_in(f"{name}@example.org")
            if answer.status != 303:
                raise RuntimeError(f"{name} cannot sign in: {answer}")
            self.signed_in[name] = visitor
        return self.signed_in[name]

    def rows(self, query, *values):
        """What the database holds, read only: ids as text."""
        with closing(sqlite3.connect(f"file:{self.data}/stylet.db?mode=ro", uri=True, timeout=20)) as connection:
            return connection.execute(query, values).fetchall()

    def one(self, query, *values):
        return self.rows(query, *values)[0][0]

    def person(self, name):
        return uuid_of(self.one("SELECT id FROM people WHERE email = ?", f"{name}@example.org"))

    def cohort(self, name):
        return uuid_of(self.one("SELECT id FROM cohorts WHERE name = ?", name))

    def wait_scored(self, session, seconds=60):
        """What the API says of a session once it is no longer pending."""
        # An administrator of either school finds it in one of them.
        for _ in range(int(seconds * 10)):
            for name in ("head", "chief"):
                told = self.program(name).get(f"/api/v1/sessions/{session}")
                if told.status == 200 and told.json["state"] != "pending":
                    return told.json
            time.sleep(0.1)
        raise RuntimeError(f"{session} was not scored within {seconds} s")

    def log(self):
        return self.service.log.read_text(errors="replace")

    def close(self):
        self.service.stop(signal.SIGKILL)
        shutil.rmtree(self.data, ignore_errors=True)


def uuid_of(value):
    import uuid

    return str(uuid.UUID(bytes=value)) if isinstance(value, bytes) else str(value)


class Watch:
    """Memory of a service and its helpers, and how long an honest visitor waits meanwhile."""

    def __init__(self, service, visitor=None, path="/account"):
        self.service, self.visitor, self.path = service, visitor, path
        self.stopped = threading.Event()
        self.begun_mb, self.peak_mb, self.waits = service.memory_mb(), 0.0, []

    def __enter__(self):
        self.threads = [threading.Thread(target=self._weigh, daemon=True)]
        if self.visitor:
            self.threads.append(threading.Thread(target=self._ask, daemon=True))
        [thread.start() for thread in self.threads]
        return self

    def __exit__(self, *_):
        self.stopped.set()
        [thread.join(70) for thread in self.threads]

    def _weigh(self):
        while not self.stopped.wait(0.05):
            self.peak_mb = max(self.peak_mb, self.service.memory_mb())

    def _ask(self):
        while not self.stopped.wait(0.05):
            begun = time.monotonic()
            try:
                answered = self.visitor.get(self.path).status == 200
            except Exception:  # noqa: BLE001: whatever cuts an honest visitor off counts as an hour
                answered = False
            self.waits.append(time.monotonic() - begun if answered else 3600.0)

    @property
    def grown_mb(self):
        return max(0.0, self.peak_mb - self.begun_mb)

    @property
    def worst_s(self):
        return max(self.waits, default=0.0)

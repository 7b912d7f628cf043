"""Attempts for the service: copies of the recordings in tests/data, each with a trainee and a motion of its own, and their exercises."""

import sys
import time
import tomllib
import urllib.error
import urllib.request
from datetime import datetime, timedelta, timezone
from pathlib import Path

from service import Answer, expect

TESTS = Path(__file__).resolve().parents[1]
sys.path.append(str(TESTS / "attack"))

from tape import Tape  # noqa: E402  in the folder above

SAMPLES = "/needle/sample"
COURSE = 'id = "recorded-{}"\ntitle = "Recorded"\n[mastery]\nrule = "passes"\npasses = 1\nof = 1\n[[exercise]]\nfile = "only.toml"\n'


def read_recordings():
    """Returns the recordings, each of another exercise."""
    return [Tape.read(path.read_bytes()) for path in sorted((TESTS / "data/recordings").glob("*.mcap"))]


def publish_exercise(service, tape):
    """Publishes a course of the exercise as it is in a recording; returns the path of the exercise's page."""
    exercise = tape.session["exercise_id"]
    folder = service.folder / exercise / "course"
    folder.mkdir(parents=True)
    text = tape.document("exercise.toml")
    scene = folder / tomllib.loads(text.decode())["scene"]
    scene.parent.mkdir(exist_ok=True)
    scene.write_bytes(tape.document("scene.toml"))
    (folder / "only.toml").write_bytes(text)
    (folder / "course.toml").write_text(COURSE.format(exercise))
    service.command("curricula", "import", str(folder.parent), "--school", "North")
    return f"/exercises/{exercise}"


def copy_recording(tape, trainee, number):
    """Returns a copy by a trainee that began an hour ago; the motion differs by nanometres, so that it is no duplicate."""
    began = datetime.now(timezone.utc) - timedelta(hours=1)
    copy = tape.another(trainee=trainee, started_at=began.strftime("%Y-%m-%dT%H:%M:%SZ"))
    place = next(place for place, message in enumerate(copy.messages) if message[0] == SAMPLES)
    topic, at, data = copy.messages[place]
    sample = copy.kind(SAMPLES).FromString(data)
    sample.position_m.x += 1e-9 * number
    copy.messages[place] = [topic, at, sample.SerializeToString()]
    return copy


class Station:
    """Uploads recordings for the trainees whom they name."""

    def __init__(self, service):
        self.service = service
        self.token = service.command("user", "token", "--station", "Room 1", "--school", "North").strip()

    def upload(self, tape):
        """Uploads a recording; returns the answer."""
        headers = {"Authorization": f"Bearer {self.token}", "Content-Type": "application/octet-stream"}
        request = urllib.request.Request(f"{self.service.url}/api/v1/sessions", tape.write(), headers)
        try:
            with urllib.request.urlopen(request, timeout=60) as response:
                return Answer(response)
        except urllib.error.HTTPError as refusal:
            with refusal:
                return Answer(refusal)


def wait_until_scored(service, count, seconds):
    """Waits until so many attempts have a grade."""
    for _ in range(seconds * 2):
        graded = int(service.rows("SELECT count(*) FROM grades")[0][0])
        if graded >= count:
            return
        time.sleep(0.5)
    expect(False, f"{graded} of {count} attempts are scored: {service.rows('SELECT state, refusal, count(*) FROM sessions GROUP BY 1, 2')}")

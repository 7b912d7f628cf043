"""What attacks share: a town that most of them leave as it is, towns of their own for the others, and honest recordings."""

import json
import time

from tape import Tape
from town import Town, Watch
from verdict import refuse

# A hand that goes in at 10 mm/s, waits and comes out, in s and m along the planned axis.
HAND = "t_s,x_m\n0,-0.005\n{turn},0.018\n{wait},0.018\n{end},-0.005\n"


class World:
    def __init__(self, template, slack):
        self.template, self.programs, self.slack = template, template.programs, slack
        self._town, self.own, self.made, self.hands = None, [], {}, 0
        self.grown_mb = None

    @property
    def town(self):
        """The town that attacks share."""
        if self._town is None or not self._town.service.is_running:
            self._town = Town(self.template, name="shared")
        return self._town

    def own_town(self, *options, **environment):
        """A town of one's own, gone after the attack."""
        self.own.append(Town(self.template, options, environment, name="own"))
        return self.own[-1]

    def end_attack(self):
        for town in self.own:
            town.close()
        self.own = []

    def close(self):
        self.end_attack()
        if self._town:
            self._town.close()

    def expert(self, exercise=None):
        """A recording that passes, at the easy exercise or another; an expert may fail, too."""
        exercise, out = exercise or self.template.exercise, self.programs.folder / "expert.mcap"
        for _ in range(20):
            self.hands += 1
            self.programs.stylet("simulate", exercise, "--operator", "expert", "--seed", self.hands, "--force", "--out", out)
            if json.loads(self.programs.stylet("score", out, "--json").stdout)["passed"]:
                return Tape.read(out.read_bytes())
        raise RuntimeError("no expert passes")

    def recording(self, exercise=None, **session):
        """A recording that nobody brought before, by a hand of its own that passes nothing; what it says of the session may be
        chosen."""
        self.hands += 1
        folder, turn = self.programs.folder, 1.5 + 0.001 * self.hands
        hand, out = folder / "hand.csv", folder / "hand.mcap"
        hand.write_text(HAND.format(turn=turn, wait=turn + 0.5, end=turn + 2))
        exercise = exercise or self.template.exercise
        self.programs.stylet("simulate", exercise, "--operator", hand, "--seed", 7, "--force", "--out", out)
        tape = Tape.read(out.read_bytes())
        tape.session.update(session)
        return tape

    def upload(self, name, tape, town=None, headers=None):
        return (town or self.town).program(name).upload(tape.write(), headers)

    def scored(self, name="ada", town=None, tape=None):
        """An honest attempt that is scored: its id."""
        town, tape = town or self.town, tape or self.recording()
        answer = self.upload(name, tape, town)
        if answer.status != 201:
            raise RuntimeError(f"an honest upload was answered {answer}")
        town.wait_scored(tape.session_id)
        return tape.session_id

    def watch(self, town, honest=None, path="/account"):
        """Weighs a town's service, and lets somebody ask for a page meanwhile."""
        return Watch(town.service, town.browser(honest) if honest else None, path)

    def hold(self, watched, most_mb=None, most_s=None):
        """Holds what was watched to its limits; what it came to."""
        self.grown_mb = max(self.grown_mb or 0.0, watched.grown_mb)
        said = f"memory +{watched.grown_mb:.0f} MB"
        if most_mb:
            refuse(watched.grown_mb <= most_mb, f"{said}, allowed are {most_mb} MB")
            said += f" (of {most_mb})"
        if watched.waits:
            limit = (most_s or 1.0) * self.slack
            said += f", honest page {watched.worst_s:.2f} s (of {limit:g})"
            refuse(watched.worst_s <= limit, said)
        return said

    def within(self, seconds, work, what):
        """Does work that must not take long; its result and how long it took, in s."""
        begun = time.monotonic()
        result = work()
        took = time.monotonic() - begun
        refuse(took <= seconds * self.slack, f"{what} took {took:.1f} s, allowed are {seconds * self.slack:g} s")
        return result, took

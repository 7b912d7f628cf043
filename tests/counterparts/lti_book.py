"""The gradebook of a learning platform: line items, and the last accepted score of each user in each of them.

It is as strict as Assignment and Grade Services 2.0: lti1p3platform passes scores on unchecked.
"""

import json
import re
import threading
from dataclasses import dataclass
from datetime import datetime
from decimal import Decimal

from lti1p3platform.exceptions import LineItemNotFoundException, LtiServiceException
from lti1p3platform.score import ActivityProgress, GradeProgress, UpdateScoreStatus

ACTIVITY = {known.value for known in ActivityProgress}
GRADING = {known.value for known in GradeProgress}
REQUIRED = {"userId", "timestamp", "activityProgress", "gradingProgress"}
OPTIONAL = {"scoreGiven", "scoreMaximum", "comment", "submission", "scoringUserId"}
ITEM = {"id", "label", "scoreMaximum", "resourceId", "resourceLinkId", "tag"}
ITEM |= {"startDateTime", "endDateTime", "gradesReleased", "submissionReview"}
# RFC 3339 with milliseconds at least.
MOMENT = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3,6}(Z|[+-]\d\d:\d\d)")
MOST_DECIMALS = 6


def demand(condition, why, status=400):
    """Refuses a request unless a condition holds."""
    if not condition:
        raise LtiServiceException(why, status)


def read_object(body):
    """Returns a JSON object with exact numbers. A name twice, NaN or infinity is refused."""

    def read_members(pairs):
        demand(len(dict(pairs)) == len(pairs), f"a name twice: {pairs}")
        return dict(pairs)

    def refuse(word):
        demand(False, f"{word} is not JSON")

    try:
        found = json.loads(body, parse_float=Decimal, parse_int=Decimal, parse_constant=refuse, object_pairs_hook=read_members)
    except ValueError as error:
        raise LtiServiceException(f"not JSON: {error}", 400) from error
    demand(isinstance(found, dict), "not a JSON object")
    return found


def read_moment(text):
    """Returns the time of an RFC 3339 text with milliseconds."""
    demand(isinstance(text, str) and MOMENT.fullmatch(text), f"not a time with milliseconds: {text!r}")
    try:
        return datetime.fromisoformat(text)
    except ValueError as error:
        raise LtiServiceException(f"{text}: {error}", 400) from error


def is_text(value):
    return isinstance(value, str) and value.strip() != ""


def is_number(value):
    return isinstance(value, Decimal)


@dataclass(frozen=True)
class Score:
    """An accepted score; `given` and `maximum` are absent while none is given yet."""

    given: Decimal | None
    maximum: Decimal | None
    at: datetime
    body: dict

    def part(self):
        """Returns the score as a part of its maximum."""
        return None if self.given is None else float(self.given / self.maximum)


def check_points(body):
    """Checks points and maximum, which come together or not at all."""
    given, maximum = body.get("scoreGiven"), body.get("scoreMaximum")
    demand((given is None) == (maximum is None), "scoreGiven and scoreMaximum come together")
    if given is None:
        return
    demand(is_number(given) and is_number(maximum), "scoreGiven and scoreMaximum are numbers")
    demand(maximum > 0, f"scoreMaximum: {maximum}")
    demand(0 <= given <= maximum, f"scoreGiven: {given} of {maximum}")
    demand(given == round(given, MOST_DECIMALS), f"scoreGiven has more than {MOST_DECIMALS} decimals: {given}")


def check_submission(submission, at):
    """Checks when the user began and submitted the attempt."""
    demand(isinstance(submission, dict) and submission.keys() <= {"startedAt", "submittedAt"}, f"submission: {submission}")
    moments = [read_moment(submission[name]) for name in ("startedAt", "submittedAt") if name in submission]
    demand(moments == sorted(moments) and all(moment <= at for moment in moments), f"submission: {submission} at {at}")


def read_score(text, users):
    """Returns the user and the score of a request's body."""
    body = read_object(text)
    demand(REQUIRED <= body.keys(), f"missing: {REQUIRED - body.keys()}")
    unknown = {name for name in body.keys() - REQUIRED - OPTIONAL if not name.startswith("https://")}
    demand(not unknown, f"unknown: {unknown}")
    demand(body["activityProgress"] in ACTIVITY, f"activityProgress: {body['activityProgress']}")
    demand(body["gradingProgress"] in GRADING, f"gradingProgress: {body['gradingProgress']}")
    demand(body["userId"] in users, f"unknown user: {body['userId']}", 404)
    demand(isinstance(body.get("comment", ""), str), "comment is a text")
    check_points(body)
    at = read_moment(body["timestamp"])
    check_submission(body.get("submission", {}), at)
    return body["userId"], Score(body.get("scoreGiven"), body.get("scoreMaximum"), at, body)


def read_item(text):
    """Returns the line item of a request's body."""
    item = read_object(text)
    unknown = {name for name in item.keys() - ITEM if not name.startswith("https://")}
    demand(not unknown, f"unknown: {unknown}")
    demand(is_text(item.get("label")), "label is required")
    demand(is_number(item.get("scoreMaximum")) and item["scoreMaximum"] > 0, "scoreMaximum is a positive number")
    for name in ("resourceId", "resourceLinkId", "tag"):
        demand(isinstance(item.get(name, ""), str), f"{name} is a text")
    return item | {"scoreMaximum": float(item["scoreMaximum"])}


class Book:
    """Line items by number, and scores by number and user. Requests may come at once."""

    def __init__(self, users):
        self.users = users
        self.items = {}
        self.scores = {}
        self.accepted = []
        self.lock = threading.Lock()
        self.last_number = 0

    def add_item(self, item):
        """Adds a line item; returns its number, which is never used again."""
        with self.lock:
            self.last_number += 1
            self.items[self.last_number] = item
            return self.last_number

    def find_item(self, number):
        if number not in self.items:
            raise LineItemNotFoundException(number)
        return self.items[number]

    def remove_item(self, number):
        self.find_item(number)
        with self.lock:
            del self.items[number]

    def record(self, number, text):
        """Keeps a score, unless it is not later than the user's last one; returns its status."""
        self.find_item(number)
        user, score = read_score(text, self.users)
        with self.lock:
            last = self.scores.get((number, user))
            if last and score.at <= last.at:
                return UpdateScoreStatus.OLD_TIMESTAMP
            self.scores[number, user] = score
            self.accepted.append((number, user, score))
        return UpdateScoreStatus.SUCCESS if last else UpdateScoreStatus.CREATED

    def points(self, number, user):
        """Returns a user's points in a line item, out of its maximum; None without a score."""
        score = self.scores.get((number, user))
        part = score and score.part()
        return None if part is None else part * self.items[number]["scoreMaximum"]

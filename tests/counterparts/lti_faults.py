"""Faults of a server, planned in advance for each of the next requests to an endpoint."""

import threading
from collections import defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Fault:
    """A fault in place of an answer. Without a status, the connection is cut.

    `is_handled`: the request is carried out first, and only its answer is lost.
    """

    name: str
    status: int = 0
    headers: dict = field(default_factory=dict)
    is_handled: bool = False
    stall_s: float = 0.0
    act: Callable = lambda: None


SERVER_ERROR = Fault("500", status=500)
UNAVAILABLE = Fault("503", status=503)
# The token that was sent is not valid any more.
UNAUTHORIZED = Fault("401", status=401)
TOO_MANY = Fault("429", status=429, headers={"Retry-After": "1"})
# Longer than a patient client waits.
STALL = Fault("stall", stall_s=15.0)
CUT_BEFORE = Fault("cut before")
CUT_AFTER = Fault("cut after", is_handled=True)
# A stall takes long, so there are few.
ALL = [SERVER_ERROR, UNAVAILABLE, UNAUTHORIZED, TOO_MANY, CUT_BEFORE, CUT_AFTER] * 3 + [STALL]


class Faults:
    """The plan of each endpoint; where it ends, requests are answered."""

    def __init__(self):
        self.plans = defaultdict(deque)
        self.lock = threading.Lock()

    def plan(self, endpoint, *faults):
        """Adds to the plan of an endpoint; None answers a request."""
        with self.lock:
            self.plans[endpoint].extend(faults)

    def take(self, endpoint):
        """Returns the fault of the next request, or None."""
        with self.lock:
            return self.plans[endpoint].popleft() if self.plans[endpoint] else None

    def left(self, endpoint=None):
        """Returns how many requests are still planned, for an endpoint or for all."""
        with self.lock:
            return sum(len(plan) for name, plan in self.plans.items() if endpoint in (None, name))

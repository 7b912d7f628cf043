"""Stylet in Python: the force law, the tissue, virtual attempts, recordings and scores.

Everything is computed by the functions that the commands of `stylet` use, so that every number is the same to the bit:

=========================  ==========================================================
`force(scene, t, x)`       the force law alone, as `stylet force`
`Field(case, tolerance)`   the tissue alone, as `stylet field`
`simulate(exercise, ...)`  a virtual hand performs an exercise, as `stylet simulate`
`read(path)`               a recording as arrays, as `stylet export`
`score(recording)`         metrics, score and what cost points, as `stylet score`
`verify(recording)`        re-simulates a recording and compares, as `stylet verify`
=========================  ==========================================================

Units are SI: m, s, N, J; each name ends with its own. Positive force pushes the needle out of the body, positive displacement goes in.

Input that is refused raises `StyletError`, a `ValueError` that names the place, the value and what is allowed. A file that cannot be read
or written raises an `OSError`. An argument of a wrong kind raises `TypeError`. Python's lock is released while something is computed, so
that threads run beside each other.
"""

from ._arrays import CutRecordingWarning, ToleranceWarning, UnsoundSceneWarning
from ._field import Field
from ._force import Forces, force
from ._native import StyletError
from ._recording import Recording, read, score, verify
from ._simulate import simulate

__all__ = [
    "CutRecordingWarning",
    "Field",
    "Forces",
    "Recording",
    "StyletError",
    "ToleranceWarning",
    "UnsoundSceneWarning",
    "force",
    "read",
    "score",
    "simulate",
    "verify",
]

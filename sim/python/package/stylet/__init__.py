"""Stylet in Python: the force law, the tissue, virtual attempts, recordings and scores.

Every number is computed by the functions that the commands of `stylet` use, and is bit-identical to theirs:

=========================  ==========================================================
`force(scene, t, x)`       the force law, as `stylet force`
`Field(case, tolerance)`   the tissue, as `stylet field`
`simulate(exercise, ...)`  a virtual hand performs an exercise, as `stylet simulate`
`read(path)`               a recording as arrays, as `stylet export`
`score(recording)`         metrics, score and deductions, as `stylet score`
`verify(recording)`        re-simulates a recording and compares, as `stylet verify`
=========================  ==========================================================

Units are SI: m, s, N, J; each name ends with its unit. Positive force pushes the needle out of the body, positive displacement goes in.

Invalid input raises `StyletError`, a `ValueError` that names the place, the value and what is allowed. A file that cannot be read or
written raises an `OSError`. An argument of the wrong type raises a `TypeError`. The global interpreter lock is released during
computations, so that threads run in parallel.
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

"""Attempts by virtual operators."""

from __future__ import annotations

import os
import warnings
from operator import index
from types import SimpleNamespace

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import PathLike, UnsoundSceneWarning, read_numbers
from ._native import StyletError
from ._recording import Recording

#: Numbers of columns of a motion: t and x; t and the position; t, the position and the orientation.
MOTION_COLUMNS = (2, 4, 8)


def simulate(
    exercise: PathLike,
    operator: PathLike | npt.ArrayLike = "expert",
    seed: int = 0,
    *,
    out: PathLike | None = None,
    overwrite: bool = False,
    tick_hz: int = 1000,
    session_id: str | None = None,
    started_at: str | None = None,
    trainee: str = "",
) -> Recording:
    """Let a virtual operator perform an exercise, as `stylet simulate` does, faster than real time.

    Parameters
    ----------
    exercise
        The exercise, a TOML file.
    operator
        Source of the motion: "novice", "intermediate", "expert", "constant:MM_PER_S" (a stiff hand), the path of a CSV file with a motion,
        or the motion itself as an array. Its columns are (t, x) with x along the planned axis; (t, px, py, pz) in the patient frame; or
        (t, px, py, pz, qx, qy, qz, qw) with the orientation patient_from_needle. Times in s increase; positions are in m, -10 to 10.
    seed
        Seed of the patient and the operator's hand, 0 to 2**64 - 1. The same seed gives bit-identical results.
    out
        Also write the recording to this file, which is renamed into place when it is complete.
    overwrite
        Replace `out` if it exists.
    tick_hz
        Servo rate in Hz, 100 to 10000.
    session_id, started_at
        Identifier (a UUID) and start (RFC 3339) of the session. By default new and now. They change nothing else in the file.
    trainee
        Pseudonym, never a real name: up to 64 letters, digits and -_.

    Returns
    -------
    Recording
        The attempt. The file is byte-identical to that of the command for the same session.

    Raises
    ------
    StyletError
        If the exercise, its scene or an argument is invalid.
    OSError
        If a file cannot be read or written; FileExistsError if `out` exists.

    Warns
    -----
    UnsoundSceneWarning
        If a rupture of the scene would create energy.
    """
    if out is not None and not overwrite and os.path.exists(out):
        raise FileExistsError(17, "exists already; overwrite=True replaces it", os.fspath(out))
    name, motion = read_operator(operator)
    seed, tick_hz = index(seed), index(tick_hz)
    if not 0 <= seed < 2**64:
        raise StyletError(f"seed = {seed}; allowed: 0 to 2**64 - 1")
    if not 0 <= tick_hz < 2**64:
        raise StyletError(f"tick_hz = {tick_hz} Hz; allowed: 100 Hz to 10000 Hz")
    wish = SimpleNamespace(
        operator=name, seed=seed, tick_hz=tick_hz, session_id=session_id, started_at=started_at, trainee=trainee
    )
    native = _native.simulate_exercise(exercise, wish, motion)
    for why in native.unsound:
        warnings.warn(f"{os.fspath(exercise)}: unsound scene: {why}", UnsoundSceneWarning, stacklevel=2)
    recording = Recording(native)
    if out is not None:
        recording.save(out, overwrite=overwrite)
    return recording


def read_operator(operator: PathLike | npt.ArrayLike) -> tuple[str | None, list[npt.NDArray[np.float64]]]:
    """Returns the name of an operator, or the columns of a motion."""
    if isinstance(operator, (str, os.PathLike)):
        return os.fspath(operator), []
    rows = read_numbers("motion", operator, 2)
    if rows.shape[1] not in MOTION_COLUMNS:
        raise StyletError(f"motion: shape {rows.shape}; allowed: (n, 2), (n, 4) or (n, 8)")
    return None, [np.ascontiguousarray(column) for column in rows.T]

"""Attempts by virtual hands."""

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

#: Columns of a motion: t and x; t and the position; and the orientation besides.
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
    """Let a virtual hand perform an exercise, as `stylet simulate` does, faster than real time.

    Parameters
    ----------
    exercise
        The exercise, a TOML file.
    operator
        Who moves the needle: "novice", "intermediate", "expert", "constant:MM_PER_S" (a stiff hand), the path of a CSV file with a motion,
        or the motion itself as an array. Its columns are (t, x) with x along the planned axis; (t, px, py, pz) in the patient frame; or
        (t, px, py, pz, qx, qy, qz, qw) with the orientation patient_from_needle. Times in s increase; ways are in m, -10 to 10.
    seed
        Draws the patient and the operator's hand, 0 to 2**64 - 1. The same seed gives the same bits.
    out
        Write the recording to this file, too, which gets its name only when it is whole.
    overwrite
        Replace `out` if it exists.
    tick_hz
        Servo rate in Hz, 100 to 10000.
    session_id, started_at
        Identifier (a UUID) and start (RFC 3339) of the session. By default a new one, now. Nothing else of the file changes with them.
    trainee
        Pseudonym, never a name: up to 64 letters, digits and -_.

    Returns
    -------
    Recording
        The attempt. The file is, to the byte, the command's for the same session.

    Raises
    ------
    StyletError
        When the exercise, its scene or an argument is refused.
    OSError
        When a file cannot be read or written; FileExistsError when `out` exists.

    Warns
    -----
    UnsoundSceneWarning
        When a rupture of the scene would create energy.
    """
    if out is not None and not overwrite and os.path.exists(out):
        raise FileExistsError(17, "exists already; overwrite=True replaces it", os.fspath(out))
    name, motion = read_operator(operator)
    seed, tick_hz = index(seed), index(tick_hz)
    if not 0 <= seed < 2**64:
        raise StyletError(f"seed = {seed}; 0 to 2**64 - 1 is allowed")
    if not 0 <= tick_hz < 2**64:
        raise StyletError(f"tick_hz = {tick_hz} Hz; 100 Hz to 10000 Hz is allowed")
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
    """The name of an operator, or the columns of a motion."""
    if isinstance(operator, (str, os.PathLike)):
        return os.fspath(operator), []
    rows = read_numbers("motion", operator, 2)
    if rows.shape[1] not in MOTION_COLUMNS:
        raise StyletError(f"motion: shape {rows.shape}; (n, 2), (n, 4) or (n, 8) is allowed")
    return None, [np.ascontiguousarray(column) for column in rows.T]

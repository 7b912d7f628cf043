"""Recordings of attempts, and what they are judged as."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import CutRecordingWarning, Floats, PathLike, view_table

#: Position and orientation stand in a row of samples one after the other.
POSE_COLUMNS = 7


class Recording:
    """An attempt, from its recording. `read` and `simulate` make one.

    Tables are structured numpy arrays with one row per message, in order of time, and the columns that `stylet export` writes:
    `recording.samples["depth_m"]` is an array, `pandas.DataFrame(recording.samples)` a data frame. What drives the simulation is float64,
    what it has computed float32. Each table is made when it is first asked for, at once and not row by row.
    """

    def __init__(self, native: _native.NativeRecording) -> None:
        self._native = native

    @cached_property
    def session(self) -> dict[str, Any]:
        """Who, what and with which program: the metadata of the file. `patient_thickness_mm` is the patient that was drawn, in mm."""
        return self._native.session()

    @property
    def complete(self) -> bool:
        """The file is whole, and not cut."""
        return self._native.complete

    @cached_property
    def samples(self) -> npt.NDArray[np.void]:
        """Every servo tick, shape (n,): `t_s`, `position_x_m`…, `orientation_x`…`_w`, `velocity_x_m_per_s`…, `x_m`, `depth_m`,
        `force_x_n`…, `tip_n`, `rim_n`, `viscous_n`, `friction_n`, `cutting_n`, `lateral_x_n`…, `device_x_n`…, `flags`, `lateness_us`,
        `bend_x_m`…"""
        return view_table(*self._native.samples())

    @cached_property
    def poses(self) -> Floats:
        """Where the needle is at every tick, shape (n, 7): position x, y, z in m, and the orientation patient_from_needle as a unit
        quaternion x, y, z, w. A view of `samples`."""
        samples = self.samples
        if not len(samples):
            return np.empty((0, POSE_COLUMNS))
        _, offset = samples.dtype.fields["position_x_m"][:2]  # type: ignore[index]
        strides = (samples.dtype.itemsize, 8)
        return np.ndarray((len(samples), POSE_COLUMNS), np.float64, samples.data, offset, strides)

    @cached_property
    def events(self) -> npt.NDArray[np.void]:
        """What happened, shape (n,): `t_s`, `kind`, `boundary`, `x_m`, `position_x_m`…, `force_n`, `dissipated_j`, `track`, `structure`,
        `text`. `boundary`, `track` and `structure` are -1 where an event has none."""
        columns = {name: np.array(values) for name, values in self._native.events().items()}
        rows = len(columns["t_s"])
        formats = {"kind": "<U1", "text": "<U1", "boundary": "<i8", "track": "<i8", "structure": "<i8"}
        kinds = [
            (name, values.dtype if rows and values.dtype.kind == "U" else formats.get(name, "<f8"))
            for name, values in columns.items()
        ]
        events = np.empty(rows, dtype=kinds)
        for name, values in columns.items():
            events[name] = values
        return events

    @cached_property
    def tents(self) -> npt.NDArray[np.void]:
        """How the tissue stands, 120 times a second, shape (n,): `t_s`, `tent_0_m`… (boundaries, into the body), `contactor_0_n`…,
        `drag_0_n`…, `follows_needle`. Without rows where the scene has no tissue."""
        return view_table(*self._native.tents())

    @cached_property
    def energy(self) -> npt.NDArray[np.void]:
        """The energy ledger, ten times a second, at each rupture and at the end, shape (n,): `t_s`, `input_j`, `returned_j`, `presliding_j`,
        `layers_0_elastic_j`…, `lagged_j`, all since the start, in J."""
        return view_table(*self._native.energies())

    @property
    def attachments(self) -> dict[str, bytes]:
        """Exercise, scene and meshes, byte for byte, by their names."""
        return self._native.attachments()

    def score(self, exercise: PathLike | None = None) -> dict[str, Any]:
        """Judge the attempt, as `stylet.score` does."""
        judged: dict[str, Any] = json.loads(self._native.score(exercise))
        return judged

    def verify(self) -> dict[str, Any]:
        """Simulate the recorded input anew and compare, as `stylet.verify` does."""
        verification: dict[str, Any] = json.loads(self._native.verify())
        return verification

    def save(self, path: PathLike, *, overwrite: bool = False) -> None:
        """Write a simulated recording to a file, which gets its name only when it is whole.

        Raises
        ------
        FileExistsError
            When there is a file and `overwrite` is false.
        ValueError
            When the recording was read: it is a file already.
        """
        content = self._native.content()
        if content is None:
            raise ValueError(f"{self._native.name}: was read from a file; only a simulated recording is saved")
        write_whole(os.fspath(path), content, overwrite)

    def __len__(self) -> int:
        return len(self.samples)

    def __repr__(self) -> str:
        samples, session = self.samples, self.session
        lasted = samples["t_s"][-1] - samples["t_s"][0] if len(samples) else 0.0
        return f"<stylet.Recording: {session['exercise_id']} by {session['device']}, {len(samples)} samples, {lasted:.2f} s>"


def write_whole(path: str, content: bytes, overwrite: bool) -> None:
    """Writes beside a path, then gives the file its name."""
    folder, name = os.path.split(path)
    handle, temporary = tempfile.mkstemp(dir=folder or ".", prefix=f".{name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        if overwrite:
            os.replace(temporary, path)
        else:
            os.link(temporary, path)
            os.unlink(temporary)
    except BaseException:
        os.unlink(temporary)
        raise


def read(path: PathLike) -> Recording:
    """Read a recording.

    Parameters
    ----------
    path
        An MCAP file of Stylet, whole or cut.

    Returns
    -------
    Recording
        Samples, events, tents, poses and energy as arrays.

    Raises
    ------
    StyletError
        When it is no recording, damaged, or larger than an hour and a half at 1 kHz.
    OSError
        When it cannot be read.

    Warns
    -----
    CutRecordingWarning
        When it ends too soon; what it holds is used.
    """
    native = _native.read_recording(path)
    if not native.complete:
        warnings.warn(f"{native.name}: the recording is cut; what it holds is used", CutRecordingWarning, stacklevel=2)
    return Recording(native)


def score(recording: PathLike | Recording, exercise: PathLike | None = None) -> dict[str, Any]:
    """Judge a recorded attempt: metrics, score and what cost points.

    Parameters
    ----------
    recording
        A recording, or its path.
    exercise
        Judge by this exercise (a TOML file) instead of the one that the recording carries.

    Returns
    -------
    dict
        What `stylet score --json` prints: `score` (0 to 100), `passed`, `metrics` (a list with `id`, `version`, `value`, `unit`,
        `direction`, `applies`), `deductions`, `hard_fails`, `rubric`. Of an attempt that counts nowhere, because the device was lost or the
        hand was not given its force, `score` is None and `void` says why.

    Raises
    ------
    StyletError
        When the recording cannot be judged.
    OSError
        When a file cannot be read.
    """
    attempt = recording if isinstance(recording, Recording) else read(recording)
    return attempt.score(exercise)


def verify(recording: PathLike | Recording) -> dict[str, Any]:
    """Simulate a recording's input anew and compare every force and tent.

    Returns
    -------
    dict
        What `stylet verify --json` prints. `largest_deviation_n`, `largest_depth_deviation_m`, `largest_tent_deviation_m`,
        `event_differences`, `tent_differences`, `ledger_differences` and `inside_differences` are all 0 where the recording is, to the
        bit, what its input makes of its scene.

    Raises
    ------
    StyletError
        When the recording does not carry what it takes.
    OSError
        When it cannot be read.
    """
    attempt = recording if isinstance(recording, Recording) else read(recording)
    return attempt.verify()

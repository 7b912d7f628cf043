"""Recordings of attempts and their scores."""

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

#: Position and orientation are adjacent in a row of samples.
POSE_COLUMNS = 7


class Recording:
    """An attempt, from its recording, as returned by `read` and `simulate`.

    Tables are structured numpy arrays with one row per message, in order of time, and the columns that `stylet export` writes:
    `recording.samples["depth_m"]` is an array, `pandas.DataFrame(recording.samples)` a data frame. Inputs of the simulation
    are float64, computed values float32. Each table is created as a whole when it is first used.
    """

    def __init__(self, native: _native.NativeRecording) -> None:
        self._native = native

    @cached_property
    def session(self) -> dict[str, Any]:
        """Metadata of the file: trainee, exercise, device, program. `patient_thickness_mm` are the layers of the drawn patient."""
        return self._native.session()

    @property
    def complete(self) -> bool:
        """Whether the file is complete, not truncated."""
        return self._native.complete

    @cached_property
    def samples(self) -> npt.NDArray[np.void]:
        """Every servo tick, shape (n,): `t_s`, `position_x_m`…, `orientation_x`…`_w`, `velocity_x_m_per_s`…, `x_m`, `depth_m`,
        `force_x_n`…, `tip_n`, `rim_n`, `viscous_n`, `friction_n`, `cutting_n`, `lateral_x_n`…, `device_x_n`…, `flags`, `lateness_us`,
        `bend_x_m`…"""
        return view_table(*self._native.samples())

    @cached_property
    def poses(self) -> Floats:
        """Pose of the needle at every tick, shape (n, 7): position x, y, z in m, and the orientation patient_from_needle as a unit
        quaternion x, y, z, w. A view of `samples`."""
        samples = self.samples
        if not len(samples):
            return np.empty((0, POSE_COLUMNS))
        _, offset = samples.dtype.fields["position_x_m"][:2]  # type: ignore[index]
        strides = (samples.dtype.itemsize, 8)
        return np.ndarray((len(samples), POSE_COLUMNS), np.float64, samples.data, offset, strides)

    @cached_property
    def events(self) -> npt.NDArray[np.void]:
        """Events, shape (n,): `t_s`, `kind`, `boundary`, `x_m`, `position_x_m`…, `force_n`, `dissipated_j`, `track`, `structure`,
        `text`. `boundary`, `track` and `structure` are -1 if an event has none."""
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
        """Deformation of the tissue, 120 times per second, shape (n,): `t_s`, `tent_0_m`… (boundaries, into the body), `contactor_0_n`…,
        `drag_0_n`…, `follows_needle`, `linear_0_n`…, `follows_secant`. Empty if the scene has no tissue model."""
        return view_table(*self._native.tents())

    @cached_property
    def energy(self) -> npt.NDArray[np.void]:
        """The energy ledger, ten times per second, at each rupture and at the end, shape (n,): `t_s`, `input_j`, `returned_j`, `presliding_j`,
        `layers_0_elastic_j`…, `lagged_j`, all since the start, in J."""
        return view_table(*self._native.energies())

    @property
    def attachments(self) -> dict[str, bytes]:
        """Exercise, scene and meshes, byte for byte, by name."""
        return self._native.attachments()

    def score(self, exercise: PathLike | None = None) -> dict[str, Any]:
        """Score the attempt, as `stylet.score` does."""
        judged: dict[str, Any] = json.loads(self._native.score(exercise))
        return judged

    def verify(self) -> dict[str, Any]:
        """Re-simulate the recorded input and compare, as `stylet.verify` does."""
        verification: dict[str, Any] = json.loads(self._native.verify())
        return verification

    def save(self, path: PathLike, *, overwrite: bool = False) -> None:
        """Write a simulated recording to a file, which is renamed into place when it is complete.

        Raises
        ------
        FileExistsError
            If the file exists and `overwrite` is false.
        ValueError
            If the recording was read from a file.
        """
        content = self._native.content()
        if content is None:
            raise ValueError(f"{self._native.name}: was read from a file; only a simulated recording can be saved")
        write_whole(os.fspath(path), content, overwrite)

    def __len__(self) -> int:
        return len(self.samples)

    def __repr__(self) -> str:
        samples, session = self.samples, self.session
        lasted = samples["t_s"][-1] - samples["t_s"][0] if len(samples) else 0.0
        return f"<stylet.Recording: {session['exercise_id']} by {session['device']}, {len(samples)} samples, {lasted:.2f} s>"


def write_whole(path: str, content: bytes, overwrite: bool) -> None:
    """Writes to a temporary file in the same folder, then renames it."""
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
        An MCAP file of Stylet, complete or truncated.

    Returns
    -------
    Recording
        Samples, events, tents, poses and energy as arrays.

    Raises
    ------
    StyletError
        If it is not a recording, is damaged, or is longer than an hour and a half at 1 kHz.
    OSError
        If it cannot be read.

    Warns
    -----
    CutRecordingWarning
        If it is truncated; its complete part is used.
    """
    native = _native.read_recording(path)
    if not native.complete:
        warnings.warn(f"{native.name}: the recording is truncated; its complete part is used", CutRecordingWarning, stacklevel=2)
    return Recording(native)


def score(recording: PathLike | Recording, exercise: PathLike | None = None) -> dict[str, Any]:
    """Score a recorded attempt: metrics, score and deductions.

    Parameters
    ----------
    recording
        A recording, or its path.
    exercise
        Score with this exercise (a TOML file) instead of the recorded one.

    Returns
    -------
    dict
        What `stylet score --json` prints: `score` (0 to 100), `passed`, `metrics` (a list with `id`, `version`, `value`, `unit`,
        `direction`, `applies`), `deductions`, `hard_fails`, `rubric`. If the attempt is void because the device was lost or the force
        did not reach the hand, `score` is None and `void` contains the reason.

    Raises
    ------
    StyletError
        If the recording cannot be scored.
    OSError
        If a file cannot be read.
    """
    attempt = recording if isinstance(recording, Recording) else read(recording)
    return attempt.score(exercise)


def verify(recording: PathLike | Recording) -> dict[str, Any]:
    """Re-simulate a recording's input and compare every force and tent.

    Returns
    -------
    dict
        What `stylet verify --json` prints. `largest_deviation_n`, `largest_depth_deviation_m`, `largest_tent_deviation_m`,
        `event_differences`, `tent_differences`, `ledger_differences` and `inside_differences` are all 0 if the re-simulation is
        bit-identical to the recording.

    Raises
    ------
    StyletError
        If the recording lacks its exercise or scene.
    OSError
        If it cannot be read.
    """
    attempt = recording if isinstance(recording, Recording) else read(recording)
    return attempt.verify()

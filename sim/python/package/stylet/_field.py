"""The tissue without the force law."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _native
from ._arrays import Floats, PathLike, ToleranceWarning, read_document


class Field:
    """Deformation of layered tissue under a needle, as computed by `stylet field`.

    The planner chooses the cheapest model and mesh that meet the tolerance. The constructor computes the result.

    Parameters
    ----------
    case
        Layers, a load at some depths and sample points in SI: the path of a JSON file, its text, or a mapping.
    tolerance
        Tolerated relative error over all samples, of the axial and of the radial displacement, 1e-6 to 1.
    model
        "auto" lets the planner choose; "axisymmetric", "mass-spring" and "volumetric" select one.

    Raises
    ------
    StyletError
        If the case, the tolerance or the model is invalid.
    OSError
        If the case cannot be read.

    Warns
    -----
    ToleranceWarning
        If even the best available model does not meet the tolerance; then `met` is false.

    Notes
    -----
    The tissue is linear: for another force, multiply the displacements by it and divide them by `force_n`. For other points, create
    another field with other `sample_r_m` and `sample_depth_m`: the error is estimated over the points of the case.
    """

    model: str
    """The model that was used."""
    reason: str
    """Why it was chosen."""
    unknowns: int
    """Number of unknowns of the largest load's model."""
    bytes: int
    """Size of all loads' models, in bytes."""
    estimated_relative_error: float
    """Estimated error of the worst load: of the axial or the radial displacement, whichever is larger."""
    tolerance: float
    """The requested tolerance."""
    met: bool
    """Whether the estimate meets the tolerance."""
    force_n: float
    """The load, in N; positive pushes into the body."""
    load_depths_m: Floats
    """Depths of the load, in m, shape (loads,)."""
    sample_depth_m: Floats
    """Depths of the samples, in m, shape (depths,)."""
    sample_r_m: Floats
    """Radii of the samples, in m, shape (radii,)."""
    u_axial_m: Floats
    """Displacement along +z, out of the body, in m, shape (loads, depths, radii): a push is negative."""
    u_radial_m: Floats
    """Displacement outward, in m, shape (loads, depths, radii)."""

    def __init__(self, case: PathLike | Mapping[str, Any], tolerance: float = 0.01, *, model: str = "auto") -> None:
        name, text = read_document(case)
        answer = _native.answer_field(name, text, model, tolerance)
        self.model, self.reason = answer["model"], answer["reason"]
        self.unknowns, self.bytes = answer["unknowns"], answer["bytes"]
        self.estimated_relative_error = answer["estimated_relative_error"]
        self.tolerance, self.met, self.force_n = float(tolerance), answer["met"], answer["force_n"]
        self.load_depths_m = np.array(answer["load_depths_m"], dtype=np.float64)
        self.sample_depth_m = np.array(answer["sample_depth_m"], dtype=np.float64)
        self.sample_r_m = np.array(answer["sample_r_m"], dtype=np.float64)
        shape = (len(self.load_depths_m), len(self.sample_depth_m), len(self.sample_r_m))
        self.u_axial_m = np.frombuffer(answer["u_axial_m"], dtype=np.float64).reshape(shape)
        self.u_radial_m = np.frombuffer(answer["u_radial_m"], dtype=np.float64).reshape(shape)
        if answer["warning"] is not None:
            warnings.warn(f"{name}: {answer['warning']}", ToleranceWarning, stacklevel=2)

    def __repr__(self) -> str:
        loads, depths, radii = self.u_axial_m.shape
        return (
            f"<stylet.Field: {self.model}, {loads} loads, {depths} × {radii} samples, "
            f"estimated error {self.estimated_relative_error:.1e}>"
        )

"""The force law without the tissue."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import Floats, PathLike, UnsoundSceneWarning, read_document, read_numbers

#: Columns of `Forces.ruptures`.
RUPTURE_DTYPE = np.dtype([("row", "<i8"), ("t_s", "<f8"), ("x_m", "<f8"), ("contactor", "<U3"), ("boundary", "<i8")])


@dataclass(frozen=True, eq=False)
class Forces:
    """Results of the force law on a trajectory of n samples. Every array except `ruptures` has the shape (n,).

    Positive force pushes the needle out of the body. `force_n` is the sum of its five parts.
    """

    t_s: Floats
    """Time, in s, as given."""
    x_m: Floats
    """Displacement of the tip, in m, as given; positive into the body."""
    v_m_per_s: Floats
    """Speed used by the law, in m/s: the backward difference of x over the scene's window."""
    force_n: Floats
    """Total force, in N."""
    tip_n: Floats
    """Elastic force of the boundary that the tip tents, in N."""
    rim_n: Floats
    """Elastic force of the boundary that the cannula's rim tents, in N."""
    viscous_n: Floats
    """Viscous force, in N."""
    friction_n: Floats
    """Friction along the shaft, in N."""
    cutting_n: Floats
    """Cutting force at the tip, in N."""
    depth_m: Floats
    """Material depth of the tip, in m, 0 or more."""
    ruptures: npt.NDArray[np.void]
    """Ruptured boundaries, in order: a structured array with `row` (of the trajectory), `t_s`, `x_m`, `contactor` ("tip" or "rim")
    and `boundary` (from 0 at the surface)."""


def force(scene: PathLike | Mapping[str, Any], t: npt.ArrayLike, x: npt.ArrayLike) -> Forces:
    """Compute the force of a needle along a given trajectory, as `stylet force` does.

    Parameters
    ----------
    scene
        Layers and needle at their effective values in SI: the path of a JSON file, its text, or a mapping.
    t
        Times in s, shape (n,), n at least 1: finite and increasing.
    x
        Displacement of the tip along the needle in m, shape (n,): from -10 m to 10 m, negative above the skin.

    Returns
    -------
    Forces
        Arrays of the shape (n,), in m, m/s and N, bit-identical to the command's table.

    Raises
    ------
    StyletError
        If the scene or a number is invalid; the message names it and what is allowed.
    OSError
        If the scene cannot be read.
    TypeError
        If an array does not contain real numbers.

    Warns
    -----
    UnsoundSceneWarning
        If a rupture of the scene would create energy. The result is computed anyway.
    """
    name, text = read_document(scene)
    t_s, x_m = read_numbers("t", t, 1), read_numbers("x", x, 1)
    content, opened, unsound = _native.compute_force(name, text, t_s, x_m)
    for why in unsound:
        warnings.warn(f"{name}: unsound scene: {why}", UnsoundSceneWarning, stacklevel=2)
    v_m_per_s, force_n, tip_n, rim_n, viscous_n, friction_n, cutting_n, depth_m = np.frombuffer(
        content, dtype=np.float64
    ).reshape(8, len(t_s))
    ruptures = np.array(
        [(row, t_s[row], x_m[row], contactor, boundary) for row, contactor, boundary in opened], dtype=RUPTURE_DTYPE
    )
    return Forces(
        t_s, x_m, v_m_per_s, force_n, tip_n, rim_n, viscous_n, friction_n, cutting_n, depth_m, ruptures
    )

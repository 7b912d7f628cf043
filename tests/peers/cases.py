"""The reference cases of tests/data/field, the error as `stylet bench field` has it, and how a time is taken."""

import dataclasses
import json
import math
import pathlib
import time

import numpy as np

DATA = pathlib.Path(__file__).resolve().parents[1] / "data" / "field"
NAMES = ["homogeneous", "lower_back", "stiff_skin_soft_fat"]


@dataclasses.dataclass(frozen=True)
class Layer:
    """Between two depths, in m; modulus in Pa."""

    top_m: float
    bottom_m: float
    youngs_modulus_pa: float
    poisson_ratio: float

    def lame(self):
        """Lamé's λ and μ, in Pa."""
        young, poisson = self.youngs_modulus_pa, self.poisson_ratio
        return young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))


class Slab:
    """A block of layers, a load at one depth, and where the answer is wanted."""

    def __init__(self, name, told, load_depth_m):
        self.name, self.load_depth_m = name, load_depth_m
        self.radius_m, self.load_radius_m, self.force_n = told["radius_m"], told["load_radius_m"], told["force_n"]
        self.layers, top = [], 0.0
        for layer in told["layers"]:
            bottom = top + layer["thickness_m"]
            self.layers.append(Layer(top, bottom, layer["youngs_modulus_pa"], layer["poisson_ratio"]))
            top = bottom
        self.depth_m = top
        self.sample_r_m = np.array(told["sample_r_m"])
        self.sample_depth_m = np.array(told["sample_depth_m"])

    def traction_pa(self, r_m):
        """The axial traction at a distance from the axis, pushing in."""
        a = self.load_radius_m
        return self.force_n / (np.pi * a * a) * np.exp(-((r_m / a) ** 2))

    def samples(self):
        """Every sample, depth after depth: r and depth in m."""
        depth, r = np.meshgrid(self.sample_depth_m, self.sample_r_m, indexing="ij")
        return r.ravel(), depth.ravel()


class Case(Slab):
    """A reference case with its load on the surface."""

    def __init__(self, name):
        told = json.loads((DATA / f"{name}.json").read_text())
        super().__init__(name, told, 0.0)
        surface = next(solution for solution in told["solutions"] if solution["depth_m"] == 0.0)
        self.reference_m = np.array(surface["u_axial_m"])

    def error(self, inward_m):
        """Relative L2 error of the displacement into the body over all samples, in the order of `samples`."""
        reference = -self.reference_m.ravel()
        return float(np.linalg.norm(np.asarray(inward_m).ravel() - reference) / np.linalg.norm(reference))


def graded(stops_m, first_m, growth):
    """Coordinates through every stop; a step at x is about `first_m` + `growth` x long. What pushes stands at 0."""
    measure = lambda x: math.log1p(growth * x / first_m) / growth
    points = [stops_m[0]]
    for start, end in zip(stops_m, stops_m[1:]):
        low, high = measure(start), measure(end)
        count = max(1, round(high - low))
        parts = np.linspace(low, high, count + 1)[1:-1]
        points.extend(np.expm1(growth * parts) * first_m / growth)
        points.append(end)
    return np.array(points)


def grid(case, fineness):
    """Coordinates r and depth, graded to the load and through every layer; the steps at the load are a / `fineness`, its depth a line."""
    first, growth = case.load_radius_m / fineness, 0.6 / fineness
    load, near = case.load_depth_m, 1e-9
    below = [layer.bottom_m - load for layer in case.layers if layer.bottom_m > load + near]
    above = [load - layer.top_m for layer in reversed(case.layers) if layer.top_m < load - near]
    depth = load + graded([0.0, *below], first, growth)
    if above:
        depth = np.concatenate([load - graded([0.0, *above], first, growth)[:0:-1], depth])
    return graded([0.0, case.radius_m], first, growth), depth


@dataclasses.dataclass(frozen=True)
class Answer:
    """What a solver made of a case; times in s."""

    case: str
    unknowns: int
    error: float
    setup_s: float
    solve_s: float


def once_s(work):
    """What `work` returns, and how long it took."""
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def median_s(work):
    """The median time of a call: until a twentieth of a second is spent, once at least."""
    times, start = [], time.perf_counter()
    while not times or (len(times) < 2001 and time.perf_counter() - start < 0.05):
        times.append(once_s(work)[1])
    return sorted(times)[len(times) // 2]

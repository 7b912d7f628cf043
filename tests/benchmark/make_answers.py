"""Makes the answers of the cases that have no reference from elsewhere, without Stylet: `python make_answers.py [OUT]`.

Force cases: the law of README.md, written anew from its equations. Field cases: layers without end sideways, solved in
Hankel space (four constants a layer for each wave number) and brought back by Gauss quadrature; no mesh, no elements.
Needs numpy and scipy.
"""

import csv
import json
import math
import pathlib
import sys

import numpy as np
from scipy.special import ive, j0, j1

HERE = pathlib.Path(__file__).resolve().parent


# The force law.


class Needle:
    """A needle on its way, sample after sample."""

    def __init__(self, case):
        factor = 1.0 / math.cos(case.get("angle_rad", 0.0))
        self.layers, self.tops, depth = case["layers"], [], 0.0
        for layer in self.layers:
            self.tops.append(depth)
            depth += layer["thickness_m"] * factor
        self.ends = self.tops[1:] + [depth]
        self.rim_behind = case["tip_to_rim_m"]
        self.spring = case["presliding_stiffness_n_per_m"]
        self.window, self.rate = case.get("speed_window_s", 0.0), case.get("rate")
        self.open = {"tip": 0, "rim": 0}
        self.front, self.friction, self.past = None, 0.0, []

    def speed(self, t, x):
        """Over the window; over the last two samples where there is none."""
        if not self.past:
            return 0.0
        if self.window == 0.0:
            old_t, old_x = self.past[-1]
        else:
            old_t, old_x = next((one for one in reversed(self.past) if t - one[0] >= self.window), self.past[0])
        return (x - old_x) / (t - old_t)

    def dent(self, contactor, x):
        """Of the next boundary of a contactor: its number, the force on it, or none."""
        at = self.open[contactor]
        limit = len(self.layers) if contactor == "tip" else self.open["tip"]
        if at >= limit or (contactor == "rim" and self.rim_behind == 0.0):
            return None
        behind = self.rim_behind if contactor == "rim" else 0.0
        deep = x - behind - self.tops[at]
        return (at, self.layers[at]["stiffness_n_per_m"] * deep) if deep > 0.0 else None

    def threshold(self, contactor, at, v):
        still = self.layers[at][f"{contactor}_rupture_n"]
        if self.rate is None:
            return still
        fast = self.rate["p_infinity_n"]
        return fast + (still - fast) / (1.0 + abs(v) / self.rate["v0_m_per_s"])

    def rupture(self, x, v):
        """Opens what gives way: tips, then rims."""
        events = []
        for contactor in ("tip", "rim"):
            while (dent := self.dent(contactor, x)) and dent[1] >= self.threshold(contactor, dent[0], v):
                events.append(f"{contactor}:{dent[0]}")
                self.open[contactor] += 1
        return events

    def cut(self, x, depth):
        """The force of the cutting front."""
        if self.open["tip"] == 0:
            return 0.0
        if self.front is None:
            self.front = x
        here = [j for j, (top, end) in enumerate(zip(self.tops, self.ends)) if top < depth <= end]
        cap = self.layers[here[0]]["cutting_n"] if here else 0.0
        force = min(max(self.spring * (x - self.front), 0.0), cap)
        if here and x - cap / self.spring > self.front:
            self.front = x - cap / self.spring
        return force

    def step(self, t, x):
        """The force and what opened."""
        v = self.speed(t, x)
        events = self.rupture(x, v)
        way = x - self.past[-1][1] if self.past else 0.0
        self.past.append((t, x))
        tip = self.open["tip"]
        depth = max(min(x, self.tops[tip]) if tip < len(self.layers) else x, 0.0)
        inside = [min(max(depth - top, 0.0), end - top) for top, end in zip(self.tops, self.ends)]
        elastic = sum(dent[1] for dent in (self.dent("tip", x), self.dent("rim", x)) if dent)
        viscous = v * sum(layer["damping_n_s_per_m2"] * length for layer, length in zip(self.layers, inside))
        cap = sum(layer["friction_n_per_m"] * length for layer, length in zip(self.layers, inside))
        self.friction = min(max(self.friction + self.spring * way, -cap), cap)
        return elastic + viscous + self.friction + self.cut(x, depth), "+".join(events)


def force_rows(folder):
    case = json.loads((folder / "case.json").read_text())
    needle = Needle(case)
    with open(folder / "motion.csv", newline="") as file:
        for row in csv.DictReader(file):
            force, events = needle.step(float(row["t_s"]), float(row["x_m"]))
            yield row["t_s"], f"{force:.12g}", events


# The field.


def wave_numbers(a):
    """Gauss points and weights over every wave number that a Gaussian of radius a has, dense near 0."""
    last = 13.0 / a
    edges = np.unique(np.concatenate([[0.0], np.geomspace(1e-4, 20.0, 60), np.linspace(20.0, last, 500)]))
    x, w = np.polynomial.legendre.leggauss(12)
    half = np.diff(edges) / 2
    return (edges[:-1, None] + half[:, None] * (x + 1)).ravel(), (half[:, None] * w).ravel()


def columns(layer, xi, from_top):
    """What the four solutions of a layer are at a distance from its top: U, W (displacements), T, S (shear, normal).

    With s = ±1 and ζ = ξ times the distance from the side where a solution is 1: (U, W) = (−s, 1) e^{sζ} and
    (s (3 − 4ν) + ζ, −s ζ) e^{sζ}. None grows away from its side, however thick the layer is.
    """
    young, nu, thick = layer["youngs_modulus_pa"], layer["poisson_ratio"], layer["thickness_m"]
    mu = young / (2 * (1 + nu))
    lam = 2 * mu * nu / (1 - 2 * nu)
    found = np.zeros((len(xi), 4, 4))
    for place, (s, distance) in enumerate([(-1, from_top), (1, from_top - thick)]):
        zeta = xi * distance
        e = np.exp(s * zeta)
        first = -s * e, e, -e, s * e
        second = (s * (3 - 4 * nu) + zeta) * e, -s * zeta * e, (1 + s * (s * (3 - 4 * nu) + zeta)) * e, (-s - zeta) * e
        for order, (u, w, du, dw) in enumerate((first, second)):
            found[:, :, 2 * place + order] = np.stack(
                [u, w, mu * xi * (du - w), xi * (lam * (xi * 0 + u + dw) + 2 * mu * dw)], axis=1
            )
    return found


def solve_stack(layers, xi, load_depth, pressure):
    """The four constants of every layer, at every wave number. Tops free, base clamped, bonded between."""
    count = len(layers)
    matrix, right = np.zeros((len(xi), 4 * count, 4 * count)), np.zeros((len(xi), 4 * count))
    scale = 1.0 / (layers[0]["youngs_modulus_pa"] * np.maximum(xi, 1e-12))[:, None, None]
    top = columns(layers[0], xi, 0.0)
    matrix[:, :2, :4] = top[:, 2:] * scale
    depth = 0.0
    if load_depth == 0.0:
        right[:, 1] = -pressure * scale[:, 0, 0]
    for at in range(count - 1):
        depth += layers[at]["thickness_m"]
        rows = slice(2 + 4 * at, 6 + 4 * at)
        above, below = columns(layers[at], xi, layers[at]["thickness_m"]), columns(layers[at + 1], xi, 0.0)
        above[:, 2:] *= scale
        below[:, 2:] *= scale
        matrix[:, rows, 4 * at : 4 * at + 4] = -above
        matrix[:, rows, 4 * at + 4 : 4 * at + 8] = below
        if abs(depth - load_depth) < 1e-12:
            right[:, 5 + 4 * at] = -pressure * scale[:, 0, 0]
    matrix[:, -2:, -4:] = columns(layers[-1], xi, layers[-1]["thickness_m"])[:, :2]
    return np.linalg.solve(matrix, right[:, :, None])[:, :, 0].reshape(len(xi), count, 4)


def half_space(layer, xi, depth, pressure):
    """U and W of a half-space under a pressure on its surface."""
    young, nu, zeta = layer["youngs_modulus_pa"], layer["poisson_ratio"], xi * depth
    common = (1 + nu) / young * pressure / xi * np.exp(-zeta)
    return -(1 - 2 * nu - zeta) * common, (2 * (1 - nu) + zeta) * common


def field_rows(folder):
    case = json.loads((folder / "case.json").read_text())
    layers, a = case["layers"], case["load_radius_m"]
    endless = folder.name == "half_space"
    xi, weight = wave_numbers(a)
    pressure = case["force_n"] / (2 * math.pi) * np.exp(-((xi * a) ** 2) / 4)
    tops = np.concatenate([[0.0], np.cumsum([layer["thickness_m"] for layer in layers])])
    for load_depth in case["load_depths_m"]:
        constants = None if endless else solve_stack(layers, xi, load_depth, pressure)
        for depth in case["sample_depth_m"]:
            at = min(int(np.searchsorted(tops, depth + 1e-12, side="right")) - 1, len(layers) - 1)
            if endless:
                u, w = half_space(layers[0], xi, depth, pressure)
            else:
                parts = columns(layers[at], xi, depth - tops[at])
                u, w = (np.einsum("ij,ij->i", parts[:, of], constants[:, at]) for of in (0, 1))
            for r in case["sample_r_m"]:
                inward, outward = (np.sum(weight * xi * part * bessel(xi * r)) for part, bessel in ((w, j0), (u, j1)))
                yield repr(load_depth), repr(depth), repr(r), f"{-inward:.9g}", f"{outward:.9g}"


def check_half_space():
    """The quadrature against the closed form of the surface, (1 − ν²) F/(E a √π) e^{−q} I₀(q), q = r²/2a²."""
    folder = HERE / "cases" / "half_space"
    case = json.loads((folder / "case.json").read_text())
    layer, a = case["layers"][0], case["load_radius_m"]
    size = (1 - layer["poisson_ratio"] ** 2) * case["force_n"] / (layer["youngs_modulus_pa"] * a * math.sqrt(math.pi))
    for load, depth, r, axial, _ in field_rows(folder):
        if float(depth) == 0.0:
            closed = -size * ive(0, float(r) ** 2 / (2 * a * a))
            assert abs(float(axial) - closed) < 1e-7 * size, (r, axial, closed)


def main():
    out = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "answers"
    out.mkdir(parents=True, exist_ok=True)
    check_half_space()
    for case in json.loads((HERE / "cases.json").read_text())["cases"]:
        if not case["made_here"]:
            continue
        make, header = {
            "force": (force_rows, "t_s,F_n,events"),
            "field": (field_rows, "load_depth_m,depth_m,r_m,u_axial_m,u_radial_m"),
        }[case["kind"]]
        rows = [",".join(row) for row in make(HERE / "cases" / case["name"])]
        (out / f"{case['name']}.csv").write_text("\n".join([header, *rows]) + "\n")


if __name__ == "__main__":
    main()

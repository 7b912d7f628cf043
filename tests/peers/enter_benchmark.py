"""scikit-fem's entry for the benchmark's field cases: `python enter_benchmark.py RESULTS [FINENESS]`, then score.py RESULTS.

Axisymmetric Q2 with one grid for every case, 4 steps to the load's radius unless told. A time is that of the whole case,
from reading to writing, in a process that has started.
"""

import json
import pathlib
import sys

import numpy as np
import skfem

import by_scikit_fem
import cases

BENCHMARK = pathlib.Path(__file__).resolve().parents[1] / "benchmark"


def answer(folder, out, fineness):
    """Writes the answer of a case."""
    told = json.loads((folder / "case.json").read_text())
    rows = []
    for load_depth_m in told["load_depths_m"]:
        slab = cases.Slab(folder.name, told, load_depth_m)
        basis, free, factor, load = by_scikit_fem.prepare(slab, skfem.ElementQuad2, fineness)
        moved = np.zeros(basis.N)
        moved[free] = factor.solve(load)
        r, depth = slab.samples()
        outward_m, inward_m = (basis.probes(np.array([r, depth])) @ moved).reshape(2, -1)
        rows += [map(repr, map(float, row)) for row in zip(np.full(len(r), load_depth_m), depth, r, -inward_m, outward_m)]
    lines = ["load_depth_m,depth_m,r_m,u_axial_m,u_radial_m", *map(",".join, rows)]
    (out / f"{folder.name}.csv").write_text("\n".join(lines) + "\n")


def main():
    out, fineness = pathlib.Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 4
    out.mkdir(parents=True, exist_ok=True)
    times = ["case,seconds"]
    for folder in sorted((BENCHMARK / "cases").iterdir()):
        if not (folder / "motion.csv").exists():
            _, seconds = cases.once_s(lambda: answer(folder, out, fineness))
            times.append(f"{folder.name},{seconds:.3f}")
    (out / "times.csv").write_text("\n".join(times) + "\n")


if __name__ == "__main__":
    main()

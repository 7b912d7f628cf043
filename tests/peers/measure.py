"""Measures other solvers on the reference cases, the load at the surface, and writes a table: `measure.py FILE`.

Its columns: `solver` as its package is called, `version`, `model` (elements, and what they solve), `dimensions` (2 with an axis of
symmetry, 3 without), `case`, `unknowns`, `relative_error` (L2, of the axial displacement over all samples), `setup_s` (mesh, matrix and
factors), `solve_s` (an answer after that, on one thread: the median, or once where it takes long) and `machine`.

Not here: dolfinx, for the registry of Python's packages has none that installs with Debian's Python; CalculiX, which is a whole process
for an answer; PyBullet, which has no layers.
"""

import csv
import importlib.metadata
import os
import pathlib
import platform
import sys

import by_mujoco
import by_ngsolve
import by_scikit_fem
import cases

COLUMNS = "solver version model dimensions case unknowns relative_error setup_s solve_s machine".split()


def machine():
    """This machine, in the words of `stylet bench`."""
    told = pathlib.Path("/proc/cpuinfo").read_text()
    model = next((line.split(":")[1].strip() for line in told.splitlines() if line.startswith("model name")), "unknown")
    system = f"{platform.system().lower()} {platform.machine()}"
    return f"{model}, {len(os.sched_getaffinity(0))} threads, {system}"


def rows():
    for solver in (by_scikit_fem, by_ngsolve, by_mujoco):
        version = importlib.metadata.version(solver.PACKAGE)
        # The first call of a package pays for what it loads.
        solver.measure(cases.Case("homogeneous"), *next((model, steps[0]) for model, steps in solver.FINENESS.items()))
        for name in cases.NAMES:
            case = cases.Case(name)
            for model, steps in solver.FINENESS.items():
                for fineness in steps:
                    found = solver.measure(case, model, fineness)
                    print(f"{solver.PACKAGE}, {model}: {found}", file=sys.stderr)
                    figures = [found.unknowns, found.error, found.setup_s, found.solve_s]
                    yield [solver.PACKAGE, version, model, solver.DIMENSIONS[model], name, *figures, machine()]


def main():
    file = pathlib.Path(sys.argv[1])
    measured = list(rows())
    with file.open("w", newline="") as table:
        writer = csv.writer(table, lineterminator="\n")
        writer.writerows([COLUMNS, *measured])


if __name__ == "__main__":
    main()

"""How long the Python package takes for 600 000 samples: ten minutes at 1 kHz.

    pip install target/wheel/dist/stylet-*.whl
    python tests/python/time_package.py

Run by hand on a release wheel; docs/measurements.md has the medians.
"""

import platform
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

import stylet

ROOT = Path(__file__).resolve().parents[2]
SAMPLES, RUNS = 600_000, 9


def measure(what, work):
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    print(f"{what:52} {statistics.median(times):.3f} s ({min(times):.3f} to {max(times):.3f})")
    return result


def main():
    print(f"Python {platform.python_version()}, numpy {np.__version__}, {SAMPLES} samples, median of {RUNS}")
    t = np.arange(SAMPLES) * 1e-3
    x = 0.05 * np.sin(0.2 * t)
    measure("stylet.force, three layers, a trocar", lambda: stylet.force(ROOT / "tests/data/force/trocar.json", t, x))
    # Sixty seconds at 10 kHz, down to the muscle.
    slow = np.linspace(0, (SAMPLES - 1) * 1e-4, 600)
    motion = np.column_stack([slow, 0.0004 * slow - 0.004])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "attempt.mcap"
        exercise = ROOT / "curricula/lower-back-basics/3-reach-the-muscle.toml"
        made = stylet.simulate(exercise, motion, tick_hz=10_000, out=path)
        assert len(made) == SAMPLES, len(made)
        measure("stylet.read", lambda: stylet.read(path))
        measure("stylet.read, and samples as an array", lambda: stylet.read(path).samples)
        measure("stylet.read, and every table", lambda: read_tables(path))


def read_tables(path):
    recording = stylet.read(path)
    return [recording.samples, recording.events, recording.tents, recording.energy]


if __name__ == "__main__":
    main()

"""Compares our radiographs with those of gVXR: `by_gvxr.py DIR`, the folder of `cargo run -p guidance --example export_volumes DIR`.

gVXR rasterises the same surfaces on a graphics adapter, in single precision; each bin of energy is one picture. Prints the relative
difference of the transmission: its median, and the value below which 99 % of the pixels lie.
"""

import csv
import pathlib
import sys

import numpy
from gvxrPython3 import gvxr

import attenuation

PIXELS = 512
# The isocentre of the export, in mm.
ISOCENTRE = numpy.array([55.0, 30.0, -75.0])
# Bounds of the median and of 99 % of the pixels.
BOUNDS = (0.005, 0.02)
ENERGY_MEV = 0.08


def load(folder):
    """The rows of the volumes, each with its surface loaded."""
    volumes = list(csv.DictReader((folder / "volumes.csv").open()))
    for volume in volumes:
        gvxr.loadMeshFile(volume["name"], str(folder / f"{volume['name']}.stl"), "mm")
    return volumes


def place(degrees):
    """The C-arm at an orbital angle."""
    angle = numpy.radians(degrees)
    direction = numpy.array([numpy.sin(angle), 0.0, numpy.cos(angle)])
    source = ISOCENTRE - 600 * direction
    gvxr.setSourcePosition(*map(float, source), "mm")
    gvxr.setDetectorPosition(*map(float, source + 1000 * direction), "mm")
    gvxr.setDetectorUpVector(0, 1, 0)


def transmissions(volumes, table):
    """The detected fraction of the energy at each pixel, by rows from the upper left."""
    substances = {volume["name"]: volume["substance"] for volume in volumes}
    total = numpy.zeros((PIXELS, PIXELS))
    for at, weight in enumerate(table["Weights"]):
        for volume in volumes:
            around = table[substances[volume["parent"]]][at] if volume["parent"] else 0.0
            gvxr.setLinearAttenuationCoefficient(volume["name"], table[volume["substance"]][at] - around, "cm-1")
        total += weight * numpy.array(gvxr.computeXRayImage()) / ENERGY_MEV
    # gVXR's rows begin at the lower right, seen from the detector.
    return total[::-1, ::-1]


def main():
    folder = pathlib.Path(sys.argv[1])
    gvxr.createOpenGLContext()
    gvxr.usePointSource()
    gvxr.setMonoChromatic(ENERGY_MEV, "MeV", 1)
    gvxr.setDetectorNumberOfPixels(PIXELS, PIXELS)
    gvxr.setDetectorPixelSize(300 / PIXELS, 300 / PIXELS, "mm")
    volumes, table = load(folder), attenuation.read_table()
    fails = False
    for degrees in (0, 30, 90):
        place(degrees)
        ours = numpy.fromfile(folder / f"{degrees}.f64").reshape(PIXELS, PIXELS)
        off = numpy.abs(transmissions(volumes, table) / ours - 1)
        found = (numpy.median(off), numpy.percentile(off, 99))
        fails |= any(value > bound for value, bound in zip(found, BOUNDS))
        print(f"{degrees:2}°: median {100 * found[0]:.3f} %, 99 % of the pixels within {100 * found[1]:.2f} %")
    sys.exit("differs by more than 0.5 % at the median or 2 % in 99 % of the pixels" if fails else 0)


main()

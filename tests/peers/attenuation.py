"""Computes the attenuation table of sim/guidance/src/attenuation.rs anew and compares it.

`tests/peers/radiographs` installs what it needs and runs it.

Spectrum: 80 kV, tungsten 12°, 3 mm Al, 0.1 mm Cu, weighted by the energy absorbed in 0.5 mm of CsI with 60 % packing.
Compositions by mass: ICRU report 44 (adipose, muscle, soft tissue, blood, cortical bone), ICRU report 46 (spongiosa, kidney).
"""

import re
import sys
from pathlib import Path

import numpy
import spekpy
import xraydb

EDGES_KEV = [15, 25, 35, 45, 55, 65, 75, 85]
CSI_CM, CSI_G_CM3, PACKING = 0.05, 4.51, 0.6

# Density in g/cm³ and fractions of the mass.
SUBSTANCES = {
    "Adipose": (0.95, dict(H=0.114, C=0.598, N=0.007, O=0.278, Na=0.001, S=0.001, Cl=0.001)),
    "Muscle": (1.05, dict(H=0.102, C=0.143, N=0.034, O=0.710, Na=0.001, P=0.002, S=0.003, Cl=0.001, K=0.004)),
    "SoftTissue": (1.06, dict(H=0.102, C=0.143, N=0.034, O=0.708, Na=0.002, P=0.003, S=0.003, Cl=0.002, K=0.003)),
    "Kidney": (1.05, dict(H=0.103, C=0.132, N=0.030, O=0.724, Na=0.002, P=0.002, S=0.002, Cl=0.002, K=0.002, Ca=0.001)),
    "Blood": (1.06, dict(H=0.102, C=0.110, N=0.033, O=0.745, Na=0.001, P=0.001, S=0.002, Cl=0.003, K=0.002, Fe=0.001)),
    "Water": (1.00, dict(H=0.111898, O=0.888102)),
    "CorticalBone": (1.92, dict(H=0.034, C=0.155, N=0.042, O=0.435, Na=0.001, Mg=0.002, P=0.103, S=0.003, Ca=0.225)),
    "Spongiosa": (
        1.18,
        dict(H=0.085, C=0.404, N=0.028, O=0.367, Na=0.001, Mg=0.001, P=0.034, S=0.002, Cl=0.002, K=0.001, Ca=0.074, Fe=0.001),
    ),
    "Steel": (7.9, dict(Fe=0.70, Cr=0.19, Ni=0.10, Mn=0.01)),
}


def coefficients(density, fractions, energies_kev):
    """Linear attenuation coefficients, in 1/cm."""
    total = sum(fractions.values())
    per_g = sum(share / total * xraydb.mu_elam(element, energies_kev * 1e3) for element, share in fractions.items())
    return density * per_g


def contrast(energies_kev):
    """Water with 89 mg of iodine per ml and the organic part of its molecule: 1.09 g/cm³."""
    water = SUBSTANCES["Water"][1]
    fractions = dict(H=0.8925 * water["H"] + 0.0023, C=0.0232, O=0.8925 * water["O"], I=0.0820)
    return coefficients(1.09, fractions, energies_kev)


def detected_spectrum():
    """Energies in keV and the fraction of the detected energy at each."""
    spectrum = spekpy.Spek(kvp=80, th=12, dk=0.5).multi_filter([("Al", 3.0), ("Cu", 0.1)])
    energies, fluence = spectrum.get_spectrum(edges=False)
    # 131.293 of caesium and 126.904 of iodine.
    csi = coefficients(CSI_G_CM3 * PACKING, dict(Cs=132.905, I=126.904), energies)
    weights = fluence * energies * (1 - numpy.exp(-csi * CSI_CM))
    return energies, weights / weights.sum()


def bins(energies, weights, values):
    """Means over each bin with the detected energy as weight."""
    inside = [(energies >= low) & (energies < high) for low, high in zip(EDGES_KEV, EDGES_KEV[1:])]
    return [float((values[own] * weights[own]).sum() / weights[own].sum()) for own in inside]


def shares(energies, weights):
    inside = [(energies >= low) & (energies < high) for low, high in zip(EDGES_KEV, EDGES_KEV[1:])]
    found = numpy.array([weights[own].sum() for own in inside])
    return [float(share) for share in found / found.sum()]


def read_table():
    """The rows of the Rust table."""
    text = (Path(__file__).parents[2] / "sim/guidance/src/attenuation.rs").read_text()
    numbers = lambda inside: [float(number) for number in inside.replace("_", "").split(",") if number.strip()]
    rows = {name: numbers(inside) for name, inside in re.findall(r"Substance::(\w+) => \[([^\]]*)\]", text)}
    rows["Weights"] = numbers(re.search(r"WEIGHTS: \[f64; BINS\] = \[([^\]]*)\]", text)[1])
    rows["Steel"] = numbers(re.search(r"STEEL_PER_CM: \[f64; BINS\] = \[([^\]]*)\]", text)[1])
    return rows


def main():
    energies, weights = detected_spectrum()
    made = {name: bins(energies, weights, coefficients(*own, energies)) for name, own in SUBSTANCES.items()}
    made["ContrastMedium"] = bins(energies, weights, contrast(energies))
    made["Weights"] = shares(energies, weights)
    worst = 0.0
    for name, written in read_table().items():
        # The table has four decimals, or five digits.
        rounding = [max(5.1e-5, 5.1e-5 * abs(other)) for other in written]
        off = max((abs(own - other) - half) / abs(own) for own, other, half in zip(made[name], written, rounding))
        worst = max(worst, off)
        print(f"{name:15} {off:.1e}  " + " ".join(f"{value:.4f}" for value in made[name]))
    # Seven bins against the whole spectrum.
    cases = {
        "10 cm of soft tissue": dict(SoftTissue=10),
        "20 cm": dict(SoftTissue=20),
        "20 cm, 2 cm spongiosa, 0.3 cm cortex": dict(SoftTissue=20, Spongiosa=2, CorticalBone=0.3),
        "20 cm, 1 mm steel": dict(SoftTissue=20, Steel=0.1),
        "20 cm, 8 mm contrast": dict(SoftTissue=20, ContrastMedium=0.8),
    }
    fine = {name: coefficients(*own, energies) for name, own in SUBSTANCES.items()} | {"ContrastMedium": contrast(energies)}
    for name, lengths in cases.items():
        exact = float((weights * numpy.exp(-sum(fine[substance] * cm for substance, cm in lengths.items()))).sum())
        depths = [sum(made[substance][at] * cm for substance, cm in lengths.items()) for at in range(7)]
        coarse = sum(share * numpy.exp(-depth) for share, depth in zip(made["Weights"], depths))
        print(f"{name}: {100 * (coarse / exact - 1):+.1f} %")
    if worst > 1e-4:
        sys.exit(f"the table differs by {worst:.1e}; allowed: 1e-4")


if __name__ == "__main__":
    main()

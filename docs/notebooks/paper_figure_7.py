# %% [markdown]
# # The paper's Fig. 7: the force along an insertion at 2 mm/s
#
# The source paper plots the force on the needle over its way through skin, fat and muscle at a constant 2 mm/s. This draws it anew, from
# the exercise that holds the paper's own layers, and puts beside every pop where the closed form of the law has it.
#
#     python docs/notebooks/paper_figure_7.py [FIGURE.png]
#
# needs `stylet`, numpy and matplotlib.

# %%
import sys
from pathlib import Path

import matplotlib

if __name__ == "__main__" and "ipykernel" not in sys.modules:
    matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import stylet

ROOT = Path(__file__).resolve().parents[2]
SPEED_MM_PER_S = 2

# %% [markdown]
# A stiff hand performs the exercise. The patient is drawn from the seed, so its layers are not exactly those of the table.

# %%
attempt = stylet.simulate(ROOT / "curricula/experiments/paper-insertion.toml", f"constant:{SPEED_MM_PER_S}", seed=0)
samples, events = attempt.samples, attempt.events
inward = samples["t_s"] <= samples["t_s"][np.argmax(samples["x_m"])]
advance_mm = samples["x_m"][inward] * 1e3
force_n = sum(samples[part][inward].astype(float) for part in ("tip_n", "rim_n", "viscous_n", "friction_n", "cutting_n"))
pops = events[np.isin(events["kind"], ["tip_rupture", "rim_rupture"])]

# %% [markdown]
# The closed form: a boundary at D gives to the tip at D + P/k, and to the rim L later by its own threshold, but never before what must have
# given before it.

# %%
NAMES = ("skin", "fat", "muscle")
STIFFNESS_N_PER_M = np.array([331, 83, 497])
THRESHOLDS_N = {"tip_rupture": np.array([1.0, 0.5, 1.5]), "rim_rupture": np.array([1.3, 0.6, 1.9])}
TIP_TO_RIM_MM = 2.0
boundary_mm = np.concatenate([[0], np.cumsum(attempt.session["patient_thickness_mm"])[:-1]])
expected_mm = {"tip_rupture": [], "rim_rupture": []}
for i, (depth_mm, k) in enumerate(zip(boundary_mm, STIFFNESS_N_PER_M)):
    tip_mm = max(depth_mm + THRESHOLDS_N["tip_rupture"][i] / k * 1e3, *expected_mm["tip_rupture"], 0)
    rim_mm = depth_mm + TIP_TO_RIM_MM + THRESHOLDS_N["rim_rupture"][i] / k * 1e3
    expected_mm["tip_rupture"].append(tip_mm)
    expected_mm["rim_rupture"].append(max(rim_mm, tip_mm, *expected_mm["rim_rupture"], 0))

print("boundary  by    at mm  expected mm  its own force N")
for pop in pops:
    at_mm, wanted_mm = pop["x_m"] * 1e3, expected_mm[pop["kind"]][pop["boundary"]]
    print(f"{NAMES[pop['boundary']]:8}  {pop['kind'][:3]} {at_mm:8.3f} {wanted_mm:12.3f} {pop['force_n']:16.3f}")
    # Seen at the tick after, so late by at most one.
    assert 0 <= at_mm - wanted_mm <= SPEED_MM_PER_S / attempt.session["tick_hz"] + 1e-9, "the law is not its closed form"

# %%
INK, TIP, RIM = "#22303c", "#b5462e", "#2a6f97"
figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
edges_mm = np.append(boundary_mm, advance_mm[-1])
for name, left, right, shade in zip(NAMES, edges_mm, edges_mm[1:], ("#f3ddcf", "#faf0cf", "#f2d3d3")):
    axes.axvspan(left, right, color=shade, lw=0)
    # Skin is too thin for a word of its own inside.
    place = dict(x=(left + right) / 2, ha="center") if right - left > 2 else dict(x=left - 0.15, ha="right")
    axes.text(y=0.97, s=name, va="top", color="#66594f", transform=axes.get_xaxis_transform(), **place)
axes.plot(advance_mm, force_n, color=INK, lw=1.4)
# The height of a curve just before its drop.
before = np.searchsorted(samples["t_s"][inward], pops["t_s"]) - 1
for kind, color, label in (("tip_rupture", TIP, "pop of the stylet's tip"), ("rim_rupture", RIM, "pop of the cannula's rim")):
    of = pops["kind"] == kind
    axes.plot(pops["x_m"][of] * 1e3, force_n[before[of]], "o", color=color, ms=6, label=label)
axes.set(
    xlabel="advance of the needle, mm",
    ylabel="force on the hand, N",
    xlim=(-2, advance_mm[-1]),
    ylim=(0, 1.16 * force_n.max()),
    title=f"Through skin, fat and muscle at {SPEED_MM_PER_S} mm/s",
)
figure.legend(loc="outside lower center", ncols=2, frameon=False)
axes.set_xticks(range(-2, 21, 2))
axes.spines[["top", "right"]].set_visible(False)
out = sys.argv[1] if len(sys.argv) > 1 and sys.argv[1].endswith(".png") else "paper_figure_7.png"
figure.savefig(out, dpi=150)
print(f"{out}: {len(advance_mm)} samples, {len(pops)} pops")

# %% [markdown]
# # Known groups: which metrics tell novices from experts?
#
# A cohort of virtual novices and experts performs an exercise, every attempt is scored, and for each metric the area under the ROC curve
# says how well it alone tells the groups apart: 0.5 is a coin, 1 a metric by which every expert is better than every novice, less than 0.5
# one by which novices are better. Its interval is by resampling people; where the groups do not overlap at all, it has no width.
#
# Virtual hands are models of what is published of people. This shows the method; it validates nothing.
#
#     python docs/notebooks/known_groups.py [FIGURE.png]
#
# needs `stylet`, numpy and matplotlib.

# %%
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib

if __name__ == "__main__" and "ipykernel" not in sys.modules:
    matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import stylet

ROOT = Path(__file__).resolve().parents[2]
EXERCISE = ROOT / "curricula/lower-back-basics/3-reach-the-muscle.toml"
PEOPLE = 24
RESAMPLES = 1000


# %% [markdown]
# Every person has a seed of their own: another hand, another patient. Python's lock is released meanwhile, so threads share the work.

# %%
def attempt(person):
    skill, seed = person
    return stylet.simulate(EXERCISE, skill, seed).score()


groups = ("novice", "expert")
everybody = [(skill, seed) for skill in groups for seed in range(PEOPLE)]
with ThreadPoolExecutor() as threads:
    scores = list(threads.map(attempt, everybody))
novices, experts = scores[:PEOPLE], scores[PEOPLE:]
for skill, group in zip(groups, (novices, experts)):
    points = np.array([judged["score"] for judged in group])
    print(f"{skill:7} {np.median(points):5.1f} points (median of {PEOPLE}), {sum(j['passed'] for j in group)} passed")


# %%
def latest(judged):
    """The newest version of each metric of the whole attempt that has a value, by its id. Those of single layers have a dot in it."""
    metrics = sorted(judged["metrics"], key=lambda metric: metric["version"])
    return {m["id"]: m for m in metrics if m["applies"] and m["value"] is not None and "." not in m["id"]}


def goodness(metric):
    """A number that is larger where the metric is better."""
    return {"lower": -metric["value"], "higher": metric["value"], "range": -abs(metric["value"])}[metric["direction"]]


def area(worse, better):
    """The probability that one of the second group is better than one of the first; a tie is half."""
    difference = better[:, None] - worse[None, :]
    return np.mean(difference > 0) + np.mean(difference == 0) / 2


random = np.random.default_rng(0)
tables = [[latest(judged) for judged in group] for group in (novices, experts)]
found = []
for name in tables[1][0]:
    columns = [np.array([goodness(person[name]) for person in table if name in person]) for table in tables]
    # A metric that half of a group lacks, or that nobody differs in, tells nothing.
    if min(map(len, columns)) < PEOPLE / 2 or np.ptp(np.concatenate(columns)) == 0:
        continue
    again = [area(*(random.choice(column, len(column)) for column in columns)) for _ in range(RESAMPLES)]
    found.append((area(*columns), *np.quantile(again, [0.025, 0.975]), name))
found.sort()

print(f"\n{'metric':36}   AUC   95 % interval")
for auc, low, high, name in reversed(found):
    print(f"{name:36} {auc:5.2f}   {low:.2f} to {high:.2f}")

# %%
figure, axes = plt.subplots(figsize=(8, 1.2 + 0.23 * len(found)), layout="constrained")
auc, low, high = np.array([row[:3] for row in found]).T
rows = np.arange(len(found))
told = np.where(low > 0.5, "#2a6f97", np.where(high < 0.5, "#b5462e", "#8a8f94"))
axes.axvline(0.5, color="#c5c9cd", lw=1, zorder=0)
axes.hlines(rows, low, high, color=told, lw=2)
axes.scatter(auc, rows, color=told, s=28, zorder=3)
axes.set_yticks(rows, [row[3] for row in found], fontsize=8)
axes.set(
    xlim=(-0.02, 1.02),
    ylim=(-0.8, len(found) - 0.2),
    xlabel="area under the ROC curve (1: every expert is better than every novice)",
    title=f"{PEOPLE} virtual novices, {PEOPLE} virtual experts: reach the muscle",
)
for color, label in (("#2a6f97", "experts are better"), ("#8a8f94", "undecided"), ("#b5462e", "novices are better")):
    axes.scatter([], [], color=color, s=28, label=label)
figure.legend(loc="outside lower center", ncols=3, frameon=False)
axes.spines[["top", "right", "left"]].set_visible(False)
axes.tick_params(axis="y", length=0)
out = sys.argv[1] if len(sys.argv) > 1 and sys.argv[1].endswith(".png") else "known_groups.png"
figure.savefig(out, dpi=150)
print(f"\n{out}: {len(found)} metrics, {sum(low > 0.5)} tell experts apart")

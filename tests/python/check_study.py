"""What a study's page and its codebook say, computed anew from its table by independent packages (pandas, scipy, pingouin).

Arguments: the table (CSV), the codebook with the figures (JSON), the page of results (HTML, English). Prints how many figures were held
against each other; exits with what differs.
"""

import html
import json
import math
import re
import sys

import numpy as np
import pandas as pd
import pingouin as pg
from scipy import stats

table = pd.read_csv(sys.argv[1])
book = json.load(open(sys.argv[2], encoding="utf-8"))
page = open(sys.argv[3], encoding="utf-8").read()
held, wrong = 0, []


def hold(what, ours, theirs, apart=1e-8):
    """Holds a figure of ours against one of the packages', relative to its size."""
    global held
    held += 1
    if not math.isclose(ours, theirs, rel_tol=apart, abs_tol=apart):
        wrong.append(f"{what}: {ours} here, {theirs} there")


def column(metric):
    return "score" if metric == "score" else "m_" + metric.replace(".", "_")


def by_group(exercise, name):
    """The means of each participant's attempts, group by group."""
    own = table[table["exercise"] == exercise].dropna(subset=[name])
    means = own.groupby(["group", "participant"])[name].mean().reset_index()
    return [means[means["group"] == place][name].to_numpy() for place in range(1, len(book["groups"]) + 1)]


def compare(exercise, found):
    groups = by_group(exercise, column(found["id"]))
    what = f"{exercise}, {found['id']}"
    for summary, values in zip(found["groups"], groups):
        if summary is None:
            continue
        hold(f"{what}: n", summary["n"], len(values))
        for key, share in [("min", 0), ("lower_quartile", 25), ("median", 50), ("upper_quartile", 75), ("max", 100)]:
            hold(f"{what}: {key}", summary[key], np.percentile(values, share))
    first, last = groups[0], groups[-1]
    test = stats.mannwhitneyu(last, first, method="asymptotic")
    hold(f"{what}: U", found["test"]["u"], test.statistic)
    ties = len(set(first) | set(last)) < len(first) + len(last)
    if not ties:
        hold(f"{what}: p", found["test"]["p"], stats.mannwhitneyu(last, first, method="exact").pvalue)
    elif len(first) + len(last) <= 16:
        dealt = stats.permutation_test(
            (last, first),
            lambda x, y, axis=-1: stats.mannwhitneyu(x, y, axis=axis, method="asymptotic").statistic,
            n_resamples=np.inf, vectorized=True, permutation_type="independent",
        )
        hold(f"{what}: p", found["test"]["p"], dealt.pvalue)
    if found["hedges_g"]:
        g = pg.compute_effsize(last, first, eftype="hedges")
        low, high = pg.compute_esci(g, len(last), len(first), eftype="hedges", decimals=12)
        for key, theirs in [("value", g), ("low", low), ("high", high)]:
            hold(f"{what}: g, {key}", found["hedges_g"][key], theirs)
    if found["auc"]:
        hold(f"{what}: AUC", found["auc"]["value"], pg.compute_effsize(last, first, eftype="CLES"))
    return found["test"]["p"]


def learn(exercise, learning):
    """The mean score of each group at each attempt, with Student's interval."""
    own = table[table["exercise"] == exercise]
    for place, attempts in enumerate(learning, start=1):
        for number, found in enumerate(attempts, start=1):
            scores = own[(own["group"] == place) & (own["attempt"] == number)]["score"].to_numpy()
            if found is None:
                continue
            what = f"{exercise}, group {place}, attempt {number}"
            hold(f"{what}: mean", found["value"], scores.mean())
            low, high = stats.t.interval(0.95, len(scores) - 1, scores.mean(), stats.sem(scores))
            # Scores end at 0 and at 100, and so does an interval of their mean.
            hold(f"{what}: low", found["low"], max(0.0, low))
            hold(f"{what}: high", found["high"], min(100.0, high))


def repeat(exercise, repeated):
    if "Ok" not in repeated:
        return
    own = table[table["exercise"] == exercise]
    whole = own.groupby("participant").filter(lambda made: len(made) == own["attempt"].max())
    icc = pg.intraclass_corr(data=whole, targets="participant", raters="attempt", ratings="score")
    names = [name.replace("(", "").replace(")", "").replace(",", "").replace(" ", "") for name in icc["Type"]]
    theirs = dict(zip(names, icc["ICC"]))
    for key, spellings in [("single_random", ["ICC2", "ICCA1"]), ("single_fixed", ["ICC3", "ICCC1"])]:
        hold(f"{exercise}: {key}", repeated["Ok"][key], next(float(theirs[s]) for s in spellings if s in theirs))


def ask(place, survey):
    """Alpha, what it would be without an item, item–rest correlations and content validity, group by group."""
    for score in survey["results"]["scores"]:
        items = [item["id"] for item in score["scale_items"]]
        columns = [f"q{place}_{item}".replace("-", "_") for item in items]
        answered = table.dropna(subset=columns)
        for group, found in score["alpha"]:
            own = answered if group == "all" else answered[answered["group"].map(name_of_group) == group]
            if isinstance(found, dict) and "alpha" in found:
                alpha, (low, high) = pg.cronbach_alpha(data=own[columns])
                what = f"{survey['instrument']}, {score['id']}, {group}"
                hold(f"{what}: alpha", found["alpha"], alpha)
                # pingouin rounds the interval to three digits.
                hold(f"{what}: alpha, low", found["low"], low, 5.1e-4)
                hold(f"{what}: alpha, high", found["high"], high, 5.1e-4)
        for item, own_column in zip(score["scale_items"], columns):
            rest = answered[[other for other in columns if other != own_column]]
            what = f"{survey['instrument']}, {item['id']}"
            if item["rest_correlation"] is not None:
                theirs = stats.pearsonr(answered[own_column], rest.sum(axis=1)).statistic
                hold(f"{what}: item–rest", item["rest_correlation"], theirs)
            if item["alpha_without"] is not None:
                hold(f"{what}: alpha without", item["alpha_without"], pg.cronbach_alpha(data=rest)[0])
    for item in survey["results"]["items"]:
        for found in item["content_validity"]:
            rated = table[table["group"].map(name_of_rater) == found["group"]]
            rated = rated[f"q{place}_{item['id']}".replace("-", "_")].dropna()
            what = f"{survey['instrument']}, {item['id']}, {found['group']}"
            hold(f"{what}: raters", found["validity"]["n"], len(rated))
            hold(f"{what}: I-CVI", found["validity"]["value"], (rated >= 3).mean())


def name_of_group(place):
    """The last group is that of the experts, whatever the study calls it."""
    return "expert" if place == len(book["groups"]) else book["groups"][place - 1]


def name_of_rater(place):
    return "experts" if place == len(book["groups"]) else book["groups"][place - 1]


def read_page():
    """The rows of the page's tables, each as its cells' words by their headings."""
    for row in re.findall(r"<tr>\s*<th scope=\"row\" data-label=\"Metric\">(.*?)</th>(.*?)</tr>", page, re.S):
        cells = re.findall(r"<td data-label=\"([^\"]*)\"[^>]*>(.*?)</td>", row[1], re.S)
        plain = {html.unescape(name): html.unescape(re.sub(r"<[^>]*>", "", words)).replace("\u2060", "") for name, words in cells}
        yield html.unescape(re.sub(r"<[^>]*>", "", row[0])).strip(), plain


def numbers(words):
    return [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", words.replace("−", "-").replace("\u202f", ""))]


def read_rounded(shown, found):
    """What the page rounds is the figure of the codebook."""
    global held
    for name, summary in zip(book["groups"], found["groups"]):
        if summary is None:
            continue
        said = numbers(re.sub(r"–(?=\d)", " ", shown[name]))
        for rounded, exact in zip(said, [summary["median"], summary["lower_quartile"], summary["upper_quartile"]]):
            held += 1
            digits = 0.5 * 10.0 ** -len(f"{rounded}".partition(".")[2]) if rounded % 1 else 0.5
            if abs(rounded - exact) > digits * 1.02 and abs(rounded - exact) > 0.006 * abs(exact):
                wrong.append(f"{found['id']}: the page says {rounded} for {exact}")
        hold(f"{found['id']}: n on the page", said[-1], summary["n"])
    for heading, key in [("Hedges’ g", "hedges_g"), ("Area under the curve", "auc")]:
        if found[key]:
            for rounded, part in zip(numbers(shown[heading]), ["value", "low", "high"]):
                hold(f"{found['id']}: {key} on the page", rounded, found[key][part], 0.0051)
    if "<" not in shown["p, Holm"]:
        hold(f"{found['id']}: p after Holm on the page", numbers(shown["p, Holm"])[0], found["p_holm"], 0.0051)


for exercise, findings in book["findings"].items():
    p = [compare(exercise, found) for found in findings["comparisons"]]
    if p:
        for found, theirs in zip(findings["comparisons"], pg.multicomp(p, method="holm")[1]):
            hold(f"{exercise}, {found['id']}: Holm", found["p_holm"], float(theirs))
    learn(exercise, findings["learning"])
    repeat(exercise, findings["repeated"])

for place, survey in enumerate(book["surveys"], start=1):
    ask(place, survey)

first = next(iter(book["findings"].values()))
by_label = {}
for found in first["comparisons"]:
    by_label.setdefault(found["label"].lower(), found)
rows = list(read_page())
for label, shown in rows:
    if label.lower() not in by_label:
        wrong.append(f"the page has a row “{label}”, of which the codebook knows nothing")
    else:
        read_rounded(shown, by_label[label.lower()])
if len(rows) != len(first["comparisons"]):
    wrong.append(f"{len(rows)} rows on the page, {len(first['comparisons'])} comparisons in the codebook")
print(held)
sys.exit("\n".join(wrong) or None)

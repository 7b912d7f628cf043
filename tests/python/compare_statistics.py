"""Statistics of a table of ratings and of two groups, by independent packages (pingouin, scipy).

Reads {"rows": [[...]]} from standard input, a row for each object and a column for each rater or item, or
{"first": [...], "second": [...]}, two groups. Prints JSON.
"""

import json
import sys

import numpy as np
import pandas as pd
import pingouin as pg
from scipy import stats


def of_table(rows):
    """Cronbach's alpha, item analysis, intraclass correlations, content validity."""
    table = pd.DataFrame(rows)
    long = table.reset_index().melt(id_vars="index", var_name="rater", value_name="rating")
    icc = pg.intraclass_corr(data=long, targets="index", raters="rater", ratings="rating")
    names = (name.replace("(", "").replace(")", "").replace(",", "").replace(" ", "") for name in icc["Type"])
    by_type = dict(zip(names, icc["ICC"]))

    def correlation(*names):
        """Packages spell the type differently from version to version."""
        return next(float(by_type[name]) for name in names if name in by_type)

    alpha, (low, high) = pg.cronbach_alpha(data=table)
    relevant = (table >= 3).mean()
    others = {item: table.drop(columns=item) for item in table}
    return {
        "alpha": float(alpha),
        "alpha_low": float(low),
        "alpha_high": float(high),
        "item_rest": [float(stats.pearsonr(table[item], rest.sum(axis=1)).statistic) for item, rest in others.items()],
        "alpha_without": [float(pg.cronbach_alpha(data=rest)[0]) for rest in others.values()],
        "icc_2_1": correlation("ICC2", "ICCA1"),
        "icc_3_1": correlation("ICC3", "ICCC1"),
        "icc_2_k": correlation("ICC2k", "ICCAk"),
        "icc_3_k": correlation("ICC3k", "ICCCk"),
        "i_cvi": [float(share) for share in relevant],
        "s_cvi": float(relevant.mean()),
    }


def of_groups(first, second):
    """Mann and Whitney's test, counted and approximated, Hedges' g with its interval, the common-language effect."""

    def u_statistic(x, y, axis=-1):
        return stats.mannwhitneyu(x, y, axis=axis, method="asymptotic").statistic

    dealt = stats.permutation_test(
        (first, second), u_statistic, n_resamples=np.inf, vectorized=True, permutation_type="independent"
    ) if len(first) + len(second) <= 16 else None
    approximated = stats.mannwhitneyu(first, second, method="asymptotic")
    ties = len(set(first) | set(second)) < len(first) + len(second)
    counted = None if ties else float(stats.mannwhitneyu(first, second, method="exact").pvalue)
    g = pg.compute_effsize(first, second, eftype="hedges")
    low, high = pg.compute_esci(g, len(first), len(second), eftype="hedges", decimals=9)
    return {
        "u": float(approximated.statistic),
        "p_normal": float(approximated.pvalue),
        "p_dealt": counted if dealt is None else float(dealt.pvalue),
        "g": float(g),
        "g_low": float(low),
        "g_high": float(high),
        "cles": float(pg.compute_effsize(first, second, eftype="CLES")),
    }


given = json.load(sys.stdin)
if "rows" in given:
    answer = of_table(given["rows"])
elif "p" in given:
    answer = {"holm": [float(p) for p in pg.multicomp(given["p"], method="holm")[1]]}
else:
    answer = of_groups(given["first"], given["second"])
print(json.dumps(answer))

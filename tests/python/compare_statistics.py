"""Cronbach's alpha, intraclass correlations and content validity of a table of ratings, by an independent package.

Reads {"rows": [[...]]} from standard input: a row for each object, a column for each rater or item. Prints JSON.
Exits 77 where pingouin is not installed.
"""

import json
import sys

try:
    import pandas as pd
    import pingouin as pg
except ImportError as missing:
    print(f"skipped: {missing}", file=sys.stderr)
    sys.exit(77)

rows = json.load(sys.stdin)["rows"]
table = pd.DataFrame(rows)
long = table.reset_index().melt(id_vars="index", var_name="rater", value_name="rating")
icc = pg.intraclass_corr(data=long, targets="index", raters="rater", ratings="rating")
by_type = dict(zip((name.replace("(", "").replace(")", "").replace(",", "").replace(" ", "") for name in icc["Type"]), icc["ICC"]))


def correlation(*names):
    """Packages spell the type differently from version to version."""
    return next(float(by_type[name]) for name in names if name in by_type)


relevant = (table >= 3).mean()
print(
    json.dumps(
        {
            "alpha": float(pg.cronbach_alpha(data=table)[0]),
            "icc_2_1": correlation("ICC2", "ICCA1"),
            "icc_3_1": correlation("ICC3", "ICCC1"),
            "icc_2_k": correlation("ICC2k", "ICCAk"),
            "icc_3_k": correlation("ICC3k", "ICCCk"),
            "i_cvi": [float(share) for share in relevant],
            "s_cvi": float(relevant.mean()),
        }
    )
)

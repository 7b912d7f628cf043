"""A school's tables for research, as pandas and polars read them.

    check_tables.py FOLDER

Fails when one of them cannot read a table, when the two read different things, when the codebook and the tables have different columns,
when a row has no attempt, or when a column of the attempts names somebody.
"""

import json
import sys
from pathlib import Path

import pandas
import polars


def main(folder: Path) -> None:
    codebook = json.loads((folder / "codebook.json").read_text())
    tables = {path.stem: (pandas.read_parquet(path), polars.read_parquet(path)) for path in sorted(folder.glob("*.parquet"))}
    for name, (by_pandas, by_polars) in tables.items():
        assert list(by_pandas.columns) == by_polars.columns, name
        assert len(by_pandas) == by_polars.height > 0, (name, len(by_pandas), by_polars.height)
        for column in by_polars.columns:
            ours, theirs = by_pandas[column].isna().sum(), by_polars[column].null_count()
            assert ours == theirs, (name, column, ours, theirs)
        described = codebook["tables"][name]
        if isinstance(described, list):
            assert [column["name"] for column in described] == list(by_pandas.columns), name
            for column in described:
                assert column["may_be_empty"] or not by_pandas[column["name"]].isna().any(), (name, column["name"])
    attempts = tables["attempts"][0]
    assert attempts["session"].is_unique
    assert len(attempts) == codebook["counts"]["attempts"]
    assert len(tables["metrics"][0]) == codebook["counts"]["metrics"]
    sessions = set(attempts["session"])
    for name in ("metrics", "samples"):
        assert name not in tables or set(tables[name][0]["session"]) <= sessions, name
    people = attempts.groupby("pseudonym")["role"].nunique()
    assert (people == 1).all()
    told = {
        "attempts": len(attempts),
        "people": int(attempts["pseudonym"].nunique()),
        "roles": sorted(attempts["role"].unique()),
        "mean_score": float(attempts["score"].mean()),
        "mean_peak_force_n": float(tables["metrics"][0].query("metric == 'peak_force_n'")["value"].mean()),
        "samples": len(tables["samples"][0]) if "samples" in tables else 0,
        "longest_s": float(tables["samples"][0].groupby("session")["t_s"].max().max()) if "samples" in tables else 0.0,
        "text": attempts.to_csv(index=False),
    }
    print(json.dumps(told))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

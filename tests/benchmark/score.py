"""Scores a solver's answers: `python score.py RESULTS [--json]`. Python 3.10 or later, and numpy.

RESULTS holds a CSV file for each case, NAME.csv, and may hold times.csv (columns case and seconds). Exit 0: every case
that is given is met, and one is given at least. 1: some is not met, or none is given. 2: the folder or the call is wrong.
"""

import argparse
import csv
import json
import math
import pathlib
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
KEYS = {"force": ["t_s"], "field": ["load_depth_m", "depth_m", "r_m"]}
SAME_KEY = 1e-9
WORDS = ("events",)


class Refused(Exception):
    """An answer that cannot be scored; says where and why."""


def read_table(path):
    """The columns of a CSV file by name, as text."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise Refused(f"{path.name}: cannot be read: {error}") from error
    if not rows:
        raise Refused(f"{path.name}: is empty; a header and a row for each sample are needed")
    header = [name.strip() for name in rows[0]]
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise Refused(f"{path.name}: column {twice[0]} appears twice; allowed: once")
    for number, row in enumerate(rows[1:], 1):
        if len(row) != len(header):
            raise Refused(f"{path.name}: row {number} has {len(row)} fields, the header has {len(header)}")
    return {name: [row[at].strip() for row in rows[1:]] for at, name in enumerate(header)}


def numbers(path, table, column):
    """A column as numbers, every one finite."""
    if column not in table:
        raise Refused(f"{path.name}: column {column} is missing; there are {', '.join(table)}")
    found = np.empty(len(table[column]))
    for row, text in enumerate(table[column]):
        try:
            found[row] = float(text)
        except ValueError:
            raise Refused(f"{path.name}: row {row + 1}: {column} is {text!r}; a number is needed") from None
        if not math.isfinite(found[row]):
            raise Refused(f"{path.name}: row {row + 1}: {column} is {text}; it must be finite")
    return found


def opened(path, column, texts):
    """The row of each rupture, by its name; `tip:0+rim:0` is two ruptures in one row."""
    rows = {}
    for row, text in enumerate(texts):
        for name in filter(None, text.split("+")):
            if name in rows:
                raise Refused(f"{path.name}: row {row + 1}: {column}: {name} opened in row {rows[name] + 1} already")
            rows[name] = row
    return rows


def relative_l2(found, wanted):
    return float(np.linalg.norm(found - wanted) / np.linalg.norm(wanted))


def measure_ticks(paths, found, wanted):
    """The most samples by which a rupture is early or late; without end where one is missing or too many."""
    found, wanted = (opened(path, "events", texts) for path, texts in zip(paths, (found, wanted)))
    if set(found) != set(wanted):
        return math.inf
    return float(max((abs(found[name] - wanted[name]) for name in wanted), default=0))


def check_keys(kind, path, table, answer_path, answer):
    """The samples are those of the case, in its order, none missing and none too many."""
    count = len(answer[KEYS[kind][0]])
    keys = {key: numbers(path, table, key) for key in KEYS[kind]}
    given = len(keys[KEYS[kind][0]])
    if given != count:
        raise Refused(f"{path.name}: {given} rows; the case has {count} samples, a row for each, in its order")
    for key in KEYS[kind]:
        wanted = numbers(answer_path, answer, key)
        off = np.flatnonzero(np.abs(keys[key] - wanted) > SAME_KEY * np.maximum(1.0, np.abs(wanted)))
        if off.size:
            row = int(off[0])
            raise Refused(f"{path.name}: row {row + 1}: {key} is {keys[key][row]:g}; the case has {wanted[row]:g} there")


def error_of(measure, path, table, answer_path, answer):
    """How far off a column is, by the norm of the case."""
    column, norm = measure["column"], measure["norm"]
    if norm == "ticks":
        if column not in table:
            raise Refused(f"{path.name}: column {column} is missing; there are {', '.join(table)}")
        return measure_ticks((path, answer_path), table[column], answer[column])
    found, wanted = numbers(path, table, column), numbers(answer_path, answer, column)
    if norm == "relative_l2":
        return relative_l2(found, wanted)
    if norm == "relative_l2_worst_load":
        loads = numbers(answer_path, answer, "load_depth_m")
        return max(relative_l2(found[loads == load], wanted[loads == load]) for load in np.unique(loads))
    raise Refused(f"cases.json: norm {norm!r} of {answer_path.stem} is none that this script knows")


def score_case(case, results, seconds):
    """What a solver made of one case."""
    path, answer_path = results / f"{case['name']}.csv", HERE / "answers" / f"{case['name']}.csv"
    told = {"case": case["name"], "kind": case["kind"], "state": "not given", "seconds": seconds, "measures": []}
    if not path.exists():
        return told
    try:
        table, answer = read_table(path), read_table(answer_path)
        check_keys(case["kind"], path, table, answer_path, answer)
        for measure in case["measures"]:
            error = error_of(measure, path, table, answer_path, answer)
            told["measures"].append({**measure, "error": error, "met": error <= measure["tolerance"]})
    except Refused as refused:
        return {**told, "state": "refused", "reason": str(refused), "measures": []}
    return {**told, "state": "met" if all(one["met"] for one in told["measures"]) else "not met"}


def read_times(results):
    """Seconds by case, if the solver tells them."""
    path = results / "times.csv"
    if not path.exists():
        return {}
    table = read_table(path)
    if "case" not in table:
        raise Refused(f"{path.name}: column case is missing; there are {', '.join(table)}")
    return dict(zip(table["case"], map(float, numbers(path, table, "seconds"))))


def score(results):
    """Every case, and how many are in which state."""
    cases = json.loads((HERE / "cases.json").read_text(encoding="utf-8"))["cases"]
    known = {case["name"] for case in cases}
    times = read_times(results)
    given = {path.stem for path in results.glob("*.csv")} - {"times"}
    for strange in sorted((given | set(times)) - known):
        raise Refused(f"{strange}: no case has this name; there are {', '.join(sorted(known))}")
    scores = [score_case(case, results, times.get(case["name"])) for case in cases]
    counts = {state: sum(one["state"] == state for one in scores) for state in ("met", "not met", "refused", "not given")}
    return {"cases": scores, "counts": counts}


def shown(measure):
    unit = " ticks" if measure["norm"] == "ticks" else ""
    sign = "<=" if measure["met"] else "> "
    return f"{measure['column']:<10} {measure['norm']:<22} {measure['error']:>9.2g} {sign} {measure['tolerance']:g}{unit}"


def show(told):
    for one in told["cases"]:
        seconds = "" if one["seconds"] is None else f"{one['seconds']:8.3f} s"
        lines = [shown(measure) for measure in one["measures"]] or [one.get("reason", "")]
        print(f"{one['case']:<27} {one['state']:<9} {seconds:>10}  {lines[0]}".rstrip())
        for line in lines[1:]:
            print(f"{'':<49} {line}")
    counts = told["counts"]
    print(
        f"{counts['met']} of {len(told['cases'])} cases met; {counts['not met']} not met, "
        f"{counts['refused']} refused, {counts['not given']} not given"
    )


def plain(value):
    """JSON has no infinity: null stands for an error without end."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def main():
    parser = argparse.ArgumentParser(description="Scores a solver's answers to the benchmark's cases.")
    parser.add_argument("results", type=pathlib.Path, help="folder with NAME.csv for each case, and times.csv if wished")
    parser.add_argument("--json", action="store_true", help="print the scores as JSON")
    arguments = parser.parse_args()
    if not arguments.results.is_dir():
        print(f"{arguments.results}: no such folder", file=sys.stderr)
        return 2
    try:
        told = score(arguments.results)
    except Refused as refused:
        print(refused, file=sys.stderr)
        return 2
    if arguments.json:
        print(json.dumps(plain(told), indent=1, allow_nan=False))
    else:
        show(told)
    counts = told["counts"]
    return 0 if counts["met"] and not counts["not met"] and not counts["refused"] else 1


if __name__ == "__main__":
    sys.exit(main())

"""Runs the attacks and prints the table: see tests/attack/run."""

import argparse
import importlib
import inspect
import os
import sys
import tempfile
import time
import traceback
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from town import ROOT, Programs, Template  # noqa: E402
from verdict import GotThrough, NotTried  # noqa: E402
from world import World  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(prog="tests/attack/run", description="Attacks a service and prints what was refused.")
    parser.add_argument("--binary", type=Path, help="web-admin, with stylet beside it")
    parser.add_argument("--slack", type=float, default=1.0, help="factor on every limit of time, for a busy or slow machine")
    parser.add_argument("--list", action="store_true", help="names the attacks and ends")
    parser.add_argument("names", nargs="*", metavar="NAME", help="families or attacks")
    return parser.parse_args()


def newest():
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    built = [target / profile / "web-admin" for profile in ("release", "debug")]
    built = [path for path in built if path.exists() and path.with_name("stylet").exists()]
    if not built:
        sys.exit("web-admin and stylet are not built: cargo build --workspace --bins, or name one by --binary")
    return max(built, key=lambda path: path.stat().st_mtime)


def attacks(names):
    """Family and function of every attack that is asked for, in the order of the files."""
    found = []
    for file in sorted((HERE / "attacks").glob("[a-z]*.py")):
        family = importlib.import_module(f"attacks.{file.stem}")
        for name, attack in vars(family).items():
            if name.startswith("attack_") and inspect.getmodule(attack) is family:
                found.append((file.stem, name.removeprefix("attack_"), attack))
    known = {name for family, attack, _ in found for name in (family, attack)}
    unknown = [name for name in names if name not in known]
    if unknown:
        sys.exit(f"{', '.join(unknown)}: no such family or attack; --list names them")
    return [one for one in found if not names or set(names) & {one[0], one[1]}]


def attempt(attack, world):
    """Outcome and what was seen."""
    try:
        return "refused", attack(world) or ""
    except GotThrough as error:
        return "GOT THROUGH", str(error)
    except NotTried as error:
        return "NOT TRIED", str(error)
    except Exception as error:  # noqa: BLE001: an attack that breaks has shown nothing
        traceback.print_exc()
        return "NOT TRIED", f"{type(error).__name__}: {error}"


def main():
    asked = arguments()
    chosen = attacks(asked.names)
    if asked.list:
        for family, name, attack in chosen:
            print(f"{family:12} {name:34} {first_line(attack)}")
        return 0
    binary = asked.binary.resolve() if asked.binary else newest()
    begun, rows = time.monotonic(), []
    with tempfile.TemporaryDirectory(prefix="stylet-attack-") as folder:
        programs = Programs(binary, folder)
        template = Template(programs)
        world = World(template, asked.slack)
        try:
            for family, name, attack in chosen:
                rows.append(one(world, (family, name, attack)))
        finally:
            world.close()
    show(rows, time.monotonic() - begun)
    return int(any(row["counts"] for row in rows))


def one(world, named):
    family, name, attack = named
    begun, before = time.monotonic(), world.grown_mb
    world.grown_mb = None
    outcome, seen = attempt(attack, world)
    world.end_attack()
    known = getattr(attack, "known", None)
    if known and outcome != "NOT TRIED":
        seen = f"{seen} [known: {known}]" if outcome != "refused" else f"{seen} [no longer lets through: take its mark away]"
        outcome = "known" if outcome != "refused" else outcome
    row = {"family": family, "name": name, "tried": first_line(attack), "outcome": outcome, "seen": seen}
    row.update(seconds=time.monotonic() - begun, memory=world.grown_mb, counts=outcome not in ("refused", "known"))
    world.grown_mb = before
    print(f"{outcome:12} {family}/{name} {row['seconds']:.1f} s: {' '.join(seen.split())[:400]}", flush=True)
    return row


def first_line(attack):
    return inspect.getdoc(attack).splitlines()[0]


def show(rows, seconds):
    print(f"\n| {'attack':46} | outcome     | time/s | memory/MB | what was tried; what was seen |")
    print(f"|{'-' * 48}|-------------|-------:|----------:|---|")
    for row in rows:
        memory = "" if row["memory"] is None else f"+{row['memory']:.0f}"
        words = " ".join(f"{row['tried']} – {row['seen']}".split())[:220].replace("|", "/")
        print(f"| {row['family'] + '/' + row['name']:46} | {row['outcome']:11} | {row['seconds']:6.1f} | {memory:>9} | {words} |")
    counts = {outcome: sum(row["outcome"] == outcome for row in rows) for outcome in ("refused", "known", "GOT THROUGH", "NOT TRIED")}
    print(f"\n{len(rows)} attacks in {seconds:.0f} s: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items() if n))


if __name__ == "__main__":
    sys.exit(main())

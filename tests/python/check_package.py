"""Holds the Python package against the commands, to the bit, and gives it what it must refuse.

    PYTHONPATH=target/wheel/site python tests/python/check_package.py PROGRAM FOLDER

PROGRAM is `stylet`, FOLDER an empty one. Prints how many numbers were compared and how many bad calls were refused.
"""

import csv
import json
import os
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import stylet

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
EXERCISE = ROOT / "curricula" / "lower-back-basics" / "1-feel-the-layers.toml"
OBLIQUE = ROOT / "curricula" / "lower-back-basics" / "5-oblique-approach.toml"
PROGRAM, FOLDER = sys.argv[1], Path(sys.argv[2])
SESSION = {"session_id": "01890a5d-ac96-774b-bcce-b302099a8057", "started_at": "2026-01-31T09:00:00Z"}
TABLES = {"samples": "samples", "events": "events", "tents": "tents", "energy": "energy"}

compared = 0


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == status, f"stylet {arguments}: {done.returncode}, {done.stderr}"
    return done.stdout


def check_same(what, ours, theirs):
    """The same bits; a zero has its sign."""
    global compared
    ours, theirs = np.ascontiguousarray(ours), np.ascontiguousarray(theirs)
    assert ours.shape == theirs.shape and ours.dtype == theirs.dtype, f"{what}: {ours.dtype}{ours.shape}, {theirs.dtype}{theirs.shape}"
    equal = ours == theirs if ours.dtype.kind == "U" else ours.view(np.uint8) == theirs.view(np.uint8)
    assert np.all(equal), f"{what}: not the same bits"
    compared += ours.size


def read_table(text):
    lines = text.splitlines()
    names = lines[0].split(",")
    rows = [line.split(",") for line in lines[1:]]
    return {name: [row[at] for row in rows] for at, name in enumerate(names)}


# --- the same numbers


def check_force():
    for scene in sorted((DATA / "force").glob("*.json")):
        track = scene.with_suffix(".csv")
        theirs = read_table(run("force", scene, "--trajectory", track))
        t, x = (np.array(theirs[name], dtype=float) for name in ("t_s", "x_m"))
        ours = stylet.force(scene, t, x)
        columns = {
            "t_s": ours.t_s, "x_m": ours.x_m, "v_m_per_s": ours.v_m_per_s, "F_n": ours.force_n, "F_tip_n": ours.tip_n,
            "F_rim_n": ours.rim_n, "F_viscous_n": ours.viscous_n, "F_friction_n": ours.friction_n,
            "F_cutting_n": ours.cutting_n, "depth_m": ours.depth_m,
        }  # fmt: skip
        assert [*columns, "events"] == list(theirs)
        for name, values in columns.items():
            check_same(f"{scene.name}: {name}", values, np.array(theirs[name], dtype=float))
        events = [""] * len(t)
        for row, _, _, contactor, boundary in ours.ruptures:
            events[row] += ("+" if events[row] else "") + f"{contactor}:{boundary}"
        assert events == theirs["events"], scene.name
        # A path, its text and what JSON makes of it are one scene; so are the ways to hold numbers.
        text = scene.read_text()
        for other in (str(scene), text, json.loads(text)):
            check_same("scene", stylet.force(other, t, x).force_n, ours.force_n)
        wide = np.zeros((len(t), 3))
        wide[:, 1] = x
        frozen = t.copy()
        frozen.flags.writeable = False
        for kind in (wide[:, 1], x.astype(">f8"), list(x), x[::-1][::-1]):
            check_same("trajectory", stylet.force(scene, frozen, kind).force_n, ours.force_n)
        whole = stylet.force(scene, np.arange(3), np.zeros(3, dtype=np.float32))
        assert whole.t_s.dtype == np.float64 and len(whole.ruptures) == 0


def check_field():
    for case in sorted((DATA / "field").glob("*.json")):
        for tolerance, model in ((0.01, "auto"), (0.001, "auto"), (0.05, "mass-spring")):
            met = model == "auto"
            with warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter("always")
                ours = stylet.Field(case, tolerance, model=model)
            assert [w.category for w in warned] == ([] if met else [stylet.ToleranceWarning])
            arguments = ["field", case, "--tolerance", tolerance, "--model", model, "--json"]
            theirs = json.loads(run(*arguments, status=0 if met else 1))
            for key in ("model", "reason", "unknowns", "bytes", "estimated_relative_error", "tolerance", "met"):
                assert getattr(ours, key) == theirs[key], f"{case.name}: {key}"
            solutions = theirs["solutions"]
            check_same(f"{case.name}: loads", ours.load_depths_m, np.array([s["depth_m"] for s in solutions]))
            for part in ("u_axial_m", "u_radial_m"):
                check_same(f"{case.name}: {part}", getattr(ours, part), np.array([s[part] for s in solutions]))


def export(path):
    folder = FOLDER / f"tables-{path.stem}"
    run("export", path, "--to", "csv", "--out", folder)
    tables = {}
    for file in folder.glob("*.csv"):
        with file.open(newline="") as opened:
            rows = list(csv.reader(opened))
        tables[file.stem] = {name: [row[at] for row in rows[1:]] for at, name in enumerate(rows[0])}
    return tables


def check_tables(path, recording):
    tables = export(path)
    for name, table in TABLES.items():
        ours, theirs = getattr(recording, name), tables.get(table, {})
        if not theirs:
            assert len(ours) == 0, f"{path.name}: {name} are in the recording alone"
            continue
        assert list(ours.dtype.names) == list(theirs), f"{path.name}: {name} have other columns: {ours.dtype.names}"
        for column, values in theirs.items():
            kind = ours.dtype[column]
            if kind.kind in "iub":
                numbers = np.array([-1 if value == "" else int(value) for value in values])
                check_same(f"{name}.{column}", ours[column].astype(np.int64), numbers.astype(np.int64))
            elif kind.kind == "U":
                assert ours[column].tolist() == values, f"{name}.{column}"
            else:
                check_same(f"{name}.{column}", ours[column], np.array(values, dtype=float).astype(kind))
    poses = recording.poses
    for at, column in enumerate(("position_x_m", "position_y_m", "position_z_m", "orientation_x", "orientation_w")):
        check_same(column, poses[:, 6 if at == 4 else at], recording.samples[column])
    assert np.shares_memory(poses, recording.samples)


def check_simulation():
    t = np.arange(0.0, 8.0, 0.01)
    x = -0.005 + 0.004 * t
    motion = FOLDER / "motion.csv"
    rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(t.tolist(), x.tolist()))
    motion.write_text("t_s,x_m\n" + rows)
    for at, (exercise, operator, seed, rate) in enumerate(
        [(EXERCISE, "novice", 3, 1000), (OBLIQUE, "expert", 5, 250), (EXERCISE, "constant:5", 0, 1000), (EXERCISE, motion, 2**64 - 1, 1000)]
    ):
        theirs, ours = FOLDER / f"theirs-{at}.mcap", FOLDER / f"ours-{at}.mcap"
        session = ["--session-id", SESSION["session_id"], "--started-at", SESSION["started_at"], "--trainee", "p-7"]
        run("simulate", exercise, "--operator", operator, "--seed", seed, "--tick-hz", rate, "--out", theirs, *session)
        made = stylet.simulate(exercise, operator, seed, tick_hz=rate, out=ours, trainee="p-7", **SESSION)
        assert ours.read_bytes() == theirs.read_bytes(), f"{operator}: another file; is the wheel of this revision? deploy/wheel --for-tests"
        read = stylet.read(theirs)
        assert made.session == read.session and read.session["trainee"] == "p-7" and read.session["seed"] == seed
        check_same("samples", made.samples.view(np.uint8), read.samples.view(np.uint8))
        check_tables(theirs, read)
        assert stylet.score(theirs) == made.score() == json.loads(run("score", theirs, "--json"))
        other = json.loads(run("score", theirs, "--exercise", OBLIQUE, "--json"))
        assert stylet.score(theirs, OBLIQUE) == read.score(OBLIQUE) == other
        assert stylet.verify(theirs) == json.loads(run("verify", theirs, "--json"))
        assert made.verify()["largest_deviation_n"] == 0
        assert read.attachments["exercise.toml"] == exercise.read_bytes()
    # The motion of the file, given as an array: along the axis, and as poses.
    along = stylet.simulate(EXERCISE, np.column_stack([t, x]), 2**64 - 1)
    check_same("motion", along.samples.view(np.uint8), stylet.read(FOLDER / "ours-3.mcap").samples.view(np.uint8))
    start = along.poses[0]
    steps = np.column_stack([t, np.full((len(t), 2), start[:2]), -x, np.full((len(t), 4), start[3:])])
    posed = stylet.simulate(EXERCISE, steps)
    assert len(posed) == len(along) and len(stylet.simulate(EXERCISE, steps[:, :4])) == len(along)
    assert along.session["device"] == "operator:array"


def check_old_recordings():
    for path in sorted((DATA / "recordings").glob("*.mcap")):
        check_tables(path, stylet.read(path))
        assert stylet.score(path) == json.loads(run("score", path, "--json"))
        assert stylet.verify(path) == json.loads(run("verify", path, "--json"))


def check_threads():
    with ThreadPoolExecutor(4) as threads:
        scores = list(threads.map(lambda seed: stylet.simulate(EXERCISE, "expert", seed).score(), [1, 2] * 4))
    assert scores[::2] == [scores[0]] * 4 and scores[1::2] == [scores[1]] * 4 and scores[0] != scores[1]


# --- what is refused

refused = 0


def check_refused(call, kind, *words):
    global refused
    try:
        call()
    except kind as error:
        assert type(error).__module__ != "pyo3_runtime", error
        missing = [word for word in words if word not in str(error)]
        assert not missing, f"{error!r} does not say {missing}"
        refused += 1
        return
    raise AssertionError(f"not refused: {words}")


def refuse_arrays():
    scene = DATA / "force" / "trocar.json"

    def push(t, x):
        return lambda: stylet.force(scene, t, x)

    check_refused(push([0, 1], [0]), stylet.StyletError, "x: 1 rows", "allowed: 2")
    check_refused(push([], []), stylet.StyletError, "t: no rows")
    check_refused(push([0, np.nan], [0, 0]), stylet.StyletError, "t[1]", "NaN", "finite")
    check_refused(push([0, 1], [0, np.inf]), stylet.StyletError, "x[1]", "inf")
    check_refused(push([0, 1, 2], [0, 0, 20]), stylet.StyletError, "x[2]", "20 m", "is the column in mm?")
    check_refused(push([0, 1, 1], [0, 0, 0]), stylet.StyletError, "t[2]", "times must increase")
    check_refused(push(np.zeros((2, 2)), [0, 0]), stylet.StyletError, "t: shape (2, 2)", "(n,)")
    check_refused(push(0.0, 0.0), stylet.StyletError, "t: shape ()")
    check_refused(push(["a"], [0]), TypeError, "t: dtype", "real numbers")
    check_refused(push([0, 1], [0, 1j]), TypeError, "x: dtype complex128")
    check_refused(push([None], [0]), TypeError, "t: dtype object")
    check_refused(push([True], [0]), TypeError, "t: dtype bool")
    check_refused(push(np.zeros(2, dtype=[("a", float)]), [0, 0]), TypeError, "t: dtype")
    for motion, words in (
        (np.zeros((3, 3)), "(3, 3)"), (np.zeros(4), "(4,)"), (np.zeros((0, 2)), "no rows"), (np.zeros((2, 2)), "times must increase"),
        ([[0, 0], [1, np.nan]], "motion[:, 1][1]"), ([[0, 0, 0, 0, 0, 0, 0, 0]], "has length 0"),
    ):  # fmt: skip
        check_refused(lambda: stylet.simulate(EXERCISE, motion), stylet.StyletError, words)


def refuse_arguments():
    check_refused(lambda: stylet.simulate(EXERCISE, "nobody"), stylet.StyletError, "operator = 'nobody'", "novice")
    check_refused(lambda: stylet.simulate(EXERCISE, "constant:0"), stylet.StyletError, "0.01 mm/s to 1000 mm/s")
    check_refused(lambda: stylet.simulate(EXERCISE, seed=-1), stylet.StyletError, "seed = -1")
    check_refused(lambda: stylet.simulate(EXERCISE, seed=2**64), stylet.StyletError, "2**64 - 1")
    check_refused(lambda: stylet.simulate(EXERCISE, seed=0.5), TypeError)
    check_refused(lambda: stylet.simulate(EXERCISE, tick_hz=99), stylet.StyletError, "tick_hz = 99 Hz", "100 Hz to 10000 Hz")
    check_refused(lambda: stylet.simulate(EXERCISE, session_id="x"), stylet.StyletError, "session_id = 'x'", "UUID")
    check_refused(lambda: stylet.simulate(EXERCISE, started_at="now"), stylet.StyletError, "started_at = 'now'", "RFC 3339")
    check_refused(lambda: stylet.simulate(EXERCISE, trainee="A Name"), stylet.StyletError, "trainee = 'A Name'", "pseudonym")
    case = DATA / "field" / "lower_back.json"
    for tolerance in (0, 2, float("nan")):
        check_refused(lambda: stylet.Field(case, tolerance), stylet.StyletError, "tolerance = ", "1e-6 to 1")
    check_refused(lambda: stylet.Field(case, model="best"), stylet.StyletError, "model = 'best'", "'mass-spring'")
    check_refused(lambda: stylet.Field(case, "small"), TypeError)
    check_refused(lambda: stylet.force({"layers": np.nan}, [0], [0]), stylet.StyletError, "scene:")
    check_refused(lambda: stylet.force({"layers": object()}, [0], [0]), TypeError, "object")
    check_refused(lambda: stylet.force(3, [0], [0]), TypeError)
    check_refused(lambda: stylet.force("{", [0], [0]), stylet.StyletError, "scene:1:1")
    loose = json.loads((DATA / "force" / "trocar.json").read_text())
    loose["layers"][1]["stiffness_n_per_m"] = -1
    check_refused(lambda: stylet.force(loose, [0], [0]), stylet.StyletError, "stiffness_n_per_m", "-1 N/m")
    loose = json.loads((DATA / "force" / "table_i.json").read_text())
    # Fat that holds to 2 N is tented 24 mm deep; when it gives way, muscle that holds to 12 N takes over with 7.8 N.
    loose["layers"][1]["tip_rupture_n"], loose["layers"][2]["tip_rupture_n"] = 2.0, 12.0
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        stylet.force(loose, [0], [0])
    assert warned and all(w.category is stylet.UnsoundSceneWarning for w in warned), "an unsound scene goes unsaid"


def refuse_files():
    gone, folder = FOLDER / "gone.mcap", FOLDER
    for call in (stylet.read, stylet.score, stylet.verify, stylet.simulate, lambda path: stylet.force(path, [0], [0]), stylet.Field):
        check_refused(lambda: call(gone), FileNotFoundError, str(gone))
        check_refused(lambda: call(folder), IsADirectoryError, str(folder))
        check_refused(lambda: call(5), TypeError)
        check_refused(lambda: call("a\0b"), (ValueError, OSError))
    check_refused(lambda: stylet.simulate(EXERCISE, "gone.csv"), FileNotFoundError, "gone.csv")
    check_refused(lambda: stylet.read(ROOT / "README.md"), stylet.StyletError, "README.md", "not a recording")
    check_refused(lambda: stylet.simulate(ROOT / "README.md"), stylet.StyletError, "README.md:")
    latin = FOLDER / "latin.json"
    latin.write_bytes(b"\xff{}")
    check_refused(lambda: stylet.Field(latin), stylet.StyletError, "byte 0", "UTF-8")
    endless = FOLDER / "endless.json"
    with endless.open("wb") as file:
        file.truncate(1 << 30)
    check_refused(lambda: stylet.Field(endless), stylet.StyletError, "larger than 16 MiB")


def check_saving():
    out = FOLDER / "saved.mcap"
    made = stylet.simulate(EXERCISE, "constant:10", out=out)
    first = out.read_bytes()
    check_refused(lambda: stylet.simulate(EXERCISE, "constant:10", out=out), FileExistsError, str(out))
    check_refused(lambda: made.save(out), FileExistsError)
    check_refused(lambda: stylet.read(out).save(out, overwrite=True), ValueError, "only a simulated recording")
    check_refused(lambda: made.save(FOLDER / "no" / "folder.mcap"), FileNotFoundError)
    assert out.read_bytes() == first
    stylet.simulate(EXERCISE, "constant:20", out=out, overwrite=True)
    assert out.read_bytes() != first and not list(FOLDER.glob(".saved*")), "a file of before, or a piece of one"
    assert out.stat().st_mode & 0o777 == 0o666 & ~read_umask()


def read_umask():
    umask = os.umask(0)
    os.umask(umask)
    return umask


def spoil_recordings():
    """Cut and changed files: read, or refused as such. Nothing else may happen."""
    whole = (DATA / "recordings" / "first-judging.mcap").read_bytes()
    random = np.random.default_rng(1)
    path = FOLDER / "spoiled.mcap"
    outcomes = {"read": 0, "refused": 0}

    def look(content):
        path.write_bytes(content)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                recording = stylet.read(path)
                for table in TABLES:
                    assert "t_s" in getattr(recording, table).dtype.names, "a table without rows has columns"
                assert recording.poses.shape == (len(recording), 7) and recording.session and recording.attachments
                repr(recording)
                recording.score()
            outcomes["read"] += 1
        except stylet.StyletError:
            outcomes["refused"] += 1

    for cut in np.linspace(0, len(whole) - 1, 60).astype(int):
        look(whole[:cut])
    for _ in range(120):
        content = bytearray(whole)
        for _ in range(random.integers(1, 4)):
            content[random.integers(len(content))] = random.integers(256)
        look(bytes(content))
    look(whole + b"more")
    assert outcomes["read"] > 10 and outcomes["refused"] > 10, outcomes
    cut = FOLDER / "cut.mcap"
    cut.write_bytes(whole[: len(whole) * 3 // 4])
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        recording = stylet.read(cut)
    assert not recording.complete and [w.category for w in warned] == [stylet.CutRecordingWarning]
    assert 0 < len(recording) < len(stylet.read(DATA / "recordings" / "first-judging.mcap"))
    return sum(outcomes.values())


def spoil_documents():
    random = np.random.default_rng(2)
    for path, call in (("force/trocar.json", lambda text: stylet.force(text, [0, 1], [0, 0.01])), ("field/lower_back.json", stylet.Field)):
        whole = (DATA / path).read_text()
        for _ in range(150):
            at = random.integers(1, len(whole))
            text = whole[:at] + random.choice(["", "-", "9", "e9", '"', "}", "[", "null", "é", "\0"]) + whole[at + random.integers(0, 3) :]
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    call(text)
            except stylet.StyletError:
                pass


def main():
    check_force()
    check_field()
    check_simulation()
    check_old_recordings()
    check_threads()
    refuse_arrays()
    refuse_arguments()
    refuse_files()
    check_saving()
    spoiled = spoil_recordings()
    spoil_documents()
    print(json.dumps({"compared": compared, "refused": refused, "spoiled": spoiled}))


if __name__ == "__main__":
    main()

"""Recordings of some kilobytes that unpack to gigabytes, or take minutes: each is refused in little memory and little time, and an honest
visitor does not notice. The same bombs lie in tests/fuzz/bombs for whoever fuzzes the reader."""

import hashlib
import shutil
import struct
import subprocess
import time
import zlib

import tape as tapes
from tape import attachment, by_hand, channel_of, chunk, message, metadata, record
from town import ROOT
from verdict import alone, honest, refuse, status

# Most memory that reading one may add to the service, in MB, and how long its uploader may wait, in s.
MOST_MB, MOST_S = 700, 10
# What a reader may skip: these may be taken in, as cheaply as the others are refused.
SKIPPED = {"metadata in number", "messages of no topic", "channels and schemas", "a chunk in chunks"}
EVENT_RUPTURE = bytes.fromhex("0900000000000000401002")


def event(**fields):
    """An event by hand: its time in s, its kind, its text."""
    data = struct.pack("<Bd", 0x09, fields.get("t_s", 1.0)) + bytes([0x10, fields.get("kind", 7)])
    words = fields.get("text", b"")
    return data + (bytes([0x52]) + varint(len(words)) + words if words else b"")


def varint(number):
    packed = bytearray()
    while number >= 128:
        packed.append(number & 127 | 128)
        number >>= 7
    return bytes([*packed, number])


def tents(count, numbers):
    """Tents of zeros: a packed list of floats each."""
    zeros = bytes(4 * numbers)
    return b"".join(struct.pack("<Bd", 0x09, float(n)) + b"\x12" + varint(len(zeros)) + zeros for n in range(count))


def bombs(base, small=False):
    """Every kind, by name, made from an honest recording; small ones are as bad in what they are, and fewer."""
    tent, events, sample = (channel_of(base, topic) for topic in ("/tissue/tent", "/events", "/needle/sample"))

    def made(*records):
        # Each is an attempt of its own, for one may be taken in where it is cheap.
        return by_hand(base if small else base.another(), *records)

    times, attached = (10, 500) if small else (100, 100_000)
    floats = bytes(4 * 2_000_000)
    large = b"".join(message(tent, struct.pack("<Bd", 0x09, float(n)) + b"\x12" + varint(len(floats)) + floats) for n in range(8))
    yield "tents", made(*[chunk(large)] * times)
    words = chunk(b"".join(message(events, event(text=b" " * 4000)) for _ in range(10_000)))
    yield "event texts", made(*[words] * times)
    yield "one long text", made(chunk(message(events, event(text=bytes(b" " * 60_000_000)))))
    yield "attachments in chunks", made(*[chunk(attachment("mesh.stl", bytes(50_000_000)))] * times)
    yield "attachments in number", made(*[attachment(f"{n}", b"") for n in range(attached)])
    if not small:
        yield "an attachment's name", made(attachment("n" * 10_000_000, b""))
    yield "empty messages", made(*[chunk(message(sample, b"") * 1_000_000)] * 8)
    yield "messages of no topic", made(*[chunk(message(999, b"") * 1_000_000)] * 8)
    yield "ruptures", made(*[chunk(message(events, EVENT_RUPTURE + b"\x18\x00") * 390_000)] * 10)
    if not small:
        yield "metadata in number", made(chunk(b"".join(metadata(f"m{n % 10}", {"k": "v" * 50}) for n in range(500_000))))
    yield "metadata of zeros", made(*[chunk(metadata("x", {"k": "\0" * 40_000_000}))] * times)
    count = 20_000 if small else 200_000
    yield "channels and schemas", made(chunk(b"".join(channel(n % 65_000 + 100, 1, "t" * 1000) for n in range(count))))
    yield "a declared size of 2^60", made(chunk(b"\0" * 1000, declared=1 << 60))
    yield "a record of 2^62 bytes", made(record(tapes.MESSAGE, b"\0" * 100, length=1 << 62))
    inner = message(tent, tents(1, 10_000_000))
    yield "a chunk in chunks", made(chunk(chunk(chunk(chunk(inner)))))
    yield "zeros alone", made(*[chunk(bytes(100_000_000))] * (4 if small else 40))


def channel(number, schema, topic):
    return record(tapes.CHANNEL, struct.pack("<HH", number, schema) + tapes.text(topic) + tapes.text("protobuf") + tapes.table({}))


def rejected(world, name, bomb, limits=(MOST_MB, MOST_S)):
    """Uploads it as ada, while ben reads pages; what it cost."""
    town = world.town
    with world.watch(town, "ben") as watched:
        (answer, took) = world.within(limits[1], lambda: town.program("ada").upload(bomb), f"{name}, {len(bomb)} bytes,")
    refuse(answer.status in ((201, 413, 422) if name in SKIPPED else (413, 422)), f"{name}: {answer}")
    refuse(town.service.is_running, f"{name}: the service is gone")
    return took, world.hold(watched, limits[0])


@alone
def attack_unpacking(world):
    """zstd bombs of every kind, uploaded one by one; limits: 700 MB, 10 s each, an honest page 1 s"""
    base, worst, slowest = world.recording(), 0.0, 0.0
    honest(world.upload("ada", base).status == 201, "an honest one is taken")
    base = base.another()
    for name, bomb in bombs(base):
        took, _ = rejected(world, name, bomb)
        worst, slowest = max(worst, world.grown_mb), max(slowest, took)
    return f"16 kinds; at most {slowest:.1f} s, +{worst:.0f} MB"


@alone
def attack_many_at_once(world):
    """twelve bombs at once by four people; limit: 1 600 MB, for two are read at once, an honest page 1 s"""
    import threading

    town, base = world.own_town(), world.recording()
    bomb = dict(bombs_of(base, "tents", "event texts"))
    answers = []

    def send(name, kind):
        answers.append(town.program(name).upload(bomb[kind]).status)

    threads = [threading.Thread(target=send, args=(name, kind)) for name in ("ada", "eve", "zoe", "sam") for kind in [*bomb, "tents"]]
    with world.watch(town, "ben") as watched:
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
    refuse(set(answers) <= {422, 429, 503, 507}, f"answers {answers}")
    honest(world.upload("ada", base.another(), town).status == 201, "afterwards an honest one is taken")
    return world.hold(watched, 1600)


def bombs_of(base, *names):
    for name, bomb in bombs(base):
        if name in names:
            yield name, bomb
        if name == names[-1]:
            return


def attack_bomb_at_every_start(world):
    """a bomb whose last byte arrives while the service is killed: it must not be taken in again at every start"""
    town, base = world.own_town(), world.recording()
    name, bomb = next(bombs_of(base, "tents"))
    program = town.program("ada")
    path = program.tus("POST", upload_length=len(bomb)).header("location")
    honest(program.tus("PATCH", path, bomb[:-1], upload_offset=0).status == 204, "all but a byte arrives")
    for _ in range(3):
        file = next((town.data / "recordings/.uploads").glob("*.tus"), None)
        if file is None:
            break
        file.write_bytes(bomb)
        with_write(town, "UPDATE uploads SET received = length")
        town.service.restart()
        honest(town.stranger().get("/readyz").status == 200, "it starts")
    refuse(town.service.is_running, "it is gone")
    honest(world.upload("ada", base.another(), town).status == 201, "an honest one is taken")
    # A death of the service condemns nothing: the helper looks at it once it is left to.
    for _ in range(300):
        stands = program.tus("HEAD", path).status
        if stands in (404, 410, 424):
            return f"three starts, the upload is answered {stands}"
        time.sleep(0.1)
    refuse(False, f"the bomb stands as {stands}")


def with_write(town, statement):
    import sqlite3

    connection = sqlite3.connect(town.data / "stylet.db", timeout=30)
    connection.execute(statement)
    connection.commit()
    connection.close()


def attack_values_out_of_range(world):
    """events at NaN, infinity and −1 s, samples out of order, a device's name of 10 MB, a million layers, rates of 0 and inf"""
    base = world.recording()
    events = channel_of(base, "/events")
    honest(world.upload("ada", base.another()).status == 201, "as it is, it is taken")
    tried = [by_hand(base.another(), chunk(message(events, event(t_s=at)))) for at in (float("nan"), float("inf"), -1.0, 1e300)]
    session = {"device": "d" * 10_000_000}
    others = [session, {"patient_thickness_mm": "[" + ",".join(["1"] * 1_000_000) + "]"}, {"tick_hz": "0"}, {"tick_hz": "inf"}, {"tick_hz": "nan"},
              {"seed": "-1"}, {"seed": "9" * 400}, {"exercise_id": "x\ny"}, {"trainee": "t" * 5000}, {"session_id": "1"}, {"exercise_sha256": "0"},
              {"device_max_force_n": "nan"}, {"law": "99"}, {"started_at": "yesterday"}]
    tried += [by_hand(base.another(), session=other) for other in others]
    backwards = base.another().fresh()
    samples = [one for one in backwards.messages if one[0] == "/needle/sample"]
    samples[10][2], samples[20][2] = samples[20][2], samples[10][2]
    tried.append(backwards.write())
    for bytes_ in tried:
        status(world.town.program("ada").upload(bytes_), 422, 413)
    return f"{len(tried)} recordings 422"


def attack_bombs_at_the_program(world):
    """every bomb given to stylet score, verify, recover and export, with 3 GB of address space beyond its own"""
    import resource

    base, folder = world.recording(), world.programs.folder
    good, bad = folder / "good.mcap", folder / "bomb.mcap"
    good.write_bytes(base.write())
    honest(world.programs.stylet("score", good, check=False).returncode == 0, "an honest one is scored")
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))  # noqa: E731
    for name, bomb in bombs(base):
        if name in ("attachments in chunks", "metadata of zeros"):
            continue
        bad.write_bytes(bomb)
        for command in ("score", "verify"):
            done = subprocess.run([world.programs.stylet_path, command, bad], capture_output=True, text=True, preexec_fn=limit, timeout=120 * world.slack)
            refuse((name in SKIPPED or done.returncode in (1, 2)) and done.returncode in (0, 1, 2) and "panicked" not in done.stderr, f"{command} of {name}: {done.returncode} {done.stderr[-200:]}")
    return "ended with a reason, none panicked"


@alone
def attack_costly_scene_in_a_recording(world):
    """a recording whose own scene takes minutes to solve, then an honest one behind it; limit: the honest one scored in 60 s"""
    town, base = world.own_town(), world.recording()
    scene = costly_scene(base.document("scene.toml").decode()).encode()
    costly = base.another(scene_sha256=hashlib.sha256(scene).hexdigest()).attach("scene.toml", scene)
    taken = world.upload("eve", costly, town)
    refuse(taken.status in (201, 422), f"the costly one: {taken}")
    tape, seconds = world.recording(), 60 * world.slack
    honest(world.upload("ada", tape, town).status == 201, "the honest one is taken")
    with world.watch(town, "ben") as watched:
        scored = wait_at_most(town, tape.session_id, seconds)
    said = world.hold(watched)
    refuse(scored, f"the honest one behind it is not scored after {seconds:g} s; {said}")
    return f"{taken.status}; the honest one is scored; {said}"


def wait_at_most(town, session, seconds):
    try:
        return town.wait_scored(session, seconds)
    except RuntimeError:
        return None


def costly_scene(text, model="volumetric"):
    """The same scene, solved as finely as it may be asked for: the table may be there or not."""
    finest = f'model = "{model}"\ntolerance = 0.000001\ncoupling = "{"field" if model == "axisymmetric" else "none"}"\n'
    return text.replace("[tissue]\n", f"[tissue]\n{finest}", 1) if "[tissue]" in text else f"{text}\n[tissue]\n{finest}"


def attack_committed_bombs(world):
    """the bombs that lie beside the fuzz targets, uploaded"""
    folder = ROOT / "tests/fuzz/bombs/recording"
    files = sorted(folder.glob("*")) if folder.is_dir() else []
    honest(files, "there are bombs in tests/fuzz/bombs/recording")
    for file in files:
        answer = world.town.program("ada").upload(file.read_bytes())
        cheap = file.name.replace("-", " ") in SKIPPED | {"metadata of zeros"}
        refuse(answer.status in ((201, 409, 413, 422) if cheap else (413, 422)), f"{file.name}: {answer}")
    honest(shutil.disk_usage(world.town.data).free > 0, "there is room")
    return f"{len(files)} refused"


@alone
def attack_workbook_and_logo(world):
    """a workbook of 6 kB that asks for 80 GB, and logos of 16 megapixels, at once; limits: 100 MB, an honest page 1 s"""
    town = world.own_town("--judge-mb", "600")
    head = town.browser("head")
    roster = b"name,email\nNew,new@example.org\n"
    send = lambda content: head.attach("/people/roster", {"cohort": "Spring"}, "file", content, page="/people/roster")
    honest(send(roster).status in (200, 303), f"a roster is shown: {send(roster)}")
    bomb = (ROOT / "web-admin/tests/data/rosters/fonts.xlsx").read_bytes()
    with world.watch(town, "teacher") as watched:
        got = [send(bomb).status for _ in range(3)]
        got += [head.attach("/admin/settings/logo", {}, "logo", wide_png(), page="/admin/settings").status for _ in range(3)]
    refuse(town.service.is_running and set(got) <= {303, 422, 503}, f"answers {got}")
    return f"{got}; {world.hold(watched, 100)}"


def wide_png(side=4000):
    """A grey picture that packs well."""
    def block(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = zlib.compress(b"\0" * (side + 1) * side, 9)
    header = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + block(b"IHDR", header) + block(b"IDAT", rows) + block(b"IEND", b"")

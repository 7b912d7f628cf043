"""Disks that fill, bits that flip, services that die or are started twice, files that are lost: what was acknowledged stays."""

import base64
import hashlib
import random
import shutil
import signal
import socket
import sqlite3
import stat
import subprocess
import time

from town import ROOT, Service
from verdict import honest, refuse, status
from visitor import CutOff


def digest(data):
    return {"Content-Digest": f"sha-256=:{base64.b64encode(hashlib.sha256(data).digest()).decode()}:"}


def flipped(data, at):
    return data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :]


def attack_flipped_bits_with_a_digest(world):
    """a recording with a flipped bit, sent plainly with its Content-Digest and in pieces with their checksums"""
    data, program = world.recording().write(), world.town.program("ada")
    for at in (0, 9, len(data) // 3, len(data) // 2, len(data) - 1):
        status(program.upload(flipped(data, at), digest(data)), 422)
    path = program.tus("POST", upload_length=len(data)).header("location")
    sha = "sha256 " + base64.b64encode(hashlib.sha256(data).digest()).decode()
    status(program.tus("PATCH", path, flipped(data, 500), upload_offset=0, upload_checksum=sha), 460)
    honest(program.tus("HEAD", path).header("upload-offset") == "0", "nothing of it has arrived")
    honest(program.tus("PATCH", path, data, upload_offset=0, upload_checksum=sha).status == 204, "as it was it is taken")
    return "422, and 460 in pieces"


def attack_flipped_bits_without_a_digest(world):
    """sixty recordings with a bit flipped somewhere, sent plainly without a digest: the file's own checksums"""
    out = world.programs.folder / "flip.mcap"
    world.programs.stylet("simulate", world.template.exercise, "--operator", "expert", "--seed", 99, "--tick-hz", "200", "--force", "--out", out)
    data, draw, taken = out.read_bytes(), random.Random(7), []
    program = world.town.program("eve")
    for _ in range(60):
        at = draw.randrange(8, len(data))
        answer = program.upload(flipped(data, at))
        if answer.status in (200, 201):
            taken.append((at, answer.json.get("complete"), answer.status))
    honest(program.upload(data).status in (200, 201, 409), "as it was it is taken")
    within = [one for one in taken if one[1]]
    refuse(not within, f"{len(within)} of 60 taken as whole: bytes {[one[0] for one in within]} of {len(data)}")
    return f"{60 - len(taken)} refused, {len(taken)} kept as damaged behind their data"


def failing_disk(world):
    """A town whose disk fails on demand, and its switch."""
    library = world.programs.folder / "failing_disk.so"
    if not library.exists():
        source = ROOT / "web-admin/tests/main/support/failing_disk.c"
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, source], check=True)
    control = world.programs.folder / f"fault-{time.monotonic_ns()}"
    town = world.own_town(LD_PRELOAD=str(library), STYLET_FAILING_DISK=str(control))

    def switch(fault=None):
        if fault:
            part = control.with_suffix(".part")
            part.write_text(fault)
            part.rename(control)
        else:
            control.unlink(missing_ok=True)

    return town, switch


def attack_full_disk_under_the_database(world):
    """ENOSPC and EIO at the database while people upload and sign in; then there is room again"""
    town, switch = failing_disk(world)
    tape = world.recording()
    honest(town.browser("ben").get("/account").status == 200, "it serves")
    for code, expected in (("28 stylet.db", 507), ("5 stylet.db", 500)):
        switch(code)
        answer = world.upload("ada", tape.another(), town)
        status(answer, expected)
        refuse(town.browser("ben").get("/account").status == 200, "pages are not read")
        switch()
        for _ in range(50):
            answer = world.upload("ada", world.recording(), town)
            if answer.status == 201:
                break
            time.sleep(0.2)
        refuse(answer.status == 201, f"with room again: {answer}")
        refuse(town.stranger().sign_in("zoe@example.org").status == 303, "nobody signs in")
    return "507 and 500 while it lasts, 201 right after"


def attack_full_disk_under_a_piece(world):
    """ENOSPC in a piece of an upload without a checksum: no byte may be acknowledged that is not on the disk"""
    town, switch = failing_disk(world)
    data, program = world.recording().write(), town.program("ada")
    third = len(data) // 3
    path = program.tus("POST", upload_length=len(data)).header("location")
    honest(program.tus("PATCH", path, data[:third], upload_offset=0).status == 204, "a piece arrives")
    for code, expected in (("28 .tus", 507), ("5 .tus", 500)):
        switch(code)
        status(program.tus("PATCH", path, data[third : 2 * third], upload_offset=third), expected)
        switch()
        offset = program.tus("HEAD", path).header("upload-offset")
        refuse(offset == str(third), f"{offset} bytes acknowledged, {third} are there")
    done = program.tus("PATCH", path, data[third:], upload_offset=third)
    honest(done.status == 204 and done.header("stylet-session"), f"with room again it is ended: {done}")
    kept = program.get(f"/api/v1/sessions/{done.header('stylet-session')}/recording").body
    refuse(kept == data, "it is not what was sent")
    return "507 and 500, back to what was received, then whole"


def attack_offsets_out_of_place(world):
    """pieces before, behind and beyond what arrived, negative and huge lengths, two who write at once"""
    data, program = world.recording().write(), world.town.program("ada")
    for length in ("-1", "x", "18446744073709551616", "1e3", ""):
        status(program.tus("POST", upload_length=length), 400, 413, 429)
    path = program.tus("POST", upload_length=len(data)).header("location")
    program.tus("PATCH", path, data[:1000], upload_offset=0)
    for offset in (0, 999, 1001, len(data), -1, "x"):
        status(program.tus("PATCH", path, data[1000:2000], upload_offset=offset), 400, 409)
    status(program.tus("PATCH", path, data[1000:] + b"more", upload_offset=1000), 400, 413, 422)
    standing = int(program.tus("HEAD", path).header("upload-offset"))
    done = program.tus("PATCH", path, data[standing:], upload_offset=standing)
    honest(done.status == 204 and done.header("stylet-session"), f"in its place it is taken: {done}")
    return "400, 409 and 413"


def attack_half_dead_connection(world):
    """a piece whose sender disappears in the middle, then its honest owner goes on; limit: 35 s, for our client waits 40"""
    town = world.own_town()
    data, program = world.recording().write(), town.program("ada")
    path = program.tus("POST", upload_length=len(data)).header("location")
    one = socket.create_connection(town.service.place)
    head = f"PATCH {path} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {program.token}\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: 0\r\n"
    head += f"Content-Type: application/offset+octet-stream\r\nContent-Length: {len(data)}\r\n\r\n"
    one.sendall(head.encode() + data[:5000])
    time.sleep(0.5)

    def go_on():
        for _ in range(400):
            standing = program.tus("HEAD", path)
            if standing.status == 200:
                at = int(standing.header("upload-offset"))
                done = program.tus("PATCH", path, data[at:], upload_offset=at)
                if done.status == 204:
                    return done
            time.sleep(0.1)
        return None

    done, took = world.within(35, go_on, "its owner's upload")
    one.close()
    honest(done and done.header("stylet-session"), "it is ended")
    return f"its owner ends it after {took:.1f} s"


def attack_kills_while_uploading(world):
    """twelve kills of the service while three people upload; what was acknowledged must be there, hashed right, scored once"""
    town, draw, acknowledged = world.own_town(), random.Random(3), {}
    base = [world.recording() for _ in range(3)]
    for round_ in range(12):
        for name, tape in zip(("ada", "ben", "eve"), base, strict=True):
            data = tape.another().write()
            try:
                answer = town.program(name).upload(data)
                if answer.status == 201:
                    acknowledged[answer.json["session_id"]] = hashlib.sha256(data).hexdigest()
            except CutOff:
                pass
            if name == ("ada", "ben", "eve")[round_ % 3]:
                time.sleep(draw.random() * 0.2)
                town.service.restart()
    honest(len(acknowledged) >= 12, f"only {len(acknowledged)} were acknowledged")
    head = town.program("head")
    lost = [one for one, sha in acknowledged.items() if hashlib.sha256(head.get(f"/api/v1/sessions/{one}/recording").body).hexdigest() != sha]
    refuse(not lost, f"{len(lost)} of {len(acknowledged)} are lost")
    for session in acknowledged:
        town.wait_scored(session)
    twice = town.one("SELECT count(*) FROM (SELECT 1 FROM scores GROUP BY session_id HAVING count(*) > 1)")
    town.service.stop()
    verified = world.programs.run("verify", "--data-dir", town.data, check=False)
    refuse(verified.returncode == 0 and twice == 0, f"{twice} scored twice; {verified.stdout[-300:]}")
    return f"{len(acknowledged)} of {len(acknowledged)} acknowledged attempts are there and scored once"


def attack_two_services(world):
    """a second service, a restore and a migration on the folder of one that runs"""
    town = world.own_town()
    for words in (("serve", "--listen", "127.0.0.1:0"), ("restore", "nothing.tar")):
        done = world.programs.run(*words, "--data-dir", town.data, check=False, timeout=60)
        refuse(done.returncode != 0 and str(town.service.child.pid) in done.stdout + done.stderr, f"{words}: {done}")
    town.service.stop(signal.SIGKILL)
    town.service.start()
    honest(town.stranger().get("/readyz").status == 200, "after it was killed another starts")
    return "refused with the process that holds the folder"


def attack_lost_database(world):
    """the database deleted, emptied or half restored beside recordings: no empty school may be served"""
    town = world.own_town()
    world.scored("ada", town)
    town.service.stop()
    database = town.data / "stylet.db"
    kept = town.data / "kept.db"
    shutil.copy(database, kept)
    for empty in (False, True):
        for path in town.data.glob("stylet.db*"):
            path.unlink()
        if empty:
            database.write_bytes(b"")
        done = world.programs.run("serve", "--listen", "127.0.0.1:0", "--data-dir", town.data, check=False, timeout=60)
        refuse(done.returncode != 0 and "contains recordings" in done.stderr + done.stdout, f"{done}")
    database.unlink(missing_ok=True)
    kept.rename(database)
    town.service = Service(world.programs, town.data)
    honest(town.stranger().get("/readyz").status == 200, "with its database it is served")
    return "refused both times"


def attack_history_rewritten(world):
    """rows of scores and of the audit log changed or cut, triggers dropped, a recording exchanged, deleted, added: verify"""
    town = world.own_town()
    session = world.scored("ada", town)
    world.scored("ben", town)
    town.service.stop()
    verify = lambda *more: world.programs.run("verify", "--data-dir", town.data, *more, check=False)  # noqa: E731
    clean = verify()
    honest(clean.returncode == 0, f"it is clean before: {clean.stdout}")
    head = clean.stdout.strip().rsplit(" ", 1)[-1]
    database, kept = town.data / "stylet.db", town.data.with_suffix(".kept")
    shutil.copytree(town.data, kept)
    file = next((town.data / "recordings").rglob("*.mcap"))
    relative = file.relative_to(town.data)
    triggers = [row[0] for row in sqlite3.connect(kept / "stylet.db").execute("SELECT name FROM sqlite_master WHERE type = 'trigger'")]
    cases = {f"DROP TRIGGER {name}": () for name in triggers}
    protected = "; ".join(cases)
    cases = {f"DROP TRIGGER {triggers[0]}": (), f"DROP TRIGGER {triggers[-1]}": ()}
    restored = {row[0]: row[1] for row in sqlite3.connect(kept / "stylet.db").execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'")}
    again = ";".join(restored.values())
    cases |= {
        f"{protected}; UPDATE scores SET score = 99; {again}": (),
        f"{protected}; UPDATE audit_log SET details = '{{}}' WHERE seq = (SELECT max(seq) - 1 FROM audit_log); {again}": (),
        f"{protected}; DELETE FROM audit_log WHERE seq = (SELECT max(seq) FROM audit_log); {again}": ("--expect-head", head),
    }
    for statement, more in cases.items():
        connection = sqlite3.connect(database)
        connection.executescript(statement)
        connection.close()
        found = verify(*more)
        refuse(found.returncode == 1, f"{statement[:40]}… {statement[len(protected):][:80]}: {found.stdout[-200:]}")
        put_back(town.data, kept)
    for change in (lambda path: path.write_bytes(flipped(path.read_bytes(), 100)), lambda path: path.unlink(),
                   lambda path: shutil.copy(path, path.with_name("00000000-0000-4000-8000-000000000001.mcap"))):
        change(town.data / relative)
        found = verify()
        refuse(found.returncode == 1, f"a changed file: {found.stdout}")
        put_back(town.data, kept)
    shutil.rmtree(kept)
    honest(session, "a session")
    return f"{len(cases) + 3} changes found"


def put_back(data, kept):
    shutil.rmtree(data)
    shutil.copytree(kept, data)


def attack_files_for_everybody(world):
    """modes of the data folder, the database, recordings, letters, the key and a backup"""
    town = world.own_town()
    world.scored("ada", town)
    fresh, backup = world.programs.folder / "fresh", world.programs.folder / "modes.tar"
    service = Service(world.programs, fresh)
    service.stop()
    backup.unlink(missing_ok=True)
    world.programs.run("backup", "--to", backup, "--data-dir", town.data)
    found = [path for path in [fresh, *fresh.rglob("*"), *(town.data / "recordings").rglob("*.mcap"), backup] if stat.S_IMODE(path.stat().st_mode) & 0o077]
    refuse(not found, f"others may read {found}")
    honest(sum(1 for _ in fresh.rglob("*")) >= 2, "there are files")
    return "0700 and 0600"


def attack_erased_person_remains(world):
    """name and address of an erased person in the database's pages, the letters and the logs"""
    town = world.own_town()
    head = town.browser("head")
    made = head.press("/people", {"name": "Quillfeather Zebulon", "email": "quillfeather@example.org", "role": "trainee"})
    honest(made.status == 303, f"a person is added: {made}")
    person = town.person("quillfeather".replace("@example.org", ""))
    head.press(f"/people/{person}/mail-link")
    folder = town.data / "mail"
    for _ in range(100):
        if folder.is_dir() and any(folder.iterdir()):
            break
        time.sleep(0.2)
    holding = lambda: [path for path in town.data.rglob("*") if path.is_file() and b"uillfeather" in path.read_bytes().lower()]  # noqa: E731
    honest(holding(), "she is there before")
    erased = head.press(f"/people/{person}/erase", {"confirm": "quillfeather@example.org"})
    honest(erased.status == 303, f"she is erased: {erased}")
    town.service.stop()
    refuse(not holding(), f"her name is in {[path.name for path in holding()]}")
    return "in no file of the data folder"

"""A result is worth what it can prove."""

import hashlib
import re
import shutil
import sqlite3

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

import tape as tapes
from verdict import honest, refuse, status
from visitor import between


def certificate(town, name):
    return town.browser(name).press(f"/trainees/{town.person(name)}/certificates/one-step")


def badge(town, name, whose):
    return town.browser(name).get(f"/trainees/{town.person(whose)}/certificates/one-step/badge.json")


def needs(town, needed):
    answer = town.browser("head").press("/admin/certificate-needs", {"needed": needed})
    honest(answer.status == 303, f"the school says what a certificate needs: {answer}")


def forged(tape):
    """The same attempt with an exercise in which everything is passed."""
    document = re.sub(rb"(?m)^pass_mark = .*$", b"pass_mark = 0", tape.document("exercise.toml"))
    other = tape.another(exercise_sha256=hashlib.sha256(document).hexdigest())
    return other.attach("exercise.toml", document)


def pair(town, key):
    """Joins a station to North; its id and its program."""
    code = between(town.browser("head").press("/admin/pairing-codes", page="/admin").text, 'code-to-type">', "<")
    public = key.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw).hex()
    name = f"lab {town.one('SELECT count(*) FROM api_tokens')}"
    joined = town.stranger().tell("/api/v1/stations/pair", {"code": code, "name": name, "public_key": public})
    honest(joined.status == 201, f"a station joins: {joined}")
    return joined.json["station_id"]


def attack_forged_mastery(world):
    """seven passes at an exercise with the school's id and a pass mark of 0, then its certificate"""
    town = world.own_town()
    needs(town, "nothing")
    for _ in range(7):
        tape = forged(world.expert())
        answer = world.upload("eve", tape, town)
        refuse(answer.json.get("uncounted") == "unpublished", f"it counts: {answer}")
        town.wait_scored(tape.session_id)
        told = town.program("eve").get(f"/api/v1/sessions/{tape.session_id}/score").json
        honest(told["passed"], f"its own document lets it pass: {told}")
    refused = certificate(town, "eve")
    status(refused, 409)
    world.scored("ada", town, world.expert())
    honest(certificate(town, "ada").status == 200, "one honest pass gives the certificate")
    return "kept as unpublished, certificate 409"


def attack_replaced_exercise(world):
    """a pass at an exercise that the school has replaced by a harder one, and then the certificate"""
    town = world.own_town()
    needs(town, "nothing")
    settings = {"name": "North", "time_zone": "UTC", "letter_language": "en", "replaced_grace_days": "0"}
    honest(town.browser("head").press("/admin/settings", settings, page="/admin/settings").status == 303, "no grace")
    folder = town.programs.folder / f"harder-{town.data.name}"
    shutil.copytree(town.template.exercise.parent.parent, folder)
    harder = folder / "course/only.toml"
    harder.write_text(re.sub(r"(?m)^pass_mark = .*$", "pass_mark = 41", harder.read_text()))
    town.service.stop()
    town.programs.run("curricula", "import", folder, "--school", "North", "--data-dir", town.data)
    with sqlite3.connect(town.data / "stylet.db") as database:
        database.execute("UPDATE replaced_revisions SET replaced_at = replaced_at - 3600000000")
    database.close()
    town.service.start()
    town.signed_in = {}
    old = world.upload("ada", world.expert(), town)
    refuse(old.json.get("uncounted") == "unpublished", f"the old one counts: {old}")
    status(certificate(town, "ada"), 409)
    world.scored("ada", town, world.expert(harder))
    honest(certificate(town, "ada").status == 200, "a pass at the new one gives the certificate")
    return "kept as uncounted, certificate 409"


def attack_documents_that_are_not_their_hash(world):
    """the published exercise's hash in the metadata, another document in the attachment"""
    tape = world.recording()
    honest(world.upload("ada", tape.another()).status == 201, "as it is, it is taken")
    document = re.sub(rb"(?m)^pass_mark = .*$", b"pass_mark = 0", tape.document("exercise.toml"))
    answer = world.upload("ada", tape.another().attach("exercise.toml", document))
    return f"{status(answer, 422)}: {answer.json.get('detail', '')[:100]}"


def attack_exercise_under_another_name(world):
    """the documents of an easy exercise under the id of a hard one"""
    tape = world.recording(exercise_id="reach-the-muscle")
    answer = world.upload("ada", tape)
    if answer.status == 201:
        refuse(answer.json.get("uncounted") == "unpublished", f"it counts: {answer}")
        return "kept as unpublished"
    return str(status(answer, 422))


def attack_recording_of_somebody_else(world):
    """a recording whose metadata name another trainee, under a new id and date"""
    ada = world.town.template.pseudonyms["ada"]
    tape = world.recording(trainee=ada)
    stolen = tape.another(started_at=tapes.ago(hours=2))
    answer = world.upload("eve", stolen)
    honest(world.upload("ada", tape).status == 201, "whose it is may bring it")
    return f"{status(answer, 409)}: {answer.json['detail'][:80]}"


def attack_relabelled_recording(world):
    """somebody else's motion with the pseudonym, the id and the date changed, packed anew"""
    ada, eve = (world.town.template.pseudonyms[name] for name in ("ada", "eve"))
    tape = world.recording(trainee=ada)
    first = world.upload("ada", tape)
    honest(first.status == 201 and not first.json.get("uncounted"), f"the first one counts: {first}")
    for name, whose in (("eve", eve), ("eve", ""), ("ada", ada)):
        answer = world.upload(name, tape.another(trainee=whose, started_at=tapes.ago(hours=3), seed="7"))
        refuse(answer.status != 201 or answer.json.get("uncounted") == "duplicate", f"the copy counts: {answer}")
    noted = world.town.one("SELECT count(*) FROM audit_log WHERE details LIKE ?", f"%repeats%{tape.session_id}%")
    refuse(noted == 3, f"the audit log names {noted} of 3 copies")
    return "three copies kept as duplicates, each in the audit log"


def attack_forged_signature(world):
    """signatures by an unknown station, by another key, of another motion, and of a recording without a trainee"""
    town, key = world.town, Ed25519PrivateKey.generate()
    station, ada = pair(town, key), world.town.template.pseudonyms["ada"]
    tape = world.recording(device="mouse", trainee=ada).sign(station, key)
    first = world.upload("ada", tape)
    honest(first.status == 201 and first.json["signed_by_station"] is True, f"a station's signature is right: {first}")
    other = world.recording(device="mouse", trainee=ada)
    others = {
        "an unknown station": other.another().sign("00000000-0000-4000-8000-000000000000", key),
        "another key": other.another().sign(station, Ed25519PrivateKey.generate()),
    }
    moved = world.recording(device="mouse", trainee=ada)
    moved.metadata["stylet.signature"] = dict(tape.metadata["stylet.signature"])
    others["another motion"] = moved
    others["a station, of nobody's attempt"] = world.recording(device="mouse", trainee="").sign(station, key)
    for what, forgery in others.items():
        answer = world.upload("ada", forgery)
        refuse(answer.json.get("signed_by_station") is not True, f"signed by {what}: {answer}")
    return "none of four counts as signed"


def attack_forces_that_do_not_follow(world):
    """a signed recording whose forces were halved afterwards"""
    town, key = world.town, Ed25519PrivateKey.generate()
    station, ada = pair(town, key), world.town.template.pseudonyms["ada"]

    def proof(tape):
        honest(world.upload("ada", tape).status == 201, "it is taken")
        town.wait_scored(tape.session_id)
        return town.program("ada").get(f"/api/v1/sessions/{tape.session_id}/score").json["proof"]

    def halve(sample):
        sample.tip_n *= 0.5
        sample.force_n.z *= 0.5

    kept = proof(world.recording(device="mouse", trainee=ada).sign(station, key))
    honest(kept["signed"] and kept["resimulated"], f"an honest one is proved: {kept}")
    altered = world.recording(device="mouse", trainee=ada).fresh().edit("/needle/sample", halve).sign(station, key)
    found = proof(altered)
    refuse(not found["signed"] and not found["resimulated"], f"it counts as proved: {found}")
    return f"not proved: {found}"


def attack_signed_fields_edited(world):
    """a signed recording whose energies, marks, interruption, field, rate or device's force were changed afterwards"""
    town, key = world.town, Ed25519PrivateKey.generate()
    station, ada = pair(town, key), world.town.template.pseudonyms["ada"]

    def signed():
        return world.recording(device="mouse", trainee=ada).fresh().sign(station, key)

    def proof(tape):
        taken = world.upload("ada", tape)
        honest(taken.status == 201, f"it is taken: {taken}")
        town.wait_scored(tape.session_id)
        told = town.program("ada").get(f"/api/v1/sessions/{tape.session_id}/score").json
        # A void attempt has no score, and so no proof of one.
        return told.get("proof") or {"signed": taken.json["signed_by_station"], "resimulated": True}

    def spare(ledger):
        for layer in ledger.layers:
            layer.friction_j = layer.lateral_j = 0

    def unfelt(sample):
        sample.flags |= 1 << 16

    def interrupt(event):
        event.kind, event.text = tapes.INTERRUPTED, "device lost"

    def session(**changed):
        tape = signed()
        tape.session.update(changed)
        return tape

    kept = proof(signed())
    honest(kept["signed"] and kept["resimulated"], f"an honest one is proved: {kept}")
    for what, tape in {
        "energies": signed().edit("/needle/energy", spare),
        "marks": signed().edit("/needle/sample", unfelt),
        "the way the field was judged": session(field="1"),
        "the rate": session(tick_hz="500"),
        "the device's force": session(device_max_force_n="3.3"),
    }.items():
        found = proof(tape)
        refuse(not (found["signed"] and found["resimulated"]), f"proved with other {what}: {found}")
    ended = signed().edit("/events", interrupt)
    taken = world.upload("ada", ended)
    refuse(taken.json.get("signed_by_station") is not True, f"signed with an interruption that did not happen: {taken}")
    return "none of six is proved"


def attack_unsigned_copy_first(world):
    """an unsigned copy of a signed attempt, brought before it"""
    town, key = world.town, Ed25519PrivateKey.generate()
    station, ada = pair(town, key), world.town.template.pseudonyms["ada"]
    tape = world.recording(device="mouse", trainee=ada)
    copy = world.upload("ada", tape.another())
    honest(copy.status == 201 and not copy.json.get("uncounted"), f"a copy alone counts: {copy}")
    original = world.upload("ada", tape.sign(station, key))
    refuse(not original.json.get("uncounted") and original.json["signed_by_station"], f"the signed one does not count: {original}")
    return "the signed one counts"


def attack_certificate_without_proof(world):
    """a certificate from one's own unsigned, unsupervised pass; confirming one's own supervision"""
    town = world.own_town()
    session = world.scored("ada", town, world.expert())
    status(certificate(town, "ada"), 409)
    status(badge(town, "ada", "ada"), 409)
    status(town.browser("ada").press(f"/sessions/{session}/supervision", {"confirm": "yes"}), 403)
    status(town.browser("ada").press("/admin/certificate-needs", {"needed": "nothing"}), 403)
    confirmed = town.browser("teacher").press(f"/sessions/{session}/supervision", {"confirm": "yes"})
    honest(confirmed.status == 303, f"the teacher confirms: {confirmed}")
    honest(certificate(town, "ada").status == 200, "supervised, it is given")
    honest(badge(town, "ada", "ada").status == 200, "and the badge, too")
    status(badge(town, "ben", "ada"), 404)
    return "409, and 403 for the trainee's own word"


def attack_backdated_start(world):
    """attempts that began a month ago, by their own word and by a clock that is told to be wrong"""
    def began(tape, **headers):
        answer = world.upload("ada", tape, headers=headers)
        honest(answer.status == 201, f"it is taken: {answer}")
        return tapes.moment(answer.json["started_at"][:19])

    hour, day_ago = tapes.ago(hours=1), tapes.moment(tapes.ago(hours=24, minutes=1))
    honest(abs(began(world.recording(started_at=hour)) - tapes.moment(hour)) < 10**9, "an hour ago is believed")
    month = began(world.recording(started_at=tapes.ago(days=30)))
    clock = began(world.recording(), **{"Stylet-Clock": tapes.ago(days=-30)})
    refuse(min(month, clock) >= day_ago, "it is believed more than a day back")
    return "believed a day back at most; the claim is kept beside it"


def attack_start_in_the_far_future(world):
    """attempts of the years 2104 and 9999, and of 1969"""
    answer = world.upload("ada", world.recording(started_at="2104-12-31T00:00:00Z"))
    honest(answer.status == 201, f"a year that messages can say is taken: {answer}")
    refuse(not answer.json["started_at"].startswith("2104"), f"it is believed: {answer}")
    for year in ("9999", "1969", "-262143", "2106"):
        status(world.upload("ada", world.recording(started_at=f"{year}-06-01T00:00:00Z")), 422)
    progress = world.town.browser("head").get("/progress")
    refuse("2104" not in progress.text and progress.status == 200, "the curve of the school runs to 2104")
    return "2104 set back to now, the others 422"

"""Reads a recording with packages that share no code with Stylet, by the schemas that the file itself carries.

    pip install mcap mcap-protobuf-support
    python read_recording.py ATTEMPT.mcap

Checks topics, schemas, metadata, attachments, counts, rates and times against the contract, and decodes every message.
Prints what it found. Exit status: 0 as the contract says, 1 not so, 2 a wrong call.
"""

import math
import sys
from collections import Counter
from datetime import datetime

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

SCHEMAS = {
    "/needle/sample": "stylet.NeedleSample",
    "/needle/summary": "stylet.NeedleSummary",
    "/needle/pose": "foxglove.PoseInFrame",
    "/needle/energy": "stylet.EnergyLedger",
    "/tf": "foxglove.FrameTransforms",
    "/scene": "foxglove.SceneUpdate",
    "/events": "stylet.Event",
    "/log": "foxglove.Log",
    "/tissue/tent": "stylet.TissueTent",
}
# Left out where the scene has no field.
OPTIONAL = {"/tissue/tent"}
KEYS = set(
    "session_id exercise_id exercise_sha256 scene_sha256 simulator_version git device device_max_force_n tick_hz seed "
    "trainee started_at patient_thickness_mm".split()
)
# Messages per second of recorded time, and how many more or fewer are allowed at the ends.
RATES = {"/needle/summary": 100, "/needle/pose": 60, "/tf": 60, "/scene": 1, "/tissue/tent": 120}
ENDS = 3


def check(good, words):
    if not good:
        raise SystemExit(f"not as the contract says: {words}")


def check_header(reader):
    header = reader.get_header()
    check(header.profile == "stylet", f"profile {header.profile!r}")
    metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    check("stylet.session" in metadata, f"metadata {sorted(metadata)}")
    session = metadata["stylet.session"]
    check(KEYS <= session.keys(), f"metadata lacks {sorted(KEYS - session.keys())}")
    attachments = {record.name: len(record.data) for record in reader.iter_attachments()}
    check({"exercise.toml", "scene.toml"} <= attachments.keys(), f"attachments {attachments}")
    return session, attachments


def check_messages(reader, session):
    """Decodes every message; returns how many there are of each topic, and the samples' times in s."""
    started = datetime.fromisoformat(session["started_at"].replace("Z", "+00:00")).timestamp()
    counts, last, times = Counter(), {}, []
    for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
        topic = channel.topic
        check(SCHEMAS.get(topic) == schema.name, f"{topic} has schema {schema.name}")
        check(message.log_time >= last.get(topic, 0), f"{topic} goes back in time at {message.log_time} ns")
        check(decoded.ByteSize() == len(message.data), f"{topic} holds bytes that its schema does not know")
        last[topic] = message.log_time
        counts[topic] += 1
        if topic == "/needle/sample":
            off = message.log_time / 1e9 - started - decoded.t_s
            check(abs(off) < 1e-5, f"log_time is {off} s off at {decoded.t_s} s")
            check(not times or decoded.t_s > times[-1], f"sample time {decoded.t_s} s does not increase")
            q = decoded.orientation
            norm = math.sqrt(q.x**2 + q.y**2 + q.z**2 + q.w**2)
            check(abs(norm - 1) < 1e-9, f"orientation of length {norm} at {decoded.t_s} s")
            times.append(decoded.t_s)
    return counts, times


def main(path):
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        session, attachments = check_header(reader)
        summary = reader.get_summary()
        check(summary is not None, "no summary")
        topics = {channel.topic for channel in summary.channels.values()}
        check(SCHEMAS.keys() - OPTIONAL <= topics <= SCHEMAS.keys(), f"topics {sorted(topics)}")
        check(all(chunk.compression == "zstd" for chunk in summary.chunk_indexes), "a chunk is not zstd")
        counts, times = check_messages(reader, session)
    check(sum(counts.values()) == summary.statistics.message_count, "the statistics miscount")
    seconds = times[-1] - times[0] if times else 0.0
    check(abs(len(times) - 1 - seconds * float(session["tick_hz"])) < 1, f"{len(times)} samples in {seconds} s")
    for topic, rate in RATES.items():
        check(topic not in topics or abs(counts[topic] - rate * seconds) <= ENDS, f"{counts[topic]} of {topic} in {seconds} s")
    print(f"{path}: {session['exercise_id']} by {session['device']}, {seconds:.3f} s, {len(summary.chunk_indexes)} chunks")
    for name, size in sorted(attachments.items()):
        print(f"  {name}: {size} bytes")
    for topic, schema in SCHEMAS.items():
        print(f"  {topic} {schema}: {counts[topic]}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit((print(__doc__, file=sys.stderr), 2)[1])
    try:
        main(sys.argv[1])
    except (McapError, OSError) as error:
        sys.exit(f"{sys.argv[1]}: {error}")

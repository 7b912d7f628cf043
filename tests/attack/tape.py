"""Recordings as an attacker writes them: an honest one with something changed, or records put together by hand."""

import copy
import hashlib
import io
import struct
import uuid
from dataclasses import dataclass, field
from datetime import datetime, timedelta, timezone

import zstandard
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 1, 2, 3, 4, 5, 6
ATTACHMENT, METADATA, DATA_END = 9, 12, 15
INTERRUPTED = 9


@dataclass
class Tape:
    """A recording in parts."""

    schemas: dict = field(default_factory=dict)
    channels: dict = field(default_factory=dict)
    messages: list = field(default_factory=list)
    metadata: dict = field(default_factory=dict)
    attachments: list = field(default_factory=list)

    @classmethod
    def read(cls, data):
        reader = make_reader(io.BytesIO(data))
        tape = cls(metadata={found.name: dict(found.metadata) for found in reader.iter_metadata()})
        tape.attachments = [(found.name, found.media_type, found.data) for found in reader.iter_attachments()]
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            tape.schemas[schema.id], tape.channels[channel.id] = schema, channel
            tape.messages.append([channel.topic, message.log_time, message.data])
        return tape

    @property
    def session(self):
        return self.metadata["stylet.session"]

    @property
    def session_id(self):
        return self.session["session_id"]

    def another(self, **session):
        """A copy under another id, with these entries of the session."""
        other = Tape(self.schemas, self.channels, list(self.messages), copy.deepcopy(self.metadata), list(self.attachments))
        other.metadata.pop("stylet.signature", None)
        other.session.update({"session_id": str(uuid.uuid4()), **session})
        return other

    def attach(self, name, data):
        """Puts a document in another's place."""
        self.attachments = [(known, kind, data if known == name else old) for known, kind, old in self.attachments]
        if all(known != name for known, _, _ in self.attachments):
            self.attachments.append((name, "application/toml", data))
        return self

    def document(self, name):
        return next(data for known, _, data in self.attachments if known == name)

    def kind(self, topic):
        """The class of a topic's messages, by the schema that the file carries."""
        schema = next(self.schemas[found.schema_id] for found in self.channels.values() if found.topic == topic)
        pool, files = descriptor_pool.DescriptorPool(), descriptor_pb2.FileDescriptorSet.FromString(schema.data)
        for file in files.file:
            pool.Add(file)
        return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))

    def edit(self, topic, change):
        """Changes messages of a topic, one by one."""
        kind = self.kind(topic)
        for message in (message for message in self.messages if message[0] == topic):
            decoded = kind.FromString(message[2])
            change(decoded)
            message[2] = decoded.SerializeToString()
        return self

    def fresh(self):
        """The same with messages of its own to change."""
        self.messages = [list(message) for message in self.messages]
        return self

    def motion(self):
        """SHA-256 of what the hand did."""
        digest, kind = hashlib.sha256(), self.kind("/needle/sample")
        for topic, _, data in self.messages:
            if topic == "/needle/sample":
                s = kind.FromString(data)
                p, q = s.position_m, s.orientation
                digest.update(struct.pack("<8dB", s.t_s, p.x, p.y, p.z, q.x, q.y, q.z, q.w, bool(s.flags & 4)))
        return digest.digest()

    def conditions(self):
        """SHA-256 of what the device did with the force, and of what ended the attempt."""
        flags, interruptions, kinds = hashlib.sha256(), hashlib.sha256(), {}
        for topic, _, data in self.messages:
            kind = kinds.setdefault(topic, self.kind(topic)) if topic in ("/needle/sample", "/events") else None
            if topic == "/needle/sample":
                flags.update(struct.pack("<I", kind.FromString(data).flags))
            elif topic == "/events" and (event := kind.FromString(data)).kind == INTERRUPTED:
                words = event.text.encode()
                interruptions.update(struct.pack("<dQ", event.t_s, len(words)) + words)
        return hashlib.sha256(flags.digest() + interruptions.digest()).digest()

    def sign(self, station, key):
        """Signs as docs/recordings.md says, by an Ed25519 key."""
        session, began = self.session, moment(self.session["started_at"])
        thickness = [float(part) for part in session["patient_thickness_mm"].strip("[]").split(",") if part.strip()]
        fields = [b"stylet.signature 2", uuid.UUID(station).bytes, uuid.UUID(session["session_id"]).bytes]
        texts = ("exercise_id", "exercise_sha256", "scene_sha256", "simulator_version", "git", "device")
        fields += [session[name].encode() for name in texts]
        fields += [struct.pack("<d", float(session["device_max_force_n"]))]
        fields += [struct.pack("<I", int(session[name])) for name in ("law", "field")]
        fields += [struct.pack("<d", float(session["tick_hz"])), struct.pack("<Q", int(session["seed"]))]
        fields += [session["trainee"].encode(), began.to_bytes(16, "little", signed=True)]
        fields += [struct.pack(f"<{len(thickness)}d", *thickness), self.motion(), self.conditions()]
        signed = b"".join(struct.pack("<I", len(part)) + part for part in fields)
        self.metadata["stylet.signature"] = {"station": station, "ed25519": key.sign(signed).hex()}
        return self

    def write(self):
        sink = io.BytesIO()
        writer = Writer(sink, compression=CompressionType.ZSTD)
        writer.start(profile="stylet", library="attack")
        schemas = {old: writer.register_schema(one.name, one.encoding, one.data) for old, one in self.schemas.items()}
        channels = {}
        for one in self.channels.values():
            channels[one.topic] = writer.register_channel(one.topic, one.message_encoding, schemas[one.schema_id], one.metadata)
        writer.add_metadata("stylet.session", self.session)
        for name, kind, data in self.attachments:
            writer.add_attachment(0, 0, name, kind, data)
        for topic, at, data in self.messages:
            writer.add_message(channels[topic], at, data, at)
        for name, values in self.metadata.items():
            if name != "stylet.session":
                writer.add_metadata(name, values)
        writer.finish()
        return sink.getvalue()


def moment(rfc3339):
    """Unix time in ns of a time as recordings write it."""
    head, _, fraction = rfc3339.rstrip("Z").partition(".")
    whole = datetime.fromisoformat(head).replace(tzinfo=timezone.utc)
    return int(whole.timestamp()) * 10**9 + int(fraction.ljust(9, "0")[:9] or 0)


def ago(**past):
    """So long ago, as recordings write it."""
    return (datetime.now(timezone.utc) - timedelta(**past)).strftime("%Y-%m-%dT%H:%M:%SZ")


# Records by hand: what no writer writes.


def text(value):
    value = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(value)) + value


def record(kind, body, length=None):
    return struct.pack("<BQ", kind, len(body) if length is None else length) + body


def table(values):
    packed = b"".join(text(key) + text(value) for key, value in values.items())
    return struct.pack("<I", len(packed)) + packed


def message(channel, data, at=0):
    return record(MESSAGE, struct.pack("<HIQQ", channel, 0, at, at) + data)


def attachment(name, data, kind="", crc=0):
    body = struct.pack("<QQ", 0, 0) + text(name) + text(kind) + struct.pack("<Q", len(data)) + data
    return record(ATTACHMENT, body + struct.pack("<I", crc))


def metadata(name, values):
    return record(METADATA, text(name) + table(values))


def chunk(records, declared=None, compression="zstd"):
    """Records in a chunk, packed; `declared` is what it says to unpack to, in bytes."""
    packed = zstandard.ZstdCompressor(level=19 if len(records) < 10_000_000 else 3).compress(records) if compression else records
    size = len(records) if declared is None else declared
    body = struct.pack("<QQQI", 0, 0, size, 0) + text(compression) + struct.pack("<Q", len(packed)) + packed
    return record(CHUNK, body)


def by_hand(tape, *records, session=None, attachments=None):
    """A whole file: what a tape begins with, and then these records."""
    head = [MAGIC, record(HEADER, text("stylet") + text("attack"))]
    head.append(metadata("stylet.session", {**tape.session, **(session or {})}))
    for name, kind, data in tape.attachments if attachments is None else attachments:
        head.append(attachment(name, data, kind))
    for one in tape.schemas.values():
        head.append(record(SCHEMA, struct.pack("<H", one.id) + text(one.name) + text(one.encoding) + text(one.data)))
    for one in tape.channels.values():
        head.append(record(CHANNEL, struct.pack("<HH", one.id, one.schema_id) + text(one.topic) + text("protobuf") + table({})))
    tail = [record(DATA_END, struct.pack("<I", 0)), record(FOOTER, struct.pack("<QQI", 0, 0, 0)), MAGIC]
    return b"".join([*head, *records, *tail])


def channel_of(tape, topic):
    return next(one.id for one in tape.channels.values() if one.topic == topic)

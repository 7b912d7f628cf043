"""Makes the bombs beside it anew: small files that would cost whoever reads them much, a folder for each fuzz target.

    target/venv/bin/python tests/fuzz/bombs/make.py

tests/fuzz/run puts them into the corpora, and the tests of each parser read them within their budget.
"""

import gzip
import struct
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(ROOT / "tests/attack"))

from attacks.bombs import bombs  # noqa: E402
from tape import Tape  # noqa: E402

# Of all together, in bytes.
MOST_BYTES = 1_000_000
DEEP, MANY = 10_000, 15_000


def documents():
    """Target, name and content: nested, long, wide and repeated without end."""
    toml = {
        "nested-lists": "a = " + "[" * DEEP,
        "nested-tables": "[" + ".".join("a" * DEEP) + "]\n",
        "nested-inline": "a = " + "{a = " * DEEP,
        "one-key": "a" * 150_000 + " = 1\n",
        "one-text": 'id = "' + "x" * 150_000 + '"\n',
        "dotted-keys": "".join(f"a.b{n % 300}.c{n} = 1\n" for n in range(6_000)),
        "numbers": "id = " + "9" * 20_000 + "\n",
    }
    for target in ("scene", "course", "instrument", "exercise"):
        end = "\0" if target == "exercise" else ""
        for name in ("nested-lists", "nested-tables", "nested-inline", "dotted-keys"):
            yield target, name, toml[name][:20_000] + end + end
    yield "scene", "one-key", toml["one-key"][:30_000]
    yield "scene", "numbers", toml["numbers"]
    yield "scene", "layers", 'id = "x"\n' + '[[layer]]\nname = "a"\n' * 1_000
    yield "course", "exercises", 'id = "x"\ntitle = "x"\n' + '[[exercise]]\nfile = "a.toml"\n' * 800
    yield "field_case", "nested", "[" * DEEP
    yield "field_case", "nested-objects", '{"a":' * 10_000
    yield "field_case", "number", '{"id": ' + "9" * 20_000 + "}"
    yield "instrument", "nested-json", "[" * DEEP
    yield "roster", "columns", ";" * MANY + "\n" + ";" * MANY + "\n"
    yield "roster", "quotes", '"' * MANY + "\n"
    yield "roster", "rows", "E-Mail;Name\n" + "a@x.example;A\n" * 800
    yield "roster", "nothing", "\n" * MANY


def main():
    whole = 0
    for target, name, data in [*documents(), *recordings(), *label_maps()]:
        data = data.encode() if isinstance(data, str) else data
        place = HERE / target / name
        place.parent.mkdir(exist_ok=True)
        place.write_bytes(data)
        whole += len(data)
        assert len(data) <= 200_000, f"{place}: {len(data)} bytes"
    assert whole <= MOST_BYTES, f"{whole} bytes in all"
    print(f"{whole} bytes")


def label_maps():
    """A NIfTI header that promises 134 million voxels, alone, packed, with nothing behind it but zeros; and one that promises more."""
    header = bytearray(352)
    struct.pack_into("<i8h", header, 0, 348, *[0] * 8)
    struct.pack_into("<8h", header, 40, 3, 512, 512, 512, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 512, 16)
    struct.pack_into("<4f", header, 76, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    header[344:348] = b"n+1\0"
    yield "segmentation", "promise", bytes(header)
    yield "segmentation", "promise-packed", gzip.compress(bytes(header), mtime=0)
    # 50 MB of air, packed to a thousandth, of the 256 MB that are promised.
    yield "segmentation", "zeros-packed", gzip.compress(bytes(header) + bytes(50_000_000), mtime=0)
    struct.pack_into("<8h", header, 40, 3, 32767, 32767, 32767, 1, 1, 1, 1)
    yield "segmentation", "too-many", bytes(header)


def recordings():
    """Those that tests/attack sends, where they are small, on documents without what makes them large."""
    base = Tape.read((ROOT / "tests/data/recordings/force-law-1.mcap").read_bytes())
    base.attachments = [(name, kind, data) for name, kind, data in base.attachments if name.endswith(".toml")]
    base.schemas = {key: one for key, one in base.schemas.items() if one.name.startswith("stylet.")}
    base.channels = {key: one for key, one in base.channels.items() if one.schema_id in base.schemas}
    # The same file each time.
    base.session["session_id"] = "00000000-0000-4000-8000-000000000000"
    for name, data in bombs(base, small=True):
        yield "recording", name.replace(" ", "-").replace("'", "").replace("^", ""), data


if __name__ == "__main__":
    main()

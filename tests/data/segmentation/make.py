"""Makes back.nii.gz beside it anew: a made-up back as a map of labels, for the example of docs/simulate.md. Nobody's anatomy.

    python3 tests/data/segmentation/make.py
"""

import gzip
import math
import struct
from pathlib import Path

SIZE, EDGES_MM, TURN = (90, 66, 56), (2.0, 2.0, 3.0), 0.15
SKIN, FAT, MUSCLE, BONE, SAC, KIDNEY, AORTA, CALYX = 1, 2, 3, 10, 11, 12, 13, 14


def within(x, y, a, b):
    return (x / a) ** 2 + (y / b) ** 2 < 1


def label(x, y, z):
    """x to the right, y anterior, z superior, in mm from the middle."""
    back = -58 * math.sqrt(max(0.0, 1 - (x / 80) ** 2)) + 3 * math.exp(-((x / 9) ** 2))
    depth = y - back
    if depth <= 0 or not within(x, y, 80, 58):
        return 0
    if depth < 2.5 or not within(x, y, 77.5, 55.5):
        return SKIN
    level = abs(z % 38 - 19)
    canal = within(x, y + 22, 9, 8)
    if within(x - 45, y + 12, 6, 5) and (z + 8) ** 2 < 36 * (1 - ((x - 45) / 6) ** 2 - ((y + 12) / 5) ** 2):
        return CALYX
    if ((x - 45) / 18) ** 2 + ((y + 12) / 14) ** 2 + ((z - 5) / 28) ** 2 < 1:
        return KIDNEY
    if (x + 12) ** 2 + (y - 24) ** 2 < 81:
        return AORTA
    if canal:
        return SAC
    body = within(x, y, 22, 16) and level < 14
    arch = within(x, y + 22, 15, 13) and level < 9
    process = abs(x) < 3 and -44 < y < -30 and level < 7
    if body or arch or process:
        return BONE
    return FAT if depth < 12 or not within(x, y, 68, 46) else MUSCLE


def main():
    cosine, sine = math.cos(TURN), math.sin(TURN)
    columns = [(cosine, sine, 0), (-sine, cosine, 0), (0, 0, 1)]
    rows = [[EDGES_MM[axis] * columns[axis][row] for axis in range(3)] for row in range(3)]
    middle = [(along - 1) / 2 for along in SIZE]
    origin = [-sum(row[axis] * middle[axis] for axis in range(3)) for row in rows]
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *SIZE, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, *EDGES_MM, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    header[123] = 2
    struct.pack_into("<2h", header, 252, 0, 1)
    for at, row in enumerate(rows):
        struct.pack_into("<4f", header, 280 + 16 * at, *row, origin[at])
    header[344:348] = b"n+1\0"
    voxels = bytearray()
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                place = [row[0] * i + row[1] * j + row[2] * k + start for row, start in zip(rows, origin)]
                voxels.append(label(*place))
    packed = gzip.compress(bytes(header) + bytes(voxels), mtime=0)
    (Path(__file__).resolve().parent / "back.nii.gz").write_bytes(packed)
    print(len(packed), "bytes")


if __name__ == "__main__":
    main()

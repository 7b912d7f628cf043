"""Arrays in and out, and documents of a call."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ._native import StyletError

PathLike = str | os.PathLike[str]
Floats = npt.NDArray[np.float64]

#: A scene or a case is smaller; whatever is larger is neither, or has no end.
LARGEST_TEXT_BYTES = 16 << 20


class UnsoundSceneWarning(UserWarning):
    """A rupture of the scene would create energy; what was asked for is computed all the same."""


class ToleranceWarning(UserWarning):
    """The best model there is does not meet the tolerance."""


class CutRecordingWarning(UserWarning):
    """A recording ends too soon; what it holds is used."""


def read_document(document: PathLike | Mapping[str, Any]) -> tuple[str, str]:
    """The name and the JSON of a document: a path, a text that begins with a brace, or what `json.load` made of one."""
    if isinstance(document, Mapping):
        try:
            return "scene", json.dumps(dict(document), allow_nan=False, default=plain_number)
        except ValueError as error:
            raise StyletError(f"scene: {error}; finite numbers are allowed") from None
    if isinstance(document, str) and document.lstrip().startswith("{"):
        return "scene", document
    path = os.fspath(document)
    if not isinstance(path, str):
        raise TypeError(f"scene: {type(document).__name__}; a path, a text of JSON or a mapping is allowed")
    with open(path, "rb") as file:
        content = file.read(LARGEST_TEXT_BYTES + 1)
    if len(content) > LARGEST_TEXT_BYTES:
        raise StyletError(f"{path}: larger than 16 MiB; a document is far smaller")
    try:
        return path, content.decode()
    except UnicodeDecodeError as error:
        raise StyletError(f"{path}: byte {error.start} is no UTF-8; text is allowed") from None


def plain_number(value: object) -> object:
    """What JSON has for numbers and arrays of numpy."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"scene: {type(value).__name__}; numbers, texts, lists and mappings are allowed")


def read_numbers(name: str, values: npt.ArrayLike, dimensions: int) -> Floats:
    """Real numbers in double precision, contiguous: a copy only where they are not yet."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: dtype {array.dtype}; real numbers are allowed")
    if array.ndim != dimensions:
        shape = "(n,)" if dimensions == 1 else "(n, columns)"
        raise StyletError(f"{name}: shape {array.shape}; {shape} is allowed")
    return np.ascontiguousarray(array, dtype=np.float64)


def view_table(fields: list[tuple[str, str, int]], row_bytes: int, rows: int, content: bytearray) -> npt.NDArray[np.void]:
    """A structured array over bytes that are laid out as its rows. Nothing is copied."""
    names, formats, offsets = (list(part) for part in zip(*fields))
    layout: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": row_bytes}
    return np.frombuffer(content, dtype=np.dtype(layout), count=rows) if rows else np.empty(0, dtype=np.dtype(layout))

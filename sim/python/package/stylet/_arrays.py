"""Conversion of arrays and documents."""

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

#: Size limit of a scene or a case; anything larger is neither.
LARGEST_TEXT_BYTES = 16 << 20


class UnsoundSceneWarning(UserWarning):
    """A rupture of the scene would create energy. The result is computed anyway."""


class ToleranceWarning(UserWarning):
    """Even the best available model does not meet the tolerance."""


class CutRecordingWarning(UserWarning):
    """A recording is truncated. Its complete part is used."""


def read_document(document: PathLike | Mapping[str, Any]) -> tuple[str, str]:
    """Returns the name and the JSON of a document: a path, a text that begins with a brace, or the result of `json.load`."""
    if isinstance(document, Mapping):
        try:
            return "scene", json.dumps(dict(document), allow_nan=False, default=plain_number)
        except ValueError as error:
            raise StyletError(f"scene: {error}; allowed: finite numbers") from None
    if isinstance(document, str) and document.lstrip().startswith("{"):
        return "scene", document
    path = os.fspath(document)
    if not isinstance(path, str):
        raise TypeError(f"scene: {type(document).__name__}; allowed: a path, a JSON text or a mapping")
    with open(path, "rb") as file:
        content = file.read(LARGEST_TEXT_BYTES + 1)
    if len(content) > LARGEST_TEXT_BYTES:
        raise StyletError(f"{path}: larger than 16 MiB; allowed: a document of at most 16 MiB")
    try:
        return path, content.decode()
    except UnicodeDecodeError as error:
        raise StyletError(f"{path}: byte {error.start} is not UTF-8; allowed: UTF-8 text") from None


def plain_number(value: object) -> object:
    """Converts numbers and arrays of numpy to their JSON equivalents."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"scene: {type(value).__name__}; allowed: numbers, texts, lists and mappings")


def read_numbers(name: str, values: npt.ArrayLike, dimensions: int) -> Floats:
    """Returns real numbers in double precision, contiguous; copies them only if necessary."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: dtype {array.dtype}; allowed: real numbers")
    if array.ndim != dimensions:
        shape = "(n,)" if dimensions == 1 else "(n, columns)"
        raise StyletError(f"{name}: shape {array.shape}; allowed: {shape}")
    return np.ascontiguousarray(array, dtype=np.float64)


def view_table(fields: list[tuple[str, str, int]], row_bytes: int, rows: int, content: bytearray) -> npt.NDArray[np.void]:
    """Returns a structured array over bytes in the layout of its rows, without copying."""
    names, formats, offsets = (list(part) for part in zip(*fields))
    layout: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": row_bytes}
    return np.frombuffer(content, dtype=np.dtype(layout), count=rows) if rows else np.empty(0, dtype=np.dtype(layout))

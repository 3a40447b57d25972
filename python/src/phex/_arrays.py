"""Vertices and faces of any kind to the arrays that are computed with."""

import operator
import os
from typing import Any, Tuple

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError

Arrays = Tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.int64]]

#: More vertices or corners than this are refused before memory is taken for them.
MOST = 1 << 30


def _array(values: Any, name: str) -> Any:
    try:
        return np.asarray(values)
    except Exception as cause:  # whatever a foreign object does
        raise InputError(f"{name}: {type(cause).__name__}: {cause}") from None


def checked_vertices(vertices: Any, name: str = "vertices") -> NDArray[np.float64]:
    """An own copy of points as float64 (n, 3); every number is finite."""
    given = _array(vertices, name)
    if given.ndim != 2 or given.shape[1] != 3:
        raise InputError(f"{name} have shape {given.shape}, not (n, 3)")
    if given.dtype.kind not in "fiu":
        raise InputError(f"{name} are {given.dtype}, not numbers")
    if len(given) > MOST:
        raise InputError(f"{len(given)} {name}, at most {MOST}")
    points = np.array(given, dtype=np.float64, order="C")
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError(f"{name}: number {k} is {points[k].tolist()}, which is not finite")
    return points


def checked_faces(faces: Any, vertices: int) -> Tuple[NDArray[np.uint32], NDArray[np.int64]]:
    """Corners of all faces one after the other, and where each face begins, with the end."""
    if isinstance(faces, np.ndarray) and faces.ndim == 2:
        m, k = faces.shape
        if m * k > MOST:
            raise InputError(f"{m} faces of {k} corners, at most {MOST} corners")
        flat, offsets = faces.reshape(-1), np.arange(m + 1, dtype=np.int64) * k
    else:
        flat, offsets = _ragged(faces)
    return checked_corners(flat, offsets, vertices)


def _ragged(faces: Any) -> Tuple[Any, NDArray[np.int64]]:
    try:
        lists = [f if isinstance(f, (list, tuple, np.ndarray)) else list(f) for f in faces]
        lengths = [len(f) for f in lists]
    except Exception:  # whatever a foreign object does
        raise InputError("faces are no list of lists of vertex numbers") from None
    flat = []
    for k, face in enumerate(lists):
        try:
            flat.extend(operator.index(v) for v in face)
        except TypeError:
            raise InputError(f"face {k}: {_shown(face)} are no vertex numbers") from None
    offsets = np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)]).astype(np.int64)
    try:
        return np.array(flat, dtype=np.int64), offsets
    except OverflowError:
        raise InputError("faces: a vertex number is too large") from None


def checked_corners(
    corners: Any, offsets: Any, vertices: int
) -> Tuple[NDArray[np.uint32], NDArray[np.int64]]:
    """The same from flat arrays."""
    flat, ends = _array(corners, "corners"), _array(offsets, "offsets")
    if flat.ndim != 1 or ends.ndim != 1:
        raise InputError(f"corners and offsets have shapes {flat.shape} and {ends.shape}")
    for name, numbers in (("faces", flat), ("offsets", ends)):
        if numbers.size and numbers.dtype.kind not in "iu":
            raise InputError(f"{name} are {numbers.dtype}, not whole numbers")
    if flat.size > MOST or ends.size > MOST:
        raise InputError(f"{flat.size} corners of faces, at most {MOST}")
    ends = np.array(ends, dtype=np.int64)
    if ends.size == 0 or ends[0] != 0 or ends[-1] != flat.size or (np.diff(ends) < 0).any():
        raise InputError("offsets do not rise from 0 to the number of corners")
    wrong = (flat < 0) | (flat >= vertices)
    if wrong.any():
        at = int(np.argmax(wrong))
        face = int(np.searchsorted(ends, at, side="right")) - 1
        raise InputError(f"face {face} has vertex {int(flat[at])}; there are {vertices}, from 0")
    short = np.diff(ends) < 3
    if short.any():
        face = int(np.argmax(short))
        raise InputError(f"face {face} has {int(ends[face + 1] - ends[face])} corners, not 3 or more")
    return np.array(flat, dtype=np.uint32, order="C"), ends


def checked_numbers(values: Any, name: str) -> NDArray[np.float64]:
    """A flat list of finite numbers."""
    numbers = _array(values, name)
    if numbers.ndim != 1 or numbers.dtype.kind not in "fiu" or numbers.size > MOST:
        raise InputError(f"{name}: {_shown(values)} is no list of numbers")
    made = np.array(numbers, dtype=np.float64, order="C")
    if not np.isfinite(made).all():
        raise InputError(f"{name}: {_shown(values)} is not finite")
    return made


def is_path(value: Any) -> bool:
    """Whether a value names a file."""
    return isinstance(value, (str, os.PathLike))


def path_text(value: Any, name: str) -> str:
    """A file's name as text."""
    if not is_path(value):
        raise InputError(f"{name}: {_shown(value)} is no path")
    text = os.fspath(value)
    if not isinstance(text, str) or not text or "\0" in text:
        raise InputError(f"{name}: {_shown(value)} is no path")
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"{name}: {_shown(value)} is no path") from None
    return text


def _shown(value: Any) -> str:
    try:
        text = repr(value)
    except Exception:  # whatever a foreign object does
        text = object.__repr__(value)
    return text if len(text) <= 80 else text[:77] + "..."


shown = _shown

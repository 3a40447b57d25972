"""The options of ``phex mesh`` as keywords: one table, from which values are checked and handed over.

A test holds this table against ``phex mesh --help``: names, values and defaults.
"""

import math
import numbers
import re
from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np

from ._arrays import checked_numbers, checked_vertices, is_path, path_text, shown
from ._errors import InputError

EFFORTS = ("draft", "normal", "best")
STAGES = ("layout",)
METHODS = (
    "lattice",
    "brick-wall",
    "power-diagram",
    "projective-dual",
    "dual-subdivision",
    "support-function",
    "tangent-planes",
    "parallel",
    "koebe",
)
BOUNDARIES = ("whole", "clip", "snap")
SYMMETRIES = ("auto", "none", "mirror")
TARGETS = ("smooth", "half-way", "facets")
UNITS = ("mm", "cm", "m", "in", "ft")
SOLVERS = ("barrier", "tetrahedra")
PROGRESS = ("auto", "none", "json")


class Option(NamedTuple):
    """A keyword: the kind of its value, its default in words, and the table of a job file."""

    kind: str
    default: Optional[str] = None
    choices: Tuple[str, ...] = ()
    table: Optional[str] = None
    #: What ``True`` stands for.
    alone: Any = None


#: Every option of ``phex mesh``, in its order; kinds are explained in :func:`checked`.
MESH: Dict[str, Option] = {
    "output": Option("path"),
    "panels": Option("size", "500, or as many as the largest sheet, edge or area asks for"),
    "edge_length": Option("length"),
    "method": Option("choice", "lattice", METHODS),
    "effort": Option("choice", "normal", EFFORTS),
    "any_domain": Option("flag"),
    "quadric": Option("numbers", "the unit sphere about a centre away from all tangent planes"),
    "regularise": Option("positive"),
    "minimal": Option("flag"),
    "regular": Option("flag"),
    "rotate": Option("number"),
    "adaptive": Option("positive", alone=0.4),
    "size_field": Option("sizes"),
    "boundary": Option("choice", "snap; with `koebe`: whole", BOUNDARIES),
    "symmetry": Option("symmetry", "none", SYMMETRIES),
    "repeat": Option("length"),
    "target": Option("choice", "smooth", TARGETS),
    "unit": Option("choice", "m", UNITS),
    "all_components": Option("flag"),
    "seed": Option("count", "0"),
    "threads": Option("count", "all cores"),
    "config": Option("path"),
    "start": Option("mesh"),
    "until": Option("choice", choices=STAGES),
    "max_deviation": Option("length", "0.5%"),
    "planarity": Option("length", "1e-12, or rounding"),
    "fix": Option("rows", table="steering"),
    "curve": Option("lines", table="steering"),
    "ground": Option("plane", table="steering", alone="lowest"),
    "ground_reach": Option("number", "0.5, or less: no farther than the largest deviation", table="steering"),
    "anchors": Option("rows", table="steering"),
    "fairness": Option("positive", table="steering"),
    "closeness": Option("positive", table="steering"),
    "clearance": Option("positive", table="steering"),
    "centres": Option("number", table="steering"),
    "solver": Option("choice", "barrier", SOLVERS, "steering"),
    "guide": Option("lines", table="guides"),
    "crease": Option("positive", table="guides", alone=30.0),
    "cones": Option("rows", table="guides"),
    "max_panel": Option("rectangle", table="limits"),
    "min_edge": Option("length", table="limits"),
    "max_edge": Option("length", table="limits"),
    "min_angle": Option("positive", table="limits"),
    "max_area": Option("area", table="limits"),
    "max_aspect": Option("positive", table="limits"),
    "min_dihedral": Option("positive", table="limits"),
    "max_dihedral": Option("positive", table="limits"),
    "write_target": Option("path"),
    "contact_sheet": Option("path"),
    "keep_invalid": Option("flag"),
    "report": Option("path"),
    "png": Option("path"),
    "html": Option("path"),
    "keep_best": Option("flag"),
    "time_limit": Option("time"),
    "progress": Option("choice", "auto", PROGRESS),
    "quiet": Option("flag"),
    "verbose": Option("flag"),
}

#: Options that are no settings of a job.
NO_SETTINGS = frozenset(
    "output config start until write_target contact_sheet keep_invalid report png html keep_best time_limit progress"
    " quiet verbose".split()
)
STEERING = tuple(name for name, option in MESH.items() if option.table == "steering")


def checked(name: str, value: Any, option: Option) -> Any:
    """A value that JSON can hold, if it is of the option's kind.

    ``count``: a whole number from 0, ``size`` from 1; ``number``, ``positive``; ``length``: a number or a text such
    as ``"20mm"``, ``"0.5%"``; ``choice``; ``symmetry``: a choice or a whole number; ``flag``;
    ``path``; ``numbers``: a list of them; ``plane``: ``"lowest"``, a height, or six numbers;
    ``rectangle``: two lengths; ``area``.
    """
    if value is True and option.alone is not None:
        return option.alone
    if option.kind == "flag":
        if isinstance(value, (bool, np.bool_)):
            return bool(value)
        raise _wrong(name, value, "True or False")
    if option.kind == "count":
        most, least = (65535, 1) if name == "threads" else ((1 << 64) - 1, 0)
        return whole(name, value, most, least)
    if option.kind == "size":
        return whole(name, value, least=1)
    if option.kind in ("number", "positive"):
        number = real(name, value)
        if option.kind == "positive" and not number > 0.0:
            raise _wrong(name, value, "a positive number")
        return number
    if option.kind in ("length", "time"):
        return measured(name, value, TIME if option.kind == "time" else LENGTH)
    if option.kind == "area":
        return measured(name, value, AREA)
    if option.kind == "rectangle":
        return _rectangle(name, value)
    if option.kind == "choice":
        if isinstance(value, str) and value in option.choices:
            return str(value)
        raise _wrong(name, value, "one of " + ", ".join(option.choices))
    if option.kind == "symmetry":
        if isinstance(value, str) and (value in option.choices or value.isdecimal()):
            return value
        if isinstance(value, numbers.Integral) and not isinstance(value, bool):
            return str(whole(name, value))
        raise _wrong(name, value, "one of " + ", ".join(option.choices) + ", or a whole number")
    if option.kind == "path":
        return path_text(value, name)
    if option.kind == "numbers":
        ten = checked_numbers(value, name).tolist()
        if len(ten) == 10:
            return ten
        raise _wrong(name, value, "a list of ten numbers")
    if option.kind == "plane":
        return _plane(name, value)
    raise AssertionError(option.kind)


def whole(name: str, value: Any, most: int = (1 << 63) - 1, least: int = 0) -> int:
    """A whole number from ``least`` to ``most``."""
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        if least <= value <= most:
            return int(value)
    raise _wrong(name, value, f"a whole number from {least} to {most}")


def real(name: str, value: Any) -> float:
    """A finite number."""
    if isinstance(value, numbers.Real) and not isinstance(value, (bool, np.bool_)):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isfinite(number):
            return number
    raise _wrong(name, value, "a finite number")


#: Units are written small, as in job files.
NUMBER = r"[+]?(\d+[.]?\d*|[.]\d+)([eE][+-]?\d+)?"
LENGTH = re.compile(rf"\s*{NUMBER}\s*(mm|cm|m|in|ft|%)?\s*", re.ASCII)
AREA = re.compile(rf"\s*{NUMBER}\s*((mm|cm|m|in|ft)[2²])?\s*", re.ASCII)
TIME = re.compile(rf"\s*{NUMBER}\s*(s|min|h)?\s*", re.ASCII)


def measured(name: str, value: Any, form: Any = LENGTH) -> Any:
    """A length (or time) as text with or without a unit, or as number; it is not negative."""
    wanted = {
        LENGTH: "a length such as 0.5, '20mm' or '1%'",
        AREA: "an area such as 2.5 or '2.5m2'",
        TIME: "a time such as '90s'",
    }[form]
    if isinstance(value, str):
        if form.fullmatch(value):
            return str(value)
        raise _wrong(name, value, wanted)
    number = real(name, value)
    if number < 0.0:
        raise _wrong(name, value, wanted)
    return number


def _rectangle(name: str, value: Any) -> str:
    """Two sides, as text or as a pair of lengths."""
    sides = re.split("[xX×]", value) if isinstance(value, str) else value
    try:
        first, second = sides
    except Exception:  # whatever a foreign object does
        raise _wrong(name, value, RECTANGLE) from None
    both = (measured(name, side) for side in (first, second))
    return "x".join(side if isinstance(side, str) else repr(side) for side in both)


def sheet(value: Any) -> Any:
    """A sheet, as text or as a pair of lengths; what is no sheet is told by the compiled part."""
    if isinstance(value, str):
        return value
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise _wrong("sheet", value, "a sheet such as '1250x2500' or (1250, 2500)")
    return [measured("sheet", side) for side in value]


RECTANGLE = "two sides, such as '1.5x3.0m' or (1.5, 3.0)"


def _plane(name: str, value: Any) -> str:
    if isinstance(value, str):
        parts = value.split(",")
        try:
            is_plane = value == "lowest" or (len(parts) in (1, 6) and all(map(_finite, parts)))
        except ValueError:
            is_plane = False
        if not is_plane:
            raise _wrong(name, value, PLANE)
        return str(value)
    if isinstance(value, numbers.Real):
        return repr(real(name, value))
    plane = checked_numbers(value, name).tolist()
    if len(plane) != 6:
        raise _wrong(name, value, PLANE)
    return ",".join(map(repr, plane))


PLANE = "'lowest', a height, or a point and a normal (six numbers)"


def _finite(text: str) -> bool:
    return math.isfinite(float(text))


def _wrong(name: str, value: Any, wanted: str) -> InputError:
    return InputError(f"{name}: {shown(value)} is not {wanted}")


def settings(options: Dict[str, Any]) -> Tuple[Dict[str, Any], Dict[str, Any], Any]:
    """Settings as in a job file, values that files would hold, and sizes at the vertices."""
    typed: Dict[str, Any] = {"steering": {}, "guides": {}, "limits": {}}
    given: Dict[str, Any] = {}
    sizes = None
    for name, value in options.items():
        option = MESH[name]
        if value is None or name in NO_SETTINGS:
            continue
        where = typed[option.table] if option.table else typed
        key = name.replace("_", "-")
        if option.kind in ("sizes", "rows", "lines") and is_path(value):
            where[key] = path_text(value, name)
        elif option.kind == "sizes":
            sizes = checked_numbers(value, name)
        elif option.kind == "rows":
            given[name] = rows(name, value)
        elif option.kind == "lines":
            given[name] = polylines(name, value)
        else:
            where[key] = checked(name, value, option)
    return typed, given, sizes


def rows(name: str, value: Any) -> Any:
    """Lists of numbers: points, points with a weight or an index, or vertex numbers."""
    try:
        entries = list(value)
    except Exception:  # whatever a foreign object does
        raise _wrong(name, value, "a path or a list of points") from None
    return [
        [real(name, e)] if isinstance(e, numbers.Real) else checked_numbers(e, name).tolist()
        for e in entries
    ]


def polylines(name: str, value: Any) -> Any:
    """One polyline (n, 3), or a list of them."""
    try:
        lines = list(value)
        # Its first point is no polyline: its coordinates are numbers.
        if lines and all(isinstance(x, numbers.Real) for x in lines[0]):
            lines = [lines]
    except Exception:  # whatever a foreign object does
        raise _wrong(name, value, "a path, a polyline or a list of polylines") from None
    return [checked_vertices(line, name).tolist() for line in lines]


def threads(value: Any) -> Optional[int]:
    """A number of threads."""
    return None if value is None else whole("threads", value, 65535, least=1)

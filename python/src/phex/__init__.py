"""Planar hexagonal meshes of free-form surfaces.

>>> import phex
>>> sphere = phex.shape("sphere", triangles=2000)
>>> made = phex.mesh(sphere, panels=32, max_deviation="5%", progress=False)
>>> made.verdict, len(made.faces) > 25
('pass', True)
>>> made.per_face("area").shape == (len(made),)
True
"""

import importlib
from typing import TYPE_CHECKING, Any, List

if TYPE_CHECKING:
    from ._compute import Future
    from ._errors import Cancelled, InputError, InternalError, NoValidResult, PhexError
    from ._explore import Exploration, explore
    from ._functions import (
        Fabrication,
        Network,
        Offset,
        Session,
        check,
        convert,
        fabricate,
        koebe,
        mesh,
        network,
        offset,
        parallel,
        planarize,
        shape,
        shapes,
        start,
    )
    from ._mesh import Mesh, Panelling, Polygons, Surface
    from ._phex import __version__
    from ._studies import Between, Study, linspace, solve, sweep

#: Where each name is: a module is imported when something of it is first used, since most of the
#: time that an import takes is numpy's.
_MODULES = {
    "_compute": ("Future",),
    "_errors": ("Cancelled", "InputError", "InternalError", "NoValidResult", "PhexError"),
    "_explore": ("Exploration", "explore"),
    "_functions": (
        "Fabrication",
        "Network",
        "Offset",
        "Session",
        "check",
        "convert",
        "fabricate",
        "koebe",
        "mesh",
        "network",
        "offset",
        "parallel",
        "planarize",
        "shape",
        "shapes",
        "start",
    ),
    "_mesh": ("Mesh", "Panelling", "Polygons", "Surface"),
    "_phex": ("__version__",),
    "_studies": ("Between", "Study", "linspace", "solve", "sweep"),
}
_PLACES = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "Between",
    "Cancelled",
    "Exploration",
    "Fabrication",
    "Future",
    "InputError",
    "InternalError",
    "Mesh",
    "Network",
    "NoValidResult",
    "Offset",
    "Panelling",
    "PhexError",
    "Polygons",
    "Session",
    "Study",
    "Surface",
    "__version__",
    "check",
    "convert",
    "explore",
    "fabricate",
    "koebe",
    "linspace",
    "mesh",
    "network",
    "offset",
    "parallel",
    "planarize",
    "shape",
    "shapes",
    "solve",
    "start",
    "sweep",
]


def __getattr__(name: str) -> Any:
    if name == "interop":
        return importlib.import_module(".interop", __name__)
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_PLACES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> List[str]:
    return sorted({*globals(), *__all__, "interop"})

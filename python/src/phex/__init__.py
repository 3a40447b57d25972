"""Planar hexagonal meshes of free-form surfaces.

>>> import phex
>>> sphere = phex.shape("sphere", triangles=2000)
>>> made = phex.mesh(sphere, panels=32, max_deviation="5%", progress=False)
>>> made.verdict, len(made.faces) > 25
('pass', True)
>>> made.per_face("area").shape == (len(made),)
True
"""

from ._compute import Future
from ._errors import Cancelled, InputError, InternalError, NoValidResult, PhexError
from ._functions import (
    Fabrication,
    Network,
    Offset,
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

__all__ = [
    "Cancelled",
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
    "Surface",
    "__version__",
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
]

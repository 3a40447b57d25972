"""Meshes of phex in other libraries. Each module imports its library when it is used."""

import importlib
from typing import Any, List

__all__ = ["compas", "pyvista", "rhino3dm", "trimesh"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return importlib.import_module(f".{name}", __name__)


def __dir__() -> List[str]:
    return sorted({*globals(), *__all__})

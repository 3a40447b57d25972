"""Files that are written: checked before a long computation, written whole or not at all."""

import os
from typing import Any, Dict, Iterable, Optional

from ._compute import run
from ._phex import write_whole as write_whole

#: Formats that the compiled part writes.
MESH_FORMATS = (".obj", ".ply", ".off", ".stl", ".json", ".dxf", ".glb", ".3mf")


def check_writable(
    paths: Dict[str, str],
    inputs: Iterable[str] = (),
    settings: Optional[Dict[str, Any]] = None,
    config: Optional[str] = None,
) -> None:
    """Refuses files that can't be written, that are written twice or read, by the program's rules;
    folders that are missing are made when they are written.

    ``paths`` are those of files by the keywords that ask for them; settings and a job file name
    inputs, too.
    """
    outputs = [[name, path, _kind(name, path)] for name, path in paths.items()]
    request = {"outputs": outputs, "inputs": list(inputs), "config": config}
    run("outputs", {**request, "settings": settings or {}})


def _kind(name: str, path: str) -> str:
    if name in MESH_FILES:
        return "other" if os.path.splitext(path)[1].lower() == ".3dm" else "mesh"
    return {"png": "picture", "html": "page"}.get(name, "other")


#: Keywords of meshes; what others name has any extension.
MESH_FILES = ("output", "write_target")

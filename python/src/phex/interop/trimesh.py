"""trimesh: triangles; ``face_attributes["face"]`` says which face each was cut from."""

from typing import Any

import numpy as np

from .._errors import InputError
from .._mesh import Mesh, Polygons, no_polygons


def to_trimesh(mesh: Polygons) -> Any:
    """A ``trimesh.Trimesh`` with the same vertices in the same order.

    >>> import phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> bool(made.to_trimesh().is_watertight)
    True
    """
    import trimesh

    triangles, face = mesh.triangles()
    return trimesh.Trimesh(
        vertices=mesh.vertices.copy(),
        faces=triangles,
        face_attributes={"face": face},
        process=False,
    )


def from_trimesh(mesh: Any, kind: Any = Mesh) -> Any:
    """Ours of a trimesh: its triangles, or the faces that :func:`to_trimesh` cut, if the mesh says
    which triangles belong together.

    >>> import phex, trimesh
    >>> len(phex.interop.trimesh.from_trimesh(trimesh.creation.box()))
    12
    """
    if not hasattr(mesh, "faces"):
        raise no_polygons(mesh, "mesh")
    triangles = np.asarray(mesh.faces)
    face = getattr(mesh, "face_attributes", {}).get("face")
    if face is None:
        return kind(np.asarray(mesh.vertices), triangles)
    if len(face) != len(triangles):
        told = f"{len(face)} values for {len(triangles)} triangles"
        raise InputError(f'face_attributes["face"] has {told}')
    order = np.argsort(face, kind="stable")
    names, first = np.unique(np.asarray(face)[order], return_index=True)
    groups = zip(names, np.split(triangles[order], first[1:]))
    return kind(np.asarray(mesh.vertices), [outline(k, group) for k, group in groups])


def outline(name: Any, triangles: Any) -> Any:
    """The corners round the triangles of a group that make one polygon.

    Raises :class:`phex.InputError` if they make none."""
    sides = [(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)]
    inner = set(sides)
    outer = [(a, b) for a, b in sides if (b, a) not in inner]
    after = dict(outer)
    corners = [outer[0][0]] if outer else []
    while len(corners) < len(after) and after.get(corners[-1], corners[0]) != corners[0]:
        corners.append(after[corners[-1]])
    # A corner that is met twice, a hole or a second part leaves sides over.
    if not corners or len(corners) != len(outer) or after.get(corners[-1]) != corners[0]:
        raise InputError(
            f'the {len(triangles)} triangles of face_attributes["face"] {name} make no polygon '
            "without holes: give each polygon a number of its own, or leave the attribute out"
        )
    return corners

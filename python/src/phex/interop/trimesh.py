"""trimesh: triangles; ``face_attributes["face"]`` says which face each was cut from."""

from typing import Any

import numpy as np

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
    groups = [triangles[np.asarray(face) == k] for k in np.unique(face)]
    return kind(np.asarray(mesh.vertices), [outline(group) for group in groups])


def outline(triangles: Any) -> Any:
    """The corners round a few triangles that make one polygon."""
    sides = [(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)]
    inner = set(sides)
    after = {a: b for a, b in sides if (b, a) not in inner}
    first = next(iter(after))
    corners = [first]
    while after[corners[-1]] != first:
        corners.append(after[corners[-1]])
    return corners

"""COMPAS: ``compas.datastructures.Mesh`` with what is known of each panel as face attributes."""

from typing import Any

import numpy as np

from .._mesh import Mesh, Panelling, Polygons


def to_compas(mesh: Polygons) -> Any:
    """A COMPAS mesh; a panelling's faces have the attributes ``panel`` (its number), ``area``,
    ``planarity`` and ``sound``. COMPAS keeps no vertex that no face uses apart, and so do we.

    >>> import phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> made.to_compas().number_of_faces() == len(made)
    True
    """
    from compas.datastructures import Mesh as CompasMesh

    faces = [face.tolist() for face in mesh.faces]
    made = CompasMesh.from_vertices_and_faces(mesh.vertices.tolist(), faces)
    made.name = mesh.name
    if isinstance(mesh, Mesh):
        bad = set()
        if isinstance(mesh, Panelling):
            checks = [c for c in mesh.report["checks"] if c["decisive"] and not c["pass"]]
            bad = {int(f) for check in checks for f in check["faces"]}
        area, planarity = mesh.per_face("area"), mesh.per_face("planarity")
        for k, face in enumerate(made.faces()):
            made.face_attribute(face, "panel", k)
            made.face_attribute(face, "area", float(area[k]))
            made.face_attribute(face, "planarity", float(planarity[k]))
            made.face_attribute(face, "sound", k not in bad)
    return made


def from_compas(mesh: Any, kind: Any = Mesh) -> Any:
    """Ours of a COMPAS mesh; vertices and faces in its order.

    >>> from compas.datastructures import Mesh
    >>> from phex.interop.compas import from_compas
    >>> len(from_compas(Mesh.from_polyhedron(12)))
    12
    """
    vertices, faces = mesh.to_vertices_and_faces()
    return kind(np.asarray(vertices, dtype=np.float64), faces, mesh.name or "")

"""pyvista: ``PolyData`` that keeps polygons; ``cell_data`` has the area of each."""

from typing import Any

import numpy as np

from .._mesh import Mesh, Polygons, no_polygons


def to_pyvista(mesh: Polygons) -> Any:
    """A ``pyvista.PolyData`` with one cell for each face.

    >>> import phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> made.to_pyvista().n_cells == len(made)
    True
    """
    import pyvista

    counts = np.diff(mesh.offsets)
    padded = np.insert(mesh.corners.astype(np.int64), mesh.offsets[:-1], counts)
    made = pyvista.PolyData(mesh.vertices.copy(), padded)
    if isinstance(mesh, Mesh):
        made.cell_data["panel"] = np.arange(len(mesh))
        made.cell_data["area"] = mesh.per_face("area")
    return made


def from_pyvista(mesh: Any, kind: Any = Mesh) -> Any:
    """Ours of a ``pyvista.PolyData``.

    >>> import pyvista
    >>> from phex.interop.pyvista import from_pyvista
    >>> len(from_pyvista(pyvista.Cube()))
    6
    """
    if not hasattr(mesh, "GetPolys"):
        raise no_polygons(mesh, "mesh")
    cells = mesh.GetPolys()
    from pyvista import convert_array

    offsets = np.asarray(convert_array(cells.GetOffsetsArray()))
    corners = np.asarray(convert_array(cells.GetConnectivityArray()))
    return kind.from_corners(np.asarray(mesh.points, dtype=np.float64), corners, offsets)

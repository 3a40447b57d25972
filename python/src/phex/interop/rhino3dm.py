"""Rhino: geometry by RhinoCommon inside Rhino, else by rhino3dm, and ``.3dm`` files.

Curves and breps hold full precision; Rhino's meshes are single precision, so outlines and planar
breps are the main output. Triangles are ears of the panels: fans are wrong on concave ones.
"""

import json
import os
import tempfile
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from .._compute import run
from .._errors import InputError
from .._mesh import Mesh, Polygons, model_unit, no_polygons
from .._output import write_whole

#: Layers below ``phex``, with their colours.
LAYERS = {
    "outlines": (20, 20, 20, 255),
    "panels": (210, 225, 240, 255),
    "mesh": (180, 180, 180, 255),
    "labels": (200, 60, 30, 255),
}
UNITS = {"mm": "Millimeters", "cm": "Centimeters", "m": "Meters", "in": "Inches", "ft": "Feet"}


def geometry() -> Any:
    """``Rhino.Geometry`` inside Rhino, else ``rhino3dm``."""
    try:
        import Rhino.Geometry

        return Rhino.Geometry
    except ImportError:
        pass
    try:
        import rhino3dm

        return rhino3dm
    except ImportError:
        raise InputError("this needs rhino3dm (pip install phex[rhino]), or Rhino") from None


def document_unit() -> Optional[str]:
    """The unit of the document that is open in Rhino; ``None`` outside Rhino, and where the
    document has none."""
    try:
        import Rhino
    except ImportError:
        return None
    document = Rhino.RhinoDoc.ActiveDoc
    name = "None" if document is None else str(document.ModelUnitSystem)
    if name in ("None", "Unset"):
        return None
    for unit, known in UNITS.items():
        if name == known:
            return unit
    raise InputError(f"the document is in {name}: phex knows {', '.join(UNITS)}")


def library(path: str) -> Any:
    """``rhino3dm``, which writes files."""
    try:
        import rhino3dm
    except ImportError:
        raise InputError(f"{path}: .3dm needs rhino3dm (pip install phex[rhino])") from None
    return rhino3dm


def names(mesh: Polygons) -> List[str]:
    """The names that the workshop gives to the panels: ``A1`` where they lie in rows, else ``P0001``."""
    try:
        return list(json.loads(run("names", {}, mesh)["names"]))
    except InputError:  # what is no mesh for a workshop has numbers still
        return [f"P{k + 1:04d}" for k in range(len(mesh))]


def outlines(mesh: Polygons) -> List[Any]:
    """A closed polyline curve for each face."""
    g = geometry()
    return [_outline(g, mesh.vertices[face]) for face in mesh.faces]


def _outline(g: Any, corners: Any) -> Any:
    points = [g.Point3d(*map(float, p)) for p in (*corners, corners[0])]
    return g.PolylineCurve(points)


def panels(mesh: Polygons) -> List[Any]:
    """A planar brep for each face; ``None`` where Rhino makes none, the face being bent."""
    g = geometry()
    return [_panel(g, mesh.vertices[face]) for face in mesh.faces]


def _panel(g: Any, corners: Any) -> Any:
    centre = corners.mean(axis=0)
    normal = np.zeros(3)
    for k in range(len(corners)):
        normal += np.cross(corners[k - 1] - centre, corners[k] - centre)
    plane = g.Plane(g.Point3d(*map(float, centre)), g.Vector3d(*map(float, normal)))
    outline = _outline(g, corners)
    if hasattr(g.Brep, "CreateTrimmedPlane"):
        return g.Brep.CreateTrimmedPlane(plane, outline)
    return g.Brep.CreatePlanarBreps(outline, 1e-6)[0]


def rhino_mesh(mesh: Polygons) -> Any:
    """One Rhino mesh of all ears, single precision."""
    g = geometry()
    made = g.Mesh()
    for point in mesh.vertices:
        made.Vertices.Add(*map(float, point))
    for a, b, c in mesh.triangles()[0].tolist():
        made.Faces.AddFace(a, b, c)
    made.Normals.ComputeNormals()
    return made


def save_3dm(
    mesh: Polygons,
    path: str,
    unit: Optional[str] = None,
    labels: Optional[Sequence[str]] = None,
    text: Optional[Dict[str, Sequence[Any]]] = None,
) -> None:
    """Writes a ``.3dm`` file: outlines, planar breps, triangles and labels on layers below ``phex``.

    ``unit`` is that of the coordinates (default: that of the mesh's run, else ``m``), ``labels``
    are the panels' names, ``text`` user text for each panel by key. Corners of curves and breps are
    exact.

    >>> import phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> made.save("out/sphere.3dm")

    Raises :class:`phex.InputError` if rhino3dm is missing or the file can't be written.
    """
    r = library(path)
    unit = model_unit(unit, mesh) or "m"
    named = list(labels) if labels is not None else names(mesh)
    if len(named) != len(mesh):
        raise InputError(f"labels: {len(named)} for {len(mesh)} panels")
    file = r.File3dm()
    file.ApplicationName = "phex"
    file.Settings.ModelUnitSystem = getattr(r.UnitSystem, UNITS[unit])
    layers = _layers(r, file)
    told = {"corners": np.diff(mesh.offsets).tolist(), **(text or {})}
    for k, face in enumerate(mesh.faces):
        corners = mesh.vertices[face]
        words = {key: values[k] for key, values in told.items()}
        file.Objects.AddCurve(_outline(r, corners), _named(r, layers["outlines"], named[k], words))
        brep = _panel(r, corners)
        if brep is not None:
            file.Objects.AddBrep(brep, _named(r, layers["panels"], named[k], words))
        centre = r.Point3d(*map(float, corners.mean(axis=0)))
        # rhino3dm makes text dots without attributes, on the current layer.
        dot = r.TextDot(named[k], centre)
        file.Objects.Add(dot, _named(r, layers["labels"], named[k], {}))
    file.Objects.AddMesh(rhino_mesh(mesh), _named(r, layers["mesh"], mesh.name, {}))
    with tempfile.TemporaryDirectory() as folder:
        whole = os.path.join(folder, "panels.3dm")
        if not file.Write(whole, 8):
            raise InputError(f"{path}: can't be written")
        with open(whole, "rb") as made:
            write_whole(path, made.read())


def _layers(r: Any, file: Any) -> Dict[str, int]:
    root = r.Layer()
    root.Name = "phex"
    parent = file.Layers[file.Layers.Add(root)].Id
    made = {}
    for name, colour in LAYERS.items():
        layer = r.Layer()
        layer.Name, layer.Color, layer.ParentLayerId = name, colour, parent
        made[name] = file.Layers.Add(layer)
    return made


def _named(r: Any, layer: int, name: str, text: Dict[str, Any]) -> Any:
    attributes = r.ObjectAttributes()
    attributes.LayerIndex, attributes.Name = layer, str(name)
    for key, value in text.items():
        attributes.SetUserString(key, str(value))
    return attributes


def read_3dm(path: str, kind: Any = Mesh) -> Any:
    """The outlines on the layer ``phex::outlines`` as one mesh; corners that are the same point,
    bit for bit, are one vertex.

    >>> from phex.interop.rhino3dm import read_3dm
    """
    import rhino3dm as r

    file = r.File3dm.Read(path)
    if file is None:
        raise InputError(f"{path}: no .3dm file")
    index = {layer.Index for layer in file.Layers if layer.FullPath == "phex::outlines"}
    faces = []
    for thing in file.Objects:
        if thing.Attributes.LayerIndex in index:
            curve = thing.Geometry
            points = [curve.Point(k) for k in range(curve.PointCount - 1)]
            faces.append([(p.X, p.Y, p.Z) for p in points])
    return kind(*_joined(faces))


def _joined(faces: Any) -> Tuple[Any, Any]:
    numbers: Dict[Any, int] = {}
    lists = [[numbers.setdefault(p, len(numbers)) for p in face] for face in faces]
    return np.array(list(numbers)).reshape(-1, 3), lists


def from_rhino(given: Any, kind: Any = Mesh, tolerance: Optional[float] = None) -> Any:
    """Ours of a Rhino mesh, or of a brep or surface, which Rhino itself meshes: in RhinoCommon to
    ``tolerance`` (model units; default 0.1 % of the diagonal), in rhino3dm by the render meshes
    that the file holds."""
    g = geometry()
    if isinstance(given, g.Mesh):
        return kind(*_mesh_arrays(given))
    if not isinstance(given, g.Brep) and not hasattr(given, "ToBrep"):
        raise no_polygons(given, "geometry")
    brep = given if isinstance(given, g.Brep) else given.ToBrep()
    parts = _meshed(g, brep, tolerance)
    if not parts:
        raise InputError("the brep has no mesh: save it shaded, or give a mesh")
    points, faces = [], []
    for part in parts:
        vertices, own = _mesh_arrays(part)
        first = sum(map(len, points))
        points.append(vertices)
        faces += [[v + first for v in face] for face in own]
    return kind(*welded(np.concatenate(points), faces))


def _meshed(g: Any, brep: Any, tolerance: Optional[float]) -> List[Any]:
    if g.__name__ == "rhino3dm":
        kind = g.MeshType.Any
        parts = [brep.Faces[k].GetMesh(kind) for k in range(len(brep.Faces))]
        return [part for part in parts if part is not None]
    size = brep.GetBoundingBox(True).Diagonal.Length
    how = g.MeshingParameters()
    how.Tolerance = tolerance or 1e-3 * size
    how.MaximumEdgeLength = 0.02 * size
    how.JaggedSeams, how.RefineGrid = False, True
    return list(g.Mesh.CreateFromBrep(brep, how))


def _mesh_arrays(given: Any) -> Tuple[Any, List[List[int]]]:
    count = given.Vertices.Count if hasattr(given.Vertices, "Count") else len(given.Vertices)
    at = given.Vertices
    double = getattr(at, "Point3dAt", at.__getitem__)
    points = [double(k) for k in range(count)]
    vertices = np.array([[p.X, p.Y, p.Z] for p in points], dtype=np.float64).reshape(-1, 3)
    faces = []
    for k in range(given.Faces.Count):
        face = given.Faces[k]
        corners = [face.A, face.B, face.C, face.D] if hasattr(face, "A") else list(face)
        faces.append(corners[:3] if corners[2] == corners[3] else corners)
    return vertices, faces


def welded(vertices: Any, faces: Any) -> Tuple[Any, Any]:
    """Vertices that are nearer than 1e-6 of the diagonal are one; faces of less than three corners
    go."""
    size = np.linalg.norm(np.ptp(vertices, axis=0)) or 1.0
    keys = np.round(vertices / (1e-6 * size)).astype(np.int64)
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    number = number.reshape(-1)
    kept = []
    for face in faces:
        corners = [int(number[v]) for v in face]
        corners = [c for k, c in enumerate(corners) if c != corners[k - 1]]
        if len(corners) >= 3:
            kept.append(corners)
    return vertices[first], kept

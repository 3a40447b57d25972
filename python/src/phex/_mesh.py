"""Surfaces, meshes of panels, and panellings: meshes with a report."""

import base64
import html
import json
import os
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from ._arrays import checked_corners, checked_faces, checked_vertices, is_path, path_text, shown
from ._compute import no_valid, run
from ._errors import InputError
from ._options import UNITS, Option, checked, real, whole
from ._output import MESH_FORMATS, write_whole


class Polygons:
    """Vertices and polygons. Arrays are copies and refuse to be written to.

    ``vertices`` is (n, 3) float64, in model units; ``faces`` an integer array (m, k) or a list of
    lists of vertex numbers, from 0. float32 and int32 are taken, too.

    >>> import phex
    >>> square = phex.Surface([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> square.corners, square.offsets
    (array([0, 1, 2, 3], dtype=uint32), array([0, 4]))

    Raises :class:`phex.InputError` that names the vertex or face which can't be used.
    """

    #: Unit of the coordinates, where it is known.
    _unit: Optional[str] = None

    def __init__(self, vertices: Any, faces: Any, name: str = "") -> None:
        if not isinstance(name, str):
            raise InputError(f"name: {shown(name)} is no text")
        points = checked_vertices(vertices)
        corners, offsets = checked_faces(faces, len(points))
        self._set(points, corners, offsets, name)

    def _set(self, vertices: Any, corners: Any, offsets: Any, name: str = "") -> None:
        self._vertices, self._corners, self._offsets = vertices, corners, offsets
        for array in (vertices, corners, offsets):
            array.setflags(write=False)
        self.name = name or type(self).__name__.lower()
        self._sha256 = ""

    @classmethod
    def from_corners(cls, vertices: Any, corners: Any, offsets: Any, name: str = "") -> Any:
        """From flat arrays: face ``k`` has ``corners[offsets[k]:offsets[k + 1]]``."""
        points = checked_vertices(vertices)
        flat, ends = checked_corners(corners, offsets, len(points))
        return cls._of((points, flat, ends), name)

    @classmethod
    def _of(cls, arrays: Any, name: str = "") -> Any:
        made = cls.__new__(cls)
        made._set(*arrays, name)
        return made

    @classmethod
    def read(cls, path: Union[str, "os.PathLike[str]"]) -> Any:
        """From a file: OBJ, PLY, STL or OFF."""
        name = path_text(path, "path")
        read = run("read", {"path": name})
        made = cls._of(read["mesh"], name)
        made._sha256 = read["sha256"]
        return made

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Positions (n, 3), model units."""
        return self._vertices

    @property
    def corners(self) -> NDArray[np.uint32]:
        """Vertex numbers of all faces, one after the other."""
        return self._corners

    @property
    def offsets(self) -> NDArray[np.int64]:
        """Where each face begins in ``corners``, and where the last one ends."""
        return self._offsets

    @property
    def faces(self) -> List[NDArray[np.uint32]]:
        """The vertex numbers of each face."""
        return np.split(self._corners, self._offsets[1:-1]) if len(self._offsets) > 1 else []

    def __len__(self) -> int:
        return len(self._offsets) - 1

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        return f"<phex.{type(self).__name__} {len(self)} faces, {len(self._vertices)} vertices>"

    def _read_from(self) -> List[str]:
        """The file that it was read from, if it was."""
        return [self.name] if self._sha256 else []

    def _given(self) -> Tuple[Any, ...]:
        return self.name, self._sha256, self._vertices, self._corners, self._offsets

    def __setstate__(self, state: Dict[str, Any]) -> None:
        self.__dict__.update(state)
        for array in (self._vertices, self._corners, self._offsets):
            array.setflags(write=False)

    def triangles(self) -> Tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The faces cut into triangles (t, 3), right for concave ones, and the face of each."""
        made = run("ears", {}, self)
        return made["mesh"][1].reshape(-1, 3).astype(np.int64), made["face"].astype(np.int64)

    def save(
        self, path: Union[str, "os.PathLike[str]"], *, unit: Optional[str] = None
    ) -> None:
        """Writes a file; the extension decides the format: OBJ, PLY, OFF, STL, COMPAS JSON, DXF,
        GLB, 3MF, or 3DM (with rhino3dm).

        ``unit`` (``"mm"``, ``"cm"``, ``"m"``, ``"in"``, ``"ft"``) is that of the coordinates: GLB
        and 3MF hold metres, and 3DM names it. Without it, it is that of the run which made the
        mesh, or else metres."""
        name = path_text(path, "path")
        unit = model_unit(unit, self) or "m"
        extension = os.path.splitext(name)[1].lower()
        if extension == ".3dm":
            from .interop.rhino3dm import save_3dm

            save_3dm(self, name, unit)
        elif extension not in MESH_FORMATS:
            raise InputError(f"path: {name} ends with none of {', '.join(self._endings())}")
        else:
            run("write", {"path": name, "unit": unit}, self)

    def _endings(self) -> Tuple[str, ...]:
        """The extensions of the files that it can become."""
        return (*MESH_FORMATS, ".3dm")

    def to_compas(self) -> Any:
        """A ``compas.datastructures.Mesh``; see :mod:`phex.interop.compas`."""
        from .interop.compas import to_compas

        return to_compas(self)

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh`` of triangles; see :mod:`phex.interop.trimesh`."""
        from .interop.trimesh import to_trimesh

        return to_trimesh(self)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` that keeps the polygons; see :mod:`phex.interop.pyvista`."""
        from .interop.pyvista import to_pyvista

        return to_pyvista(self)


class Surface(Polygons):
    """A surface that is to be covered: triangles, or polygons that are cut into some."""


class Mesh(Polygons):
    """A mesh of panels."""

    def _reference(self) -> Optional[Surface]:
        return None

    def _judged(self, name: str) -> Any:
        """The judgement of its run, where colours show it."""
        return None

    def per_face(self, name: str) -> NDArray[np.float64]:
        """A number for each face.

        ``area`` (model units), ``clearance`` (mean edges), ``planarity`` (mean edges),
        ``deviation`` (% of the diagonal; needs a surface), ``panel-area`` (mean areas),
        ``panel-aspect`` (length over width), ``corners`` (their number). The others are the numbers
        that colours of pictures stand for: ``curvature`` is the smaller principal curvature over
        the larger one (1 on spheres, 0 on cylinders, negative on saddles); ``feature-size`` the
        panel's length times the largest curvature there; ``valence`` the class of the number of
        corners, and ``validity`` that of what checks say, each with its colour in the legend.
        """
        if not isinstance(name, str):
            raise InputError(f"name: {shown(name)} is no text")
        if name == "corners":
            return np.diff(self._offsets).astype(np.float64)
        surface = self._reference()
        meshes = [self] if surface is None else [self, surface]
        values = run("values", {"name": name}, *meshes, kept=self._judged(name))["values"]
        if len(values) != len(self):
            raise InputError(f"`{name}` has a value for each edge, not for each face")
        return values  # type: ignore[no-any-return]

    def picture(
        self, color: str = "valence", svg: bool = False, **options: Any
    ) -> bytes:
        """A picture as PNG or SVG, without a display; ``options`` are those of ``phex render``:
        ``width``, ``height`` (16 to 16384 pixels), ``azimuth``, ``elevation``, ``edges``,
        ``legend``, ``ground``; and ``supersampling`` (1 to 8), samples per pixel and direction."""
        if not isinstance(color, str):
            raise InputError(f"color: {shown(color)} is no text")
        for name in ("width", "height"):
            if name in options:
                options[name] = whole(name, options[name], 16384, 16)
        for name in ("azimuth", "elevation"):
            if options.get(name) is not None:
                options[name] = real(name, options[name])
        for name in options:
            if name not in _PICTURE:
                raise TypeError(f"picture() got an unexpected keyword argument {name!r}")
        for name in ("edges", "legend", "ground"):
            if name in options:
                options[name] = _truth(name, options[name])
        if "supersampling" in options:
            options["supersampling"] = whole("supersampling", options["supersampling"], 8, 1)
        request = {"color": color, "svg": _truth("svg", svg), "options": options}
        surface = self._reference()
        meshes = [self] if surface is None else [self, surface]
        return run("picture", request, *meshes, kept=self._judged(color))["picture"]  # type: ignore[no-any-return]

    def save(
        self,
        path: Union[str, "os.PathLike[str]"],
        keep_invalid: bool = False,
        *,
        unit: Optional[str] = None,
    ) -> None:
        """Writes a file; the extension decides what: a mesh as :meth:`Polygons.save`, or a picture
        (PNG, SVG)."""
        name = path_text(path, "path")
        extension = os.path.splitext(name)[1].lower()
        if extension in (".png", ".svg"):
            write_whole(name, self.picture(svg=extension == ".svg"))
        else:
            super().save(name, unit=unit)

    def _endings(self) -> Tuple[str, ...]:
        return (*super()._endings(), ".png", ".svg")

    def _repr_png_(self) -> bytes:
        return self.picture(width=800, height=600)

    def offset(self, distance: Any = None, **options: Any) -> Any:
        """Layers of this mesh; see :func:`phex.offset`."""
        from ._functions import offset

        return offset(self, distance, **options)


class Panelling(Mesh):
    """A mesh with a report: what :func:`phex.mesh` and the others make."""

    _report_text: str
    _kept: Any

    @classmethod
    def _from_answer(cls, answer: Dict[str, Any], surface: Any, keep_invalid: bool) -> "Panelling":
        made: Panelling = cls._of(answer["mesh"])
        made._report_text = answer["report"]
        made._kept = answer["kept"]
        made._verdict = json.loads(answer["verdict"])
        made._keep_invalid = keep_invalid
        made._unit = made.report["unit"]
        made.surface = surface
        found = answer.get("basis")
        made.basis = None if found is None else found.reshape(-1, 5)
        target = answer["target"]
        made.target = None if target is None else Surface._of(target)
        if made.target is not None:
            made.target._unit = made._unit
        return made

    def __getstate__(self) -> Dict[str, Any]:
        state = self.__dict__.copy()
        kept = state.pop("_kept", None)
        if kept is not None:
            state["_copied"] = kept.arrays()
        return state

    _verdict: str
    _keep_invalid: bool
    #: Of a copy: the surface that it was judged by, and the panels before the last step.
    _copied: List[Any]
    #: The surface that was given, or ``None``.
    surface: Optional[Surface]
    #: See :func:`phex.parallel`, or ``None``.
    basis: Optional[NDArray[np.float64]]
    #: The smooth surface that the panels were fitted to, or ``None``.
    target: Optional[Surface]

    def _reference(self) -> Optional[Surface]:
        return self.target or self.surface

    @property
    def verdict(self) -> str:
        """``pass``, ``outside_tolerance`` or ``invalid``."""
        return self._verdict

    @property
    def sound(self) -> bool:
        """Whether the mesh is valid; a figure may be outside a tolerance."""
        return self._verdict != "invalid"

    @property
    def report(self) -> Dict[str, Any]:
        """The run report, as ``phex mesh --report`` writes it."""
        return json.loads(self._report_text)  # type: ignore[no-any-return]

    @property
    def offenders(self) -> Dict[str, List[int]]:
        """The ids of the elements that fail, by the names of the checks that fail."""
        checks = self.report["checks"]
        return {c["name"]: c["ids"] for c in checks if not c["pass"]}

    def __repr__(self) -> str:
        return f"<phex.Panelling {len(self)} panels, {self._verdict.upper()}>"

    def page(self, title: str = "", curves: bool = True) -> str:
        """The HTML report as a text: pictures, tables and, where it was built in, the interactive
        view."""
        if not isinstance(title, str):
            raise InputError(f"title: {shown(title)} is no text")
        curves = _truth("curves", curves)
        request = {"title": title or self.name, "command": "phex (Python)", "curves": curves}
        return run("page", request, kept=self._judgement())["page"]  # type: ignore[no-any-return]

    def _judged(self, name: str) -> Any:
        return self._judgement() if name == "validity" else None

    def _judgement(self) -> Any:
        """What is kept for pages and pictures."""
        if "_kept" not in self.__dict__:
            self._kept = self._judged_again()
        return self._kept

    def _judged_again(self) -> Any:
        """What a copy keeps for pages: judged by the limits of its report, which it takes up."""
        report = self.report
        none = (np.zeros((0, 3)), np.zeros(0, np.uint32), np.zeros(1, np.int64))
        surface, start = (Surface._of(none if a is None else a) for a in self._copied)
        meshes = [self, surface, self.target or Surface._of(none), start]
        limits = {"limits": {}, "promised": report["limits"], "job": None, "copied": report}
        return run("check", limits, *meshes)["kept"]

    def save(
        self,
        path: Union[str, "os.PathLike[str]"],
        keep_invalid: bool = False,
        *,
        unit: Optional[str] = None,
    ) -> None:
        """Writes a file; the extension decides what: a mesh as :meth:`Polygons.save`, a picture
        (PNG, SVG), or the report (HTML). A mesh that is not valid needs ``keep_invalid``."""
        name = path_text(path, "path")
        extension = os.path.splitext(name)[1].lower()
        if extension in (".html", ".htm"):
            self._save_page(name)
        elif extension in (".png", ".svg") or self.sound or keep_invalid or self._keep_invalid:
            super().save(name, unit=unit)
        else:
            raise no_valid(f"{name}: not written, since the mesh is not valid", self)

    def _endings(self) -> Tuple[str, ...]:
        return (*super()._endings(), ".html")

    def _save_page(self, path: str) -> None:
        write_whole(path, self.page(os.path.basename(path)).encode())

    def save_report(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the run report as JSON."""
        write_whole(path_text(path, "path"), self._report_text.encode())

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td style='text-align:left'>{html.escape(name)}</td>"
            f"<td style='text-align:left'>{html.escape(text)}</td></tr>"
            for name, text in self._figures()
        )
        png = base64.b64encode(self._repr_png_()).decode()
        return f"<table>{rows}</table><img width='640' src='data:image/png;base64,{png}'>"

    def _figures(self) -> Iterator[Tuple[str, str]]:
        report = self.report
        measures = report["measures"]
        yield "verdict", self._verdict.upper()
        yield "panels", str(measures["faces"])
        yield "planarity", f"max {measures['planarity']['max']:.1e} mean edges"
        yield "clearance", f"least {measures['clearance']['min']:.3f} mean edges"
        for name in ("deviation_smooth", "deviation_facets"):
            if report.get(name):
                yield name.replace("_", " "), f"max {100 * report[name]['deviation_max']:.3f} %"
        for name, ids in self.offenders.items():
            yield f"FAILED {name}", f"{len(ids)} elements, first {ids[:5]}"


#: Keywords of pictures.
_PICTURE = frozenset(
    "width height supersampling azimuth elevation edges legend ground".split()
)


def _truth(name: str, value: Any) -> bool:
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise InputError(f"{name}: {shown(value)} is not True or False")


def model_unit(given: Any, mesh: Polygons) -> Optional[str]:
    """The unit that is given, or else that of a mesh, where it is known."""
    if given is None:
        return mesh._unit
    return str(checked("unit", given, Option("choice", choices=UNITS)))


def as_polygons(given: Any, kind: Any, what: str) -> Any:
    """A surface or mesh from whatever holds one: ours, a path, ``(vertices, faces)``, or an object
    of COMPAS, trimesh, pyvista or Rhino."""
    if isinstance(given, Polygons):
        return given
    if is_path(given):
        return kind.read(given)
    if isinstance(given, (tuple, list)) and len(given) == 2:
        return kind(given[0], given[1])
    module = type(given).__module__.split(".")[0]
    if hasattr(type(given), "to_vertices_and_faces"):
        vertices, faces = given.to_vertices_and_faces()
        return kind(vertices, faces)
    if module == "pyvista" and hasattr(given, "GetPolys"):
        from .interop.pyvista import from_pyvista

        return from_pyvista(given, kind)
    if module == "trimesh" and hasattr(given, "vertices") and hasattr(given, "faces"):
        from .interop.trimesh import from_trimesh

        return from_trimesh(given, kind)
    if module in ("rhino3dm", "Rhino"):
        from .interop.rhino3dm import from_rhino

        return from_rhino(given, kind)
    raise no_polygons(given, what)


def no_polygons(given: Any, what: str) -> InputError:
    """The error of an object that holds no polygons."""
    kind = type(given)
    is_plain = kind.__module__ == "builtins"
    told = shown(given) if is_plain else f"an object of {kind.__module__}.{kind.__qualname__}"
    return InputError(f"{what}: {told} is no surface, mesh, path or (vertices, faces)")

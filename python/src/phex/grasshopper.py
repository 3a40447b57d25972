"""Components for Grasshopper in Rhino 8: all of their logic, so that a component is five lines.

A component calls a function of this module with its environment and its inputs. The computation
runs in the background: the function gives what is known now (nothing, then a preview, then the
result), writes progress onto the component, and asks Grasshopper to solve again a little later. A
change of an input cancels what ran.

Outside Rhino the same functions work with rhino3dm and any object that has ``Component``; that is
how they are tested.
"""

import hashlib
import json
from typing import Any, Callable, Dict, List, NamedTuple, Optional

import numpy as np

from . import _functions
from ._compute import Future
from ._errors import Cancelled, InputError, PhexError
from ._mesh import Mesh, Panelling, Polygons, Surface, as_polygons
from .interop.rhino3dm import (
    document_unit,
    from_rhino,
    geometry,
    names,
    outlines,
    panels,
    rhino_mesh,
)

#: Milliseconds after which a component that computes is solved again.
AGAIN = 250


class Shown(NamedTuple):
    """Outputs of a component: geometry of Rhino, and a text."""

    #: A closed polyline for each panel.
    outlines: List[Any]
    #: A planar brep for each panel.
    panels: List[Any]
    #: One Rhino mesh (single precision).
    mesh: Any
    #: Figures and failed checks, or the error.
    report: str
    #: The mesh of phex, for other components.
    phex: Optional[Mesh]


class _Run(NamedTuple):
    key: str
    future: Any


#: What each component computes, by its id.
_runs: Dict[str, _Run] = {}

NOTHING = Shown([], [], None, "", None)


def surface_of(given: Any, tolerance: Optional[float] = None) -> Surface:
    """A surface of a mesh, brep or surface of Rhino, or of what :func:`phex.mesh` takes."""
    module = type(given).__module__.split(".")[0]
    if module in ("rhino3dm", "Rhino"):
        return from_rhino(given, Surface, tolerance)  # type: ignore[no-any-return]
    return as_polygons(given, Surface, "Surface")  # type: ignore[no-any-return]


def mesh(
    ghenv: Any,
    surface: Any,
    panels: Any = None,
    run: bool = True,
    tolerance: Optional[float] = None,
    **options: Any,
) -> Shown:
    """The component Mesh: covers a surface with planar hexagonal panels."""
    try:
        options = _in_unit(options)
    except InputError as error:
        return _told(ghenv, NOTHING._replace(report=str(error)), "failed", error)
    return _background(
        ghenv,
        run and surface is not None,
        {"panels": panels, "tolerance": tolerance, **options},
        lambda: surface_of(surface, tolerance),
        lambda there: _functions.start(
            there, keep_invalid=True, panels=None if panels is None else int(panels), **options
        ),
    )


def planarize(ghenv: Any, mesh: Any, surface: Any = None, run: bool = True, **options: Any) -> Shown:
    """The component Planarize: makes the faces of a mesh planar."""
    mesh = _one_or_outlines(mesh)
    if not run or mesh is None:
        return _told(ghenv, NOTHING, "")
    there = None if surface is None else surface_of(surface)

    def work() -> Panelling:
        panels = _panels_of(mesh)
        how = _in_unit(options, panels)
        return _functions.planarize(panels, there, keep_invalid=True, progress=False, **how)

    return _now(ghenv, work)


def offset(ghenv: Any, mesh: Any, distance: Any, run: bool = True, **options: Any) -> List[Shown]:
    """The component Offset: a layer for each distance."""
    if not run or mesh is None or distance is None:
        return []
    try:
        panels = _panels_of(mesh)
        made = _functions.offset(panels, distance, **_in_unit(options, panels))
    except (PhexError, TypeError) as error:
        return [_told(ghenv, NOTHING._replace(report=str(error)), "failed", error)]
    return [_shown(layer) for layer in made.layers]


def fabricate(ghenv: Any, mesh: Any, folder: Any, run: bool = False, **options: Any) -> str:
    """The component Fabricate: writes the workshop's files, and says what they are."""
    if not run or mesh is None or not folder:
        return ""
    try:
        panels = _panels_of(mesh)
        given = {name: value for name, value in options.items() if value is not None}
        made = _functions.fabricate(panels, folder, progress=False, **_in_unit(given, panels))
    except (PhexError, TypeError) as error:
        return _told(ghenv, NOTHING._replace(report=str(error)), "failed", error).report
    return "\n".join(f"{name}: {value}" for name, value in made.summary.items())


def check(ghenv: Any, mesh: Any, surface: Any = None, **options: Any) -> Shown:
    """The component Check: judges any polygon mesh."""
    mesh = _one_or_outlines(mesh)
    if mesh is None:
        return _told(ghenv, NOTHING, "")
    there = None if surface is None else surface_of(surface)
    return _now(ghenv, lambda: _judged(mesh, there, options))


def report(ghenv: Any, mesh: Any, path: Any = None, run: bool = False) -> str:
    """The component Report: figures as text; writes the HTML report where asked."""
    if mesh is None:
        return ""
    made = mesh if isinstance(mesh, Panelling) else _judged(mesh, None, {})
    if run and path:
        made.save(path)
    return text_of(made)


def text_of(made: Mesh) -> str:
    """Figures and failed checks of a panelling, a line each."""
    if not isinstance(made, Panelling):
        return ""
    return "\n".join(f"{name}: {value}" for name, value in made._figures())


def _judged(mesh: Any, surface: Optional[Surface], options: Dict[str, Any]) -> Panelling:
    panels = _panels_of(mesh)
    return _functions.check(panels, surface, **_in_unit(options, panels))


def _in_unit(options: Dict[str, Any], mesh: Optional[Mesh] = None) -> Dict[str, Any]:
    """Options with the unit of Rhino's document where neither they nor the mesh have one."""
    if options.get("unit") is not None or (mesh is not None and mesh._unit is not None):
        return options
    return {**options, "unit": document_unit()}


def _one_or_outlines(given: Any) -> Any:
    """What an input with list access delivers: one mesh in a list is that mesh."""
    if not isinstance(given, list):
        return given
    there = [thing for thing in given if thing is not None]
    if not there:
        return None
    return there if len(there) > 1 or hasattr(there[0], "PointCount") else there[0]


def _panels_of(given: Any) -> Mesh:
    if isinstance(given, Polygons):
        return given  # type: ignore[return-value]
    if isinstance(given, (list, tuple)) and given and hasattr(given[0], "PointCount"):
        return _of_outlines(given)
    return as_polygons(given, Mesh, "Mesh")  # type: ignore[no-any-return]


def _of_outlines(curves: Any) -> Mesh:
    """Closed polylines as one mesh; corners that are the same point are one vertex."""
    from .interop.rhino3dm import _joined

    faces = []
    for curve in curves:
        points = [curve.Point(k) for k in range(curve.PointCount - 1)]
        faces.append([(p.X, p.Y, p.Z) for p in points])
    return Mesh(*_joined(faces))


def _shown(made: Mesh) -> Shown:
    return Shown(outlines(made), panels_of(made), rhino_mesh(made), text_of(made), made)


def panels_of(made: Mesh) -> List[Any]:
    """A planar brep for each panel."""
    return panels(made)


def _now(ghenv: Any, work: Callable[[], Mesh]) -> Shown:
    try:
        made = work()
    except (PhexError, TypeError) as error:
        return _told(ghenv, NOTHING._replace(report=str(error)), "failed", error)
    verdict = made.verdict if isinstance(made, Panelling) else ""
    return _told(ghenv, _shown(made), verdict)


def _background(
    ghenv: Any,
    runs: bool,
    options: Dict[str, Any],
    read: Callable[[], Surface],
    begin: Callable[[Surface], Future],
) -> Shown:
    """What a component that computes in the background shows now."""
    name = str(ghenv.Component.InstanceGuid)
    if not runs:
        _stop(name)
        return _told(ghenv, NOTHING, "off")
    try:
        surface = read()
        key = _key(surface, options)
        known = _runs.get(name)
        if known is None or known.key != key:
            _stop(name)
            known = _Run(key, begin(surface))
            _runs[name] = known
        if not known.future.done():
            return _going(ghenv, known.future)
        made = known.future.result()
    except (PhexError, TypeError, ValueError) as error:
        if isinstance(error, Cancelled):
            return _told(ghenv, NOTHING, "cancelled")
        return _told(ghenv, NOTHING._replace(report=str(error)), "failed", error)
    return _told(ghenv, _shown(made), made.verdict)


def _going(ghenv: Any, future: Future) -> Shown:
    """A preview, and another look later."""
    _later(ghenv)
    news = future.preview()
    told = f"{100 * future.progress:.0f} %"
    if news is None:
        return _told(ghenv, NOTHING, told)
    stage, now = news
    seen = Shown(outlines(now), [], None, f"preview after {stage}, not checked", now)
    return _told(ghenv, seen, f"{told}: {stage}")


def _stop(name: str) -> None:
    known = _runs.pop(name, None)
    if known is not None:
        known.future.cancel()


def _key(surface: Surface, options: Dict[str, Any]) -> str:
    """A checksum of the inputs."""
    digest = hashlib.sha256()
    for array in (surface.vertices, surface.corners, surface.offsets):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(json.dumps(options, sort_keys=True, default=repr).encode())
    return digest.hexdigest()


def _told(ghenv: Any, shown: Shown, message: str, error: Any = None) -> Shown:
    """Writes a message below the component, and an error into its balloon."""
    ghenv.Component.Message = message
    if error is not None and geometry().__name__ != "rhino3dm":
        from Grasshopper.Kernel import GH_RuntimeMessageLevel

        ghenv.Component.AddRuntimeMessage(GH_RuntimeMessageLevel.Error, str(error))
    return shown


def _later(ghenv: Any) -> None:
    """Asks Grasshopper to solve the component again."""
    document = ghenv.Component.OnPingDocument()
    if document is not None:
        document.ScheduleSolution(AGAIN, lambda _: ghenv.Component.ExpireSolution(False))


__all__ = [
    "Shown",
    "check",
    "fabricate",
    "mesh",
    "names",
    "offset",
    "planarize",
    "report",
    "surface_of",
]

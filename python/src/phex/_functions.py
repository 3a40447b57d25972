"""What phex computes."""

import json
import os
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from . import _options, _phex
from ._arrays import checked_numbers, is_path, path_text, shown
from ._compute import Future, begin, close, finish, floats, listener, no_valid, progress_mode, run
from ._errors import InputError
from ._folder import check_folder, save_folder
from ._mesh import Mesh, Panelling, Surface, as_polygons, model_unit
from ._options import Option, checked, real, measured, whole
from ._output import MESH_FILES, MESH_FORMATS, check_writable, write_whole


def mesh(
    surface: Any,
    *,
    output: Any = None,
    panels: Optional[int] = None,
    edge_length: Any = None,
    method: Optional[str] = None,
    effort: Optional[str] = None,
    any_domain: bool = False,
    quadric: Any = None,
    regularise: Optional[float] = None,
    minimal: bool = False,
    regular: bool = False,
    rotate: Optional[float] = None,
    adaptive: Any = None,
    size_field: Any = None,
    boundary: Optional[str] = None,
    symmetry: Any = None,
    repeat: Any = None,
    target: Optional[str] = None,
    unit: Optional[str] = None,
    all_components: bool = False,
    seed: Optional[int] = None,
    threads: Optional[int] = None,
    config: Any = None,
    start: Any = None,
    until: Optional[str] = None,
    max_deviation: Any = None,
    planarity: Any = None,
    fix: Any = None,
    curve: Any = None,
    ground: Any = None,
    ground_reach: Optional[float] = None,
    anchors: Any = None,
    fairness: Optional[float] = None,
    closeness: Optional[float] = None,
    clearance: Optional[float] = None,
    centres: Optional[float] = None,
    solver: Optional[str] = None,
    guide: Any = None,
    crease: Any = None,
    cones: Any = None,
    max_panel: Any = None,
    min_edge: Any = None,
    max_edge: Any = None,
    min_angle: Optional[float] = None,
    max_area: Any = None,
    max_aspect: Optional[float] = None,
    min_dihedral: Optional[float] = None,
    max_dihedral: Optional[float] = None,
    write_target: Any = None,
    contact_sheet: Any = None,
    keep_invalid: bool = False,
    report: Any = None,
    png: Any = None,
    html: Any = None,
    keep_best: bool = False,
    time_limit: Any = None,
    progress: Any = "auto",
    quiet: bool = False,
    verbose: bool = False,
) -> Panelling:
    """Covers a surface with planar hexagonal panels.

    The keywords are the options of ``phex mesh``, by the same names and with the same defaults
    (``None`` is not given). What the program reads from text files may be given as arrays:
    ``size_field`` (n,), ``fix`` and ``anchors`` lists of points, ``cones`` rows of ``x y z index``,
    ``curve`` and ``guide`` polylines (n, 3). ``adaptive``, ``crease`` and ``ground`` may be
    ``True``, as the options without a value. ``progress`` is also a function that is called with
    each event, a dictionary, in this thread; the computation stops if it returns ``False``.

    >>> import phex
    >>> sphere = phex.shape("sphere", triangles=2000)
    >>> made = phex.mesh(sphere, panels=32, max_deviation="5%", progress=lambda event: True)
    >>> made.verdict
    'pass'

    Raises :class:`phex.InputError` if something given can't be used, :class:`phex.NoValidResult` if
    no valid mesh was reached (unless ``keep_invalid``), :class:`phex.Cancelled` if it was stopped.
    """
    options = locals()
    del options["surface"]
    hear = listener(progress, quiet, verbose)
    job = _MeshJob(surface, options)
    try:
        answer = finish(job.begin(), hear, job.keep_best)
    finally:
        close(hear)
    return job.made(answer)


def start(surface: Any, **options: Any) -> Future:
    """As :func:`mesh`, in the background: gives a :class:`phex.Future` at once.

    Files (``output``, ``report``, ``png`` and so on) are written by the first
    :meth:`phex.Future.result`, and are not if nobody asks for it. Nothing is shown meanwhile:
    ``progress`` is ``"auto"`` or ``"none"``, and what happens is told by
    :attr:`phex.Future.progress` and :meth:`phex.Future.events`. A future that nothing holds any
    more is cancelled.

    >>> import phex
    >>> future = phex.start(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> future.result().verdict, future.progress
    ('pass', 1.0)
    """
    for name in options:
        if name not in _options.MESH:
            raise TypeError(f"start() got an unexpected keyword argument {name!r}")
    _check_silent(**_talk(options))
    job = _MeshJob(surface, options)
    return Future(job.begin(preview=True), job.made)


def _talk(options: Dict[str, Any]) -> Dict[str, Any]:
    """What options say of how progress is shown."""
    usual = {"progress": "auto", "quiet": False, "verbose": False}
    return {name: options.get(name, value) for name, value in usual.items()}


def _check_silent(progress: Any, quiet: Any, verbose: Any) -> None:
    """Refuses what would be shown of a computation in the background."""
    mode = progress_mode(progress, quiet, verbose)
    if mode not in ("auto", "none"):
        told = "has no effect in the background: ask the future for its progress and events()"
        raise InputError(f"progress: {shown(progress)} {told}")
    if verbose:
        raise InputError("verbose: has no effect in the background: ask the future for its events()")


class Session:
    """A surface kept between panellings: a change of options computes again what depends on it
    alone (what panels are laid out on, and curvature, stay where number of panels and boundary
    do), and the result is that of :func:`mesh`, bit for bit.

    >>> import phex
    >>> session = phex.Session(phex.shape("torus", triangles=2000), panels=60, max_deviation="5%")
    >>> turned = [session.mesh(rotate=angle) for angle in (0, 10)]
    >>> [made.verdict for made in turned]
    ['pass', 'pass']
    """

    def __init__(self, surface: Any, **options: Any) -> None:
        #: The surface.
        self.surface = as_polygons(surface, Surface, "surface")
        #: Options of every panelling, unless others are given.
        self.options = options
        self._kept = _phex.KeptSurface(self.surface._given())

    def mesh(self, **options: Any) -> Panelling:
        """As :func:`phex.mesh`."""
        job = self._job(options)
        hear = listener(**_talk({**self.options, **options}))
        try:
            answer = finish(job.begin(session=self._kept), hear, job.keep_best)
        finally:
            close(hear)
        return job.made(answer)

    def start(self, **options: Any) -> Future:
        """As :func:`phex.start`."""
        _check_silent(**_talk(options))
        job = self._job(options)
        return Future(job.begin(preview=True, session=self._kept), job.made)

    def _job(self, options: Dict[str, Any]) -> "_MeshJob":
        for name in {**self.options, **options}:
            if name not in _options.MESH:
                raise TypeError(f"mesh() got an unexpected keyword argument {name!r}")
        return _MeshJob(self.surface, options, self.options)

    def __getstate__(self) -> Dict[str, Any]:
        return {"surface": self.surface, "options": self.options}

    def __setstate__(self, state: Dict[str, Any]) -> None:
        Session.__init__(self, state["surface"], **state["options"])


#: Keywords that name files to write.
FILES = ("output", "write_target", "contact_sheet", "png", "html", "report")


def _check_format(name: str, path: str) -> None:
    """Refuses a mesh file of an unknown format."""
    extension = os.path.splitext(path)[1].lower()
    if extension == ".3dm":
        from .interop.rhino3dm import library

        library(path)
    elif extension not in MESH_FORMATS:
        known = ", ".join((*MESH_FORMATS, ".3dm"))
        raise InputError(f"{name}: {path}: a mesh is written as one of {known}")


class _MeshJob:
    """The options of a panelling, checked."""

    def __init__(
        self, surface: Any, asked: Dict[str, Any], usual: Optional[Dict[str, Any]] = None
    ) -> None:
        defaults = {name: False if o.kind == "flag" else None for name, o in _options.MESH.items()}
        options = {**defaults, **(usual or {}), **asked}
        self.surface = as_polygons(surface, Surface, "surface")
        typed, given, self.sizes = _options.settings(options)
        flags = {name: _flag(name, options[name]) for name in ("keep_best", "keep_invalid")}
        self.keep_best, self.keep_invalid = flags["keep_best"], flags["keep_invalid"]
        self.threads = _options.threads(options["threads"])
        self.paths = {
            name: path_text(options[name], name) for name in FILES if options[name] is not None
        }
        time_limit = options["time_limit"]
        if time_limit is not None:
            time_limit = str(checked("time_limit", time_limit, _options.MESH["time_limit"]))
        config = options["config"]
        earlier = options["start"]
        until = options["until"]
        if until is not None:
            until = checked("until", until, _options.MESH["until"])
        self.meshes = [self.surface]
        if earlier is not None:
            self.meshes.append(as_polygons(earlier, Mesh, "start"))
        asked_typed, asked_given, asked_sizes = _options.settings(asked)
        self.request = {
            "asked": {
                "settings": asked_typed,
                "given": asked_given,
                "size_field": asked_sizes is not None,
                "keep_best": bool(asked.get("keep_best")),
                "time_limit": asked.get("time_limit") is not None,
            },
            "settings": typed,
            "config": None if config is None else path_text(config, "config"),
            "given": given,
            "keep_best": self.keep_best,
            "time_limit": time_limit,
            "until": until,
        }
        self.request["contact_sheet"] = self._sheet(earlier is not None or until is not None)
        for name in MESH_FILES:
            if name in self.paths:
                _check_format(name, self.paths[name])
        if self.paths:
            read = [path for mesh in self.meshes for path in mesh._read_from()]
            check_writable(self.paths, read, typed, self.request["config"])
        # What is laid out alone is a picture of what will be, and no invalid result.
        self.keep_invalid = self.keep_invalid or until is not None

    def _sheet(self, is_idle: bool) -> Optional[str]:
        path = self.paths.get("contact_sheet")
        if path is not None and not path.lower().endswith((".png", ".html", ".htm")):
            raise InputError(f"contact_sheet: {path}: a contact sheet is a .png or a .html file")
        if path is not None and is_idle:
            raise InputError("contact_sheet: with `start` or `until` no ways are tried: leave it out")
        if self.request["until"] is not None and "write_target" in self.paths:
            raise InputError("write_target: with `until` panels are fitted to nothing: leave it out")
        return path

    def begin(self, preview: bool = False, session: Any = None) -> Any:
        return begin(
            "mesh", self.request, self.meshes, self.sizes, None, self.threads, preview, session
        )

    def made(self, answer: Dict[str, Any]) -> Panelling:
        return _delivered(answer, self.surface, self.keep_invalid, self.paths)


def _delivered(
    answer: Dict[str, Any], surface: Any, keep_invalid: bool, paths: Dict[str, str]
) -> Panelling:
    """A result with its files, or an error that holds it."""
    made = Panelling._from_answer(answer, surface, keep_invalid)
    if "png" in paths:
        write_whole(paths["png"], made.picture())
    if "contact_sheet" in paths:
        write_whole(paths["contact_sheet"], answer["contact_sheet"])
    if "html" in paths:
        made._save_page(paths["html"])
    if "report" in paths:
        made.save_report(paths["report"])
    if "write_target" in paths and made.target is not None:
        made.target.save(paths["write_target"])
    if not (made.sound or keep_invalid):
        failed = "; ".join(f"{name}: {ids[:10]}" for name, ids in made.offenders.items())
        raise no_valid(f"no valid mesh was reached ({failed}); keep_invalid=True gives it", made)
    if "output" in paths:
        made.save(paths["output"])
    return made


def _flag(name: str, value: Any) -> bool:
    return bool(checked(name, value, Option("flag")))


def _limits(**options: Any) -> Dict[str, Any]:
    table = _options.MESH
    return {
        name.replace("_", "-"): checked(name, value, table[name])
        for name, value in options.items()
        if value is not None
    }


def _with_surface(first: Any, surface: Any) -> Tuple[List[Any], Optional[Surface]]:
    panels = as_polygons(first, Mesh, "mesh")
    if surface is None:
        return [panels], None
    there = as_polygons(surface, Surface, "surface")
    return [panels, there], there


def planarize(
    mesh: Any,
    surface: Any = None,
    *,
    max_deviation: Any = None,
    planarity: Any = None,
    unit: Optional[str] = None,
    fix: Any = None,
    curve: Any = None,
    ground: Any = None,
    ground_reach: Optional[float] = None,
    anchors: Any = None,
    fairness: Optional[float] = None,
    closeness: Optional[float] = None,
    clearance: Optional[float] = None,
    centres: Optional[float] = None,
    solver: Optional[str] = None,
    refit: bool = False,
    config: Any = None,
    threads: Optional[int] = None,
    keep_invalid: bool = False,
    progress: Any = "auto",
) -> Panelling:
    """Makes the faces of a mesh planar, close to a surface or to where they are (three faces at
    each interior vertex); keywords as ``phex planarize`` and :func:`mesh`.

    >>> import numpy as np, phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> bent = made.vertices + 1e-3 * np.random.default_rng(0).normal(size=made.vertices.shape)
    >>> flat = phex.planarize((bent, made.faces))
    >>> bool(flat.per_face("planarity").max() < 1e-12)
    True
    """
    options = locals()
    typed, given, _ = _options.settings({name: options[name] for name in _options.STEERING})
    panels = as_polygons(mesh, Mesh, "mesh")
    unit = model_unit(unit, panels)
    request = {
        "steering": typed["steering"],
        "given": given,
        "config": None if config is None else path_text(config, "config"),
        "limits": _limits(max_deviation=max_deviation, planarity=planarity, unit=unit),
        "refit": _flag("refit", refit),
    }
    return _judged("planarize", request, panels, surface, threads, keep_invalid, progress)


def _judged(
    what: str,
    request: Dict[str, Any],
    mesh: Any,
    surface: Any,
    threads: Optional[int],
    keep_invalid: bool,
    progress: Any,
) -> Panelling:
    meshes, there = _with_surface(mesh, surface)
    is_kept = _flag("keep_invalid", keep_invalid)
    hear = listener(progress, False, False)
    count = _options.threads(threads)
    try:
        answer = finish(begin(what, request, meshes, threads=count), hear)
    finally:
        close(hear)
    return _delivered(answer, there, is_kept, {})


def check(
    mesh: Any,
    surface: Any = None,
    *,
    report_of: Any = None,
    limits: Any = None,
    boundary: Optional[str] = None,
    max_deviation: Any = None,
    planarity: Any = None,
    unit: Optional[str] = None,
    keep_invalid: bool = True,
) -> Panelling:
    """Judges any polygon mesh: planar, simple, sound, close to a surface. The answer is the mesh
    with a report; an invalid one is no error.

    ``report_of`` is an earlier run, a :class:`phex.Panelling` or the path of its report: limits, the
    unit and surfaces that are not given are those of that run. Reports that Python wrote name no
    smooth surface: with their path a mesh is judged by the facets alone. ``limits`` is a job file,
    whose limits and unit come before those of the run.

    >>> import phex
    >>> phex.check(([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]], [[0, 1, 2, 3]])).verdict
    'outside_tolerance'
    """
    job = None if limits is None else path_text(limits, "limits")
    panels = as_polygons(mesh, Mesh, "mesh")
    if job is None and report_of is None:
        unit = model_unit(unit, panels)
    typed = _limits(boundary=boundary, max_deviation=max_deviation, planarity=planarity, unit=unit)
    promised, there, smooth = (None, None, None) if report_of is None else _promise(report_of)
    if surface is not None:
        there, smooth = as_polygons(surface, Surface, "surface"), None
    request = {"limits": typed, "promised": promised, "job": job}
    meshes = [panels]
    meshes += [m for m in (there, smooth) if m is not None]
    answer = finish(begin("check", request, meshes))
    return _delivered(answer, there, _flag("keep_invalid", keep_invalid), {})


def _promise(report_of: Any) -> Tuple[Any, Optional[Surface], Optional[Surface]]:
    """What an earlier run was judged by: limits, the surface, the smooth surface."""
    if isinstance(report_of, Panelling):
        report, folder = report_of.report, ""
        surface, smooth = report_of.surface, report_of.target
    else:
        path = path_text(report_of, "report_of")
        try:
            with open(path, encoding="utf-8") as file:
                report = json.load(file)
            folder = os.path.dirname(path)
            surface, smooth = _surfaces_of(report, folder)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as cause:
            if isinstance(cause, InputError):
                raise
            raise InputError(f"report_of: {path}: no run report: {cause}") from None
    if not isinstance(report.get("limits"), dict):
        raise InputError("report_of: the report does not say what its mesh was judged by")
    return report["limits"], surface, smooth if surface is not None else None


def _surfaces_of(report: Dict[str, Any], folder: str) -> Tuple[Any, Any]:
    """The surfaces that a report names, from where it lies or from here."""

    def found(entry: Dict[str, Any]) -> Optional[Surface]:
        """The first that has not changed."""
        places = [os.path.join(folder, entry["path"]), entry["path"]]
        read = [Surface.read(place) for place in places if os.path.isfile(place)]
        # Reports of earlier versions do not tell the checksum of what was written.
        same = [s for s in read if s._sha256 == entry.get("sha256", s._sha256)]
        if read and not same:
            changed = f"{read[0].name} has changed since the report"
            raise InputError(f"report_of: {changed}: give the surface")
        return same[0] if same else None

    # `mesh` reads the surface first, the others the mesh.
    read = report["inputs"][0 if report["command"] == "mesh" else 1 :][:1]
    surface = smooth = None
    for entry in read:
        surface = found(entry)
        if surface is None:
            told = "is not there: give the surface"
            raise InputError(f"report_of: the surface {entry['path']} {told}")
    for entry in report["outputs"]:
        smooth = found(entry) if entry["content"] == "smooth_target" else smooth
    return surface, smooth


class Offset(NamedTuple):
    """Layers of a mesh."""

    #: A mesh for each distance, in their order.
    layers: List[Mesh]
    #: Signed distances, model units.
    distances: List[float]
    #: The largest distances to both sides, inward (negative) first, if asked for.
    max_distance: Optional[Tuple[float, float]]
    #: The parallel mesh that touches the unit sphere, if asked for.
    gauss_image: Optional[Mesh]
    #: Solid panels between successive layers (one layer: between it and the mesh), if asked for.
    solids: Tuple[Mesh, ...] = ()
    #: Sum of the volumes of each of these.
    volumes: Tuple[float, ...] = ()
    #: Beams and nodes between the same layers, if asked for: ``edge``, ``vertices`` (m, 2), ``ends``
    #: (m, 2, 3), ``plane_normal`` (m, 3), ``torsion`` (m,) radians; ``node``, ``base``,
    #: ``direction`` (n, 3), ``length``.
    beams: Tuple[Dict[str, NDArray[Any]], ...] = ()


def offset(
    mesh: Any,
    distance: Any = None,
    *,
    kind: str = "face",
    max_distance: bool = False,
    gauss_image: bool = False,
    solids: bool = False,
    gap: Any = None,
    beams: bool = False,
    planarity: Any = None,
    unit: Optional[str] = None,
    threads: Optional[int] = None,
) -> Offset:
    """Layers at constant distance of faces, edges or vertices, each a valid mesh.

    ``distance`` is one or a list of lengths: numbers, ``"-20mm"``, ``"1%"`` of the diagonal;
    positive is the side of the face normals. Without ``unit``, it is that of the run which made the
    mesh, or else metres. ``solids`` gives the panels between successive layers
    as solids, with joints as wide as ``gap``; ``beams`` the axes of beams and nodes between them.

    >>> import phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> shell = phex.offset(made, [-0.05, "1%"], max_distance=True)
    >>> len(shell.layers), shell.max_distance[0] < -0.05
    (2, True)
    """
    panels = as_polygons(mesh, Mesh, "mesh")
    unit = model_unit(unit, panels) or "m"
    wanted = [] if distance is None else distance
    if isinstance(wanted, np.ndarray):
        wanted = checked_numbers(wanted.reshape(-1), "distance").tolist()
    if not isinstance(wanted, (list, tuple)):
        wanted = [wanted]
    distances = [_length(panels, d, unit) for d in wanted]
    between = {"solids": _flag("solids", solids), "beams": _flag("beams", beams)}
    if not distances and any(between.values()):
        raise InputError("solids and beams have no effect without layers: give a distance")
    if gap is not None and not solids:
        raise InputError("gap has no effect without solids")
    request = {
        **between,
        "gap": 0.0 if gap is None else _length(panels, gap, unit),
        "kind": checked("kind", kind, Option("choice", choices=("face", "edge", "vertex"))),
        "distances": distances,
        "max_distance": _flag("max_distance", max_distance),
        "gauss_image": _flag("gauss_image", gauss_image),
        "planarity": None if planarity is None else measured("planarity", planarity),
        "unit": unit,
    }
    made = run("offset", request, panels, threads=_options.threads(threads))
    ends = made.get("max_distance")
    touching = made.get("gauss_image")

    def in_unit(arrays: Any) -> Mesh:
        layer: Mesh = Mesh._of(arrays)
        layer._unit = unit
        return layer

    return Offset(
        [in_unit(arrays) for arrays in made["layers"]],
        distances,
        None if ends is None else (float(ends[0]), float(ends[1])),
        None if touching is None else Mesh._of(touching),
        tuple(in_unit(arrays) for arrays in made.get("solids", ())),
        tuple(floats(made["volumes"])) if "volumes" in made else (),
        tuple(
            {name: np.array(values) for name, values in pair.items()}
            for pair in json.loads(made.get("beams", "[]"))
        ),
    )


def _length(panels: Mesh, value: Any, unit: str) -> float:
    """A signed length in model units."""
    if not isinstance(value, str):
        return real("distance", value)
    bare = value.strip()
    sign = -1.0 if bare.startswith("-") else 1.0
    length = measured("distance", bare[1:] if sign < 0 else bare)
    request = {"lengths": [length], "unit": unit}
    return sign * floats(run("lengths", request, panels)["lengths"])[0]


def koebe(
    mesh: Any,
    *,
    boundary: Optional[str] = None,
    opening: Optional[float] = None,
    keep_invalid: bool = False,
    progress: Any = "auto",
) -> Panelling:
    """The mesh of a given graph whose edges all touch the unit sphere, as ``phex koebe``.

    >>> import numpy as np, phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> len(phex.koebe(made)) == len(made)
    True
    """
    kinds = ("equal-radii", "gauss-image", "angles")
    request = {
        "boundary": None
        if boundary is None
        else checked("boundary", boundary, Option("choice", choices=kinds)).replace("-", "_"),
        "opening": None if opening is None else real("opening", opening),
    }
    return _judged("koebe", request, mesh, None, None, keep_invalid, progress)


def parallel(
    mesh: Any,
    surface: Any = None,
    *,
    lengths: Any = None,
    basis: bool = False,
    start: Optional[str] = None,
    least_edge: Optional[float] = None,
    fairness: Optional[float] = None,
    constant_mean_curvature: Optional[float] = None,
    max_deviation: Any = None,
    planarity: Any = None,
    unit: Optional[str] = None,
    keep_invalid: bool = False,
    progress: Any = "auto",
) -> Panelling:
    """The mesh with the edge directions of ``mesh`` that is closest to a surface, or to ``lengths``:
    a dictionary or list of ``(from, to): length`` with the numbers of two vertices; other edges
    keep theirs. As ``phex parallel``: ``start`` (``"normals"`` or ``"positions"``), ``least_edge``
    (0.05), ``fairness`` (0.001) and ``constant_mean_curvature`` (0) say how a surface is come close
    to.

    ``basis=True`` adds ``basis`` to the result, a sparse basis of the space of parallel meshes: rows
    of ``vector, edge, from, to, change of length``.

    >>> import phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> found = phex.parallel(made, basis=True)
    >>> found.basis.shape[1], found.report["statistics"]["dimension"] > 1
    (5, True)
    """
    panels = as_polygons(mesh, Mesh, "mesh")
    unit = model_unit(unit, panels)
    starts = Option("choice", choices=("normals", "positions"))
    weights = {
        "least_edge": least_edge,
        "fairness": fairness,
        "constant_mean_curvature": constant_mean_curvature,
    }
    request = {
        "start": None if start is None else checked("start", start, starts),
        **{name: None if x is None else real(name, x) for name, x in weights.items()},
        "limits": _limits(max_deviation=max_deviation, planarity=planarity, unit=unit),
        "lengths": _edge_lengths(lengths),
        "basis": _flag("basis", basis),
    }
    if surface is not None and lengths is not None:
        raise InputError("lengths: has no effect with a surface")
    return _judged("parallel", request, panels, surface, None, keep_invalid, progress)


def _edge_lengths(lengths: Any) -> List[List[Any]]:
    """Edges by their two vertices, and their lengths."""
    if lengths is None:
        return []
    try:
        pairs = lengths.items() if isinstance(lengths, dict) else lengths
        given = [(*edge, length) for edge, length in pairs]
        rows = [[whole("lengths", a), whole("lengths", b), real("lengths", x)] for a, b, x in given]
    except InputError:
        raise
    except Exception:  # whatever a foreign object does
        raise InputError(f"lengths: {shown(lengths)} are no pairs (from, to): length") from None
    for a, b, x in rows:
        if x < 0.0:
            raise InputError(f"lengths: {x!r} of the edge from {a} to {b} is not at least 0")
    return rows


class Fabrication(NamedTuple):
    """Workshop files."""

    #: Counts and figures, as ``fab.json`` has them.
    summary: Dict[str, Any]
    #: The bytes of each file, by its path in the folder.
    files: Dict[str, bytes]

    def save(self, folder: Any) -> None:
        """Writes a folder: a new or an empty one, or that of an earlier run. Files of others in it
        stay; nothing is written if files of the earlier run were changed since, or if others have
        names that are needed."""
        save_folder(path_text(folder, "folder"), self.files)


def fabricate(
    mesh: Any,
    folder: Any = None,
    *,
    thickness: Any,
    gap: Any = None,
    side: str = "inside",
    unit: Optional[str] = None,
    sheet: Any = "1250x2500",
    spacing: Any = "5mm",
    rotations: Any = "free",
    nest_effort: int = 60,
    text: Any = "25mm",
    tolerance: Any = "1mm",
    angle_tolerance: float = 0.1,
    limits: Any = None,
    planarity: Any = None,
    threads: Optional[int] = None,
    progress: Any = "auto",
) -> Fabrication:
    """Flat labelled panels on sheets (DXF, SVG), schedules (CSV, XLSX), solids (STL, OBJ), as
    ``phex fab``; writes them into ``folder`` if one is given.

    ``sheet`` is ``"1250x2500"`` or a pair, plain numbers are mm; ``rotations`` ``"free"`` or a list
    of angles in degrees; ``limits`` a job file, whose limits get columns in the table of panels.
    Without ``unit``, it is that of the run which made the mesh or of the job file, or else metres.

    >>> import phex
    >>> made = phex.mesh(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> workshop = phex.fabricate(made, thickness="20mm", sheet=(1250, 2500), nest_effort=0)
    >>> workshop.summary["panels"] == len(made), "panels.csv" in workshop.files
    (True, True)
    """
    panels = as_polygons(mesh, Mesh, "mesh")
    free = isinstance(rotations, str) and rotations == "free"
    angles = None if free else checked_numbers(rotations, "rotations").tolist()
    if angles == []:
        raise InputError("rotations: there is none: give 'free' or angles in degrees")
    request = {
        "thickness": measured("thickness", thickness),
        "gap": None if gap is None else measured("gap", gap),
        "side": checked("side", side, Option("choice", choices=("inside", "outside", "centre"))),
        "unit": None if unit is None else checked("unit", unit, _options.MESH["unit"]),
        "mesh_unit": panels._unit,
        "sheet": _options.sheet(sheet),
        "spacing": measured("spacing", spacing),
        "rotations": angles,
        "nest_effort": whole("nest_effort", nest_effort, (1 << 32) - 1),
        "text": measured("text", text),
        "tolerance": measured("tolerance", tolerance),
        "angle_tolerance": real("angle_tolerance", angle_tolerance),
        "limits": None if limits is None else path_text(limits, "limits"),
        "planarity": None if planarity is None else measured("planarity", planarity),
    }
    if folder is not None:
        read = [str(given) for given in (mesh, limits) if is_path(given)]
        check_folder(path_text(folder, "folder"), inputs=read)
    hear = listener(progress, False, False)
    count = _options.threads(threads)
    try:
        answer = finish(begin("fabricate", request, [panels], threads=count), hear)
    finally:
        close(hear)
    made = Fabrication(json.loads(answer["summary"]), dict(answer["files"]))
    if folder is not None:
        made.save(folder)
    return made


class Network(NamedTuple):
    """A conjugate curve network; a closed curve ends with its first point."""

    #: Curves along rows, each (n, 3).
    rows: List[NDArray[np.float64]]
    #: Curves across rows, each (n, 3).
    columns: List[NDArray[np.float64]]
    #: ``|II(a, b)| / |II|`` of rows and columns: median, 95 %, worst; empty on flat surfaces.
    conjugacy: List[float]


def network(
    surface: Any,
    *,
    panels: int = 500,
    columns_along: Any = None,
    threads: Optional[int] = None,
) -> Network:
    """A conjugate curve network of a surface, as dense as ``panels`` bricks, as ``phex network``.

    >>> import phex
    >>> found = phex.network(phex.shape("roof", triangles=2000), panels=100)
    >>> len(found.rows) > 2, len(found.columns) > 2
    (True, True)
    """
    there = as_polygons(surface, Surface, "surface")
    axis = None
    if columns_along is not None:
        axis = checked_numbers(columns_along, "columns_along").tolist()
        if len(axis) != 3:
            raise InputError(f"columns_along: {shown(columns_along)} is no direction x, y, z")
    request = {"panels": whole("panels", panels), "columns_along": axis}
    made = run("network", request, there, threads=_options.threads(threads))
    return Network(made["rows"], made["columns"], floats(made["conjugacy"]))


def convert(source: Any, output: Any, *, unit: Optional[str] = None) -> None:
    """Reads a file and writes it in the format of the other one's extension, as ``phex convert``.
    ``unit`` is that of the coordinates, in metres if it is not given: GLB and 3MF hold metres, and
    3DM names it; files of other formats have none."""
    read, written = path_text(source, "source"), path_text(output, "output")
    _check_format("output", written)
    if unit is not None and not written.lower().endswith((".glb", ".3mf", ".3dm")):
        told = "whose coordinates stay as they are: leave it out"
        raise InputError(f"unit: {unit} has no effect on {written}, {told}")
    check_writable({"output": written}, [read])
    Mesh.read(read).save(written, unit=unit)


def shapes() -> Dict[str, Dict[str, Any]]:
    """The built-in surfaces: what each is, and its parameters with defaults and ranges.

    >>> import phex
    >>> phex.shapes()["torus"]["parameters"]["minor"]["default"] > 0
    True
    """
    listed = json.loads(run("shapes", {})["shapes"])
    return {
        s["name"]: {
            "summary": s["summary"],
            "parameters": {p.pop("name"): p for p in s["parameters"]},
        }
        for s in listed
    }


def shape(
    name: str,
    *,
    triangles: int = 8000,
    jitter: float = 0.0,
    jitter_seed: int = 0,
    **parameters: float,
) -> Surface:
    """A built-in surface, as ``phex shape``: ``parameters`` are those of :func:`shapes`, the ``seed``
    of ``b-spline`` among them. ``jitter`` moves vertices by a share of an edge, as ``jitter_seed``
    has it (``--seed`` of the program); ``seed`` stands for it where the shape has none of its own.

    >>> import phex
    >>> phex.shape("torus", triangles=1000, minor=0.3).vertices.shape[1]
    3
    """
    if not isinstance(name, str):
        raise InputError(f"name: {shown(name)} is no text")
    if "seed" in parameters and "seed" not in shapes().get(name, {}).get("parameters", {"seed"}):
        if not jitter:
            raise InputError(f"seed: has no effect on {name} without jitter")
        jitter_seed = parameters.pop("seed")  # type: ignore[assignment]
    request = {
        "name": name,
        "parameters": [[key, real(key, value)] for key, value in parameters.items()],
        "options": {
            "triangles": whole("triangles", triangles),
            "jitter": real("jitter", jitter),
            "seed": whole("jitter_seed", jitter_seed),
        },
    }
    made: Surface = Surface._of(run("shape", request)["mesh"], name)
    return made

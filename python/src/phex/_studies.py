"""Studies: many designs at once, on the processes of one machine or on a cluster."""

import html
import itertools
import json
import os
import queue
import random
import signal
import sys
import time
import warnings
from collections import Counter, deque
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor
from typing import (
    Any,
    Deque,
    Dict,
    Iterable,
    Iterator,
    List,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
    Union,
)

from . import _options
from ._arrays import is_path, path_text, shown
from ._compute import close, listener, run, stops
from ._errors import Cancelled, InputError, PhexError
from ._mesh import Polygons, Surface, as_polygons
from ._options import Option, checked, measured, real, whole
from ._output import write_whole

Row = Dict[str, Any]
Variants = List[Dict[str, Any]]

#: Variants that an executor has at a time, so that a hundred thousand need no memory of their own.
MOST_WAITING = 4096
#: What helps where an executor is gone.
GO_ON = "what is finished is kept: go on with the same call"
#: Figures of which more is better; of all others less is.
MORE_IS_BETTER = frozenset({"clearance", "hexagons", "least-angle", "sheet-use"})
#: Figures of every mesh that a study makes.
FIGURES = (
    "panels",
    "deviation",
    "clearance",
    "planarity",
    "hexagons",
    "irregular",
    "concave",
    "least-angle",
    "area-spread",
    "mean-edge",
    "distinct-lengths",
)
#: Figures of a study with a workshop.
WORKSHOP_FIGURES = ("sheets", "sheet-use", "distinct-panels", "distinct-angles")
#: What can be asked for besides the options of ``phex mesh``.
SAMPLES = ("grid", "random", "latin-hypercube")


class Between(NamedTuple):
    """A range that values are drawn from; whole numbers if both ends are ``int``.

    >>> import phex
    >>> phex.Between(40, 90).at(0.5), phex.Between(0.0, 60.0).at(0.5)
    (65, 30.0)
    """

    low: Any
    high: Any

    @property
    def is_whole(self) -> bool:
        """Whether whole numbers are drawn."""
        return isinstance(self.low, int) and isinstance(self.high, int)

    def at(self, share: float) -> Any:
        """The value at a share from 0 to 1 of the range."""
        if self.is_whole:
            return min(self.high, self.low + int(share * (self.high - self.low + 1)))
        return float(self.low + share * (self.high - self.low))


def linspace(low: float, high: float, count: int) -> List[float]:
    """``count`` numbers from ``low`` to ``high``.

    >>> import phex
    >>> phex.linspace(0, 60, 3)
    [0.0, 30.0, 60.0]
    """
    low, high, count = real("low", low), real("high", high), whole("count", count, 10**7)
    last = max(count - 1, 1)
    rounding = 4 * sys.float_info.epsilon * max(abs(low), abs(high))
    values = [low + (high - low) * (k / last) for k in range(count)]
    # As the program does in a study file, which makes ranges of whole numbers of these.
    is_whole = [abs(x) < 2**53 and abs(x - round(x)) <= rounding for x in values]
    return [float(round(x)) if whole_one else x for x, whole_one in zip(values, is_whole)]


def solve(job: Dict[str, Any]) -> Row:
    """One variant of a study: a row, and a folder with its mesh, report and picture.

    ``job`` is a dictionary of plain values, so that any engine may run it, twice, or elsewhere:
    ``surface`` (a path), ``out`` (the folder of the folders), ``settings`` as in a job file, and
    perhaps ``surface_name`` (what the row calls it, else the file's name), ``workshop``, ``limits``
    (``seconds``, ``megabytes``), ``html``, ``threads``. The folder is named by a checksum of what
    the result depends on; one that has ``run.json`` is finished and is not computed again. Ends
    without a valid mesh are rows, too: see ``out:status``.

    >>> import phex
    >>> phex.shape("sphere", triangles=500).save("ball.obj")
    >>> settings = {"panels": 32, "max-deviation": "5%"}
    >>> row = phex.solve({"surface": "ball.obj", "out": "study", "settings": settings})
    >>> row["in:panels"], row["out:status"], row["img"] == row["key"] + "/picture.png"
    (32, 'pass', True)
    """
    if not isinstance(job, dict):
        raise InputError(f"job: {shown(job)} is no dictionary")
    known = {"surface", "surface_name", "out", "settings", "workshop", "limits", "html", "threads"}
    unknown = set(job) - known
    if unknown:
        raise InputError(f"job: there is no `{sorted(map(str, unknown))[0]}`")
    for name in ("surface", "out"):
        if name not in job:
            raise InputError(f"job: `{name}` is missing")
    request = {
        "variant": _variant(job),
        "out": path_text(job["out"], "out"),
        "options": _solve_options(job),
    }
    made = run("solve", request, threads=_options.threads(job.get("threads", 1)))
    return json.loads(made["row"])  # type: ignore[no-any-return]


def _solve_options(job: Dict[str, Any]) -> Dict[str, Any]:
    return {"limits": job.get("limits") or {}, "html": bool(job.get("html", False))}


def _variant(job: Dict[str, Any]) -> Dict[str, Any]:
    return {
        "surface": path_text(job["surface"], "surface"),
        "surface_name": job.get("surface_name"),
        "settings": job.get("settings") or {},
        "workshop": job.get("workshop"),
    }


class Study:
    """The rows of a study, in the order of its variants, and the folder of their folders."""

    def __init__(self, rows: List[Row], out: str) -> None:
        #: A dictionary for each variant: ``in:``, ``out:``, ``img``, ``threeD``, ``key``.
        self.rows = rows
        #: The folder.
        self.out = out

    @classmethod
    def read(cls, out: Any) -> "Study":
        """What is finished in a folder, ordered by what was wanted; as ``phex sweep collect``."""
        folder = path_text(out, "out")
        found = run("collect", {"out": folder})
        for told in json.loads(found["broken"]):
            warnings.warn(f"{told}: left out; run the study again", stacklevel=2)
        return cls(json.loads(found["rows"]), folder)

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __repr__(self) -> str:
        return f"<phex.Study {len(self)} variants in {self.out}>"

    def counts(self) -> Dict[str, int]:
        """How many variants ended how."""
        ends = [row["out:status"] for row in self.rows]
        return {end: ends.count(end) for end in sorted(set(ends))}

    def column(self, name: str) -> List[Any]:
        """A figure or setting of all variants, ``None`` where one has none; ``out:`` and ``in:``
        may be left out."""
        names = (name, f"out:{name}", f"in:{name}")
        there = {column for row in self.rows for column in row}
        there |= {f"out:{figure}" for figure in (*FIGURES, *WORKSHOP_FIGURES)}
        # A setting that is at its default has no column.
        if not isinstance(name, str) or not there.union(_settings()).intersection(names):
            raise _no_column("column", name, sorted(there))
        return [next((row[n] for n in names if n in row), None) for row in self.rows]

    def pareto(self, *objectives: Any) -> List[Row]:
        """The valid variants that no other one beats in every objective. An objective is a column,
        of which less is better (more of clearance, hexagons, least-angle, sheet-use), or a pair
        such as ``("panels", "max")``."""
        signs = [_objective(o) for o in objectives]
        for name, _ in signs:
            checked_column(name, (*FIGURES, *WORKSHOP_FIGURES), "objective")
        found = [(_costs(row, signs), row) for row in self.rows if _is_mesh(row)]
        there = [(c, row) for c, row in found if c is not None]
        return [row for c, row in there if not any(_beats(other, c) for other, _ in there)]

    def table(self) -> str:
        """CSV with the columns of Design Explorer."""
        return str(run("table", self._request())["table"])

    def page(self, title: str = "") -> str:
        """One HTML page: pictures, parallel axes, a scatter with the best, two variants compared."""
        return str(run("study-page", self._request(title))["page"])

    def _request(self, title: str = "") -> Dict[str, Any]:
        title = title or os.path.basename(os.path.abspath(self.out))
        return {"title": title, "rows": self.rows, "out": self.out}

    def save(self, path: Any) -> None:
        """Writes a table (``.csv``, ``.parquet`` with pyarrow) or the page (``.html``). The page
        finds reports and large pictures where it lies in the folder :attr:`out`."""
        name = path_text(path, "path")
        extension = os.path.splitext(name)[1].lower()
        if extension == ".csv":
            write_whole(name, self.table().encode())
        elif extension in (".html", ".htm"):
            write_whole(name, self.page().encode())
        elif extension == ".parquet":
            self._save_parquet(name)
        else:
            raise InputError(f"{name}: a study is saved as .csv, .parquet or .html")

    def _save_parquet(self, name: str) -> None:
        import io

        import pyarrow
        import pyarrow.parquet

        columns = sorted({column for row in self.rows for column in row})
        values = {c: [row.get(c) for row in self.rows] for c in columns}
        mixed = {c for c, v in values.items() if len({type(x) for x in v if x is not None}) > 1}
        number = {c for c in mixed if all(isinstance(x, (int, float)) for x in values[c] if x is not None)}
        for c in mixed:
            to = float if c in number else str
            values[c] = [None if x is None else to(x) for x in values[c]]
        buffer = io.BytesIO()
        pyarrow.parquet.write_table(pyarrow.table(values), buffer)
        write_whole(name, buffer.getvalue())

    def _repr_html_(self) -> str:
        ends = "".join(
            f"<tr><td style='text-align:left'>{html.escape(end)}</td><td>{count}</td></tr>"
            for end, count in self.counts().items()
        )
        return f"<table><tr><th>ended</th><th>variants</th></tr>{ends}</table>"


def _objective(objective: Any) -> Tuple[str, float]:
    """A column, and the sign that makes less of it better."""
    name, way = objective if isinstance(objective, (tuple, list)) else (objective, None)
    if not isinstance(name, str) or way not in (None, "min", "max"):
        raise InputError(f"objective: {shown(objective)} is no column, and no pair with 'min' or 'max'")
    bare = name[4:] if name.startswith("out:") else name
    is_max = way == "max" or (way is None and bare in MORE_IS_BETTER)
    return bare, -1.0 if is_max else 1.0


def checked_column(name: Any, known: Sequence[str], what: str) -> str:
    """A figure without ``out:``, if it is one that is known."""
    bare = name[4:] if isinstance(name, str) and name.startswith("out:") else name
    if isinstance(bare, str) and bare in known:
        return bare
    raise _no_column(what, name, known)


def _no_column(what: str, name: Any, known: Sequence[str]) -> InputError:
    return InputError(f"{what}: there is no column {shown(name)}; there are {', '.join(known)}")


def _settings() -> Set[str]:
    """The columns that settings may have."""
    settings = {n: o for n, o in _options.MESH.items() if n not in _options.NO_SETTINGS}
    keys = ((o.table, n.replace("_", "-")) for n, o in settings.items())
    return {f"in:{table}.{key}" if table else f"in:{key}" for table, key in keys}


def _is_mesh(row: Row) -> bool:
    return row["out:status"] in ("pass", "outside-tolerance")


def _costs(row: Row, objectives: Iterable[Tuple[str, float]]) -> Optional[List[float]]:
    values = [(row.get(f"out:{name}"), sign) for name, sign in objectives]
    if any(isinstance(v, bool) or not isinstance(v, (int, float)) for v, _ in values):
        return None
    return [sign * v for v, sign in values]


def _beats(a: Sequence[float], b: Sequence[float]) -> bool:
    return all(x <= y for x, y in zip(a, b)) and any(x < y for x, y in zip(a, b))


def sweep(
    space: Any,
    *,
    out: Any,
    sample: str = "grid",
    count: Optional[int] = None,
    seed: int = 0,
    executor: Any = None,
    workers: Optional[int] = None,
    threads: int = 1,
    workshop: Optional[Dict[str, Any]] = None,
    time_limit: Any = None,
    memory_limit: Any = None,
    html: bool = False,
    retries: int = 2,
    progress: Any = "auto",
) -> Study:
    """Solves every variant of a space, each in a folder below ``out``; what is finished there is
    read, not computed again.

    ``space`` maps ``surface`` and keywords of :func:`phex.mesh` to a value, a list of values, or
    :class:`phex.Between`; or it is a list of variants. ``sample`` is ``"grid"`` (every combination
    of lists), or ``"random"`` or ``"latin-hypercube"`` (with scipy) of ``count`` variants.

    ``executor`` is any ``concurrent.futures.Executor`` (``dask.distributed.Client.get_executor()``
    for clusters) or one of submitit; by default ``workers`` processes that are spawned. A worker
    that dies takes nothing with it: its variant is tried ``retries`` times more, and then has a row
    that says so. ``time_limit`` (``"90s"``) and ``memory_limit`` (``"2GB"``, of the worker's
    process) are a variant's. ``workshop`` (``thickness``, ``sheet``, ``nest_effort``) adds sheets
    and distinct parts. ``html`` writes a report for each variant.

    >>> import phex
    >>> phex.shape("sphere", triangles=500).save("ball.obj")
    >>> space = {"surface": "ball.obj", "panels": [32, 42], "max_deviation": "5%"}
    >>> study = phex.sweep(space, out="study", workers=1)
    >>> study.counts(), study.column("in:panels")
    ({'pass': 2}, [32, 42])
    """
    folder = os.path.abspath(path_text(out, "out"))
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise InputError(f"out: {folder} is a file, and no folder")
    how = _how(threads, workshop, time_limit, memory_limit, html)
    variants = _variants(space, sample, count, seed)
    jobs = [_job(variant, folder, how, k) for k, variant in enumerate(variants)]
    _name_surfaces(jobs, variants)
    engine = _engine(executor, workers, how["threads"])
    hear = listener(progress, False, False)
    try:
        rows = _solved(jobs, folder, engine, whole("retries", retries, 1000), hear)
    finally:
        engine.close()
        close(hear)
    return Study(rows, folder)


def _how(
    threads: Any, workshop: Any, time_limit: Any, memory_limit: Any, html: Any
) -> Dict[str, Any]:
    """What all jobs of a study share."""
    limits = {
        "seconds": None if time_limit is None else _amount("time_limit", time_limit, SECONDS),
        "megabytes": None if memory_limit is None else _amount("memory_limit", memory_limit, MEGABYTES),
    }
    made = {
        "threads": _options.threads(threads) or 1,
        "limits": limits,
        "html": bool(checked("html", html, Option("flag"))),
        "workshop": None,
    }
    if workshop is not None:
        made["workshop"] = _workshop(workshop)
    return made


SECONDS = {"min": 60.0, "h": 3600.0, "s": 1.0, "": 1.0}
MEGABYTES = {"GB": 1000.0, "MB": 1.0, "": 1.0}


def _amount(name: str, value: Any, units: Dict[str, float]) -> float:
    if not isinstance(value, str):
        return _above_zero(name, real(name, value))
    text = value.strip()
    unit = next(u for u in units if text.endswith(u))
    try:
        number = float(text[: len(text) - len(unit)]) * units[unit]
    except ValueError:
        raise InputError(f"{name}: {shown(value)} is no amount such as {'1' + next(iter(units))!r}") from None
    return _above_zero(name, real(name, number))


def _above_zero(name: str, number: float) -> float:
    if not number > 0.0:
        raise InputError(f"{name}: {shown(number)} is not above 0")
    return number


def _workshop(workshop: Any) -> Dict[str, Any]:
    names = {"thickness", "sheet", "nest_effort"}
    if not isinstance(workshop, dict) or "thickness" not in workshop or set(workshop) - names:
        raise InputError(f"workshop: {shown(workshop)} has no thickness, or more than sheet and nest_effort")
    made: Dict[str, Any] = {"thickness": measured("thickness", workshop["thickness"])}
    if "sheet" in workshop:
        made["sheet"] = _options.sheet(workshop["sheet"])
    made["nest_effort"] = whole("nest_effort", workshop.get("nest_effort", 0), (1 << 32) - 1)
    # Lengths are text for the compiled part, as in a study file.
    return json.loads(json.dumps(made))  # type: ignore[no-any-return]


# What is varied.


def _axes(space: Any) -> Dict[str, Any]:
    """Every name with its list of values, or its range."""
    if not isinstance(space, dict) or not space:
        raise InputError(f"space: {shown(space)} is no dictionary, and no list of some")
    axes: Dict[str, Any] = {}
    for name, values in space.items():
        if name != "surface" and (name not in _options.MESH or name in _options.NO_SETTINGS):
            raise InputError(f"space: {shown(name)} is not `surface`, and no setting of phex.mesh")
        if name == "threads":
            raise InputError("space: `threads` has no effect on a variant: give it beside the space")
        if isinstance(values, Between):
            low, high = real(name, values.low), real(name, values.high)
            if name == "surface" or low >= high:
                raise InputError(f"space: {name}: {shown(values)} is no range")
            axes[name] = values
        elif isinstance(values, (list, range)) or type(values).__name__ == "ndarray":
            axes[name] = [v.item() if hasattr(v, "item") else v for v in values]
            if not axes[name]:
                raise InputError(f"space: `{name}` is empty")
        else:
            axes[name] = [values]
    if "surface" not in axes:
        raise InputError("space: `surface` is missing")
    return axes


def _variants(space: Any, sample: Any, count: Any, seed: Any) -> Variants:
    sample = checked("sample", sample, Option("choice", choices=SAMPLES))
    if isinstance(space, (list, tuple)):
        if count is not None or sample != "grid":
            raise InputError("sample and count have no effect on a list of variants")
        return [{name: v[0] for name, v in _axes(variant).items()} for variant in space]
    axes = _axes(space)
    if sample == "grid":
        if count is not None:
            raise InputError("count has no effect on a grid: every combination is solved")
        for name, values in axes.items():
            if isinstance(values, Between):
                told = "is a range: give a list, or sample='random' or 'latin-hypercube'"
                raise InputError(f"space: `{name}` {told}")
        combinations = itertools.product(*axes.values())
        return [dict(zip(axes, values)) for values in combinations]
    if count is None:
        raise InputError(f"sample={sample!r} needs a count")
    return [
        {name: pick(values, share) for (name, values), share in zip(axes.items(), shares)}
        for shares in _shares(sample, whole("count", count, 10**7), len(axes), whole("seed", seed))
    ]


def _shares(sample: str, count: int, axes: int, seed: int) -> Iterable[Sequence[float]]:
    """Points of the unit cube."""
    if sample == "latin-hypercube":
        from scipy.stats import qmc

        return qmc.LatinHypercube(axes, rng=seed).random(count).tolist()  # type: ignore[no-any-return]
    numbers = random.Random(seed)
    return [[numbers.random() for _ in range(axes)] for _ in range(count)]


def pick(values: Any, share: float) -> Any:
    """The value of a list or range at a share from 0 to 1."""
    if isinstance(values, Between):
        return values.at(share)
    return values[min(int(share * len(values)), len(values) - 1)]


def _job(variant: Dict[str, Any], folder: str, how: Dict[str, Any], k: int) -> Dict[str, Any]:
    """A job for :func:`solve`: plain values, paths that other processes find."""
    options = {name: value for name, value in variant.items() if name != "surface"}
    if "surface" not in variant:
        raise InputError(f"variant {k} (counted from 0): `surface` is missing")
    try:
        typed, given, sizes = _options.settings(options)
    except InputError as wrong:
        raise InputError(f"variant {k} (counted from 0): {wrong}") from None
    if given or sizes is not None:
        name = next(iter(given), "size_field")
        raise InputError(f"variant {k} (counted from 0): {name}: a study takes files, and no arrays")
    for name, value in options.items():
        option = _options.MESH[name]
        if option.kind in ("sizes", "rows", "lines") and is_path(value):
            where = typed[option.table] if option.table else typed
            where[name.replace("_", "-")] = os.path.abspath(path_text(value, name))
    typed = {name: value for name, value in typed.items() if value != {}}
    return {"surface": _surface(variant["surface"], folder), "settings": typed, "out": folder, **how}


def _name_surfaces(jobs: List[Dict[str, Any]], variants: Variants) -> None:
    """Calls files of one name in several folders by their paths as they were given."""
    paths = {job["surface"] for job in jobs}
    names = Counter(os.path.basename(path) for path in paths)
    for job, variant in zip(jobs, variants):
        if names[os.path.basename(job["surface"])] > 1 and is_path(variant["surface"]):
            job["surface_name"] = path_text(variant["surface"], "surface")


def _surface(surface: Any, folder: str) -> str:
    """The file of a surface; one that is in memory gets a file below the study's folder."""
    if is_path(surface):
        return os.path.abspath(path_text(surface, "surface"))
    import hashlib

    given = surface if isinstance(surface, Polygons) else as_polygons(surface, Surface, "surface")
    arrays = (given.vertices, given.corners, given.offsets)
    name = hashlib.sha256(b"".join(a.tobytes() for a in arrays)).hexdigest()[:12]
    path = os.path.join(folder, "surfaces", f"{name}.obj")
    if not os.path.exists(path):
        try:
            os.makedirs(os.path.dirname(path), exist_ok=True)
        except OSError as cause:
            raise InputError(f"{folder}: {cause}") from None
        given.save(path)
    return path


# Who solves it.


class _Processes:
    """Processes of this machine, made anew when one dies."""

    #: A worker that dies takes all with it that its pool has.
    breaks = True

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._pool: Optional[ProcessPoolExecutor] = None

    def submit(self, job: Dict[str, Any]) -> Any:
        if self._pool is None:
            import multiprocessing

            spawn = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self.workers, spawn, _ignore_interrupts)
        return self._pool.submit(solve, job)

    def check(self) -> None:
        pass

    def window(self) -> int:
        return 2 * self.workers

    def renew(self) -> None:
        """Lets go of a broken pool."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(wait=False)

    def stop(self) -> None:
        """Ends what still runs."""
        pool, self._pool = self._pool, None
        if pool is None:
            return
        for process in list((getattr(pool, "_processes", None) or {}).values()):
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)

    def close(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(wait=True)


def _ignore_interrupts() -> None:
    """Ctrl-C is for the process that waits."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class _Given:
    """An executor of the caller's, which sees to its own workers."""

    breaks = False

    def __init__(self, executor: Any) -> None:
        if not callable(getattr(executor, "submit", None)):
            raise InputError(f"executor: {shown(executor)} has no submit")
        self._executor = executor

    def submit(self, job: Dict[str, Any]) -> Any:
        return self._executor.submit(solve, job)

    def batch(self, jobs: List[Dict[str, Any]]) -> Optional[List[Any]]:
        """All jobs at once, where an executor makes an array of them (submitit)."""
        array = getattr(self._executor, "map_array", None)
        return None if array is None else list(array(solve, jobs))

    def check(self) -> None:
        """Ends the wait for a client of Dask that has lost its scheduler: its futures never end."""
        client = getattr(self._executor, "_client", None)
        if getattr(client, "status", None) in ("closing", "closed"):
            raise PhexError(f"the executor has lost its scheduler; {GO_ON}")

    def window(self) -> int:
        return MOST_WAITING

    def renew(self) -> None:
        pass

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


_Engine = Union[_Processes, _Given]


def _engine(executor: Any, workers: Optional[int], threads: int) -> _Engine:
    if executor is not None:
        if workers is not None:
            raise InputError("workers has no effect with an executor, which has its own")
        return _Given(executor)
    count = max(1, (os.cpu_count() or 1) // threads) if workers is None else workers
    return _Processes(whole("workers", count, 10**6, least=1))


def _solved(
    jobs: List[Dict[str, Any]], folder: str, engine: _Engine, retries: int, hear: Any
) -> List[Row]:
    """The rows of jobs, in their order; the engine is ready for more."""
    rows: List[Optional[Row]] = _known(jobs, folder)
    todo = [k for k, row in enumerate(rows) if row is None]
    begun, ended = time.monotonic(), 0
    _tell(hear, None, len(jobs) - len(todo), len(jobs), 0.0)
    try:
        for k, row in _each(jobs, todo, engine, retries):
            rows[k] = row
            ended += 1
            left = (time.monotonic() - begun) / ended * (len(todo) - ended)
            _tell(hear, row, len(jobs) - len(todo) + ended, len(jobs), left)
    except BaseException:
        engine.stop()
        raise
    return [row for row in rows if row is not None]


def _known(jobs: List[Dict[str, Any]], folder: str) -> List[Optional[Row]]:
    """The rows that are there already."""
    if not jobs:
        return []
    keys = json.loads(run("keys", {"variants": [_variant(job) for job in jobs]})["keys"])
    request = {"out": folder, "keys": keys, "options": _solve_options(jobs[0])}
    return json.loads(run("finished", request)["rows"])  # type: ignore[no-any-return]


def _tell(hear: Any, row: Optional[Row], done: int, count: int, left: float) -> None:
    if hear is None:
        return
    events: List[Dict[str, Any]] = [{"event": "variant", "row": row}] if row else []
    share = done / count if count else 1.0
    events.append({"event": "progress", "done": share, "left_seconds": left})
    for event in events:
        if stops(hear(event)):
            raise Cancelled("the callback asked to stop; what is finished is kept")


def _each(
    jobs: List[Dict[str, Any]], todo: List[int], engine: _Engine, retries: int
) -> Iterator[Tuple[int, Row]]:
    """Numbers of jobs with their rows, as they end."""
    tries = {k: 0 for k in todo}
    waiting: Deque[int] = deque(todo)
    # Jobs one of which has killed a worker: alone each shows whether it was the one.
    suspects: Deque[int] = deque()
    running: Dict[Any, int] = {}
    ended = _Ended()
    batch = engine.batch([jobs[k] for k in todo]) if isinstance(engine, _Given) and todo else None
    if batch is not None:
        waiting.clear()
        for k, future in zip(todo, batch):
            running[future] = k
            ended.watch(future)
    while waiting or suspects or running:
        while (waiting and len(running) < engine.window()) or (suspects and not waiting and not running):
            k = waiting.popleft() if waiting else suspects.popleft()
            future = _submitted(engine, jobs[k])
            running[future] = k
            ended.watch(future)
        future = ended.next(running, engine)
        k = running.pop(future)
        try:
            row = future.result()
        except (InputError, KeyboardInterrupt):
            raise
        except BrokenExecutor as cause:
            # All that the pool had are under suspicion; one that was alone is guilty.
            broken = [k, *running.values()]
            running.clear()
            ended = _Ended()
            engine.renew()
            if len(broken) > 1:
                suspects.extend(sorted(broken))
                continue
            row = _lost_or_again(k, cause, tries, retries, suspects, jobs)
        except (Exception, CancelledError) as cause:
            row = _lost_or_again(k, cause, tries, retries, waiting, jobs)
        if row is not None:
            yield k, row


def _lost_or_again(
    k: int, cause: BaseException, tries: Dict[int, int], retries: int, again: Deque[int], jobs: Any
) -> Optional[Row]:
    tries[k] += 1
    if tries[k] <= retries:
        again.append(k)
        return None
    told = " ".join(str(cause).split())[:300] or type(cause).__name__
    reason = f"its worker was lost {tries[k]} times: {told}"
    made = run("lost", {"variant": _variant(jobs[k]), "reason": reason})
    return json.loads(made["row"])  # type: ignore[no-any-return]


def _submitted(engine: _Engine, job: Dict[str, Any]) -> Any:
    try:
        return engine.submit(job)
    except BrokenExecutor:
        engine.renew()
    except Exception as cause:
        raise PhexError(f"the executor takes no more work ({cause}); {GO_ON}") from cause
    return engine.submit(job)


class _Ended:
    """Futures in the order in which they end; those that call nobody back are asked."""

    def __init__(self) -> None:
        self._ended: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        self._asked: List[Any] = []

    def watch(self, future: Any) -> None:
        if isinstance(future, Future):
            future.add_done_callback(self._ended.put)
        else:
            self._asked.append(future)

    def next(self, running: Dict[Any, int], engine: _Engine) -> Any:
        while True:
            try:
                # A short wait, so that signals are heard.
                future = self._ended.get(timeout=0.2 if not self._asked else 0.05)
            except queue.Empty:
                engine.check()
                done = [f for f in self._asked if f.done()]
                for f in done:
                    self._asked.remove(f)
                    self._ended.put(f)
                continue
            if future in running:
                return future


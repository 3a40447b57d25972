"""Search among designs: optuna's samplers over the same variants as a study's."""

import json
import os
import time
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

from ._arrays import path_text, shown
from ._compute import close, listener, stops
from ._errors import InputError
from ._options import real, whole
from ._studies import (
    FIGURES,
    WORKSHOP_FIGURES,
    Between,
    Row,
    Study,
    _axes,
    _engine,
    _how,
    _job,
    _objective,
    _solved,
    checked_column,
)

#: What an objective is: a column, a column with a way, or a function of a row.
Objective = Union[str, Tuple[str, str], Callable[[Row], float]]
#: The file of optuna's journal.
JOURNAL = "optuna.journal"
#: How far from valid an end is, for samplers that learn from what is not allowed.
ENDS = {"pass": 0.0, "outside-tolerance": 1.0, "invalid": 2.0}


class Exploration(Study):
    """A study whose variants were chosen one after the other; rows are in the order of trials."""

    #: Names of the objectives.
    objectives: List[str]
    _values: List[Optional[List[float]]]
    _allowed: List[bool]

    def best(self) -> List[Row]:
        """The allowed variants that no other one beats in every objective."""
        there = [k for k, v in enumerate(self._values) if v is not None and self._allowed[k]]
        keys, best = set(), []
        for k in there:
            beaten = any(_beats(self._values[j], self._values[k]) for j in there)
            if not beaten and self.rows[k]["key"] not in keys:
                keys.add(self.rows[k]["key"])
                best.append(self.rows[k])
        return best

    def values(self) -> List[Optional[List[float]]]:
        """The objectives of each trial, of which less is better; ``None`` where there is no mesh or
        a constraint fails."""
        pairs = zip(self._values, self._allowed)
        return [value if allowed else None for value, allowed in pairs]


def _beats(a: Any, b: Any) -> bool:
    return all(x <= y for x, y in zip(a, b)) and any(x < y for x, y in zip(a, b))


def explore(
    space: Any,
    objectives: Sequence[Objective],
    *,
    out: Any,
    trials: int = 100,
    constraints: Optional[Dict[str, Tuple[Optional[float], Optional[float]]]] = None,
    batch: Optional[int] = None,
    seed: int = 0,
    sampler: Any = None,
    executor: Any = None,
    workers: Optional[int] = None,
    threads: int = 1,
    workshop: Optional[Dict[str, Any]] = None,
    time_limit: Any = None,
    memory_limit: Any = None,
    html: bool = False,
    retries: int = 2,
    progress: Any = "auto",
) -> Exploration:
    """Looks for the best variants of a space with optuna: it proposes a ``batch``, which is solved
    as by :func:`phex.sweep` and told to it, until there are ``trials`` of them. Small batches (4, if
    nothing else is asked for) learn more, large ones keep more workers busy.

    ``objectives`` are columns of the table (``"panels"``, ``"deviation"``, ``"distinct-lengths"``,
    ``"area-spread"``, ``"clearance"``, ``"sheet-use"`` with ``workshop``, ...), of which less is
    better, or more of those of :meth:`Study.pareto`; pairs such as ``("panels", "max")``; or
    functions of a row, to be made small. A variant is allowed if it passes every check and each
    column of ``constraints`` lies in its range ``(low, high)``, ``None`` for no limit. Lists of
    numbers are taken in their order, other lists as names; ranges are :class:`phex.Between`.

    Trials are kept in ``optuna.journal`` below ``out``: the same call goes on where it ended, with
    more ``trials`` it adds some. ``sampler`` is one of optuna's (default: a multi-objective TPE).
    """
    try:
        import optuna
    except ImportError as error:
        raise ImportError("phex.explore needs optuna: pip install 'phex[explore]'") from error

    folder = os.path.abspath(path_text(out, "out"))
    count, seed = whole("trials", trials, 10**7), whole("seed", seed, (1 << 32) - 1)
    known = FIGURES + (WORKSHOP_FIGURES if workshop is not None else ())
    if not isinstance(objectives, (list, tuple)):
        raise InputError(f"objectives: {shown(objectives)} is no list of columns")
    aims = [_aim(objective, known) for objective in objectives]
    if not aims:
        raise InputError("objectives: there is none")
    limits = _limits(constraints or {}, known)
    search = _search(objectives, limits)
    axes = _axes(space)
    how = _how(threads, workshop, time_limit, memory_limit, html)
    engine = _engine(executor, workers, how["threads"])
    retries = whole("retries", retries, 1000)
    size = whole("batch", 4 if batch is None else batch, 10**6)
    if size == 0:
        raise InputError("batch: 0 variants at a time")
    os.makedirs(folder, exist_ok=True)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    backend = optuna.storages.journal.JournalFileBackend(os.path.join(folder, JOURNAL))
    storage = optuna.storages.JournalStorage(backend)
    study = optuna.create_study(
        study_name="phex", storage=storage, load_if_exists=True, directions=["minimize"] * len(aims)
    )
    if len(study.directions) != len(aims):
        raise InputError(f"out: {folder} is of a search with {len(study.directions)} objectives")
    done = [t for t in study.get_trials(deepcopy=False) if "row" in t.user_attrs]
    if done and study.user_attrs.get("search", search) != search:
        told = "is of a search with other objectives or constraints: give those, or another folder"
        raise InputError(f"out: {folder} {told}")
    _lay_aside(study, optuna)
    study.set_user_attr("search", search)
    study.sampler = sampler or _usual_sampler(optuna, seed + len(done))
    hear = listener(progress, False, False)
    begun, known_before = time.monotonic(), len(done)
    try:
        while len(done) < count:
            asked = [study.ask() for _ in range(min(size, count - len(done)))]
            variants = [_variant_of(trial, axes) for trial in asked]
            jobs = [_job(variant, folder, how, k) for k, variant in enumerate(variants)]
            for trial, row in zip(asked, _solved(jobs, folder, engine, retries, None)):
                _told(study, trial, row, aims, limits, optuna)
            done = [t for t in study.get_trials(deepcopy=False) if "row" in t.user_attrs]
            if hear is not None:
                each = (time.monotonic() - begun) / (len(done) - known_before)
                left = each * max(count - len(done), 0)
                event = {"event": "progress", "done": len(done) / count, "left_seconds": left}
                if stops(hear(event)):
                    break
    finally:
        engine.close()
        close(hear)
    made = Exploration([t.user_attrs["row"] for t in done], folder)
    made.objectives = [name for name, _ in aims]
    made._values = [t.values if t.values else None for t in done]
    made._allowed = [all(c <= 0.0 for c in t.user_attrs["constraints"]) for t in done]
    return made


def _search(objectives: Sequence[Objective], limits: "Limits") -> Dict[str, Any]:
    """What trials are judged by, as JSON holds it: a function is known by its name."""
    aims = [_named(o) if callable(o) else _objective(o) for o in objectives]
    return json.loads(json.dumps({"objectives": aims, "constraints": limits}))  # type: ignore[no-any-return]


def _named(objective: Any) -> str:
    return getattr(objective, "__name__", "function")


def _usual_sampler(optuna: Any, seed: int) -> Any:
    import warnings

    with warnings.catch_warnings():
        # Constraints and joint sampling are marked as experiments of optuna.
        warnings.simplefilter("ignore")
        return optuna.samplers.TPESampler(
            seed=seed,
            multivariate=True,
            constant_liar=True,
            n_startup_trials=12,
            constraints_func=lambda trial: trial.user_attrs["constraints"],
        )


def _aim(objective: Any, known: Sequence[str]) -> Tuple[str, Callable[[Row], Optional[float]]]:
    """An objective's name, and what of a row is to be small."""
    if callable(objective):
        return _named(objective), lambda row: _finite(objective(row))
    name, sign = _objective(objective)
    checked_column(name, known, "objectives")

    def value(row: Row) -> Optional[float]:
        found = _finite(row.get(f"out:{name}"))
        return None if found is None else sign * found

    return name, value


def _finite(value: Any) -> Optional[float]:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    number = float(value)
    return number if abs(number) < float("inf") else None


Limits = List[Tuple[str, float, float]]


def _limits(constraints: Any, known: Sequence[str]) -> Limits:
    """Columns with the factor and limit by which more than 0 is not allowed."""
    if not isinstance(constraints, dict):
        raise InputError(f"constraints: {shown(constraints)} is no dictionary")
    made: Limits = []
    for column, ends in constraints.items():
        name = checked_column(column, known, "constraints")
        if not isinstance(ends, (tuple, list)) or len(ends) != 2:
            raise InputError(f"constraints: {name}: {shown(ends)} is no pair (low, high)")
        low, high = ends
        if low is not None:
            made.append((name, -1.0, -real(name, low)))
        if high is not None:
            made.append((name, 1.0, real(name, high)))
    return made


def _excess(row: Row, limits: Limits) -> List[float]:
    """How far a row is outside of each limit; at most 0 is inside."""
    excess = [ENDS.get(row["out:status"], 3.0)]
    for name, sign, limit in limits:
        value = _finite(row.get(f"out:{name}"))
        excess.append(1.0 if value is None else sign * value - limit)
    return excess


def _variant_of(trial: Any, axes: Dict[str, Any]) -> Dict[str, Any]:
    """A variant that optuna proposes."""
    variant: Dict[str, Any] = {}
    for name, values in axes.items():
        if isinstance(values, Between):
            draw = trial.suggest_int if values.is_whole else trial.suggest_float
            variant[name] = draw(name, values.low, values.high)
        elif len(values) == 1:
            variant[name] = values[0]
        elif all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):
            variant[name] = sorted(values)[trial.suggest_int(name, 0, len(values) - 1)]
        else:
            variant[name] = values[trial.suggest_categorical(name, list(range(len(values))))]
    return variant


def _told(study: Any, trial: Any, row: Row, aims: Any, limits: Limits, optuna: Any) -> None:
    trial.set_user_attr("row", row)
    trial.set_user_attr("constraints", _excess(row, limits))
    values = [aim(row) for _, aim in aims] if row["out:status"] in ENDS else [None]
    if any(value is None for value in values):
        study.tell(trial, state=optuna.trial.TrialState.FAIL)
    else:
        study.tell(trial, values)


def _lay_aside(study: Any, optuna: Any) -> None:
    """Trials that an earlier run left open are asked again."""
    running = optuna.trial.TrialState.RUNNING
    for trial in study.get_trials(deepcopy=False, states=(running,)):
        study.tell(trial.number, state=optuna.trial.TrialState.FAIL)
        if trial.params:
            study.enqueue_trial(trial.params)

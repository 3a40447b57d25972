"""Waiting for a computation: events, signals and callbacks in the caller's thread."""

import json
import sys
import threading
import time
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np

from . import _phex
from ._arrays import shown
from ._errors import Cancelled, InputError, NoValidResult

Event = Dict[str, Any]
Listener = Callable[[Event], Any]

#: Seconds that the caller's thread sleeps before it looks for signals and events.
TICK = 0.05


def begin(
    what: str,
    request: Dict[str, Any],
    meshes: Any = (),
    sizes: Any = None,
    kept: Any = None,
    threads: Optional[int] = None,
    preview: bool = False,
    session: Optional[_phex.KeptSurface] = None,
) -> _phex.Computation:
    """Begins a computation on threads of its own."""
    try:
        text = json.dumps(request, allow_nan=False)
        text.encode("utf-8")
    except (TypeError, ValueError) as cause:
        raise InputError(f"an option is not finite, or no text: {cause}") from None
    given = ([m._given() for m in meshes], sizes, kept, session)
    return _phex.start(what, text, given, threads, preview)


def finish(
    computation: _phex.Computation, hear: Optional[Listener] = None, keep_best: bool = False
) -> Dict[str, Any]:
    """Waits for the answer. A signal or a callback that returns ``False`` ends the computation;
    with ``keep_best`` it ends with what it has, unless there is a second signal."""
    was_stopped = False
    while True:
        try:
            ended = computation.wait(TICK)
            if hear is not None and not was_stopped:
                for text in computation.events():
                    if stops(hear(json.loads(text))):
                        raise Cancelled("the callback asked to stop")
            if ended:
                break
        except BaseException as stop:
            computation.cancel()
            if was_stopped or not keep_best or not isinstance(stop, (KeyboardInterrupt, Cancelled)):
                raise
            was_stopped = True
    return computation.take()


def run(what: str, request: Dict[str, Any], *meshes: Any, **how: Any) -> Dict[str, Any]:
    """Begins a computation and waits for it."""
    hear = how.pop("hear", None)
    return finish(begin(what, request, meshes, **how), hear)


class Future:
    """A computation that runs; as :class:`concurrent.futures.Future`, with progress and preview.
    It is cancelled when nothing holds the future any more: nobody could ask for its result.

    >>> import phex
    >>> future = phex.start(phex.shape("sphere", triangles=2000), panels=32, max_deviation="5%")
    >>> future.result(timeout=60).verdict
    'pass'
    """

    def __init__(
        self, computation: _phex.Computation, made: Callable[[Dict[str, Any]], Any]
    ) -> None:
        self._computation = computation
        self._made = made
        self._lock = threading.RLock()
        self._outcome: Optional[Tuple[Any, Optional[BaseException]]] = None
        self._was_cancelled = False
        self._done = 0.0
        self._events: List[Event] = []

    def done(self) -> bool:
        """Whether there is a result, or an error; at once after :meth:`cancel`."""
        return self._was_cancelled or self._computation.wait(0.0)

    def running(self) -> bool:
        """Whether it computes still."""
        return not self.done()

    def cancel(self) -> bool:
        """Ends it; ``False`` if it had ended. What computes still stops by itself, soon."""
        if self._computation.wait(0.0):
            return False
        self._was_cancelled = True
        self._computation.cancel()
        return True

    def cancelled(self) -> bool:
        """Whether it was cancelled before it ended."""
        return self._was_cancelled

    def events(self) -> List[Event]:
        """What happened since the last call."""
        with self._lock:
            self._hear()
            events, self._events = self._events, []
        return events

    @property
    def progress(self) -> float:
        """Share that is done, from 0 to 1; it never falls."""
        with self._lock:
            self._hear()
            return 1.0 if self.done() else self._done

    def _hear(self) -> None:
        events = [json.loads(text) for text in self._computation.events()]
        for event in events:
            if event.get("event") == "progress":
                self._done = max(self._done, event["done"])
        self._events.extend(events)

    def preview(self) -> Any:
        """What the mesh looks like now: ``(stage, Mesh)`` if that is news, else ``None``. It may not
        be valid."""
        from ._mesh import Mesh

        news = self._computation.preview()
        return None if news is None else (news[0], Mesh._of(news[1]))

    def result(self, timeout: Optional[float] = None) -> Any:
        """Waits for the result, ``timeout`` seconds at the most.

        Raises :class:`TimeoutError`, or what the computation ended with."""
        until = None if timeout is None else time.monotonic() + timeout
        while not (self._was_cancelled or self._computation.wait(TICK)):
            if until is not None and time.monotonic() >= until:
                raise TimeoutError(f"the computation takes more than {timeout} s")
        with self._lock:
            if self._outcome is None:
                try:
                    if self._was_cancelled:
                        raise Cancelled("the computation was cancelled")
                    self._outcome = (self._made(self._computation.take()), None)
                except Exception as error:
                    self._outcome = (None, error)
            made, error = self._outcome
        if error is not None:
            raise error
        return made

    def exception(self, timeout: Optional[float] = None) -> Optional[BaseException]:
        """The error that it ended with, or ``None``; waits as :meth:`result`."""
        try:
            self.result(timeout)
        except TimeoutError:
            raise
        except Exception as error:
            return error
        return None

    def add_done_callback(self, call: Callable[["Future"], Any]) -> None:
        """Calls back on a thread of its own when the computation has ended."""

        def wait() -> None:
            while not self._computation.wait(60.0):
                pass
            call(self)

        threading.Thread(target=wait, daemon=True).start()


def stops(answer: Any) -> bool:
    """Whether a callback's answer, ``False`` of Python or numpy, ends the computation."""
    return isinstance(answer, (bool, np.bool_)) and not answer


def listener(progress: Any, quiet: bool, verbose: bool) -> Optional[Listener]:
    """What hears the events: a callback, a bar, lines of JSON, or nothing."""
    mode = progress_mode(progress, quiet, verbose)
    if callable(mode):
        return mode  # type: ignore[no-any-return]
    if mode == "json":
        return lambda event: print(json.dumps(event), file=sys.stderr, flush=True)
    if mode == "bar" or (mode == "auto" and not quiet and _is_watched()):
        return Bar(verbose)
    return None


def progress_mode(progress: Any, quiet: Any, verbose: Any) -> Any:
    """How progress is shown: a callback, or ``auto``, ``none``, ``json`` or ``bar``."""
    for name, value in (("quiet", quiet), ("verbose", verbose)):
        if not isinstance(value, (bool, np.bool_)):
            raise InputError(f"{name}: {shown(value)} is not True or False")
    if callable(progress):
        return progress
    mode = {True: "bar", False: "none"}[progress] if isinstance(progress, bool) else progress
    if not isinstance(mode, str) or mode not in ("auto", "none", "json", "bar"):
        told = "'auto', 'none', 'json', a bool or a function"
        raise InputError(f"progress: {shown(progress)} is not {told}")
    return mode


def _is_watched() -> bool:
    """Whether somebody sees a bar: in a terminal, or a notebook."""
    shell = sys.modules.get("IPython")
    in_notebook = shell is not None and "ZMQ" in type(shell.get_ipython()).__name__
    try:
        return in_notebook or sys.stderr.isatty()
    except (AttributeError, ValueError):
        return False


class Bar:
    """A bar of the share that is done: that of tqdm if it is there, else one of our own."""

    def __init__(self, verbose: bool = False) -> None:
        self._verbose = verbose
        self._width = 0
        try:
            from tqdm.auto import tqdm
        except ImportError:
            self._tqdm = None
        else:
            self._tqdm = tqdm(total=100, unit="%", leave=False)

    def __call__(self, event: Event) -> None:
        kind = event.get("event")
        if kind == "progress":
            self._show(event["done"], event["left_seconds"])
        elif kind == "note" or (self._verbose and kind == "stage_finished"):
            text = event.get("message") or f"{event['stage']}: done"
            self.close()
            print(text, file=sys.stderr)

    def _show(self, done: float, left: float) -> None:
        if self._tqdm is not None:
            self._tqdm.n = round(100 * done)
            self._tqdm.refresh()
            return
        full = int(30 * done)
        text = f"{100 * done:3.0f} % [{'#' * full}{'.' * (30 - full)}] about {left:.0f} s left"
        print("\r" + text.ljust(self._width), end="", file=sys.stderr, flush=True)
        self._width = len(text)

    def close(self) -> None:
        """Takes the bar off the screen."""
        if self._tqdm is not None:
            self._tqdm.clear()
        elif self._width:
            print("\r" + " " * self._width + "\r", end="", file=sys.stderr, flush=True)
            self._width = 0


def close(hear: Any) -> None:
    """The computation has ended."""
    if isinstance(hear, Bar):
        hear.close()
        if hear._tqdm is not None:
            hear._tqdm.close()


def no_valid(message: str, result: Any) -> NoValidResult:
    """The error of a mesh that is not valid, with the mesh."""
    error = NoValidResult(message)
    error.result = result
    return error


def floats(values: Any) -> List[float]:
    """Plain numbers of an array."""
    return [float(x) for x in np.asarray(values, dtype=np.float64).reshape(-1)]

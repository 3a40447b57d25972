import concurrent.futures
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import phex
import pytest

#: Seconds within which a computation is left, on a machine that has other work as well.
AT_ONCE = 1.0


@pytest.fixture(scope="module")
def large():
    return phex.shape("roof", triangles=20000)


def small_job(seed):
    made = phex.mesh(
        phex.shape("torus", triangles=1500), panels=40, seed=seed, max_deviation="5%",
        keep_invalid=True, progress=False,
    )  # fmt: skip
    return made.vertices.tobytes()


def stops(large, call):
    """Seconds between `call`, a while into a computation, and its end."""
    began = []

    def later():
        time.sleep(1.0)
        began.append(time.monotonic())
        call()

    threading.Thread(target=later).start()
    return began


def test_an_interrupt_ends_it_at_once(large):
    # A shell's background jobs ignore interrupts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    began = stops(large, lambda: os.kill(os.getpid(), signal.SIGINT))
    try:
        with pytest.raises(KeyboardInterrupt):
            phex.mesh(large, panels=3000)
        assert time.monotonic() - began[0] < AT_ONCE
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_callback_ends_it_at_once_in_its_own_thread(large):
    heard = []

    def hear(event):
        heard.append((threading.get_ident(), time.monotonic()))
        return len(heard) < 5

    with pytest.raises(phex.Cancelled):
        phex.mesh(large, panels=3000, progress=hear)
    assert time.monotonic() - heard[-1][1] < AT_ONCE
    assert {thread for thread, _ in heard} == {threading.get_ident()}


def test_a_false_of_numpy_ends_it_too(large):
    with pytest.raises(phex.Cancelled):
        phex.mesh(large, panels=3000, progress=lambda event: np.bool_(False))


def test_what_would_be_shown_has_no_effect_in_the_background(roof):
    session = phex.Session(roof, progress=print, verbose=True)
    wrong = {"progress": [print, "json", True, "loud", 3], "verbose": [True, 1], "quiet": [1, "no"]}
    for name, values in wrong.items():
        for value in values:
            for call in (session.start, lambda **options: phex.start(roof, **options)):
                with pytest.raises(phex.InputError, match=name):
                    call(**{name: value})
    for start in (session.start, lambda **options: phex.start(roof, **options)):
        start(progress=False, quiet=True).cancel()
        start(progress="none").cancel()


def test_files_of_the_background_are_written_when_the_result_is_asked_for(sphere):
    future = phex.start(sphere, panels=32, max_deviation="5%", output="deep/a.obj")
    while not future.done():
        time.sleep(0.01)
    assert not os.path.exists("deep")
    future.result()
    assert os.path.exists("deep/a.obj")


def test_a_future_that_nothing_holds_is_cancelled(large):
    future = phex.start(large, panels=3000)
    while future.progress == 0.0:
        time.sleep(0.01)
    del future

    def works():
        before = time.process_time()
        time.sleep(0.3)
        return time.process_time() - before > 0.03

    began = time.monotonic()
    while works():
        assert time.monotonic() - began < 10.0 * AT_ONCE


def test_an_error_of_a_callback_comes_out(large):
    def hear(event):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        phex.mesh(large, panels=3000, progress=hear)


def test_another_thread_cancels_and_other_threads_go_on(large):
    future = phex.start(large, panels=3000)
    ticks = 0
    until = time.monotonic() + 1.0
    while time.monotonic() < until:
        time.sleep(0.005)
        ticks += 1
    assert ticks > 20, "the interpreter's lock is held"
    began = stops(large, future.cancel)
    with pytest.raises(phex.Cancelled):
        future.result(timeout=100)
    assert time.monotonic() - began[0] < 20 and future.cancelled() and future.done()


def test_a_future_tells_progress_and_shows_previews(roof):
    future = phex.start(roof, panels=60, max_deviation="5%", keep_invalid=True)
    with pytest.raises(TimeoutError):
        future.result(timeout=0.0)
    shares, stages = [0.0], set()
    while not future.done():
        shares.append(future.progress)
        news = future.preview()
        if news is not None:
            stages.add(news[0])
            low, high = roof.vertices.min(axis=0), roof.vertices.max(axis=0)
            size = np.linalg.norm(high - low)
            assert (news[1].vertices > low - 0.2 * size).all(), "model coordinates"
            assert (news[1].vertices < high + 0.2 * size).all(), "model coordinates"
        time.sleep(0.01)
    news = future.preview()
    stages |= {news[0]} if news else set()
    assert shares == sorted(shares) and stages
    called = threading.Event()
    future.add_done_callback(lambda f: called.set())
    assert called.wait(10) and future.result() is future.result() and future.progress == 1.0
    assert {e["event"] for e in future.events()} >= {"stage_started", "progress"}


def test_the_best_so_far_is_kept_where_asked(roof):
    seen = []

    def hear(event):
        seen.append(event)
        return not (event["event"] == "stage_finished" and event["stage"] == "trim")

    made = phex.mesh(
        roof, panels=300, progress=hear, keep_best=True, keep_invalid=True, max_deviation="5%"
    )
    assert any("best mesh so far" in note for note in made.report["notes"])
    with pytest.raises(phex.NoValidResult, match="within 0.01 s"):
        phex.mesh(phex.shape("roof", triangles=20000), panels=3000, time_limit="0.01s")


def test_threads_do_not_change_the_result(roof):
    how = {"panels": 40, "max_deviation": "5%", "keep_invalid": True}
    one, two = phex.mesh(roof, threads=1, **how), phex.mesh(roof, threads=2, **how)
    assert one.vertices.tobytes() == two.vertices.tobytes()


def test_two_threads_at_once():
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        made = list(pool.map(small_job, [1, 2, 1]))
    assert made[0] == made[2] == small_job(1) and made[0] != made[1]


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_child_processes_give_the_same(method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {method} here")
    here = small_job(1)
    context = multiprocessing.get_context(method)
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        assert pool.submit(small_job, 1).result(timeout=200) == here


def test_meshes_cross_processes(ball):
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        judged = pool.submit(phex.check, ball).result(timeout=200)
    assert judged.verdict == "pass" and np.array_equal(judged.vertices, ball.vertices)


def test_it_is_imported_fast_and_numpy_is_all_it_takes():
    code = (
        "import sys, numpy, time; t = time.perf_counter(); import phex; "
        "s = time.perf_counter() - t; "
        "heavy = {'compas', 'trimesh', 'pyvista', 'rhino3dm', 'tqdm', 'IPython'} & set(sys.modules); "
        "print(s, heavy)"
    )
    said = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    seconds, heavy = said.stdout.split(" ", 1)
    assert float(seconds) < 0.5 and heavy.strip() == "set()"


def test_bars_are_drawn_and_taken_away(roof, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    phex.mesh(roof, panels=30, progress=True, max_deviation="5%", keep_invalid=True)
    drawn = capsys.readouterr().err
    assert "left" in drawn and drawn.rstrip(" ").endswith("\r")
    phex.mesh(roof, panels=30, progress="json", max_deviation="5%", keep_invalid=True)
    assert '"event": "progress"' in capsys.readouterr().err
    phex.mesh(roof, panels=30, max_deviation="5%", keep_invalid=True)
    assert capsys.readouterr().err == "", "nobody watches"

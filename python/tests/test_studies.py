"""Studies: one variant has one folder, one mesh and one row, whoever solves it."""

import csv
import hashlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import phex
import pytest

SPACE = {"panels": [40, 46], "rotate": [0.0, 20.0], "boundary": ["snap", "clip"], "max_deviation": "5%"}


@pytest.fixture(scope="module")
def dome(tmp_path_factory):
    path = tmp_path_factory.mktemp("surfaces") / "dome.obj"
    phex.shape("elliptic-paraboloid", triangles=600).save(path)
    return str(path)


@pytest.fixture(scope="module")
def solved(dome, tmp_path_factory):
    """A study on processes, which others are compared with."""
    out = tmp_path_factory.mktemp("processes")
    return phex.sweep({"surface": dome, **SPACE}, out=out, workers=2)


def meshes(out):
    return {p.parent.name: p.read_bytes() for p in pathlib.Path(out).glob("*/mesh.obj")}


def same(one, other):
    key = lambda row: row["key"]  # noqa: E731
    assert sorted(one.rows, key=key) == sorted(other.rows, key=key)
    assert meshes(one.out) == meshes(other.out) and len(meshes(one.out)) == len(one)


def test_a_variant_is_a_folder_and_a_row(solved):
    assert len(solved) == 8 and set(solved.counts()) <= {"pass", "outside-tolerance"}
    for row in solved:
        folder = pathlib.Path(solved.out) / row["key"]
        record = json.loads((folder / "run.json").read_text())
        assert record["row"] == row and record["cost"]["seconds"] > 0
        digest = hashlib.sha256((folder / "mesh.obj").read_bytes()).hexdigest()
        assert row["out:mesh"] == digest[:16]
        report = json.loads((folder / "report.json").read_text())
        assert row["out:panels"] == report["measures"]["faces"]
        assert (folder / "picture.png").read_bytes()[:4] == b"\x89PNG"
        assert row["in:surface"] == "dome.obj" and row["in:max-deviation"] == "5%"
    assert len({row["key"] for row in solved}) == 8


def test_the_program_s_shards_give_the_same(solved, dome, program, tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(
        f"surfaces = ['{dome}']\n[settings]\nmax-deviation = '5%'\n[space]\npanels = [40, 46]\n"
        "rotate = [0, 20.0]\nboundary = ['snap', 'clip']\n"
    )
    out = tmp_path / "shards"
    for shard in ("1/3", "2/3", "3/3"):
        words = [program, "sweep", str(study), "-o", str(out), "--shard", shard, "-q", "-t", "1"]
        subprocess.run(words, check=True, timeout=300)
    same(solved, phex.Study.read(out))
    subprocess.run([program, "sweep", "collect", str(out), "-q"], check=True, timeout=60)
    with open(out / "designs.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    assert len(rows) == 8 and {"in:panels", "out:deviation", "img", "threeD", "key"} <= set(rows[0])
    assert (out / rows[0]["img"]).exists() and (out / rows[0]["threeD"]).exists()
    assert phex.Study.read(out).table() == (out / "designs.csv").read_text()
    assert "parallel axes" in (out / "index.html").read_text()


def test_what_is_finished_is_read(solved, dome):
    marks = {p: p.stat().st_mtime_ns for p in pathlib.Path(solved.out).rglob("*")}
    again = phex.sweep({"surface": dome, **SPACE}, out=solved.out, workers=1)
    assert again.rows == solved.rows
    assert marks == {p: p.stat().st_mtime_ns for p in pathlib.Path(solved.out).rglob("*")}


def test_ends_without_a_mesh_are_rows(dome, tmp_path):
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    variants = [
        {"surface": dome, "rotate": 4000.0},
        {"surface": bad},
        {"surface": dome, "panels": 40, "max_deviation": "0.0001%"},
        {"surface": dome, "panels": 40, "max_deviation": "5%"},
    ]
    study = phex.sweep(variants, out="study", workers=1)
    assert [row["out:exit"] for row in study] == [4, 4, 3, 0]
    assert "rotate" in study.rows[0]["out:reason"] and "9" in study.rows[1]["out:reason"]
    assert study.rows[2]["out:reason"].startswith("deviation")
    assert study.column("panels")[:2] == [None, None]
    study.save("designs.csv")
    assert len(list(csv.DictReader(open("designs.csv", newline="")))) == 4


def test_limits_end_a_variant_and_wider_ones_try_again(dome):
    variant = {"surface": dome, "panels": 40, "max_deviation": "5%"}
    late = phex.sweep([variant], out="study", workers=1, time_limit=1e-4)
    assert late.counts() == {"time-limit": 1} and "0.0001 s" in late.rows[0]["out:reason"]
    kept = phex.sweep([variant], out="study", workers=1, time_limit=1e-5)
    assert kept.rows == late.rows, "a narrower limit needs no second try"
    wide = phex.sweep([variant], out="study", workers=1, time_limit="60s")
    assert wide.counts() == {"pass": 1} and wide.rows[0]["key"] == late.rows[0]["key"]
    if sys.platform == "linux":
        heavy = phex.sweep([{**variant, "panels": 41}], out="study", workers=1, memory_limit=1.0)
        assert heavy.counts() == {"memory-limit": 1}


def test_samples_fill_the_space_and_repeat(dome):
    from phex._studies import _variants

    space = {"surface": dome, "panels": phex.Between(40, 49), "rotate": phex.Between(0.0, 60.0)}
    pytest.importorskip("scipy")
    cube = _variants(space, "latin-hypercube", 10, 3)
    assert sorted(v["panels"] for v in cube) == list(range(40, 50)), "one in each tenth"
    assert sorted(int(v["rotate"] // 6) for v in cube) == list(range(10))
    assert cube == _variants(space, "latin-hypercube", 10, 3) != _variants(space, "latin-hypercube", 10, 4)
    drawn = _variants(space, "random", 200, 0)
    assert {v["panels"] for v in drawn} == set(range(40, 50))
    assert all(0.0 <= v["rotate"] <= 60.0 for v in drawn)


@pytest.mark.parametrize(
    "space, more, word",
    [
        ({"panels": 40}, {}, "surface"),
        ({"surface": "no.obj"}, {}, "no.obj"),
        ({"surface": "no.obj", "pannels": 3}, {}, "pannels"),
        ({"surface": "no.obj", "output": "x"}, {}, "output"),
        ({"surface": "no.obj", "panels": []}, {}, "empty"),
        ({"surface": "no.obj", "threads": [1, 2]}, {}, "beside the space"),
        ({"surface": "no.obj", "panels": phex.Between(1, 5)}, {}, "range"),
        ({"surface": "no.obj", "panels": phex.Between(5, 5)}, {"sample": "random", "count": 2}, "range"),
        ({"surface": "no.obj", "panels": float("nan")}, {}, "panels"),
        ({"surface": "no.obj", "size_field": [1.0]}, {}, "size_field"),
        ({"surface": "no.obj"}, {"sample": "sobol"}, "sobol"),
        ({"surface": "no.obj"}, {"time_limit": "soon"}, "soon"),
        ({"surface": "no.obj"}, {"memory_limit": -1}, "memory_limit"),
        ({"surface": "no.obj"}, {"workshop": {"sheet": (1, 2)}}, "thickness"),
        ({"surface": "no.obj"}, {"workshop": {"thickness": 1, "sheet": ("10%", "8000")}}, "percentage"),
        ({"surface": "no.obj"}, {"workshop": {"thickness": 1, "sheet": "big"}}, "no sheet"),
        ({"surface": "no.obj"}, {"workers": 0}, "workers"),
        ({"surface": "no.obj"}, {"threads": 0}, "threads"),
        ({"surface": "no.obj"}, {"executor": 3}, "submit"),
        ("roof", {}, "space"),
        ([{"surface": "no.obj"}], {"sample": "random", "count": 3}, "list"),
    ],
)
def test_what_a_study_can_t_mean_is_refused(space, more, word):
    with pytest.raises(phex.InputError, match=word):
        phex.sweep(space, out="study", **more)
    assert not list(pathlib.Path().glob("study/*/run.json"))


def test_a_study_is_no_file():
    pathlib.Path("study").write_text("mine")
    with pytest.raises(phex.InputError, match="study is a file"):
        phex.sweep({"surface": "no.obj"}, out="study")
    assert pathlib.Path("study").read_text() == "mine"


def test_a_killed_worker_loses_nothing(solved, dome):
    """Workers are killed while they compute; rows and meshes are those of an undisturbed study."""
    out, ended = pathlib.Path("killed"), threading.Event()

    def kill():
        killed = 0
        while killed < 3 and not ended.wait(0.05):
            workers = children(os.getpid())
            begun = len(list(out.glob("*/mesh.obj")))
            if workers and begun > killed:
                os.kill(workers[0], signal.SIGKILL)
                killed += 1
        assert killed > 0

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        study = phex.sweep({"surface": dome, **SPACE}, out=out, workers=2)
    finally:
        ended.set()
        killer.join()
    same(solved, study)


def children(parent):
    """Processes that Python's pool has spawned (not the one that tracks their resources)."""
    found = []
    for place in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            status = (place / "stat").read_text().rsplit(")", 1)[1].split()
            words = (place / "cmdline").read_text()
        except OSError:
            continue
        if int(status[1]) == parent and "spawn_main" in words:
            found.append(int(place.name))
    return found


class Deadly:
    """An executor whose worker dies of some jobs, as Dask tells of it."""

    def __init__(self, deadly):
        self.deadly, self.calls = deadly, []

    def submit(self, function, job):
        from concurrent.futures import Future

        future = Future()
        self.calls.append(job["settings"]["panels"])
        if self.deadly(job, self.calls):
            future.set_exception(RuntimeError("the worker died"))
        else:
            future.set_result(function(job))
        return future


def test_a_job_that_kills_its_workers_is_a_row(dome):
    space = {"surface": dome, "panels": [40, 46], "max_deviation": "5%"}
    always = Deadly(lambda job, calls: job["settings"]["panels"] == 40)
    study = phex.sweep(space, out="study", executor=always)
    assert study.counts() == {"lost": 1, "pass": 1} and always.calls.count(40) == 3
    assert "3 times: the worker died" in study.rows[0]["out:reason"]
    once = Deadly(lambda job, calls: calls.count(40) == 1 and job["settings"]["panels"] == 40)
    study = phex.sweep(space, out="study", executor=once)
    assert study.counts() == {"pass": 2}, "a lost variant is tried again by the next call"
    assert once.calls.count(46) == 0, "and what was finished is not"


def test_a_lost_scheduler_ends_the_wait(dome):
    from concurrent.futures import Future

    class Lost:
        """As Dask's executor when its client has given up: futures that never end."""

        class _client:
            status = "closed"

        def submit(self, function, job):
            return Future()

    with pytest.raises(phex.PhexError, match="go on with the same call"):
        phex.sweep([{"surface": dome}], out="study", executor=Lost())


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no full device")
def test_a_full_disk_is_a_row_and_tried_again(dome):
    variant = {"surface": dome, "panels": 40, "max_deviation": "5%"}
    key = phex.sweep([{**variant, "rotate": 4000.0}, variant], out="other", workers=1).rows[1]["key"]
    folder = pathlib.Path("study") / key
    folder.mkdir(parents=True)
    (folder / "mesh.obj").symlink_to("/dev/full")
    study = phex.sweep([variant, {**variant, "panels": 46}], out="study", workers=1)
    assert study.counts() == {"not-written": 1, "pass": 1}
    assert "No space left" in study.rows[0]["out:reason"]
    assert not (folder / "run.json").exists()
    (folder / "mesh.obj").unlink()
    study = phex.sweep([variant, {**variant, "panels": 46}], out="study", workers=1)
    assert study.counts() == {"pass": 2}


def test_a_study_is_stopped_and_goes_on(dome):
    def stop(event):
        return np.bool_(event["event"] != "variant")

    space = {"surface": dome, **SPACE}
    with pytest.raises(phex.Cancelled):
        phex.sweep(space, out="study", workers=1, progress=stop)
    assert 1 <= len(phex.Study.read("study")) < 8
    assert children(os.getpid()) == [] or time.sleep(1.0) or children(os.getpid()) == []
    heard = []
    phex.sweep(space, out="study", workers=2, progress=lambda event: heard.append(event))
    shares = [e["done"] for e in heard if e["event"] == "progress"]
    assert shares == sorted(shares) and shares[0] > 0.0 and shares[-1] == 1.0


def test_tables_and_the_best(solved, tmp_path):
    best = solved.pareto("panels", "deviation")
    assert 1 <= len(best) < len(solved)
    for row in best:
        beaten = [
            r
            for r in solved
            if r["out:panels"] <= row["out:panels"] and r["out:deviation"] < row["out:deviation"]
        ]
        assert not beaten
    assert solved.pareto(("panels", "max")) == [
        r for r in solved if r["out:panels"] == max(solved.column("panels"))
    ]
    pytest.importorskip("pyarrow.parquet")
    import pyarrow.parquet

    solved.save("designs.parquet")
    assert pyarrow.parquet.read_table("designs.parquet").num_rows == 8
    solved.save("index.html")
    with pytest.raises(phex.InputError, match="xlsx"):
        solved.save("designs.xlsx")


def test_surfaces_of_one_file_name_are_told_apart_and_a_broken_variant_is_left_out(tmp_path):
    for folder, triangles in (("a", 500), ("b", 2000)):
        (tmp_path / folder).mkdir()
        phex.shape("sphere", triangles=triangles).save(tmp_path / folder / "ball.obj")
    paths = [str(tmp_path / folder / "ball.obj") for folder in "ab"]
    space = {"surface": paths, "panels": 32, "max_deviation": "5%"}
    study = phex.sweep(space, out=tmp_path / "study", workers=1)
    assert study.column("in:surface") == paths
    (tmp_path / "study" / study.rows[0]["key"] / "run.json").write_text("{")
    with pytest.warns(UserWarning, match="run the study again"):
        assert phex.Study.read(tmp_path / "study").rows == study.rows[1:]


def test_surfaces_in_memory_and_sheets(tmp_path):
    ball = phex.shape("sphere", triangles=500)
    workshop = {"thickness": "20mm", "sheet": "2500x1250"}
    space = {"surface": [ball, ball], "panels": 32, "max_deviation": "5%"}
    study = phex.sweep(space, out="study", workers=1, workshop=workshop)
    row = study.rows[0]
    assert study.rows[1] == row, "the same surface is the same variant"
    assert row["out:sheets"] >= 1 and 0 < row["out:sheet-use"] <= 100 and row["out:distinct-panels"] >= 1
    assert row["in:workshop.thickness"] == "20mm"


def test_dask_gives_the_same(solved, dome, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            space = {"surface": dome, **SPACE}
            same(solved, phex.sweep(space, out=tmp_path / "dask", executor=client.get_executor(retries=3)))


def test_submitit_gives_the_same(solved, dome, tmp_path):
    submitit = pytest.importorskip("submitit")
    executor = submitit.AutoExecutor(tmp_path / "logs", cluster="local")
    executor.update_parameters(timeout_min=5)
    same(solved, phex.sweep({"surface": dome, **SPACE}, out=tmp_path / "submitit", executor=executor))


def test_explore_finds_and_goes_on(dome):
    pytest.importorskip("optuna")
    space = {
        "surface": dome,
        "panels": phex.Between(40, 60),
        "rotate": [0.0, 15.0, 30.0],
        "boundary": ["snap", "clip"],
        "effort": "draft",
        "max_deviation": "5%",
    }
    aims = ["panels", "deviation"]

    def look(trials):
        return phex.explore(
            space, aims, out="search", trials=trials, batch=3, workers=1,
            constraints={"deviation": (None, 4.0)},
        )  # fmt: skip

    found = look(6)
    assert len(found) == 6 and found.objectives == aims
    more = look(9)
    assert len(more) == 9 and more.rows[:6] == found.rows, "it goes on where it ended"
    assert look(6).rows == more.rows
    for row in more.best():
        assert row["out:status"] == "pass" and row["out:deviation"] <= 4.0
    with pytest.raises(phex.InputError, match="objectives"):
        phex.explore(space, ["panels"], out="search", trials=10)
    limits = {"deviation": (None, 4.0)}
    for other, more in ((["panels", ("deviation", "max")], limits), (aims, {}), (["panels", "clearance"], limits)):
        with pytest.raises(phex.InputError, match="other objectives or constraints"):
            phex.explore(space, other, out="search", trials=10, constraints=more)


def test_explore_keeps_its_workers_and_says_how_long_it_takes(dome, monkeypatch):
    pytest.importorskip("optuna")
    from phex import _studies

    begun, heard = [], []
    pool = _studies.ProcessPoolExecutor
    monkeypatch.setattr(_studies, "ProcessPoolExecutor", lambda *how: begun.append(how) or pool(*how))
    space = {"surface": dome, "panels": phex.Between(40, 60), "effort": "draft", "max_deviation": "5%"}
    phex.explore(
        space, ["panels"], out="search", trials=4, batch=2, workers=1, progress=lambda e: heard.append(e)
    )
    assert len(begun) == 1 and children(os.getpid()) == []
    left = [event["left_seconds"] for event in heard]
    assert left[0] > 0.0 and left[-1] == 0.0
    with pytest.raises(phex.InputError, match="retries"):
        phex.explore(space, ["panels"], out="search", trials=4, retries=-1)


def test_a_page_that_is_wanted_later_is_made(dome):
    variant = {"surface": dome, "panels": 40, "max_deviation": "5%", "effort": "draft"}
    first = phex.sweep([variant], out="study", workers=1)
    again = phex.sweep([variant], out="study", workers=1, html=True)
    assert again.rows == first.rows and len(list(pathlib.Path("study").glob("*/report.html"))) == 1


def test_columns_that_no_study_has_are_named(solved, dome):
    for call in (
        lambda: solved.column("nope"),
        lambda: solved.column(["nope"]),
        lambda: solved.pareto("panels", "nope"),
        lambda: solved.pareto(("nope", "max")),
    ):
        with pytest.raises(phex.InputError, match="no column .*nope.*deviation"):
            call()
    for name in ("out:deviation", "rotate", "in:rotate", "in:steering.closeness", "sheets"):
        assert len(solved.column(name)) == 8
    assert solved.column("sheets") == [None] * 8
    assert set(solved.column("deviation")) == set(solved.column("out:deviation")) != {None}


def test_every_figure_of_a_row_may_be_an_objective(solved):
    from phex._studies import FIGURES

    texts = {"out:status", "out:exit", "out:reason", "out:mesh"}
    there = {c for row in solved for c in row if c.startswith("out:")}
    assert there - texts == {f"out:{name}" for name in FIGURES}


@pytest.mark.parametrize(
    "aims, more, word",
    [
        (["devation"], {}, "'devation'.*deviation"),
        ([("devation", "max")], {}, "'devation'.*deviation"),
        ("panels", {}, "'panels' is no list"),
        (["sheets"], {}, "'sheets'.*deviation"),
        (["panels"], {"constraints": {"clearence": (0.1, None)}}, "'clearence'.*clearance"),
    ],
)
def test_a_search_for_what_no_row_has_is_refused(dome, aims, more, word):
    pytest.importorskip("optuna")
    with pytest.raises(phex.InputError, match=word):
        phex.explore({"surface": dome, "panels": [40, 46]}, aims, out="search", trials=2, **more)
    assert not pathlib.Path("search").exists()

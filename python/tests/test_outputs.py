"""Files that are asked for are checked before the computation, and written wherever they can be."""

import os
import pathlib

import phex
import pytest

HOW = {"panels": 32, "max_deviation": "5%"}
#: A file for each keyword.
FILES = {
    "output": "panels.obj",
    "write_target": "target.ply",
    "contact_sheet": "sheet.png",
    "png": "picture.png",
    "html": "page.html",
    "report": "run.json",
}


@pytest.fixture
def idle(monkeypatch):
    """Nothing is computed."""
    monkeypatch.setattr(phex._functions, "begin", lambda *a, **k: pytest.fail("it computes"))


@pytest.mark.parametrize("name, file", FILES.items())
def test_places_that_take_no_file_are_refused_first(idle, sphere, name, file):
    pathlib.Path("taken").write_text("a file")
    pathlib.Path(file).mkdir()
    refusing = [f"/proc/{file}"] if os.path.isdir("/proc/self") else []
    long = [300 * "x" + file, f"deep/{300 * 'x'}/{file}"]
    for path in (f"taken/{file}", f"taken/deep/{file}", file, "", *long, *refusing):
        for call in (phex.mesh, phex.start):
            with pytest.raises(phex.InputError) as raised:
                call(sphere, **HOW, **{name: path})
            assert name in str(raised.value) and path in str(raised.value)


@pytest.mark.parametrize("name", ["output", "write_target"])
@pytest.mark.parametrize("path", ["panels.xyz", "panels", "panels.png", ".obj"])
def test_endings_of_meshes_are_known(idle, sphere, name, path):
    with pytest.raises(phex.InputError, match=f"{name}: .*a mesh is written as one of .obj"):
        phex.mesh(sphere, **HOW, **{name: path})


def test_missing_folders_are_made_for_every_file(sphere):
    paths = {name: f"deep/{name}/{file}" for name, file in FILES.items()}
    made = phex.mesh(sphere, effort="draft", **HOW, **paths)
    assert all(pathlib.Path(path).stat().st_size > 0 for path in paths.values())
    for name in ("a/b.html", "c/d.png", "e/f.svg", "g/h.obj"):
        made.save(name)
        assert pathlib.Path(name).exists()
    made.save_report("i/j.json")


def test_an_error_names_the_file_and_not_one_before_it(ball):
    pathlib.Path("taken").write_text("a file")
    for name in ("taken/a.png", "taken/a.html"):
        with pytest.raises(phex.InputError) as raised:
            ball.save(name)
        assert str(raised.value).startswith(name) and ".phex-" not in str(raised.value)


@pytest.fixture
def given(sphere):
    """The user's own files."""
    sphere.save("in.obj")
    pathlib.Path("job.toml").write_text("panels = 32\n[guides]\nguide = 'g.obj'\n")
    pathlib.Path("g.obj").write_text("v 1 0 0\nv 0 1 0\nl 1 2\n")


@pytest.mark.parametrize(
    "how",
    [
        {"output": "in.obj"},
        {"report": "./in.obj"},
        {"png": "link.png"},
        {"config": "job.toml", "report": "job.toml"},
        {"config": "job.toml", "output": "g.obj"},
        {"guide": "g.obj", "output": "g.obj"},
        {"html": "same.html", "report": "same.html"},
        {"output": "a.obj", "write_target": "a.obj"},
    ],
)
def test_no_file_is_written_that_is_read_or_written_twice(idle, given, how):
    os.symlink("in.obj", "link.png")
    for surface in ("in.obj", phex.Surface.read("in.obj")):
        for call in (phex.mesh, phex.start):
            with pytest.raises(phex.InputError, match="is also read, or written twice"):
                call(surface, **how)


def test_a_file_is_not_converted_into_itself(given):
    with pytest.raises(phex.InputError, match="output: in.obj: is also read"):
        phex.convert("in.obj", "in.obj")


def test_links_are_followed_by_every_file(sphere):
    for file in FILES.values():
        os.symlink(f"real-{file}", file)
    phex.mesh(sphere, effort="draft", **HOW, **FILES)
    for file in FILES.values():
        assert os.path.islink(file) and os.path.getsize(f"real-{file}") > 0


@pytest.mark.parametrize("name, path", [("png", "a.jpg"), ("html", "a.png")])
def test_pictures_and_pages_have_names_of_their_kind(tmp_path, roof, name, path):
    with pytest.raises(phex.InputError, match=f"{name}: .*are written as"):
        phex.mesh(roof, panels=40, **{name: tmp_path / path})
    assert not list(tmp_path.iterdir())

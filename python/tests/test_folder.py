"""A folder of workshop files is written by the rules of `phex fab`: nothing of others goes."""

import hashlib
import pathlib
import subprocess

import phex
import pytest

HEAD = "# Files of `phex fab`: it writes over them and removes them as long as they are as listed.\n"
HOW = {"thickness": "20mm", "nest_effort": 0}


@pytest.fixture(scope="module")
def workshop(ball):
    return phex.fabricate(ball, **HOW)


def checksum(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def folder_of(files, head=HEAD):
    folder = pathlib.Path("folder")
    folder.mkdir()
    for name, content in files.items():
        (folder / name).write_text(content)
    lines = (f"{checksum(folder / name)}  {name}\n" for name in files)
    (folder / "phex.sha256").write_text(head + "".join(lines))
    return folder


@pytest.mark.parametrize("head", ["", "# Files of `phex offset`: others.\n"])
def test_files_that_other_lists_name_stay(workshop, head):
    folder = folder_of({"mine.txt": "mine"}, head)
    with pytest.raises(phex.InputError, match="not a list that `phex fab` wrote"):
        workshop.save(folder)
    assert sorted(p.name for p in folder.iterdir()) == ["mine.txt", "phex.sha256"]


@pytest.mark.parametrize("name", ["../mine.txt", "{here}/mine.txt", "a/../../mine.txt", "", "."])
def test_a_list_names_nothing_outside_of_its_folder(workshop, name):
    mine = pathlib.Path("mine.txt")
    mine.write_text("mine")
    pathlib.Path("folder").mkdir()
    entry = f"{checksum(mine)}  {name.format(here=pathlib.Path.cwd())}\n"
    pathlib.Path("folder/phex.sha256").write_text(HEAD + entry)
    with pytest.raises(phex.InputError, match="line 2 is no checksum and name"):
        workshop.save("folder")
    assert mine.read_text() == "mine"


def test_lines_of_a_list_are_checksums_and_names(workshop):
    folder_of({})
    for line in ("short  a.txt", "0" * 64 + " a.txt", "g" * 64 + "  a.txt"):
        pathlib.Path("folder/phex.sha256").write_text(HEAD + line + "\n")
        with pytest.raises(phex.InputError, match="line 2 is no checksum and name"):
            workshop.save("folder")


def test_a_note_of_the_user_stays_and_what_is_no_longer_made_goes(workshop, program, ball):
    folder = folder_of({"old.dxf": "old"})
    (folder / "note.txt").write_text("mine")
    workshop.save(folder)
    assert (folder / "note.txt").read_text() == "mine" and not (folder / "old.dxf").exists()
    listed = (folder / "phex.sha256").read_text().splitlines()[1:]
    assert [line[66:] for line in listed] == sorted(workshop.files)
    ball.save("ball.obj")
    words = ["--thickness", "20mm", "--nest-effort", "0", "-q"]
    subprocess.run([program, "fab", "ball.obj", "-o", str(folder), *words], check=True)
    workshop.save(folder)
    assert (folder / "note.txt").read_text() == "mine"


def test_what_is_in_the_way_stops_it_before_anything_is_written(workshop):
    folder = folder_of({"old.dxf": "old"})
    for place in ("panels.csv", "sheets"):
        (folder / place).write_text("mine")
        with pytest.raises(phex.InputError, match="is in the way"):
            workshop.save(folder)
        (folder / place).unlink()
    (folder / "sheets").symlink_to(pathlib.Path.cwd(), target_is_directory=True)
    with pytest.raises(phex.InputError, match="is in the way"):
        workshop.save(folder)
    (folder / "sheets").unlink()
    (folder / "old.dxf").write_text("changed")
    with pytest.raises(phex.InputError, match="old.dxf has been changed since"):
        workshop.save(folder)
    assert sorted(p.name for p in folder.iterdir()) == ["old.dxf", "phex.sha256"]


def test_the_folder_is_checked_before_the_nesting(ball, monkeypatch):
    monkeypatch.setattr(phex._functions, "begin", lambda *a, **k: pytest.fail("it computes"))
    pathlib.Path("other").mkdir()
    pathlib.Path("other/mine.txt").write_text("mine")
    with pytest.raises(phex.InputError, match="other files"):
        phex.fabricate(ball, "other", **HOW)
    with pytest.raises(phex.InputError, match="no folder"):
        phex.fabricate(ball, "other/mine.txt", **HOW)
    with pytest.raises(phex.InputError, match="folder: '' is no path"):
        phex.fabricate(ball, "", **HOW)
    folder_of({})
    ball.save("folder/ball.obj")
    with pytest.raises(phex.InputError, match="is read and lies in the folder"):
        phex.fabricate("folder/ball.obj", "folder", **HOW)

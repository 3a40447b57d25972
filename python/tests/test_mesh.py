import copy
import json
import pathlib
import pickle
import re
import subprocess

import numpy as np
import phex
import pytest


def program_mesh(program, surface, *words):
    surface.save("surface.obj")
    subprocess.run(
        [program, "mesh", "surface.obj", "-o", "made.obj", "--report", "run.json", "-q", *words],
        check=False,
    )
    with open("run.json", encoding="utf-8") as file:
        return phex.Mesh.read("made.obj"), json.load(file)


def same(a, b):
    return all(
        np.array_equal(x, y)
        for x, y in ((a.vertices, b.vertices), (a.corners, b.corners), (a.offsets, b.offsets))
    )


def test_same_mesh_as_the_program_bit_for_bit(program, roof):
    theirs, report = program_mesh(
        program, roof, "-n", "50", "--rotate", "15.1", "--max-deviation", "3%", "--fairness", "1.37"
    )
    there = phex.Surface.read("surface.obj")
    ours = phex.mesh(there, panels=50, rotate=15.1, max_deviation="3%", fairness=1.37)
    assert same(ours, theirs)
    for part in ("settings", "checks", "measures", "verdict", "inputs", "statistics", "limits"):
        assert ours.report[part] == report[part], part


def test_a_job_file_means_the_same(program, roof):
    text = "panels = 40\nmax-deviation = '4%'\nseed = 3\n[steering]\ncloseness = 1.7\n"
    with open("job.toml", "w", encoding="utf-8") as file:
        file.write(text)
    theirs, _ = program_mesh(program, roof, "--config", "job.toml")
    assert same(phex.mesh("surface.obj", config="job.toml"), theirs)
    # Keywords come first, as the command line does.
    other = phex.mesh("surface.obj", config="job.toml", panels=30, seed=0)
    assert other.report["settings"]["panels"] == 30 and other.report["settings"]["seed"] == 0


def test_arrays_in_memory_mean_the_same_as_files(program, roof):
    sizes = 2.0 + np.arange(len(roof.vertices)) / len(roof.vertices)
    points = roof.vertices[[0, -1]] * 1.0000001
    np.savetxt("sizes.txt", sizes, fmt="%.17g")
    np.savetxt("points.txt", points, fmt="%.17g")
    words = ["--size-field", "sizes.txt", "--anchors", "points.txt", "-n", "40", "--keep-invalid"]
    theirs, _ = program_mesh(program, roof, *words, "--max-deviation", "5%")
    how = {"panels": 40, "max_deviation": "5%", "keep_invalid": True}
    ours = phex.mesh("surface.obj", size_field=sizes, anchors=points, **how)
    files = phex.mesh("surface.obj", size_field="sizes.txt", anchors="points.txt", **how)
    assert same(ours, theirs) and same(files, theirs)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("index", [np.int32, np.uint8, np.int64])
def test_arrays_of_any_kind_are_taken(kind, index):
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=kind)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array(quads, dtype=index)
    for given in (faces, np.asfortranarray(faces), faces.tolist(), [tuple(f) for f in quads]):
        made = phex.Mesh(cube[::1], given)
        assert made.per_face("area").tolist() == [1.0] * 6
        assert phex.check(made).verdict == "pass"
    assert phex.Mesh.from_corners(cube, faces.ravel(), np.arange(0, 25, 4)).offsets[-1] == 24


def test_what_a_result_tells(ball, sphere):
    assert 25 < len(ball) == len(ball.faces) < 40 and ball.sound and ball.verdict == "pass"
    assert sorted({len(face) for face in ball.faces}) == [5, 6]
    assert ball.offenders == {} and ball.report["tool"]["name"] == "phex"
    assert ball.per_face("planarity").max() < 1e-12
    assert ball.per_face("corners").sum() == len(ball.corners)
    assert ball.per_face("area").sum() == pytest.approx(4 * np.pi, rel=0.2)
    with pytest.raises(phex.InputError, match="each edge"):
        ball.per_face("dihedral")
    with pytest.raises(phex.InputError, match="`nothing` is none of"):
        ball.per_face("nothing")
    with pytest.raises(ValueError, match="read-only"):
        ball.vertices[0] = 0.0


def tables(made):
    """What a page says, without the data that it draws."""
    page = made.page(curves=False).split('id="phex-data"')[0]
    return re.sub(r"base64,[^\"]*", "", page)


def test_pictures_and_pages(ball):
    assert ball._repr_png_().startswith(b"\x89PNG") and "<table>" in ball._repr_html_()
    assert b"<svg" in ball.picture("planarity", svg=True)
    assert "</html>" in ball.page(curves=False)
    again = pickle.loads(pickle.dumps(ball))
    assert same(again, ball) and again.report == ball.report
    assert tables(again) == tables(ball)
    with pytest.raises(ValueError, match="read-only"):
        again.vertices[0] = 0.0


def test_pages_of_copies_say_what_those_of_the_results_say(sphere, panels):
    failing = phex.mesh(sphere, panels=60, min_edge=0.5, max_deviation="5%", effort="draft")
    assert "min_edge" in failing.offenders
    bent = panels.vertices + 1e-4 * np.sin(1e3 * panels.vertices)
    for made in (failing, panels, phex.planarize((bent, panels.faces)), phex.check(panels)):
        for again in (copy.copy(made), pickle.loads(pickle.dumps(copy.deepcopy(made)))):
            assert tables(again) == tables(made)


def test_a_copy_that_the_judge_sees_otherwise_has_no_page(ball):
    other = copy.copy(ball)
    other._report_text = ball._report_text.replace('"verdict": "pass"', '"verdict": "invalid"')
    with pytest.raises(phex.InputError, match="make the page from the result itself"):
        other.page()


def test_files(ball):
    for name in ["a.obj", "a.ply", "a.off", "a.stl", "a.json", "a.dxf", "a.glb", "a.3mf", "a.png"]:
        ball.save(name)
    assert same(phex.Mesh.read("a.ply"), ball)
    with pytest.raises(phex.InputError, match="a.xyz"):
        ball.save("a.xyz")
    with pytest.raises(phex.InputError, match="nowhere"):
        phex.Surface.read("nowhere.obj")
    phex.convert("a.obj", "b.off")
    assert same(phex.Mesh.read("b.off"), ball)


def test_an_invalid_mesh_is_an_error_with_the_mesh():
    torus = phex.shape("torus", triangles=1000)
    with pytest.raises(phex.NoValidResult) as raised:
        phex.mesh(torus, panels=4, output="no.obj")
    made = raised.value.result
    assert made.verdict == "invalid" and made.offenders
    with pytest.raises(FileNotFoundError):
        open("no.obj", encoding="utf-8")
    kept = phex.mesh(torus, panels=4, keep_invalid=True)
    kept.save("yes.obj")
    assert not kept.sound


def test_offsets(ball):
    made = phex.offset(ball, [-0.05, "2%"], max_distance=True, gauss_image=True)
    inner, outer = made.layers
    assert phex.check(inner).verdict == "pass" and made.max_distance[0] < -0.05
    assert made.distances[1] == pytest.approx(0.02 * np.linalg.norm(np.ptp(ball.vertices, axis=0)))
    corners = [ball.vertices[f].mean(axis=0) for f in ball.faces]
    normals = [n / np.linalg.norm(n) for n in corners]
    for k, face in enumerate(inner.faces):
        gap = (ball.vertices[ball.faces[k]] - inner.vertices[face]) @ normals[k]
        assert gap == pytest.approx(0.05, abs=0.01)
    with pytest.raises(phex.NoValidResult, match="largest safe distance") as refused:
        ball.offset(-5.0)
    largest = re.search(r"side is (-[0-9.]+) ", str(refused.value)).group(1)
    assert len(largest.lstrip("-0.")) <= 6 and ball.offset(float(largest)).layers
    with pytest.raises(phex.InputError, match="touching the unit sphere"):
        phex.offset(ball, 0.1, kind="edge")


def test_koebe_meshes_have_edge_offsets(ball):
    koebe = phex.koebe(ball)
    for a, b in zip(koebe.faces[0], np.roll(koebe.faces[0], -1)):
        p, d = koebe.vertices[a], koebe.vertices[b] - koebe.vertices[a]
        foot = p - d * (p @ d) / (d @ d)
        assert np.linalg.norm(foot) == pytest.approx(1.0, abs=1e-9)
    assert len(phex.offset(koebe, 0.05, kind="edge").layers) == 1
    near = phex.parallel(koebe, phex.shape("sphere", triangles=2000), max_deviation="20%")
    assert len(near) == len(ball)


def test_planarize_and_check(ball):
    rng = np.random.default_rng(0)
    bent = phex.Mesh(ball.vertices + 1e-3 * rng.normal(size=ball.vertices.shape), ball.faces)
    judged = phex.check(bent)
    assert judged.verdict != "pass" and "planarity" in judged.offenders
    flat = phex.planarize(bent, fix=[0])
    assert flat.per_face("planarity").max() < 1e-12 and flat.sound
    assert np.array_equal(flat.vertices[0], bent.vertices[0])


def test_the_workshop(ball):
    made = phex.fabricate(ball, "workshop", thickness="20mm", nest_effort=0)
    assert made.summary["panels"] == len(ball) and "sheets/sheet-01.dxf" in made.files
    made.save("workshop")
    with open("workshop/panels.csv", "a", encoding="utf-8") as file:
        file.write("mine\n")
    with pytest.raises(phex.InputError, match="panels.csv"):
        made.save("workshop")
    with pytest.raises(phex.InputError, match="thickness"):
        phex.fabricate(ball, thickness="thick")


def test_the_same_workshop_as_the_program(program, ball):
    ball.save("ball.obj")
    words = ["--thickness", "20mm", "--nest-effort", "0", "--sheet", "1500x3000", "-q"]
    subprocess.run([program, "fab", "ball.obj", "-o", "theirs", *words], check=True)
    ours = phex.fabricate("ball.obj", thickness="20mm", nest_effort=0, sheet="1500x3000")
    for name, content in ours.files.items():
        with open(f"theirs/{name}", "rb") as file:
            if not name.endswith(".xlsx"):  # which hold the time
                assert file.read() == content, name
    # The program takes the folder that Python wrote for one of its own.
    ours.save("mixed")
    subprocess.run([program, "fab", "ball.obj", "-o", "mixed", *words], check=True)
    ours.save("mixed")


def test_networks_and_shapes(roof):
    found = phex.network(roof, panels=80)
    assert all(curve.shape[1] == 3 for curve in found.rows + found.columns)
    assert "torus" in phex.shapes()
    with pytest.raises(phex.InputError, match="minor"):
        phex.shape("torus", minor=-1.0)


def test_a_warm_start_moves_what_it_is_told(ball, sphere):
    again = phex.mesh(sphere, start=ball, fix=[3], max_deviation="5%")
    assert len(again) == len(ball)


def test_faces_that_are_there_twice_are_left_out(roof):
    once = phex.mesh(roof, panels=60, max_deviation="5%", keep_invalid=True)
    faces = [*roof.faces, *roof.faces]
    twice = phex.mesh((roof.vertices, faces), panels=60, max_deviation="5%", keep_invalid=True)
    assert np.array_equal(once.vertices, twice.vertices)
    assert any("there twice" in note for note in twice.report["notes"])


def test_planarize_sews_panels_that_have_corners_of_their_own(ball):
    corners = np.concatenate([ball.vertices[face] for face in ball.faces])
    ends = np.cumsum([len(face) for face in ball.faces])
    loose = (corners, [np.arange(end - len(face), end) for face, end in zip(ball.faces, ends)])
    flat = phex.planarize(loose)
    assert len(flat.vertices) == len(ball.vertices) and len(flat) == len(ball)
    assert "joined" in flat.report["notes"][0]


@pytest.mark.parametrize(
    "name, value",
    [
        ("guide", [[(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]]),
        ("cones", [(0.0, 0.0, 1.0, 1)]),
        ("size_field", np.ones(1002)),
    ],
)
def test_a_warm_start_refuses_arrays_that_a_layout_heeds(ball, sphere, name, value):
    told = name.replace("_", "-")
    with pytest.raises(phex.InputError, match=f"`{told}` has no effect with `start`"):
        phex.mesh(sphere, start=ball, **{name: value})


def test_a_mesh_is_judged_again_as_its_run_was(roof, program, monkeypatch):
    roof.save("roof.obj")
    words = [program, "mesh", "roof.obj", "-n", "60", "--boundary", "snap", "--max-deviation", "3%"]
    subprocess.run([*words, "-o", "panels.obj", "--report", "run.json", "-q"], check=False)
    again = phex.check("panels.obj", report_of="run.json")
    limits = json.loads(pathlib.Path("run.json").read_text())["limits"]
    assert again.report["limits"] == limits and again.report["limits"]["max_deviation"] == "3%"
    assert again.report["deviation_facets"] is not None
    pathlib.Path("elsewhere").mkdir()
    with monkeypatch.context() as moved:
        moved.chdir("elsewhere")
        pathlib.Path("roof.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        same = phex.check("../panels.obj", report_of="../run.json")
    assert same.report["deviation_facets"] == again.report["deviation_facets"]
    tighter = phex.check("panels.obj", report_of="run.json", max_deviation="0.0001%")
    assert "deviation" in tighter.offenders and again.verdict != tighter.verdict
    made = phex.mesh("roof.obj", panels=60, boundary="snap", max_deviation="3%", keep_invalid=True)
    judged = phex.check(made, report_of=made)
    assert judged.verdict == made.verdict
    assert judged.report["deviation_smooth"] == made.report["deviation_smooth"]
    pathlib.Path("roof.obj").write_text("v 0 0 0\n")
    with pytest.raises(phex.InputError, match="changed|roof.obj"):
        phex.check("panels.obj", report_of="run.json")
    with pytest.raises(phex.InputError, match="report_of"):
        phex.check("panels.obj", report_of="no.json")


def test_solids_and_beams_lie_between_layers(ball):
    shell = phex.offset(ball, [-0.05, 0.05], solids=True, beams=True)
    (solids,), (beams,) = shell.solids, shell.beams
    area = ball.per_face("area").sum()
    assert shell.volumes[0] == pytest.approx(0.1 * area, rel=0.01)
    corners = np.diff(ball.offsets)
    assert len(solids) == int((corners + 2).sum()), "two faces and a side for each edge"
    lower = shell.layers[0].vertices
    assert np.array_equal(beams["ends"], lower[beams["vertices"]])
    assert beams["direction"].shape == (len(lower), 3) and np.abs(beams["torsion"]).max() < 1e-9
    single = phex.offset(ball, 0.05, solids=True, gap="1mm")
    assert 0 < single.volumes[0] < 0.05 * area * 1.05
    for wrong in ({"solids": True}, {"distance": 0.1, "gap": 0.01}):
        with pytest.raises(phex.InputError):
            phex.offset(ball, **wrong)


def test_the_space_of_parallel_meshes(ball):
    free = phex.parallel(ball, basis=True)
    assert np.abs(free.vertices - ball.vertices).max() < 1e-9
    vectors = int(free.basis[:, 0].max()) + 1
    assert vectors == free.report["statistics"]["dimension"]
    edge = tuple(int(v) for v in free.basis[0, 2:4])
    before = np.linalg.norm(ball.vertices[edge[0]] - ball.vertices[edge[1]])
    made = phex.parallel(ball, lengths={edge: 1.01 * before}, keep_invalid=True)
    after = np.linalg.norm(made.vertices[edge[0]] - made.vertices[edge[1]])
    assert before < after < 1.01 * before * (1 + 1e-9)
    faces = zip(ball.faces, made.faces)
    assert all(np.array_equal(a, b) for a, b in faces)
    with pytest.raises(phex.InputError, match="no edge joins 0 and 0"):
        phex.parallel(ball, lengths=[((0, 0), 1.0)])


def test_a_session_keeps_what_stays_and_nothing_else(roof):
    session = phex.Session(roof, panels=60, effort="draft", max_deviation="5%", keep_invalid=True)
    for options in ({}, {"rotate": 20}, {"boundary": "whole"}, {"panels": 40}, {}):
        kept = session.mesh(**options)
        anew = phex.mesh(roof, **{**session.options, **options})
        assert kept.vertices.tobytes() == anew.vertices.tobytes(), options
    assert session.start(until="layout").result(timeout=60).verdict
    again = pickle.loads(pickle.dumps(session))
    assert again.mesh().vertices.tobytes() == session.mesh().vertices.tobytes()
    with pytest.raises(TypeError, match="pannels"):
        session.mesh(pannels=3)
    with pytest.raises(phex.InputError):
        phex.Session("no.obj")


def test_panels_beyond_a_limit_of_the_run_are_outside_a_tolerance():
    sphere = phex.shape("sphere", triangles=2000)
    options = dict(panels=32, max_deviation="5%", max_edge=0.1, keep_invalid=True)
    made = phex.mesh(sphere, **options)
    assert (made.per_face("validity") >= 2).all()
    assert (phex.mesh(sphere, panels=32, max_deviation="5%").per_face("validity") < 2).all()

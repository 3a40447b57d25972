import math
import os
import random

import numpy as np
import phex
import pytest

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


class Foreign:
    """An object that fails at whatever is asked of it."""

    def __getattr__(self, name):
        raise RuntimeError("no")

    def __repr__(self):
        raise RuntimeError("no")


BAD_MESHES = [
    ("shape", np.zeros((4, 2)), [[0, 1, 2]], r"\(4, 2\)"),
    ("flat", np.zeros(12), [[0, 1, 2]], r"\(12,\)"),
    ("nan", [[0, 0, 0], [1, 0, math.nan], [0, 1, 0]], [[0, 1, 2]], "number 1"),
    ("inf", [[0, 0, 0], [1, 0, math.inf], [0, 1, 0]], [[0, 1, 2]], "number 1"),
    ("strings", [["a", "b", "c"]], [[0, 0, 0]], "not numbers"),
    ("complex", np.zeros((3, 3), dtype=complex), [[0, 1, 2]], "complex"),
    ("objects", np.array([[None] * 3] * 3), [[0, 1, 2]], "object"),
    ("ragged", [[0, 0, 0], [1, 0]], [[0, 1, 2]], "vertices"),
    ("far", SQUARE, [[0, 1, 9]], "face 0 has vertex 9"),
    ("negative", SQUARE, [[0, 1, -1]], "face 0 has vertex -1"),
    ("short", SQUARE, [[0, 1, 2], [0, 1]], "face 1 has 2 corners"),
    ("float faces", SQUARE, [[0.0, 1.0, 2.0]], "face 0"),
    ("float array", SQUARE, np.array([[0.5, 1, 2]]), "float64"),
    ("huge number", SQUARE, [[0, 1, 1 << 70]], "too large"),
    ("1e9 faces", SQUARE, np.broadcast_to(np.array([[0, 1, 2]]), (10**9, 3)), "1000000000 faces"),
    ("no list", SQUARE, 7, "no list"),
    ("text", SQUARE, "faces", "face 0"),
    ("none", None, None, "shape"),
]


@pytest.mark.parametrize("vertices, faces, message", [b[1:] for b in BAD_MESHES], ids=[b[0] for b in BAD_MESHES])
def test_bad_meshes_name_the_element(vertices, faces, message):
    for kind in (phex.Surface, phex.Mesh):
        with pytest.raises(phex.InputError, match=message):
            kind(vertices, faces)


@pytest.mark.parametrize(
    "faces, message",
    [([], "no face|face"), ([[0, 1, 1]], "face 0")],
)
def test_polygons_that_are_no_surface(faces, message):
    with pytest.raises(phex.InputError, match=message):
        phex.mesh((SQUARE, faces), panels=3)


def test_1e9_vertices_take_no_memory():
    many = np.broadcast_to(np.zeros(3), (10**10, 3))
    with pytest.raises(phex.InputError, match="10000000000 vertices"):
        phex.Surface(many, [[0, 1, 2]])


BAD_OPTIONS = [
    ("panels", "abc"),
    ("panels", -1),
    ("panels", 0),
    ("panels", 2.5),
    ("panels", True),
    ("panels", 10**9),
    ("panels", 10**30),
    ("edge_length", "long"),
    ("edge_length", math.nan),
    ("edge_length", -1.0),
    ("method", "none"),
    ("method", 3),
    ("any_domain", "yes"),
    ("quadric", [1, 2, 3]),
    ("rotate", math.inf),
    ("rotate", 1e9),
    ("adaptive", -1),
    ("size_field", [1.0, 2.0]),
    ("size_field", np.zeros((3, 3))),
    ("size_field", "nowhere.txt"),
    ("boundary", "bend"),
    ("symmetry", "round"),
    ("symmetry", 1),
    ("symmetry", 2.5),
    ("target", b"smooth"),
    ("max_deviation", "20 miles"),
    ("planarity", Foreign()),
    ("unit", "km"),
    ("seed", -1),
    ("threads", 0),
    ("threads", 10**6),
    ("config", "nowhere.toml"),
    ("config", 7),
    ("start", 7),
    ("fix", [[0, 0]]),
    ("fix", [[0, 0, math.nan]]),
    ("curve", [[[0, 0, 0]]]),
    ("ground", "up"),
    ("ground", [1, 2]),
    ("anchors", Foreign()),
    ("fairness", 0),
    ("fairness", "1"),
    ("centres", -1),
    ("solver", "magic"),
    ("guide", "nowhere.obj"),
    ("crease", 200),
    ("cones", [[0, 0, 0, 9]]),
    ("cones", [[1e9, 0, 0, 1]]),
    ("max_panel", "2"),
    ("max_panel", (1, 2, 3)),
    ("max_area", "2m"),
    ("min_edge", -1),
    ("min_angle", 200.0),
    ("time_limit", "soon"),
    ("time_limit", -3),
    ("output", 3),
    ("output", "a\0b"),
    ("progress", "loud"),
    ("keep_best", "no"),
]


@pytest.mark.parametrize("name, value", BAD_OPTIONS, ids=[f"{n}-{k}" for k, (n, _) in enumerate(BAD_OPTIONS)])
def test_bad_options_are_named(roof, name, value):
    with pytest.raises(phex.InputError) as raised:
        phex.mesh(roof, **{name: value})
    told = str(raised.value)
    words = {name, name.replace("_", "-"), "nowhere", "panels", "threads", "cone"}
    assert any(word in told for word in words), told


def test_options_that_do_nothing_are_refused(roof):
    with pytest.raises(phex.InputError, match="`regularise` has no effect"):
        phex.mesh(roof, regularise=0.1)
    with pytest.raises(phex.InputError, match="exclude"):
        phex.mesh(roof, panels=30, edge_length=1.0)
    with pytest.raises(TypeError, match="pannels"):
        phex.mesh(roof, pannels=30)
    with pytest.raises(TypeError, match="pannels"):
        phex.start(roof, pannels=30)


@pytest.mark.parametrize(
    "option, name",
    [
        ({"symmetry": 4}, "symmetry"),
        ({"ground": True}, "ground"),
        ({"fix": [[0, 0, 0]]}, "fix"),
        ({"fairness": 2.0}, "fairness"),
        ({"target": "facets"}, "target facets"),
        ({"effort": "best"}, "effort best"),
        ({"time_limit": "5s"}, "time-limit"),
        ({"keep_best": True}, "keep-best"),
        ({"max_deviation": "1%"}, "max-deviation"),
    ],
)
def test_a_layout_refuses_what_comes_after_it(roof, option, name):
    with pytest.raises(phex.InputError, match=f"`{name}` has no effect with `until layout`"):
        phex.mesh(roof, panels=60, until="layout", **option)


def test_a_layout_has_no_target_and_a_start_no_number(roof, ball):
    with pytest.raises(phex.InputError, match="write_target: with `until`"):
        phex.mesh(roof, until="layout", write_target="target.ply")
    with pytest.raises(phex.InputError, match="`panels` has no effect with `start`"):
        phex.mesh(roof, start=ball, panels=40)


def test_options_of_a_parallel_mesh_are_named(ball, sphere):
    for name, value in (("least_edge", -1), ("fairness", -1), ("least_edge", 1.0)):
        with pytest.raises(phex.InputError, match=name):
            phex.parallel(ball, sphere, **{name: value})
        with pytest.raises(phex.InputError, match=f"{name}: has no effect without a surface"):
            phex.parallel(ball, **{name: value})


def test_foreign_surfaces_are_refused():
    for thing in (None, 7, object(), Foreign(), [], (1, 2, 3), {"vertices": []}, b"roof.obj", ""):
        with pytest.raises(phex.PhexError):
            phex.mesh(thing)


@pytest.mark.parametrize("text", ["20MM", "20Mm", "1.5E2 M", "3 Ft", "0.5m2", "٣mm"])
def test_lengths_are_spelt_as_in_the_program(roof, text):
    with pytest.raises(phex.InputError, match=r"^max_deviation: .* is not a length"):
        phex.mesh(roof, max_deviation=text)


def test_whole_numbers_tell_their_limits(roof):
    with pytest.raises(phex.InputError, match="threads: 100000 .*to 65535"):
        phex.mesh(roof, threads=100000)
    with pytest.raises(phex.InputError, match="seed: .*to 18446744073709551615"):
        phex.mesh(roof, seed=2**64)


def test_one_polyline_is_a_list_of_points():
    from phex._options import polylines

    line = [[0, 0, 0], [1, 1, 1]]
    for given in (line, [line], np.array(line), [np.array(line)], np.array([line]), tuple(line)):
        assert polylines("curve", given) == [line]


def test_rotations_pictures_and_names(ball):
    with pytest.raises(phex.InputError, match="rotations: there is none"):
        phex.fabricate(ball, thickness="20mm", rotations=[])
    for size in (0, 15, 16385, 10**9, 2.5, True):
        for side in ("width", "height"):
            with pytest.raises(phex.InputError, match=f"{side}: .*from 16 to 16384"):
                ball.picture(**{side: size})
    assert ball.picture(width=16, height=np.int64(16))
    for name in ("azimuth", "elevation"):
        with pytest.raises(phex.InputError, match=f"{name}: nan is not a finite number"):
            ball.picture(**{name: math.nan})
    with pytest.raises(phex.InputError, match="name: 5 is no text"):
        phex.Surface(SQUARE, [[0, 1, 2, 3]], name=5)


VALUES = [
    None, True, False, 0, 1, -1, 3, 10**18, 10**40, 0.5, -0.0, 1e308, math.nan, math.inf, "", "a",
    "1%", "2mm", "\ud800", "\0", b"x", [], [[]], [1, 2, 3], [[0, 0, 0]], [[1, 2, 3, 4]], {}, {1: 2},
    (), object(), Foreign(), np.zeros(3), np.zeros((2, 3)), np.array("x"), np.float32(2), np.int8(3),
    np.ma.masked, len, type, SQUARE, range(5), "snap", "lattice", "mm", "nowhere.obj", np.empty((0, 3)),
]  # fmt: skip


def test_random_calls_end_with_typed_errors(ball):
    """Whatever is given: a result, or one of phex's own errors (a wrong keyword is a TypeError)."""
    calls = int(os.environ.get("PHEX_FUZZ", "3000"))
    rng = random.Random(int(os.environ.get("PHEX_FUZZ_SEED", "7")))
    options = list(phex._options.MESH)
    small = phex.Surface(SQUARE, [[0, 1, 2, 3]])
    pick = lambda: rng.choice(VALUES)  # noqa: E731
    # Options that would make it compute for long, or write, are left out.
    left_out = {"output", "report", "png", "html", "write_target", "contact_sheet", "keep_invalid"}
    names = [n for n in options if n not in left_out]
    kinds = {
        "polygons": lambda: phex.Mesh(pick(), pick()),
        "corners": lambda: phex.Mesh.from_corners(SQUARE, pick(), pick()),
        "mesh": lambda: phex.mesh(small, panels=rng.choice(["x", -1, 0]), **{rng.choice(names): pick()}),
        "start": lambda: phex.start(pick(), **{rng.choice(names): pick()}).cancel(),
        "check": lambda: phex.check(pick(), unit=pick()),
        "planarize": lambda: phex.planarize(pick(), fix=pick()),
        "offset": lambda: phex.offset(ball, pick(), kind=rng.choice(["face", "edge", 3])),
        "values": lambda: ball.per_face(pick()),
        "shape": lambda: phex.shape("torus", triangles=rng.choice([0, 100, "x"]), minor=pick()),
        "fabricate": lambda: phex.fabricate(ball, thickness=pick(), sheet="1x1", nest_effort=0),
        "koebe": lambda: phex.koebe(ball, opening=pick()),
        "convert": lambda: phex.convert(pick(), "x.obj"),
    }
    for k in range(calls):
        name = rng.choice(list(kinds))
        try:
            kinds[name]()
        except phex.InternalError as error:
            pytest.fail(f"call {k}, {name}: {error}")
        except (phex.PhexError, TypeError) as error:
            is_keyword = isinstance(error, TypeError) and "multiple values" in str(error)
            if isinstance(error, TypeError) and not is_keyword:
                raise


def test_files_of_unknown_kinds_are_refused_with_those_that_are_written(tmp_path):
    surface = phex.shape("sphere", triangles=500)
    mesh = phex.Mesh(surface.vertices, surface.faces)
    for thing, kinds in ((surface, ".3mf, .3dm$"), (mesh, ".3mf, .3dm, .png, .svg$")):
        with pytest.raises(phex.InputError, match=f"x.foo ends with none of .obj, .*{kinds}"):
            thing.save(tmp_path / "x.foo")


def test_no_panels_are_refused_by_the_name_of_the_keyword():
    surface = phex.shape("sphere", triangles=500)
    with pytest.raises(phex.InputError, match="^panels: "):
        phex.mesh(surface, panels=0)


def test_a_search_without_its_library_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(__import__("sys").modules, "optuna", None)
    with pytest.raises(ImportError, match=r"pip install 'phex\[explore\]'"):
        phex.explore({}, ["panels"], out=tmp_path)


def test_errors_name_the_keyword(ball, roof):
    with pytest.raises(phex.InputError, match="edges: 1 is not True or False"):
        ball.picture(edges=1)
    with pytest.raises(TypeError, match="foo"):
        ball.picture(foo=1)
    with pytest.raises(phex.InputError, match="title: 3 is no text"):
        ball.page(title=3)
    with pytest.raises(phex.InputError, match="config: "):
        phex.mesh(roof, panels=40, config="nope.toml")
    with pytest.raises(phex.InputError, match="^edge_length"):
        phex.mesh(roof, edge_length=0)
    with pytest.raises(phex.InputError, match="threads: -1 is not a whole number from 1 to 65535"):
        phex.mesh(roof, panels=40, threads=-1)
    with pytest.raises(phex.InputError, match="corners") as raised:
        ball.per_face("foo")
    assert "dihedral" not in str(raised.value)


def test_negative_lengths_of_edges_are_refused(ball):
    a, b = (int(v) for v in ball.faces[0][:2])
    with pytest.raises(phex.InputError, match="lengths: -1.0 .* is not at least 0"):
        phex.parallel(ball, lengths={(a, b): -1})


def test_a_shape_takes_its_own_seed():
    made = [phex.shape("b-spline", triangles=500, seed=seed).vertices for seed in (1, 7)]
    assert not np.array_equal(*made)
    with pytest.raises(phex.InputError, match="seed"):
        phex.shape("torus", triangles=500, seed=3)

import subprocess
import sys
import time
import types

import numpy as np
import phex
import phex.interop.compas
import phex.interop.pyvista
import phex.interop.rhino3dm
import phex.interop.trimesh
import pytest


@pytest.fixture(scope="module")
def mesh():
    """Panels of a saddle: most of them are concave."""
    saddle = phex.shape("hyperbolic-paraboloid", triangles=3000)
    made = phex.mesh(saddle, panels=60, max_deviation="5%", keep_invalid=True)
    assert (made.per_face("corners") == 6).sum() > 20
    return made


def areas(vertices, faces):
    """Newell's areas, which are right for concave planar polygons."""
    made = []
    for face in faces:
        p = vertices[face]
        made.append(0.5 * np.linalg.norm(np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)))
    return np.array(made)


def flatness(vertices, face):
    p = vertices[face] - vertices[face].mean(axis=0)
    return np.abs(p @ np.linalg.svd(p)[2][2]).max()


def same(a, b):
    return np.array_equal(a.vertices, b.vertices) and [f.tolist() for f in a.faces] == [
        f.tolist() for f in b.faces
    ]


def test_ears_have_the_area_of_their_panel(mesh):
    triangles, face = mesh.triangles()
    p = mesh.vertices[triangles]
    parts = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    cut = np.bincount(face, weights=parts, minlength=len(mesh))
    assert np.allclose(cut, areas(mesh.vertices, mesh.faces), rtol=1e-9)
    # What the ears are for: fans from the first corner are wrong on many panels.
    fans = [
        sum(
            np.linalg.norm(np.cross(q[k] - q[0], q[k + 1] - q[0])) / 2 for k in range(1, len(q) - 1)
        )
        for q in (mesh.vertices[f] for f in mesh.faces)
    ]
    assert (np.abs(fans - cut) > 1e-6 * cut).sum() > 10


def test_compas_round_trip(mesh):
    compas_data = pytest.importorskip("compas.data")
    there = mesh.to_compas()
    again = compas_data.json_loads(compas_data.json_dumps(there))
    back = phex.interop.compas.from_compas(again)
    assert same(back, mesh) and there.number_of_faces() == len(mesh)
    area = mesh.per_face("area")
    for k, face in enumerate(again.faces()):
        assert again.face_attribute(face, "panel") == k
        assert again.face_attribute(face, "area") == area[k]
        assert again.face_attribute(face, "sound") is True
    size = np.linalg.norm(np.ptp(back.vertices, axis=0))
    assert max(flatness(back.vertices, f) for f in back.faces) <= 1e-14 * size
    assert same(phex.check(again), mesh), "COMPAS meshes are taken wherever meshes are"


def test_trimesh_round_trip(mesh):
    trimesh = pytest.importorskip("trimesh")
    there = mesh.to_trimesh()
    assert there.area == pytest.approx(areas(mesh.vertices, mesh.faces).sum(), rel=1e-9)
    back = phex.interop.trimesh.from_trimesh(there)
    assert np.array_equal(back.vertices, mesh.vertices)
    for ours, theirs in zip(mesh.faces, back.faces):
        k = theirs.tolist().index(ours[0])
        assert np.roll(theirs, -k).tolist() == ours.tolist()
    judged = phex.check(there)
    assert (judged.verdict, len(judged)) == (mesh.verdict, len(mesh)), "taken wherever meshes are"
    assert len(phex.check(trimesh.creation.box())) == 12


def test_a_trimesh_of_many_faces_is_read_in_seconds():
    """Twice as many faces may take twice the time: 40,000 took 14 s where each looked at all."""
    count = 200
    there = types.SimpleNamespace(vertices=np.zeros(((count + 1) ** 2, 3)))
    there.vertices[:, :2] = [(i, k) for i in range(count + 1) for k in range(count + 1)]
    i, k = np.divmod(np.arange(count**2), count)
    corner = i * (count + 1) + k
    squares = np.stack([corner, corner + count + 1, corner + count + 2, corner + 1], 1)
    # The halves of a square are far apart in the list.
    there.faces = np.concatenate([squares[:, :3], squares[:, [0, 2, 3]]])
    there.face_attributes = {"face": np.tile(np.arange(count**2), 2)}
    begun = time.process_time()
    back = phex.interop.trimesh.from_trimesh(there)
    assert time.process_time() - begun < 5.0
    assert [sorted(face) for face in back.faces] == [sorted(square) for square in squares]


APART = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]]


@pytest.mark.parametrize("second", [[3, 4, 5], [1, 3, 4], [1, 0, 3], [0, 1, 2]])
def test_groups_of_triangles_that_are_no_polygon_are_refused(second):
    trimesh = pytest.importorskip("trimesh")
    faces = [[0, 1, 2], second, [3, 4, 5]]
    groups = {"face": np.array([7, 7, 8])}
    if second == [1, 0, 3]:
        good = trimesh.Trimesh(APART, faces[:2], process=False, face_attributes={"face": [7, 7]})
        assert len(phex.interop.trimesh.from_trimesh(good).faces[0]) == 4
        return
    mesh = trimesh.Trimesh(APART, faces, process=False, face_attributes=groups)
    with pytest.raises(phex.InputError, match=r'2 triangles of face_attributes\["face"\] 7 make no'):
        phex.interop.trimesh.from_trimesh(mesh)


def test_pyvista_round_trip(mesh):
    pytest.importorskip("pyvista")
    there = mesh.to_pyvista()
    assert there.n_cells == len(mesh) and there.cell_data["panel"].tolist() == list(range(len(mesh)))
    assert np.array_equal(there.cell_data["area"], mesh.per_face("area"))
    assert same(phex.interop.pyvista.from_pyvista(there), mesh)
    assert same(phex.check(there), mesh)


def test_rhino_files_hold_outlines_breps_and_labels(mesh):
    rhino3dm = pytest.importorskip("rhino3dm")
    names = [f"A{k}" for k in range(len(mesh))]
    kinds = mesh.per_face("valence").astype(int).tolist()
    phex.interop.rhino3dm.save_3dm(mesh, "a.3dm", "mm", names, {"kind": kinds})
    file = rhino3dm.File3dm.Read("a.3dm")
    assert file.Settings.ModelUnitSystem == rhino3dm.UnitSystem.Millimeters
    layers = {layer.Index: layer.FullPath for layer in file.Layers}
    assert set(layers.values()) == {"phex", *(f"phex::{n}" for n in phex.interop.rhino3dm.LAYERS)}
    found = {}
    for thing in file.Objects:
        found.setdefault(layers[thing.Attributes.LayerIndex], []).append(thing)
    assert len(found["phex::outlines"]) == len(found["phex::panels"]) == len(mesh)
    assert [t.Attributes.Name for t in found["phex::outlines"]] == names
    assert [t.Geometry.Text for t in found["phex::labels"]] == names
    expected = areas(mesh.vertices, mesh.faces)
    for k, thing in enumerate(found["phex::panels"]):
        brep = thing.Geometry
        assert brep.IsValid and len(brep.Edges) == len(mesh.faces[k]), names[k]
        assert brep.Faces[0].IsPlanar(1e-9 * expected[k] ** 0.5)
        assert thing.Attributes.GetUserString("kind") == str(kinds[k])
        assert thing.Attributes.GetUserString("corners") == str(len(mesh.faces[k]))
    curves = [t.Geometry for t in found["phex::outlines"]]
    for k, curve in enumerate(curves):
        points = np.array([[p.X, p.Y, p.Z] for p in map(curve.Point, range(curve.PointCount))])
        assert np.array_equal(points[:-1], mesh.vertices[mesh.faces[k]]), "bit for bit"
    triangles = found["phex::mesh"][0].Geometry
    assert triangles.Faces.Count == len(mesh.triangles()[0])
    back = phex.interop.rhino3dm.read_3dm("a.3dm")
    assert np.array_equal(areas(back.vertices, back.faces), expected) and len(back) == len(mesh)
    assert len(back.vertices) == len(mesh.vertices), "corners that are one point are one vertex"
    mesh.save("b.3dm")
    with pytest.raises(phex.InputError, match="unit"):
        phex.interop.rhino3dm.save_3dm(mesh, "c.3dm", "km")


def test_rhino_meshes_are_surfaces(roof):
    rhino3dm = pytest.importorskip("rhino3dm")
    there = phex.interop.rhino3dm.rhino_mesh(roof)
    assert isinstance(there, rhino3dm.Mesh)
    surface = phex.interop.rhino3dm.from_rhino(there, phex.Surface)
    size = np.linalg.norm(np.ptp(roof.vertices, axis=0))
    assert np.abs(surface.vertices - roof.vertices).max() < 1e-7 * size, "single precision"
    assert phex.mesh(there, panels=30, max_deviation="5%", keep_invalid=True).sound


def test_objects_without_polygons_are_refused_by_their_type():
    trimesh, pyvista = pytest.importorskip("trimesh"), pytest.importorskip("pyvista")
    rhino3dm = pytest.importorskip("rhino3dm")
    from phex.interop import pyvista as of_pyvista, rhino3dm as of_rhino, trimesh as of_trimesh

    line = rhino3dm.LineCurve(rhino3dm.Point3d(0, 0, 0), rhino3dm.Point3d(1, 1, 1))
    grid = pyvista.ImageData(dimensions=(2, 2, 2))
    objects = {
        "Scene": (trimesh.Scene(), of_trimesh.from_trimesh),
        "PointCloud": (trimesh.PointCloud(np.eye(3)), of_trimesh.from_trimesh),
        "ImageData": (grid, of_pyvista.from_pyvista),
        "UnstructuredGrid": (grid.cast_to_unstructured_grid(), of_pyvista.from_pyvista),
        "LineCurve": (line, of_rhino.from_rhino),
    }
    for name, (thing, read) in objects.items():
        for call in (read, phex.mesh, phex.check, lambda given: phex.offset(given, 0.1)):
            with pytest.raises(phex.InputError, match=rf"an object of \S*{name} is no surface"):
                call(thing)


def test_modules_are_there_without_an_import_of_their_own():
    for name in ("compas.from_compas", "trimesh.from_trimesh", "rhino3dm.save_3dm"):
        code = f"import phex; assert callable(phex.interop.{name}); assert 'interop' in dir(phex)"
        subprocess.run([sys.executable, "-c", code], check=True)
    with pytest.raises(AttributeError, match="blender"):
        phex.interop.blender  # noqa: B018

"""Files of phex in the eyes of other programs: each is opened by a reader that is not ours, and its counts, corners and
positions are compared with the mesh that went in. Usage: check.py PHEX FOLDER MESH (the program, an empty folder, a valid mesh in metres)."""

import csv
import json
import math
import pathlib
import subprocess
import sys

import ezdxf
import numpy as np
import openpyxl
import pyvista
import shapely
import trimesh
from compas.data import json_load
from compas.datastructures import Mesh

SHEET = (2500.0, 1250.0)
SPACING = 6.0
UNIT_MM = 1000.0


def phex(program, *arguments):
    subprocess.run([program, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def read_obj(path):
    """Vertices and faces of an OBJ file, by nobody's library: the truth that readers are compared with."""
    vertices, faces = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words and words[0] == "v":
            vertices.append([float(x) for x in words[1:4]])
        elif words and words[0] == "f":
            faces.append([int(w.split("/")[0]) - 1 for w in words[1:]])
    return np.array(vertices), faces


def same_polygon(a, b, tolerance):
    return len(a) == len(b) and np.abs(np.asarray(a) - np.asarray(b)).max() <= tolerance


def check_polygon_formats(program, folder, mesh):
    vertices, faces = read_obj(mesh)
    for extension in ["ply", "off", "obj", "json"]:
        phex(program, "convert", mesh, folder / f"mesh.{extension}")
    for name, reader in [("obj", Mesh.from_obj), ("off", Mesh.from_off), ("json", json_load)]:
        found = reader(str(folder / f"mesh.{name}"))
        keys = sorted(found.faces())
        assert len(keys) == len(faces), name
        for key, face in zip(keys, faces):
            assert same_polygon(found.face_coordinates(key), vertices[face], 1e-12), (name, key)
    data = json_load(str(folder / "mesh.json"))
    assert max(data.face_attribute(f, "planarity") for f in data.faces()) < 1e-9
    for extension in ["ply", "obj"]:
        found = pyvista.read(folder / f"mesh.{extension}")
        assert found.n_cells == len(faces) and found.n_points == len(vertices), extension
        for k, face in enumerate(faces):
            assert same_polygon(found.get_cell(k).points, vertices[face], 1e-6), (extension, k)
    return vertices, faces


def check_triangle_formats(program, folder, mesh, vertices, faces):
    triangles = sum(len(f) - 2 for f in faces)
    edges = {tuple(sorted((f[i - 1], f[i]))) for f in faces for i in range(len(f))}
    size = np.ptp(vertices, axis=0).max()
    for extension in ["stl", "glb", "3mf"]:
        phex(program, "convert", mesh, folder / f"mesh.{extension}")
    area = trimesh.load(folder / "mesh.stl", force="mesh").area
    for extension in ["stl", "3mf"]:
        found = trimesh.load(folder / f"mesh.{extension}", force="mesh")
        assert len(found.faces) == triangles, extension
        distance = np.linalg.norm(found.vertices[:, None] - vertices[None], axis=2)
        assert max(distance.min(0).max(), distance.min(1).max()) < 1e-6 * size, extension
        assert abs(found.area - area) < 1e-5 * area, "ears cover every face once"
    scene = trimesh.load(folder / "mesh.glb", process=False)
    parts = {type(g).__name__: (g, n) for n, g in scene.geometry.items()}
    solid, _ = parts["Trimesh"]
    assert len(solid.faces) == triangles and len(solid.vertices) == sum(map(len, faces))
    transform = next(scene.graph.get(n)[0] for n in scene.graph.nodes_geometry)
    placed = trimesh.transform_points(solid.vertices, transform)
    corners = np.concatenate([vertices[f] for f in faces])
    assert np.abs(placed - corners[:, [0, 2, 1]] * [1, 1, -1]).max() < 1e-6 * size, "y up"
    lines, _ = parts["Path3D"]
    # trimesh joins all points of a line primitive to one path, so the lines themselves are read from the file.
    ends = trimesh.transform_points(lines.vertices, transform)
    distance = np.linalg.norm(ends[:, None] - (vertices[:, [0, 2, 1]] * [1, 1, -1])[None], axis=2)
    assert max(distance.min(0).max(), distance.min(1).max()) < 1e-6 * size
    content = (folder / "mesh.glb").read_bytes()
    document = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])
    primitives = [p for m in document["meshes"] for p in m["primitives"] if p.get("mode") == 1]
    indices = [p.get("indices", p["attributes"]["POSITION"]) for p in primitives]
    assert sum(document["accessors"][i]["count"] for i in indices) == 2 * len(edges)
    return triangles


def polylines(path):
    drawing = ezdxf.readfile(path)
    auditor = drawing.audit()
    assert not auditor.errors and not auditor.fixes, path
    found = {}
    for entity in drawing.modelspace():
        assert entity.dxftype() == "POLYLINE", path
        points = np.array([v.dxf.location for v in entity.vertices])
        found.setdefault(entity.dxf.layer, []).append((points, entity.is_closed))
    return found


def check_dxf_mesh(program, folder, mesh, vertices, faces):
    phex(program, "convert", mesh, folder / "mesh.dxf")
    panels = polylines(folder / "mesh.dxf")["PANELS"]
    assert len(panels) == len(faces)
    for (points, closed), face in zip(panels, faces):
        assert closed and same_polygon(points, vertices[face], 0.0)


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def check_tables(out, vertices, faces):
    tables = {p.stem: rows_of(p) for p in out.glob("*.csv")}
    panels = {row["id"]: row for row in tables["panels"]}
    assert len(panels) == len(faces), "every panel has a name of its own"
    edges = {row["id"]: row for row in tables["edges"]}
    nodes = {row["id"]: row for row in tables["nodes"]}
    assert len(nodes) == len(vertices)
    positions = np.array([[float(row[k]) for k in ("x_mm", "y_mm", "z_mm")] for row in tables["nodes"]])
    assert np.abs(positions - vertices * UNIT_MM).max() < 1e-9 * np.abs(vertices).max() * UNIT_MM
    for name, row in panels.items():
        own = [edges[e] for e in row["edges"].split(";")]
        assert all(name in (e["panel_1"], e["panel_2"]) for e in own)
        others = [e["panel_2"] if e["panel_1"] == name else e["panel_1"] for e in own]
        assert others == row["neighbours"].split(";")
        assert all(name in nodes[n]["panels"].split(";") for n in row["nodes"].split(";"))
    types = {row["type"] for row in tables["panels"]}
    groups = {row["type"]: row for row in tables["groups"]}
    assert types == {t for t, row in groups.items() if row["kind"] == "panel"}
    for kind, count in [("panel", len(panels)), ("edge length", len(edges))]:
        assert sum(int(g["count"]) for g in groups.values() if g["kind"] == kind) == count
    workbook = openpyxl.load_workbook(out / "schedules.xlsx")
    for name, rows in tables.items():
        sheet = workbook[name]
        assert sheet.max_row == len(rows) + 1, name
        assert [c.value for c in sheet[1]] == list(rows[0]), name
        assert str(sheet.cell(2, 1).value) == rows[0][next(iter(rows[0]))], name
    return panels, tables


def check_flat(panels, vertices, faces):
    """Flat panels have the lengths and angles of the faces, to 1e-9 of a mean edge."""
    ends = {tuple(sorted((f[i - 1], f[i]))) for f in faces for i in range(len(f))}
    mean = np.mean([np.linalg.norm(vertices[a] - vertices[b]) for a, b in ends]) * UNIT_MM
    for row, face in zip(panels.values(), faces):
        corners = vertices[face] * UNIT_MM
        lengths = np.linalg.norm(np.roll(corners, -1, 0) - corners, axis=1)
        assert np.abs(lengths - [float(x) for x in row["lengths_mm"].split(";")]).max() < 1e-9 * mean
        to_next, to_last = np.roll(corners, -1, 0) - corners, np.roll(corners, 1, 0) - corners
        normal = np.cross(corners, np.roll(corners, -1, 0)).sum(0)
        normal /= np.linalg.norm(normal)
        angles = np.arctan2(np.cross(to_next, to_last) @ normal, (to_next * to_last).sum(1)) % (2 * math.pi)
        flat = np.radians([float(x) for x in row["angles_deg"].split(";")])
        assert np.abs(angles - flat).max() < 1e-9


def check_sheets(out, panels, tables, gap):
    """Every panel on exactly one sheet, no overlap, spacing kept; the outline is the panel's."""
    plates = polylines(out / "plates.dxf")
    assert len(plates["TOP"]) == len(plates["BOTTOM"]) == len(panels)
    seen = []
    for row in tables["cut_list"]:
        layers = polylines(out / f"{row['file']}.dxf")
        assert set(layers) <= {"CUT", "ENGRAVE", "LABEL", "SHEET"}
        border = shapely.Polygon(layers["SHEET"][0][0][:, :2])
        assert border.bounds == (0.0, 0.0, *SHEET)
        names = row["panels"].split(";")
        cuts = [shapely.Polygon(points[:, :2]) for points, closed in layers["CUT"] if closed]
        assert len(cuts) == len(names) == int(row["panel_count"])
        inner = border.buffer(-SPACING + 1e-6, join_style="mitre")
        for name, cut in zip(names, cuts):
            assert cut.is_valid and inner.contains(cut), name
            assert panels[name]["sheet"] == row["sheet"]
            assert abs(cut.area * 1e-6 - float(panels[name]["area_m2"])) < 1e-9
        for i, a in enumerate(cuts):
            for b in cuts[:i]:
                assert a.distance(b) >= SPACING - 1e-9, (row["sheet"], names[i])
        use = 100 * sum(c.area for c in cuts) / border.area
        assert abs(use - float(row["use_percent"])) < 1e-6
        texts = [shapely.LineString(p[:, :2]) for layer in ("ENGRAVE", "LABEL") for p, _ in layers.get(layer, [])]
        assert texts and all(any(c.contains(t) for c in cuts) for t in texts), "texts stay inside panels"
        svg = (out / f"{row['file']}.svg").read_text()
        assert svg.count(" Z\"/>") == len(cuts) + 1
        seen += names
    assert sorted(seen) == sorted(panels)
    assert gap > 0 or all(
        abs(shapely.Polygon(p).area) > 0 for p, _ in plates["TOP"]
    )


def check_solids(out, panels, gap):
    whole = trimesh.load(out / "solids.stl", force="mesh")
    volume = sum(float(row["volume_m3"]) for row in panels.values())
    assert abs(whole.volume - volume) < 1e-4 * volume
    if gap > 0:  # without a gap they touch, and a reader that joins vertices can't tell them apart
        bodies = whole.split(only_watertight=False)
        assert len(bodies) == len(panels) and all(b.is_watertight and b.is_winding_consistent for b in bodies)
    names = [line[2:] for line in (out / "solids.obj").read_text().splitlines() if line.startswith("o ")]
    assert names == list(panels)
    tops, bottoms = (polylines(out / "plates.dxf")[layer] for layer in ("TOP", "BOTTOM"))
    assert all(len(a[0]) == len(b[0]) and a[1] and b[1] for a, b in zip(tops, bottoms))


def check_fabrication(program, folder, mesh, vertices, faces, gap, more=()):
    out = folder / f"fab-{gap}"
    arguments = ["--thickness", "20mm", "--gap", f"{gap}mm", "--spacing", f"{SPACING}mm", "-q", "-o", out]
    phex(program, "fab", mesh, *arguments, *more)
    panels, tables = check_tables(out, vertices, faces)
    if gap == 0:
        check_flat(panels, vertices, faces)
    check_sheets(out, panels, tables, gap)
    check_solids(out, panels, gap)
    compas = json_load(str(out / "mesh.json"))
    assert [compas.face_attribute(f, "id") for f in sorted(compas.faces())] == list(panels)
    first = {p.name: p.read_bytes() for p in out.rglob("*") if p.is_file()}
    phex(program, "fab", mesh, *arguments, *more, "-t", 1)
    assert first == {p.name: p.read_bytes() for p in out.rglob("*") if p.is_file()}, "the same bytes again"
    return json.loads((out / "fab.json").read_text())


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    mesh = pathlib.Path(sys.argv[3])
    vertices, faces = check_polygon_formats(program, folder, mesh)
    check_triangle_formats(program, folder, mesh, vertices, faces)
    check_dxf_mesh(program, folder, mesh, vertices, faces)
    for gap in (0, 4):
        summary = check_fabrication(program, folder, mesh, vertices, faces, gap, ["--nest-effort", 4])
        print(f"{summary['panels']} panels on {summary['sheets']} sheets, use {summary['use_percent']:.1f} %,",
              f"{summary['use_without_last_offcut_percent']:.1f} % without the last offcut")
    print("all files are read by other programs, and agree")


if __name__ == "__main__":
    main()

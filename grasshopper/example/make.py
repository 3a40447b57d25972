"""Makes the example of this folder, `pavilion.3dm`, and the pictures of docs/book/src/grasshopper.md.

python grasshopper/example/make.py [FOLDER]

The file has the pavilion's surface on the layer `surface`, for the component Mesh, and what that component gives below
`phex`. The pictures are drawn by this script: panels by phex, wires and components from the bundles' `metadata.json`.
"""

import html
import json
import os
import pathlib
import sys

import phex
import rhino3dm

ROOT = pathlib.Path(__file__).resolve().parents[2]
#: The canvas: components, where they stand, and inputs with what is wired to them.
CANVAS = (
    ("Mesh", 250, 30, {"Surface": "surface of pavilion.3dm", "Panels": "slider 150", "Run": "toggle True"}),
    ("Check", 760, 20, {"Mesh": "Mesh.Phex", "Surface": "surface of pavilion.3dm"}),
    ("Offset", 760, 230, {"Mesh": "Mesh.Phex", "Distance": "panel -0.05", "Run": "toggle True"}),
)


def pavilion():
    """A free-form roof of 45 m with 150 panels."""
    surface = phex.Surface.read(ROOT / "data" / "roof.obj")
    made = phex.mesh(surface, panels=150, boundary="snap", unit="m", progress=False)
    return surface, made


def save(surface, made, path):
    made.save(path)
    file = rhino3dm.File3dm.Read(str(path))
    layer = rhino3dm.Layer()
    layer.Name = "surface"
    place = file.Layers.Add(layer)
    attributes = rhino3dm.ObjectAttributes()
    attributes.LayerIndex = place
    attributes.Name = "pavilion"
    mesh = rhino3dm.Mesh()
    for point in surface.vertices:
        mesh.Vertices.Add(*map(float, point))
    for a, b, c in surface.triangles()[0].tolist():
        mesh.Faces.AddFace(a, b, c)
    mesh.Normals.ComputeNormals()
    file.Objects.AddMesh(mesh, attributes)
    if not file.Write(str(path), 7):
        raise OSError(f"{path} can't be written")


def canvas():
    """The canvas as SVG."""
    parts, ports = [], {}
    drawn = {name: json.loads((ROOT / "grasshopper" / name / "metadata.json").read_text()) for name, *_ in CANVAS}
    for name, x, y, _ in CANVAS:
        told = drawn[name]["ghpython"]
        ins = [p["name"] for p in told["inputParameters"]]
        outs = [p["name"] for p in told["outputParameters"]]
        high = 26 + 22 * max(len(ins), len(outs))
        parts.append(f'<rect x="{x}" y="{y}" width="220" height="{high}" rx="8" fill="#dde3ea" stroke="#333"/>')
        parts.append(f'<text x="{x + 110}" y="{y + high / 2 + 5}" text-anchor="middle" font-weight="bold">{name}</text>')
        for k, port in enumerate(ins):
            at = y + 30 + 22 * k
            ports[name, "in", port] = (x, at)
            parts.append(f'<circle cx="{x}" cy="{at - 4}" r="4" fill="#fff" stroke="#333"/><text x="{x + 8}" y="{at}">{port}</text>')
        for k, port in enumerate(outs):
            at = y + 30 + 22 * k
            ports[name, "out", port] = (x + 220, at)
            parts.append(
                f'<circle cx="{x + 220}" cy="{at - 4}" r="4" fill="#fff" stroke="#333"/>'
                f'<text x="{x + 212}" y="{at}" text-anchor="end">{port}</text>'
            )
    for name, _, _, wired in CANVAS:
        for port, source in wired.items():
            x, y = ports[name, "in", port]
            if "." in source and source.split(".")[0] in drawn:
                a, b = ports[(source.split(".")[0], "out", source.split(".")[1])]
                parts.append(f'<path d="M{a} {b - 4} C{a + 60} {b - 4} {x - 60} {y - 4} {x} {y - 4}" fill="none" stroke="#555" stroke-width="2"/>')
            else:
                label = html.escape(source)
                parts.append(
                    f'<rect x="{x - 200}" y="{y - 18}" width="180" height="20" rx="4" fill="#f7e7b4" stroke="#333"/>'
                    f'<text x="{x - 192}" y="{y - 3}">{label}</text>'
                    f'<path d="M{x - 20} {y - 8} L{x} {y - 4}" stroke="#555" stroke-width="2"/>'
                )
    body = "\n".join(parts)
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1000 380" font-family="sans-serif" font-size="12">\n'
        f'<rect width="1000" height="380" fill="#fafafa"/>\n{body}\n</svg>\n'
    )


def main():
    out = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).parent
    out.mkdir(parents=True, exist_ok=True)
    surface, made = pavilion()
    save(surface, made, out / "pavilion.3dm")
    pictures = ROOT / "docs/book/src/pictures" if len(sys.argv) <= 1 else out
    (pictures / "grasshopper-canvas.svg").write_text(canvas(), encoding="utf-8")
    (pictures / "grasshopper-panels.png").write_bytes(made.picture(width=900, height=600))
    print(f"{os.path.getsize(out / 'pavilion.3dm') // 1000} kB, {len(made)} panels, {made.verdict}")


if __name__ == "__main__":
    main()

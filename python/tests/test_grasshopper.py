"""Components run as Grasshopper runs them: their code with inputs and `ghenv` as names."""

import csv
import importlib.util
import json
import struct
import sys
import time
import types

import numpy as np
import phex
import pytest
from conftest import ROOT

rhino3dm = pytest.importorskip("rhino3dm")
import phex.grasshopper as g  # noqa: E402
from phex.interop.rhino3dm import rhino_mesh  # noqa: E402

FOLDERS = sorted(p.parent for p in (ROOT / "grasshopper").glob("*/code.py"))


class Component:
    """What a component's script sees of itself."""

    def __init__(self, guid="one"):
        self.InstanceGuid = guid
        self.Message = ""
        self.again = 0

    def OnPingDocument(self):
        return self

    def ScheduleSolution(self, milliseconds, call):
        self.again += 1

    def ExpireSolution(self, now):
        raise AssertionError("called by Grasshopper only")


class Ghenv:
    def __init__(self, guid="one"):
        self.Component = Component(guid)


def solved(folder, ghenv, **inputs):
    """Runs a component until it does not ask to be solved again; its outputs by name."""
    code = (folder / "code.py").read_text(encoding="utf-8")
    told = json.loads((folder / "metadata.json").read_text(encoding="utf-8"))["ghpython"]
    parameters = told["inputParameters"]
    names = {p["name"]: None for p in parameters}
    assert set(inputs) <= set(names)
    # Grasshopper delivers what the access says: lists, or one thing at a time.
    lists = {p["name"] for p in parameters if p["scriptParamAccess"] == "list"}
    for name, value in inputs.items():
        assert name in lists or not isinstance(value, list), name
    inputs = {n: [v] if n in lists and not isinstance(v, list) else v for n, v in inputs.items()}
    for _ in range(4000):
        asked = ghenv.Component.again
        scope = {**names, **inputs, "ghenv": ghenv}
        exec(compile(code, str(folder), "exec"), scope)
        if ghenv.Component.again == asked:
            return {p["name"]: scope[p["name"]] for p in told["outputParameters"]}
        time.sleep(0.01)
    raise AssertionError("it never ends")


@pytest.fixture(scope="module")
def surface():
    return rhino_mesh(phex.shape("roof", triangles=2000))


@pytest.fixture(scope="module")
def made(surface):
    ghenv = Ghenv("made")
    outputs = solved(ROOT / "grasshopper/Mesh", ghenv, Surface=surface, Panels=40, Run=True)
    assert ghenv.Component.Message in ("pass", "outside_tolerance") and ghenv.Component.again > 0
    return outputs


def test_components_are_whole():
    names = [folder.name for folder in FOLDERS]
    assert names == ["Check", "Fabricate", "Mesh", "Offset", "Planarize", "Report"]
    for folder in FOLDERS:
        told = json.loads((folder / "metadata.json").read_text(encoding="utf-8"))
        assert told["name"] == folder.name and told["category"] == "phex"
        assert {"name", "nickname", "description"} <= set(told["ghpython"]["outputParameters"][0])
        icon = (folder / "icon.png").read_bytes()
        assert icon[:4] == b"\x89PNG" and struct.unpack(">II", icon[16:24]) == (24, 24)
        code = (folder / "code.py").read_text(encoding="utf-8").splitlines()
        assert code[:2] == ["#! python3", "# r: phex"] and len(code) <= 5


def test_mesh_gives_geometry_of_rhino(made):
    assert len(made["Outlines"]) == len(made["Panels"]) == len(made["Phex"]) > 30
    assert all(isinstance(b, rhino3dm.Brep) and b.IsValid for b in made["Panels"])
    assert all(c.IsClosed for c in made["Outlines"]) and isinstance(made["Mesh"], rhino3dm.Mesh)
    assert "clearance" in made["Report"]


def test_the_other_components_go_on_from_it(made, surface, tmp_path):
    at = ROOT / "grasshopper"
    checked = solved(at / "Check", Ghenv(), Mesh=made["Outlines"])
    assert len(checked["Phex"]) == len(made["Phex"]) and "PASS" in checked["Report"]
    for given in (made["Phex"], made["Outlines"]):
        flat = solved(at / "Planarize", Ghenv(), Mesh=given, Surface=surface, Run=True)
        assert len(flat["Panels"]) == len(made["Panels"])
    whole = solved(at / "Check", Ghenv(), Mesh=made["Phex"], Surface=surface)
    assert len(whole["Phex"]) == len(made["Phex"])
    assert solved(at / "Check", Ghenv(), Mesh=[])["Report"] == ""
    layers = solved(at / "Offset", Ghenv(), Mesh=made["Phex"], Distance=[-0.01, 0.01], Run=True)
    assert len(layers["Outlines"]) == 2 * len(made["Outlines"])
    folder = str(tmp_path / "workshop")
    told = solved(
        at / "Fabricate",
        Ghenv(),
        Mesh=made["Phex"],
        Folder=folder,
        Thickness="1mm",
        Sheet="20x20m",
        Run=True,
    )
    assert "panels: " in told["Report"], told
    with open(f"{folder}/panels.csv", encoding="utf-8") as table:
        assert [row["id"] for row in csv.DictReader(table)] == g.names(made["Phex"])
    page = str(tmp_path / "a.html")
    assert "verdict" in solved(at / "Report", Ghenv(), Mesh=made["Phex"], Path=page, Run=True)["Report"]
    with open(page, encoding="utf-8") as file:
        assert "</html>" in file.read()


def test_the_unit_is_that_of_the_document(made, surface, tmp_path, monkeypatch):
    document = types.SimpleNamespace(ModelUnitSystem="Millimeters")
    rhino = types.SimpleNamespace(RhinoDoc=types.SimpleNamespace(ActiveDoc=document))
    monkeypatch.setitem(sys.modules, "Rhino", rhino)
    at, how = ROOT / "grasshopper", {"Mesh": phex.Mesh(made["Phex"].vertices, made["Phex"].faces)}
    how |= {"Folder": str(tmp_path / "workshop"), "Run": True, "Thickness": "1mm"}

    def length(**more):
        told = solved(at / "Fabricate", Ghenv("unit"), **how, **more)["Report"]
        assert "panels: " in told, told
        return json.loads((tmp_path / "workshop/fab.json").read_text())["options"]

    options = length(Gap="0.5mm", Side="centre", Sheet="4x8ft")
    assert (options["unit_mm"], options["thickness"], options["gap"]) == (1.0, 1.0, 0.5)
    assert (options["side"], options["sheet_mm"]) == ("centre", [2438.4, 1219.2])
    assert length(Unit="cm")["unit_mm"] == 10.0
    laid = solved(at / "Mesh", Ghenv("unit"), Surface=surface, Panels=40, Run=True)["Phex"]
    assert laid._unit == "mm"
    shell = g.offset(Ghenv("unit"), how["Mesh"], "0.01%")
    assert shell[0].phex._unit == "mm", shell[0].report
    for name, more in (("Check", {}), ("Planarize", {"Run": True})):
        assert solved(at / name, Ghenv("unit"), Mesh=how["Mesh"], **more)["Phex"]._unit == "mm"
    document.ModelUnitSystem = "Centimeters"
    checked = solved(at / "Check", Ghenv("unit"), Mesh=laid)["Phex"]
    assert checked._unit == "mm", "a mesh of phex keeps its unit"
    document.ModelUnitSystem = "Miles"
    told = solved(at / "Mesh", Ghenv("unit"), Surface=surface, Panels=40, Run=True)["Report"]
    assert "Miles" in told


def test_a_change_of_input_cancels_what_ran(surface):
    ghenv = Ghenv("changed")
    g.mesh(ghenv, surface, 3000)
    first = g._runs["changed"].future
    g.mesh(ghenv, surface, 3000)
    assert g._runs["changed"].future is first, "nothing changed"
    assert "%" in ghenv.Component.Message
    g.mesh(ghenv, surface, 2999)
    assert first.cancelled() and g._runs["changed"].future is not first
    second = g._runs["changed"].future
    assert g.mesh(ghenv, surface, 2999, run=False) == g.NOTHING
    assert second.cancelled() and "changed" not in g._runs and ghenv.Component.Message == "off"


def test_errors_are_told_and_nothing_is_raised(surface):
    ghenv = Ghenv("wrong")
    shown = g.mesh(ghenv, surface, -3)
    assert ghenv.Component.Message == "failed" and "panels" in shown.report
    assert g.check(ghenv, 7).report and ghenv.Component.Message == "failed"
    assert "thickness" in g.fabricate(ghenv, phex.Mesh(np.eye(3), [[0, 1, 2]]), "x", True, thickness="?")
    assert g.offset(ghenv, phex.Mesh(np.eye(3), [[0, 1, 2]]), [1e99])[0].report


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda p: p.name)
def test_the_componentizer_takes_the_bundles(folder):
    bundle = pytest.importorskip("ghpython_componentizer.bundle")
    icon, code, told = bundle.validate_source_bundle(str(folder))
    assert icon[:4] == b"\x89PNG" and "phex.grasshopper" in code and told["name"] == folder.name
    assert folder.name in bundle.discover_source_bundles(str(folder.parent))
    assert "example" not in bundle.discover_source_bundles(str(folder.parent))


def test_the_example_has_the_surface_and_its_panels(tmp_path):
    script = ROOT / "grasshopper" / "example" / "make.py"
    spec = importlib.util.spec_from_file_location("make", script)
    make = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make)
    surface = phex.shape("roof", triangles=500)
    made = phex.mesh(surface, panels=40, max_deviation="5%", effort="draft", keep_invalid=True)
    make.save(surface, made, tmp_path / "small.3dm")
    for path, count in ((tmp_path / "small.3dm", len(made)), (script.parent / "pavilion.3dm", 146)):
        file = rhino3dm.File3dm.Read(str(path))
        kinds = [type(o.Geometry).__name__ for o in file.Objects]
        assert (kinds.count("Brep"), kinds.count("PolylineCurve")) == (count, count)
        assert "surface" in [layer.Name for layer in file.Layers]
    svg = make.canvas()
    assert svg.count("<circle") > 15 and all(f">{name}<" in svg for name, *_ in make.CANVAS)

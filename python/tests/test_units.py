"""Lengths in files and in workshops are what they are in the model, whatever its unit."""

import json
import pathlib
import struct
import subprocess

import numpy as np
import phex
import pytest


@pytest.fixture(scope="module")
def small(sphere):
    """Panels of a sphere whose radius is 5 m, in millimetres."""
    there = phex.Surface(5000.0 * sphere.vertices, sphere.faces)
    return phex.mesh(there, panels=32, max_deviation="5%", unit="mm")


def glb_size(path):
    """The largest coordinate of a GLB file."""
    data = pathlib.Path(path).read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    accessors = json.loads(data[20 : 20 + length])["accessors"]
    return max(max(a["max"]) for a in accessors if "max" in a and a["type"] == "VEC3")


@pytest.mark.parametrize("extension", ["glb", "3mf"])
def test_files_in_metres_hold_metres(program, small, extension):
    small.save("a.obj")
    words = [program, "convert", "a.obj", f"theirs.{extension}", "--unit", "mm", "-q"]
    subprocess.run(words, check=True)
    theirs = pathlib.Path(f"theirs.{extension}").read_bytes()
    small.save(f"own.{extension}")
    phex.Mesh(small.vertices, small.faces).save(f"given.{extension}", unit="mm")
    phex.convert("a.obj", f"converted.{extension}", unit="mm")
    for name in ("own", "given", "converted"):
        assert pathlib.Path(f"{name}.{extension}").read_bytes() == theirs, name


def test_a_unit_without_effect_is_refused(small):
    small.save("a.obj")
    with pytest.raises(phex.InputError, match="unit: mm has no effect on a.ply"):
        phex.convert("a.obj", "a.ply", unit="mm")


def test_outputs_and_layers_are_in_the_unit_of_the_run(sphere, small):
    there = phex.Surface(5000.0 * sphere.vertices, sphere.faces)
    how = {"panels": 32, "max_deviation": "5%", "unit": "mm"}
    phex.mesh(there, output="a.glb", write_target="target.glb", **how)
    small.offset("10mm").layers[0].save("layer.glb")
    phex.check(small).save("judged.glb")
    phex.planarize(small).save("flat.glb")
    for name in ("a", "target", "layer", "judged", "flat"):
        assert glb_size(f"{name}.glb") == pytest.approx(5.0, rel=0.1), name
    small.save("raw.glb", unit="m")
    assert glb_size("raw.glb") == pytest.approx(5000.0, rel=0.1)
    assert small.offset("10mm").distances == [10.0]
    with pytest.raises(phex.InputError, match="unit: 'km'"):
        small.save("a.glb", unit="km")


def test_a_3dm_file_names_the_unit(small):
    rhino3dm = pytest.importorskip("rhino3dm")
    small.save("deep/own.3dm")
    phex.Mesh(small.vertices, small.faces).save("given.3dm", unit="mm")
    for name in ("deep/own.3dm", "given.3dm"):
        unit = rhino3dm.File3dm.Read(name).Settings.ModelUnitSystem
        assert unit == rhino3dm.UnitSystem.Millimeters


def test_a_workshop_takes_the_unit_of_the_run_or_of_the_job(program, small):
    how = {"thickness": "20mm", "nest_effort": 0, "sheet": "5000x9000"}
    own = phex.fabricate(small, **how)
    assert own.summary["area_m2"] == pytest.approx(4 * np.pi * 25.0, rel=0.2)
    pathlib.Path("job.toml").write_text("unit = 'mm'\n[limits]\nmax-edge = '3m'\n")
    small.save("a.obj")
    words = ["--thickness", "20mm", "--nest-effort", "0", "--sheet", "5000x9000", "-q"]
    command = [program, "fab", "a.obj", "-o", "theirs", "--limits", "job.toml", *words]
    subprocess.run(command, check=True)
    by_job = phex.fabricate("a.obj", limits="job.toml", **how)
    assert by_job.files["panels.csv"] == pathlib.Path("theirs/panels.csv").read_bytes()
    pathlib.Path("other.toml").write_text("unit = 'cm'\n")
    with pytest.raises(phex.InputError, match="the job's unit is cm, and that of the mesh mm"):
        phex.fabricate(small, limits="other.toml", **how)
    given = phex.fabricate(small, limits="other.toml", unit="mm", **how)
    assert given.summary["area_m2"] == own.summary["area_m2"]


def test_a_mesh_is_judged_by_a_job_file(program, small):
    pathlib.Path("job.toml").write_text("unit = 'mm'\n[limits]\nmax-edge = '1m'\n")
    small.save("a.obj")
    words = [program, "check", "a.obj", "--limits", "job.toml", "--report", "run.json", "-q"]
    subprocess.run(words, check=False)
    theirs = json.loads(pathlib.Path("run.json").read_text())
    ours = phex.check("a.obj", limits="job.toml").report
    assert ours["limits"] == theirs["limits"] and ours["checks"] == theirs["checks"]
    assert ours["unit"] == "mm" and ours["verdict"] == "outside_tolerance"
    judged = phex.check("a.obj", limits="job.toml", unit="cm", planarity="1mm").report
    assert judged["unit"] == "cm" and judged["limits"]["planarity"] == "1mm"
    with pytest.raises(phex.InputError, match="nowhere.toml"):
        phex.check("a.obj", limits="nowhere.toml")

"""Every option of `phex mesh --help` is a keyword of the same name, kind and default."""

import inspect
import re
import subprocess

import phex
import pytest
from phex._options import MESH

#: Kinds of keywords by the name of the value in the help.
KINDS = {
    "N": {"count", "size"},
    "SEED": {"count"},
    "THREADS": {"count"},
    "LENGTH": {"length"},
    "AXB": {"rectangle"},
    "AREA": {"area"},
    "TIME": {"time"},
    "DEG": {"number", "positive"},
    "C": {"positive"},
    "Q": {"numbers"},
    "SIZES.TXT": {"sizes"},
    "POINTS.TXT": {"rows"},
    "CONES.TXT": {"rows"},
    "CURVE.OBJ": {"lines"},
    "LINES.OBJ": {"lines"},
    "JOB.TOML": {"path"},
    "RUN.JSON": {"path"},
    "RUN.HTML": {"path"},
    "PICTURE.PNG": {"path"},
    "SURFACE": {"path"},
    "SHEET": {"path"},
    "MESH": {"path", "mesh"},
    "HOW": {"choice"},
    "LEVEL": {"choice"},
    "STAGE": {"choice"},
    "KIND": {"choice"},
    "METHOD": {"choice"},
    "MODE": {"choice"},
    "UNIT": {"choice"},
    "X": {"length", "positive", "number"},
    "Z|X,Y,Z,NX,NY,NZ": {"plane"},
    "AUTO|NONE|MIRROR|N": {"symmetry"},
}


def helped(program):
    """Name, value, text of each option of the long help."""
    text = subprocess.run(
        [program, "mesh", "--help"], check=True, capture_output=True, text=True
    ).stdout
    pattern = r"^ {2,6}(?:-\w, )?--([a-z-]+)(?:[ =](\[?)[<=]*([^>\]\n]+)>?\]?)?$"
    found = list(re.finditer(pattern, text, re.MULTILINE))
    ends = [m.start() for m in found[1:]] + [len(text)]
    return {
        m.group(1).replace("-", "_"): (m.group(3), bool(m.group(2)), text[m.end() : end])
        for m, end in zip(found, ends)
        if m.group(1) != "help"
    }


def test_keywords_are_the_options(program):
    options = helped(program)
    keywords = inspect.signature(phex.mesh).parameters
    assert len(options) > 30
    assert set(options) == set(MESH) == set(keywords) - {"surface"}


def test_kinds_are_those_of_the_options(program):
    for name, (value, may_be_alone, text) in helped(program).items():
        option = MESH[name]
        assert (option.kind == "flag") == (value is None), name
        if value is not None:
            assert option.kind in KINDS[value.upper()], (name, value)
        assert (option.alone is not None) == may_be_alone, name
        choices = re.findall(r"^ +- ([a-z-]+)(?:$|:)", text, re.MULTILINE)
        listed = re.search(r"\[possible values: ([^\]]+)\]", text)
        choices = choices or (listed.group(1).split(", ") if listed else [])
        if option.kind != "symmetry":
            assert sorted(option.choices) == sorted(choices), name


def test_defaults_are_those_of_the_options(program):
    for name, (_, _, text) in helped(program).items():
        said = re.search(r"\[default:\s+([^\]]+)\]", text)
        default = re.sub(r"\s+", " ", said.group(1)) if said else None
        assert MESH[name].default == default, name
        keyword = inspect.signature(phex.mesh).parameters[name].default
        expected = {"progress": "auto"}.get(name, False if MESH[name].kind == "flag" else None)
        assert keyword is expected or keyword == expected, name


@pytest.mark.parametrize("name", [n for n, o in MESH.items() if o.alone is not None])
def test_what_true_stands_for_is_what_the_option_alone_stands_for(program, name, roof):
    roof.save("roof.obj")
    words = [program, "mesh", "roof.obj", "-o", "a.obj", "-n", "30", "--report", "run.json", "-q"]
    subprocess.run([*words, "--keep-invalid", "--" + name.replace("_", "-")], check=False)
    import json

    with open("run.json", encoding="utf-8") as file:
        theirs = json.load(file)["settings"]
    ours = phex.mesh(roof, panels=30, keep_invalid=True, **{name: True}).report["settings"]
    assert ours == theirs

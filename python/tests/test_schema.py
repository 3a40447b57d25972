"""Reports keep to the schema that the book publishes, and have no field that it does not name."""

import copy
import json

import jsonschema
import phex
import pytest
from conftest import ROOT

SCHEMA = json.loads((ROOT / "docs/book/src/report-schema.json").read_text(encoding="utf-8"))


def closed(part):
    """The same schema, but fields that it does not name are refused."""
    if isinstance(part, list):
        return [closed(p) for p in part]
    if not isinstance(part, dict):
        return part
    part = {key: closed(value) for key, value in part.items()}
    if part.get("required") and "kind" not in part["required"]:
        part["additionalProperties"] = False
    return part


def reports(roof, ball, panels):
    bent = (panels.vertices + [[0, 0, 1e-3 * (i % 2)] for i in range(len(panels.vertices))], panels.faces)
    limits = {"min_edge": "1m", "max_panel": "1x1m"}
    yield panels.report
    yield ball.report
    yield phex.check(bent).report
    yield phex.check(ball, surface=phex.shape("sphere", triangles=500)).report
    yield phex.mesh(roof, panels=40, effort="draft", keep_invalid=True, **limits).report
    yield phex.koebe(ball).report
    yield phex.planarize(bent, keep_invalid=True).report
    yield phex.parallel(ball, keep_invalid=True).report


def test_reports_keep_to_the_schema(roof, ball, panels):
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    judge = jsonschema.Draft202012Validator(closed(SCHEMA))
    for report in reports(roof, ball, panels):
        found = [f"{list(e.absolute_path)}: {e.message}" for e in judge.iter_errors(report)]
        assert not found, found[:5]


@pytest.mark.parametrize("path", [("verdict",), ("checks", 0, "scale"), ("measures", "planarity")])
def test_the_schema_refuses_what_is_no_report(ball, path):
    report = copy.deepcopy(ball.report)
    place = report
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = "strange"
    assert not jsonschema.Draft202012Validator(SCHEMA).is_valid(report)

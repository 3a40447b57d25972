"""Examples of docstrings and of the documentation run, and say what they say."""

import doctest
import importlib
import pkgutil
import re

import phex
import pytest
from conftest import ROOT

MODULES = ["phex"] + [
    m.name
    for m in pkgutil.walk_packages(phex.__path__, "phex.")
    if not m.name.endswith(("._phex", ".grasshopper"))
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_docstrings(name, tmp_path):
    (tmp_path / "out").mkdir()
    module = importlib.import_module(name)
    failed, _ = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert failed == 0


@pytest.mark.parametrize("page", ["docs/book/src/python.md", "docs/book/src/studies.md", "docs/book/src/project-python.md"])
def test_blocks_of_the_documentation(page, roof, monkeypatch):
    roof.save("roof.obj")
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(blocks) > 1
    names = {"__name__": "docs"}
    for block in blocks:
        exec(compile(block, page, "exec"), names)


@pytest.mark.parametrize("path", sorted((ROOT / "python/notebooks").glob("*.ipynb")), ids=str)
def test_notebooks(path):
    import json

    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names = {"__name__": "notebook", "display": lambda thing: getattr(thing, "_repr_html_", str)()}
    code = [c for c in cells if c["cell_type"] == "code"]
    assert len(code) > 3
    for cell in code:
        exec(compile("".join(cell["source"]), str(path), "exec"), names)

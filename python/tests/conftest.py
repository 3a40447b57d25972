import os
import pathlib
import shutil

import phex
import pytest


@pytest.fixture(scope="session")
def program():
    """The program `phex` that was built with the module."""
    path = os.environ.get("PHEX_PROGRAM") or shutil.which("phex")
    if not path:
        pytest.skip("PHEX_PROGRAM does not name the program phex")
    return path


@pytest.fixture(scope="session")
def roof():
    return phex.shape("roof", triangles=2000)


@pytest.fixture(scope="session")
def sphere():
    return phex.shape("sphere", triangles=2000)


@pytest.fixture(scope="session")
def panels(roof):
    """A panelling with concave panels."""
    return phex.mesh(roof, panels=60, max_deviation="5%", keep_invalid=True)


@pytest.fixture(scope="session")
def ball(sphere):
    return phex.mesh(sphere, panels=32, max_deviation="5%")


@pytest.fixture(autouse=True)
def inside(tmp_path, monkeypatch):
    """Every test writes into a folder of its own."""
    monkeypatch.chdir(tmp_path)


ROOT = pathlib.Path(__file__).resolve().parents[2]

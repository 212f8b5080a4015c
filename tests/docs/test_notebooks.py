"""The notebooks run from their first cell to their last, and hold no outputs."""

import json
import sys
import types
from pathlib import Path

import matplotlib as mpl
import pytest

FOLDER = Path(__file__).parent.parent.parent / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def code_of(path):
    """Returns the code cells of a notebook."""
    cells = json.loads(path.read_text())["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, monkeypatch):
    mpl.use("agg")
    module = types.ModuleType("notebook")
    monkeypatch.setitem(sys.modules, "notebook", module)
    for cell in code_of(path):
        exec(compile("".join(cell["source"]), path.name, "exec"), module.__dict__)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_stored_without_outputs(path):
    assert all(not cell["outputs"] for cell in code_of(path))


def test_there_are_three():
    assert len(NOTEBOOKS) == 3

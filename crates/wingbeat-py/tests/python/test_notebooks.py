"""The notebooks run from their first cell to their last."""

import nbformat
import pytest
from conftest import ROOT
from nbclient import NotebookClient

BOOKS = sorted((ROOT / "crates/wingbeat-py/notebooks").glob("*.ipynb"))
LONG = {"calibrate": [pytest.mark.long]}


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("path", [pytest.param(path, marks=LONG.get(path.stem, []), id=path.stem) for path in BOOKS])
def test_a_notebook_runs(path, tmp_path):
    book = nbformat.read(path, as_version=4)
    assert all(not cell.get("outputs") for cell in book.cells)
    NotebookClient(book, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()

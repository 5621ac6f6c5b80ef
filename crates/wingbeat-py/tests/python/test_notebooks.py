"""The notebooks run from their first cell to their last and show what they hold; `cargo xtask python notebooks` writes it anew."""

import os
import re

import nbformat
import pytest
from conftest import ROOT
from nbclient import NotebookClient

BOOKS = sorted((ROOT / "crates/wingbeat-py/notebooks").glob("*.ipynb"))
LONG = {"calibrate": [pytest.mark.long]}
# The cell that a warning names, by a path of the process that ran it, and where an object lies.
PLACE = re.compile(r"/\S*/ipykernel_\d+/\d+\.py:\d+: |(?<= at) 0x[0-9a-f]+|(?<=: )/\S*/(?=numbers\.toml)")


def cleaned(output):
    """An output without what changes from run to run: places, and forms of a figure beside its picture."""
    output.pop("metadata", None)
    if "text" in output:
        output["text"] = PLACE.sub("", output["text"])
    for kind in [kind for kind in output.get("data", ()) if kind not in ("text/plain", "text/html", "image/png")]:
        del output["data"][kind]
    if "image/png" in output.get("data", ()):
        output["data"] = {"image/png": output["data"]["image/png"], "text/plain": "<Figure>"}
    if output["output_type"] in ("execute_result", "display_data"):
        output["metadata"] = {}
    return output


def said(book):
    """What each cell prints and returns, without pictures; its two streams may come in either order, and in pieces."""
    for cell in book.cells:
        told = {}
        for output in cell.get("outputs", ()):
            text = output.get("text") or output.get("data", {}).get("text/plain") or ""
            told[output.get("name")] = told.get(output.get("name"), "") + text
        yield told


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("path", [pytest.param(path, marks=LONG.get(path.stem, []), id=path.stem) for path in BOOKS])
def test_a_notebook_runs_and_shows_what_it_holds(path, tmp_path):
    held = nbformat.read(path, as_version=4)
    book = nbformat.read(path, as_version=4)
    NotebookClient(book, timeout=300, record_timing=False, resources={"metadata": {"path": str(tmp_path)}}).execute()
    for cell in book.cells:
        if cell.cell_type == "code":
            cell.outputs = [cleaned(output) for output in cell.outputs]
    book.metadata = held.metadata
    if os.environ.get("WINGBEAT_WRITE_NOTEBOOKS"):
        nbformat.write(book, path)
        return
    assert any("image/png" in output.get("data", ()) for cell in held.cells for output in cell.get("outputs", ()))
    assert list(said(book)) == list(said(held)), "cargo xtask python notebooks writes what they show"

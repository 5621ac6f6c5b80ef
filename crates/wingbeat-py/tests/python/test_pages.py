"""Python in README and docs runs as it stands there; that of the tutorials is in files, which their test runs."""

import re

import pytest
from conftest import ROOT

# What a page does many times, a few times here.
FEWER = {'"runs": 200': '"runs": 2', "num_envs=64": "num_envs=4"}
SCHEDULER = "tcp://scheduler:8786"


def blocks(page):
    """The blocks of a page, with few runs."""
    text = page.read_text(encoding="utf-8")
    for many, few in FEWER.items():
        text = text.replace(many, few)
    return re.findall(r"^```python\n(.*?)^```", text, re.S | re.M)


# The examples of python_reference.md are those of the docstrings.
APART = {"python_reference.md"}
PAGES = [
    page
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if "tutorials" not in page.parts and page.name not in APART and blocks(page)
]


def run(page, texts):
    """Runs blocks one after another, as a reader of the page would."""
    names = {}
    for text in texts:
        exec(compile(text, str(page), "exec"), names)


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_python_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    here = ["\n".join(line for line in text.splitlines() if SCHEDULER not in line) for text in blocks(page)]
    run(page, here)


@pytest.mark.long
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("page", [page for page in PAGES if SCHEDULER in page.read_text(encoding="utf-8")], ids=lambda page: page.stem)
def test_python_of_a_page_runs_with_dask(page, tmp_path, monkeypatch):
    from distributed import LocalCluster

    monkeypatch.chdir(tmp_path)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        run(page, [text.replace(SCHEDULER, cluster.scheduler_address) for text in blocks(page)])


def test_pages_have_python():
    assert any(page.stem == "python" for page in PAGES)

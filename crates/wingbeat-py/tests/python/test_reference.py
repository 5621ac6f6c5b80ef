"""The page of the package's names is what its docstrings say."""

import subprocess
import sys
from pathlib import Path

REFERENCE = Path(__file__).parents[2] / "reference.py"


def test_the_python_reference_is_current():
    done = subprocess.run([sys.executable, REFERENCE], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_python_reference_has_every_name_with_its_parameters():
    import wingbeat

    page = (REFERENCE.parents[2] / "docs/python_reference.md").read_text()
    documented = [name for name in wingbeat.__all__ if not name.startswith("_")]
    assert [name for name in documented if f"## {name}\n" not in page] == []
    assert "- `period_s`: Time between two updates, s" in page

"""The package as it is installed: types, time of import, what comes with it."""

import inspect
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from conftest import ROOT

import wingbeat

EXAMPLES = ROOT / "crates/wingbeat-py/examples"


def mypy(*arguments):
    """Runs a tool of mypy's in the configuration of the package."""
    return subprocess.run(
        [sys.executable, "-m", *arguments], cwd=ROOT / "crates/wingbeat-py", capture_output=True, text=True
    )


@pytest.mark.long
def test_the_stub_is_that_of_the_extension():
    done = mypy("mypy.stubtest", "wingbeat._wingbeat", "--mypy-config-file", "pyproject.toml")
    assert done.returncode == 0, done.stdout


@pytest.mark.long
def test_package_and_examples_are_typed():
    done = mypy("mypy", "--strict", "--config-file", "pyproject.toml", "-p", "wingbeat")
    assert done.returncode == 0, done.stdout
    files = [str(path) for path in sorted(EXAMPLES.glob("*.py"))]
    done = mypy("mypy", "--strict", "--config-file", "pyproject.toml", *files)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("example", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_examples_run(example, tmp_path):
    done = subprocess.run([sys.executable, example], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_importing_is_quick():
    code = "import time; t, c = time.perf_counter(), time.thread_time(); import wingbeat; "
    code += "print(time.perf_counter() - t, time.thread_time() - c)"
    runs = [subprocess.check_output([sys.executable, "-c", code], text=True).split() for _ in range(5)]
    wall, processor = (min(map(float, times)) for times in zip(*runs, strict=True))
    print(f"import: {wall:.3f} s, {processor:.3f} s of the processor")
    # The processor's time: that of the clock grows with what else runs; of the thread that imports, as the threads of NumPy's BLAS
    # spin while they wait.
    assert processor < 0.3


def test_heavy_packages_are_not_imported_unasked():
    code = "import sys, wingbeat; print([m for m in ('pandas', 'matplotlib', 'gymnasium', 'dask') if m in sys.modules])"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "[]\n"


def test_importing_adds_little_to_numpy(tmp_path):
    code = "import numpy, time; c = time.thread_time(); import wingbeat; print(time.thread_time() - c)"
    # With bytecode, as it lies beside what is installed after the first time.
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    kept["PYTHONPYCACHEPREFIX"] = str(tmp_path)
    once = [sys.executable, "-c", code]
    least = min(float(subprocess.check_output(once, text=True, env=kept)) for _ in range(6))
    print(f"import beside NumPy: {least:.4f} s of the processor")
    # The time is that of the machine and its neighbours; this tells what is imported unasked.
    assert least < 0.1


def documented(name):
    """The parameters of a public function or class, and its docstring."""
    what = getattr(wingbeat, name)
    return [p for p in inspect.signature(what).parameters if p not in ("args", "kwargs")], inspect.getdoc(what) or ""


@pytest.mark.parametrize("name", ["Robot", "Scenario", "Stepper", *(n for n in wingbeat.__all__ if n.islower() and n[0] != "_")])
def test_help_names_every_parameter(name):
    parameters, text = documented(name)
    listed = re.search(r"^Parameters\n-+\n(.*?)(\n\n\w+\n-+\n|\Z)", text, re.S | re.M)
    assert listed, text
    names = {n.strip() for line in re.findall(r"^(\w[\w, ]*)$", listed.group(1), re.M) for n in line.split(",")}
    assert set(parameters) == names


def test_a_missing_package_is_named_with_its_extra(monkeypatch):
    flight = wingbeat.fly(wingbeat.shipped("scenarios/glide.toml"), {"flight.duration_s": 0.02})
    for module in ("pandas", "matplotlib", "matplotlib.figure"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ModuleNotFoundError, match=r"pandas is not installed: pip install 'wingbeat\[tables\]'"):
        flight.record.to_pandas()
    with pytest.raises(ModuleNotFoundError, match=r"wingbeat\[figures\]"):
        flight.plot3d()
    assert "wingbeat[figures]" in flight._repr_html_()


def test_the_wheel_holds_the_program_and_its_version(tmp_path):
    program = Path(sys.executable).parent / "wingbeat"
    told = subprocess.run([program, "--version"], capture_output=True, text=True)
    assert told.returncode == 0 and wingbeat.__version__ in told.stdout, told
    subprocess.run([program, "new", "case", "case.toml"], cwd=tmp_path, check=True)
    subprocess.run([program, "tether", "case.toml", "--quiet"], cwd=tmp_path, check=True)
    assert (tmp_path / "runs/case/summary.json").exists()


def test_all_files_come_with_the_package():
    home = Path(wingbeat.__file__).parent
    for folder in ("robots", "scenarios", "cases", "rigs", "sweeps", "calibrations"):
        own = {path.relative_to(ROOT) for path in (ROOT / folder).rglob("*.toml")}
        assert own == {path.relative_to(home) for path in (home / folder).rglob("*.toml")}
    assert tomllib.loads(wingbeat.shipped("robots/glider.toml").read_text())
    assert (home / "py.typed").exists()

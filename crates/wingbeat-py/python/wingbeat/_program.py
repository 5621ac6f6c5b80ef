"""What the program ``wingbeat``, which comes with the package, does by itself: pictures, averages, plans of the arm, comparisons."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wingbeat import _wingbeat
from wingbeat._documents import Overrides, Robot, Scenario, Source, document
from wingbeat._record import Record
from wingbeat._verdicts import judged

if TYPE_CHECKING:
    from subprocess import CompletedProcess
    from tempfile import TemporaryDirectory

# Exit codes of the program: bad input, and what Ctrl-C leaves.
BAD_INPUT, INTERRUPTED = 2, 130


def program(name: str = "wingbeat") -> Path:
    """The program of that name: beside the interpreter, where the package puts it, else on the path."""
    import shutil
    import sysconfig

    ending = ".exe" if os.name == "nt" else ""
    folders = [Path(sysconfig.get_path("scripts")), Path(sys.executable).parent]
    folders += [Path(sysconfig.get_path("scripts", scheme)) for scheme in sysconfig.get_scheme_names() if scheme.endswith("_user")]
    for folder in folders:
        if (path := folder / f"{name}{ending}").is_file():
            return path
    if found := shutil.which(name):
        return Path(found)
    raise FileNotFoundError(f"{name} is neither in {folders[0]} nor on the path")


def run(arguments: Sequence[str | PathLike[str]], name: str = "wingbeat") -> CompletedProcess[str]:
    """Runs the program; bad input raises ``ValueError`` with its message."""
    import subprocess

    done = subprocess.run([program(name), *(fspath(each) for each in arguments)], capture_output=True, encoding="utf-8", check=False)
    if done.returncode == BAD_INPUT:
        raise ValueError(done.stderr.strip().removeprefix("error: "))
    if done.returncode == INTERRUPTED:
        raise KeyboardInterrupt
    if done.returncode < 0:
        raise RuntimeError(f"{name} was ended by signal {-done.returncode}: {done.stderr.strip()}")
    return done


def _aside() -> TemporaryDirectory[str]:
    """A folder that goes when its work is done."""
    from tempfile import TemporaryDirectory

    return TemporaryDirectory(prefix="wingbeat-")


def _options(overrides: Overrides | None) -> list[str]:
    """Overrides as the program takes them."""
    texts = _wingbeat.overrides(dict(overrides or {}))
    return [word for text in texts for word in ("--set", text)]


@dataclass(frozen=True)
class Picture:
    """A picture, which a notebook shows."""

    png: bytes = field(repr=False)
    svg: str = field(repr=False)
    name: str

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the picture: PNG, or SVG where ``path`` ends so."""
        path = Path(path)
        if path.suffix.lower() == ".svg":
            path.write_text(self.svg, encoding="utf-8")
        else:
            path.write_bytes(self.png)

    def _repr_png_(self) -> bytes:
        return self.png


def show(
    source: Source | Robot | Scenario,
    overrides: Overrides | None = None,
    *,
    phase_rad: float | None = None,
    joints_deg: Sequence[float] | None = None,
) -> Picture:
    """Draws a robot, a scenario, a case, a rig or a run of the rig: frames, links, hinges and outlines.

    Parameters
    ----------
    source
        A TOML file, a dictionary of the same keys, a `Robot` or a `Scenario`.
    overrides
        Keys that are set otherwise, ``{"body.mass_kg": 0.012}``.
    phase_rad
        Phase of the gait, rad; without it that of the start.
    joints_deg
        Joint positions of the arm of a rig, deg; without them those of the run's plan, else zero.

    Returns
    -------
    Picture
        With ``save(path)``; a notebook shows it.
    """
    options = [] if phase_rad is None else ["--phase", repr(float(phase_rad))]
    if joints_deg is not None:
        options += ["--joints-deg", ",".join(repr(float(joint)) for joint in joints_deg)]
    with _aside() as folder:
        if isinstance(source, (str, PathLike)):
            file = Path(source)
            options += _options(overrides)
        else:
            file = Path(folder) / "shown.toml"
            if isinstance(source, (Robot, Scenario)):
                if overrides:
                    raise ValueError("overrides: allowed with a file or a dictionary; this is checked already")
                file.write_text(source.toml, encoding="utf-8")
            else:
                file.write_text(document(source, overrides, "shown").resolved(), encoding="utf-8")
        run(["show", "--quiet", "--out", Path(folder) / "out", *options, "--", file])
        drawn = Path(folder) / "out/figures/show"
        return Picture(drawn.with_suffix(".png").read_bytes(), drawn.with_suffix(".svg").read_text(encoding="utf-8"), file.stem)


@dataclass(frozen=True, kw_only=True)
class Averaged:
    """Phase averages of a file of the load cell."""

    record: Record
    """Columns ``phase`` (cycles), and for each channel its mean and ``NAME_std``, its standard deviation over the cycles."""
    summary: dict[str, Any] = field(repr=False)
    """Frequency, cycles and verdict."""
    picture: Picture = field(repr=False)

    @property
    def status(self) -> str:
        """``ok``, or what is wrong with the data."""
        return str(self.summary["status"])

    def _repr_png_(self) -> bytes:
        return self.picture.png


def average(
    file: str | PathLike[str],
    *,
    rate_hz: float | None = None,
    units: Sequence[str] = (),
    columns: Sequence[str] = (),
    frequency_hz: float | None = None,
    rest_s: float | None = None,
    bins: int = 200,
) -> Averaged:
    """Averages measured loads over the cycles of the wings, from a file of the load cell alone.

    Parameters
    ----------
    file
        Samples: text with columns and a header, or six columns without one, or any file that `process` reads.
    rate_hz
        Samples per second, Hz; without it the file has a column ``t`` (s).
    units
        Units of forces and of moments, ``["N", "N m"]``, or one for each channel; without them those of the file.
    columns
        Channels to average; without them all but time, status and sequence.
    frequency_hz
        Frequency of the cycle, Hz, in place of the one that the data have.
    rest_s
        Seconds of rest at the start of the file: what the channels read there is subtracted, and they are left out.
    bins
        Number of phases of the average.

    Returns
    -------
    Averaged
        ``record``, ``summary`` and ``picture``.
    """
    options = ["--bins", str(bins)]
    for name, value in (("--rate", rate_hz), ("--frequency", frequency_hz), ("--rest", rest_s)):
        if value is not None:
            # With the sign of equality: the program takes a negative number for an option otherwise.
            options.append(f"{name}={float(value)!r}")
    for name, words in (("--units", units), ("--columns", columns)):
        if words:
            options.append(f"{name}={','.join(words)}")
    with _aside() as folder:
        out = Path(folder) / "out"
        run(["average", "--quiet", "--out", out, *options, "--", file])
        summary = (out / "summary.json").read_text(encoding="utf-8")
        figure = out / "figures/cycles"
        picture = Picture(figure.with_suffix(".png").read_bytes(), figure.with_suffix(".svg").read_text(encoding="utf-8"), "cycles")
        record = Record(_wingbeat.read_csv(fspath(out / "cycles.csv")))
        return Averaged(record=record, summary=judged(summary), picture=picture)


@dataclass(frozen=True)
class RigPlan:
    """A banking turn placed in the workspace of the arm."""

    name: str
    report: str = field(repr=False)
    """The plan in words and numbers."""
    toml: str = field(repr=False)
    """The run as resolved."""
    joints: Record = field(repr=False)
    """Motion of the joints at 1 kHz: ``time_s``, then positions (deg), rates (deg/s) and accelerations (deg/s2) by joint."""
    files: dict[str, str] = field(repr=False)
    """The trajectory for Kortex (CSV), ROS 2 (YAML) and the Kinova Web App (JSON), by file name."""


def rig_plan(
    path: Source,
    overrides: Overrides | None = None,
    *,
    from_deg: Sequence[float] | None = None,
) -> list[RigPlan]:
    """Places the banking turns of a run, or of all that a file lists, in the arm's workspace.

    Parameters
    ----------
    path
        A TOML file of a run of the rig or with ``runs = ["a.toml", ...]``, or a dictionary of the same keys.
    overrides
        Keys of the run that are set otherwise, ``{"profile": "paper-tool"}``.
    from_deg
        Present joint positions, deg: the files of the way from there to the start of each run come too.

    Returns
    -------
    list of RigPlan
        A run that no placement allows raises ``ValueError`` with the limit that it exceeds.
    """
    options = _options(overrides)
    if from_deg is not None:
        options += ["--from-deg", ",".join(repr(float(joint)) for joint in from_deg)]
    with _aside() as folder:
        out, file = Path(folder) / "out", Path(folder) / "run.toml"
        if isinstance(path, Mapping):
            file.write_text(document(path, None, "run").resolved(), encoding="utf-8")
        else:
            file = Path(path)
        done = run(["rig", "plan", "--quiet", "--out", out, *options, "--", file])
        if done.returncode != 0:
            raise ValueError(done.stderr.strip().removeprefix("error: "))
        plans = []
        # A run's own files and those of its way: the names of other runs may begin with its name.
        ends = ["", "_approach"] if from_deg is not None else [""]
        for report in sorted(out.glob("*.txt")):
            name = report.stem
            files = [out / f"{name}{end}{kind}" for end in ends for kind in (".csv", ".json", ".yaml")]
            texts = {each.name: each.read_text(encoding="utf-8") for each in files if each.is_file()}
            joints = Record(_wingbeat.read_csv(fspath(out / f"{name}.csv")))
            toml = (out / f"{name}.toml").read_text(encoding="utf-8")
            plans.append(RigPlan(name, report.read_text(encoding="utf-8"), toml, joints, texts))
        return plans


def validate(*, only: str | None = None, quick: bool = True) -> list[dict[str, Any]]:
    """Compares the models with published and independent numbers, as ``wingbeat validate`` does.

    The comparisons are a program of their own, ``wingbeat-validate``, which the package does not hold: build it in the
    repository (``cargo build --release -p wingbeat-validate``) and put it on the path.

    Parameters
    ----------
    only
        Beginning of the names of the comparisons that are made; without it all.
    quick
        Leave out the comparisons that take minutes.

    Returns
    -------
    list of dict
        A row per comparison: ``id``, ``metric``, ``value``, ``limit`` and whether it passes.
    """
    with _aside() as folder:
        rows = Path(folder) / "rows.json"
        options = (["--quick"] if quick else []) + ([] if only is None else [f"--only={only}"])
        run(["--quiet", "--json", rows, *options], name="wingbeat-validate")
        found: list[dict[str, Any]] = json.loads(rows.read_text(encoding="utf-8"))
        return found

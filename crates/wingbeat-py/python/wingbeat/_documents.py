"""Robots and scenarios: from files, texts and dictionaries."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeAlias

from wingbeat import _wingbeat
from wingbeat._record import Column

Source: TypeAlias = "str | PathLike[str] | Mapping[str, Any]"
Overrides: TypeAlias = Mapping[str, Any]


def shipped(name: str) -> Path:
    """A file that comes with the package: ``shipped("scenarios/banking_turn.toml")``.

    Parameters
    ----------
    name
        Path of the file below ``robots``, ``scenarios``, ``cases``, ``rigs``, ``calibrations`` or ``sweeps``.
    """
    home = Path(__file__).parent
    path = home / name
    inside = home in path.resolve().parents
    if not inside or not path.exists():
        folder = path.parent if inside and path.parent.is_dir() else home
        known = sorted(entry.name for entry in folder.iterdir() if entry.suffix == ".toml" or entry.is_dir())
        raise ValueError(f"{name}: allowed are {', '.join(known)}")
    return path


def _table(toml: str) -> dict[str, Any]:
    """A TOML text as a dictionary."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    return tomllib.loads(toml)


def number(key: str, given: Any) -> float:
    """A number that was given as ``key``."""
    try:
        return float(given)
    except (TypeError, ValueError):
        raise ValueError(f"{key} = {given!r}: allowed is a number") from None


def document(source: Source, overrides: Overrides | None, name: str) -> _wingbeat.Document:
    """A document of a file or a dictionary, with overrides; errors call a dictionary ``name``."""
    if isinstance(source, Mapping):
        made = _wingbeat.Document.value(name, dict(source))
    else:
        made = _wingbeat.Document.file(fspath(source))
    return made.overridden(dict(overrides)) if overrides else made


class Robot:
    """A checked robot.

    Parameters
    ----------
    source
        A TOML file, or a dictionary of the same keys (lengths in m, masses in kg, angles in rad unless a key ends in ``_deg``).
    overrides
        Keys that are set otherwise: paths, ``{"body.mass_kg": 0.012}``, or dictionaries in dictionaries.
    """

    def __init__(self, source: Source, overrides: Overrides | None = None) -> None:
        self._take(document(source, overrides, "robot"))

    @classmethod
    def from_text(cls, toml: str, overrides: Overrides | None = None) -> Robot:
        """A robot from TOML."""
        robot = cls.__new__(cls)
        made = _wingbeat.Document.text("robot", toml)
        robot._take(made.overridden(dict(overrides)) if overrides else made)
        return robot

    def _take(self, made: _wingbeat.Document) -> None:
        self._name = made.robot()
        self._document = made

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self._name

    @property
    def toml(self) -> str:
        """The robot with its overrides as TOML."""
        return self._document.resolved()

    def to_dict(self) -> dict[str, Any]:
        """The robot with its overrides as a dictionary."""
        return _table(self.toml)

    def __eq__(self, other: object) -> bool:
        return self.toml == other.toml if isinstance(other, Robot) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.toml)

    def __reduce__(self) -> tuple[Any, ...]:
        return Robot.from_text, (self.toml,)

    def __repr__(self) -> str:
        return f"Robot({self.name!r})"


class Scenario:
    """A checked scenario. Bad input raises ``ValueError`` with the text that the program prints.

    Parameters
    ----------
    source
        A TOML file, or a dictionary of the same keys.
    overrides
        Keys that are set otherwise: paths, ``{"aero.preset": "full"}``, or dictionaries in dictionaries.
    robot
        Takes the place of the scenario's own robot: a `Robot`, a TOML file, or a dictionary.

    Examples
    --------
    >>> glide = Scenario(shipped("scenarios/glide.toml"), {"air": {"wind_m_s": [-1.0, 0.0, 0.0]}})
    """

    def __init__(
        self, source: Source, overrides: Overrides | None = None, *, robot: Robot | Source | None = None
    ) -> None:
        self._take(document(source, None, "scenario"), overrides, robot)

    @classmethod
    def from_text(
        cls, toml: str, overrides: Overrides | None = None, *, robot: Robot | Source | None = None
    ) -> Scenario:
        """A scenario from TOML; files that it names are sought from the working folder."""
        scenario = cls.__new__(cls)
        scenario._take(_wingbeat.Document.text("scenario", toml), overrides, robot)
        return scenario

    def _take(
        self, made: _wingbeat.Document, overrides: Overrides | None, robot: Robot | Source | None
    ) -> None:
        if robot is not None:
            given = robot if isinstance(robot, Robot) else Robot(robot)
            made = made.put("robot", given._document)
        self._native = _wingbeat.Scenario(made.overridden(dict(overrides)) if overrides else made)

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self._native.name

    @property
    def toml(self) -> str:
        """The merged configuration as TOML: robot and overrides are in it."""
        return self._native.resolved

    def to_dict(self) -> dict[str, Any]:
        """The merged configuration as a dictionary."""
        return _table(self.toml)

    @property
    def states(self) -> list[Column]:
        """The states in order, with units, frames and limits."""
        return [Column(*channel) for channel in self._native.states]

    @property
    def inputs(self) -> list[Column]:
        """The inputs in order, with units and limits."""
        return [Column(*channel) for channel in self._native.inputs]

    @property
    def start(self) -> list[float]:
        """The state at t = 0."""
        return self._native.start

    @property
    def mass_kg(self) -> float:
        """Mass of the robot that flies, kg."""
        return self._native.mass_kg

    def reference(self, t: float) -> tuple[float, float, list[float]] | None:
        """Roll and pitch (rad) and angular rate (rad/s, body axes) that the manoeuvre asks at ``t``."""
        return self._native.reference(number("t", t))

    def __eq__(self, other: object) -> bool:
        return self.toml == other.toml if isinstance(other, Scenario) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.toml)

    def __reduce__(self) -> tuple[Any, ...]:
        return Scenario.from_text, (self.toml,)

    def __repr__(self) -> str:
        return f"Scenario({self.name!r})"

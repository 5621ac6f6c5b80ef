"""Flights, plans, periodic flights, wings in prescribed motion, wakes, the rig, and calibrations."""

from __future__ import annotations

import copyreg
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from numpy.typing import ArrayLike

from wingbeat import _wingbeat
from wingbeat._documents import Overrides, Robot, Scenario, Source, document, number
from wingbeat._html import picture, table, text
from wingbeat._record import Array, Record, Strips
from wingbeat._verdicts import judged
from wingbeat._views import Shown, Viewed, summary_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Observer: TypeAlias = Callable[[float, Array, Array], object]


# `copy` and `pickle` find it here.
copyreg.pickle(
    _wingbeat.Measurement,
    lambda told: (_wingbeat.Measurement.of, (told.taken, told.names, told.array)),
)


class Controller(Protocol):
    """What steers a flight from Python."""

    def update(self, t: float, measurement: _wingbeat.Measurement, /) -> ArrayLike | None:
        """The inputs that hold from the time ``t`` (s) until the next update, in the order of ``Scenario.inputs``.

        ``None`` leaves those in force and is counted as a failure.
        """


@dataclass(frozen=True, kw_only=True)
class Result(Shown):
    """What every run gives."""

    summary: dict[str, Any] = field(repr=False)
    """What the program writes as ``summary.json``."""

    document: str = field(default="", repr=False)
    """What was run, as it was resolved: TOML."""

    @property
    def status(self) -> str:
        """``ok``, or what kept the run from it."""
        return str(self.summary["status"])

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        texts = {"summary.json": summary_text(self.summary), "scenario.toml": self.document}
        return type(self).__name__.lower(), texts, {"record.parquet": getattr(self, "record", None)}

    def _repr_html_(self) -> str:
        return table(type(self).__name__, self.summary) + self._picture()

    def _picture(self) -> str:
        """The time histories, where there are some and Matplotlib is installed."""
        record = getattr(self, "record", None)
        if not isinstance(record, Record) or record.rows < 2:
            return ""
        try:
            return picture(record.plot())
        except ModuleNotFoundError as error:
            return text(str(error))


@dataclass(frozen=True, kw_only=True)
class Recorded(Result):
    """A run with its time histories."""

    record: Record
    """Time histories."""

    def plot(self, names: str | Sequence[str] | None = None) -> Figure:
        """See :meth:`Record.plot`."""
        return self.record.plot(names)


@dataclass(frozen=True, kw_only=True)
class Flight(Recorded):
    """A flown scenario; its status is ``ok``, ``not_judged``, ``off_target``, ``outside``, ``not_resolved`` or ``failed``."""

    strips: Strips | None
    """Loads of the strips, where ``flight.record_strips_every_s`` asks for them."""

    def plot3d(self, frames: int = 12) -> Figure:
        """The path in space, with the body axes at ``frames`` instants: a figure of Matplotlib, in m."""
        from wingbeat._figures import path

        return path(self.record, frames)


@dataclass(frozen=True, kw_only=True)
class Plan(Result):
    """A plan made offline; its status is ``ok``, ``off_target``, ``outside``, ``not_periodic``, ``not_resolved``, ``not_found``,
    ``failed`` or, of one that was stopped, ``interrupted``.
    """

    record: Record | None
    """The plan as simulated under its inputs; none of a plan that misses its constraints."""
    nodes: Record | None
    """The plan as the solver has it, a row per node: states, inputs, multipliers; none when nothing could be evaluated."""
    constants: dict[str, Any] | None
    """What of it has one value: times, parameters, constraints on the ends, with limits and multipliers."""
    files: dict[str, str] = field(repr=False)
    """Scenarios and cases that follow the plan, by name, as TOML."""

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        name, texts, records = super()._held()
        return name, {**texts, "plan.json": ""}, records


@dataclass(frozen=True, kw_only=True)
class Moved(Recorded):
    """A wing that was moved in a wind: loads by source and motion; its status is ``ok``, ``suspect_data``, ``not_resolved``,
    ``not_periodic`` or ``failed``.
    """

    strips: Strips
    """Loads and motion of the strips."""
    cycle: Record | None = None
    """Measured, computed and fitted cycle, where there is a measured file."""

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        texts = {"summary.json": summary_text(self.summary), "case.toml": self.document}
        return "case", texts, {"loads.csv": self.record, "strips.parquet": self.strips.record}


@dataclass(frozen=True, kw_only=True)
class Trimmed(Result):
    """A periodic flight; its status is ``ok``, ``outside`` or ``not_found``, of a search of gaits also ``off_target``."""

    record: Record | None
    """The cycle; none where no orbit was found."""
    multipliers: Record | None
    """Floquet multipliers."""
    family: Record | None
    """Orbits along the parameter of ``[trim.family]``."""
    starts: Record | None
    """What the search of ``[trim.search]`` came to from each of its starts."""
    files: dict[str, str] = field(repr=False)
    """``orbit.toml``, a scenario on the orbit, as TOML; of a search also ``robot.toml``, the robot with its gait."""

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        name, texts, records = super()._held()
        return name, texts, {**records, "multipliers.parquet": self.multipliers}

    def plot(self, names: str | Sequence[str] | None = None) -> Figure:
        """See :meth:`Record.plot`."""
        if self.record is None:
            raise ValueError(str(self.summary["reason"]))
        return self.record.plot(names)


@dataclass(frozen=True)
class Stretch:
    """A case, or a stretch of a flight, stepped by the vortex lattice."""

    name: str
    """Empty for a case."""
    record: Record
    """Loads in the world's axes about the body's origin, and mean bound circulations, by step."""
    phases: dict[str, str] = field(repr=False)
    """Rings of wing and wake at the start and in the middle of downstroke and upstroke of the last cycle, as VTK text."""


@dataclass(frozen=True, kw_only=True)
class Wake(Result):
    """The vortex lattice of a case or along a flight; its status is ``ok``, ``not_resolved`` or ``failed``."""

    stretches: list[Stretch]

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        texts = {"summary.json": summary_text(self.summary)}
        records: dict[str, Record | None] = {}
        for stretch in self.stretches:
            before = f"{stretch.name}_" if stretch.name else ""
            records[f"{stretch.name or 'wake'}.parquet"] = stretch.record
            texts |= {f"{before}{phase}.vtk": text for phase, text in stretch.phases.items()}
        return "wake", texts, records


@dataclass(frozen=True)
class Calibrated(Viewed):
    """What was fitted to runs on the load cell."""

    record: Record | None
    """Measured and predicted cycles with their bands; none where only the information was asked for."""
    summary: dict[str, Any]
    """What the program writes as ``summary.json``; empty where only the information was asked for."""
    information: str
    """What the runs say of the parameters before the fit, as a table."""
    report: str
    """The report as the program prints it."""
    numbers: str = field(repr=False)
    """The fitted parameters as TOML: write it to a file that ``robot.numbers`` names."""
    residual: str = field(default="", repr=False)
    """The wrench learned of runs with ``residual = true`` as TOML, for a file that ``robot.residual`` names; empty without such runs."""

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        texts = {"summary.json": summary_text(self.summary)}
        return "calibration", texts, {"record.parquet": self.record}

    def _repr_html_(self) -> str:
        return text(self.report or self.information)

    @property
    def status(self) -> str:
        """``ok``, or what kept the fit from it; ``not_judged`` where only the information was asked for."""
        return str(self.summary.get("status", "not_judged"))

    @property
    def values(self) -> dict[str, float]:
        """The fitted parameters by name."""
        return {row["name"]: row["value"] for row in self.summary.get("parameters", [])}

    @property
    def errors(self) -> dict[str, float]:
        """Their standard errors by name, whole cycles as clusters."""
        return {row["name"]: row["standard_error"] for row in self.summary.get("parameters", [])}


@dataclass(frozen=True, kw_only=True)
class Bench(Result):
    """A simulated run of the rig; its status is ``ok``, ``outside``, ``not_found`` or ``failed``."""

    name: str
    record: Record | None
    """Samples of the load cell; none of a run that was refused or failed."""

    @property
    def window_s(self) -> tuple[float, float]:
        """Start and end of what is to be averaged, s."""
        begin, end = self.summary["window_s"]
        return begin, end


@dataclass(frozen=True, kw_only=True)
class Processed(Result):
    """Samples of the rig, processed; its status is ``ok`` or ``suspect_data``."""

    name: str
    record: Record | None
    """Phase averages of the six channels; none of static tilts."""

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        return self.name, {"summary.json": summary_text(self.summary)}, {f"{self.name}.parquet": self.record}


@dataclass(frozen=True, kw_only=True)
class ProcessedRuns(Result):
    """Folders of samples of the rig, processed together; the status is the worst of all."""

    records: dict[str, Record | None]
    """By the name of the run, phase averages of the six channels; none of static tilts."""

    envelope: Record | None
    """What all runs cover, beside the simulation of one of them; none of static tilts."""

    documents: dict[str, str] = field(default_factory=dict, repr=False)
    """By the name of the run, what was processed, as it was resolved: TOML."""

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        files = {f"{name}.parquet": record for name, record in self.records.items()}
        return "processed", {"summary.json": summary_text(self.summary)}, files | {"envelope.parquet": self.envelope}


def _given(columns: list[_wingbeat._Column] | None) -> Record | None:
    """The record of what may be missing."""
    return None if columns is None else Record(columns)


def scenario_of(source: Scenario | Source, overrides: Overrides | None) -> Scenario:
    """A scenario, or one of a file or a dictionary."""
    if not isinstance(source, Scenario):
        return Scenario(source, overrides)
    if overrides:
        raise ValueError("overrides: allowed with a file or a dictionary; a Scenario is checked already")
    return source


def fly(
    scenario: Scenario | Source,
    overrides: Overrides | None = None,
    *,
    controller: Controller | Callable[[float, _wingbeat.Measurement], ArrayLike | None] | None = None,
    period_s: float | None = None,
    sees: Sequence[str] | None = None,
    observe: Observer | None = None,
) -> Flight:
    """Flies a scenario under its own controller, or under one of Python's.

    Parameters
    ----------
    scenario
        A `Scenario`, a TOML file, or a dictionary of the same keys.
    overrides
        Keys of a file or a dictionary that are set otherwise, ``{"flight.duration_s": 1.0}``.
    controller
        An object with ``update(t, measurement)``, or such a function: the inputs that hold from ``t`` (s) on, in the order of
        ``Scenario.inputs``; ``None`` leaves those in force.
    period_s
        Time between two updates, s: whole time steps of the scenario; without it 5 ms. Only beside a controller.
    sees
        States that the controller sees, by name or by what their names begin with: ``["quat", "w_WB_B"]`` is an inertial unit.
        Without it all.
    observe
        ``observe(t, x, u)`` is shown every recorded sample: time (s), states and inputs. A true answer ends the flight.

    Returns
    -------
    Flight
        ``record`` (a row per ``flight.record_every_s``), ``strips``, ``summary``, ``status``.
    """
    native = scenario_of(scenario, overrides)._native
    for name, given in {"period_s": period_s, "sees": sees}.items():
        if controller is None and given is not None:
            raise ValueError(f"{name} = {given!r}: allowed is nothing without a controller")
    period = 0.005 if period_s is None else number("period_s", period_s)
    names = [sees] if isinstance(sees, str) else None if sees is None else list(sees)
    record, strips, summary = _wingbeat.fly(native, controller, period, names, observe)
    parts = None if strips is None else Strips(Record(strips))
    return Flight(record=Record(record), strips=parts, summary=judged(summary), document=native.resolved)


def plan(scenario: Scenario | Source, overrides: Overrides | None = None) -> Plan:
    """Plans what the scenario's ``[plan]`` says: the quickest roll-in, or a gait of least power.

    Ctrl-C ends the solver: the ``KeyboardInterrupt`` has the best plan so far as its attribute ``plan``, of status ``interrupted``.

    Parameters
    ----------
    scenario
        A `Scenario`, a TOML file, or a dictionary of the same keys.
    overrides
        Keys of a file or a dictionary that are set otherwise.

    Returns
    -------
    Plan
        ``record``, ``nodes`` and ``constants`` with multipliers, ``files`` that follow the plan, ``summary``.
    """
    native = scenario_of(scenario, overrides)._native
    record, nodes, summary, files, raised = _wingbeat.plan(native)
    points, constants = nodes if nodes is not None else (None, None)
    made = Plan(
        record=_given(record),
        nodes=_given(points),
        constants=None if constants is None else json.loads(constants),
        summary=judged(summary) if raised is None else json.loads(summary),
        document=native.resolved,
        files=dict(files),
    )
    if raised is not None:
        raised.plan = made  # type: ignore[attr-defined]
        raise raised
    return made


def _robot_of(source: Scenario | Robot | Source) -> _wingbeat.Document | None:
    """The document of a robot by itself, if it is one."""
    if isinstance(source, Robot):
        return source._document
    if isinstance(source, Scenario):
        return None
    made = document(source, None, "scenario")
    return made if made.is_of_robot() else None


def trim(
    scenario: Scenario | Robot | Source,
    overrides: Overrides | None = None,
    *,
    bank_deg: float | None = None,
    progress: Callable[[dict[str, float]], object] | None = None,
) -> Trimmed:
    """Finds the periodic flight that the scenario's ``[trim]`` asks for; with ``[trim.search]`` that of the best gait.

    A robot is trimmed from its file alone: guess, search, orbit and verdict.

    Parameters
    ----------
    scenario
        A `Scenario` or a `Robot`, a TOML file of either, or a dictionary of the same keys.
    overrides
        Keys of a file or a dictionary that are set otherwise, ``{"trim.speed_m_s": 4.2}``; of a robot those of the scenario around
        it, ``{"robot.body.mass_kg": 0.02}``.
    bank_deg
        Of a robot: also fly a turn of this bank about the gait that is found; positive is right wing down.
    progress
        Receives every iteration as a dictionary; a true answer ends the search. Of a gait it holds ``start``, ``iteration``,
        ``power_w_kg`` (W/kg), ``frequency_hz`` (Hz) and ``violation`` (the worst limit missed, in its scale), of an orbit
        ``orbits``, ``iteration`` and ``residual``.

    Returns
    -------
    Trimmed
        ``record`` (one cycle), ``multipliers``, ``family``, ``starts``, ``files``, ``summary``.
    """
    alone = _robot_of(scenario)
    if alone is not None:
        around = _wingbeat.overrides(dict(overrides or {}))
        resolved, found = _wingbeat.trim_robot(alone, around, bank_deg or 0.0, progress)
    else:
        if bank_deg is not None:
            raise ValueError("bank_deg: allowed with a robot; a scenario has trim.bank_deg")
        assert not isinstance(scenario, Robot)
        native = scenario_of(scenario, overrides)._native
        resolved, found = native.resolved, _wingbeat.trim(native, progress)
    record, multipliers, family, starts, summary, files = found
    return Trimmed(
        record=_given(record),
        multipliers=_given(multipliers),
        family=_given(family),
        starts=_given(starts),
        summary=judged(summary),
        document=resolved,
        files=dict(files),
    )


def tether(
    case: Source,
    overrides: Overrides | None = None,
    *,
    compare: str | PathLike[str] | None = None,
    converge: bool = False,
) -> Moved:
    """Moves the wing of a case in its wind.

    Parameters
    ----------
    case
        A TOML file of a case, or a dictionary of the same keys.
    overrides
        Keys that are set otherwise, ``{"wind.speed_m_s": 2.0}``.
    compare
        A measured CSV file with which the last cycle is compared, as ``[compare]`` says; the result is in ``summary``.
    converge
        Run the case with coarser and finer strips and steps too; the spread is in ``summary``.

    Returns
    -------
    Moved
        ``record`` (loads, N and N m, and motion), ``strips``, ``summary``, and ``cycle`` where compared.
    """
    made = document(case, overrides, "case")
    file = None if compare is None else fspath(compare)
    record, strips, cycle, summary, resolved = _wingbeat.tether(made, file, converge)
    parts = Strips(Record(strips))
    return Moved(
        record=Record(record),
        strips=parts,
        summary=judged(summary),
        document=resolved,
        cycle=_given(cycle),
    )


def wake(
    source: Source | Flight,
    overrides: Overrides | None = None,
    *,
    scenario: Scenario | Source | None = None,
    at: Sequence[float] = (),
    cycles: int | None = None,
    model: bool = False,
    chordwise: int | None = None,
    spanwise: int | None = None,
    steps: int | None = None,
    prescribed: bool = False,
    core: float | None = None,
    critical_suction: float | None = None,
) -> Wake:
    """Steps the vortex lattice of a case, or along a flight of ``scenario``.

    Parameters
    ----------
    source
        A TOML file of a case, a dictionary of the same keys, or a `Flight`.
    overrides
        Keys of the case, or of the scenario where that is a file or a dictionary, that are set otherwise.
    scenario
        The scenario that was flown, for a `Flight`.
    at
        Of a flight, the times at which the stretches end, s; without them that before the turn and the last.
    cycles
        Of a flight, cycles of a stretch, from rest; without it 3.
    model
        Of a flight, shed the circulations of the model that flew.
    chordwise, spanwise
        Panels along chord and span; without them the program's.
    steps
        Steps per cycle; without them as many as make a step of the wind a panel's chord.
    prescribed
        Let the wind alone carry the wake.
    core
        Radius of the cores of the wake's vortices, mean chords; without it the program's.
    critical_suction
        Largest suction parameter of the leading edges: what is above is shed there; without it the flow stays attached.

    Returns
    -------
    Wake
        ``stretches`` with ``record`` (loads, N and N m) and ``phases`` (VTK), and ``summary``.
    """
    panels = (chordwise, spanwise)
    asked = ([float(t) for t in at], cycles, model, *panels, steps, prescribed, core, critical_suction)
    if isinstance(source, Flight):
        if scenario is None:
            raise ValueError("scenario: allowed is the scenario that was flown, for a flight")
        native = scenario_of(scenario, overrides)._native
        stepped, summary = _wingbeat.wake_flight(native, source.record._given(), asked)
    else:
        of_flight = {"scenario": scenario, "at": at or None, "cycles": cycles, "model": model or None}
        for name, given in of_flight.items():
            if given is not None:
                raise ValueError(f"{name} = {given!r}: allowed is nothing for a case, which is no Flight")
        stepped, summary = _wingbeat.wake_case(document(source, overrides, "case"), asked)
    stretches = [Stretch(name, Record(record), dict(phases)) for name, record, phases in stepped]
    return Wake(stretches=stretches, summary=judged(summary))


def calibrate(
    calibration: Source, overrides: Overrides | None = None, *, information: bool = False
) -> Calibrated:
    """Fits parameters of robot and rig to runs on the load cell.

    Parameters
    ----------
    calibration
        A TOML file of a calibration, or a dictionary of the same keys.
    overrides
        Keys that are set otherwise.
    information
        Only predict the standard errors, without a fit.

    Returns
    -------
    Calibrated
        ``values`` and ``errors`` by name, ``report``, ``numbers`` and ``residual`` (TOML), ``information``, ``record``, ``summary``.
    """
    made = document(calibration, overrides, "calibration")
    information_text, found = _wingbeat.calibrate(made, information)
    if found is None:
        return Calibrated(None, {}, information_text, "", "")
    record, (numbers, residual), report, summary = found
    return Calibrated(Record(record), judged(summary), information_text, report, numbers, residual)


def rig(run: Source, overrides: Overrides | None = None) -> list[Bench]:
    """Plans and simulates a run of the rig, or all that a file lists.

    Parameters
    ----------
    run
        A TOML file of a run of the rig or with ``runs = ["a.toml", ...]``, or a dictionary of the same keys.
    overrides
        Keys of the run that are set otherwise, ``{"frequency_hz": 3.0}``.

    Returns
    -------
    list of Bench
        Of each run its ``name``, ``record`` (samples of the load cell, N and N m), ``summary`` and ``window_s``.
    """
    texts = _wingbeat.overrides(dict(overrides or {}))
    runs = _wingbeat.rig_simulate(document(run, None, "run"), texts)
    return [
        Bench(name=name, record=_given(record), summary=judged(summary), document=resolved)
        for name, record, summary, resolved in runs
    ]


def process(
    samples: str | PathLike[str],
    run: Source,
    overrides: Overrides | None = None,
    *,
    window_s: tuple[float, float] | None = None,
) -> Processed:
    """Processes a file of samples as the run of a file.

    Parameters
    ----------
    samples
        Samples of the load cell, in any format that the program reads.
    run
        The run that was measured: a TOML file, or a dictionary of the same keys.
    overrides
        Keys of the run that are set otherwise.
    window_s
        Start and end of what is averaged, s, where a simulation gives them (``Bench.window_s``).

    Returns
    -------
    Processed
        ``record`` (phase averages of the six channels, N and N m), ``summary``, ``status``.
    """
    made = document(run, overrides, "run")
    name, record, summary, resolved = _wingbeat.rig_process(fspath(samples), made, window_s)
    return Processed(name=name, record=_given(record), summary=judged(summary), document=resolved)


def process_all(
    path: str | PathLike[str],
    run: Source | None = None,
    overrides: Overrides | None = None,
) -> ProcessedRuns:
    """Processes a folder of ``rig simulate`` or ``rig record``, or a folder of such folders, together.

    The average of a run that another one names as its ``process.still_air`` is taken away from that one, as the program does.

    Parameters
    ----------
    path
        The folder, or a file of samples.
    run
        The run that was measured: a TOML file, or a dictionary of the same keys; without it that of each folder.
    overrides
        Keys of every run that are set otherwise.

    Returns
    -------
    ProcessedRuns
        ``records`` by the name of the run (phase averages of the six channels, N and N m), ``envelope``, ``documents``, ``summary``, ``status``.
    """
    made = None if run is None else document(run, None, "run")
    texts = _wingbeat.overrides(dict(overrides or {}))
    parts, envelope, summary = _wingbeat.rig_process_all(fspath(path), made, texts)
    return ProcessedRuns(
        records={name: _given(record) for name, record, _ in parts},
        envelope=_given(envelope),
        summary=judged(summary),
        documents={name: resolved for name, _, resolved in parts},
    )

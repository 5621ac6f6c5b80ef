"""A robot step by step."""

from __future__ import annotations

import copyreg
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from wingbeat import _wingbeat
from wingbeat._documents import Overrides, Scenario, Source
from wingbeat._record import Array
from wingbeat._runs import scenario_of


def _again(scenario: Scenario, parts: _wingbeat._Parts) -> Stepper:
    """A stepper as it was pickled."""
    stepper = Stepper(scenario)
    stepper._native.restore(_wingbeat.Saved.of(scenario._native, parts))
    return stepper


def _saved(toml: str, parts: _wingbeat._Parts) -> _wingbeat.Saved:
    """What was saved, as it was pickled."""
    return _wingbeat.Saved.of(Scenario.from_text(toml)._native, parts)


# `copy` and `pickle` find it here: the extension has no constructor of it.
copyreg.pickle(_wingbeat.Saved, lambda saved: (_saved, saved.parts()))


class Stepper:
    """The robot of a scenario under way: state, clock and inputs, without controller and record.

    Parameters
    ----------
    scenario
        A `Scenario`, a TOML file, or a dictionary of the same keys.
    overrides
        Keys of a file or a dictionary that are set otherwise.

    Examples
    --------
    >>> stepper = Stepper("scenarios/glide.toml")
    >>> stepper.step(1e-3, steps=100)
    >>> stepper.t
    0.1
    """

    def __init__(self, scenario: Scenario | Source, overrides: Overrides | None = None) -> None:
        self._scenario = scenario_of(scenario, overrides)
        self._native = _wingbeat.Stepper(self._scenario._native)

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self._scenario, self._native.save().parts()[1])

    @property
    def t(self) -> float:
        """Time, s."""
        return self._native.t

    @property
    def state(self) -> Array:
        """The state, a copy, in the order of ``Scenario.states``; may be set."""
        return self._native.state

    @state.setter
    def state(self, state: ArrayLike) -> None:
        self._native.state = np.asarray(state, dtype=np.float64)

    @property
    def inputs(self) -> Array:
        """The inputs in force, a copy, in the order of ``Scenario.inputs``; may be set, limited to what the robot can do."""
        return self._native.inputs

    @inputs.setter
    def inputs(self, inputs: ArrayLike) -> None:
        self._native.inputs = np.asarray(inputs, dtype=np.float64)

    def reset(self, t: float = 0.0, state: ArrayLike | None = None) -> None:
        """Starts anew at ``t`` (s) in a state, or that of the scenario."""
        self._native.reset(t, None if state is None else np.asarray(state, dtype=np.float64))

    def step(self, dt: float = 1e-3, steps: int = 1) -> None:
        """Takes ``steps`` steps of ``dt`` seconds (at most 0.1) under the inputs as they are set.

        Raises ``RuntimeError`` where the model cannot be evaluated; the state is then that before the step.
        """
        self._native.step(dt, steps)

    def save(self) -> _wingbeat.Saved:
        """All that changes, for :meth:`restore`."""
        return self._native.save()

    def restore(self, saved: _wingbeat.Saved) -> None:
        """Goes back to what a stepper of the same scenario saved; what follows repeats to the bit."""
        self._native.restore(saved)

    def observe(self) -> dict[str, Any]:
        """Angles (rad), joint coordinates, powers (W), forces (N) and moments (N m) by source in body axes, now."""
        return self._native.observe()

"""Tasks, and the environments that they make."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, TypeAlias

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from wingbeat import _wingbeat
from wingbeat._documents import Overrides, Scenario, Source, shipped
from wingbeat._record import Column
from wingbeat._runs import Flight, scenario_of

Array: TypeAlias = NDArray[np.float64]
Actions: TypeAlias = NDArray[np.floating[Any]]
# Numbers with which robots are stepped: four or eight at once.
Precision: TypeAlias = Literal["f64", "f32"]

# Width and height of a picture.
PIXELS = (640, 360)
# Time between two actions, s.
PERIOD_S = 0.005

class Task:
    """What is to be learned, and what it is flown with where nothing else is given."""

    id: ClassVar[str]
    """As Gymnasium calls it."""
    name: ClassVar[str]
    """As the library calls it."""
    scenario: ClassVar[str]
    """The scenario that ships; its duration is that of an episode."""

class BankingTurn(Task):
    """A level second, then a turn at constant bank: roll, pitch and angular rate are rewarded.

    An observation has 39 numbers for Aerobat with its 8 elements, clipped to their limits:

    - 0, 1: `roll`, `pitch`, rad, to pi and pi/2.
    - 2 to 7: `w_WB_B_x` ... angular rate to 60 rad/s, `v_WB_B_x` ... velocity in body axes to 30 m/s.
    - 8 to 12: `roll_reference`, `pitch_reference`, `w_reference_x` ..., with the same limits.
    - 13, 14: `sin_phase`, `cos_phase` of the gait.
    - 15 to 30: `displacement_*` of the structure to 4 times the range, then `rate_*` to 400 ranges per s.
    - 31 to 38: `action_*`, the last action.

    The reward is `flown`, 1 for each step (chosen), and the cost of the scenario's predictive controller without `input_change` and
    `clearance` (chosen): `roll`, `pitch`, `rate` and `input` are minus the squares of weight times error, and of weight times input
    over half of its range.

    An episode terminates when roll or pitch is 60 deg off the setpoint, the angular rate exceeds 60 rad/s or the speed 30 m/s (chosen),
    and with reward 0 when the model cannot be evaluated. Each draws 5 deg in roll, pitch and yaw, 0.1 m/s and 0.5 rad/s to both sides
    (chosen, times `spread`) and any phase of the gait, from the seed.

    Over 20 episodes of 5 s (at most 1000) the scenario's predictive controller, which knows the model, earns 942 to 950, actions of
    0, which displace the elbows, -1213 to -319 (seeds 1000 to 1019). Three greedy policies of PPO with the default network of Stable-Baselines3 earned 410 to 862 after a million steps
    under `controller.weights.input=0.005`.
    """

    id = "wingbeat/BankingTurn-v0"
    name = "banking_turn"
    scenario = "scenarios/banking_turn.toml"

TASKS: tuple[type[Task], ...] = (BankingTurn,)

def register() -> None:
    """Makes the environments known to Gymnasium."""
    for task in TASKS:
        if task.id not in gym.registry:
            gym.register(
                task.id,
                entry_point="wingbeat.learn:Environment",
                vector_entry_point="wingbeat.learn:VectorEnvironment",
                kwargs={"task": task},
            )

class _Flock:
    """Robots under a task with their spaces, behind both kinds of environments."""

    def __init__(
        self,
        task: type[Task],
        scenario: Scenario | Source | None,
        overrides: Overrides | None,
        count: int,
        threads: int,
        spread: float,
        precision: Precision,
    ) -> None:
        chosen = scenario_of(shipped(task.scenario) if scenario is None else scenario, overrides)
        self.scenario = chosen
        self.given = (task.name, count, threads, precision)
        self.native = _wingbeat.Flock(chosen._native, *self.given)
        self.spread = float(spread)
        self.states = chosen.states
        self.terms = self.native.terms
        self.observation = [Column(*channel) for channel in self.native.observation]
        self.action = [Column(*channel) for channel in self.native.action]
        low = np.array([column.low for column in self.observation])
        high = np.array([column.high for column in self.observation])
        self.observations = gym.spaces.Box(low, high, dtype=np.float64)
        # Of single precision, as what learns gives them.
        self.actions = gym.spaces.Box(-1.0, 1.0, (len(self.action),), dtype=np.float32)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"native": self.native.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        saved = state.pop("native")
        self.__dict__.update(state)
        self.native = _wingbeat.Flock(self.scenario._native, *self.given)
        self.native.restore(saved)

    def judged(self, flight: Flight) -> dict[str, Array]:
        """The terms of the reward of a flight at the ends of the steps of an episode."""
        record = flight.record
        step = record["t"][1] - record["t"][0]
        every = round(PERIOD_S / step)
        if every < 1 or abs(every * step - PERIOD_S) > 1e-6 * PERIOD_S:
            raise ValueError(
                f"flight.record_every_s = {step:.6g}: allowed is {PERIOD_S} s over a whole number, so that records meet the steps"
            )
        rows = slice(every, None, every)
        middle = np.array([0.5 * (c.low + c.high) for c in self.action])
        half = np.array([0.5 * (c.high - c.low) for c in self.action])
        states = record.to_numpy([column.name for column in self.states])[rows]
        # The action in force at the end of a step is the one that was held over it.
        inputs = record.to_numpy([column.name for column in self.action])[: -every : every]
        terms = [
            self.native.judge(t, state, (given - middle) / half)
            for t, state, given in zip(record["t"][rows], states, inputs, strict=True)
        ]
        return dict(zip(self.terms, np.array(terms).T, strict=True))

    def rows(self, actions: Actions, shape: tuple[int, ...]) -> Array:
        """Actions of that shape, a row for each robot."""
        given = np.asarray(actions, dtype=np.float64)
        if given.shape != shape:
            raise ValueError(f"actions of the shape {given.shape}: allowed is {shape}")
        return given.reshape(-1, len(self.action))

    def spread_of(self, options: dict[str, Any] | None) -> float:
        """How much the start varies: the option ``spread``, or what was given at first."""
        unknown = set(options or {}) - {"spread"}
        if unknown:
            raise ValueError(f"options: {', '.join(sorted(unknown))}: allowed is spread")
        return float((options or {}).get("spread", self.spread))

class Environment(gym.Env[Array, Actions]):
    """One robot under a task.

    Actions in [-1, 1] are the inputs from their lower to their upper limits, held for 5 ms. An episode is terminated when the task
    has failed, and truncated at the end of the scenario's duration. ``info["reward_terms"]`` holds the terms of the reward.
    ``spread`` says how much the start varies: 0 is the scenario's own. ``precision`` is that of the stepping: ``"f64"``, or
    ``"f32"``, which is faster (over 3 s of random actions roll and pitch differ by at most 2.0e-3 deg); observations and rewards are
    of double precision in any case.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012

    def __init__(
        self,
        task: type[Task],
        scenario: Scenario | Source | None = None,
        overrides: Overrides | None = None,
        *,
        spread: float = 1.0,
        precision: Precision = "f64",
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode = {render_mode!r}: allowed is None, 'rgb_array'")
        self._flock = _Flock(task, scenario, overrides, 1, 1, spread, precision)
        self._begun: tuple[int, float] | None = None
        self.render_mode = render_mode
        self.observation_space = self._flock.observations
        self.action_space = self._flock.actions

    @property
    def observation(self) -> list[Column]:
        """What an observation holds: names, units, frames and limits, in order."""
        return self._flock.observation

    @property
    def action(self) -> list[Column]:
        """What an action moves: names, units and limits of the inputs, in order."""
        return self._flock.action

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Starts an episode: from a seed, or the next one of the last seed."""
        super().reset(seed=seed)
        spread = self._flock.spread_of(options)
        if seed is None and self._begun is not None and self._begun[1] == spread:
            return self._flock.native.again()[0], {}
        chosen = int(self.np_random.integers(2**63)) if seed is None else seed
        self._begun = (chosen, spread)
        return self._flock.native.reset([chosen], spread)[0], {}

    def step(self, action: Actions) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Holds an action for 5 ms."""
        if self._begun is None:
            raise gym.error.ResetNeeded("reset the environment before the first step")
        rows = self._flock.rows(action, (len(self.action),))
        seen, reward, terms, terminated, truncated = self._flock.native.step(rows)
        info = {"reward_terms": dict(zip(self._flock.terms, terms[0].tolist(), strict=True))}
        return seen[0], float(reward[0]), bool(terminated[0]), bool(truncated[0]), info

    def judge(self, flight: Flight) -> dict[str, Array]:
        """The terms of the reward that a flight of the same robot earns at each step, under any controller."""
        return self._flock.judged(flight)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the robot from behind and from its side."""
        if self.render_mode is None:
            return None
        return _wingbeat.picture_of(self._flock.native, 0, *PIXELS)

class VectorEnvironment(VectorEnv[Array, Actions, Array]):
    """Robots side by side under a task, stepped by the library on ``threads`` cores (0: all).

    Robot ``i`` of ``reset(seed=s)`` is the single environment of the seed ``s + i`` and the same ``precision``, to the bit.
    Where an episode is over the next step begins another one.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": ["rgb_array"],
        "render_fps": 20,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        *,
        task: type[Task],
        scenario: Scenario | Source | None = None,
        overrides: Overrides | None = None,
        spread: float = 1.0,
        threads: int = 0,
        precision: Precision = "f64",
        render_mode: str | None = None,
    ) -> None:
        super().__init__()
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode = {render_mode!r}: allowed is None, 'rgb_array'")
        self._flock = _Flock(task, scenario, overrides, num_envs, threads, spread, precision)
        self._begun: float | None = None
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.single_observation_space = self._flock.observations
        self.single_action_space = self._flock.actions
        self.observation_space = batch_space(self._flock.observations, num_envs)
        self.action_space = batch_space(self._flock.actions, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Starts all episodes: from ``seed``, ``seed + 1``, ..., or the next ones of the last seeds."""
        spread = self._flock.spread_of(options)
        if isinstance(seed, (int, np.integer)):
            super().reset(seed=int(seed))
            seeds = [int(seed) + number for number in range(self.num_envs)]
        elif seed is None and self._begun == spread:
            return self._flock.native.again(), {}
        else:
            given = seed if seed is not None else [None] * self.num_envs
            seeds = [int(self.np_random.integers(2**63)) if one is None else int(one) for one in given]
            if min(seeds, default=0) < 0:
                raise ValueError(f"seed = {min(seeds)}: allowed is 0 or more")
        self._begun = spread
        return self._flock.native.reset(seeds, spread), {}

    def step(  # type: ignore[override]  # ends of episodes are no numbers
        self, actions: Actions
    ) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Holds an action of each robot for 5 ms."""
        if self._begun is None:
            raise gym.error.ResetNeeded("reset the environments before the first step")
        rows = self._flock.rows(actions, (self.num_envs, len(self._flock.action)))
        seen, rewards, terms, terminated, truncated = self._flock.native.step(rows)
        named = {name: terms[:, place] for place, name in enumerate(self._flock.terms)}
        return seen, rewards, terminated, truncated, {"reward_terms": named}

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Pictures of all robots."""
        if self.render_mode is None:
            return None
        return tuple(_wingbeat.picture_of(self._flock.native, number, *PIXELS) for number in range(self.num_envs))

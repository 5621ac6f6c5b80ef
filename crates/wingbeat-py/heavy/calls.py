"""Calls of everything that the package shows, with arguments of an unlucky or hostile user.

    python calls.py [--calls 10000] [--seed 1] [--only N] [--no-interrupts]

Each call is drawn from its number: a function, a class, a method or a property, with arguments of which some are as they should be and
some are not. None may end the interpreter, panic, take a gigabyte, or end with an exception without a text. What lasts is interrupted
after half a second, as Ctrl-C does, and must answer within one. What comes back is pickled and must be equal.
"""

import argparse
import copy
import inspect
import json
import os
import pickle
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

# Most memory of a call, and of what the process may ask for, bytes.
MEMORY, ASKED = 1 << 30, 8 << 30
# Time after which a call is interrupted, and in which it must then answer, s.
PATIENCE, ANSWER = 0.5, 1.0
# Calls of a process, and the time after which it hangs, s.
BATCH, HANGS = 250, 120.0

# -- what is given ----------------------------------------------------------------------------------------------------------------


class Raises:
    """Raises whatever is asked of it."""

    def _raise(self, *_):
        raise ValueError("raised by the argument")

    __float__ = __index__ = __len__ = __iter__ = __getitem__ = __fspath__ = __bool__ = __array__ = __call__ = _raise
    __hash__ = object.__hash__

    def __repr__(self):
        return "Raises()"


class Endless:
    """Is as long as one waits, and its own list."""

    def __iter__(self):
        while True:
            yield 1.0

    def __len__(self):
        return 2**62

    def tolist(self):
        return self

    def __fspath__(self):
        return self

    def __repr__(self):
        return "Endless()"


class Lies:
    """Says that it is short and is a number, and is not."""

    size = -1
    shape = (2**40, 2**40)

    def __len__(self):
        return 3

    def __getitem__(self, place):
        raise IndexError(f"nothing at {place}")

    def __float__(self):
        return float("nan")

    def __repr__(self):
        return "Lies()"


def inside():
    """A dictionary that holds itself, and a list that does."""
    table = {}
    table["a"] = table
    row = []
    row.append(row)
    return random.choice([table, row, {"flight": table}, {"a": row}])


def deep(rng):
    """Lists or tables in one another."""
    value = rng.choice([1.0, [], {}])
    table = rng.random() < 0.5
    for _ in range(rng.choice([10, 70, 500, 10_000])):
        value = {"a": value} if table else [value]
    return value


def number(rng):
    """A number, or what may be taken for one."""
    import numpy as np

    return rng.choice(
        [0, -1, 1, 2, 7, 0.0, -0.0, 0.5, 1e-3, -1e-3, 5e-324, 1e-300, 1e12, 1e300, -1e300, float("nan"), float("inf"),
         -float("inf"), 2**31, 2**63 - 1, 2**63, 2**64, -(2**63) - 1, 10**400, True, np.float32(0.1), np.int8(-3), np.float64("nan"),
         np.uint64(2**64 - 1), 1j, rng.uniform(-10.0, 10.0), rng.randrange(100)]
    )


def text(rng):
    """A text."""
    return rng.choice(
        ["", "a", "\0", "\ud800", "roll", "flight.duration_s", "a.b.c.d", "=", "a=b", '"', "'''", "[[[", "{", "nan", "x" * 1_000_000,
         "é" * 50, "../../etc", "/", "/nonexistent/file.toml", "glide.toml\n", "[" * 5000, "a." * 5000, "🦇", "__class__", "f64", "dask"]
    )


def path(rng, pool):
    """A path, seldom of a file that is meant."""
    return rng.choice(
        [pool.folder, pool.folder / "absent", Path("/"), Path("/dev/null"), Path("/dev/zero"), Path("/dev/full"), Path("/proc/self/mem"),
         Path("/proc/self/status"), pool.fifo, pool.binary, pool.empty, pool.parquet, pool.csv, Path("x" * 300), b"glide.toml",
         pool.folder / "new" / "deep" / "file", "", ".", pool.locked]
    )


def array(rng):
    """An array."""
    import numpy as np

    size = rng.choice([0, 1, 2, 3, 8, 13, 100, 1000, 300_000])
    wild = np.array([0.0, 1.0, -1.0, np.nan, np.inf, 1e300, -1e300, 5e-324])
    made = wild[np.random.default_rng(rng.randrange(2**31)).integers(0, len(wild), size)]
    kind = rng.randrange(12)
    if kind == 0:
        return made.astype(np.float32)
    if kind == 1:
        return np.asfortranarray(made.reshape(-1, 1) + np.zeros((1, 3)))
    if kind == 2:
        return made[::-1]
    if kind == 3:
        return made[::2].astype(object)
    if kind == 4:
        return np.zeros((2, 2, 2))
    if kind == 5:
        return np.zeros(3, dtype=[("a", "f8"), ("b", "i4")])
    if kind == 6:
        return np.array(["a", "b"])
    if kind == 7:
        return np.broadcast_to(np.float64(1.0), (5_000_000,))
    if kind == 8:
        return np.zeros(5_000_000)
    if kind == 9:
        return np.array(made, dtype=">f8")
    if kind == 10:
        return np.ma.masked_invalid(made)
    return made


def anything(rng, pool):
    """Whatever a user might hand over."""
    kind = rng.randrange(12)
    if kind < 4:
        return number(rng)
    if kind == 4:
        return text(rng)
    if kind == 5:
        return path(rng, pool)
    if kind == 6:
        return array(rng)
    if kind == 7:
        return rng.choice([inside(), deep(rng)])
    if kind == 8:
        return [number(rng) for _ in range(rng.choice([0, 1, 2, 3, 8, 13, 200]))]
    if kind == 9:
        return {text(rng): number(rng) for _ in range(rng.randrange(4))}
    if kind == 10:
        return rng.choice(
            [None, (), [], {}, set(), b"", b"\xff" * 100, bytearray(10), memoryview(b"abc"), range(10**9), iter([1, 2]), object(), type,
             len, Raises(), Endless(), Lies(), Exception("an exception"), sys, slice(None), NotImplemented, ..., lambda *_: None,
             pool.thrower, frozenset([1]), complex(1, 1)]
        )
    return rng.choice(pool.objects())


def spoiled(rng, table):
    """A table of keys with another value, or none, at one to three of its keys."""
    table = copy.deepcopy(table)
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        at = table
        for _ in range(6):
            keys = list(at) if isinstance(at, dict) else list(range(len(at)))
            if not keys:
                break
            key = rng.choice(keys)
            below = at[key]
            if isinstance(below, dict | list) and rng.random() < 0.9:
                at = below
                continue
            act = rng.randrange(10)
            if act == 0:
                del at[key]
            elif act == 1:
                at[key] = rng.choice([inside(), [], {}, None, b"x", object(), Endless(), "", "nan"])
            elif isinstance(below, float | int) and act < 5:
                at[key] = below * rng.choice([-1.0, 0.0, 0.5, 2.0, 10.0, 1e3, 1e-3])
            else:
                at[key] = number(rng)
            break
    return table


# -- what is called ---------------------------------------------------------------------------------------------------------------


class Pool:
    """What calls are made of: files, and objects as they should be, each made when it is first asked for."""

    def __init__(self, folder):
        import wingbeat

        self.folder, self._made = Path(folder), {}
        self.shipped = wingbeat.shipped
        self.fifo, self.binary, self.empty = (self.folder / name for name in ("fifo", "binary.toml", "empty.toml"))
        if not self.fifo.exists():
            os.mkfifo(self.fifo)
        self.binary.write_bytes(bytes(range(256)) * 40)
        self.empty.write_text("")
        self.csv = self.folder / "loads.csv"
        self.csv.write_text("t,Fx,Fy,Fz,Tx,Ty,Tz\n" + "".join(f"{k * 1e-3},1,0,{k % 7},0,nan,0\n" for k in range(50)))
        self.locked = self.folder / "locked"
        self.locked.mkdir(exist_ok=True)
        self.locked.chmod(0o500)
        self.parquet = self.folder / "record.parquet"

    def thrower(self, *_):
        """What ends whoever calls it."""
        raise ValueError("raised by the callback")

    def of(self, name):
        """The object of this name."""
        if name not in self._made:
            self._made[name] = getattr(self, name)()
        return self._made[name]

    def scenario(self):
        import wingbeat

        return wingbeat.Scenario(self.shipped("scenarios/glide.toml"), {"flight.duration_s": 0.02})

    def turn(self):
        import wingbeat

        return wingbeat.Scenario(self.shipped("scenarios/banking_turn.toml"), {"flight.duration_s": 0.02})

    def robot(self):
        import wingbeat

        return wingbeat.Robot(self.shipped("robots/glider.toml"))

    def flight(self):
        import wingbeat

        flown = wingbeat.fly(self.of("scenario").to_dict() | {}, {"flight.record_strips_every_s": 0.01})
        flown.record.write(self.parquet)
        return flown

    def strips(self):
        return self.of("flight").strips

    def record(self):
        return self.of("flight").record

    def moved(self):
        import wingbeat

        return wingbeat.tether(self.shipped("cases/plunge.toml"), {"time.cycles": 2, "time.steps_per_cycle": 24})

    def waked(self):
        import wingbeat

        return wingbeat.wake(self.shipped("cases/plunge.toml"), chordwise=1, spanwise=4, steps=8, cycles=1)

    def bench(self):
        import wingbeat

        keys = {"seconds": 0.1}
        del keys["seconds"]
        return wingbeat.rig(self.shipped("rigs/runs/roll15_speed08.toml"), keys)[0]

    def measurement(self):
        import wingbeat

        seen = []
        wingbeat.fly(self.of("scenario"), controller=lambda t, told: seen.append(told))
        return seen[0]

    def saved(self):
        return self.stepper().save()

    def stepper(self):
        import wingbeat

        return wingbeat.Stepper(self.of("scenario"))

    def environment(self):
        from wingbeat import learn

        made = learn.Environment(learn.BankingTurn, self.of("turn"), render_mode="rgb_array")
        made.reset(seed=1)
        return made

    def flock(self):
        from wingbeat import learn

        made = learn.VectorEnvironment(2, task=learn.BankingTurn, scenario=self.of("turn"), threads=1)
        made.reset(seed=1)
        return made

    def task(self):
        from wingbeat import learn

        return learn.BankingTurn

    def warning(self):
        import wingbeat

        return wingbeat.ResultWarning("kind.what", "a text")

    def objects(self):
        """Some of the package's own."""
        return [self.of(name) for name in ("scenario", "robot", "record", "flight", "saved", "measurement", "strips", "task")]

    def table(self, name):
        """A document as a dictionary."""
        return self.of(name).to_dict()

    def case(self):
        import tomllib

        return tomllib.loads(self.shipped("cases/plunge.toml").read_text()) | {"time": {"frequency_hz": 2.0, "cycles": 2, "steps_per_cycle": 24}}

    def fit(self):
        air = ["rig.aero.preset=paper", "rig.aero.law=linear"]
        run = str(self.shipped("rigs/runs/roll15_speed08.toml"))
        return {"name": "fit", "model": air, "starts": 1, "steps_per_cycle": 40, "truth": {"set": air}, "runs": [{"run": run}],
                "parameters": [{"name": "surfaces.wing.lift_slope_per_rad"}]}

    def lot(self):
        return {"name": "some", "scenario": self.table("scenario"), "sampling": "random", "runs": 3,
                "draws": [{"key": "start.pitch_deg", "low": -5.0, "high": 5.0}], "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0}}

    def gait(self):
        short = {"storage": 1.0, "up_n": 0.08, "frequency_hz": [3.5, 3.5], "pitch_deg": [-15.0, -15.0], "effort_w": 0.3, "intervals": 4,
                 "meshes": 1, "tolerance": 0.1, "iterations": 5}
        return self.shipped("scenarios/least_power_gait.toml"), {"plan": {"least_power": short}}


# Properties and functions by themselves, classes by their name.
SELF = {
    "Robot": "robot", "Scenario": "scenario", "Record": "record", "Strips": "strips", "Stepper": "stepper", "Measurement": "measurement",
    "Flight": "flight", "Moved": "moved", "Wake": "waked", "Environment": "environment", "VectorEnvironment": "flock",
    "BankingTurn": "task", "Task": "task", "ResultWarning": "warning", "Column": "column", "Bench": "bench",
}
# Those that change: each call has its own.
CHANGING = {"stepper", "environment", "flock"}
# What is called of a class beside what it shows.
SPECIAL = ["__getitem__", "__iter__", "__len__", "__eq__", "__hash__", "__repr__", "__contains__", "__array__", "__reduce__", "__copy__",
           "__setattr__", "__getattribute__", "__str__", "__format__"]
# Methods of what the package builds on, which wait for others.
FOREIGN = {"get_wrapper_attr", "has_wrapper_attr", "set_wrapper_attr", "args", "with_traceback", "add_note"}


def targets():
    """Everything that the package shows: (name of the class or empty, name)."""
    import wingbeat
    from wingbeat import learn

    found = []
    for module in (wingbeat, learn):
        for name in module.__all__:
            thing = getattr(module, name)
            if not callable(thing):
                continue
            found.append(("", name))
            if not inspect.isclass(thing) or name not in SELF:
                continue
            own = [each for each in dir(thing) if not each.startswith("_") and each not in FOREIGN]
            special = [each for each in SPECIAL if each in dir(thing)]
            found += [(name, each) for each in own + special]
    return found


def valid(rng, pool, owner, name, parameter):
    """An argument as it should be, by what is called and its name there; nothing where none is known."""
    import wingbeat

    short = {"flight.duration_s": 0.01}
    known = {
        ("fly", "scenario"): lambda: rng.choice([pool.of("scenario"), pool.table("scenario"), spoiled(rng, pool.table("scenario")),
                                                 spoiled(rng, pool.table("turn"))]),
        ("fly", "controller"): lambda: rng.choice([None, lambda t, told: None, lambda t, told: array(rng), pool.thrower]),
        ("fly", "period_s"): lambda: 0.005,
        ("fly", "sees"): lambda: rng.choice([None, ["quat"], ["quat", "w_WB_B"]]),
        ("fly", "observe"): lambda: rng.choice([None, lambda t, x, u: False, lambda t, x, u: anything(rng, pool), pool.thrower]),
        ("Stepper", "scenario"): lambda: rng.choice([pool.of("scenario"), spoiled(rng, pool.table("scenario"))]),
        ("plan", "scenario"): lambda: pool.gait()[0],
        ("plan", "overrides"): lambda: rng.choice([pool.gait()[1], spoiled(rng, pool.gait()[1])]),
        ("trim", "scenario"): lambda: pool.shipped("scenarios/cruise_20g.toml"),
        ("trim", "overrides"): lambda: rng.choice([None, {"trim.speed_m_s": number(rng)}, {"robot.surfaces": []}]),
        ("trim", "progress"): lambda: rng.choice([None, lambda told: False, lambda told: True, pool.thrower]),
        ("tether", "case"): lambda: rng.choice([pool.case(), spoiled(rng, pool.case())]),
        ("tether", "compare"): lambda: rng.choice([None, pool.csv]),
        ("wake", "source"): lambda: rng.choice([pool.case(), spoiled(rng, pool.case()), pool.of("flight")]),
        ("wake", "scenario"): lambda: rng.choice([None, pool.of("scenario")]),
        ("wake", "at"): lambda: rng.choice([(), [0.01]]),
        ("wake", "cycles"): lambda: 1,
        ("wake", "chordwise"): lambda: 1,
        ("wake", "spanwise"): lambda: 4,
        ("wake", "steps"): lambda: 8,
        ("calibrate", "calibration"): lambda: rng.choice([pool.fit(), spoiled(rng, pool.fit())]),
        ("calibrate", "information"): lambda: True,
        ("rig", "path"): lambda: pool.shipped("rigs/runs/roll15_speed08.toml"),
        ("process", "samples"): lambda: rng.choice([pool.csv, pool.parquet]),
        ("process", "run"): lambda: pool.shipped("rigs/runs/roll15_speed08.toml"),
        ("process", "window_s"): lambda: rng.choice([None, (0.0, 1.0), (1.0, 0.0), (float("nan"), 1.0)]),
        ("sweep", "source"): lambda: rng.choice([pool.lot(), spoiled(rng, pool.lot())]),
        ("sweep", "out"): lambda: pool.folder / f"sweep-{rng.randrange(10**9)}",
        ("sweep", "engine"): lambda: "local",
        ("sweep", "cores"): lambda: rng.choice([1, 2, None]),
        ("Scenario", "source"): lambda: rng.choice([pool.table("scenario"), spoiled(rng, pool.table("scenario"))]),
        ("Scenario", "robot"): lambda: rng.choice([None, pool.of("robot")]),
        ("Robot", "source"): lambda: rng.choice([pool.table("robot"), spoiled(rng, pool.table("robot"))]),
        ("from_text", "toml"): lambda: rng.choice([pool.of("scenario").toml, pool.of("robot").toml, "a = 1", text(rng)]),
        ("shipped", "name"): lambda: rng.choice(["scenarios/glide.toml", "../", "robots", text(rng)]),
        ("Record", "columns"): lambda: pool.of("record")._given(),
        ("read", "path"): lambda: pool.parquet,
        ("write", "path"): lambda: pool.folder / "written.parquet",
        ("plot", "names"): lambda: rng.choice([None, "roll", ["p_WB_x"], [text(rng)]]),
        ("to_numpy", "names"): lambda: rng.choice([None, ["roll"], [], [text(rng)]]),
        ("Strips", "record"): lambda: pool.of("record"),
        ("step", "dt"): lambda: rng.choice([1e-3, 1e-4, 0.01, 0.1]),
        ("step", "steps"): lambda: rng.choice([1, 10, 100, 10**9]),
        ("reset", "t"): lambda: 0.0,
        ("reset", "state"): lambda: rng.choice([None, pool.of("scenario").start]),
        ("reset", "seed"): lambda: rng.choice([None, 1, [1, 2], [None, 3]]),
        ("reset", "options"): lambda: rng.choice([None, {"spread": 0.5}, {"spread": number(rng)}, {text(rng): 1}]),
        ("restore", "saved"): lambda: rng.choice([pool.of("saved"), wingbeat.Stepper(pool.of("turn")).save()]),
        ("step", "action"): lambda: action(rng, pool, 1),
        ("step", "actions"): lambda: action(rng, pool, 2),
        ("judge", "flight"): lambda: rng.choice([pool.of("flight"), wingbeat.fly(pool.of("turn"))]),
        ("Environment", "task"): lambda: pool.of("task"),
        ("VectorEnvironment", "task"): lambda: pool.of("task"),
        ("Environment", "scenario"): lambda: rng.choice([None, pool.of("turn"), pool.of("scenario"), spoiled(rng, pool.table("turn"))]),
        ("VectorEnvironment", "scenario"): lambda: rng.choice([None, pool.of("turn"), spoiled(rng, pool.table("turn"))]),
        ("VectorEnvironment", "num_envs"): lambda: rng.choice([1, 2, 5, 0, 10**5, 10**12]),
        ("VectorEnvironment", "threads"): lambda: rng.choice([0, 1, 2, 10**6]),
        ("Environment", "render_mode"): lambda: rng.choice([None, "rgb_array"]),
        ("VectorEnvironment", "render_mode"): lambda: rng.choice([None, "rgb_array"]),
        ("reference", "t"): lambda: number(rng),
    }
    made = known.get((name, parameter)) or known.get((owner, parameter))
    if made is None and parameter == "overrides":
        made = lambda: rng.choice([None, short, {}, {text(rng): number(rng)}, {"flight": {"duration_s": number(rng)}}, inside()])  # noqa: E731
    if made is None and parameter == "precision":
        made = lambda: rng.choice(["f64", "f32"])  # noqa: E731
    return made


def action(rng, pool, robots):
    """Actions of robots, or nearly."""
    import numpy as np

    count = len(pool.of("turn").inputs)
    return rng.choice([np.zeros((robots, count)), np.full((robots, count), number_of(rng)), np.zeros(count), array(rng), [0.0] * count])


def number_of(rng):
    """A real number."""
    return rng.choice([0.0, 1.0, -1.0, 5.0, float("nan"), float("inf"), 1e300])


def arguments(rng, pool, owner, name, call):
    """Positional arguments and those by name."""
    try:
        parameters = list(inspect.signature(call).parameters.values())
    except (TypeError, ValueError):
        return [anything(rng, pool) for _ in range(rng.choice([0, 0, 1, 1, 2]))], {}
    given, named = [], {}
    wild = rng.choice([0.0, 0.0, 0.1, 0.3, 1.0])
    for parameter in parameters:
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        made = valid(rng, pool, owner, name, parameter.name)
        optional = parameter.default is not parameter.empty
        if optional and rng.random() < (0.4 if made else 0.7):
            continue
        value = anything(rng, pool) if made is None or rng.random() < wild else made()
        if parameter.kind == parameter.POSITIONAL_ONLY:
            given.append(value)
        else:
            named[parameter.name] = value
    if rng.random() < 0.03:
        named["unknown"] = 1
    if rng.random() < 0.03:
        given.append(anything(rng, pool))
    return given, named


def drawn(rng, pool, all_targets):
    """A call: its words, and what makes it."""
    import wingbeat
    from wingbeat import learn

    owner, name = rng.choice(all_targets)
    # The functions do more than the properties.
    if owner and rng.random() < 0.6:
        owner, name = rng.choice([target for target in all_targets if not target[0]])
    if not owner:
        call = getattr(wingbeat, name, None) or getattr(learn, name)
        words = name
    else:
        kind = SELF[owner]
        thing = wingbeat.Column("a", "m", "W", 0.0, 1.0) if kind == "column" else None
        thing = thing or (getattr(pool, kind)() if kind in CHANGING else pool.of(kind))
        words = f"{owner}.{name}"
        settable = kind == "stepper" and name in ("state", "inputs")
        if settable and rng.random() < 0.7:
            value = rng.choice([array(rng), anything(rng, pool), [0.0] * len(getattr(thing, name))])
            return f"{words} = {brief(value)}", lambda: setattr(thing, name, value)
        call = getattr(thing, name)
        if not callable(call):
            return words, lambda: getattr(thing, name)
    given, named = arguments(rng, pool, owner, name, call)
    shown = ", ".join([brief(value) for value in given] + [f"{key}={brief(value)}" for key, value in named.items()])

    def make():
        result = call(*given, **named)
        return thing if owner and SELF[owner] in CHANGING and rng.random() < 0.3 else result

    return f"{words}({shown})", make


def brief(value):
    """The beginning of what a value looks like."""
    try:
        kind = type(value).__name__
        if isinstance(value, str | bytes) and len(value) > 40:
            return f"{kind} of {len(value)}: {value[:20]!r}"
        if isinstance(value, dict | list) and (len(value) > 8 or kind in ("dict", "list")):
            return f"{kind} of {len(value)}: {list(value)[:3]!s:.60}"
        return f"{value!r:.80}".replace("\n", " ")
    except RecursionError:
        return f"deep {type(value).__name__}"
    except Exception as error:  # noqa: BLE001
        return f"{type(value).__name__} ({type(error).__name__})"


# -- what must hold ---------------------------------------------------------------------------------------------------------------


def same(a, b):
    """Whether two results are equal, numbers that are none too."""
    import numpy as np
    import wingbeat
    from wingbeat import learn

    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray | np.generic):
        kind = a.dtype.kind
        return kind == b.dtype.kind and (kind not in "biuf" or np.array_equal(a, b, equal_nan=kind == "f"))
    if isinstance(a, wingbeat.Record):
        return a.columns == b.columns and all(same(a[name], b[name]) for name in a)
    if isinstance(a, wingbeat.Strips):
        return same(a.record, b.record)
    if isinstance(a, wingbeat.Stepper):
        return a.t == b.t and same(a.state, b.state) and same(a.inputs, b.inputs)
    if isinstance(a, wingbeat.Measurement):
        return a.taken == b.taken and a.names == b.names and same(a.values, b.values)
    if isinstance(a, learn.Environment | learn.VectorEnvironment):
        return same(a._flock.native.save(), b._flock.native.save())
    if isinstance(a, float):
        return a == b or (a != a and b != b)
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, key), getattr(b, key)) for key in a.__dataclass_fields__)
    if isinstance(a, wingbeat.ResultWarning):
        return a.id == b.id and str(a) == str(b)
    return type(a).__module__.split(".")[0] != "wingbeat" or type(a) is type or a == b or not hasattr(a, "toml")


def ours(value):
    """Whether a value is of the package."""
    of = value[0] if isinstance(value, list) and value else value
    return type(of).__module__.split(".")[0] == "wingbeat"


def kept(thing, words, account):
    """Pickles a thing of the package, and says what is wrong with what comes back."""
    if not ours(thing):
        return None
    kind = type(thing).__name__
    try:
        again = pickle.loads(pickle.dumps(thing))
    except Exception as error:  # noqa: BLE001
        # A plain container of whatever it is given is as good as that.
        plain = hasattr(thing, "__dataclass_fields__") and words.startswith(kind)
        return None if plain else f"{kind} cannot be pickled: {type(error).__name__}: {error}"
    account.counts["pickled"] += 1
    return None if same(thing, again) else f"{kind} is not what it was once it is pickled"


def threads():
    """Threads of work that go on."""
    names = []
    for task in Path("/proc/self/task").iterdir():
        try:
            names.append((task / "comm").read_text().strip())
        except OSError:
            continue
    return names.count("wingbeat")


def peak():
    """Most resident memory since it was forgotten, bytes."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) << 10
    return 0


class Account:
    """What became of the calls of a process."""

    def __init__(self, where):
        self.where = Path(where)
        self.counts, self.kinds, self.failures = Counter(), Counter(), []
        self.slowest, self.most, self.lingering = 0.0, 0, 0.0

    def tell(self, number, words):
        """Says what is called next, for the one who finds the process dead."""
        self.where.write_text(json.dumps([number, words], ensure_ascii=True))

    def fail(self, number, words, why):
        """A call that did not end as it must."""
        self.failures.append([number, words, why])

    def numbers(self):
        """All as it is handed over."""
        return {"counts": self.counts, "kinds": self.kinds, "failures": self.failures, "slowest": self.slowest, "most": self.most,
                "lingering": self.lingering}


def one(number, seed, pool, all_targets, account, stderr):
    """Makes a call and judges how it ends."""
    rng = random.Random(seed * 1_000_003 + number)
    fired = []

    def interrupt(*_):
        fired.append(time.perf_counter())
        raise KeyboardInterrupt("after its time")

    signal.signal(signal.SIGALRM, interrupt)
    words, outcome = "?", None
    account.tell(number, words)
    try:
        words, make = drawn(rng, pool, all_targets)
    except Exception as error:  # noqa: BLE001
        account.fail(number, words, f"not made: {type(error).__name__}: {error}")
        return
    account.tell(number, words)
    Path("/proc/self/clear_refs").write_text("5")
    before = peak()
    try:
        signal.setitimer(signal.ITIMER_REAL, PATIENCE)
        try:
            result = make()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        account.counts["returned"] += 1
        outcome = kept(result, words, account)
    except KeyboardInterrupt:
        account.counts["interrupted"] += 1
        outcome = None if fired else "KeyboardInterrupt though none was sent"
    except RecursionError as error:
        # Where the argument holds itself, and Python finds out.
        account.kinds["RecursionError"] += 1
        account.counts["refused"] += 1
        if "wingbeat" in traceback.format_exc().splitlines()[-2]:
            outcome = f"RecursionError: {error}"
    except Exception as error:  # noqa: BLE001
        account.counts["refused"] += 1
        account.kinds[type(error).__name__] += 1
        if not str(error).strip():
            outcome = f"{type(error).__name__} without a text"
    except BaseException as error:  # noqa: BLE001
        outcome = f"{type(error).__name__}: {error}"
    if fired:
        late = time.perf_counter() - fired[0]
        account.slowest = max(account.slowest, late)
        if late > ANSWER:
            outcome = f"answered after {late:.2f} s"
    grown = peak()
    account.most = max(account.most, grown)
    if grown > MEMORY:
        outcome = f"{grown >> 20} MiB, {before >> 20} before"
    said = stderr.read_text(errors="replace")
    if "panicked at" in said or "overflowed" in said:
        outcome = f"panicked: {said[-300:]}"
    if said:
        os.truncate(stderr, 0)
    if outcome:
        account.fail(number, words, outcome)
    # Work that was left goes on until it looks; the next call shall be alone.
    waited = time.perf_counter()
    while threads() and time.perf_counter() - waited < 3.0:
        time.sleep(0.01)
    account.lingering = max(account.lingering, time.perf_counter() - waited)


def worker(first, count, seed, folder):
    """The calls of one process; the last line tells what became of them."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (ASKED, ASKED))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    stderr = Path(folder) / "stderr"
    with stderr.open("w") as file:
        os.dup2(file.fileno(), 2)
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    os.chdir(folder)
    warnings.simplefilter("ignore")
    account, pool, all_targets = Account(Path(folder) / "told"), Pool(folder), targets()
    for number in range(first, first + count):
        one(number, seed, pool, all_targets, account, stderr)
        plt.close("all")
    print(json.dumps(account.numbers()), flush=True)
    # What goes on in other threads shall not keep the process.
    os._exit(0)


# -- the processes ----------------------------------------------------------------------------------------------------------------


def batch(first, count, seed):
    """Makes calls in a process of their own; what became of them, and the call at which it died."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, __file__, "--worker", str(first), str(count), str(seed), folder]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as child:
            told, seen, since = Path(folder) / "told", None, time.time()
            while child.poll() is None:
                time.sleep(0.05)
                now = told.read_text() if told.exists() else None
                if now != seen:
                    seen, since = now, time.time()
                if time.time() - since > HANGS:
                    child.kill()
            line = child.stdout.read().strip().splitlines()
        if line:
            return json.loads(line[-1]), None
        stderr = Path(folder) / "stderr"
        said = stderr.read_text(errors="replace")[-400:] if stderr.exists() else ""
        number, what = json.loads(told.read_text()) if told.exists() else (first, "the start")
        ended = "hung" if child.returncode == -9 else f"ended with {child.returncode}"
        return None, (number, what, f"{ended}: {said}")


def calls(count, seed):
    """Makes so many calls; true when all ended as they must."""
    total, kinds, failures = Counter(), Counter(), []
    slowest = most = lingering = 0
    number, begun = 0, time.time()
    while number < count:
        size = min(BATCH, count - number)
        told, died = batch(number, size, seed)
        if died:
            failures.append(died)
            # What came before it is made again without it.
            before = max(died[0] - number, 0)
            told = batch(number, before, seed)[0] if before else None
            size = before + 1
        if told:
            total.update(told["counts"])
            kinds.update(told["kinds"])
            failures += told["failures"]
            slowest, most = max(slowest, told["slowest"]), max(most, told["most"])
            lingering = max(lingering, told["lingering"])
        number += size
    for at, words, why in failures:
        print(f"call {at}: {words[:300]}\n    {why}")
    print(f"{count} calls in {time.time() - begun:.0f} s: {dict(total)}, {len(failures)} failed")
    print(f"refused by {dict(kinds.most_common())}")
    print(f"most memory {most >> 20} MiB; slowest answer to an interrupt {slowest:.3f} s; longest work that went on {lingering:.1f} s")
    return not failures


# Calls that last, each with what is interrupted.
LONG = {
    "fly": "wingbeat.fly(s('banking_turn'), {'flight.duration_s': 100.0, 'flight.record_every_s': 0.1})",
    "fly_controller": "wingbeat.fly(s('glide'), {'flight.duration_s': 100.0, 'flight.record_every_s': 0.1}, controller=lambda t, told: None)",
    "trim": "wingbeat.trim(s('hover'), {'aero.law': 'lev'})",
    "search": "wingbeat.trim(s('gait_search_beta'))",
    "plan": "wingbeat.plan(s('paper_plan'))",
    "gait": "wingbeat.plan(s('least_power_gait'))",
    "roll_in": "wingbeat.plan(s('roll_in'))",
    "sweep": "wingbeat.sweep(dict(lot, runs=100000), out=out)",
    "calibrate": "wingbeat.calibrate(f('calibrations/seven_runs.toml'))",
    "information": "wingbeat.calibrate(f('calibrations/seven_runs.toml'), information=True)",
    "wake": "wingbeat.wake(f('cases/flap_f1.toml'), chordwise=8, spanwise=40, steps=400)",
    "wake_flight": "wingbeat.wake(wingbeat.fly(s('banking_turn'), {'flight.duration_s': 1.5}), scenario=s('banking_turn'), steps=200, spanwise=40)",
    "tether": "wingbeat.tether(f('cases/step.toml'), {'time.steps_per_cycle': 120000})",
    "converge": "wingbeat.tether(f('cases/flap_f1.toml'), {'time.steps_per_cycle': 4000}, converge=True)",
    "rig": "wingbeat.rig(f('rigs/seven_runs.toml'))",
    "step": "wingbeat.Stepper(s('banking_turn')).step(1e-4, 10**9)",
    "vector": "v = learn.VectorEnvironment(20000, task=learn.BankingTurn, threads=1); v.reset(seed=1)\n"
              "while True: v.step(np.zeros((20000, v.single_action_space.shape[0])))",
    "make_vector": "[learn.VectorEnvironment(2**16, task=learn.BankingTurn).reset(seed=k) for k in range(1000)]",
    "lattice": "wingbeat.fly(s('glider'), {'lattice.step_s': 2e-3, 'lattice.longest_age_s': 0.4, 'flight.duration_s': 20.0})",
}

PROLOGUE = """
import os, signal, sys, threading, time, warnings
import numpy as np
import wingbeat
from wingbeat import learn
warnings.simplefilter("ignore")
f = wingbeat.shipped
s = lambda name: f(f"scenarios/{name}.toml")
out = sys.argv[1]
lot = {"name": "long", "scenario": str(s("banking_turn")), "sampling": "random", "runs": 20,
       "draws": [{"key": "air.gust_m_s", "low": 0.0, "high": 0.5}], "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0}}
print("ready", flush=True)
try:
    exec(sys.argv[2])
    print("ended", time.time(), flush=True)
except KeyboardInterrupt as raised:
    now = time.time()
    plan = getattr(raised, "plan", None)
    print("interrupted", now, "-" if plan is None else plan.status, flush=True)
except BaseException as raised:
    print("raised", time.time(), type(raised).__name__, str(raised)[:200].replace(chr(10), " "), flush=True)
os._exit(0)
"""


def interrupts(seed, times=(0.4, 1.1, 2.3)):
    """Sends Ctrl-C to each call that lasts; true when each answers in time."""
    good = True
    rng = random.Random(seed)
    for name, code in LONG.items():
        answers, kept = [], ""
        for after in times:
            with tempfile.TemporaryDirectory() as folder:
                words = [sys.executable, "-c", PROLOGUE, str(Path(folder) / "out"), code]
                with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
                    child.stdout.readline()
                    time.sleep(after * rng.uniform(0.7, 1.3))
                    sent = time.time()
                    child.send_signal(signal.SIGINT)
                    try:
                        said, errors = child.communicate(timeout=HANGS)
                    except subprocess.TimeoutExpired:
                        child.kill()
                        said, errors = "", "hung"
            word, *rest = (said.splitlines() or ["nothing"])[-1].split(maxsplit=2)
            late = float(rest[0]) - sent if rest else float("inf")
            kept = rest[1] if len(rest) > 1 else kept
            fine = word == "interrupted" and late < ANSWER and "panicked" not in errors
            answers.append(f"{late:.3f}" if word == "interrupted" else f"{word} {' '.join(rest[1:])}{errors[-200:]}")
            # What had ended before is no answer.
            good &= fine or (word == "ended" and late < 0)
        print(f"{name:<16}{'  '.join(answers)}  {kept}", flush=True)
    return good


def main():
    """By the command line."""
    if len(sys.argv) > 1 and sys.argv[1] == "--worker":
        first, count, seed = map(int, sys.argv[2:5])
        worker(first, count, seed, sys.argv[5])
    parser = argparse.ArgumentParser()
    parser.add_argument("--calls", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--no-interrupts", action="store_true")
    asked = parser.parse_args()
    if asked.only is not None:
        print(json.dumps(batch(asked.only, 1, asked.seed), indent=1))
        return
    good = calls(asked.calls, asked.seed) if asked.calls else True
    if not asked.no_interrupts:
        good &= interrupts(asked.seed)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()

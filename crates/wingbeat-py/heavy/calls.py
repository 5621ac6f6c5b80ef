"""Calls of everything that the package shows, with arguments of an unlucky or hostile user.

    python calls.py [--calls 10000] [--seed 1] [--only N] [--no-interrupts]

Each call is drawn from its number: a function, a class, a method or a property, with arguments of which some are as they should be and
some are not. None may end the interpreter, panic, take a gigabyte, or end with an exception without a text. What lasts is interrupted
after half a second, as Ctrl-C does, and must answer within one. What comes back is pickled and must be equal.
"""

import argparse
import inspect
import json
import os
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

from given import anything, array, inside, number, spoiled, text
from interrupts import ANSWER, HANGS, interrupts
from kept import kept

# Most memory of a call, and of what the process may ask for, bytes.
MEMORY, ASKED = 1 << 30, 8 << 30
# Time after which a call is interrupted, s.
PATIENCE = 0.5
# Calls of a process.
BATCH = 250

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

        return wingbeat.wake(self.shipped("cases/plunge.toml"), chordwise=1, spanwise=4, steps=8)

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


class Clock:
    """Seconds that a process had: those of its processor, and those in which it waits for something other than one."""

    def __init__(self, pid):
        self.process, self.slept, self.last = Path(f"/proc/{pid}"), 0.0, time.perf_counter()
        self.used = 0.0
        self.begun = self.spent()[0]

    def spent(self):
        """Seconds on the processors, and whether a thread runs or waits for its turn."""
        try:
            fields = self.fields(self.process)
            ready = any(self.fields(thread)[0] in "RD" for thread in (self.process / "task").iterdir())
        except OSError:
            # A thread, or all of it, ended meanwhile.
            return self.used, True
        self.used = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        return self.used, ready

    @staticmethod
    def fields(of):
        """What Linux tells of a process or thread, from its state on."""
        return (of / "stat").read_text().rsplit(")", 1)[1].split()

    def passed(self):
        """Seconds since the clock was made. Beside other work a call takes longer, but has no more of them."""
        now = time.perf_counter()
        used, ready = self.spent()
        self.slept += 0.0 if ready else now - self.last
        self.last = now
        return self.slept + max(used - self.begun, 0.0)


def batch(first, count, seed):
    """Makes calls in a process of their own; what became of them, and the call at which it died."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, __file__, "--worker", str(first), str(count), str(seed), folder]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as child:
            told, seen, clock = Path(folder) / "told", None, Clock(child.pid)
            while child.poll() is None:
                time.sleep(0.05)
                now = told.read_text() if told.exists() else None
                if now != seen:
                    seen, clock = now, Clock(child.pid)
                if clock.passed() > HANGS:
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

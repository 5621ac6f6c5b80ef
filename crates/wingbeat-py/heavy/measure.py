"""Measures what the package costs; prints one line for each number.

    python measure.py WHEEL [importing] [controlling] [threads] [stepping] [erring] [lanes] [dask]
"""

import itertools
import os
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from pathlib import Path

import gymnasium as gym
import numpy as np
import psutil

import wingbeat
import wingbeat.learn

TURN = wingbeat.shipped("scenarios/banking_turn.toml")
ROUNDS = 5


def clock_ghz():
    """Clock of the processor as the system states it."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    found = [float(line.split(":")[1]) for line in lines if line.startswith("cpu MHz")]
    return np.median(found) * 1e-3 if found else float("nan")


def importing():
    """Least time to import the package, wall and processor."""
    code = "import time; t, c = time.perf_counter(), time.thread_time(); import wingbeat; "
    code += "print(time.perf_counter() - t, time.thread_time() - c)"
    runs = [subprocess.check_output([sys.executable, "-c", code], text=True).split() for _ in range(ROUNDS)]
    wall, processor = (min(map(float, times)) for times in zip(*runs, strict=True))
    print(f"import: {wall:.3f} s, {processor:.3f} s of the processor")


def controlling():
    """Time of a call of a controller in Python that does nothing."""
    held = np.zeros(8)
    flight = wingbeat.fly(TURN, {"flight.duration_s": 2.0}, controller=lambda t, m: held, period_s=1e-3)
    timing = flight.summary["controller"]
    print(f"controller in Python: median {timing['median_us']:.1f} us, 99 % {timing['p99_us']:.1f} us a call")


def pin(core):
    """Keeps all threads of this process, and those that they start, to a core."""
    for thread in os.listdir("/proc/self/task"):
        os.sched_setaffinity(int(thread), {core})


def two_threads():
    """How much faster two flights are on two threads than one after another, each on a core of its own in both cases, and what of one is in its
    caller's thread.
    """
    scenario = wingbeat.Scenario(TURN, {"flight.duration_s": 1.0})
    cores = sorted(os.sched_getaffinity(0))[:2]

    def fly(core):
        os.sched_setaffinity(0, {core})
        wingbeat.fly(scenario)

    ratios, shares = [], []
    for _ in range(6 * ROUNDS + 1):
        begun, own, whole = time.perf_counter(), time.thread_time(), time.process_time()
        for core in cores:
            fly(core)
        one = time.perf_counter() - begun
        shares.append((time.thread_time() - own) / (time.process_time() - whole))
        threads = [threading.Thread(target=fly, args=(core,)) for core in cores]
        begun = time.perf_counter()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        ratios.append(one / (time.perf_counter() - begun))
    os.sched_setaffinity(0, set(cores))
    print(
        f"two threads: {np.median(ratios):.2f} times one ({min(ratios):.2f} to {max(ratios):.2f}); {100 * np.median(shares):.2f} % "
        f"of a flight in its caller's thread; load of the machine {os.getloadavg()[0]:.1f}"
    )


PRESETS = {"paper": ("aero.paper.nodes", 12), "full": ("aero.full.strips", 9)}


def vector(preset, count, **keys):
    """Robots of the banking turn on one thread."""
    size, strips = PRESETS[preset]
    overrides = {"aero.preset": preset, size: strips}
    return gym.make_vec(
        "wingbeat/BankingTurn-v0",
        num_envs=count,
        vectorization_mode="vector_entry_point",
        overrides=overrides,
        threads=1,
        **keys,
    )


def spent(work, count):
    """Processor time of some work, s per item."""
    begun = time.process_time()
    work()
    return (time.process_time() - begun) / count


def stepping():
    """Cycles of a step of the vector environment on one thread, in turns with the stepping of robots one by one."""
    for preset, (size, strips) in PRESETS.items():
        scenario = wingbeat.Scenario(TURN, {"aero.preset": preset, size: strips})
        alone = wingbeat.Stepper(scenario)
        ways = {"one by one, without observations": (lambda: (alone.reset(), [alone.step(1e-3, 5) for _ in range(64)]), 64)}
        for precision in ("f64", "f32"):
            robots, actions = vector(preset, 32, precision=precision), np.zeros((32, 8))
            robots.reset(seed=1)
            ways[f"vector environment, {precision}"] = (
                lambda robots=robots, actions=actions: [robots.step(actions) for _ in range(8)],
                256,
            )
        times = {way: [] for way in ways}
        for _ in range(4 * ROUNDS + 1):
            for way, (work, count) in ways.items():
                times[way].append(spent(work, count))
        for way, seen in times.items():
            seen = np.array(seen[1:]) * clock_ghz() * 1e6
            print(
                f"step of 5 ms, {preset} {strips}, {way}: {np.median(seen):.1f} thousand cycles at {clock_ghz():.2f} GHz "
                f"({seen.min():.1f} to {seen.max():.1f})"
            )


def erring():
    """What single precision and steps of 1 ms change in a second, and in three, of random actions."""
    names = ["roll, pitch [deg]", "angular rate [rad/s]", "velocity [m/s]"]
    parts = [slice(0, 2), slice(2, 5), slice(5, 8)]
    scale = [np.degrees(1.0), 1.0, 1.0]
    for preset, (size, strips) in PRESETS.items():
        pair = [vector(preset, 32, precision=precision) for precision in ("f64", "f32")]
        for robots in pair:
            robots.reset(seed=3)
        random = np.random.default_rng(3)
        alive = np.ones(32, dtype=bool)
        for step in range(1, 601):
            given = random.uniform(-1.0, 1.0, (32, 8))
            told = [robots.step(given) for robots in pair]
            alive &= ~(told[0][2] | told[1][2])
            if step in (200, 600) and alive.any():
                apart = np.abs(told[0][0] - told[1][0])[alive]
                worst = [f"{name} {k * apart[:, part].max():.1e}" for name, part, k in zip(names, parts, scale, strict=True)]
                print(f"f32 against f64, {preset} {strips}, {0.005 * step:.0f} s, {alive.sum()} robots: {', '.join(worst)}")
        scenario = wingbeat.Scenario(TURN, {"aero.preset": preset, size: strips})
        steppers = [wingbeat.Stepper(scenario) for _ in range(3)]
        limits = [(channel.low, channel.high) for channel in scenario.inputs]
        names_of_states = [channel.name for channel in scenario.states]
        rates = [names_of_states.index(f"w_WB_B_{axis}") for axis in "xyz"]
        for step in range(1, 601):
            inputs = [random.uniform(*limit) for limit in limits]
            for stepper, parts_of_step in zip(steppers, (5, 50, 100), strict=True):
                stepper.inputs = inputs
                stepper.step(0.005 / parts_of_step, parts_of_step)
            if step in (200, 600):
                coarse, fine, finest = (np.array(stepper.state)[rates] for stepper in steppers)
                print(
                    f"steps of 1 ms against .1 ms, {preset} {strips}, {0.005 * step:.0f} s: angular rate "
                    f"{np.abs(coarse - fine).max():.1e} rad/s (.1 ms against .05 ms {np.abs(fine - finest).max():.1e})"
                )


MASSES = {"key": "mismatch.mass", "low": 0.95, "high": 1.05}
GUSTS = {"key": "air.gust_m_s", "low": 0.05, "high": 0.3}
# Sweeps that are made with lanes and without: flights at rest, about an orbit, and under the predictive controller.
SWEPT = {
    "at rest, paper 12": ({"scenario": "banking_turn", "without": ["controller", "manoeuvre", "goal"]}, {}),
    "at rest, full 9": ({"scenario": "cruise_beta"}, {"scenario.aero.full.strips": 9}),
    "about an orbit, full 9": ({"scenario": "bank15_20g"}, {}),
    "predictive, paper 12": ({"scenario": "banking_turn"}, {}),
    "predictive, full 9": ({"scenario": "banking_turn"}, {"scenario.aero.preset": "full", "scenario.aero.full.strips": 9}),
}


def sweeping_in_lanes(runs=32):
    """What lanes save of the processor's time of sweeps on one thread, in turns, and how far rows are apart."""
    hold = {"roll_within_deg": 5.0, "pitch_within_deg": 10.0}
    with tempfile.TemporaryDirectory() as folder:
        for name, (what, overrides) in SWEPT.items():
            scenario = tomllib.loads(wingbeat.Scenario(wingbeat.shipped(f"scenarios/{what['scenario']}.toml")).toml)
            for table in what.get("without", []):
                scenario.pop(table, None)
            spec = {"name": "lanes", "scenario": scenario, "runs": runs, "seed": 1, "draws": [MASSES, GUSTS], "hold": hold}
            times, tables = {False: [], True: []}, {}
            for k in range(ROUNDS + 1):
                for lanes in times:
                    keys = {"scenario.flight.duration_s": 1.0, "lanes": lanes} | overrides
                    begun = time.process_time()
                    tables[lanes] = wingbeat.sweep(spec, keys, out=Path(folder) / f"{len(times)}-{name}-{lanes}-{k}", cores=1)
                    times[lanes].append((time.process_time() - begun) / runs)
            one, many = (np.array(times[lanes][1:]) for lanes in (False, True))
            worst = {
                column: np.nanmax(np.abs(tables[False][column] - tables[True][column]))
                for column in ("roll_max_error", "altitude_change", "distance_x")
                if not np.all(np.isnan(tables[False][column]))
            }
            apart = ", ".join(f"{column} {most:.1e} {tables[False].units[column]}" for column, most in worst.items())
            print(
                f"sweep in lanes, {name}: {np.median(one / many):.2f} times as fast ({min(one / many):.2f} to {max(one / many):.2f}), "
                f"{1e3 * np.median(one):.0f} and {1e3 * np.median(many):.0f} ms of the processor for a flight of a second; rows apart by {apart}",
                flush=True,
            )


def spent_by(processes):
    """Processor time of processes and all below them, s."""
    every = [one for process in processes for one in (process, *process.children(recursive=True))]
    return sum(sum(one.cpu_times()[:2]) for one in set(every))


def sweeping():
    """What Dask adds on two workers, in turns with two threads of this process: to jobs of about a second of the processor, and to each of many
    jobs that do next to nothing, which other programs move less. Worker and thread have a core of their own.
    """
    from concurrent.futures import ThreadPoolExecutor

    import wingbeat._sweeps
    from distributed import Client, LocalCluster

    own = psutil.Process()
    cores = sorted(os.sched_getaffinity(0))[:2]
    left = itertools.cycle(cores)
    wingbeat._sweeps.ThreadPoolExecutor = lambda count, **keys: ThreadPoolExecutor(
        count, initializer=lambda: os.sched_setaffinity(0, {next(left)}), **keys
    )

    def compared(folder, address, jobs, seconds, rounds):
        """Time of the clock and of the processor on threads and on workers, by round; whether the rows are the same."""
        flights = {
            "name": "mass",
            "scenario": str(TURN),
            "sampling": "grid",
            "draws": [{"key": "mismatch.mass", "low": 0.9, "high": 1.1, "points": jobs}],
            "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0},
        }
        times, same = [], True
        for k in range(rounds):
            tables, spent_here = [], []
            for way, keys in (("threads", {"cores": 2}), ("workers", {"engine": "dask", "address": address})):
                begun, before = time.perf_counter(), spent_by([own])
                out = Path(folder) / f"{way}-{jobs}-{k}"
                tables.append(wingbeat.sweep(flights, {"scenario.flight.duration_s": seconds}, out=out, **keys))
                spent_here.append((time.perf_counter() - begun, spent_by([own]) - before))
            times.append(spent_here)
            same &= all(np.array_equal(tables[0][name], tables[1][name], equal_nan=True) for name in tables[0])
        return np.array(times), same

    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
    ):
        address = cluster.scheduler_address
        with Client(address) as client:
            for core, worker in zip(cores, client.scheduler_info()["workers"], strict=True):
                client.run(pin, core, workers=[worker])
        compared(folder, address, 4, 0.02, 1)
        short, same = compared(folder, address, 200, 0.005, ROUNDS)
        added = 1e3 * (short[:, 1] - short[:, 0]) / 200
        wall, processor = (f"{np.median(one):.1f} ms ({one.min():.1f} to {one.max():.1f})" for one in added.T)
        print(f"Dask adds to each of 200 short jobs {wall}, {processor} of the processor; rows the same: {same}")
        whole, same = compared(folder, address, 8, 3.0, 3 * ROUNDS)
        added = 100 * (whole[:, 1] / whole[:, 0] - 1)
        wall, processor = (
            f"{np.median(one):+.1f} % (quartiles {np.quantile(one, 0.25):+.1f} and {np.quantile(one, 0.75):+.1f}, {one.min():+.1f} to "
            f"{one.max():+.1f})"
            for one in added.T
        )
        print(
            f"Dask adds to 8 jobs of {np.median(whole[:, 0, 1]) / 8:.2f} s of the processor {wall}, {processor} of the processor; "
            f"rows the same: {same}; load of the machine {os.getloadavg()[0]:.1f}"
        )


MEASURED = {
    "importing": importing,
    "controlling": controlling,
    "threads": two_threads,
    "stepping": stepping,
    "erring": erring,
    "lanes": sweeping_in_lanes,
    "dask": sweeping,
}

if __name__ == "__main__":
    print(f"wheel: {Path(sys.argv[1]).stat().st_size * 1e-6:.2f} MB")
    for name in sys.argv[2:] or MEASURED:
        MEASURED[name]()

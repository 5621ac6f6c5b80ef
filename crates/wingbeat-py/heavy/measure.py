"""Measures what the package costs; prints one line for each number.

    python measure.py WHEEL
"""

import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import gymnasium as gym
import numpy as np

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
    code = "import time; t, c = time.perf_counter(), time.process_time(); import wingbeat; "
    code += "print(time.perf_counter() - t, time.process_time() - c)"
    runs = [subprocess.check_output([sys.executable, "-c", code], text=True).split() for _ in range(ROUNDS)]
    wall, processor = (min(map(float, times)) for times in zip(*runs, strict=True))
    print(f"import: {wall:.3f} s, {processor:.3f} s of the processor")


def controlling():
    """Time of a call of a controller in Python that does nothing."""
    held = np.zeros(8)
    flight = wingbeat.fly(TURN, {"flight.duration_s": 2.0}, controller=lambda t, m: held, period_s=1e-3)
    timing = flight.summary["controller"]
    print(f"controller in Python: median {timing['median_us']:.1f} us, 99 % {timing['p99_us']:.1f} us a call")


def two_threads():
    """How much faster two flights are on two threads than one after another."""
    scenario = wingbeat.Scenario(TURN, {"flight.duration_s": 1.0})
    ratios = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        wingbeat.fly(scenario)
        wingbeat.fly(scenario)
        one = time.perf_counter() - begun
        threads = [threading.Thread(target=wingbeat.fly, args=(scenario,)) for _ in range(2)]
        begun = time.perf_counter()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        ratios.append(one / (time.perf_counter() - begun))
    print(f"two threads: {np.median(ratios):.2f} times one ({min(ratios):.2f} to {max(ratios):.2f})")


def stepping():
    """Cycles of a step of the vector environment on one thread."""
    for preset, strips in (("paper", 12), ("full", 9)):
        size = {"paper": "aero.paper.nodes", "full": "aero.full.strips"}[preset]
        robots = gym.make_vec(
            "wingbeat/BankingTurn-v0",
            num_envs=32,
            vectorization_mode="vector_entry_point",
            overrides={"aero.preset": preset, size: strips},
            threads=1,
        )
        robots.reset(seed=1)
        actions = np.zeros((32, 8))
        for _ in range(3):
            robots.step(actions)
        times = []
        for _ in range(ROUNDS):
            begun = time.process_time()
            for _ in range(10):
                robots.step(actions)
            times.append((time.process_time() - begun) / 320)
        cycles = min(times) * clock_ghz() * 1e9
        print(
            f"step of 5 ms, {preset} {strips}, f64: {1e6 * min(times):.1f} us, {1e-3 * cycles:.1f} thousand cycles "
            f"at {clock_ghz():.2f} GHz; spread {1e6 * min(times):.1f} to {1e6 * max(times):.1f} us"
        )


def sweeping():
    """What Dask adds to jobs of about a second on two workers."""
    from distributed import LocalCluster

    flights = {
        "name": "second",
        "scenario": str(TURN),
        "sampling": "grid",
        "draws": [{"key": "mismatch.mass", "low": 0.9, "high": 1.1, "points": 16}],
        "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0},
    }
    scenario = {"scenario.flight.duration_s": 1.2}
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        one = wingbeat.sweep(flights, scenario, out=Path(folder) / "local", cores=2)
        local = time.perf_counter() - begun
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            address = cluster.scheduler_address
            wingbeat.sweep(flights | {"seed": 1}, scenario, out=Path(folder) / "warm", engine="dask", address=address)
            begun = time.perf_counter()
            many = wingbeat.sweep(flights, scenario, out=Path(folder) / "dask", engine="dask", address=address)
            dask = time.perf_counter() - begun
    same = all(np.array_equal(one[name], many[name], equal_nan=True) for name in one)
    print(f"16 flights: {local:.2f} s on two threads, {dask:.2f} s on two workers of Dask, rows the same: {same}")


if __name__ == "__main__":
    print(f"wheel: {Path(sys.argv[1]).stat().st_size * 1e-6:.2f} MB")
    importing()
    controlling()
    two_threads()
    stepping()
    sweeping()

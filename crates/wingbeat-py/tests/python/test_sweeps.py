"""Sweeps: the same rows on any number of cores and machines, and nothing lost."""

import json
import math
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import ROOT

import wingbeat

CASE = {
    "name": "plunge",
    "case": str(ROOT / "cases/plunge.toml"),
    "sampling": "latin_hypercube",
    "runs": 8,
    "seed": 4,
    "draws": [
        {"key": "time.frequency_hz", "low": 0.1, "high": 0.3},
        {"key": "wind.incidence_deg", "low": -5.0, "high": 5.0},
    ],
}
SHORT = {"case.time.cycles": 2, "case.time.steps_per_cycle": 32}


def same(one, other):
    return list(one) == list(other) and all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


def plunge(**keys):
    case = wingbeat._documents.document(CASE["case"], {k.removeprefix("case."): v for k, v in SHORT.items()}, "case")
    import tomllib

    return CASE | {"case": tomllib.loads(case.resolved())} | keys


def test_rows_are_those_of_the_program_on_any_number_of_cores(program, tmp_path):
    one = wingbeat.sweep(plunge(), out=tmp_path / "one", cores=1)
    two = wingbeat.sweep(plunge(), out=tmp_path / "two", cores=2)
    assert same(one, two)
    assert sorted(path.name for path in (tmp_path / "one").iterdir()) == ["record.parquet", "sweep.toml"]
    done = program("sweep", tmp_path / "one/sweep.toml", "--quiet", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    bytes_of = [(tmp_path / place / "record.parquet").read_bytes() for place in ("one", "two", "run")]
    assert bytes_of[0] == bytes_of[1] == bytes_of[2]


def test_flights_on_a_grid(tmp_path, turn):
    flights = {
        "name": "mass",
        "scenario": str(turn),
        "sampling": "grid",
        "draws": [{"key": "mismatch.mass", "low": 0.9, "high": 1.1, "points": 3}],
        "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0},
    }
    record = wingbeat.sweep(flights, {"scenario.flight.duration_s": 0.05}, out=tmp_path / "mass", cores=2)
    assert record["mismatch.mass"].tolist() == pytest.approx([0.9, 1.0, 1.1])
    assert record["completed"].tolist() == [1.0, 1.0, 1.0]
    assert record.units["altitude_change"] == "m"


def test_lanes_give_the_rows_of_flights_one_by_one_but_for_rounding(program, tmp_path, turn):
    flights = {
        "name": "gusts",
        "scenario": str(turn),
        "runs": 6,
        "lanes": True,
        "draws": [{"key": "air.gust_m_s", "low": 0.1, "high": 0.3}, {"key": "mismatch.mass", "low": 0.95, "high": 1.05}],
        "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0},
    }
    keys = {"scenario.flight.duration_s": 0.1}
    one = wingbeat.sweep(flights, keys, out=tmp_path / "one", cores=1)
    assert same(one, wingbeat.sweep(flights, keys, out=tmp_path / "two", cores=2))
    done = program("sweep", tmp_path / "one/sweep.toml", "--quiet", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "one/record.parquet").read_bytes() == (tmp_path / "run/record.parquet").read_bytes()
    plain = wingbeat.sweep(flights, keys | {"lanes": False}, out=tmp_path / "plain", cores=2)
    for name in plain:
        assert np.allclose(one[name], plain[name], rtol=1e-10, atol=1e-10, equal_nan=True), name


def searched(turn, **keys):
    goal = {"key": "distance_x_m", "low": 0.06, "per": 0.01}
    draws = [{"key": "start.velocity_m_s[0]", "low": 1.0, "high": 2.0}, {"key": "start.nose_up_deg", "low": 5.0, "high": 20.0}]
    search = {"population": 4, "flights": [["flight.duration_s=0.03"]], "goals": [goal]}
    return {"name": "fast", "scenario": str(turn), "runs": 10, "seed": 3, "search": search, "draws": draws} | keys


def test_a_search_is_that_of_the_program_and_goes_on(program, tmp_path, turn):
    one = wingbeat.sweep(searched(turn), out=tmp_path / "one", cores=1)
    assert one.rows == 10 and one["cost"].min() < one["cost"][0]
    missed = np.maximum(0.06 - one["flight_0_distance_x_m"], 0.0) / 0.01
    assert one["cost"] == pytest.approx(missed**2)
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert names == ["best.toml", "record.parquet", "summary.json", "sweep.toml"]
    done = program("sweep", tmp_path / "one/sweep.toml", "--quiet", "--out", tmp_path / "run")
    assert done.returncode in (0, 3), done.stderr
    for name in ("record.parquet", "best.toml"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "run" / name).read_bytes(), name
    told = [json.loads((tmp_path / place / "summary.json").read_text()) for place in ("one", "run")]
    assert told[0] == told[1]
    best = int(np.argmin(one["cost"]))
    assert (told[0]["best"], told[0]["cost"]) == (one["run"][best], one["cost"][best])
    # What was cut off in a generation goes on from its log.
    (tmp_path / "cut").mkdir()
    (tmp_path / "cut/sweep.toml").write_text((tmp_path / "one/sweep.toml").read_text())
    log = "".join(",".join(repr(float(one[name][k])) for name in one) + "\n" for k in (0, 1, 2, 3, 5))
    (tmp_path / "cut/rows.log").write_text(log)
    assert same(one, wingbeat.sweep(searched(turn), out=tmp_path / "cut", cores=2))
    (tmp_path / "cut/record.parquet").unlink()
    (tmp_path / "cut/rows.log").write_text(log.replace(repr(float(one["cost"][1])), "1.0").replace("0.0,1.", "0.0,9.", 1))
    with pytest.raises(ValueError):
        wingbeat.sweep(searched(turn), out=tmp_path / "cut", cores=2)
    with pytest.raises(ValueError, match="search.population"):
        wingbeat.sweep(searched(turn, search={"population": 1, "goals": []}), out=tmp_path / "bad")


INTERRUPTED = """
import sys, tomllib, wingbeat
spec = tomllib.loads(open(sys.argv[1]).read())
print("ready", flush=True)
try:
    wingbeat.sweep(spec, out=sys.argv[2], cores=1)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_what_was_ended_goes_on(tmp_path, sent):
    slow = plunge(runs=30)
    slow["case"]["time"]["cycles"] = 20
    whole = wingbeat.sweep(slow, out=tmp_path / "whole", cores=2)
    command = [sys.executable, "-c", INTERRUPTED, tmp_path / "whole/sweep.toml", tmp_path / "cut"]
    log = tmp_path / "cut/rows.log"
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout.readline() == "ready\n"
        while not (log.exists() and log.read_text().count("\n") >= 3):
            assert child.poll() is None
            time.sleep(0.005)
        os.kill(child.pid, sent)
    done = log.read_text().count("\n")
    assert 3 <= done < 30
    log.write_text(log.read_text() + "7,0.1")
    assert same(whole, wingbeat.sweep(slow, out=tmp_path / "cut", cores=2))


def test_another_sweep_is_refused(tmp_path):
    wingbeat.sweep(plunge(), out=tmp_path / "a", cores=1)
    with pytest.raises(ValueError, match=r"sweep.toml: another sweep is here"):
        wingbeat.sweep(plunge(seed=5), out=tmp_path / "a")
    (tmp_path / "b").mkdir()
    (tmp_path / "b/mine.txt").write_text("mine")
    with pytest.raises(ValueError, match="allowed is a new or empty folder"):
        wingbeat.sweep(plunge(), out=tmp_path / "b")
    with pytest.raises(ValueError, match="engine = 'ray'"):
        wingbeat.sweep(plunge(), out=tmp_path / "c", engine="ray")
    with pytest.raises(ValueError, match=r"draws\[0\].key"):
        wingbeat.sweep(plunge(draws=[{"key": "time.frequency", "low": 0.1, "high": 0.3}]), out=tmp_path / "c")


@pytest.mark.filterwarnings("default")
@pytest.mark.long
def test_a_cluster_makes_the_same_rows_though_a_worker_is_killed(tmp_path):
    from distributed import LocalCluster

    slow = plunge(runs=40)
    slow["case"]["time"]["cycles"] = 20
    one = wingbeat.sweep(slow, out=tmp_path / "one", cores=2)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        log = tmp_path / "many/rows.log"

        def kill():
            while not (log.exists() and log.read_text().count("\n") >= 20):
                time.sleep(0.01)
            os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        many = wingbeat.sweep(slow, out=tmp_path / "many", engine="dask", address=cluster.scheduler_address)
        killer.join()
    assert same(one, many)
    assert (tmp_path / "one/record.parquet").read_bytes() == (tmp_path / "many/record.parquet").read_bytes()
    assert not any(math.isnan(value) for value in many["mean_lift"])

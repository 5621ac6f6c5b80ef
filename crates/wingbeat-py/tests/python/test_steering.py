"""Controllers, observers and steppers of one's own; signals and threads."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import SHORT

import wingbeat


class Leveller:
    """Lifts the lower wing in proportion to the roll rate."""

    def __init__(self, inputs):
        self.left, self.right = (inputs.index(f"command_shoulder_{side}") for side in ("left", "right"))
        self.count = len(inputs)
        self.seen = []

    def update(self, t, measurement):
        self.seen.append((t, measurement.taken, measurement["w_WB_B_x"]))
        inputs = np.zeros(self.count)
        inputs[self.left], inputs[self.right] = -0.1, 0.1
        return inputs


def test_a_controller_of_ones_own_flies(turn):
    scenario = wingbeat.Scenario(turn, SHORT)
    own = Leveller([column.name for column in scenario.inputs])
    flight = wingbeat.fly(scenario, controller=own, period_s=0.005, sees=["quat", "w_WB_B"])
    assert flight.summary["controller"]["updates"] == 20
    assert flight.summary["controller"]["failures"] == 0
    assert [t for t, _, _ in own.seen] == pytest.approx(np.arange(20) * 0.005)
    assert np.all(flight.record["command_shoulder_right"] == 0.1)
    assert own.seen[-1][2] == flight.record["w_WB_B_x"][95]


def test_what_is_not_seen_is_not_told(turn):
    told = []

    def look(t, measurement):
        told.append(measurement.names)

    flight = wingbeat.fly(turn, {"flight.duration_s": 0.01}, controller=look, sees=["quat"])
    assert told[0] == ["quat_w", "quat_x", "quat_y", "quat_z"]
    assert flight.summary["controller"]["failures"] == 2
    with pytest.raises(ValueError, match="sees = quaternion: allowed is"):
        wingbeat.fly(turn, SHORT, controller=look, sees=["quaternion"])


def test_exceptions_of_a_controller_come_back(turn):
    def broken(t, measurement):
        if t > 0.02:
            raise ZeroDivisionError("mine")
        return np.zeros(8)

    with pytest.raises(ZeroDivisionError, match="mine"):
        wingbeat.fly(turn, SHORT, controller=broken)
    with pytest.raises(ValueError, match="answers 3 inputs: allowed are 8"):
        wingbeat.fly(turn, SHORT, controller=lambda t, m: np.zeros(3))
    with pytest.raises(ValueError, match="command_shoulder_left = NaN at t = 0.0000 s"):
        wingbeat.fly(turn, SHORT, controller=lambda t, m: np.full(8, np.nan))
    with pytest.raises(TypeError, match="a method update"):
        wingbeat.fly(turn, SHORT, controller=3)
    with pytest.raises(ValueError, match="period_s"):
        wingbeat.fly(turn, SHORT, controller=broken, period_s=1.7e-4)


def test_observers_see_every_sample_and_end_a_flight(turn):
    times = []

    def observe(t, x, u):
        times.append(t)
        return len(times) == 11

    flight = wingbeat.fly(turn, SHORT, observe=observe)
    assert times == pytest.approx(np.arange(11) * 1e-3)
    assert (flight.status, flight.record.rows) == ("interrupted", 11)


def test_a_stepper_repeats_to_the_bit(turn):
    stepper = wingbeat.Stepper(turn)
    stepper.inputs = np.full(8, 0.05)
    stepper.step(1e-3, 20)
    saved = stepper.save()
    stepper.step(1e-3, 30)
    once = (stepper.t, stepper.state)
    stepper.restore(saved)
    stepper.step(1e-3, 30)
    assert stepper.t == once[0] == pytest.approx(0.05)
    assert np.array_equal(stepper.state, once[1])
    seen = stepper.observe()
    total = sum(value for name, value in seen.items() if name.startswith("force_"))
    assert np.allclose(total, 0.0, atol=1e-12)
    stepper.reset()
    assert stepper.t == 0.0
    assert list(stepper.state) == wingbeat.Scenario(turn).start
    with pytest.raises(ValueError, match="inputs = 3 numbers: allowed is 8 numbers"):
        stepper.inputs = [0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="dt = 0: allowed is"):
        stepper.step(0.0)


def test_a_stepper_flies_as_the_flight_does(turn):
    scenario = wingbeat.Scenario(turn, SHORT | {"flight.step_s": 1e-3})
    flight = wingbeat.fly(scenario, controller=lambda t, m: np.zeros(8))
    stepper = wingbeat.Stepper(scenario)
    stepper.step(1e-3, 100)
    last = [flight.record[column.name][-1] for column in scenario.states]
    assert np.array_equal(stepper.state, last)


INTERRUPTED = """
import sys, time, wingbeat
what = sys.argv[1]
print("ready", flush=True)
try:
    if what == "fly":
        wingbeat.fly(wingbeat.shipped("scenarios/banking_turn.toml"), {"aero.preset": "full"})
    elif what == "plan":
        wingbeat.plan(wingbeat.shipped("scenarios/roll_in.toml"))
    elif what == "search":
        wingbeat.trim(wingbeat.shipped("scenarios/gait_search_beta.toml"))
    elif what == "step":
        wingbeat.Stepper(wingbeat.shipped("scenarios/banking_turn.toml")).step(1e-4, 10_000_000)
    print("done")
except KeyboardInterrupt:
    print(time.time(), flush=True)
"""


@pytest.mark.parametrize("what", ["fly", "plan", "search", "step"])
def test_ctrl_c_ends_work_at_once(what):
    command = [sys.executable, "-c", INTERRUPTED, what]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout.readline() == "ready\n"
        time.sleep(0.5)
        sent = time.time()
        os.kill(child.pid, signal.SIGINT)
        ended = float(child.stdout.readline())
        assert child.wait(10) == 0
    print(f"Ctrl-C in {what}: {ended - sent:.3f} s")
    # Asked are .2 s; a busy machine may take longer to give the processor back.
    assert ended - sent < 1.0


def test_flights_leave_the_interpreter_to_others(turn):
    scenario = wingbeat.Scenario(turn, {"flight.duration_s": 1.0, "aero.preset": "full"})
    thread = threading.Thread(target=wingbeat.fly, args=(scenario,))
    thread.start()
    ticks = 0
    while thread.is_alive():
        time.sleep(1e-3)
        ticks += 1
    assert ticks > 50


def test_a_flight_holds_the_interpreter_for_little_of_its_time(turn):
    """What a flight does in its caller's thread cannot be done by two at once: at a share s two threads are at most 2/(1 + s)
    times as fast as one. Shares of the processor's time, which other programs do not move.
    """
    scenario = wingbeat.Scenario(turn, {"flight.duration_s": 1.0})
    own, whole = time.thread_time(), time.process_time()
    wingbeat.fly(scenario)
    share = (time.thread_time() - own) / (time.process_time() - whole)
    print(f"share of a flight in its caller's thread: {share:.4f}")
    assert share < 0.05

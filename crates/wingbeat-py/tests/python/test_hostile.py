"""Arguments of an unlucky or hostile user: none ends the interpreter."""

import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import wingbeat
import wingbeat.learn  # noqa: F401

LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
import numpy as np
import wingbeat
class Endless:
    def tolist(self):
        return self
inside = {}
inside["a"] = inside
deep = []
for _ in range(10_000):
    deep = [deep]
wide = [0.0] * 1000
for _ in range(20):
    wide = [wide] * 100
values = {"inside": inside, "deep": {"a": deep}, "wide": {"a": wide}, "endless": {"a": Endless()},
          "array": {"a": np.zeros(5_000_000)}, "text": {"a": "x" * 50_000_000}}
value = values[sys.argv[1]]
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for make in (wingbeat.Scenario, wingbeat.Robot,
             lambda given: wingbeat.Scenario(wingbeat.shipped("scenarios/glide.toml"), given)):
    try:
        make(value)
    except ValueError as error:
        print(error)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) >> 10)
"""


@pytest.mark.parametrize("what", ["inside", "deep", "wide", "endless", "array", "text"])
def test_dictionaries_without_end_are_refused(what):
    done = subprocess.run([sys.executable, "-c", LIMITED, what], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    *refused, grown = done.stdout.splitlines()
    assert len(refused) == 3 and all("allowed are at most" in text for text in refused), done.stdout
    assert int(grown) < 200, f"{grown} MiB"


def test_a_stepper_takes_back_its_own_alone(turn):
    stepper = wingbeat.Stepper(turn)
    other = wingbeat.Stepper(wingbeat.shipped("scenarios/glide.toml"))
    with pytest.raises(ValueError, match="saved = of .*: allowed is what a stepper of the same scenario saved"):
        stepper.restore(other.save())
    stepper.restore(wingbeat.Stepper(turn).save())


def test_a_step_is_none_of_minutes(turn):
    with pytest.raises(ValueError, match="dt = 1000: allowed is above 0, at most 0.1 s"):
        wingbeat.Stepper(turn).step(1e3, 1)


def test_what_is_pickled_is_equal(turn):
    scenario = wingbeat.Scenario(turn, {"flight.duration_s": 0.1})
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    stepper = wingbeat.Stepper(scenario)
    stepper.inputs = np.full(8, 0.05)
    stepper.step(1e-3, 20)
    again = pickle.loads(pickle.dumps(stepper))
    for one in (stepper, again):
        one.step(1e-3, 30)
    assert stepper.t == again.t
    assert np.array_equal(stepper.state, again.state)


@pytest.mark.parametrize("vector", [False, True])
def test_environments_are_pickled_with_their_state(vector):
    name, options = "wingbeat/BankingTurn-v0", {"num_envs": 3, "vectorization_mode": "vector_entry_point"}
    environment = (gymnasium.make_vec(name, **options) if vector else gymnasium.make(name)).unwrapped
    environment.reset(seed=3)
    action = np.full(environment.action_space.shape, 0.2)
    environment.step(action)
    again = pickle.loads(pickle.dumps(environment))
    for _ in range(3):
        one, other = environment.step(action), again.step(action)
        assert all(np.array_equal(a, b) for a, b in zip(one[:4], other[:4], strict=True))
    assert np.array_equal(environment.reset()[0], again.reset()[0])


SWEEP = """
import sys, time, wingbeat
spec = {"name": "long", "scenario": str(wingbeat.shipped("scenarios/banking_turn.toml")), "sampling": "random", "runs": 200,
        "draws": [{"key": "air.gust_m_s", "low": 0.0, "high": 0.5}],
        "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0}}
print("ready", flush=True)
try:
    wingbeat.sweep(spec, out=sys.argv[1])
except KeyboardInterrupt:
    print(time.time(), flush=True)
"""


def test_ctrl_c_ends_a_sweep_at_once(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", SWEEP, tmp_path / "out"], stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout.readline() == "ready\n"
        time.sleep(1.5)
        sent = time.time()
        child.send_signal(signal.SIGINT)
        ended = float(child.stdout.readline())
        assert child.wait(10) == 0
    print(f"Ctrl-C in sweep: {ended - sent:.3f} s")
    assert ended - sent < 1.0


CALLS = Path(__file__).parents[2] / "heavy/calls.py"


def test_drawn_calls_end_as_they_must():
    words = [sys.executable, CALLS, "--calls", "40", "--seed", "3", "--no-interrupts"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_a_user_keeps_is_pickled():
    warning = pickle.loads(pickle.dumps(wingbeat.ResultWarning("kind.what", "a text")))
    assert (warning.id, str(warning)) == ("kind.what", "kind.what: a text")
    scenario, told = wingbeat.Scenario(wingbeat.shipped("scenarios/glide.toml"), {"flight.duration_s": 0.01}), []
    wingbeat.fly(scenario, controller=lambda t, measured: told.append(measured))
    again = pickle.loads(pickle.dumps(told[0]))
    assert again.names == told[0].names and np.array_equal(again.array, told[0].array)
    stepper = wingbeat.Stepper(scenario)
    saved = pickle.loads(pickle.dumps(stepper.save()))
    stepper.step(1e-3, 5)
    stepper.restore(saved)
    assert stepper.t == 0.0


PLAN = """
import sys, time, wingbeat
print("ready", flush=True)
try:
    keys = {"intervals": 4, "meshes": 20, "tolerance": 1e-9}
    wingbeat.plan(wingbeat.shipped("scenarios/least_power_gait.toml"), {"plan": {"least_power": keys}})
except KeyboardInterrupt as raised:
    print(time.time(), raised.plan.status, raised.plan.nodes.rows, flush=True)
"""


@pytest.mark.long
def test_ctrl_c_in_a_plan_keeps_the_best_so_far():
    with subprocess.Popen([sys.executable, "-c", PLAN], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout.readline() == "ready\n"
        # The gait of the robot itself is simulated first.
        time.sleep(3.0)
        sent = time.time()
        child.send_signal(signal.SIGINT)
        ended, status, rows = child.stdout.readline().split()
        assert child.wait(10) == 0
    assert float(ended) - sent < 1.0 and status == "interrupted" and int(rows) > 4


def test_a_state_has_an_attitude(turn):
    stepper = wingbeat.Stepper(turn)
    names = [channel.name for channel in wingbeat.Scenario(turn).states]
    at = names.index("quat_w")
    for norm in (0.0, 2.0):
        state = stepper.state
        state[at : at + 4] *= norm
        with pytest.raises(ValueError, match=rf"quaternion of norm {norm:g}"):
            stepper.state = state
        with pytest.raises(ValueError, match="quaternion of norm"):
            stepper.reset(0.0, state)
    state = stepper.state
    state[at : at + 4] *= 1.0 + 1e-6
    stepper.state = state
    with pytest.raises(ValueError, match=r"steps = -1: allowed is 0 or more"):
        stepper.step(1e-3, -1)


def test_arguments_are_refused_as_arguments(turn):
    def steer(t, measurement):
        return [0.0] * 8

    short = {"flight.duration_s": 0.006}
    with pytest.raises(ValueError, match="^period_s = 0.00033") as refused:
        wingbeat.fly(turn, short, controller=steer, period_s=0.00033)
    assert ".toml" not in str(refused.value)
    seen = []
    wingbeat.fly(turn, short, controller=lambda t, m: seen.append(m.names) or [0.0] * 8, sees="quat")
    assert seen[0] == ["quat_w", "quat_x", "quat_y", "quat_z"]


def test_what_is_given_wrongly_is_named(turn):
    with pytest.raises(ValueError, match="x: .*"):
        wingbeat.Scenario(turn, robot="x")
    assert wingbeat.Scenario(turn, robot=wingbeat.shipped("robots/aerobat_beta.toml")).mass_kg > 0.0
    with pytest.raises(ValueError, match="period_s = 'a': allowed is a number"):
        wingbeat.fly(turn, {"flight.duration_s": 0.02}, controller=lambda t, seen: None, period_s="a")
    for name, given in {"period_s": 0.01, "sees": ["quat"]}.items():
        with pytest.raises(ValueError, match=f"^{name} = .*without a controller"):
            wingbeat.fly(turn, {"flight.duration_s": 0.02}, **{name: given})
    case = wingbeat.shipped("cases/flap_f1.toml")
    for name, given in {"at": [0.1], "cycles": 1, "model": True, "scenario": turn}.items():
        with pytest.raises(ValueError, match=f"^{name} = .*no Flight"):
            wingbeat.wake(case, **{name: given})
    with pytest.raises(ValueError, match="t = NaN: allowed is a finite number"):
        wingbeat.Scenario(turn).reference(float("nan"))
    with pytest.raises(ValueError, match="allowed are .*scenarios"):
        wingbeat.shipped("../x")
    with pytest.raises(ValueError, match="allowed are .*scenarios"):
        wingbeat.shipped("../numpy")


def test_the_overrides_of_a_scenario_are_nearer_than_those_of_its_robot(turn):
    robot = wingbeat.Robot(wingbeat.shipped("robots/aerobat_beta.toml"), {"body.mass_kg": 0.7})
    for given in (robot, wingbeat.Robot(robot.to_dict())):
        assert wingbeat.Scenario(turn, robot=given).to_dict()["robot"]["body"]["mass_kg"] == 0.7
        nearer = wingbeat.Scenario(turn, {"robot.body.mass_kg": 0.8}, robot=given)
        assert nearer.to_dict()["robot"]["body"]["mass_kg"] == 0.8


def test_the_record_has_what_sensors_read(turn):
    short = {"flight.duration_s": 0.05}
    assert not [name for name in wingbeat.fly(turn, short).record if name.startswith("reading_")]
    record = wingbeat.fly(turn, short | {"sensors.position_m": 0.001}).record
    assert [name for name in record if name.startswith("reading_")] == [f"reading_p_WB_{axis}" for axis in "xyz"]
    assert record.to_pandas().attrs["units"]["reading_p_WB_z"] == "m"


def test_an_override_takes_the_place_of_another_alternative():
    path = wingbeat.shipped("scenarios/path_figure8.toml")
    line = {"line": {"length_m": 12.0}}
    for given in ({"path": {"curve": line}}, {"path.curve": line}, {"path.curve.line.length_m": 12.0}):
        assert wingbeat.Scenario(path, given).to_dict()["path"]["curve"] == line
    both = {"path": {"curve": line | {"helix": {"radius_m": 5.0}}}}
    with pytest.raises(ValueError, match="allowed is one of line, .*, alone"):
        wingbeat.Scenario(path, both)


def test_records_are_equal_by_their_values(turn):
    short = {"flight.duration_s": 0.02}
    one, other = (wingbeat.fly(turn, short).record for _ in range(2))
    assert one == other and one is not other
    assert one != wingbeat.fly(turn, {"flight.duration_s": 0.03}).record
    assert one != {} and (one == 3) is False

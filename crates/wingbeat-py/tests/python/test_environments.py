"""Environments: Gymnasium's own check, and that they repeat whatever stands beside them."""

import tomllib
import warnings

import gymnasium as gym
import numpy as np
import pytest
from conftest import SHORT
from gymnasium.utils.env_checker import check_env

import wingbeat.learn

ID = "wingbeat/BankingTurn-v0"


def make(**keys):
    return gym.make(ID, overrides=SHORT, **keys)


def make_vec(count, **keys):
    return gym.make_vec(ID, num_envs=count, vectorization_mode="vector_entry_point", overrides=SHORT, **keys)


def actions(count, steps, seed=3):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, count, 8))


def test_gymnasium_finds_nothing_wrong():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make(render_mode="rgb_array").unwrapped)


def test_vectors_keep_to_their_spaces():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robots = make_vec(3)
        robots.action_space.seed(5)
        assert robots.single_action_space == make().action_space
        assert robots.action_space.dtype == np.float32
        seen, info = robots.reset(seed=7)
        assert seen in robots.observation_space and info == {}
        for _ in range(45):
            given = robots.action_space.sample()
            seen, rewards, terminated, truncated, info = robots.step(given)
            assert seen in robots.observation_space
            assert rewards.shape == terminated.shape == truncated.shape == (3,)
            assert rewards.dtype == np.float64 and terminated.dtype == truncated.dtype == np.bool_
            assert {terms.shape for terms in info["reward_terms"].values()} == {(3,)}
        robots.close()


def test_observations_are_described_and_within_their_limits():
    environment = make().unwrapped
    names = [column.name for column in environment.observation]
    assert names[:2] == ["roll", "pitch"]
    assert names.index("cos_phase") == 14
    assert environment.observation_space.shape == (len(names),) == (39,)
    assert [column.name for column in environment.action][:2] == ["command_shoulder_left", "command_shoulder_right"]
    seen, _ = environment.reset(seed=1, options={"spread": 0.0})
    asked = dict(zip(names, seen, strict=True))
    assert asked["pitch"] == asked["pitch_reference"] == pytest.approx(np.radians(-15.0))
    assert asked["v_WB_B_x"] == pytest.approx(1.5 * np.cos(np.radians(15.0)))


def test_rewards_are_the_sum_of_their_terms():
    environment = make()
    environment.reset(seed=2)
    _, reward, _, _, info = environment.step(np.full(8, 0.5))
    terms = info["reward_terms"]
    assert reward == sum(terms.values())
    assert terms["flown"] == 1.0
    limits = np.array([(column.low, column.high) for column in environment.unwrapped.action])
    half, middle = 0.5 * (limits[:, 1] - limits[:, 0]), limits.mean(axis=1)
    # As the predictive controller weighs inputs: over half of their ranges.
    weight = tomllib.loads(wingbeat.shipped(wingbeat.learn.BankingTurn.scenario).read_text())["controller"]["weights"]["input"]
    assert terms["input"] == pytest.approx(-np.sum((weight * (middle + 0.5 * half) / half) ** 2))


def test_an_episode_ends_in_either_way():
    environment = make()
    environment.reset(seed=2)
    for step in range(20):
        *_, terminated, truncated, _ = environment.step(np.zeros(8))
        assert not terminated
        assert truncated == (step == 19)
    rolled = {"start.roll_deg": 55.0, "flight.duration_s": 1.0}
    environment = gym.make(ID, overrides=rolled, spread=0.0)
    environment.reset(seed=2)
    hard = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    for _ in range(200):
        *_, terminated, truncated, _ = environment.step(hard)
        if terminated or truncated:
            break
    assert terminated
    assert not truncated


def test_seeds_repeat_and_differ():
    environment = make()
    first, again, other = (environment.reset(seed=seed)[0] for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    environment.reset(seed=5)
    following = environment.reset()[0]
    assert not np.array_equal(following, first)
    environment.reset(seed=5)
    assert np.array_equal(environment.reset()[0], following)


@pytest.mark.parametrize(
    ("count", "threads", "precision"),
    [(1, 1, "f64"), (3, 1, "f64"), (7, 2, "f64"), (7, 0, "f64"), (1, 1, "f32"), (9, 2, "f32")],
)
def test_a_robot_does_not_depend_on_its_neighbours(count, threads, precision):
    steps = 45
    given = actions(9, steps)[:, :count]
    vector = make_vec(count, threads=threads, precision=precision)
    seen = [vector.reset(seed=11)[0]]
    told = []
    for action in given:
        observation, reward, terminated, truncated, info = vector.step(action)
        seen.append(observation)
        told.append((reward, terminated, truncated, info["reward_terms"]["roll"]))
    for robot in range(count):
        single = make(precision=precision).unwrapped
        assert np.array_equal(single.reset(seed=11 + robot)[0], seen[0][robot])
        over = False
        for step in range(steps):
            if over:
                observation, reward, ended = single.reset()[0], 0.0, (False, False)
            else:
                observation, reward, *ended, _ = single.step(given[step, robot])
                ended = tuple(ended)
            over = any(ended)
            assert np.array_equal(observation, seen[step + 1][robot])
            assert reward == told[step][0][robot]
            assert ended == (told[step][1][robot], told[step][2][robot])


@pytest.mark.parametrize(("preset", "limit"), [("paper", 1e-4), ("full", 1e-3)])
def test_single_precision_is_near_double(preset, limit):
    """Roll, pitch (rad), rates (rad/s) and velocities (m/s) after .1 s; docs/python.md has those of a second."""
    vectors = [
        gym.make_vec(
            ID,
            num_envs=8,
            vectorization_mode="vector_entry_point",
            overrides=SHORT | {"aero.preset": preset},
            precision=precision,
        )
        for precision in ("f64", "f32")
    ]
    for vector in vectors:
        vector.reset(seed=1)
    for action in actions(8, 20):
        double, single = (vector.step(action)[0] for vector in vectors)
    apart = np.max(np.abs(double - single)[:, :8], axis=0)
    print(f"single precision, {preset}, .1 s: {apart.max():.1e}")
    assert np.all(apart < limit * np.array([1.0, 1.0, 60.0, 60.0, 60.0, 30.0, 30.0, 30.0]))
    assert apart.max() > 0.0


def test_nothing_handed_out_is_used_again():
    vector = make_vec(4)
    first, _ = vector.reset(seed=1)
    kept = first.copy()
    outcomes = [vector.step(action) for action in actions(4, 3)]
    assert np.array_equal(first, kept)
    arrays = [first] + [array for outcome in outcomes for array in outcome[:4]]
    assert not any(np.shares_memory(a, b) for i, a in enumerate(arrays) for b in arrays[:i])
    arrays[1][:] = 0.0
    vector.reset(seed=1)
    assert np.array_equal(vector.step(actions(4, 3)[0])[1], outcomes[0][1])


def test_a_flight_is_judged_by_the_same_reward(turn):
    environment = make(spread=0.0).unwrapped
    environment.reset(seed=1)
    held = np.full(8, 0.3)
    flown = [environment.step(held)[4]["reward_terms"] for _ in range(20)]
    inputs = [0.5 * (c.low + c.high) + 0.5 * (c.high - c.low) * 0.3 for c in environment.action]
    flight = wingbeat.fly(turn, SHORT | {"flight.step_s": 1e-3}, controller=lambda t, m: inputs)
    judged = environment.judge(flight)
    for name, terms in judged.items():
        assert terms == pytest.approx([step[name] for step in flown], abs=1e-12)
    for every in (2e-3, 1e-2):
        flight = wingbeat.fly(turn, SHORT | {"flight.record_every_s": every}, controller=lambda t, m: inputs)
        with pytest.raises(ValueError, match=r"flight.record_every_s = 0.0.*: allowed is 0.005 s over a whole number"):
            environment.judge(flight)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="render_mode = 'human': allowed is None, 'rgb_array'"):
        wingbeat.learn.Environment(wingbeat.learn.BankingTurn, render_mode="human")
    environment = make().unwrapped
    with pytest.raises(gym.error.ResetNeeded):
        environment.step(np.zeros(8))
    environment.reset(seed=1)
    with pytest.raises(ValueError, match=r"actions of the shape \(3,\): allowed is \(8,\)"):
        environment.step(np.zeros(3))
    with pytest.raises(ValueError, match=r"actions of the shape \(2, 4\): allowed is \(8,\)"):
        environment.step(np.zeros((2, 4)))
    robots = make_vec(2)
    assert np.array_equal(robots.reset(seed=np.int64(3))[0], make_vec(2).reset(seed=3)[0])
    for given in [(8, 2), (4, 4), (1, 16), (16,)]:
        with pytest.raises(ValueError, match=r"allowed is \(2, 8\)"):
            robots.step(np.zeros(given))
    with pytest.raises(ValueError, match="seed = -1: allowed is 0 or more"):
        robots.reset(seed=[-1, 2])
    with pytest.raises(ValueError, match=r"actions\[0\]\[2\] = NaN: allowed is a finite number"):
        environment.step(np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0, 0.0, 0.0]))
    with pytest.raises(ValueError, match="allowed is spread"):
        environment.reset(options={"phase": 1.0})
    with pytest.raises(ValueError, match="spread = -1"):
        environment.reset(options={"spread": -1.0})
    with pytest.raises(ValueError, match="precision = f16: allowed is f64, f32"):
        make(precision="f16")
    for count in (0, -1):
        with pytest.raises(ValueError, match=f"count = {count}: allowed is"):
            wingbeat.learn.VectorEnvironment(count, task=wingbeat.learn.BankingTurn)
    with pytest.raises(ValueError, match="threads = -1: allowed is"):
        make_vec(1, threads=-1)
    with pytest.raises(ValueError, match="manoeuvre"):
        gym.make(ID, scenario=wingbeat.shipped("scenarios/glide.toml"))


def test_pictures_need_no_display():
    environment = make(render_mode="rgb_array")
    environment.reset(seed=4)
    picture = environment.render()
    assert picture.shape == (360, 640, 3)
    assert picture.dtype == np.uint8
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    # Left is blue and right orange: from behind each on its side.
    left, right = picture[:, :160].astype(int), picture[:, 160:320].astype(int)
    blue, orange = (lambda half: (half[..., 2] - half[..., 0] > 60).sum()), (lambda half: (half[..., 0] - half[..., 2] > 60).sum())
    assert blue(left) > 5 * blue(right) and orange(right) > 5 * orange(left)
    before = picture
    for _ in range(4):
        environment.step(environment.action_space.sample())
    assert (environment.render() != before).any()

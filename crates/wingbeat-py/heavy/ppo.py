"""Checks the environment by Stable-Baselines3, trains its PPO and puts it beside the predictive controller.

    python ppo.py STEPS [SEED...]
"""

import sys
import time
import warnings

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env

import wingbeat
import wingbeat.learn

ID = "wingbeat/BankingTurn-v0"
TURN = wingbeat.shipped("scenarios/banking_turn.toml")


OTHERS = range(1000, 1020)
# Steps of an episode of 5 s.
WHOLE = 1000


def episode(policy, spread, seed):
    """Reward of an episode under a policy, and its length."""
    environment = gym.make(ID, spread=spread)
    seen, _ = environment.reset(seed=seed)
    total, steps, over = 0.0, 0, False
    while not over:
        action, _ = policy.predict(seen, deterministic=True)
        seen, reward, terminated, truncated, _ = environment.step(action)
        total, steps, over = total + reward, steps + 1, terminated or truncated
    return total, steps


class AtRest:
    """Leaves every regulator in the middle of its range."""

    def predict(self, seen, deterministic):
        return np.zeros(8), None


def start(spread, seed):
    """Keys of the scenario for the start that a seed gives."""
    environment = gym.make(ID, spread=spread).unwrapped
    seen, _ = environment.reset(seed=seed)
    x = environment._flock.native.save()[0][0][0]
    names = [column.name for column in environment._flock.states]
    part = lambda stem, parts: [float(x[names.index(f"{stem}_{part}")]) for part in parts]
    w, i, j, k = part("quat", "wxyz")
    seen = dict(zip([column.name for column in environment.observation], seen, strict=True))
    return {
        "start.roll_deg": np.degrees(np.arctan2(2 * (w * i + j * k), 1 - 2 * (i * i + j * j))),
        "start.nose_up_deg": -np.degrees(np.arcsin(2 * (w * j - k * i))),
        "start.yaw_deg": np.degrees(np.arctan2(2 * (w * k + i * j), 1 - 2 * (j * j + k * k))),
        "start.velocity_m_s": part("v_WB_W", "xyz"),
        "start.rate_rad_s": part("w_WB_B", "xyz"),
        "start.phase_rad": np.arctan2(seen["sin_phase"], seen["cos_phase"]),
    }


def predictive(spread, seed):
    """The same under the scenario's predictive controller."""
    terms = gym.make(ID).unwrapped.judge(wingbeat.fly(TURN, start(spread, seed) if spread > 0 else None))
    rewards = np.sum(list(terms.values()), axis=0)
    return rewards.sum(), len(rewards)


def row(name, seed, steps, run):
    """A row of the table: from the scenario's start, and from twenty others."""
    total, length = run(0.0, 0)
    others = [run(1.0, number) for number in OTHERS]
    rewards, lengths = zip(*others, strict=True)
    whole = sum(flown == WHOLE for flown in lengths)
    print(
        f"| {name} | {seed} | {steps} | {total:.1f} | {length} | {np.mean(rewards):.1f} ({min(rewards):.1f} to "
        f"{max(rewards):.1f}) | {whole} |",
        flush=True,
    )
    return total, np.mean(rewards)


def main(steps, seeds):
    """Prints a row for the predictive controller, one for regulators at rest, and one for each seed."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gym.make(ID).unwrapped)
    print("Stable-Baselines3 finds nothing wrong, and warns of nothing")
    torch.set_num_threads(1)
    print("| controller | seed | steps trained | reward from the scenario's start | steps flown | from 20 other starts, mean (least to most) | whole of 20 |")
    print("|---|---|---:|---:|---:|---:|---:|")
    row("predictive", "", "", predictive)
    row("at rest", "", "", lambda spread, seed: episode(AtRest(), spread, seed))
    found, begun = [], time.process_time()
    for seed in seeds:
        robots = make_vec_env(ID, n_envs=8, seed=seed)
        policy = PPO("MlpPolicy", robots, seed=seed, n_steps=256, batch_size=256, gamma=0.99, ent_coef=0.0, device="cpu")
        policy.learn(steps)
        found.append(row("PPO", seed, steps, lambda spread, start, policy=policy: episode(policy, spread, start)))
    mean, deviation = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) if len(found) > 1 else (np.nan, np.nan)
    print(
        f"PPO over {len(found)} seeds: {mean[0]:.1f} +- {deviation[0]:.1f} from the scenario's start, {mean[1]:.1f} +- "
        f"{deviation[1]:.1f} from the others (mean and standard deviation); {(time.process_time() - begun) / len(found):.0f} s "
        "of the processor a seed"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]), [int(seed) for seed in sys.argv[2:]] or [0, 1, 2])

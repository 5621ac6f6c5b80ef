"""Checks the environment by Stable-Baselines3, trains its PPO and puts it beside the predictive controller.

    python ppo.py STEPS [SEED...]
"""

import sys

import gymnasium as gym
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env

import wingbeat
import wingbeat.learn

ID = "wingbeat/BankingTurn-v0"
TURN = wingbeat.shipped("scenarios/banking_turn.toml")


def flown(policy, spread, seed):
    """Reward of an episode, its length and its largest errors after 2 s."""
    environment = gym.make(ID, spread=spread)
    seen, _ = environment.reset(seed=seed)
    total, steps, over = 0.0, 0, False
    while not over:
        action, _ = policy.predict(seen, deterministic=True)
        seen, reward, terminated, truncated, _ = environment.step(action)
        total, steps, over = total + reward, steps + 1, terminated or truncated
    return total, steps


def main(steps, seeds):
    """Prints a row for the predictive controller and one for each seed."""
    check_env(gym.make(ID).unwrapped)
    print("Stable-Baselines3 finds nothing wrong")
    terms = gym.make(ID).unwrapped.judge(wingbeat.fly(TURN))
    rewards = np.sum(list(terms.values()), axis=0)
    print("| controller | seed | steps trained | reward from the scenario's start | steps flown | reward from 20 other starts, mean (least to most) |")
    print("|---|---|---:|---:|---:|---:|")
    print(f"| predictive | | | {rewards.sum():.1f} | {len(rewards)} | |")
    for seed in seeds:
        robots = make_vec_env(ID, n_envs=8, seed=seed)
        policy = PPO("MlpPolicy", robots, seed=seed, n_steps=256, batch_size=256, gamma=0.99, ent_coef=0.0, device="cpu")
        policy.learn(steps)
        total, length = flown(policy, 0.0, 0)
        others = [flown(policy, 1.0, 1000 + number)[0] for number in range(20)]
        print(
            f"| PPO | {seed} | {steps} | {total:.1f} | {length} | "
            f"{np.mean(others):.1f} ({min(others):.1f} to {max(others):.1f}) |",
            flush=True,
        )


if __name__ == "__main__":
    main(int(sys.argv[1]), [int(seed) for seed in sys.argv[2:]] or [0, 1, 2])

"""Processor time of environment steps of 5 ms beside MuJoCo's steps of the same tree without air, in turns.

    python steps.py FOLDER

FOLDER holds the reference tree and its accelerations. Prints rows as JSON: what, microseconds (median, least, most).
"""

import json
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import gymnasium as gym
import mujoco
import mujoco.rollout
import numpy as np

import wingbeat
import wingbeat.learn

ROBOTS = 32
STEPS = 8
ROUNDS = 41
TURN = wingbeat.shipped("scenarios/banking_turn.toml")


def clock_ghz():
    """Clock of the processor as the system states it."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    found = [float(line.split(":")[1]) for line in lines if line.startswith("cpu MHz")]
    return float(np.median(found)) * 1e-3 if found else float("nan")


def tree(urdf):
    """The tree of a URDF, its base free, as the model of MuJoCo: fourth-order steps of 1 ms, nothing touches; gravity is that of
    the reference."""
    root = ElementTree.parse(urdf).getroot()
    links = {link.get("name"): link for link in root.iter("link")}
    joints = list(root.iter("joint"))

    def body(name, joint):
        inertial = links[name].find("inertial")
        about = inertial.find("inertia").attrib
        axes = [about[key] for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]
        turns = "<freejoint/>"
        place = "0 0 0"
        if joint is not None:
            place = joint.find("origin").get("xyz")
            turns = f'<joint name="{joint.get("name")}" type="hinge" axis="{joint.find("axis").get("xyz")}"/>'
        inside = "".join(body(j.find("child").get("link"), j) for j in joints if j.find("parent").get("link") == name)
        return (
            f'<body name="{name}" pos="{place}">{turns}<inertial pos="{inertial.find("origin").get("xyz")}" '
            f'mass="{inertial.find("mass").get("value")}" fullinertia="{" ".join(axes)}"/>{inside}</body>'
        )

    return mujoco.MjModel.from_xml_string(
        '<mujoco><option timestep="0.001" integrator="RK4" gravity="0 0 -9.81"><flag contact="disable" '
        f'constraint="disable"/></option><worldbody>{body("body", None)}</worldbody></mujoco>'
    )


def same(model, folder):
    """Largest difference of the accelerations from those of the reference, relative to the largest of them."""
    q, v, tau, wanted = (np.loadtxt(folder / f"ref_{name}.txt") for name in ("q", "v", "tau", "qdd_pin_local"))
    data = mujoco.MjData(model)
    # The reference has the quaternion x, y, z, w, velocities in the body's axes, joints by name.
    data.qpos[:3], data.qpos[3:7] = q[:3], q[[6, 3, 4, 5]]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, data.qpos[3:7])
    turn = turn.reshape(3, 3)
    names = sorted(["sh_l", "el_l", "sh_r", "el_r"], key=lambda name: model.joint(name).id)
    order = ["sh_l", "el_l", "sh_r", "el_r"]
    at = [order.index(name) for name in names]
    data.qpos[7:] = q[7:][at]
    data.qvel[:3], data.qvel[3:6], data.qvel[6:] = turn @ v[:3], v[3:6], v[6:][at]
    data.qfrc_applied[:3], data.qfrc_applied[3:6], data.qfrc_applied[6:] = turn @ tau[:3], tau[3:6], tau[6:][at]
    mujoco.mj_forward(model, data)
    linear = turn.T @ data.qacc[:3] - np.cross(v[3:6], v[:3])
    found = np.concatenate([linear, data.qacc[3:6], data.qacc[6:]])
    wanted = np.concatenate([wanted[:6], wanted[6:][at]])
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def environments():
    """What takes the steps of all robots, by name."""
    ways = {}
    for preset, size, strips in (("paper", "aero.paper.nodes", 12), ("full", "aero.full.strips", 9)):
        for precision in ("f64", "f32"):
            robots = gym.make_vec(
                "wingbeat/BankingTurn-v0",
                num_envs=ROBOTS,
                vectorization_mode="vector_entry_point",
                overrides={"aero.preset": preset, size: strips},
                threads=1,
                precision=precision,
            )
            robots.reset(seed=1)
            actions = np.zeros((ROBOTS, 8))
            ways[f"environment, {preset} {strips}, {precision}"] = (
                lambda robots=robots, actions=actions: [robots.step(actions) for _ in range(STEPS)]
            )
    return ways


def main(folder):
    model = tree(folder / "aerobat10.urdf")
    ways = environments()
    data = mujoco.MjData(model)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.zeros(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, start, full)
    start[-model.nv :] = np.random.default_rng(1).uniform(-1.0, 1.0, model.nv)
    states = np.repeat(start[None], ROBOTS, axis=0)
    ways["MuJoCo, 5 steps of the tree without air"] = lambda: [
        mujoco.rollout.rollout(model, data, states, nstep=5) for _ in range(STEPS)
    ]
    times = {way: [] for way in ways}
    for _ in range(ROUNDS + 1):
        for way, work in ways.items():
            begun = time.process_time()
            work()
            times[way].append((time.process_time() - begun) / (ROBOTS * STEPS))
    rows = {way: [1e6 * f(seen[1:]) for f in (np.median, min, max)] for way, seen in times.items()}
    print(json.dumps({"rows": rows, "clock_ghz": clock_ghz(), "difference": same(model, folder)}))


main(Path(sys.argv[1]))

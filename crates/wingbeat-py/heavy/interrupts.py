"""Ctrl-C in every call of the package that lasts."""

import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Time in which a call must answer, and after which it hangs, s.
ANSWER, HANGS = 1.0, 120.0

# Calls that last, each with what is interrupted.
LONG = {
    "fly": "wingbeat.fly(s('banking_turn'), {'flight.duration_s': 100.0, 'flight.record_every_s': 0.1})",
    "fly_controller": "wingbeat.fly(s('glide'), {'flight.duration_s': 100.0, 'flight.record_every_s': 0.1}, controller=lambda t, told: None)",
    "trim": "wingbeat.trim(s('hover'), {'aero.law': 'lev'})",
    "search": "wingbeat.trim(s('gait_search_beta'))",
    "plan": "wingbeat.plan(s('paper_plan'))",
    "gait": "wingbeat.plan(s('least_power_gait'))",
    "roll_in": "wingbeat.plan(s('roll_in'))",
    "sweep": "wingbeat.sweep(dict(lot, runs=100000), out=out)",
    "calibrate": "wingbeat.calibrate(f('calibrations/seven_runs.toml'))",
    "information": "wingbeat.calibrate(f('calibrations/seven_runs.toml'), information=True)",
    "wake": "wingbeat.wake(f('cases/flap_f1.toml'), chordwise=8, spanwise=40, steps=400)",
    "wake_flight": "wingbeat.wake(wingbeat.fly(s('banking_turn'), {'flight.duration_s': 1.5}), scenario=s('banking_turn'), steps=200, spanwise=40)",
    "tether": "wingbeat.tether(f('cases/step.toml'), {'time.steps_per_cycle': 120000})",
    "converge": "wingbeat.tether(f('cases/flap_f1.toml'), {'time.steps_per_cycle': 4000}, converge=True)",
    "rig": "wingbeat.rig(f('rigs/seven_runs.toml'))",
    "step": "wingbeat.Stepper(s('banking_turn')).step(1e-4, 10**9)",
    "vector": "v = learn.VectorEnvironment(20000, task=learn.BankingTurn, threads=1); v.reset(seed=1)\n"
              "while True: v.step(np.zeros((20000, v.single_action_space.shape[0])))",
    "make_vector": "[learn.VectorEnvironment(2**16, task=learn.BankingTurn).reset(seed=k) for k in range(1000)]",
    "lattice": "wingbeat.fly(s('glider'), {'lattice.step_s': 2e-3, 'lattice.longest_age_s': 0.4, 'flight.duration_s': 20.0})",
}

PROLOGUE = """
import os, signal, sys, threading, time, warnings
import numpy as np
import wingbeat
from wingbeat import learn
warnings.simplefilter("ignore")
# What a shell puts into the background ignores Ctrl-C, and so do its children.
signal.signal(signal.SIGINT, signal.default_int_handler)
f = wingbeat.shipped
s = lambda name: f(f"scenarios/{name}.toml")
out = sys.argv[1]
lot = {"name": "long", "scenario": str(s("banking_turn")), "sampling": "random", "runs": 20,
       "draws": [{"key": "air.gust_m_s", "low": 0.0, "high": 0.5}], "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0}}
print("ready", flush=True)
try:
    exec(sys.argv[2])
    print("ended", time.time(), flush=True)
except KeyboardInterrupt as raised:
    now = time.time()
    plan = getattr(raised, "plan", None)
    print("interrupted", now, "-" if plan is None else plan.status, flush=True)
except BaseException as raised:
    print("raised", time.time(), type(raised).__name__, str(raised)[:200].replace(chr(10), " "), flush=True)
os._exit(0)
"""


def interrupts(seed, times=(0.4, 1.1, 2.3)):
    """Sends Ctrl-C to each call that lasts; true when each answers in time."""
    good = True
    rng = random.Random(seed)
    for name, code in LONG.items():
        answers, kept = [], ""
        for after in times:
            with tempfile.TemporaryDirectory() as folder:
                words = [sys.executable, "-c", PROLOGUE, str(Path(folder) / "out"), code]
                with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
                    child.stdout.readline()
                    time.sleep(after * rng.uniform(0.7, 1.3))
                    sent = time.time()
                    child.send_signal(signal.SIGINT)
                    try:
                        said, errors = child.communicate(timeout=HANGS)
                    except subprocess.TimeoutExpired:
                        child.kill()
                        said, errors = "", "hung"
            word, *rest = (said.splitlines() or ["nothing"])[-1].split(maxsplit=2)
            late = float(rest[0]) - sent if rest else float("inf")
            kept = rest[1] if len(rest) > 1 else kept
            fine = word == "interrupted" and late < ANSWER and "panicked" not in errors
            answers.append(f"{late:.3f}" if word == "interrupted" else f"{word} {' '.join(rest[1:])}{errors[-200:]}")
            # What had ended before is no answer.
            good &= fine or (word == "ended" and late < 0)
        print(f"{name:<16}{'  '.join(answers)}  {kept}", flush=True)
    return good

"""Simulation, calibration and control of bat-like, morphing-wing flapping flight.

>>> import wingbeat
>>> flight = wingbeat.fly(wingbeat.shipped("scenarios/banking_turn.toml"), {"flight.duration_s": 0.2})
>>> flight.status
'not_judged'

SI units throughout; body axes x forward, y left, z up, the world's z up: negative pitch is nose up.
"""

from wingbeat._documents import Robot, Scenario, shipped
from wingbeat._record import Column, Record, Strips
from wingbeat._runs import (
    Bench,
    Controller,
    Flight,
    Moved,
    Plan,
    Processed,
    fly,
    plan,
    process,
    rig,
    tether,
)
from wingbeat._stepper import Stepper
from wingbeat._sweeps import sweep
from wingbeat._wingbeat import Measurement

__all__ = [
    "Bench",
    "Column",
    "Controller",
    "Flight",
    "Measurement",
    "Moved",
    "Plan",
    "Processed",
    "Record",
    "Robot",
    "Scenario",
    "Stepper",
    "Strips",
    "fly",
    "plan",
    "process",
    "rig",
    "shipped",
    "sweep",
    "tether",
]

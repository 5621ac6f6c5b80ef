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
    Calibrated,
    Controller,
    Flight,
    Moved,
    Plan,
    Processed,
    Stretch,
    Trimmed,
    Wake,
    calibrate,
    fly,
    plan,
    process,
    rig,
    tether,
    trim,
    wake,
)
from wingbeat._stepper import Stepper
from wingbeat._sweeps import sweep
from wingbeat._verdicts import ResultWarning
from wingbeat._wingbeat import Measurement, __version__

__all__ = [
    "Bench",
    "Calibrated",
    "Column",
    "Controller",
    "Flight",
    "Measurement",
    "Moved",
    "Plan",
    "Processed",
    "Record",
    "ResultWarning",
    "Robot",
    "Scenario",
    "Stepper",
    "Stretch",
    "Strips",
    "Trimmed",
    "Wake",
    "__version__",
    "calibrate",
    "fly",
    "plan",
    "process",
    "rig",
    "shipped",
    "sweep",
    "tether",
    "trim",
    "wake",
]

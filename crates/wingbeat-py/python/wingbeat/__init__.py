"""Simulation, calibration and control of bat-like, morphing-wing flapping flight.

>>> import wingbeat
>>> flight = wingbeat.fly(wingbeat.shipped("scenarios/banking_turn.toml"), {"flight.duration_s": 0.2})
>>> flight.status
'not_judged'

SI units throughout; body axes x forward, y left, z up, the world's z up. Records have the pitch of these axes: negative is nose
up. Documents give ``nose_up_deg``.
"""

from collections.abc import Mapping

from wingbeat._documents import Robot, Scenario, shipped
from wingbeat._paper import Paper, paper
from wingbeat._program import Averaged, Picture, RigPlan, average, rig_plan, show, validate
from wingbeat._record import Column, Record, Strips
from wingbeat._runs import (
    Bench,
    Calibrated,
    Controller,
    Flight,
    Moved,
    Plan,
    Processed,
    ProcessedRuns,
    Stretch,
    Trimmed,
    Wake,
    calibrate,
    fly,
    plan,
    process,
    process_all,
    rig,
    tether,
    trim,
    wake,
)
from wingbeat._stepper import Stepper
from wingbeat._sweeps import sweep
from wingbeat._verdicts import ResultWarning
from wingbeat._views import View
from wingbeat._wingbeat import Measurement, __version__

# What a controller sees is a mapping.
Mapping.register(Measurement)

__all__ = [
    "Averaged",
    "Bench",
    "Calibrated",
    "Column",
    "Controller",
    "Flight",
    "Measurement",
    "Moved",
    "Paper",
    "Picture",
    "Plan",
    "Processed",
    "ProcessedRuns",
    "Record",
    "ResultWarning",
    "RigPlan",
    "Robot",
    "Scenario",
    "Stepper",
    "Stretch",
    "Strips",
    "Trimmed",
    "View",
    "Wake",
    "__version__",
    "average",
    "calibrate",
    "fly",
    "paper",
    "plan",
    "process",
    "process_all",
    "rig",
    "rig_plan",
    "shipped",
    "show",
    "sweep",
    "tether",
    "trim",
    "validate",
    "wake",
]

"""A controller of one's own: raises the lower wing's stroke with roll and roll rate."""

import math

import numpy as np
from numpy.typing import NDArray

import wingbeat


class Leveller:
    """Proportional and derivative control of roll by the shoulders."""

    def __init__(self, scenario: wingbeat.Scenario) -> None:
        names = [channel.name for channel in scenario.inputs]
        self.inputs = np.zeros(len(names))
        self.left = names.index("command_shoulder_left")
        self.right = names.index("command_shoulder_right")

    def update(self, t: float, measurement: wingbeat.Measurement) -> NDArray[np.float64]:
        """The inputs that hold until the next update."""
        w, x, y, z = (measurement[f"quat_{axis}"] for axis in "wxyz")
        roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        stroke = 0.5 * roll + 0.02 * measurement["w_WB_B_x"]
        self.inputs[self.left], self.inputs[self.right] = -stroke, stroke
        return self.inputs


scenario = wingbeat.Scenario(wingbeat.shipped("scenarios/banking_turn.toml"), {"flight.duration_s": 0.5})
flight = wingbeat.fly(scenario, controller=Leveller(scenario), sees=["quat", "w_WB_B"])
roll = np.degrees(flight.record["roll"])
print(f"roll {roll.min():.2f} to {roll.max():.2f} deg under {flight.summary['controller']['updates']} updates")

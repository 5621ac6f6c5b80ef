"""A wing of one's own in a wind: loads over a cycle and along the span."""

import numpy as np

import wingbeat

edge = {"leading_edge_m": 0.025, "trailing_edge_m": -0.075}
case = {
    "name": "plate",
    "wing": {"planform": [{"arc_m": 0.0, **edge}, {"arc_m": 0.4, **edge}]},
    "body": {"heave_m": {"fourier": {"cos": [0.02]}}},
    "wind": {"speed_m_s": 3.0, "density_kg_m3": 1.225},
    "time": {"frequency_hz": 2.0, "cycles": 4, "steps_per_cycle": 100},
}
moved = wingbeat.tether(case, {"aero.law": "linear"})
lift = moved.strips["force_z"]
print(moved.status, f"peak lift {moved.record['force_wind_lift'].max():.4f} N")
print("mean lift by strip [mN]:", np.round(1e3 * lift[-100:].mean(axis=0), 3))

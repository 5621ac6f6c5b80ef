"""A robot as a picture, drawn without a display."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

# Half of what is shown, m.
HALF = 0.25
SURFACES = ("#4477aa", "#cc6677", "#ddcc77", "#117733")


def axes_of(quaternion: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, float]:
    """Rotation from body to heading axes (x forward and level, y left, z up), roll and pitch."""
    w, x, y, z = quaternion
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    heading = np.array([[np.cos(yaw), np.sin(yaw), 0.0], [-np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    pitch = np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0]))
    return heading, float(roll), float(pitch)


def picture(
    t: float, state: NDArray[np.float64], outlines: Sequence[Sequence[Sequence[Sequence[float]]]]
) -> NDArray[np.uint8]:
    """The robot from behind and from its right side, beside level lines."""
    place = state[:3]
    heading, roll, pitch = axes_of(state[3:7])
    figure = Figure(figsize=(6.4, 3.6), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    # From behind left is left; from the right side forward is right.
    for panel, (title, across) in zip(
        figure.subplots(1, 2), (("from behind", (1, -1.0)), ("from the right", (0, 1.0))), strict=True
    ):
        for number, outline in enumerate(outlines):
            points = (np.asarray(outline) - place) @ heading.T
            for left, right in zip(points[:-1], points[1:], strict=True):
                panels = np.array([left[1], right[1], right[2], left[2]])
                flat = across[1] * panels[:, across[0]]
                colour = SURFACES[number % len(SURFACES)]
                panel.fill(flat, panels[:, 2], facecolor=colour, edgecolor="black", alpha=0.6, linewidth=0.8)
        panel.plot([0.0], [0.0], "o", color="black", markersize=4)
        panel.axhline(0.0, color="0.7", linewidth=0.8, zorder=0)
        panel.set(title=title, xlim=(-HALF, HALF), ylim=(-HALF, HALF), aspect="equal", xlabel="[m]")
    x, y, z = place
    figure.suptitle(
        f"{t:.3f} s   roll {np.degrees(roll):.1f}, pitch {np.degrees(pitch):.1f} deg (negative is nose up)   "
        f"at ({x:.2f}, {y:.2f}, {z:.2f}) m",
        fontsize="small",
    )
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3].copy()

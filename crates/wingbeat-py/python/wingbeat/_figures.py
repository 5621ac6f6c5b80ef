"""Figures of records, drawn without a display."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wingbeat._extras import needed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wingbeat._record import Column, Record

# Body axes x, y, z in a picture of a path.
AXES = ("C3", "C2", "C0")
# What a flight shows where nothing is chosen.
FLIGHT = ("roll", "roll_reference", "pitch", "pitch_reference", "yaw", "p_WB_x", "p_WB_y", "p_WB_z")
# What a tethered wing shows.
TETHER = ("force_wind_lift", "force_wind_drag", "power")
MARKS = ("o", "s", "^", "x")
DASHES = ("-", "--", "-.", ":")


def chosen(record: Record, names: str | Sequence[str] | None) -> list[Column]:
    """The columns to be drawn: a name, or the beginning of several."""
    known = {column.name: column for column in record.columns}
    if names is None:
        tethered = TETHER[0] in known
        own = [known[name] for name in (TETHER if tethered else FLIGHT) if name in known]
        own += [column for name, column in known.items() if name.startswith("hinge_" if tethered else "command_")]
        return own or [column for name, column in known.items() if name not in ("t", "phase", "run")]
    found: list[Column] = []
    for name in [names] if isinstance(names, str) else names:
        own = [known[name]] if name in known else [c for n, c in known.items() if n.startswith(name)]
        if not own:
            raise ValueError(f"{name}: allowed are {', '.join(known)}")
        found += [column for column in own if column not in found]
    return found


def columns(record: Record, names: str | Sequence[str] | None, against: str | None) -> Figure:
    """One panel per unit, commands apart; angles in degrees."""
    if against is None:
        against = next((name for name in ("t", "phase") if name in record), next(iter(record)))
    drawn = chosen(record, names)
    # Runs that do not rise in what they are drawn over are no curve: those of a grid, or of draws.
    ordered = "run" not in record or bool(np.all(np.diff(record[against]) > 0.0))
    panel_of = {column.name: (column.unit, column.name.startswith("command_")) for column in drawn}
    kinds = list(dict.fromkeys(panel_of.values()))
    unit_of = {column.name: column.unit for column in record.columns}
    figure: Figure = needed("matplotlib.figure", "figures").Figure(figsize=(9.0, 0.8 + 2.4 * len(kinds)), layout="constrained")
    panels = figure.subplots(len(kinds), 1, sharex=True, squeeze=False)[:, 0]
    for panel, kind in zip(panels, kinds, strict=True):
        scale, shown = (np.degrees(1.0), "deg") if kind[0] == "rad" else (1.0, kind[0])
        own = [column for column in drawn if panel_of[column.name] == kind]
        for number, column in enumerate(own):
            style = {"color": f"C{number % 10}", "linestyle": DASHES[number // 10 % len(DASHES)]}
            if ordered:
                panel.plot(record[against], scale * record[column.name], label=column.name, linewidth=1.2, **style)
            else:
                mark = {"color": style["color"], "linestyle": "", "marker": MARKS[number // 10 % len(MARKS)]}
                panel.plot(record[against], scale * record[column.name], label=column.name, markersize=4.0, **mark)
        for limit in sorted({limit for c in own for limit in (c.low, c.high) if np.isfinite(limit)}):
            panel.axhline(scale * limit, color="0.6", linewidth=0.8, linestyle=(0, (4, 3)))
        panel.set_ylabel(f"[{shown}]" if shown else "[-]")
        panel.grid(alpha=0.3)
        panel.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    panels[-1].set_xlabel(f"{against} [{unit_of[against] or '-'}]")
    return figure


def path(record: Record, frames: int) -> Figure:
    """The path of the body in space, with the body axes at ``frames`` instants, evenly spaced in time."""
    for name in ("p_WB_x", "p_WB_y", "p_WB_z"):
        if name not in record:
            raise ValueError(f"{name} is missing: allowed is the record of a flight")
    if frames < 0:
        raise ValueError(f"frames = {frames}: allowed is 0 or more")
    figure: Figure = needed("matplotlib.figure", "figures").Figure(figsize=(8.0, 7.0), layout="constrained")
    axes: Any = figure.add_subplot(projection="3d")
    place = record.to_numpy(["p_WB_x", "p_WB_y", "p_WB_z"])
    axes.plot(*place.T, color="0.3", linewidth=1.2)
    finite = place[np.isfinite(place).all(axis=1)]
    if len(finite) == 0:
        raise ValueError("the record holds no finite place")
    reach = max(float(np.ptp(finite, axis=0).max()), 1e-6)
    quat = ("quat_w", "quat_x", "quat_y", "quat_z")
    if frames and all(name in record for name in quat):
        rows = np.unique(np.linspace(0, len(place) - 1, frames).astype(int))
        w, x, y, z = (record[name][rows] for name in quat)
        # Columns of the rotation from body to world: the body axes in the world.
        turned = (
            (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
            (2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
            (2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)),
        )
        for colour, label, axis in zip(AXES, ("x, forward", "y, left", "z, up"), turned, strict=True):
            ends = place[rows] + 0.08 * reach * np.stack(axis, axis=-1)
            for number, (start, end) in enumerate(zip(place[rows], ends, strict=True)):
                axes.plot(*np.stack([start, end]).T, color=colour, linewidth=1.5, label=None if number else label)
        axes.legend(fontsize="small")
    # One scale for all three axes.
    middle = 0.5 * (finite.min(axis=0) + finite.max(axis=0))
    for name, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{name}lim")(centre - 0.55 * reach, centre + 0.55 * reach)
        getattr(axes, f"set_{name}label")(f"{name} [m]")
    axes.set_box_aspect((1, 1, 1))
    return figure

"""Figures of records, drawn without a display."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from wingbeat._record import Column, Record

# What a flight shows where nothing is chosen.
FLIGHT = ("roll", "roll_reference", "pitch", "pitch_reference", "yaw", "p_WB_x", "p_WB_y", "p_WB_z")
DASHES = ("-", "--", "-.", ":")


def chosen(record: Record, names: str | Sequence[str] | None) -> list[Column]:
    """The columns to be drawn: a name, or the beginning of several."""
    known = {column.name: column for column in record.columns}
    if names is None:
        flight = [known[name] for name in FLIGHT if name in known]
        commands = [column for name, column in known.items() if name.startswith("command_")]
        return flight + commands or [column for name, column in known.items() if name not in ("t", "phase")]
    found: list[Column] = []
    for name in [names] if isinstance(names, str) else names:
        own = [known[name]] if name in known else [c for n, c in known.items() if n.startswith(name)]
        if not own:
            raise ValueError(f"{name}: allowed are {', '.join(known)}")
        found += [column for column in own if column not in found]
    return found


def columns(record: Record, names: str | Sequence[str] | None, against: str) -> Figure:
    """One panel per unit, commands apart; angles in degrees."""
    drawn = chosen(record, names)
    panel_of = {column.name: (column.unit, column.name.startswith("command_")) for column in drawn}
    kinds = list(dict.fromkeys(panel_of.values()))
    unit_of = {column.name: column.unit for column in record.columns}
    figure = Figure(figsize=(9.0, 0.8 + 2.4 * len(kinds)), layout="constrained")
    panels = figure.subplots(len(kinds), 1, sharex=True, squeeze=False)[:, 0]
    for panel, kind in zip(panels, kinds, strict=True):
        scale, shown = (np.degrees(1.0), "deg") if kind[0] == "rad" else (1.0, kind[0])
        own = [column for column in drawn if panel_of[column.name] == kind]
        for number, column in enumerate(own):
            style = {"color": f"C{number % 10}", "linestyle": DASHES[number // 10 % len(DASHES)]}
            panel.plot(record[against], scale * record[column.name], label=column.name, linewidth=1.2, **style)
        for limit in sorted({limit for c in own for limit in (c.low, c.high) if np.isfinite(limit)}):
            panel.axhline(scale * limit, color="0.6", linewidth=0.8, linestyle=(0, (4, 3)))
        panel.set_ylabel(f"[{shown}]" if shown else "[-]")
        panel.grid(alpha=0.3)
        panel.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    panels[-1].set_xlabel(f"{against} [{unit_of[against] or '-'}]")
    return figure

"""Results as notebooks show them."""

from __future__ import annotations

from typing import Any

# Numbers of a summary that are worth a line, where they are there.
SHOWN = (
    "reason",
    "roll_mean_deg",
    "pitch_mean_deg",
    "altitude_change_m",
    "mean_speed_m_s",
    "frequency_hz",
    "power_w_kg",
    "mean_power_w",
    "largest_multiplier",
    "least_clearance_m",
    "chi_squared",
)


def table(kind: str, summary: dict[str, Any]) -> str:
    """Status, warnings and a few numbers."""
    from html import escape

    rows = [("status", summary.get("status", "-"))]
    rows += [(name, summary[name]) for name in SHOWN if isinstance(summary.get(name), (str, int, float))]
    for warning in summary.get("warnings") or []:
        rows.append(("warning", warning["text"] if isinstance(warning, dict) else warning))
    cells = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'>{escape(f'{value:.5g}' if isinstance(value, float) else str(value))}</td></tr>"
        for name, value in rows
    )
    return f"<table><caption>{escape(kind)}</caption>{cells}</table>"


def picture(figure: Any) -> str:
    """A figure of Matplotlib inside a page."""
    import base64
    import io

    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=80)
    return f"<img alt='time histories' src='data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}'>"


def text(words: str) -> str:
    """A text as it is printed."""
    from html import escape

    return f"<pre>{escape(words)}</pre>"

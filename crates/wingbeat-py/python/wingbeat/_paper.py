"""The paper by our numbers: its figures, and each of its statements with a verdict."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from wingbeat._program import Picture, _aside, run
from wingbeat._verdicts import judged
from wingbeat._views import View


@dataclass(frozen=True, kw_only=True)
class Paper:
    """Figures and statements of the paper."""

    statements: list[dict[str, Any]] = field(repr=False)
    """What the paper says, what came out here, and the verdict, one by one."""
    figures: dict[str, Picture] = field(repr=False)
    """Its six figures by name."""
    sheet: str = field(repr=False)
    """The page with all of them, HTML."""
    summary: dict[str, Any] = field(repr=False)
    """Verdict of the sheet, and the commands that it rests on."""

    @property
    def status(self) -> str:
        """``ok``, or what is missing."""
        return str(self.summary["status"])

    def _repr_html_(self) -> str:
        return View(self.sheet, 600)._repr_html_()


def paper(source: str | PathLike[str] | None = None, *, out: str | PathLike[str] | None = None) -> Paper:
    """Draws the figures of the paper by our numbers and judges its statements, as ``wingbeat paper`` does; it takes about a minute.

    Parameters
    ----------
    source
        Folder with the scenarios, robots and rigs; without it those that come with the package.
    out
        New folder that keeps everything, the run folders of the flights and of the rig too; without it nothing is kept.

    Returns
    -------
    Paper
        ``statements``, ``figures``, ``sheet`` and ``summary``.
    """
    home = Path(__file__).parent if source is None else Path(source)
    with _aside() as folder:
        kept = Path(folder) / "paper" if out is None else Path(out)
        run(["paper", "--quiet", "--from", home, "--out", kept])
        summary = judged((kept / "summary.json").read_text(encoding="utf-8"))
        pictures = {}
        for name in summary["figures"]:
            figure = kept / "figures" / name
            svg = figure.with_suffix(".svg").read_text(encoding="utf-8")
            pictures[name] = Picture(figure.with_suffix(".png").read_bytes(), svg, name)
        sheet = (kept / "sheet.html").read_text(encoding="utf-8")
        return Paper(statements=summary["statements"], figures=pictures, sheet=sheet, summary=summary)

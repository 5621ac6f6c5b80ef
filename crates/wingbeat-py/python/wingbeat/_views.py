"""Results as pages that move, animations, and the files of other programs."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from wingbeat import _wingbeat

if TYPE_CHECKING:
    from wingbeat._record import Record

Format: TypeAlias = Literal["csv", "npz", "mat", "vtk", "gltf", "mcap"]
Seen: TypeAlias = Literal["whole", "behind", "side", "above"]

_ENDINGS: dict[str, Format] = {
    ".csv": "csv",
    ".npz": "npz",
    ".mat": "mat",
    ".glb": "gltf",
    ".mcap": "mcap",
}


@dataclass(frozen=True)
class View:
    """A page that moves; a notebook shows it."""

    html: str = field(repr=False)
    """The whole page: it loads nothing."""
    height: int = 760
    """Height in a notebook, px."""

    def save(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """Writes the page to ``path``; ``force`` replaces a file that is there."""
        _free(Path(path), force)
        _write(Path(path), self.html.encode())

    def _repr_html_(self) -> str:
        from html import escape

        return (
            f'<iframe title="Run of wingbeat" srcdoc="{escape(self.html, quote=True)}" sandbox="allow-scripts" '
            f'width="100%" height="{self.height}" style="border:0"></iframe>'
        )


class Viewed:
    """What a result with a page can do."""

    def _held(self) -> tuple[str, dict[str, str], dict[str, Record | None]]:
        """Name, texts and records under the names that the program gives their files."""
        raise NotImplementedError

    def _given(self) -> tuple[str, list[tuple[str, str]], list[tuple[str, list[Any]]]]:
        """The same as the extension takes them."""
        name, texts, records = self._held()
        there = [(file, record._given()) for file, record in records.items() if record is not None]
        if not there:
            raise ValueError("the result holds no record: there is nothing to show")
        document = texts.get("scenario.toml") or texts.get("case.toml") or ""
        named = re.search(r'^name = "(.*)"$', document, re.MULTILINE)
        return named.group(1) if named else name, list(texts.items()), there

    def view(self, *others: Viewed, wake: bool = True, strips: bool = True, height: int = 760) -> View:
        """The page of the program's ``report.html``, from memory, of this result or of several overlaid.

        Parameters
        ----------
        others
            Results of the same kind that are drawn over this one.
        wake, strips
            Whether the page holds the wake and the forces of the strips.
        height
            Height in a notebook, px.
        """
        if height < 200:
            raise ValueError(f"height = {height}: allowed is 200 or more")
        return View(_wingbeat.page_of([one._given() for one in (self, *others)], wake, strips), height)

    def animate(
        self,
        path: str | PathLike[str],
        *,
        view: Seen = "whole",
        speed: float = 1.0,
        rate: float = 20.0,
        width: int = 640,
        wide: bool = False,
        force: bool = False,
    ) -> None:
        """Writes an animated PNG to ``path``, or where that does not end in ``.png`` a folder with a PNG of every frame.

        Parameters
        ----------
        view
            ``whole``, ``behind``, ``side`` or ``above``.
        speed
            Seconds of the run in a second.
        rate
            Frames a second.
        width
            Width, px.
        wide
            16:9 in place of 4:3.
        force
            Replace a file that is there.
        """
        path = Path(path)
        frames = path.suffix.lower() not in (".png", ".apng")
        if frames and path.suffix:
            raise ValueError(f"{path}: allowed is a file that ends in .png, or a folder")
        _free(path, force and not frames)
        numbers = (float(speed), float(rate), float(width))
        _files(path, _wingbeat.animation_of(self._given(), view, numbers, wide, frames))

    def export(self, path: str | PathLike[str], *, format: Format | None = None, force: bool = False) -> None:
        """Writes the files of another program: ``csv``, ``npz``, ``mat``, ``gltf``, ``mcap``, or ``vtk``, which is a folder.

        Without ``format`` the ending of ``path`` says it. ``force`` replaces a file that is there.
        """
        path = Path(path)
        chosen = format or _ENDINGS.get(path.suffix.lower())
        if chosen is None:
            allowed = ", ".join(_ENDINGS)
            raise ValueError(f"{path}: allowed are the endings {allowed}, or format='vtk' for a folder")
        _free(path, force and chosen != "vtk")
        _files(path, _wingbeat.export_of(self._given(), chosen))


class Shown(Viewed):
    """The same with the page as a file."""

    def report(
        self,
        path: str | PathLike[str],
        *others: Viewed,
        wake: bool = True,
        strips: bool = True,
        force: bool = False,
    ) -> None:
        """Writes that page to ``path``; ``force`` replaces a file that is there."""
        self.view(*others, wake=wake, strips=strips).save(path, force=force)


def summary_text(summary: dict[str, Any]) -> str:
    """A summary as its file holds it."""
    return json.dumps(summary)


def _free(path: Path, force: bool) -> None:
    """Refuses what is there, unless it is a file that may be replaced."""
    if (path.exists() or path.is_symlink()) and not (force and path.is_file()):
        hint = "; force=True replaces it" if path.is_file() else ""
        raise FileExistsError(f"{path}: is there already{hint}")


def _write(path: Path, content: bytes) -> None:
    """Writes a file beside its place and moves it there."""
    beside = path.with_name(f".{path.name}.partial")
    try:
        beside.write_bytes(content)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def _files(path: Path, written: Sequence[tuple[str, bytes]]) -> None:
    """Writes one file without a name to ``path``, or several into that folder."""
    if len(written) == 1 and not written[0][0]:
        _write(path, written[0][1])
        return
    beside = path.with_name(f".{path.name}.partial")
    shutil.rmtree(beside, ignore_errors=True)
    try:
        beside.mkdir(parents=True)
        for name, content in written:
            (beside / name).write_bytes(content)
        beside.rename(path)
    finally:
        shutil.rmtree(beside, ignore_errors=True)

"""Figures of every shipped document, by their pixels: no panel is blank."""

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from matplotlib.image import imread

# Room inside the frame of a panel that ticks take, px of the drawing. *Choice.*
INSET = 8
# Difference of the channels of a coloured pixel, and brightness of a drawn black one. *Choices.*
COLOURED, DARK = 0.15, 0.35
# Pixels without which a panel counts as blank. *Choice*: a curve at zero across a narrow panel has more.
LEAST = 40


def panels(svg):
    """Rectangles of the panels of a drawing, in its own px: those that clip what is drawn in them."""
    clips = dict(re.findall(r'<clipPath id="([^"]+)">(<rect [^>]*>)', svg))
    places = re.findall(r'<g transform="translate\(([-\d.]+),\s*([-\d.]+)\)"', svg)
    boxes = []
    for number, rect in enumerate(clips.values()):
        x, y, width, height = (float(re.search(rf' {name}="([-\d.]+)"', rect).group(1)) for name in ("x", "y", "width", "height"))
        # A panel is a group of its own, moved to its place.
        dx, dy = map(float, places[number]) if number < len(places) else (0.0, 0.0)
        boxes.append((x + dx, y + dy, width, height))
    return boxes


def blank(png):
    """The panels of a picture in which nothing is drawn, by their numbers."""
    svg = png.with_suffix(".svg").read_text()
    pixels = imread(png)[..., :3]
    scale = pixels.shape[1] / float(re.search(r'width="([\d.]+)"', svg).group(1))
    found = []
    for number, (x, y, width, height) in enumerate(panels(svg)):
        left, right = (round(scale * edge) for edge in (x + INSET, x + width - INSET))
        top, bottom = (round(scale * edge) for edge in (y + INSET, y + height - INSET))
        inside = pixels[top:bottom, left:right]
        coloured = inside.max(axis=-1) - inside.min(axis=-1) > COLOURED
        drawn = coloured | (inside.max(axis=-1) < DARK)
        if np.count_nonzero(drawn) < LEAST:
            found.append(number)
    return found


def documents(folder):
    """Shipped documents of a folder."""
    return sorted((ROOT / folder).glob("*.toml"))


def calls():
    """Calls of the program that draw the figures of every scenario, case and run, short ones."""
    for path in documents("scenarios"):
        text = path.read_text()
        if path.stem not in ("gait_search_beta", "least_power_gait", "paper_plan", "roll_in"):
            yield ["fly", path, "--set", "flight.duration_s=0.6"]
        if re.search(r"^\[trim\]|^trim\.", text, re.M) and "search" not in text:
            yield ["trim", path]
    for path in documents("cases"):
        yield ["tether", path]
        if path.stem == "flap_fold":
            yield ["wake", path, "--prescribed"]
    for path in documents("rigs/runs"):
        yield ["rig", "plan", path]
        yield ["rig", "simulate", path]
    for path in [*documents("robots"), ROOT / "rigs/aerobat_on_gen3.toml"]:
        yield ["show", path]


@pytest.mark.long
@pytest.mark.parametrize("call", list(calls()), ids=lambda call: f"{call[0]}-{Path(next(w for w in call if isinstance(w, Path))).stem}")
def test_no_panel_of_a_figure_is_blank(call, program, tmp_path):
    done = program(*call, "--quiet", "--out", tmp_path / "out")
    # A short try of a flight may miss what its scenario asks.
    assert done.returncode in (0, 3), done.stderr
    pictures = sorted((tmp_path / "out").rglob("*.png"))
    faults = {picture.name: numbers for picture in pictures if (numbers := blank(picture))}
    assert not faults, faults
    assert pictures or call[0] in ("rig",)


def test_a_blank_panel_is_found(program, tmp_path):
    done = program("tether", ROOT / "cases/flap_fold.toml", "--quiet", "--out", tmp_path / "out", "--set", "time.cycles=1")
    assert done.returncode in (0, 3), done.stderr
    picture = next((tmp_path / "out/figures").glob("*.png"))
    assert len(panels(picture.with_suffix(".svg").read_text())) > 1 and blank(picture) == []
    from matplotlib.image import imsave

    pixels = imread(picture)
    svg = picture.with_suffix(".svg").read_text()
    x, y, width, height = panels(svg)[1]
    scale = pixels.shape[1] / float(re.search(r'width="([\d.]+)"', svg).group(1))
    pixels[round(scale * y) : round(scale * (y + height)), round(scale * x) : round(scale * (x + width)), :3] = 1.0
    imsave(picture, pixels)
    assert blank(picture) == [1]

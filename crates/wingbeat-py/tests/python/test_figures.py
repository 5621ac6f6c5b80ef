"""Figures of every shipped document, by their pixels: no panel is blank."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from matplotlib.image import imread

# Folders of shipped documents.
FOLDERS = ("robots", "scenarios", "cases", "rigs", "calibrations", "sweeps")
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


# Scenarios that a search or a plan of `wingbeat trim` or `wingbeat plan` makes, which no flight of their own shows.
NOT_FLOWN = ("gait_search_airs", "gait_search_beta", "least_power_gait", "paper_plan", "reorientation", "roll_in")


def of_sweep(path):
    """A sweep in few runs: of a grid two values of each draw."""
    spec = tomllib.loads(path.read_text())
    keys = ["scenario.flight.duration_s=0.6"] if "scenario" in spec else ["case.time.cycles=2"]
    if "search" in spec:
        keys += ["runs=4", "search.population=4", "scenario.flight.duration_s=0.1"]
    elif spec.get("sampling") == "grid":
        keys += [f"draws[{k}].points=2" for k, draw in enumerate(spec["draws"]) if "points" in draw]
    else:
        keys += ["runs=3"]
    return ["sweep", path, *(word for key in keys for word in ("--set", key))]


def calls():
    """Calls of the program that draw the figures of every shipped document, short ones where they can be."""
    for path in documents("scenarios"):
        text = path.read_text()
        if path.stem not in NOT_FLOWN:
            yield ["fly", path, "--set", "flight.duration_s=0.6"]
        else:
            yield ["show", path]
        if re.search(r"^\[trim\]|^trim\.", text, re.M) and "search" not in text:
            yield ["trim", path]
    for path in documents("cases"):
        yield ["tether", path]
        if path.stem == "flap_fold":
            yield ["wake", path, "--prescribed"]
    for path in [*documents("rigs/runs"), *documents("rigs/identification")]:
        if re.search(r"^\[?turn\b|^base", path.read_text(), re.M):
            yield ["rig", "plan", path]
        yield ["rig", "simulate", path]
    for path in [*documents("robots"), *documents("robots/any"), *sorted((ROOT / "rigs").glob("*_on_gen3.toml"))]:
        yield ["show", path]
    for path in documents("sweeps"):
        yield of_sweep(path)
    for path in documents("calibrations"):
        yield ["calibrate", path]
    yield ["rig", "simulate", ROOT / "rigs/seven_runs.toml"]
    yield ["rig", "simulate", ROOT / "rigs/identification.toml"]


def named(call):
    """The document of a call."""
    return next(word for word in call if isinstance(word, Path))


def looked_at(call, program, folder):
    """Runs a call; no panel of its pictures is blank."""
    done = program(*call, "--quiet", "--out", folder / "out")
    # A short try of a flight may miss what its scenario asks.
    assert done.returncode in (0, 3), done.stderr
    if call[:2] == ["rig", "simulate"] and (folder / "out").is_dir():
        processed = program("rig", "process", folder / "out", "--quiet", "--out", folder / "loads")
        assert processed.returncode in (0, 3), processed.stderr
    pictures = sorted(folder.rglob("*.png"))
    faults = {picture.name: numbers for picture in pictures if (numbers := blank(picture))}
    assert not faults, faults
    assert pictures or call[0] == "rig"


def test_every_shipped_document_is_drawn():
    drawn = {named(call) for call in calls()}
    # An arm is drawn with its rig.
    left = {path for folder in FOLDERS for path in (ROOT / folder).rglob("*.toml")} - drawn - set(documents("rigs/arms"))
    assert not left and len(drawn) > 100, left


# A few that take a second; a case is looked at below.
FEW = [["fly", "scenarios/glide.toml", "--set", "flight.duration_s=0.3"], ["show", "robots/four_wings.toml"]]


@pytest.mark.parametrize("call", FEW, ids=lambda call: call[0])
def test_no_panel_of_a_few_figures_is_blank(call, program, tmp_path):
    looked_at([call[0], ROOT / call[1], *call[2:]], program, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("call", list(calls()), ids=lambda call: f"{call[0]}-{named(call).stem}")
def test_no_panel_of_a_figure_is_blank(call, program, tmp_path):
    looked_at(call, program, tmp_path)


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

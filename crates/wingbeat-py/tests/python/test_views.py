"""Pages, animations, exports and pixels: what notebooks and other programs see of a result."""

import json
import re
import subprocess
import zlib
from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest

import wingbeat


@pytest.fixture(scope="module")
def flight() -> wingbeat.Flight:
    return wingbeat.fly(wingbeat.shipped("scenarios/banking_turn.toml"), {"flight.duration_s": 0.2})


def runs(page: str) -> list[dict]:
    """What a page holds of its runs."""
    letters = re.search(r'id="bytes">([^<]*)</script>', page).group(1)
    content = zlib.decompress(b64decode(letters), -15)
    return json.loads(content[4 : 4 + int.from_bytes(content[:4], "little")])


def test_a_notebook_shows_the_page_from_memory(flight):
    view = flight.view()
    frame = view._repr_html_()
    assert frame.startswith("<iframe") and 'sandbox="allow-scripts"' in frame
    # Inside the attribute nothing ends it.
    inside = re.search(r'srcdoc="([^"]*)"', frame).group(1)
    assert len(inside) > 50_000 and "<" not in inside and ">" not in inside
    (run,) = runs(view.html)
    assert run["axis"]["values"]["rows"] == flight.record.rows == 201
    assert [surface["name"] for surface in run["motion"]["surfaces"]] and run["motion"]["sources"]
    assert "<title>banking_turn</title>" in view.html
    assert runs(flight.view(wake=False, strips=False).html)[0]["motion"]["circulation"] is None


def test_the_page_is_that_of_the_program(flight, tmp_path):
    flight.report(tmp_path / "own.html")
    command = [wingbeat._program.program(), "fly", str(wingbeat.shipped("scenarios/banking_turn.toml"))]
    out = tmp_path / "run"
    made = subprocess.run(
        [*command, "--set", "flight.duration_s=0.2", "--quiet", "--out", out], check=False, timeout=120
    )
    assert made.returncode in (0, 3)
    own, program = (path.read_text(encoding="utf-8") for path in (tmp_path / "own.html", out / "report.html"))
    assert runs(own) == runs(program)
    letters = [re.search(r'id="bytes">([^<]*)</script>', page).group(1) for page in (own, program)]
    assert letters[0] == letters[1]


def test_results_are_overlaid_and_other_kinds_refused(flight, tmp_path):
    pages = runs(flight.view(flight).html)
    assert len(pages) == 2
    case = wingbeat.tether(wingbeat.shipped("cases/flap_f2.toml"), {"time.cycles": 2})
    assert runs(case.view().html)[0]["motion"]["repeats"]
    for kind in ("csv", "npz", "mat", "gltf"):
        case.export(tmp_path / f"case.{kind}", format=kind)
    with pytest.raises(FileExistsError, match="is there already; force=True"):
        flight.export(tmp_path / "case.csv")
    with pytest.raises(FileExistsError, match="is there already"):
        flight.report(tmp_path)
    with pytest.raises(ValueError, match="allowed are the endings .csv, .npz"):
        flight.export(tmp_path / "flight.xls")
    with pytest.raises(ValueError, match="height = 10: allowed is 200 or more"):
        flight.view(height=10)
    with pytest.raises(ValueError, match="holds no record"):
        wingbeat.Trimmed(
            record=None, multipliers=None, family=None, starts=None, summary={"status": "not_found"}, files={}
        ).view()


def test_grounds_and_wings_alone_are_shown():
    flight = wingbeat.fly(
        wingbeat.shipped("scenarios/glider.toml"), {"flight.duration_s": 0.05, "air.ground_m": -0.3}
    )
    (run,) = runs(flight.view().html)
    assert run["motion"]["ground"] == -0.3 and not run["motion"]["bare"]
    (height,) = [panel for panel in run["panels"] if panel["title"] == "height"]
    assert [curve["label"] for curve in height["curves"]] == ["z", "ground"]
    case = wingbeat.tether(wingbeat.shipped("cases/flap_f2.toml"), {"time.cycles": 2})
    assert runs(case.view().html)[0]["motion"]["bare"]


def test_exports_hold_the_record(flight, tmp_path):
    flight.export(tmp_path / "a.npz")
    kept = np.load(tmp_path / "a.npz")
    assert np.array_equal(kept["roll"], flight.record["roll"]) and set(kept) == set(flight.record)
    flight.export(tmp_path / "a.csv")
    rows = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    assert np.array_equal(rows["p_WB_z"], flight.record["p_WB_z"])
    flight.export(tmp_path / "a.mcap")
    flight.export(tmp_path / "a.glb")
    assert (tmp_path / "a.mcap").read_bytes()[:5] == b"\x89MCAP"
    assert (tmp_path / "a.glb").read_bytes()[:4] == b"glTF"
    flight.export(tmp_path / "frames", format="vtk")
    frames = sorted(path.name for path in (tmp_path / "frames").iterdir())
    assert len(frames) == 202 and frames[0] == "frame_00000.vtk" and frames[-1] == "frames.vtk.series"
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
    with pytest.raises(ValueError, match='format = "xml": allowed are csv'):
        flight.export(tmp_path / "a.xml", format="xml")


def test_animations_are_files_or_frames(flight, tmp_path):
    flight.animate(tmp_path / "a.png", speed=0.5, width=200, view="behind")
    content = (tmp_path / "a.png").read_bytes()
    frames = int.from_bytes(content.split(b"acTL")[1][:4], "big")
    assert content[:8] == b"\x89PNG\r\n\x1a\n" and frames == 8
    flight.animate(tmp_path / "frames", rate=10.0, width=200)
    assert [path.name for path in sorted((tmp_path / "frames").iterdir())] == ["frame_0000.png", "frame_0001.png"]
    for wrong, said in [
        ({"speed": float("nan")}, "speed NaN: allowed is 0.001 to 1000"),
        ({"speed": 1e300}, "speed 1e300: allowed is"),
        ({"rate": 0.0}, "rate 0: allowed is 1 to 100"),
        ({"width": 10}, "width 10: allowed is 160 to 3840"),
        ({"view": "below"}, 'view = "below": allowed are whole'),
        ({"speed": 0.001, "rate": 100.0}, "frames: allowed are at most 1200"),
    ]:
        with pytest.raises(ValueError, match=re.escape(said)):
            flight.animate(tmp_path / "b.png", **wrong)
    with pytest.raises(ValueError, match="allowed is a file that ends in .png"):
        flight.animate(tmp_path / "a.mp4")
    assert not Path(tmp_path / "b.png").exists()

"""Pictures, averages and plans that the program makes for the package, and results as notebooks show them."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

import wingbeat

PNG = b"\x89PNG"


def test_a_flight_shows_itself_in_a_notebook():
    flight = wingbeat.fly(wingbeat.shipped("scenarios/glide.toml"), {"flight.duration_s": 0.1, "name": "a"})
    page = flight._repr_html_()
    assert "<img" in page and "status" in page and "<script" not in page
    hostile = wingbeat.Flight(record=flight.record, strips=None, summary={"status": "<b>", "warnings": [{"id": "x", "text": "a<b"}]})
    assert "<b>" not in hostile._repr_html_() and "a&lt;b" in hostile._repr_html_()
    figure = flight.plot3d(frames=3)
    assert len(figure.axes[0].lines) == 1 + 3 * 3
    with pytest.raises(ValueError, match="frames"):
        flight.plot3d(frames=-1)


def test_show_draws_files_dictionaries_and_robots(tmp_path):
    robot = wingbeat.Robot(wingbeat.shipped("robots/glider.toml"))
    for source in (robot, robot.to_dict(), wingbeat.shipped("robots/glider.toml")):
        picture = wingbeat.show(source)
        assert picture.png.startswith(PNG) and "<svg" in picture.svg
    picture.save(tmp_path / "a.svg")
    picture.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == picture._repr_png_() and "<svg" in (tmp_path / "a.svg").read_text()
    with pytest.raises(ValueError, match="phase"):
        wingbeat.show(robot, phase_rad=math.nan)
    with pytest.raises(ValueError, match=r"none\.toml"):
        wingbeat.show(tmp_path / "none.toml")


def test_average_finds_the_frequency_of_a_file(tmp_path):
    t = np.arange(4000) / 1000.0
    generator = np.random.default_rng(1)
    loads = [np.cos(2 * np.pi * 3.5 * t + k) + 0.01 * generator.standard_normal(len(t)) for k in range(6)]
    np.savetxt(tmp_path / "cell.csv", np.column_stack(loads), delimiter=",")
    averaged = wingbeat.average(tmp_path / "cell.csv", rate_hz=1000.0, units=["N", "N m"])
    assert averaged.status == "ok" and abs(averaged.summary["frequency_hz"] - 3.5) < 1e-3
    assert averaged.record.rows == 200 and averaged.picture.png.startswith(PNG)
    with pytest.raises(ValueError, match="rate"):
        wingbeat.average(tmp_path / "cell.csv", rate_hz=-1.0)


@pytest.mark.long
def test_the_paper_has_its_figures_and_statements(tmp_path):
    made = wingbeat.paper(out=tmp_path / "paper")
    assert made.status == "ok" and set(made.figures) == {"setup", "arm", "force_moment", "wake_phases", "states", "path"}
    assert len(made.statements) > 5 and all("verdict" in each for each in made.statements)
    assert all(figure.png.startswith(PNG) for figure in made.figures.values()) and "<svg" in made.sheet
    assert (tmp_path / "paper/turn/record.parquet").exists() and "sandbox=" in made._repr_html_()


def test_a_paper_without_its_documents_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"banking_turn\.toml"):
        wingbeat.paper(tmp_path, out=tmp_path / "a")
    assert not (tmp_path / "a").exists()


def test_a_run_of_the_rig_is_planned():
    [plan] = wingbeat.rig_plan(wingbeat.shipped("rigs/runs/roll15_speed08.toml"))
    assert plan.name == "roll15_speed08" and "turn at" in plan.report and set(plan.files) >= {"roll15_speed08.yaml"}
    assert plan.joints.rows > 1000 and list(plan.joints)[:2] == ["time_s", "joint_1_deg"]
    with pytest.raises(ValueError, match="exceeds the limit"):
        wingbeat.rig_plan(wingbeat.shipped("rigs/runs/roll15_speed08.toml"), {"profile": "paper-tool"})


def test_a_plan_has_the_files_of_its_own_run(tmp_path):
    names = ["roll15_speed08", "roll15_speed08b"]
    files = [wingbeat.shipped(f"rigs/runs/{name}.toml").as_posix() for name in names]
    (tmp_path / "two.toml").write_text(f"runs = {files}\n", encoding="utf-8")
    plans = wingbeat.rig_plan(tmp_path / "two.toml")
    assert [plan.name for plan in plans] == names
    for plan in plans:
        assert sorted(plan.files) == [f"{plan.name}{ending}" for ending in (".csv", ".json", ".yaml")]


def test_files_may_begin_with_a_minus_sign(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "-a.toml").write_text(wingbeat.Robot(wingbeat.shipped("robots/glider.toml")).toml, encoding="utf-8")
    assert wingbeat.show("-a.toml").name == "-a"
    with pytest.raises(ValueError, match=r"none\.toml"):
        wingbeat.rig_plan("-none.toml")
    with pytest.raises(ValueError, match=r"none\.csv"):
        wingbeat.average("-none.csv", rate_hz=1.0)


def test_validate_says_what_is_missing(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileNotFoundError, match="wingbeat-validate"):
        wingbeat.validate(only="aero")


@pytest.mark.skipif(os.name == "nt", reason="the stand-in is a script of the shell")
def test_validate_takes_the_words_of_its_program(monkeypatch, tmp_path):
    stand_in = tmp_path / "wingbeat-validate"
    row = '[{"id": "aero.one", "metric": "m", "value": 1.0, "limit": 2.0, "pass": true}]'
    # It knows the options and no verb, writes the rows and ends as one does whose comparison failed.
    words = "--quiet) ;; --quick) ;; --only=*) ;; --json) shift; out=$1 ;; *) echo \"error: unexpected argument '$1' found\" >&2; exit 2"
    script = f"#!/bin/sh\nwhile [ $# -gt 0 ]; do case $1 in {words} ;; esac; shift; done\necho '{row}' > \"$out\"\nexit 1\n"
    stand_in.write_text(script, encoding="utf-8")
    stand_in.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    rows = wingbeat.validate(only="aero")
    assert rows == [{"id": "aero.one", "metric": "m", "value": 1.0, "limit": 2.0, "pass": True}]


def test_validate_compares():
    real = Path(os.environ.get("WINGBEAT_PROGRAM", "wingbeat")).with_name("wingbeat-validate")
    if not real.is_file():
        pytest.skip("the program of the comparisons is not built")
    path = f"{real.parent}{os.pathsep}{os.environ['PATH']}"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", path)
        rows = wingbeat.validate(only="paper.equations")
        assert rows and all(row["id"].startswith("paper.equations") and row["pass"] for row in rows)
        with pytest.raises(ValueError, match="no such comparison"):
            wingbeat.validate(only="paper.equation_of_none")


def test_a_measurement_is_a_mapping(turn):
    from collections.abc import Mapping

    seen = []

    def controller(t, measurement):
        seen.append(measurement)
        return [0.0] * 8

    start = {"flight.duration_s": 0.006, "start.roll_deg": 10.0, "start.nose_up_deg": 5.0, "start.yaw_deg": -20.0}
    wingbeat.fly(turn, start, controller=controller, sees=["quat", "w_WB_B"])
    first = seen[0]
    assert isinstance(first, Mapping) and len(first) == 7 and list(first) == first.names == list(first.keys())
    assert dict(first) == dict(first.items()) and "quat_w" in first and "p_WB_x" not in first
    assert first["quat"].shape == (4,) and first["w_WB_B"].shape == (3,) and first.get("p_WB_x", 2.0) == 2.0
    angles = np.degrees([first.roll, first.pitch, first.yaw])
    assert np.allclose(angles, [10.0, -5.0, -20.0], atol=1e-9)
    assert first.array.tolist() == first.values()
    with pytest.raises(KeyError, match="allowed are quat_w"):
        first["qua"]
    wingbeat.fly(turn, start, controller=controller, sees=["w_WB_B"])
    with pytest.raises(AttributeError, match="not measured"):
        _ = seen[-1].roll
    assert "quat" in first and "qua" not in first and 3 not in first and "quat" not in seen[-1]


def test_a_sweep_overrides_its_scenario(turn, tmp_path):
    spec = {
        "name": "short",
        "scenario": str(turn),
        "set": ["flight.duration_s=0.02", "flight.record_every_s=0.002"],
        "runs": 2,
        "draws": [{"key": "start.nose_up_deg", "low": 14.0, "high": 16.0}],
        "hold": {"roll_within_deg": 5.0, "pitch_within_deg": 10.0},
    }
    table = wingbeat.sweep(spec, out=tmp_path / "a")
    assert table.rows == 2 and np.all(table["distance_x"] < 0.2)
    with pytest.raises(ValueError, match="flight.duration"):
        wingbeat.sweep({**spec, "set": ["flight.duration=1"]}, out=tmp_path / "b")

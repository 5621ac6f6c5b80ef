"""The package runs what the program runs, to the byte."""

import json
import warnings

import numpy as np
import pytest
from conftest import ROOT, SHORT

import wingbeat


def test_a_flight_is_the_programs_flight(program, tmp_path):
    sets = {"flight.duration_s": 0.3, "flight.record_strips_every_s": 0.01, "aero.preset": "full"}
    out = ("--quiet", "--out", tmp_path / "run")
    done = program("fly", "scenarios/banking_turn.toml", *out, *sets_of(sets))
    assert done.returncode in (0, 3), done.stderr
    flight = wingbeat.fly(ROOT / "scenarios/banking_turn.toml", sets)
    flight.record.write(tmp_path / "record.parquet")
    flight.strips.record.write(tmp_path / "strips.parquet")
    for name in ("record.parquet", "strips.parquet"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "run" / name).read_bytes()
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    timed = {"real_time_factor", "controller"}
    assert {k: v for k, v in flight.summary.items() if k not in timed} == {
        k: v for k, v in summary.items() if k not in timed
    }
    scenario = wingbeat.Scenario(ROOT / "scenarios/banking_turn.toml", sets)
    assert scenario.toml == (tmp_path / "run/scenario.toml").read_text()


def test_a_result_warns_of_what_its_summary_says(turn):
    with pytest.warns(wingbeat.ResultWarning) as told:
        flight = wingbeat.fly(turn, SHORT)
    said = [each["id"] for each in flight.summary["warnings"]]
    assert [each.message.id for each in told] == [*said, "status.not_judged"]
    assert "flight.weight_carried" in flight.summary["reason"]
    limits = {"limits.flight.crossing_fraction": -1.0}
    with pytest.warns(wingbeat.ResultWarning, match="status.outside: .*limits.flight.crossing_fraction"):
        assert wingbeat.fly(turn, {**SHORT, **limits}).status == "outside"


def test_a_file_a_text_and_a_dictionary_fly_alike(turn):
    file = wingbeat.Scenario(turn, SHORT)
    text = wingbeat.Scenario.from_text(file.toml)
    table = wingbeat.Scenario(file.to_dict())
    records = [wingbeat.fly(scenario).record for scenario in (file, text, table)]
    for other in records[1:]:
        assert list(other) == list(records[0])
        assert all(np.array_equal(other[name], records[0][name]) for name in other)


def test_a_robot_takes_the_place_of_another(turn):
    heavy = wingbeat.Robot(wingbeat.shipped("robots/aerobat_paper.toml"), {"body": {"mass_kg": 0.02}})
    scenario = wingbeat.Scenario(turn, robot=heavy)
    assert scenario.mass_kg == pytest.approx(0.03)
    assert scenario.to_dict()["robot"] == heavy.to_dict()
    assert wingbeat.Robot.from_text(heavy.toml).name == heavy.name


def test_a_case_is_the_programs_case(program, tmp_path):
    done = program("tether", "cases/plunge.toml", "--quiet", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    moved = wingbeat.tether(ROOT / "cases/plunge.toml")
    moved.strips.record.write(tmp_path / "strips.parquet")
    assert (tmp_path / "strips.parquet").read_bytes() == (tmp_path / "run/strips.parquet").read_bytes()
    assert moved.summary == json.loads((tmp_path / "run/summary.json").read_text())


def sets_of(overrides):
    """Overrides as the program takes them."""
    return [part for key, value in overrides.items() for part in ("--set", f"{key}={value}")]


def test_a_periodic_flight_is_the_programs(program, tmp_path):
    scenario = ROOT / "scenarios/cruise_20g.toml"
    done = program("trim", scenario, "--quiet", "--out", tmp_path / "orbit")
    assert done.returncode == 0, done.stderr
    trimmed = wingbeat.trim(scenario)
    assert trimmed.status == "ok" and trimmed.family is None
    trimmed.record.write(tmp_path / "record.parquet")
    trimmed.multipliers.write(tmp_path / "multipliers.parquet")
    for name in ("record.parquet", "multipliers.parquet"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "orbit" / name).read_bytes()
    assert trimmed.files["orbit.toml"] == (tmp_path / "orbit/orbit.toml").read_text()
    on_orbit = wingbeat.Scenario.from_text(trimmed.files["orbit.toml"])
    assert on_orbit.mass_kg == pytest.approx(0.02, rel=0.05)


def test_a_search_of_gaits_is_the_programs_and_tells_how_far_it_is(program, tmp_path):
    scenario = ROOT / "scenarios/cruise_20g.toml"
    search = {
        "goal": "power",
        "limits": {"frequency_hz": 6.2},
        "iterations": 2,
        "starts": 2,
        "vary": [{"key": "trim.speed_m_s", "low": 3.4, "high": 4.4}],
    }
    keys = {"trim.step_s": 1e-3, "trim.search": search}
    wingbeat.Scenario(scenario, keys)
    told = []
    trimmed = wingbeat.trim(scenario, keys, progress=told.append)
    assert trimmed.summary["search"]["starts"] == 2 and trimmed.starts.rows == 2
    assert {at["start"] for at in told if "start" in at} == {0.0, 1.0}
    assert {"power_w_kg", "frequency_hz", "violation", "iteration"} < set(told[0]) and "residual" in told[-1]
    (tmp_path / "search.toml").write_text(wingbeat.Scenario(scenario, keys).toml)
    done = program("trim", tmp_path / "search.toml", "--quiet", "--out", tmp_path / "gait")
    assert done.returncode == 0, done.stderr
    trimmed.starts.write(tmp_path / "starts.parquet")
    assert (tmp_path / "starts.parquet").read_bytes() == (tmp_path / "gait/starts.parquet").read_bytes()
    for name in ("orbit.toml", "robot.toml"):
        assert trimmed.files[name] == (tmp_path / "gait" / name).read_text()

    ended = wingbeat.trim(scenario, keys, progress=lambda at: at["iteration"] == 1)
    assert ended.status == "not_found" and ended.starts is None and ended.files == {}

    def fails(at):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        wingbeat.trim(scenario, keys, progress=fails)


def warned(make):
    """What a call warns of, by id, and its result."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        result = make()
    return [each.message.id for each in told if isinstance(each.message, wingbeat.ResultWarning)], result


def test_a_robot_by_itself_is_trimmed_until_it_is_told_to_end():
    hand, seen = ROOT / "robots/any/hand_30g.toml", []
    for robot in (hand, wingbeat.Robot(hand)):
        ids, trimmed = warned(lambda robot=robot: wingbeat.trim(robot, progress=lambda at: seen.append(at) or True))
        assert trimmed.status == "interrupted", trimmed.summary
        assert "status.interrupted" in ids
        assert 'name = "hand_30g"' in trimmed.document
    assert "orbits" in seen[0]
    with pytest.raises(ValueError, match="bank_deg = NaN"):
        wingbeat.trim(hand, bank_deg=float("nan"))
    with pytest.raises(ValueError, match=r"bank_deg: allowed with a robot"):
        wingbeat.trim(ROOT / "scenarios/cruise_20g.toml", bank_deg=10.0)
    with pytest.raises(ValueError, match=r"robot.body.mass_kg = -1"):
        wingbeat.trim(hand, {"robot.body.mass_kg": -1.0})


@pytest.mark.long
def test_a_trim_of_a_robot_by_itself_is_the_programs(program, tmp_path):
    hand = ROOT / "robots/any/hand_30g.toml"
    program("trim", hand, "--quiet", "--out", tmp_path / "run")
    _, trimmed = warned(lambda: wingbeat.trim(hand))
    trimmed.record.write(tmp_path / "record.parquet")
    assert (tmp_path / "record.parquet").read_bytes() == (tmp_path / "run/record.parquet").read_bytes()
    assert trimmed.summary["power_w_kg"] == json.loads((tmp_path / "run/summary.json").read_text())["power_w_kg"]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: wingbeat.tether(ROOT / "cases/pazy.toml", {"wind.speed_m_s": 90.0, "time.steps_per_cycle": 48}), "tether.growth_fraction"),
        (lambda: wingbeat.tether(ROOT / "cases/pitch.toml", {"wind.speed_m_s": 120.0, "time.frequency_hz": 19.1}), "range.mach"),
        (lambda: wingbeat.tether(ROOT / "cases/flap_f1.toml", {"wing.hinges[0].angle_deg": {"fourier": {"sin": [100.0]}}}), "tether.crossing_fraction"),
        (lambda: wingbeat.fly(ROOT / "scenarios/sail_glide.toml", {"flight.duration_s": 0.1, "robot.surfaces[0].membrane.damping_s": 0.2}), "membrane"),
    ],
    ids=["spar", "mach", "crossing", "membrane"],
)
def test_new_models_warn_of_their_range(make, said):
    ids, result = warned(make)
    assert any(each.startswith(said) for each in [*ids, *(judged["id"] for judged in result.summary["judged"] if not judged["met"])]), ids
    assert ids or result.status == "ok"


def test_a_changed_file_of_a_run_is_refused(program, tmp_path):
    out = tmp_path / "run"
    assert program("fly", ROOT / "scenarios/glide.toml", "--quiet", "--set", "flight.duration_s=0.02", "--out", out).returncode == 0
    record = out / "record.parquet"
    wingbeat.Record.read(record)
    data = bytearray(record.read_bytes())
    data[100] ^= 1
    record.write_bytes(data)
    with pytest.raises(ValueError, match=r"record.parquet: changed after its run was written"):
        wingbeat.Record.read(record)


def test_numbers_of_numpy_are_taken(turn):
    keys = {"start.roll_deg": np.float64(2.5), "start.velocity_m_s": np.array([1.0, 0.0, 0.25]), "seed": np.int64(3)}
    plain = {"start.roll_deg": 2.5, "start.velocity_m_s": [1.0, 0.0, 0.25], "seed": 3}
    assert wingbeat.Scenario(turn, keys).toml == wingbeat.Scenario(turn, plain).toml
    with pytest.raises(ValueError, match=f"seed = {2**70}: allowed is a whole number of 64 bits"):
        wingbeat.Scenario(turn, {"seed": 2**70})


def test_a_wake_is_the_programs_wake(program, tmp_path):
    small = ("--quiet", "--prescribed", "--chordwise", "2", "--spanwise", "8")
    case = ROOT / "cases/flap_f1.toml"
    sets = {"time.cycles": 3}
    done = program("wake", case, *small, "--steps", "16", "--out", tmp_path / "case", *sets_of(sets))
    assert done.returncode == 0, done.stderr
    asked = {"prescribed": True, "chordwise": 2, "spanwise": 8}
    wake = wingbeat.wake(case, sets, steps=16, **asked)
    assert wake.status == "ok"
    assert wake.summary == json.loads((tmp_path / "case/summary.json").read_text())
    wake.stretches[0].record.write(tmp_path / "case.parquet")
    assert (tmp_path / "case.parquet").read_bytes() == (tmp_path / "case/record.parquet").read_bytes()
    vtk = (tmp_path / "case/upstroke_begins.vtk").read_text()
    assert wake.stretches[0].phases["upstroke begins"] == vtk

    turn = ROOT / "scenarios/banking_turn.toml"
    short = {"flight.duration_s": 0.6}
    done = program("fly", turn, "--quiet", "--out", tmp_path / "flight", *sets_of(short))
    done = program("wake", tmp_path / "flight", *small, "--cycles", "1", "--out", tmp_path / "wake")
    assert done.returncode == 0, done.stderr
    scenario = wingbeat.Scenario(turn, short)
    along = wingbeat.wake(wingbeat.fly(scenario), scenario=scenario, cycles=1, **asked)
    assert along.summary == json.loads((tmp_path / "wake/summary.json").read_text())
    with pytest.raises(ValueError, match="scenario: allowed is the scenario that was flown"):
        wingbeat.wake(wingbeat.fly(scenario))
    with pytest.raises(ValueError, match="cycles = 0: allowed is 1 or more"):
        wingbeat.wake(wingbeat.fly(scenario), scenario=scenario, cycles=0)
    for count in (0, -1, 2**70):
        with pytest.raises(ValueError, match=f"spanwise = {count}: allowed is"):
            wingbeat.wake(case, sets, spanwise=count)


def test_a_calibration_is_the_programs(program, tmp_path):
    file = tmp_path / "coarse.toml"
    base = ROOT / "calibrations/two_runs.toml"
    # One run of a cell at 1.75 kHz in place of 7: what a bench costs is its samples.
    cell = ["rig.cell.rate_hz=1750", "rig.cell.filter_hz=500"]
    model = json.dumps(["rig.aero.preset=paper", "rig.aero.law=linear", *cell])
    truth = json.dumps(["rig.aero.preset=full", "rig.aero.law=lev", *cell])
    file.write_text(
        f'name = "coarse"\nbase = "{base}"\nstarts = 1\nsteps_per_cycle = 60\nmodel = {model}\n'
        # Another model made the samples, and the misfit is meant.
        f'limits.calibration.wrong_model_chi_squared = 1e12\n[truth]\nset = {truth}\n[[runs]]\nrun = "{ROOT}/rigs/runs/roll15_speed08.toml"\n'
    )
    told = wingbeat.calibrate(file, information=True)
    assert told.record is None and told.values == {} and "surfaces.wing.lift_slope_per_rad" in told.information
    done = program("calibrate", file, "--quiet", "--out", tmp_path / "fit")
    assert done.returncode == 0, done.stderr
    fitted = wingbeat.calibrate(file)
    assert fitted.summary == json.loads((tmp_path / "fit/summary.json").read_text())
    fitted.record.write(tmp_path / "record.parquet")
    assert (tmp_path / "record.parquet").read_bytes() == (tmp_path / "fit/record.parquet").read_bytes()
    assert set(fitted.values) == set(fitted.errors)
    (tmp_path / "numbers.toml").write_text(fitted.numbers)
    turn = wingbeat.Scenario(
        ROOT / "scenarios/banking_turn.toml", {"robot.numbers": str(tmp_path / "numbers.toml")}
    )
    assert turn.mass_kg > 0.0


def test_numbers_by_name_are_given_as_numbers_toml_writes_them():
    case = ROOT / "cases/flap_f2.toml"
    few = {"time.cycles": 1, "time.steps_per_cycle": 24, "aero.full.strips": 8}
    drag = {"surfaces.wing.cd0": 0.06, "surfaces.wing.lift_slope_per_rad": 5.0}
    nested = wingbeat.tether(case, {**few, "numbers": drag})
    by_path = wingbeat.tether(case, {**few, **{f'numbers."{name}"': value for name, value in drag.items()}})
    assert nested.record == by_path.record
    assert wingbeat.tether(case, few).record != nested.record
    flown = wingbeat.Scenario(ROOT / "scenarios/glide.toml", {"robot": {"numbers": {"body.mass_kg": 0.02}}})
    assert flown.to_dict()["robot"]["numbers"] == {"body.mass_kg": 0.02}


def test_a_plan_is_the_programs_plan(program, tmp_path):
    least_power = {
        "storage": 1.0,
        "up_n": 0.08,
        "frequency_hz": [3.5, 3.5],
        "nose_up_deg": [15.0, 15.0],
        "effort_w": 0.3,
        "intervals": 8,
        "meshes": 1,
        "tolerance": 1e-1,
    }
    sets = {f"plan.least_power.{key}": value for key, value in least_power.items()}
    scenario = ROOT / "scenarios/least_power_gait.toml"
    done = program("plan", scenario, "--quiet", "--out", tmp_path / "run", *sets_of(sets))
    # On so coarse a mesh it is not resolved, and is kept.
    assert done.returncode == 3 and "not_resolved" in done.stderr, done.stderr
    plan = wingbeat.plan(scenario, sets)
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    times = {"solve_s", "processor_s"}
    assert {k: v for k, v in plan.summary.items() if k not in times} == {
        k: v for k, v in summary.items() if k not in times
    }
    plan.nodes.write(tmp_path / "plan.parquet")
    assert (tmp_path / "plan.parquet").read_bytes() == (tmp_path / "run/plan.parquet").read_bytes()
    assert plan.constants == json.loads((tmp_path / "run/plan.json").read_text())
    plan.record.write(tmp_path / "record.parquet")
    assert (tmp_path / "record.parquet").read_bytes() == (tmp_path / "run/record.parquet").read_bytes()
    assert plan.files
    for name, text in plan.files.items():
        assert (tmp_path / "run" / name).read_text() == text


def test_a_run_of_the_bench_is_the_programs(program, tmp_path):
    run, sets = ROOT / "rigs/runs/bench.toml", {"hold.each_s": 0.5}
    done = program("rig", "simulate", run, "--quiet", "--out", tmp_path / "run", *sets_of(sets))
    [bench] = wingbeat.rig(run, sets)
    assert (bench.status, done.returncode) == ("ok", 0), done.stderr
    folder = tmp_path / "run" / bench.name
    bench.record.write(tmp_path / "record.parquet")
    assert (tmp_path / "record.parquet").read_bytes() == (folder / "record.parquet").read_bytes()
    summary = json.loads((folder / "summary.json").read_text())
    assert bench.summary == {key: summary[key] for key in bench.summary}


def test_processed_samples_are_the_programs(program, tmp_path):
    run, sets = ROOT / "rigs/runs/bench.toml", {"hold.each_s": 4.0, "rig.cell.rate_hz": 1750.0, "rig.cell.filter_hz": 500.0}
    [bench] = wingbeat.rig(run, sets)
    bench.record.write(tmp_path / "samples.parquet")
    out = ("--quiet", "--out", tmp_path / "out")
    done = program("rig", "process", tmp_path / "samples.parquet", "--run", run, *out, *sets_of(sets))
    assert done.returncode == 0, done.stderr
    processed = wingbeat.process(tmp_path / "samples.parquet", run, sets)
    processed.record.write(tmp_path / "record.parquet")
    assert (tmp_path / "record.parquet").read_bytes() == (tmp_path / "out/bench.parquet").read_bytes()
    assert processed.summary == json.loads((tmp_path / "out/summary.json").read_text())
    assert processed.status == processed.summary["status"] == "ok"
    with pytest.raises(ValueError, match="window_s"):
        wingbeat.process(tmp_path / "samples.parquet", run, sets, window_s=(float("nan"), 3.0))


def test_a_folder_of_runs_is_processed_as_by_the_program(program, tmp_path):
    sets = {"hold.each_s": 4.0, "rig.cell.rate_hz": 1750.0, "rig.cell.filter_hz": 500.0}
    runs = tmp_path / "runs.toml"
    for name in ["a", "b"]:
        text = (ROOT / "rigs/runs/bench.toml").read_text().replace('name = "bench"', f'name = "{name}"')
        text = text.replace('rig = "../', f'rig = "{ROOT}/rigs/')
        (tmp_path / f"{name}.toml").write_text(text)
    runs.write_text('runs = ["a.toml", "b.toml"]\n')
    assert program("rig", "simulate", runs, "--quiet", "--out", tmp_path / "sim", *sets_of(sets)).returncode == 0
    process = {"process.bins": 100}
    done = program("rig", "process", tmp_path / "sim", "--quiet", "--out", tmp_path / "out", *sets_of(process))
    assert done.returncode == 0, done.stderr
    together = wingbeat.process_all(tmp_path / "sim", overrides=process)
    assert together.summary == json.loads((tmp_path / "out/summary.json").read_text())
    assert together.status == "ok" and list(together.records) == list(together.documents) == ["a", "b"]

    def same(record, file):
        record.write(tmp_path / "record.parquet")
        assert (tmp_path / "record.parquet").read_bytes() == (tmp_path / file).read_bytes()

    for name, record in together.records.items():
        same(record, f"out/{name}.parquet")
    # Runs at rest have an envelope each, and none together.
    assert together.envelope is None and not (tmp_path / "out/envelope.parquet").exists()
    # A run that is given is that of every folder.
    with pytest.raises(ValueError, match="a second run called"):
        wingbeat.process_all(tmp_path / "sim", tmp_path / "a.toml", sets)
    one = wingbeat.process_all(tmp_path / "sim/a", tmp_path / "a.toml", sets)
    assert list(one.records) == ["a"]
    alone = ("--run", tmp_path / "a.toml", "--quiet", "--out", tmp_path / "alone")
    assert program("rig", "process", tmp_path / "sim/a", *alone, *sets_of(sets)).returncode == 0
    same(one.envelope, "alone/envelope.parquet")
    with pytest.raises(ValueError, match=r"run=\"RUN.toml\""):
        wingbeat.process_all(tmp_path / "sim/a/record.parquet")


def test_samples_that_are_suspect_are_a_warning(tmp_path):
    run, sets = ROOT / "rigs/runs/bench.toml", {"hold.each_s": 4.0, "rig.cell.rate_hz": 1750.0, "rig.cell.filter_hz": 500.0}
    [bench] = wingbeat.rig(run, sets)
    bench.record.write(tmp_path / "samples.parquet")
    columns = {name: f"-{name}" for name in ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")}
    with pytest.warns(wingbeat.ResultWarning) as warned:
        processed = wingbeat.process(tmp_path / "samples.parquet", run, {**sets, "process.input.columns": columns})
    assert processed.status == "suspect_data" and processed.summary["reason"]
    assert "status.suspect_data" in [each.message.id for each in warned]


def test_a_run_of_the_bench_may_be_a_dictionary(tmp_path):
    import tomllib

    run, sets = ROOT / "rigs/runs/bench.toml", {"hold.each_s": 2.0, "rig.cell.rate_hz": 1750.0, "rig.cell.filter_hz": 500.0}
    [bench] = wingbeat.rig(run, sets)
    whole = tomllib.loads(bench.document)
    [again] = wingbeat.rig(whole)
    assert again.summary == bench.summary
    bench.record.write(tmp_path / "samples.parquet")
    sampled = tmp_path / "samples.parquet"
    assert wingbeat.process(sampled, whole).summary == wingbeat.process(sampled, run, sets).summary


def test_a_case_is_compared_and_refined_as_the_program_does(program, tmp_path):
    case, sets = ROOT / "cases/plunge.toml", {"time.steps_per_cycle": 48, "aero.full.strips": 12}
    cycle = wingbeat.tether(case, sets)
    rows = slice(-49, None)
    t, lift = cycle.record["t"][rows], cycle.record["force_wind_lift"][rows]
    measured = "t,force_wind_lift\n" + "".join(f"{a!r},{1.1 * b!r}\n" for a, b in zip(t.tolist(), lift.tolist()))
    (tmp_path / "measured.csv").write_text(measured)
    more = ("--quiet", "--out", tmp_path / "run", "--converge", "--compare", tmp_path / "measured.csv")
    done = program("tether", case, *more, *sets_of(sets))
    assert (tmp_path / "run/summary.json").exists(), done.stderr
    moved = wingbeat.tether(case, sets, compare=tmp_path / "measured.csv", converge=True)
    assert moved.summary == json.loads((tmp_path / "run/summary.json").read_text())
    # A straight line between 48 samples of a cycle leaves sinc^2(1/48) of it.
    assert moved.summary["compare"][0]["gain"] == pytest.approx(1.1 * np.sinc(1 / 48) ** 2, abs=1e-4)
    assert list(moved.cycle)[0] == "phase"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("robot.body.mass_kg", -1.0),
        ("robot.body.mas_kg", 0.01),
        ("flight.duration_s", "long"),
        ("aero.law", "stal"),
        ("flight.step_s", 1e300),
        ("manoeuvre", 3),
        ("start.velocity_m_s", [1.5, 1e-9, float("inf")]),
    ],
)
def test_bad_input_is_refused_in_the_programs_words(program, turn, key, value):
    done = program("fly", "scenarios/banking_turn.toml", "--set", f"{key}={value}")
    assert done.returncode == 2
    with pytest.raises(ValueError) as refused:
        wingbeat.fly(ROOT / "scenarios/banking_turn.toml", {key: value})
    said = done.stderr.removeprefix("error: ").removesuffix("\n")
    assert str(refused.value).replace(str(ROOT) + "/", "") == said


def test_what_has_no_place_in_a_configuration_is_refused(turn):
    with pytest.raises(TypeError, match="flight.duration_s: a object"):
        wingbeat.fly(turn, {"flight.duration_s": object()})
    with pytest.raises(ValueError, match="allowed are .*banking_turn.toml"):
        wingbeat.shipped("scenarios/none.toml")
    with pytest.raises(ValueError, match="a Scenario is checked already"):
        wingbeat.fly(wingbeat.Scenario(turn), SHORT)


def test_records_share_memory_and_carry_units(turn):
    record = wingbeat.fly(turn, SHORT).record
    table = record.to_pandas()
    assert table.attrs["units"]["roll"] == "rad"
    assert table.attrs["frames"]["p_WB_x"] == "W"
    assert np.shares_memory(table["roll"].to_numpy(), record["roll"])
    assert not record["roll"].flags.writeable
    assert record.to_numpy(["t", "roll"]).shape == (record.rows, 2)
    assert record.to_numpy([]).shape == (record.rows, 0)
    with pytest.raises(KeyError, match="allowed are t, phase"):
        record["rol"]


def test_written_records_are_read_again(turn, tmp_path):
    import pandas as pd

    record = wingbeat.fly(turn, SHORT).record
    record.write(tmp_path / "record.parquet")
    again = wingbeat.Record.read(tmp_path / "record.parquet")
    assert again.columns == record.columns
    assert all(np.array_equal(again[name], record[name]) for name in record)
    assert pd.read_parquet(tmp_path / "record.parquet").attrs == record.to_pandas().attrs


def test_strips_are_an_array_of_time_strip_and_component(turn):
    flight = wingbeat.fly(turn, SHORT | {"flight.record_strips_every_s": 0.01, "aero.preset": "full"})
    strips = flight.strips
    array = np.asarray(strips)
    assert array.shape == (len(strips.t), strips.count, len(strips.components)) == (11, 16, array.shape[2])
    lift = strips["force_z"]
    assert np.shares_memory(lift, strips.record["force_z"])
    assert np.array_equal(lift, array[:, :, strips.components.index("force_z")])
    assert np.array_equal(strips["strip"][3], np.arange(16))


def test_runs_of_a_grid_are_marks_and_rising_ones_a_line():
    columns = {"run": [0.0, 1.0, 2.0, 3.0], "speed": [1.0, 2.0, 1.0, 2.0], "mean_lift": [1.0, 2.0, 3.0, 4.0]}
    grid = wingbeat.Record([(name, "", "", -np.inf, np.inf, np.array(values)) for name, values in columns.items()])
    (line,) = grid.plot("mean_lift", against="speed").axes[0].lines
    assert (line.get_linestyle(), line.get_marker()) == ("None", "o")
    (line,) = grid.plot("mean_lift", against="run").axes[0].lines
    assert (line.get_linestyle(), line.get_marker()) == ("-", "None")


def test_figures_need_no_display(turn, tmp_path):
    flight = wingbeat.fly(turn, SHORT)
    figure = flight.plot()
    assert [panel.get_ylabel() for panel in figure.axes] == ["[deg]", "[m]", "[deg]"]
    figure.savefig(tmp_path / "flight.png")
    assert (tmp_path / "flight.png").stat().st_size > 10_000
    with pytest.raises(ValueError, match="allowed are t, phase"):
        flight.plot("no_such")

//! Runs on the rig: what is refused of samples, what a fit finds.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::math::Jet;
use wingbeat::rig::cell::{CellSpec, LoadCell};
use wingbeat::scenario::Document;
use wingbeat::simulate::{Column, Record};
use wingbeat_calibrate::measured::{MeasuredPass, observed};
use wingbeat_calibrate::{
    CalibrationFile, FitProgress, HarmonicLayout, ModelStructure, ObservedCycles, RigTarget, RunRole,
    checked, clean, expected_noise, respond, solve,
};

fn shipped(name: &str, overrides: &[&str]) -> CalibrationFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../calibrations").join(name);
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    CalibrationFile::new(Document::file(&path).unwrap().overridden(&overrides)).unwrap()
}

/// `two_runs.toml` with the model itself as its truth. Both read the cell at 1.75 kHz in place of 7: what a bench costs is
/// its samples.
fn of_itself(overrides: &[&str]) -> CalibrationFile {
    let set = "[\"rig.aero.preset=paper\", \"rig.aero.law=linear\", \"rig.cell.rate_hz=1750\", \
               \"rig.cell.filter_hz=500\"]";
    let both = [format!("model={set}"), format!("truth.set={set}")];
    let all: Vec<&str> = both.iter().map(String::as_str).chain(overrides.iter().copied()).collect();
    shipped("two_runs.toml", &all)
}

/// Runs, and the first one's passes.
fn first() -> (CalibrationFile, ModelStructure, Vec<MeasuredPass>) {
    let calibration = of_itself(&["truth.passes=3"]);
    let structure = calibration.structure(&[], &|_, _| None).unwrap();
    let truth = calibration.truth(&|_, _| None).unwrap();
    let made = clean(&truth[0]).unwrap();
    let spec = calibration.spec.truth.as_ref().unwrap();
    let passes = (0..3).map(|pass| made.pass(&truth[0], spec, 1, pass).unwrap()).collect();
    (calibration, structure, passes)
}

fn see(target: &RigTarget, passes: &[MeasuredPass]) -> Result<ObservedCycles, String> {
    observed(target, passes, RunRole::Fitted, true).map_err(|error| error.to_string())
}

#[test]
fn the_cell_answers_harmonics_as_it_does_samples() {
    let calibration = shipped("two_runs.toml", &[]);
    let structure = calibration.structure(&[], &|_, _| None).unwrap();
    let mut cell: CellSpec = structure.model.targets[0].run.spec.rig.cell.clone();
    (cell.noise_steps, cell.bias, cell.drift_per_s) = (0.0, [0.0; 6], [0.0; 6]);
    let (frequency, harmonic) = (3.5, 9);
    let layout = HarmonicLayout { channels: 6, harmonics: harmonic };
    let mut cycle = vec![0.0; layout.len()];
    cycle[layout.at(2, 2 * harmonic - 1)] = 5.0;
    let wave = |cycle: &[f64], t: f64| layout.value(cycle, 2, std::f64::consts::TAU * frequency * t);
    let load = |t: f64| {
        let mut six = [0.0; 6];
        six[2] = wave(&cycle, t);
        wingbeat::rig::cell::wrench(six)
    };
    let step = 1.0 / cell.rate_hz;
    let mut real = LoadCell::new(&cell, &load(0.0), 0).unwrap();
    let shown: Vec<f64> = (0..7000).map(|k| real.sample(&load(f64::from(k) * step)).values[2]).collect();
    let mut expected = cycle.clone();
    respond(&cell, frequency, layout, &mut expected);
    let resolution = cell.calibration.resolution()[2];
    for k in 5000..7000 {
        let apart = shown[k] - wave(&expected, k as f64 * step);
        assert!(apart.abs() < 0.6 * resolution, "{k}: {apart}");
    }
}

#[test]
fn samples_that_cannot_be_the_runs_are_refused_with_what_would_be_right() {
    let (_, structure, passes) = first();
    let target = &structure.model.targets[0];
    assert_eq!(see(target, &passes).unwrap().cycles.len(), 9);
    let with = |change: &dyn Fn(&mut MeasuredPass)| {
        let mut changed = passes.clone();
        change(&mut changed[1]);
        see(target, &changed)
    };
    let twice = with(&|pass| *pass = passes[0].clone()).unwrap_err();
    assert!(twice.contains("the very samples of"), "{twice}");
    let slower = with(&|pass| pass.phase.iter_mut().for_each(|phase| *phase *= 0.97)).unwrap_err();
    assert!(slower.contains("frequency_hz=3.39"), "{slower}");
    // A gap of NaN rows costs its cycle.
    let gap = |pass: &mut MeasuredPass| {
        let at = pass.time.partition_point(|t| *t < 1.3);
        pass.channels[2][at..at + 40].fill(f64::NAN);
    };
    let holed = with(&gap).unwrap();
    assert_eq!((holed.cycles.len(), holed.left_out), (8, 1));
    let nothing = with(&|pass| pass.channels[0].fill(f64::NAN)).unwrap_err();
    assert!(nothing.contains("rest"), "{nothing}");
    let full = with(&|pass| {
        let from = pass.time.partition_point(|t| *t < 0.0);
        pass.channels[2][from..].fill(17.0);
    });
    let full = full.unwrap_err();
    assert!(
        full.contains("saturated samples, the first by Fz") && full.contains("process.saturated"),
        "{full}"
    );
    let no_encoder = with(&|pass| pass.phase.clear()).unwrap_err();
    assert!(no_encoder.contains("process.phase"), "{no_encoder}");
    let short = with(&|pass| {
        let to = pass.time.partition_point(|t| *t < 0.5);
        pass.time.truncate(to);
        pass.phase.truncate(to);
        pass.channels.iter_mut().for_each(|channel| channel.truncate(to));
    });
    assert!(short.unwrap_err().contains("process.input.start_s"));
}

#[test]
fn status_words_of_the_box_are_those_of_processed_runs() {
    let (_, mut structure, passes) = first();
    let with = |target: &RigTarget, word: f64| {
        let mut changed = passes.clone();
        let (from, to) =
            (passes[1].time.partition_point(|t| *t < 1.3), passes[1].time.partition_point(|t| *t < 1.32));
        changed[1].status = vec![0.0; passes[1].time.len()];
        changed[1].status[from..to].fill(word);
        (see(target, &changed), to - from)
    };
    let target = &structure.model.targets[0];
    let (saturated, serious) = (f64::from(0x8002_0000_u32), f64::from(0x8000_0001_u32));
    let (refused, count) = with(target, saturated);
    let refused = refused.unwrap_err();
    assert!(
        refused.contains(&format!("{count} saturated samples, the first by the status word")),
        "{refused}"
    );
    let (left, count) = with(target, serious);
    let left = left.unwrap();
    assert_eq!((left.cycles.len(), left.left_out), (8, 1));
    assert!(left.oddities[0].contains(&format!("{count} are not to be trusted")), "{:?}", left.oddities);
    // In the rest they are no part of the tare.
    let mut rest = passes.clone();
    rest[0].status = vec![0.0; passes[0].time.len()];
    let end = passes[0].time.partition_point(|t| *t < -0.05);
    rest[0].status[end - 40..end].fill(serious);
    rest[0].channels[2][end - 40..end].fill(7.0);
    let (clean, held) = (see(target, &passes).unwrap(), see(target, &rest).unwrap());
    let apart = clean.mean.iter().zip(&held.mean).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-3, "{apart}");
    let leave_out = of_itself(&[
        "truth.passes=3",
        "model=[\"process.saturated=leave_out\", \"rig.aero.preset=paper\", \"rig.aero.law=linear\", \"rig.cell.rate_hz=1750\", \"rig.cell.filter_hz=500\"]",
    ]);
    structure = leave_out.structure(&[], &|_, _| None).unwrap();
    let (left, _) = with(&structure.model.targets[0], saturated);
    assert_eq!(left.unwrap().left_out, 1);
}

#[test]
fn the_model_follows_the_joints_that_were_recorded() {
    let (_, mut structure, mut passes) = first();
    let target = &mut structure.model.targets[0];
    let planned = target.predict(&[]).unwrap();
    assert!(!target.follow(&passes), "no pass has joints");
    let carrier = target.carrier().clone();
    let rate = 12.0;
    let shaken = |by: f64, pass: &MeasuredPass| {
        let mut columns = vec![Column { values: pass.time.clone(), ..Column::new("t", "s", "") }];
        for j in 0..target.run.arm.dof() {
            let wave = |t: f64| [(rate * t).sin(), rate * (rate * t).cos(), -rate * rate * (rate * t).sin()];
            for (k, name) in ["q", "dq", "ddq"].into_iter().enumerate() {
                let value = |t: &f64| {
                    let Jet { x, d, dd } = carrier.joints(*t).unwrap()[j];
                    [x, d, dd][k] + by * wave(*t)[k]
                };
                let values = pass.time.iter().map(value).collect();
                columns.push(Column { values, ..Column::new(format!("{name}{}", j + 1), "", "") });
            }
        }
        Some(Record::new(columns, 0).unwrap())
    };
    let apart = |target: &RigTarget| {
        let told = target.predict(&[]).unwrap();
        let largest = |of: &[f64]| of.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let differ: Vec<f64> = told.iter().zip(&planned).map(|(a, b)| a - b).collect();
        largest(&differ) / largest(&planned)
    };
    let motions = [0.0, 0.005, -0.005].map(|by| shaken(by, &passes[0]));
    let target = &mut structure.model.targets[0];
    passes.truncate(2);
    let mut follow = |of: [usize; 2]| {
        passes.iter_mut().zip(of).for_each(|(pass, k)| pass.motion.clone_from(&motions[k]));
        assert!(target.follow(&passes));
        apart(target)
    };
    let [planned, shaken, mean] = [[0, 0], [1, 1], [1, 2]].map(&mut follow);
    assert!(planned < 1e-6 && shaken > 0.01 && mean < 1e-6, "{planned} {shaken} {mean}");
    passes[1].motion = None;
    assert!(!target.follow(&passes), "one pass has no joints");
}

#[test]
fn priors_that_cannot_be_and_of_what_no_load_depends_on_are_refused() {
    let with = |prior: &str| {
        let parameters = format!(
            "parameters=[{{name=\"surfaces.wing.cd0\"}}, {{name=\"surfaces.wing.stall_angle_rad\", prior={prior}}}]"
        );
        let calibration = of_itself(&["truth.passes=3", &parameters]);
        let prepared = calibration.prepared().map_err(|error| error.to_string())?;
        prepared.check().map_err(|error| error.to_string())
    };
    let degrees = with("[12.0, 1.0]").unwrap_err();
    assert!(degrees.contains("parameters[1].prior[0] = 12"), "{degrees}");
    let silent = with("[0.2, 0.02]").unwrap_err();
    assert!(silent.contains("surfaces.wing.stall_angle_rad: no load of the runs depends on it"), "{silent}");
}

#[test]
fn swapped_axes_and_shifted_phases_are_found_and_proposed() {
    let (_, structure, passes) = first();
    let values: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
    let target = &structure.model.targets[0];
    let told = |change: &dyn Fn(&mut MeasuredPass)| {
        let mut changed = passes.clone();
        changed.iter_mut().for_each(change);
        let runs = [observed(target, &changed, RunRole::Fitted, true).unwrap()];
        checked(&structure, &runs, &values).map_err(|error| error.to_string())
    };
    assert_eq!(told(&|_| {}), Ok(Vec::new()));
    let swapped = told(&|pass| pass.channels.swap(0, 2)).unwrap_err();
    assert!(
        swapped.contains("Fx is Fz of the file") && swapped.contains("Fz is Fx of the file"),
        "{swapped}"
    );
    let flipped = told(&|pass| pass.channels[2].iter_mut().for_each(|x| *x = -*x)).unwrap_err();
    assert!(flipped.contains("Fz is -Fz of the file") && !flipped.contains("Fx is"), "{flipped}");
    let late = told(&|pass| pass.phase.iter_mut().for_each(|phase| *phase += 0.2)).unwrap_err();
    assert!(late.contains("11.5 deg behind") && late.contains("gait.phase_rad"), "{late}");
    let little = told(&|pass| pass.phase.iter_mut().for_each(|phase| *phase += 6_f64.to_radians()));
    assert!(little.is_err_and(|what| what.contains("deg behind")), "6 deg are more than 5");
    assert_eq!(told(&|pass| pass.phase.iter_mut().for_each(|phase| *phase += 0.06)), Ok(Vec::new()));
    let clipped =
        told(&|pass| pass.channels[4].iter_mut().for_each(|x| *x = x.clamp(-0.02, 0.02))).unwrap().join(" ");
    assert!(clipped.contains("samples of Ty stand at"), "{clipped}");
}

/// Counts that come and go are fitted, as `rig process` does; an encoder that goes back all the time is refused with what turns it round.
#[test]
fn an_encoder_whose_counts_go_back_is_fitted() {
    let (_, structure, passes) = first();
    let target = &structure.model.targets[0];
    let clean = see(target, &passes).unwrap();
    let count = std::f64::consts::TAU / 1024.0;
    let mut counted = passes.clone();
    for pass in &mut counted {
        for (k, phase) in pass.phase.iter_mut().enumerate() {
            // Counts come and go by one.
            *phase = ((*phase / count).round() + [-1.0, 1.0, 0.0][k % 3]) * count;
        }
        assert!(pass.phase.windows(2).any(|pair| pair[1] < pair[0]));
    }
    let fitted = see(target, &counted).unwrap();
    let size = clean.mean.iter().map(|x| x.abs()).fold(0.0, f64::max);
    for (a, b) in clean.mean.iter().zip(&fitted.mean) {
        assert!((a - b).abs() < 0.01 * size, "{a} {b}");
    }
    let mut back = passes;
    back.iter_mut().flat_map(|pass| &mut pass.phase).for_each(|phase| *phase = -*phase);
    let told = see(target, &back).unwrap_err();
    assert!(told.contains("phase = \"-phase\""), "{told}");
}

#[test]
fn a_fit_of_the_right_model_finds_the_truth() {
    let calibration = of_itself(&["starts=1"]);
    let mut structure = calibration.structure(&[], &|_, _| None).unwrap();
    let none = |path: &Path, _: &wingbeat::scenario::RigRun| {
        Err(wingbeat_calibrate::Error::data(path.display().to_string(), "no file"))
    };
    let runs = calibration.observed(&mut structure, &|_, _| None, &none).unwrap();
    let truth: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
    structure.parameters.iter_mut().for_each(|parameter| parameter.start *= 1.15);
    let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
    let plan = calibration.plan();
    let solved = solve(&structure.model, &runs, &structure.parameters, &plan, &mut (), watch).unwrap();
    for (k, truth) in truth.iter().enumerate() {
        let (value, error) = (solved.values[k], solved.errors()[k]);
        let name = &structure.parameters[k].name;
        assert!((value - truth).abs() < 4.0 * error, "{name}: {value} +- {error}, truth {truth}");
        assert!(error < 0.1 * truth.abs(), "{name}: {error}");
    }
    let predicted = solved.predicted(1).unwrap();
    for (channel, share) in predicted.coverage(&runs[1], &predicted.deviations).iter().enumerate() {
        assert!(*share > 0.8, "channel {channel}: {share}");
    }
}

#[test]
fn the_noise_of_a_run_to_come_is_that_of_its_samples() {
    let calibration = of_itself(&["starts=1"]);
    let mut structure = calibration.structure(&[], &|_, _| None).unwrap();
    let none = |path: &Path, _: &wingbeat::scenario::RigRun| {
        Err(wingbeat_calibrate::Error::data(path.display().to_string(), "no file"))
    };
    let runs = calibration.observed(&mut structure, &|_, _| None, &none).unwrap();
    let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
    let plan = calibration.plan();
    let solved = solve(&structure.model, &runs, &structure.parameters, &plan, &mut (), watch).unwrap();
    let expected = expected_noise(&solved, &structure.model.targets[1..], &runs[1..]).swap_remove(0);
    let layout = runs[1].layout;
    let size = |of: &[nalgebra::DMatrix<f64>], channel: usize| {
        let part = |part: usize| {
            HarmonicLayout::share(part) * of[HarmonicLayout::harmonic(part)][(channel, channel)]
        };
        (0..layout.width()).map(part).sum::<f64>().sqrt()
    };
    for channel in 0..6 {
        let found = size(&solved.problem.noise[1], channel);
        let (told, before) = (size(&expected, channel), size(&solved.problem.noise[0], channel));
        assert!(
            (told / found - 1.0).abs() < 0.4,
            "channel {channel}: {told} of {found}, {before} of the run made"
        );
    }
}

#[test]
fn static_tilts_tell_mass_and_centre_in_a_stage_of_their_own() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let tilts =
        format!("{{ run = \"{root}/rigs/identification/static_tilts.toml\", set = [\"hold.each_s=0.5\"] }}");
    let turn = format!("{{ run = \"{root}/rigs/runs/roll15_speed08.toml\" }}");
    let parameters = "parameters=[{ name = \"mount.mass_kg\", stage = 1 }, { name = \"body.mass_kg\", stage = 1 }, \
                      { name = \"body.com_m[0]\", stage = 1, low = -0.1, high = 0.1 }, \
                      { name = \"surfaces.wing.cd90\", stage = 2 }]";
    let calibration =
        of_itself(&["starts=1", "truth.passes=3", &format!("runs=[{tilts}, {turn}]"), parameters]);
    let mut structure = calibration.structure(&[], &|_, _| None).unwrap();
    let none = |path: &Path, _: &wingbeat::scenario::RigRun| {
        Err(wingbeat_calibrate::Error::data(path.display().to_string(), "no file"))
    };
    let runs = calibration.observed(&mut structure, &|_, _| None, &none).unwrap();
    assert_eq!((runs[0].layout.harmonics, runs[0].left_out), (6, 0));
    let truth: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
    assert!(checked(&structure, &runs, &truth).is_ok());
    for (k, parameter) in structure.parameters.iter_mut().enumerate() {
        parameter.start = if k == 2 { truth[k] + 0.004 } else { 1.1 * truth[k] };
    }
    let mut stages = Vec::new();
    let watch = &mut |at: &FitProgress| {
        stages.push((at.stage, at.values.to_vec()));
        ControlFlow::Continue(())
    };
    let plan = calibration.plan();
    let solved = solve(&structure.model, &runs, &structure.parameters, &plan, &mut (), watch).unwrap();
    for (k, truth) in truth.iter().enumerate() {
        let (value, error) = (solved.values[k], solved.errors()[k]);
        let name = &structure.parameters[k].name;
        assert!((value - truth).abs() < 5.0 * error, "{name}: {value} +- {error}, truth {truth}");
    }
    // The first stage ends, by the tilts alone, near the truth with the drag still at its start.
    let (_, then) = stages.iter().find(|(stage, _)| *stage == 2).unwrap();
    assert!((then[2] - truth[2]).abs() < 0.001, "{then:?}");
    assert_eq!(then[3], structure.parameters[3].start);
}

#[test]
fn designs_are_laid_out_and_what_cannot_be_planned_is_told() {
    let stand = "{ run = \"../rigs/identification/faster_wind.toml\", set = [\"hold.each_s=1.0\"], vary = [\
                 { key = \"frequency_hz\", values = [2.5, 5.0] }, { key = \"wind_m_s\", values = [\"[-0.8, 0.0, 0.0]\"] }] }";
    let turn = "{ run = \"../rigs/runs/roll15_speed08.toml\", vary = [{ key = \"turn.speed_m_s\", values = [0.8, 1.9] }] }";
    let calibration = shipped(
        "two_runs.toml",
        &[&format!("design=[{stand}, {turn}]").replace("..", concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))],
    );
    let (candidates, refused) = calibration.candidates(&|_, _| None).unwrap();
    let names: Vec<&str> = candidates.model.targets.iter().map(|target| target.name.as_str()).collect();
    assert_eq!(names[0], "frequency_hz=2.5 wind_m_s=[-0.8, 0.0, 0.0]");
    assert_eq!((names.len(), refused.len()), (3, 1), "{names:?} {refused:?}");
    assert!(
        refused[0].contains("turn.speed_m_s=1.9") && refused[0].contains("cannot be planned"),
        "{refused:?}"
    );
    let starts: Vec<f64> = candidates.parameters.iter().map(|parameter| parameter.start).collect();
    let target = &candidates.model.targets[1];
    let share = target.load_share(&target.predict(&candidates.model.numbers(&starts)).unwrap());
    assert!((0.02..5.0).contains(&share), "{share}");
}

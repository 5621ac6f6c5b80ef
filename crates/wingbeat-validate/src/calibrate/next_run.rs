//! The run that a calibration asks for: its promise against what it brings, and against runs at random.

use super::{all_clean, measured, no_answer, shipped, structure, truth};
use crate::{Error, Row};
use std::ops::ControlFlow;
use wingbeat::math::Random;
use wingbeat_calibrate::design::{largest, rank};
use wingbeat_calibrate::{Observed, Plan, Problem, Progress, Solved, solve};

/// Random runs that the designed one is held against.
const RANDOM: usize = 20;

/// Overrides of candidates: a stand in a wind at some tilt, frequency and speed.
fn candidate(random: &mut Random) -> String {
    let (frequency, speed) = (random.between(2.0, 5.0), random.between(0.5, 1.8));
    let (side, roll, pitch) = (
        random.between(-20.0, 20.0_f64).to_radians(),
        random.between(-30.0, 30.0),
        random.between(-25.0, 5.0),
    );
    format!(
        "{{ name = \"NAME\", run = \"RIGS/identification/faster_wind.toml\", set = [\"frequency_hz={frequency:.3}\", \
         \"wind_m_s=[{:.4}, {:.4}, 0.0]\", \"hold.tilts_deg=[[{roll:.2}, {pitch:.2}]]\", \"hold.each_s=3.0\", \"rig.cell.calibration=SI-25-0.25\"] }}",
        -speed * side.cos(),
        speed * side.sin()
    )
}

fn worst(solved: &Solved, k: usize) -> f64 {
    solved.errors()[k]
}

/// Standard error promised and found; that of the designed run against the median of random ones.
pub fn rows() -> Result<Vec<Row>, Error> {
    let mut random = Random::stream(23, 0);
    let candidates: Vec<String> =
        (0..RANDOM).map(|k| candidate(&mut random).replace("NAME", &format!("c{k}"))).collect();
    let base = "{ run = \"RIGS/runs/roll10_speed08.toml\" }, { run = \"RIGS/runs/roll15_speed08.toml\" }";
    let rigs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../rigs");
    let list = format!("runs=[{base}, {}]", candidates.join(", ")).replace("RIGS", rigs);
    let calibration = shipped(
        "seven_runs.toml",
        &[
            &list,
            "structures=[]",
            "truth.set=[\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]",
            "discrepancy=false",
            "parameters[6].prior=[0.0, 10.0]",
        ],
    )?;
    let (own, targets) = (structure(&calibration)?, truth(&calibration)?);
    let all = measured(&calibration, &targets, &all_clean(&targets)?, 3)?;
    let plan = Plan { starts: 1, spread: 0.0, seed: 0, discrepancy: false };
    let fitted = |of: &[usize]| -> Vec<Observed> {
        let held = |(k, run): (usize, &Observed)| Observed { held_out: !of.contains(&k), ..run.clone() };
        all.iter().enumerate().map(held).collect()
    };
    let solve_with = |runs: &[Observed], take: &mut dyn FnMut(&Solved) -> Result<(), Error>| {
        let watch = &mut |_: &Progress| ControlFlow::Continue(());
        let solved = solve(&own.model, runs, &own.parameters, &plan, &mut (), watch).map_err(no_answer)?;
        take(&solved)
    };
    let first = fitted(&[0, 1]);
    let (mut promised, mut parameter, mut now) = (Vec::new(), 0, 0.0);
    solve_with(&first, &mut |solved| {
        parameter = largest(&solved.errors(), &own.parameters).0;
        now = worst(solved, parameter);
        let problem = Problem::new(&own.model, &first, &own.parameters).map_err(no_answer)?;
        promised = rank(solved, &problem).map_err(no_answer)?;
        Ok(())
    })?;
    let mut found = Vec::new();
    for k in 2..all.len() {
        let runs = fitted(&[0, 1, k]);
        solve_with(&runs, &mut |solved| {
            found.push((k, worst(solved, parameter)));
            Ok(())
        })?;
    }
    let best =
        promised.iter().find(|candidate| candidate.index >= 2).ok_or_else(|| no_answer("no candidate"))?;
    let of = |k: usize| found.iter().find(|(run, _)| *run == k).map_or(f64::NAN, |(_, error)| *error);
    let realised = of(best.index);
    let mut others: Vec<f64> = found.iter().map(|(_, error)| *error).collect();
    others.sort_by(f64::total_cmp);
    let median = 0.5 * (others[others.len() / 2] + others[(others.len() - 1) / 2]);
    let ratio = best.errors[parameter] / realised;
    let name = &own.parameters[parameter].name;
    let source = "own truth, two runs and one more of 20 on a stand in a wind";
    let promise = format!(
        "|promised over found standard error of {name} - 1|: {:.2e} before, {:.2e} promised, {realised:.2e} found",
        now, best.errors[parameter]
    );
    Ok(vec![
        Row::judged("calibrate.next_run", source, &promise, (ratio - 1.0).abs(), 0.3, ""),
        Row::judged(
            "calibrate.next_run.gain",
            source,
            &format!("found over the median of 20 random runs ({median:.2e}): at most 1/1.5"),
            realised / median,
            1.0 / 1.5,
            "",
        ),
    ])
}

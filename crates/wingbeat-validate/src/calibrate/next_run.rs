//! The run that a calibration asks for: its promise against what it brings, and against runs at random.

use super::{all_clean, measured, no_answer, shipped, structure, truth};
use crate::{ComparisonRow, Error};
use std::ops::ControlFlow;
use wingbeat::math::Random;
use wingbeat_calibrate::design::largest;
use wingbeat_calibrate::{FitPlan, FitProgress, NextRun, ObservedCycles, RunRole, solve};

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

/// The runs that the design lays out: corners of the range of the random ones and places between.
const DESIGN: &str = "{ run = \"RIGS/identification/faster_wind.toml\", set = [\"hold.each_s=3.0\", \"rig.cell.calibration=SI-25-0.25\"], vary = [\
    { key = \"frequency_hz\", values = [2.0, 3.5] }, \
    { key = \"wind_m_s\", values = [\"[-1.8, 0.0, 0.0]\", \"[-1.6915, 0.6156, 0.0]\", \"[-1.6915, -0.6156, 0.0]\"] }, \
    { key = \"hold.tilts_deg\", values = [\"[[-30.0, 5.0]]\", \"[[0.0, 5.0]]\", \"[[30.0, 5.0]]\", \"[[-30.0, -10.0]]\", \
        \"[[0.0, -10.0]]\", \"[[30.0, -10.0]]\", \"[[-30.0, -25.0]]\", \"[[0.0, -25.0]]\", \"[[30.0, -25.0]]\"] } ] }";

/// Standard error promised and found; that of the designed run against the median of random ones.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut random = Random::stream(23, 0);
    let candidates: Vec<String> =
        (0..RANDOM).map(|k| candidate(&mut random).replace("NAME", &format!("c{k}"))).collect();
    let rigs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../rigs");
    let list = |of: &[String]| of.join(", ").replace("RIGS", rigs);
    let base =
        ["roll10_speed08", "roll15_speed08"].map(|run| format!("{{ run = \"RIGS/runs/{run}.toml\" }}"));
    let common = [
        "structures=[]",
        "truth.set=[\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]",
        "discrepancy=false",
        "parameters[6].prior=[0.0, 10.0]",
    ];
    let with = |more: &[&str]| shipped("seven_runs.toml", &[&common, more].concat());
    let plan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: false };
    let first_runs = format!("runs=[{}]", list(&base));

    // What is asked for, from the two runs alone.
    let designs = list(&[DESIGN.into()]);
    let asking = with(&[&first_runs, &format!("design=[{designs}]")])?;
    let (own, targets) = (structure(&asking)?, truth(&asking)?);
    let runs = measured(&asking, &targets, &all_clean(&targets)?, 3)?;
    let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
    let solved = solve(&own.model, &runs, &own.parameters, &plan, &mut (), watch).map_err(no_answer)?;
    let (parameter, _) = largest(&solved.errors(), &own.parameters);
    let now = solved.errors()[parameter];
    let (laid_out, _) = asking.candidates(&|_, _| None).map_err(no_answer)?;
    let passes = asking.spec.truth.as_ref().map_or(1, |truth| truth.passes);
    let ranked = NextRun::all(&laid_out, &solved, passes).map_err(no_answer)?;
    let best = ranked.first().ok_or_else(|| no_answer("no run can be made"))?;
    let chosen = asking.spec.design.iter().flat_map(|design| design.laid_out());
    let chosen = chosen.into_iter().find(|run| run.name.as_deref() == Some(best.name.as_str()));
    let chosen = chosen.ok_or_else(|| no_answer(format!("no run {}", best.name)))?;

    // What it brings, and what the random ones bring.
    let designed = format!(
        "{{ name = \"designed\", run = \"RIGS/identification/faster_wind.toml\", set = {:?} }}",
        chosen.set
    );
    let all_runs = list(&[&base[..], &[designed], &candidates].concat());
    let bringing = with(&[&format!("runs=[{all_runs}]")])?;
    let (own, targets) = (structure(&bringing)?, truth(&bringing)?);
    let all = measured(&bringing, &targets, &all_clean(&targets)?, 3)?;
    let found = |k: usize| -> Result<f64, Error> {
        let held = |(i, run): (usize, &ObservedCycles)| ObservedCycles {
            role: if i > 1 && i != k { RunRole::HeldOut } else { RunRole::Fitted },
            ..run.clone()
        };
        let runs: Vec<ObservedCycles> = all.iter().enumerate().map(held).collect();
        let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
        let solved = solve(&own.model, &runs, &own.parameters, &plan, &mut (), watch).map_err(no_answer)?;
        Ok(solved.errors()[parameter])
    };
    let realised = found(2)?;
    let mut others = (3..all.len()).map(found).collect::<Result<Vec<f64>, Error>>()?;
    wingbeat::math::order::ascend(&mut others);
    let median = 0.5 * (others[others.len() / 2] + others[(others.len() - 1) / 2]);
    let ratio = best.error_then / realised;
    let name = &own.parameters[parameter].name;
    let source = "own truth, two runs and one more on a stand in a wind";
    let promise = format!(
        "|promised over found standard error of {name} - 1|: {now:.2e} before, {:.2e} promised, {realised:.2e} found, of {} runs laid out ({})",
        best.error_then,
        ranked.len(),
        best.name
    );
    Ok(vec![
        ComparisonRow::judged("calibrate.next_run", source, &promise, (ratio - 1.0).abs(), 0.3, ""),
        ComparisonRow::judged(
            "calibrate.next_run.gain",
            source,
            &format!(
                "found over the median of 20 random runs ({median:.2e}, best of them {:.2e}): at most 1/1.5",
                others[0]
            ),
            realised / median,
            1.0 / 1.5,
            "",
        ),
    ])
}

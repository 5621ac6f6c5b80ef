//! The right model fitted to noisy runs of itself, fifty times.

use super::{all_clean, measured, no_answer, shipped, structure, truth};
use crate::{ComparisonRow, Error};
use std::ops::ControlFlow;
use wingbeat_calibrate::{FitPlan, FitProgress, NORMAL_95, solve, student_95};

/// Seeds of the noise.
const SEEDS: usize = 50;

/// Share of intervals that hold the truth, pooled and by parameter, and the stated errors against the scatter.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let calibration = shipped(
        "seven_runs.toml",
        &[
            "truth.set=[\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]",
            "discrepancy=false",
            "parameters[6].prior=[0.0, 10.0]",
        ],
    )?;
    let (mut own, targets) = (structure(&calibration)?, truth(&calibration)?);
    let clean = all_clean(&targets)?;
    let true_values: Vec<f64> = own.parameters.iter().map(|parameter| parameter.start).collect();
    // The fit begins elsewhere than at the truth.
    for parameter in &mut own.parameters {
        parameter.start = (parameter.start + 0.05 * parameter.scale()).clamp(parameter.low, parameter.high);
    }
    let plan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: false };
    let count = true_values.len();
    let (mut inside, mut inside_white) = (vec![0_usize; count], 0_u32);
    let (mut values, mut errors) = (vec![Vec::new(); count], vec![0.0; count]);
    for seed in 0..SEEDS {
        let runs = measured(&calibration, &targets, &clean, seed as u64)?;
        let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
        let solved = solve(&own.model, &runs, &own.parameters, &plan, &mut (), watch).map_err(no_answer)?;
        let (clustered, white) = (solved.errors(), solved.white_errors());
        for k in 0..count {
            let apart = (solved.values[k] - true_values[k]).abs();
            inside[k] += usize::from(apart <= student_95(solved.covariances.freedom) * clustered[k]);
            inside_white += u32::from(apart <= NORMAL_95 * white[k]);
            values[k].push(solved.values[k]);
            errors[k] += clustered[k] / SEEDS as f64;
        }
    }
    let source = "own truth, 50 seeds of noise, seven runs of 21 cycles";
    let total = (SEEDS * count) as f64;
    let pooled = inside.iter().sum::<usize>() as f64 / total;
    let mut rows = vec![ComparisonRow::judged(
        "calibrate.recovers_truth",
        source,
        &format!("|share of 95 % intervals that hold the truth ({pooled:.3}) - 0.95|"),
        (pooled - 0.95).abs(),
        0.03,
        "",
    )];
    let fewest = inside.iter().min().copied().unwrap_or(0);
    rows.push(ComparisonRow::judged(
        "calibrate.recovers_truth.each",
        source,
        "most misses of one parameter",
        (SEEDS - fewest) as f64,
        8.0,
        "",
    ));
    let mut worst = 0.0_f64;
    for k in 0..count {
        let mean = values[k].iter().sum::<f64>() / SEEDS as f64;
        let scatter =
            (values[k].iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (SEEDS as f64 - 1.0)).sqrt();
        let ratio = errors[k] / scatter;
        worst = worst.max((ratio - 1.0).abs());
        let metric =
            format!("{}: mean standard error over scatter; {} of 50 held", own.parameters[k].name, inside[k]);
        rows.push(ComparisonRow::shown(
            &format!("calibrate.recovers_truth.ratio_{k}"),
            source,
            &metric,
            ratio,
            "",
        ));
    }
    rows.push(ComparisonRow::judged(
        "calibrate.recovers_truth.errors",
        source,
        "largest |mean standard error over scatter - 1|",
        worst,
        0.2,
        "",
    ));
    let white = f64::from(inside_white) / total;
    rows.push(ComparisonRow::shown(
        "calibrate.recovers_truth.white",
        source,
        "share of intervals of independent samples that hold the truth",
        white,
        "",
    ));
    Ok(rows)
}

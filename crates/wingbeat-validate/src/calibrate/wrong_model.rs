//! A model that is not the one that made the runs, from twenty starts, held against runs unlike those it was fitted to.

use super::{all_clean, measured, no_answer, shipped, structure, truth};
use crate::{ComparisonRow, Error};
use std::ops::ControlFlow;
use wingbeat::math::Random;
use wingbeat_calibrate::{
    CycleModel, FitPlan, FitProgress, HarmonicLayout, NORMAL_95, ObservedCycles, PHASES, RunRole,
    SolvedCalibration, channel_name, phase_of, rms, solve,
};

/// Draws of the starts.
const DRAWS: usize = 20;
/// Share by which a start is off.
const OFF: f64 = 0.2;
/// Channels whose error must fall to half, and those whose error may not rise.
const HALVED: [usize; 3] = [2, 4, 5];

/// Rms of the noise of the run's mean, by channel.
fn floor(run: &ObservedCycles) -> Vec<f64> {
    let count = run.cycles.len() as f64;
    let channel = |channel: usize| {
        let of = |cycle: &Vec<f64>| {
            let apart: Vec<f64> = cycle.iter().zip(&run.mean).map(|(x, mean)| x - mean).collect();
            run.layout.mean_square(&apart, channel)
        };
        (run.cycles.iter().map(of).sum::<f64>() / (count - 1.0) / count).sqrt()
    };
    (0..run.layout.channels).map(channel).collect()
}

fn median(of: &mut [f64]) -> f64 {
    wingbeat::math::order::ascend(of);
    0.5 * (of[(of.len() - 1) / 2] + of[of.len() / 2])
}

/// Shares of values that a band must hold, and its largest half width over the error.
const HELD: [f64; 2] = [0.9, 0.99];
const WIDEST: f64 = 2.5;
/// Draws of errors.
const ERRORS: usize = 4000;

/// How often a band that is right would hold enough of two runs, be narrow enough, and both, in every channel: of errors that are drawn
/// with the very deviations that the band has, harmonic by harmonic those of what is left in the fitted runs; a channel's error is a few
/// numbers only, whose size in two runs is a matter of luck.
fn exact(solved: &SolvedCalibration, runs: usize) -> [f64; 3] {
    let layout = solved.problem.runs[solved.at.of[0]].layout;
    let mut power = vec![0.0; layout.len()];
    for (run, residual) in solved.at.of.iter().zip(&solved.at.residuals) {
        let left = solved.problem.coloured(*run, residual);
        power.iter_mut().zip(left).for_each(|(sum, x)| *sum += x * x / solved.at.of.len() as f64);
    }
    let alike = |channel: usize, part: usize| {
        let of = |part| power[layout.at(channel, part)];
        let k = HarmonicLayout::harmonic(part);
        if k == 0 { of(0) } else { 0.5 * (of(2 * k - 1) + of(2 * k)) }
    };
    let mut random = Random::stream(29, 0);
    let mut met = [0.0; 3];
    let waves: Vec<Vec<f64>> = (0..PHASES)
        .map(|k| (0..layout.width()).map(|part| HarmonicLayout::wave(part, phase_of(k))).collect())
        .collect();
    for _ in 0..ERRORS {
        let (mut holds, mut narrow) = (true, true);
        for channel in 0..layout.channels {
            let variances: Vec<f64> = (0..layout.width()).map(|part| alike(channel, part)).collect();
            let deviation = |wave: &Vec<f64>| -> f64 {
                wave.iter().zip(&variances).map(|(wave, of)| wave * wave * of).sum::<f64>().sqrt()
            };
            let half: Vec<f64> = waves.iter().map(|wave| NORMAL_95 * deviation(wave)).collect();
            let (mut inside, mut width) = (0.0, 0.0);
            for _ in 0..runs {
                let numbers: Vec<f64> = variances.iter().map(|of| of.sqrt() * random.normal()).collect();
                let values =
                    waves.iter().map(|wave| wave.iter().zip(&numbers).map(|(w, x)| w * x).sum::<f64>());
                let (mut within, mut square) = (0, 0.0);
                for (value, half) in values.zip(&half) {
                    within += usize::from(value.abs() <= *half);
                    square += value * value / PHASES as f64;
                }
                inside += within as f64 / (PHASES * runs) as f64;
                width += half.iter().sum::<f64>() / PHASES as f64 / square.sqrt() / runs as f64;
            }
            holds &= (HELD[0]..=HELD[1]).contains(&inside);
            narrow &= width <= WIDEST;
        }
        for (met, is) in met.iter_mut().zip([holds, narrow, holds && narrow]) {
            *met += f64::from(u8::from(is)) / ERRORS as f64;
        }
    }
    met
}

/// Errors before and after, and the coverage of the band, in the runs held out.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let calibration = shipped("seven_runs.toml", &["structures=[]", "starts=1"])?;
    let (mut own, targets) = (structure(&calibration)?, truth(&calibration)?);
    let runs = measured(&calibration, &targets, &all_clean(&targets)?, 1)?;
    let held: Vec<usize> = (0..runs.len()).filter(|run| runs[*run].role == RunRole::HeldOut).collect();
    let nominal = own.parameters.clone();
    let plan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: true };
    let channels = runs[0].layout.channels;
    let (mut before, mut after) = (vec![Vec::new(); channels], vec![Vec::new(); channels]);
    let (mut covered, mut white, mut width) =
        (vec![Vec::new(); channels], vec![Vec::new(); channels], vec![Vec::new(); channels]);
    let mut by_luck = [0.0; 3];
    for draw in 0..DRAWS {
        let mut random = Random::stream(17, draw as u64);
        for (parameter, nominal) in own.parameters.iter_mut().zip(&nominal) {
            let by = random.between(-OFF, OFF);
            parameter.start = (nominal.start + by * nominal.scale()).clamp(nominal.low, nominal.high);
        }
        let starts: Vec<f64> = own.parameters.iter().map(|parameter| parameter.start).collect();
        let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
        let solved = solve(&own.model, &runs, &own.parameters, &plan, &mut (), watch).map_err(no_answer)?;
        if draw == 0 {
            by_luck = exact(&solved, held.len());
        }
        let mut sums = vec![[0.0; 6]; channels];
        for run in &held {
            let (observed, noise) = (&runs[*run], floor(&runs[*run]));
            let was = rms(observed, &own.model.predict(*run, &starts).map_err(no_answer)?);
            let predicted = solved.predicted(*run).map_err(no_answer)?;
            let is = rms(observed, &predicted.cycle);
            let inside = predicted.coverage(observed, &predicted.deviations);
            let plain = predicted.coverage(observed, &predicted.white);
            let half = predicted.half_widths();
            for channel in 0..channels {
                let share = 1.0 / held.len() as f64;
                let sum = &mut sums[channel];
                sum[0] += share * (was[channel].powi(2) - noise[channel].powi(2)).max(0.0);
                sum[1] += share * (is[channel].powi(2) - noise[channel].powi(2)).max(0.0);
                sum[2] += share * inside[channel];
                sum[3] += share * plain[channel];
                sum[4] += share * half[channel] / is[channel];
                sum[5] += share * noise[channel];
            }
        }
        for (channel, sum) in sums.iter().enumerate() {
            before[channel].push(sum[0].sqrt());
            after[channel].push(sum[1].sqrt() - if HALVED.contains(&channel) { 0.0 } else { sum[5] });
            covered[channel].push(sum[2]);
            white[channel].push(sum[3]);
            width[channel].push(sum[4]);
        }
    }
    let source = "own truth (full, lev) under paper, linear; 5 Hz and 1.2 m/s held out, 20 starts +-20 %";
    let mut rows = Vec::new();
    let (mut halved, mut risen, mut off, mut wide, mut most_white) =
        (0.0_f64, f64::NEG_INFINITY, 0.0_f64, 0.0_f64, 0.0_f64);
    for channel in 0..channels {
        let name = channel_name(runs[0].layout, channel);
        let (was, is) = (median(&mut before[channel]), median(&mut after[channel]));
        let (inside, plain, half) =
            (median(&mut covered[channel]), median(&mut white[channel]), median(&mut width[channel]));
        if HALVED.contains(&channel) {
            halved = halved.max(is / was);
        } else {
            risen = risen.max(is / was);
        }
        off = off.max((inside - 0.5 * (HELD[0] + HELD[1])).abs());
        wide = wide.max(half);
        most_white = most_white.max(plain);
        let metric = format!(
            "{name}: error {is:.5} of {was:.5} before; {:.1} % in the band of {half:.2} rms, {:.1} % in that of samples",
            100.0 * inside,
            100.0 * plain
        );
        rows.push(ComparisonRow::shown(
            &format!("calibrate.wrong_model.{name}"),
            source,
            &metric,
            is / was,
            "",
        ));
    }
    let id = |end: &str| format!("calibrate.wrong_model.{end}");
    let asked = ["90 to 99 % of every channel", "at most 2.5 rms wide in every channel", "both"];
    for (k, (asked, share)) in asked.iter().zip(by_luck).enumerate() {
        let metric = format!("{ERRORS} draws of errors as large as the band says: {asked}");
        rows.push(ComparisonRow::shown(&id(&format!("exact_{k}")), source, &metric, share, ""));
    }
    let judged = [
        ("halved", "Fz, Ty, Tz: largest median error after over before", halved, 0.5),
        ("not_worse", "Fx, Fy, Tx: largest median error after, less the noise, over before", risen, 1.0),
        ("coverage", "largest |share in the 95 % band - 0.945|: 90 to 99 %", off, 0.5 * (HELD[1] - HELD[0])),
        ("width", "largest half width of the band over the rms in the runs held out", wide, WIDEST),
        ("white", "largest share in the band of independent samples", most_white, 0.6),
    ];
    for (end, metric, value, limit) in judged {
        rows.push(ComparisonRow::judged(&id(end), source, metric, value, limit, ""));
    }
    Ok(rows)
}

//! Nine pressure taps on a flapping wing as a calibration: what such data tell, and what they do not.

use super::no_answer;
use crate::aero_full::yeo::lifts;
use crate::{ComparisonRow, Error};
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use wingbeat::aero::SurfaceNumbers;
use wingbeat_calibrate::{
    CycleModel, Error as Fault, FitPlan, FitProblem, FitProgress, FittedParameter, HarmonicLayout,
    ObservedCycles, RunRole, solve_problem,
};

/// Three strips of taps, six harmonics: the digitised series hold no more.
const LAYOUT: HarmonicLayout = HarmonicLayout { channels: 3, harmonics: 6 };
/// Deviation of a harmonic, in parts of its strip's amplitude: there are no repeats to tell it. *Choice.*
const NOISE: f64 = 0.02;
/// Step of a central difference, in parts of a number.
const STEP: f64 = 1e-3;
/// Where a number stands among those of a surface.
type TapNumber = fn(&mut SurfaceNumbers) -> &mut f64;
/// What is fitted, with its place among the numbers of a surface.
const NUMBERS: [(&str, TapNumber); 4] = [
    ("section_slope", |numbers| &mut numbers.section_slope),
    ("added_mass_scale", |numbers| &mut numbers.added_mass_scale),
    ("critical_suction", |numbers| &mut numbers.critical_suction),
    ("cd90", |numbers| &mut numbers.cd90),
];

/// Harmonics of equally spaced values, their mean left out: the taps' zero is not known to the needed part.
fn harmonics(values: &[f64]) -> Vec<f64> {
    let n = values.len() as f64;
    let part = |part: usize| {
        let k = HarmonicLayout::harmonic(part) as f64;
        let wave = |i: usize| {
            if part % 2 == 1 { (TAU * k * i as f64 / n).cos() } else { (TAU * k * i as f64 / n).sin() }
        };
        values.iter().enumerate().map(|(i, x)| 2.0 / n * x * wave(i)).sum()
    };
    std::iter::once(0.0).chain((1..LAYOUT.width()).map(part)).collect()
}

/// The strip model at the taps.
struct Taps;

impl Taps {
    fn cycles(values: &[f64], which: usize) -> Result<Vec<f64>, Error> {
        let strips = lifts(|numbers| {
            for ((_, of), value) in NUMBERS.iter().zip(values) {
                *of(numbers) = *value;
            }
        })?;
        Ok(strips.iter().flat_map(|strip| harmonics(&strip[which])).collect())
    }
}

impl CycleModel for Taps {
    fn predict(&self, _: usize, values: &[f64]) -> Result<Vec<f64>, Fault> {
        Self::cycles(values, 0).map_err(|error| Fault::data("yeo2011", error.to_string()))
    }
    fn slopes(&self, run: usize, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        let by = |k: usize| {
            let moved = |share: f64| {
                let mut moved = values.to_vec();
                moved[k] *= 1.0 + share;
                self.predict(run, &moved)
            };
            let (high, low) = (moved(STEP)?, moved(-STEP)?);
            Ok(high.iter().zip(&low).map(|(high, low)| (high - low) / (2.0 * STEP * values[k])).collect())
        };
        (0..values.len()).map(by).collect()
    }
}

/// Values, labels and the closest pair: shown, for there is no truth.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let nominal = std::cell::Cell::new(None);
    lifts(|numbers| nominal.set(Some(numbers.clone())))?;
    let mut numbers = nominal.take().ok_or_else(|| no_answer("no numbers"))?;
    let start: Vec<f64> = NUMBERS.iter().map(|(_, of)| *of(&mut numbers)).collect();
    let measured = Taps::cycles(&start, 1)?;
    let run = ObservedCycles {
        name: "nine taps".into(),
        layout: LAYOUT,
        cycles: vec![measured.clone()],
        weights: vec![1.0],
        mean: measured.clone(),
        sample_noise: DMatrix::zeros(3, 3),
        samples_per_cycle: 100.0,
        left_out: 0,
        oddities: Vec::new(),
        found: Vec::new(),
        frequency_hz: 3.3,
        role: RunRole::Fitted,
        unmeasured: Vec::new(),
        common: Default::default(),
    };
    let noise =
        DMatrix::from_fn(
            3,
            3,
            |i, j| {
                if i == j { NOISE * NOISE * LAYOUT.mean_square(&measured, i) } else { 0.0 }
            },
        );
    let parameters: Vec<FittedParameter> = NUMBERS
        .iter()
        .zip(&start)
        .map(|((name, _), start)| FittedParameter {
            name: (*name).into(),
            start: *start,
            low: 0.1 * start,
            high: 4.0 * start,
            prior: None,
            stage: 1,
        })
        .collect();
    let runs = [run];
    let noise = vec![vec![noise; LAYOUT.harmonics + 1]];
    let problem = FitProblem::with_noise(&Taps, &runs, &parameters, noise).map_err(no_answer)?;
    let plan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: true };
    let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
    let solved = solve_problem(problem, &plan, &mut (), watch).map_err(no_answer)?;
    let (errors, profiles) = (solved.errors(), solved.profiles().map_err(no_answer)?);
    let source = "Yeo, Atkins & Shyy 2011, measured; noise 2 % a choice";
    let mut rows = Vec::new();
    for (k, parameter) in parameters.iter().enumerate() {
        let metric = format!(
            "{} from nine taps, {:.4} before, standard error {:.2e}, {}",
            parameter.name,
            parameter.start,
            errors[k],
            profiles[k].label.word()
        );
        rows.push(ComparisonRow::shown(
            &format!("calibrate.yeo.{}", parameter.name),
            source,
            &metric,
            solved.values[k],
            "",
        ));
    }
    let correlations = solved.correlations();
    let mut closest = (0.0_f64, "", "");
    for i in 0..parameters.len() {
        for j in 0..i {
            if correlations[(i, j)].abs() > closest.0.abs() {
                closest = (correlations[(i, j)], NUMBERS[j].0, NUMBERS[i].0);
            }
        }
    }
    let metric = format!("closest pair, {} and {}: correlation", closest.1, closest.2);
    rows.push(ComparisonRow::shown("calibrate.yeo.closest", source, &metric, closest.0, ""));
    let metric = "chi squared over freedom: above 1 the model is wrong beyond 2 %";
    rows.push(ComparisonRow::shown("calibrate.yeo.chi_squared", source, metric, solved.chi_squared, ""));
    Ok(rows)
}

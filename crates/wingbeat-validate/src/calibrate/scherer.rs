//! Fourteen mean thrusts of a heaving and pitching wing as a calibration: what such data tell, and what they do not.

use super::no_answer;
use crate::aero_full::{ComparedPreset, Thrust, scherer_lev_thrust, scherer_points};
use crate::{ComparisonRow, Error};
use nalgebra::DMatrix;
use std::ops::ControlFlow;
use wingbeat::aero::SurfaceNumbers;
use wingbeat_calibrate::{
    CycleModel, Error as Fault, FitPlan, FitProblem, FitProgress, FittedParameter, HarmonicLayout,
    Information, LinearisedRuns, ObservedCycles, RunRole, solve_problem,
};

/// One number a point: its mean thrust coefficient.
const LAYOUT: HarmonicLayout = HarmonicLayout { channels: 1, harmonics: 0 };
/// Step of a central difference, in parts of a number's size.
const STEP: f64 = 2e-3;
/// Where a number stands among those of a surface.
type SurfaceNumber = fn(&mut SurfaceNumbers) -> &mut f64;
/// What is fitted: its place, where the fit begins, and its bounds.
const NUMBERS: [(&str, SurfaceNumber, f64, [f64; 2]); 4] = [
    ("section_slope", |numbers| &mut numbers.section_slope, std::f64::consts::TAU, [2.0, 12.0]),
    ("cd0", |numbers| &mut numbers.cd0, 0.057, [0.0, 0.3]),
    ("critical_suction", |numbers| &mut numbers.critical_suction, 0.259, [0.03, 1.0]),
    ("added_mass_scale", |numbers| &mut numbers.added_mass_scale, 1.0, [0.1, 4.0]),
];

/// The strip model at the points.
struct ThrustPoints(Vec<Thrust>);

impl CycleModel for ThrustPoints {
    fn predict(&self, run: usize, values: &[f64]) -> Result<Vec<f64>, Fault> {
        let Thrust { theta_deg, psi_deg, .. } = self.0[run];
        let change = |numbers: &mut SurfaceNumbers| {
            for ((_, of, ..), value) in NUMBERS.iter().zip(values) {
                *of(numbers) = *value;
            }
        };
        let thrust = scherer_lev_thrust(theta_deg, psi_deg, change);
        thrust.map(|thrust| vec![thrust]).map_err(|error| Fault::data("scherer1968", error.to_string()))
    }
    fn slopes(&self, run: usize, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        let by = |k: usize| {
            let (.., size, [low, high]) = NUMBERS[k];
            let step = STEP * size;
            let [low, high] = [-step, step].map(|by| (values[k] + by).clamp(low, high));
            let at = |value: f64| {
                let mut moved = values.to_vec();
                moved[k] = value;
                Ok::<f64, Fault>(self.predict(run, &moved)?[0])
            };
            Ok(vec![(at(high)? - at(low)?) / (high - low)])
        };
        (0..values.len()).map(by).collect()
    }
}

/// Mean |error| of the model at `values`.
fn mean_error(model: &ThrustPoints, values: &[f64]) -> Result<f64, Error> {
    let points: Vec<usize> = (0..model.0.len()).collect();
    let off = wingbeat::parallel::map(&points, |_, k| {
        Ok::<f64, Fault>((model.predict(*k, values)?[0] - model.0[*k].measured).abs())
    });
    let off = off.into_iter().collect::<Result<Vec<f64>, _>>().map_err(no_answer)?;
    Ok(off.iter().sum::<f64>() / off.len() as f64)
}

/// Values, labels and the closest pair: shown, for there is no truth.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let model = ThrustPoints(scherer_points(ComparedPreset::Full)?);
    let run = |point: &Thrust| ObservedCycles {
        name: format!("pitch {} deg, phase {} deg", point.theta_deg, point.psi_deg),
        layout: LAYOUT,
        cycles: vec![vec![point.measured]],
        weights: vec![1.0],
        mean: vec![point.measured],
        sample_noise: DMatrix::zeros(1, 1),
        samples_per_cycle: 1.0,
        left_out: 0,
        oddities: Vec::new(),
        found: Vec::new(),
        frequency_hz: 5.0,
        role: RunRole::Fitted,
        unmeasured: Vec::new(),
        common: Default::default(),
    };
    let runs: Vec<ObservedCycles> = model.0.iter().map(run).collect();
    // The two points measured twice scatter by 0.012, as long as the bars are: a bar counts as one deviation.
    let noise = |point: &Thrust| {
        let deviation = 0.5 * (point.bars.0 + point.bars.1);
        vec![DMatrix::from_element(1, 1, deviation * deviation)]
    };
    let noise: Vec<_> = model.0.iter().map(noise).collect();
    let parameters = NUMBERS.map(|(name, _, start, [low, high])| FittedParameter {
        name: name.into(),
        start,
        low,
        high,
        prior: None,
        stage: 1,
    });
    let start: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
    let problem = FitProblem::with_noise(&model, &runs, &parameters, noise).map_err(no_answer)?;
    let at = LinearisedRuns::at(&problem, &problem.fitted(), &start).map_err(no_answer)?;
    let together = Information::of(&problem, &at, &start).together;
    let plan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: true };
    let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
    let solved = solve_problem(problem, &plan, &mut (), watch).map_err(no_answer)?;
    let (errors, profiles) = (solved.errors(), solved.profiles().map_err(no_answer)?);
    let source = "Scherer 1968, measured; a bar is one deviation, a choice";
    let mut rows = Vec::new();
    for (k, parameter) in parameters.iter().enumerate() {
        let metric = format!(
            "{} from fourteen mean thrusts, {:.3} before, standard error {:.2e} (before the fit {:.0} % of it), {}",
            parameter.name,
            parameter.start,
            errors[k],
            100.0 * together[k],
            profiles[k].label.word()
        );
        let id = format!("calibrate.scherer.{}", parameter.name);
        rows.push(ComparisonRow::shown(&id, source, &metric, solved.values[k], ""));
    }
    let correlations = solved.correlations();
    let pairs = (0..parameters.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let closest = pairs.max_by(|a, b| correlations[*a].abs().total_cmp(&correlations[*b].abs()));
    let (i, j) = closest.ok_or_else(|| no_answer("no pair"))?;
    let metric = format!("closest pair, {} and {}: correlation", NUMBERS[j].0, NUMBERS[i].0);
    rows.push(ComparisonRow::shown("calibrate.scherer.closest", source, &metric, correlations[(i, j)], ""));
    let metric = "chi squared over freedom: above 1 the model is wrong beyond the bars";
    rows.push(ComparisonRow::shown("calibrate.scherer.chi_squared", source, metric, solved.chi_squared, ""));
    let metric = format!(
        "mean |error| of thrust coefficient after the fit, {:.4} before",
        mean_error(&model, &start)?
    );
    rows.push(ComparisonRow::shown(
        "calibrate.scherer.error",
        source,
        &metric,
        mean_error(&model, &solved.values)?,
        "",
    ));
    Ok(rows)
}

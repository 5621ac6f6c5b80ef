//! Models of several structures calibrated for flight: numbers of the paper's seven runs, and the wrench that they leave on nine stands.

use super::{all_clean, measured, no_answer, shipped, structure, truth};
use crate::Error;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};
use wingbeat::aero::{CRITICAL_SUCTION, LiftLaw, STALL_ANGLE};
use wingbeat::math::{Random, Vec3};
use wingbeat::robot::ResidualSpec;
use wingbeat_calibrate::{
    CycleModel, FitPlan, FitProgress, FittedParameter, LearnedChannel, LearnedResidual, ObservedCycles,
    Rival, solve,
};

/// Draws of the numbers before the fit.
const DRAWS: usize = 20;
/// Share by which they are off.
const OFF: f64 = 0.2;
/// Share by which a fit of the right model begins beside it.
const BESIDE: f64 = 0.15;
/// The calibration.
const FILE: &str = "for_flight.toml";
/// Numbers that not every law asks for, with the key by which it does.
const OF_LAW: [(&str, &str); 2] = [
    ("surfaces.wing.stall_angle_rad", STALL_ANGLE.key),
    ("surfaces.wing.critical_suction", CRITICAL_SUCTION.key),
];
/// Channels in the plane of symmetry: those that a stand in a wind from ahead loads; the others show noise.
const OF_PLANE: [&str; 3] = ["Fx", "Fz", "Ty"];
/// The truth.
pub(super) const TRUTH: [&str; 2] = ["full", "lev"];

/// Overrides that choose preset and law.
pub(super) fn aero([preset, law]: [&str; 2]) -> [String; 2] {
    [format!("aero.preset={preset}"), format!("aero.law={law}")]
}

/// The override that sets numbers of a robot.
pub(super) fn set(numbers: &[(String, f64)]) -> Option<String> {
    let list: Vec<String> = numbers.iter().map(|(name, value)| format!("{name:?} = {value:?}")).collect();
    (!list.is_empty()).then(|| format!("robot.numbers={{ {} }}", list.join(", ")))
}

/// The override that lets a learned wrench act on a robot.
pub(super) fn with_residual(residual: &ResidualSpec) -> Result<String, Error> {
    let table = toml::Value::try_from(residual).map_err(no_answer)?;
    Ok(format!("robot.residual={table}"))
}

/// A structure of the model, calibrated.
pub(super) struct Calibrated {
    /// Preset and law.
    pub structure: [&'static str; 2],
    /// What is fitted; starts are the model's own values.
    parameters: Vec<FittedParameter>,
    values: Vec<f64>,
    /// Error in runs left out, in parts of what was measured.
    pub left_out: f64,
    /// What it leaves of the loads on the stands.
    pub residual: LearnedResidual,
    /// Error of the numbers alone on the stands, of which none is fitted, and of one left out with the wrench of the others; in parts of what
    /// was measured.
    pub on_stands: [f64; 2],
}

/// What the fitted model leaves of runs on the stand, and what the wrench leaves of one that it is not learned from, in parts of what was
/// measured: means over the channels in the plane of symmetry.
fn on_stands(residual: &LearnedResidual, runs: &[ObservedCycles]) -> [f64; 2] {
    let share = |(place, own): (usize, &LearnedChannel)| {
        let square = |(run, _): &(usize, Vec3)| runs[*run].layout.mean_square(&runs[*run].mean, place);
        let measured = residual.runs.iter().map(square).sum::<f64>() / residual.runs.len() as f64;
        let left = own.left / (measured.sqrt() * OF_PLANE.len() as f64);
        [left, left * if own.is_told() { own.missed } else { 1.0 }]
    };
    let of_plane =
        residual.channels.iter().enumerate().filter(|(_, own)| OF_PLANE.contains(&own.name.as_str()));
    of_plane.map(share).fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
}

/// Numbers of the robot by name; the encoder's lag is the rig's.
fn named(parameters: &[FittedParameter], values: &[f64]) -> Vec<(String, f64)> {
    let all = parameters.iter().zip(values).map(|(parameter, value)| (parameter.name.clone(), *value));
    all.filter(|(name, _)| name != "gait.phase_rad").collect()
}

impl Calibrated {
    /// Numbers of the robot by name, in their declared units.
    pub fn numbers(&self) -> Vec<(String, f64)> {
        named(&self.parameters, &self.values)
    }

    /// Numbers, in their declared units, up to 20 % off those of the model before the fit.
    pub fn drawn(&self) -> Vec<Vec<(String, f64)>> {
        let draw = |draw: usize| {
            let mut random = Random::stream(29, draw as u64);
            let one = |parameter: &FittedParameter| {
                let value = parameter.start + random.between(-OFF, OFF) * parameter.scale();
                value.clamp(parameter.low, parameter.high)
            };
            named(&self.parameters, &self.parameters.iter().map(one).collect::<Vec<f64>>())
        };
        (0..DRAWS).map(draw).collect()
    }

    /// Fits a structure; the numbers that the calibration names and its law has.
    fn of(structure_is: [&'static str; 2], runs: &[ObservedCycles]) -> Result<Self, Error> {
        let model = aero(structure_is).map(|key| format!("rig.{key}"));
        let mut calibration = shipped(FILE, &[&format!("model={model:?}")])?;
        let law = LiftLaw::ALL.into_iter().find(|law| law.name() == structure_is[1]);
        let asks = |key: &str| law.is_some_and(|law| law.about().parameters.iter().any(|own| own.key == key));
        let of_law = |name: &str| OF_LAW.iter().find(|(own, _)| *own == name);
        calibration.spec.parameters.retain(|own| of_law(&own.name).is_none_or(|(_, key)| asks(key)));
        let own = structure(&calibration)?;
        let mut begin = own.parameters.clone();
        if structure_is == TRUTH {
            for (parameter, side) in begin.iter_mut().zip([1.0, -1.0].into_iter().cycle()) {
                let value = parameter.start + side * BESIDE * parameter.scale();
                parameter.start = value.clamp(parameter.low, parameter.high);
            }
        }
        let plan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: true };
        let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
        let solved = solve(&own.model, runs, &begin, &plan, &mut (), watch).map_err(no_answer)?;
        let left_out = Rival::of("", runs, &solved).map_err(no_answer)?.left_out_share;
        let said = |run: usize| own.model.predict(run, &solved.values);
        let residual = LearnedResidual::of(&own.model, runs, &solved.values, &said).map_err(no_answer)?;
        let residual = residual.ok_or_else(|| no_answer("no run whose residual is learned"))?;
        let (parameters, values) = (own.parameters, solved.values);
        let on_stands = on_stands(&residual, runs);
        Ok(Self { structure: structure_is, parameters, values, left_out, residual, on_stands })
    }
}

/// What was measured and fitted so far: comparisons share it.
static FITTED: Mutex<(Vec<ObservedCycles>, Vec<Arc<Calibrated>>)> = Mutex::new((Vec::new(), Vec::new()));

/// `structures` fitted to the same samples of the truth; the truth's own from numbers beside its own.
pub(super) fn calibrated(structures: &[[&'static str; 2]]) -> Result<Vec<Arc<Calibrated>>, Error> {
    let mut so_far = FITTED.lock().map_err(no_answer)?;
    let (runs, fitted) = &mut *so_far;
    if runs.is_empty() {
        let calibration = shipped(FILE, &[])?;
        let targets = truth(&calibration)?;
        *runs = measured(&calibration, &targets, &all_clean(&targets)?, 1)?;
    }
    let mut one = |structure: &[&'static str; 2]| {
        if let Some(own) = fitted.iter().find(|own| own.structure == *structure) {
            return Ok(Arc::clone(own));
        }
        let own = Arc::new(Calibrated::of(*structure, runs)?);
        fitted.push(Arc::clone(&own));
        Ok(own)
    };
    structures.iter().map(&mut one).collect()
}

/// The middle of several.
pub(super) fn median(mut of: Vec<f64>) -> f64 {
    wingbeat::math::order::ascend(&mut of);
    0.5 * (of[(of.len() - 1) / 2] + of[of.len() / 2])
}

//! Pairs that cannot be told apart are named; pairs that hardly can are told.

use super::{all_clean, measured, no_answer, shipped, structure, truth};
use crate::{ComparisonRow, Error};
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use wingbeat_calibrate::{
    CycleModel, Error as Fault, FitPlan, FitProblem, FitProgress, FittedParameter, HarmonicLayout,
    Information, Label, LinearisedRuns, ObservedCycles, RunRole, correlations, solve,
};

/// Lift of a section in the quasi-steady theory of thin plates, L = rho/2 a0 U^2 c angle: density and slope enter by their
/// product alone.
struct ThinPlate;

/// Dynamic pressure over density times chord, m3/s2, and the amplitudes of the angle's mean and first harmonics, rad.
const SCALE: f64 = 0.5 * 9.0 * 0.08;
const ANGLES: [f64; 3] = [0.05, 0.2, -0.1];

impl CycleModel for ThinPlate {
    fn predict(&self, _: usize, values: &[f64]) -> Result<Vec<f64>, Fault> {
        Ok(ANGLES.iter().map(|angle| SCALE * values[0] * values[1] * angle).collect())
    }
    fn slopes(&self, _: usize, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        let by = |other: f64| ANGLES.iter().map(|angle| SCALE * other * angle).collect();
        Ok(vec![by(values[1]), by(values[0])])
    }
}

fn parameter(name: &str, start: f64) -> FittedParameter {
    FittedParameter { name: name.into(), start, low: 0.0, high: 100.0, prior: None, stage: 1 }
}

/// The refusal that names slope and density of a section, if there is one.
fn refusal() -> Result<Option<String>, Error> {
    let layout = HarmonicLayout { channels: 1, harmonics: 1 };
    let mean = ThinPlate.predict(0, &[TAU, 1.225]).map_err(no_answer)?;
    let run = ObservedCycles {
        name: "section".into(),
        layout,
        cycles: vec![mean.clone(); 20],
        weights: vec![1.0; 20],
        mean,
        sample_noise: DMatrix::identity(1, 1),
        samples_per_cycle: 2000.0,
        left_out: 0,
        oddities: Vec::new(),
        found: Vec::new(),
        frequency_hz: 3.5,
        role: RunRole::Fitted,
        unmeasured: Vec::new(),
        common: Default::default(),
    };
    let (runs, parameters) = ([run], [parameter("a0", TAU), parameter("density", 1.225)]);
    let noise = vec![vec![DMatrix::from_element(1, 1, 1e-6); 2]];
    let problem = FitProblem::with_noise(&ThinPlate, &runs, &parameters, noise).map_err(no_answer)?;
    let at = LinearisedRuns::at(&problem, &[0], &[TAU, 1.225]).map_err(no_answer)?;
    let information = Information::of(&problem, &at, &[TAU, 1.225]);
    Ok(information.check(&problem).err().map(|error| error.to_string()))
}

/// Slope with density as a product; the distal mass with its place, hardly told apart, identified all the same.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let said = refusal()?.unwrap_or_default();
    let named = said.contains("the product a0 x density");
    let mut rows = vec![ComparisonRow::judged(
        "calibrate.degenerate",
        "L = rho/2 a0 U2 c angle",
        "slope with density, named as a product: 0 yes, 1 no",
        f64::from(u8::from(!named)),
        0.0,
        "",
    )];
    let calibration = shipped(
        "seven_runs.toml",
        &["truth.set=[\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]", "discrepancy=false", "starts=1"],
    )?;
    let (own, targets) = (structure(&calibration)?, truth(&calibration)?);
    let runs = measured(&calibration, &targets, &all_clean(&targets)?, 1)?;
    let parameters: Vec<FittedParameter> =
        own.parameters.iter().filter(|p| p.name.starts_with("links.")).cloned().collect();
    let names = parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let model = wingbeat_calibrate::RigModel {
        targets: own.model.targets,
        cases: Vec::new(),
        names,
        held: Vec::new(),
    };
    let plan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: false };
    let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
    let solved = solve(&model, &runs, &parameters, &plan, &mut (), watch).map_err(no_answer)?;
    let correlation = correlations(&solved.information_covariance())[(0, 1)];
    let labels = solved.profiles().map_err(no_answer)?;
    let other = labels.iter().filter(|profile| profile.label != Label::Identified).count();
    rows.push(ComparisonRow::judged(
        "calibrate.degenerate.pair",
        "own truth, seven runs",
        &format!(
            "profiles of distal mass and its place, correlation {correlation:.3}, that are not identified"
        ),
        other as f64,
        0.0,
        "",
    ));
    Ok(rows)
}

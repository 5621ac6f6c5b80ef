//! Calibration: exact slopes, recovery of a truth, what cannot be told, a model that is wrong, the next run.

mod degenerate;
mod fitted;
mod flight;
mod gradient;
mod next_run;
pub(crate) mod planned;
mod recovers;
mod scherer;
mod stroke;
mod wrong_model;
mod yeo;

use std::path::Path;

use crate::{Case, Error};
use wingbeat::scenario::Document;
use wingbeat_calibrate::measured::{MeasuredPass, observed};
use wingbeat_calibrate::{CalibrationFile, Clean, ModelStructure, ObservedCycles, RigTarget, RunRole, clean};

/// The comparisons that take seconds.
pub const CASES: &[Case] = &[
    Case { id: "calibrate.gradient", quick: false, run: gradient::rows },
    Case { id: "calibrate.degenerate", quick: false, run: degenerate::rows },
    Case { id: "calibrate.yeo", quick: false, run: yeo::rows },
    Case { id: "calibrate.scherer", quick: false, run: scherer::rows },
];

/// Those that take minutes.
pub const LONG: &[Case] = &[
    Case { id: "calibrate.recovers_truth", quick: false, run: recovers::rows },
    Case { id: "calibrate.wrong_model", quick: false, run: wrong_model::rows },
    Case { id: "calibrate.next_run", quick: false, run: next_run::rows },
    Case { id: "calibrate.flight", quick: false, run: flight::rows },
    Case { id: "calibrate.flight.planned", quick: false, run: planned::rows },
];

fn no_answer(error: impl ToString) -> Error {
    Error::NoAnswer(error.to_string())
}

/// A shipped calibration with overrides.
fn shipped(name: &str, overrides: &[&str]) -> Result<CalibrationFile, Error> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../calibrations").join(name);
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    let document = Document::file(&path).map_err(no_answer)?.overridden(&overrides);
    CalibrationFile::new(document).map_err(no_answer)
}

/// Its runs with its own structure of the model.
fn structure(calibration: &CalibrationFile) -> Result<ModelStructure, Error> {
    calibration.structure(&[], &|_, _| None).map_err(no_answer)
}

/// Its runs with the structure of its truth.
fn truth(calibration: &CalibrationFile) -> Result<Vec<RigTarget>, Error> {
    calibration.truth(&|_, _| None).map_err(no_answer)
}

/// The runs of a truth without noise.
fn all_clean(targets: &[RigTarget]) -> Result<Vec<Clean>, Error> {
    targets.iter().map(clean).collect::<Result<_, _>>().map_err(no_answer)
}

/// What the cell shows of them with the noise of `seed`.
fn measured(
    calibration: &CalibrationFile,
    targets: &[RigTarget],
    clean: &[Clean],
    seed: u64,
) -> Result<Vec<ObservedCycles>, Error> {
    let spec = calibration.spec.truth.as_ref().ok_or_else(|| no_answer("no truth"))?;
    let one = |k: usize| {
        let own = seed.wrapping_mul(7919).wrapping_add(1000 * k as u64);
        let passes = (0..spec.passes).map(|pass| clean[k].pass(&targets[k], spec, own, pass));
        let passes = passes.collect::<Result<Vec<MeasuredPass>, _>>()?;
        observed(&targets[k], &passes, RunRole::of(&calibration.spec.runs[k]), calibration.spec.robust)
    };
    let indices: Vec<usize> = (0..targets.len()).collect();
    let all: Result<Vec<ObservedCycles>, wingbeat_calibrate::Error> =
        wingbeat::parallel::map(&indices, |_, k| one(*k)).into_iter().collect();
    all.map_err(no_answer)
}

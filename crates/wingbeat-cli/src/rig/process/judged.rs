//! Whether samples can be those of the run that is given for them.

use std::f64::consts::TAU;

use wingbeat::rig::process::CycleAverage;
use wingbeat::scenario::ProcessedRun;
use wingbeat_calibrate::{Layout, disagreement, in_cell, project};

/// Harmonics by which a cycle is judged.
const HARMONICS: usize = 8;

/// What of the run does not agree with its model, with the keys that would mend it; none where nothing is wrong.
pub fn judged(one: &ProcessedRun) -> Option<String> {
    let processed = one.averaged()?;
    let model = processed.model.as_ref()?;
    let layout = Layout { channels: 6, harmonics: HARMONICS };
    let (measured, model) = (harmonics(&processed.cycles)?, harmonics(&model.cycles)?);
    let turned = |cycle: &[f64]| match one.run.spec.process.steps.body_frame {
        true => in_cell(&one.run.mount_as_drawn(), layout, cycle),
        false => cycle.to_vec(),
    };
    let cell = [turned(&measured), turned(&model)];
    let found = disagreement(layout, [&measured, &model], [&cell[0], &cell[1]])?;
    Some(format!("{}: --set '{}'", found.words(), found.mend()))
}

/// Mean and harmonics of averaged cycles.
fn harmonics(cycles: &[CycleAverage; 6]) -> Option<Vec<f64>> {
    let bins = cycles[0].mean.len();
    let at = |k: usize| (k + bins - 1) % bins;
    let phase: Vec<f64> = (0..bins + 3).map(|k| TAU * (k as f64 - 1.0) / bins as f64).collect();
    let channels = cycles.each_ref().map(|cycle| (0..bins + 3).map(|k| cycle.mean[at(k)]).collect());
    project(&phase, &channels, 0.0, HARMONICS)
}

//! Whether runs can be those that their files say, before they are fitted.

use crate::measured::{axes, shift};
use crate::{Error, Observed, Structure};
use wingbeat::rig::cell::CHANNELS;

/// Largest shift of phase between measurement and model that is taken without a word, rad.
const LARGEST_SHIFT: f64 = 5.0_f64.to_radians();
/// The parameter that takes up a shift.
const PHASE: &str = "gait.phase_rad";
/// Smallest correlation at the best shift for the shift to be believed. *Choice.*
const BELIEVED: f64 = 0.8;
/// Smallest gain of the correlation by the shift for it to be believed. *Choice.*
const GAINED: f64 = 0.01;

/// Refuses runs whose axes are swapped or flipped, or whose phase is off by more than 5 deg where no parameter takes it up,
/// each with what would be right; what is only odd is returned in words.
///
/// # Errors
/// [`Error::Data`] with the run and the proposal; a model without an answer.
pub fn checked(structure: &Structure, runs: &[Observed], values: &[f64]) -> Result<Vec<String>, Error> {
    let mut odd = Vec::new();
    let fits_phase = structure.parameters.iter().any(|parameter| parameter.name == PHASE);
    for (k, run) in runs.iter().enumerate() {
        let target = &structure.model.targets[k];
        let predicted = target.predict(&structure.model.numbers(values))?;
        let (measured, model) = (target.in_cell(&run.mean), target.in_cell(&predicted));
        if let Some(found) = axes(run.layout, &measured, &model) {
            let wrong = found.iter().enumerate().filter(|(i, (from, sign))| from != i || *sign < 0.0);
            let words: Vec<String> = wrong
                .map(|(i, (from, sign))| {
                    let sign = if *sign < 0.0 { "-" } else { "" };
                    format!("{} is {sign}{} of the file", CHANNELS[i].0, CHANNELS[*from].0)
                })
                .collect();
            let what = format!(
                "axes of the cell do not agree with the model; as if {} (process.input.columns swaps columns)",
                words.join(", ")
            );
            return Err(Error::data(&run.name, what));
        }
        let shift = shift(run.layout, &run.mean, &predicted);
        let believed =
            shift.correlation[1] > BELIEVED && shift.correlation[1] - shift.correlation[0] > GAINED;
        if shift.by.abs() > LARGEST_SHIFT && believed {
            let what = format!(
                "the measured cycle is {:.1} deg {} the model's (correlation {:.3}, shifted {:.3})",
                shift.by.abs().to_degrees(),
                if shift.by > 0.0 { "behind" } else { "ahead of" },
                shift.correlation[0],
                shift.correlation[1]
            );
            if !fits_phase {
                let proposal = format!(
                    "{what}: set rig.robot.numbers={{\"{PHASE}\"={:.4}}}, or make {PHASE} a parameter",
                    -shift.by
                );
                return Err(Error::data(&run.name, proposal));
            }
            odd.push(format!("{}: {what}; {PHASE} is fitted", run.name));
        }
    }
    Ok(odd)
}

//! Whether runs can be those that their files say, before they are fitted.

use crate::measured::{CellAxes, PhaseShift, axes, dead, shift};
use crate::{Error, HarmonicLayout, ModelStructure, ObservedCycles};
use wingbeat::rig::cell::CHANNELS;

/// Largest shift of phase between measurement and model that is taken without a word, rad.
const LARGEST_SHIFT: f64 = 5.0_f64.to_radians();
/// The parameter that takes up a shift.
const PHASE: &str = "gait.phase_rad";
/// Smallest correlation at the best shift for the shift to be believed. *Choice.*
const BELIEVED: f64 = 0.8;
/// Smallest gain of the correlation by the shift for it to be believed, in parts of what the measured cycle itself would
/// lose by that shift. *Choice.*
const GAINED: f64 = 0.5;

/// What of a measured cycle does not agree with the model's.
#[derive(Clone, Debug, PartialEq)]
pub enum Disagreement {
    /// A channel that stands still where the model's moves.
    Dead(usize),
    /// Channels that would agree much better if they were others, or had the other sign, with the factor on each.
    Axes(CellAxes),
    /// A cycle behind (or, negative, ahead of) the model's by more than 5 deg.
    Phase(PhaseShift),
}

/// What of the cycle `measured` does not agree with `model`; `in_cell` are both in the frame of the cell, in the units of the
/// channels. A channel that stands still is told first, as no other one can be in its place; axes that are swapped or flipped are told before
/// a phase: with them it means nothing.
pub fn disagreement(
    layout: HarmonicLayout,
    [measured, model]: [&[f64]; 2],
    in_cell: [&[f64]; 2],
) -> Option<Disagreement> {
    if let Some(channel) = dead(layout, in_cell[0], in_cell[1]).first() {
        return Some(Disagreement::Dead(*channel));
    }
    if let Some(found) = axes(layout, in_cell[0], in_cell[1]) {
        return Some(Disagreement::Axes(found));
    }
    let shift = shift(layout, measured, model);
    let gained = shift.correlation[1] - shift.correlation[0];
    let believed = shift.correlation[1] > BELIEVED && gained > GAINED * shift.own_loss;
    (shift.by.abs() > LARGEST_SHIFT && believed).then_some(Disagreement::Phase(shift))
}

impl Disagreement {
    /// What is seen.
    pub fn words(&self) -> String {
        match self {
            Self::Dead(channel) => {
                format!("{} stands still where the model's moves: the channel is dead", CHANNELS[*channel].0)
            }
            Self::Axes(found) => {
                let words: Vec<String> = wrong(found)
                    .map(|(i, from)| format!("{} is {from} of the file", CHANNELS[i].0))
                    .collect();
                format!("axes of the cell do not agree with the model; as if {}", words.join(", "))
            }
            Self::Phase(shift) => format!(
                "the measured cycle is {:.1} deg {} the model's (correlation {:.3}, shifted {:.3})",
                shift.by.abs().to_degrees(),
                if shift.by > 0.0 { "behind" } else { "ahead of" },
                shift.correlation[0],
                shift.correlation[1]
            ),
        }
    }

    /// What would be right, as keys of the run.
    pub fn mend(&self) -> String {
        match self {
            Self::Dead(channel) => {
                format!(
                    "process.input.columns={{{0} = \"NAME\"}} if {0} is another column",
                    CHANNELS[*channel].0
                )
            }
            Self::Axes(found) => {
                let columns: Vec<String> =
                    wrong(found).map(|(i, from)| format!("{} = \"{from}\"", CHANNELS[i].0)).collect();
                format!("process.input.columns={{{}}}", columns.join(", "))
            }
            Self::Phase(shift) => format!("rig.robot.numbers={{\"{PHASE}\"={:.4}}}", -shift.by),
        }
    }
}

/// Channels that are not what they should be, with the column of the file that would be right.
fn wrong(found: &CellAxes) -> impl Iterator<Item = (usize, String)> {
    let changed = found.iter().enumerate().filter(|(i, (from, sign))| from != i || *sign < 0.0);
    changed.map(|(i, (from, sign))| {
        let sign = if *sign < 0.0 { "-" } else { "" };
        (i, format!("{sign}{}", CHANNELS[*from].0))
    })
}

/// Refuses runs whose axes are swapped or flipped, or whose phase is off by more than 5 deg where no parameter takes it up,
/// each with what would be right. `values` are in the units of the parameters, and what is only odd is returned in words.
///
/// # Errors
/// [`Error::Data`] with the run and the proposal; a model without an answer.
pub fn checked(
    structure: &ModelStructure,
    runs: &[ObservedCycles],
    values: &[f64],
) -> Result<Vec<String>, Error> {
    let mut odd = Vec::new();
    let fits_phase = structure.parameters.iter().any(|parameter| parameter.name == PHASE);
    for (k, run) in runs.iter().enumerate() {
        let Some(target) = structure.model.targets.get(k) else {
            check_case(structure, (k, run), values)?;
            continue;
        };
        odd.extend(run.oddities.iter().map(|what| format!("{}: {what}", run.name)));
        let predicted = target.predict(&structure.model.numbers(values))?;
        let (measured, model) = (target.in_cell(&run.mean), target.in_cell(&predicted));
        let found = disagreement(run.layout, [&run.mean, &predicted], [&measured, &model]);
        let Some(found) = found else { continue };
        if target.tilts().is_some() && matches!(found, Disagreement::Phase(_)) {
            continue;
        }
        match found {
            Disagreement::Dead(_) | Disagreement::Axes(_) => {
                return Err(Error::data(&run.name, format!("{}: set {}", found.words(), found.mend())));
            }
            Disagreement::Phase(_) if fits_phase => {
                odd.push(format!("{}: {}; {PHASE} is fitted", run.name, found.words()));
            }
            Disagreement::Phase(_) => {
                let proposal =
                    format!("{}: set {}, or make {PHASE} a parameter", found.words(), found.mend());
                return Err(Error::data(&run.name, proposal));
            }
        }
    }
    Ok(odd)
}

/// Refuses a case whose channels are swapped or flipped, or whose phase is off; of samples that are wrong by themselves neither means
/// anything, and the verdict says what they are.
fn check_case(
    structure: &ModelStructure,
    (k, run): (usize, &ObservedCycles),
    values: &[f64],
) -> Result<(), Error> {
    if run.found.iter().any(|finding| finding.serious) {
        return Ok(());
    }
    let target = &structure.model.cases[k - structure.model.targets.len()];
    let predicted = target.predict(&structure.model.numbers(values))?;
    // What was not measured is no channel that another one could be.
    let mut among = predicted.clone();
    for channel in &run.unmeasured {
        (0..run.layout.width()).for_each(|part| among[run.layout.at(*channel, part)] = 0.0);
    }
    let what = match disagreement(run.layout, [&run.mean, &predicted], [&run.mean, &among]) {
        // What stands still is found in the data too, by its name and with its size.
        None | Some(Disagreement::Dead(_)) => return Ok(()),
        Some(found @ Disagreement::Axes(_)) => {
            format!(
                "{}: compare.channels says which column is which, compare.scale with which sign",
                found.words()
            )
        }
        Some(found @ Disagreement::Phase(_)) => {
            format!("{}: the motion of the case begins at t = 0, or phase 0, of the file", found.words())
        }
    };
    Err(Error::data(&run.name, what))
}

//! What the measured loads of a case say of themselves and beside the model, before they are fitted.

use crate::tethered::LOADS;
use crate::{CaseTarget, Error, Layout, Observed, PHASES, Structure, phase_of};
use wingbeat::judge::Limits;
use wingbeat::judge::data::{Channel, Finding, Pair, Purpose, Series, compared, examined};
use wingbeat::rig::cell::CHANNELS;

/// What is wrong with the samples of one file at `phase` (cycles): `of` are the channels that it has.
pub fn findings(
    target: &CaseTarget,
    file: &str,
    phase: &[f64],
    (of, channels): (&[usize], &[Vec<f64>; 6]),
) -> Vec<Finding> {
    let channel = |i: &usize| Channel { name: LOADS[*i], unit: CHANNELS[*i].1, samples: &channels[*i] };
    let series = Series {
        what: file,
        phase,
        frequency_hz: Some(target.case.measured_frequency()),
        channels: of.iter().map(channel).collect(),
        purpose: Purpose::Loads,
    };
    examined(&series, &target.case.limits).into_iter().map(keyed).collect()
}

/// What of the mean cycle of `run` cannot be the one that the model predicts.
fn beside(run: &Observed, predicted: &[f64], limits: &Limits) -> Vec<Finding> {
    let layout = run.layout;
    let cycles: Vec<[Vec<f64>; 2]> = (0..layout.channels)
        .map(|c| [run.mean.as_slice(), predicted].map(|of| values(layout, of, c)))
        .collect();
    let pairs: Vec<Pair> = (0..layout.channels)
        .filter(|channel| run.is_measured(*channel))
        .map(|c| Pair {
            name: LOADS[c],
            unit: CHANNELS[c].1,
            measured: &cycles[c][0],
            computed: &cycles[c][1],
        })
        .collect();
    compared(&run.name, &pairs, limits).into_iter().map(keyed).collect()
}

/// What is wrong with the cases of `structure`: what their samples say, and their cycles beside those predicted with `values`.
///
/// # Errors
/// A model without an answer.
pub fn suspected(structure: &Structure, runs: &[Observed], values: &[f64]) -> Result<Vec<Finding>, Error> {
    let model = &structure.model;
    let mut found = Vec::new();
    for (case, run) in model.cases.iter().zip(&runs[model.targets.len()..]) {
        found.extend(run.found.iter().cloned());
        found.extend(beside(run, &case.predict(&model.numbers(values))?, &case.case.limits));
    }
    Ok(found)
}

fn values(layout: Layout, cycle: &[f64], channel: usize) -> Vec<f64> {
    (0..PHASES).map(|k| layout.value(cycle, channel, phase_of(k))).collect()
}

/// The same with the key of the case that mends it.
fn keyed(finding: Finding) -> Finding {
    let key = match finding.id {
        "data.frequency" => Some("compare.frequency_hz"),
        "data.reversed" | "data.scaled" | "data.tiny" | "data.huge" => Some("compare.scale"),
        "data.swapped" | "data.dead" => Some("compare.channels"),
        _ => None,
    };
    finding.mended_by(key.map(Into::into))
}

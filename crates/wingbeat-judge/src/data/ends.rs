//! Where a table of one cycle closes.

use super::outliers::place;
use super::{Finding, MeasuredChannel, Purpose, Series};
use crate::limits::data::{CURVED, ENDS, FEW_CURVED, PHASE_GAP, SAMPLES};

/// Rows from which the inside of a table tells how it moves. *Choice.*
const FEW: usize = 5;
/// Part of the largest value that is rounding. *Choice.*
const ROUNDED: f64 = 1e-4;
/// Difference from a whole cycle up to which the last row is the first of the next cycle.
const WHOLE: f64 = 1e-6;

/// The finding that the ends of one cycle of a motion do not meet: the divided second differences across the closure
/// over the largest inside, which are what the accelerations are.
pub(super) fn apart(series: &Series, channel: &MeasuredChannel) -> Option<Finding> {
    let (phase, y, cycles) = (series.phase, channel.samples, series.cycles());
    if series.purpose != Purpose::Motion || cycles > 1.0 + WHOLE || y.iter().any(|y| !y.is_finite()) {
        return None;
    }
    // A last row that is the first of the next cycle goes.
    let count = if cycles > 1.0 - WHOLE { y.len() - 1 } else { y.len() };
    if count < FEW {
        return None;
    }
    let step = |k: usize| match k + 1 < count {
        true => [phase[k + 1] - phase[k], y[k + 1] - y[k]],
        false => [1.0 + phase[0] - phase[count - 1], y[0] - y[count - 1]],
    };
    // Between the step that begins at a row and the one before it.
    let bent = |k: usize| {
        let [[before, from], [after, to]] = [step((k + count - 1) % count), step(k)];
        (2.0 * (to / after - from / before) / (after + before)).abs()
    };
    let inside = (1..count - 1).map(bent).fold(0.0, f64::max);
    let size = bent(0).max(bent(count - 1)) / inside.max(f64::MIN_POSITIVE);
    let largest = y.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    let by = if count < y.len() { y[count] - y[0] } else { step(count - 1)[1] };
    let text = format!(
        "its ends do not meet, or meet in a corner (the last value less the first is {:.4}): the motion would jump once a cycle, \
         with {size:.0} times its largest acceleration; give one whole cycle, or harmonics",
        if count < y.len() { by } else { -by }
    );
    let told = by.abs() > ROUNDED * largest || inside > 0.0;
    told.then(|| {
        Finding::new("data.ends", &ENDS, series.about(channel.name), size, text).in_channel(channel.name)
    })
}

/// The findings that the samples of a cycle are so few that others would have the same, and that the mean cycle of loads loses harmonics.
pub(super) fn sparse(series: &Series, cycles: f64) -> Vec<Finding> {
    let size = series.phase.len().saturating_sub(1) as f64 / cycles;
    let same = "motions and loads of other frequencies have the same; sample faster";
    let lost = "the mean cycle loses part of its second harmonic (16 % with 5, 6 % with 6, 1 % with 8); sample faster";
    let of = |limit, words: &str| {
        let text = format!("{size:.2} samples a cycle: {words}");
        Finding::new("data.few_samples", limit, series.what, size, text)
    };
    let mut found = vec![of(&SAMPLES, same)];
    // Of the limits for loads the one that refuses comes first.
    if series.purpose.is_loads() && size >= SAMPLES.value {
        found.push(of(if size < CURVED.value { &CURVED } else { &FEW_CURVED }, lost));
    }
    found.retain(|_| cycles > 1.0);
    found
}

/// Places of the cycle in which samples are looked for. *Choice.*
const PLACES: usize = 60;

/// The longest stretch of the cycle that no sample of whole cycles falls into.
pub(super) fn gap(series: &Series, cycles: f64) -> Option<Finding> {
    let mut seen = [false; PLACES];
    for phase in series.phase {
        seen[place(*phase, PLACES)] = true;
    }
    let first = seen.iter().position(|seen| *seen)?;
    // Once round from a place with a sample, and to it again.
    let (mut run, mut longest) = (0, 0);
    for k in 1..=PLACES {
        run = if seen[(first + k) % PLACES] { 0 } else { run + 1 };
        longest = longest.max(run);
    }
    let size = longest as f64 / PLACES as f64;
    let (what, cure) = match series.purpose {
        Purpose::Loads | Purpose::Datum => {
            ("loads", "sample faster, or at a rate that is no multiple of the frequency")
        }
        Purpose::Motion => ("motion", "give rows of the whole cycle, or the frequency of the data"),
    };
    let text = format!(
        "no cycle has a sample in {:.0} % of the cycle in a row: too few samples in a cycle to tell its {what}; {cure}",
        100.0 * size
    );
    (cycles >= 1.0 || series.purpose == Purpose::Motion)
        .then(|| Finding::new("data.few_samples", &PHASE_GAP, series.what, size, text))
}

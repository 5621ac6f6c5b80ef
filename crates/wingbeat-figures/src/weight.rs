//! What carries the weight over a flight.

use std::f64::consts::TAU;

use wingbeat::robot::WeightPart;
use wingbeat::simulate::{Cost, Record};

use crate::panel::{Curve, Panel};

/// Share of the weight that a part must reach somewhere to have a curve.
const SHOWN: f64 = 0.01;

/// The shares of the weight by part with their sum, as means over a stroke about each instant; at each instant where the record holds no
/// whole stroke. None without the columns.
pub fn panel(record: &Record) -> Option<Panel> {
    let (t, phase) = (record.values("t")?, record.values("phase")?);
    let windows = windows(phase);
    let share = |part: WeightPart| Some((part, averaged(record.values(&Cost::column(part))?, &windows)));
    let shares: Vec<(WeightPart, Vec<f64>)> =
        WeightPart::ALL.into_iter().map(share).collect::<Option<_>>()?;
    let total = (0..t.len()).map(|k| shares.iter().map(|(_, share)| share[k]).sum()).collect();
    let seen = |share: &Vec<f64>| share.iter().any(|share| share.abs() >= SHOWN);
    let mut curves: Vec<Curve> = shares
        .into_iter()
        .filter(|(_, share)| seen(share))
        .enumerate()
        .map(|(index, (part, share))| Curve::new(part.words(), t, share, index))
        .collect();
    curves.push(Curve::total("sum", t, total));
    let title =
        if windows.is_empty() { "share of the weight" } else { "share of the weight, mean over a stroke" };
    Some(Panel { levels: vec![0.0, 1.0], ..Panel::new(title, curves) })
}

/// First row and the one after the last of the stroke about each row, cut at the ends of the record; none without a whole stroke.
fn windows(phase: &[f64]) -> Vec<(usize, usize)> {
    let whole = matches!(phase, [first, .., last] if last - first >= TAU);
    let (mut from, mut to) = (0, 0);
    let about = |at: &f64| {
        while phase[from] < at - 0.5 * TAU {
            from += 1;
        }
        while to < phase.len() && phase[to] < at + 0.5 * TAU {
            to += 1;
        }
        (from, to)
    };
    if whole { phase.iter().map(about).collect() } else { Vec::new() }
}

/// Means over the windows, by sums from the begin; where there are none the values.
fn averaged(values: &[f64], windows: &[(usize, usize)]) -> Vec<f64> {
    if windows.is_empty() {
        return values.to_vec();
    }
    let mut sums = vec![0.0; values.len() + 1];
    for (k, value) in values.iter().enumerate() {
        sums[k + 1] = sums[k] + value;
    }
    windows.iter().map(|(from, to)| (sums[*to] - sums[*from]) / (to - from) as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_averages_what_repeats_with_it() {
        let phase: Vec<f64> = (0..=400).map(|k| 0.3 + f64::from(k) * TAU / 100.0).collect();
        let values: Vec<f64> = phase.iter().map(|p| 0.7 + 5.0 * p.sin()).collect();
        let means = averaged(&values, &windows(&phase));
        assert!(means[50..350].iter().all(|mean| (mean - 0.7).abs() < 1e-12), "{means:?}");
        assert_eq!(averaged(&values[..50], &windows(&phase[..50])), values[..50]);
    }
}

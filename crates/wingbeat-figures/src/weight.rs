//! What carries the weight over a flight.

use std::f64::consts::TAU;

use wingbeat::robot::WeightPart;
use wingbeat::simulate::{Cost, Record};

use crate::panel::{FigurePanel, PanelCurve};

/// Share of the weight that a part must reach somewhere to have a curve.
const SHOWN: f64 = 0.01;

/// Phase by which rows may be off by rounding, rad.
const ROUNDING: f64 = 1e-9;
/// Points of a curve of means: they hardly change within a part of a stroke.
const POINTS: usize = 240;

/// The shares of the weight by part with their sum, as means over the stroke about each instant, where one lies within the record; at
/// each instant where the record holds no whole stroke; `broadside` is what `cd90` gives in words. None without the columns.
pub fn panel(record: &Record, broadside: &'static str) -> Option<FigurePanel> {
    let (t, phase) = (record.values("t")?, record.values("phase")?);
    let windows = windows(phase);
    let windows: Vec<&StrokeWindow> = windows.iter().step_by(windows.len().div_ceil(POINTS).max(1)).collect();
    let share = |part: WeightPart| Some((part, averaged(record.values(&Cost::column(part))?, &windows)));
    let shares: Vec<(WeightPart, Vec<f64>)> =
        WeightPart::ALL.into_iter().map(share).collect::<Option<_>>()?;
    let t: Vec<f64> =
        if windows.is_empty() { t.to_vec() } else { windows.iter().map(|w| t[w.row]).collect() };
    let total = (0..t.len()).map(|k| shares.iter().map(|(_, share)| share[k]).sum()).collect();
    let seen = |share: &Vec<f64>| share.iter().any(|share| share.abs() >= SHOWN);
    let mut curves: Vec<PanelCurve> = shares
        .into_iter()
        .filter(|(_, share)| seen(share))
        .enumerate()
        .map(|(index, (part, share))| PanelCurve::new(part.words(broadside), &t, share, index))
        .collect();
    curves.push(PanelCurve::total("sum", &t, total));
    let title =
        if windows.is_empty() { "share of the weight" } else { "share of the weight, mean over a cycle" };
    Some(FigurePanel { levels: vec![0.0, 1.0], ..FigurePanel::new(title, curves) })
}

/// The rows of the stroke about a row.
struct StrokeWindow {
    row: usize,
    from: usize,
    to: usize,
}

/// The strokes about the rows about which a whole one lies within the record.
fn windows(phase: &[f64]) -> Vec<StrokeWindow> {
    let (Some(first), Some(last)) = (phase.first(), phase.last()) else { return Vec::new() };
    let (mut from, mut to) = (0, 0);
    let about = |(row, at): (usize, &f64)| {
        // A row at the begin counts and one at the end does not, whatever their rounding.
        let (begin, end) = (at - 0.5 * TAU - ROUNDING, at + 0.5 * TAU - ROUNDING);
        if begin + 2.0 * ROUNDING < *first || end > *last {
            return None;
        }
        while phase[from] < begin {
            from += 1;
        }
        while to < phase.len() && phase[to] < end {
            to += 1;
        }
        Some(StrokeWindow { row, from, to })
    };
    phase.iter().enumerate().filter_map(about).collect()
}

/// Means over the windows, by sums from the begin; where there are none the values.
fn averaged(values: &[f64], windows: &[&StrokeWindow]) -> Vec<f64> {
    if windows.is_empty() {
        return values.to_vec();
    }
    let mut sums = vec![0.0; values.len() + 1];
    for (k, value) in values.iter().enumerate() {
        sums[k + 1] = sums[k] + value;
    }
    windows.iter().map(|w| (sums[w.to] - sums[w.from]) / (w.to - w.from) as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_averages_what_repeats_with_it() {
        let phase: Vec<f64> = (0..=400).map(|k| 0.3 + f64::from(k) * TAU / 100.0).collect();
        let values: Vec<f64> = phase.iter().map(|p| 0.7 + 5.0 * p.sin()).collect();
        let strokes = windows(&phase);
        assert!(strokes.len() > 298 && strokes[0].row >= 50, "{}", strokes.len());
        let means = averaged(&values, &strokes.iter().collect::<Vec<_>>());
        assert!(means.iter().all(|mean| (mean - 0.7).abs() < 1e-12), "{means:?}");
        assert!(windows(&phase[..50]).is_empty());
        assert_eq!(averaged(&values[..50], &[]), values[..50]);
    }
}

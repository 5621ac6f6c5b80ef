//! What processing made of a run: raw against filtered samples, and every cycle with their mean.

use std::borrow::Cow;

use wingbeat::rig::cell::CHANNELS;
use wingbeat::simulate::Record;

use crate::panel::{FigurePanel, PanelCurve, seen, stacked, stacked_with};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Height of a panel, px.
const HEIGHT: f64 = 130.0;

/// Most lines that mark the begins of cycles: more would be a wall.
const MOST_MARKS: usize = 60;
/// Most points of the cycles of a panel together, and fewest of one that is drawn by itself.
const MOST_SWEPT: usize = 12_000;
const FEWEST_SWEPT: usize = 400;
/// Parts of a cycle, each with one stroke from the lowest to the highest of all cycles: one a pixel.
const STROKES: usize = 700;

/// What the samples of a figure are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellOrigin {
    /// A load cell.
    Measured,
    /// A simulated load cell.
    Simulated,
    /// Of some runs a load cell, of others a simulated one.
    Both,
}

impl CellOrigin {
    /// That of runs of which `simulated` are simulated and `measured` are not.
    pub fn of(simulated: usize, measured: usize) -> Self {
        match (simulated, measured) {
            (0, _) => Self::Measured,
            (_, 0) => Self::Simulated,
            _ => Self::Both,
        }
    }

    /// What it is called in figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Measured => "load cell",
            Self::Simulated => "simulated load cell",
            Self::Both => "load cell, of some runs simulated",
        }
    }
}

/// Title of a channel.
fn title(name: &str, unit: &str) -> String {
    format!("{name} [{unit}]")
}

/// Each channel before (`raw_<channel>`) and after the filter over `t`; a line where each cycle begins.
pub fn filtered(trace: &Record, cell: CellOrigin) -> Result<Figure, Error> {
    let (t, cycle) = (needed(trace, "t")?, needed(trace, "cycle")?);
    if t.len() < 2 {
        return Err(Error::Rows { rows: t.len(), needed: 2 });
    }
    let mut panels = Vec::new();
    for (name, unit) in CHANNELS {
        let values = |name: &str| -> Result<Vec<f64>, Error> { Ok(needed(trace, name)?.to_vec()) };
        let raw = PanelCurve {
            colour: style::tint(0),
            weight: style::FINE,
            ..PanelCurve::new("unfiltered", t, values(&format!("raw_{name}"))?, 0)
        };
        let filtered = PanelCurve::new("filtered", t, values(name)?, 1).whole();
        panels.push(FigurePanel::new(title(name, unit), vec![raw, filtered]));
    }
    let marks = (1..t.len()).filter(|k| cycle[*k].floor() > cycle[k - 1].floor()).map(|k| t[k]);
    let marks: Vec<f64> = std::iter::once(t[0]).chain(marks).collect();
    let few = marks.len() <= MOST_MARKS;
    let marked = if few { "; broken lines: begin of each cycle" } else { "" };
    let x = format!("t [s] of the {}{marked}", cell.name());
    Ok(Figure::new("filtered", stacked_with(panels, &x, HEIGHT, if few { &marks } else { &[] })))
}

/// Each channel against the phase of the stroke: every sweep of `trace`, or what all of them cover where there are
/// many, and the mean of `average`; what `still_<channel>` says is taken away from both.
pub fn cycles(trace: &Record, average: &Record, cell: CellOrigin) -> Result<Figure, Error> {
    let (cycle, phase) = (needed(trace, "cycle")?, needed(average, "cycle")?);
    let mut panels = Vec::new();
    for (name, unit) in CHANNELS {
        let still = average.values(&format!("still_{name}"));
        let mut curves = sweeps(cycle, &less(needed(trace, name)?, cycle, still));
        let mean = closed(needed(average, name)?, |first| first);
        curves.push(PanelCurve::new("mean", &closed(phase, |first| first + 1.0), mean, 1).whole());
        panels.push(FigurePanel::new(title(name, unit), curves));
    }
    let x = format!("phase of the cycle, turns; {}", cell.name());
    Ok(Figure::new("cycles", stacked(panels, &x, HEIGHT)))
}

/// Values over a cycle with that of its end, which `again` makes of the first.
fn closed(values: &[f64], again: impl Fn(f64) -> f64) -> Vec<f64> {
    values.iter().copied().chain(values.first().map(|first| again(*first))).collect()
}

/// `values` without the average in still air where that is taken away from the mean too.
fn less<'a>(values: &'a [f64], cycle: &[f64], still: Option<&[f64]>) -> Cow<'a, [f64]> {
    let Some(still) = still.filter(|still| !still.is_empty()) else { return values.into() };
    let at = |cycle: f64| {
        let place = (cycle - cycle.floor()) * still.len() as f64;
        let (bin, share) = (place as usize, place.fract());
        (1.0 - share) * still[bin % still.len()] + share * still[(bin + 1) % still.len()]
    };
    values.iter().zip(cycle).map(|(value, cycle)| value - at(*cycle)).collect()
}

/// Every cycle by itself while they are few, else one curve up and down between the lowest and the highest of all.
fn sweeps(cycle: &[f64], values: &[f64]) -> Vec<PanelCurve> {
    let light = |curve| PanelCurve { colour: style::tint(0), weight: style::FINE, ..curve };
    let each = || cycle.chunk_by(|a, b| a.floor() == b.floor());
    let points = MOST_SWEPT / each().count().max(1);
    if points < FEWEST_SWEPT {
        return vec![light(covered(cycle, values))];
    }
    let mut curves = Vec::new();
    let mut from = 0;
    for sweep in each() {
        let y = &values[from..from + sweep.len()];
        let name = if from == 0 { "each cycle" } else { "" };
        from += sweep.len();
        let kept = seen(y, points);
        let x: Vec<f64> = kept.iter().map(|k| sweep[*k] - sweep[*k].floor()).collect();
        curves.push(light(PanelCurve::new(name, &x, kept.iter().map(|k| y[*k]).collect(), 0)));
    }
    curves
}

/// The range of all cycles, phase by phase, as strokes.
fn covered(cycle: &[f64], values: &[f64]) -> PanelCurve {
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); STROKES];
    for (cycle, value) in cycle.iter().zip(values).filter(|(cycle, value)| (**cycle + **value).is_finite()) {
        let part = ((cycle - cycle.floor()) * STROKES as f64) as usize;
        let (low, high) = &mut ranges[part.min(STROKES - 1)];
        (*low, *high) = (low.min(*value), high.max(*value));
    }
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for (k, (low, high)) in ranges.into_iter().enumerate().filter(|(_, (low, high))| low <= high) {
        x.extend([(k as f64 + 0.5) / STROKES as f64; 2]);
        // Up and down in turn, so that one line draws all strokes.
        y.extend(if k % 2 == 0 { [low, high] } else { [high, low] });
    }
    PanelCurve::new("all cycles, lowest to highest", &x, y, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_cycle_ends_where_it_begins() {
        assert_eq!(closed(&[0.0, 0.25, 0.5, 0.75], |first| first + 1.0), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(closed(&[3.0, 1.0], |first| first), [3.0, 1.0, 3.0]);
    }

    #[test]
    fn cycles_lose_what_their_mean_lost() {
        let (values, cycle) = ([5.0, 5.0, 5.0, 5.0], [2.0, 2.125, 2.5, 2.875]);
        assert_eq!(*less(&values, &cycle, Some(&[1.0, 2.0, 3.0, 4.0])), [4.0, 3.5, 2.0, 2.5]);
        assert_eq!(*less(&values, &cycle, None), values);
    }
}

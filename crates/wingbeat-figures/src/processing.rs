//! What processing made of a run: raw against filtered samples, and every cycle with their mean.

use kuva::plot::annotations::ReferenceLine;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::simulate::Record;

use crate::panel::{Curve, Panel, stacked, stacked_with};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Height of a panel, px.
const HEIGHT: f64 = 130.0;

/// Title of a channel and the factor to the unit drawn.
fn title(name: &str, unit: &str) -> (String, f64) {
    match unit {
        "N m" => (format!("{name} [N mm]"), 1e3),
        _ => (format!("{name} [{unit}]"), 1.0),
    }
}

/// Each channel before (`raw_<channel>`) and after the filter over `t`; a line where each cycle begins.
pub fn filtered(trace: &Record) -> Result<Figure, Error> {
    let (t, cycle) = (needed(trace, "t")?, needed(trace, "cycle")?);
    if t.len() < 2 {
        return Err(Error::Rows { rows: t.len(), needed: 2 });
    }
    let mut panels = Vec::new();
    for (name, unit) in CHANNELS {
        let (title, scale) = title(name, unit);
        let values = |name: &str| -> Result<Vec<f64>, Error> {
            Ok(needed(trace, name)?.iter().map(|x| x * scale).collect())
        };
        let raw = Curve {
            colour: style::tint(0),
            weight: style::FINE,
            ..Curve::new("unfiltered", t, values(&format!("raw_{name}"))?, 0)
        };
        let filtered = Curve::new("filtered", t, values(name)?, 1);
        panels.push(Panel { title, curves: vec![raw, filtered], limits: None, zero: true });
    }
    let marks = (1..t.len()).filter(|k| cycle[*k].floor() > cycle[k - 1].floor()).map(|k| t[k]);
    let marks: Vec<ReferenceLine> = std::iter::once(t[0])
        .chain(marks)
        .map(|at| ReferenceLine::vertical(at).with_color(style::GUIDE).with_stroke_width(0.8))
        .collect();
    let x = "t [s]; broken lines: begin of each cycle";
    Ok(Figure { name: "filtered", scene: stacked_with(panels, x, HEIGHT, &marks) })
}

/// Each channel against the phase of the stroke: every sweep of `trace`, and the mean of `average`.
pub fn cycles(trace: &Record, average: &Record) -> Result<Figure, Error> {
    let (cycle, phase) = (needed(trace, "cycle")?, needed(average, "cycle")?);
    let mut panels = Vec::new();
    for (name, unit) in CHANNELS {
        let (title, scale) = title(name, unit);
        let values = needed(trace, name)?;
        let mut curves = Vec::new();
        let mut from = 0;
        for sweep in cycle.chunk_by(|a, b| a.floor() == b.floor()) {
            let x: Vec<f64> = sweep.iter().map(|c| c - c.floor()).collect();
            let y = values[from..from + sweep.len()].iter().map(|y| y * scale).collect();
            let name = if from == 0 { "each cycle" } else { "" };
            from += sweep.len();
            curves.push(Curve { colour: style::tint(0), weight: style::FINE, ..Curve::new(name, &x, y, 0) });
        }
        let mean = needed(average, name)?.iter().map(|x| x * scale).collect();
        curves.push(Curve::new("mean", phase, mean, 1));
        panels.push(Panel { title, curves, limits: None, zero: true });
    }
    Ok(Figure { name: "cycles", scene: stacked(panels, "phase of the stroke, turns", HEIGHT) })
}

//! Channels over the phase of the cycle, averaged over all cycles.

use wingbeat::simulate::{Column, Record};

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed};

/// Height of a panel, px.
const HEIGHT: f64 = 130.0;
/// What a column with the standard deviation of a channel is called after it.
pub const DEVIATION: &str = "_std";

/// Each channel of `cycles`, which has columns `phase` and for each channel NAME its mean and `NAME_std`: the mean, and around it
/// one standard deviation over the `count` cycles, where it is a number. The last phase is the first of the next cycle.
pub fn averaged(cycles: &Record, count: usize) -> Result<Figure, Error> {
    let closed = |values: &[f64], last: f64| [values, &[last]].concat();
    let phase = closed(needed(cycles, "phase")?, 1.0);
    let mut panels = Vec::new();
    for Column { name, unit, values: mean, .. } in cycles.columns() {
        let Some(deviation) = cycles.values(&format!("{name}{DEVIATION}")) else { continue };
        let round = |values: &[f64]| closed(values, values.first().copied().unwrap_or(f64::NAN));
        let (mean, deviation) = (round(mean), round(deviation));
        let edges = phase.iter().zip(&mean).zip(&deviation).map(|((p, m), d)| (*p, m - d, m + d));
        // Of a single cycle no deviation is known.
        let edges: Vec<_> = edges.filter(|(_, low, _)| low.is_finite()).collect();
        let title = if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") };
        let panel = FigurePanel::new(title, vec![PanelCurve::new("mean", &phase, mean, 0)]);
        panels.push(FigurePanel { bands: vec![edges], narrow: true, ..panel });
    }
    if panels.is_empty() {
        return Err(Error::Column(format!("*{DEVIATION}")));
    }
    let x = match count {
        1 => "phase, cycles; a single cycle".to_owned(),
        _ => format!("phase, cycles; grey: one standard deviation over {count} cycles"),
    };
    Ok(Figure::new("cycles", stacked(panels, &x, HEIGHT)))
}

//! How a tethered wing's numbers converge, and how they compare with measured ones.

use wingbeat::scenario::{Convergence, ConvergenceRun, MeasuredComparison, QUANTITIES};

use crate::chart::{Chart, ChartAxis, ChartSeries, Look, grid};
use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Height of a panel of the table of strips and steps, px.
const HEIGHT: f64 = 210.0;
/// Least range of a panel as a share of its values: numbers that have converged look alike. *Choice.*
const LEAST_RANGE: f64 = 0.05;

/// Each quantity over the strips, a curve per number of steps.
pub fn convergence(table: &Convergence) -> Figure {
    let looks = [Look::Dotted, Look::Dashed, Look::Line];
    let panel = |k: usize| {
        let of_steps = |(i, steps): (usize, usize)| {
            let own = table.levels.spar_elements.map(|[own, _]| own);
            let alike = |run: &&ConvergenceRun| run.steps_per_cycle == steps && run.spar_elements == own;
            let runs = table.cells.iter().filter(alike);
            let point = |run: &ConvergenceRun| (run.strips as f64, run.values()[k]);
            let points = runs.map(point).filter(|point| point.1.is_finite()).collect();
            ChartSeries::new(format!("{steps} steps per cycle"), points, looks[i], i)
        };
        let values = table.cells.iter().map(|run| run.values()[k]);
        let (low, high) = style::span(values);
        let room = (0.5 * (LEAST_RANGE * low.abs().max(high.abs()) - (high - low))).max(0.05 * (high - low));
        let y = ChartAxis::new(title(QUANTITIES[k]));
        Chart {
            title: String::new(),
            x: ChartAxis::new("strips"),
            y: if room > 0.0 { y.over(low - room, high + room) } else { y },
            // The whole line first: those that are broken are seen on it where they agree.
            series: table.levels.steps_per_cycle.into_iter().enumerate().rev().map(of_steps).collect(),
            passes: None,
        }
    };
    grid("converge", (0..QUANTITIES.len()).map(panel).collect(), 2, HEIGHT)
}

/// A key that ends with its unit, as words with the unit in brackets.
pub(crate) fn title(key: &str) -> String {
    let (name, unit) = key.rsplit_once('_').unwrap_or((key, ""));
    format!("{} [{}]", name.replace('_', " "), unit.to_uppercase())
}

/// Measured cycle, mean with the range of its cycles, over the computed one, as it is and fitted.
pub fn comparison(comparison: &MeasuredComparison) -> Result<Figure, Error> {
    let phase = needed(&comparison.cycle, "phase")?;
    let mut panels = Vec::new();
    for channel in &comparison.channels {
        let column = |kind: &str| needed(&comparison.cycle, &format!("{kind}_{}", channel.computed));
        let (low, high) = (column("low")?, column("high")?);
        let band = (0..phase.len()).map(|i| (phase[i], low[i], high[i])).collect();
        let fitted = PanelCurve::new("fitted", phase, column("fitted")?.to_vec(), 0).whole();
        let curves = vec![
            PanelCurve::total("measured", phase, column("measured")?.to_vec()),
            PanelCurve {
                dashes: Some(style::GUIDE_DASHES),
                ..PanelCurve::new("computed", phase, column("computed")?.to_vec(), 1)
            },
            PanelCurve { weight: style::CURVE, ..fitted },
        ];
        let computed = comparison.cycle.column(&format!("computed_{}", channel.computed));
        let unit = computed.map(|column| column.unit.as_str()).filter(|unit| !unit.is_empty());
        let title = format!(
            "{} against computed {}{} (lag {:.3} cycles, gain {:.4})",
            channel.measured,
            channel.computed.replace('_', " "),
            unit.map_or(String::new(), |unit| format!(" [{unit}]")),
            channel.fit.lag_cycles,
            channel.fit.gain
        );
        panels.push(FigurePanel { bands: vec![band], ..FigurePanel::new(title, curves) });
    }
    Ok(Figure::new(
        "compare",
        stacked(panels, "phase [cycles]; shaded: range of the measured cycles", style::PANEL),
    ))
}

//! Several runs over one another: a panel for each quantity, a colour for each run.

use crate::panel::{FigurePanel, PanelCurve, two_stacks};
use crate::write::Figure;

/// Height of a panel, px.
const HEIGHT: f64 = 150.0;
/// Most panels: two stacks of ten.
pub const MOST_PANELS: usize = 20;
/// Strokes and gaps of the second curve of a run in a panel and of later ones, px.
const DASHES: [Option<&str>; 4] = [None, Some("8 5"), Some("2 4"), Some("11 4 2 4")];

/// A quantity of several runs.
pub struct OverlaidQuantity {
    /// What it is, with its unit in brackets.
    pub title: String,
    /// Number of the run, which of its curves, name, values in the unit of the title.
    pub curves: Vec<(usize, usize, String, Vec<f64>)>,
    /// What the values may not leave, in the unit of the title.
    pub limits: Option<(f64, f64)>,
}

/// The quantities over `x`, the axis of each run.
pub fn overlaid(quantities: Vec<OverlaidQuantity>, x: &[&[f64]], x_label: &str) -> Figure {
    let panel = |quantity: OverlaidQuantity| {
        let curve = |(run, which, name, values): (usize, usize, String, Vec<f64>)| {
            let finite: Vec<(f64, f64)> =
                x[run].iter().copied().zip(values).filter(|point| point.1.is_finite()).collect();
            let (x, y): (Vec<f64>, Vec<f64>) = finite.into_iter().unzip();
            PanelCurve { dashes: DASHES[which % DASHES.len()], ..PanelCurve::new(name, &x, y, run) }
        };
        let curves: Vec<PanelCurve> = quantity.curves.into_iter().map(curve).collect();
        // A limit far away from the curves would flatten them.
        let values = || curves.iter().flat_map(|curve| curve.y.iter().copied());
        let (low, high) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let near = |limit: f64| limit > low - (high - low) && limit < high + (high - low);
        let limits = quantity.limits.filter(|limits| near(limits.0) && near(limits.1));
        FigurePanel { title: quantity.title, curves, limits, ..FigurePanel::default() }
    };
    let panels: Vec<FigurePanel> = quantities.into_iter().take(MOST_PANELS).map(panel).collect();
    Figure::new("overlaid", two_stacks(panels, x_label, HEIGHT))
}

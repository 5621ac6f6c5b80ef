//! The plots of several runs as one figure.

use wingbeat::math::order::{ascend_by, descend_by};
use wingbeat_figures::{Figure, MOST_PANELS, OverlaidQuantity, overlaid};

use crate::panels::{CurveRole, PageCurve, PagePanel};
use crate::run::ShownRun;

/// Most curves of a run in a plot, beside the reference: of one run, and of each of several, whose curves differ by colour and strokes.
const MOST_CURVES: [usize; 2] = [4, 2];

/// The plots that the runs have in common, over one another; of one run all its plots. At most as many as a sheet holds, and in each at
/// most four curves of a run, of several runs two of each: the sum of the others first, then the largest of the first run.
///
/// # Errors
/// Nothing to draw.
pub fn sheet(runs: &[ShownRun]) -> Result<Figure, String> {
    let first = runs.first().ok_or("no runs: there is nothing to draw")?;
    let quantity = |panel: &PagePanel| {
        let labels = labels(panel, MOST_CURVES[usize::from(runs.len() > 1)]);
        let mut curves = Vec::new();
        for (number, run) in runs.iter().enumerate() {
            let own = run.panels.iter().find(|own| own.title == panel.title && own.unit == panel.unit)?;
            for (which, label) in labels.iter().enumerate() {
                // A reference is that of the task, and the same for all.
                let shown = |curve: &&PageCurve| {
                    curve.label == *label && (number == 0 || curve.role != CurveRole::Reference)
                };
                if let Some(curve) = own.curves.iter().find(shown) {
                    let name = [run.name.as_str(), label].into_iter().filter(|part| !part.is_empty());
                    let name = name.collect::<Vec<_>>().join(": ");
                    curves.push((number, which, name, curve.values.clone()));
                }
            }
        }
        let drawn = curves.iter().any(|(.., values)| values.iter().any(|value| value.is_finite()));
        let title = format!("{} [{}]", panel.title, told(panel.unit));
        drawn.then_some(OverlaidQuantity { title, curves, limits: panel.limits })
    };
    let quantities: Vec<OverlaidQuantity> =
        first.panels.iter().filter_map(quantity).take(MOST_PANELS).collect();
    if quantities.is_empty() {
        return Err("these runs have no plot in common: there is nothing to draw on one sheet".into());
    }
    let x: Vec<&[f64]> = runs.iter().map(|run| run.axis.values.as_slice()).collect();
    Ok(overlaid(quantities, &x, &format!("{} [{}]", first.axis.label, told(first.axis.unit))))
}

/// A unit in words.
fn told(unit: &str) -> &str {
    if unit.is_empty() { "-" } else { unit }
}

/// The names of the curves that are drawn of a panel: at most `most`, and the reference, which is that of the task.
fn labels(panel: &PagePanel, most: usize) -> Vec<&str> {
    let size = |curve: &PageCurve| {
        curve.values.iter().filter(|value| value.is_finite()).map(|v| v.abs()).sum::<f64>()
    };
    let (reference, mut curves): (Vec<&PageCurve>, Vec<&PageCurve>) =
        panel.curves.iter().partition(|curve| curve.role == CurveRole::Reference);
    if curves.len() > most {
        descend_by(&mut curves, |curve| size(curve));
        ascend_by(&mut curves, |curve| if curve.role == CurveRole::Total { 0.0 } else { 1.0 });
    }
    curves.into_iter().take(most).chain(reference).map(|curve| curve.label.as_str()).collect()
}

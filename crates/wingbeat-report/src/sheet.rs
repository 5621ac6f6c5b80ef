//! The plots of several runs as one figure.

use wingbeat_figures::{Figure, MOST_PANELS, Quantity, overlaid};

use crate::panels::Role;
use crate::run::Run;

/// The plots that the runs have in common, over one another; of one run all its plots. At most as many as a sheet holds.
///
/// # Errors
/// Nothing to draw.
pub fn sheet(runs: &[Run]) -> Result<Figure, String> {
    let mut quantities: Vec<(Quantity, usize)> = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        for panel in &run.panels {
            let unit = if panel.unit.is_empty() { "-" } else { panel.unit };
            let title = format!("{} [{unit}]", panel.title);
            let found = quantities.iter().position(|(quantity, _)| quantity.title == title);
            let place = found.unwrap_or_else(|| {
                quantities.push((Quantity { title, curves: Vec::new(), limits: panel.limits }, 0));
                quantities.len() - 1
            });
            let (quantity, having) = &mut quantities[place];
            *having += 1;
            // A reference is that of the task, and the same for all.
            let shown = panel.curves.iter().filter(|curve| number == 0 || curve.role != Role::Reference);
            for (which, curve) in shown.enumerate() {
                let name = [run.name.as_str(), curve.label.as_str()];
                let name = name.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(": ");
                quantity.curves.push((number, which, name, curve.values.clone()));
            }
        }
    }
    let all = runs.len();
    let common = |(quantity, having): &(Quantity, usize)| {
        let drawn = quantity.curves.iter().any(|curve| curve.3.iter().any(|value| value.is_finite()));
        *having == all && drawn
    };
    quantities.retain(common);
    let quantities: Vec<Quantity> =
        quantities.into_iter().map(|(quantity, _)| quantity).take(MOST_PANELS).collect();
    let Some(first) = runs.first().filter(|_| !quantities.is_empty()) else {
        return Err("these runs have no plot in common: there is nothing to draw on one sheet".into());
    };
    let x: Vec<&[f64]> = runs.iter().map(|run| run.axis.values.as_slice()).collect();
    let unit = if first.axis.unit.is_empty() { "-" } else { first.axis.unit };
    Ok(overlaid(quantities, &x, &format!("{} [{unit}]", first.axis.label)))
}

//! A hover: how far from its place, how turned, and the force of the air as the observer has it.

use wingbeat::math::DEGREES;
use wingbeat::simulate::Record;

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Distance from the place, rotation, and the force of the air by its observer beside the true one's upward part, over time.
///
/// Needs `t`, `roll`, `pitch`, `yaw`, `hover_error_*`, `hover_force_*` and the forces of the air by source.
pub fn hover(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let scaled = |name: &str, factor: f64| -> Result<Vec<f64>, Error> {
        Ok(needed(record, name)?.iter().map(|value| factor * value).collect())
    };
    let three = |prefix: &str, factor: f64| -> Result<Vec<PanelCurve>, Error> {
        let axes = ["x", "y", "z"].into_iter().enumerate();
        axes.map(|(i, axis)| Ok(PanelCurve::new(axis, t, scaled(&format!("{prefix}_{axis}"), factor)?, i)))
            .collect()
    };
    let angles = [("roll", "roll", DEGREES), ("pitch", "nose up", -DEGREES), ("yaw", "yaw", DEGREES)]
        .into_iter()
        .enumerate();
    let angles =
        angles.map(|(i, (column, name, scale))| Ok(PanelCurve::new(name, t, scaled(column, scale)?, i)));
    let mut up = vec![0.0; t.len()];
    for source in wingbeat::aero::LoadSource::ALL.iter().filter(|source| source.is_of_air()) {
        let force = needed(record, &format!("force_{}_z", source.name()))?;
        up.iter_mut().zip(force).for_each(|(sum, force)| *sum += force);
    }
    let air = PanelCurve {
        colour: style::tint(2),
        weight: style::FINE,
        ..PanelCurve::new("z, true, in B", t, up, 2).whole()
    };
    let mut forces = vec![air];
    forces.extend(three("hover_force", 1.0)?);
    let panels = vec![
        FigurePanel::new("distance from the place [mm]", three("hover_error", 1e3)?),
        FigurePanel::new("rotation [°]", angles.collect::<Result<_, Error>>()?),
        FigurePanel::new("force of the air, as its observer has it [N]", forces),
    ];
    Ok(Figure::new("hover", stacked(panels, "time [s]", style::PANEL)))
}

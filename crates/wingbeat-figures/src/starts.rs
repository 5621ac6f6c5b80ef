//! The starts of a search of gaits.

use kuva::plot::legend::LegendPosition;
use kuva::plot::scatter::ScatterPlot;
use kuva::render::figure::Figure as Grid;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use wingbeat::simulate::Record;

use crate::write::Figure;
use crate::{Error, needed, style};

/// Every start by the frequency and power of the gait it comes to, those that keep to the limits and those that do not.
///
/// Needs `frequency_hz`, `power_w_kg` and `kept` (1 or 0).
pub fn starts(record: &Record) -> Result<Figure, Error> {
    let (frequency, power) = (needed(record, "frequency_hz")?, needed(record, "power_w_kg")?);
    let kept = needed(record, "kept")?;
    if record.rows() == 0 {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let cloud = |wanted: bool, name: &str, index: usize| -> Option<Plot> {
        let rows = (0..record.rows()).filter(|&row| (kept[row] == 1.0) == wanted);
        let points: Vec<(f64, f64)> = rows.map(|row| (frequency[row], power[row])).collect();
        let name = format!("{name}: {} of {}", points.len(), record.rows());
        let cloud =
            ScatterPlot::new().with_data(points.clone()).with_color(style::colour(index)).with_size(4.0);
        (!points.is_empty()).then(|| cloud.with_marker_opacity(0.75).with_legend(name).into())
    };
    let clouds = [cloud(true, "limits kept", 0), cloud(false, "limits missed", 1)];
    let plots: Vec<Plot> = clouds.into_iter().flatten().collect();
    let layout = style::axes(Layout::auto_from_plots(&plots))
        .with_x_label("frequency of the gait [Hz]")
        .with_y_label("power over the mass [W/kg]")
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_box(false);
    let scene = Grid::new(1, 1)
        .with_plots(vec![plots])
        .with_layouts(vec![layout])
        .with_figure_size(style::WIDTH, 0.6 * style::WIDTH)
        .render();
    Ok(Figure::new("starts", scene))
}

//! The flights of a sweep: largest errors of roll and pitch, and what counts as held.

use kuva::plot::annotations::ReferenceLine;
use kuva::plot::legend::LegendPosition;
use kuva::plot::scatter::ScatterPlot;
use kuva::render::figure::Figure as Grid;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use wingbeat::simulate::Record;

use crate::write::Figure;
use crate::{Error, needed, style};

/// Least error that is told apart, deg: the axes are logarithmic.
const LEAST: f64 = 1e-2;

/// Every flight by its largest errors (deg) of roll and pitch; `limits` are those of a held flight.
///
/// Needs `roll_max_error`, `pitch_max_error` and `held` (1 or 0).
pub fn robustness(record: &Record, limits: (f64, f64)) -> Result<Figure, Error> {
    let (roll, pitch) = (needed(record, "roll_max_error")?, needed(record, "pitch_max_error")?);
    let held = needed(record, "held")?;
    let flights: Vec<(f64, f64, bool)> = (0..record.rows())
        .filter(|&row| roll[row].is_finite() && pitch[row].is_finite())
        .map(|row| (roll[row].max(LEAST), pitch[row].max(LEAST), held[row] == 1.0))
        .collect();
    if flights.is_empty() {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let cloud = |wanted: bool, name: &str, index: usize| -> Plot {
        let points: Vec<(f64, f64)> =
            flights.iter().filter(|flight| flight.2 == wanted).map(|flight| (flight.0, flight.1)).collect();
        let missing = if wanted || flights.len() == record.rows() {
            String::new()
        } else {
            format!(", {} broke down", record.rows() - flights.len())
        };
        let name = format!("{name}: {} of {}{missing}", points.len(), record.rows());
        let cloud = ScatterPlot::new().with_data(points).with_color(style::colour(index)).with_size(3.0);
        cloud.with_marker_opacity(0.75).with_legend(name).into()
    };
    let mut plots = vec![cloud(true, "held", 0)];
    if flights.iter().any(|flight| !flight.2) || flights.len() < record.rows() {
        plots.push(cloud(false, "lost", 1));
    }
    let least = |errors: &[f64]| errors.iter().any(|error| *error < LEAST);
    let below = if least(roll) || least(pitch) {
        format!("; smaller than {LEAST}° drawn there")
    } else {
        String::new()
    };
    let layout = layout(&plots, &flights, limits, &below);
    let scene = Grid::new(1, 1)
        .with_plots(vec![plots])
        .with_layouts(vec![layout])
        .with_figure_size(style::WIDTH, 0.6 * style::WIDTH)
        .render();
    Ok(Figure::new("robustness", scene))
}

fn layout(plots: &[Plot], flights: &[(f64, f64, bool)], limits: (f64, f64), below: &str) -> Layout {
    let range = |of: fn(&(f64, f64, bool)) -> f64, limit: f64| {
        let values = flights.iter().map(of).chain([limit]);
        let (low, high) =
            values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        (0.7 * low, 1.5 * high)
    };
    let ((left, right), (low, high)) = (range(|f| f.0, limits.0), range(|f| f.1, limits.1));
    let dashed =
        |line: ReferenceLine| line.with_color(style::GUIDE).with_stroke_width(1.0).with_dasharray("6 4");
    style::axes(Layout::auto_from_plots(plots))
        .with_log_scale()
        .with_x_axis_min(left)
        .with_x_axis_max(right)
        .with_y_axis_min(low)
        .with_y_axis_max(high)
        .with_x_label(format!("largest error of roll [°]; dashed: limit {}°{below}", limits.0))
        .with_y_label(format!("largest error of pitch [°]; dashed: limit {}°", limits.1))
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_box(false)
        .with_reference_line(dashed(ReferenceLine::vertical(limits.0)))
        .with_reference_line(dashed(ReferenceLine::horizontal(limits.1)))
}

//! Where the flights of a sweep end.

use kuva::plot::annotations::TextAnnotation;
use kuva::plot::legend::LegendPosition;
use kuva::plot::scatter::{MarkerShape, ScatterPlot};
use kuva::render::figure::Figure as Grid;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use wingbeat::simulate::Record;

use crate::scale::TickScale;
use crate::write::Figure;
use crate::{Error, needed, style};

/// Flights by group, and what is published.
pub struct EndPoints<'a> {
    /// Name and rows of each group.
    pub groups: &'a [(String, Vec<usize>)],
    /// Published end point, m; y to the left.
    pub published: Option<(f64, f64)>,
    /// The only number that was varied: its column, and what it is with its unit.
    pub varied: Option<(&'a str, String)>,
}

/// Room beyond the outermost points, as a share of the larger side, and its least, m.
const ROOM: (f64, f64) = (0.08, 0.05);
/// Height of a number above its point, over that room.
const NUMBER: f64 = 0.15;

/// Every flight that was flown to the end by its end point, seen from above with x to the right and y up; those that did
/// not hold their attitude are hollow.
///
/// Needs `distance_x`, `distance_y`, `held` and `completed` (1 or 0).
pub fn end_points(record: &Record, what: &EndPoints) -> Result<Figure, Error> {
    let (x, y) = (needed(record, "distance_x")?, needed(record, "distance_y")?);
    let (held, completed) = (needed(record, "held")?, needed(record, "completed")?);
    let mut plots: Vec<Plot> = Vec::new();
    // Of a turn the start is shown too: it tells the way.
    let mut all = if what.varied.is_some() { Vec::new() } else { vec![(0.0, 0.0)] };
    let flown_from = all.len();
    for (index, (name, rows)) in what.groups.iter().enumerate() {
        let flown = |wanted: bool| -> Vec<(f64, f64)> {
            let rows = rows.iter().filter(|&&row| completed[row] == 1.0 && (held[row] == 1.0) == wanted);
            rows.map(|&row| (x[row], y[row])).filter(|p| p.0.is_finite() && p.1.is_finite()).collect()
        };
        let (kept, lost) = (flown(true), flown(false));
        all.extend(kept.iter().chain(&lost));
        let cloud = |points: Vec<(f64, f64)>, colour: &str, shape| {
            ScatterPlot::new().with_data(points).with_color(colour).with_size(3.2).with_marker(shape)
        };
        let mut legend = format!("{name}: {} of {} held", kept.len(), rows.len());
        if !lost.is_empty() {
            legend += " (others: crosses)";
        }
        if !lost.is_empty() {
            plots.push(cloud(lost, &style::tint(index), MarkerShape::Cross).into());
        }
        plots.push(cloud(kept, style::colour(index), MarkerShape::Circle).with_legend(legend).into());
    }
    if let Some(point) = what.published {
        all.push(point);
        let star = ScatterPlot::new().with_data(vec![point]).with_color(style::INK).with_size(8.0);
        plots.push(star.with_marker(MarkerShape::Diamond).with_legend("the paper's end point").into());
    }
    if all.len() == flown_from {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let ((left, right), (low, high)) =
        (style::span(all.iter().map(|p| p.0)), style::span(all.iter().map(|p| p.1)));
    let room = (ROOM.0 * (right - left).max(high - low)).max(ROOM.1);
    let varied = what.varied.as_ref().map_or(String::new(), |(_, label)| format!("; numbers: {label}"));
    let mut layout = style::axes(Layout::auto_from_plots(&plots));
    // The ends of what was varied have their numbers.
    let values = what.varied.as_ref().and_then(|(key, _)| record.values(key)).unwrap_or_default();
    let flown = |row: &usize| completed[*row] == 1.0 && x[*row].is_finite() && y[*row].is_finite();
    let mut rows: Vec<usize> = (0..values.len()).filter(flown).collect();
    wingbeat::math::order::ascend_by(&mut rows, |row| values[*row]);
    let ends = [rows.first(), rows.last().filter(|_| rows.len() > 1)];
    for row in ends.into_iter().flatten().copied() {
        let number = TextAnnotation::new(style::number(values[row]), x[row], y[row] + NUMBER * room);
        layout = layout.with_annotation(number.with_font_size(style::TICKS).with_color(style::INK));
    }
    let layout = TickScale::new(left - room, right + room).right(layout);
    let layout = TickScale::new(low - room, high + room)
        .upwards(layout)
        .with_x_label(format!("x at the end [m]{varied}"))
        .with_y_label("y at the end [m], left is positive")
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_box(false);
    let scene = Grid::new(1, 1)
        .with_plots(vec![plots])
        .with_layouts(vec![layout])
        .with_figure_size(style::WIDTH, 0.68 * style::WIDTH)
        .render();
    Ok(Figure::new("end_points", scene))
}

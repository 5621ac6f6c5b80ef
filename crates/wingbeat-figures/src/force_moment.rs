//! Forces and moments on the load cell: the band of all runs and the simulation.

use kuva::plot::LinePlot;
use kuva::plot::band::BandPlot;
use kuva::render::figure::Figure as Grid;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::TextAnchor;
use wingbeat::simulate::Record;

use crate::processing::Cell;
use crate::scale::Scale;
use crate::write::Figure;
use crate::{Error, needed, style};

/// Channels by row: a force and the moment about the same axis.
const ROWS: [[(&str, &str); 2]; 3] = [
    [("Fx", "Fx, forward [N]"), ("Tx", "Mx, roll, right wing down [N m]")],
    [("Fy", "Fy, left [N]"), ("Ty", "My, pitch, nose down [N m]")],
    [("Fz", "Fz, up [N]"), ("Tz", "Mz, yaw, nose left [N m]")],
];

/// Red of the measured band.
const BAND: &str = "#d62728";
/// Room for the line that explains the colours, px.
const FOOT: f64 = 26.0;
/// Height of a panel, px.
const HEIGHT: f64 = 190.0;

/// Six panels over the time of the record: the band between `low_<channel>` and
/// `high_<channel>` of all runs in red, `simulation_<channel>`, where there is one, in black, in the body frame.
pub fn force_moment(record: &Record, cell: Cell) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let simulated = record.column("simulation_Fz").is_some();
    let (mut plots, mut layouts) = (Vec::new(), Vec::new());
    for (row, pair) in ROWS.iter().enumerate() {
        for (channel, title) in pair {
            let of = |prefix: &str| needed(record, &format!("{prefix}{channel}"));
            let (low, high) = (of("low_")?, of("high_")?);
            let line = if simulated { Some(of("simulation_")?) } else { None };
            let (panel, layout) = drawn(t, low, high, line, title, row + 1 == ROWS.len());
            plots.push(panel);
            layouts.push(layout);
        }
    }
    let mut scene = Grid::new(ROWS.len(), 2)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_spacing(6.0)
        .with_padding(6.0)
        .with_row_height(ROWS.len() - 1, HEIGHT + 22.0)
        .with_figure_size(style::WIDTH, HEIGHT * ROWS.len() as f64 + 22.0 + 12.0)
        .render();
    scene.height += FOOT;
    let black = if simulated { "; black: the model on the measured motion of one run" } else { "" };
    let foot = format!("red: {}, smallest to largest of all runs, stroke after stroke{black}", cell.name());
    let (x, y) = (style::WIDTH / 2.0, scene.height - 10.0);
    scene.elements.push(style::words(x, y, foot, TextAnchor::Middle, false));
    Ok(Figure::new("force_moment", scene))
}

fn drawn(
    t: &[f64],
    low: &[f64],
    high: &[f64],
    line: Option<&[f64]>,
    title: &str,
    last: bool,
) -> (Vec<Plot>, Layout) {
    let band = BandPlot::new(t.iter().copied(), low.iter().copied(), high.iter().copied())
        .with_color(BAND)
        .with_opacity(0.45);
    let mut plots: Vec<Plot> = vec![band.into()];
    plots.extend(line.map(|line| {
        let points: Vec<(f64, f64)> = t.iter().copied().zip(line.iter().copied()).collect();
        LinePlot::new().with_data(points).with_color("#000000").with_stroke_width(style::CURVE).into()
    }));
    let values = || low.iter().chain(high).chain(line.unwrap_or(&[])).copied();
    let (bottom, top) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
    let up = Scale::padded(bottom, top, 0.08);
    let across = Scale::new(t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(1.0));
    let axes = up.upwards(across.right(style::axes(Layout::auto_from_plots(&plots))));
    let axes = if last { axes.with_x_label(across.label("time [s]")) } else { axes };
    let layout = axes
        .with_title(up.label(title))
        .with_title_size(style::LETTERS)
        .with_force_margins(62.0, 10.0)
        .with_force_margins_y(32.0, if last { 46.0 } else { 24.0 })
        .with_reference_line(style::thin(0.0));
    (plots, layout)
}

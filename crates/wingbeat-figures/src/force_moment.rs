//! Forces and moments on the load cell: the band of all runs, or the curve of one, and the simulation.

use kuva::plot::LinePlot;
use kuva::plot::band::BandPlot;
use kuva::render::figure::Figure as Grid;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::TextAnchor;
use wingbeat::simulate::Record;

use crate::processing::CellOrigin;
use crate::scale::TickScale;
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
/// Weight of its edges.
const EDGE: f64 = 0.6;
/// Width of the measured curve of one run, over that of the simulation: it is seen under it. *Choice.*
const UNDER: f64 = 2.5;
/// Room for the line that explains the colours, px.
const FOOT: f64 = 26.0;
/// Height of a panel, px.
const HEIGHT: f64 = 190.0;

/// Six panels over the time of the record: the band between `low_<channel>` and
/// `high_<channel>` of all runs in red, a curve where there is one run, `simulation_<channel>`, where there is one, in black, in the body frame.
pub fn force_moment(record: &Record, cell: CellOrigin) -> Result<Figure, Error> {
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
    let runs = if one_run(record) { "one run" } else { "smallest to largest of all runs" };
    let foot = format!("red: {}, {runs}, cycle after cycle{black}", cell.name());
    let (x, y) = (style::WIDTH / 2.0, scene.height - 10.0);
    scene.elements.push(style::words(x, y, foot, TextAnchor::Middle, false));
    Ok(Figure::new("force_moment", scene))
}

/// Whether the smallest of all runs are the largest: a band without a width.
fn one_run(record: &Record) -> bool {
    let names = ROWS.iter().flatten().map(|(channel, _)| channel);
    names.into_iter().all(|name| {
        let of = |prefix: &str| record.values(&format!("{prefix}{name}"));
        of("low_") == of("high_")
    })
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
    let curve = |values: &[f64], colour: &str, width: f64| -> Plot {
        let points: Vec<(f64, f64)> = t.iter().copied().zip(values.iter().copied()).collect();
        LinePlot::new().with_data(points).with_color(colour).with_stroke_width(width).into()
    };
    let mut plots: Vec<Plot> = match low == high {
        true => vec![curve(low, BAND, UNDER * style::CURVE)],
        // Its edges too, as a band may be narrower than a stroke.
        false => vec![band.into(), curve(low, BAND, EDGE), curve(high, BAND, EDGE)],
    };
    plots.extend(line.map(|line| curve(line, "#000000", style::CURVE)));
    let values = || low.iter().chain(high).chain(line.unwrap_or(&[])).copied();
    let (bottom, top) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
    let up = TickScale::padded(bottom, top, 0.08);
    let across = TickScale::new(t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(1.0));
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

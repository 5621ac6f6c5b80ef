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
    [("Fx", "Fx, forward [N]"), ("Tx", "Tx, roll, right wing down [N m]")],
    [("Fy", "Fy, left [N]"), ("Ty", "Ty, pitch, nose down [N m]")],
    [("Fz", "Fz, up [N]"), ("Tz", "Tz, yaw, nose left [N m]")],
];

/// Red of the measured band.
const BAND: &str = "#d62728";
/// Weight of its edges.
const EDGE: f64 = 0.6;
/// Width of the measured curve of one run, over that of the simulation: it is seen under it. *Choice.*
const UNDER: f64 = 2.5;
/// Room for a line of the legend, px.
const FOOT: f64 = 22.0;
/// Left end of the frames and of the samples in the legend, px.
const LEFT: f64 = 62.0;
/// Length of a sample in the legend, and the width of that of the band, px.
const SAMPLE: f64 = 34.0;
const BROAD: f64 = 7.0;
/// Share of the largest range of a unit that every frame of it holds. *Choice.*
const QUIET: f64 = 0.15;
/// Height of a panel, px.
const HEIGHT: f64 = 190.0;

/// Six panels over the time of the record: the band between `low_<channel>` and
/// `high_<channel>` of all runs in red, a curve where there is one run, `simulation_<channel>`, where there is one, in black, in the body frame.
pub fn force_moment(record: &Record, cell: CellOrigin) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let simulated = record.column("simulation_Fz").is_some();
    let (mut plots, mut layouts) = (Vec::new(), Vec::new());
    let of = |prefix: &str, channel: &str| needed(record, &format!("{prefix}{channel}"));
    let values = |channel: &str| -> Result<CellCurves<'_>, Error> {
        let line = if simulated { Some(of("simulation_", channel)?) } else { None };
        Ok(CellCurves { low: of("low_", channel)?, high: of("high_", channel)?, line })
    };
    // What is near zero beside the others of its unit is noise, and does not fill its frame.
    let mut least = [0.0_f64; 2];
    for pair in ROWS {
        for ((channel, _), least) in pair.iter().zip(&mut least) {
            let (bottom, top) = values(channel)?.ends();
            *least = least.max(QUIET * (top - bottom));
        }
    }
    for (row, pair) in ROWS.iter().enumerate() {
        for ((channel, title), least) in pair.iter().zip(least) {
            let (panel, layout) = drawn(t, &values(channel)?, least, title, row + 1 == ROWS.len());
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
    let runs = if one_run(record) { "one run" } else { "smallest to largest of all runs" };
    let mut legend = vec![(BAND, BROAD, format!("{}, {runs}, cycle after cycle", cell.name()))];
    if simulated {
        legend.push(("#000000", style::CURVE, "the model on the measured motion of one run".into()));
    }
    for (colour, weight, words) in legend {
        let (x, y) = (LEFT, scene.height + 8.0);
        scene.elements.push(style::sample((x, y), (x + SAMPLE, y), colour, weight, None));
        scene.elements.push(style::words(x + SAMPLE + 8.0, y + 4.0, words, TextAnchor::Start, false));
        scene.height += FOOT;
    }
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

/// What is drawn of a channel, in its unit.
struct CellCurves<'a> {
    low: &'a [f64],
    high: &'a [f64],
    line: Option<&'a [f64]>,
}

impl CellCurves<'_> {
    /// Least and largest value, zero among them.
    fn ends(&self) -> (f64, f64) {
        let values = || self.low.iter().chain(self.high).chain(self.line.unwrap_or(&[])).copied();
        (values().fold(0.0, f64::min), values().fold(0.0, f64::max))
    }
}

/// The curves of a channel in a frame that holds a range of `least` or more.
fn drawn(t: &[f64], curves: &CellCurves<'_>, least: f64, title: &str, last: bool) -> (Vec<Plot>, Layout) {
    let &CellCurves { low, high, line } = curves;
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
    let (bottom, top) = curves.ends();
    let more = 0.5 * (least - (top - bottom)).max(0.0);
    let up = TickScale::padded(bottom - more, top + more, 0.08);
    let across = TickScale::new(t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(1.0));
    let axes = up.upwards(across.right(style::axes(Layout::auto_from_plots(&plots))));
    let axes = if last { axes.with_x_label(across.label("time [s]")) } else { axes };
    let layout = axes
        .with_title(up.label(title))
        .with_title_size(style::LETTERS)
        .with_force_margins(LEFT, 10.0)
        .with_force_margins_y(32.0, if last { 46.0 } else { 24.0 })
        .with_reference_line(style::thin(0.0));
    (plots, layout)
}

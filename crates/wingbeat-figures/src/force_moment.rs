//! Forces and moments on the load cell: the band of all runs, or the curve of one, and the simulation.

use wingbeat::simulate::Record;

use crate::canvas::{Canvas, TextAnchor};
use crate::plot_frame::{FrameAxis, PanelPlace, PlotFrame};
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
/// Share of the largest range of a unit that every frame of it holds. *Choice*: ten steps of a cell whose largest load is a tenth of its range.
const QUIET: f64 = 0.03;
/// Height of a panel, px.
const HEIGHT: f64 = 190.0;
/// Room around the figure, between its panels, and for the label of the axis, px.
const PADDING: f64 = 6.0;
const SPACING: f64 = 6.0;
const LABEL: f64 = 22.0;

/// Six panels over the time of the record: the band between `low_<channel>` and
/// `high_<channel>` of all runs in red, a curve where there is one run, `simulation_<channel>`, where there is one, in black, in the body frame.
pub fn force_moment(record: &Record, cell: CellOrigin) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let simulated = record.column("simulation_Fz").is_some();
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
    let wide = (style::WIDTH - 2.0 * PADDING - SPACING) / 2.0;
    let height = HEIGHT * ROWS.len() as f64 + LABEL + 2.0 * PADDING;
    let mut scene = Canvas::new(style::WIDTH, height);
    for (row, pair) in ROWS.iter().enumerate() {
        let last = row + 1 == ROWS.len();
        let y = PADDING + HEIGHT * row as f64;
        let tall = if last { HEIGHT + LABEL } else { HEIGHT - SPACING };
        for (column, ((channel, title), least)) in pair.iter().zip(least).enumerate() {
            let place = [PADDING + (wide + SPACING) * column as f64, y, wide, tall];
            draw(&mut scene, place, t, &values(channel)?, least, title, last);
        }
    }
    let runs = if one_run(record) { "one run" } else { "smallest to largest of all runs" };
    let mut legend = vec![(BAND, BROAD, format!("{}, {runs}, cycle after cycle", cell.name()))];
    if simulated {
        legend.push((style::INK, style::CURVE, "the model on the measured motion of one run".into()));
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

/// The ends of a frame that holds these and a range of `least` or more.
fn widened((bottom, top): (f64, f64), least: f64) -> (f64, f64) {
    let more = 0.5 * (least - (top - bottom)).max(0.0);
    (bottom - more, top + more)
}

/// The curves of a channel in a frame that holds a range of `least` or more.
fn draw(
    canvas: &mut Canvas,
    place: PanelPlace,
    t: &[f64],
    curves: &CellCurves<'_>,
    least: f64,
    title: &str,
    last: bool,
) {
    let &CellCurves { low, high, line } = curves;
    let (bottom, top) = widened(curves.ends(), least);
    let up = TickScale::padded(bottom, top, 0.08);
    let across = TickScale::new(t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(1.0));
    let x = FrameAxis::of(across);
    let x = if last { x.labelled(across.label("time [s]")) } else { x };
    let room = [LEFT - PADDING, 10.0, 32.0, if last { 46.0 } else { 24.0 }];
    let mut frame = PlotFrame::new(place, room, x, FrameAxis::of(up));
    frame.guide(0.0);
    let points =
        |values: &'_ [f64]| -> Vec<(f64, f64)> { t.iter().copied().zip(values.iter().copied()).collect() };
    if low == high {
        frame.line(points(low), BAND, UNDER * style::CURVE, None);
    } else {
        let edges: Vec<(f64, f64, f64)> = (0..t.len()).map(|k| (t[k], low[k], high[k])).collect();
        frame.band(&edges, BAND, 0.45);
        // Its edges too, as a band may be narrower than a stroke.
        [low, high].into_iter().for_each(|edge| frame.line(points(edge), BAND, EDGE, None));
    }
    if let Some(line) = line {
        frame.line(points(line), style::INK, style::CURVE, None);
    }
    frame.draw(canvas);
    let (x, y) = (place[0] + 0.5 * (room[0] + place[2] - room[1]), place[1] + 20.0);
    canvas.elements.push(style::words(x, y, up.label(title), TextAnchor::Middle, false));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_load_fills_its_frame_and_noise_does_not() {
        // A roll of 4 mN m beside a pitch of 72, and noise of a step of the cell.
        let least = QUIET * 72e-3;
        assert_eq!(widened((0.0, 4e-3), least), (0.0, 4e-3));
        let (bottom, top) = widened((0.0, 1e-4), least);
        assert!((top - bottom - least).abs() < 1e-15 && top - bottom > 10.0 * 1e-4);
    }
}

//! Panels in a grid, each with its own axes, above one legend.

use crate::canvas::{Canvas, TextAnchor};
use crate::panel::MOST_NAMED;
use crate::plot_frame::{FrameAxis, MarkShape, PlotFrame, mark};
use crate::scale::TickScale;
use crate::style;
use crate::write::Figure;

/// Room to the left of a panel, px.
const LEFT: f64 = 52.0;
/// Room to the right of a panel, px.
const RIGHT: f64 = 10.0;
/// Room above a panel, for its title, px.
const HEAD: f64 = 28.0;
/// Room below a panel, for the numbers of its axis, px.
const FOOT: f64 = 22.0;
/// Room for the label of an axis, px.
const LABEL: f64 = 20.0;
/// Room for a line of the legend, px.
const LEGEND: f64 = 22.0;
/// Length of the sample of a line in the legend, px.
const SAMPLE: f64 = 26.0;
/// From a name of the legend to the next sample, px.
const APART: f64 = 22.0;
/// Room around the figure, px.
const PADDING: f64 = 6.0;
/// Strokes and gaps of broken lines, px.
const DASHES: &str = "9 6";
/// Strokes and gaps of dotted lines, px.
const DOTS: &str = "2 5";
/// Radius of a mark, px.
const MARK: f64 = 3.2;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A line.
    Line,
    /// A broken line.
    Dashed,
    /// A dotted line.
    Dotted,
    /// Open circles.
    Circles,
    /// Crosses.
    Crosses,
}

impl Look {
    /// Strokes and gaps of a line, px; none of a whole one, and of marks.
    fn dashes(self) -> Option<&'static str> {
        match self {
            Self::Dashed => Some(DASHES),
            Self::Dotted => Some(DOTS),
            Self::Line | Self::Circles | Self::Crosses => None,
        }
    }

    /// The shape of marks; none of a line.
    fn mark(self) -> Option<MarkShape> {
        match self {
            Self::Circles => Some(MarkShape::Ring),
            Self::Crosses => Some(MarkShape::Cross),
            Self::Line | Self::Dashed | Self::Dotted => None,
        }
    }
}

/// Points with their name in the legend.
#[derive(Clone, Debug)]
pub struct ChartSeries {
    /// Name in the legend; none when empty. Series of one name and look stand there once.
    pub name: String,
    /// (x, y) in drawing order, in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Bars below and above each point, in the unit of y; none when empty.
    pub bars: Vec<(f64, f64)>,
    /// How the points are drawn.
    pub look: Look,
    /// CSS colour.
    pub colour: String,
}

impl ChartSeries {
    /// Points, in the units of the axes, in the colour number `index` of the house.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>, look: Look, index: usize) -> Self {
        Self { name: name.into(), points, bars: Vec::new(), look, colour: style::colour(index).into() }
    }

    /// What the others are compared with, in the units of the axes: black circles.
    pub fn reference(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        let colour = style::INK.into();
        Self { name: name.into(), points, bars: Vec::new(), look: Look::Circles, colour }
    }
}

/// An axis: label with unit, range when it is given, logarithmic or not.
#[derive(Clone, Debug, Default)]
pub struct ChartAxis {
    /// Quantity and unit.
    pub label: String,
    /// Range, in the unit of the label; without it that of the series.
    pub range: Option<(f64, f64)>,
    /// Logarithmic.
    pub log: bool,
}

impl ChartAxis {
    /// A linear axis over the range of the series.
    pub fn new(label: impl Into<String>) -> Self {
        Self { label: label.into(), ..Self::default() }
    }

    /// A logarithmic axis over the range of the series; upwards with a tick per decade.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), log: true, ..Self::default() }
    }

    /// The same with a given range, in the unit of the label.
    pub fn over(self, low: f64, high: f64) -> Self {
        Self { range: Some((low, high)), ..self }
    }
}

/// Series over common axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What this panel shows; empty when the quantity upwards says it.
    pub title: String,
    /// Axis to the right.
    pub x: ChartAxis,
    /// Axis upwards; its label stands above the panel.
    pub y: ChartAxis,
    /// Curves and marks, the first below.
    pub series: Vec<ChartSeries>,
    /// Shaded ground: the range of y that passes, in its unit.
    pub passes: Option<(f64, f64)>,
}

/// `charts` row by row in `columns` columns, each panel `height` px high, the legend below.
///
/// A label of x that a column shares stands below its last panel.
pub fn grid(name: &'static str, charts: Vec<Chart>, columns: usize, height: f64) -> Figure {
    let rows = charts.len().div_ceil(columns);
    let width = (style::WIDTH - 2.0 * PADDING) / columns as f64;
    let labelled = |i: usize| charts.get(i + columns).is_none_or(|below| below.x.label != charts[i].x.label);
    let heights: Vec<f64> =
        (0..rows).map(|row| height + if labelled(row * columns) { LABEL } else { 0.0 }).collect();
    let mut scene = Canvas::new(style::WIDTH, heights.iter().sum::<f64>() + 2.0 * PADDING);
    for (i, chart) in charts.iter().enumerate() {
        let (row, column) = (i / columns, i % columns);
        let x = PADDING + width * column as f64;
        let y = PADDING + heights[..row].iter().sum::<f64>();
        let foot = if labelled(i) { FOOT + LABEL } else { FOOT };
        drawn(chart, [x, y, width, heights[row]], foot, labelled(i)).draw(&mut scene);
        caption(&mut scene, chart, (x, y), (charts.len() > 1).then_some(i));
    }
    legend(&mut scene, &charts);
    Figure::new(name, scene)
}

/// Letter, title and the quantity upwards, above the panel at `(x, y)`.
fn caption(scene: &mut Canvas, chart: &Chart, (x, y): (f64, f64), letter: Option<usize>) {
    let (mut start, above) = (x + LEFT, y + HEAD - 8.0);
    if let Some(index) = letter {
        let letter = char::from(b'a' + index as u8);
        scene.elements.push(style::words(start, above, letter, TextAnchor::Start, true));
        start += 16.0;
    }
    let (low, high) = up(chart);
    let label =
        if chart.y.log { chart.y.label.clone() } else { TickScale::new(low, high).label(&chart.y.label) };
    let title = if chart.title.is_empty() { label } else { format!("{}: {label}", chart.title) };
    scene.elements.push(style::words(start, above, title, TextAnchor::Start, false));
}

/// The panel at a place with `foot` px below its frame.
fn drawn(chart: &Chart, place: [f64; 4], foot: f64, labelled: bool) -> PlotFrame {
    let (left, right) = across(chart);
    let (low, high) = up(chart);
    let scale = TickScale::new(left, right);
    let x = if chart.x.log { FrameAxis::log(left, right) } else { FrameAxis::of(scale) };
    let label = if chart.x.log { chart.x.label.clone() } else { scale.label(&chart.x.label) };
    let x = if labelled { x.labelled(label) } else { x };
    let y = if chart.y.log {
        FrameAxis::every(low, high, ((high - low) / 5.0).ceil(), style::decade)
    } else {
        FrameAxis::of(TickScale::new(low, high))
    };
    let mut frame = PlotFrame::new(place, [LEFT, RIGHT, HEAD, foot], x, y);
    if let Some((floor, ceiling)) = chart.passes {
        let (floor, ceiling) = (upwards(&chart.y, floor), upwards(&chart.y, ceiling));
        frame.shade(floor.max(low), ceiling.min(high), style::SHADE, 0.5);
    }
    if !chart.y.log && low < 0.0 && high > 0.0 {
        frame.guide(0.0);
    }
    chart.series.iter().for_each(|series| plot(&mut frame, series, &chart.y));
    frame
}

/// The range to the right.
fn across(chart: &Chart) -> (f64, f64) {
    range(chart, &chart.x, |point, _| [point.0; 2])
}

/// The range upwards, in decades on a logarithmic axis.
fn up(chart: &Chart) -> (f64, f64) {
    let (low, high) = range(chart, &chart.y, |point, bar| [point.1 - bar.0, point.1 + bar.1]);
    (upwards(&chart.y, low), upwards(&chart.y, high))
}

/// Height of `value` on the axis: its decades on a logarithmic one.
fn upwards(axis: &ChartAxis, value: f64) -> f64 {
    if axis.log { value.log10() } else { value }
}

fn plot(frame: &mut PlotFrame, series: &ChartSeries, y: &ChartAxis) {
    let points: Vec<(f64, f64)> = series.points.iter().map(|point| (point.0, upwards(y, point.1))).collect();
    let colour = series.colour.as_str();
    if series.look.mark().is_some() {
        points.iter().zip(&series.bars).for_each(|(point, bar)| frame.bar(*point, *bar, colour));
    }
    match series.look.mark() {
        Some(shape) => frame.marks(&points, shape, MARK, colour, 1.0),
        None => frame.line(points, colour, style::CURVE, series.look.dashes()),
    }
}

/// The range of `axis`: as given, or else that of the series with a margin.
fn range(
    chart: &Chart,
    axis: &ChartAxis,
    of: impl Fn(&(f64, f64), (f64, f64)) -> [f64; 2] + Copy,
) -> (f64, f64) {
    if let Some(given) = axis.range {
        return given;
    }
    let ends = chart.series.iter().flat_map(|series| {
        let bar = |i: usize| series.bars.get(i).copied().unwrap_or_default();
        series.points.iter().enumerate().flat_map(move |(i, point)| of(point, bar(i)))
    });
    let scaled = ends.map(|value| if axis.log { value.log10() } else { value });
    let (low, high) = style::span(scaled);
    let TickScale { low, high, .. } = TickScale::padded(low, high, 0.05);
    let back = |value: f64| if axis.log { 10_f64.powf(value) } else { value };
    (back(low), back(high))
}

/// Below the panels a sample and the name of every kind of series, in as many lines as they need.
fn legend(scene: &mut Canvas, charts: &[Chart]) {
    let mut kinds: Vec<&ChartSeries> = Vec::new();
    for series in charts.iter().flat_map(|chart| &chart.series).filter(|series| !series.name.is_empty()) {
        if kinds.iter().all(|known| known.name != series.name || known.look != series.look) {
            kinds.push(series);
        }
    }
    let more = if kinds.len() > MOST_NAMED { kinds.len() - (MOST_NAMED - 1) } else { 0 };
    kinds.truncate(kinds.len() - more);
    let room = |series: &ChartSeries| SAMPLE + 8.0 + 6.9 * series.name.chars().count() as f64 + APART;
    let mut lines: Vec<(f64, Vec<&ChartSeries>)> = Vec::new();
    for series in kinds {
        let width = room(series);
        match lines.last_mut() {
            Some((taken, line)) if *taken + width - APART <= style::WIDTH - 2.0 * PADDING => {
                *taken += width;
                line.push(series);
            }
            _ => lines.push((width, vec![series])),
        }
    }
    for (taken, line) in lines {
        let mut x = 0.5 * (style::WIDTH - taken + APART).max(0.0);
        for series in line {
            sample(scene, series, x, scene.height + 8.0);
            let (at, name) = (x + SAMPLE + 8.0, series.name.clone());
            scene.elements.push(style::words(at, scene.height + 12.0, name, TextAnchor::Start, false));
            x += room(series);
        }
        scene.height += LEGEND;
    }
    if more > 0 {
        let (x, y) = (0.5 * style::WIDTH, scene.height + 12.0);
        scene.elements.push(style::words(x, y, format!("and {more} more"), TextAnchor::Middle, false));
        scene.height += LEGEND;
    }
}

/// A short line or a mark as the series has them.
fn sample(scene: &mut Canvas, series: &ChartSeries, x: f64, y: f64) {
    let colour = series.colour.as_str();
    match series.look.mark() {
        Some(shape) => scene.elements.extend(mark((x + 0.5 * SAMPLE, y), shape, MARK, colour, 1.0)),
        None => {
            let dashes = series.look.dashes();
            scene.elements.push(style::sample((x, y), (x + SAMPLE, y), colour, style::CURVE, dashes));
        }
    }
}

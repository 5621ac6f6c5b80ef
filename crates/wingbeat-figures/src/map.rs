//! Measures of a sweep over the values that were drawn: cells of a grid, or points.

use wingbeat::simulate::Record;

use crate::canvas::{Canvas, Colour, Primitive, TextAnchor};
use crate::chart::{Chart, ChartAxis, ChartSeries, Look, grid};
use crate::plot_frame::{FrameAxis, MarkShape, PlotFrame};
use crate::scale::TickScale;
use crate::wake::Diverging;
use crate::write::Figure;
use crate::{Error, needed, style};

/// Width and height of a panel, px.
const PANEL: (f64, f64) = (424.0, 270.0);
/// Room to the left of a panel, to the right with the bar of colours, above and below, px.
const ROOM: [f64; 4] = [56.0, 78.0, 28.0, 42.0];
/// Room around the figure, px.
const PADDING: f64 = 6.0;
/// Radius of a point, px.
const POINT: f64 = 5.0;
/// Shades of the bar of colours.
const SHADES: usize = 60;
/// Most runs that are drawn: more are less than a dot each. *Choice.*
const MOST_RUNS: usize = 20_000;

/// `measures` over the drawn values of `keys`, each a column and its label: colours over the first two, cells where they are a whole grid and
/// points otherwise; marks over the only one.
pub fn map(
    record: &Record,
    keys: &[(&str, String)],
    measures: &[&str],
    whole: bool,
) -> Result<Figure, Error> {
    if record.rows() > MOST_RUNS {
        return Err(Error::Many { rows: record.rows(), most: MOST_RUNS });
    }
    let [x, y, ..] = keys else { return over_one(record, keys, measures) };
    let (x, y) = (DrawnValues::of(record, x)?, DrawnValues::of(record, y)?);
    let cells = whole && keys.len() == 2 && x.places.len() > 1 && y.places.len() > 1;
    let maps = measures.iter().map(|name| RangedMeasure::of(record, name)).collect::<Result<Vec<_>, _>>()?;
    let rows = maps.len().div_ceil(2);
    let size = (2.0 * PANEL.0 + 2.0 * PADDING, rows as f64 * PANEL.1 + 2.0 * PADDING);
    let mut scene = Canvas::new(size.0, size.1);
    for (i, measured) in maps.iter().enumerate() {
        let corner = (PADDING + PANEL.0 * (i % 2) as f64, PADDING + PANEL.1 * (i / 2) as f64);
        let axis = |drawn: &DrawnValues| FrameAxis::of(drawn.scale).labelled(drawn.scale.label(&drawn.name));
        let mut frame = PlotFrame::new([corner.0, corner.1, PANEL.0, PANEL.1], ROOM, axis(&x), axis(&y));
        if cells {
            measured.fill(&mut scene, corner, &x, &y);
        } else {
            measured.points(&mut frame, &x, &y);
        }
        frame.draw(&mut scene);
        measured.bar(&mut scene, corner, i);
    }
    Ok(Figure::new("map", scene))
}

fn over_one(record: &Record, keys: &[(&str, String)], measures: &[&str]) -> Result<Figure, Error> {
    let (key, label) = keys.first().ok_or(Error::Rows { rows: 0, needed: 1 })?;
    let x = needed(record, key)?;
    let (low, high) = style::span(x.iter().copied());
    let room = if high > low { 0.05 * (high - low) } else { 0.1 * low.abs().max(1e-9) };
    let panel = |name: &&str| -> Result<Chart, Error> {
        let y = needed(record, name)?;
        let mut points: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).collect();
        wingbeat::math::order::ascend_by(&mut points, |item| item.0);
        let marks = points.iter().copied().filter(|point| point.1.is_finite()).collect();
        let unit = record.column(name).map_or("", |column| column.unit.as_str());
        let line = ChartSeries { colour: style::tint(0), ..ChartSeries::new("", points, Look::Line, 0) };
        Ok(Chart {
            title: String::new(),
            // All panels have the same axis, whichever runs have their measure.
            x: ChartAxis::new(label.clone()).over(low - room, high + room),
            y: ChartAxis::new(labelled(name, unit)),
            series: vec![line, ChartSeries::new("", marks, Look::Circles, 0)],
            passes: None,
        })
    };
    Ok(grid("map", measures.iter().map(panel).collect::<Result<_, _>>()?, 2, 210.0))
}

fn labelled(name: &str, unit: &str) -> String {
    let name = name.replace('_', " ");
    if unit.is_empty() { name } else { format!("{name} [{unit}]") }
}

/// Values drawn for one key.
struct DrawnValues<'a> {
    name: String,
    values: &'a [f64],
    /// Those that are different, ascending.
    places: Vec<f64>,
    scale: TickScale,
}

impl<'a> DrawnValues<'a> {
    fn of(record: &'a Record, (key, name): &(&'a str, String)) -> Result<Self, Error> {
        let values = needed(record, key)?;
        let mut places = values.to_vec();
        wingbeat::math::order::ascend(&mut places);
        places.dedup();
        let (low, high) = style::span(values.iter().copied());
        // Half a cell of a grid lies beyond its ends.
        let margin = 0.5 * (high - low) / (places.len().max(2) - 1) as f64;
        let margin = margin.max(0.04 * (high - low));
        Ok(Self { name: name.clone(), values, places, scale: TickScale::new(low - margin, high + margin) })
    }

    /// The share of the axis at `value`.
    fn share(&self, value: f64) -> f64 {
        (value - self.scale.low) / (self.scale.high - self.scale.low)
    }

    /// The ends of the cell at the place of a value: half way to its neighbours.
    fn cell(&self, value: f64) -> (f64, f64) {
        let at = self.places.partition_point(|place| *place < value);
        let half = |a: usize, b: usize| 0.5 * (self.places[a] + self.places[b]);
        let low = if at > 0 { half(at - 1, at) } else { self.scale.low };
        let high = if at + 1 < self.places.len() { half(at, at + 1) } else { self.scale.high };
        (self.share(low), self.share(high))
    }
}

/// A measure with its range.
struct RangedMeasure<'a> {
    values: &'a [f64],
    label: String,
    scale: TickScale,
}

impl<'a> RangedMeasure<'a> {
    fn of(record: &'a Record, name: &str) -> Result<Self, Error> {
        let values = needed(record, name)?;
        let unit = record.column(name).map_or("", |column| column.unit.as_str());
        let (low, high) = style::span(values.iter().copied());
        Ok(Self { values, label: labelled(name, unit), scale: TickScale::new(low, high) })
    }

    /// From dark to light; of a measure that is negative somewhere blue below zero, white at it and red above.
    fn colour(&self, value: f64) -> String {
        let TickScale { low, high, .. } = self.scale;
        if low < 0.0 {
            return Diverging { most: low.abs().max(high.abs()) }.colour(value);
        }
        let share = (value - self.scale.low) / (self.scale.high - self.scale.low);
        Colour::Rgb(style::viridis(share)).to_string()
    }

    /// The runs as points.
    fn points(&self, frame: &mut PlotFrame, x: &DrawnValues, y: &DrawnValues) {
        for run in (0..self.values.len()).filter(|run| self.values[*run].is_finite()) {
            let point = (x.values[run], y.values[run]);
            frame.marks(&[point], MarkShape::Disc, POINT, &self.colour(self.values[run]), 1.0);
        }
    }

    /// A cell for every run; those that failed stay white.
    fn fill(&self, scene: &mut Canvas, (left, top): (f64, f64), x: &DrawnValues, y: &DrawnValues) {
        let (wide, high) = (PANEL.0 - ROOM[0] - ROOM[1], PANEL.1 - ROOM[2] - ROOM[3]);
        for run in (0..self.values.len()).filter(|run| self.values[*run].is_finite()) {
            let ((from, to), (low, up)) = (x.cell(x.values[run]), y.cell(y.values[run]));
            let corner = (left + ROOM[0] + wide * from, top + ROOM[2] + high * (1.0 - up));
            let size = (wide * (to - from), high * (up - low));
            scene.elements.push(rectangle(corner, size, &self.colour(self.values[run])));
        }
    }

    /// The title and the bar of colours with its numbers.
    fn bar(&self, scene: &mut Canvas, (left, top): (f64, f64), index: usize) {
        let letter = char::from(b'a' + index as u8);
        let above = top + ROOM[2] - 8.0;
        scene.elements.push(style::words(left + ROOM[0], above, letter, TextAnchor::Start, true));
        let label = self.scale.label(&self.label);
        scene.elements.push(style::words(left + ROOM[0] + 16.0, above, label, TextAnchor::Start, false));
        let (x, high) = (left + PANEL.0 - ROOM[1] + 12.0, PANEL.1 - ROOM[2] - ROOM[3]);
        let (low, range) = (self.scale.low, self.scale.high - self.scale.low);
        for k in 0..SHADES {
            let share = (k as f64 + 0.5) / SHADES as f64;
            let y = top + ROOM[2] + high * (1.0 - (k + 1) as f64 / SHADES as f64);
            let colour = self.colour(low + range * share);
            scene.elements.push(rectangle((x, y), (14.0, high / SHADES as f64 + 0.3), &colour));
        }
        let first = (low / self.scale.step).ceil();
        let ticks = (0..20).map(|k| (first + f64::from(k)) * self.scale.step);
        for tick in ticks.take_while(|tick| *tick <= low + range * (1.0 + 1e-9)) {
            let y = top + ROOM[2] + high * (1.0 - (tick - low) / range);
            let number = self.scale.number(tick);
            scene.elements.push(style::words(x + 18.0, y + 4.0, number, TextAnchor::Start, false));
        }
    }
}

fn rectangle((x, y): (f64, f64), (width, height): (f64, f64), colour: &str) -> Primitive {
    Primitive::Rect { x, y, width, height, fill: Colour::from(colour), opacity: None }
}

//! Measures of a sweep over the values that were drawn: cells of a grid, or points.

use wingbeat::simulate::Record;

use crate::canvas::{Canvas, Colour, Primitive, TextAnchor};
use crate::chart::{Chart, ChartAxis, ChartSeries, Look, grid};
use crate::plot_frame::{FrameAxis, MarkShape, PlotFrame, mark};
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
/// Room for the legend, px.
const LEGEND: f64 = 26.0;
/// What it says of crosses.
const REFUSED: &str = "refused by the run's own verdict: in no colour and in no table";
/// Most runs that are drawn: more are less than a dot each. *Choice.*
const MOST_RUNS: usize = 20_000;

/// `measures` over the drawn values of `keys`, each a column and its label: colours over the first two, cells where they are a whole grid and
/// points otherwise; marks over the only one. Runs that are not among the rows `usable` have crosses in place of their values, as the legend says.
pub fn map(
    record: &Record,
    keys: &[(&str, String)],
    measures: &[&str],
    (whole, usable): (bool, &[usize]),
) -> Result<Figure, Error> {
    if record.rows() > MOST_RUNS {
        return Err(Error::Many { rows: record.rows(), most: MOST_RUNS });
    }
    let [x, y, ..] = keys else { return over_one(record, keys, measures, usable) };
    let (x, y) = (DrawnValues::of(record, x)?, DrawnValues::of(record, y)?);
    let cells = whole && keys.len() == 2 && x.places.len() > 1 && y.places.len() > 1;
    let maps =
        measures.iter().map(|name| RangedMeasure::of(record, name, usable)).collect::<Result<Vec<_>, _>>()?;
    let rows = maps.len().div_ceil(2);
    let legend = if maps.iter().any(|measured| !measured.refused.is_empty()) { LEGEND } else { 0.0 };
    let size = (2.0 * PANEL.0 + 2.0 * PADDING, rows as f64 * PANEL.1 + 2.0 * PADDING + legend);
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
        measured.crosses(&mut frame, &x, &y);
        frame.draw(&mut scene);
        measured.bar(&mut scene, corner, i);
    }
    if legend > 0.0 {
        let (x, y) = (PADDING + ROOM[0], size.1 - PADDING - 0.5 * LEGEND);
        scene.elements.extend(mark((x, y), MarkShape::Cross, POINT, style::INK, 1.0));
        scene.elements.push(style::words(x + 14.0, y + 4.5, REFUSED, TextAnchor::Start, false));
    }
    Ok(Figure::new("map", scene))
}

fn over_one(
    record: &Record,
    keys: &[(&str, String)],
    measures: &[&str],
    usable: &[usize],
) -> Result<Figure, Error> {
    let (key, label) = keys.first().ok_or(Error::Rows { rows: 0, needed: 1 })?;
    let x = needed(record, key)?;
    let (low, high) = style::span(x.iter().copied());
    let room = if high > low { 0.05 * (high - low) } else { 0.1 * low.abs().max(1e-9) };
    let panel = |name: &&str| -> Result<Chart, Error> {
        let y = needed(record, name)?;
        let (kept, refused) = parted(y, usable);
        let of = |rows: &[usize]| rows.iter().map(|row| (x[*row], y[*row])).collect::<Vec<(f64, f64)>>();
        let (mut points, crossed) = (of(&kept), of(&refused));
        wingbeat::math::order::ascend_by(&mut points, |item| item.0);
        let marks = points.iter().copied().filter(|point| point.1.is_finite()).collect();
        let unit = record.column(name).map_or("", |column| column.unit.as_str());
        let line = ChartSeries { colour: style::tint(0), ..ChartSeries::new("", points, Look::Line, 0) };
        let mut series = vec![line, ChartSeries::new("", marks, Look::Circles, 0)];
        if !crossed.is_empty() {
            let crosses = ChartSeries::new(REFUSED, crossed, Look::Crosses, 0);
            series.push(ChartSeries { colour: style::INK.into(), ..crosses });
        }
        Ok(Chart {
            title: String::new(),
            // All panels have the same axis, whichever runs have their measure.
            x: ChartAxis::new(label.clone()).over(from_zero(low, low - room), high + room),
            y: ChartAxis::new(labelled(name, unit)),
            series,
            passes: None,
        })
    };
    Ok(grid("map", measures.iter().map(panel).collect::<Result<_, _>>()?, 2, 210.0))
}

/// The rows whose value is a number: those that are `usable` (ascending), and the others.
fn parted(values: &[f64], usable: &[usize]) -> (Vec<usize>, Vec<usize>) {
    (0..values.len())
        .filter(|row| values[*row].is_finite())
        .partition(|row| usable.binary_search(row).is_ok())
}

/// The lower end of an axis whose values begin at `low`, moved to zero where it passes zero and they do not.
fn from_zero(low: f64, end: f64) -> f64 {
    if low >= 0.0 { end.max(0.0) } else { end }
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
        Ok(Self {
            name: name.clone(),
            values,
            places,
            scale: TickScale::new(from_zero(low, low - margin), high + margin),
        })
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
    /// Rows that are drawn by their values, and those that are crossed.
    kept: Vec<usize>,
    refused: Vec<usize>,
    label: String,
    scale: TickScale,
}

impl<'a> RangedMeasure<'a> {
    fn of(record: &'a Record, name: &str, usable: &[usize]) -> Result<Self, Error> {
        let values = needed(record, name)?;
        let unit = record.column(name).map_or("", |column| column.unit.as_str());
        let (kept, refused) = parted(values, usable);
        let (low, high) = style::span(kept.iter().map(|row| values[*row]));
        Ok(Self { values, kept, refused, label: labelled(name, unit), scale: TickScale::new(low, high) })
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
        for &run in &self.kept {
            let point = (x.values[run], y.values[run]);
            frame.marks(&[point], MarkShape::Disc, POINT, &self.colour(self.values[run]), 1.0);
        }
    }

    /// Crosses where runs are refused.
    fn crosses(&self, frame: &mut PlotFrame, x: &DrawnValues, y: &DrawnValues) {
        let points: Vec<(f64, f64)> =
            self.refused.iter().map(|&run| (x.values[run], y.values[run])).collect();
        frame.marks(&points, MarkShape::Cross, POINT, style::INK, 1.0);
    }

    /// A cell for every run that is used; the others stay white.
    fn fill(&self, scene: &mut Canvas, (left, top): (f64, f64), x: &DrawnValues, y: &DrawnValues) {
        let (wide, high) = (PANEL.0 - ROOM[0] - ROOM[1], PANEL.1 - ROOM[2] - ROOM[3]);
        for &run in &self.kept {
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

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::simulate::Column;

    fn record() -> Record {
        let column =
            |name: &str, values: [f64; 4]| Column { values: values.into(), ..Column::new(name, "", "") };
        let columns = vec![
            column("speed", [0.5, 0.5, 6.0, 6.0]),
            column("frequency", [0.3, 3.0, 0.3, 3.0]),
            column("thrust", [1.0, 2.0, 3.0, 900.0]),
        ];
        Record::new(columns, 0).unwrap()
    }

    /// What a run has that its own verdict refuses is drawn in no colour and stretches no scale.
    #[test]
    fn refused_runs_are_crossed() {
        let keys = [("speed", "speed".to_owned()), ("frequency", "frequency".to_owned())];
        for (keys, whole) in [(&keys[..], true), (&keys[..], false), (&keys[..1], true)] {
            let text = |usable: &[usize]| map(&record(), keys, &["thrust"], (whole, usable)).unwrap().svg();
            let (all, three) = (text(&[0, 1, 2, 3]), text(&[0, 1, 2]));
            assert!(!all.contains(REFUSED) && three.contains(REFUSED), "{three}");
            assert!(all.contains(">800<") || all.contains(">900<"), "{all}");
            // The only axis of marks holds the crosses too.
            assert!(keys.len() == 1 || !three.contains("00<"), "{three}");
        }
    }

    #[test]
    fn axes_of_what_is_not_negative_begin_at_zero_or_above() {
        let of = |key: &str| DrawnValues::of(&record(), &(key, String::new())).unwrap().scale.low;
        assert_eq!((of("speed"), of("frequency")), (0.0, 0.0));
        assert_eq!((from_zero(-1.0, -1.5), from_zero(2.0, 1.5)), (-1.5, 1.5));
    }
}

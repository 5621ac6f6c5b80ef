//! The frame of a panel: its axes with ticks and numbers, and what lies within.

use crate::canvas::{Canvas, Colour, PaperPoint, PathData, Primitive, TextAnchor};
use crate::scale::TickScale;
use crate::style;

/// Length of a tick beside a number, and of one without, px.
const TICK: (f64, f64) = (5.0, 3.0);
/// From the frame to the base line of the numbers below it, px.
const BELOW: f64 = 16.0;
/// From the frame to the numbers on its left, and from the middle of these down to their base line, px.
const BESIDE: (f64, f64) = (8.0, 4.4);
/// From the lower and from the left edge of a panel to the base line of the label there, px.
const LABEL: (f64, f64) = (9.0, 14.0);
/// Half the width of the end of a bar, px.
const BAR: f64 = 3.0;
/// Furthest place on paper, px: what lies further is out of any frame, and its number would be long.
const FURTHEST: f64 = 1e5;
/// Most ticks of an axis, with those without numbers.
const MOST_TICKS: f64 = 200.0;
/// Decades from which a logarithmic axis has numbers at powers of ten only. *Choice.*
const DECADES: f64 = 2.5;
/// By how much a mark may lie beyond the frame by rounding, px.
const NEAR: f64 = 1e-6;

/// An axis: its range with ticks, each with its number where it has one, and its label.
#[derive(Clone, Debug)]
pub struct FrameAxis {
    low: f64,
    high: f64,
    log: bool,
    ticks: Vec<(f64, String)>,
    label: Option<String>,
}

impl FrameAxis {
    /// The range of a scale, with its ticks.
    pub fn of(scale: TickScale) -> Self {
        Self::every(scale.low, scale.high, scale.step, |value| scale.number(value))
    }

    /// From `low` to `high` with ticks at the multiples of `step`, all in the unit of the axis.
    pub fn every(low: f64, high: f64, step: f64, number: impl Fn(f64) -> String) -> Self {
        let near = 1e-9 * (high - low).abs();
        let (first, last) = (((low - near) / step).ceil(), ((high + near) / step).floor());
        let count = (last - first + 1.0).clamp(0.0, MOST_TICKS) as usize;
        let tick = |k: usize| (first + k as f64) * step;
        let ticks = (0..count).map(|k| (tick(k), number(tick(k)))).collect();
        Self { low, high, log: false, ticks, label: None }
    }

    /// From `low` to `high`, above zero and in the unit of the axis, by their logarithms.
    pub fn log(low: f64, high: f64) -> Self {
        let decades = (high / low).log10();
        let numbered: &[u8] = if decades < DECADES { &[1, 2, 5] } else { &[1] };
        let near = 1.0 + 1e-9;
        let first = low.log10().floor() as i32;
        let powers = (first..=high.log10().floor() as i32).take((MOST_TICKS / 9.0) as usize);
        let all = powers.flat_map(|power| (1..=9).map(move |digit| (digit, power)));
        let tick = |(digit, power): (u8, i32)| {
            let value = f64::from(digit) * 10_f64.powi(power);
            let number = if digit == 1 { style::decade(f64::from(power)) } else { style::number(value) };
            (value, if numbered.contains(&digit) { number } else { String::new() })
        };
        let ticks = all.map(tick).filter(|tick| low <= tick.0 * near && tick.0 <= high * near).collect();
        Self { low, high, log: true, ticks, label: None }
    }

    /// The same with a label.
    pub fn labelled(self, label: impl Into<String>) -> Self {
        Self { label: Some(label.into()), ..self }
    }

    /// The same without numbers: an axis below has them.
    pub fn without_numbers(mut self) -> Self {
        self.ticks.iter_mut().for_each(|tick| tick.1.clear());
        self
    }

    /// The share of the axis (dimensionless) at a value in its unit; no number where it has none.
    fn share(&self, value: f64) -> f64 {
        let place = |value: f64| if self.log { value.ln() } else { value };
        (place(value) - place(self.low)) / (place(self.high) - place(self.low))
    }
}

/// How points are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkShape {
    /// A filled circle.
    Disc,
    /// An open circle.
    Ring,
    /// Two crossed strokes.
    Cross,
    /// A square on its corner.
    Diamond,
}

/// A panel's place on paper, px: left edge, upper edge, width and height.
pub type PanelPlace = [f64; 4];

/// A panel: axes about what is drawn within.
#[derive(Clone, Debug)]
pub struct PlotFrame {
    panel: PanelPlace,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: FrameAxis,
    y: FrameAxis,
    inside: Vec<Primitive>,
    marks: Vec<Primitive>,
}

impl PlotFrame {
    /// A frame in a panel with `room` to its left, right, above and below, px.
    pub fn new(panel: PanelPlace, room: [f64; 4], x: FrameAxis, y: FrameAxis) -> Self {
        let [from, top, width, height] = panel;
        Self {
            panel,
            left: from + room[0],
            right: from + width - room[1],
            top: top + room[2],
            bottom: top + height - room[3],
            x,
            y,
            inside: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Where a point, in the units of the axes, lies on paper.
    pub fn at(&self, (x, y): (f64, f64)) -> PaperPoint {
        let held = |place: f64| place.clamp(-FURTHEST, FURTHEST);
        (
            held(self.left + (self.right - self.left) * self.x.share(x)),
            held(self.bottom - (self.bottom - self.top) * self.y.share(y)),
        )
    }

    /// Shades the ground between two heights, in the unit of the axis upwards.
    pub fn shade(&mut self, from: f64, to: f64, colour: &str, opacity: f64) {
        let (low, high) = (self.at((self.x.low, from)).1, self.at((self.x.low, to)).1);
        let corners = [(self.left, low), (self.right, low), (self.right, high), (self.left, high)];
        self.inside.push(style::area(&corners, colour, opacity));
    }

    /// A line across the panel at a height in the unit of the axis upwards.
    pub fn across(&mut self, height: f64, colour: &str, weight: f64, dashes: Option<&str>) {
        let y = self.at((self.x.low, height)).1;
        self.inside.push(style::sample((self.left, y), (self.right, y), colour, weight, dashes));
    }

    /// A line up the panel at a place in the unit of the axis to the right.
    pub fn upwards(&mut self, place: f64, colour: &str, weight: f64, dashes: Option<&str>) {
        let x = self.at((place, self.y.low)).0;
        self.inside.push(style::sample((x, self.bottom), (x, self.top), colour, weight, dashes));
    }

    /// A thin line that guides the eye, at a height in the unit of the axis upwards.
    pub fn guide(&mut self, height: f64) {
        self.across(height, style::GUIDE, style::GUIDE_WEIGHT, None);
    }

    /// A line through points, in the units of the axes, which points that are not finite part.
    pub fn line(
        &mut self,
        points: impl IntoIterator<Item = (f64, f64)>,
        colour: &str,
        weight: f64,
        dashes: Option<&str>,
    ) {
        self.inside.push(Primitive::PolyLine {
            points: points.into_iter().map(|point| self.at(point)).collect(),
            stroke: Colour::from(colour),
            stroke_width: weight,
            stroke_dasharray: dashes.map(Into::into),
        });
    }

    /// The ground between two curves, as (x, low, high) in the units of the axes.
    pub fn band(&mut self, edges: &[(f64, f64, f64)], colour: &str, opacity: f64) {
        let finite = |edge: &(f64, f64, f64)| edge.0.is_finite() && edge.1.is_finite() && edge.2.is_finite();
        for piece in edges.split(|edge| !finite(edge)).filter(|piece| piece.len() > 1) {
            let low = piece.iter().map(|edge| self.at((edge.0, edge.1)));
            let high = piece.iter().rev().map(|edge| self.at((edge.0, edge.2)));
            let corners: Vec<PaperPoint> = low.chain(high).collect();
            self.inside.push(style::area(&corners, colour, opacity));
        }
    }

    /// A mark of the radius `size`, px, at each point within the axes, in their units: whole where it lies on the frame.
    pub fn marks(&mut self, points: &[(f64, f64)], shape: MarkShape, size: f64, colour: &str, opacity: f64) {
        for point in points {
            let at = self.at(*point);
            let within = |low: f64, value: f64, high: f64| (low - NEAR..=high + NEAR).contains(&value);
            if within(self.left, at.0, self.right) && within(self.top, at.1, self.bottom) {
                self.marks.extend(mark(at, shape, size, colour, opacity));
            }
        }
    }

    /// An upright bar from `below` to `above` a point, all in the units of the axes.
    pub fn bar(&mut self, (x, y): (f64, f64), (below, above): (f64, f64), colour: &str) {
        let (low, high) = (self.at((x, y - below)), self.at((x, y + above)));
        if [low, high].iter().all(|end| end.0.is_finite() && end.1.is_finite()) {
            let stroke = |from, to| style::sample(from, to, colour, style::FINE, None);
            let end = |at: PaperPoint| stroke((at.0 - BAR, at.1), (at.0 + BAR, at.1));
            self.inside.extend([stroke(low, high), end(low), end(high)]);
        }
    }

    /// Words in the middle over a point in the units of the axes.
    pub fn words(&mut self, point: (f64, f64), content: String) {
        let (x, y) = self.at(point);
        self.inside.push(style::small(x, y, content, TextAnchor::Middle));
    }

    /// Draws, as a group, what is within, cut at the frame, then the frame with its ticks, numbers and labels, and then the marks.
    pub fn draw(self, canvas: &mut Canvas) {
        let Self { panel, left, right, top, bottom, .. } = self;
        let line = |from, to| style::sample(from, to, style::INK, style::AXIS, None);
        let length = |number: &str| if number.is_empty() && self.x.log { TICK.1 } else { TICK.0 };
        let mut outside = Vec::new();
        for (value, number) in &self.x.ticks {
            let x = left + (right - left) * self.x.share(*value);
            outside.push(line((x, bottom - length(number)), (x, bottom)));
            if !number.is_empty() {
                outside.push(style::small(x, bottom + BELOW, number.clone(), TextAnchor::Middle));
            }
        }
        for (value, number) in &self.y.ticks {
            let y = bottom - (bottom - top) * self.y.share(*value);
            outside.push(line((left, y), (left + length(number), y)));
            if !number.is_empty() {
                outside.push(style::small(left - BESIDE.0, y + BESIDE.1, number.clone(), TextAnchor::End));
            }
        }
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        outside.extend((0..4).map(|k| line(corners[k], corners[(k + 1) % 4])));
        if let Some(label) = self.x.label {
            let at = (0.5 * (left + right), panel[1] + panel[3] - LABEL.0);
            outside.push(style::words(at.0, at.1, label, TextAnchor::Middle, false));
        }
        if let Some(content) = self.y.label {
            outside.push(Primitive::Text {
                x: panel[0] + LABEL.1,
                y: 0.5 * (top + bottom),
                content,
                size: style::LETTERS,
                anchor: TextAnchor::Middle,
                rotate: Some(-90.0),
                bold: false,
                color: Some(Colour::from(style::INK)),
            });
        }
        let (width, height) = (right - left, bottom - top);
        canvas.elements.push(Primitive::GroupStart { right: 0.0, down: 0.0 });
        canvas.elements.push(Primitive::ClipStart { x: left, y: top, width, height });
        canvas.elements.extend(self.inside);
        canvas.elements.push(Primitive::ClipEnd);
        canvas.elements.extend(outside);
        canvas.elements.extend(self.marks);
        canvas.elements.push(Primitive::GroupEnd);
    }
}

/// A mark of the radius `size`, px, at a place on paper.
pub fn mark((x, y): PaperPoint, shape: MarkShape, size: f64, colour: &str, opacity: f64) -> Vec<Primitive> {
    let circle = |fill: Colour, fill_opacity: Option<f64>, stroke: Option<Colour>| {
        let stroke_width = stroke.map(|_| style::FINE);
        vec![Primitive::Circle { cx: x, cy: y, r: size, fill, fill_opacity, stroke, stroke_width }]
    };
    let ink = Colour::from(colour);
    match shape {
        MarkShape::Disc => circle(ink, (opacity < 1.0).then_some(opacity), None),
        MarkShape::Ring => circle(Colour::None, None, Some(ink)),
        MarkShape::Cross => {
            let stroke =
                |up: f64| style::sample((x - size, y - up), (x + size, y + up), colour, style::FINE, None);
            vec![stroke(size), stroke(-size)]
        }
        MarkShape::Diamond => {
            let corners = vec![(x, y - size), (x + size, y), (x, y + size), (x - size, y), (x, y - size)];
            let opacity = (opacity < 1.0).then_some(opacity);
            let path = PathData {
                pieces: vec![corners],
                fill: ink,
                stroke: Colour::None,
                stroke_width: 0.0,
                opacity,
            };
            vec![Primitive::Path(Box::new(path))]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(axis: &FrameAxis) -> Vec<&str> {
        axis.ticks.iter().map(|tick| tick.1.as_str()).filter(|number| !number.is_empty()).collect()
    }

    #[test]
    fn logarithmic_axes_have_numbers_at_powers_and_between_them_where_they_are_short() {
        assert_eq!(numbers(&FrameAxis::log(0.3, 30.0)), ["0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(numbers(&FrameAxis::log(1e-4, 10.0)), ["10⁻⁴", "10⁻³", "0.01", "0.1", "1", "10"]);
        let axis = FrameAxis::log(1.0, 100.0);
        assert!((axis.share(10.0) - 0.5).abs() < 1e-15 && axis.share(-1.0).is_nan());
        assert!(FrameAxis::log(1e-300, 1e300).ticks.len() <= MOST_TICKS as usize);
    }

    #[test]
    fn points_lie_by_their_shares_of_the_axes() {
        let axis = |low, high| FrameAxis::every(low, high, 1.0, style::number);
        let frame = PlotFrame::new(
            [10.0, 20.0, 200.0, 100.0],
            [40.0, 10.0, 20.0, 30.0],
            axis(0.0, 2.0),
            axis(-1.0, 1.0),
        );
        assert_eq!(frame.at((0.0, -1.0)), (50.0, 90.0));
        assert_eq!(frame.at((2.0, 1.0)), (200.0, 40.0));
        assert_eq!(frame.at((1.0, 0.0)), (125.0, 65.0));
        assert_eq!(frame.at((1e300, -1e300)), (FURTHEST, FURTHEST));
        assert!(frame.at((f64::NAN, 0.0)).0.is_nan());
        assert_eq!(numbers(&frame.x), ["0", "1", "2"]);
    }

    #[test]
    fn what_is_not_finite_leaves_no_mark_and_parts_a_band() {
        let axis = || FrameAxis::every(0.0, 4.0, 1.0, style::number);
        let mut frame = PlotFrame::new([0.0, 0.0, 100.0, 100.0], [10.0; 4], axis(), axis());
        frame.marks(
            &[(1.0, f64::NAN), (f64::INFINITY, 1.0), (1.0, 1.0)],
            MarkShape::Disc,
            2.0,
            style::INK,
            1.0,
        );
        frame.bar((1.0, 1.0), (f64::NAN, 1.0), style::INK);
        let edge = |x: f64, low: f64| (x, low, 3.0);
        frame.band(
            &[edge(0.0, 1.0), edge(1.0, 1.0), edge(2.0, f64::NAN), edge(3.0, 1.0), edge(4.0, 1.0)],
            style::SHADE,
            1.0,
        );
        assert_eq!((frame.marks.len(), frame.inside.len()), (1, 2));
        let mut canvas = Canvas::new(100.0, 100.0);
        frame.draw(&mut canvas);
        assert!(!canvas.svg("it").contains("NaN"));
    }
}

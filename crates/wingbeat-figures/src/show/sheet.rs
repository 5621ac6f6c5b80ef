//! Views on paper, labels beside them.

use wingbeat::math::Vec3;

use super::{AXIS, Drawing, ViewPoint};
use crate::canvas::{Canvas, Colour, Primitive, TextAnchor};
use crate::space::Camera;
use crate::style;

/// Azimuths and elevations of the oblique view, degrees: the first from which no side is seen edge on, else that from which both are seen best.
const OBLIQUE: [(f64, f64); 5] = [(-55.0, 28.0), (-55.0, 50.0), (-35.0, 50.0), (-25.0, 30.0), (-70.0, 65.0)];
/// Share of its area from which on a side is not seen edge on. *Choice.*
const SEEN: f64 = 0.3;
/// Views from the sides: title, azimuth, elevation.
const SIDES: [(&str, f64, f64); 3] =
    [("front, from +x", 0.0, 0.0), ("side, from −y", -90.0, 0.0), ("above, from +z", -90.0, 90.0)];
/// Height of the large view and of the small ones, px.
const LARGE: f64 = 430.0;
const SMALL: f64 = 270.0;
/// Width of a column of labels, px.
const COLUMN: f64 = 190.0;
/// From label to label, px.
const LINE: f64 = 16.0;
/// Room above, px, and around a view.
const HEAD: f64 = 34.0;
const MARGIN: f64 = 26.0;
/// Colours of the axes x, y, z of a frame.
const AXES: [&str; 3] = ["#d55e00", "#009e73", "#0072b2"];

/// A place on paper, px.
#[derive(Clone, Copy)]
struct PaperCell {
    x: f64,
    y: f64,
    width: f64,
    height: f64,
}

/// One view in its cell.
struct PlacedView {
    view: Camera,
    scale: f64,
    origin: (f64, f64),
}

impl PlacedView {
    fn at(&self, point: ViewPoint) -> (f64, f64) {
        let (right, down) = self.view.project(point);
        (self.origin.0 + self.scale * right, self.origin.1 + self.scale * down)
    }
}

/// The paper.
pub struct Sheet<'a> {
    drawing: &'a Drawing,
    scene: Canvas,
}

impl<'a> Sheet<'a> {
    fn new(drawing: &'a Drawing, height: f64, title: &str) -> Self {
        let notes = LINE * drawing.notes.len() as f64;
        let mut scene = Canvas::new(style::WIDTH, height + notes + 18.0);
        scene.elements.push(style::words(14.0, 20.0, title, TextAnchor::Start, true));
        for (i, note) in drawing.notes.iter().enumerate() {
            let y = height + LINE * (i + 1) as f64;
            scene.elements.push(style::words(14.0, y, note, TextAnchor::Start, false));
        }
        Self { drawing, scene }
    }

    /// The oblique view.
    fn oblique(&self) -> (f64, f64) {
        let least = |(azimuth, elevation): (f64, f64)| {
            let view = Camera::orthographic(azimuth, elevation);
            let mut sides: Vec<(&str, f64, f64)> = Vec::new();
            for (points, colour, _) in &self.drawing.areas {
                let corners: Vec<Vec3> = points.iter().map(|point| Vec3(*point)).collect();
                let flat = |&point: &ViewPoint| {
                    let (right, down) = view.project(point);
                    Vec3::new(right, down, 0.0)
                };
                let (whole, seen) = (area(&corners), area(&points.iter().map(flat).collect::<Vec<_>>()));
                match sides.iter_mut().find(|side| side.0 == *colour) {
                    Some(side) => (side.1, side.2) = (side.1 + whole, side.2 + seen),
                    None => sides.push((colour, whole, seen)),
                }
            }
            sides.into_iter().map(|(_, whole, seen)| seen / whole.max(1e-12)).fold(1.0, f64::min)
        };
        let first = OBLIQUE.into_iter().find(|view| least(*view) >= SEEN);
        let best = || OBLIQUE.into_iter().max_by(|a, b| least(*a).total_cmp(&least(*b)));
        first.or_else(best).unwrap_or(OBLIQUE[0])
    }

    /// The oblique view with all labels above three from the sides at one scale.
    pub fn labelled(drawing: &'a Drawing, title: &str) -> Canvas {
        let rows = drawing.labels.len().div_ceil(2) as f64;
        let large = LARGE.max(LINE * (rows + 1.0));
        let mut sheet = Self::new(drawing, HEAD + large + SMALL, title);
        let cell = PaperCell { x: COLUMN, y: HEAD, width: style::WIDTH - 2.0 * COLUMN, height: large };
        let placed = sheet.place(sheet.oblique(), cell, None);
        sheet.draw(&placed);
        sheet.labels(&placed, HEAD, large);
        let width = style::WIDTH / 3.0;
        let cells =
            [0.0, 1.0, 2.0].map(|i| PaperCell { x: width * i, y: HEAD + large, width, height: SMALL });
        let own = |i: usize| sheet.place((SIDES[i].1, SIDES[i].2), cells[i], None).scale;
        let scale = (0..3).map(own).fold(f64::INFINITY, f64::min);
        for (cell, (title, azimuth, elevation)) in cells.into_iter().zip(SIDES) {
            let placed = sheet.place((azimuth, elevation), cell, Some(scale));
            sheet.draw(&placed);
            sheet.title(title, cell);
        }
        sheet.bar(scale, (14.0, HEAD + large + SMALL - 10.0));
        sheet.scene
    }

    /// The oblique view with all labels beside one from above.
    pub fn pair(drawing: &'a Drawing, title: &str) -> Canvas {
        let mut sheet = Self::new(drawing, HEAD + 2.0 * LARGE, title);
        let cell = PaperCell { x: 0.5 * COLUMN, y: HEAD, width: style::WIDTH - COLUMN, height: LARGE };
        let placed = sheet.place(sheet.oblique(), cell, None);
        sheet.draw(&placed);
        sheet.labels(&placed, HEAD, LARGE);
        let cell = PaperCell { x: 0.0, y: HEAD + LARGE, width: style::WIDTH, height: LARGE };
        let placed = sheet.place((-90.0, 90.0), cell, None);
        sheet.draw(&placed);
        sheet.title(SIDES[2].0, cell);
        sheet.bar(placed.scale, (14.0, HEAD + 2.0 * LARGE - 10.0));
        sheet.scene
    }

    /// The view that fills a cell, or has the given scale in its middle.
    fn place(&self, (azimuth, elevation): (f64, f64), cell: PaperCell, scale: Option<f64>) -> PlacedView {
        let view = Camera::orthographic(azimuth, elevation);
        let seen: Vec<(f64, f64)> = self.drawing.points().map(|point| view.project(point)).collect();
        let (left, right) = style::span(seen.iter().map(|p| p.0));
        let (top, bottom) = style::span(seen.iter().map(|p| p.1));
        let fit = |room: f64, size: f64| (room - 2.0 * MARGIN) / size.max(1e-9);
        let own = fit(cell.width, right - left).min(fit(cell.height, bottom - top));
        let scale = scale.unwrap_or(own);
        let middle = (cell.x + 0.5 * cell.width, cell.y + 0.5 * cell.height);
        let origin = (middle.0 - scale * 0.5 * (left + right), middle.1 - scale * 0.5 * (top + bottom));
        PlacedView { view, scale, origin }
    }

    fn draw(&mut self, placed: &PlacedView) {
        let drawing = self.drawing;
        let mut areas: Vec<_> = drawing.areas.iter().collect();
        let depth = |points: &[ViewPoint]| {
            points.iter().map(|&p| placed.view.nearness(p)).sum::<f64>() / points.len() as f64
        };
        wingbeat::math::order::ascend_by(&mut areas, |item| depth(&item.0));
        for (points, colour, opacity) in areas {
            self.area(placed, points, colour, *opacity);
        }
        for (points, look) in &drawing.lines {
            let points = points.iter().map(|&p| placed.at(p)).collect();
            self.scene.elements.push(Primitive::PolyLine {
                points,
                stroke: Colour::from(look.colour),
                stroke_width: look.weight,
                stroke_dasharray: look.dashes.map(Into::into),
            });
        }
        let size = AXIS * drawing.size();
        let mut lettered: Vec<(f64, f64)> = Vec::new();
        for frame in &drawing.frames {
            // Of frames upon one another the letters of the first are enough.
            let at = placed.at(frame.origin.0);
            let near =
                |other: &(f64, f64)| (at.0 - other.0).hypot(at.1 - other.1) < 1.5 * size * placed.scale;
            let letters = if lettered.iter().any(near) { "" } else { "xyz" };
            lettered.push(at);
            for (i, colour) in AXES.into_iter().enumerate() {
                let tip = frame.origin + frame.rotation.column(i) * size;
                self.arrow(at, placed.at(tip.0), colour, letters, i);
            }
        }
        for &(point, r, colour) in &drawing.dots {
            self.scene.elements.push(style::disc(placed.at(point), r, colour));
        }
    }

    fn arrow(&mut self, from: (f64, f64), to: (f64, f64), colour: &str, names: &str, i: usize) {
        self.scene.elements.push(style::sample(from, to, colour, 1.8, None));
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy);
        // Seen along its length an axis has no end to name.
        if let Some(name) = names.get(i..=i).filter(|_| length > 6.0) {
            let (x, y) = (to.0 + 7.0 * dx / length, to.1 + 7.0 * dy / length + 4.0);
            let color = Some(Colour::from(colour));
            self.scene.elements.push(Primitive::Text {
                x,
                y,
                content: name.into(),
                size: style::TICKS,
                anchor: TextAnchor::Middle,
                rotate: None,
                bold: false,
                color,
            });
        }
    }

    fn area(&mut self, placed: &PlacedView, points: &[ViewPoint], colour: &str, opacity: f64) {
        let corners: Vec<_> = points.iter().map(|point| placed.at(*point)).collect();
        self.scene.elements.push(style::area(&corners, colour, opacity));
    }

    /// Labels in the columns left and right of the view, each with a line to its point; none crosses another's row.
    fn labels(&mut self, placed: &PlacedView, top: f64, height: f64) {
        let mut sides: [Vec<((f64, f64), &str)>; 2] = [Vec::new(), Vec::new()];
        let mut all: Vec<((f64, f64), &str)> =
            self.drawing.labels.iter().map(|(at, text)| (placed.at(*at), text.as_str())).collect();
        wingbeat::math::order::ascend_by(&mut all, |item| item.0.0);
        let half = all.len() / 2;
        for (i, label) in all.into_iter().enumerate() {
            sides[usize::from(i >= half)].push(label);
        }
        for (side, labels) in sides.iter_mut().enumerate() {
            wingbeat::math::order::ascend_by(labels, |item| item.0.1);
            let rows = rows(&labels.iter().map(|label| label.0.1).collect::<Vec<_>>(), top, height);
            for (&((x, y), text), row) in labels.iter().zip(rows) {
                let (edge, anchor, end) = match side {
                    0 => (14.0, TextAnchor::Start, 14.0 + 6.6 * text.chars().count() as f64 + 4.0),
                    _ => {
                        let edge = style::WIDTH - 14.0;
                        (edge, TextAnchor::End, edge - 6.6 * text.chars().count() as f64 - 4.0)
                    }
                };
                let line = style::sample((end, row - 4.0), (x, y), style::GUIDE, 0.7, None);
                self.scene.elements.push(line);
                self.small(edge, row, text, anchor);
            }
        }
    }

    fn small(&mut self, x: f64, y: f64, text: &str, anchor: TextAnchor) {
        let color = Some(Colour::from(style::INK));
        self.scene.elements.push(Primitive::Text {
            x,
            y,
            content: text.into(),
            size: style::TICKS,
            anchor,
            rotate: None,
            bold: false,
            color,
        });
    }

    fn title(&mut self, title: &str, cell: PaperCell) {
        self.small(cell.x + 0.5 * cell.width, cell.y + 14.0, title, TextAnchor::Middle);
    }

    /// A bar of a round length.
    fn bar(&mut self, scale: f64, (x, y): (f64, f64)) {
        let lengths = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0];
        let length = lengths.into_iter().find(|l| l * scale > 50.0).unwrap_or(10.0);
        self.scene.elements.push(style::sample((x, y), (x + length * scale, y), style::INK, 2.0, None));
        let text = format!("{} mm", style::number(1e3 * length));
        self.small(x + length * scale + 6.0, y + 4.0, &text, TextAnchor::Start);
    }
}

/// Area of a plane polygon, m2.
fn area(corners: &[Vec3]) -> f64 {
    let Some(&first) = corners.first() else { return 0.0 };
    let edges = corners.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first));
    0.5 * edges.fold(Vec3::ZERO, |sum, edge| sum + edge).norm()
}

/// Heights of labels that want to stand at `wanted`, ascending, a line apart and between `top` and the end of `height`.
fn rows(wanted: &[f64], top: f64, height: f64) -> Vec<f64> {
    let mut rows: Vec<f64> = Vec::with_capacity(wanted.len());
    for &y in wanted {
        let least = rows.last().map_or(top + LINE, |last| last + LINE);
        rows.push(y.max(least));
    }
    let mut most = top + height;
    for row in rows.iter_mut().rev() {
        *row = row.min(most);
        most = *row - LINE;
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_their_distance_and_their_order() {
        let rows = rows(&[10.0, 11.0, 12.0, 95.0, 99.0], 0.0, 100.0);
        assert!(rows.windows(2).all(|pair| pair[1] - pair[0] >= LINE - 1e-9), "{rows:?}");
        assert!(rows[0] >= LINE && rows[4] <= 100.0);
    }
}

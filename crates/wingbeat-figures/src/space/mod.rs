//! Space on paper: areas and lines in world coordinates, what is further away first, with axes and a bar of length.

mod axes;
mod camera;

pub use camera::Camera;

pub(crate) use axes::round_step;

use crate::canvas::{Canvas, Colour, PathData, Primitive, TextAnchor};
use crate::style;

/// A point in world coordinates, m.
pub type WorldPoint = [f64; 3];

/// Room around what is seen for ticks and names, px.
const MARGIN: f64 = 46.0;

/// A rectangle of the paper, its lengths in px from the upper left corner.
#[derive(Clone, Copy, Debug)]
pub struct Pane {
    /// Its left end.
    pub x: f64,
    /// Its upper end.
    pub y: f64,
    /// Its width.
    pub width: f64,
    /// Its height.
    pub height: f64,
}

/// A box of space, m.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Lowest corner.
    pub low: WorldPoint,
    /// Highest corner.
    pub high: WorldPoint,
}

impl Bounds {
    /// The box around the finite `points`; none where there is none.
    pub fn of(points: impl Iterator<Item = WorldPoint>) -> Option<Self> {
        let finite = points.filter(|point| point.iter().all(|x| x.is_finite()));
        let start = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        let around = finite.fold(start, |box_, point| Self {
            low: std::array::from_fn(|i| box_.low[i].min(point[i])),
            high: std::array::from_fn(|i| box_.high[i].max(point[i])),
        });
        (around.low[0] <= around.high[0]).then_some(around)
    }

    /// The box that holds both.
    pub fn with(self, other: Self) -> Self {
        let low = std::array::from_fn(|i| self.low[i].min(other.low[i]));
        Self { low, high: std::array::from_fn(|i| self.high[i].max(other.high[i])) }
    }

    /// The corner number `bits`: high along axis i where bit i is set.
    fn corner(&self, bits: usize) -> WorldPoint {
        std::array::from_fn(|i| if bits >> i & 1 == 0 { self.low[i] } else { self.high[i] })
    }
}

/// What is drawn, with the place by which it is sorted.
struct SortedPiece {
    nearness: f64,
    drawn: Primitive,
}

/// A part of space as a camera sees it in a pane.
pub struct Space {
    camera: Camera,
    bounds: Bounds,
    scale: f64,
    origin: (f64, f64),
    pane: Pane,
    back: Vec<Primitive>,
    pieces: Vec<SortedPiece>,
    front: Vec<Primitive>,
}

impl Space {
    /// The camera's view of `bounds` as large as the pane allows.
    pub fn new(camera: Camera, bounds: Bounds, pane: Pane) -> Self {
        let seen = Self::seen(&camera, &bounds);
        let fit =
            |room: f64, (low, high): (f64, f64)| (room - 2.0 * MARGIN).max(1.0) / (high - low).max(1e-9);
        Self::with_scale(camera, bounds, pane, fit(pane.width, seen.0).min(fit(pane.height, seen.1)))
    }

    /// Height of the pane that `bounds` fill over its `width`, or `most` where that is lower, px.
    pub fn height(camera: &Camera, bounds: &Bounds, width: f64, most: f64) -> f64 {
        let ((left, right), (top, bottom)) = Self::seen(camera, bounds);
        let scale = (width - 2.0 * MARGIN).max(1.0) / (right - left).max(1e-9);
        most.min(scale * (bottom - top) + 2.0 * MARGIN)
    }

    /// The same with `scale` px per m at the target, so that several panes have one.
    pub fn with_scale(camera: Camera, bounds: Bounds, pane: Pane, scale: f64) -> Self {
        let ((left, right), (top, bottom)) = Self::seen(&camera, &bounds);
        let middle =
            |from: f64, size: f64, low: f64, high: f64| from + 0.5 * size - scale * 0.5 * (low + high);
        let origin = (middle(pane.x, pane.width, left, right), middle(pane.y, pane.height, top, bottom));
        let (back, pieces, front) = (Vec::new(), Vec::new(), Vec::new());
        Self { camera, bounds, scale, origin, pane, back, pieces, front }
    }

    /// Pixels of a metre at the target of the view.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Ranges to the right and down in which the camera sees `bounds`, m.
    fn seen(camera: &Camera, bounds: &Bounds) -> ((f64, f64), (f64, f64)) {
        let corners = || (0..8).map(|bits| camera.project(bounds.corner(bits)));
        (style::span(corners().map(|p| p.0)), style::span(corners().map(|p| p.1)))
    }

    /// Place of a point on the paper, px.
    pub fn at(&self, point: WorldPoint) -> (f64, f64) {
        let (right, down) = self.camera.project(point);
        (self.origin.0 + self.scale * right, self.origin.1 + self.scale * down)
    }

    /// An area with straight edges, which covers the share `opacity` of what is behind; of `edge` with a line of that colour
    /// about it. Areas are sorted by their middles.
    pub fn area(&mut self, corners: &[WorldPoint], colour: &str, opacity: f64, edge: Option<&str>) {
        let place = |point: &WorldPoint| self.at(*point);
        let places: Vec<(f64, f64)> = corners.iter().map(place).collect();
        let drawn = Primitive::Path(Box::new(PathData {
            pieces: vec![style::closed(&places)],
            fill: Colour::from(colour),
            stroke: edge.map_or(Colour::None, Colour::from),
            stroke_width: if edge.is_some() { 0.4 } else { 0.0 },
            opacity: Some(opacity),
        }));
        self.push(corners, drawn, &places);
    }

    /// A line of the `weight` px, sorted piece by piece among the areas.
    pub fn line(&mut self, points: &[WorldPoint], colour: &str, weight: f64) {
        for pair in points.windows(2) {
            let [from, to] = [self.at(pair[0]), self.at(pair[1])];
            self.push(pair, style::sample(from, to, colour, weight, None), &[from, to]);
        }
    }

    /// A line of the `weight` px before all areas.
    pub fn outline(&mut self, points: &[WorldPoint], colour: &str, weight: f64) {
        let points: Vec<(f64, f64)> = points.iter().map(|point| self.at(*point)).collect();
        if points.iter().all(|p| p.0.is_finite() && p.1.is_finite()) {
            let stroke = Colour::from(colour);
            let line = Primitive::PolyLine { points, stroke, stroke_width: weight, stroke_dasharray: None };
            self.front.push(line);
        }
    }

    /// Words at a point, `shift` px from it.
    pub fn label(&mut self, at: WorldPoint, shift: (f64, f64), text: &str, anchor: TextAnchor) {
        let (x, y) = self.at(at);
        self.front.push(style::words(x + shift.0, y + shift.1, text, anchor, false));
    }

    /// Keeps what has finite places.
    fn push(&mut self, points: &[WorldPoint], drawn: Primitive, places: &[(f64, f64)]) {
        if points.is_empty() || !places.iter().all(|p| p.0.is_finite() && p.1.is_finite()) {
            return;
        }
        let sum: WorldPoint = std::array::from_fn(|i| points.iter().map(|point| point[i]).sum());
        let nearness = self.camera.nearness(sum.map(|x| x / points.len() as f64));
        self.pieces.push(SortedPiece { nearness, drawn });
    }

    /// Draws all on the paper: axes, then what is further away, then lines before all and words.
    pub fn paint(mut self, scene: &mut Canvas) {
        wingbeat::math::order::ascend_by(&mut self.pieces, |item| item.nearness);
        scene.elements.extend(self.back);
        scene.elements.extend(self.pieces.into_iter().map(|piece| piece.drawn));
        scene.elements.extend(self.front);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PANE: Pane = Pane { x: 10.0, y: 20.0, width: 400.0, height: 300.0 };

    fn square(x: f64) -> [WorldPoint; 4] {
        [[x, -1.0, -1.0], [x, 1.0, -1.0], [x, 1.0, 1.0], [x, -1.0, 1.0]]
    }

    fn fills(scene: &Canvas) -> Vec<Colour> {
        let fill = |element: &Primitive| match element {
            Primitive::Path(path) => Some(path.fill),
            _ => None,
        };
        scene.elements.iter().filter_map(fill).collect()
    }

    #[test]
    fn what_is_nearer_is_drawn_later_and_all_lies_in_the_pane() {
        let bounds = Bounds::of(square(-1.0).into_iter().chain(square(1.0))).unwrap();
        let cameras = [Camera::orthographic(-50.0, 28.0), Camera::perspective(-50.0, 28.0, [0.0; 3], 6.0)];
        for camera in cameras {
            let mut space = Space::new(camera, bounds, PANE);
            space.area(&square(1.0), "#0000ff", 1.0, None);
            space.area(&square(-1.0), "#ff0000", 1.0, Some("#000000"));
            space.area(&[[f64::NAN, 0.0, 0.0]], "#00ff00", 1.0, None);
            for bits in 0..8 {
                let (x, y) = space.at(bounds.corner(bits));
                assert!((10.0..=410.0).contains(&x) && (20.0..=320.0).contains(&y), "{x} {y}");
            }
            let mut scene = Canvas::new(430.0, 340.0);
            space.paint(&mut scene);
            assert_eq!(fills(&scene), [Colour::from("#ff0000"), Colour::from("#0000ff")]);
        }
        assert!(Bounds::of([[f64::NAN; 3]].into_iter()).is_none());
    }

    #[test]
    fn axes_have_names_and_a_bar_has_its_length() {
        let bounds = Bounds { low: [-2.0, -1.0, 0.0], high: [2.0, 1.0, 0.5] };
        let mut space = Space::new(Camera::orthographic(-50.0, 28.0), bounds, PANE);
        space.axes(["x [m]", "y [m]", "z [m]"]);
        space.bar(1.0);
        let scale = space.scale();
        let mut scene = Canvas::new(430.0, 340.0);
        space.paint(&mut scene);
        let words: Vec<&str> = scene
            .elements
            .iter()
            .filter_map(|element| match element {
                Primitive::Text { content, .. } => Some(content.as_str()),
                _ => None,
            })
            .collect();
        for name in ["x [m]", "y [m]", "z [m]", "−2", "1 m"] {
            assert!(words.contains(&name), "{name}: {words:?}");
        }
        let bar = scene.elements.iter().rev().find_map(|element| match element {
            Primitive::Line { x1, x2, .. } => Some(x2 - x1),
            _ => None,
        });
        assert!((bar.unwrap() - scale).abs() < 1e-9);
        // An axis too short for two ticks as far apart as others has two nearer ones.
        let flat = Bounds { low: [-2.0, -1.0, -0.09], high: [2.0, 1.0, 0.09] };
        let space = Space::new(Camera::orthographic(-50.0, 28.0), flat, PANE);
        assert!((0..3).all(|axis| space.has_scale(axis)) || space.scale() * 0.18 < 20.0, "{}", space.scale());
        // Straight from the front x is a point and has no ticks.
        let mut front = Space::new(Camera::orthographic(0.0, 0.0), bounds, PANE);
        front.axes(["x [m]", "y [m]", "z [m]"]);
        assert!(
            front.front.iter().all(|e| !matches!(e, Primitive::Text { content, .. } if content == "x [m]"))
        );
    }
}

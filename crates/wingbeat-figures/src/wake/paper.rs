//! Areas, lines, letters and colour scales on paper, px from the upper left corner.

use super::colour::Diverging;
use crate::canvas::{Canvas, Colour, Primitive, TextAnchor};
use crate::scale::TickScale;
use crate::style;

/// Width and height of a scale, px.
const SCALE: (f64, f64) = (260.0, 12.0);
/// Steps of colour in it.
const STEPS: usize = 52;

/// A drawing.
pub struct Paper {
    pub scene: Canvas,
}

impl Paper {
    pub fn new(width: f64, height: f64) -> Self {
        Self { scene: Canvas::new(width, height) }
    }

    pub fn area(&mut self, corners: &[(f64, f64)], colour: &str, opacity: f64) {
        self.scene.elements.push(style::area(corners, colour, opacity));
    }

    pub fn line(&mut self, points: Vec<(f64, f64)>, colour: &str, weight: f64) {
        self.scene.elements.push(Primitive::PolyLine {
            points,
            stroke: Colour::from(colour),
            stroke_width: weight,
            stroke_dasharray: None,
        });
    }

    pub fn text(&mut self, (x, y): (f64, f64), content: &str, anchor: TextAnchor) {
        self.scene.elements.push(style::words(x, y, content, anchor, false));
    }

    /// A colour scale with its ends, zero and name, its upper left corner at `(x, y)` px.
    pub fn scale(&mut self, scale: &Diverging, (x, y): (f64, f64), name: &str) {
        let axis = TickScale::new(-scale.most, scale.most);
        let at = |share: f64| x + SCALE.0 * share;
        for k in 0..STEPS {
            let [from, to] = [k, k + 1].map(|k| k as f64 / STEPS as f64);
            let colour = scale.colour(scale.most * (from + to - 1.0));
            let corners = [(at(from), y), (at(to), y), (at(to), y + SCALE.1), (at(from), y + SCALE.1)];
            self.area(&corners, &colour, 1.0);
        }
        let count = (scale.most / axis.step).floor() as i64;
        for tick in (-count..=count).map(|k| k as f64 * axis.step) {
            let across = at(0.5 + 0.5 * tick / scale.most);
            self.line(vec![(across, y + SCALE.1), (across, y + SCALE.1 + 4.0)], style::INK, 1.0);
            self.text((across, y + SCALE.1 + 18.0), &axis.number(tick), TextAnchor::Middle);
        }
        self.text((x + SCALE.0 + 16.0, y + SCALE.1), &axis.label(name), TextAnchor::Start);
    }
}

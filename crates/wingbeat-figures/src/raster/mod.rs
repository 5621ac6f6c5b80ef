//! A drawing to pixels.

mod bitmap;
mod coverage;
mod letters;

pub use bitmap::{Bitmap, colour};
use coverage::{Coverage, PixelBox, PixelPlace};
use letters::Words;

use crate::canvas::{Canvas, Colour, PathData, Primitive, TextAnchor};

/// Weight up to which a line along an axis lies on whole pixels, px.
const CRISP: f32 = 2.0;
/// Most pixels of a picture. *Choice*: 16 by 16 thousand.
const MOST: f64 = 2.56e8;

/// The drawing with `scale` pixels per pixel of its own.
///
/// # Errors
/// A drawing without a size, or with more pixels than a picture may have.
pub fn bitmap(scene: &Canvas, scale: f64) -> Result<Bitmap, String> {
    let (width, height) = ((scale * scene.width).ceil(), (scale * scene.height).ceil());
    if !(width >= 1.0 && height >= 1.0 && width * height <= MOST) {
        return Err(format!(
            "{width} by {height} pixels: allowed are at least 1 by 1 and at most {MOST:e} in all"
        ));
    }
    let (width, height) = (width as usize, height as usize);
    let coverage = Coverage::new(width, height);
    let first = GroupFrame { shift: (0.0, 0.0), clip: coverage.clip };
    let mut painter = BitmapPainter {
        bitmap: Bitmap::new(width, height),
        coverage,
        scale: scale as f32,
        frame: first,
        outer: Vec::new(),
    };
    scene.elements.iter().for_each(|element| painter.draw(element));
    Ok(painter.bitmap)
}

/// Reads the letters, so that they are there when the first picture is drawn.
pub fn prepare() {
    let mut coverage = Coverage::new(1, 1);
    let anchor = TextAnchor::Start;
    Words { content: "a", size: 1.0, bold: false, anchor, turn: 0.0 }.outline(&mut coverage, (0.0, 0.0));
}

/// Where a group lies, px of the drawing, and what of it may be seen.
#[derive(Clone, Copy)]
struct GroupFrame {
    shift: (f64, f64),
    clip: PixelBox,
}

struct BitmapPainter {
    bitmap: Bitmap,
    coverage: Coverage,
    scale: f32,
    frame: GroupFrame,
    outer: Vec<GroupFrame>,
}

impl BitmapPainter {
    fn at(&self, (x, y): (f64, f64)) -> PixelPlace {
        let (right, down) = self.frame.shift;
        ((x + right) as f32 * self.scale, (y + down) as f32 * self.scale)
    }

    fn paint(&mut self, colour: Colour, opacity: Option<f64>) {
        // A colour that is none covers nothing, and what it was to cover is forgotten.
        let known = match colour {
            Colour::Rgb(shade) => Some(bitmap::ink(shade)),
            Colour::None => None,
        };
        let opacity = if known.is_some() { opacity.unwrap_or(1.0).clamp(0.0, 1.0) as f32 } else { 0.0 };
        self.coverage.paint(&mut self.bitmap, known.unwrap_or_default(), opacity);
    }

    fn enter(&mut self, frame: GroupFrame) {
        self.outer.push(std::mem::replace(&mut self.frame, frame));
        self.coverage.clip = self.frame.clip;
    }

    fn leave(&mut self) {
        if let Some(frame) = self.outer.pop() {
            self.frame = frame;
            self.coverage.clip = frame.clip;
        }
    }

    fn line(&mut self, points: &[(f64, f64)], colour: Colour, weight: f64) {
        let points: Vec<PixelPlace> = points.iter().map(|point| self.at(*point)).collect();
        self.coverage.line(points.into_iter(), weight as f32 * self.scale);
        self.paint(colour, None);
    }

    /// A line between two points; a thin one along an axis lies on whole pixels.
    fn straight(&mut self, from: (f64, f64), to: (f64, f64), colour: Colour, weight: f64) {
        let (mut a, mut b) = (self.at(from), self.at(to));
        let mut weight = weight as f32 * self.scale;
        if weight < CRISP && (a.0 == b.0 || a.1 == b.1) {
            weight = weight.floor().max(1.0);
            let crisp = |x: f32| if weight as u32 % 2 == 1 { x.floor() + 0.5 } else { x.round() };
            if a.0 == b.0 {
                (a.0, b.0) = (crisp(a.0), crisp(b.0));
            } else {
                (a.1, b.1) = (crisp(a.1), crisp(b.1));
            }
        }
        self.coverage.line([a, b].into_iter(), weight);
        self.paint(colour, None);
    }

    fn rectangle(&mut self, (x, y): (f64, f64), (width, height): (f64, f64)) {
        // Neighbours share an edge of whole pixels, so that no ground is seen between them; one of less than a pixel has its share.
        let ends = [self.at((x, y)), self.at((x + width, y + height))];
        let whole = ends.map(|(x, y)| (x.round(), y.round()));
        let seen = whole[0].0 != whole[1].0 && whole[0].1 != whole[1].1;
        let [(left, top), (right, bottom)] = if seen { whole } else { ends };
        let places = [(left, top), (right, top), (right, bottom), (left, bottom)];
        self.coverage.polygon(&places);
    }

    fn circle(
        &mut self,
        centre: (f64, f64),
        r: f64,
        filled: (Colour, Option<f64>),
        edge: (Option<Colour>, f64),
    ) {
        let (centre, r) = (self.at(centre), r as f32 * self.scale);
        self.coverage.disc(centre, r, 1.0);
        self.paint(filled.0, filled.1);
        if let (Some(colour), weight) = edge {
            let half = 0.5 * weight as f32 * self.scale;
            self.coverage.disc(centre, r + half, 1.0);
            if r > half {
                self.coverage.disc(centre, r - half, -1.0);
            }
            self.paint(colour, None);
        }
    }

    fn path(&mut self, path: &PathData) {
        if path.fill != Colour::None {
            for piece in &path.pieces {
                let places: Vec<PixelPlace> = piece.iter().map(|point| self.at(*point)).collect();
                self.coverage.polygon(&places);
            }
            self.paint(path.fill, path.opacity);
        }
        if path.stroke != Colour::None && path.stroke_width > 0.0 {
            for piece in &path.pieces {
                let places: Vec<PixelPlace> = piece.iter().map(|point| self.at(*point)).collect();
                self.coverage.line(places.into_iter(), path.stroke_width as f32 * self.scale);
            }
            self.paint(path.stroke, None);
        }
    }

    fn draw(&mut self, element: &Primitive) {
        match element {
            Primitive::GroupStart { right, down } => {
                let (x, y) = self.frame.shift;
                self.enter(GroupFrame { shift: (x + right, y + down), ..self.frame });
            }
            Primitive::ClipStart { x, y, width, height } => {
                let (low, high) = (self.at((*x, *y)), self.at((x + width, y + height)));
                let outer = self.frame.clip;
                let clip = PixelBox {
                    left: (low.0.floor() as usize).clamp(outer.left, outer.right),
                    top: (low.1.floor() as usize).clamp(outer.top, outer.bottom),
                    right: (high.0.ceil() as usize).clamp(outer.left, outer.right),
                    bottom: (high.1.ceil() as usize).clamp(outer.top, outer.bottom),
                };
                self.enter(GroupFrame { clip, ..self.frame });
            }
            Primitive::GroupEnd | Primitive::ClipEnd => self.leave(),
            Primitive::Rect { x, y, width, height, fill, opacity } => {
                self.rectangle((*x, *y), (*width, *height));
                self.paint(*fill, *opacity);
            }
            Primitive::Line { x1, y1, x2, y2, stroke, stroke_width, .. } => {
                self.straight((*x1, *y1), (*x2, *y2), *stroke, *stroke_width);
            }
            Primitive::PolyLine { points, stroke, stroke_width, .. } => {
                self.line(points, *stroke, *stroke_width);
            }
            Primitive::Circle { cx, cy, r, fill, fill_opacity, stroke, stroke_width } => {
                let edge = (*stroke, stroke_width.unwrap_or(1.0));
                self.circle((*cx, *cy), *r, (*fill, *fill_opacity), edge);
            }
            Primitive::Path(path) => self.path(path),
            Primitive::Text { x, y, content, size, anchor, rotate, bold, color } => {
                let turn = rotate.unwrap_or(0.0).to_radians() as f32;
                let mut at = self.at((*x, *y));
                if turn == 0.0 {
                    at.1 = at.1.round();
                }
                let size = *size as f32 * self.scale;
                Words { content, size, bold: *bold, anchor: *anchor, turn }.outline(&mut self.coverage, at);
                self.paint(color.unwrap_or(Colour::Rgb([0; 3])), None);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style;

    #[test]
    fn groups_move_and_regions_cut() {
        let mut scene = Canvas::new(40.0, 20.0);
        let square = style::area(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)], "#000000", 0.5);
        let mut inner = Canvas::new(40.0, 20.0);
        inner.elements.push(Primitive::ClipStart { x: 2.0, y: 0.0, width: 4.0, height: 40.0 });
        inner.elements.push(square);
        inner.elements.push(Primitive::ClipEnd);
        scene.elements = style::moved(inner, 5.0, 3.0);
        let bitmap = bitmap(&scene, 2.0).unwrap();
        assert_eq!((bitmap.width, bitmap.height), (80, 40));
        let dark: Vec<usize> = (0..80 * 40).filter(|k| bitmap.ink[*k] != 0).collect();
        assert_eq!(dark.len(), 8 * 20);
        assert!(dark.iter().all(|k| (14..22).contains(&(k % 80)) && (6..26).contains(&(k / 80))));
        assert!((126..=129).contains(&(bitmap.ink[dark[0]] & 255)));
        assert!(super::bitmap(&Canvas::new(0.0, 3.0), 1.0).is_err());
    }
}

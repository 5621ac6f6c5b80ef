//! Letters as outlines: parts of DejaVu Sans, whose licence lies beside them, made by
//! `pyftsubset DejaVuSans.ttf --no-hinting --layout-features=''` with the characters that figures and names take.

use std::sync::OnceLock;

use ttf_parser::{Face, OutlineBuilder};

use super::coverage::{Coverage, PixelPlace};

use crate::canvas::TextAnchor;

static PLAIN: &[u8] = include_bytes!("../../fonts/DejaVuSans-part.ttf");
static BOLD: &[u8] = include_bytes!("../../fonts/DejaVuSans-Bold-part.ttf");

/// Pieces of a curve of an outline.
const PIECES: usize = 4;

/// Width of a letter that is in no font, as a share of its size.
const UNKNOWN: f32 = 0.6;

/// The letters, plain or bold.
fn face(bold: bool) -> Option<&'static Face<'static>> {
    static FACES: OnceLock<[Option<Face<'static>>; 2]> = OnceLock::new();
    let faces = FACES.get_or_init(|| [PLAIN, BOLD].map(|bytes| Face::parse(bytes, 0).ok()));
    faces[usize::from(bold)].as_ref()
}

/// Words on a bitmap.
pub struct Words<'a> {
    pub content: &'a str,
    /// Size of the letters, px.
    pub size: f32,
    pub bold: bool,
    pub anchor: TextAnchor,
    /// Turn to the right, rad.
    pub turn: f32,
}

impl Words<'_> {
    /// Adds the letters' outlines, the base line through `at`.
    pub fn outline(&self, coverage: &mut Coverage, at: PixelPlace) {
        let Some(plain) = face(false) else { return };
        let chosen = face(self.bold).unwrap_or(plain);
        let glyph = |letter: char| {
            let own = chosen.glyph_index(letter).map(|id| (chosen, id));
            own.or_else(|| plain.glyph_index(letter).map(|id| (plain, id)))
                .or_else(|| plain.glyph_index('\u{25a1}').map(|id| (plain, id)))
        };
        let glyphs: Vec<_> = self.content.chars().map(glyph).collect();
        let advance = |glyph: &Option<(&Face, ttf_parser::GlyphId)>| {
            let known = glyph.and_then(|(face, id)| {
                Some(f32::from(face.glyph_hor_advance(id)?) / f32::from(face.units_per_em()))
            });
            self.size * known.unwrap_or(UNKNOWN)
        };
        let width: f32 = glyphs.iter().map(advance).sum();
        let mut pen = match self.anchor {
            TextAnchor::Start => 0.0,
            TextAnchor::Middle => -0.5 * width,
            TextAnchor::End => -width,
        };
        let (sin, cos) = self.turn.sin_cos();
        for glyph in &glyphs {
            if let Some((face, id)) = *glyph {
                let scale = self.size / f32::from(face.units_per_em());
                let (x, y) = (at.0 + pen * cos, at.1 + pen * sin);
                let place = |(px, py): PixelPlace| {
                    let (px, py) = (scale * px, -scale * py);
                    (x + cos * px - sin * py, y + sin * px + cos * py)
                };
                let mut outline = GlyphOutline { coverage, place, start: (0.0, 0.0), last: (0.0, 0.0) };
                face.outline_glyph(id, &mut outline);
            }
            pen += advance(glyph);
        }
    }
}

/// The outline of a letter on its way to the bitmap.
struct GlyphOutline<'a, F: Fn(PixelPlace) -> PixelPlace> {
    coverage: &'a mut Coverage,
    place: F,
    start: PixelPlace,
    last: PixelPlace,
}

impl<F: Fn(PixelPlace) -> PixelPlace> GlyphOutline<'_, F> {
    fn to(&mut self, next: PixelPlace) {
        self.coverage.edge((self.place)(self.last), (self.place)(next));
        self.last = next;
    }

    /// The curve of the control points `p`, whose weights at a share of the way `of` gives.
    fn curve<const N: usize>(&mut self, p: [PixelPlace; N], of: impl Fn(f32) -> [f32; N]) {
        for k in 1..=PIECES {
            let weights = of(k as f32 / PIECES as f32);
            let sum = |part: fn(&PixelPlace) -> f32| p.iter().zip(weights).map(|(p, w)| w * part(p)).sum();
            self.to((sum(|p| p.0), sum(|p| p.1)));
        }
    }
}

impl<F: Fn(PixelPlace) -> PixelPlace> OutlineBuilder for GlyphOutline<'_, F> {
    fn move_to(&mut self, x: f32, y: f32) {
        (self.start, self.last) = ((x, y), (x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.to((x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let of = |t: f32| [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t];
        self.curve([self.last, (x1, y1), (x, y)], of);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let of = |t: f32| {
            let s = 1.0 - t;
            [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
        };
        self.curve([self.last, (x1, y1), (x2, y2), (x, y)], of);
    }

    fn close(&mut self) {
        self.to(self.start);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::bitmap::Bitmap;

    /// Lowest and highest column and row with ink.
    fn ink(words: &Words, at: PixelPlace) -> [usize; 4] {
        let (mut bitmap, mut coverage) = (Bitmap::new(100, 100), Coverage::new(100, 100));
        words.outline(&mut coverage, at);
        coverage.paint(&mut bitmap, 0xff_ffff, 1.0);
        let dark = || (0..10_000).filter(|k| bitmap.ink[*k] & 255 > 127).map(|k| (k % 100, k / 100));
        let range = |of: fn((usize, usize)) -> usize| {
            (dark().map(of).min().unwrap_or(0), dark().map(of).max().unwrap_or(0))
        };
        let ((left, right), (top, bottom)) = (range(|p| p.0), range(|p| p.1));
        [left, right, top, bottom]
    }

    #[test]
    fn letters_stand_on_their_line_and_turn_with_it() {
        let words = |anchor, turn| Words { content: "HH", size: 20.0, bold: false, anchor, turn };
        let [left, right, top, bottom] = ink(&words(TextAnchor::Start, 0.0), (50.0, 50.0));
        assert!((51..54).contains(&left) && (76..80).contains(&right), "{left} {right}");
        assert!((35..37).contains(&top) && bottom == 49, "{top} {bottom}");
        let [left, right, ..] = ink(&words(TextAnchor::End, 0.0), (50.0, 50.0));
        assert!(left > 18 && right < 50);
        // Upwards.
        let up = -0.25 * std::f32::consts::TAU;
        let [left, right, top, bottom] = ink(&words(TextAnchor::Start, up), (50.0, 50.0));
        assert!((35..37).contains(&left) && right == 49 && top > 18 && bottom < 50);
    }

    #[test]
    fn every_sign_of_a_figure_is_there() {
        let plain = face(false).unwrap();
        for sign in "°−µ²³⁻⁰⁹×·–—…±√≤≥∞πλψωθδéüäößñ→Ω∂".chars()
        {
            assert!(plain.glyph_index(sign).is_some(), "{sign}");
        }
        assert!(face(true).unwrap().glyph_index('a').is_some());
    }
}

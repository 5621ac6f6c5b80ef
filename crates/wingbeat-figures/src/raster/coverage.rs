//! How much of each pixel a shape covers.
//!
//! An edge that goes down or up by h within a row of pixels adds its sign times h to all that lies to its right in that row, and to the pixel
//! that it crosses the share of the pixel to its right. The sum from the left is then the winding number, averaged over the pixel: exact
//! for polygons, with no samples.
//!
//! **Source:** R. Levien, *Inside the fastest font renderer in the world* (2016), where glyphs are drawn so.

use std::f32::consts::TAU;

use super::bitmap::Bitmap;

/// A place on a bitmap, px from its upper left corner.
pub type PixelPlace = (f32, f32);

/// Cosine of the turn of a line from which on its corner is filled. *Choice*: below it no gap is wider than a sixth of the line.
const STRAIGHT: f32 = 0.95;
/// Points of a line that lie nearer than this to the one before are left out, px.
const NEAR: f32 = 0.2;

/// Two to the power of this are most blocks of a row: the bits of a word.
const BLOCKS: u32 = 6;

/// A rectangle of whole pixels, its far ends not within.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelBox {
    pub left: usize,
    pub top: usize,
    pub right: usize,
    pub bottom: usize,
}

/// The shape that is being drawn.
pub struct Coverage {
    stride: usize,
    sums: Vec<f32>,
    /// A bit for each block of columns of each row that has a sum, the first the lowest.
    touched: Vec<u64>,
    /// Bits of a column's number that tell its place in its block.
    block: u32,
    /// First and last row that was touched.
    rows: (usize, usize),
    /// Where it may be seen.
    pub clip: PixelBox,
}

impl Coverage {
    pub fn new(width: usize, height: usize) -> Self {
        let stride = width + 2;
        Self {
            stride,
            sums: vec![0.0; stride * height],
            touched: vec![0; height],
            block: (stride.ilog2() + 1).saturating_sub(BLOCKS),
            rows: (usize::MAX, 0),
            clip: PixelBox { left: 0, top: 0, right: width, bottom: height },
        }
    }

    /// An edge of a closed outline.
    ///
    /// Test: `a_square_covers_its_area`.
    pub fn edge(&mut self, a: PixelPlace, b: PixelPlace) {
        let (sign, (x0, y0), (x1, y1)) = if a.1 < b.1 { (1.0, a, b) } else { (-1.0, b, a) };
        let (top, bottom) = (y0.max(self.clip.top as f32), y1.min(self.clip.bottom as f32));
        let slope = (x1 - x0) / (y1 - y0);
        // Neither a level edge nor one that is not finite.
        if !(bottom > top && slope.is_finite()) {
            return;
        }
        let (first, last) = (top as usize, bottom.ceil() as usize - 1);
        self.rows = (self.rows.0.min(first), self.rows.1.max(last));
        let mut x = x0 + (top - y0) * slope;
        for row in first..=last {
            let high = bottom.min((row + 1) as f32) - top.max(row as f32);
            let next = x + slope * high;
            self.slice(row, x, next, sign * high);
            x = next;
        }
    }

    /// The part of an edge within a row, from column `a` to `b`, of the signed height `high`.
    fn slice(&mut self, row: usize, a: f32, b: f32, high: f32) {
        let (low, most) = (self.clip.left as f32, self.clip.right as f32);
        let (left, right) = (a.min(b).clamp(low, most), a.max(b).clamp(low, most));
        let first = left as usize;
        let end = (right.ceil() as usize).max(first + 1);
        let (near, far) = (first >> self.block, end >> self.block);
        self.touched[row] |= (u64::MAX >> (63 - far)) & (u64::MAX << near);
        let sums = &mut self.sums[row * self.stride..][..self.stride];
        if end == first + 1 {
            let before = 0.5 * (left + right) - first as f32;
            sums[first] += high * (1.0 - before);
            sums[first + 1] += high * before;
            return;
        }
        // The area right of the edge grows by a triangle in the first column, by a square in each between, and by a triangle in the last.
        let per_column = high / (right - left);
        let into = (first + 1) as f32 - left;
        let mut area = 0.5 * per_column * into * into;
        sums[first] += area;
        let mut crossed = per_column * into;
        for column in first + 1..end {
            let wide = (right - column as f32).min(1.0);
            let next = crossed + per_column * wide;
            // What lies above the edge at the left of the column, all of it, and what the edge goes down within it.
            let now = crossed + per_column * wide * (1.0 - 0.5 * wide);
            sums[column] += now - area;
            (area, crossed) = (now, next);
        }
        sums[end] += high - area;
    }

    /// A closed outline.
    pub fn polygon(&mut self, corners: &[PixelPlace]) {
        let Some(mut last) = corners.last().copied() else { return };
        for corner in corners {
            self.edge(last, *corner);
            last = *corner;
        }
    }

    /// A disc of a radius in px; the `sign` -1 (dimensionless) takes it away from another.
    pub fn disc(&mut self, (x, y): PixelPlace, radius: f32, sign: f32) {
        let sides = (8.0 + 3.0 * radius.max(0.0)).min(96.0) as usize;
        let at = |k: usize| {
            let (sin, cos) = (TAU * k as f32 / sides as f32).sin_cos();
            (x + radius * cos, y - sign * radius * sin)
        };
        (0..sides).for_each(|k| self.edge(at(k), at((k + 1) % sides)));
    }

    /// A line of the weight `weight` px that ends at its ends, with round corners.
    pub fn line(&mut self, points: impl Iterator<Item = PixelPlace>, weight: f32) {
        let half = 0.5 * weight;
        let mut from: Option<PixelPlace> = None;
        let mut before: Option<PixelPlace> = None;
        let mut skipped = None;
        let mut piece = |from: PixelPlace, to: PixelPlace| {
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let length = dx.hypot(dy);
            let (dx, dy) = (dx / length, dy / length);
            let (nx, ny) = (-dy * half, dx * half);
            self.polygon(&[
                (from.0 + nx, from.1 + ny),
                (to.0 + nx, to.1 + ny),
                (to.0 - nx, to.1 - ny),
                (from.0 - nx, from.1 - ny),
            ]);
            if before.is_some_and(|(x, y)| x * dx + y * dy < STRAIGHT) {
                self.disc(from, half, 1.0);
            }
            before = Some((dx, dy));
        };
        for point in points {
            match from {
                Some(last) if (point.0 - last.0).hypot(point.1 - last.1) < NEAR => skipped = Some(point),
                Some(last) => {
                    piece(last, point);
                    (from, skipped) = (Some(point), None);
                }
                None => from = Some(point),
            }
        }
        if let (Some(from), Some(end)) = (from, skipped.filter(|end| Some(*end) != from)) {
            piece(from, end);
        }
    }

    /// Lays the `ink` with an `opacity` (dimensionless) over what the shape covers, and forgets the shape. In steps of 1/32: few shades make a small file.
    pub fn paint(&mut self, bitmap: &mut Bitmap, ink: u32, opacity: f32) {
        let (first, last) = std::mem::replace(&mut self.rows, (usize::MAX, 0));
        let most = 32.0 * opacity;
        for row in first..=last {
            let touched = std::mem::take(&mut self.touched[row]);
            let (sums, pixels) = (row * self.stride, row * bitmap.width);
            let (mut winding, mut parts) = (0.0_f32, 0);
            let mut column = (touched.trailing_zeros() as usize) << self.block;
            while column < self.stride {
                let end = (((column >> self.block) + 1) << self.block).min(self.stride);
                // Paper beside the shape.
                if parts == 0 && touched >> (column >> self.block) & 1 == 0 {
                    column = end;
                    continue;
                }
                while column < end {
                    let sum = self.sums[sums + column];
                    if sum != 0.0 {
                        self.sums[sums + column] = 0.0;
                        winding += sum;
                        parts = (most * winding.abs().min(1.0) + 0.5) as u32;
                    }
                    if parts != 0 && column < self.clip.right {
                        let pixel = &mut bitmap.ink[pixels + column];
                        *pixel = if parts == 32 { ink } else { mixed(*pixel, ink, parts) };
                    }
                    column += 1;
                }
            }
        }
    }
}

/// Of 32 parts `parts` of the ink `over`, and the others of the ink `under`.
fn mixed(under: u32, over: u32, parts: u32) -> u32 {
    // Two bytes with room above each, and the one between them.
    let mix =
        |mask: u32, half: u32| (((under & mask) * (32 - parts) + (over & mask) * parts + half) >> 5) & mask;
    mix(0x00ff_00ff, 0x0010_0010) | mix(0x0000_ff00, 0x0000_1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dark share of each pixel, and of all.
    fn drawn(shape: impl Fn(&mut Coverage)) -> (Vec<f32>, f32) {
        let mut bitmap = Bitmap::new(20, 10);
        let mut coverage = Coverage::new(20, 10);
        shape(&mut coverage);
        coverage.paint(&mut bitmap, 0xff_ffff, 1.0);
        assert!(coverage.sums.iter().all(|sum| *sum == 0.0));
        let dark: Vec<f32> = bitmap.ink.iter().map(|ink| (ink & 255) as f32 / 255.0).collect();
        let all = dark.iter().sum();
        (dark, all)
    }

    #[test]
    fn a_square_covers_its_area() {
        let (dark, all) = drawn(|shape| shape.polygon(&[(2.5, 1.5), (6.25, 1.5), (6.25, 4.0), (2.5, 4.0)]));
        assert!((all - 3.75 * 2.5).abs() < 0.1, "{all}");
        assert!((dark[20 + 2] - 0.25).abs() < 0.02 && (dark[2 * 20 + 6] - 0.25).abs() < 0.02);
        assert_eq!((dark[2 * 20 + 3], dark[2 * 20 + 7]), (1.0, 0.0));
        // A slanted edge over many columns, and one that goes both ways.
        let (_, all) = drawn(|shape| shape.polygon(&[(1.0, 2.0), (18.3, 3.4), (9.0, 8.7)]));
        assert!((all - 0.5 * (17.3 * 6.7 - 8.0_f32 * 1.4)).abs() < 0.3, "{all}");
    }

    #[test]
    fn lines_have_their_weight_and_stay_in_the_picture() {
        let (_, all) = drawn(|shape| shape.line([(2.0, 2.0), (14.0, 7.0)].into_iter(), 1.5));
        assert!((all - 13.0 * 1.5).abs() < 0.4, "{all}");
        let (_, all) =
            drawn(|shape| shape.line([(-50.0, 5.0), (70.0, 5.0), (f32::NAN, 1.0)].into_iter(), 2.0));
        assert!((all - 40.0).abs() < 0.1, "{all}");
        let (_, ring) = drawn(|shape| {
            shape.disc((8.0, 5.0), 4.0, 1.0);
            shape.disc((8.0, 5.0), 3.0, -1.0);
        });
        assert!((ring - std::f32::consts::PI * 7.0).abs() < 0.7, "{ring}");
    }
}

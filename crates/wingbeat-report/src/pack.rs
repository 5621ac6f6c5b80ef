//! Columns of numbers in few bytes: rounded to a step, differences of the order that leaves least, one plane of bytes after the other.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde::Serialize;

/// Most steps between the least and the most of a column.
const MOST_STEPS: f64 = 16_777_215.0;
/// Least step, as a share of the largest number.
const FINEST: f64 = 1e-12;
/// Highest order of the differences.
const ORDERS: usize = 5;

/// Where a column lies in the bytes, and how it is read: `value = step (base + q - 1)`, where q = 0 stands for no number.
#[derive(Clone, Copy, Debug, Serialize, PartialEq)]
pub struct PackedColumn {
    /// First byte.
    at: usize,
    /// Rows.
    rows: usize,
    /// Least number, steps.
    base: f64,
    step: f64,
    /// How often differences were taken.
    order: usize,
    /// Planes of bytes.
    planes: usize,
}

/// The bytes of a page.
#[derive(Debug, Default)]
pub struct Pack {
    bytes: Vec<u8>,
    from: usize,
}

impl Pack {
    /// From now on only what columns have from this row on is packed.
    pub fn begin_at(&mut self, row: usize) {
        self.from = row;
    }

    /// Adds a column, in its unit, whose numbers may be wrong by half a `step`; by more only where they span more than
    /// [`MOST_STEPS`].
    pub fn add(&mut self, values: &[f64], step: f64) -> PackedColumn {
        let values = &values[self.from.min(values.len())..];
        let (low, high) = range(values);
        // Halves, as the whole of two large numbers may have no number.
        let least = 2.0 * ((0.5 * high - 0.5 * low) / MOST_STEPS);
        // No finer than a number near it can be told.
        let finest = (FINEST * low.abs().max(high.abs())).max(f64::MIN_POSITIVE);
        let step = rounded_up(step.max(least).max(finest));
        let base = (low / step).floor();
        let of = |value: &f64| if value.is_finite() { (value / step - base).round() as i64 + 1 } else { 0 };
        let mut best: Vec<i64> = values.iter().map(of).collect();
        let mut order = 0;
        let mut next = best.clone();
        for tried in 1..ORDERS {
            for i in (1..next.len()).rev() {
                next[i] -= next[i - 1];
            }
            if cost(&next) < cost(&best) {
                (best, order) = (next.clone(), tried);
            }
        }
        let folded: Vec<u64> = best.iter().map(|&d| ((d << 1) ^ (d >> 63)) as u64).collect();
        let most = folded.iter().copied().max().unwrap_or(0);
        let planes = (64 - most.leading_zeros() as usize).div_ceil(8);
        let at = self.bytes.len();
        for plane in 0..planes {
            self.bytes.extend(folded.iter().map(|value| (value >> (8 * plane)) as u8));
        }
        PackedColumn { at, rows: values.len(), base, step, order, planes }
    }

    /// Adds a column, in its unit, to the share 1/`parts` of its range.
    pub fn add_parts(&mut self, values: &[f64], parts: f64) -> PackedColumn {
        let (low, high) = range(values);
        self.add(values, 2.0 * ((0.5 * high - 0.5 * low) / parts))
    }

    /// A text with its length before it, and the bytes, deflated, as letters.
    pub fn letters(&self, text: &str) -> String {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        let length = (text.len() as u32).to_le_bytes();
        let parts = [&length, text.as_bytes(), &self.bytes];
        // Nothing can fail in memory.
        let deflated = parts.iter().try_for_each(|part| encoder.write_all(part));
        let deflated = deflated.and_then(|()| encoder.finish()).unwrap_or_default();
        BASE64_STANDARD.encode(deflated)
    }
}

/// Least and most of the finite numbers.
fn range(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// A number of three digits that is not below `step`.
fn rounded_up(step: f64) -> f64 {
    let text = format!("{:.2e}", step * 1.004);
    text.parse().ok().filter(|rounded: &f64| rounded.is_finite() && *rounded >= step).unwrap_or(step)
}

/// About the bits that differences need.
fn cost(values: &[i64]) -> u64 {
    values.iter().map(|value| u64::from(64 - value.unsigned_abs().leading_zeros())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the page does.
    fn read(pack: &Pack, channel: PackedColumn) -> Vec<f64> {
        let PackedColumn { at, rows, base, step, order, planes } = channel;
        let folded = |i: usize| -> u64 {
            (0..planes).map(|p| u64::from(pack.bytes[at + p * rows + i]) << (8 * p)).sum()
        };
        let mut q: Vec<i64> = (0..rows).map(folded).map(|f| (f >> 1) as i64 ^ -((f & 1) as i64)).collect();
        for _ in 0..order {
            for i in 1..rows {
                q[i] += q[i - 1];
            }
        }
        q.iter().map(|&q| if q == 0 { f64::NAN } else { step * (base + (q - 1) as f64) }).collect()
    }

    #[test]
    fn columns_come_back_within_half_a_step_and_smooth_ones_are_small() {
        let smooth: Vec<f64> = (0..1000).map(|i| 0.15 * (0.11 * f64::from(i)).sin()).collect();
        let mut pack = Pack::default();
        let channel = pack.add(&smooth, 5e-5);
        let worst = smooth.iter().zip(read(&pack, channel)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst <= 2.6e-5 && channel.order >= 3 && channel.planes <= 2, "{worst} {channel:?}");
        assert!(pack.letters("").len() < 1000, "{}", pack.letters("").len());
    }

    #[test]
    fn odd_columns_come_back() {
        let odd: [&[f64]; 5] = [
            &[],
            &[f64::NAN, f64::INFINITY],
            &[1e300, -1e300, 0.0, f64::NAN],
            &[f64::MAX, f64::MIN],
            &[2.5, 2.5, 2.5],
        ];
        for values in odd {
            let mut pack = Pack::default();
            let channel = pack.add(values, 1e-4);
            for (value, read) in values.iter().zip(read(&pack, channel)) {
                let near = (0.5 * value - 0.5 * read).abs() <= channel.step;
                assert!(near || (!value.is_finite() && read.is_nan()), "{value} {read} {channel:?}");
            }
        }
    }
}

//! The box's clock beside the host's.

use wingbeat::rig::netft::{APART_S, BOX_RATE};

use crate::Row;

/// A line through (sequence, time) by running sums.
#[derive(Default)]
pub struct ClockFit {
    first: Option<(u32, u64)>,
    /// Time from the first record to the last, s.
    pub span: f64,
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl ClockFit {
    /// Adds a record that came at `ns`.
    pub fn add(&mut self, sequence: u32, ns: u64) {
        let (s0, t0) = *self.first.get_or_insert((sequence, ns));
        let x = f64::from(sequence.wrapping_sub(s0) as i32);
        let y = (ns as i64 - t0 as i64) as f64 * 1e-9;
        self.span = self.span.max(y);
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Samples per second and spread of arrival, s.
    pub fn result(&self) -> (f64, f64) {
        let (sxx, sxy) = (self.xx - self.x * self.x / self.n, self.xy - self.x * self.y / self.n);
        let syy = self.yy - self.y * self.y / self.n;
        if self.n < 3.0 || sxx <= 0.0 || sxy <= 0.0 {
            return (0.0, 0.0);
        }
        (sxx / sxy, ((syy - sxy * sxy / sxx).max(0.0) / self.n).sqrt())
    }
}

/// Times of rows by the box's own count of samples, bridged by arrival where that count began anew.
#[derive(Debug, Default)]
pub struct Timeline {
    last: Option<Row>,
    /// Time of the last row: samples since the anchor, and the anchor's time, s.
    samples: i64,
    anchor: f64,
}

impl Timeline {
    /// Time of `row`, the next that came, from the first on, s.
    pub fn time(&mut self, row: &Row) -> f64 {
        if let Some(last) = self.last.replace(*row) {
            let step = row.record.ft_sequence.wrapping_sub(last.record.ft_sequence) as i32;
            let arrival = (row.arrival_ns() as i64 - last.arrival_ns() as i64) as f64 * 1e-9;
            if (f64::from(step) / BOX_RATE - arrival).abs() < APART_S {
                self.samples += i64::from(step);
            } else {
                self.anchor += self.samples as f64 / BOX_RATE + arrival;
                self.samples = 0;
            }
        }
        self.anchor + self.samples as f64 / BOX_RATE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::rig::netft::RdtRecord;

    #[test]
    fn time_goes_on_over_a_wrap_and_a_restart_of_the_box() {
        let row = |ft_sequence: u32, ms: u64| Row {
            host_ns: 1_000_000_000 + ms * 1_000_000,
            kernel_ns: 0,
            record: RdtRecord { ft_sequence, ..Default::default() },
        };
        let mut line = Timeline::default();
        let rows = [row(u32::MAX, 0), row(13, 2), row(6, 2), row(20, 9), row(1, 2009), row(8, 2010)];
        let times = rows.map(|row| line.time(&row));
        let expected = [0.0, 0.002, 0.001, 0.003, 2.003, 2.004];
        assert!(times.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{times:?}");
    }

    #[test]
    fn the_rate_is_the_slope_of_the_line() {
        let mut fit = ClockFit::default();
        (0..70_000_u32).for_each(|k| fit.add(k.wrapping_sub(9), 5 + u64::from(k) * 142_857));
        let (rate, spread) = fit.result();
        assert!((rate - 1e9 / 142_857.0).abs() < 1e-6 && spread < 1e-6, "{rate} {spread}");
    }
}

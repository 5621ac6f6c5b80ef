//! Cycles as sums of harmonics.

use std::f64::consts::TAU;

/// How the numbers of a cycle lie: channel after channel its mean, then cosine and sine of each harmonic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HarmonicLayout {
    /// Number of channels.
    pub channels: usize,
    /// Number of harmonics beside the mean.
    pub harmonics: usize,
}

impl HarmonicLayout {
    /// Numbers per channel.
    pub fn width(self) -> usize {
        1 + 2 * self.harmonics
    }
    /// Numbers of a cycle.
    pub fn len(self) -> usize {
        self.channels * self.width()
    }
    /// True without any number.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
    /// Place of the part `part` (0 mean, 2k - 1 cosine, 2k sine of harmonic k) of a channel.
    pub fn at(self, channel: usize, part: usize) -> usize {
        channel * self.width() + part
    }
    /// The harmonic of a part.
    pub fn harmonic(part: usize) -> usize {
        part.div_ceil(2)
    }
    /// What a part multiplies at a phase, rad: 1, cos, sin, cos 2, ...
    pub fn wave(part: usize, phase: f64) -> f64 {
        let turned = Self::harmonic(part) as f64 * phase;
        match part {
            0 => 1.0,
            part if part % 2 == 1 => turned.cos(),
            _ => turned.sin(),
        }
    }
    /// Means and harmonics of rows of channels, in the units of these, at equal steps of a cycle from phase 0.
    pub fn of_steps(self, rows: &[[f64; 6]]) -> Vec<f64> {
        let mut cycle = vec![0.0; self.len()];
        let count = rows.len() as f64;
        for (k, row) in rows.iter().enumerate() {
            let phase = TAU * k as f64 / count;
            for part in 0..self.width() {
                let weight = Self::wave(part, phase) / (Self::share(part) * count);
                for (channel, x) in row.iter().enumerate() {
                    cycle[self.at(channel, part)] += x * weight;
                }
            }
        }
        cycle
    }
    /// Share of the square of a part in the mean square over the cycle.
    pub fn share(part: usize) -> f64 {
        if part == 0 { 1.0 } else { 0.5 }
    }
    /// Mean square of a channel over the cycle, in the square of its unit.
    pub fn mean_square(self, cycle: &[f64], channel: usize) -> f64 {
        (0..self.width()).map(|part| Self::share(part) * cycle[self.at(channel, part)].powi(2)).sum()
    }
    /// A channel at the phase `phase`, rad.
    pub fn value(self, cycle: &[f64], channel: usize, phase: f64) -> f64 {
        let waves = (1..=self.harmonics).map(|k| {
            let (sin, cos) = (k as f64 * phase).sin_cos();
            cycle[self.at(channel, 2 * k - 1)] * cos + cycle[self.at(channel, 2 * k)] * sin
        });
        cycle[self.at(channel, 0)] + waves.sum::<f64>()
    }
}

/// Means and harmonics of `channels`, in the units of these, over the cycle that begins at the phase `begin` (rad): x_k = 1/pi
/// integral of x cos(k phase) over it, by trapezia between the samples, the ends by linear interpolation. `phase` ascends and
/// covers the cycle. None where a sample is missing.
///
/// Equation: calibrate.projection
/// `x_k = 1/pi int x cos(k phase) over a cycle, by trapezia`
/// Source: Fourier.
/// Test: `harmonics_of_a_sum_of_harmonics_come_back`.
pub fn project(phase: &[f64], channels: &[Vec<f64>; 6], begin: f64, harmonics: usize) -> Option<Vec<f64>> {
    let layout = HarmonicLayout { channels: 6, harmonics };
    let end = begin + TAU;
    let first = phase.partition_point(|p| *p <= begin);
    let last = phase.partition_point(|p| *p < end);
    if first == 0 || last >= phase.len() || first >= last {
        return None;
    }
    let between = |k: usize, p: f64| {
        let share = (p - phase[k - 1]) / (phase[k] - phase[k - 1]);
        channels.each_ref().map(|x| x[k - 1] + share * (x[k] - x[k - 1]))
    };
    let mut cycle = vec![0.0; layout.len()];
    let mut before = (begin, between(first, begin));
    let inner = (first..last).map(|k| (phase[k], channels.each_ref().map(|x| x[k])));
    let points = inner.chain([(end, between(last, end))]);
    let mut add = |(p, x): (f64, [f64; 6]), weight: f64| {
        let (sin, cos) = p.sin_cos();
        let (mut s, mut c) = (0.0, 1.0);
        for k in 0..=harmonics {
            for (channel, value) in x.iter().enumerate() {
                let scaled = value * weight;
                if k == 0 {
                    cycle[layout.at(channel, 0)] += 0.5 * scaled;
                } else {
                    cycle[layout.at(channel, 2 * k - 1)] += scaled * c;
                    cycle[layout.at(channel, 2 * k)] += scaled * s;
                }
            }
            (s, c) = (s * cos + c * sin, c * cos - s * sin);
        }
    };
    let mut width_before = 0.0;
    for point in points {
        let width = (point.0 - before.0) / TAU;
        add(before, width_before + width);
        (before, width_before) = (point, width);
    }
    add(before, width_before);
    cycle.iter().all(|x| x.is_finite()).then_some(cycle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_of_a_sum_of_harmonics_come_back() {
        let phase: Vec<f64> = (0..900).map(|k| 0.1 + 0.0101 * f64::from(k)).collect();
        let x = |p: f64| 0.7 + 0.3 * p.cos() - 0.2 * (2.0 * p).sin() + 0.05 * (3.0 * p).cos();
        let mut channels: [Vec<f64>; 6] = Default::default();
        for (i, channel) in channels.iter_mut().enumerate() {
            *channel = phase.iter().map(|p| (1.0 + i as f64) * x(*p)).collect();
        }
        let layout = HarmonicLayout { channels: 6, harmonics: 4 };
        let cycle = project(&phase, &channels, 0.3, 4).unwrap();
        let of = |part: usize| cycle[layout.at(1, part)] / 2.0;
        for (part, expected) in [(0, 0.7), (1, 0.3), (2, 0.0), (3, 0.0), (4, -0.2), (5, 0.05), (7, 0.0)] {
            assert!((of(part) - expected).abs() < 2e-5, "{part}: {}", of(part));
        }
        assert!((layout.value(&cycle, 2, 1.1) - 3.0 * x(1.1)).abs() < 1e-4);
        assert!(project(&phase, &channels, 3.0, 4).is_none(), "the samples end before the cycle");
    }
}

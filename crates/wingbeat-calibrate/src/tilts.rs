//! Static tilts as a run: wings still, the robot held in one attitude after another.
//!
//! A cycle is one pass through the attitudes and its phase their number: its harmonics are those of the loads in the n attitudes, which
//! (n - 1)/2 of them and the mean give back where n is odd.

use crate::HarmonicLayout;
use std::f64::consts::TAU;
use std::ops::Range;

/// Share of each attitude's time that is left out at its begin and at its end, as the weighing of tilts does.
const SETTLING: [f64; 2] = [0.2, 0.05];
/// Parts of the rest of each attitude, one part of all attitudes a cycle: their scatter is the noise. *Choice.*
const PARTS: usize = 12;
/// Instants of the simulation in each attitude.
pub const INSTANTS: usize = 20;

/// Attitudes of a run of static tilts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilts {
    /// Number of attitudes.
    pub count: usize,
    /// Time in each, s.
    pub each_s: f64,
}

impl Tilts {
    /// How the numbers of a cycle lie.
    pub fn layout(self) -> HarmonicLayout {
        HarmonicLayout { channels: 6, harmonics: (self.count - 1) / 2 }
    }

    /// Begin and end of what is used of attitude `k`, s.
    fn used(self, k: usize) -> (f64, f64) {
        let at = |share: f64| (k as f64 + share) * self.each_s;
        (at(SETTLING[0]), at(1.0 - SETTLING[1]))
    }

    /// The cycle of loads (N and N m) at ascending times (s).
    pub fn cycle(self, time: &dyn Fn(usize) -> f64, rows: &[[f64; 6]]) -> Option<Vec<f64>> {
        let mean = |k: usize| {
            let (begin, end) = self.used(k);
            let own = (0..rows.len()).filter(|row| (begin..=end).contains(&time(*row)));
            mean(own.map(|row| rows[row]))
        };
        self.of_means((0..self.count).map(mean))
    }

    /// The cycles (N and N m) of the samples of a pass, none in place of one with an attitude without samples. `time` (s)
    /// ascends, and `load` is what a sample that can be used shows.
    pub fn cycles(self, time: &[f64], load: &dyn Fn(usize) -> Option<[f64; 6]>) -> Vec<Option<Vec<f64>>> {
        let one = |part: usize| {
            self.of_means((0..self.count).map(|k| mean(self.rows(time, k, part).filter_map(load))))
        };
        (0..PARTS).map(one).collect()
    }

    /// Samples of part `part` of attitude `k`.
    fn rows(self, time: &[f64], k: usize, part: usize) -> Range<usize> {
        let (begin, end) = self.used(k);
        let at = |part: usize| {
            let t = begin + (end - begin) * part as f64 / PARTS as f64;
            time.partition_point(|own| *own < t)
        };
        at(part)..at(part + 1)
    }

    /// Number of samples of a cycle at `rate_hz`.
    pub fn samples(self, rate_hz: f64) -> f64 {
        let (begin, end) = self.used(0);
        (end - begin) * rate_hz * self.count as f64 / PARTS as f64
    }

    /// Mean and harmonics of the time, s, over a pass: the middle of what is used of each attitude.
    pub fn clock(self) -> Vec<f64> {
        let middle = |k: usize| {
            let (begin, end) = self.used(k);
            Some([0.5 * (begin + end); 6])
        };
        let whole = self.of_means((0..self.count).map(middle)).unwrap_or_default();
        whole[..self.layout().width()].to_vec()
    }

    /// The attitude in which the robot is at `t`, as a phase, rad; none while it settles.
    pub fn phase(self, t: f64) -> Option<f64> {
        let k = (t / self.each_s).floor();
        let (begin, end) = self.used(k.max(0.0) as usize);
        let held = (0.0..self.count as f64).contains(&k) && (begin..=end).contains(&t);
        held.then_some(TAU * k / self.count as f64)
    }

    fn of_means(self, means: impl Iterator<Item = Option<[f64; 6]>>) -> Option<Vec<f64>> {
        let rows: Option<Vec<[f64; 6]>> = means.collect();
        Some(self.layout().of_steps(&rows?))
    }
}

fn mean(rows: impl Iterator<Item = [f64; 6]>) -> Option<[f64; 6]> {
    let (mut sum, mut count) = ([0.0; 6], 0.0);
    for row in rows {
        sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        count += 1.0;
    }
    (count > 0.0).then(|| sum.map(|x| x / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_in_an_odd_number_of_attitudes_come_back() {
        let tilts = Tilts { count: 5, each_s: 2.0 };
        let load = |k: usize| std::array::from_fn(|i| (1.0 + i as f64) * (k * k) as f64);
        let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let cycles = tilts.cycles(&time, &|row| Some(load((time[row] / 2.0) as usize)));
        assert_eq!(cycles.len(), PARTS);
        for cycle in cycles {
            let cycle = cycle.unwrap();
            for k in 0..5 {
                let back = tilts.layout().value(&cycle, 2, TAU * k as f64 / 5.0);
                assert!((back - load(k)[2]).abs() < 1e-12, "{k}: {back}");
            }
        }
        let none = tilts.cycles(&time, &|row| (time[row] > 2.0).then_some([0.0; 6]));
        assert!(none.iter().all(Option::is_none), "the first attitude has no sample");
    }
}

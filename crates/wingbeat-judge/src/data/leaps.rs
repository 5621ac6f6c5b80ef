//! Where a channel leaps: steps that lie far from those before and after them, and whether they come after equal numbers of samples.

use super::cycle::variance;
use super::noise::{OF_THIRD, deviation_beside, third};
use super::outliers::place;
use super::values::Extent;
use super::{Finding, MeasuredChannel, Series};
use crate::limits::data::LEAPS;

/// Third differences, taken evenly from the file, that tell the noise. *Choice.*
const TOLD: usize = 512;
/// Deviations of third differences from which one is a leap. *Choice.*
const BEYOND: f64 = LEAPS.value;
/// Part of the range and counts of the converter that a leap has at least. *Choices.*
const LEAST: [f64; 2] = [0.02, 4.0];
/// Leaps from which their order tells, and most that are looked at. *Choices.*
const FEWEST: usize = 24;
const MOST: usize = 2048;
/// Longest turns that are sought, in samples. *Choice.*
const LONGEST: usize = 128;
/// Logarithm of the chance of so many leaps at one place of turns, below which they are turns. With 128 lengths and as many places of each
/// it leaves one false alarm of 1e8 channels. *Choice.*
const SURE: f64 = 28.0;
/// Share of all leaps that lie at the place of the turns. *Choice.*
const SHARE: f64 = 0.6;
/// Turns by which the cycle drifts against them from start to end, and places of the cycle that they meet else, of so many: knocks and what
/// rings after them come at some few. *Choices.*
const DRIFTS: f64 = 1.0;
const PLACES: usize = 16;
const MET: usize = 8;
/// Correlation of one leap and the next below which they go up and down: a difference that goes with a load has -cos w after w of its cycle,
/// values that are held have cos w. *Choice.*
const UP_AND_DOWN: f64 = -0.2;
/// Deviation of the sizes of the leaps over their mean below which they are those of a ripple on the load. *Choice.*
const STEADY: f64 = 0.3;

/// Leaps of a channel, each by the sample after it and its size.
pub(super) struct Leaps {
    of: Vec<(usize, f64)>,
    /// Deviation of what a step of the noise lies off those beside it.
    noise: f64,
    /// Mean magnitude of the leaps over it.
    over_noise: f64,
}

impl Leaps {
    /// A third difference t of the samples k - 1 to k + 2 is minus two times what the step from k to k + 1 lies off the mean of those beside
    /// it. White noise of deviation s gives t the deviation sqrt(20) s; s is told by the lower quartile of |t|, so that leaps at a quarter
    /// of the samples do not hide themselves.
    pub fn of(samples: &[f64], extent: Extent) -> Self {
        let every = (samples.len() / TOLD).max(1);
        let mut told: Vec<f64> = samples.windows(4).step_by(every).map(third).collect();
        let usual = OF_THIRD * deviation_beside(&mut told);
        let count = if extent.count.is_finite() { extent.count } else { 0.0 };
        let least = (BEYOND * usual).max(2.0 * LEAST[0] * extent.range()).max(2.0 * LEAST[1] * count);
        let mut of = Vec::new();
        let mut sum = 0.0;
        // Counted as wide as the samples are, several at once: most channels have none.
        let any = samples.windows(4).map(|four| u64::from(third(four).abs() > least)).sum::<u64>() > 0;
        for (k, four) in samples.windows(4).enumerate().take(if any { samples.len() } else { 0 }) {
            let here = third(four).abs();
            if here > least {
                let beside = |k: usize| samples.get(k..k + 4).map_or(0.0, |four| third(four).abs());
                if here >= beside(k + 1) && (k == 0 || here > beside(k - 1)) {
                    of.push((k + 2, -0.5 * third(four)));
                    sum += here;
                }
            }
        }
        let over_noise = sum / (of.len().max(1) as f64 * usual.max(f64::MIN_POSITIVE));
        Self { of, noise: 0.5 * usual, over_noise }
    }

    /// The finding that samples come from two sources by turns, in the whole file or in a part of it.
    ///
    /// Of n leaps at random places n / m lie at one place of turns of m samples. c of them there have the chance exp(-s),
    /// s = c ln(c m / n) - c + n / m (the bound of H. Chernoff, Ann. Math. Statist. 23 (1952) 493-507, for a Poisson number). Those of two
    /// sources go up and down by turns, and keep no step with the cycle. Leaps that are all alike are those of a ripple that is added to the
    /// load, as of a chopper: they are noted.
    pub fn turns(&self, series: &Series, channel: &MeasuredChannel) -> Option<Finding> {
        if self.of.len() < FEWEST {
            return None;
        }
        let from = self.of.len().saturating_sub(MOST) / 2;
        let all = &self.of[from..self.of.len().min(from + MOST)];
        let many = all.len() as f64;
        let surprise = |there: usize, m: usize| {
            let (c, usual) = (there as f64, many / m as f64);
            c * (c / usual).ln() - c + usual
        };
        let most = |m: usize| {
            let mut there = vec![0_usize; m];
            all.iter().for_each(|(k, _)| there[k % m] += 1);
            let at = (0..m).max_by_key(|k| there[*k])?;
            Some((surprise(there[at], m), m, at, there[at]))
        };
        let (sure, m, at, there) = (3..=LONGEST).filter_map(most).max_by(|a, b| a.0.total_cmp(&b.0))?;
        if sure < SURE || (there as f64) < SHARE * many {
            return None;
        }
        let own = || all.iter().filter(|(k, _)| k % m == at);
        let mut met = [false; PLACES];
        own().for_each(|(k, _)| met[place(series.phase[*k], PLACES)] = true);
        let (mut next, mut squares) = (0.0, 0.0);
        for (a, b) in own().zip(own().skip(1)).filter(|(a, b)| b.0 - a.0 == m) {
            next += a.1 * b.1;
            squares += 0.5 * (a.1 * a.1 + b.1 * b.1);
        }
        let turns = channel.samples.len() as f64 / series.cycles() / m as f64;
        let drifts = (turns - turns.round()).abs() * series.cycles() > DRIFTS;
        let any_phase = drifts || met.iter().filter(|met| **met).count() >= MET;
        let told = any_phase && next < UP_AND_DOWN * squares;
        // Of all ends of turns there, large or not, with the signs that a ripple would give them.
        let joins = (all[0].0..=all[all.len() - 1].0).filter(|k| k % m == at);
        let sign = |k: usize| if (k / m).is_multiple_of(2) { 1.0 } else { -1.0 };
        let off = |k: usize| channel.samples.get(k - 2..k + 2).map_or(0.0, |four| -0.5 * third(four));
        let off: Vec<f64> = joins.map(|k| sign(k) * off(k)).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let steady = variance(&off) < (STEADY * mean).powi(2) + 2.0 * self.noise.powi(2);
        let or = if steady { ", or a ripple of that period" } else { "" };
        let text = format!(
            "leaps up and down every {m} samples, {} times, and is smooth between: two sources by turns in one column{or}",
            self.of.len()
        );
        let found = || {
            Finding::new("data.alternates", &LEAPS, series.about(channel.name), self.over_noise, text)
                .in_channel(channel.name)
        };
        told.then(|| if steady { found().noted() } else { found() })
    }
}

//! What was measured in a run: its cycles, their mean and their scatter.

use crate::HarmonicLayout;
use nalgebra::DMatrix;
use wingbeat::judge::data::Finding;
use wingbeat::scenario::{CalibratedCaseSpec, CalibratedRunSpec};

/// Distance beyond which a cycle counts less, in deviations (Huber 1964: 95 % efficient on normal noise).
const HUBER: f64 = 1.345;
/// Rounds of weighing.
const ROUNDS: usize = 8;
/// Cycles beyond one for each channel and each mean that tell a scatter whose inverse weighs: with fewer the estimates so weighed have
/// no variance (`estimated_weights`).
pub const SPARE: usize = 2;

/// What a run is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RunRole {
    /// The numbers are fitted to it.
    #[default]
    Fitted,
    /// It is only predicted.
    HeldOut,
    /// What the fitted model leaves of it is learned.
    Residual,
}

impl RunRole {
    /// Of a run as a calibration names it.
    pub fn of(run: &CalibratedRunSpec) -> Self {
        match run {
            CalibratedRunSpec { residual: true, .. } => Self::Residual,
            CalibratedRunSpec { held_out: true, .. } => Self::HeldOut,
            _ => Self::Fitted,
        }
    }
    /// Of a case.
    pub fn of_case(case: &CalibratedCaseSpec) -> Self {
        if case.held_out { Self::HeldOut } else { Self::Fitted }
    }
}

/// The cycles of a run.
#[derive(Clone, Debug)]
pub struct ObservedCycles {
    /// Name of the run.
    pub name: String,
    /// How the numbers lie.
    pub layout: HarmonicLayout,
    /// Numbers of each cycle, in the units of the channels (N and N m).
    pub cycles: Vec<Vec<f64>>,
    /// Weight of each cycle, dimensionless: 1 for an ordinary one.
    pub weights: Vec<f64>,
    /// Weighted mean of the cycles, in the units of the channels.
    pub mean: Vec<f64>,
    /// Covariance of the channels from sample to sample at one phase, in the units of the channels, squared.
    pub sample_noise: DMatrix<f64>,
    /// Samples per cycle.
    pub samples_per_cycle: f64,
    /// Cycles left out because samples are missing or saturated.
    pub left_out: usize,
    /// What is odd of the samples, in words.
    pub oddities: Vec<String>,
    /// What is wrong with the samples.
    pub found: Vec<Finding>,
    /// Frequency that was measured, Hz.
    pub frequency_hz: f64,
    /// What the run is for.
    pub role: RunRole,
    /// Channels that were not measured: their numbers say nothing.
    pub unmeasured: Vec<usize>,
    /// Errors that cycles share.
    pub common: Common,
}

/// Errors that cycles share, which their scatter does not show.
#[derive(Clone, Debug, Default)]
pub struct Common {
    /// The group of each cycle, where those of a group are parts of one pass and only what differs within it scatters; empty where all
    /// cycles scatter about one mean.
    pub groups: Vec<usize>,
    /// Covariance of the error of the mean that is of the tare, in the units of the channels, squared; none where nothing is
    /// tared.
    pub mean: Option<DMatrix<f64>>,
    /// The same of the cycles of one pass.
    pub pass: Option<DMatrix<f64>>,
    /// Number of batches of rest beyond the lines they take of which both were told.
    pub tare_freedom: f64,
}

impl ObservedCycles {
    /// Weighs the cycles, `robust` or all alike, and takes their mean.
    pub fn weigh(&mut self, robust: bool) {
        self.weights = vec![1.0; self.cycles.len()];
        self.mean = self.weighted_mean();
        if !robust || self.cycles.len() < 5 {
            return;
        }
        for _ in 0..ROUNDS {
            let distances: Vec<f64> = self.cycles.iter().map(|cycle| self.distance(cycle)).collect();
            let mut sorted = distances.clone();
            wingbeat::math::order::ascend(&mut sorted);
            // Half of the cycles of normal noise lie below the median distance: it is the scale.
            let usual = sorted[sorted.len() / 2].max(f64::MIN_POSITIVE);
            let weight = |d: &f64| (HUBER * usual / d.max(f64::MIN_POSITIVE)).min(1.0);
            self.weights = distances.iter().map(weight).collect();
            self.mean = self.weighted_mean();
        }
    }

    fn weighted_mean(&self) -> Vec<f64> {
        let total: f64 = self.weights.iter().sum();
        let mut mean = vec![0.0; self.layout.len()];
        for (cycle, weight) in self.cycles.iter().zip(&self.weights) {
            mean.iter_mut().zip(cycle).for_each(|(m, x)| *m += weight / total * x);
        }
        mean
    }

    /// Root mean square over the cycle of what `cycle` differs from the mean, each channel in parts of its own.
    fn distance(&self, cycle: &[f64]) -> f64 {
        let apart: Vec<f64> = cycle.iter().zip(&self.mean).map(|(x, m)| x - m).collect();
        let of = |channel: usize| {
            let own = self.layout.mean_square(&self.mean, channel).max(f64::MIN_POSITIVE);
            self.layout.mean_square(&apart, channel) / own
        };
        (0..self.layout.channels).map(of).sum::<f64>().sqrt()
    }

    /// What each cycle differs, in the units of the channels, from the mean about which it scatters: that of all, or of its
    /// group.
    pub fn deviations(&self) -> Vec<Vec<f64>> {
        let group = |k: usize| self.common.groups.get(k).copied().unwrap_or(0);
        let mut sums = vec![(0.0, vec![0.0; self.layout.len()]); self.groups()];
        for (k, (cycle, weight)) in self.cycles.iter().zip(&self.weights).enumerate() {
            let (total, sum) = &mut sums[group(k)];
            *total += weight;
            sum.iter_mut().zip(cycle).for_each(|(sum, x)| *sum += weight * x);
        }
        let apart = |(k, cycle): (usize, &Vec<f64>)| {
            let (total, sum) = &sums[group(k)];
            cycle.iter().zip(sum).map(|(x, sum)| x - sum / total).collect()
        };
        self.cycles.iter().enumerate().map(apart).collect()
    }

    /// Number of groups of cycles.
    fn groups(&self) -> usize {
        self.common.groups.iter().max().map_or(1, |last| last + 1)
    }

    /// Cycles beyond those that their means take.
    pub fn freedom(&self) -> f64 {
        self.cycles.len() as f64 - self.groups() as f64
    }

    /// Whether channel `channel` was measured.
    pub fn is_measured(&self, channel: usize) -> bool {
        !self.unmeasured.contains(&channel)
    }

    /// Variance of the number `i` of the mean that is of the tare, in the square of its unit.
    pub fn tare_variance(&self, i: usize) -> f64 {
        self.common.mean.as_ref().map_or(0.0, |of| of[(i, i)])
    }

    /// Root mean square over the cycle of what a cycle differs from the mean about which it scatters, by channel.
    fn sizes(&self) -> Vec<f64> {
        let (freedom, deviations) = (self.freedom().max(1.0), self.deviations());
        let channel = |channel: usize| {
            let one = |(apart, weight): (&Vec<f64>, &f64)| weight * self.layout.mean_square(apart, channel);
            (deviations.iter().zip(&self.weights).map(one).sum::<f64>() / freedom).sqrt()
        };
        (0..self.layout.channels).map(channel).collect()
    }

    /// Number of cycles that would scatter the mean as the weighted ones do.
    pub fn effective(&self) -> f64 {
        let (sum, squares) =
            self.weights.iter().fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
        if squares > 0.0 { sum * sum / squares } else { 0.0 }
    }
}

/// Covariance of the channels by harmonic from cycle to cycle, cosines and sines alike, of each of the runs, which have one
/// layout and measured the same channels: S_k = D R_k D, with D the scatter of the run's own cycles by channel (loads that are larger scatter more) and R_k, the
/// shape over channels and harmonics, pooled over the runs with each channel in parts of its D.
///
/// Equation: calibrate.scatter
/// `S_k = D R_k D, D the scatter of the run by channel, R_k of all runs in parts of it`
/// Source: own.
/// Test: `each_run_scatters_by_its_own_size`.
pub fn scatter(runs: &[&ObservedCycles]) -> Option<Vec<Vec<DMatrix<f64>>>> {
    let layout = runs.first()?.layout;
    let freedom: f64 = runs.iter().map(|run| run.freedom()).sum();
    if freedom < (layout.channels - runs[0].unmeasured.len() + SPARE) as f64 {
        return None;
    }
    let own: Vec<Vec<f64>> = runs.iter().map(|run| run.sizes()).collect();
    // A run of one cycle scatters as the others do.
    let all: Vec<f64> = (0..layout.channels)
        .map(|c| {
            let squares = runs.iter().zip(&own).map(|(run, own)| run.freedom() * own[c].powi(2));
            (squares.sum::<f64>() / freedom).sqrt()
        })
        .collect();
    let sizes: Vec<&Vec<f64>> =
        runs.iter().zip(&own).map(|(run, own)| if run.freedom() > 0.0 { own } else { &all }).collect();
    let mut shape = vec![DMatrix::zeros(layout.channels, layout.channels); layout.harmonics + 1];
    for (run, size) in runs.iter().zip(&sizes) {
        for (deviation, weight) in run.deviations().iter().zip(&run.weights) {
            let apart = |channel: usize, part: usize| {
                deviation[layout.at(channel, part)] / size[channel].max(f64::MIN_POSITIVE)
            };
            for part in 0..layout.width() {
                let harmonic = HarmonicLayout::harmonic(part);
                let count = if part == 0 { freedom } else { 2.0 * freedom };
                for a in 0..layout.channels {
                    for b in 0..layout.channels {
                        shape[harmonic][(a, b)] += weight * apart(a, part) * apart(b, part) / count;
                    }
                }
            }
        }
    }
    Some(sizes.iter().map(|size| sized(&shape, size)).collect())
}

/// Matrices with row and column `c` times the factor `by[c]`, a ratio.
pub fn sized(shape: &[DMatrix<f64>], by: &[f64]) -> Vec<DMatrix<f64>> {
    let one = |of: &DMatrix<f64>| DMatrix::from_fn(of.nrows(), of.ncols(), |a, b| of[(a, b)] * by[a] * by[b]);
    shape.iter().map(one).collect()
}

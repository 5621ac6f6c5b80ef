//! The rest before a run: the line that is taken away, and what its noise puts into the cycles.

use crate::measured::MeasuredPass;
use crate::rig::{RigTarget, SETTLING};
use crate::{Error, HarmonicLayout, ObservedCycles};
use nalgebra::{DMatrix, DVector};
use wingbeat::rig::process::tare_line;

/// The rest before a run.
pub struct Rest {
    /// Offset at t = 0 and slope of each channel, in its unit and that per s.
    pub lines: [(f64, f64); 6],
    /// Covariance of the channels' noise per sample, as far as it does not average out from sample to sample.
    noise: DMatrix<f64>,
    /// Batches beyond the numbers of a line, of which that was told.
    freedom: f64,
    /// (X'X)^-1 of offset and slope: variances and covariance of both for noise of 1 per sample.
    spread: [f64; 3],
}

/// What the noise of the rest puts into the cycles of a pass.
#[derive(Clone)]
pub struct Tare {
    /// Its covariance.
    covariance: DMatrix<f64>,
    /// Batches beyond the numbers of a line, of which that was told.
    freedom: f64,
}

/// Batches of the rest by whose means its noise is told: what is correlated from sample to sample is uncorrelated from batch to
/// batch. *Choice.*
const BATCHES: usize = 24;

/// Offset and slope of each channel over the `usable` samples of the rest, as it is read; none where the run takes no tare.
pub fn rest(target: &RigTarget, pass: &MeasuredPass, usable: &[bool]) -> Result<Option<Rest>, Error> {
    if !target.tared() {
        return Ok(None);
    }
    let end = pass.time.partition_point(|t| *t < -1e-9);
    let from = (end as f64 * SETTLING) as usize;
    let rows: Vec<usize> = (from..end).filter(|k| usable[*k]).collect();
    if rows.len() < 16 {
        let what = format!(
            "{} samples of rest before the run: at least 16 are needed for the tare (process.input.start_s says when \
             the run begins; process.steps.tare = false does without)",
            rows.len()
        );
        return Err(Error::data(&pass.file, what));
    }
    let time: Vec<f64> = rows.iter().map(|row| pass.time[*row]).collect();
    let drift = target.run.spec.process.steps.drift;
    let lines = pass.channels.each_ref().map(|channel| {
        let values: Vec<f64> = rows.iter().map(|k| channel[*k]).collect();
        if drift {
            tare_line(&time, &values)
        } else {
            (values.iter().sum::<f64>() / values.len() as f64, 0.0)
        }
    });
    let count = rows.len() as f64;
    let middle = time.iter().sum::<f64>() / count;
    let square: f64 = time.iter().map(|t| (t - middle).powi(2)).sum();
    let spread = match drift {
        true => [count.recip() + middle * middle / square, -middle / square, square.recip()],
        false => [count.recip(), 0.0, 0.0],
    };
    let batches = BATCHES.min(rows.len() / 2);
    let length = rows.len() / batches;
    let mut noise = DMatrix::zeros(6, 6);
    for batch in rows.chunks_exact(length).take(batches) {
        let mean = DVector::from_fn(6, |i, _| {
            let left = |k: &usize| pass.channels[i][*k] - lines[i].0 - lines[i].1 * pass.time[*k];
            batch.iter().map(left).sum::<f64>() / length as f64
        });
        noise += &mean * mean.transpose();
    }
    let taken = if drift { 2.0 } else { 1.0 };
    let freedom = (batches as f64 - taken).max(1.0);
    noise *= length as f64 / freedom;
    Ok(Some(Rest { lines, noise, freedom, spread }))
}

impl Rest {
    /// Covariance of what the noise of the rest puts into the cycles of a pass: an error of the offset is a load of the same
    /// size at every phase, one of the slope that load times the time, which over the cycle is `clock` (s).
    ///
    /// Equation: calibrate.tare_covariance
    /// `T = K (x) M N M', K = [[var b, cov], [cov, var d]] between 1 and t over the cycle, N of the means of batches
    /// of the rest, M from cell to body`
    /// Source: generalised least squares, Aitken 1936; batch means.
    /// Test: `standard_errors_of_what_tilts_tell_are_those_of_many_seeds`.
    pub fn tare(&self, target: &RigTarget, layout: HarmonicLayout, clock: &[f64]) -> Tare {
        let turn = DMatrix::from_columns(
            &(0..6)
                .map(|i| {
                    let unit = std::array::from_fn(|k| f64::from(u8::from(k == i)));
                    DVector::from_row_slice(&target.in_body(unit))
                })
                .collect::<Vec<_>>(),
        );
        let body = &turn * &self.noise * turn.transpose();
        let [offset, both, slope] = self.spread;
        let constant = |part: usize| f64::from(u8::from(part == 0));
        let between = |p: usize, q: usize| {
            offset * constant(p) * constant(q)
                + both * (constant(p) * clock[q] + clock[p] * constant(q))
                + slope * clock[p] * clock[q]
        };
        let width = layout.width();
        let covariance = DMatrix::from_fn(layout.len(), layout.len(), |i, j| {
            between(i % width, j % width) * body[(i / width, j / width)]
        });
        Tare { covariance, freedom: self.freedom }
    }
}

/// Mean and harmonics of the time, s, over cycles that begin at the phase `begin.0` and have the frequency `begin.1`, about
/// `middle`: a sawtooth, whose sines about that phase are -1/(pi k f).
pub fn clock(layout: HarmonicLayout, (begin, frequency): (f64, f64), middle: f64) -> Vec<f64> {
    let part = |part: usize| {
        let k = HarmonicLayout::harmonic(part) as f64;
        let size = -1.0 / (std::f64::consts::PI * k * frequency);
        match part {
            0 => middle,
            part if part % 2 == 1 => -size * (k * begin).sin(),
            _ => size * (k * begin).cos(),
        }
    };
    (0..layout.width()).map(part).collect()
}

/// Sets what the cycles have in common: `of` says of which pass each is, `tares` what the tare of each pass puts into its cycles.
/// The passes' tares are independent: of a mean with the weights w the covariance is the sum over the passes of (sum w / sum of all w)^2
/// times theirs.
pub fn share(observed: &mut ObservedCycles, of: &[usize], tares: &[Option<Tare>]) {
    let total: f64 = observed.weights.iter().sum();
    let size = observed.layout.len();
    let (mut mean, mut pass, mut known) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size), 0.0);
    for (k, tare) in tares.iter().enumerate() {
        let Some(tare) = tare else { continue };
        let own = observed.weights.iter().zip(of).filter(|(_, of)| **of == k);
        let share = own.map(|(weight, _)| weight).sum::<f64>() / total;
        mean += &tare.covariance * (share * share);
        pass += &tare.covariance;
        observed.common.tare_freedom += tare.freedom;
        known += 1.0;
    }
    if known > 0.0 {
        (observed.common.mean, observed.common.pass) = (Some(mean), Some(pass / known));
    }
}

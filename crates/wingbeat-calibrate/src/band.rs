//! Runs as predicted, with bands.

use crate::fit::step;
use crate::solve::{PHASES, SolvedCalibration, phase_of};
use crate::uncertainty::NORMAL_95;
use crate::{Error, HarmonicLayout, ObservedCycles};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A predicted cycle with its band.
#[derive(Clone, Debug)]
pub struct Predicted {
    /// How its numbers lie.
    pub layout: HarmonicLayout,
    /// Numbers of the cycle, in the units of the channels (N and N m).
    pub cycle: Vec<f64>,
    /// Standard deviation by channel and phase of one measured cycle, in the units of the channels: estimates, noise, what the
    /// model cannot say.
    pub deviations: Vec<Vec<f64>>,
    /// The same from independent samples alone.
    pub white: Vec<Vec<f64>>,
}

impl Predicted {
    /// Share of the measured cycles' values within 95 % of `deviations`, by channel.
    pub fn coverage(&self, observed: &ObservedCycles, deviations: &[Vec<f64>]) -> Vec<f64> {
        let channel = |channel: usize| {
            let inside = |cycle: &Vec<f64>| {
                let within = |k: &usize| {
                    let measured = self.layout.value(cycle, channel, phase_of(*k));
                    let predicted = self.layout.value(&self.cycle, channel, phase_of(*k));
                    (measured - predicted).abs() <= NORMAL_95 * deviations[channel][*k]
                };
                (0..PHASES).filter(within).count()
            };
            let inside: usize = observed.cycles.iter().map(inside).sum();
            inside as f64 / (PHASES * observed.cycles.len()) as f64
        };
        (0..self.layout.channels).map(channel).collect()
    }

    /// Mean half width of the 95 % band, by channel, in the units of the channels.
    pub fn half_widths(&self) -> Vec<f64> {
        let mean = |of: &Vec<f64>| NORMAL_95 * of.iter().sum::<f64>() / of.len() as f64;
        self.deviations.iter().map(mean).collect()
    }
}

/// What the fitted runs of one layout, each left out, say of what the model cannot say.
struct Unsaid {
    /// Mean square of the error by channel and phase.
    square: Vec<Vec<f64>>,
    /// Root mean square of the load that is in doubt, by channel.
    load: Vec<f64>,
    /// Mean Jacobian.
    jacobian: DMatrix<f64>,
}

/// E s^p and E s^2p of a ratio s of loads, the power p unknown between 0, an error that stays, and 1, one in proportion:
/// (s - 1)/ln s and (s^2 - 1)/(2 ln s).
fn grown(ratio: f64) -> (f64, f64) {
    let log = ratio.ln();
    if log.abs() < 1e-6 {
        return (1.0, 1.0);
    }
    ((ratio - 1.0) / log, (ratio * ratio - 1.0) / (2.0 * log))
}

/// Squares at the phases of a cycle, smoothed to their mean and half of their first harmonic: a weight 1 + cos of the
/// distance in phase, which leaves no square negative. *Choice.*
fn smoothed(squares: &[f64]) -> Vec<f64> {
    let count = squares.len() as f64;
    let (mut mean, mut cosine, mut sine) = (0.0, 0.0, 0.0);
    for (k, square) in squares.iter().enumerate() {
        let (sin, cos) = (TAU * k as f64 / count).sin_cos();
        mean += square / count;
        cosine += square * cos / count;
        sine += square * sin / count;
    }
    let at = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / count).sin_cos();
        mean + cosine * cos + sine * sin
    };
    (0..squares.len()).map(at).collect()
}

/// 1, cos, sin, cos 2, ... of a phase.
fn waves(layout: HarmonicLayout, phase: f64) -> Vec<f64> {
    (0..layout.width()).map(|part| HarmonicLayout::wave(part, phase)).collect()
}

/// Rows of a Jacobian at a phase of a channel.
fn at_phase(layout: HarmonicLayout, jacobian: &DMatrix<f64>, channel: usize, wave: &[f64]) -> DVector<f64> {
    DVector::from_fn(jacobian.ncols(), |k, _| {
        (0..layout.width()).map(|part| wave[part] * jacobian[(layout.at(channel, part), k)]).sum()
    })
}

fn square(by: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
    (by.transpose() * covariance * by)[(0, 0)]
}

impl SolvedCalibration<'_> {
    /// The run `run` as predicted, with the deviations of a band.
    ///
    /// What the model cannot say, d at the fitted runs, moves the estimates by e; r = d + J e is what is left there. At a run with loads
    /// s times as large it is s^p d, and the error is s^p d + J'e = s^p r + (J' - s^p J) e. Its square is E s^2p times that of r, from
    /// runs left out, by channel and phase, and that of the second term over the covariance of e; the noise of estimates and of
    /// one cycle is added.
    ///
    /// Equation: calibrate.band
    /// `E s^2p r^2 + E (J' - s^p J) C (J' - s^p J)' + noise, s ratio of loads, p even in 0 to 1; r of runs left out,
    /// by channel and phase, C of the estimates from the discrepancy`
    /// Source: own; p, smoothing a choice.
    /// Test: `bands_hold_a_run_unlike_those_fitted`.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn predicted(&self, run: usize) -> Result<Predicted, Error> {
        let cycle = self.problem.model.predict(run, &self.values)?;
        let jacobian = self.problem.jacobians(&[run], &self.values)?.swap_remove(0);
        let layout = self.problem.runs[run].layout;
        let noisy = &self.covariances.clustered - &self.covariances.unsaid;
        let unsaid = self.unsaid(layout);
        let loads = self.problem.load(run);
        let samples = &self.problem.runs[run].sample_noise;
        let count = self.problem.runs[run].samples_per_cycle / layout.width() as f64;
        let (mut deviations, mut white) = (Vec::new(), Vec::new());
        for channel in 0..layout.channels {
            let observed = &self.problem.runs[run];
            // Where cycles scatter within their pass alone, the tare of the pass comes beside.
            let tare = observed.common.pass.as_ref().filter(|_| !observed.common.groups.is_empty());
            let noise = |wave: &[f64]| -> f64 {
                let one = |part: usize| {
                    let k = HarmonicLayout::harmonic(part);
                    let row = |of: &DMatrix<f64>| -> f64 {
                        let number =
                            |q: usize| wave[q] * of[(layout.at(channel, part), layout.at(channel, q))];
                        wave[part] * (0..layout.width()).map(number).sum::<f64>()
                    };
                    wave[part].powi(2) * self.problem.noise[run][k][(channel, channel)]
                        + tare.map_or(0.0, row)
                };
                (0..layout.width()).map(one).sum()
            };
            let beyond = |k: usize, own: &DVector<f64>, wave: &[f64]| -> f64 {
                let Some(Unsaid { square: left, load, jacobian }) = &unsaid else { return 0.0 };
                if load[channel] == 0.0 {
                    return 0.0;
                }
                let (once, twice) = grown((loads[channel] / load[channel]).max(f64::MIN_POSITIVE));
                let fitted = at_phase(layout, jacobian, channel, wave);
                let covariance = &self.covariances.unsaid;
                let across = (fitted.transpose() * covariance * own)[(0, 0)];
                let moved =
                    twice * square(&fitted, covariance) - 2.0 * once * across + square(own, covariance);
                twice * left[channel][k] + moved.max(0.0)
            };
            let plain =
                if samples.nrows() == layout.channels { samples[(channel, channel)] / count } else { 0.0 };
            let (mut own_deviations, mut own_white) = (Vec::new(), Vec::new());
            for k in 0..PHASES {
                let wave = waves(layout, phase_of(k));
                let own = at_phase(layout, &jacobian, channel, &wave);
                let variance = square(&own, &noisy).max(0.0) + noise(&wave) + beyond(k, &own, &wave);
                own_deviations.push(variance.sqrt());
                own_white.push((square(&own, &self.covariances.white).max(0.0) + plain).sqrt());
            }
            deviations.push(own_deviations);
            white.push(own_white);
        }
        Ok(Predicted { layout, cycle, deviations, white })
    }

    /// What is left in the fitted runs of `layout`, each left out by one step on the Jacobian of the fit; none where the model says
    /// all.
    fn unsaid(&self, layout: HarmonicLayout) -> Option<Unsaid> {
        if self.problem.discrepancy.iter().all(|share| *share == 0.0) {
            return None;
        }
        let parameters = self.problem.parameters;
        let free: Vec<usize> = (0..self.values.len()).collect();
        let alone = self.at.of.len() < 2;
        let (mut squares, mut loads) = (vec![vec![0.0; PHASES]; layout.channels], vec![0.0; layout.channels]);
        let mut jacobian = DMatrix::<f64>::zeros(layout.len(), self.values.len());
        // Runs by channel that measured it.
        let mut count = vec![0.0_f64; layout.channels];
        let fitted = self.at.of.iter().zip(&self.at.jacobians).zip(&self.at.residuals);
        for ((run, own), residual) in fitted.filter(|((run, _), _)| self.problem.runs[**run].layout == layout)
        {
            let leave = if alone { vec![] } else { vec![*run] };
            let normal = self.at.normal(parameters, &self.values, &leave);
            let values = step(&normal, 0.0, parameters, &self.values, &free);
            let moved = DVector::from_fn(values.len(), |k, _| values[k] - self.values[k]);
            let left = self.problem.coloured(*run, &(residual + own * moved));
            let is_measured = |channel: usize| self.problem.runs[*run].is_measured(channel);
            for (channel, squares) in
                squares.iter_mut().enumerate().filter(|(channel, _)| is_measured(*channel))
            {
                count[channel] += 1.0;
                for (k, square) in squares.iter_mut().enumerate() {
                    *square += layout.value(&left, channel, phase_of(k)).powi(2);
                }
            }
            for (channel, load) in
                self.problem.load(*run).into_iter().enumerate().filter(|(c, _)| is_measured(*c))
            {
                loads[channel] += load * load;
            }
            for (k, column) in own.column_iter().enumerate() {
                let plain = self.problem.coloured(*run, &column.into_owned());
                plain.iter().enumerate().for_each(|(i, x)| jacobian[(i, k)] += x);
            }
        }
        if count.iter().all(|count| *count == 0.0) {
            return None;
        }
        count.iter_mut().for_each(|count| *count = count.max(1.0));
        for (squares, count) in squares.iter_mut().zip(&count) {
            squares.iter_mut().for_each(|square| *square /= count);
        }
        let width = layout.width();
        Some(Unsaid {
            square: squares.iter().map(|squares| smoothed(squares)).collect(),
            load: loads.iter().zip(&count).map(|(sum, count)| (sum / count).sqrt()).collect(),
            jacobian: DMatrix::from_fn(layout.len(), self.values.len(), |i, k| {
                jacobian[(i, k)] / count[i / width]
            }),
        })
    }
}

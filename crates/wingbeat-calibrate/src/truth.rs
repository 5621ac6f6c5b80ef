//! Samples of a robot that is known, in place of measured ones.

use crate::Error;
use crate::measured::MeasuredPass;
use crate::rig::{RigTarget, of_six};
use std::f64::consts::TAU;
use wingbeat::math::Random;
use wingbeat::rig::cell::LoadCell;
use wingbeat::rig::{Instants, Unrest, Wrenches, rms_about_mean};
use wingbeat::scenario::TruthSpec;

/// A run of a known robot, without noise.
pub struct Clean {
    rows: Wrenches,
    begin: f64,
    step: f64,
    /// Rms of each channel about its mean while the wings beat.
    rms: [f64; 6],
}

/// Simulates the run of `target` at the rate of its cell.
///
/// # Errors
/// A model without an answer.
pub fn clean(target: &RigTarget) -> Result<Clean, Error> {
    let rig = &target.run.spec.rig;
    let step = 1.0 / rig.cell.rate_hz;
    let steps = ((rig.rest_s + target.window().1) / step).ceil() as usize + 2;
    let (robot, numbers) = target.run.adjusted(&[])?;
    let experiment = target.run.experiment(&robot, numbers, target.carrier(), 0);
    let instants = Instants { begin: -rig.rest_s, step, steps };
    let rows =
        experiment.wrenches(&instants).map_err(|fault| Error::Model { run: target.name.clone(), fault })?;
    let beating = (rig.rest_s / step) as usize..rows.len();
    // Still wings in still air stir nothing.
    let rms = if target.tilts().is_some() { [0.0; 6] } else { rms_about_mean(&rows[beating]) };
    Ok(Clean { rows, begin: -rig.rest_s, step, rms })
}

impl Clean {
    /// A pass of the run as the cell shows it: with what differs from instant to instant, resonance, noise, steps.
    ///
    /// # Errors
    /// Bad numbers of the cell.
    pub fn pass(
        &self,
        target: &RigTarget,
        truth: &TruthSpec,
        seed: u64,
        number: usize,
    ) -> Result<MeasuredPass, Error> {
        let rig = &target.run.spec.rig;
        let mut random = Random::stream(seed, 2 * number as u64);
        let first = self.rows.first().copied().unwrap_or_default();
        let mut cell =
            LoadCell::new(&rig.cell, &of_six(first), seed.wrapping_mul(1_000_003) + number as u64)?;
        let mut unrest = Unrest::new(self.step, truth.unrest_time_s);
        let mut pass = MeasuredPass {
            file: format!("{} pass {}", target.name, number + 1),
            time: Vec::with_capacity(self.rows.len()),
            phase: Vec::with_capacity(self.rows.len()),
            channels: Default::default(),
            status: Vec::new(),
            motion: None,
        };
        let rate = TAU * target.run.frequency();
        for (k, row) in self.rows.iter().enumerate() {
            let t = self.begin + k as f64 * self.step;
            let mut load = *row;
            if truth.unrest > 0.0 && t >= 0.0 {
                let noise = unrest.next(&mut random);
                (0..6).for_each(|i| load[i] += truth.unrest * self.rms[i] * noise[i]);
            }
            let reading = cell.sample(&of_six(load));
            pass.time.push(t);
            pass.phase.push(rate * ahead(t, rig.spin_up_s));
            pass.channels.iter_mut().zip(reading.values).for_each(|(channel, x)| channel.push(x));
        }
        Ok(pass)
    }
}

/// Time of the gait's clock at `t`, as the encoder of an even crank shows it; it ascends through the rest, where the
/// phase is of no use, by so little that it counts as standing.
fn ahead(t: f64, spin_up: f64) -> f64 {
    if t <= 0.0 {
        return t * 1e-9;
    }
    let s = (t / spin_up).min(1.0);
    if t >= spin_up { t - 0.5 * spin_up } else { spin_up * s * s * s * (1.0 - 0.5 * s) }
}

//! Instruments on a flight: what they read at their own times, with noise, a constant offset and a delay.

use super::{Instrument, Places, Reading};
use wingbeat_math::Random;
use wingbeat_ocp::plant::{Channel, Fault, Plant};
use wingbeat_robot::Wind;

/// Instruments on a flight, and what they have read and not yet told.
#[derive(Debug)]
pub(super) struct Fitted {
    instruments: Vec<Instrument>,
    /// Steps of the flight between readings.
    every: Vec<usize>,
    biases: Vec<f64>,
    noise: Vec<Random>,
    places: Places,
    wind: Wind,
    waiting: Vec<Reading>,
    dx: Vec<f64>,
}

impl Fitted {
    /// `instruments` of a plant whose states are `channels`, in `wind`, on a flight in steps of `step` s; noise and offsets
    /// follow `seed`. None of a plant without a body.
    pub fn new(
        instruments: Vec<Instrument>,
        channels: &[Channel],
        wind: Wind,
        step: f64,
        seed: u64,
    ) -> Option<Self> {
        let mut noise: Vec<Random> =
            (0..instruments.len()).map(|i| Random::stream(seed, 1 + i as u64)).collect();
        Some(Self {
            every: instruments.iter().map(|i| (i.every / step).round().max(1.0) as usize).collect(),
            biases: instruments.iter().zip(&mut noise).map(|(i, noise)| i.bias * noise.normal()).collect(),
            noise,
            places: Places::of(channels)?,
            wind,
            waiting: Vec::new(),
            dx: vec![0.0; channels.len()],
            instruments,
        })
    }

    /// Lets the instruments read that are due at step `k` of the flight.
    pub fn watch<P: Plant>(
        &mut self,
        k: usize,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
    ) -> Result<(), Fault> {
        if !self.every.iter().any(|every| k.is_multiple_of(*every)) {
            return Ok(());
        }
        plant.rates_in_numbers(t, x, u, &mut self.dx)?;
        let motion = self.places.motion(x, &self.dx, self.wind.at(t).0);
        for (i, instrument) in self.instruments.iter().enumerate() {
            if k.is_multiple_of(self.every[i]) {
                let error = self.biases[i] + instrument.noise * self.noise[i].normal();
                let value = instrument.reads(&motion) + error;
                self.waiting.push(Reading { instrument: i, taken: t, value });
            }
        }
        Ok(())
    }

    /// Moves what has arrived by the time `t` to `told`, in the order in which it was read.
    pub fn tell(&mut self, t: f64, told: &mut Vec<Reading>) {
        told.clear();
        let arrived =
            |reading: &Reading| reading.taken + self.instruments[reading.instrument].delay <= t + ROUNDING;
        told.extend(self.waiting.iter().copied().filter(arrived));
        let instruments = &self.instruments;
        self.waiting.retain(|r| r.taken + instruments[r.instrument].delay > t + ROUNDING);
    }
}

/// Rounding of times, s.
const ROUNDING: f64 = 1e-9;

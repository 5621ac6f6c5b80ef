//! Instruments on a flight: what they read at their own times, with noise, a constant offset and a delay.

use super::{Instrument, Places, Reading};
use crate::simulate::record::Column;
use wingbeat_math::Random;
use wingbeat_ocp::plant::{Channel, Fault, Plant};
use wingbeat_robot::Wind;

/// Instruments on a flight, and what they have read and not yet told.
#[derive(Debug)]
pub(super) struct Fitted {
    instruments: Vec<Instrument>,
    /// Columns of what each has told, without numbers.
    columns: Vec<Column>,
    /// Steps of the flight between readings.
    every: Vec<usize>,
    biases: Vec<f64>,
    noise: Vec<Random>,
    places: Places,
    wind: Wind,
    waiting: Vec<Reading>,
    /// The newest reading of each that has arrived; until one has, its first.
    newest: Vec<Reading>,
    /// Time up to which arrivals are among them, s.
    arrived_by: f64,
    /// The longest delay of all, s.
    longest_delay: f64,
    dx: Vec<f64>,
}

impl Fitted {
    /// Instruments, each with the name of its table, of a plant whose states are `channels`, in `wind`, on a flight in steps
    /// of `step` s; noise and offsets follow `seed`. None of a plant without a body.
    pub fn new(
        named: Vec<(&'static str, Instrument)>,
        channels: &[Channel],
        wind: Wind,
        step: f64,
        seed: u64,
    ) -> Option<Self> {
        let columns = named.iter().map(|(table, instrument)| column(table, instrument)).collect();
        let instruments: Vec<_> = named.into_iter().map(|(_, instrument)| instrument).collect();
        let mut noise: Vec<Random> =
            (0..instruments.len()).map(|i| Random::stream(seed, 1 + i as u64)).collect();
        Some(Self {
            every: instruments.iter().map(|i| (i.every / step).round().max(1.0) as usize).collect(),
            biases: instruments.iter().zip(&mut noise).map(|(i, noise)| i.bias * noise.normal()).collect(),
            noise,
            places: Places::of(channels)?,
            wind,
            waiting: Vec::new(),
            newest: Vec::with_capacity(instruments.len()),
            arrived_by: f64::NEG_INFINITY,
            longest_delay: instruments.iter().fold(0.0, |longest, i| f64::max(longest, i.delay)),
            dx: vec![0.0; channels.len()],
            columns,
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
                let reading = Reading { instrument: i, taken: t, value };
                self.waiting.push(reading);
                // All read at the first step.
                if self.newest.len() == i {
                    self.newest.push(reading);
                }
            }
        }
        Ok(())
    }

    /// Moves what has arrived by the time `t` to `told`, in the order in which it was read.
    pub fn tell(&mut self, t: f64, told: &mut Vec<Reading>) {
        self.hold(t);
        told.clear();
        let instruments = &self.instruments;
        told.extend(self.waiting.iter().copied().filter(|reading| has_arrived(instruments, reading, t)));
        self.waiting.retain(|reading| !has_arrived(instruments, reading, t));
    }

    /// Columns of what [`held`](Self::held) writes.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Writes over `values` the newest reading of each instrument that has arrived by the time `t`, s, in its unit; until one
    /// has, its first. Nothing before the first step.
    pub fn held(&mut self, t: f64, values: &mut Vec<f64>) {
        self.hold(t);
        values.clear();
        values.extend(self.newest.iter().map(|reading| reading.value));
    }

    /// Keeps what has arrived by the time `t`, s, as the newest: what is older than the longest delay was seen before.
    fn hold(&mut self, t: f64) {
        let seen_before = self.arrived_by - self.longest_delay;
        for reading in self.waiting.iter().rev().take_while(|reading| reading.taken >= seen_before) {
            let newest = &mut self.newest[reading.instrument];
            if reading.taken > newest.taken && has_arrived(&self.instruments, reading, t) {
                *newest = *reading;
            }
        }
        self.arrived_by = t;
    }
}

/// Whether a reading of one of `instruments` has arrived by the time `t`, s.
fn has_arrived(instruments: &[Instrument], reading: &Reading, t: f64) -> bool {
    reading.taken + instruments[reading.instrument].delay <= t + ROUNDING
}

/// Column of what an instrument of the table `table` tells; a table of the name of its one quantity is named once.
fn column(table: &str, instrument: &Instrument) -> Column {
    let quantity = &instrument.quantity;
    let name = if table == quantity.name {
        format!("reading_{table}")
    } else {
        format!("reading_{table}_{}", quantity.name)
    };
    Column::new(name, quantity.unit, quantity.frame)
}

/// Rounding of times, s.
const ROUNDING: f64 = 1e-9;

//! Several processed runs together: still air taken away, the envelope, the simulation beside it.

use super::ConfigError;
use super::rig::RigRun;
use super::rig_process::{Processed, Weighed};
use crate::Error;
use crate::plant::Fault;
use crate::rig::carrier::Carrier;
use crate::rig::cell::CHANNELS;
use crate::rig::process::{Comparison, compare, envelope};
use crate::simulate::{Column, Record};
use std::collections::BTreeMap;

/// Cycles of an envelope, side by side.
const CYCLES: usize = 3;
/// Largest difference of the flapping frequency of two runs of which one is taken away, as a share.
const SAME_FREQUENCY: f64 = 0.01;

/// What processing a run gives.
#[derive(Clone, Debug)]
pub enum Evaluated {
    /// Phase averages.
    Averaged(Box<Processed>),
    /// Mass, centre, offsets of static tilts.
    Weighed(Box<Weighed>),
}

/// A run and what processing it gave.
#[derive(Debug)]
pub struct ProcessedRun {
    /// The run.
    pub run: RigRun,
    /// What it gave.
    pub result: Evaluated,
}

/// What several runs say together.
#[derive(Clone, Debug)]
pub struct Together {
    /// Name of the run whose simulation, or else mean, stands beside the envelope.
    pub reference: String,
    /// True when that run holds the noise-free wrench of a simulation.
    pub simulated: bool,
    /// Columns `t`, `low_`, `high_` of each channel over three cycles, and `simulation_` or `mean_`.
    pub envelope: Record,
    /// Middle of the envelope against the simulation, by channel; empty where there is none.
    pub against_simulation: BTreeMap<&'static str, Comparison>,
}

impl RigRun {
    /// Weighs static tilts, averages the cycles of any other run. `window` (s) is what is averaged.
    ///
    /// # Errors
    /// Those of [`process`](Self::process) and [`weigh`](Self::weigh).
    pub fn evaluate(
        &self,
        record: Record,
        carrier: &Carrier,
        window: (f64, f64),
    ) -> Result<Result<Evaluated, Fault>, Error> {
        if self.is_weighing() {
            let weighed = self.weigh(record, carrier)?;
            return Ok(weighed.map(|weighed| Evaluated::Weighed(Box::new(weighed))));
        }
        let averaged = self.process(record, carrier, window)?;
        Ok(averaged.map(|processed| Evaluated::Averaged(Box::new(processed))))
    }
}

impl RigRun {
    /// Evaluates the samples of the run with what carried the robot: the turn is planned anew, unless `measured` says
    /// which part of it a simulation measured (begin and end, s). What was averaged is told too; the text says why a
    /// turn cannot be planned, or the samples not be evaluated.
    ///
    /// # Errors
    /// Those of [`plan`](Self::plan) and [`evaluate`](Self::evaluate).
    pub fn evaluated(
        &self,
        record: Record,
        measured: Option<(f64, f64)>,
    ) -> Result<Result<(Evaluated, (f64, f64)), String>, Error> {
        let plan = match (&self.spec.turn, measured) {
            (Some(_), None) => match self.plan()? {
                Ok(plan) => Some(plan),
                Err(refusal) => return Ok(Err(format!("limit profile {}: {refusal}", self.profile.name))),
            },
            _ => None,
        };
        let carrier = self.carrier(plan.as_ref());
        let window = self.spec.process.window_s.map(|[begin, end]| (begin, end));
        let window = window.or(measured).unwrap_or_else(|| self.window(plan.as_ref(), &carrier));
        let evaluated = self.evaluate(record, &carrier, window)?;
        Ok(evaluated.map(|evaluated| (evaluated, window)).map_err(|fault| fault.to_string()))
    }
}

impl ProcessedRun {
    /// Name of the run.
    pub fn name(&self) -> &str {
        &self.run.spec.name
    }

    /// The phase averages, if that is what it gave.
    pub fn averaged(&self) -> Option<&Processed> {
        match &self.result {
            Evaluated::Averaged(processed) => Some(processed),
            Evaluated::Weighed(_) => None,
        }
    }
}

/// Takes the average of the run in still air, `process.still_air`, away from those that ask for it.
///
/// # Errors
/// A run in still air that is not there, does not flap, or flaps at another frequency.
pub fn subtract_still_air(runs: &mut [ProcessedRun]) -> Result<(), ConfigError> {
    for index in 0..runs.len() {
        let Some(name) = runs[index].run.spec.process.still_air.clone() else { continue };
        let refused = |allowed: String| {
            runs[index].run.explain(&Error::invalid("process.still_air", format!("{name:?}"), allowed))
        };
        let found = runs.iter().position(|other| other.name() == name && other.name() != runs[index].name());
        let Some((other, still)) = found.and_then(|k| Some((&runs[k], runs[k].averaged()?))) else {
            let names: Vec<_> = runs.iter().map(ProcessedRun::name).collect();
            let names = names.join(", ");
            return Err(refused(format!("another flapping run processed with this one: {names}")));
        };
        let (own, frequency) = (runs[index].run.frequency(), other.run.frequency());
        if (own - frequency).abs() > SAME_FREQUENCY * own {
            return Err(refused(format!(
                "a run that flaps at {own} Hz, as this one; that one at {frequency} Hz"
            )));
        }
        let still = still.clone();
        if let Evaluated::Averaged(processed) = &mut runs[index].result {
            processed.subtract(&name, &still);
        }
    }
    Ok(())
}

/// The envelope over the turns (or of a run that is alone), beside the simulation of the run that says
/// `process.reference`, or else of the first; none where no run was averaged.
///
/// # Errors
/// [`Error::Invalid`] when the runs have averages of different numbers of phases.
pub fn together(runs: &[ProcessedRun]) -> Result<Option<Together>, Error> {
    let averaged: Vec<_> = runs.iter().filter_map(|one| Some((one, one.averaged()?))).collect();
    let turns: Vec<_> = averaged.iter().filter(|(one, _)| one.run.spec.turn.is_some()).copied().collect();
    let band = if turns.is_empty() && averaged.len() == 1 { averaged } else { turns };
    let asked = band.iter().find(|(one, _)| one.run.spec.process.reference);
    let Some(&(reference, black)) = asked.or(band.first()) else { return Ok(None) };
    let bins = black.cycles[0].mean.len();
    if let Some((other, p)) = band.iter().find(|(_, p)| p.cycles[0].mean.len() != bins) {
        let allowed = format!("{bins}, as in {}: {} is averaged with it", reference.name(), other.name());
        return Err(Error::invalid("process.bins", p.cycles[0].mean.len(), allowed));
    }
    let time = |k: usize| k as f64 / bins as f64 / reference.run.frequency();
    let mut columns = vec![Column::new("t", "s", "")];
    columns[0].values = (0..=CYCLES * bins).map(time).collect();
    let mut against_simulation = BTreeMap::new();
    for (i, (name, unit)) in CHANNELS.iter().enumerate() {
        let (low, high) = envelope(band.iter().map(|(_, p)| &p.cycles[i]));
        let simulation = black.truth.as_ref().map(|truth| &truth[i].mean);
        let middle: Vec<f64> = low.iter().zip(&high).map(|(a, b)| 0.5 * (a + b)).collect();
        if let Some(simulation) = simulation {
            against_simulation.insert(*name, compare(&middle, simulation));
        }
        let mean = ("mean_", &black.cycles[i].mean);
        let beside = simulation.map_or(mean, |simulation| ("simulation_", simulation));
        for (prefix, values) in [("low_", &low), ("high_", &high), beside] {
            let column = Column::new(format!("{prefix}{name}"), *unit, reference.run.processed_frame());
            let values = (0..=CYCLES * bins).map(|k| values[k % bins]).collect();
            columns.push(Column { values, ..column });
        }
    }
    Ok(Some(Together {
        reference: reference.name().into(),
        simulated: black.truth.is_some(),
        envelope: Record::new(columns, 0)?,
        against_simulation,
    }))
}

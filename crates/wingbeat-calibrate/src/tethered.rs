//! Cases of a tethered wing as a model of cycles, and their samples.

use crate::bins::Bins;
use crate::observed::{Common, RunRole};
use crate::{Error, HarmonicLayout, ObservedCycles, doctor, project};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use wingbeat::plant::Fault;
use wingbeat::scenario::{ConfigError, TetherCase};
use wingbeat::simulate::Record;

/// Columns of the loads that a case may be fitted to, in the order of the channels Fx .. Tz.
pub use wingbeat::tether::BODY_LOADS as LOADS;
/// Largest distance of a phase from a whole number of cycles that is rounding, cycles.
const ROUNDING: f64 = 1e-9;

/// A case of a tethered wing.
pub struct CaseTarget {
    /// The case.
    pub case: TetherCase,
    /// What the report calls it.
    pub name: String,
    harmonics: usize,
    known: Vec<String>,
}

impl CaseTarget {
    /// A case that is held against `harmonics` beside the mean.
    ///
    /// # Errors
    /// Too few steps in a cycle; columns that are no forces and moments in body axes.
    pub fn new(case: TetherCase, name: &str, harmonics: usize) -> Result<Self, ConfigError> {
        let steps = case.tether.clock.steps_per_cycle;
        if steps < 4 * harmonics {
            let allowed = format!("{} or more for {harmonics} harmonics", 4 * harmonics);
            return Err(case.explain(&wingbeat::Error::invalid("time.steps_per_cycle", steps, allowed)));
        }
        if let Some((ours, theirs)) =
            case.spec.compare.channels.iter().find(|(ours, _)| !LOADS.contains(&ours.as_str()))
        {
            let allowed = format!("under one of {}: a calibration fits loads in body axes", LOADS.join(", "));
            let error = wingbeat::Error::invalid(format!("compare.channels.{ours}"), theirs, allowed);
            return Err(case.explain(&error));
        }
        let known = case.named_numbers().into_iter().map(|(name, _)| name).collect();
        Ok(Self { case, name: name.into(), harmonics, known })
    }

    /// How its numbers lie.
    pub fn layout(&self) -> HarmonicLayout {
        HarmonicLayout { channels: LOADS.len(), harmonics: self.harmonics }
    }

    /// Those of the numbers that the wing has.
    fn own<'a>(&self, to: &[(&'a str, f64)]) -> Vec<(&'a str, f64)> {
        to.iter().copied().filter(|(name, _)| self.known.iter().any(|known| known == name)).collect()
    }

    fn named(&self, fault: Fault) -> Error {
        Error::Model { run: self.name.clone(), fault }
    }

    /// Numbers of the last cycle, N and N m, with these numbers of wing and air.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn predict(&self, to: &[(&str, f64)]) -> Result<Vec<f64>, Error> {
        let rows = self.case.adjusted(&self.own(to))?.last_wrenches().map_err(|fault| self.named(fault))?;
        Ok(self.layout().of_steps(&rows))
    }

    /// Derivatives of [`predict`](Self::predict) by the first `count` of the numbers, over the units of these; none depends on
    /// what a wing alone has not.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn slopes(&self, to: &[(&str, f64)], count: usize) -> Result<Vec<Vec<f64>>, Error> {
        let own = self.own(&to[..count]);
        let keys: Vec<&str> = own.iter().map(|(name, _)| *name).collect();
        let rows = self.case.differentiated(&self.own(to), &keys)?.map_err(|fault| self.named(fault))?;
        let mut found = rows.iter().map(|rows| self.layout().of_steps(rows));
        let mut one = |name: &str| match keys.contains(&name) {
            true => found.next().unwrap_or_default(),
            false => vec![0.0; self.layout().len()],
        };
        Ok(to[..count].iter().map(|(name, _)| one(name)).collect())
    }

    /// Name of the lift law that most strips and instants of the last cycle, with these numbers of wing and air, are past the angle of attack of, up
    /// to which it holds, and their share.
    ///
    /// # Errors
    /// Numbers that no wing has.
    pub fn past_law(&self, to: &[(&str, f64)]) -> Result<Option<(&'static str, f64)>, Error> {
        let run = self.case.adjusted(&self.own(to))?.run(|_| ControlFlow::Continue(()));
        let most = run.stalled.by_law().max_by(|a, b| a.1.total_cmp(&b.1));
        Ok(most.map(|(law, share)| (law.name(), share)))
    }

    /// What was measured: the whole cycles of the `files`, their names beside.
    ///
    /// # Errors
    /// Files whose columns or times do not fit the case, that hold the same samples, or no whole cycle.
    pub fn observed(
        &self,
        files: &[(String, Record)],
        role: RunRole,
        robust: bool,
    ) -> Result<ObservedCycles, Error> {
        let mut bins = Bins::new();
        let (mut cycles, mut left_out, mut samples, mut turns) = (Vec::new(), 0, 0.0, 0.0);
        let mut measured: Option<Vec<usize>> = None;
        let mut found = Vec::new();
        let mut seen: Vec<(&str, [Vec<f64>; 6])> = Vec::new();
        let mut passes: Vec<(&str, Vec<f64>)> = Vec::new();
        for (file, record) in files {
            let wrong = |what: String| Error::data(file, what);
            let (of, channels) = self.channels(record).map_err(wrong)?;
            match &measured {
                Some(first) if *first != of => {
                    return Err(wrong(format!("has other channels than {}: one case, one list", files[0].0)));
                }
                _ => measured = Some(of.clone()),
            }
            if let Some((other, _)) = seen.iter().find(|(_, same)| *same == channels) {
                return Err(wrong(format!("holds the very samples of {other}: one pass counts once")));
            }
            let phase = self.case.measured_phase(record).map_err(|error| wrong(error.to_string()))?;
            found.extend(doctor::findings(self, file, &phase, (&of, &channels)));
            let snapped = |phase: &f64| {
                let whole = phase.round();
                TAU * if (phase - whole).abs() < ROUNDING { whole } else { *phase }
            };
            let phase: Vec<f64> = phase.iter().map(snapped).collect();
            let [first, .., last] = phase.as_slice() else {
                return Err(wrong("one sample: a whole cycle is needed".into()));
            };
            let begin = (first / TAU).ceil();
            let whole = (last / TAU - begin).floor().max(0.0) as usize;
            if whole == 0 {
                let given = (last - first) / TAU;
                return Err(wrong(format!(
                    "{given:.3} cycles and no whole one from phase 0: compare.frequency_hz says the pace"
                )));
            }
            let all = (0..whole)
                .map(|cycle| project(&phase, &channels, TAU * (begin + cycle as f64), self.harmonics));
            let all: Vec<Option<Vec<f64>>> = all.collect();
            left_out += all.iter().filter(|cycle| cycle.is_none()).count();
            let own = cycles.len();
            cycles.extend(all.into_iter().flatten());
            passes.extend(mean_of(&cycles[own..]).map(|mean| (file.as_str(), mean)));
            for (k, phase) in phase.iter().enumerate() {
                bins.add(*phase, channels.each_ref().map(|channel| channel[k]));
            }
            samples += phase.len() as f64;
            turns += (last - first) / TAU;
            seen.push((file, channels));
        }
        if cycles.is_empty() {
            return Err(Error::data(&self.name, "no whole cycle in its files"));
        }
        let measured = measured.unwrap_or_default();
        found.extend(doctor::beside_other_passes(self, &measured, &passes));
        let mut observed = ObservedCycles {
            name: self.name.clone(),
            layout: self.layout(),
            cycles,
            weights: Vec::new(),
            mean: Vec::new(),
            sample_noise: bins.covariance(),
            samples_per_cycle: samples / turns,
            left_out,
            oddities: Vec::new(),
            found,
            frequency_hz: self.case.measured_frequency(),
            role,
            unmeasured: (0..LOADS.len()).filter(|channel| !measured.contains(channel)).collect(),
            common: Common::default(),
        };
        observed.weigh(robust);
        Ok(observed)
    }

    /// Numbers and values of the channels that a file has, in the units and with the signs of the loads; zeros in place of those that
    /// it has not.
    fn channels(&self, record: &Record) -> Result<(Vec<usize>, [Vec<f64>; 6]), String> {
        let mapped = self.case.channels(record).map_err(|error| error.to_string())?;
        let mut channels: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; record.rows()]);
        let mut of = Vec::new();
        for (ours, theirs) in &mapped {
            let Some(channel) = LOADS.iter().position(|load| load == ours) else { continue };
            channels[channel] = self.case.measured_values(record, ours, theirs);
            of.push(channel);
        }
        of.sort_unstable();
        if of.is_empty() {
            return Err(format!("none of {} (compare.channels)", LOADS.join(", ")));
        }
        Ok((of, channels))
    }
}

/// The mean of numbers of cycles; none of no cycle.
fn mean_of(cycles: &[Vec<f64>]) -> Option<Vec<f64>> {
    let first = cycles.first()?;
    let at = |i: usize| cycles.iter().map(|cycle| cycle[i]).sum::<f64>() / cycles.len() as f64;
    Some((0..first.len()).map(at).collect())
}

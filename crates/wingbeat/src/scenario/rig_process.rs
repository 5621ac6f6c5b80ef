//! A recorded run to phase-averaged wrenches.

use super::RigRun;
use crate::Error;
use crate::flight::{Column, Record};
use crate::plant::Fault;
use crate::rig::cell::CHANNELS;
use crate::rig::process::{
    Comparison, Corrected, Corrector, CycleAverage, PhaseSource, Samples, Steps, compare, phase_average,
    phase_of,
};

/// A processed run: six channels in the body frame.
#[derive(Clone, Debug)]
pub struct Processed {
    /// Phase averages of the measured channels.
    pub cycles: [CycleAverage; 6],
    /// Phase averages of the noise-free wrench of a simulated run.
    pub truth: Option<[CycleAverage; 6]>,
    /// Tare offsets in the cell frame.
    pub offset: [f64; 6],
    /// Drift per s in the cell frame.
    pub slope: [f64; 6],
    /// Samples with a channel at the end of its range.
    pub saturated: usize,
}

impl Processed {
    /// Measured against truth, channel by channel.
    pub fn against_truth(&self) -> Option<[Comparison; 6]> {
        let truth = self.truth.as_ref()?;
        Some(std::array::from_fn(|i| compare(&self.cycles[i].mean, &truth[i].mean)))
    }

    /// Columns: phase in cycles, then mean, low, high (and truth) of each channel.
    ///
    /// # Errors
    /// None in practice: the columns have one length and distinct names.
    pub fn record(&self) -> Result<Record, Error> {
        let bins = self.cycles[0].mean.len();
        let mut columns = vec![Column::new("cycle", "", "")];
        columns[0].values = (0..bins).map(|k| k as f64 / bins as f64).collect();
        for (i, (name, unit)) in CHANNELS.iter().enumerate() {
            let c = &self.cycles[i];
            let mut add = |prefix: &str, values: &[f64]| {
                let column = Column::new(format!("{prefix}{name}"), *unit, "B");
                columns.push(Column { values: values.to_vec(), ..column });
            };
            add("", &c.mean);
            add("low_", &c.low);
            add("high_", &c.high);
            if let Some(truth) = &self.truth {
                add("truth_", &truth[i].mean);
            }
        }
        Record::new(columns, 0)
    }
}

impl RigRun {
    /// Corrects, filters and phase-averages a record of this run over `window` (s).
    ///
    /// # Errors
    /// Missing columns, a window without a whole cycle, steps that cannot be
    /// made. A fault of the model comes back as such.
    pub fn process(&self, record: &Record, window: (f64, f64)) -> Result<Result<Processed, Fault>, Error> {
        let spec = &self.spec.process;
        let samples = Samples::from_record(record, "")?;
        let measured = match self.corrected(&samples, spec.steps)? {
            Ok(corrected) => corrected,
            Err(fault) => return Ok(Err(fault)),
        };
        let phase =
            phase_of(spec.phase, &samples.time, &samples.phase, &measured.channels[2], self.frequency())?;
        let truth = match record.column("true_Fz") {
            None => None,
            Some(_) => {
                let exact = Steps { tare: false, drift: false, cutoff_multiple: 0.0, ..spec.steps };
                match self.corrected(&Samples::from_record(record, "true_")?, exact)? {
                    Ok(corrected) => {
                        let phase = if spec.phase == PhaseSource::Encoder { &samples.phase } else { &phase };
                        Some(self.averages(&corrected, phase, window)?)
                    }
                    Err(fault) => return Ok(Err(fault)),
                }
            }
        };
        Ok(Ok(Processed {
            cycles: self.averages(&measured, &phase, window)?,
            truth,
            offset: measured.offset,
            slope: measured.slope,
            saturated: saturated(record),
        }))
    }

    fn corrected(&self, samples: &Samples, steps: Steps) -> Result<Result<Corrected, Fault>, Error> {
        let corrector = Corrector {
            robot: &self.robot,
            arm: Some(&self.arm),
            mount: &self.mount,
            steps,
            frequency: self.frequency(),
        };
        corrector.correct(samples)
    }

    fn averages(
        &self,
        corrected: &Corrected,
        phase: &[f64],
        (begin, end): (f64, f64),
    ) -> Result<[CycleAverage; 6], Error> {
        let from = corrected.time.partition_point(|t| *t < begin - 1e-9);
        let to = corrected.time.partition_point(|t| *t <= end + 1e-9);
        let mut averages: [CycleAverage; 6] = Default::default();
        for (average, channel) in averages.iter_mut().zip(&corrected.channels) {
            *average = phase_average(&phase[from..to], &channel[from..to], self.spec.process.bins)?;
        }
        Ok(averages)
    }
}

/// Rows with a channel on its limit.
fn saturated(record: &Record) -> usize {
    let columns: Vec<_> = CHANNELS.iter().filter_map(|(name, _)| record.column(name)).collect();
    let out = |row: usize| columns.iter().any(|c| c.values[row] <= c.low || c.values[row] >= c.high);
    (0..record.rows()).filter(|row| out(*row)).count()
}

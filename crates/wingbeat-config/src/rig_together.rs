//! Several processed runs together: still air taken away, the envelope, the simulation beside it.

use super::ConfigError;
use super::rig::RigRun;
use super::rig_process::{Processed, TiltWeighing};
use std::collections::BTreeMap;
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_math::{Error, require};
use wingbeat_ocp::plant::Fault;
use wingbeat_rig::carrier::ToolCarrier;
use wingbeat_rig::cell::CHANNELS;
use wingbeat_rig::process::{Comparison, CycleAverage, compare};

/// Cycles of an envelope, one after the other.
const CYCLES: f64 = 3.0;
/// Part of a stroke by which a window may end early or begin late without notice.
const NEARLY: f64 = 0.01;
/// Largest difference of the flapping frequency of two runs of which one is taken away, as a share.
const SAME_FREQUENCY: f64 = 0.01;

/// What processing a run gives.
#[derive(Clone, Debug)]
pub enum Evaluated {
    /// Phase averages.
    Averaged(Box<Processed>),
    /// Mass, centre, offsets of static tilts.
    Weighed(Box<TiltWeighing>),
}

/// What processing a run gave, with begin and end (s) of what was averaged.
pub type WindowedRun = (Evaluated, (f64, f64));

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
pub struct CombinedRuns {
    /// Name of the run whose simulation, or else mean, stands beside the envelope.
    pub reference: String,
    /// True when the model has an answer on the measured motion of that run.
    pub simulated: bool,
    /// Number of strokes drawn: three that follow each other, or as many as the windows hold.
    pub turns: f64,
    /// Columns `t`, `low_`, `high_` of each channel over these strokes, and `simulation_` where there is one.
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
        carrier: &ToolCarrier,
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
    /// A window that is none; those of [`plan`](Self::plan) and [`evaluate`](Self::evaluate).
    pub fn evaluated(
        &self,
        record: Record,
        measured: Option<(f64, f64)>,
    ) -> Result<Result<WindowedRun, String>, Error> {
        measured.map_or(Ok(()), |(begin, end)| require::range("window_s", [begin, end]))?;
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

/// What was measured over a window, by turns of the stroke.
struct Strand<'a> {
    trace: &'a Record,
    cycle: &'a [f64],
    /// First and last turn.
    begin: f64,
    end: f64,
}

impl<'a> Strand<'a> {
    fn of(trace: &'a Record) -> Option<Self> {
        let cycle = trace.values("cycle")?;
        Some(Self { trace, cycle, begin: *cycle.first()?, end: *cycle.last()? })
    }

    fn turns(&self) -> f64 {
        self.end - self.begin
    }

    /// The channel `at` turns after the first instant at which the stroke has the phase `begin` (turns). Where the window ends
    /// before, one turn earlier.
    fn value(&self, channel: &str, begin: f64, at: f64) -> f64 {
        let ahead = (begin - self.begin).rem_euclid(1.0);
        let first = if ahead > 1.0 - NEARLY { ahead - 1.0 } else { ahead };
        let mut turn = self.begin + first + at;
        while turn > self.end + NEARLY && turn - 1.0 >= self.begin {
            turn -= 1.0;
        }
        let values = self.trace.values(channel).unwrap_or(&[]);
        wingbeat_math::interpolation::piecewise_linear(self.cycle, values, turn)
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

/// The envelope over the turns (or of a run that is alone), stroke after stroke, beside the model on the measured motion of the
/// run that says `process.reference`, or else of the first; none where no run was averaged.
///
/// # Errors
/// [`Error::Invalid`] when the runs have averages of different numbers of phases.
pub fn together(runs: &[ProcessedRun]) -> Result<Option<CombinedRuns>, Error> {
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
    let Some(drawn) = DrawnStrokes::of(band.iter().map(|(_, p)| *p), black) else { return Ok(None) };
    let frequency = black.model.as_ref().map_or(reference.run.frequency(), |model| model.frequency_hz);
    let mut columns = vec![Column::new("t", "s", "")];
    columns[0].values = drawn.points.iter().map(|turn| turn / frequency).collect();
    let mut against_simulation = BTreeMap::new();
    for (i, (name, unit)) in CHANNELS.iter().enumerate() {
        let (low, high) = drawn.band(i);
        let simulation = drawn.simulation(i);
        if let Some(simulation) = &simulation {
            let middle: Vec<f64> = low.iter().zip(&high).map(|(a, b)| 0.5 * (a + b)).collect();
            against_simulation.insert(*name, compare(&middle, simulation));
        }
        let mut curves = vec![("low_", low), ("high_", high)];
        curves.extend(simulation.map(|simulation| ("simulation_", simulation)));
        for (prefix, values) in curves {
            let column = Column::new(format!("{prefix}{name}"), *unit, reference.run.processed_frame());
            columns.push(Column { values, ..column });
        }
    }
    Ok(Some(CombinedRuns {
        reference: reference.name().into(),
        simulated: drawn.model.is_some(),
        turns: drawn.turns,
        envelope: Record::new(columns, 0)?,
        against_simulation,
    }))
}

/// What is drawn of several runs: strokes that follow each other, from the phase at which the window of one run begins.
struct DrawnStrokes<'a> {
    runs: Vec<(Strand<'a>, &'a Processed)>,
    model: Option<Strand<'a>>,
    still: Option<&'a [CycleAverage; 6]>,
    /// Phase at which the strokes begin, turns.
    begin: f64,
    turns: f64,
    /// Instants, turns.
    points: Vec<f64>,
    bins: usize,
}

impl<'a> DrawnStrokes<'a> {
    fn of(runs: impl Iterator<Item = &'a Processed>, black: &'a Processed) -> Option<Self> {
        let runs: Vec<_> = runs.filter_map(|p| Some((Strand::of(&p.trace)?, p))).collect();
        let model = black.model.as_ref().and_then(|model| Strand::of(&model.trace));
        let bins = black.cycles[0].mean.len();
        let turns =
            runs.iter().map(|(strand, _)| strand).chain(&model).map(Strand::turns).fold(CYCLES, f64::min);
        Some(Self {
            still: black.model.as_ref().and_then(|model| model.still.as_ref()),
            begin: Strand::of(&black.trace)?.begin,
            points: (0..=(turns * bins as f64) as usize).map(|k| k as f64 / bins as f64).collect(),
            runs,
            model,
            turns,
            bins,
        })
    }

    /// Place in an average of the phase `at` turns after the begin.
    fn bin(&self, at: f64) -> usize {
        ((self.begin + at).rem_euclid(1.0) * self.bins as f64) as usize % self.bins
    }

    /// A channel of a strand at all points, less what is common in still air.
    fn along(&self, strand: &Strand, still: Option<&[CycleAverage; 6]>, channel: usize) -> Vec<f64> {
        let common = |at: f64| still.map_or(0.0, |still| still[channel].mean[self.bin(at)]);
        let value = |at: &f64| strand.value(CHANNELS[channel].0, self.begin, *at) - common(*at);
        self.points.iter().map(value).collect()
    }

    /// Lowest and highest value of a channel over the runs. Where samples are missing the mean of the run's cycles stands for
    /// them.
    fn band(&self, channel: usize) -> (Vec<f64>, Vec<f64>) {
        let count = self.points.len();
        let (mut low, mut high) = (vec![f64::INFINITY; count], vec![f64::NEG_INFINITY; count]);
        for (strand, p) in &self.runs {
            let values = self.along(strand, p.still.as_ref(), channel);
            for (k, value) in values.into_iter().enumerate() {
                let mean = || p.cycles[channel].mean[self.bin(self.points[k])];
                let value = if value.is_finite() { value } else { mean() };
                (low[k], high[k]) = (low[k].min(value), high[k].max(value));
            }
        }
        (low, high)
    }

    fn simulation(&self, channel: usize) -> Option<Vec<f64>> {
        self.model.as_ref().map(|strand| self.along(strand, self.still, channel))
    }
}

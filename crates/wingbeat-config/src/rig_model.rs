//! The model of a run on the motion that was measured: what stands beside the measured wrenches.

use super::RigRun;
use std::f64::consts::TAU;
use wingbeat_flight::simulate::Record;
use wingbeat_math::Error;
use wingbeat_math::{Jet, Vec3};
use wingbeat_ocp::plant::Fault;
use wingbeat_rig::Instants;
use wingbeat_rig::carrier::ToolCarrier;
use wingbeat_rig::process::{
    Comparison, CrankRipple, CycleAverage, PhaseSource, Samples, Steps, compare, phase_of, tare_line,
};

/// Steps of a stroke.
const STEPS_PER_CYCLE: f64 = 400.0;
/// Most strokes that are simulated within the window: of a longer one the first so many stand for all.
const MOST_CYCLES: f64 = 24.0;
/// Strokes simulated before the window at least, so that the air has settled, and after it, for the filter.
const BEFORE: f64 = 24.0;
const AFTER: f64 = 2.0;

/// The model of a run, simulated on measured motion and processed as the samples were.
#[derive(Clone, Debug)]
pub struct Modelled {
    /// Phase averages.
    pub cycles: [CycleAverage; 6],
    /// The window sample by sample, as of what was measured.
    pub trace: Record,
    /// Flapping frequency that was measured, Hz.
    pub frequency_hz: f64,
    /// By how much the wings are ahead of those of an even crank that begins with the run, rad; none where the phase is not
    /// measured.
    pub ahead_rad: Option<f64>,
    /// Phase averages of the model in still air that were taken away from the averages.
    pub still: Option<[CycleAverage; 6]>,
}

/// What was measured of the stroke: instants and phases (rad), and begin and end of what is averaged, s.
pub(super) struct Strokes<'a> {
    pub time: &'a [f64],
    pub phase: &'a [f64],
    /// How the crank turns unevenly within a cycle.
    pub ripple: &'a CrankRipple,
    pub window: (f64, f64),
}

impl Modelled {
    /// Measured averages against those of the model.
    pub fn against(&self, measured: &[CycleAverage; 6]) -> [Comparison; 6] {
        std::array::from_fn(|i| compare(&measured[i].mean, &self.cycles[i].mean))
    }
}

impl RigRun {
    /// The run by its model, on the motion of `carrier` and with wings that beat as they were measured to: at the mean rate
    /// of the window, within a cycle as the crank does in all. Without an encoder the crank begins with the run, and is even.
    ///
    /// # Errors
    /// Those of processing. A fault of the model comes back as such.
    pub(super) fn modelled(
        &self,
        strokes: &Strokes,
        carrier: &ToolCarrier,
    ) -> Result<Result<Modelled, Fault>, Error> {
        let (begin, end) = strokes.window;
        let rows = super::rig_process::rows(strokes.time, strokes.window);
        let even: Vec<f64> = strokes.phase[rows.clone()].iter().map(|x| strokes.ripple.even(*x)).collect();
        let (at_zero, rate) = tare_line(&strokes.time[rows], &even);
        let frequency = rate / TAU;
        let end = end.min(begin + (MOST_CYCLES + 0.5) / frequency);
        let encoder = self.spec.process.phase == PhaseSource::Encoder;
        let cranked = self.cranked();
        let own = cranked.phase(0.0);
        // The clock of the experiment loses half of the time in which the flapping starts.
        let ahead = encoder.then_some(at_zero + 0.5 * rate * self.spec.rig.spin_up_s);
        let pace = ahead.map_or(Vec::new(), |ahead| strokes.ripple.waves(rate, ahead));
        // The clock with its waves begins at 0.
        let begun = pace.iter().map(|wave| rate * wave.at(Jet::default()).x).sum::<f64>();
        let start = own + ahead.unwrap_or(0.0) + begun;
        let start = [("gait.phase_rate_rad_s", rate), ("gait.phase_rad", start)];
        let robot = cranked.with(&cranked.given(&start)?)?;
        let windy = self.robot.mean_wind() != Vec3::ZERO;
        let step = 1.0 / (STEPS_PER_CYCLE * frequency);
        let rest = if windy { self.spec.rig.rest_s } else { 16.0 * step };
        let first = (begin - BEFORE / frequency).max(-rest);
        let last = end + AFTER / frequency;
        let instants = Instants { begin: first, step, steps: ((last - first) / step).ceil() as usize };
        let mut experiment = self.experiment(&robot, self.numbers, carrier, 0);
        experiment.deviations.pace = pace;
        let wrenches = match experiment.wrenches(&instants) {
            Ok(wrenches) => wrenches,
            Err(fault) => return Ok(Err(fault)),
        };
        let time: Vec<f64> = (0..wrenches.len()).map(|k| first + k as f64 * step).collect();
        let shown: Vec<f64> = time.iter().map(|t| experiment.phase(*t) - own).collect();
        let known = if encoder { shown.clone() } else { Vec::new() };
        let channels = std::array::from_fn(|i| wrenches.iter().map(|row| row[i]).collect());
        let samples = Samples::carried(time, channels, known, carrier);
        let tare = windy && first <= -rest && self.spec.process.steps.tare;
        let steps = Steps { tare, drift: false, ..self.spec.process.steps };
        let corrected = match self.corrector(steps).correct(samples)? {
            Ok(corrected) => corrected,
            Err(fault) => return Ok(Err(fault)),
        };
        let phase = match self.spec.process.phase {
            PhaseSource::Encoder => shown,
            other => phase_of(other, &corrected.time, Vec::new(), &corrected.channels[2], frequency)?,
        };
        let window = (begin, end);
        Ok(Ok(Modelled {
            cycles: self.averages(&corrected, &phase, window)?,
            trace: self.trace(corrected, phase, window)?,
            frequency_hz: frequency,
            ahead_rad: ahead.map(|ahead| (ahead + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0),
            still: None,
        }))
    }
}

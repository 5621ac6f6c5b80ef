//! A recorded run to phase-averaged wrenches.

use super::RigRun;
use super::rig_model::{Modelled, Strokes};
use super::rig_spec::Saturated;
use super::rig_statement::statement;
use serde::Serialize;
use std::f64::consts::TAU;
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_judge::data::{Finding, MeasuredChannel, Purpose, Series, cut_off, of_few_counts, rest_scatter};
use wingbeat_judge::limits::data::{REST, REST_DRIFT};
use wingbeat_math::Error;
use wingbeat_ocp::plant::Fault;
use wingbeat_rig::JointTrajectory;
use wingbeat_rig::carrier::ToolCarrier;
use wingbeat_rig::cell::{CHANNELS, six, wrench};
use wingbeat_rig::netft::{StatusClass, classify};
use wingbeat_rig::process::{
    Comparison, Corrected, Corrector, CycleAverage, PhaseSource, RestDrift, Samples, Steps, Tilt, Weighing,
    compare, phase_average, phase_of, recorded_motion, tare_line, weigh,
};

/// Share of each attitude's time that is left out at its begin and at its end.
const SETTLING: [f64; 2] = [0.2, 0.05];
/// Motion of the arm that is kept after the window, s.
const AFTER_S: f64 = 5.0;
/// Standard errors from which a rest drifts: of sixteen means, noise reaches 5 less than once in 5000 rests (Student).
const ERRORS: f64 = 5.0;
/// Length at which forces and moments of the cell are known equally well, m: 1/64 N mm over 1/320 N.
const LEVER: f64 = 5e-3;

/// A processed run: six channels in the body frame.
#[derive(Clone, Debug)]
pub struct Processed {
    /// Phase averages of the measured channels.
    pub cycles: [CycleAverage; 6],
    /// Phase averages of the noise-free wrench of a simulated run.
    pub truth: Option<[CycleAverage; 6]>,
    /// The model on the measured motion; none where it has no answer, which the statement says.
    pub model: Option<Modelled>,
    /// Phase averages in still air that were taken away from both.
    pub still: Option<[CycleAverage; 6]>,
    /// Tare offsets in the cell frame, N and N m.
    pub offset: [f64; 6],
    /// Drift in the cell frame, N/s and N m/s.
    pub slope: [f64; 6],
    /// Samples with a channel at the end of its range.
    pub saturated: usize,
    /// What is wrong with the channels of the cell as they were recorded: too few counts, cut off, a rest that drifts.
    pub recorded: Vec<Finding>,
    /// Samples left out because the box says that they are not to be trusted.
    pub serious: usize,
    /// The window sample by sample: t, cycle (turns of the stroke), each channel unfiltered (`raw_`) and as averaged.
    pub trace: Record,
    /// What was done, step by step, in words.
    pub statement: Vec<String>,
}

/// What static tilts say of the load on the cell.
#[derive(Clone, Debug, Serialize)]
pub struct TiltWeighing {
    /// All that the cell carries.
    pub load: Weighing,
    /// The mount alone: the load less the weight of the robot by its model.
    pub mount: Weighing,
    /// How the centre of the mount moves in the cell's frame for each degree of the gait's phase by which the wings rest elsewhere than
    /// in the model, mm: no plus-minus holds it.
    pub mount_mm_per_deg: [f64; 3],
}

impl Processed {
    /// True for samples of a simulated load cell: only those come with the noise-free wrench.
    pub fn is_simulated(&self) -> bool {
        self.truth.is_some()
    }

    /// Measured against truth, channel by channel.
    pub fn against_truth(&self) -> Option<[Comparison; 6]> {
        let truth = self.truth.as_ref()?;
        Some(std::array::from_fn(|i| compare(&self.cycles[i].mean, &truth[i].mean)))
    }

    /// Measured against the model on the measured motion, channel by channel.
    pub fn against_model(&self) -> Option<[Comparison; 6]> {
        self.model.as_ref().map(|model| model.against(&self.cycles))
    }

    /// Takes the average of the run `name` in still air away.
    pub fn subtract(&mut self, name: &str, still: &Self) {
        for (cycle, common) in self.cycles.iter_mut().zip(&still.cycles) {
            cycle.subtract(common);
        }
        if let (Some(truth), Some(common)) = (&mut self.truth, &still.truth) {
            truth.iter_mut().zip(common).for_each(|(cycle, common)| cycle.subtract(common));
        }
        if let (Some(model), Some(common)) = (&mut self.model, &still.model) {
            model.cycles.iter_mut().zip(&common.cycles).for_each(|(cycle, common)| cycle.subtract(common));
            model.still = Some(common.cycles.clone());
        }
        self.still = Some(still.cycles.clone());
        self.statement.push(format!("still air: the average of {name} taken away, phase by phase"));
    }

    /// Columns: phase in cycles, then mean, low, high (and truth) of each channel.
    ///
    /// # Errors
    /// None in practice: the columns have one length and distinct names.
    pub fn record(&self, frame: &str) -> Result<Record, Error> {
        let bins = self.cycles[0].mean.len();
        let mut columns = vec![Column::new("cycle", "", "")];
        columns[0].values = (0..bins).map(|k| k as f64 / bins as f64).collect();
        for (i, (name, unit)) in CHANNELS.iter().enumerate() {
            let c = &self.cycles[i];
            let mut add = |prefix: &str, values: &[f64]| {
                let column = Column::new(format!("{prefix}{name}"), *unit, frame);
                columns.push(Column { values: values.to_vec(), ..column });
            };
            add("", &c.mean);
            add("low_", &c.low);
            add("high_", &c.high);
            if let Some(truth) = &self.truth {
                add("truth_", &truth[i].mean);
            }
            if let Some(model) = &self.model {
                add("model_", &model.cycles[i].mean);
            }
            if let Some(still) = &self.still {
                add("still_", &still[i].mean);
            }
        }
        Record::new(columns, 0)
    }
}

impl RigRun {
    /// True when the run holds the robot still in several attitudes: it is weighed, not averaged.
    pub fn is_weighing(&self) -> bool {
        self.frequency() == 0.0 && self.spec.hold.as_ref().is_some_and(|hold| hold.tilts_deg.len() > 1)
    }

    /// Frame of the processed channels.
    pub fn processed_frame(&self) -> &'static str {
        if self.spec.process.steps.body_frame { "B" } else { "C" }
    }

    /// Corrects, filters and phase-averages a record of this run over `window` (s, cut to the record).
    /// Motion that the record does not hold is that of `carrier`.
    ///
    /// # Errors
    /// Missing columns, saturated samples, a window without a whole cycle, steps that cannot be
    /// made. A fault of the model comes back as such.
    pub fn process(
        &self,
        record: Record,
        carrier: &ToolCarrier,
        window: (f64, f64),
    ) -> Result<Result<Processed, Fault>, Error> {
        let spec = &self.spec.process;
        let recorded = self.recorded_joints(&record, window);
        let recorded =
            recorded.map(|trajectory| ToolCarrier::Arm { arm: Box::new(self.arm.clone()), trajectory });
        let carrier = recorded.as_ref().unwrap_or(carrier);
        let own_motion = holds_motion(&record);
        let simulated = record.column("true_Fz").map(|_| record.clone());
        let (samples, outside) = self.samples(record, carrier, window.1)?;
        let mut found = self.as_recorded(&samples, window);
        let mut measured = match self.corrector(spec.steps).correct(samples)? {
            Ok(corrected) => corrected,
            Err(fault) => return Ok(Err(fault)),
        };
        let encoder = std::mem::take(&mut measured.phase);
        let force = &measured.channels[2];
        let phase = phase_of(spec.phase, &measured.time, encoder, force, self.frequency())?;
        self.check_sense(&measured.time, &phase, window)?;
        let truth = match simulated {
            None => None,
            Some(record) => {
                let exact = Steps { tare: false, drift: false, cutoff_multiple: 0.0, ..spec.steps };
                let mut samples = self.read(record, "true_")?;
                if !own_motion {
                    samples.carried_by(carrier);
                }
                match self.corrector(exact).correct(samples)? {
                    Ok(corrected) => Some(self.averages(&corrected, &phase, window)?),
                    Err(fault) => return Ok(Err(fault)),
                }
            }
        };
        let cycles = self.averages(&measured, &phase, window)?;
        found.extend(measured.rest.and_then(|rest| self.drifting(&rest, &cycles, window)));
        let of_record = own_motion || recorded.is_some();
        let mut statement = statement(self, &measured, &cycles[0], window, of_record);
        let strokes = Strokes { time: &measured.time, phase: &phase, ripple: &measured.ripple, window };
        let modelled = self.modelled(&strokes, carrier).map_err(|error| error.to_string());
        let model = match modelled.and_then(|answer| answer.map_err(|fault| fault.to_string())) {
            Ok(model) => Some(model),
            Err(reason) => {
                statement.push(format!("simulation: none, the model has no answer: {reason}"));
                None
            }
        };
        Ok(Ok(Processed {
            statement,
            model,
            offset: measured.offset,
            slope: measured.slope,
            trace: self.trace(measured, phase, window)?,
            cycles,
            truth,
            still: None,
            saturated: outside.saturated,
            recorded: found,
            serious: outside.serious,
        }))
    }

    /// Mass, centre and offsets (kg, m, N and N m) from a record of static tilts.
    ///
    /// # Errors
    /// Missing columns, attitudes without samples or that do not part mass from offsets.
    pub fn weigh(&self, record: Record, carrier: &ToolCarrier) -> Result<Result<TiltWeighing, Fault>, Error> {
        let Some(hold) = &self.spec.hold else {
            return Err(Error::invalid("hold", "absent", "[hold] with the attitudes"));
        };
        let end = self.duration(carrier);
        let (samples, _) = self.samples(record, carrier, end)?;
        let corrector = self.corrector(self.spec.process.steps);
        let (mut load, mut mount, mut posed) = (Vec::new(), Vec::new(), Vec::new());
        // A degree of the gait, s.
        let pace = self.robot.frequency_hz();
        let degree = if pace > 0.0 { 1.0 / (360.0 * pace) } else { 0.0 };
        for k in 0..hold.tilts_deg.len() {
            let at = |share: f64| samples.index((k as f64 + share) * hold.each_s);
            let rows = at(SETTLING[0])..at(1.0 - SETTLING[1]);
            let middle = rows.start.midpoint(rows.end);
            let whole: Vec<usize> = rows.filter(|row| samples.is_whole(*row)).collect();
            if whole.is_empty() {
                let given = format!("attitude {} from {} s", k + 1, k as f64 * hold.each_s);
                return Err(Error::invalid("hold.each_s", given, "a time for which the record has samples"));
            }
            let weight = |later: f64| corrector.robot_weight(&samples, middle, later);
            let ((robot, gravity), other) = match weight(0.0).and_then(|now| Ok((now, weight(degree)?.0))) {
                Ok(weights) => weights,
                Err(fault) => return Ok(Err(fault)),
            };
            let mean = |of: &[f64]| whole.iter().map(|row| of[*row]).sum::<f64>() / whole.len() as f64;
            let all = std::array::from_fn(|i| mean(&samples.channels[i]));
            let tilt = Tilt { time: mean(&samples.time), gravity, wrench: all };
            load.push(tilt);
            mount.push(Tilt { wrench: six(&(wrench(all) + -robot)), ..tilt });
            posed.push(Tilt { wrench: six(&(wrench(all) + -other)), ..tilt });
        }
        let drift = self.spec.process.steps.drift;
        let mount = weigh(&mount, drift, LEVER)?;
        let posed = weigh(&posed, drift, LEVER)?;
        let mount_mm_per_deg = std::array::from_fn(|i| 1e3 * (posed.com_m[i] - mount.com_m[i]));
        Ok(Ok(TiltWeighing { load: weigh(&load, drift, LEVER)?, mount, mount_mm_per_deg }))
    }

    /// The samples of a record, without those that are not to be used.
    fn samples<'a>(
        &self,
        record: Record,
        carrier: &'a ToolCarrier,
        end: f64,
    ) -> Result<(Samples<'a>, Outside), Error> {
        let own_motion = holds_motion(&record);
        let mut samples = self.read(record, "")?;
        if !own_motion {
            samples.carried_by(carrier);
        }
        let outside = self.outside(&samples.time, &samples.channels, &samples.status, end)?;
        samples.leave_out(&outside.rows);
        Ok((samples, outside))
    }

    /// The channels behind `prefix` of a record; the encoder's only where the phase is by it.
    fn read<'a>(&self, record: Record, prefix: &str) -> Result<Samples<'a>, Error> {
        let mut samples = Samples::from_record(record, prefix)?;
        if self.spec.process.phase != PhaseSource::Encoder {
            samples.phase.clear();
        }
        Ok(samples)
    }

    /// Refuses an encoder whose `phase` (rad) at the times `time` (s) goes down over the `window` (s).
    ///
    /// # Errors
    /// [`Error::Invalid`] with what turns it round.
    pub fn check_sense(&self, time: &[f64], phase: &[f64], window: (f64, f64)) -> Result<(), Error> {
        let rows = rows(time, window);
        let (_, rate) = tare_line(&time[rows.clone()], &phase[rows]);
        if !(rate < 0.0) {
            return Ok(());
        }
        let given = format!("a phase that turns at {:.4} Hz", rate / TAU);
        let allowed = "the phase of the gait, which goes ahead: a minus before the name of its column turns the encoder round, \
                       process.input.columns = {phase = \"-phase\"}";
        Err(Error::invalid("process.input.columns", given, allowed))
    }

    /// The drift of the rest that moves the tare most, where no slope is taken away.
    fn drifting(&self, rest: &RestDrift, cycles: &[CycleAverage; 6], window: (f64, f64)) -> Option<Finding> {
        let steps = self.spec.process.steps;
        let range = |of: &CycleAverage| {
            let (low, high) = of.mean.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
            high - low
        };
        let later = 0.5 * (window.0 + window.1) - rest.middle_s;
        let part = |i: usize| {
            let largest = cycles[i / 3 * 3..i / 3 * 3 + 3].iter().map(range).fold(0.0, f64::max);
            (rest.slope[i] * later).abs() / largest.max(f64::MIN_POSITIVE)
        };
        let told = (0..6).filter(|i| rest.slope[*i].abs() > ERRORS * rest.error[*i]);
        let most = told.max_by(|a, b| part(*a).total_cmp(&part(*b)))?;
        let ((name, unit), slope) = (CHANNELS[most], rest.slope[most]);
        let text = format!(
            "changes by {slope:.2e} {unit} per s in the rest, {:.0} standard errors: by the middle of what is averaged the tare is off \
             by {:.2e} {unit}, {:.0} % of the range; take the slope away, or let the cell warm up",
            (slope / rest.error[most]).abs(),
            (slope * later).abs(),
            100.0 * part(most)
        );
        let found =
            Finding::new("data.rest_drifts", &REST_DRIFT, format!("{name} of the file"), part(most), text);
        let found = found.mended_by(Some("process.steps.drift".into()));
        (steps.tare && !steps.drift && found.breaks(&self.limits)).then_some(found)
    }

    /// What of the channels in the `window` (s) has too few counts or is cut off.
    fn as_recorded(&self, samples: &Samples, window: (f64, f64)) -> Vec<Finding> {
        let rows = rows(&samples.time, window);
        let whole = rows.clone().all(|row| samples.is_whole(row));
        let kept = |of: &[f64]| -> Vec<f64> {
            rows.clone().filter(|row| samples.is_whole(*row)).map(|row| of[row]).collect()
        };
        // Long files are not copied where nothing is missing.
        let copied = if whole { Vec::new() } else { samples.channels.iter().map(|of| kept(of)).collect() };
        let of = |i: usize| copied.get(i).map_or(&samples.channels[i][rows.clone()], Vec::as_slice);
        let time = if whole { Vec::new() } else { kept(&samples.time) };
        let channels = CHANNELS.iter().enumerate();
        let series = Series {
            what: "the file",
            phase: if whole { &samples.time[rows.clone()] } else { &time },
            frequency_hz: None,
            channels: channels
                .map(|(i, (name, unit))| MeasuredChannel { name, unit, samples: of(i) })
                .collect(),
            purpose: Purpose::Loads,
        };
        let mut found = of_few_counts(&series, &self.limits);
        found.extend(cut_off(&series, &self.limits));
        found.extend(self.restless(samples, rows.clone()).filter(|finding| finding.breaks(&self.limits)));
        found
    }

    /// How the loads scatter in the rest from which the tare is taken, beside those in `rows`.
    fn restless(&self, samples: &Samples, rows: std::ops::Range<usize>) -> Option<Finding> {
        let steps = self.spec.process.steps;
        let rest = 0..samples.index(0.0);
        let of = samples.channels.iter().filter_map(|of| rest_scatter(&of[rest.clone()], &of[rows.clone()]));
        let least = of.fold(f64::INFINITY, f64::min);
        let text = format!(
            "the loads scatter there by {:.0} % of what they do in the run: the wings move in it, or the loads are noise; say when the run \
             begins, or without a rest set process.steps.tare and drift to false",
            100.0 * least
        );
        let asked = (steps.tare || steps.drift) && !rest.is_empty() && least.is_finite();
        asked.then(|| Finding::new("data.rest", &REST, "the rest of the file", least, text))
    }

    /// The motion of the arm's joints by their columns of a record, of which `window` (s) is averaged; none where one is missing.
    pub fn recorded_joints(&self, record: &Record, window: (f64, f64)) -> Option<JointTrajectory> {
        recorded_motion(record, &self.arm, window.1 + AFTER_S)
    }

    /// Samples at the end of the cell's range or with a bad status, up to `end` (s), of `channels` (N and N m) at the times `time` (s) with
    /// the words `status` (none without a box).
    ///
    /// # Errors
    /// Saturated samples, unless `process.saturated` says what becomes of them.
    pub fn outside(
        &self,
        time: &[f64],
        channels: &[Vec<f64>; 6],
        status: &[f64],
        end: f64,
    ) -> Result<Outside, Error> {
        let range = self.spec.rig.cell.calibration.range();
        let policy = self.spec.process.saturated;
        let mut outside = Outside::default();
        let mut first = None;
        for row in 0..time.partition_point(|t| *t < end - 1e-9) {
            let over = (0..6).find(|i| channels[*i][row].abs() >= range[*i] * (1.0 - 1e-9));
            let class = status.get(row).map_or(StatusClass::Good, |status| classify(*status as u32));
            if over.is_some() || class == StatusClass::Saturated {
                outside.saturated += 1;
                first = first.or(Some((row, over)));
                if policy == Saturated::LeaveOut {
                    outside.rows.push(row);
                }
            } else if class == StatusClass::Serious {
                outside.serious += 1;
                outside.rows.push(row);
            }
        }
        let (Some((row, over)), Saturated::Refuse) = (first, policy) else { return Ok(outside) };
        let channel = over.map_or("the status word", |i| CHANNELS[i].0);
        let key = format!("{} saturated samples, the first by {channel}", outside.saturated);
        let allowed = format!(
            "none within the range of {:?}: lessen the load or take a wider calibration; \
             process.saturated = leave_out leaves their cycles out, keep uses them",
            self.spec.rig.cell.calibration
        );
        Err(Error::invalid(key, format!("t {:.4} s", time[row]), allowed))
    }

    pub(super) fn corrector(&self, steps: Steps) -> Corrector<'_> {
        let frequency = self.frequency();
        Corrector { robot: self.cranked(), arm: Some(&self.arm), mount: &self.mount, steps, frequency }
    }

    pub(super) fn averages(
        &self,
        corrected: &Corrected,
        phase: &[f64],
        window: (f64, f64),
    ) -> Result<[CycleAverage; 6], Error> {
        let rows = rows(&corrected.time, window);
        if rows.is_empty() {
            let allowed = "a window with samples: of a hold hold.each_s above rig.spin_up_s";
            return Err(Error::invalid("window", format!("{:.4} to {:.4} s", window.0, window.1), allowed));
        }
        let mut averages: [CycleAverage; 6] = Default::default();
        for (average, channel) in averages.iter_mut().zip(&corrected.channels) {
            *average = phase_average(&phase[rows.clone()], &channel[rows.clone()], self.spec.process.bins)?;
        }
        Ok(averages)
    }

    /// The window sample by sample, in the memory of what was measured.
    pub(super) fn trace(
        &self,
        measured: Corrected,
        phase: Vec<f64>,
        window: (f64, f64),
    ) -> Result<Record, Error> {
        let rows = rows(&measured.time, window);
        let frame = self.processed_frame();
        let begin = phase.get(rows.start).map_or(0.0, |phase| (phase / TAU).floor());
        let cut = |mut values: Vec<f64>| {
            values.truncate(rows.end);
            values.drain(..rows.start);
            values
        };
        let mut cycle = cut(phase);
        cycle.iter_mut().for_each(|phase| *phase = *phase / TAU - begin);
        let mut columns = vec![
            Column { values: cut(measured.time), ..Column::new("t", "s", "") },
            Column { values: cycle, ..Column::new("cycle", "", "") },
        ];
        for (prefix, channels) in [("raw_", measured.unfiltered), ("", measured.channels)] {
            for ((name, unit), values) in CHANNELS.iter().zip(channels) {
                let column = Column::new(format!("{prefix}{name}"), *unit, frame);
                columns.push(Column { values: cut(values), ..column });
            }
        }
        Record::new(columns, 0)
    }
}

/// Samples that are not to be used, or not as they are.
#[derive(Clone, Debug, Default)]
pub struct Outside {
    /// Those that are left out.
    pub rows: Vec<usize>,
    /// How many have a channel at the end of its range, or a status word that says so.
    pub saturated: usize,
    /// How many others have a status word that forbids to trust them.
    pub serious: usize,
}

/// Rows of a window of time.
pub(super) fn rows(time: &[f64], (begin, end): (f64, f64)) -> std::ops::Range<usize> {
    let first = time.partition_point(|t| *t < begin - 1e-9);
    first..time.partition_point(|t| *t <= end + 1e-9).max(first)
}

/// True when the record itself says how the tool moved.
fn holds_motion(record: &Record) -> bool {
    ["ddq1", "quat_w"].iter().any(|name| record.column(name).is_some())
}

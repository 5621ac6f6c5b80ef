//! Tare, drift, weight and inertia, and the change to the body frame.

use super::clock::{CrankRipple, PhaseFit};
use crate::arm::{MAX_JOINTS, SerialArm};
use crate::carrier::{CellMount, ToolCarrier, carried_frames};
use crate::cell::{CHANNELS, six, wrench};
use crate::{FrameMotion, Pose};
use serde::{Deserialize, Serialize};
use wingbeat_flight::simulate::Record;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{GRAVITY, Jet, Quat, Vec3, Wrench, unwrapped};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::{BodyMotion, Robot};

/// Which corrections are made; each can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct Steps {
    /// Take the offset of the rest before the run away.
    pub tare: bool,
    /// Take the slope of that rest away.
    pub drift: bool,
    /// Take the weight of mount and robot away.
    pub gravity: bool,
    /// Take the inertia of the mount away.
    pub mount_inertia: bool,
    /// Take the inertia of body and wings away, at the encoder's phase: what is left is aerodynamic.
    pub robot_inertia: bool,
    /// Turn the wrench to the body frame, about the body's origin; else it stays in the cell's.
    pub body_frame: bool,
    /// Cut-off of the zero-phase filter, as a ratio to the flapping frequency; 0 leaves it out.
    pub cutoff_multiple: f64,
}

ranges!(Steps { cutoff_multiple: Range::NOT_NEGATIVE });

impl Default for Steps {
    fn default() -> Self {
        Self {
            tare: true,
            drift: true,
            gravity: true,
            mount_inertia: true,
            robot_inertia: false,
            body_frame: true,
            cutoff_multiple: 16.0,
        }
    }
}

/// Raw channels with the motion under them, one entry per sample at equal steps of
/// time. Missing samples are not-a-number.
#[derive(Clone, Debug, Default)]
pub struct Samples<'a> {
    /// Time, s; the run begins at 0, rest lies before.
    pub time: Vec<f64>,
    /// Fx .. Tz in the cell frame, N and N m.
    pub channels: [Vec<f64>; 6],
    /// Phase of the gait, rad, without jumps and gaps; empty when there is no encoder.
    pub phase: Vec<f64>,
    /// Status words of the box, bits without unit; empty when there are none.
    pub status: Vec<f64>,
    motion: ToolMotion<'a>,
}

/// Where the motion of the tool comes from.
#[derive(Clone, Debug, Default)]
enum ToolMotion<'a> {
    /// It stands upright.
    #[default]
    Still,
    /// Columns q, dq, ddq of every joint; empty where a rate is not recorded.
    Joints(Vec<[Vec<f64>; 3]>),
    /// Columns of the quaternion of a stand.
    Stand([Vec<f64>; 4]),
    /// What the run itself plans.
    Carried(&'a ToolCarrier),
}

/// Motion of the tool at one sample: of the arm's joints, or of a stand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Posture {
    Joints([Jet; MAX_JOINTS]),
    Stand(Pose<Jet>),
}

impl<'a> Samples<'a> {
    /// Takes the columns t, Fx .. Tz (or `prefix` before them), phase, status, and q, dq,
    /// ddq of the joints or the quaternion of a stand.
    ///
    /// # Errors
    /// A column that is missing, with the ones that are there.
    pub fn from_record(record: Record, prefix: &str) -> Result<Self, Error> {
        let mut columns = record.into_columns();
        let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
        let mut taken = |name: &str| {
            let index = names.iter().position(|known| known == name)?;
            Some(std::mem::take(&mut columns[index].values))
        };
        let missing =
            |name: &str| Error::invalid("record.column", name, format!("one of {}", names.join(", ")));
        let mut channels: [Vec<f64>; 6] = Default::default();
        for (channel, (name, _)) in channels.iter_mut().zip(CHANNELS) {
            let name = format!("{prefix}{name}");
            *channel = taken(&name).ok_or_else(|| missing(&name))?;
        }
        let mut joints = Vec::new();
        while let Some(q) = taken(&format!("q{}", joints.len() + 1)).filter(|_| joints.len() < MAX_JOINTS) {
            let j = joints.len() + 1;
            let rates = ["dq", "ddq"].map(|name| taken(&format!("{name}{j}")).unwrap_or_default());
            let [first, second] = rates;
            joints.push([q, first, second]);
        }
        let quaternion = ["quat_w", "quat_x", "quat_y", "quat_z"].map(|name| taken(name).unwrap_or_default());
        let motion = match (joints.is_empty(), quaternion[0].is_empty()) {
            (false, _) => ToolMotion::Joints(joints),
            (_, false) => ToolMotion::Stand(quaternion),
            _ => ToolMotion::Still,
        };
        Ok(Self {
            time: taken("t").ok_or_else(|| missing("t"))?,
            phase: taken("phase").map_or(Vec::new(), unwrapped),
            status: taken("status").unwrap_or_default(),
            motion,
            channels,
        })
    }

    /// Samples of a run that `carrier` moves: times in s, channels in N and N m, phases in rad.
    pub fn carried(
        time: Vec<f64>,
        channels: [Vec<f64>; 6],
        phase: Vec<f64>,
        carrier: &'a ToolCarrier,
    ) -> Self {
        Self { time, channels, phase, status: Vec::new(), motion: ToolMotion::Carried(carrier) }
    }

    /// The motion of the run's own carrier, where the record does not hold it.
    pub fn carried_by(&mut self, carrier: &'a ToolCarrier) {
        self.motion = ToolMotion::Carried(carrier);
    }

    fn posture(&self, row: usize) -> Posture {
        let at = |column: &[f64]| column.get(row).copied().unwrap_or(0.0);
        match &self.motion {
            ToolMotion::Still => Posture::Stand(Pose::constant(&Pose::IDENTITY)),
            ToolMotion::Joints(joints) => Posture::Joints(std::array::from_fn(|j| {
                joints.get(j).map_or(Jet::default(), |[q, dq, ddq]| Jet::new(at(q), at(dq), at(ddq)))
            })),
            ToolMotion::Stand(columns) => {
                let q = [0, 1, 2, 3].map(|i| at(&columns[i]));
                let upright = q.iter().all(|x| *x == 0.0);
                let attitude = if upright { Quat::IDENTITY } else { Quat::from_wxyz(&q) };
                Posture::Stand(Pose::constant(&Pose { rotation: attitude.matrix(), ..Pose::IDENTITY }))
            }
            ToolMotion::Carried(carrier) => {
                let t = self.time[row];
                match carrier.joints(t) {
                    Some(joints) => Posture::Joints(joints),
                    None => Posture::Stand(Pose::constant(&carrier.tool(t).values())),
                }
            }
        }
    }

    /// True when no channel misses at `row`.
    pub fn is_whole(&self, row: usize) -> bool {
        self.channels.iter().all(|channel| channel[row].is_finite())
    }

    /// Takes the samples of `rows` out: they count as missing.
    pub fn leave_out(&mut self, rows: &[usize]) {
        for channel in &mut self.channels {
            rows.iter().for_each(|row| channel[*row] = f64::NAN);
        }
    }

    /// Samples per second.
    pub fn rate(&self) -> f64 {
        let span = self.time.last().unwrap_or(&0.0) - self.time.first().unwrap_or(&0.0);
        (self.time.len().saturating_sub(1)) as f64 / span
    }

    /// Index of the first sample at or after `t`.
    pub fn index(&self, t: f64) -> usize {
        self.time.partition_point(|x| *x < t - 1e-9)
    }
}

/// The model by which weight and inertia are taken away.
#[derive(Debug)]
pub struct Corrector<'a> {
    /// The robot; still air suffices.
    pub robot: &'a Robot,
    /// The arm; none on a stand.
    pub arm: Option<&'a SerialArm>,
    /// Mount and cell.
    pub mount: &'a CellMount,
    /// What is done.
    pub steps: Steps,
    /// Flapping frequency, Hz.
    pub frequency: f64,
}

/// Wrenches of the robot in the body frame, and what was taken away.
#[derive(Clone, Debug, Default)]
pub struct Corrected {
    /// Time, s.
    pub time: Vec<f64>,
    /// Stroke phase as it was fitted, rad; empty when there is no encoder.
    pub phase: Vec<f64>,
    /// How the crank turns unevenly within a cycle; evenly without an encoder.
    pub ripple: CrankRipple,
    /// Fx .. Tz about the body origin in B (or the cell's in C), N and N m.
    pub channels: [Vec<f64>; 6],
    /// The same before the filter.
    pub unfiltered: [Vec<f64>; 6],
    /// Tare offsets of the channels in C at t = 0, N and N m.
    pub offset: [f64; 6],
    /// Drift of the channels in C, per s.
    pub slope: [f64; 6],
    /// How the channels moved in the rest, where it was tared.
    pub rest: Option<RestDrift>,
    /// Samples per second.
    pub rate: f64,
}

/// Slopes of the channels in C over the rest before the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestDrift {
    /// Per s, in N and N m.
    pub slope: [f64; 6],
    /// Standard errors of them, per s in N and N m, by the scatter of means over parts of the rest: noise that lasts counts as such.
    pub error: [f64; 6],
    /// Middle of the rest, s.
    pub middle_s: f64,
}

/// Parts of the rest whose means tell its slope. *Choice*: each lasts far longer than a period of the mains.
const PARTS: usize = 16;

impl RestDrift {
    /// Of the channels at the times `t` (s), 16 or more.
    fn of(t: &[f64], channels: &[Vec<f64>; 6]) -> Self {
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let each = t.len().div_ceil(PARTS);
        let times: Vec<f64> = t.chunks(each).map(mean).collect();
        let (middle_s, parts) = (mean(t), times.len() as f64);
        let places: f64 = times.iter().map(|t| (t - mean(&times)).powi(2)).sum();
        let one = |y: &Vec<f64>| {
            let means: Vec<f64> = y.chunks(each).map(mean).collect();
            let (at_zero, slope) = tare_line(&times, &means);
            let left: f64 = times.iter().zip(&means).map(|(t, y)| (y - at_zero - slope * t).powi(2)).sum();
            [slope, (left / (parts - 2.0).max(1.0) / places).sqrt()]
        };
        let all = channels.each_ref().map(one);
        Self { slope: all.map(|of| of[0]), error: all.map(|of| of[1]), middle_s }
    }
}

impl Corrector<'_> {
    /// Corrects, turns and filters the samples, in their own memory as far as that goes: there may be millions.
    ///
    /// # Errors
    /// No rest before the run although tare or drift is asked for; a cut-off
    /// above half the rate. Faults of the model come back as such.
    pub fn correct(&self, mut samples: Samples) -> Result<Result<Corrected, Fault>, Error> {
        let mut out = Corrected { rate: samples.rate(), ..Default::default() };
        let mut memory = ModelMemory { fit: self.fitted(&samples), ..Default::default() };
        if (self.steps.tare || self.steps.drift)
            && let Err(fault) = self.tare(&samples, &mut memory, &mut out)?
        {
            return Ok(Err(fault));
        }
        if memory.fit.is_some() {
            out.phase.reserve_exact(samples.phase.len());
        }
        for row in 0..samples.time.len() {
            out.phase.extend(memory.phase(row).map(|phase| phase.x));
            if !samples.is_whole(row) {
                samples.channels.iter_mut().for_each(|channel| channel[row] = f64::NAN);
                continue;
            }
            let model = match self.model(&samples, row, &mut memory) {
                Ok(model) => six(&model.removed),
                Err(fault) => return Ok(Err(fault)),
            };
            let t = samples.time[row];
            let raw = std::array::from_fn(|i| {
                samples.channels[i][row] - out.offset[i] - out.slope[i] * t - model[i]
            });
            let turned = if self.steps.body_frame { six(&self.mount.to_body(&wrench(raw))) } else { raw };
            for (channel, value) in samples.channels.iter_mut().zip(turned) {
                channel[row] = value;
            }
        }
        if self.steps.cutoff_multiple > 0.0 && self.frequency > 0.0 {
            let cutoff = self.steps.cutoff_multiple * self.frequency;
            let filter = super::Butterworth::new(cutoff, out.rate)?;
            out.channels = samples.channels.each_ref().map(|channel| filter.apply_between_gaps(channel));
        } else {
            out.channels = samples.channels.clone();
        }
        match memory.fit {
            Some(fit) => out.ripple = fit.ripple,
            None => out.phase = samples.phase,
        }
        (out.time, out.unfiltered) = (samples.time, samples.channels);
        Ok(Ok(out))
    }

    /// Offset and slope of each channel over the rest, less the weight that the model expects there.
    fn tare(
        &self,
        samples: &Samples,
        memory: &mut ModelMemory,
        out: &mut Corrected,
    ) -> Result<Result<(), Fault>, Error> {
        let rest = samples.index(0.0);
        // The filter and resonance of the box settle within the first part of the rest.
        let rows: Vec<usize> = (rest / 8..rest).filter(|row| samples.is_whole(*row)).collect();
        if rows.len() < 16 {
            return Err(Error::invalid(
                "record.t",
                format!("{} samples before 0", rows.len()),
                "a rest of 16 samples or more for the tare: process.input.start_s says when the run begins; \
                 without a rest set process.steps.tare and drift to false",
            ));
        }
        let time: Vec<f64> = rows.iter().map(|row| samples.time[*row]).collect();
        let mut unloaded: [Vec<f64>; 6] = Default::default();
        for row in &rows {
            let weight = match self.model(samples, *row, memory) {
                Ok(model) => six(&model.weight),
                Err(fault) => return Ok(Err(fault)),
            };
            for (i, y) in unloaded.iter_mut().enumerate() {
                y.push(samples.channels[i][*row] - weight[i]);
            }
        }
        out.rest = Some(RestDrift::of(&time, &unloaded));
        for (i, y) in unloaded.iter().enumerate() {
            let (offset, slope) = tare_line(&time, y);
            if self.steps.drift {
                (out.offset[i], out.slope[i]) = (offset, slope);
            } else {
                out.offset[i] = y.iter().sum::<f64>() / y.len() as f64;
            }
        }
        Ok(Ok(()))
    }

    /// What the model says of a sample; that of the last one where posture and clock are the same.
    fn model(
        &self,
        samples: &Samples,
        row: usize,
        memory: &mut ModelMemory,
    ) -> Result<ModelledSample, Fault> {
        let asked = (samples.posture(row), self.clock(memory.phase(row)));
        match &memory.last {
            Some((same, model)) if *same == asked => Ok(*model),
            _ => {
                let model = self.new_model(&asked, memory)?;
                memory.last = Some((asked, model));
                Ok(model)
            }
        }
    }

    fn new_model(
        &self,
        (posture, clock): &(Posture, Jet),
        memory: &mut ModelMemory,
    ) -> Result<ModelledSample, Fault> {
        let (cell, body) = carried_frames(&self.tool(posture), self.mount);
        let loads = self.robot_loads(&body, *clock, memory)?;
        let still = FrameMotion {
            velocity: Default::default(),
            acceleration: Default::default(),
            rate: Default::default(),
            angular_acceleration: Default::default(),
            ..cell
        };
        let mount_weight = self.mount.wrench(&still);
        let mount_inertia = self.mount.wrench(&cell) + -mount_weight;
        let weight = self.mount.to_cell(&loads.0) + mount_weight;
        let mut removed = Wrench::ZERO;
        if self.steps.gravity {
            removed += weight;
        }
        if self.steps.mount_inertia {
            removed += mount_inertia;
        }
        if self.steps.robot_inertia {
            removed += self.mount.to_cell(&loads.1);
        }
        Ok(ModelledSample { weight, removed })
    }

    /// The gait's clock, s, with its rate and the slope of that: where the encoder shows 0 the wings are at `gait.phase_rad`. Without an
    /// encoder they are there throughout.
    fn clock(&self, phase: Option<Jet>) -> Jet {
        let per_s = std::f64::consts::TAU * self.frequency;
        phase.map_or(Jet::default(), |phase| phase / per_s)
    }

    /// The fit of the encoder's phase; none without one, or where the wings are still.
    fn fitted(&self, samples: &Samples) -> Option<PhaseFit> {
        let many = samples.phase.len();
        let even = many == samples.time.len();
        even.then(|| PhaseFit::new(&samples.phase, 1.0 / samples.rate(), self.frequency))?
    }

    /// Weight of the robot at `row`, in C, its gait's clock `later` (s), and the direction of gravity, m/s2 in C.
    ///
    /// # Errors
    /// Faults of the model.
    pub fn robot_weight(
        &self,
        samples: &Samples,
        row: usize,
        later: f64,
    ) -> Result<(Wrench<f64>, Vec3), Fault> {
        let (cell, body) = carried_frames(&self.tool(&samples.posture(row)), self.mount);
        let mut memory = ModelMemory { fit: self.fitted(samples), ..Default::default() };
        let clock = self.clock(memory.phase(row)) + later;
        let loads = self.robot_loads(&body, clock, &mut memory)?;
        let down = cell.pose.rotation.transpose_mul(Vec3([0.0, 0.0, -GRAVITY]));
        Ok((self.mount.to_cell(&loads.0), down))
    }

    fn tool(&self, posture: &Posture) -> Pose<Jet> {
        match (posture, self.arm) {
            (Posture::Joints(q), Some(arm)) => arm.tool_pose(q),
            (Posture::Joints(_), None) => Pose::constant(&Pose::IDENTITY),
            (Posture::Stand(pose), _) => *pose,
        }
    }

    /// Weight and inertia of the robot about the body origin, in B.
    fn robot_loads(
        &self,
        body: &FrameMotion,
        clock: Jet,
        memory: &mut ModelMemory,
    ) -> Result<(Wrench<f64>, Wrench<f64>), Fault> {
        if memory.x.len() != self.robot.carried_states() {
            memory.x = self.robot.carried_still();
        }
        memory.u.resize(self.robot.inputs().len(), 0.0);
        memory.dx.resize(memory.x.len(), 0.0);
        let ModelMemory { x, u, dx, .. } = memory;
        let loads = self.robot.carried_in_numbers(&clock, &BodyMotion::from(body), x, u, dx)?;
        Ok((loads.gravity, loads.inertia))
    }
}

/// What is kept from sample to sample: room for the model's states, and its last answer.
#[derive(Debug, Default)]
struct ModelMemory {
    x: Vec<f64>,
    u: Vec<f64>,
    dx: Vec<f64>,
    last: Option<((Posture, Jet), ModelledSample)>,
    fit: Option<PhaseFit>,
    /// The phase of one row.
    phase: Option<(usize, Jet)>,
}

impl ModelMemory {
    /// The phase of the stroke at `row`, with its rates; none without an encoder.
    fn phase(&mut self, row: usize) -> Option<Jet> {
        let fit = self.fit.as_ref()?;
        match self.phase {
            Some((of, phase)) if of == row => Some(phase),
            _ => {
                let phase = fit.at(row);
                self.phase = Some((row, phase));
                Some(phase)
            }
        }
    }
}

/// What the model says of one sample, in C.
#[derive(Clone, Copy, Debug)]
struct ModelledSample {
    weight: Wrench<f64>,
    removed: Wrench<f64>,
}

/// Least-squares line through (t, y): value at t = 0 and slope, in the unit of y and that per s.
pub fn tare_line(t: &[f64], y: &[f64]) -> (f64, f64) {
    let n = t.len() as f64;
    let (mt, my) = (t.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (mut tt, mut ty) = (0.0, 0.0);
    for (t, y) in t.iter().zip(y) {
        tt += (t - mt) * (t - mt);
        ty += (t - mt) * (y - my);
    }
    let slope = if tt > 0.0 { ty / tt } else { 0.0 };
    (my - slope * mt, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Random;

    #[test]
    fn a_rest_that_drifts_is_told_from_one_that_hums() {
        let t: Vec<f64> = (0..14_000).map(|k| k as f64 / 7000.0 - 2.0).collect();
        let mut random = Random::stream(7, 0);
        let mut channel = |slope: f64| -> Vec<f64> {
            t.iter().map(|t| slope * t + 3e-3 * random.normal() + 0.05 * (314.0 * t).sin()).collect()
        };
        let channels = [0.01, 0.0, 0.0, -0.02, 0.0, 0.0].map(&mut channel);
        let rest = RestDrift::of(&t, &channels);
        assert!((rest.slope[0] - 0.01).abs() < 2e-3 && (rest.slope[3] + 0.02).abs() < 2e-3, "{rest:?}");
        let ratio = |i: usize| (rest.slope[i] / rest.error[i]).abs();
        assert!(ratio(0) > 8.0 && ratio(3) > 8.0 && [1, 2, 4, 5].iter().all(|i| ratio(*i) < 5.0), "{rest:?}");
        assert!((rest.middle_s + 1.0).abs() < 1e-3);
    }
}

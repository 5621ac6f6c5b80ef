//! One run on the rig: the carried robot, the cell, and the record of both.

use super::carrier::{CellMount, ToolCarrier};
use super::cell::{CHANNELS, CellSpec, LoadCell, six, wrench};
use super::numbers::RigNumbers;
use super::{BenchDeviations, FrameMotion, Pose, Unrest};
use std::ops::ControlFlow;
use wingbeat_flight::simulate::{
    AirCoupling, Bears, Beyond, Column, Ending, Flow, Held, Moment, Observed, Record, Sizes, Steers, Stepper,
    System, pin_columns, step_in,
};
use wingbeat_math::Error;
use wingbeat_math::{Jet, Mat3, Quat, Random, Scalar, Wrench};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::{BeyondLoads, Deflections, MotorWork};
use wingbeat_robot::{BodyMotion, CarriedLoads, Compiled, Robot, StallCount, Stance};

/// A run ready to be simulated.
#[derive(Clone, Debug)]
pub struct Experiment<'a> {
    /// The robot in its air; its gait begins at t = 0.
    pub robot: &'a Robot,
    /// What carries it.
    pub carrier: &'a ToolCarrier,
    /// Cell and mount as drawn.
    pub mount: &'a CellMount,
    /// Mount and crank as they are.
    pub numbers: RigNumbers,
    /// Properties of the cell.
    pub cell: &'a CellSpec,
    /// Seed of the noise.
    pub seed: u64,
    /// Time before the motion with the robot at rest in the starting pose, s: the tare.
    pub rest: f64,
    /// Duration after the rest, s.
    pub duration: f64,
    /// Whether the wings flap after the rest; at rest they hold the starting phase.
    pub flapping: bool,
    /// Time over which the flapping starts, s.
    pub spin_up: f64,
    /// What the run does that its files do not say.
    pub deviations: BenchDeviations,
}

/// Columns of what the motor does.
const MOTOR: [(&str, &str); 4] =
    [("crank_rate", "rad/s"), ("motor_torque", "N m"), ("motor_power", "W"), ("electrical_power", "W")];
/// The stream of the loads' unrest among those of a seed.
const UNREST: u64 = 1;

/// What a run gave.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Columns: time, phase, joints, cell readings (frame C), noise-free wrenches.
    pub record: Record,
    /// Samples with a saturated channel.
    pub saturated: usize,
    /// Strips and samples after the rest by their angles of attack.
    pub stalled: StallCount,
    /// Largest deflections after the rest.
    pub deflections: Deflections,
    /// Heights over the chord of the strips of each membrane after the rest, dimensionless.
    pub heights: Vec<Vec<[f64; 2]>>,
    /// How the robot and the air that was stepped beside it were brought together.
    pub coupling: Option<AirCoupling>,
}

/// Loads of one instant, without noise.
#[derive(Clone, Copy, Debug)]
pub struct CellLoads {
    /// What the cell feels, about its origin, in C, N and N m.
    pub wrench: Wrench<f64>,
    /// Of the air, about the body origin, in B, N and N m.
    pub air: Wrench<f64>,
    /// Of the inertia of body and links, about the body origin, in B, N and N m.
    pub inertia: Wrench<f64>,
    /// Phase of the gait, rad.
    pub phase: f64,
    /// What the motor does, where one turns the crank.
    pub motor: Option<MotorWork>,
    /// The strips by their angles of attack.
    pub stalled: StallCount,
    /// How far what is soft gives way.
    pub deflections: Deflections,
}

/// How often membranes are looked at, as the records of flights are, Hz. *Choice.*
const LOOKS_HZ: f64 = 1000.0;
/// Instants at which they are, at most. *Choice.*
const MOST_LOOKS: usize = 100_000;

/// A state with the loads of the air from beyond the robot's models.
type At<'a> = (f64, (&'a [f64], &'a [f64]), &'a BeyondLoads);

impl Experiment<'_> {
    /// Simulates the run sample by sample at the cell's rate, in the air `flow` if there is one; `progress` sees the share done.
    ///
    /// # Errors
    /// Bad numbers of the cell; a fault of the model comes back with its time.
    pub fn simulate(
        &self,
        flow: Option<&mut dyn Flow>,
        mut progress: impl FnMut(f64),
    ) -> Result<Result<Outcome, Fault>, Error> {
        self.cell.check()?;
        let step = 1.0 / self.cell.rate_hz;
        let samples = self.samples();
        let mut record = Record::new(self.columns(), samples + 1)?;
        let mut row = Vec::new();
        let (mut saturated, mut stalled, mut deflections) =
            (0, StallCount::default(), Deflections::default());
        let mut heights = vec![Vec::new(); self.robot.surfaces().count()];
        let bent = self.robot.bent_states();
        let thin = ((self.cell.rate_hz / LOOKS_HZ) as usize).max(samples / MOST_LOOKS + 1);
        let begun = match self.still(self.robot, (&self.numbers.mount(self.mount), &self.numbers), -self.rest)
        {
            Ok(x) => x,
            Err(fault) => return Ok(Err(fault)),
        };
        let mut cell = LoadCell::new(self.cell, &Wrench::ZERO, self.seed)?;
        let mut random = Random::stream(self.seed, UNREST);
        let mut unrest = Unrest::new(step, self.deviations.unrest_time_s);
        let mut measure = |k: usize, (t, states, beyond): At| {
            let now = self.look((t, states, beyond))?;
            let mut load = now.wrench;
            if self.deviations.is_restless() && t >= 0.0 {
                let noise = unrest.next(&mut random);
                load += wrench(std::array::from_fn(|i| noise[i] * self.deviations.unrest[i]));
            }
            if t >= 0.0 {
                stalled.add(&now.stalled);
                deflections = deflections.largest(now.deflections);
                if k.is_multiple_of(thin) {
                    let now = self.robot.membrane_heights(states.0);
                    heights.iter_mut().zip(now).for_each(|(all, now)| all.extend(now));
                }
            }
            if k == 0 {
                cell.rest(&now.wrench);
            }
            let reading = cell.sample(&load);
            saturated += usize::from(reading.saturated);
            self.fill(&mut row, t, &now, &reading.values, bent.iter().map(|i| states.0[*i]));
            if self.robot.has_pin_springs() {
                let (_, clock, _) = self.motion(&self.numbers.mount(self.mount), &self.numbers, t);
                let pins = self.robot.carried_pins(&clock, states)?;
                row.extend(&pins.angles);
                row.push(pins.by_wing[0] + pins.by_wing[1]);
            }
            record.append_finite(&row)?;
            if k.is_multiple_of(512) {
                progress(k as f64 / samples as f64);
            }
            Ok(ControlFlow::Continue(()))
        };
        let (ending, coupling) = match flow {
            None => {
                let mut watched =
                    Held(|k: usize, at: Moment| measure(k, (at.t, (at.x, at.u), &BeyondLoads::NONE)));
                (Stepper::new(self, -self.rest, &begun).run(step, samples, &mut watched), None)
            }
            Some(flow) => {
                let beside = CoupledRun(self);
                let mut stepper = Stepper::new(&beside, -self.rest, &begun);
                let (ending, coupling) =
                    step_in(flow, &mut stepper, (step, samples), &mut WatchedRun(measure));
                (ending, Some(coupling))
            }
        };
        match ending {
            Ending::Fault(fault) => Ok(Err(fault)),
            Ending::Complete | Ending::Stopped => {
                Ok(Ok(Outcome { record, saturated, stalled, deflections, heights, coupling }))
            }
        }
    }

    /// Samples after the first.
    pub fn samples(&self) -> usize {
        ((self.rest + self.duration) * self.cell.rate_hz).round() as usize
    }

    /// Phase of the gait at `t`, rad, of a crank without a motor.
    pub fn phase(&self, t: f64) -> f64 {
        self.robot.phase(self.clock(t).x)
    }

    /// The gait's clock at `t`, with the pace of the crank; its rate is a motor's share of its supply voltage.
    fn clock(&self, t: f64) -> Jet {
        self.deviations.clock(self.even_clock(t))
    }

    /// The clock of an even crank: at rest before the start, then running up
    /// smoothly (rate 3 s^2 - 2 s^3) to the pace of time.
    fn even_clock(&self, t: f64) -> Jet {
        if !self.flapping || t <= 0.0 {
            return Jet::default();
        }
        if t >= self.spin_up {
            return Jet::new(t - 0.5 * self.spin_up, 1.0, 0.0);
        }
        let s = t / self.spin_up;
        let time = self.spin_up * s * s * s * (1.0 - 0.5 * s);
        Jet::new(time, s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / self.spin_up)
    }

    /// The states of `robot` on `mount` that begins at `t`, in still air.
    pub(super) fn still<S: Scalar>(
        &self,
        robot: &Robot<S>,
        (mount, numbers): (&CellMount<S>, &RigNumbers<S>),
        t: f64,
    ) -> Result<Vec<S>, Fault> {
        let mut x = robot.carried_still();
        let (_, clock, body) = self.motion(mount, numbers, t);
        let inputs = vec![S::ZERO; self.robot.inputs().len()];
        robot.settle_carried(&clock, &body, &mut x, &inputs)?;
        Ok(x)
    }

    /// Loads of `robot` on `mount` at `t`, and the motion of the cell; what both carry derivatives of.
    pub(super) fn carried<S: Compiled>(
        &self,
        robot: &Robot<S>,
        (mount, numbers): (&CellMount<S>, &RigNumbers<S>),
        (t, x, u): (f64, &[S], &[S]),
        dx: &mut [S],
    ) -> Result<(FrameMotion, CarriedLoads<S>), Fault> {
        let (cell, clock, body) = self.motion(mount, numbers, t);
        let loads = S::carried(robot, &clock, &body, x, u, dx)?;
        Ok((cell, loads))
    }

    /// Motion of the cell, clock of the gait and motion of the body at `t`.
    fn motion<S: Scalar>(
        &self,
        mount: &CellMount<S>,
        numbers: &RigNumbers<S>,
        t: f64,
    ) -> (FrameMotion, Jet<S>, BodyMotion<S>) {
        let cell = FrameMotion::from_jets(&(self.carrier.tool(t) * Pose::constant(&mount.cell)));
        let clock = numbers.rippled(self.clock(t), std::f64::consts::TAU * self.robot.frequency_hz());
        (cell, clock, mount.body_motion(&cell))
    }

    /// Loads of the robot on the mount as they are, the loads `beyond` included.
    fn carried_now(
        &self,
        (t, states, beyond): At,
        dx: &mut [f64],
    ) -> Result<(FrameMotion, CellMount, CarriedLoads), Fault> {
        let mount = self.numbers.mount(self.mount);
        let (cell, clock, body) = self.motion(&mount, &self.numbers, t);
        let loads = self.robot.carried_beyond(&clock, &body, states, beyond, dx)?;
        Ok((cell, mount, loads))
    }

    /// Looks at the run under loads from beyond.
    fn look(&self, at: At) -> Result<CellLoads, Fault> {
        let (t, (x, _), _) = at;
        let (cell, mount, loads) = self.carried_now(at, &mut vec![0.0; x.len()])?;
        let wrench = mount.to_cell(&loads.total()) + mount.wrench(&cell);
        let (phase, motor) = self.robot.carried_crank(&self.clock(t), x);
        let air = loads.air.total() + loads.body_drag;
        let CarriedLoads { inertia, stalled, deflections, .. } = loads;
        Ok(CellLoads { wrench, air, inertia, phase, motor, stalled, deflections })
    }

    fn columns(&self) -> Vec<Column> {
        let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "rad", "")];
        let joints = self.carrier.joints(0.0).map_or(0, |_| self.dof());
        for (prefix, unit) in [("q", "rad"), ("dq", "rad/s"), ("ddq", "rad/s2")] {
            columns.extend((1..=joints).map(|j| Column::new(format!("{prefix}{j}"), unit, "")));
        }
        if joints == 0 {
            columns.extend(["w", "x", "y", "z"].map(|c| Column::new(format!("quat_{c}"), "", "WT")));
        }
        let range = self.cell.calibration.range();
        for (i, (name, unit)) in CHANNELS.iter().enumerate() {
            let mut column = Column::new(*name, *unit, "C");
            (column.low, column.high) = (-range[i], range[i]);
            columns.push(column);
        }
        for (prefix, frame) in [("true", "C"), ("air", "B"), ("inertia", "B")] {
            columns.extend(CHANNELS.map(|(name, unit)| Column::new(format!("{prefix}_{name}"), unit, frame)));
        }
        let bent = self.robot.bent_states().into_iter();
        columns.extend(bent.map(|i| Column::from(&self.robot.states()[self.robot.layout().structure + i])));
        if self.robot.motor().is_some() {
            columns.extend(MOTOR.map(|(name, unit)| Column::new(name, unit, "")));
        }
        columns.extend(pin_columns(self.robot));
        columns
    }

    fn dof(&self) -> usize {
        match self.carrier {
            ToolCarrier::Arm { arm, .. } => arm.dof(),
            ToolCarrier::Stand { .. } => 0,
        }
    }

    fn fill(
        &self,
        row: &mut Vec<f64>,
        t: f64,
        now: &CellLoads,
        reading: &[f64; 6],
        bent: impl Iterator<Item = f64>,
    ) {
        row.clear();
        // An encoder shows 0 where the wings are at `gait.phase_rad`.
        row.extend([t, now.phase - self.robot.phase(0.0) + self.deviations.encoder_rad]);
        match self.carrier.joints(t) {
            Some(q) => {
                let q = &q[..self.dof()];
                row.extend(q.iter().map(|j| j.x).chain(q.iter().map(|j| j.d)).chain(q.iter().map(|j| j.dd)));
            }
            None => row.extend(quaternion(&self.carrier.tool(t).values().rotation)),
        }
        row.extend(reading);
        row.extend(six(&now.wrench).into_iter().chain(six(&now.air)).chain(six(&now.inertia)));
        row.extend(bent);
        row.extend(
            now.motor.iter().flat_map(|m| [m.crank_rate, m.shaft_torque, m.shaft_power, m.electrical_power]),
        );
    }
}

impl System for Experiment<'_> {
    type Memory = ();

    fn sizes(&self) -> Sizes {
        Sizes { states: self.robot.carried_states(), inputs: self.robot.inputs().len() }
    }
    fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
        self.carried_now((at.t, (at.x, at.u), &BeyondLoads::NONE), dx).map(|_| ())
    }
}

impl Observed for Experiment<'_> {
    type Observation = CellLoads;

    fn observed(&self, at: Moment) -> Result<CellLoads, Fault> {
        self.look((at.t, (at.x, at.u), &BeyondLoads::NONE))
    }
}

/// A run with loads of the air beside it in its memory.
struct CoupledRun<'a>(&'a Experiment<'a>);

impl System for CoupledRun<'_> {
    type Memory = Beyond;

    fn sizes(&self) -> Sizes {
        self.0.sizes()
    }
    fn slope(&self, at: Moment<Beyond>, dx: &mut [f64]) -> Result<(), Fault> {
        self.0.carried_now((at.t, (at.x, at.u), &at.memory.at(at.t)), dx).map(|_| ())
    }
}

impl Bears for CoupledRun<'_> {
    fn robot(&self) -> &Robot {
        self.0.robot
    }
    fn stance(&self, t: f64, x: &[f64], u: &[f64], beyond: &BeyondLoads) -> Result<Stance, Fault> {
        let (mount, robot) = (self.0.numbers.mount(self.0.mount), self.0.robot);
        let (cell, clock, body) = self.0.motion(&mount, &self.0.numbers, t);
        let stance = robot.carried_stance(&clock, cell.pose.point(mount.body.origin), &body, x);
        if !robot.has_bent_chords() {
            return Ok(stance);
        }
        let (mut dx, air) = (vec![0.0; x.len()], robot.layout().aero - robot.layout().structure);
        self.0.carried_now((t, (x, u), beyond), &mut dx)?;
        Ok(robot.bent_as(stance, (&x[air..], &dx[air..])))
    }
    fn attached_loads(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &BeyondLoads,
    ) -> Result<BeyondLoads, Fault> {
        let mount = self.0.numbers.mount(self.0.mount);
        let (_, clock, body) = self.0.motion(&mount, &self.0.numbers, t);
        self.0.robot.carried_attached_loads(&clock, &body, (x, u), beyond)
    }
}

/// A run is watched and not steered.
struct WatchedRun<F>(F);

impl<F: FnMut(usize, At) -> Result<ControlFlow<()>, Fault>> Steers for WatchedRun<F> {
    fn see(
        &mut self,
        k: usize,
        (t, x, u): (f64, &[f64], &[f64]),
        beyond: &BeyondLoads,
    ) -> Result<ControlFlow<()>, Fault> {
        (self.0)(k, (t, (x, u), beyond))
    }
}

/// w, x, y, z of a rotation.
fn quaternion(r: &Mat3) -> [f64; 4] {
    let q = Quat::exp(super::rotation_vector(r));
    [q.w, q.v[0], q.v[1], q.v[2]]
}

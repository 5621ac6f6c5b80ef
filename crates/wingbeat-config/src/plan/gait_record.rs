//! A gait on the stand as simulated from rest: the whole robot, both wings.

use crate::recorder::{joint_columns, source_columns, source_values};
use std::ops::ControlFlow;
use wingbeat_flight::guide::{CYCLES, Flapping, Means, Stand};
use wingbeat_flight::simulate::{Column, Driver, Moment, Observed, Record, Sizes, Stepper, System};
use wingbeat_math::Error;
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::body::drive_power;
use wingbeat_robot::{CarriedLoads, MAX_ELEMENTS, StallCount};

/// Runge-Kutta steps and samples per cycle.
const STEPS: usize = 2000;
const SAMPLES: usize = 400;
/// Columns of the robot's own gait that stand beside the plan's.
const BESIDE: [&str; 9] = [
    "sweep_left",
    "shoulder_left",
    "elbow_left",
    "twist_left",
    "joint_power",
    "drive_power",
    "power_to_air",
    "force_up",
    "force_forward",
];

/// Column of the share of the strips past stall.
const STALLED: &str = "stalled_share";

/// A gait on a stand with its commands.
pub(super) struct Replay<'a> {
    pub stand: &'a Stand<'a>,
    pub flapping: Flapping,
    /// Writes the commands of one wing at the time since the cycle began, s.
    pub commands: &'a dyn Fn(f64, &mut [f64]),
    /// Share of negative power stored.
    pub storage: f64,
}

impl Replay<'_> {
    /// The last of [`CYCLES`] cycles from rest, and how far its end is from its start:
    /// the largest difference of a state, in its unit.
    pub fn record(&self) -> Result<Result<(Record, f64, StallCount), Error>, Fault> {
        let robot = self.stand.robot();
        let mut record = match Record::new(self.columns(), SAMPLES + 1) {
            Ok(record) => record,
            Err(error) => return Ok(Err(error)),
        };
        let h = 1.0 / self.flapping.frequency_hz / STEPS as f64;
        let mut stepper = Stepper::new(self, 0.0, &robot.carried_still());
        for _ in 1..CYCLES {
            stepper.run(h, STEPS, &mut Player { replay: self, told: None }).check()?;
            stepper.set_time(0.0);
        }
        let start = stepper.state().to_vec();
        let mut stalled = StallCount::default();
        let told = Some((&mut record, &mut stalled));
        stepper.run(h, STEPS, &mut Player { replay: self, told }).check()?;
        let ends = stepper.state().iter().zip(&start);
        let closure = ends.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        Ok(Ok((record, closure, stalled)))
    }

    fn loads(&self, at: Moment, dx: &mut [f64]) -> Result<CarriedLoads, Fault> {
        let (clock, body) = (self.stand.clock(at.t, &self.flapping), self.stand.body(self.flapping.pitch));
        self.stand.robot().carried_in_numbers(&clock, &body, at.x, at.u, dx)
    }

    fn columns(&self) -> Vec<Column> {
        let robot = self.stand.robot();
        let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "rad", "")];
        columns.extend(joint_columns(robot));
        columns.extend(["joint_power", "drive_power", "power_to_air"].map(|n| Column::new(n, "W", "")));
        columns.extend(["force_up", "force_forward"].map(|n| Column::new(n, "N", "W")));
        columns.push(Column::new("trim_moment", "N m", "B"));
        columns.push(Column::new(STALLED, "", ""));
        columns.extend(source_columns());
        columns.extend(robot.clearances().iter().map(Column::from));
        columns.extend(robot.inputs().iter().map(Column::from));
        columns.extend(robot.states()[robot.layout().structure..].iter().map(Column::from));
        columns
    }

    fn row(&self, at: Moment) -> Result<(Vec<f64>, StallCount), Fault> {
        let o = self.observed(at)?;
        let Moment { t, x, u, .. } = at;
        let (robot, clock) = (self.stand.robot(), self.stand.clock(t, &self.flapping).x);
        let mut row = vec![t, robot.phase(clock)];
        row.extend(o.joints.iter().map(|j| j.x));
        row.extend(&o.torques);
        row.extend([o.joint_power(), drive_power(&o.torques, &o.joints, self.storage, 0.0), -o.air_power]);
        row.extend(self.stand.lift_thrust_trim(&o, self.flapping.pitch));
        row.push(o.stalled.stalled());
        row.extend(source_values(&o.parts()));
        row.extend(robot.least_clearances(clock, x)?);
        row.extend(u);
        row.extend(x);
        Ok((row, o.stalled))
    }
}

impl System for Replay<'_> {
    type Memory = ();

    fn sizes(&self) -> Sizes {
        let robot = self.stand.robot();
        Sizes { states: robot.carried_states(), inputs: robot.inputs().len() }
    }
    fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
        self.loads(at, dx).map(|_| ())
    }
}

impl Observed for Replay<'_> {
    type Observation = CarriedLoads;

    fn observed(&self, at: Moment) -> Result<CarriedLoads, Fault> {
        self.loads(at, &mut at.x.to_vec())
    }
}

/// The commands over one cycle, with the record of it.
struct Player<'a> {
    replay: &'a Replay<'a>,
    told: Option<(&'a mut Record, &'a mut StallCount)>,
}

impl Driver<()> for Player<'_> {
    fn inputs(&self, t: f64, u: &mut [f64]) {
        let mirror = self.replay.stand.mirror();
        let mut kept = [0.0; MAX_ELEMENTS];
        let kept = &mut kept[..mirror.inputs.len()];
        (self.replay.commands)(t, kept);
        mirror.expand_inputs(kept, u);
    }

    fn observe(&mut self, k: usize, at: Moment) -> Result<ControlFlow<()>, Fault> {
        if let Some((record, all)) = self.told.as_mut().filter(|_| k.is_multiple_of(STEPS / SAMPLES)) {
            // The cycle closes at its very period, which steps only come to within rounding.
            let t = if k == STEPS { 1.0 / self.replay.flapping.frequency_hz } else { at.t };
            let (row, stalled) = self.replay.row(Moment { t, ..at })?;
            record.append(&row);
            all.add(&stalled);
        }
        Ok(ControlFlow::Continue(()))
    }
}

/// Mean of a column over a recorded cycle by the trapezoid rule. Commands, and with them forces, may jump where the
/// cycle closes: both ends count half.
pub(super) fn cycle_mean(record: &Record, name: &str) -> f64 {
    match record.values(name).unwrap_or(&[]) {
        [first, inner @ .., last] => {
            (inner.iter().sum::<f64>() + 0.5 * (first + last)) / (inner.len() + 1) as f64
        }
        _ => f64::NAN,
    }
}

/// Mean share of the strips past stall.
pub(super) fn stalled(record: &Record) -> f64 {
    cycle_mean(record, STALLED)
}

/// Means of a recorded cycle.
pub(super) fn means(record: &Record) -> Means {
    let mean = |name: &str| cycle_mean(record, name);
    Means {
        drive_power_w: mean("drive_power"),
        up_n: mean("force_up"),
        forward_n: mean("force_forward"),
        trim_n_m: mean("trim_moment"),
    }
}

/// The record with the robot's own gait beside the plan's, at the same share of the cycle.
pub(super) fn beside(plan: &Record, own: &Record) -> Result<Record, Error> {
    let mut columns = plan.columns().to_vec();
    let own_columns = BESIDE.iter().filter_map(|name| own.column(name));
    columns.extend(own_columns.map(|c| Column { name: format!("own_{}", c.name), ..c.clone() }));
    Record::new(columns, plan.rows())
}

//! A gait on the stand as simulated from rest: the whole robot, both wings.

use crate::Error;
use crate::body::drive_power;
use crate::flight::{Column, Record};
use crate::guide::{Flapping, Means, Stand};
use crate::math::{RK4, Workspace};
use crate::plant::{Fault, Plant};
use crate::robot::CarriedLoads;
use crate::scenario::recorder::{joint_columns, source_columns, source_values};

/// Cycles from rest; the last one is recorded. The slowest lag of a slow wing decays by a third per cycle.
const CYCLES: usize = 24;
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
    pub fn record(&self) -> Result<Result<(Record, f64), Error>, Fault> {
        let robot = self.stand.robot();
        let mut record = match Record::new(self.columns(), SAMPLES + 1) {
            Ok(record) => record,
            Err(error) => return Ok(Err(error)),
        };
        let period = 1.0 / self.flapping.frequency_hz;
        let h = period / STEPS as f64;
        let mut x = vec![0.0; robot.carried_states()];
        let mut start = x.clone();
        let mut work = Workspace::new(x.len(), RK4.b.len());
        for step in 0..=CYCLES * STEPS {
            let t = (step % STEPS) as f64 * h;
            let last = step >= (CYCLES - 1) * STEPS;
            if last && step % (STEPS / SAMPLES) == 0 {
                let t = if step == CYCLES * STEPS { period } else { t };
                record.append(&self.row(t, &x)?);
            }
            if step == (CYCLES - 1) * STEPS {
                start.copy_from_slice(&x);
            }
            if step < CYCLES * STEPS {
                RK4.step(|t, x, dx| self.loads(t, x, dx).map(|_| ()), t, h, &mut x, &mut work)?;
            }
        }
        let closure = x.iter().zip(&start).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        Ok(Ok((record, closure)))
    }

    fn inputs(&self, t: f64) -> Vec<f64> {
        let mirror = self.stand.mirror();
        let (mut kept, mut all) =
            (vec![0.0; mirror.inputs.len()], vec![0.0; self.stand.robot().inputs().len()]);
        (self.commands)(t, &mut kept);
        mirror.expand_inputs(&kept, &mut all);
        all
    }

    fn loads(&self, t: f64, x: &[f64], dx: &mut [f64]) -> Result<CarriedLoads, Fault> {
        let (clock, body) = (self.stand.clock(t, &self.flapping), self.stand.body(self.flapping.pitch));
        self.stand.robot().carried(&clock, &body, x, &self.inputs(t), dx)
    }

    fn columns(&self) -> Vec<Column> {
        let robot = self.stand.robot();
        let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "rad", "")];
        columns.extend(joint_columns(robot));
        columns.extend(["joint_power", "drive_power", "power_to_air"].map(|n| Column::new(n, "W", "")));
        columns.extend(["force_up", "force_forward"].map(|n| Column::new(n, "N", "W")));
        columns.push(Column::new("trim_moment", "N m", "B"));
        columns.extend(source_columns());
        columns.extend(robot.inputs().iter().map(Column::from));
        columns.extend(robot.states()[robot.layout().structure..].iter().map(Column::from));
        columns
    }

    fn row(&self, t: f64, x: &[f64]) -> Result<Vec<f64>, Fault> {
        let o = self.loads(t, x, &mut x.to_vec())?;
        let mut row = vec![t, self.stand.robot().phase(self.stand.clock(t, &self.flapping).x)];
        row.extend(o.joints.iter().map(|j| j.x));
        row.extend(&o.torques);
        row.extend([o.joint_power(), drive_power(&o.torques, &o.joints, self.storage, 0.0), -o.air_power]);
        row.extend(self.stand.lift_thrust_trim(&o, self.flapping.pitch));
        let air = &o.air;
        row.extend(source_values(&[
            air.circulatory,
            air.induced_drag,
            air.added_mass,
            air.profile_drag,
            o.body_drag,
            o.gravity,
            o.inertia,
        ]));
        row.extend(self.inputs(t));
        row.extend(x);
        Ok(row)
    }
}

/// Means of a recorded cycle by the trapezoid rule, which is exact to rounding for what is smooth and periodic.
pub(super) fn means(record: &Record) -> Means {
    let mean = |name: &str| {
        let values = record.values(name).unwrap_or(&[]);
        let inner = &values[..values.len().saturating_sub(1)];
        inner.iter().sum::<f64>() / inner.len() as f64
    };
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

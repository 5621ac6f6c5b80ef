//! From an observed robot to the columns of a record.

use crate::Error;
use crate::flight::{Column, Controller, Record, Sample};
use crate::math::{Vec3, Wrench};
use crate::plant::{Fault, Plant};
use crate::robot::{Observation, Robot};

/// Lines of a surface recorded at each end of its panels.
const LINES: [&str; 3] = ["hinge", "leading", "trailing"];
/// Load sources in the order of [`sources`].
const SOURCES: [&str; 7] =
    ["circulatory", "induced_drag", "added_mass", "profile_drag", "body_drag", "gravity", "inertia"];

fn sources(o: &Observation) -> [Wrench<f64>; SOURCES.len()] {
    let air = &o.air;
    [air.circulatory, air.induced_drag, air.added_mass, air.profile_drag, o.body_drag, o.gravity, o.inertia]
}

/// Columns of force and moment by source.
pub(super) fn source_columns() -> impl Iterator<Item = Column> {
    let axes = |kind: &'static str, source: &'static str, unit: &'static str| {
        ["x", "y", "z"].map(move |a| Column::new(format!("{kind}_{source}_{a}"), unit, "B"))
    };
    SOURCES.iter().flat_map(move |s| axes("force", s, "N").into_iter().chain(axes("moment", s, "N m")))
}

/// Numbers of [`source_columns`].
pub(super) fn source_values(sources: &[Wrench<f64>; SOURCES.len()]) -> impl Iterator<Item = f64> {
    sources.iter().flat_map(|w| w.force.0.into_iter().chain(w.moment.0))
}

/// Samples of a flight as they become a [`Record`].
pub struct Recorder<'a> {
    robot: &'a Robot,
    record: Record,
    row: Vec<f64>,
    incidence: Vec<f64>,
}

impl<'a> Recorder<'a> {
    /// An empty record of `robot` under `controller` with room for `rows` samples.
    pub fn new<C: Controller>(robot: &'a Robot, controller: &C, rows: usize) -> Result<Self, Error> {
        let mut columns = columns(robot);
        columns.extend(controller.columns());
        let width = columns.len();
        Ok(Self {
            robot,
            record: Record::new(columns, rows)?,
            row: Vec::with_capacity(width),
            incidence: Vec::new(),
        })
    }

    /// Appends a sample and the controller's diagnostics.
    pub fn sample<C: Controller>(&mut self, sample: &Sample, controller: &C) -> Result<(), Fault> {
        let Sample { t, x, u, .. } = *sample;
        let o = self.robot.observe(t, x, u)?;
        let layout = self.robot.layout();
        let position = Vec3::from_slice(&x[layout.position..]);
        let mut row = std::mem::take(&mut self.row);
        row.clear();
        row.extend([t, self.robot.phase(t)]);
        row.extend(o.attitude.roll_pitch_yaw().0);
        row.extend(&o.joints);
        row.extend(&o.torques);
        row.push(o.power);
        row.extend(source_values(&sources(&o)));
        row.extend((position + o.attitude * o.center_of_mass).0);
        row.extend(o.outlines.iter().flatten().flatten().flat_map(|p| (position + o.attitude * *p).0));
        row.extend(&o.incidence);
        row.extend(u);
        row.extend(x);
        controller.diagnostics(&mut row);
        self.record.append(&row);
        self.row = row;
        self.incidence.extend(&o.incidence);
        Ok(())
    }

    /// The record, and the share of strips past `stall_angle` (rad) over all samples.
    pub fn finish(self) -> (Record, f64) {
        let limits = self
            .robot
            .surfaces()
            .flat_map(|(_, aero)| std::iter::repeat_n(aero.stall_angle(), aero.strips()));
        let limits: Vec<f64> = limits.collect();
        let past =
            self.incidence.iter().zip(limits.iter().cycle()).filter(|(a, limit)| a.abs() > **limit).count();
        (self.record, past as f64 / self.incidence.len().max(1) as f64)
    }
}

/// Columns of the coordinates of all joints, then of their efforts.
pub(super) fn joint_columns(robot: &Robot) -> impl Iterator<Item = Column> {
    let units = |i: usize| robot.tree().kind(i).units();
    let coordinates = robot.joint_names().enumerate().map(move |(i, n)| Column::new(n, units(i)[0], ""));
    let efforts = robot.joint_names().enumerate();
    coordinates.chain(efforts.map(move |(i, n)| Column::new(format!("torque_{n}"), units(i)[2], "")))
}

fn columns(robot: &Robot) -> Vec<Column> {
    let column = |name: String, unit: &str, frame: &str| Column::new(name, unit, frame);
    let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "rad", "")];
    columns.extend(["roll", "pitch", "yaw"].map(|n| Column::new(n, "rad", "WB")));
    columns.extend(joint_columns(robot));
    columns.push(Column::new("joint_power", "W", ""));
    columns.extend(source_columns());
    columns.extend(["x", "y", "z"].map(|a| column(format!("com_{a}"), "m", "W")));
    for point in robot.outline_names() {
        for line in LINES {
            columns.extend(["x", "y", "z"].map(|a| column(format!("{line}_{point}_{a}"), "m", "W")));
        }
    }
    for (i, (name, aero)) in robot.surfaces().enumerate() {
        let prefix = if i == 0 { String::new() } else { format!("{name}_") };
        columns.extend((0..aero.strips()).map(|i| column(format!("{prefix}incidence_{i}"), "rad", "")));
    }
    columns.extend(robot.inputs().iter().map(Column::from));
    columns.extend(robot.states().iter().map(Column::from));
    columns
}

//! From an observed robot to the columns of a record.

use crate::Error;
use crate::math::{Vec3, Wrench};
use crate::plant::{Fault, Plant};
use crate::robot::{JOINTS, Observation, Robot, WING_POINTS};
use crate::simulate::{Column, Controller, Record, Sample};

/// Names of the wing's recorded points, left tip to right tip.
const POINT_NAMES: [&str; WING_POINTS] =
    ["left_tip", "left_elbow", "left_shoulder", "right_shoulder", "right_elbow", "right_tip"];
/// Lines of the wing recorded at each point.
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
        row.extend(o.joints);
        row.extend(o.torques);
        row.push(o.power);
        row.extend(source_values(&sources(&o)));
        row.extend((position + o.attitude * o.center_of_mass).0);
        row.extend(o.wing.iter().flatten().flat_map(|p| (position + o.attitude * *p).0));
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
        let limit = self.robot.aero().stall_angle();
        let past = self.incidence.iter().filter(|a| a.abs() > limit).count();
        (self.record, past as f64 / self.incidence.len().max(1) as f64)
    }
}

fn columns(robot: &Robot) -> Vec<Column> {
    let column = |name: String, unit: &str, frame: &str| Column::new(name, unit, frame);
    let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "rad", "")];
    columns.extend(["roll", "pitch", "yaw"].map(|n| Column::new(n, "rad", "WB")));
    columns.extend(JOINTS.map(|n| Column::new(n, "rad", "")));
    columns.extend(JOINTS.map(|n| column(format!("torque_{n}"), "N m", "")));
    columns.push(Column::new("joint_power", "W", ""));
    columns.extend(source_columns());
    columns.extend(["x", "y", "z"].map(|a| column(format!("com_{a}"), "m", "W")));
    for point in POINT_NAMES {
        for line in LINES {
            columns.extend(["x", "y", "z"].map(|a| column(format!("{line}_{point}_{a}"), "m", "W")));
        }
    }
    columns.extend((0..robot.aero().strips()).map(|i| column(format!("incidence_{i}"), "rad", "")));
    columns.extend(robot.inputs().iter().map(Column::from));
    columns.extend(robot.states().iter().map(Column::from));
    columns
}

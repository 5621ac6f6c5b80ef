//! From an observed robot to the columns of a record.

use super::flow_past::FlowPast;
use super::hinged::FlapSummary;
use super::link_spar::LinkSparSummary;
use super::nearness::surfaces_apart;
use super::perch::{self, PerchSpec};
use super::pinned::PinSummary;
use super::skin::MembraneSummary;
use super::summary::{LawState, mean};
use std::cmp::Reverse;
use std::f64::consts::TAU;
use wingbeat_aero::{Aero, FROM_BEHIND, LoadSource, Loads, StallCount, StripState};
use wingbeat_flight::guide::Manoeuvre;
use wingbeat_flight::simulate::{
    AXES, Column, Controller, Cost, Ending, Flight, Record, Sample, StripRecorder, pin_columns,
};
use wingbeat_judge::Judge;
use wingbeat_judge::limits::range;
use wingbeat_math::Error;
use wingbeat_math::{Mat3, Vec3, Wrench};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::{Robot, RobotSpec};

/// Lines of a surface recorded at each end of its panels.
const LINES: [&str; 3] = ["hinge", "leading", "trailing"];
/// Column of the angular momentum about the centre of mass, in a vacuum.
const MOMENTUM: &str = "angular_momentum";

/// Largest change of the angular momentum over a record, kg m2/s; none where there is air.
pub(super) fn momentum_change(record: &Record) -> Option<f64> {
    let axes = AXES.map(|axis| record.values(&format!("{MOMENTUM}_{axis}")));
    let [Some(x), Some(y), Some(z)] = axes else { return None };
    let at = |row: usize| Vec3::new(x[row], y[row], z[row]);
    (0..x.len()).map(|row| (at(row) - at(0)).norm()).reduce(|a, b| if a > b || a.is_nan() { a } else { b })
}

/// Columns of force and moment by source.
pub(super) fn source_columns() -> impl Iterator<Item = Column> {
    let axes = |kind: &'static str, source: &'static str, unit: &'static str| {
        AXES.map(move |a| Column::new(format!("{kind}_{source}_{a}"), unit, "B"))
    };
    let names = LoadSource::ALL.iter().map(|source| source.name());
    names.flat_map(move |s| axes("force", s, "N").into_iter().chain(axes("moment", s, "N m")))
}

/// Numbers of [`source_columns`].
pub(super) fn source_values(parts: &[Wrench<f64>; LoadSource::ALL.len()]) -> impl Iterator<Item = f64> {
    parts.iter().flat_map(|w| w.force.0.into_iter().chain(w.moment.0))
}

/// Instants of a flight at which it is looked how near its surfaces come. *Choice*: 40 of each of five cycles.
const LOOKS: usize = 200;

impl FlightMeans {
    /// Holds what the air and the surfaces are like against what the models were made for.
    pub fn hold(&self, judge: &mut Judge) {
        judge.hold(&range::REVERSED, self.reversed_fraction);
        judge.hold_if(&range::VISCOUS, self.reynolds);
        judge.hold_if(&range::NEAR, self.surfaces_apart);
    }
}

/// The records of a flight.
pub struct Recorded {
    /// One row per sample.
    pub record: Record,
    /// One row per strip and instant, where asked for.
    pub strips: Option<Record>,
    /// Means over all samples; none where samples were cut off.
    pub means: Option<FlightMeans>,
}

/// What is averaged over all samples of a flight while it is recorded.
#[derive(Clone, Debug)]
pub struct FlightMeans {
    /// Strips by their angles of attack.
    pub stalled: StallCount,
    /// Share of strips that the wind meets from behind, at an angle of attack above 135 degrees.
    pub reversed_fraction: f64,
    /// Mean Reynolds number of the strips, by their own chords and speeds, dimensionless; none where there is no air.
    pub reynolds: Option<f64>,
    /// Largest speed of a strip through the mean wind, from sample to sample, m/s.
    pub fastest_m_s: f64,
    /// Least distance of surfaces that lie on one another, over the larger chord, dimensionless; none where none do.
    pub surfaces_apart: Option<f64>,
    /// Means over strips and samples: separated share of the flow, share of the suction that law `lev` takes away.
    pub separated_fraction: f64,
    pub suction_lost_fraction: f64,
    /// Means of the states that the laws of the surfaces declare.
    pub law_states: Vec<LawState>,
    /// Share of the samples beyond the velocities of `robot.residual`; none without one.
    pub beyond_residual_fraction: Option<f64>,
    /// Membranes, where there are any.
    pub membrane: Option<MembraneSummary>,
    /// Flaps, likewise.
    pub flap: Option<FlapSummary>,
    /// Spars, likewise.
    pub spar: Option<LinkSparSummary>,
    /// Springs on pins of the linkage, likewise.
    pub pin_springs: Option<PinSummary>,
}

/// Samples of a flight as they become a [`Record`].
pub struct Recorder<'a> {
    robot: &'a Robot,
    /// Of the robot, kg.
    mass: f64,
    manoeuvre: Option<&'a dyn Manoeuvre>,
    /// Columns of what the sensors read.
    readings: usize,
    record: Record,
    row: Vec<f64>,
    /// Loads of the sample before, to be written over.
    loads: Option<Box<Loads<f64>>>,
    incidence: Vec<f64>,
    /// Sums of separated and suction_lost over the same strips.
    shares: [f64; 2],
    past: FlowPast,
    /// Every how many samples it is looked how near surfaces come, and samples so far.
    looks: [usize; 2],
    apart: Option<f64>,
    /// Samples beyond the velocities of `robot.residual`, and all of those that tell.
    beyond: [f64; 2],
    strips: Option<StripRows>,
    /// The perch, and whether its claw has latched.
    perch: Option<&'a PerchSpec>,
    latched: bool,
}

/// Loads of the strips at every so many samples.
struct StripRows {
    recorder: StripRecorder,
    every: usize,
    due: usize,
}

impl<'a> Recorder<'a> {
    /// An empty record of `robot` under `controller`, with columns for the `readings` of its sensors and room for `rows`
    /// samples; with `samples_per_strips` the strips at every so many of them. What the `manoeuvre` asks is written last.
    pub fn new(
        robot: &'a Robot,
        manoeuvre: Option<&'a dyn Manoeuvre>,
        (controller, readings): (&dyn Controller, Vec<Column>),
        rows: usize,
        samples_per_strips: Option<usize>,
    ) -> Result<Self, Error> {
        let strips = |every: usize| StripRows {
            recorder: StripRecorder::new(robot.surfaces().map(|(_, aero)| aero), "rad", rows.div_ceil(every)),
            every,
            due: 0,
        };
        let mut columns = columns(robot);
        columns.extend(controller.columns());
        let heard = readings.len();
        columns.extend(readings);
        if manoeuvre.is_some() {
            columns.extend(["roll_reference", "pitch_reference"].map(|n| Column::new(n, "rad", "WB")));
        }
        let width = columns.len();
        Ok(Self {
            robot,
            mass: robot.mass(),
            manoeuvre,
            readings: heard,
            record: Record::new(columns, rows)?,
            row: Vec::with_capacity(width),
            loads: None,
            incidence: Vec::new(),
            shares: [0.0; 2],
            past: FlowPast::default(),
            looks: [rows.div_ceil(LOOKS).max(1), 0],
            apart: None,
            beyond: [0.0; 2],
            strips: samples_per_strips.map(strips),
            perch: None,
            latched: false,
        })
    }

    /// Looks out for the claw to latch as `perch` says.
    pub fn beside(&mut self, perch: Option<&'a PerchSpec>) {
        self.perch = perch;
    }

    /// Whether the claw has latched, which ends the flight.
    pub fn latched(&self) -> bool {
        self.latched
    }

    /// A flight that a latched claw has ended is whole.
    pub fn complete(&self, flight: &mut Flight) {
        if self.latched {
            flight.ending = Ending::Complete;
        }
    }

    /// Appends a sample and the controller's diagnostics.
    pub fn sample(&mut self, sample: &Sample, controller: &dyn Controller) -> Result<(), Fault> {
        let Sample { t, x, u, beyond, readings, .. } = *sample;
        let loads = self.loads.take().unwrap_or_else(Loads::boxed);
        let o = self.robot.observe_beyond(t, x, u, beyond, loads)?;
        let layout = self.robot.layout();
        let position = Vec3::from_slice(&x[layout.position..]);
        let mut row = std::mem::take(&mut self.row);
        row.clear();
        row.extend([t, o.phase]);
        row.extend(o.attitude.roll_pitch_yaw().0);
        row.extend(&o.joints);
        row.extend(&o.torques);
        row.extend(&o.pins);
        row.extend(self.robot.has_pin_springs().then_some(o.pin_power));
        row.extend([o.power, o.separate_power, o.drive_power, o.regulator_power]);
        row.extend(o.motor.iter().flat_map(|m| [m.shaft_torque, m.shaft_power, m.electrical_power]));
        row.extend(source_values(&o.parts()));
        if !self.robot.thrusters().is_empty() {
            row.extend(o.thrust.force.0.into_iter().chain(o.thrust.moment.0));
        }
        row.extend(o.weight_shares(self.mass));
        row.extend((position + o.attitude * o.center_of_mass).0);
        if !self.robot.wind_over_time().is_steady() {
            row.extend(self.robot.wind_over_time().at(t).0.0);
        }
        if self.robot.is_in_vacuum() {
            row.extend(o.angular_momentum.0);
        }
        if let Some((perch, seen)) = self.robot.perch().zip(self.robot.at_perch(x)) {
            row.extend(perch.place().0);
            row.extend([seen.distance, seen.speed, seen.off_hanging, seen.force]);
            row.extend(self.robot.perch_clearance(t, x)?);
            self.latched |= self.perch.is_some_and(|perch| perch.latches(&seen));
        }
        row.extend(o.outlines.iter().flatten().flatten().flat_map(|p| (position + o.attitude * *p).0));
        row.extend(o.incidence());
        row.extend(&o.clearances);
        row.extend(u);
        row.extend(x);
        controller.diagnostics(&mut row);
        row.extend(&readings[..self.readings]);
        let asked = self.manoeuvre.map(|manoeuvre| manoeuvre.reference(t));
        row.extend(asked.into_iter().flat_map(|asked| [asked.roll, asked.pitch]));
        let recorded = self.record.append_finite(&row);
        self.row = row;
        recorded?;
        self.incidence.extend(o.incidence());
        let quarter_chords = o.strips.quarter_chord.iter().map(|p| position + o.attitude * *p);
        self.past.see(self.robot, t, quarter_chords);
        let [every, seen] = &mut self.looks;
        if seen.is_multiple_of(*every) && self.robot.surfaces().nth(1).is_some() {
            let apart = surfaces_apart(self.robot, t, x);
            self.apart = [self.apart, apart].into_iter().flatten().reduce(f64::min);
        }
        *seen += 1;
        let columns = [&o.strips.separated, &o.strips.suction_lost];
        for (sum, column) in self.shares.iter_mut().zip(columns) {
            *sum += column[..o.strips.strips].iter().sum::<f64>();
        }
        if let Some(beyond) = o.beyond_residual {
            self.beyond[0] += f64::from(u8::from(beyond));
            self.beyond[1] += 1.0;
        }
        if let Some(strips) = &mut self.strips {
            if strips.due == 0 {
                let instant = [t, o.phase];
                strips.recorder.append(instant, &o.strips, &[], Mat3::IDENTITY, Vec3::ZERO);
                strips.due = strips.every;
            }
            strips.due -= 1;
        }
        self.loads = Some(o.strips);
        Ok(())
    }

    /// The record so far.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// What was recorded.
    pub fn finish(self) -> Recorded {
        let mut stalled = StallCount::default();
        let mut incidence = self.incidence.iter().copied();
        while incidence.len() > 0 {
            for (_, aero) in self.robot.surfaces() {
                stalled.see(aero, incidence.by_ref().take(aero.strips()));
            }
        }
        let all = self.robot.surfaces().map(|(_, aero)| aero.strips()).sum::<usize>();
        let covered =
            self.robot.surfaces().map(|(_, aero)| (0..aero.strips()).filter(|i| aero.covers(*i)).count());
        let instants = self.incidence.len() / all.max(1);
        let count = (instants * covered.sum::<usize>()).max(1) as f64;
        let reversed = self.incidence.iter().filter(|a| a.abs() > FROM_BEHIND).count() as f64 / count;
        let [separated_fraction, suction_lost_fraction] = self.shares.map(|sum| sum / count);
        let means = FlightMeans {
            separated_fraction,
            suction_lost_fraction,
            law_states: law_states(self.robot, &self.record),
            beyond_residual_fraction: (self.beyond[1] > 0.0).then(|| self.beyond[0] / self.beyond[1]),
            membrane: skins(self.robot, &self.record),
            flap: flaps(self.robot, &self.record),
            spar: LinkSparSummary::of(self.robot, &self.record),
            pin_springs: PinSummary::of(self.robot, &self.record),
            reversed_fraction: reversed,
            reynolds: self.past.reynolds(self.robot.density()),
            fastest_m_s: self.past.fastest_m_s,
            surfaces_apart: self.apart,
            stalled,
        };
        let strips = self.strips.map(|strips| strips.recorder.finish());
        Recorded { record: self.record, strips, means: Some(means) }
    }
}

/// The membranes of `robot`, from the columns that `record` has of them.
fn skins(robot: &Robot, record: &Record) -> Option<MembraneSummary> {
    // Wings at rest too need membranes that follow within the flight: with this frequency the lag is that part of it.
    let times = record.values("t").unwrap_or_default();
    let duration = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    let slowest = if duration > 0.0 { 1.0 / (TAU * duration) } else { 0.0 };
    let frequency = robot.frequency_hz().max(slowest);
    let of = |(k, (name, aero)): (usize, (&str, &Aero))| {
        let prefix = if k == 0 { String::new() } else { format!("{name}_") };
        let columns = (0..aero.strips()).filter_map(|i| {
            let column = |of: &str| record.values(&format!("{prefix}{of}_{i}"));
            Some(column("camber")?.iter().zip(column("camber_forward")?).map(|(a, b)| [*a, *b]))
        });
        MembraneSummary::of(aero, columns.flatten(), frequency)
    };
    robot.surfaces().enumerate().filter_map(of).reduce(MembraneSummary::worse)
}

/// The flaps of `robot`, from the columns that `record` has of them.
fn flaps(robot: &Robot, record: &Record) -> Option<FlapSummary> {
    let of = |(k, (name, aero)): (usize, (&str, &Aero))| {
        let prefix = if k == 0 { String::new() } else { format!("{name}_") };
        let columns = (0..aero.strips()).filter_map(|i| record.values(&format!("{prefix}flap_{i}")));
        FlapSummary::of(aero, columns.flatten().copied())
    };
    robot.surfaces().enumerate().filter_map(of).reduce(FlapSummary::worse)
}

/// Means of the states that the laws of the surfaces of `robot` declare, in the order of the surfaces.
fn law_states(robot: &Robot, record: &Record) -> Vec<LawState> {
    let mut declared: Vec<&'static StripState> = Vec::new();
    for state in robot.surfaces().flat_map(|(_, aero)| aero.law().states()) {
        if !declared.iter().any(|other| other.name == state.name) {
            declared.push(state);
        }
    }
    declared.into_iter().filter_map(|state| LawState::of(state, robot, record)).collect()
}

impl LawState {
    /// Of the columns that `record` has of it; none where nothing was recorded.
    fn of(state: &'static StripState, robot: &Robot, record: &Record) -> Option<Self> {
        let carrying = robot
            .surfaces()
            .enumerate()
            .filter(|(_, (_, aero))| aero.law().states().iter().any(|other| other.name == state.name));
        let names = carrying.flat_map(|(k, (name, aero))| {
            let prefix = if k == 0 { String::new() } else { format!("{name}_") };
            (0..aero.strips()).map(move |i| format!("{prefix}{}_{i}", state.name))
        });
        let means: Vec<f64> = names.filter_map(|name| mean(record.values(&name)?)).collect();
        Some(Self { meaning: state.meaning, unit: state.unit, mean: mean(&means)? })
    }
}

/// Columns of the coordinates of all joints, then of their efforts.
pub(super) fn joint_columns(robot: &Robot) -> impl Iterator<Item = Column> {
    let units = |i: usize| robot.tree().kind(i).units();
    let coordinates = robot.joint_names().enumerate().map(move |(i, n)| Column::new(n, units(i)[0], ""));
    let efforts = robot.joint_names().enumerate();
    coordinates.chain(efforts.map(move |(i, n)| Column::new(format!("torque_{n}"), units(i)[2], "")))
}

/// Refuses a name of a part of `spec`, of which `robot` is made, that is or makes the name of another column of the record.
pub(super) fn check_columns(spec: &RobotSpec, robot: &Robot) -> Result<(), Error> {
    Record::new(columns(robot), 0).map(drop).map_err(|error| of_part(spec, error))
}

/// The error of a column that comes twice, told of the part of `spec` that the column is called after: of those whose name is in
/// the column's the one with the longest.
pub(super) fn of_part(spec: &RobotSpec, error: Error) -> Error {
    let Error::Invalid { key, value, .. } = &error;
    if key != Record::COLUMN {
        return error;
    }
    let parts = spec.named_parts().into_iter().flatten();
    let within = |name: &str| format!("_{value}_").contains(&format!("_{name}_"));
    match parts.filter(|(_, name)| within(name)).min_by_key(|(_, name)| Reverse(name.len())) {
        Some((key, name)) => {
            let allowed = format!("another name: the record of a flight has a column {value} already");
            Error::invalid(key, format!("{name:?}"), allowed).within("robot")
        }
        None => error,
    }
}

fn columns(robot: &Robot) -> Vec<Column> {
    let column = |name: String, unit: &str, frame: &str| Column::new(name, unit, frame);
    let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "rad", "")];
    columns.extend(["roll", "pitch", "yaw"].map(|n| Column::new(n, "rad", "WB")));
    columns.extend(joint_columns(robot));
    columns.extend(pin_columns(robot));
    let powers = ["joint_power", "separate_power", "drive_power", "regulator_power"];
    columns.extend(powers.map(|n| Column::new(n, "W", "")));
    if robot.motor().is_some() {
        let motor = [("motor_torque", "N m"), ("motor_power", "W"), ("electrical_power", "W")];
        columns.extend(motor.map(|(name, unit)| Column::new(name, unit, "")));
    }
    columns.extend(source_columns());
    if !robot.thrusters().is_empty() {
        columns.extend(AXES.map(|a| column(format!("thrust_{a}"), "N", "B")));
        columns.extend(AXES.map(|a| column(format!("thrust_moment_{a}"), "N m", "B")));
    }
    columns.extend(Cost::columns());
    columns.extend(AXES.map(|a| column(format!("com_{a}"), "m", "W")));
    if !robot.wind_over_time().is_steady() {
        columns.extend(AXES.map(|a| column(format!("wind_{a}"), "m/s", "W")));
    }
    if robot.is_in_vacuum() {
        columns.extend(AXES.map(|a| column(format!("{MOMENTUM}_{a}"), "kg m2/s", "W")));
    }
    if robot.perch().is_some() {
        columns.extend(perch::COLUMNS.map(|[name, unit, frame]| Column::new(name, unit, frame)));
    }
    for point in robot.outline_names() {
        for line in LINES {
            columns.extend(AXES.map(|a| column(format!("{line}_{point}_{a}"), "m", "W")));
        }
    }
    for (i, (name, aero)) in robot.surfaces().enumerate() {
        let prefix = if i == 0 { String::new() } else { format!("{name}_") };
        columns.extend((0..aero.strips()).map(|i| column(format!("{prefix}incidence_{i}"), "rad", "")));
    }
    columns.extend(robot.clearances().iter().map(Column::from));
    columns.extend(robot.inputs().iter().map(Column::from));
    columns.extend(robot.states().iter().map(Column::from));
    columns
}

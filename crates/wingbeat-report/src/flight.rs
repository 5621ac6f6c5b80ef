//! The motion of a recorded flight: the robot of its scenario, in the states that the record holds.

use wingbeat::aero::{Circulation, Loads};
use wingbeat::math::Vec3;
use wingbeat::plant::{Channel, Fault, Plant};
use wingbeat::robot::{Outline, Robot, Skeleton};
use wingbeat::scenario::Scenario;
use wingbeat::simulate::Record;

use crate::motion::{
    ForceTrack, LineTrack, PointTrack, RunMotion, StripTrack, SurfaceTrack, push, rows, sound,
};

/// How far from the middle plane the middle of a panel lies that is of a side, m.
const MIDDLE: f64 = 1e-6;

/// What is said where nothing can be shown in space.
pub type Silent = String;

/// The rows that are shown of a flight.
pub fn shown(record: &Record) -> Vec<usize> {
    rows(record.values("t").unwrap_or_default(), drawable(record))
}

/// How many of the first rows of a flight can be drawn.
pub fn drawable(record: &Record) -> usize {
    let place = ["x", "y", "z"].map(|axis| record.values(&format!("p_WB_{axis}")).unwrap_or_default());
    if place[0].is_empty() { record.rows() } else { sound(&place) }
}

/// The motion of the flight of `scenario` in the `shown` rows of `record`.
///
/// # Errors
/// Why the record does not say how the robot moves.
pub fn motion(scenario: &Scenario, record: &Record, shown: &[usize]) -> Result<RunMotion, Silent> {
    let robot = scenario.robot();
    let column = |name: &str| record.values(name).ok_or_else(|| format!("the record has no column {name}"));
    let all = |channels: &[Channel]| -> Result<Vec<&[f64]>, Silent> {
        channels.iter().map(|channel| column(&channel.name)).collect()
    };
    let (t, states, inputs) = (column("t")?, all(robot.states())?, all(robot.inputs())?);
    let axes = |name: &str| axes(record, shown, name);
    let [w, x, y, z] = ["w", "x", "y", "z"].map(|axis| taken(record, shown, &format!("quat_{axis}")));
    let mut motion = RunMotion {
        t: taken(record, shown, "t")?,
        position: axes("p_WB")?,
        attitude: [w?, x?, y?, z?],
        sources: sources(scenario, record, shown),
        path: axes("path_nearest").ok(),
        wind: robot.mean_wind().0,
        free: true,
        ground: robot.ground(),
        ..RunMotion::default()
    };
    if let Some(perch) = robot.perch() {
        let still = |end: Vec3| end.0.map(|axis| vec![axis; shown.len()]);
        motion.lines = vec![LineTrack { name: "perch", weight: 5.0, points: perch.ends().map(still).into() }];
    }
    // Where the lattice gives the attached flow, the model's strips are not those that flew; a vacuum has none.
    let strips = scenario.spec.lattice.is_none() && !robot.is_in_vacuum();
    motion.circulation = strips.then(|| told(robot));
    let mut loads = strips.then(Loads::boxed);
    for &row in shown {
        let at = |columns: &[&[f64]]| columns.iter().map(|column| column[row]).collect::<Vec<f64>>();
        let (x, u) = (at(&states), at(&inputs));
        let faulty = |fault: Fault| format!("t = {} s: {fault}", t[row]);
        let Some(room) = loads.take() else {
            add_skeleton(&mut motion, &robot.skeleton(t[row], &x, &u).map_err(faulty)?);
            continue;
        };
        let (drawn, seen) = robot.observe_drawn(t[row], &x, &u, room).map_err(faulty)?;
        add_skeleton(&mut motion, &drawn);
        add_strips(&mut motion, robot, &seen.strips);
        loads = Some(seen.strips);
    }
    motion.surfaces.iter_mut().for_each(SurfaceTrack::place_strips);
    Ok(motion)
}

/// Adds the strips of all surfaces in one frame.
fn add_strips(motion: &mut RunMotion, robot: &Robot, loads: &Loads<f64>) {
    let mut first = 0;
    for (surface, (_, aero)) in motion.surfaces.iter_mut().zip(robot.surfaces()) {
        surface.strips.resize_with(aero.strips(), StripTrack::default);
        for (k, strip) in surface.strips.iter_mut().enumerate() {
            let (point, load) = (loads.quarter_chord[first + k], loads.strip[first + k].total());
            push(&mut strip.quarter_chord, point);
            push(&mut strip.force, load.force);
            push(&mut strip.moment, load.moment - point.cross(load.force));
            strip.circulation.push(loads.circulation[first + k]);
        }
        first += aero.strips();
    }
}

/// What the circulations of the robot's strips are.
fn told(robot: &Robot) -> &'static str {
    match robot.surfaces().any(|(_, aero)| aero.circulation() == Circulation::LagSum) {
        true => "sum of the lags that stands for the circulation",
        false => "circulation",
    }
}

/// Adds the robot as it is drawn in one frame.
pub fn add_skeleton(motion: &mut RunMotion, seen: &Skeleton) {
    push(&mut motion.com, seen.center_of_mass);
    motion.surfaces.resize_with(seen.outlines.len(), SurfaceTrack::default);
    for (surface, outline) in motion.surfaces.iter_mut().zip(&seen.outlines) {
        add_outline(surface, outline);
    }
}

/// Adds a surface as it is drawn in one frame.
pub fn add_outline(surface: &mut SurfaceTrack, outline: &Outline) {
    if surface.ribs.is_empty() {
        surface.name.clone_from(&outline.name);
        surface.ribs.resize_with(outline.ribs.len(), Default::default);
        surface.covered.clone_from(&outline.covered);
        surface.side = sides(&outline.ribs);
        surface.raised.resize_with(outline.raised.len(), Default::default);
        surface.hinge = outline.hinge;
    }
    let raised = outline.raised.as_flattened().iter();
    let points = outline.ribs.as_flattened().iter().chain(raised);
    let tracks = surface.ribs.as_flattened_mut().iter_mut().chain(surface.raised.as_flattened_mut());
    tracks.zip(points).for_each(|(track, point)| push(track, *point));
}

/// Of the panels between `ribs` 0 left, 1 right, 2 neither.
fn sides(ribs: &[[Vec3; 2]]) -> Vec<usize> {
    let y = |rib: &[Vec3; 2]| 0.5 * (rib[0].0[1] + rib[1].0[1]);
    let side = |pair: &[[Vec3; 2]]| match y(&pair[0]) + y(&pair[1]) {
        sum if sum > MIDDLE => 0,
        sum if sum < -MIDDLE => 1,
        _ => 2,
    };
    ribs.windows(2).map(side).collect()
}

/// The numbers of a column, in its unit, in the rows that are shown.
pub fn taken(record: &Record, shown: &[usize], name: &str) -> Result<Vec<f64>, Silent> {
    let column = record.values(name).ok_or_else(|| format!("the record has no column {name}"))?;
    Ok(shown.iter().map(|&row| column[row]).collect())
}

/// The columns `<name>_x`, `_y`, `_z`, likewise.
pub fn axes(record: &Record, shown: &[usize], name: &str) -> Result<PointTrack, Silent> {
    let [x, y, z] = ["x", "y", "z"].map(|axis| taken(record, shown, &format!("{name}_{axis}")));
    Ok([x?, y?, z?])
}

/// The forces that the record names by source.
pub fn named(record: &Record, shown: &[usize]) -> Vec<ForceTrack> {
    let names = record.columns().iter().map(|column| column.name.as_str());
    let names = names.filter_map(|name| name.strip_prefix("force_")?.strip_suffix("_x"));
    // The lift and drag of a case are its forces in other axes.
    let names = names.filter(|name| *name != "wind");
    let source = |name: &str| {
        let force = axes(record, shown, &format!("force_{name}")).ok()?;
        Some(ForceTrack { name: name.replace('_', " "), place: None, force })
    };
    names.filter_map(source).collect()
}

/// Those, and the thrusters.
fn sources(scenario: &Scenario, record: &Record, shown: &[usize]) -> Vec<ForceTrack> {
    let thruster = |thruster: &wingbeat::robot::ThrusterSpec| {
        let thrust = taken(record, shown, &format!("displacement_{}", thruster.name)).ok()?;
        let length = Vec3(thruster.direction).norm();
        let force = thruster.direction.map(|part| thrust.iter().map(|n| n * part / length).collect());
        Some(ForceTrack { name: thruster.name.clone(), place: Some(thruster.place_m), force })
    };
    let thrusters = scenario.spec.robot.thrusters.iter().filter_map(thruster);
    named(record, shown).into_iter().chain(thrusters).collect()
}

//! The motion of what is held: a wing in prescribed motion, and a robot on the arm of the rig.

use std::f64::consts::TAU;

use wingbeat::aero::Circulation;
use wingbeat::math::{Quat, Vec3};
use wingbeat::plant::{Channel, Plant};
use wingbeat::rig::{Pose, rotation_vector};
use wingbeat::scenario::{RigRun, Scenario, TetherCase};
use wingbeat::simulate::Record;
use wingbeat::tether::{STRAIN, Shape};

use crate::flight::{Silent, add_outline, add_skeleton, named, taken};
use crate::motion::{LineTrack, PointTrack, RunMotion, StripTrack, SurfaceTrack, push};

/// Ribs of each half of a case's wing.
const RIBS: usize = 12;
/// Half the width of the table under the arm, m.
const TABLE: f64 = 0.4;

/// The wing of `case` in the `shown` rows of its loads, with the `strips` that its run holds.
///
/// # Errors
/// Why the records do not say how it moves.
pub fn wing(
    case: &TetherCase,
    loads: &Record,
    strips: Option<&Record>,
    shown: &[usize],
) -> Result<RunMotion, Silent> {
    let tether = &case.tether;
    let arcs = tether.drawn_arcs(RIBS);
    let t = taken(loads, shown, "t")?;
    let mut motion = RunMotion {
        sources: named(loads, shown),
        wind: tether.wind.0,
        bare: true,
        ground: tether.ground.as_ref().map(|plane| plane.height_m),
        ..RunMotion::default()
    };
    let strains = strains(case, loads);
    let heights = strips.and_then(|strips| heights(strips, loads.rows(), tether.aero.strips()));
    let flaps = strips.and_then(|strips| strips.values("flap"));
    let flaps = flaps.filter(|flaps| flaps.len() == loads.rows() * tether.aero.strips());
    let mut surface = SurfaceTrack::default();
    for (&t, &row) in t.iter().zip(shown) {
        let frame = tether.motion.body(t).frame();
        let (origin, rotation) = (frame.origin.each(|j| j.x), frame.turn.each(|j| j.x));
        add_pose(&mut motion, &Pose { rotation, origin });
        push(&mut motion.com, Vec3::ZERO);
        let spar: Vec<f64> = strains.iter().map(|strain| strain[row]).collect();
        let count = tether.aero.strips();
        let heights = heights.map(|heights| heights.map(|of| &of[row * count..(row + 1) * count]));
        let flaps = flaps.map_or(&[][..], |flaps| &flaps[row * count..][..count]);
        let shape = Shape { spar: &spar, heights: heights.unwrap_or_default(), flaps };
        let mut seen = tether.outline(t, &arcs, shape);
        let inside = |point: &mut Vec3| *point = rotation.transpose_mul(*point - origin);
        seen.ribs.as_flattened_mut().iter_mut().for_each(inside);
        seen.raised.as_flattened_mut().iter_mut().for_each(inside);
        add_outline(&mut surface, &seen);
    }
    if let Some(strips) = strips {
        surface.strips = strips_of(strips, loads, shown, &tether.strip_weights()).unwrap_or_default();
        surface.place_strips();
        motion.circulation = match tether.aero.circulation() {
            Circulation::Bound => Some("circulation"),
            Circulation::LagSum => Some("sum of the lags that stands for the circulation"),
        };
    }
    motion.t = t;
    motion.surfaces = vec![surface];
    Ok(motion)
}

/// The coordinates of the spar, in the units of its strains, that has bent the wing of `case` with those `loads`; nothing of a
/// rigid one, and of loads that lack some.
pub fn strains<'a>(case: &TetherCase, loads: &'a Record) -> Vec<&'a [f64]> {
    let count = case.tether.spar.as_ref().map_or(0, |spar| spar.beam.coordinates());
    let all: Option<Vec<&[f64]>> = (0..count).map(|i| loads.values(&format!("{STRAIN}{i}"))).collect();
    all.unwrap_or_default()
}

/// Both heights of the membrane of all `count` strips at `rows` instants.
fn heights(strips: &Record, rows: usize, count: usize) -> Option<[&[f64]; 2]> {
    let [camber, forward] = ["camber", "camber_forward"].map(|name| strips.values(name));
    Some([camber?, forward?]).filter(|[camber, _]| camber.len() == count * rows)
}

/// The strips of a record that has as many rows an instant as strips, of the instants of the `shown` rows of `loads`: those of which a share
/// counts (`weights`), with that share of their loads.
fn strips_of(strips: &Record, loads: &Record, shown: &[usize], weights: &[f64]) -> Option<Vec<StripTrack>> {
    let (t, number) = (strips.values("t")?, strips.values("strip")?);
    let all = loads.values("t")?;
    let most = number.iter().fold(0.0_f64, |most, n| most.max(*n));
    let count = (most < t.len() as f64).then_some(most as usize + 1)?;
    if t.len() != count * all.len() {
        return None;
    }
    let rows = |k: usize| shown.iter().map(move |row| row * count + k).collect::<Vec<usize>>();
    let strip = |k: usize| {
        let rows = rows(k);
        let of = |name: &str| crate::flight::axes(strips, &rows, name).ok();
        let circulation = ["circulation", "circulation_lag_sum"];
        let circulation = circulation.iter().find_map(|name| taken(strips, &rows, name).ok())?;
        let weighed = |name: &str| {
            let scaled = |part: Vec<f64>| part.iter().map(|value| weights[k] * value).collect();
            of(name).map(|track| track.map(scaled))
        };
        let (quarter_chord, force) = (of("quarter_chord")?, weighed("force")?);
        let moment = weighed("moment").unwrap_or_default();
        Some(StripTrack { quarter_chord, force, moment, circulation, ..StripTrack::default() })
    };
    let counts = |k: &usize| weights[*k] > 0.0;
    (weights.len() == count).then(|| (0..count).filter(counts).map(strip).collect())?
}

/// The robot on the arm in the `shown` rows of the record of `run`.
///
/// # Errors
/// Why the record does not say how it moves.
pub fn on_arm(run: &RigRun, record: &Record, shown: &[usize]) -> Result<RunMotion, Silent> {
    let joint = |k: usize| taken(record, shown, &format!("q{}", k + 1));
    let q: Vec<Vec<f64>> = (0..run.arm.dof()).map(joint).collect::<Result<_, _>>()?;
    let mut motion = RunMotion { t: taken(record, shown, "t")?, ..RunMotion::default() };
    let (none, z): (PointTrack, f64) = (Default::default(), run.spec.rig.table_m);
    let phase = taken(record, shown, "phase").ok();
    let mut arm = LineTrack { name: "arm", weight: 7.0, points: vec![none.clone(); run.arm.dof() + 3] };
    let mut sting = LineTrack { name: "mount and cell", weight: 4.0, points: vec![none; 3] };
    for (i, t) in motion.t.clone().into_iter().enumerate() {
        let q: Vec<f64> = q.iter().map(|joint| joint[i]).collect();
        let frames = run.arm.frames(&q);
        // From the table to the base of the arm.
        push(&mut arm.points[0], Vec3([0.0, 0.0, z]));
        push(&mut arm.points[1], Vec3::ZERO);
        for (point, frame) in arm.points[2..].iter_mut().zip(&frames[..=run.arm.dof()]) {
            push(point, frame.origin);
        }
        let tool = frames[run.arm.dof()];
        let cell = tool * run.mount.cell;
        let body = cell * run.mount.body;
        for (point, place) in sting.points.iter_mut().zip([tool, cell, body]) {
            push(point, place.origin);
        }
        add_pose(&mut motion, &body);
        // The encoder shows 0 where the gait is at its start.
        let gait = phase.as_ref().map_or(t, |phase| phase[i] / (TAU * run.frequency()));
        let seen = run.cranked().at_rest(gait).map_err(|fault| format!("t = {t} s: {fault}"))?;
        add_skeleton(&mut motion, &seen);
    }
    motion.lines = vec![arm, sting];
    motion.table = Some([[-TABLE, -TABLE, z], [TABLE, -TABLE, z], [TABLE, TABLE, z], [-TABLE, TABLE, z]]);
    Ok(motion)
}

/// The robot held with its nose down by `pitch`, rad, in the `shown` rows of the `record` of a gait that was planned: what of its states
/// the record lacks is that of the body, at rest.
///
/// # Errors
/// Why the record does not say how it moves.
pub fn gait(scenario: &Scenario, record: &Record, shown: &[usize], pitch: f64) -> Result<RunMotion, Silent> {
    let robot = scenario.robot();
    let mut rest = vec![0.0; robot.states().len()];
    rest[robot.attitude().ok_or("the robot has no attitude")?] = 1.0;
    let of = |channels: &[Channel]| -> Vec<Option<&[f64]>> {
        channels.iter().map(|channel| record.values(&channel.name)).collect()
    };
    let (states, inputs) = (of(robot.states()), of(robot.inputs()));
    let phase = record.values("phase").ok_or("the record has no column phase")?;
    let mut motion = RunMotion {
        t: taken(record, shown, "t")?,
        sources: named(record, shown),
        wind: robot.mean_wind().0,
        repeats: true,
        ..RunMotion::default()
    };
    for &row in shown {
        let at = |columns: &[Option<&[f64]>], rest: &[f64]| -> Vec<f64> {
            columns
                .iter()
                .zip(rest)
                .map(|(column, rest)| column.map_or(*rest, |column| column[row]))
                .collect()
        };
        let (x, u) = (at(&states, &rest), at(&inputs, &vec![0.0; inputs.len()]));
        // The time at which the robot's own gait has this phase.
        let t = (phase[row] - robot.phase(0.0)) / (TAU * robot.frequency_hz());
        let seen = robot.skeleton(t, &x, &u).map_err(|fault| format!("phase {} rad: {fault}", phase[row]))?;
        push(&mut motion.position, Vec3::ZERO);
        let nose = [(0.5 * pitch).cos(), 0.0, (0.5 * pitch).sin(), 0.0];
        motion.attitude.iter_mut().zip(nose).for_each(|(column, part)| column.push(part));
        add_skeleton(&mut motion, &seen);
    }
    Ok(motion)
}

/// Adds a place of the body, its quaternion of the sign that is nearer to the one before.
fn add_pose(motion: &mut RunMotion, pose: &Pose) {
    push(&mut motion.position, pose.origin);
    let mut next = [0.0; 4];
    Quat::exp(rotation_vector(&pose.rotation)).store_wxyz(&mut next);
    let along = motion.attitude.iter().zip(next).map(|(column, part)| column.last().unwrap_or(&part) * part);
    let sign = if along.sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
    motion.attitude.iter_mut().zip(next).for_each(|(column, part)| column.push(sign * part));
}

//! What is seen over a cycle of an orbit.

use super::cycle::{Cycle, PARTS};
use super::newton::Orbit;
use crate::simulate::Cost;
use wingbeat_math::{GRAVITY, Vec3};
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::Observation;

/// Areas of the strips of all surfaces in turn, chord times width, m2.
pub type StripAreas = Vec<f64>;

/// Half the thickness of a wing's skin, by which a clearance falls short, m: choice.
pub const SKIN: f64 = 0.003;
/// Incidences beyond which shares of the wing are counted, deg.
const INCIDENCES_DEG: [f64; 2] = [12.0, 20.0];
/// Half the width of the soft edge, deg: choice.
const SOFT_DEG: f64 = 3.0;

/// Numbers of a cycle.
#[derive(Clone, Debug, Default)]
pub struct Measures {
    /// Mean upward force of the air over the weight.
    pub lift_over_weight: f64,
    /// Power of the joints, and what carries the weight.
    pub cost: Cost,
    /// Mean force of the air across the plane of symmetry over the weight, positive to the left.
    pub side_force_over_weight: f64,
    /// Mean power of the joints that twist a wing ([`Robot::is_twist`](wingbeat_robot::Robot::is_twist)), W; of an
    /// elastic hinge what it takes from the air and gives to the body is negative.
    pub twist_power: f64,
    /// Mean power of the regulators, W.
    pub regulator_power: f64,
    /// Frequency times the vertical way against the body of the tip that goes furthest, over the speed; dimensionless.
    pub strouhal: f64,
    /// Shares of U^2 c dy dt beyond 12 and 20 deg of incidence, U the speed of the strip's quarter chord in the air.
    pub stalled: [f64; 2],
    /// The shares with an edge of `SOFT_DEG` to either side in place of a sharp one: where an incidence only just passes
    /// the edge and turns, the sharp ones change by the root of what the gait changes by.
    pub softly_stalled: [f64; 2],
    /// The same shares of strips and time alone, as flights count.
    pub stalled_strips: [f64; 2],
    /// Mean shares of separated flow and of lost suction, weighted alike.
    pub separated: [f64; 2],
    /// Heights of a membrane over the chord, `camber` and `camber_forward` of [`Loads`](wingbeat_aero::Loads), of all strips at every step.
    pub heights: Vec<Vec<[f64; 2]>>,
    /// Angles of the flaps, rad, likewise.
    pub flaps: Vec<Vec<f64>>,
    /// Least of all clearances, m.
    pub least_clearance: Option<f64>,
    /// The clearance that it is of, by its place among those of the robot.
    pub nearest: usize,
    /// The least of all in each of equal parts of the cycle, m; of a robot without clearances infinite.
    pub clearances: [f64; PARTS],
    /// Least and largest roll, pitch, rad.
    pub roll: [f64; 2],
    /// The same of the pitch.
    pub pitch: [f64; 2],
    /// Mean roll and pitch, rad.
    pub mean_angles: [f64; 2],
    /// Peak to peak of the vertical motion of the body origin, m.
    pub heave: f64,
}

/// Looks at a cycle of `orbit` at every step; `areas` are those of the strips (m2). Rates of joints and strips are central
/// differences over the cycle, which closes.
///
/// # Errors
/// The [`Fault`] that makes the model unusable on the way.
pub fn measure(cycle: &Cycle, orbit: &Orbit, areas: &[f64]) -> Result<Measures, Fault> {
    let (robot, point) = (cycle.robot(), &orbit.point);
    let paced = robot.paced(point.pace);
    let mut seen: Vec<Observation> = Vec::with_capacity(cycle.steps());
    let mut states: Vec<Vec<f64>> = Vec::with_capacity(cycle.steps());
    let duration = orbit.end.duration;
    let step = duration / cycle.steps() as f64;
    cycle.fly(&point.z, point.pace, &point.inputs, |k, _, x| {
        // At the end of the cycle stands its begin.
        seen.push(paced.observe(k as f64 * step, x, &point.inputs)?);
        states.push(x.to_vec());
        Ok(())
    })?;
    let n = seen.len();
    let mean = |of: &dyn Fn(usize) -> f64| (0..n).map(of).sum::<f64>() / n as f64;
    let around = |k: usize| [(k + n - 1) % n, (k + 1) % n];
    let rate = |k: usize, of: &dyn Fn(&Observation) -> f64| {
        let [before, after] = around(k);
        (of(&seen[after]) - of(&seen[before])) / (2.0 * step)
    };
    let mut measures = Measures {
        lift_over_weight: mean(&|k| {
            let air = (seen[k].air.total() + seen[k].body_drag).force;
            (seen[k].attitude * air)[2]
        }) / (robot.mass() * GRAVITY),
        side_force_over_weight: mean(&|k| (seen[k].air.total() + seen[k].body_drag).force[1])
            / (robot.mass() * GRAVITY),
        cost: Cost::mean(seen.iter().map(|seen| Cost::of(seen, robot.mass()))).unwrap_or_default(),
        regulator_power: mean(&|k| seen[k].regulator_power),
        ..Measures::default()
    };
    for joint in (0..robot.tree().links()).filter(|joint| robot.is_twist(*joint)) {
        measures.twist_power += mean(&|k| seen[k].torques[joint] * rate(k, &|o| o.joints[joint]));
    }
    let layout = robot.layout();
    let swing = |of: &dyn Fn(usize) -> f64| {
        (0..n).map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let angles = |k: usize| seen[k].attitude.roll_pitch_yaw().0;
    measures.roll = swing(&|k| angles(k)[0]);
    measures.pitch = swing(&|k| angles(k)[1]);
    measures.mean_angles = [mean(&|k| angles(k)[0]), mean(&|k| angles(k)[1])];
    let [low, high] = swing(&|k| states[k][layout.position + 2] - orbit.course.climb * (k + 1) as f64 * step);
    measures.heave = high - low;
    // The tip that goes furthest: in a turn they differ.
    let tips = seen[0].outlines.iter().enumerate().flat_map(|(i, points)| {
        [0, points.len().saturating_sub(1)]
            .into_iter()
            .filter(|_| !points.is_empty())
            .map(move |end| (i, end))
    });
    let furthest = tips.map(|(i, end)| {
        let [low, high] = swing(&|k| seen[k].outlines[i][end][0][2]);
        high - low
    });
    let frequency = robot.strokes_per_cycle() as f64 / duration;
    measures.strouhal = frequency * furthest.fold(0.0, f64::max) / orbit.course.speed;
    let heights = |o: &Observation| {
        (0..o.strips.strips).map(|i| [o.strips.camber[i], o.strips.camber_forward[i]]).collect()
    };
    measures.heights = seen.iter().map(heights).collect();
    measures.flaps = seen.iter().map(|o| o.strips.flap[..o.strips.strips].to_vec()).collect();
    let clearances = seen.iter().flat_map(|o| o.clearances.iter().copied().enumerate());
    if let Some((nearest, least)) = clearances.min_by(|a, b| a.1.total_cmp(&b.1)) {
        (measures.nearest, measures.least_clearance) = (nearest, Some(least));
    }
    measures.clearances = [f64::INFINITY; PARTS];
    for (k, o) in seen.iter().enumerate() {
        let least = &mut measures.clearances[k * PARTS / n];
        *least = o.clearances.iter().copied().fold(*least, f64::min);
    }
    let wind = robot.mean_wind();
    let mut total = 0.0;
    let strips = areas.len().min(seen[0].strips.strips);
    let covered = areas.iter().take(strips).filter(|area| **area > 0.0).count().max(1);
    for k in 0..n {
        let (o, x) = (&seen[k], &states[k]);
        let velocity = o.attitude.transpose_mul(Vec3::from_slice(&x[layout.velocity..]) - wind);
        let turning = Vec3::from_slice(&x[layout.rate..]);
        for (i, area) in areas.iter().enumerate().take(strips) {
            let moved: Vec3 = Vec3(std::array::from_fn(|axis| rate(k, &|o| o.strips.quarter_chord[i][axis])));
            let speed = velocity + turning.cross(o.strips.quarter_chord[i]) + moved;
            let weight = speed.norm_squared() * area;
            total += weight;
            let [before, after] = around(k).map(|k| seen[k].strips.incidence[i].abs());
            let here = o.strips.incidence[i].abs();
            for (j, limit) in INCIDENCES_DEG.iter().enumerate() {
                let limit = limit.to_radians();
                let around = [(before + here) / 2.0, here, (here + after) / 2.0];
                measures.stalled[j] += weight * share_beyond(around, limit);
                measures.softly_stalled[j] += weight * soft_step((here - limit) / SOFT_DEG.to_radians());
                if here > limit {
                    measures.stalled_strips[j] += 1.0 / (n * covered) as f64;
                }
            }
            measures.separated[0] += weight * o.strips.separated[i];
            measures.separated[1] += weight * o.strips.suction_lost[i];
        }
    }
    if total > 0.0 {
        let shares = measures.stalled.iter_mut().chain(&mut measures.softly_stalled);
        shares.chain(&mut measures.separated).for_each(|share| *share /= total);
    }
    Ok(measures)
}

/// From 0 at -1 to 1 at 1, level at both.
fn soft_step(x: f64) -> f64 {
    let s = (0.5 * (x + 1.0)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Share of a sample's time in which a number is beyond `limit` that goes evenly from its value half a sample before over
/// its own to that half a sample after: without it shares would jump from gait to gait.
fn share_beyond([before, here, after]: [f64; 3], limit: f64) -> f64 {
    let half = |a: f64, b: f64| match (a > limit, b > limit) {
        (true, true) => 1.0,
        (false, false) => 0.0,
        (true, false) => (a - limit) / (a - b),
        (false, true) => (b - limit) / (b - a),
    };
    (half(before, here) + half(here, after)) / 2.0
}

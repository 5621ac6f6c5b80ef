//! What is seen over a cycle of an orbit.

use super::cycle::{Cycle, PARTS};
use super::newton::Orbit;
use crate::simulate::Cost;
use wingbeat_aero::StallShares;
use wingbeat_math::{GRAVITY, Vec3};
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::{Observation, Robot};

/// Areas of the strips of all surfaces in turn, chord times width, m2.
pub type StripAreas = Vec<f64>;

/// Half the thickness of a wing's skin, by which a clearance falls short, m: choice.
pub const SKIN: f64 = 0.003;

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
    /// Shares of the wing in stall.
    pub stall: StallShares,
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
    let (robot, point, course) = (cycle.robot(), &orbit.point, &orbit.course);
    let paced = robot.paced(point.pace);
    let mut seen: Vec<Observation> = Vec::with_capacity(cycle.steps());
    let mut states: Vec<Vec<f64>> = Vec::with_capacity(cycle.steps());
    let step = orbit.end.duration / cycle.steps() as f64;
    cycle.fly(&point.z, point.pace, &point.inputs, |k, _, x| {
        // At the end of the cycle stands its begin.
        seen.push(paced.observe(k as f64 * step, x, &point.inputs)?);
        states.push(x.to_vec());
        Ok(())
    })?;
    let weight = robot.mass() * GRAVITY;
    let mean = |of: &dyn Fn(&Observation) -> f64| seen.iter().map(of).sum::<f64>() / seen.len() as f64;
    let air = |o: &Observation| (o.air.total() + o.body_drag).force;
    let angle = |o: &Observation, axis: usize| o.attitude.roll_pitch_yaw()[axis];
    let height =
        |(k, x): (usize, &Vec<f64>)| x[robot.layout().position + 2] - course.climb * (k + 1) as f64 * step;
    let [low, high] = swing(states.iter().enumerate().map(height));
    let heights = |o: &Observation| {
        (0..o.strips.strips).map(|i| [o.strips.camber[i], o.strips.camber_forward[i]]).collect()
    };
    let clearances = seen.iter().flat_map(|o| o.clearances.iter().copied().enumerate());
    let (nearest, least) = clearances.min_by(|a, b| a.1.total_cmp(&b.1)).unzip();
    let frequency = robot.strokes_per_cycle() as f64 / orbit.end.duration;
    Ok(Measures {
        lift_over_weight: mean(&|o| (o.attitude * air(o))[2]) / weight,
        cost: Cost::mean(seen.iter().map(|o| Cost::of(o, robot.mass()))).unwrap_or_default(),
        side_force_over_weight: mean(&|o| air(o)[1]) / weight,
        twist_power: twist_power(robot, &seen, step),
        regulator_power: mean(&|o| o.regulator_power),
        strouhal: frequency * furthest(&seen) / course.speed,
        stall: stall(robot, (&seen, &states), step, areas),
        heights: seen.iter().map(heights).collect(),
        flaps: seen.iter().map(|o| o.strips.flap[..o.strips.strips].to_vec()).collect(),
        least_clearance: least,
        nearest: nearest.unwrap_or_default(),
        clearances: least_in_parts(&seen),
        roll: swing(seen.iter().map(|o| angle(o, 0))),
        pitch: swing(seen.iter().map(|o| angle(o, 1))),
        mean_angles: [mean(&|o| angle(o, 0)), mean(&|o| angle(o, 1))],
        heave: high - low,
    })
}

/// Least and largest.
fn swing(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// The steps before and after step `k` of `n`.
fn around(k: usize, n: usize) -> [usize; 2] {
    [(k + n - 1) % n, (k + 1) % n]
}

/// Rate of a number at step `k`.
fn rate(seen: &[Observation], step: f64, k: usize, of: impl Fn(&Observation) -> f64) -> f64 {
    let [before, after] = around(k, seen.len());
    (of(&seen[after]) - of(&seen[before])) / (2.0 * step)
}

fn twist_power(robot: &Robot, seen: &[Observation], step: f64) -> f64 {
    let power = |joint: usize| {
        let at = |k: usize| seen[k].torques[joint] * rate(seen, step, k, |o| o.joints[joint]);
        (0..seen.len()).map(at).sum::<f64>() / seen.len() as f64
    };
    let twists = (0..robot.tree().links()).filter(|joint| robot.is_twist(*joint));
    twists.map(power).fold(0.0, |sum, power| sum + power)
}

/// Vertical way of the tip that goes furthest, m: in a turn they differ.
fn furthest(seen: &[Observation]) -> f64 {
    let ends = |points: usize| [0, points.saturating_sub(1)].into_iter().filter(move |_| points > 0);
    let tips =
        seen[0].outlines.iter().enumerate().flat_map(|(i, of)| ends(of.len()).map(move |end| (i, end)));
    let way = |(i, end): (usize, usize)| {
        let [low, high] = swing(seen.iter().map(|o| o.outlines[i][end][0][2]));
        high - low
    };
    tips.map(way).fold(0.0, f64::max)
}

/// The least clearance in each of equal parts of the cycle, m.
fn least_in_parts(seen: &[Observation]) -> [f64; PARTS] {
    let mut parts = [f64::INFINITY; PARTS];
    for (k, o) in seen.iter().enumerate() {
        let least = &mut parts[k * PARTS / seen.len()];
        *least = o.clearances.iter().copied().fold(*least, f64::min);
    }
    parts
}

/// Shares of the wing in stall.
fn stall(
    robot: &Robot,
    (seen, states): (&[Observation], &[Vec<f64>]),
    step: f64,
    areas: &[f64],
) -> StallShares {
    let (wind, layout) = (robot.mean_wind(), robot.layout());
    let strips = areas.len().min(seen[0].strips.strips);
    let covered = areas.iter().take(strips).filter(|area| **area > 0.0).count().max(1);
    let share = 1.0 / (seen.len() * covered) as f64;
    let mut shares = StallShares::default();
    for (k, (o, x)) in seen.iter().zip(states).enumerate() {
        let velocity = o.attitude.transpose_mul(Vec3::from_slice(&x[layout.velocity..]) - wind);
        let turning = Vec3::from_slice(&x[layout.rate..]);
        let [before, after] = around(k, seen.len()).map(|k| &seen[k].strips.incidence);
        for (i, area) in areas.iter().enumerate().take(strips) {
            let along = |axis| rate(seen, step, k, |o| o.strips.quarter_chord[i][axis]);
            let moved = Vec3(std::array::from_fn(along));
            let speed = velocity + turning.cross(o.strips.quarter_chord[i]) + moved;
            let incidence = [before[i], o.strips.incidence[i], after[i]];
            let separated = [o.strips.separated[i], o.strips.suction_lost[i]];
            shares.see((speed.norm_squared() * area, share), incidence, separated);
        }
    }
    shares.of_all()
}

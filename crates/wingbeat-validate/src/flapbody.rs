//! FLAPBODY-14: a free-floating flapping body with four regulators, the
//! optimal-control problem shared with other solvers.

use crate::{Error, ReferenceTable, reference_table};
use wingbeat::math::{Scalar, Vec3};
use wingbeat::ocp::realtime::{Component, LinearLimit, RealTime, Settings, Tracking};
use wingbeat::plant::{Channel, Fault, Plant};

/// Intervals of problem A.
pub const INTERVALS: usize = 5;
/// Length of an interval of problem A, s.
pub const STEP: f64 = 5e-3;

const MASS: f64 = 0.040;
const INERTIA: [f64; 3] = [1.2e-4, 8.0e-5, 1.6e-4];
const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1.225;
const AREA: f64 = 0.04;
const SPAN: f64 = 0.30;
const CHORD: f64 = 0.12;
const REGULATOR_TIME: f64 = 0.020;
const FLAP_RATE: f64 = 2.0 * std::f64::consts::PI * 3.5;
/// Largest difference of the commands of a pair, dimensionless: they are shares of a stroke.
pub const DIFFERENCE: f64 = 1.2;

/// The plant: x = [roll, pitch, yaw, w(3), v(3), s(4), z], u = commanded strokes.
/// Body axes with z down; Euler angles Z-Y-X.
#[derive(Clone, Debug)]
pub struct FlapBody {
    states: Vec<Channel>,
    inputs: Vec<Channel>,
}

impl Default for FlapBody {
    fn default() -> Self {
        let mut states: Vec<Channel> = ["roll", "pitch", "yaw"].map(|n| Channel::free(n, "rad", "W")).into();
        states.extend(["w_x", "w_y", "w_z"].map(|n| Channel::free(n, "rad/s", "B")));
        states.extend(["v_x", "v_y", "v_z"].map(|n| Channel::free(n, "m/s", "B")));
        states.extend((1..=4).map(|i| Channel::limited(format!("stroke_{i}"), "", "", -1.0, 1.0)));
        states.push(Channel::free("lag", "", ""));
        let inputs = (1..=4).map(|i| Channel::limited(format!("command_{i}"), "", "", -1.0, 1.0)).collect();
        Self { states, inputs }
    }
}

/// State of the recorded flight at t = 0, in the units of its channels.
pub fn initial_state() -> [f64; 14] {
    let mut x = [0.0; 14];
    (x[1], x[6], x[8]) = (-15_f64.to_radians(), 1.0, 0.1);
    x
}

impl Plant for FlapBody {
    fn states(&self) -> &[Channel] {
        &self.states
    }
    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }
    fn rates<S: Scalar>(&self, t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        let (w, v) = (Vec3::from_slice(&x[3..]), Vec3::from_slice(&x[6..]));
        let (sp, cp) = x[0].sin_cos();
        let (st, ct) = x[1].sin_cos();
        let (force, moment, lag_rate) = loads(t, w, v, &x[9..13], x[13]);
        let weight = Vec3([-st, sp * ct, cp * ct]) * S::from(GRAVITY);
        let gyroscopic = w.cross(Vec3(std::array::from_fn(|i| w[i] * INERTIA[i])));
        let turn = sp * w[1] + cp * w[2];
        dx[0] = w[0] + st / ct * turn;
        dx[1] = cp * w[1] - sp * w[2];
        dx[2] = turn / ct;
        let torque = moment - gyroscopic;
        for i in 0..3 {
            dx[3 + i] = torque[i] / INERTIA[i];
        }
        (force * S::from(1.0 / MASS) - w.cross(v) + weight).store(&mut dx[6..]);
        for i in 0..4 {
            dx[9 + i] = (u[i] - x[9 + i]) / REGULATOR_TIME;
        }
        dx[13] = lag_rate;
        Ok(())
    }
}

/// Force and moment in body axes and the rate of the lag state, for the body
/// rates `w`, the velocity `v`, the regulators `s` and the lag `z`.
fn loads<S: Scalar>(t: S, w: Vec3<S>, v: Vec3<S>, s: &[S], z: S) -> (Vec3<S>, Vec3<S>, S) {
    let plunge = (t * FLAP_RATE).cos();
    let speed = (v.norm_squared() + 0.01).sqrt();
    let inverse = speed.recip();
    let alpha = v[2].atan2(v[0] + 0.3);
    let slip = v[1] * inverse;
    let (t1, t2) = (s[0].tanh(), s[1].tanh());
    let effective = alpha + plunge * 0.8 * ((t1 + t2) * 0.25 + 1.0);
    let q = speed * speed * (0.5 * DENSITY * AREA);
    let (se, ce) = effective.sin_cos();
    let lift = se * ce * 4.5 - z * 0.5;
    let drag = se * se * 0.9 + 0.15;
    let (sa, ca) = alpha.sin_cos();
    let thrust = (plunge * 0.3 + (s[0] + s[1]) * 0.2 + 1.0) * 0.25;
    let force =
        Vec3([q * (lift * sa - drag * ca) + thrust, q * slip * (-0.8), -(q * (lift * ca + drag * sa))]);
    let roll = (t1 - t2) * 0.08 * (plunge * 0.5 + 1.0) - w[0] * inverse * (0.15 * SPAN);
    let pitch = (s[2].tanh() + s[3] * plunge * 0.5) * 0.25 - alpha * 0.30 - w[1] * inverse * (1.5 * CHORD)
        + plunge * 0.05;
    let yaw = (s[3] - s[2] * plunge * 0.5) * 0.06 + slip * 0.05 - w[2] * inverse * (0.10 * SPAN);
    let moment = Vec3([q * roll * SPAN, q * pitch * CHORD, q * yaw * SPAN]);
    let lag_rate = speed * (2.0 / CHORD) * ((effective - z) * 0.165 - z * 0.0455);
    (force, moment, lag_rate)
}

/// The cost and linear limits of problem A.
#[derive(Clone, Debug)]
pub struct BankTurn {
    /// Roll reference at nodes 1 to 5, rad.
    pub roll: [f64; INTERVALS],
    limits: Vec<LinearLimit>,
}

impl BankTurn {
    /// Follows the given roll angles, rad, at pitch -15 deg.
    pub fn new(roll: [f64; INTERVALS]) -> Self {
        let pair = |name: &str, i: usize| LinearLimit {
            name: name.into(),
            terms: vec![(Component::State(i), 1.0), (Component::State(i + 1), -1.0)],
            low: -DIFFERENCE,
            high: DIFFERENCE,
        };
        Self { roll, limits: vec![pair("stroke_1 - stroke_2", 9), pair("stroke_3 - stroke_4", 11)] }
    }
}

impl Tracking for BankTurn {
    fn residuals(&self, node: usize) -> usize {
        if node == 0 { 4 } else { 9 }
    }
    fn residual<S: Scalar>(&self, node: usize, _t: f64, x: &[S], u: &[S], r: &mut [S]) {
        for (r, u) in r.iter_mut().zip(u) {
            *r = *u * 1e-3_f64.sqrt();
        }
        if node > 0 {
            r[4] = (x[0] - self.roll[node - 1]) * 10.0;
            r[5] = (x[1] + 15_f64.to_radians()) * 10.0;
            for i in 0..3 {
                r[6 + i] = x[3 + i] * 0.1_f64.sqrt();
            }
        }
    }
    fn change_weight(&self, _input: usize) -> f64 {
        1e-2
    }
    fn limits(&self) -> &[LinearLimit] {
        &self.limits
    }
}

/// A recorded instance of problem A and its optimum.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Time, s.
    pub time: f64,
    /// State at node 0, in the units of its channels.
    pub state: Vec<f64>,
    /// The problem.
    pub problem: BankTurn,
    /// Optimal inputs, node by node, 6 x 4, in the units of their channels.
    pub inputs: Vec<f64>,
    /// Optimal cost, dimensionless.
    pub cost: f64,
}

/// The 200 recorded instances.
pub fn instances() -> Result<Vec<Instance>, Error> {
    let table: ReferenceTable = reference_table!("flapbody14/instances.csv")?;
    let columns: Vec<Vec<f64>> = (0..45).map(|j| table.column_at(j)).collect::<Result<_, _>>()?;
    let row = |i: usize, range: std::ops::Range<usize>| range.map(|j| columns[j][i]).collect::<Vec<f64>>();
    let instance = |i: usize| Instance {
        time: columns[0][i],
        state: row(i, 1..15),
        problem: BankTurn::new(std::array::from_fn(|k| columns[15 + k][i])),
        inputs: row(i, 20..44),
        cost: columns[44][i],
    };
    Ok((0..table.len()).map(instance).collect())
}

/// The real-time solver of problem A.
pub fn solver(plant: &FlapBody) -> Result<RealTime, Error> {
    Ok(RealTime::new(plant, &BankTurn::new([0.0; INTERVALS]), Settings::new(INTERVALS, STEP))?)
}

//! A plant of one's own under the predictive controller: a rigid body that three reaction wheels turn.
//!
//! `cargo run --release --example own_plant`

use std::collections::BTreeMap;
use std::error::Error;
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat::guide::{Mpc, MpcSpec, Turn, Weights};
use wingbeat::math::{Quat, Scalar, Vec3};
use wingbeat::plant::{Channel, Fault, Plant, Role};
use wingbeat::simulate::{Schedule, Sensors, fly};

/// Principal inertia of the body, kg m2.
const INERTIA: [f64; 3] = [2e-5, 3e-5, 4e-5];
/// Largest torque of a wheel, N m.
const TORQUE: f64 = 2e-4;

/// States: attitude quaternion and angular rate; inputs: torques.
struct Satellite {
    states: Vec<Channel>,
    inputs: Vec<Channel>,
}

impl Satellite {
    fn new() -> Self {
        let attitude = ["q_w", "q_x", "q_y", "q_z"].iter().enumerate();
        let attitude = attitude.map(|(i, name)| Channel::free(*name, "", "WB").of(Role::Attitude(i)));
        let rates = ["w_x", "w_y", "w_z"].iter().enumerate();
        let rates = rates.map(|(i, name)| Channel::free(*name, "rad/s", "B").of(Role::AngularRate(i)));
        let torque = |name| Channel::limited(name, "N m", "B", -TORQUE, TORQUE);
        Self {
            states: attitude.chain(rates).collect(),
            inputs: ["torque_x", "torque_y", "torque_z"].map(torque).into(),
        }
    }
}

impl Plant for Satellite {
    fn states(&self) -> &[Channel] {
        &self.states
    }

    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }

    fn attitude(&self) -> Option<usize> {
        Some(0)
    }

    /// q' = q w / 2, I w' = torque - w x I w (Euler).
    fn rates<S: Scalar>(&self, _t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        let w = Vec3::from_slice(&x[4..]);
        Quat::from_wxyz(x).rate(w).store_wxyz(dx);
        let momentum = Vec3(std::array::from_fn(|i| w[i] * INERTIA[i]));
        let gyroscopic = w.cross(momentum);
        for i in 0..3 {
            dx[4 + i] = (u[i] - gyroscopic[i]) / INERTIA[i];
        }
        Ok(())
    }
}

/// Runs the example.
pub fn main() -> Result<(), Box<dyn Error>> {
    let (satellite, turn) = (Satellite::new(), Turn { roll_deg: 30.0, nose_up_deg: 10.0, ..Turn::default() });
    let spec = MpcSpec {
        period_s: 0.01,
        intervals: 10,
        interval_s: Some(0.05),
        horizon_cycles: None,
        horizon_between_cycles: None,
        prepared: false,
        iterations: 2,
        continuous_input: false,
        input_rate_per_s: BTreeMap::new(),
        deadline_s: None,
        clearance_m: 0.0,
        clearance_width_m: 1e-3,
        weights: Weights {
            roll: 1.0,
            pitch: 1.0,
            rate_axes: None,
            rate: 0.1,
            input: 0.01,
            input_change: 0.0,
            clearance: 0.0,
            terminal: 2.0,
        },
    };
    let mut controller = Mpc::new(&satellite, Arc::new(turn), &spec)?;
    let schedule = Schedule { step: 1e-3, steps: 2000, steps_per_update: Some(10), steps_per_sample: 100 };
    let mut x = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut sensors = Sensors::perfect(&satellite);
    let flight = fly(&satellite, &mut sensors, &mut controller, &schedule, &mut x, |sample, _| {
        let angles = Quat::from_wxyz(sample.x).matrix().roll_pitch_yaw().0.map(f64::to_degrees);
        println!(
            "{:4.1} s: roll {:6.2}, pitch {:6.2}, yaw {:6.2} deg",
            sample.t, angles[0], angles[1], angles[2]
        );
        Ok(ControlFlow::Continue(()))
    });
    let angles = Quat::from_wxyz(&x).matrix().roll_pitch_yaw().0.map(f64::to_degrees);
    assert_eq!(flight.failures, 0);
    assert!((angles[0] - 30.0).abs() < 0.5 && (angles[1] + 10.0).abs() < 0.5, "{angles:?}");
    Ok(())
}

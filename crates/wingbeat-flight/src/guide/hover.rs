//! Hover on thrusters about beating wings that the controller does not see.

use super::controllers::{ControllerSpec, ControllerTask};
use crate::simulate::{AXES, Column, Controller, Measurement, Update};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{GRAVITY, Vec3};
use wingbeat_ocp::plant::{Channel, Plant, Role};
use wingbeat_robot::Thruster;

/// Smallest ratio of the thrusters' singular values with which they push and turn in all directions. *Choice.*
const DEGENERATE: f64 = 1e-6;

/// Holds place and attitude by thrusters. The model is a rigid body under thrust and gravity alone; an extended state
/// observer finds the rest, which is what the wings and the air do, and the thrusters balance its slow part.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct HoverSpec {
    /// Time between updates, s.
    pub period_s: f64,
    /// Place to hold, in W, m.
    #[serde(default)]
    pub place_m: [f64; 3],
    /// Principal inertias of the whole robot as the controller has them, kg m2.
    pub inertia_kg_m2: [f64; 3],
    /// Natural frequency of the place, rad/s; damping ratio 1.
    pub place_rad_s: f64,
    /// Natural frequency of the attitude, rad/s; damping ratio 1.
    pub attitude_rad_s: f64,
    /// Bandwidth of the observer, rad/s: its poles.
    pub observer_rad_s: f64,
}

ranges!(HoverSpec {
    period_s: Range::POSITIVE,
    place_m: Range::between(-1000.0, 1000.0),
    inertia_kg_m2: Range::POSITIVE,
    place_rad_s: Range::POSITIVE,
    attitude_rad_s: Range::POSITIVE,
    observer_rad_s: Range::POSITIVE,
});

/// An extended state observer of an axis: place, velocity, and the acceleration that no input explains.
#[derive(Clone, Copy, Debug, Default)]
struct Observer {
    place: f64,
    rate: f64,
    unknown: f64,
}

impl Observer {
    /// Over `dt` s under the known acceleration, from the measured place; all poles at `w` rad/s.
    ///
    /// Equation: guide.extended_state
    /// `p' = v, v' = known + unknown, unknown' = 0, corrected by l (p - p_x) with all poles at exp(-w dt): l = [1 -
    /// z^3, 3/2 (1 - z)^2 (1 + z)/dt, (1 - z)^3/dt^2]`
    /// Source: Han 2009, IEEE TIE 56(3); Gao 2003 (one bandwidth); the sampled gains those of the critically damped
    /// filter, Brookner 1998, ch. 1.
    /// Test: `the_observer_finds_a_force_that_it_does_not_know_with_its_own_poles`.
    fn follow(&mut self, dt: f64, w: f64, known: f64, measured: f64) {
        // The observer of a sampled triple integrator whose poles are all at z = exp(-w dt).
        let z = (-w * dt).exp();
        let predicted = self.place + self.rate * dt + 0.5 * (self.unknown + known) * dt * dt;
        let off = measured - predicted;
        let one = 1.0 - z;
        self.place = predicted + (1.0 - z * z * z) * off;
        self.rate += (self.unknown + known) * dt + 1.5 * one * one * (1.0 + z) / dt * off;
        self.unknown += one * one * one / (dt * dt) * off;
    }
}

/// The controller.
struct Hover<'a> {
    spec: HoverSpec,
    mass: f64,
    thrusters: &'a [Thruster],
    inputs: &'a [Channel],
    /// Thrusts by the wrench asked.
    share: DMatrix<f64>,
    place: [Observer; 3],
    /// Of the rotation vector, small.
    turn: [Observer; 3],
    started: bool,
    held: Vec<f64>,
    /// Error of the place, force of the air.
    seen: [Vec3; 2],
}

impl ControllerSpec for HoverSpec {
    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn build<'a>(&self, task: ControllerTask<'a>) -> Result<Box<dyn Controller + 'a>, Error> {
        self.in_range()?;
        let robot = task.model;
        let thrusters = robot.thrusters();
        let columns: Vec<DVector<f64>> = thrusters
            .iter()
            .map(|thruster| {
                let wrench = thruster.wrench(1.0);
                DVector::from_iterator(6, wrench.force.0.into_iter().chain(wrench.moment.0))
            })
            .collect();
        let allowed = "a robot with thrusters that push and turn it in all directions: six or more";
        let missing = || Error::invalid("", "given", allowed);
        if thrusters.len() < 6 {
            return Err(missing());
        }
        let by_thrust = DMatrix::from_columns(&columns);
        let values = by_thrust.singular_values();
        let (least, most) = (values.min(), values.max());
        if !(least > DEGENERATE * most) {
            return Err(missing());
        }
        let share = by_thrust.pseudo_inverse(DEGENERATE * most).map_err(|_| missing())?;
        Ok(Box::new(Hover {
            mass: robot.mass(),
            thrusters,
            inputs: robot.inputs(),
            share,
            place: [Observer::default(); 3],
            turn: [Observer::default(); 3],
            started: false,
            held: vec![0.0; robot.inputs().len()],
            seen: [Vec3::ZERO; 2],
            spec: self.clone(),
        }))
    }
}

impl Hover<'_> {
    /// Force and moment of the thrusters as they are measured, in B.
    fn thrust(&self, measurement: &Measurement) -> Option<[Vec3; 2]> {
        let mut sum = [Vec3::ZERO; 2];
        for thruster in self.thrusters {
            let wrench = thruster.wrench(measurement.value(Role::Displacement(thruster.element))?);
            sum[0] += wrench.force;
            sum[1] += wrench.moment;
        }
        Some(sum)
    }

    /// Plans from the measurement; `None` where too little is measured.
    ///
    /// Equation: guide.hover
    /// `F = m R'(-w^2 (p - p_0) - 2 w v - unknown + g), M = I (-w_a^2 d - 2 w_a d' - unknown) + w x I w; thrusts of
    /// least norm`
    /// Source: feedback linearisation with disturbance rejection, Han 2009.
    /// Test: `a_guarded_robot_hovers_and_its_observer_finds_the_force_of_the_air`.
    fn plan(&mut self, measurement: &Measurement) -> Option<()> {
        let (place, attitude) = (measurement.vector(Role::Position)?, measurement.attitude()?);
        let rate = measurement.vector(Role::AngularRate)?;
        let [force, moment] = self.thrust(measurement)?;
        let (matrix, turned) = (attitude.matrix(), attitude.log());
        let (spec, dt) = (&self.spec, self.spec.period_s);
        let inertia = Vec3(spec.inertia_kg_m2);
        let turning = |w: Vec3| Vec3(std::array::from_fn(|i| inertia[i] * w[i]));
        let gyroscopic = rate.cross(turning(rate));
        let pushed = matrix * force * (1.0 / self.mass) - Vec3::new(0.0, 0.0, GRAVITY);
        for i in 0..3 {
            if !self.started {
                self.place[i].place = place[i];
                self.turn[i].place = turned[i];
            }
            self.place[i].follow(dt, spec.observer_rad_s, pushed[i], place[i]);
            let turned_by = (moment[i] - gyroscopic[i]) / inertia[i];
            self.turn[i].follow(dt, spec.observer_rad_s, turned_by, turned[i]);
        }
        self.started = true;
        let of = |observers: &[Observer; 3], w: f64, target: Vec3| {
            Vec3(std::array::from_fn(|i| {
                let o = observers[i];
                -w * w * (o.place - target[i]) - 2.0 * w * o.rate - o.unknown
            }))
        };
        let target = Vec3(spec.place_m);
        let asked = of(&self.place, spec.place_rad_s, target) + Vec3::new(0.0, 0.0, GRAVITY);
        let force = matrix.transpose_mul(asked * self.mass);
        let moment = turning(of(&self.turn, spec.attitude_rad_s, Vec3::ZERO)) + gyroscopic;
        let wrench = DVector::from_iterator(6, force.0.into_iter().chain(moment.0));
        let thrusts = &self.share * wrench;
        for (thruster, thrust) in self.thrusters.iter().zip(thrusts.iter()) {
            self.held[thruster.element] = self.inputs[thruster.element].clamp(*thrust);
        }
        let unknown = Vec3(std::array::from_fn(|i| self.place[i].unknown));
        self.seen = [place - target, unknown * self.mass];
        Some(())
    }
}

impl Controller for Hover<'_> {
    fn update(&mut self, _: f64, measurement: &Measurement) -> Update {
        self.plan(measurement).map_or(Update::Kept, |()| Update::Fresh)
    }

    fn input(&self, _: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.held);
    }

    fn columns(&self) -> Vec<Column> {
        let errors = AXES.map(|axis| Column::new(format!("hover_error_{axis}"), "m", "W"));
        let forces = AXES.map(|axis| Column::new(format!("hover_force_{axis}"), "N", "W"));
        let asked = AXES.map(|axis| Column::new(format!("hover_asked_{axis}"), "m", "W"));
        errors.into_iter().chain(forces).chain(asked).collect()
    }

    fn diagnostics(&self, row: &mut Vec<f64>) {
        row.extend(self.seen.iter().flat_map(|vector| vector.0).chain(self.spec.place_m));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_observer_finds_a_force_that_it_does_not_know_with_its_own_poles() {
        let (dt, w, unknown) = (5e-3, 12.0, -3.0);
        let (mut observer, mut place, mut rate) = (Observer::default(), 0.0, 0.0);
        for k in 0..400 {
            let known = (0.3 * k as f64).sin();
            place += rate * dt + 0.5 * (known + unknown) * dt * dt;
            rate += (known + unknown) * dt;
            observer.follow(dt, w, known, place);
            // A triple pole leaves (1 + w t + (w t)^2 / 2) exp(-w t) of a step, a little more when sampled.
            let left = w * dt * (k + 1) as f64;
            let bound = 3.0 * (1.0 + left + 0.5 * left * left) * (-left).exp() + 1e-9;
            assert!((observer.unknown - unknown).abs() < 1.2 * bound, "{k}: {}", observer.unknown);
        }
        assert!((observer.unknown - unknown).abs() < 1e-6 && (observer.rate - rate).abs() < 1e-6);
    }
}

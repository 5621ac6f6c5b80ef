//! The cost of the predictive controller: attitude, angular rate, inputs, and soft limits of clearances.

use super::manoeuvre::{Manoeuvre, angle_error};
use super::mpc::{MpcSpec, Weights};
use super::soft_clearance::SoftClearance;
use std::ops::Range;
use std::sync::Arc;
use wingbeat_math::Error;
use wingbeat_math::Scalar;
use wingbeat_ocp::plant::{Channel, LocalChart, Plant, Role};
use wingbeat_ocp::realtime::Tracking;

/// The paper's cost J = sum (z - z_ref)' C (z - z_ref), z = [roll, pitch, w],
/// on the nodes after the first, with a small cost on the inputs at all nodes; and the soft limits of the clearances.
pub struct AttitudeTracking<'a, P: Plant> {
    pub(super) chart: LocalChart<'a, P>,
    manoeuvre: Arc<dyn Manoeuvre>,
    weights: Weights,
    /// Index of the angular rate in the local state.
    rate: usize,
    /// Residual per input, weight over half range.
    input_weights: Vec<f64>,
    /// Cost per squared change of an input.
    change_weights: Vec<f64>,
    /// Largest rate per input, per second.
    rate_limits: Vec<f64>,
    clearance: SoftClearance,
    /// The last node.
    last: usize,
}

impl<'a, P: Plant> AttitudeTracking<'a, P> {
    pub(super) fn new(plant: &'a P, manoeuvre: Arc<dyn Manoeuvre>, spec: &MpcSpec) -> Result<Self, Error> {
        let chart = LocalChart::new(plant);
        let missing = |what: &str| Error::invalid("plant", what, "a plant with attitude and angular rate");
        chart.rotation().ok_or_else(|| missing("no attitude"))?;
        let rate = Role::AngularRate(0).place(chart.states());
        let half_range = |c: &Channel| 0.5 * (c.high - c.low);
        let inputs = plant.inputs();
        let (weight, limit, width) = (spec.weights.clearance, spec.clearance_m, spec.clearance_width_m);
        Ok(Self {
            manoeuvre,
            weights: spec.weights.clone(),
            rate: rate.ok_or_else(|| missing("no angular rate"))?,
            input_weights: inputs.iter().map(|c| spec.weights.input / half_range(c)).collect(),
            change_weights: inputs
                .iter()
                .map(|c| (spec.weights.input_change / half_range(c)).powi(2))
                .collect(),
            rate_limits: spec.rate_limits(inputs)?,
            clearance: SoftClearance::new(plant, "weights.clearance", weight, limit, width)?,
            last: spec.intervals,
            chart,
        })
    }
}

impl<P: Plant> Tracking for AttitudeTracking<'_, P> {
    fn residuals(&self, node: usize) -> usize {
        self.input_weights.len() + if node == 0 { 0 } else { 5 + self.clearance.count }
    }

    fn residual<S: Scalar>(&self, node: usize, t: f64, x: &[S], u: &[S], r: &mut [S]) {
        let (inputs, outputs) = r.split_at_mut(self.input_weights.len());
        for (i, r) in inputs.iter_mut().enumerate() {
            *r = u[i] * self.input_weights[i];
        }
        if node == 0 {
            return;
        }
        let angles = self.chart.rotation_matrix(x).roll_pitch_yaw();
        let reference = self.manoeuvre.reference(t);
        let factor = if node == self.last { self.weights.terminal } else { 1.0 };
        outputs[0] = angle_error(angles[0], reference.roll) * (self.weights.roll * factor);
        outputs[1] = angle_error(angles[1], reference.pitch) * (self.weights.pitch * factor);
        let rates = self.weights.rates();
        for (i, weight) in rates.into_iter().enumerate() {
            outputs[2 + i] = (x[self.rate + i] - reference.w[i]) * (weight * factor);
        }
        self.clearance.shortfalls(&self.chart, t, x, &mut outputs[5..]);
    }

    fn known_states(&self, states: usize) -> Range<usize> {
        // Clearances know the shape.
        let rotation = self.chart.rotation().filter(|_| self.clearance.count == 0);
        rotation.map_or(0..states, |rotation| rotation.min(self.rate)..rotation.max(self.rate) + 3)
    }

    fn change_weight(&self, input: usize) -> f64 {
        self.change_weights[input]
    }

    fn rate_limit(&self, input: usize) -> f64 {
        self.rate_limits[input]
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Mpc, Turn};
    use super::*;
    use std::collections::BTreeMap;
    use wingbeat_math::{Dual, Quat, Vec3};
    use wingbeat_ocp::plant::Fault;

    /// A free body with two clearances that bend with time and state.
    struct BendingBody {
        states: Vec<Channel>,
        inputs: Vec<Channel>,
        clearances: Vec<Channel>,
    }

    impl Plant for BendingBody {
        fn states(&self) -> &[Channel] {
            &self.states
        }
        fn inputs(&self) -> &[Channel] {
            &self.inputs
        }
        fn attitude(&self) -> Option<usize> {
            Some(0)
        }
        fn rates<S: Scalar>(&self, _: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
            Quat::from_wxyz(x).rate(Vec3::from_slice(&x[4..])).store_wxyz(dx);
            dx[4..7].copy_from_slice(u);
            Ok(())
        }
        fn clearances(&self) -> &[Channel] {
            &self.clearances
        }
        fn clear<S: Scalar>(&self, t: S, x: &[S], values: &mut [S]) -> Result<(), Fault> {
            values[0] = (t + x[4]).sin() * 0.01;
            values[1] = x[1] * x[5] + 0.02;
            Ok(())
        }
    }

    fn body() -> BendingBody {
        let roles = (0..4).map(Role::Attitude).chain((0..3).map(Role::AngularRate));
        BendingBody {
            states: roles.map(|role| Channel::free(format!("{role:?}"), "", "").of(role)).collect(),
            inputs: ["x", "y", "z"].map(|n| Channel::limited(n, "N m", "B", -1.0, 1.0)).into(),
            clearances: ["one", "other"].map(|n| Channel::free(n, "m", "B")).into(),
        }
    }

    fn spec(clearance: f64) -> MpcSpec {
        let weights = Weights {
            roll: 1.0,
            pitch: 1.0,
            rate: 0.1,
            rate_axes: None,
            input: 0.01,
            input_change: 0.0,
            clearance,
            terminal: 2.0,
        };
        MpcSpec {
            period_s: 0.01,
            intervals: 3,
            interval_s: Some(0.02),
            horizon_cycles: None,
            horizon_between_cycles: None,
            prepared: false,
            iterations: 1,
            continuous_input: true,
            input_rate_per_s: BTreeMap::new(),
            deadline_s: None,
            clearance_m: 0.015,
            clearance_width_m: 1e-3,
            weights,
        }
    }

    #[test]
    fn residuals_of_the_soft_limit_and_their_derivatives_are_exact() {
        let turn = Turn { roll_deg: 10.0, nose_up_deg: 5.0, yaw_rate_rad_s: 0.1, ..Turn::default() };
        let plant = body();
        let mut tracking = AttitudeTracking::new(&plant, Arc::new(turn), &spec(50.0)).unwrap();
        tracking.chart.center_at(&[0.9, 0.3, -0.2, 0.1, 0.0, 0.0, 0.0]);
        assert_eq!([0, 1, 3].map(|node| tracking.residuals(node)), [3, 10, 10]);
        let (x, u, t) = ([0.05, -0.1, 0.2, 0.3, -0.02, 0.4], [0.1, 0.2, -0.3], 0.35);
        let at = |x: &[f64; 6]| {
            let mut r = [0.0; 10];
            tracking.residual(3, t, x, &u, &mut r);
            r
        };
        let short = |c: f64| 25.0 * (0.015 - c + (0.015 - c).hypot(1e-3));
        assert!((at(&x)[8] - short(0.01 * (t + x[3]).sin())).abs() < 1e-14);
        for i in 0..6 {
            let mut dual = x.map(Dual::<1>::constant);
            dual[i].eps[0] = 1.0;
            let mut exact = [Dual::<1>::ZERO; 10];
            tracking.residual(3, t, &dual, &u.map(Dual::constant), &mut exact);
            let moved = |h: f64| {
                let mut x = x;
                x[i] += h;
                at(&x)
            };
            let (h, k) = (moved(1e-6), moved(-1e-6));
            for r in 0..10 {
                let difference = (h[r] - k[r]) / 2e-6;
                assert!((exact[r].eps[0] - difference).abs() < 1e-6, "{r} by {i}");
            }
        }
    }

    #[test]
    fn the_cost_has_five_entries_of_its_own() {
        let plant = body();
        let residuals = |rate_axes: Option<[f64; 3]>| {
            let weights = Weights { roll: 2.0, pitch: 3.0, rate_axes, ..spec(0.0).weights };
            let spec = MpcSpec { weights, ..spec(0.0) };
            let mut tracking = AttitudeTracking::new(&plant, Arc::new(Turn::default()), &spec).unwrap();
            tracking.chart.center_at(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let mut r = [0.0; 8];
            tracking.residual(1, 0.1, &[0.1, 0.0, 0.0, 1.0, 1.0, 1.0], &[0.0; 3], &mut r);
            r
        };
        assert_eq!(residuals(Some([0.1; 3])), residuals(None));
        let own = residuals(Some([0.5, 0.7, 0.9]));
        assert_eq!(own[..5], residuals(None)[..5]);
        assert_eq!(own[5..], [0.5, 0.7, 0.9]);
    }

    #[test]
    fn a_soft_limit_needs_clearances() {
        let bare = BendingBody { clearances: Vec::new(), ..body() };
        let manoeuvre = || Arc::new(Turn::default());
        let error = Mpc::new(&bare, manoeuvre(), &spec(1.0)).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.starts_with("weights.clearance = 1"), "{error}");
        assert!(Mpc::new(&bare, manoeuvre(), &spec(0.0)).is_ok());
    }
}

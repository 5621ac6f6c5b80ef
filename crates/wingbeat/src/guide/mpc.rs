//! Model predictive control of attitude by direct collocation.

use super::controllers::{ControllerSpec, Task};
use super::manoeuvre::{Manoeuvre, angle_error};
use crate::Error;
use crate::math::Scalar;
use crate::ocp::realtime::{HorizonSolver, Plan, RealTime, Settings, Tracking};
use crate::plant::{Channel, LocalChart, Plant, Role};
use crate::range::{Range, ranges};
use crate::require;
use crate::simulate::{Column, Controller, Estimator, Measurement, TrueState, Update};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest horizon, and most iterations of an update.
const MAX_INTERVALS: usize = 100;

/// Horizon and cost of the controller.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct MpcSpec {
    /// Time between updates, s.
    pub period_s: f64,
    /// Intervals of the horizon.
    pub intervals: usize,
    /// Length of an interval, s.
    pub interval_s: f64,
    /// Iterations of sequential quadratic programming per update.
    pub iterations: usize,
    /// The plan's first input is the last one applied; else it may jump.
    #[serde(default)]
    pub continuous_input: bool,
    /// Largest rate of inputs by their channel, in its unit per second; the
    /// others have none. Needs `continuous_input`: a jump has no finite rate.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub input_rate_per_s: BTreeMap<String, f64>,
    /// An update that takes longer by the wall clock is dropped and counted, s;
    /// without it none is. A flight with a deadline does not repeat to the bit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deadline_s: Option<f64>,
    /// Clearance below which the soft limit `weights.clearance` counts, m.
    #[serde(default)]
    pub clearance_m: f64,
    /// Width over which that limit is rounded off, m: within it the limit is felt already.
    #[serde(default = "clearance_width")]
    pub clearance_width_m: f64,
    /// Weights.
    pub weights: Weights,
}

/// Weights of the residuals; the cost holds their squares.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// Roll error, per rad.
    pub roll: f64,
    /// Pitch error, per rad.
    pub pitch: f64,
    /// Angular-rate error, per rad/s.
    pub rate: f64,
    /// Angular-rate error about each body axis, per rad/s, in place of `rate`: with roll and pitch the roots of the five
    /// diagonal entries of the paper's C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_axes: Option<[f64; 3]>,
    /// Input, per half of its range.
    pub input: f64,
    /// Change of the input over an interval, per half of its range.
    #[serde(default)]
    pub input_change: f64,
    /// Clearance short of `clearance_m`, per m, at the nodes after the first; 0 for none.
    #[serde(default)]
    pub clearance: f64,
    /// Factor on the state residuals of the last node: the terminal cost.
    #[serde(default = "one")]
    pub terminal: f64,
}

/// *Choice.*
fn clearance_width() -> f64 {
    1e-3
}

fn one() -> f64 {
    1.0
}

impl ControllerSpec for MpcSpec {
    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn build<'a>(&self, task: Task<'a>) -> Result<Box<dyn Controller + 'a>, Error> {
        let allowed = "a manoeuvre to fly: add [manoeuvre]";
        let manoeuvre = task.manoeuvre.ok_or_else(|| Error::invalid("", "given", allowed))?;
        Ok(match task.solver {
            None => Box::new(Mpc::new(task.model, manoeuvre, self)?),
            Some(solver) => {
                let make = |chart: &_, tracking: &_, settings| solver.build(chart, tracking, settings);
                Box::new(Mpc::with(task.model, manoeuvre, self, TrueState, make)?)
            }
        })
    }
}

ranges!(MpcSpec {
    period_s: Range::POSITIVE,
    intervals: Range::between(1.0, MAX_INTERVALS as f64),
    interval_s: Range::POSITIVE,
    iterations: Range::between(1.0, MAX_INTERVALS as f64),
    deadline_s: Range::POSITIVE,
    clearance_width_m: Range::POSITIVE,
    input_rate_per_s: Range::POSITIVE,
});
ranges!(Weights {
    roll: Range::NOT_NEGATIVE,
    pitch: Range::NOT_NEGATIVE,
    rate: Range::NOT_NEGATIVE,
    rate_axes: Range::NOT_NEGATIVE,
    input: Range::POSITIVE,
    input_change: Range::NOT_NEGATIVE,
    clearance: Range::NOT_NEGATIVE,
    terminal: Range::NOT_NEGATIVE,
});

impl MpcSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.weights.in_range().map_err(|e| e.within("weights"))?;
        require::finite("clearance_m", &[self.clearance_m])?;
        if !self.input_rate_per_s.is_empty() && !self.continuous_input {
            let allowed = "true where input_rate_per_s is given: an input that jumps has no finite rate";
            return Err(Error::invalid("continuous_input", false, allowed));
        }
        Ok(())
    }

    /// The rate limit of each input of a plant, infinite where none is given.
    fn rate_limits(&self, inputs: &[Channel]) -> Result<Vec<f64>, Error> {
        let known = |name: &String| inputs.iter().any(|c| c.name == *name);
        if let Some((name, rate)) = self.input_rate_per_s.iter().find(|(name, _)| !known(name)) {
            let names: Vec<&str> = inputs.iter().map(|c| c.name.as_str()).collect();
            let allowed = format!("the inputs {}", names.join(", "));
            return Err(Error::invalid(format!("input_rate_per_s.{name}"), rate, allowed));
        }
        let limit = |c: &Channel| self.input_rate_per_s.get(&c.name).copied().unwrap_or(f64::INFINITY);
        Ok(inputs.iter().map(limit).collect())
    }
}

/// Most clearances of a plant that a controller may watch.
const MAX_CLEARANCES: usize = 16;

/// The paper's cost J = sum (z - z_ref)' C (z - z_ref), z = [roll, pitch, w],
/// on the nodes after the first, with a small cost on the inputs at all nodes; and the soft limits of the clearances.
pub struct AttitudeTracking<'a, P: Plant> {
    chart: LocalChart<'a, P>,
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
    /// Number of clearances with a soft limit.
    clearances: usize,
    /// Their limit, and the width over which it is rounded off, m.
    clearance: f64,
    clearance_width: f64,
    /// The last node.
    last: usize,
}

impl<'a, P: Plant> AttitudeTracking<'a, P> {
    fn new(plant: &'a P, manoeuvre: Arc<dyn Manoeuvre>, spec: &MpcSpec) -> Result<Self, Error> {
        let chart = LocalChart::new(plant);
        let missing = |what: &str| Error::invalid("plant", what, "a plant with attitude and angular rate");
        chart.rotation().ok_or_else(|| missing("no attitude"))?;
        let rate = Role::AngularRate(0).place(chart.states());
        let half_range = |c: &Channel| 0.5 * (c.high - c.low);
        let inputs = plant.inputs();
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
            clearances: soft_limits(plant, spec)?,
            clearance: spec.clearance_m,
            clearance_width: spec.clearance_width_m,
            last: spec.intervals,
            chart,
        })
    }

    /// Weight times the smooth positive part of what each clearance is short of its limit. Where the model cannot
    /// be evaluated it has none: its rates refuse the state.
    ///
    /// Equation: guide.soft_clearance
    fn shortfalls<S: Scalar>(&self, t: f64, x: &[S], r: &mut [S]) {
        let mut clearances = [S::ZERO; MAX_CLEARANCES];
        let clearances = &mut clearances[..self.clearances];
        if self.chart.clear(S::from(t), x, clearances).is_err() {
            return r.fill(S::ZERO);
        }
        for (r, c) in r.iter_mut().zip(clearances) {
            *r = (-*c + self.clearance).smooth_positive(self.clearance_width) * self.weights.clearance;
        }
    }
}

/// Number of clearances under the soft limit.
fn soft_limits<P: Plant>(plant: &P, spec: &MpcSpec) -> Result<usize, Error> {
    if spec.weights.clearance == 0.0 {
        return Ok(0);
    }
    match plant.clearances().len() {
        count @ 1..=MAX_CLEARANCES => Ok(count),
        count => {
            let allowed = format!("0 for a robot with {count} clearances; with 1 to {MAX_CLEARANCES} any");
            Err(Error::invalid("weights.clearance", spec.weights.clearance, allowed))
        }
    }
}

impl<P: Plant> Tracking for AttitudeTracking<'_, P> {
    fn residuals(&self, node: usize) -> usize {
        self.input_weights.len() + if node == 0 { 0 } else { 5 + self.clearances }
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
        let rates = self.weights.rate_axes.unwrap_or([self.weights.rate; 3]);
        for (i, weight) in rates.into_iter().enumerate() {
            outputs[2 + i] = (x[self.rate + i] - reference.w[i]) * (weight * factor);
        }
        if self.clearances > 0 {
            self.shortfalls(t, x, &mut outputs[5..]);
        }
    }

    fn change_weight(&self, input: usize) -> f64 {
        self.change_weights[input]
    }

    fn rate_limit(&self, input: usize) -> f64 {
        self.rate_limits[input]
    }
}

/// Predictive controller of any plant with an attitude and an angular rate among its states.
/// It plans from the state that its estimator `E` makes of the measurement, with the horizon solver `H`.
pub struct Mpc<'a, P: Plant, E = TrueState, H = RealTime> {
    tracking: AttitudeTracking<'a, P>,
    solver: H,
    /// The plan to go on with when an update comes late.
    previous: Plan,
    deadline: Option<Duration>,
    iterations: usize,
    last_update: Option<f64>,
    local: Vec<f64>,
    estimator: E,
    estimate: Vec<f64>,
    applied: Vec<f64>,
}

impl<'a, P: Plant> Mpc<'a, P> {
    /// A controller of `plant` for a manoeuvre that takes what is measured for the true state and plans
    /// with [`RealTime`].
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is out of range, or the plant has no
    /// attitude or angular rate.
    pub fn new(plant: &'a P, manoeuvre: Arc<dyn Manoeuvre>, spec: &MpcSpec) -> Result<Self, Error> {
        Self::with(plant, manoeuvre, spec, TrueState, RealTime::new)
    }
}

impl<'a, P, E, H> Mpc<'a, P, E, H>
where
    P: Plant,
    E: Estimator,
    H: HorizonSolver<LocalChart<'a, P>, AttitudeTracking<'a, P>>,
{
    /// A controller of `plant` for a manoeuvre behind an estimator of its state, with the solver that
    /// `make` makes for its chart, cost and horizon.
    ///
    /// # Errors
    /// Those of [`new`](Mpc::new) and of `make`.
    pub fn with(
        plant: &'a P,
        manoeuvre: Arc<dyn Manoeuvre>,
        spec: &MpcSpec,
        estimator: E,
        make: impl FnOnce(&LocalChart<'a, P>, &AttitudeTracking<'a, P>, Settings) -> Result<H, Error>,
    ) -> Result<Self, Error> {
        spec.check()?;
        let tracking = AttitudeTracking::new(plant, manoeuvre, spec)?;
        let chart = &tracking.chart;
        let settings = Settings {
            hold_first_input: spec.continuous_input,
            ..Settings::new(spec.intervals, spec.interval_s)
        };
        let solver = make(chart, &tracking, settings)?;
        Ok(Self {
            local: vec![0.0; chart.states().len()],
            estimator,
            estimate: vec![0.0; plant.states().len()],
            applied: vec![0.0; plant.inputs().len()],
            tracking,
            previous: solver.plan().clone(),
            solver,
            deadline: spec.deadline_s.map(|s| Duration::try_from_secs_f64(s).unwrap_or(Duration::MAX)),
            iterations: spec.iterations,
            last_update: None,
        })
    }

    /// The solver with its plan, in the chart of the last update.
    pub fn solver(&self) -> &H {
        &self.solver
    }

    /// Centres the chart at the measured attitude and moves the plan's states over.
    fn recenter(&mut self, x: &[f64], nodes: usize) {
        let chart = &mut self.tracking.chart;
        let old = chart.reference();
        chart.center_at(x);
        for k in 0..nodes {
            chart.adopt(old, self.solver.plan_mut().state_mut(k));
        }
        chart.localise(x, &mut self.local);
    }

    /// Solves for the plan from the state `x` at `t`; the deadline counts from `begun`.
    fn replan(&mut self, t: f64, x: &[f64], begun: Instant) -> Update {
        if let Some(last) = self.last_update {
            self.solver.shift(&self.tracking.chart, t - last);
            let nodes = self.solver.plan().nodes();
            self.recenter(x, nodes);
        } else {
            self.recenter(x, 0);
            self.solver.reset(&self.tracking.chart, &self.local);
        }
        self.last_update = Some(t);
        self.previous.clone_from(self.solver.plan());
        let status = self.solver.solve(&self.tracking.chart, &self.tracking, t, &self.local, self.iterations);
        if !status.updated() {
            return Update::Kept;
        }
        if self.deadline.is_some_and(|limit| begun.elapsed() > limit) {
            self.solver.plan_mut().clone_from(&self.previous);
            return Update::Late;
        }
        Update::Fresh
    }
}

impl<'a, P, E, H> Controller for Mpc<'a, P, E, H>
where
    P: Plant,
    E: Estimator,
    H: HorizonSolver<LocalChart<'a, P>, AttitudeTracking<'a, P>>,
{
    fn update(&mut self, t: f64, measurement: &Measurement) -> Update {
        let begun = Instant::now();
        self.solver.plan().input_at(t, &mut self.applied);
        let mut x = std::mem::take(&mut self.estimate);
        let estimated = self.estimator.estimate(t, measurement, &self.applied, &mut x);
        let update = estimated.map_or(Update::Kept, |()| self.replan(t, &x, begun));
        self.estimate = x;
        update
    }

    fn input(&self, t: f64, u: &mut [f64]) {
        self.solver.plan().input_at(t, u);
    }

    fn columns(&self) -> Vec<Column> {
        let last = self.solver.plan().nodes() - 1;
        let angles = ["roll", "pitch", "yaw"].map(|a| Column::new(format!("plan_{a}_{last}"), "rad", "WB"));
        let measures = ["iterations", "qp_changes", "active_limits", "stationarity", "defect"];
        let measures = measures.map(|m| Column::new(format!("solver_{m}"), "", ""));
        angles.into_iter().chain(measures).collect()
    }

    fn diagnostics(&self, row: &mut Vec<f64>) {
        let (plan, statistics) = (self.solver.plan(), self.solver.statistics());
        let end = plan.state(plan.nodes() - 1);
        row.extend(self.tracking.chart.rotation_matrix(end).roll_pitch_yaw().0);
        let counts = [statistics.iterations, statistics.qp_changes, statistics.active];
        row.extend(counts.map(|c| c as f64));
        row.extend([statistics.stationarity, statistics.defect]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Turn;
    use super::*;
    use crate::math::{Dual, Quat, Vec3};
    use crate::plant::Fault;

    /// A free body with two clearances that bend with time and state.
    struct Body {
        states: Vec<Channel>,
        inputs: Vec<Channel>,
        clearances: Vec<Channel>,
    }

    impl Plant for Body {
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

    fn body() -> Body {
        let roles = (0..4).map(Role::Attitude).chain((0..3).map(Role::AngularRate));
        Body {
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
            interval_s: 0.02,
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
        let turn = Turn { roll_deg: 10.0, pitch_deg: -5.0, yaw_rate_rad_s: 0.1, ..Turn::default() };
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
        let bare = Body { clearances: Vec::new(), ..body() };
        let manoeuvre = || Arc::new(Turn::default());
        let error = Mpc::new(&bare, manoeuvre(), &spec(1.0)).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.starts_with("weights.clearance = 1"), "{error}");
        assert!(Mpc::new(&bare, manoeuvre(), &spec(0.0)).is_ok());
    }
}

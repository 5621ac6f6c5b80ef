//! Model predictive control of attitude by direct collocation.

use super::manoeuvre::{Manoeuvre, angle_error};
use crate::Error;
use crate::math::{Quat, Scalar, Vec3};
use crate::ocp::realtime::{Plan, RealTime, Settings, Tracking};
use crate::plant::{Channel, LocalChart, Plant, Role};
use crate::require;
use crate::simulate::{Column, Controller, Estimator, Measurement, TrueState, Update};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Longest horizon, and most iterations of an update.
const MAX_INTERVALS: usize = 100;

/// Horizon and cost of the controller.
#[derive(Clone, Debug, Deserialize, Serialize)]
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
    /// Weights.
    pub weights: Weights,
}

/// Weights of the residuals; the cost holds their squares.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// Roll error, per rad.
    pub roll: f64,
    /// Pitch error, per rad.
    pub pitch: f64,
    /// Angular-rate error, per rad/s.
    pub rate: f64,
    /// Input, per half of its range.
    pub input: f64,
    /// Change of the input over an interval, per half of its range.
    #[serde(default)]
    pub input_change: f64,
    /// Factor on the state residuals of the last node: the terminal cost.
    #[serde(default = "one")]
    pub terminal: f64,
}

fn one() -> f64 {
    1.0
}

impl MpcSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        let weights = &self.weights;
        let positive =
            [("period_s", self.period_s), ("interval_s", self.interval_s), ("weights.input", weights.input)];
        let weights = [
            ("weights.roll", weights.roll),
            ("weights.pitch", weights.pitch),
            ("weights.rate", weights.rate),
            ("weights.input_change", weights.input_change),
            ("weights.terminal", weights.terminal),
        ];
        positive.iter().try_for_each(|(key, value)| require::positive(key, *value))?;
        weights.iter().try_for_each(|(key, value)| require::not_negative(key, *value))?;
        self.deadline_s.map_or(Ok(()), |deadline| require::positive("deadline_s", deadline))?;
        require::between("intervals", self.intervals, 1, MAX_INTERVALS)?;
        require::between("iterations", self.iterations, 1, MAX_INTERVALS)?;
        for (name, rate) in &self.input_rate_per_s {
            require::positive(&format!("input_rate_per_s.{name}"), *rate)?;
        }
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

/// The paper's cost J = sum (z - z_ref)' C (z - z_ref), z = [roll, pitch, w],
/// on the nodes after the first, with a small cost on the inputs at all nodes.
struct AttitudeTracking {
    manoeuvre: Manoeuvre,
    weights: Weights,
    /// Attitude at which the chart is centred.
    center: Quat,
    /// Index of the rotation vector in the local state.
    rotation: usize,
    /// Index of the angular rate in the local state.
    rate: usize,
    /// Residual per input, weight over half range.
    input_weights: Vec<f64>,
    /// Cost per squared change of an input.
    change_weights: Vec<f64>,
    /// Largest rate per input, per second.
    rate_limits: Vec<f64>,
    /// The last node.
    last: usize,
}

impl Tracking for AttitudeTracking {
    fn residuals(&self, node: usize) -> usize {
        self.input_weights.len() + if node == 0 { 0 } else { 5 }
    }

    fn residual<S: Scalar>(&self, node: usize, t: f64, x: &[S], u: &[S], r: &mut [S]) {
        let (inputs, outputs) = r.split_at_mut(self.input_weights.len());
        for (i, r) in inputs.iter_mut().enumerate() {
            *r = u[i] * self.input_weights[i];
        }
        if node == 0 {
            return;
        }
        let attitude = Quat::constant(self.center) * Quat::exp(Vec3::from_slice(&x[self.rotation..]));
        let angles = attitude.matrix().roll_pitch_yaw();
        let reference = self.manoeuvre.reference(t);
        let factor = if node == self.last { self.weights.terminal } else { 1.0 };
        outputs[0] = angle_error(angles[0], reference.roll) * (self.weights.roll * factor);
        outputs[1] = angle_error(angles[1], reference.pitch) * (self.weights.pitch * factor);
        for i in 0..3 {
            outputs[2 + i] = (x[self.rate + i] - reference.w[i]) * (self.weights.rate * factor);
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
/// It plans from the state that its estimator makes of the measurement.
pub struct Mpc<'a, P: Plant, E = TrueState> {
    chart: LocalChart<'a, P>,
    tracking: AttitudeTracking,
    solver: RealTime,
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
    /// A controller of `plant` for a manoeuvre that takes what is measured for the true state.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is out of range, or the plant has no
    /// attitude or angular rate.
    pub fn new(plant: &'a P, manoeuvre: Manoeuvre, spec: &MpcSpec) -> Result<Self, Error> {
        Self::with_estimator(plant, manoeuvre, spec, TrueState)
    }
}

impl<'a, P: Plant, E: Estimator> Mpc<'a, P, E> {
    /// A controller of `plant` for a manoeuvre behind an estimator of its state.
    ///
    /// # Errors
    /// Those of [`new`](Mpc::new).
    pub fn with_estimator(
        plant: &'a P,
        manoeuvre: Manoeuvre,
        spec: &MpcSpec,
        estimator: E,
    ) -> Result<Self, Error> {
        spec.check()?;
        let chart = LocalChart::new(plant);
        let missing = |what: &str| Error::invalid("plant", what, "a plant with attitude and angular rate");
        let rotation = chart.rotation().ok_or_else(|| missing("no attitude"))?;
        let rate = Role::AngularRate(0).place(chart.states());
        let half_range = |c: &Channel| 0.5 * (c.high - c.low);
        let tracking = AttitudeTracking {
            manoeuvre,
            weights: spec.weights.clone(),
            center: Quat::IDENTITY,
            rotation,
            rate: rate.ok_or_else(|| missing("no angular rate"))?,
            input_weights: plant.inputs().iter().map(|c| spec.weights.input / half_range(c)).collect(),
            change_weights: plant
                .inputs()
                .iter()
                .map(|c| (spec.weights.input_change / half_range(c)).powi(2))
                .collect(),
            rate_limits: spec.rate_limits(plant.inputs())?,
            last: spec.intervals,
        };
        let settings = Settings {
            hold_first_input: spec.continuous_input,
            ..Settings::new(spec.intervals, spec.interval_s)
        };
        let solver = RealTime::new(&chart, &tracking, settings)?;
        Ok(Self {
            local: vec![0.0; chart.states().len()],
            estimator,
            estimate: vec![0.0; plant.states().len()],
            applied: vec![0.0; plant.inputs().len()],
            chart,
            tracking,
            previous: solver.plan().clone(),
            solver,
            deadline: spec.deadline_s.map(|s| Duration::try_from_secs_f64(s).unwrap_or(Duration::MAX)),
            iterations: spec.iterations,
            last_update: None,
        })
    }

    /// The solver with its plan, in the chart of the last update.
    pub fn solver(&self) -> &RealTime {
        &self.solver
    }

    /// Centres the chart at the measured attitude and moves the plan's states over.
    fn recenter(&mut self, x: &[f64], nodes: usize) {
        let old = self.chart.reference();
        self.chart.center_at(x);
        self.tracking.center = self.chart.reference();
        for k in 0..nodes {
            self.chart.adopt(old, self.solver.plan_mut().state_mut(k));
        }
        self.chart.localise(x, &mut self.local);
    }

    /// Solves for the plan from the state `x` at `t`; the deadline counts from `begun`.
    fn replan(&mut self, t: f64, x: &[f64], begun: Instant) -> Update {
        if let Some(last) = self.last_update {
            self.solver.shift(&self.chart, t - last);
            let nodes = self.solver.plan().nodes();
            self.recenter(x, nodes);
        } else {
            self.recenter(x, 0);
            self.solver.reset(&self.chart, &self.local);
        }
        self.last_update = Some(t);
        self.previous.clone_from(self.solver.plan());
        let status = self.solver.solve(&self.chart, &self.tracking, t, &self.local, self.iterations);
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

impl<P: Plant, E: Estimator> Controller for Mpc<'_, P, E> {
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
        row.extend(self.chart.rotation_matrix(end).roll_pitch_yaw().0);
        let counts = [statistics.iterations, statistics.qp_changes, statistics.active];
        row.extend(counts.map(|c| c as f64));
        row.extend([statistics.stationarity, statistics.defect]);
    }
}

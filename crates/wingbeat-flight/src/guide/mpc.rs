//! Model predictive control of attitude by direct collocation.

use super::attitude_tracking::AttitudeTracking;
use super::controllers::{ControllerSpec, ControllerTask};
use super::free_end::FreeEnd;
use super::manoeuvre::Manoeuvre;
use super::receding::{self, Receding};
use super::told::Told;
use crate::simulate::{Column, Controller, Estimator, Measurement, TrueState, Update};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_ocp::plant::{Channel, LocalChart, Plant};
use wingbeat_ocp::realtime::{HorizonSolver, RealTime, Settings};

/// Longest horizon, and most iterations of an update.
pub(super) const MAX_INTERVALS: usize = 100;
/// Longest horizon in cycles of the gait.
const MAX_CYCLES: f64 = 100.0;
/// What a horizon in cycles is told where nothing flaps.
const NO_GAIT: &str = "interval_s for a plant without a gait";
/// What a controller without a manoeuvre is told.
const NO_MANOEUVRE: &str = "a manoeuvre to fly: add [manoeuvre]";

/// Horizon and cost of the controller.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct MpcSpec {
    /// Time between updates, s.
    pub period_s: f64,
    /// Intervals of the horizon.
    pub intervals: usize,
    /// Length of an interval, s; this or `horizon_cycles`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_s: Option<f64>,
    /// Length of the whole horizon in cycles of the gait, cut into its intervals: 1 for n intervals during a gait cycle,
    /// as the paper's section IV has them; this or `interval_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_cycles: Option<f64>,
    /// Least and largest length of the horizon in cycles where the controller chooses it too, as the paper's t_f; it begins
    /// with `horizon_cycles`. An update then takes twice as long.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_between_cycles: Option<[f64; 2]>,
    /// Iterations of sequential quadratic programming per update.
    pub iterations: usize,
    /// Each update is prepared before its measurement: the problem is linearised about the state that the plan leads to, and the state
    /// that is found enters by that linearisation. The commands then come soon after the measurement (`answer_median_us` of the summary).
    #[serde(default)]
    pub prepared: bool,
    /// The plan's first input is the last one applied; else it may jump.
    #[serde(default)]
    pub continuous_input: bool,
    /// Largest rate of inputs by their channel, in its unit per second; the
    /// others have none. Needs `continuous_input`: a jump has no finite rate.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub input_rate_per_s: BTreeMap<String, f64>,
    /// An update that takes longer by the wall clock, its preparation included, is dropped and
    /// counted, s; without it none is. A flight with a deadline does not repeat to the bit.
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
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
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
    /// Weight of the input, per half of its range.
    pub input: f64,
    /// Weight of the change of the input over an interval, per half of its range.
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
pub(super) fn clearance_width() -> f64 {
    1e-3
}

fn one() -> f64 {
    1.0
}

impl ControllerSpec for MpcSpec {
    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn build<'a>(&self, task: ControllerTask<'a>) -> Result<Box<dyn Controller + 'a>, Error> {
        self.in_range()?;
        let in_seconds = self.in_seconds(task.model.frequency_hz())?;
        if let Some(between) = self.horizon_between_cycles {
            return self.of_free_horizon(task, &in_seconds, between);
        }
        let manoeuvre = task.manoeuvre.ok_or_else(|| Error::invalid("", "given", NO_MANOEUVRE))?;
        Ok(match task.solver {
            None => {
                Box::new(Mpc::with(task.model, manoeuvre, &in_seconds, Told::new(task.model), RealTime::new)?)
            }
            Some(_) if self.prepared => {
                let allowed = "false with a solver of its own: the shipped one prepares updates";
                return Err(Error::invalid("prepared", true, allowed).against(["solver"]));
            }
            Some(solver) => {
                let make = |chart: &_, tracking: &_, settings| {
                    solver.build(chart, tracking, settings).map_err(|e| e.within("solver"))
                };
                Box::new(Mpc::with(task.model, manoeuvre, &in_seconds, Told::new(task.model), make)?)
            }
        })
    }
}

ranges!(MpcSpec {
    period_s: Range::POSITIVE,
    intervals: Range::between(1.0, MAX_INTERVALS as f64),
    interval_s: Range::POSITIVE,
    horizon_cycles: Range::over(0.0, MAX_CYCLES),
    horizon_between_cycles: Range::over(0.0, MAX_CYCLES),
    iterations: Range::between(1.0, MAX_INTERVALS as f64),
    deadline_s: Range::POSITIVE,
    clearance_width_m: Range::POSITIVE,
    input_rate_per_s: Range::POSITIVE,
});
impl Weights {
    /// Weight of the angular-rate error about each body axis, per rad/s.
    pub fn rates(&self) -> [f64; 3] {
        self.rate_axes.unwrap_or([self.rate; 3])
    }
}

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
    /// The controller that chooses the length of its horizon too.
    fn of_free_horizon<'a>(
        &self,
        task: ControllerTask<'a>,
        in_seconds: &Self,
        between: [f64; 2],
    ) -> Result<Box<dyn Controller + 'a>, Error> {
        let key = "horizon_between_cycles";
        require::range(key, between)?;
        let Some(cycles) =
            self.horizon_cycles.filter(|cycles| between[0] <= *cycles && *cycles <= between[1])
        else {
            let allowed = "a range around horizon_cycles, which gives the first length";
            return Err(Error::invalid(key, format!("{between:?}"), allowed).against(["horizon_cycles"]));
        };
        if self.prepared {
            let allowed = "false where the horizon is free: two solvers take turns";
            return Err(Error::invalid("prepared", true, allowed).against([key]));
        }
        if let Some(deadline) = self.deadline_s {
            let allowed =
                "left out where the horizon is free: a late update takes back a plan of another length";
            return Err(Error::invalid("deadline_s", deadline, allowed).against([key]));
        }
        if task.solver.is_some() {
            let allowed = "left out with a solver of its own: the shipped one solves for the horizon";
            return Err(Error::invalid(key, format!("{between:?}"), allowed).against(["solver"]));
        }
        let per_cycle = in_seconds.interval()? / cycles;
        let steps = between.map(|cycles| cycles * per_cycle);
        let make = |chart: &_, tracking: &_, settings| FreeEnd::new(chart, tracking, settings, steps);
        let manoeuvre = task.manoeuvre.ok_or_else(|| Error::invalid("", "given", NO_MANOEUVRE))?;
        Ok(Box::new(Mpc::with(task.model, manoeuvre, in_seconds, Told::new(task.model), make)?))
    }

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

    /// Length of an interval, s.
    ///
    /// # Errors
    /// [`Error::Invalid`] where not just one key gives the horizon, or where it is given in cycles of a gait that the
    /// plant is not known to have.
    fn interval(&self) -> Result<f64, Error> {
        match (self.interval_s, self.horizon_cycles) {
            (Some(interval), None) => Ok(interval),
            (None, Some(cycles)) => Err(Error::invalid("horizon_cycles", cycles, NO_GAIT)),
            (Some(_), Some(cycles)) => {
                let allowed = "interval_s or horizon_cycles, not both";
                Err(Error::invalid("horizon_cycles", cycles, allowed).against(["interval_s"]))
            }
            (None, None) => {
                let allowed = "a number of seconds here or a number of cycles in horizon_cycles";
                Err(Error::invalid("interval_s", "not given", allowed))
            }
        }
    }

    /// The same with its horizon in seconds, for a gait of the frequency `hz`: intervals of cycles / (hz intervals).
    ///
    /// Equation: guide.horizon_cycles
    /// `interval = cycles / (f N)`
    /// Source: Paper section IV: n time intervals during a gait cycle.
    /// Test: `a_horizon_in_cycles_is_the_one_in_seconds`.
    ///
    /// # Errors
    /// [`Error::Invalid`] where not just one key gives the horizon, or where nothing flaps.
    pub fn in_seconds(&self, hz: f64) -> Result<Self, Error> {
        match (self.interval_s, self.horizon_cycles) {
            (None, Some(cycles)) => {
                let interval = cycles / (hz * self.intervals as f64);
                if interval > 0.0 && interval.is_finite() {
                    return Ok(Self { interval_s: Some(interval), horizon_cycles: None, ..self.clone() });
                }
                Err(Error::invalid("horizon_cycles", cycles, NO_GAIT).against(["gait.frequency_hz"]))
            }
            _ => self.interval().map(|_| self.clone()),
        }
    }

    /// The rate limit of each input of a plant, infinite where none is given.
    pub(super) fn rate_limits(&self, inputs: &[Channel]) -> Result<Vec<f64>, Error> {
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

/// Predictive controller of any plant with an attitude and an angular rate among its states.
/// It plans from the state that its estimator `E` makes of the measurement, with the horizon solver `H`.
pub struct Mpc<'a, P: Plant, E = TrueState, H = RealTime> {
    tracking: AttitudeTracking<'a, P>,
    receding: Receding<H>,
    estimator: E,
    estimate: Vec<f64>,
    /// The state that the plan leads to.
    expected: Vec<f64>,
    applied: Vec<f64>,
    /// Whether updates are prepared.
    prepared: bool,
    /// Whether the length of the horizon is chosen too, and recorded.
    free_horizon: bool,
}

impl<'a, P: Plant> Mpc<'a, P> {
    /// A controller of `plant` for a manoeuvre that takes what is measured for the true state and plans
    /// with [`RealTime`].
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is out of range, or the plant has no
    /// attitude or angular rate.
    pub fn new(plant: &'a P, manoeuvre: Arc<dyn Manoeuvre>, spec: &MpcSpec) -> Result<Self, Error> {
        if let Some(between) = spec.horizon_between_cycles {
            let allowed = "none here: build the controller from a scenario, which chooses the horizon";
            return Err(Error::invalid("horizon_between_cycles", format!("{between:?}"), allowed));
        }
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
            prepared: spec.prepared,
            ..Settings::new(spec.intervals, spec.interval()?)
        };
        let solver = make(chart, &tracking, settings)?;
        let plan = solver.plan().clone();
        Ok(Self {
            receding: Receding::new(solver, plan, spec.deadline_s, spec.iterations),
            estimator,
            estimate: vec![0.0; plant.states().len()],
            expected: vec![0.0; plant.states().len()],
            applied: vec![0.0; plant.inputs().len()],
            prepared: spec.prepared,
            free_horizon: spec.horizon_between_cycles.is_some(),
            tracking,
        })
    }

    /// The solver with its plan, in the chart of the last update.
    pub fn solver(&self) -> &H {
        &self.receding.solver
    }
}

impl<'a, P, E, H> Controller for Mpc<'a, P, E, H>
where
    P: Plant,
    E: Estimator,
    H: HorizonSolver<LocalChart<'a, P>, AttitudeTracking<'a, P>>,
{
    fn prepare(&mut self, t: f64) {
        let expected = &mut self.expected;
        if self.prepared
            && self.receding.expect::<_, AttitudeTracking<P>>(&mut self.tracking.chart, t, expected)
        {
            self.receding.prepare(&self.tracking.chart, &self.tracking);
        }
    }

    fn update(&mut self, t: f64, measurement: &Measurement) -> Update {
        let begun = Instant::now();
        self.prepare(t);
        self.receding.solver.plan().input_at(t, &mut self.applied);
        let mut x = std::mem::take(&mut self.estimate);
        let estimated = self.estimator.estimate(t, measurement, &self.applied, &mut x);
        let update = estimated.map_or(Update::Kept, |()| {
            self.receding.follow(&mut self.tracking.chart, t, &x);
            self.receding.improve(&self.tracking.chart, &self.tracking, t, begun)
        });
        self.estimate = x;
        update
    }

    fn input(&self, t: f64, u: &mut [f64]) {
        self.receding.solver.plan().input_at(t, u);
    }

    fn columns(&self) -> Vec<Column> {
        let last = self.receding.solver.plan().nodes() - 1;
        let angles = ["roll", "pitch", "yaw"].map(|a| Column::new(format!("plan_{a}_{last}"), "rad", "WB"));
        let horizon = self.free_horizon.then(|| Column::new("horizon", "s", ""));
        let missed = ["attitude", "attitude_largest"]
            .map(|what| Column::new(format!("plan_missed_{what}"), "rad", ""));
        let missed = missed.into_iter().filter(|_| self.prepared);
        angles.into_iter().chain(receding::columns()).chain(horizon).chain(missed).collect()
    }

    fn diagnostics(&self, row: &mut Vec<f64>) {
        let plan = self.receding.solver.plan();
        let end = plan.state(plan.nodes() - 1);
        row.extend(self.tracking.chart.rotation_matrix(end).roll_pitch_yaw().0);
        row.extend(receding::measures(&self.receding.solver.statistics()));
        if self.free_horizon {
            row.push(plan.horizon.step * plan.horizon.intervals as f64);
        }
        if self.prepared {
            row.extend([self.receding.missed, self.receding.missed_largest]);
        }
    }
}

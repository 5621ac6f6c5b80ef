//! The quickest way from level flight into a banked turn, planned offline.

use super::manoeuvre::angle_error;
use super::reorientation::Turning;
use super::turn::Track;
use super::{MAX_INTERVALS, MAX_ITERATIONS, MAX_MESHES, processor_time};
use crate::simulate::{Driver, Moment, Stepper};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_math::{Scalar, Vec3, pitch_of_nose_up};
use wingbeat_ocp::interior_point::Options;
use wingbeat_ocp::nlp::Program;
use wingbeat_ocp::plant::{Channel, Fault, LocalChart, Plant, Role};
use wingbeat_ocp::{
    Collocation, Ends, Instant, Interpolant, Limits, OptimalControl, Progress, Refinement, Scheme, Setup,
    Starts, Trajectory, Transcribed, defects, optimise_from,
};
use wingbeat_robot::Robot;

/// Steps per second of the flight with resting regulators that serves as the guess.
const GUESS_RATE: f64 = 2000.0;
/// Samples of the guess.
const GUESS_SAMPLES: usize = 200;

/// Goal and effort of a roll-in.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct RollInSpec {
    /// Start of the roll-in, s; the scenario is flown up to there.
    pub start_s: f64,
    /// Bank at its end, deg; positive is right wing down.
    pub roll_deg: f64,
    /// Pitch at its end, deg; positive is nose up.
    pub nose_up_deg: f64,
    /// How far the pitch may be off, deg.
    pub pitch_within_deg: f64,
    /// Largest angular rate about each body axis, and largest rate of each
    /// structure element, at the end, rad/s.
    pub rate_within_rad_s: f64,
    /// Largest displacement of each structure element at the end, as a share
    /// of what its input may command: a body that is only turned by the
    /// reaction to its moving wings turns back with them.
    pub displacement_within: f64,
    /// Least clearance between parts on the way, m; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
    /// Longest duration, s.
    pub longest_s: f64,
    /// Cost of each input at its limit, seconds per second: m inputs at their limits cost m times as much.
    pub effort: f64,
    /// The cost J = sum (z - z_ref)' C (z - z_ref) of attitude and rates along the way, beside those of time and effort;
    /// without it none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracking: Option<TrackingCost>,
    /// Whether displacements keep to their ranges all the way, g_i >= 0.
    #[serde(default)]
    pub within_strokes: bool,
    /// Guesses tried: flights at rest of different durations. The lowest solution is kept, and the plan says whether the
    /// minima differ.
    #[serde(default = "one_start")]
    pub starts: usize,
    /// Intervals of the first mesh.
    pub intervals: usize,
    /// Most meshes.
    pub meshes: usize,
    /// Largest error of an interval, relative.
    pub tolerance: f64,
    /// Most iterations of the solver, over all meshes of a start: a count that no load of the machine changes.
    #[serde(default = "super::most_iterations")]
    pub iterations: usize,
    /// Most processor time of the plan of a start, s, beside `iterations`; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit_s: Option<f64>,
}

/// The diagonal of C over z = [roll, pitch, angular rate about x, y, z], per second of the way.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct TrackingCost {
    /// Cost of roll minus that of the end, s per rad^2 and second.
    pub roll: f64,
    /// Cost of pitch minus that of the end, s per rad^2 and second.
    pub pitch: f64,
    /// Cost of the angular rate about each body axis, s per (rad/s)^2 and second.
    pub rate: [f64; 3],
}

fn one_start() -> usize {
    1
}

/// Most guesses.
const MAX_STARTS: usize = 20;

ranges!(TrackingCost { roll: Range::NOT_NEGATIVE, pitch: Range::NOT_NEGATIVE, rate: Range::NOT_NEGATIVE });
ranges!(RollInSpec {
    start_s: Range::NOT_NEGATIVE,
    roll_deg: Range::inside(-80.0, 80.0),
    nose_up_deg: Range::inside(-80.0, 80.0),
    pitch_within_deg: Range::POSITIVE,
    rate_within_rad_s: Range::POSITIVE,
    displacement_within: Range::POSITIVE,
    longest_s: Range::POSITIVE,
    effort: Range::POSITIVE,
    starts: Range::between(1.0, MAX_STARTS as f64),
    intervals: Range::between(1.0, MAX_INTERVALS as f64),
    meshes: Range::between(1.0, MAX_MESHES as f64),
    tolerance: Range::POSITIVE,
    iterations: Range::between(1.0, MAX_ITERATIONS as f64),
    time_limit_s: Range::POSITIVE,
});

impl RollInSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.tracking.map_or(Ok(()), |cost| cost.in_range()).map_err(|e| e.within("tracking"))?;
        require::finite("clearance_m", self.clearance_m.as_slice())
    }
}

/// The roll-in of any plant with an attitude and an angular rate among its states: min t_f - t_0 + integral of effort |u|^2 +
/// (z - z_ref)' C (z - z_ref), the paper's problem: boundary conditions r_i at both ends, stroke inequalities g_i, free t_f.
///
/// Equation: guide.roll_in
/// `min t_f - t_0 + int (e sum (u_i/limit_i)^2 + (z - z_ref)' C (z - z_ref)) dt, z = [roll, pitch, w], five diagonal
/// entries; r_i at both ends, g_i by the strokes`
/// Source: Paper section IV.
/// Test: `a_cost_of_attitude_and_rates_adds_no_more_than_it_costs_on_the_quickest_way`.
pub struct RollIn<'a, P: Plant> {
    chart: LocalChart<'a, P>,
    spec: RollInSpec,
    start: Vec<f64>,
    rate: usize,
    half_ranges: Vec<f64>,
    /// How far each structure element may be displaced.
    strokes: Vec<[f64; 2]>,
    /// Structure elements at rest at the end: state and its size then.
    settled: Vec<(usize, f64)>,
    /// The attitude at the end where it is given as a rotation from the start; a bank is asked without it.
    pub(super) turn: Option<Turning>,
}

/// The flight that is the guess, as far as it is one.
struct Guess<'a> {
    turn: Option<&'a Turning>,
    /// Where the rotation vector lies in the state.
    rotation: usize,
    every: usize,
    steps: usize,
    kept: Trajectory,
}

impl Driver<()> for Guess<'_> {
    fn inputs(&self, t: f64, u: &mut [f64]) {
        if let Some(turn) = self.turn {
            turn.command(t, u);
        }
    }
    fn observe(&mut self, i: usize, at: Moment) -> Result<ControlFlow<()>, Fault> {
        let turned = self.turn.is_some_and(|turn| turn.is_reached(&at.x[self.rotation..]));
        if i.is_multiple_of(self.every) || i == self.steps || turned {
            self.kept.t.push(at.t);
            self.kept.x.push(at.x.to_vec());
            self.kept.u.push(at.u.to_vec());
        }
        Ok(if turned { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    }
}

impl<'a, P: Plant> RollIn<'a, P> {
    /// The roll-in of `plant`, whose structure elements have `strokes` (in the units of their channels), from its state `x` at
    /// `spec.start_s`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is out of range or the plant has no
    /// attitude or angular rate.
    ///
    /// # Panics
    /// When there is not a stroke for each element.
    pub fn new(plant: &'a P, x: &[f64], strokes: &[[f64; 2]], spec: &RollInSpec) -> Result<Self, Error> {
        spec.check()?;
        let mut chart = LocalChart::new(plant);
        chart.center_at(x);
        let missing = |what: &str| Error::invalid("plant", what, "a plant with attitude and angular rate");
        chart.rotation().ok_or_else(|| missing("no attitude"))?;
        let rate = Role::AngularRate(0).place(chart.states());
        let mut start = vec![0.0; chart.states().len()];
        chart.localise(x, &mut start);
        let elements = chart.states().iter().filter(|c| matches!(c.role, Role::Displacement(_))).count();
        assert_eq!(strokes.len(), elements, "a stroke for each element");
        limited_clearances(plant, spec.clearance_m)?;
        clear_at_start(plant, x, spec)?;
        let half_ranges: Vec<f64> = plant.inputs().iter().map(|c| 0.5 * (c.high - c.low)).collect();
        Ok(Self {
            settled: settled(chart.states(), strokes, spec),
            turn: None,
            strokes: strokes.to_vec(),
            rate: rate.ok_or_else(|| missing("no angular rate"))?,
            half_ranges,
            spec: spec.clone(),
            start,
            chart,
        })
    }

    /// Plans the roll-in; `observer` sees every iteration and mesh.
    ///
    /// # Errors
    /// The [`Fault`] of the flight with resting regulators that is the guess.
    pub fn plan(&self, observer: &mut dyn FnMut(Progress) -> ControlFlow<()>) -> Result<Starts, Fault> {
        let refinement = Refinement {
            intervals: self.spec.intervals,
            tolerance: self.spec.tolerance,
            objective_tolerance: 1e-3,
            meshes: self.spec.meshes,
            iterations: self.spec.iterations,
            solver: Options {
                time: processor_time(self.spec.time_limit_s),
                iterations: 300,
                tolerance: 1e-6,
                complementarity: 1e-7,
                acceptable: 1e-4,
                ..Options::default()
            },
            ..Refinement::default()
        };
        // The others last other parts of the longest duration.
        let other = |k: usize| self.guess(k as f64 / self.spec.starts as f64 * self.spec.longest_s);
        let guesses: Result<Vec<Trajectory>, Fault> =
            std::iter::once(self.first_guess()).chain((1..self.spec.starts).map(other)).collect();
        Ok(optimise_from(self, &guesses?, &refinement, observer))
    }

    /// Flight with resting regulators over a third of the longest duration; of a reorientation under the waves of its guess.
    ///
    /// # Errors
    /// The [`Fault`] of that flight.
    pub fn first_guess(&self) -> Result<Trajectory, Fault> {
        self.guess(if self.turn.is_some() { self.spec.longest_s } else { self.spec.longest_s / 3.0 })
    }

    /// Flight with resting regulators, or under the waves of the guess until it has turned.
    fn guess(&self, duration: f64) -> Result<Trajectory, Fault> {
        let steps = ((duration * GUESS_RATE).ceil() as usize).max(1);
        let every = (steps / GUESS_SAMPLES).max(1);
        let rotation = self.chart.rotation().unwrap_or(0);
        let mut guess =
            Guess { turn: self.turn.as_ref(), rotation, every, steps, kept: Trajectory::default() };
        let mut stepper = Stepper::new(&self.chart, self.spec.start_s, &self.start);
        stepper.run(duration / steps as f64, steps, &mut guess).check()?;
        Ok(guess.kept)
    }

    /// The attitude and rates of a planned trajectory, for a controller to follow.
    pub fn track(&self, trajectory: &Trajectory) -> Track {
        let mut track = Track { time_s: trajectory.t.clone(), ..Track::default() };
        for x in &trajectory.x {
            let angles = self.chart.rotation_matrix(x).roll_pitch_yaw();
            track.roll_rad.push(angles[0]);
            track.pitch_rad.push(angles[1]);
            track.rate_rad_s.push([x[self.rate], x[self.rate + 1], x[self.rate + 2]]);
        }
        track
    }

    /// Whether it asks for a rotation from the start rather than for a bank.
    pub fn is_reorientation(&self) -> bool {
        self.turn.is_some()
    }

    /// Length of the rotation vector from the start to the end of a plan, rad.
    pub fn turned(&self, plan: &Interpolant) -> Option<f64> {
        let end = plan.points.x.last()?;
        Some(Vec3::from_slice(end.get(self.chart.rotation()?..)?).norm())
    }

    /// Roll, pitch and yaw of a local state, rad.
    pub fn angles(&self, local: &[f64]) -> [f64; 3] {
        self.chart.rotation_matrix(local).roll_pitch_yaw().0
    }
}

/// Compiled once, in this crate, for robots.
impl RollIn<'_, Robot> {
    /// [`plan`](Self::plan) of a robot.
    ///
    /// # Errors
    /// Those of `plan`.
    pub fn planned(&self, observer: &mut dyn FnMut(Progress) -> ControlFlow<()>) -> Result<Starts, Fault> {
        self.plan(observer)
    }

    /// [`Interpolant::resimulate`] of a robot's plan, in the units of the states.
    ///
    /// # Errors
    /// The [`Fault`] of a state that the model refuses.
    pub fn resimulated(&self, plan: &Interpolant, steps: usize) -> Result<Vec<f64>, Fault> {
        plan.resimulate(self, steps)
    }

    /// Defects of a plan from its states and inputs alone, in the units of the states.
    ///
    /// # Errors
    /// The [`Fault`] of a state that the model refuses.
    pub fn defects(&self, unknowns: &Trajectory) -> Result<Vec<Vec<f64>>, Fault> {
        defects(self, &Scheme::hermite_simpson(), unknowns)
    }

    /// Hands the problem on its first mesh to `see`, with the start of the first guess, in the units of its channels.
    ///
    /// # Errors
    /// The [`Fault`] of the flight that is the guess.
    pub fn see_program(&self, see: &mut dyn FnMut(&mut dyn Program, &[f64])) -> Result<(), Fault> {
        let guess = self.first_guess()?;
        let mesh = Transcribed::uniform(Scheme::hermite_simpson(), self.spec.intervals);
        let mut program = Collocation::new(self, mesh, &guess);
        let start = program.unknowns(&guess);
        see(&mut program, &start);
        Ok(())
    }
}

impl<P: Plant> OptimalControl for RollIn<'_, P> {
    fn setup(&self) -> Setup {
        let spec = &self.spec;
        let start: Vec<Limits> = self.start.iter().map(|&x| [x, x]).collect();
        let (soonest, latest) = (spec.start_s + 0.02 * spec.longest_s, spec.start_s + spec.longest_s);
        let mut setup =
            Setup::new(self.chart.states().to_vec(), self.chart.inputs().to_vec(), [soonest, latest]);
        setup.times[0] = [spec.start_s; 2];
        setup.start = start;
        if spec.within_strokes {
            for channel in &mut setup.states {
                if let Role::Displacement(element) = channel.role {
                    [channel.low, channel.high] = self.strokes[element];
                }
            }
        }
        let end = |name: &str, unit, frame, size: f64| {
            Channel::limited(format!("final {name}"), unit, frame, -size, size)
        };
        setup.ends = match &self.turn {
            Some(turn) => ["x", "y", "z"]
                .map(|axis| end(&format!("rotation error {axis}"), "rad", "B", turn.within))
                .into(),
            None => vec![
                end("roll error", "rad", "WB", 0.0),
                end("pitch error", "rad", "WB", spec.pitch_within_deg.to_radians()),
                end("w_WB_B_x", "rad/s", "B", spec.rate_within_rad_s),
                end("w_WB_B_y", "rad/s", "B", spec.rate_within_rad_s),
                end("w_WB_B_z", "rad/s", "B", spec.rate_within_rad_s),
            ],
        };
        setup.path = clearance_path(self.chart.clearances(), spec.clearance_m);
        let states = self.chart.states();
        setup
            .ends
            .extend(self.settled.iter().map(|&(i, size)| end(&states[i].name, states[i].unit, "", size)));
        setup
    }

    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        self.chart.rates(at.t, at.x, at.u, dx)
    }

    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        let share = |(u, half): (&S, &f64)| (*u * (1.0 / half)).squared();
        let effort = at.u.iter().zip(&self.half_ranges).map(share).fold(S::ZERO, |sum, s| sum + s);
        let Some(cost) = &self.spec.tracking else { return effort * self.spec.effort };
        let angles = self.chart.rotation_matrix(at.x).roll_pitch_yaw();
        let roll = angle_error(angles[0], self.spec.roll_deg.to_radians());
        let pitch = angle_error(angles[1], pitch_of_nose_up(self.spec.nose_up_deg));
        let attitude = roll.squared() * cost.roll + pitch.squared() * cost.pitch;
        let rates = &at.x[self.rate..self.rate + 3];
        let rates = rates.iter().zip(cost.rate).fold(S::ZERO, |sum, (w, c)| sum + w.squared() * c);
        effort * self.spec.effort + attitude + rates
    }

    fn constrain_path<S: Scalar>(&self, at: Instant<S>, values: &mut [S]) {
        if !values.is_empty() && self.chart.clear(at.t, at.x, values).is_err() {
            values.fill(S::from(f64::NAN));
        }
    }

    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.t[1] - ends.t[0]
    }

    fn constrain_ends<S: Scalar>(&self, ends: Ends<S>, values: &mut [S]) {
        let x = ends.x[1];
        let count = values.len() - self.settled.len();
        let (attitude, settled) = values.split_at_mut(count);
        match &self.turn {
            Some(turn) => {
                let rotation = &x[self.chart.rotation().unwrap_or(0)..];
                for (i, value) in attitude.iter_mut().enumerate() {
                    *value = rotation[i] - turn.rotation[i];
                }
            }
            None => {
                let angles = self.chart.rotation_matrix(x).roll_pitch_yaw();
                attitude[0] = angle_error(angles[0], self.spec.roll_deg.to_radians());
                attitude[1] = angle_error(angles[1], pitch_of_nose_up(self.spec.nose_up_deg));
                attitude[2..].copy_from_slice(&x[self.rate..self.rate + 3]);
            }
        }
        for (value, &(i, _)) in settled.iter_mut().zip(&self.settled) {
            *value = x[i];
        }
    }
}

/// Refuses a least clearance where a plant has none.
pub(super) fn limited_clearances<P: Plant>(plant: &P, least: Option<f64>) -> Result<(), Error> {
    match least {
        Some(given) if plant.clearances().is_empty() => {
            Err(Error::invalid("clearance_m", given, "a robot with clearances, or no limit"))
        }
        _ => Ok(()),
    }
}

/// Distance, m, by which parts may be nearer at the start than is asked: below what solvers tell apart. *Choice.*
const AT_START: f64 = 1e-6;

/// Refuses a clearance that the state `x`, at which a plan starts whatever is planned, does not have.
fn clear_at_start<P: Plant>(plant: &P, x: &[f64], spec: &RollInSpec) -> Result<(), Error> {
    let (Some(least), clearances) = (spec.clearance_m, plant.clearances()) else { return Ok(()) };
    let mut values = vec![0.0; clearances.len()];
    if plant.clear(spec.start_s, x, &mut values).is_err() {
        return Ok(());
    }
    match clearances.iter().zip(&values).find(|(_, value)| **value < least - AT_START) {
        Some((channel, value)) => {
            let allowed = format!("at most {value:.3e}, what {} has at the start of the plan", channel.name);
            Err(Error::invalid("clearance_m", least, allowed))
        }
        None => Ok(()),
    }
}

/// The clearances as path constraints; none without a limit.
pub(super) fn clearance_path(clearances: &[Channel], least: Option<f64>) -> Vec<Channel> {
    let limited = |low: f64| clearances.iter().map(move |c| Channel { low, ..c.clone() });
    least.into_iter().flat_map(limited).collect()
}

/// The structure elements' displacements and rates among the states, and how
/// large they may be at the end.
fn settled(states: &[Channel], strokes: &[[f64; 2]], spec: &RollInSpec) -> Vec<(usize, f64)> {
    let size = |(i, channel): (usize, &Channel)| match channel.role {
        Role::Displacement(element) => {
            let [low, high] = strokes.get(element)?;
            Some((i, spec.displacement_within * 0.5 * (high - low)))
        }
        Role::DisplacementRate(_) => Some((i, spec.rate_within_rad_s)),
        _ => None,
    };
    states.iter().enumerate().filter_map(size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::{GuessSpec, ReorientationSpec, WaveSpec};
    use wingbeat_math::Quat;

    /// A body of unit inertia turned by three torques.
    struct Top {
        states: Vec<Channel>,
        inputs: Vec<Channel>,
        /// The distance left between the rate of roll and 1 rad/s.
        clearances: Vec<Channel>,
    }

    impl Plant for Top {
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
            let w = Vec3::from_slice(&x[4..]);
            Quat::from_wxyz(x).rate(w).store_wxyz(dx);
            dx[4..7].copy_from_slice(u);
            Ok(())
        }
        fn clearances(&self) -> &[Channel] {
            &self.clearances
        }
        fn clear<S: Scalar>(&self, _: S, x: &[S], values: &mut [S]) -> Result<(), Fault> {
            values[0] = -x[4] + 1.0;
            Ok(())
        }
    }

    fn top() -> Top {
        let roles = (0..4).map(Role::Attitude).chain((0..3).map(Role::AngularRate));
        Top {
            states: roles.map(|role| Channel::free(format!("{role:?}"), "", "").of(role)).collect(),
            inputs: ["x", "y", "z"].map(|n| Channel::limited(n, "N m", "B", -1.0, 1.0)).into(),
            clearances: vec![Channel::free("rate", "rad/s", "B")],
        }
    }

    /// A bank of 15 deg.
    fn bank(clearance_m: Option<f64>) -> RollInSpec {
        RollInSpec {
            start_s: 0.25,
            roll_deg: 15.0,
            nose_up_deg: 0.0,
            pitch_within_deg: 1.0,
            rate_within_rad_s: 1e-6,
            displacement_within: 1.0,
            clearance_m,
            longest_s: 4.0,
            effort: 1e-4,
            tracking: None,
            within_strokes: false,
            starts: 1,
            intervals: 20,
            meshes: 4,
            tolerance: 1e-5,
            iterations: 1000,
            time_limit_s: Some(20.0),
        }
    }

    #[test]
    fn a_free_body_turns_beyond_a_quarter_in_the_time_of_full_torque() {
        let (top, x) = (top(), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let wave = |amplitude: f64, frequency_hz: f64| GuessSpec {
            frequency_hz,
            waves: vec![WaveSpec { input: "y".into(), amplitude, phase_rad: 0.0 }],
        };
        let mut spec = ReorientationSpec {
            rotation_deg: [0.0, 170.0, 0.0],
            within_deg: 0.01,
            rate_within_rad_s: 1.0,
            displacement_within: 1.0,
            clearance_m: None,
            longest_s: 4.0,
            effort: 1e-4,
            guess: wave(1.0, 0.1),
            intervals: 10,
            meshes: 1,
            tolerance: 1e-3,
            iterations: 200,
            time_limit_s: None,
        };
        let problem = RollIn::reorientation(&top, &x, &[], &spec).unwrap();
        let guess = problem.first_guess().unwrap();
        let end = guess.x[guess.x.len() - 1][1];
        assert!((end - 170_f64.to_radians()).abs() < 1e-2, "the guess ends as it has turned: {end}");
        let optimum = problem.plan(&mut |_| ControlFlow::Continue(())).unwrap().best;
        assert!(optimum.status.is_success(), "{}", optimum.status);
        let points = optimum.solution.unwrap().points;
        // Nothing stops the body at the end: full torque all the way, theta = t^2/2.
        let duration = points.t[points.t.len() - 1];
        assert!((duration - (2.0 * 170_f64.to_radians()).sqrt()).abs() < 2e-3, "{duration}");
        spec.guess.waves.push(WaveSpec { input: "u".into(), amplitude: 1.0, phase_rad: 0.0 });
        let error = RollIn::reorientation(&top, &x, &[], &spec).err().map(|e| e.to_string());
        assert!(error.unwrap_or_default().starts_with("guess.waves[1].input"), "no such input");
        let none = ReorientationSpec { rotation_deg: [0.0; 3], guess: wave(1.0, 1.0), ..spec };
        assert!(none.check().is_err(), "no rotation");
    }

    #[test]
    fn a_path_that_keeps_its_clearance_takes_longer() {
        let (top, x) = (top(), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let spec = bank(Some(0.7));
        let problem = RollIn::new(&top, &x, &[], &spec).unwrap();
        let optimum = problem.plan(&mut |_| ControlFlow::Continue(())).unwrap().best;
        assert!(optimum.status.is_success(), "{}", optimum.status);
        let points = optimum.solution.unwrap().points;
        // Full torque up to 0.3 rad/s, on at that rate, full counter-torque.
        let expected = 15_f64.to_radians() / 0.3 + 0.3;
        let duration = points.t[points.t.len() - 1] - spec.start_s;
        assert!((duration - expected).abs() < 2e-3, "{duration} {expected}");
        // The limit holds at the nodes; where torque ends within an interval the cubic between bulges over it.
        let fastest = points.x.iter().map(|x| x[problem.rate]).fold(0.0, f64::max);
        assert!((fastest - 0.3).abs() < 0.01, "{fastest}");
        let wide = RollInSpec { clearance_m: Some(1.1), ..spec.clone() };
        let error = RollIn::new(&top, &x, &[], &wide).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains("at the start of the plan"), "{error}");
        let bare = Top { clearances: Vec::new(), ..top };
        let error = RollIn::new(&bare, &x, &[], &spec).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.starts_with("clearance_m = 0.7"), "{error}");
    }

    #[test]
    fn a_cost_of_attitude_and_rates_adds_no_more_than_it_costs_on_the_quickest_way() {
        let (top, x) = (top(), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let cost = TrackingCost { roll: 1.0, pitch: 1.0, rate: [0.5, 0.5, 0.5] };
        let spec = RollInSpec { tracking: Some(cost), starts: 3, ..bank(None) };
        let problem = RollIn::new(&top, &x, &[], &spec).unwrap();
        let starts = problem.plan(&mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!((starts.minima(), starts.objectives.len()), (1, 3), "{}", starts.words());
        let points = starts.best.solution.unwrap().points;
        let duration = points.t[points.t.len() - 1] - spec.start_s;
        // No way is quicker than that of full torque and full counter-torque.
        assert!(duration > 2.0 * 15_f64.to_radians().sqrt() - 2e-3, "{duration}");
        let quick = RollIn::new(&top, &x, &[], &bank(None)).unwrap();
        let quick = quick.plan(&mut |_| ControlFlow::Continue(())).unwrap().best.objective;
        // On it, T = 2 sqrt(a) long, the cost is a^2 T 23/60 of roll and .5 a T/3 of the rate: a bound from above, to the
        // thousandth of the objective that the meshes are refined to.
        let (a, objective) = (15_f64.to_radians(), starts.best.objective);
        let on_it = 2.0 * a.sqrt() * (a * a * 23.0 / 60.0 + 0.5 * a / 3.0);
        assert!(objective > quick && objective < quick + on_it + 2e-3, "{objective} {quick} {on_it}");
    }

    #[test]
    fn a_free_body_takes_the_time_of_full_torque_and_full_counter_torque() {
        let (top, spec) = (top(), bank(None));
        let x = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let problem = RollIn::new(&top, &x, &[], &spec).unwrap();
        let optimum = problem.plan(&mut |_| ControlFlow::Continue(())).unwrap().best;
        assert!(optimum.status.is_success(), "{}", optimum.status);
        let points = optimum.solution.unwrap().points;
        let duration = points.t[points.t.len() - 1] - spec.start_s;
        assert!((duration - 2.0 * 15_f64.to_radians().sqrt()).abs() < 2e-3, "{duration}");
        let track = problem.track(&points);
        track.check().unwrap();
        assert!((track.roll_rad[track.roll_rad.len() - 1] - 15_f64.to_radians()).abs() < 1e-6);
    }
}

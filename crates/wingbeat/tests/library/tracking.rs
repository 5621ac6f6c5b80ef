//! The real-time solver against linear-quadratic theory.

use wingbeat::math::Scalar;
use wingbeat::ocp::realtime::{Component, LinearLimit, RealTime, Settings, Tracking, UpdateStatus};
use wingbeat::plant::{Channel, Fault, Plant};

const STEP: f64 = 0.1;
const INTERVALS: usize = 8;
const CHANGE: f64 = 0.3;
/// Square roots of the weights on position, speed and input.
const WEIGHTS: [f64; 3] = [1.0, 0.5, 0.2];

/// A mass on a rail, pushed by the input.
struct Mass {
    states: [Channel; 2],
    inputs: [Channel; 1],
}

impl Mass {
    fn new(force: f64) -> Self {
        let states = [Channel::free("position", "m", "W"), Channel::free("speed", "m/s", "W")];
        Self { states, inputs: [Channel::limited("force", "N", "W", -force, force)] }
    }
}

impl Plant for Mass {
    fn states(&self) -> &[Channel] {
        &self.states
    }
    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }
    fn rates<S: Scalar>(&self, _t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (x[1], u[0]);
        Ok(())
    }
}

/// Keeps the mass at the origin.
struct Origin;

impl Tracking for Origin {
    fn residuals(&self, _node: usize) -> usize {
        3
    }
    fn residual<S: Scalar>(&self, _node: usize, _t: f64, x: &[S], u: &[S], r: &mut [S]) {
        (r[0], r[1], r[2]) = (x[0] * WEIGHTS[0], x[1] * WEIGHTS[1], u[0] * WEIGHTS[2]);
    }
    fn change_weight(&self, _input: usize) -> f64 {
        CHANGE
    }
}

type Matrix3 = [[f64; 3]; 3];

/// One step of the pair (state, force) under a force that changes by w:
/// exact for a force linear in time.
fn advance(s: [f64; 3], w: f64) -> [f64; 3] {
    let (h, next) = (STEP, s[2] + w);
    [s[0] + h * s[1] + h * h * (s[2] / 3.0 + next / 6.0), s[1] + h * (s[2] + next) / 2.0, next]
}

fn quadratic(p: &Matrix3, a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..9).map(|i| a[i / 3] * p[i / 3][i % 3] * b[i % 3]).sum()
}

/// Riccati recursion on (position, speed, force): the gain of every step and
/// the cost matrix at the start.
fn riccati() -> (Vec<[f64; 3]>, Matrix3) {
    let unit = |i: usize| std::array::from_fn(|j| f64::from(u8::from(i == j)));
    let stage: Matrix3 = std::array::from_fn(|i| unit(i).map(|one: f64| one * WEIGHTS[i].powi(2)));
    let (mut p, mut gains) = (stage, Vec::new());
    for _ in 0..INTERVALS {
        let push = advance([0.0; 3], 1.0);
        let images: [[f64; 3]; 3] = std::array::from_fn(|i| advance(unit(i), 0.0));
        let curvature = CHANGE + quadratic(&p, push, push);
        let gain: [f64; 3] = std::array::from_fn(|i| quadratic(&p, push, images[i]) / curvature);
        p = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                stage[i][j] + quadratic(&p, images[i], images[j]) - gain[i] * gain[j] * curvature
            })
        });
        gains.push(gain);
    }
    gains.reverse();
    (gains, p)
}

#[test]
fn an_unlimited_linear_problem_has_the_riccati_solution() {
    let plant = Mass::new(f64::INFINITY);
    let mut solver = RealTime::new(&plant, &Origin, Settings::new(INTERVALS, STEP)).unwrap();
    let x0 = [0.7, -0.4];
    solver.reset(&plant, &x0);
    let status = solver.solve(&plant, &Origin, 0.0, &x0, 1);
    assert_eq!(status, UpdateStatus::IterationLimit);
    let (gains, p) = riccati();
    let mut s = [x0[0], x0[1], -(p[2][0] * x0[0] + p[2][1] * x0[1]) / p[2][2]];
    for k in 0..=INTERVALS {
        assert!((solver.input(k)[0] - s[2]).abs() < 1e-12, "node {k}");
        assert!((solver.state(k)[0] - s[0]).abs() < 1e-12 && (solver.state(k)[1] - s[1]).abs() < 1e-12);
        if k < INTERVALS {
            s = advance(s, -(0..3).map(|i| gains[k][i] * s[i]).sum::<f64>());
        }
    }
    assert_eq!(solver.solve(&plant, &Origin, 0.0, &x0, 3), UpdateStatus::Solved);
}

#[test]
fn a_held_first_input_is_kept_and_the_rest_is_optimal() {
    let plant = Mass::new(f64::INFINITY);
    let settings = Settings { hold_first_input: true, ..Settings::new(INTERVALS, STEP) };
    let mut solver = RealTime::new(&plant, &Origin, settings).unwrap();
    solver.reset(&plant, &[0.7, -0.4]);
    solver.plan_mut().input_mut(0)[0] = 0.35;
    solver.solve(&plant, &Origin, 0.0, &[0.7, -0.4], 1);
    let (gains, _) = riccati();
    let s = advance([0.7, -0.4, 0.35], -(0.7 * gains[0][0] - 0.4 * gains[0][1] + 0.35 * gains[0][2]));
    assert_eq!(solver.input(0)[0], 0.35);
    assert!((solver.input(1)[0] - s[2]).abs() < 1e-12);
}

#[test]
fn limited_inputs_bind_and_shift_with_time() {
    let plant = Mass::new(0.3);
    let mut solver = RealTime::new(&plant, &Origin, Settings::new(INTERVALS, STEP)).unwrap();
    solver.reset(&plant, &[2.0, 0.0]);
    assert_eq!(solver.solve(&plant, &Origin, 0.0, &[2.0, 0.0], 4), UpdateStatus::Solved);
    assert_eq!(solver.input(0)[0], -0.3);
    assert!(solver.statistics().active > 0);
    // Moving on by a quarter interval follows the interpolant and, past the
    // end, the motion under the last input.
    let (plan, dt) = (solver.plan().clone(), 0.25 * STEP);
    solver.shift(&plant, dt);
    let mut x = [0.0; 2];
    plan.state_at(3.0 * STEP + dt, &mut x);
    assert!((solver.state(3)[0] - x[0]).abs() < 1e-14);
    let (end, u) = (plan.state(INTERVALS), plan.input(INTERVALS)[0]);
    let expected = end[0] + dt * end[1] + 0.5 * dt * dt * u;
    assert!((solver.state(INTERVALS)[0] - expected).abs() < 1e-14);
    assert!((solver.plan().start - dt).abs() < 1e-15);
}

/// Keeps the mass at the origin with a force that changes by at most `0` N/s.
struct Gently(f64);

impl Tracking for Gently {
    fn residuals(&self, node: usize) -> usize {
        Origin.residuals(node)
    }
    fn residual<S: Scalar>(&self, node: usize, t: f64, x: &[S], u: &[S], r: &mut [S]) {
        Origin.residual(node, t, x, u, r);
    }
    fn rate_limit(&self, _input: usize) -> f64 {
        self.0
    }
}

#[test]
fn the_rate_of_an_input_is_limited_from_the_held_one_on() {
    let plant = Mass::new(2.0);
    let settings = Settings { hold_first_input: true, ..Settings::new(INTERVALS, STEP) };
    let solve = |rate: f64| {
        let mut solver = RealTime::new(&plant, &Gently(rate), settings).unwrap();
        solver.reset(&plant, &[2.0, 0.0]);
        let status = solver.solve(&plant, &Gently(rate), 0.0, &[2.0, 0.0], 4);
        assert_eq!(status, UpdateStatus::Solved);
        solver.plan().u.clone()
    };
    let changes = |u: &[f64]| u.windows(2).map(|p| (p[1] - p[0]).abs()).fold(0.0, f64::max);
    let (free, huge, gentle) = (solve(f64::INFINITY), solve(1e6), solve(3.0));
    assert_eq!(free, huge);
    assert!(changes(&free) > 0.5, "{}", changes(&free));
    assert!((changes(&gentle) - 3.0 * STEP).abs() < 1e-12, "{}", changes(&gentle));
    // What binds first is the step away from the held input.
    assert_eq!(gentle[0], 0.0);
    assert!((gentle[1] + 3.0 * STEP).abs() < 1e-12);
    for bad in [0.0, -1.0, f64::NAN] {
        let error = RealTime::new(&plant, &Gently(bad), settings).unwrap_err().to_string();
        assert!(error.contains("rate_limit.force"), "{error}");
    }
}

/// A pendulum, turned by the input.
struct Pendulum(Mass);

impl Plant for Pendulum {
    fn states(&self) -> &[Channel] {
        self.0.states()
    }
    fn inputs(&self) -> &[Channel] {
        self.0.inputs()
    }
    fn rates<S: Scalar>(&self, _t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (x[1], u[0] - x[0].sin() * 4.0);
        Ok(())
    }
}

/// Keeps the origin with a limit on a sum of position and speed, and with forces that change slowly.
struct Corner(Vec<LinearLimit>);

impl Corner {
    fn new(high: f64) -> Self {
        let terms = vec![(Component::State(0), 1.0), (Component::State(1), 0.5), (Component::Input(0), 0.1)];
        Self(vec![LinearLimit { name: "corner".into(), terms, low: -high, high }])
    }
}

impl Tracking for Corner {
    fn residuals(&self, node: usize) -> usize {
        Origin.residuals(node)
    }
    fn residual<S: Scalar>(&self, node: usize, t: f64, x: &[S], u: &[S], r: &mut [S]) {
        Origin.residual(node, t, x, u, r);
        // The state of the first node counts too.
        r[2] += x[0] * 0.3;
    }
    fn rate_limit(&self, _: usize) -> f64 {
        4.0
    }
    fn limits(&self) -> &[LinearLimit] {
        &self.0
    }
}

/// Plans after an update from a state that lies `off` times a fixed distance from the expected one, to which so many
/// iterations were made before: whole, and in two phases.
fn both_ways<P: Plant>(plant: &P, tracking: &Corner, off: f64, before: usize) -> [RealTime; 2] {
    let settings = Settings { prepared: true, ..Settings::new(INTERVALS, STEP) };
    let mut whole = RealTime::new(plant, tracking, settings).unwrap();
    let start = [0.5, 0.3];
    whole.reset(plant, &start);
    assert!(whole.solve(plant, tracking, 0.0, &start, 3).updated());
    whole.shift(plant, 0.3 * STEP);
    let expected = whole.state(0).to_vec();
    assert!(whole.solve(plant, tracking, 0.3 * STEP, &expected, before).updated());
    let found = [expected[0] + 0.1 * off, expected[1] - 0.2 * off];
    let mut phased = whole.clone();
    assert!(phased.prepare(plant, tracking, 0.3 * STEP, 1));
    let ends = [whole.solve(plant, tracking, 0.3 * STEP, &found, 1), phased.answer(plant, tracking, &found)];
    assert!(ends.iter().all(UpdateStatus::updated), "{ends:?}");
    assert_eq!(phased.state(0), found);
    [whole, phased]
}

/// Largest difference of the states and inputs of two plans.
fn apart([one, other]: &[RealTime; 2]) -> f64 {
    let numbers = |of: &RealTime| [of.plan().x.clone(), of.plan().u.clone()].concat();
    numbers(one).iter().zip(numbers(other)).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn an_answer_from_where_it_was_prepared_is_the_whole_update() {
    let pendulum = Pendulum(Mass::new(1.5));
    let tracking = Corner::new(0.45);
    let plans = both_ways(&pendulum, &tracking, 0.0, 1);
    assert!(apart(&plans) < 1e-12, "{}", apart(&plans));
    assert!(plans[0].statistics().active > 2, "{}", plans[0].statistics().active);
    // Elsewhere the linearisation is another: where the plan is the best there, it is off by the square of the distance.
    let [near, far] = [0.05, 0.1].map(|off| apart(&both_ways(&pendulum, &tracking, off, 30)));
    assert!(near > 1e-9 && (3.0..5.0).contains(&(far / near)), "{near:.3e}, {far:.3e}");
}

#[test]
fn an_answer_needs_its_own_preparation() {
    let pendulum = Pendulum(Mass::new(1.5));
    let tracking = Corner::new(0.45);
    let [mut plan, _] = both_ways(&pendulum, &tracking, 0.0, 1);
    let x = plan.state(0).to_vec();
    assert!(plan.prepare(&pendulum, &tracking, 0.03, 2) && plan.statistics().iterations == 1);
    plan.shift(&pendulum, 0.01);
    assert_eq!(plan.answer(&pendulum, &tracking, &x), UpdateStatus::NumericalTrouble);
    let mut whole = RealTime::new(&pendulum, &tracking, Settings::new(INTERVALS, STEP)).unwrap();
    whole.reset(&pendulum, &x);
    assert!(!whole.prepare(&pendulum, &tracking, 0.0, 1));
    // A limit that no input can keep from there.
    assert!(plan.prepare(&pendulum, &tracking, 0.03, 1));
    let kept = plan.plan().clone();
    let end = plan.answer(&pendulum, &tracking, &[40.0, 0.0]);
    assert!(matches!(end, UpdateStatus::Infeasible { .. }), "{end:?}");
    assert_eq!(plan.plan().x, kept.x);
}

#[test]
fn a_saturated_plan_that_began_elsewhere_is_not_solved() {
    let plant = Mass::new(0.3);
    let settings = Settings { prepared: true, ..Settings::new(INTERVALS, STEP) };
    let mut plan = RealTime::new(&plant, &Origin, settings).unwrap();
    plan.reset(&plant, &[20.0, 0.0]);
    assert_eq!(plan.solve(&plant, &Origin, 0.0, &[20.0, 0.0], 4), UpdateStatus::Solved);
    assert!(plan.prepare(&plant, &Origin, 0.0, 1));
    assert_eq!(plan.answer(&plant, &Origin, &[20.5, 0.0]), UpdateStatus::IterationLimit);
    assert!((plan.statistics().defect - 0.5).abs() < 1e-12);
    assert!(plan.prepare(&plant, &Origin, 0.0, 1));
    assert_eq!(plan.answer(&plant, &Origin, &[20.5, 0.0]), UpdateStatus::Solved);
}

#[test]
fn a_plan_goes_on_after_an_answer_as_after_a_whole_update() {
    let pendulum = Pendulum(Mass::new(1.5));
    let tracking = Corner::new(0.45);
    let mut plans = both_ways(&pendulum, &tracking, 0.0, 1);
    for plan in &mut plans {
        plan.shift(&pendulum, 0.4 * STEP);
    }
    assert!(apart(&plans) < 1e-12, "{}", apart(&plans));
    // What was prepared is used once: a whole update follows.
    let x = plans[0].state(0).to_vec();
    let ends = plans.each_mut().map(|plan| plan.solve(&pendulum, &tracking, 0.7 * STEP, &x, 2));
    assert!(ends[0] == ends[1] && apart(&plans) < 1e-12, "{ends:?}");
}

/// A pendulum, turned by an actuator that follows the input by itself, and says so where it is `told`.
struct Actuated {
    states: [Channel; 4],
    inputs: [Channel; 1],
    told: bool,
}

impl Actuated {
    fn new(told: bool) -> Self {
        let states = ["angle", "place", "speed", "rate"].map(|name| Channel::free(name, "", ""));
        Self { states, inputs: [Channel::limited("command", "", "", -1.5, 1.5)], told }
    }
}

impl Plant for Actuated {
    fn states(&self) -> &[Channel] {
        &self.states
    }
    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }
    fn rates<S: Scalar>(&self, _t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (x[3], x[2]);
        dx[2] = (u[0] - x[1].sin()) * 90.0 - x[2] * 12.0;
        dx[3] = x[1] + x[2] * x[3] * 0.1 - x[0].sin() * 4.0;
        Ok(())
    }
    fn driven_states(&self) -> std::ops::Range<usize> {
        if self.told { 1..3 } else { 0..0 }
    }
}

#[test]
fn states_that_are_driven_are_found_first_and_the_plan_is_the_same() {
    // The longer horizon has more columns than a panel.
    for (intervals, step) in [(INTERVALS, STEP), (60, 0.05)] {
        let settings = Settings { prepared: true, ..Settings::new(intervals, step) };
        let start = [0.5, 0.0, 0.0, 0.3];
        let mut plans = [true, false].map(|told| {
            let plant = Actuated::new(told);
            let mut plan = RealTime::new(&plant, &Origin, settings).unwrap();
            plan.reset(&plant, &start);
            assert_eq!(plan.solve(&plant, &Origin, 0.0, &start, 30), UpdateStatus::Solved);
            plan
        });
        assert!(apart(&plans) < 1e-9, "{}", apart(&plans));
        for (plan, told) in plans.iter_mut().zip([true, false]) {
            let plant = Actuated::new(told);
            plan.shift(&plant, 0.3 * step);
            let found: Vec<f64> = plan.state(0).iter().map(|x| x + 0.01).collect();
            assert!(plan.prepare(&plant, &Origin, 0.3 * step, 1));
            assert!(plan.answer(&plant, &Origin, &found).updated());
        }
        assert!(apart(&plans) < 1e-9, "{}", apart(&plans));
        let [one, other] = plans.each_ref().map(|plan| plan.sensitivity(intervals));
        let off = one.iter().zip(other).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(off < 1e-9 && one.iter().any(|s| s.abs() > 0.1), "{off}");
    }
}

/// [`Origin`], which says of which states it knows.
struct Knowing;

impl Tracking for Knowing {
    fn residuals(&self, node: usize) -> usize {
        Origin.residuals(node)
    }
    fn residual<S: Scalar>(&self, node: usize, t: f64, x: &[S], u: &[S], r: &mut [S]) {
        Origin.residual(node, t, x, u, r);
    }
    fn known_states(&self, _: usize) -> std::ops::Range<usize> {
        0..2
    }
    fn change_weight(&self, input: usize) -> f64 {
        Origin.change_weight(input)
    }
}

#[test]
fn a_cost_that_says_which_states_it_knows_has_the_same_plan() {
    let (plant, settings, start) =
        (Actuated::new(true), Settings::new(INTERVALS, STEP), [0.5, 0.1, 0.0, 0.3]);
    let [mut one, mut other] = [
        RealTime::new(&plant, &Origin, settings).unwrap(),
        RealTime::new(&plant, &Knowing, settings).unwrap(),
    ];
    one.reset(&plant, &start);
    other.reset(&plant, &start);
    let ends = [one.solve(&plant, &Origin, 0.0, &start, 3), other.solve(&plant, &Knowing, 0.0, &start, 3)];
    assert!(ends.iter().all(UpdateStatus::updated) && one.plan().x == other.plan().x);
}

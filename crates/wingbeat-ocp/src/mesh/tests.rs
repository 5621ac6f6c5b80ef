use super::*;
use crate::defects::defects;
use crate::plant::{Channel, Fault};
use crate::{Ends, FREE, Instant, Limits};
use std::cell::Cell;
use wingbeat_math::Scalar;

/// A cart driven from rest to rest over `distance` in least time, |u| <= 1;
/// the least time is 2 sqrt(distance).
struct Cart {
    distance: f64,
    speed: Limits,
    time: Limits,
    /// Position from which on the model breaks.
    wall: f64,
}

const CART: Cart = Cart { distance: 1.0, speed: FREE, time: [0.1, 10.0], wall: f64::INFINITY };

impl OptimalControl for Cart {
    fn setup(&self) -> Setup {
        let [low, high] = self.speed;
        let states =
            vec![Channel::free("position", "m", ""), Channel::limited("speed", "m/s", "", low, high)];
        Setup::new(states, vec![Channel::limited("thrust", "m/s2", "", -1.0, 1.0)], self.time)
            .between(&[[0.0; 2], [0.0; 2]], &[[self.distance; 2], [0.0; 2]])
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let broken = (at.x[0].value() > self.wall).then_some(f64::NAN);
        (dx[0], dx[1]) = (at.x[1], at.u[0] + broken.unwrap_or(0.0));
        Ok(())
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.t[1]
    }
}

fn run<P: OptimalControl>(problem: &P, refinement: &Refinement) -> Optimum {
    let guess = problem.setup().straight_line();
    optimise(problem, &guess, refinement, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn bang_bang_is_found_and_its_input_drives_the_model_there() {
    for scheme in [Scheme::hermite_simpson(), Scheme::lobatto(), Scheme::trapezoid()] {
        let loose = scheme.order == 2;
        let tolerance = if loose { 1e-4 } else { 1e-8 };
        let found = run(&CART, &Refinement { scheme, tolerance, ..Refinement::default() });
        assert!(found.status.is_success(), "{}", found.status);
        let error = (found.objective - 2.0).abs();
        assert!(error < if loose { 1e-3 } else { 2e-6 }, "{error:e}");
        let drift = found.solution.unwrap().resimulate(&CART, 4).unwrap();
        assert!(drift.iter().all(|d| *d < if loose { 1e-2 } else { 1e-6 }), "{drift:?}");
    }
}

#[test]
fn bad_problems_get_a_clear_answer() {
    let short = Cart { time: [0.1, 1.0], ..CART };
    let slow = Cart { distance: 30.0, time: [0.1, 2.0], ..CART };
    for unreachable in [short, slow] {
        let status = run(&unreachable, &Refinement::default()).status;
        assert!(
            matches!(&status, SolveStatus::Infeasible { channel, .. } if channel.contains("dynamics of")),
            "{status}"
        );
    }
    let status = run(&Cart { speed: [2.0, 1.0], ..CART }, &Refinement::default()).status;
    assert!(
        matches!(&status, SolveStatus::Infeasible { channel, .. } if channel.contains("speed")),
        "{status}"
    );
    let status = run(&Cart { wall: -1.0, ..CART }, &Refinement::default()).status;
    assert!(
        matches!(&status, SolveStatus::NumericalTrouble { cause } if cause.contains("speed")),
        "{status}"
    );
    let status = run(&Cart { wall: 0.4, ..CART }, &Refinement::default()).status;
    assert!(!status.is_success(), "{status}");
    let status = run(&Cart { time: [0.0, 0.0], ..CART }, &Refinement::default()).status;
    assert!(
        matches!(&status, SolveStatus::Infeasible { channel, .. } if channel.contains("horizon")),
        "{status}"
    );
}

/// x' = u / x: singular where the straight line starts.
struct Singular;

impl OptimalControl for Singular {
    fn setup(&self) -> Setup {
        let u = vec![Channel::limited("u", "", "", -1.0, 1.0)];
        Setup::new(vec![Channel::free("x", "", "")], u, [1.0, 1.0]).between(&[[0.0; 2]], &[[1.0; 2]])
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        dx[0] = at.u[0] / at.x[0];
        Ok(())
    }
}

#[test]
fn singular_dynamics_are_reported() {
    let status = run(&Singular, &Refinement::default()).status;
    assert!(
        matches!(&status, SolveStatus::NumericalTrouble { cause } if cause.contains("rate of x")),
        "{status}"
    );
}

/// The cart on up to three meshes with a limit of iterations.
fn limited(iterations: usize) -> Optimum {
    run(&CART, &Refinement { intervals: 8, meshes: 3, iterations, ..Refinement::default() })
}

#[test]
fn a_limit_of_iterations_returns_the_best_that_was_met() {
    let whole = limited(usize::MAX);
    let first = whole.passes[0].iterations;
    assert!(whole.passes[0].status.is_success() && whole.iterations > first, "{:?}", whole.passes);
    // Within the first mesh: the best of its points, feasible as far as its own number says.
    for iterations in [1, 3, first - 1] {
        let found = limited(iterations);
        assert_eq!((&found.status, found.iterations), (&SolveStatus::IterationLimit, iterations));
        let misses = found.misses.clone().unwrap();
        let shown = defects(&CART, &Scheme::hermite_simpson(), &found.solution.unwrap().unknowns()).unwrap();
        let worst = shown.iter().flatten().fold(0.0_f64, |m, d| m.max(d.abs()));
        assert!(found.objective.is_finite() && misses.residual > 1e-9, "{misses:?}");
        assert!((misses.violation - worst).abs() < 1e-9 * (1.0 + worst), "{misses:?} {worst}");
        assert_eq!(misses.constraint.is_empty(), worst == 0.0, "{misses:?}");
    }
    // Within the second: the optimum of the first.
    let found = limited(first + 1);
    assert_eq!(found.solution.as_ref().unwrap().intervals(), 8);
    assert!((found.objective - whole.passes[0].objective).abs() < 1e-12, "{}", found.objective);
    assert!(!found.status.is_success() || found.error <= 100.0 * Refinement::default().tolerance);
    // The same however often it is asked.
    assert_eq!(limited(first + 1).objective.to_bits(), found.objective.to_bits());
}

/// The cart, whose track is another for each solve, the last with a drag: stands in for a finer mesh on which the warm start finds nothing
/// and the cold one another optimum.
struct Tracks {
    of_solves: [Cart; 3],
    drag: f64,
    solved: Cell<usize>,
}

impl OptimalControl for Tracks {
    fn setup(&self) -> Setup {
        self.of_solves[self.solved.get()].setup()
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        CART.rates(at, dx)?;
        let drag = if self.solved.get() == 2 { self.drag } else { 0.0 };
        dx[1] -= at.x[1].squared() * drag;
        Ok(())
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        CART.end_cost(ends)
    }
}

#[test]
fn a_plan_keeps_its_coarser_optimum_over_a_dominated_one() {
    // Without drag the first is exact on any mesh. None reaches 30 m in 2 s.
    let found = |last: Cart, drag: f64| {
        let lost = Cart { distance: 30.0, time: [0.1, 2.0], ..CART };
        let problem = Tracks { of_solves: [CART, lost, last], drag, solved: Cell::new(0) };
        let guess = problem.setup().straight_line();
        let refinement = Refinement { intervals: 8, meshes: 3, ..Refinement::default() };
        let optimum = optimise(&problem, &guess, &refinement, &mut |at| {
            if matches!(at, Progress::Pass(_)) {
                problem.solved.set((problem.solved.get() + 1).min(2));
            }
            ControlFlow::Continue(())
        });
        let ends: Vec<bool> = optimum.passes.iter().map(|pass| pass.status.is_success()).collect();
        assert_eq!(ends[..3], [true, false, true], "{:?}", optimum.passes);
        optimum
    };
    // Slower, and with a drag: dearer and less accurate.
    let dominated = found(Cart { speed: [-0.5, 0.5], ..CART }, 0.5);
    let [first, _, third] = &dominated.passes[..] else { panic!("{:?}", dominated.passes) };
    assert!(
        third.objective > first.objective + 0.4 && third.error > first.error + 1e-8,
        "{third:?} {first:?}"
    );
    assert_eq!(dominated.objective.to_bits(), first.objective.to_bits());
    assert_eq!((&dominated.status, dominated.ended_on), (&SolveStatus::Acceptable, third.intervals));
    assert_eq!(dominated.solution.as_ref().unwrap().intervals(), 8);
    // A cheaper one takes its place.
    let cheaper = found(Cart { distance: 0.5, ..CART }, 0.0);
    assert!(cheaper.objective < first.objective - 0.5, "{}", cheaper.objective);
}

#[test]
fn a_limit_of_time_counts_the_processor_alone() {
    let solver = Options { time: Duration::from_millis(400), ..Options::default() };
    let slow = Refinement { solver, ..Refinement::default() };
    let guess = CART.setup().straight_line();
    let mut waited = false;
    let found = optimise(&CART, &guess, &slow, &mut |_| {
        if !std::mem::replace(&mut waited, true) {
            std::thread::sleep(Duration::from_millis(500));
        }
        ControlFlow::Continue(())
    });
    assert!(found.status.is_success() && found.time > Duration::from_millis(500), "{}", found.status);
    assert!(found.processor_time < Duration::from_millis(400));
    let none = Options { time: Duration::ZERO, ..Options::default() };
    let found = run(&CART, &Refinement { solver: none, ..Refinement::default() });
    assert_eq!(found.status, SolveStatus::TimeLimit);
    assert!(found.objective.is_finite() && found.solution.is_some());
}

#[test]
fn defects_of_a_solution_vanish_and_multipliers_meet_the_limits() {
    for scheme in [Scheme::hermite_simpson(), Scheme::separated_hermite_simpson(), Scheme::lobatto()] {
        let found = run(
            &CART,
            &Refinement { scheme: scheme.clone(), meshes: 1, intervals: 10, ..Refinement::default() },
        );
        let (solution, multipliers) = (found.solution.unwrap(), found.multipliers.unwrap());
        let mut unknowns = solution.unknowns();
        let worst = |of: &Trajectory| {
            let found = defects(&CART, &scheme, of).unwrap();
            found.iter().flatten().fold(0.0_f64, |m, d| m.max(d.abs()))
        };
        assert!(worst(&unknowns) < 1e-8, "{}: {:e}", scheme.name, worst(&unknowns));
        let last = unknowns.t.len() - 1;
        unknowns.x[last][0] += 1e-3;
        assert!((worst(&unknowns) - 1e-3).abs() < 1e-8, "{}", scheme.name);
        // Full thrust, then full counter-thrust: the multipliers have the signs of the limits that hold.
        let thrust: Vec<f64> = multipliers.bounds.iter().filter_map(|of| of[1].first().copied()).collect();
        assert!(thrust[0] > 1e-3 && thrust[thrust.len() - 1] < -1e-3, "{thrust:?}");
        // The time is free, and its costate at the end what one more second would cost: H = -1 all the way.
        assert_eq!(multipliers.defects.len(), solution.points.t.len());
        assert!(multipliers.defects[0].is_empty());
        assert!(multipliers.constants[1].abs() < 1e-6, "{:?}", multipliers.constants);
    }
}

use super::*;
use crate::plant::{Channel, Fault};
use crate::{Ends, FREE, Instant, Limits};
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
            matches!(&status, Status::Infeasible { channel, .. } if channel.contains("dynamics of")),
            "{status}"
        );
    }
    let status = run(&Cart { speed: [2.0, 1.0], ..CART }, &Refinement::default()).status;
    assert!(matches!(&status, Status::Infeasible { channel, .. } if channel.contains("speed")), "{status}");
    let status = run(&Cart { wall: -1.0, ..CART }, &Refinement::default()).status;
    assert!(matches!(&status, Status::NumericalTrouble { cause } if cause.contains("speed")), "{status}");
    let status = run(&Cart { wall: 0.4, ..CART }, &Refinement::default()).status;
    assert!(!status.is_success(), "{status}");
    let status = run(&Cart { time: [0.0, 0.0], ..CART }, &Refinement::default()).status;
    assert!(matches!(&status, Status::Infeasible { channel, .. } if channel.contains("horizon")), "{status}");
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
    assert!(matches!(&status, Status::NumericalTrouble { cause } if cause.contains("rate of x")), "{status}");
}

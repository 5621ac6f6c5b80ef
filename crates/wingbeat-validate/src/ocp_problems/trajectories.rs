//! Nine optimal-control problems with optima in closed form or from a fine
//! Radau collocation, each solved from the straight line between its ends.

use super::problem::ClassicProblem;
use crate::{Case, ComparisonRow, Error};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::time::Duration;
use wingbeat::math::{GRAVITY, Scalar};
use wingbeat::ocp::interior_point::{Options, SolveStatus};
use wingbeat::ocp::{Ends, FREE, Instant, Limits, OptimalControl, Refinement, Scheme, Setup, optimise};
use wingbeat::plant::{Channel, Fault};

pub(super) const CLOSED_FORM: &str = "closed form";
const CASADI: &str = "CasADi 3.8.2 + IPOPT, Radau IIA degree 4";

/// Relative distance of the optimum found from the reference, by Hermite-Simpson collocation.
pub(super) fn compare(
    name: &str,
    source: &str,
    problem: &ClassicProblem,
    optimum: f64,
) -> Result<Vec<ComparisonRow>, Error> {
    compare_by(Scheme::hermite_simpson(), name, source, problem, optimum)
}

/// Relative distance of the optimum found by a collocation scheme from the reference.
pub(super) fn compare_by(
    scheme: Scheme,
    name: &str,
    source: &str,
    problem: &ClassicProblem,
    optimum: f64,
) -> Result<Vec<ComparisonRow>, Error> {
    let solver = Options { time: Duration::from_secs(300), ..Options::default() };
    let refinement = Refinement { scheme, solver, ..Refinement::default() };
    let guess = problem.setup().straight_line();
    let mut quiet = |_: wingbeat::ocp::Progress| ControlFlow::Continue(());
    let found = optimise(problem, &guess, &refinement, &mut quiet);
    if found.status != SolveStatus::Solved {
        return Err(Error::NoAnswer(found.status.to_string()));
    }
    let value = (found.objective - optimum).abs() / optimum.abs();
    let last = found.passes.last().map_or(0, |p| p.intervals);
    let iterations: usize = found.passes.iter().map(|p| p.iterations).sum();
    let meshes = found.passes.len();
    let metric = format!("objective, relative; {meshes} meshes to {last} intervals, {iterations} iterations");
    Ok(vec![ComparisonRow::judged(&format!("ocp.{name}"), source, &metric, value, 1e-6, "")])
}

pub(super) fn free(names: &[&str]) -> Vec<Channel> {
    names.iter().map(|n| Channel::free(*n, "", "")).collect()
}

pub(super) fn exactly<const N: usize>(values: [f64; N]) -> [Limits; N] {
    values.map(|v| [v, v])
}

/// Bryson & Ho 1975: a cart thrown and caught below a ceiling.
pub(super) struct BrysonDenham;

impl OptimalControl for BrysonDenham {
    fn setup(&self) -> Setup {
        let x = Channel::limited("x", "m", "", f64::NEG_INFINITY, 1.0 / 9.0);
        Setup::new(vec![x, Channel::free("v", "m/s", "")], free(&["u"]), [1.0, 1.0])
            .between(&exactly([0.0, 1.0]), &exactly([0.0, -1.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (at.x[1], at.u[0]);
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.u[0].squared() * 0.5
    }
}

/// A cart brought one metre on with least energy.
pub(super) struct DoubleIntegrator;

impl OptimalControl for DoubleIntegrator {
    fn setup(&self) -> Setup {
        Setup::new(free(&["x", "v"]), free(&["u"]), [1.0, 1.0])
            .between(&exactly([0.0, 0.0]), &exactly([1.0, 0.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (at.x[1], at.u[0]);
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.u[0].squared() * 0.5
    }
}

/// The scalar linear regulator on a finite horizon.
pub(super) struct LqrScalar;

impl OptimalControl for LqrScalar {
    fn setup(&self) -> Setup {
        Setup::new(free(&["x"]), free(&["u"]), [1.0, 1.0]).between(&exactly([1.0]), &[FREE])
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        dx[0] = at.u[0];
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.x[0].squared() + at.u[0].squared()
    }
}

/// The curve of quickest descent (J. Bernoulli 1696), angle from the vertical.
pub(super) struct Brachistochrone;

impl OptimalControl for Brachistochrone {
    fn setup(&self) -> Setup {
        let degree = PI / 180.0;
        let angle = Channel::limited("theta", "rad", "", 0.01 * degree, 179.9 * degree);
        Setup::new(free(&["x", "y", "v"]), vec![angle], [0.1, 10.0])
            .between(&exactly([0.0, 10.0, 0.0]), &[[10.0, 10.0], [5.0, 5.0], FREE])
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let (s, c) = at.u[0].sin_cos();
        (dx[0], dx[1], dx[2]) = (at.x[2] * s, -at.x[2] * c, c * GRAVITY);
        Ok(())
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.t[1]
    }
}

/// Swing-up of a pole on a cart (Kelly 2017, SIAM Review 59).
pub(super) struct CartPole;

impl OptimalControl for CartPole {
    fn setup(&self) -> Setup {
        let mut states = free(&["q1", "q2", "v1", "v2"]);
        states[0] = Channel::limited("q1", "m", "", -2.0, 2.0);
        Setup::new(states, vec![Channel::limited("u", "N", "", -20.0, 20.0)], [2.0, 2.0])
            .between(&exactly([0.0; 4]), &exactly([1.0, PI, 0.0, 0.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let (m1, m2, l, g) = (1.0, 0.3, 0.5, 9.81);
        let ((s, c), u, rate) = (at.x[1].sin_cos(), at.u[0], at.x[3]);
        let swing = s * rate.squared() * (l * m2);
        let inertia = (-(c * c) + 1.0) * m2 + m1;
        (dx[0], dx[1]) = (at.x[2], rate);
        dx[2] = (swing + u + c * s * (m2 * g)) / inertia;
        dx[3] = -(swing * c + u * c + s * ((m1 + m2) * g)) / (inertia * l);
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.u[0].squared()
    }
}

/// Van der Pol's oscillator with limits on a state and on the input.
pub(super) struct VanDerPol;

impl OptimalControl for VanDerPol {
    fn setup(&self) -> Setup {
        let states = vec![Channel::limited("x1", "", "", -0.25, f64::INFINITY), Channel::free("x2", "", "")];
        Setup::new(states, vec![Channel::limited("u", "", "", -1.0, 1.0)], [10.0, 10.0])
            .between(&exactly([0.0, 1.0]), &[FREE, FREE])
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let (a, b) = (at.x[0], at.x[1]);
        (dx[0], dx[1]) = ((-(b * b) + 1.0) * a - b + at.u[0], a);
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.x[0].squared() + at.x[1].squared() + at.u[0].squared()
    }
}

/// Rayleigh's equation driven to rest.
pub(super) struct Rayleigh;

impl OptimalControl for Rayleigh {
    fn setup(&self) -> Setup {
        Setup::new(free(&["x1", "x2"]), free(&["u"]), [2.5, 2.5])
            .between(&exactly([-5.0, -5.0]), &exactly([0.0, 0.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let (a, b) = (at.x[0], at.x[1]);
        (dx[0], dx[1]) = (b, -a + b * (-(b * b) * 0.14 + 1.4) + at.u[0] * 4.0);
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.x[0].squared() + at.u[0].squared()
    }
}

/// Two boundary layers around a long rest (Rao & Mease 2000).
pub(super) struct Hypersensitive;

impl OptimalControl for Hypersensitive {
    fn setup(&self) -> Setup {
        Setup::new(free(&["x"]), free(&["u"]), [40.0, 40.0]).between(&exactly([1.5]), &exactly([1.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        dx[0] = at.u[0] - at.x[0] * at.x[0] * at.x[0];
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        (at.x[0].squared() + at.u[0].squared()) * 0.5
    }
}

/// Soft landing with least fuel: full thrust after a switch (Meditch 1964).
pub(super) struct MoonLander;

impl OptimalControl for MoonLander {
    fn setup(&self) -> Setup {
        Setup::new(free(&["h", "v"]), vec![Channel::limited("u", "m/s2", "", 0.0, 3.0)], [0.1, 10.0])
            .between(&exactly([10.0, -2.0]), &exactly([0.0, 0.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (at.x[1], at.u[0] - 1.5);
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.u[0]
    }
}

/// A comparison by name.
macro_rules! case {
    ($name:literal, $source:expr, $problem:expr, $optimum:expr) => {
        Case {
            id: concat!("ocp.", $name),
            quick: true,
            run: || compare($name, $source, &$problem.into(), $optimum),
        }
    };
}

/// The comparisons.
pub const CASES: &[Case] = &[
    case!("bryson_denham", CLOSED_FORM, BrysonDenham, 4.0),
    case!("double_integrator_min_energy", CLOSED_FORM, DoubleIntegrator, 6.0),
    case!("lqr_scalar", CLOSED_FORM, LqrScalar, 1.0_f64.tanh()),
    case!("brachistochrone", CLOSED_FORM, Brachistochrone, 1.8016031224530813),
    case!("cart_pole_swing_up", CASADI, CartPole, 58.80766745805528),
    case!("van_der_pol", CASADI, VanDerPol, 3.6151813645666784),
    case!("rayleigh", CASADI, Rayleigh, 29.915027501641166),
    case!("hypersensitive", CASADI, Hypersensitive, 1.3308069049424534),
    case!("moon_lander", CLOSED_FORM, MoonLander, 2.0 * 17.0_f64.sqrt()),
];

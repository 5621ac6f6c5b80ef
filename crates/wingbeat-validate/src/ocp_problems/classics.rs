//! Further classical problems: an unstable current, state constraints, singular
//! arcs, integral constraints; each from the straight line between its ends.

use super::trajectories::{CLOSED_FORM, compare, compare_by, exactly, free};
use crate::{Case, ComparisonRow, Error};
use std::f64::consts::PI;
use wingbeat::math::Scalar;
use wingbeat::ocp::{Ends, FREE, Instant, Limits, OptimalControl, Scheme, Setup};
use wingbeat::plant::{Channel, Fault};

/// Least time through a current u = -y (Zermelo 1931; Bryson & Ho 1975, 2.7).
/// The heading obeys theta' = cos^2 theta, so tan theta grows by 1 per second.
pub(super) struct Zermelo;

/// Headings at start and end; the start lies where such a path begins.
const HEADINGS: [f64; 2] = [105.0 * PI / 180.0, 240.0 * PI / 180.0];

impl Zermelo {
    /// x and y at the start of the path that ends at the origin.
    fn start() -> [f64; 2] {
        let [a, b] = HEADINGS.map(f64::tan);
        let root = |s: f64| (1.0 + s * s).sqrt();
        let drift = |s: f64| 0.5 * (s.asinh() - s * root(s)) + root(b) * s;
        [drift(b) - drift(a), root(b) - root(a)]
    }
}

impl OptimalControl for Zermelo {
    fn setup(&self) -> Setup {
        let heading = vec![Channel::limited("theta", "rad", "", 0.0, 2.0 * PI)];
        Setup::new(free(&["x", "y"]), heading, [0.1, 20.0])
            .between(&exactly(Self::start()), &exactly([0.0, 0.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let (s, c) = at.u[0].sin_cos();
        (dx[0], dx[1]) = (c - at.x[1], s);
        Ok(())
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.t[1]
    }
}

/// Four coupled states kept outside a sphere that swells four times: "Alp
/// rider" (Betts 2010, example 4.10).
pub(super) struct AlpRider;

impl OptimalControl for AlpRider {
    fn setup(&self) -> Setup {
        let mut setup = Setup::new(free(&["a", "b", "c", "d"]), free(&["u", "v"]), [20.0, 20.0])
            .between(&exactly([2.0, 1.0, 2.0, 1.0]), &exactly([2.0, 3.0, 1.0, -2.0]));
        setup.path = vec![Channel::limited("terrain", "", "", 0.0, f64::INFINITY)];
        setup
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let ([a, b, c, d], [u, v]) = ([at.x[0], at.x[1], at.x[2], at.x[3]], [at.u[0], at.u[1]]);
        dx[0] = -a * 10.0 + u + v;
        dx[1] = -b * 2.0 + u + v * 2.0;
        dx[2] = -c * 3.0 + d * 5.0 + u - v;
        dx[3] = c * 5.0 - d * 3.0 + u + v * 3.0;
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        squares(at.x) * 100.0 + squares(at.u) * 0.01
    }
    fn constrain_path<S: Scalar>(&self, at: Instant<S>, values: &mut [S]) {
        let peak = |height: f64, t: f64, width: f64| (-(at.t - t).squared() * width).exp() * height;
        let terrain =
            peak(3.0, 3.0, 12.0) + peak(3.0, 6.0, 10.0) + peak(3.0, 10.0, 6.0) + peak(8.0, 15.0, 4.0);
        values[0] = squares(at.x) - terrain - 0.01;
    }
}

fn squares<S: Scalar>(values: &[S]) -> S {
    values.iter().fold(S::ZERO, |sum, v| sum + v.squared())
}

/// The cart thrown and caught below a ceiling at `0` m (Bryson & Ho 1975, 3.11).
pub(super) struct Ceiling(f64);

impl Ceiling {
    /// The cost: touching the ceiling at a point (above 1/6 m) or along it.
    fn optimum(&self) -> f64 {
        let l = self.0;
        if l > 1.0 / 6.0 { 2.0 + 6.0 * (1.0 - 4.0 * l).powi(2) } else { 4.0 / (9.0 * l) }
    }
}

impl OptimalControl for Ceiling {
    fn setup(&self) -> Setup {
        let x = Channel::limited("x", "m", "", f64::NEG_INFINITY, self.0);
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

/// A cart brought one metre on from rest to rest: with least energy in 1 s, or
/// in least time.
pub(super) struct CartProblem {
    force: f64,
    speed: f64,
    time: Limits,
    energy: bool,
}

impl OptimalControl for CartProblem {
    fn setup(&self) -> Setup {
        let limited = |name: &str, size: f64| Channel::limited(name, "", "", -size, size);
        let states = vec![Channel::free("x", "m", ""), limited("v", self.speed)];
        Setup::new(states, vec![limited("u", self.force)], self.time)
            .between(&exactly([0.0, 0.0]), &exactly([1.0, 0.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (at.x[1], at.u[0]);
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        if self.energy { at.u[0].squared() * 0.5 } else { S::ZERO }
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        if self.energy { S::ZERO } else { ends.t[1] }
    }
}

/// Least energy under a force of at most 5 N; without the limit it peaks at 6 N.
const WEAK: CartProblem = CartProblem { force: 5.0, speed: f64::INFINITY, time: [1.0, 1.0], energy: true };

/// U^2 (1/2 - 2/3 s), where the force leaves its limit U a time s before the
/// middle: s^2 = 3/4 - 3/U.
fn weak_cart() -> f64 {
    let force: f64 = 5.0;
    force * force * (0.5 - 2.0 / 3.0 * (0.75 - 3.0 / force).sqrt())
}

/// Least time under |u| <= 1 and |v| <= 1/2: 1/2 s up, 3/2 s along, 1/2 s down.
const SLOW: CartProblem = CartProblem { force: 1.0, speed: 0.5, time: [0.1, 10.0], energy: false };

/// Least time to height 5 and speed 45 along the horizon under a thrust of 100
/// (linear tangent steering; Betts 2010, example 4.6).
pub(super) struct LinearTangent;

impl OptimalControl for LinearTangent {
    fn setup(&self) -> Setup {
        Setup::new(
            free(&["x", "y", "v_x", "v_y"]),
            vec![Channel::limited("u", "rad", "", -0.5 * PI, 0.5 * PI)],
            [0.1, 10.0],
        )
        .between(&exactly([0.0; 4]), &[FREE, [5.0; 2], [45.0; 2], [0.0; 2]])
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let (s, c) = at.u[0].sin_cos();
        (dx[0], dx[1], dx[2], dx[3]) = (at.x[2], at.x[3], c * 100.0, s * 100.0);
        Ok(())
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.t[1]
    }
}

/// The shape of a chain of length 4 between (0, 1) and (1, 3) by its least
/// potential energy, the length as a state (COPS 3, problem 4).
pub(super) struct HangingChain;

impl OptimalControl for HangingChain {
    fn setup(&self) -> Setup {
        Setup::new(free(&["x", "length"]), free(&["slope"]), [1.0, 1.0])
            .between(&exactly([1.0, 0.0]), &exactly([3.0, 4.0]))
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        (dx[0], dx[1]) = (at.u[0], (at.u[0].squared() + 1.0).sqrt());
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.x[0] * (at.u[0].squared() + 1.0).sqrt()
    }
}

/// Mixing of two catalysts along a reactor, with a singular arc (Jackson 1968;
/// COPS 3, problem 14).
pub(super) struct CatalystMixing;

impl OptimalControl for CatalystMixing {
    fn setup(&self) -> Setup {
        Setup::new(free(&["a", "b"]), vec![Channel::limited("u", "", "", 0.0, 1.0)], [1.0, 1.0])
            .between(&exactly([1.0, 0.0]), &[FREE, FREE])
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let turned = at.u[0] * (at.x[1] * 10.0 - at.x[0]);
        (dx[0], dx[1]) = (turned, -turned - (-at.u[0] + 1.0) * at.x[1]);
        Ok(())
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.x[1][0] + ends.x[1][1] - 1.0
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

/// By the scheme of order 6: with inputs that are linear in each interval the
/// terrain leaves multipliers on which the solver stalls.
fn alp_rider() -> Result<Vec<ComparisonRow>, Error> {
    compare_by(Scheme::lobatto(), "alp_rider", BETTS, &AlpRider.into(), 2030.85609)
}

const BETTS: &str = "Betts 2010";

/// The comparisons.
pub const CASES: &[Case] = &[
    case!("zermelo", CLOSED_FORM, Zermelo, HEADINGS[1].tan() - HEADINGS[0].tan()),
    Case { id: "ocp.alp_rider", quick: false, run: alp_rider },
    case!("ceiling_touched", CLOSED_FORM, Ceiling(0.2), Ceiling(0.2).optimum()),
    case!("ceiling_followed", CLOSED_FORM, Ceiling(0.05), Ceiling(0.05).optimum()),
    case!("cart_limited_force", CLOSED_FORM, WEAK, weak_cart()),
    case!("cart_limited_speed", CLOSED_FORM, SLOW, 2.5),
    case!("linear_tangent", BETTS, LinearTangent, 0.554570878337),
    case!("hanging_chain", "closed form (catenary)", HangingChain, 5.068480110993416),
    case!("catalyst_mixing", "switches and mixture by Newton's method", CatalystMixing, -0.04805568586087783),
];

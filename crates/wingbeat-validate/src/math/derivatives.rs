//! First and second derivatives of every scalar function against num-dual.

use crate::{ComparisonRow, Error};
use num_dual::{Dual2_64, DualNum, HyperDual64};
use wingbeat::math::{Dual, Jet, Scalar};

type Nested = Dual<1, Dual<1>>;
type Nested2 = Dual<2, Dual<2>>;

/// A function of one variable in the three algebras, and where to try it.
struct Unary {
    nested: fn(Nested) -> Nested,
    jet: fn(Jet) -> Jet,
    oracle: fn(Dual2_64) -> Dual2_64,
    points: &'static [f64],
}

/// A function of two variables; the points are tried as pairs.
struct Binary {
    nested: fn(Nested2, Nested2) -> Nested2,
    oracle: fn(HyperDual64, HyperDual64) -> HyperDual64,
}

macro_rules! unary {
    ($x:ident: $ours:expr, $theirs:expr, $points:expr) => {
        Unary { nested: |$x| $ours, jet: |$x| $ours, oracle: |$x| $theirs, points: &$points }
    };
}

const ANY: [f64; 5] = [-2.3, -0.4, 0.1, 0.9, 3.7];
const POSITIVE: [f64; 4] = [0.02, 0.3, 1.0, 7.5];
const INSIDE: [f64; 4] = [-0.9, -0.2, 0.3, 0.95];
const WIDTH: f64 = 0.2;

fn unary() -> Vec<Unary> {
    vec![
        unary!(x: x.sqrt(), x.sqrt(), POSITIVE),
        unary!(x: x.exp(), x.exp(), ANY),
        unary!(x: x.ln(), x.ln(), POSITIVE),
        unary!(x: x.sin_cos().0, x.sin_cos().0, ANY),
        unary!(x: x.sin_cos().1, x.sin_cos().1, ANY),
        unary!(x: x.sin(), x.sin(), ANY),
        unary!(x: x.cos(), x.cos(), ANY),
        unary!(x: x.tan(), x.tan(), ANY),
        unary!(x: x.tanh(), x.tanh(), ANY),
        unary!(x: x.acos(), x.acos(), INSIDE),
        unary!(x: x.recip(), x.recip(), ANY),
        unary!(x: x.squared(), x * x, ANY),
        unary!(x: x.mul_add(x, x.sin()), x * x + x.sin(), ANY),
        unary!(x: x.smooth_abs(WIDTH), (x * x + WIDTH * WIDTH).sqrt(), ANY),
        unary!(x: x.smooth_positive(WIDTH), (x + (x * x + WIDTH * WIDTH).sqrt()) * 0.5, ANY),
        unary!(x: x.clamped(-5.0, 5.0), x, ANY),
        unary!(x: x.atan2(x * x + 0.5), x.atan2(x * x + 0.5), ANY),
        unary!(x: (-x * 3.0 + 1.0) / (x * x + 2.0) - 0.25, (-x * 3.0 + 1.0) / (x * x + 2.0) - 0.25, ANY),
    ]
}

fn binary() -> Vec<Binary> {
    vec![
        Binary { nested: |x, y| x + y, oracle: |x, y| x + y },
        Binary { nested: |x, y| x - y, oracle: |x, y| x - y },
        Binary { nested: |x, y| x * y, oracle: |x, y| x * y },
        Binary { nested: |x, y| x / y, oracle: |x, y| x / y },
        Binary { nested: |x, y| x.mul_add(y, x / y), oracle: |x, y| x * y + x / y },
        Binary { nested: |x, y| x.atan2(y), oracle: |x, y| x.atan2(y) },
        Binary { nested: |x, y| (x * y.sin()).exp() / y, oracle: |x, y| (x * y.sin()).exp() / y },
    ]
}

/// |a - b| over the size of b, at least 1.
fn error(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs().max(1.0)
}

fn unary_errors(case: &Unary) -> [f64; 2] {
    case.points.iter().fold([0.0; 2], |[first, second], &x| {
        let nested = (case.nested)(Dual { re: Dual::variable(x, 0), eps: [Dual::constant(1.0)] });
        let jet = (case.jet)(Jet::new(x, 1.0, 0.0));
        let exact = (case.oracle)(Dual2_64::new(x, 1.0, 0.0));
        let slopes = [nested.re.eps[0], nested.eps[0].re, jet.d].map(|v| error(v, exact.v1));
        let bends = [nested.eps[0].eps[0], jet.dd].map(|v| error(v, exact.v2));
        [slopes.into_iter().fold(first, f64::max), bends.into_iter().fold(second, f64::max)]
    })
}

/// The variable of direction `i`, with its derivative in both layers.
fn variable(x: f64, i: usize) -> Nested2 {
    let mut v = Dual::constant(Dual::variable(x, i));
    v.eps[i] = Dual::constant(1.0);
    v
}

fn binary_errors(case: &Binary) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for (x, y) in ANY.iter().flat_map(|x| ANY.iter().map(move |y| (*x, *y))) {
        let nested = (case.nested)(variable(x, 0), variable(y, 1));
        let exact = (case.oracle)(HyperDual64::new(x, 1.0, 0.0, 0.0), HyperDual64::new(y, 0.0, 1.0, 0.0));
        let first = error(nested.re.eps[0], exact.eps1).max(error(nested.re.eps[1], exact.eps2));
        let mixed = error(nested.eps[0].eps[1], exact.eps1eps2);
        worst = [worst[0].max(first), worst[1].max(mixed).max(error(nested.eps[1].eps[0], exact.eps1eps2))];
    }
    worst
}

/// Largest relative error of first and second derivatives over all functions and points.
pub fn against_num_dual() -> Result<Vec<ComparisonRow>, Error> {
    let all = unary().iter().map(unary_errors).chain(binary().iter().map(binary_errors)).collect::<Vec<_>>();
    let worst = |k: usize| all.iter().map(|e| e[k]).fold(0.0, f64::max);
    let metric = format!("max relative error of first ({:.0e}) and second derivatives", worst(0));
    let value = worst(0).max(worst(1));
    Ok(vec![ComparisonRow::judged("math.dual_against_num_dual", "num-dual 0.15", &metric, value, 1e-12, "")])
}

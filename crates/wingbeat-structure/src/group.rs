//! Rigid motions: places, their exponentials and the tangents of these.

use wingbeat_math::{Mat3, Scalar, Vec3};

/// Terms of the series of tangents: 1/20! of an angle of one radian per step of a beam.
const TERMS: usize = 20;

/// Position and attitude of a section; the columns of `r` are its axes.
#[derive(Clone, Copy, Debug)]
pub struct Place<S: Scalar = f64> {
    /// Position, m.
    pub p: Vec3<S>,
    /// Attitude, a rotation matrix.
    pub r: Mat3<S>,
}

impl Place {
    /// At the origin, along the axes.
    pub const IDENTITY: Self =
        Self { p: Vec3([0.0; 3]), r: Mat3([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) };
}

/// A rate of turn and a velocity, or a moment and a force.
#[derive(Clone, Copy, Debug)]
pub struct Pair<S: Scalar> {
    /// Turn, rad, or moment, N m; of a strain rad/m.
    pub turn: Vec3<S>,
    /// Displacement, m, or force, N; of a strain dimensionless.
    pub push: Vec3<S>,
}

impl<S: Scalar> Pair<S> {
    pub const ZERO: Self = Self { turn: Vec3([S::ZERO; 3]), push: Vec3([S::ZERO; 3]) };

    pub fn plus(self, other: Self, factor: f64) -> Self {
        let factor = S::from(factor);
        Self { turn: self.turn + other.turn * factor, push: self.push + other.push * factor }
    }
    pub fn times(self, factor: f64) -> Self {
        Self::ZERO.plus(self, factor)
    }
    /// The bracket [self, other] of two strains.
    pub fn bracket(self, other: Self) -> Self {
        Self {
            turn: self.turn.cross(other.turn),
            push: self.turn.cross(other.push) + self.push.cross(other.turn),
        }
    }
    /// What the load `self` does through the bracket [strain, x], as a load on x.
    pub fn through(self, strain: &Self) -> Self {
        Self {
            turn: self.turn.cross(strain.turn) + self.push.cross(strain.push),
            push: self.push.cross(strain.turn),
        }
    }
    pub fn component(&self, k: usize) -> S {
        if k < 3 { self.turn[k] } else { self.push[k - 3] }
    }
    pub fn component_mut(&mut self, k: usize) -> &mut S {
        if k < 3 { &mut self.turn[k] } else { &mut self.push[k - 3] }
    }
}

/// sin(x)/x, (1 - cos x)/x^2 and (x - sin x)/x^3 of x^2, smooth at zero.
fn ratios<S: Scalar>(square: S) -> [S; 3] {
    if square.value() > 0.25 {
        let x = square.sqrt();
        let (sin, cos) = x.sin_cos();
        return [sin / x, (-cos + 1.0) / square, (x - sin) / (square * x)];
    }
    // Sums of (-x^2)^k / (2 k + n)! for n = 1, 2, 3: below 1e-19 after eight terms.
    let series = |n: usize| {
        let mut sum = S::ZERO;
        for k in (0..8).rev() {
            let next = ((2 * k + n + 1) * (2 * k + n + 2)) as f64;
            sum = -(sum * square) / next + 1.0;
        }
        sum / [1.0, 2.0, 6.0][n - 1]
    };
    [series(1), series(2), series(3)]
}

impl<S: Scalar> Place<S> {
    /// The place that numbers say which do not change.
    pub fn constant(place: &Place) -> Self {
        Self { p: Vec3::constant(place.p), r: Mat3::constant(place.r) }
    }

    /// Goes on by the exponential of `step`.
    ///
    /// Equation: structure.exponential
    /// `R exp(turn), p + R (I + (1 - cos x)/x^2 [turn] + (x - sin x)/x^3 [turn]^2) push, x = abs(turn)`
    /// Source: Rodrigues 1840; Murray, Li & Sastry 1994, section 2.3.
    /// Test: `the_tangent_is_that_of_the_exponential`.
    pub fn moved(&self, step: &Pair<S>) -> Self {
        let (turn, push) = (step.turn, step.push);
        let [a, b, c] = ratios(turn.norm_squared());
        let cross = |v: Vec3<S>| v + turn.cross(v) * a + turn.cross(turn.cross(v)) * b;
        let axis = |k: usize| {
            let mut unit = Vec3([S::ZERO; 3]);
            unit[k] = S::ONE;
            cross(unit)
        };
        let along = push + turn.cross(push) * b + turn.cross(turn.cross(push)) * c;
        Self { p: self.p + self.r * along, r: self.r * Mat3::from_columns(axis(0), axis(1), axis(2)) }
    }
}

/// The load on a change of `step` that does the work of `load`, at the end of the step in the axes there.
///
/// Equation: structure.tangent
/// `T'w, T = sum (-ad)^k/(k + 1)! : exp(X + dX) = exp(X) exp(T dX)`
/// Source: Hausdorff 1906; Iserles et al. 2000, Acta Numerica 9, section 2.
/// Test: `the_tangent_is_that_of_the_exponential`.
pub fn drawn_back<S: Scalar>(step: &Pair<S>, load: &Pair<S>) -> Pair<S> {
    let (mut term, mut sum) = (*load, *load);
    for k in 1..TERMS {
        term = term.through(step).times(-1.0 / (k + 1) as f64);
        sum = sum.plus(term, 1.0);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Dual;

    #[test]
    fn the_tangent_is_that_of_the_exponential() {
        for size in [1e-4, 0.3, 1.1] {
            let constant = Pair { turn: Vec3::new(0.6, -0.9, 0.4) * size, push: Vec3::new(0.3, 0.8, -0.5) };
            let load = Pair { turn: Vec3::new(0.2, -1.0, 0.7), push: Vec3::new(1.1, 0.4, -0.6) };
            let drawn = drawn_back(&constant, &load);
            for k in 0..6 {
                let lift = |v: Vec3| v.each(Dual::<1>::constant);
                let mut step = Pair { turn: lift(constant.turn), push: lift(constant.push) };
                step.component_mut(k).eps[0] = 1.0;
                let end = Place::constant(&Place::IDENTITY).moved(&step);
                let r = end.r.each(|x: Dual<1>| x.re);
                let rate = end.r.each(|x: Dual<1>| x.eps[0]);
                let turning = r.transpose() * rate;
                let turn = Vec3::new(turning.0[2][1], turning.0[0][2], turning.0[1][0]);
                let push = r.transpose_mul(end.p.each(|x: Dual<1>| x.eps[0]));
                let work = load.turn.dot(turn) + load.push.dot(push);
                assert!((work - drawn.component(k)).abs() < 1e-14, "{size} {k}");
            }
        }
    }
}

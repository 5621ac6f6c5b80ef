//! Interpolation in one variable. Abscissae and values are in the caller's units.

use super::Scalar;

/// a + (b - a) s, s in [0, 1].
#[inline]
pub fn lerp<S: Scalar>(a: S, b: S, s: S) -> S {
    a + (b - a) * s
}

/// Cubic Hermite polynomial on [0, h] at t from end values and slopes: (value, slope).
#[inline]
pub fn hermite<S: Scalar>(t: S, h: S, x: [S; 2], dx: [S; 2]) -> (S, S) {
    let s = t / h;
    let (s2, one) = (s * s, S::ONE);
    let h00 = (one + s * 2.0) * (one - s) * (one - s);
    let h10 = s * (one - s) * (one - s);
    let h01 = s2 * (S::from(3.0) - s * 2.0);
    let h11 = s2 * (s - one);
    let value = h00 * x[0] + h10 * h * dx[0] + h01 * x[1] + h11 * h * dx[1];
    let d00 = (s2 - s) * 6.0;
    let d10 = s2 * 3.0 - s * 4.0 + 1.0;
    let d11 = s2 * 3.0 - s * 2.0;
    let slope = d00 * (x[0] - x[1]) / h + d10 * dx[0] + d11 * dx[1];
    (value, slope)
}

/// Piecewise-linear function through (x, y), constant outside; `x` ascending.
pub fn piecewise_linear<S: Scalar>(xs: &[S], ys: &[S], x: S) -> S {
    let last = xs.len() - 1;
    let i = xs.partition_point(|&v| v <= x).clamp(1, last.max(1)) - 1;
    if last == 0 {
        return ys[0];
    }
    let s = ((x - xs[i]) / (xs[i + 1] - xs[i])).clamped(0.0, 1.0);
    lerp(ys[i], ys[i + 1], s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hermite_reproduces_a_cubic() {
        let (f, df) =
            (|t: f64| 2.0 - t + 3.0 * t * t - 0.5 * t * t * t, |t: f64| -1.0 + 6.0 * t - 1.5 * t * t);
        let (value, slope) = hermite(0.3, 0.8, [f(0.0), f(0.8)], [df(0.0), df(0.8)]);
        assert!((value - f(0.3)).abs() < 1e-14 && (slope - df(0.3)).abs() < 1e-14);
    }

    #[test]
    fn piecewise_linear_holds_its_ends() {
        let (xs, ys) = ([0.0, 1.0, 3.0], [1.0, 3.0, -1.0]);
        let at = |x| piecewise_linear(&xs, &ys, x);
        assert_eq!((at(-1.0), at(0.5), at(2.0), at(3.0), at(9.0)), (1.0, 2.0, 1.0, -1.0, -1.0));
    }
}

//! Cubic splines with continuous second derivative.

use super::Jet;
use crate::Error;

/// A C2 cubic spline through a table, natural or periodic. Abscissae and values are in the caller's units.
#[derive(Clone, Debug, PartialEq)]
pub struct CubicSpline {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Second derivatives at the knots.
    curvature: Vec<f64>,
    period: Option<f64>,
}

impl CubicSpline {
    /// Natural spline: curvature zero at both ends, straight beyond them.
    ///
    /// # Errors
    /// [`Error::Invalid`] with fewer than two knots, or knots that do not ascend.
    pub fn natural(x: &[f64], y: &[f64]) -> Result<Self, Error> {
        check(x, y, 2)?;
        let n = x.len();
        let mut curvature = vec![0.0; n];
        if n > 2 {
            let (lower, diagonal, upper, right) = system(x, y);
            let inner = tridiagonal(&lower, &diagonal, &upper, &right);
            curvature[1..n - 1].copy_from_slice(&inner);
        }
        Ok(Self { x: x.to_vec(), y: y.to_vec(), curvature, period: None })
    }

    /// Periodic spline; the knots lie in [x0, x0 + period).
    ///
    /// # Errors
    /// [`Error::Invalid`] with fewer than three knots, or knots that do not
    /// ascend within one period.
    pub fn periodic(x: &[f64], y: &[f64], period: f64) -> Result<Self, Error> {
        check(x, y, 3)?;
        let n = x.len();
        if !(x[n - 1] - x[0] < period && period.is_finite()) {
            return Err(Error::invalid("spline.x", x[n - 1], format!("less than {} + {period}", x[0])));
        }
        // Two knots beyond each end close the ring for the inner equations.
        let knot = |i: isize| {
            let turns = i.div_euclid(n as isize);
            let k = i.rem_euclid(n as isize) as usize;
            (x[k] + turns as f64 * period, y[k])
        };
        let (ring_x, ring_y): (Vec<_>, Vec<_>) = (-1..=n as isize).map(knot).unzip();
        let (lower, diagonal, upper, right) = system(&ring_x, &ring_y);
        let curvature = cyclic(&lower, &diagonal, &upper, &right);
        let mut spline = Self { x: x.to_vec(), y: y.to_vec(), curvature, period: Some(period) };
        spline.x.push(x[0] + period);
        spline.y.push(y[0]);
        spline.curvature.push(spline.curvature[0]);
        Ok(spline)
    }

    /// Whether it repeats.
    pub fn is_periodic(&self) -> bool {
        self.period.is_some()
    }

    /// Value, slope and curvature at `x`.
    ///
    /// Equation: math.cubic_spline
    /// `C2 cubic through a table, natural or periodic`
    /// Source: Schoenberg 1946.
    /// Test: `a_periodic_spline_converges_to_a_sine_with_its_derivatives`.
    pub fn at(&self, x: f64) -> Jet<f64> {
        let x = self.period.map_or(x, |period| self.x[0] + (x - self.x[0]).rem_euclid(period));
        let last = self.x.len() - 1;
        let i = self.x.partition_point(|&knot| knot <= x).clamp(1, last) - 1;
        let h = self.x[i + 1] - self.x[i];
        if x < self.x[0] || x > self.x[last] {
            let end = if x < self.x[0] { 0 } else { last };
            let edge = self.cubic(i, if end == 0 { 0.0 } else { h });
            return Jet::new(edge.x + edge.d * (x - self.x[end]), edge.d, 0.0);
        }
        self.cubic(i, x - self.x[i])
    }

    /// The cubic of interval `i` at `t` from its left knot.
    fn cubic(&self, i: usize, t: f64) -> Jet<f64> {
        let h = self.x[i + 1] - self.x[i];
        let (m0, m1) = (self.curvature[i], self.curvature[i + 1]);
        let slope = (self.y[i + 1] - self.y[i]) / h - h * (2.0 * m0 + m1) / 6.0;
        let t = Jet::new(t, 1.0, 0.0);
        t * (t * (t * ((m1 - m0) / (6.0 * h)) + 0.5 * m0) + slope) + self.y[i]
    }

    /// The spline with its values multiplied by `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.y.iter_mut().chain(&mut self.curvature).for_each(|v| *v *= factor);
        self
    }
}

fn check(x: &[f64], y: &[f64], least: usize) -> Result<(), Error> {
    if x.len() < least || x.len() != y.len() {
        return Err(Error::invalid("spline.knots", x.len(), format!("at least {least}, as many x as y")));
    }
    for (i, (&a, &b)) in x.iter().zip(y).enumerate() {
        if !(a.is_finite() && b.is_finite() && (i == 0 || a > x[i - 1])) {
            return Err(Error::invalid(format!("spline.x[{i}]"), a, "finite and more than the one before"));
        }
    }
    Ok(())
}

/// Rows of continuity of the slope at the inner knots: (lower, diagonal, upper, right side).
fn system(x: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>) {
    let rows = 1..x.len() - 1;
    let h = |i: usize| x[i + 1] - x[i];
    let slope = |i: usize| (y[i + 1] - y[i]) / h(i);
    (
        rows.clone().map(|i| h(i - 1) / 6.0).collect(),
        rows.clone().map(|i| (h(i - 1) + h(i)) / 3.0).collect(),
        rows.clone().map(|i| h(i) / 6.0).collect(),
        rows.map(|i| slope(i) - slope(i - 1)).collect(),
    )
}

/// Thomas' algorithm; the matrix is diagonally dominant.
fn tridiagonal(lower: &[f64], diagonal: &[f64], upper: &[f64], right: &[f64]) -> Vec<f64> {
    let n = diagonal.len();
    let (mut c, mut d) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        let (before_c, before_d) = if i == 0 { (0.0, 0.0) } else { (c[i - 1], d[i - 1]) };
        let pivot = diagonal[i] - lower[i] * before_c;
        c[i] = upper[i] / pivot;
        d[i] = (right[i] - lower[i] * before_d) / pivot;
    }
    for i in (0..n.saturating_sub(1)).rev() {
        d[i] -= c[i] * d[i + 1];
    }
    d
}

/// A tridiagonal system closed to a ring by lower[0] and upper[n-1]
/// (Sherman-Morrison).
fn cyclic(lower: &[f64], diagonal: &[f64], upper: &[f64], right: &[f64]) -> Vec<f64> {
    let n = diagonal.len();
    let corner = -diagonal[0];
    let mut shifted = diagonal.to_vec();
    shifted[0] -= corner;
    shifted[n - 1] -= lower[0] * upper[n - 1] / corner;
    let mut u = vec![0.0; n];
    (u[0], u[n - 1]) = (corner, upper[n - 1]);
    let y = tridiagonal(lower, &shifted, upper, right);
    let q = tridiagonal(lower, &shifted, upper, &u);
    let v = lower[0] / corner;
    let factor = (y[0] + v * y[n - 1]) / (1.0 + q[0] + v * q[n - 1]);
    y.iter().zip(&q).map(|(y, q)| y - factor * q).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_periodic_spline_converges_to_a_sine_with_its_derivatives() {
        let error = |n: usize| {
            let x: Vec<f64> = (0..n).map(|i| 0.3 + 2.0 * i as f64 / n as f64).collect();
            let y: Vec<f64> = x.iter().map(|x| (TAU * x / 2.0).sin()).collect();
            let spline = CubicSpline::periodic(&x, &y, 2.0).unwrap();
            (0..200).fold([0.0_f64; 3], |worst, k| {
                let at = -5.0 + 0.06 * k as f64;
                let (s, c) = (TAU * at / 2.0).sin_cos();
                let w = TAU / 2.0;
                let f = spline.at(at);
                let e = [f.x - s, f.d - w * c, f.dd + w * w * s];
                std::array::from_fn(|j| worst[j].max(e[j].abs()))
            })
        };
        let (coarse, fine) = (error(16), error(32));
        for (j, order) in [4.0, 3.0, 2.0].into_iter().enumerate() {
            let observed = (coarse[j] / fine[j]).log2();
            assert!(observed > order - 0.3, "derivative {j}: order {observed}");
        }
    }

    #[test]
    fn a_natural_spline_is_smooth_at_its_knots_and_straight_outside() {
        let (x, y) = ([0.0, 1.0, 1.5, 3.0], [1.0, -1.0, 2.0, 0.5]);
        let spline = CubicSpline::natural(&x, &y).unwrap();
        for (i, knot) in x.iter().enumerate() {
            let (a, b) = (spline.at(knot - 1e-9), spline.at(knot + 1e-9));
            assert!((spline.at(*knot).x - y[i]).abs() < 1e-14);
            assert!((a.d - b.d).abs() < 1e-6 && (a.dd - b.dd).abs() < 1e-6, "knot {i}");
        }
        let (a, b) = (spline.at(4.0), spline.at(5.0));
        assert!((a.x + a.d - b.x).abs() < 1e-14 && b.dd == 0.0);
        assert_eq!(CubicSpline::natural(&[0.0, 2.0], &[0.0, 4.0]).unwrap().at(0.5), Jet::new(1.0, 2.0, 0.0));
    }

    #[test]
    fn knots_must_ascend_within_a_period() {
        assert!(CubicSpline::natural(&[0.0, 0.0], &[1.0, 2.0]).is_err());
        assert!(CubicSpline::periodic(&[0.0, 0.5, 1.0], &[1.0, 2.0, 1.0], 1.0).is_err());
    }
}

//! Lobatto collocation schemes: a scheme is its abscissae; weights and defects follow.

/// How the input varies inside an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputShape {
    /// Linear between the nodes; limits hold at the nodes.
    Linear,
    /// The polynomial through its values at every collocation point; limits
    /// hold at every collocation point.
    Polynomial,
}

/// A collocation scheme on the unit interval with both ends among its points
/// (Lobatto IIIA). Its defects at the points j > 0 are
/// x_j - x_0 - h sum_i A_ji f_i, and A_ji = int_0^{c_j} l_i with the Lagrange
/// polynomials l_i of the points; the last row of A is the quadrature.
///
/// With three points and a linear input this is the Hermite-Simpson method:
/// its middle defect says that the middle state lies on the cubic through the
/// ends. The compressed form puts that cubic in place of the middle state, which
/// leaves the solutions as they are and half the unknowns.
#[derive(Clone, Debug)]
pub struct Scheme {
    /// Name in the literature.
    pub name: &'static str,
    /// The error at a fixed time falls as h^order.
    pub order: i32,
    /// Points, from 0 to 1 as shares of the interval.
    pub c: Vec<f64>,
    /// Integrals of the Lagrange polynomials, one row per point, as shares of the interval.
    pub a: Vec<Vec<f64>>,
    /// The input between the nodes.
    pub input: InputShape,
    /// The state inside an interval is the middle of the cubic through its
    /// ends, not an unknown; of three points only.
    pub compressed: bool,
}

impl Scheme {
    fn new(name: &'static str, c: &[f64], input: InputShape) -> Self {
        let a = c.iter().map(|&end| integrals(c, end)).collect();
        Self { name, order: 2 * (c.len() as i32 - 1), c: c.to_vec(), a, input, compressed: false }
    }

    /// x quadratic, rates linear: order 2.
    pub fn trapezoid() -> Self {
        Self::new("trapezoid", &[0.0, 1.0], InputShape::Linear)
    }

    /// x cubic, input linear: order 4 (Hargraves & Paris 1987).
    pub fn hermite_simpson() -> Self {
        Self { name: "Hermite-Simpson", compressed: true, ..Self::separated_hermite_simpson() }
    }

    /// The same with the middle states as unknowns.
    pub fn separated_hermite_simpson() -> Self {
        Self::new("Hermite-Simpson, separated", &[0.0, 0.5, 1.0], InputShape::Linear)
    }

    /// x quartic, input cubic, four Gauss-Lobatto points: order 6.
    pub fn lobatto() -> Self {
        let c = 0.5 - 0.5 / 5.0_f64.sqrt();
        Self::new("Gauss-Lobatto 4", &[0.0, c, 1.0 - c, 1.0], InputShape::Polynomial)
    }

    /// Number of points, both ends included.
    pub fn points(&self) -> usize {
        self.c.len()
    }

    /// The points whose defects are equations of the program.
    pub fn defects(&self) -> std::ops::Range<usize> {
        if self.compressed { self.points() - 1..self.points() } else { 1..self.points() }
    }

    /// Quadrature weights on the unit interval.
    pub fn weights(&self) -> &[f64] {
        &self.a[self.c.len() - 1]
    }

    /// Integrals from 0 to `s` of the Lagrange polynomials, all as shares of the interval.
    ///
    /// Equation: ocp.lobatto
    /// `x_j - x_0 - h sum_i A_ji f_i = 0, A_ji = integral of the Lagrange polynomial l_i to c_j`
    /// Source: Lobatto IIIA; Betts 2010, ch. 4.
    /// Test: `quadratures_reach_their_order`.
    pub fn integrals(&self, s: f64) -> Vec<f64> {
        integrals(&self.c, s)
    }

    /// The input at `s` as weights of its values at the points.
    pub fn input_weights(&self, s: f64) -> Vec<f64> {
        match self.input {
            InputShape::Polynomial => lagrange(&self.c, s),
            InputShape::Linear => {
                let mut weights = vec![0.0; self.c.len()];
                (weights[0], weights[self.c.len() - 1]) = (1.0 - s, s);
                weights
            }
        }
    }

    /// The rates at `s` as weights of their values at the points.
    pub fn rate_weights(&self, s: f64) -> Vec<f64> {
        lagrange(&self.c, s)
    }
}

/// Values at `s` of the Lagrange polynomials through `c`.
fn lagrange(c: &[f64], s: f64) -> Vec<f64> {
    let factor = |i: usize, j: usize| if i == j { 1.0 } else { (s - c[j]) / (c[i] - c[j]) };
    (0..c.len()).map(|i| (0..c.len()).map(|j| factor(i, j)).product()).collect()
}

/// Integrals from 0 to `end` of the Lagrange polynomials through `c`, by
/// expanding each into its monomials.
fn integrals(c: &[f64], end: f64) -> Vec<f64> {
    let integral = |i: usize| {
        let mut monomials = vec![1.0];
        for (j, &root) in c.iter().enumerate().filter(|&(j, _)| j != i) {
            let scale = 1.0 / (c[i] - c[j]);
            monomials.push(0.0);
            for k in (0..monomials.len()).rev() {
                let below = if k > 0 { monomials[k - 1] } else { 0.0 };
                monomials[k] = scale * (below - root * monomials[k]);
            }
        }
        monomials.iter().enumerate().map(|(k, m)| m * end.powi(k as i32 + 1) / (k + 1) as f64).sum()
    };
    (0..c.len()).map(integral).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{IntervalEnds, Midpoint, Transcription};
    use super::*;

    #[test]
    fn quadratures_reach_their_order() {
        for scheme in [Scheme::trapezoid(), Scheme::hermite_simpson(), Scheme::lobatto()] {
            let integrate = |power: i32| -> f64 {
                scheme.weights().iter().zip(&scheme.c).map(|(w, c)| w * c.powi(power)).sum()
            };
            for power in 0..scheme.order {
                assert!((integrate(power) - 1.0 / f64::from(power + 1)).abs() < 1e-14, "{}", scheme.name);
            }
            assert!((integrate(scheme.order) - 1.0 / f64::from(scheme.order + 1)).abs() > 1e-4);
        }
    }

    #[test]
    fn three_points_are_the_compressed_method_with_its_middle_state_kept() {
        let (h, rate) = (0.3, |t: f64, x: f64, u: f64| (3.0 * x).sin() + u + t);
        let (x0, x1, u) = (0.4, 0.9, [0.2, -0.5]);
        let f = [rate(0.0, x0, u[0]), rate(h, x1, u[1])];
        let interval =
            IntervalEnds { t: 0.0, h, x: [&[x0], &[x1]], u: [&u[..1], &u[1..]], f: [&f[..1], &f[1..]] };
        let (mut middle, mut defect) = (Midpoint::new(1, 1), [0.0]);
        let rates = |t: f64, x: &[f64], u: &[f64], dx: &mut [f64]| {
            dx[0] = rate(t, x[0], u[0]);
            Ok(())
        };
        Transcription::HermiteSimpson.defect(&interval, rates, &mut middle, &mut defect).unwrap();
        // x_c = x_0 + h sum A_1i f_i + defect/2 is the compressed middle state.
        let scheme = Scheme::hermite_simpson();
        let all = [f[0], middle.f[0], f[1]];
        let sum = |row: &[f64]| h * row.iter().zip(&all).map(|(a, f)| a * f).sum::<f64>();
        assert!((x1 - x0 - sum(&scheme.a[2]) - defect[0]).abs() < 1e-15);
        assert!((x0 + sum(&scheme.a[1]) + 0.5 * defect[0] - middle.x[0]).abs() < 1e-15);
    }
}

//! The part of the curvature that Gauss-Newton leaves out. Gradients, steps and curvatures are in the caller's units.

use wingbeat_math::rows::{axpy, dot};

/// A symmetric correction A to the Gauss-Newton Hessian G, learnt from the
/// reduced gradients of successive iterates by symmetric rank-one updates, so
/// that (G + A) s = y (structured secant: Dennis, Gay & Welsch 1981).
#[derive(Clone, Debug)]
pub struct Correction {
    matrix: Vec<f64>,
    /// Gradient before the last step.
    gradient: Vec<f64>,
    step: Vec<f64>,
    gap: Vec<f64>,
    /// Steps recorded since the last start.
    steps: usize,
}

impl Correction {
    /// No correction, for `n` variables.
    pub fn new(n: usize) -> Self {
        Self {
            matrix: vec![0.0; n * n],
            gradient: vec![0.0; n],
            step: vec![0.0; n],
            gap: vec![0.0; n],
            steps: 0,
        }
    }

    /// Forgets everything.
    pub fn start(&mut self) {
        self.matrix.fill(0.0);
        self.steps = 0;
    }

    /// Remembers the gradient at this point and the step taken from it.
    pub fn record(&mut self, gradient: &[f64], step: &[f64]) {
        self.gradient.copy_from_slice(gradient);
        self.step.copy_from_slice(step);
        self.steps += 1;
    }

    /// Learns from the gradient and Gauss-Newton Hessian at the new point:
    /// v = y - (G + A) s, A += v v' / (v's).
    ///
    /// Equation: ocp.secant
    /// `A += v v' / (v's), v = y - (G + A) s`
    /// Source: Dennis, Gay & Welsch 1981; Conn, Gould & Toint 1991.
    /// Test: `a_quadratic_is_learnt_in_as_many_steps_as_it_has_variables`.
    pub fn learn(&mut self, gradient: &[f64], hessian: &[f64]) {
        if self.steps == 0 {
            return;
        }
        let n = self.gap.len();
        for i in 0..n {
            let known = dot(&hessian[i * n..][..n], &self.step) + dot(&self.matrix[i * n..][..n], &self.step);
            self.gap[i] = gradient[i] - self.gradient[i] - known;
        }
        let along = dot(&self.gap, &self.step);
        let size = dot(&self.gap, &self.gap) * dot(&self.step, &self.step);
        if along * along > 1e-8 * size {
            for i in 0..n {
                axpy(&mut self.matrix[i * n..][..n], self.gap[i] / along, &self.gap);
            }
        }
    }

    /// Adds the correction to `hessian`.
    pub fn add_to(&self, hessian: &mut [f64]) {
        axpy(hessian, 1.0, &self.matrix);
    }

    /// Takes the correction back out of `hessian` and forgets it.
    pub fn withdraw(&mut self, hessian: &mut [f64]) {
        axpy(hessian, -1.0, &self.matrix);
        self.start();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_learnt_in_as_many_steps_as_it_has_variables() {
        let exact = [5.0, 1.0, 1.0, -2.0];
        let gauss_newton = [4.0, 0.0, 0.0, 1.0];
        let mut correction = Correction::new(2);
        let mut gradient = [0.3, -0.2];
        for step in [[1.0, 0.5], [-0.25, 1.0]] {
            correction.record(&gradient, &step);
            for i in 0..2 {
                gradient[i] += dot(&exact[2 * i..][..2], &step);
            }
            correction.learn(&gradient, &gauss_newton);
        }
        let mut hessian = gauss_newton;
        correction.add_to(&mut hessian);
        assert!(hessian.iter().zip(&exact).all(|(a, b)| (a - b).abs() < 1e-12), "{hessian:?}");
        correction.withdraw(&mut hessian);
        assert!(hessian.iter().zip(&gauss_newton).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}

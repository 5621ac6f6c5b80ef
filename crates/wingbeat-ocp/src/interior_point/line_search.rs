//! The filter line search with second-order corrections
//! (Waechter & Biegler 2006, algorithm A).

use super::filter::{GAMMA_PHI, GAMMA_THETA};
use super::solver::{SearchStep, Solver};

/// Armijo's share of the predicted decrease.
const ETA: f64 = 1e-8;
/// Powers of the switching condition.
const POWER_THETA: f64 = 1.1;
const POWER_PHI: f64 = 2.3;
/// Shortest step, as a share of what could still be acceptable.
const SHORTEST: f64 = 0.05;
/// Second-order corrections per step, and their required progress.
const CORRECTIONS: usize = 4;
const CORRECTION_PROGRESS: f64 = 0.99;
/// Infeasibility up to which shortened steps are corrected, as a multiple of that below which the objective alone may decide: a
/// choice that leaves steps far from feasible points as they are.
const NEAR: f64 = 100.0;
/// Smallest share of the distance to the limits that a step may use.
const LEAST_TAU: f64 = 0.99;
/// Steps in a row shortened by the filter alone that clear it, and how often
/// (IPOPT's reset: corners left by a worse part of the path hold the solve up).
const REFUSALS: usize = 5;
const CLEARINGS: usize = 5;
/// Steps below this, relative to the point, are taken as they are.
const TINY_STEP: f64 = 10.0 * f64::EPSILON;

/// The measures at the present point that a trial is held against.
#[derive(Clone, Copy)]
struct Here {
    theta: f64,
    phi: f64,
    /// Slope of phi along the step.
    slope: f64,
}

impl Here {
    /// True when the predicted decrease of phi outweighs the infeasibility.
    fn switches(&self, alpha: f64, theta_small: f64) -> bool {
        self.theta <= theta_small
            && self.slope < 0.0
            && alpha * (-self.slope).powf(POWER_PHI) > self.theta.powf(POWER_THETA)
    }

    fn shortest(&self, theta_small: f64) -> f64 {
        let mut share = GAMMA_THETA;
        if self.slope < 0.0 {
            share = share.min(GAMMA_PHI * self.theta / -self.slope);
            if self.theta <= theta_small {
                share = share.min(self.theta.powf(POWER_THETA) / (-self.slope).powf(POWER_PHI));
            }
        }
        (SHORTEST * share).max(1e-13)
    }

    /// Room for rounding in a comparison of phi.
    fn rounding(&self) -> f64 {
        10.0 * f64::EPSILON * self.phi.abs()
    }
}

impl Solver<'_> {
    /// Moves the point along the Newton step as far as the filter allows.
    pub(super) fn search(&mut self) -> SearchStep {
        let tau = LEAST_TAU.max(1.0 - self.mu);
        let here = Here {
            theta: self.point.theta(&self.standard),
            phi: self.point.phi(&self.standard, self.mu),
            slope: self.slope.iter().zip(&self.dw).map(|(g, d)| g * d).sum(),
        };
        let longest = self.point.longest_step(&self.standard, &self.dw, tau);
        if self.is_tiny() {
            return if self.evaluate_trial(longest) { self.take(longest, tau) } else { SearchStep::None };
        }
        let shortest = here.shortest(self.theta_small);
        let mut alpha = longest;
        self.refused = false;
        while alpha >= shortest {
            if self.evaluate_trial(alpha) {
                if self.acceptable(&here, alpha) {
                    self.reconsider_filter(&here);
                    return self.take(alpha, tau);
                }
                let worse = self.trial.theta(&self.standard) >= here.theta;
                if alpha == longest && worse && self.correct(&here, alpha, tau) {
                    return self.take(alpha, tau);
                }
                let bends = alpha < longest && worse && here.theta <= NEAR * self.theta_small;
                if bends && let Some(reach) = self.bend(&here, alpha, tau) {
                    return self.take(reach, tau);
                }
            }
            alpha *= 0.5;
        }
        SearchStep::None
    }

    fn is_tiny(&self) -> bool {
        self.dw.iter().zip(&self.point.w).all(|(d, w)| d.abs() <= TINY_STEP * (1.0 + w.abs()))
    }

    /// Evaluates the trial point w + alpha dw; false where the model fails.
    fn evaluate_trial(&mut self, alpha: f64) -> bool {
        let n = self.standard.n;
        for (t, (w, d)) in self.trial.w.iter_mut().zip(self.point.w.iter().zip(&self.dw)) {
            *t = w + alpha * d;
        }
        match self.standard.evaluate(&self.trial.w[..n], &mut self.trial.g) {
            Ok(f) => self.trial.objective = f,
            Err(_) => return false,
        }
        self.trial.objective.is_finite() && self.trial.theta(&self.standard).is_finite()
    }

    /// Tests the trial point; a step that is not one of descent in phi adds
    /// the present point to the filter.
    fn acceptable(&mut self, here: &Here, alpha: f64) -> bool {
        let (theta, phi) = (self.trial.theta(&self.standard), self.trial.phi(&self.standard, self.mu));
        let rounding = here.rounding();
        let descends = here.switches(alpha, self.theta_small);
        let better = if descends {
            phi - here.phi <= ETA * alpha * here.slope + rounding
        } else {
            theta <= (1.0 - GAMMA_THETA) * here.theta || phi - here.phi <= -GAMMA_PHI * here.theta + rounding
        };
        if !phi.is_finite() || !better {
            self.refused = false;
            return false;
        }
        if !self.filter.accepts(theta, phi - rounding) {
            self.refused = true;
            return false;
        }
        if !descends {
            self.filter.add(here.theta, here.phi);
        }
        true
    }

    /// Clears the filter when, near feasible points, it alone has shortened
    /// several steps in a row.
    fn reconsider_filter(&mut self, here: &Here) {
        self.refusals = if self.refused && here.theta <= self.theta_small { self.refusals + 1 } else { 0 };
        if self.refusals >= REFUSALS && self.clearings < CLEARINGS {
            self.filter.clear();
            (self.refusals, self.clearings) = (0, self.clearings + 1);
        }
    }

    /// Second-order corrections: steps that account for the constraints'
    /// values at the trial point. On success the step is replaced.
    fn correct(&mut self, here: &Here, alpha: f64, tau: f64) -> bool {
        let (dw, dy) = (self.dw.clone(), self.dy.clone());
        let mut factor = alpha;
        let mut last = here.theta;
        for _ in 0..CORRECTIONS {
            let theta = self.trial.theta(&self.standard);
            if theta > CORRECTION_PROGRESS * last && last != here.theta {
                break;
            }
            last = theta;
            for i in 0..self.c.len() {
                self.c[i] = factor * self.c[i] + self.trial.row(&self.standard, i);
            }
            self.kkt.solve(&self.standard, &self.r, &self.c, &mut self.dw, &mut self.dy);
            factor = self.point.longest_step(&self.standard, &self.dw, tau);
            if !self.evaluate_trial(factor) {
                break;
            }
            if self.acceptable(here, alpha) {
                return true;
            }
        }
        (self.dw, self.dy) = (dw, dy);
        false
    }

    /// Corrects a shortened step, so that the search near feasible points follows an arc along the constraints: by how much they
    /// bend away from the step of length `alpha` falls with its square, and a correction finds them again where that is little.
    /// On success the step is replaced; returns its length.
    ///
    /// w + alpha dw + d with A d = -c(w + alpha dw) and c = g - s is the Newton step for c(w) + c(w + alpha dw) / alpha.
    /// After Mayne & Polak 1982 (Mathematical Programming Study 16:45-61), whose arc has the one correction of the whole step.
    /// Test: `steps_follow_constraints_that_bend`.
    fn bend(&mut self, here: &Here, alpha: f64, tau: f64) -> Option<f64> {
        let (dw, dy) = (self.dw.clone(), self.dy.clone());
        for i in 0..self.c.len() {
            self.c[i] = self.point.row(&self.standard, i) + self.trial.row(&self.standard, i) / alpha;
        }
        self.kkt.solve(&self.standard, &self.r, &self.c, &mut self.dw, &mut self.dy);
        let reach = alpha.min(self.point.longest_step(&self.standard, &self.dw, tau));
        if self.evaluate_trial(reach) && self.acceptable(here, alpha) {
            return Some(reach);
        }
        (self.dw, self.dy) = (dw, dy);
        None
    }

    /// Makes the trial point the present one.
    fn take(&mut self, alpha: f64, tau: f64) -> SearchStep {
        self.step = alpha;
        std::mem::swap(&mut self.point.w, &mut self.trial.w);
        std::mem::swap(&mut self.point.g, &mut self.trial.g);
        self.point.objective = self.trial.objective;
        for (y, d) in self.point.y.iter_mut().zip(&self.dy) {
            *y += alpha * d;
        }
        self.point.step_limits(&self.standard, &self.trial.w, &self.dw, self.mu, tau);
        SearchStep::Taken
    }
}

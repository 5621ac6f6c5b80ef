//! A point of the barrier method and the measures taken at it.

use super::standard::Standard;

/// Pull of the objective on components with one limit only, per barrier, so
/// that none runs off (Waechter & Biegler 2006, 3.7).
const DAMPING: f64 = 1e-5;
/// Mean multiplier above which the dual errors are scaled down.
const LARGEST_MEAN: f64 = 100.0;
/// How far a limit's multiplier may stray from barrier / distance.
const LARGEST_STRAY: f64 = 1e10;

/// Unknowns w = (x, s), multipliers y of the rows and z of the limits, and
/// the scaled functions at x.
#[derive(Clone, Debug, Default)]
pub(super) struct Iterate {
    pub w: Vec<f64>,
    pub y: Vec<f64>,
    pub z_low: Vec<f64>,
    pub z_high: Vec<f64>,
    pub objective: f64,
    pub g: Vec<f64>,
}

/// Errors of the optimality conditions, largest component each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    pub stationarity: f64,
    pub feasibility: f64,
    pub complementarity: f64,
}

impl Errors {
    pub fn largest(&self) -> f64 {
        self.stationarity.max(self.feasibility).max(self.complementarity)
    }
}

impl Iterate {
    /// Takes the values of another point, into the room that is there.
    pub fn copy(&mut self, other: &Self) {
        let Self { w, y, z_low, z_high, objective, g } = other;
        self.w.clone_from(w);
        self.y.clone_from(y);
        self.z_low.clone_from(z_low);
        self.z_high.clone_from(z_high);
        self.objective = *objective;
        self.g.clone_from(g);
    }

    /// Residual g - s of row `i`.
    pub fn row(&self, standard: &Standard, i: usize) -> f64 {
        self.g[i] - self.w[standard.n + i]
    }

    /// Writes the residuals g - s.
    pub fn rows(&self, standard: &Standard, out: &mut [f64]) {
        for (i, c) in out.iter_mut().enumerate() {
            *c = self.row(standard, i);
        }
    }

    /// Infeasibility, sum |g - s|.
    pub fn theta(&self, standard: &Standard) -> f64 {
        (0..standard.m).map(|i| self.row(standard, i).abs()).sum()
    }

    /// Barrier objective f - mu sum ln(distance to the limits).
    pub fn phi(&self, standard: &Standard, mu: f64) -> f64 {
        let mut logs = 0.0;
        for (k, &w) in self.w.iter().enumerate() {
            let (low, high) = (standard.low[k], standard.high[k]);
            match (low.is_finite(), high.is_finite()) {
                (true, true) => logs += ((w - low) * (high - w)).ln(),
                (true, false) => logs += (w - low).ln() - DAMPING * (w - low),
                (false, true) => logs += (high - w).ln() - DAMPING * (high - w),
                (false, false) => {}
            }
        }
        self.objective - mu * logs
    }

    /// Gradient of phi over w.
    pub fn phi_gradient(&self, standard: &Standard, mu: f64, out: &mut [f64]) {
        let n = standard.n;
        out[..n].copy_from_slice(&standard.derivatives.gradient);
        out[n..].fill(0.0);
        for (k, r) in out.iter_mut().enumerate() {
            let (low, high) = (standard.low[k], standard.high[k]);
            match (low.is_finite(), high.is_finite()) {
                (true, true) => *r += mu / (high - self.w[k]) - mu / (self.w[k] - low),
                (true, false) => *r += mu * (DAMPING - 1.0 / (self.w[k] - low)),
                (false, true) => *r += mu * (1.0 / (high - self.w[k]) - DAMPING),
                (false, false) => {}
            }
            if !standard.free[k] {
                *r = 0.0;
            }
        }
    }

    /// Writes (A' y, -y), the slope of the rows' part of the Lagrangian.
    pub fn pull(&self, standard: &Standard, out: &mut [f64]) {
        out[..standard.n].fill(0.0);
        standard.add_transposed(&self.y, out);
        for (i, y) in self.y.iter().enumerate() {
            out[standard.n + i] = -y;
        }
    }

    /// Diagonal of the condensed limits, z / distance.
    pub fn sigma(&self, standard: &Standard, out: &mut [f64]) {
        for (k, s) in out.iter_mut().enumerate() {
            *s = self.z_low[k] / (self.w[k] - standard.low[k])
                + self.z_high[k] / (standard.high[k] - self.w[k]);
        }
    }

    /// Errors of the optimality conditions for the barrier `mu`, with the [`pull`](Self::pull) of the rows.
    pub fn errors(&self, standard: &Standard, mu: f64, pull: &[f64]) -> Errors {
        let gradient = &standard.derivatives.gradient;
        let mut stationarity = 0.0_f64;
        for k in 0..self.w.len() {
            let slope = if k < standard.n { gradient[k] + pull[k] } else { pull[k] };
            let slope = if standard.free[k] { slope } else { 0.0 };
            stationarity = stationarity.max((slope - self.z_low[k] + self.z_high[k]).abs());
        }
        let sum_y: f64 = self.y.iter().map(|y| y.abs()).sum();
        let (sum_z, count, largest) = self.limits(standard, mu);
        Errors {
            stationarity: stationarity / mean(sum_y + sum_z, standard.m + count),
            feasibility: (0..standard.m).fold(0.0_f64, |m, i| m.max(self.row(standard, i).abs())),
            complementarity: largest / mean(sum_z, count),
        }
    }

    /// Sum of the multipliers of the limits, how many there are, and how far multiplier times distance is from `mu` at most.
    fn limits(&self, standard: &Standard, mu: f64) -> (f64, usize, f64) {
        let (mut sum, mut count, mut largest) = (0.0, 0, 0.0_f64);
        for k in 0..self.w.len() {
            let (low, high) = (self.w[k] - standard.low[k], standard.high[k] - self.w[k]);
            for (z, distance) in [(self.z_low[k], low), (self.z_high[k], high)] {
                if distance.is_finite() {
                    (sum, count) = (sum + z, count + 1);
                    largest = largest.max((z * distance - mu).abs());
                }
            }
        }
        (sum, count, largest)
    }

    /// Error of complementarity for the barrier `mu`.
    pub fn complementarity(&self, standard: &Standard, mu: f64) -> f64 {
        let (sum, count, largest) = self.limits(standard, mu);
        largest / mean(sum, count)
    }

    /// Longest step in (0, 1] along `dw` that keeps the share 1 - `tau` of
    /// every distance to the limits.
    pub fn longest_step(&self, standard: &Standard, dw: &[f64], tau: f64) -> f64 {
        let mut alpha = 1.0_f64;
        for (k, &d) in dw.iter().enumerate() {
            if d < 0.0 {
                alpha = alpha.min(-tau * (self.w[k] - standard.low[k]) / d);
            } else if d > 0.0 {
                alpha = alpha.min(tau * (standard.high[k] - self.w[k]) / d);
            }
        }
        alpha
    }

    /// Moves the limits' multipliers along their Newton step for `dw`, as far
    /// as they stay positive; returns the step length.
    pub fn step_limits(&mut self, standard: &Standard, old: &[f64], dw: &[f64], mu: f64, tau: f64) -> f64 {
        let newton = |z: f64, distance: f64, change: f64| (mu - z * change) / distance - z;
        let mut alpha = 1.0_f64;
        for (k, &d) in dw.iter().enumerate() {
            let sides = [
                (self.z_low[k], newton(self.z_low[k], old[k] - standard.low[k], d)),
                (self.z_high[k], newton(self.z_high[k], standard.high[k] - old[k], -d)),
            ];
            for (z, dz) in sides {
                if z > 0.0 && dz < 0.0 {
                    alpha = alpha.min(-tau * z / dz);
                }
            }
        }
        for (k, &d) in dw.iter().enumerate() {
            if standard.low[k].is_finite() {
                self.z_low[k] += alpha * newton(self.z_low[k], old[k] - standard.low[k], d);
            }
            if standard.high[k].is_finite() {
                self.z_high[k] += alpha * newton(self.z_high[k], standard.high[k] - old[k], -d);
            }
        }
        self.bound_limits(standard, mu);
        alpha
    }

    /// Keeps each z within a factor of mu / distance.
    fn bound_limits(&mut self, standard: &Standard, mu: f64) {
        let near = |z: f64, distance: f64| {
            let central = mu / distance;
            z.clamp(central / LARGEST_STRAY, central * LARGEST_STRAY)
        };
        for k in 0..self.w.len() {
            if standard.low[k].is_finite() {
                self.z_low[k] = near(self.z_low[k], self.w[k] - standard.low[k]);
            }
            if standard.high[k].is_finite() {
                self.z_high[k] = near(self.z_high[k], standard.high[k] - self.w[k]);
            }
        }
    }

    /// Sets every limit's multiplier to mu / distance, at most `most`.
    pub fn center_limits(&mut self, standard: &Standard, mu: f64, most: f64) {
        for k in 0..self.w.len() {
            self.z_low[k] = (mu / (self.w[k] - standard.low[k])).min(most);
            self.z_high[k] = (mu / (standard.high[k] - self.w[k])).min(most);
        }
    }
}

/// `value` moved inside [low, high] by at least `share` of the range or of the
/// limit's size, whichever is less (Waechter & Biegler 2006, 3.6).
pub(super) fn inside(value: f64, low: f64, high: f64, share: f64) -> f64 {
    let margin = |limit: f64| (share * limit.abs().max(1.0)).min(share * (high - low));
    match (low.is_finite(), high.is_finite()) {
        (true, true) => value.max(low + margin(low)).min(high - margin(high)),
        (true, false) => value.max(low + margin(low)),
        (false, true) => value.min(high - margin(high)),
        (false, false) => value,
    }
}

/// The mean of `count` multipliers as a multiple of what is not scaled down, at least one.
fn mean(sum: f64, count: usize) -> f64 {
    (sum / count.max(1) as f64).max(LARGEST_MEAN) / LARGEST_MEAN
}

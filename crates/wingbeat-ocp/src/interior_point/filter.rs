//! The filter: pairs of infeasibility and barrier objective that a step must
//! improve upon (Fletcher & Leyffer 2002; Waechter & Biegler 2006, 2.3).

/// Required decrease of the infeasibility.
pub(super) const GAMMA_THETA: f64 = 1e-5;
/// Required decrease of the objective per infeasibility.
pub(super) const GAMMA_PHI: f64 = 1e-8;

#[derive(Clone, Debug, Default)]
pub(super) struct Filter {
    corners: Vec<(f64, f64)>,
    ceiling: f64,
}

impl Filter {
    /// An empty filter that refuses infeasibility above `ceiling`.
    pub fn new(ceiling: f64) -> Self {
        Self { corners: Vec::new(), ceiling }
    }

    /// Refuses infeasibility above `ceiling` from now on.
    pub fn lower_ceiling(&mut self, ceiling: f64) {
        self.ceiling = self.ceiling.min(ceiling);
    }

    pub fn clear(&mut self) {
        self.corners.clear();
    }

    /// True when no corner is at least as good in both measures.
    pub fn accepts(&self, theta: f64, phi: f64) -> bool {
        theta <= self.ceiling && self.corners.iter().all(|&(t, p)| theta < t || phi < p)
    }

    /// Forbids what does not improve on (theta, phi) by the margins.
    pub fn add(&mut self, theta: f64, phi: f64) {
        let corner = ((1.0 - GAMMA_THETA) * theta, phi - GAMMA_PHI * theta);
        self.corners.retain(|&(t, p)| t < corner.0 || p < corner.1);
        self.corners.push(corner);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dominated_pairs_are_refused() {
        let mut filter = Filter::new(10.0);
        filter.add(1.0, 5.0);
        assert!(!filter.accepts(1.0, 5.0) && !filter.accepts(2.0, 6.0) && !filter.accepts(11.0, 0.0));
        assert!(filter.accepts(0.5, 9.0) && filter.accepts(2.0, 4.0));
    }
}

//! The point that a solve returns when it does not converge.

use super::iterate::Iterate;

/// How good a point is that is no optimum: how far it misses the constraints, and its objective.
///
/// Points that miss the constraints by no more than the acceptable tolerance are all feasible, and the lower objective is the
/// better of two. Of others the better one misses them less, whatever its objective. This is the lexicographic order of
/// violation and objective: one sum of both, a merit function, would need a weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quality {
    /// Largest scaled violation of a constraint.
    pub infeasibility: f64,
    /// The objective.
    pub objective: f64,
}

impl Quality {
    /// Nothing was found.
    pub const NONE: Self = Self { infeasibility: f64::INFINITY, objective: f64::INFINITY };

    /// True when this is better than `other`, where violations up to `acceptable` are none.
    pub fn beats(&self, other: &Self, acceptable: f64) -> bool {
        if !(self.infeasibility.is_finite() && self.objective.is_finite()) {
            return false;
        }
        let feasible = |of: &Self| of.infeasibility <= acceptable;
        match (feasible(self), feasible(other)) {
            (true, true) => self.objective < other.objective,
            (false, false) => self.infeasibility < other.infeasibility,
            (own, _) => own,
        }
    }
}

/// The best point so far.
#[derive(Clone, Debug)]
pub(super) struct Best {
    quality: Quality,
    point: Iterate,
}

impl Default for Best {
    fn default() -> Self {
        Self { quality: Quality::NONE, point: Iterate::default() }
    }
}

impl Best {
    /// Keeps `point` where it is better.
    pub fn see(&mut self, point: &Iterate, infeasibility: f64, acceptable: f64) {
        let quality = Quality { infeasibility, objective: point.objective };
        if quality.beats(&self.quality, acceptable) {
            self.quality = quality;
            self.point.copy(point);
        }
    }

    /// The point, where there is one.
    pub fn take(self) -> Option<Iterate> {
        (self.quality != Quality::NONE).then_some(self.point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feasible_point_beats_a_lower_one_that_is_not() {
        let point = |infeasibility, objective| Quality { infeasibility, objective };
        assert!(point(1e-7, 5.0).beats(&point(1e-2, 1.0), 1e-6));
        assert!(!point(1e-2, 1.0).beats(&point(1e-7, 5.0), 1e-6));
        assert!(point(1e-7, 4.0).beats(&point(0.0, 5.0), 1e-6));
        assert!(point(1e-3, 9.0).beats(&point(1e-2, 1.0), 1e-6));
        assert!(!point(f64::NAN, 0.0).beats(&Quality::NONE, 1e-6));
        assert!(!point(0.0, f64::NAN).beats(&Quality::NONE, 1e-6));
    }
}

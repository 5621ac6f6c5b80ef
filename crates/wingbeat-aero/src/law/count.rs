//! How much of a wing is past the angle of attack up to which its law holds.

use super::{LiftLaw, UNTESTED_DEG};
use crate::Aero;
use wingbeat_math::Scalar;

/// Strips at instants of a run, counted by angle of attack.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StallCount {
    seen: f64,
    stalled: f64,
    untested: f64,
    /// By law those that it moves, and those past the angle up to which it holds.
    of: [[f64; 2]; LiftLaw::ALL.len()],
}

impl StallCount {
    /// Counts the strips of `aero` at an instant, or at several, by their angles of attack, rad; those in gaps are none.
    pub fn see<P: Scalar>(&mut self, aero: &Aero<P>, incidence: impl Iterator<Item = f64>) {
        let (law, stall) = (aero.law(), aero.stall_angle());
        let [holds, untested] = [law.holds_to(stall), UNTESTED_DEG.to_radians()];
        let past = |a: f64, limit: f64| f64::from(u8::from(a.abs() > limit));
        let [seen, beyond] = &mut self.of[law as usize];
        let covered = (0..aero.strips()).map(|i| aero.covers(i)).cycle();
        for (a, _) in incidence.zip(covered).filter(|(_, covered)| *covered) {
            self.seen += 1.0;
            self.stalled += past(a, stall);
            self.untested += past(a, untested);
            *seen += 1.0;
            *beyond += past(a, holds);
        }
    }

    /// Adds the strips of `other`.
    pub fn add(&mut self, other: &Self) {
        self.seen += other.seen;
        self.stalled += other.stalled;
        self.untested += other.untested;
        let both = self.of.iter_mut().flatten().zip(other.of.iter().flatten());
        both.for_each(|(sum, more)| *sum += more);
    }

    /// Share past the stall angle.
    pub fn stalled(&self) -> f64 {
        self.stalled / self.seen.max(1.0)
    }

    /// Share past the angle of attack beyond which no law was measured.
    pub fn untested(&self) -> f64 {
        self.untested / self.seen.max(1.0)
    }

    /// Each law that moves strips, with the share of all strips that is past the angle of attack up to which it holds.
    pub fn by_law(&self) -> impl Iterator<Item = (LiftLaw, f64)> {
        let all = LiftLaw::ALL.into_iter().zip(self.of);
        all.filter(|(_, [seen, _])| *seen > 0.0).map(|(law, [_, beyond])| (law, beyond / self.seen))
    }
}

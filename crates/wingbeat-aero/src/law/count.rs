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

/// Angles of attack beyond which shares of a wing are told, deg.
const TOLD_DEG: [f64; 2] = [12.0, 20.0];
/// Half the width of the soft edge, deg: choice.
const SOFT_DEG: f64 = 3.0;

/// What of a wing over a cycle is beyond 12 and 20 deg of incidence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StallShares {
    /// Shares of U^2 c dy dt, U the speed of the strip's quarter chord in the air.
    pub sharp: [f64; 2],
    /// The shares with an edge of `SOFT_DEG` to either side in place of a sharp one: where an incidence only just passes
    /// the edge and turns, the sharp ones change by the root of what the gait changes by.
    pub soft: [f64; 2],
    /// The same shares of strips and time alone, as flights count.
    pub strips: [f64; 2],
    /// Mean shares of separated flow and of lost suction, weighted as the first.
    pub separated: [f64; 2],
    weight: f64,
}

impl StallShares {
    /// Adds a strip at a time with its `weight` and its share of `strips` and time: its incidence (rad) before, then and after, its shares of
    /// separated flow and of lost suction.
    pub fn see(&mut self, (weight, strips): (f64, f64), incidence: [f64; 3], separated: [f64; 2]) {
        let [before, here, after] = incidence.map(f64::abs);
        self.weight += weight;
        for (j, limit) in TOLD_DEG.map(f64::to_radians).into_iter().enumerate() {
            self.sharp[j] +=
                weight * share_beyond([(before + here) / 2.0, here, (here + after) / 2.0], limit);
            self.soft[j] += weight * soft_step((here - limit) / SOFT_DEG.to_radians());
            self.strips[j] += if here > limit { strips } else { 0.0 };
            self.separated[j] += weight * separated[j];
        }
    }

    /// Those of all that was seen.
    #[must_use]
    pub fn of_all(mut self) -> Self {
        if self.weight > 0.0 {
            let sums = self.sharp.iter_mut().chain(&mut self.soft).chain(&mut self.separated);
            sums.for_each(|sum| *sum /= self.weight);
        }
        self
    }
}

/// From 0 at -1 to 1 at 1, level at both.
fn soft_step(x: f64) -> f64 {
    let s = (0.5 * (x + 1.0)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Share of a sample's time in which a number is beyond `limit` that goes evenly from its value half a sample before over
/// its own to that half a sample after: without it shares would jump from gait to gait.
fn share_beyond([before, here, after]: [f64; 3], limit: f64) -> f64 {
    let half = |a: f64, b: f64| match (a > limit, b > limit) {
        (true, true) => 1.0,
        (false, false) => 0.0,
        (true, false) => (a - limit) / (a - b),
        (false, true) => (b - limit) / (b - a),
    };
    (half(before, here) + half(here, after)) / 2.0
}

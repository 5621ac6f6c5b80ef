//! What a prescribed motion is, whatever becomes of the air.

use wingbeat_flight::tether::Tether;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::{range, tether};

/// A prescribed motion in numbers that are judged.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Share of the last cycle in which a half of the wing lies beyond the middle plane.
    pub crossing: f64,
    /// Largest speed of an edge through the air, m/s.
    pub speed_m_s: f64,
    /// Cycles, of a motion that repeats.
    pub cycles: Option<usize>,
}

impl Moved {
    /// That of `tether`.
    pub fn new(tether: &Tether) -> Self {
        Self {
            crossing: tether.crossing_fraction(),
            speed_m_s: tether.largest_speed(),
            cycles: tether.repeats().then_some(tether.clock.cycles),
        }
    }

    /// Holds it against the limits.
    pub fn hold(&self, judge: &mut Judge) {
        judge.hold(&tether::CROSSING, self.crossing);
        judge.hold(&tether::CROSSED, self.crossing);
        for limit in [&range::COMPRESSED, &range::MACH] {
            judge.hold(limit, self.speed_m_s / range::SOUND_M_S);
        }
        if let Some(cycles) = self.cycles {
            judge.hold(&tether::FIRST, cycles as f64);
        }
    }
}

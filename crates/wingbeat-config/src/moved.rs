//! What a prescribed motion is, whatever becomes of the air.

use std::f64::consts::PI;
use wingbeat_flight::tether::{Clock, Tether, TetherRun};
use wingbeat_judge::limits::{range, tether};
use wingbeat_judge::{Judge, Warning};

/// A prescribed motion in numbers that are judged.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Share of the last cycle in which a half of the wing lies beyond the middle plane.
    pub crossing: f64,
    /// Largest speed of an edge through the air, m/s.
    pub speed_m_s: f64,
    /// Least distance from the ground, m, where there is one.
    pub ground_m: Option<f64>,
    /// Cycles, of a motion that repeats, and reduced frequency k = omega c / (2 V) by the mean speed.
    pub repeated: Option<(usize, f64)>,
    /// Density of the fluid, kg/m3, and Reynolds number by the mean chord and speed.
    pub fluid: [f64; 2],
}

impl Moved {
    /// That of `tether`.
    pub fn new(tether: &Tether) -> Self {
        let [chord, speed] = tether.mean_chord_and_speed();
        let Clock { cycles, frequency_hz, .. } = tether.clock;
        let density = tether.reference.density_kg_m3;
        Self {
            crossing: tether.crossing_fraction(),
            speed_m_s: tether.largest_speed(),
            ground_m: tether.ground_distance(),
            repeated: tether.repeats().then(|| (cycles, PI * frequency_hz * chord / speed)),
            fluid: [density, density * speed * chord / range::viscosity(density)],
        }
    }

    /// Holds it against the limits.
    pub fn hold(&self, judge: &mut Judge) {
        judge.hold(&tether::CROSSING, self.crossing);
        judge.hold(&tether::CROSSED, self.crossing);
        judge.hold_if(&tether::GROUND, self.ground_m);
        for limit in [&range::COMPRESSED, &range::MACH] {
            judge.hold(limit, self.speed_m_s / range::SOUND_M_S);
        }
        let [density, reynolds] = self.fluid;
        if density > 0.0 {
            judge.hold(&range::THIN, density);
            judge.hold(&tether::VISCOUS, reynolds);
        }
        if let Some((cycles, reduced_frequency)) = self.repeated {
            judge.hold(&tether::FIRST, cycles as f64);
            judge.hold(&tether::REDUCED, reduced_frequency);
        }
    }
}

/// Part of its range within which a load is the same half a cycle later. *Choice.*
const WITHIN: f64 = 2e-2;
/// Range of a load over the largest of all below which it is rounding. *Choice.*
const ROUNDING: f64 = 1e-7;

/// The caution that all loads repeat twice or three times in what is called a cycle, of `hz` (Hz): a table of another frequency
/// is read so.
pub fn repeating(run: &TetherRun, hz: f64) -> Option<Warning> {
    let change = run.periodicity.as_ref()?.change;
    let within = WITHIN.max(2.0 * change);
    let names = run.loads.columns().iter().map(|column| column.name.as_str());
    let cycles: Vec<&[f64]> =
        names.filter(|name| !["t", "phase"].contains(name)).filter_map(|name| run.last_cycle(name)).collect();
    let range = |of: &[f64]| {
        let (low, high) = of.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        high - low
    };
    let all: Vec<(&[f64], f64)> = cycles.iter().map(|cycle| (*cycle, range(cycle))).collect();
    let most = all.iter().map(|(_, range)| *range).fold(0.0, f64::max);
    // What is zero by symmetry is rounding.
    let moving: Vec<(&[f64], f64)> = all.into_iter().filter(|(_, range)| *range > ROUNDING * most).collect();
    let repeats = |times: usize| {
        let steps = run.steps_per_cycle;
        let same = |(cycle, range): &(&[f64], f64)| {
            let by = steps / times;
            (0..steps).all(|k| (cycle[(k + by) % steps] - cycle[k]).abs() <= within * range)
        };
        steps.is_multiple_of(times) && !moving.is_empty() && moving.iter().all(same)
    };
    let times = [2, 3].into_iter().find(|times| repeats(*times))?;
    let key = "time.frequency_hz";
    let text = format!(
        "all loads repeat {times} times in a cycle of {hz} Hz: is the frequency that of the motion? A table with `harmonics` \
         at {times} times the frequency given is read so"
    );
    Some(Warning::new("tether.repeats", text).size(times as f64).key(key))
}

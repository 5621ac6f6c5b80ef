//! What a prescribed motion is, whatever becomes of the air.

use std::f64::consts::PI;
use wingbeat_aero::induced_power;
use wingbeat_flight::tether::{Clock, Side, Tether, TetherRun};
use wingbeat_judge::limits::{range, tether};
use wingbeat_judge::{Judge, Warning};
use wingbeat_math::Vec3;

/// A prescribed motion in numbers that are judged.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Share of the last cycle in which a half of the wing lies beyond the middle plane.
    pub crossing: f64,
    /// Largest speed of an edge through the air, m/s.
    pub speed_m_s: f64,
    /// Least distance from the ground, m, where there is one.
    pub ground_m: Option<f64>,
    /// Way of the wind in a cycle over the longest of a section in it, dimensionless, of a wing whose sections go further than some chords.
    pub advance: Option<f64>,
    /// Cycles, of a motion that goes on without repeating, of a wing whose sections go further than some chords.
    pub turning: Option<usize>,
    /// Cycles, of a motion that repeats, and reduced frequency k = omega c / (2 V) by the mean speed.
    pub repeated: Option<(usize, f64)>,
    /// Whether nothing moves.
    pub is_still: bool,
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
            advance: advance(tether, chord),
            turning: (!tether.repeats() && goes_far(tether, chord)).then_some(cycles),
            repeated: tether.repeats().then(|| (cycles, PI * frequency_hz * chord / speed)),
            is_still: tether.motion.is_still(),
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
        judge.hold_if(&tether::ADVANCE, self.advance.filter(|_| density > 0.0));
        judge.hold_if(
            &tether::TURNING,
            self.turning.filter(|_| self.ground_m.is_none()).map(|cycles| cycles as f64),
        );
    }
}

/// Way of the wind in a cycle over that of the section which goes furthest, where that is long beside the mean chord `chord`, m:
/// what stirs in place is judged by its reduced frequency.
fn advance(tether: &Tether, chord: f64) -> Option<f64> {
    let way = || tether.clock.frequency_hz * tether.longest_way();
    goes_far(tether, chord).then(|| tether.wind.norm() / way())
}

/// Whether a section goes so far in a cycle, beside the mean chord `chord`, m, that it may come back into its own wake.
fn goes_far(tether: &Tether, chord: f64) -> bool {
    tether.longest_way() > STROKE * chord
}

/// Least power of the disc that the wing reaches over the power into the air in the last cycle of `run`, dimensionless: joints and wind together. None over
/// ground, of a single cycle, and where the cycle is not like the one before.
///
/// Equation: tether.ideal_power_fraction
/// `P_ideal / (P + F.U), P_ideal by aero.induced_power`
/// Source: balance of work in the air that is at rest far off.
/// Test: `a_wing_that_beats_the_ideal_power_is_outside`.
pub fn ideal_power_fraction(tether: &Tether, run: &TetherRun) -> Option<f64> {
    let repeats = run.periodicity.as_ref()?.change <= tether::CYCLES.value;
    if tether.ground.is_some() || !repeats {
        return None;
    }
    let [drag, side, lift] = ["drag", "side", "lift"].map(|axis| run.mean(&format!("force_wind_{axis}")));
    let (force, wind) = (Vec3::new(drag?, side?, lift?), Vec3::new(tether.wind.norm(), 0.0, 0.0));
    let (density, reach) = (tether.reference.density_kg_m3, tether.reach());
    let ideal = match tether.side {
        Side::Both => induced_power(force, wind, density, reach),
        // Half of what both take.
        _ => 0.5 * induced_power(Vec3::new(2.0 * force[0], 0.0, 2.0 * force[2]), wind, density, reach),
    };
    let given = run.mean("power")? + force.dot(wind);
    // What is zero by symmetry is rounding.
    let scale = run.mean_positive_power()? + force.norm() * wind.norm();
    (ideal > ROUNDING * scale).then(|| fraction_of(ideal, given))
}

/// The power `ideal` over that `given`, W; a thousand where less or none is given.
pub(super) fn fraction_of(ideal: f64, given: f64) -> f64 {
    ideal / given.max(ideal / MOST)
}

/// Number that stands for every larger one, and for a wing that takes power from the air.
const MOST: f64 = 1e3;
/// Way of a section in a cycle, in mean chords, from which it may come back into its own wake. *Choice.*
const STROKE: f64 = 4.0;
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

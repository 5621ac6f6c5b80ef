//! Begin and middle of down- and upstroke.

use super::CourseClock;
use wingbeat::tether::{HingeKind, Tether};

/// Points of a cycle among which extremes are sought.
const POINTS: usize = 1440;

/// Names of the four phases, in order.
pub const PHASES: [&str; 4] =
    ["downstroke begins", "middle of downstroke", "upstroke begins", "middle of upstroke"];

/// The stroke over the last cycle. The downstroke begins where the wing is highest, the upstroke where it is lowest; the middles lie
/// where it passes half way between, which of a stroke a + b cos(phase) is the zero of the cosine.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// Steps nearest to the four phases; none for a wing that does not stroke.
    pub steps: Option<[usize; 4]>,
    /// Shares of the cycle at which they lie.
    pub phases: [f64; 4],
}

impl Stroke {
    /// The first flapping hinge of `tether`, or the heave of a wing without one.
    pub fn of(tether: &Tether, clock: &CourseClock) -> Self {
        let hinges = tether.wing.hinges().iter().zip(&tether.motion.hinges);
        let flap = hinges.clone().find(|(hinge, _)| hinge.kind == HingeKind::Flap).map(|(_, angle)| &angle.1);
        let stroke = flap.unwrap_or(&tether.motion.heave);
        let first = (clock.cycles - 1) as f64;
        Self::new(clock, |share| stroke.at((first + share) / clock.frequency_hz).x)
    }

    /// The stroke `height` (any unit) by the share of the last cycle.
    pub fn new(clock: &CourseClock, height: impl Fn(f64) -> f64) -> Self {
        let values: Vec<f64> = (0..POINTS).map(|k| height(k as f64 / POINTS as f64)).collect();
        let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let top = (0..POINTS).max_by(by).unwrap_or(0);
        let bottom = (0..POINTS).min_by(by).unwrap_or(0);
        let middle = 0.5 * (values[top] + values[bottom]);
        let between = |from: usize, to: usize| {
            let count = (to + POINTS - from) % POINTS;
            let off = |k: &usize| (values[(from + k) % POINTS] - middle).abs();
            (from + (0..=count).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)) % POINTS
        };
        let points = [top, between(top, bottom), bottom, between(bottom, top)];
        let phases = points.map(|k| k as f64 / POINTS as f64);
        let last = clock.first_of_last();
        let step = |phase: f64| last + ((phase * clock.steps as f64).round() as usize) % clock.steps;
        let strokes = values[top] - values[bottom] > 0.0;
        Self { steps: strokes.then(|| phases.map(step)), phases }
    }

    /// Whether the share of the cycle lies in the downstroke.
    pub fn is_down(&self, phase: f64) -> bool {
        let since = |from: f64| (phase - from).rem_euclid(1.0);
        since(self.phases[0]) < (self.phases[2] - self.phases[0]).rem_euclid(1.0)
    }
}

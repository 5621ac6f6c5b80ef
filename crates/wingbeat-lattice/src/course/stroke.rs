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
    /// Means over the down- and the upstroke of a quantity whose `values` (any unit) lie evenly over the last cycle, from its begin on: of the
    /// polygon through them, which is closed, so that a sample beside a border counts with its share.
    ///
    /// Equation: lattice.stroke_means
    /// `1/(b - a) int_a^b x dphase of the closed polygon, a and b the begin and end of the stroke`
    /// Source: definition of a mean; trapezoids.
    /// Test: `means_of_strokes_do_not_hang_on_the_number_of_samples`.
    pub fn means(&self, values: &[f64]) -> [f64; 2] {
        let count = values.len();
        let at = |k: usize| values[k % count];
        // Integral from the begin of the cycle to `phase`, in samples.
        let until = |phase: f64| {
            let place = phase * count as f64;
            let (whole, share) = (place as usize, place.fract());
            let before: f64 = (0..whole).map(|k| 0.5 * (at(k) + at(k + 1))).sum();
            before + share * (at(whole) + 0.5 * share * (at(whole + 1) - at(whole)))
        };
        let [down, _, up, _] = self.phases;
        let (length, all) = ((up - down).rem_euclid(1.0), until(1.0));
        let between = until(up) - until(down);
        let between = if up < down { all + between } else { between };
        [between / length, (all - between) / (1.0 - length)].map(|sum| sum / count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn means_of_strokes_do_not_hang_on_the_number_of_samples() {
        for begin in [0.0, 0.13, 0.77] {
            let clock = CourseClock { frequency_hz: 1.0, cycles: 1, steps: 48 };
            let stroke = Stroke::new(&clock, |phase| (TAU * (phase - begin)).cos());
            // Half a wave of 0.3 + sin over either stroke, whose mean is 0.3 and 2/pi more or less.
            for count in [24, 25, 31, 36, 61] {
                let values: Vec<f64> =
                    (0..count).map(|k| 0.3 + (TAU * (k as f64 / count as f64 - begin)).sin()).collect();
                let [down, up] = stroke.means(&values);
                let error = (down - 0.3 - 2.0 / std::f64::consts::PI)
                    .abs()
                    .max((up - 0.3 + 2.0 / std::f64::consts::PI).abs());
                assert!(error < 5e-3, "{begin} {count}: {down} {up}");
            }
        }
    }
}

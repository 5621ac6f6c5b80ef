//! How long a flight will still take.

use std::time::Duration;
use wingbeat::scenario::LatticeSpec;

/// Tells the time left from the time that has passed: that of a second of flight is even but for what the wake adds, which grows with
/// its age (carried by the air alone as its square) until the wake is cut off. Both shares are found by least squares.
#[derive(Clone, Debug)]
pub struct TimeLeft {
    /// Power of the wake's age; 0 where there is none.
    power: i32,
    /// Age at which it ends, s.
    longest: f64,
    /// Sums of products of the even part, the growing part and the elapsed time.
    sums: [f64; 5],
    last: (f64, f64),
}

impl TimeLeft {
    /// Of a flight whose every second costs the same.
    pub fn even() -> Self {
        Self { power: 0, longest: f64::INFINITY, sums: [0.0; 5], last: (0.0, 0.0) }
    }

    /// Of a flight in a lattice.
    pub fn in_lattice(spec: &LatticeSpec) -> Self {
        let longest = spec.longest_age_s.unwrap_or(f64::INFINITY);
        Self { power: if spec.free_wake { 2 } else { 1 }, longest, ..Self::even() }
    }

    /// What the wake has added up to the time `t` s: the integral of its age to the power.
    fn grown(&self, t: f64) -> f64 {
        let (young, power) = (t.min(self.longest), self.power);
        let ended = if t > self.longest { (t - self.longest) * self.longest.powi(power) } else { 0.0 };
        young.powi(power + 1) / f64::from(power + 1) + ended
    }

    /// At `t` s of the flight `elapsed` s have passed.
    pub fn see(&mut self, t: f64, elapsed: f64) {
        let grown = self.grown(t);
        let products = [t * t, t * grown, grown * grown, t * elapsed, grown * elapsed];
        self.sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        self.last = (t, elapsed);
    }

    /// What is left at `t` s of a flight of `duration` s; none before anything was seen.
    pub fn at(&self, t: f64, duration: f64) -> Option<Duration> {
        let ((seen, elapsed), [tt, tg, gg, te, ge]) = (self.last, self.sums);
        if seen <= 0.0 {
            return None;
        }
        let rest = [duration - t, self.grown(duration) - self.grown(t)];
        let by_share = |share: [f64; 2]| share[0] * rest[0] + share[1] * rest[1];
        let determinant = tt * gg - tg * tg;
        let both = [(te * gg - ge * tg) / determinant, (ge * tt - te * tg) / determinant];
        let even = [elapsed / seen, 0.0];
        let growing = [0.0, elapsed / self.grown(seen)];
        let left = match both {
            _ if self.power == 0 || !(determinant > 1e-9 * tt * gg) => by_share(even),
            [even_part, _] if even_part < 0.0 => by_share(growing),
            [_, growing_part] if growing_part < 0.0 => by_share(even),
            both => by_share(both),
        };
        Duration::try_from_secs_f64(left).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::scenario::Document;

    fn told(spec: &str, seen_to: f64, duration: f64, elapsed: impl Fn(f64) -> f64) -> f64 {
        let spec: LatticeSpec = Document::text("lattice.toml", spec).unwrap().parse().unwrap();
        let mut left = TimeLeft::in_lattice(&spec);
        (1..=50)
            .for_each(|k| left.see(seen_to * f64::from(k) / 50.0, elapsed(seen_to * f64::from(k) / 50.0)));
        left.at(seen_to, duration).unwrap().as_secs_f64()
    }

    #[test]
    fn a_growing_wake_is_in_the_time_that_is_left() {
        // A prescribed wake: the flight takes 2 t + 3 t^2/2 s.
        let left = told("step_s = 0.01", 2.0, 10.0, |t| 2.0 * t + 1.5 * t * t);
        assert!((left - (20.0 + 150.0 - 10.0)).abs() < 1e-6, "{left}");
        // The same cut off at 4 s, and as long as nothing has grown.
        let left = told("step_s = 0.01\nlongest_age_s = 4.0", 2.0, 10.0, |t| 2.0 * t + 1.5 * t * t);
        assert!((left - (20.0 + 24.0 + 12.0 * 6.0 - 10.0)).abs() < 1e-6, "{left}");
        let left = told("step_s = 0.01", 2.0, 10.0, |t| 2.0 * t);
        assert!((left - 16.0).abs() < 1e-6, "{left}");
        let free = told("step_s = 0.01\nfree_wake = true", 2.0, 4.0, |t| t + t * t * t);
        assert!((free - (68.0 - 10.0)).abs() < 1e-6, "{free}");
    }

    #[test]
    fn an_even_flight_goes_on_as_it_went() {
        let mut left = TimeLeft::even();
        assert!(left.at(0.0, 5.0).is_none());
        left.see(1.0, 3.0);
        assert_eq!(left.at(1.0, 5.0), Some(Duration::from_secs(12)));
    }
}

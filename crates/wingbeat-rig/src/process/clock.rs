//! The phase of the stroke with its rates, out of the encoder's samples.

use crate::Sinusoid;
use std::f64::consts::TAU;
use wingbeat_math::Jet;

/// Part of a cycle over which the encoder is fitted. *Choice*: counts of 1/1024 turn leave 1 % of the wings' acceleration; what a crank
/// does in every cycle alike is taken out before.
const PART: f64 = 0.125;
/// Samples on either side of one that are fitted, at least and at most. *Choice*: a cubic takes five.
const HALF: [usize; 2] = [2, 512];
/// Harmonics of a crank's ripple. *Choice*: cubics lose a third of what beats six times a cycle; a crank that beats so far has others of them.
const HARMONICS: usize = 12;
/// Whole cycles from which a ripple is told from the pace of one cycle. *Choice.*
const LEAST_CYCLES: f64 = 2.0;
/// Share of the usual turn within a nominal cycle from which the wings beat, and are not run up or down. *Choice.*
const BEATING: f64 = 0.9;
/// Largest sum of the harmonics of the rate's reciprocal, in parts of its mean, for which the phase ascends for certain. *Choice*: below 1.
const MOST_RIPPLE: f64 = 0.95;
/// Steps of Newton that invert the even phase, at most.
const INVERTED: usize = 20;
/// Points of a cycle at which the ripple is taken as waves of the even phase.
const WAVE_POINTS: usize = 128;

/// How a crank turns unevenly within each cycle, alike in all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrankRipple {
    /// Cosine and sine of the harmonics of d(even phase)/d(phase) beside 1, dimensionless; none of an even crank.
    parts: Vec<[f64; 2]>,
}

impl CrankRipple {
    /// Of the encoder's `phase` (rad) at equal steps, about `cycle` of them a cycle: the time that it spends about each phase over all whole
    /// cycles, of which the first and the last weigh little by Hann's window. None of too few cycles.
    ///
    /// Equation: rig.crank_evened
    /// `d(even)/d(phase) = 1 + sum_h a_h cos(h phase) + b_h sin(h phase), a_h = 2 <cos(h phase)>, b_h = 2 <sin(h phase)>`
    /// Source: time spent per phase; means over time under the window 1 - cos(turns / cycles).
    /// Test: `the_ripple_of_a_crank_is_no_noise`.
    fn of(phase: &[f64], cycle: usize) -> Self {
        let turns = |k: usize| phase[k + cycle] - phase[k];
        let all = phase.len().saturating_sub(cycle);
        let mut beating: Vec<f64> = (0..all).map(turns).filter(|turn| *turn > 0.5 * TAU).collect();
        if beating.is_empty() {
            return Self::default();
        }
        let middle = beating.len() / 2;
        let usual = *beating.select_nth_unstable_by(middle, f64::total_cmp).1;
        let beats = |k: &usize| turns(*k) >= BEATING * usual;
        let (Some(first), Some(last)) = ((0..all).find(beats), (0..all).rev().find(beats)) else {
            return Self::default();
        };
        let (begin, end) = (phase[first], phase[last + cycle]);
        let cycles = ((end - begin) / TAU).floor();
        if !(cycles >= LEAST_CYCLES) {
            return Self::default();
        }
        let until = begin + TAU * cycles;
        let (mut parts, mut time) = (vec![[0.0; 2]; HARMONICS], 0.0);
        for x in phase[first..=last + cycle].iter().filter(|x| (begin..until).contains(*x)) {
            // Over whole cycles the weights of all phases have one sum.
            let weight = 1.0 - ((x - begin) / cycles).cos();
            let (sin, cos) = x.sin_cos();
            let (mut s, mut c) = (sin, cos);
            time += weight;
            for part in &mut parts {
                part[0] += 2.0 * weight * c;
                part[1] += 2.0 * weight * s;
                (s, c) = (s * cos + c * sin, c * cos - s * sin);
            }
        }
        parts.iter_mut().flatten().for_each(|part| *part /= time);
        let most: f64 = parts.iter().map(|[a, b]| a.hypot(*b)).sum();
        if most < MOST_RIPPLE { Self { parts } } else { Self::default() }
    }

    /// The even phase with its first and second derivative by the phase (rad): the same on the mean over time.
    fn evened(&self, phase: f64) -> [f64; 3] {
        let mut even = [phase, 1.0, 0.0];
        if self.parts.is_empty() {
            return even;
        }
        let (sin, cos) = phase.sin_cos();
        let (mut s, mut c) = (sin, cos);
        for (k, [a, b]) in self.parts.iter().enumerate() {
            let h = (k + 1) as f64;
            even[0] += (a * s - b * c) / h;
            even[1] += a * c + b * s;
            even[2] += h * (b * c - a * s);
            (s, c) = (s * cos + c * sin, c * cos - s * sin);
        }
        even
    }

    /// Phase that an even crank of the same mean rate has where this one has `phase`, rad.
    pub fn even(&self, phase: f64) -> f64 {
        self.evened(phase)[0]
    }

    /// The phase of the crank at the `even` one, rad, with its rates.
    fn phase(&self, even: Jet) -> Jet {
        if self.parts.is_empty() {
            return even;
        }
        let mut phase = even.x;
        for _ in 0..INVERTED {
            let [at, slope, _] = self.evened(phase);
            let step = (even.x - at) / slope;
            phase += step;
            if step.abs() < 1e-13 * (1.0 + phase.abs()) {
                break;
            }
        }
        let [_, slope, bend] = self.evened(phase);
        let d = even.d / slope;
        Jet::new(phase, d, (even.dd - bend * d * d) / slope)
    }

    /// By how much the crank is ahead of an even one as waves of that one's time (s), which turns at `rate` (rad/s) and has the phase `at_zero` (rad)
    /// at 0; amplitudes in s.
    pub fn waves(&self, rate: f64, at_zero: f64) -> Vec<Sinusoid> {
        let ahead = |k: usize| {
            let even = TAU * k as f64 / WAVE_POINTS as f64;
            (even, self.phase(Jet::new(even, 1.0, 0.0)).x - even)
        };
        let points: Vec<(f64, f64)> = (0..WAVE_POINTS).map(ahead).collect();
        let wave = |k: usize| {
            let h = (k + 1) as f64;
            let part = |of: fn(f64) -> f64| -> f64 {
                points.iter().map(|(even, ahead)| ahead * of(h * even)).sum::<f64>() * 2.0
                    / WAVE_POINTS as f64
            };
            let (sine, cosine) = (part(f64::sin), part(f64::cos));
            let amplitude = sine.hypot(cosine) / rate;
            Sinusoid { amplitude, rate: h * rate, phase: h * at_zero + cosine.atan2(sine) }
        };
        (0..self.parts.len()).map(wave).collect()
    }
}

/// Cubics by least squares through the samples about each one, less the ripple of the crank.
#[derive(Clone, Debug)]
pub struct PhaseFit {
    half: usize,
    step: f64,
    /// Sums of u^0, u^2, u^4, u^6 over the samples, u from -1 to 1.
    sums: [f64; 4],
    /// How the crank turns unevenly.
    pub ripple: CrankRipple,
    /// The samples as an even crank would show them, rad.
    even: Vec<f64>,
}

impl PhaseFit {
    /// Of the samples `phase` (rad) at every `step` (s) of strokes at `frequency` (Hz); none where they are too few.
    pub fn new(phase: &[f64], step: f64, frequency: f64) -> Option<Self> {
        let [least, most] = HALF;
        let half = ((0.5 * PART / (frequency * step)) as usize)
            .clamp(least, most)
            .min(phase.len().saturating_sub(1) / 2);
        let known = half >= least && step > 0.0 && frequency > 0.0;
        let places = |half: usize| (0..=2 * half).map(move |k| k as f64 / half as f64 - 1.0);
        let sum = |power: i32| places(half).map(|u| u.powi(power)).sum();
        known.then(|| {
            let ripple = CrankRipple::of(phase, ((1.0 / (frequency * step)).round() as usize).max(1));
            let even = phase.iter().map(|phase| ripple.even(*phase)).collect();
            Self { half, step, sums: [0, 2, 4, 6].map(sum), ripple, even }
        })
    }

    /// Phase (rad), its rate and the slope of that, per s, at `row`.
    ///
    /// Equation: rig.encoder_clock
    /// `even(t_k + s) = c0 + c1 s + c2 s^2 + c3 s^3, least squares over 1/8 cycle; phase(t) by rig.crank_evened`
    /// Source: A. Savitzky and M. J. E. Golay, Anal. Chem. 36 (1964) 1627-1639.
    /// Test: `counts_and_noise_of_an_encoder_leave_its_rates`.
    pub fn at(&self, row: usize) -> Jet {
        let (half, phase) = (self.half, &self.even);
        let centre = row.clamp(half, phase.len() - 1 - half);
        let of = 1.0 / half as f64;
        let mut y = [0.0; 4];
        for (k, value) in phase[centre - half..=centre + half].iter().enumerate() {
            let (u, d) = (k as f64 * of - 1.0, value - phase[centre]);
            y[0] += d;
            y[1] += u * d;
            y[2] += u * u * d;
            y[3] += u * u * u * d;
        }
        let [n, s2, s4, s6] = self.sums;
        let (even, odd) = (n * s4 - s2 * s2, s2 * s6 - s4 * s4);
        let c0 = (s4 * y[0] - s2 * y[2]) / even;
        let c2 = (n * y[2] - s2 * y[0]) / even;
        let c1 = (s6 * y[1] - s4 * y[3]) / odd;
        let c3 = (s2 * y[3] - s4 * y[1]) / odd;
        // Away from the middle only at the ends of the record.
        let u = (row as f64 - centre as f64) * of;
        let per = of / self.step;
        self.ripple.phase(Jet::new(
            phase[centre] + c0 + u * (c1 + u * (c2 + u * c3)),
            (c1 + u * (2.0 * c2 + 3.0 * u * c3)) * per,
            (2.0 * c2 + 6.0 * u * c3) * per * per,
        ))
    }
}

/// The `phase` of an encoder (rad) that was sampled at every `step` (s) of strokes at `frequency` (Hz), as it is fitted: counts that come and
/// go leave it ascending. As it is where samples are too few to fit.
pub fn fitted_phase(phase: Vec<f64>, step: f64, frequency: f64) -> Vec<f64> {
    match PhaseFit::new(&phase, step, frequency) {
        Some(fit) => (0..phase.len()).map(|row| fit.at(row).x).collect(),
        None => phase,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::{Random, Scalar};

    /// A crank at 3.5 Hz that beats a little twice a cycle, read at 7 kHz.
    fn crank(t: f64) -> Jet {
        let w = 3.5 * TAU;
        let t = Jet::new(t, 1.0, 0.0);
        t * w + (t * (2.0 * w)).sin() * 0.02
    }

    #[test]
    fn counts_and_noise_of_an_encoder_leave_its_rates() {
        let step = 1.0 / 7000.0;
        let w = 3.5 * TAU;
        let mut random = Random::stream(3, 0);
        let count = TAU / 1024.0;
        let mut read = |of: usize, t: f64| match of {
            0 => (crank(t).x / count).round() * count,
            1 => crank(t).x + 1e-3 * random.normal(),
            // Read at 1 kHz and held.
            _ => crank((t * 1000.0).floor() / 1000.0).x,
        };
        for (of, lag) in [(0, 0.0), (1, 0.0), (2, 3.0 * step)] {
            let seen: Vec<f64> = (0..14_000).map(|k| read(of, k as f64 * step)).collect();
            let fit = PhaseFit::new(&seen, step, 3.5).unwrap();
            let (mut rate, mut slope) = (0.0, 0.0);
            for row in 500..13_500 {
                let (found, right) = (fit.at(row), crank(row as f64 * step - lag));
                assert!((found.x - right.x).abs() < 3e-3, "{of}: {found:?} {right:?}");
                rate += (found.d - right.d).powi(2) / 13_000.0;
                slope += (found.dd - right.dd).powi(2) / 13_000.0;
                assert!(row == 500 || found.x > fit.at(row - 1).x, "{of}: the phase goes back");
            }
            assert!(rate.sqrt() < 0.01 * w && slope.sqrt() < 0.015 * w * w, "{of}: {rate} {slope}");
        }
    }

    /// A crank at 5 Hz as a motor turns it: by a sixth faster and slower, twice to six times a cycle, and run up before.
    fn driven(t: f64) -> Jet {
        let w = 5.0 * TAU;
        let even = Jet::new(t, 1.0, 0.0) * w;
        even + (even * 2.0).sin() * 0.06 + (even * 4.0 + 0.7).sin() * 0.015 + (even * 6.0 + 0.2).sin() * 0.004
    }

    #[test]
    fn the_ripple_of_a_crank_is_no_noise() {
        let (step, w) = (1.0 / 7000.0, 5.0 * TAU);
        let count = TAU / 1024.0;
        for (quantised, limit) in [(false, 0.004), (true, 0.02)] {
            let seen = |t: f64| if quantised { (driven(t).x / count).round() * count } else { driven(t).x };
            let seen: Vec<f64> = (0..21_000).map(|k| seen(k as f64 * step)).collect();
            // The frequency that the file says need not be the motor's own.
            let fit = PhaseFit::new(&seen, step, 4.7).unwrap();
            let (mut rate, mut slope, mut size) = (0.0, 0.0, 0.0);
            for row in 500..20_500 {
                let (found, right) = (fit.at(row), driven(row as f64 * step));
                assert!((found.x - right.x).abs() < 3e-3, "{found:?} {right:?}");
                rate += (found.d - right.d).powi(2) / 20_000.0;
                slope += (found.dd - right.dd).powi(2) / 20_000.0;
                size += right.dd.powi(2) / 20_000.0;
            }
            let (rate, slope, size) = (rate.sqrt() / w, slope.sqrt(), size.sqrt());
            println!("{quantised}: rate {rate:.5}, slope {:.5} of {:.3} w2", slope / (w * w), size / (w * w));
            assert!(rate < limit && slope < limit * w * w, "{quantised}: {rate} {slope} {size}");
            // The waves are the crank's.
            let waves = fit.ripple.waves(w, 0.0);
            let ahead = |t: f64| {
                waves.iter().map(|wave| w * wave.amplitude * (wave.rate * t + wave.phase).sin()).sum::<f64>()
            };
            for k in 0..100 {
                let t = 0.002 * f64::from(k);
                let right = driven(t).x - w * t;
                assert!((ahead(t) - right).abs() < 2e-3, "{t}: {} {right}", ahead(t));
                let even = fit.ripple.even(driven(t).x);
                assert!((even - w * t).abs() < 2e-3);
            }
        }
    }

    #[test]
    fn cubics_come_back_at_the_ends_too() {
        let step = 1e-3;
        let cubic = |t: f64| 0.3 + 20.0 * t - 3.0 * t * t + 5.0 * t * t * t;
        let seen: Vec<f64> = (0..300).map(|k| cubic(k as f64 * step)).collect();
        let fit = PhaseFit::new(&seen, step, 2.0).unwrap();
        for row in [0, 3, 150, 299] {
            let (found, t) = (fit.at(row), row as f64 * step);
            assert!((found.x - cubic(t)).abs() < 1e-12);
            assert!((found.d - (20.0 - 6.0 * t + 15.0 * t * t)).abs() < 1e-9);
            assert!((found.dd - (-6.0 + 30.0 * t)).abs() < 1e-6);
        }
        assert!(PhaseFit::new(&seen[..4], step, 2.0).is_none() && PhaseFit::new(&seen, step, 0.0).is_none());
    }
}

//! The air the robot flies in: density, mean wind and gusts.

use super::dryden::Dryden;
use std::f64::consts::TAU;
use wingbeat_math::{Lanes, Mat3, Meets, Random, Scalar, Vec3};

/// The air.
#[derive(Clone, Debug, PartialEq)]
pub struct Air {
    /// Density, kg/m3.
    pub density: f64,
    /// Its motion.
    pub wind: Wind,
}

/// Velocity of the air over time, the same everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Wind<P: Scalar = f64> {
    mean: Vec3<P>,
    waves: Vec<GustWave<P>>,
    pulses: Vec<Pulse<P>>,
    course: VelocityCourse<P>,
}

/// Velocities at equal times, linear between them; before the first and after the last that one.
#[derive(Clone, Debug, PartialEq)]
struct VelocityCourse<P: Scalar> {
    /// Time between nodes, s.
    step: f64,
    nodes: Vec<Vec3<P>>,
}

impl<P: Scalar> VelocityCourse<P> {
    const NONE: Self = Self { step: 1.0, nodes: Vec::new() };

    /// Velocity and its rate at the time `t`; none without nodes.
    fn at<S: Scalar + Meets<P>>(&self, t: S) -> Option<(Vec3<S>, Vec3<S>)> {
        let last = self.nodes.len().checked_sub(1)?;
        let place = t.value() / self.step;
        if !(place >= 0.0 && place < last as f64) {
            let end = if place < 0.0 { 0 } else { last };
            return Some((self.nodes[end].met(), Vec3::ZERO));
        }
        let (i, per_time) = (place as usize, 1.0 / self.step);
        let (from, to): (Vec3<S>, Vec3<S>) = (self.nodes[i].met(), self.nodes[i + 1].met());
        let rate = (to - from) * S::from(per_time);
        Some((from + rate * (t - i as f64 * self.step), rate))
    }
}

/// One gust at a stated time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse<P: Scalar = f64> {
    /// Begin, s.
    pub start: P,
    /// From begin to end, s.
    pub duration: P,
    /// Velocity in its middle, m/s in W.
    pub velocity: Vec3<P>,
}

impl<P: Scalar> Pulse<P> {
    /// Share of the velocity at the time `t`, and its rate, 1/s; zero before and after.
    ///
    /// Equation: robot.pulse
    /// `gust v(t) = V (1 - cos(2 pi (t - t_0)/T))/2 from t_0 to t_0 + T`
    /// Source: the discrete gust of CS-25.341.
    /// Test: `a_pulse_has_its_velocity_in_its_middle_and_none_outside`.
    fn share<S: Scalar + Meets<P>>(&self, t: S) -> (S, S) {
        let since = t - self.start;
        let rate = P::from(TAU) / self.duration;
        let (s, c) = (since * rate).sin_cos();
        let during = |x| {
            let begun = S::ZERO.if_below(since, x, S::ZERO);
            since.if_below(<S as From<P>>::from(self.duration), begun, S::ZERO)
        };
        (during((-c + 1.0) * 0.5), during(s * (rate * 0.5)))
    }
}

/// One sinusoid of a gust: v_i = amplitude_i sin(rate t + phase_i).
#[derive(Clone, Debug, PartialEq)]
struct GustWave<P: Scalar> {
    amplitude: P,
    rate: f64,
    phase: [P; 3],
}

/// Frequencies of a gust, Hz: slow against the flapping, so that the air may
/// count as uniform over the wing.
const GUST_FREQUENCIES: [f64; 6] = [0.2, 0.33, 0.54, 0.87, 1.4, 2.3];

impl Wind {
    /// Wind that does not change, m/s in W.
    pub fn steady(mean: Vec3) -> Self {
        Self { mean, waves: Vec::new(), pulses: Vec::new(), course: VelocityCourse::NONE }
    }

    /// Mean wind with a gust: along each axis a sum of sinusoids with random
    /// phases at frequencies in a constant ratio, amplitudes falling with the inverse
    /// of the frequency (a spectrum of slope -3; [`turbulent`](Self::turbulent) has Dryden's, -2) and
    /// adding up to `peak`, m/s, so that no component ever exceeds it.
    pub fn gusty(mean: Vec3, peak: f64, seed: u64) -> Self {
        if peak == 0.0 {
            return Self::steady(mean);
        }
        let mut random = Random::new(seed);
        let total: f64 = GUST_FREQUENCIES.iter().map(|f| 1.0 / f).sum();
        let waves = GUST_FREQUENCIES
            .iter()
            .map(|f| GustWave {
                amplitude: peak / (f * total),
                rate: TAU * f,
                phase: std::array::from_fn(|_| random.between(0.0, TAU)),
            })
            .collect();
        Self { waves, ..Self::steady(mean) }
    }

    /// This wind with gusts at stated times.
    #[must_use]
    pub fn with(mut self, pulses: impl IntoIterator<Item = Pulse>) -> Self {
        self.pulses.extend(pulses);
        self
    }

    /// This wind with the turbulence `of` for `duration` s, its first axis `heading` rad from x to the left.
    #[must_use]
    pub fn turbulent(mut self, of: &Dryden, heading: f64, duration: f64, seed: u64) -> Self {
        let count = (duration / of.step()).ceil() as usize + 2;
        let turn = Mat3::rotation_z(heading);
        let nodes = of.nodes(count, seed).into_iter().map(|velocity| turn * velocity).collect();
        self.course = VelocityCourse { step: of.step(), nodes };
        self
    }

    /// Whether both are made of as many waves and gusts, so that they can blow in lanes side by side.
    pub(super) fn fits_beside(&self, other: &Self) -> bool {
        let course = (self.course.step, self.course.nodes.len());
        self.waves.len() == other.waves.len()
            && self.pulses.len() == other.pulses.len()
            && course == (other.course.step, other.course.nodes.len())
    }

    /// Winds that fit side by side, each in a lane; the lanes that are left over repeat the last.
    ///
    /// # Panics
    /// When there is none.
    pub(super) fn side_by_side<S: Lanes>(winds: &[&Self]) -> Wind<S> {
        let last = winds.len() - 1;
        let each = |number: &dyn Fn(&Self) -> f64| S::of(|lane| number(winds[lane.min(last)]));
        let vector = |of: &dyn Fn(&Self) -> Vec3| Vec3(std::array::from_fn(|i| each(&|wind| of(wind)[i])));
        let wave = |k: usize| GustWave {
            amplitude: each(&|wind| wind.waves[k].amplitude),
            rate: winds[0].waves[k].rate,
            phase: std::array::from_fn(|i| each(&|wind| wind.waves[k].phase[i])),
        };
        let pulse = |k: usize| Pulse {
            start: each(&|wind| wind.pulses[k].start),
            duration: each(&|wind| wind.pulses[k].duration),
            velocity: vector(&|wind| wind.pulses[k].velocity),
        };
        Wind {
            mean: vector(&|wind| wind.mean),
            waves: (0..winds[0].waves.len()).map(wave).collect(),
            pulses: (0..winds[0].pulses.len()).map(pulse).collect(),
            course: VelocityCourse {
                step: winds[0].course.step,
                nodes: (0..winds[0].course.nodes.len())
                    .map(|k| vector(&|wind| wind.course.nodes[k]))
                    .collect(),
            },
        }
    }
}

impl<P: Scalar> Wind<P> {
    /// Whether it is one velocity for all time.
    pub fn is_steady(&self) -> bool {
        self.waves.is_empty() && self.pulses.is_empty() && self.course.nodes.is_empty()
    }

    /// The wind without its gust, m/s in W.
    pub fn mean(&self) -> Vec3<P> {
        self.mean
    }

    /// The same wind in another type, `f` of each number.
    pub(super) fn map<Q: Scalar>(&self, f: impl Fn(P) -> Q + Copy) -> Wind<Q> {
        let vector = |v: Vec3<P>| v.each(f);
        let wave = |wave: &GustWave<P>| GustWave {
            amplitude: f(wave.amplitude),
            rate: wave.rate,
            phase: wave.phase.map(f),
        };
        let pulse = |pulse: &Pulse<P>| Pulse {
            start: f(pulse.start),
            duration: f(pulse.duration),
            velocity: vector(pulse.velocity),
        };
        Wind {
            mean: vector(self.mean),
            waves: self.waves.iter().map(wave).collect(),
            pulses: self.pulses.iter().map(pulse).collect(),
            course: VelocityCourse {
                step: self.course.step,
                nodes: self.course.nodes.iter().map(|node| vector(*node)).collect(),
            },
        }
    }

    /// Velocity (m/s) and acceleration (m/s2) of the air in W at the time `t`, s.
    #[inline]
    pub fn at<S: Scalar + Meets<P>>(&self, t: S) -> (Vec3<S>, Vec3<S>) {
        let (mut velocity, mut acceleration) = (self.mean.met(), Vec3::ZERO);
        for wave in &self.waves {
            for i in 0..3 {
                let (s, c) = (t * wave.rate + wave.phase[i]).sin_cos();
                velocity[i] += s * wave.amplitude;
                acceleration[i] += c * (wave.amplitude * wave.rate);
            }
        }
        for pulse in &self.pulses {
            let (share, rate) = pulse.share(t);
            for i in 0..3 {
                velocity[i] += share * pulse.velocity[i];
                acceleration[i] += rate * pulse.velocity[i];
            }
        }
        if let Some((of_course, rate)) = self.course.at(t) {
            velocity += of_course;
            acceleration += rate;
        }
        (velocity, acceleration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Dual;

    #[test]
    fn a_gust_stays_below_its_peak_and_follows_its_seed() {
        let gust = Wind::gusty(Vec3::new(1.0, 0.0, 0.0), 0.3, 7);
        let largest = (0..20000)
            .map(|i| gust.at(i as f64 * 1e-3).0 - gust.mean())
            .fold(0.0, |m: f64, v| m.max(v[0].abs()).max(v[1].abs()).max(v[2].abs()));
        assert!(largest <= 0.3 && largest > 0.15, "peak {largest}");
        assert_eq!(gust, Wind::gusty(Vec3::new(1.0, 0.0, 0.0), 0.3, 7));
        assert_ne!(gust, Wind::gusty(Vec3::new(1.0, 0.0, 0.0), 0.3, 8));
    }

    const PULSE: Pulse = Pulse { start: 0.5, duration: 0.4, velocity: Vec3([0.0, -0.3, 0.6]) };

    #[test]
    fn the_acceleration_is_the_derivative() {
        let of = Dryden { deviation: [0.3; 3], length: [2.0; 3], airspeed: 4.0 };
        let turbulent = Wind::steady(Vec3::ZERO).turbulent(&of, 0.4, 2.0, 5);
        for wind in [Wind::gusty(Vec3::ZERO, 0.2, 1), Wind::steady(Vec3::ZERO).with([PULSE]), turbulent] {
            let (v, _) = wind.at(Dual::<1>::variable(0.62, 0));
            let (_, a) = wind.at(0.62);
            for i in 0..3 {
                assert!((v[i].eps[0] - a[i]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_pulse_has_its_velocity_in_its_middle_and_none_outside() {
        let mean = Vec3::new(1.0, 0.0, 0.0);
        let wind = Wind::steady(mean).with([PULSE]);
        let at = |t: f64| (wind.at(t).0 - mean).0;
        assert_eq!((at(0.5), at(0.9), at(3.0)), ([0.0; 3], [0.0; 3], [0.0; 3]));
        let [x, y, z] = at(0.7);
        assert!(x == 0.0 && (y + 0.3).abs() < 1e-15 && (z - 0.6).abs() < 1e-15);
        assert!((at(0.6)[2] - 0.3).abs() < 1e-15);
    }
}

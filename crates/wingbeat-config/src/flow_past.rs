//! How fast the air passes the strips of a robot, beside their chords.

use wingbeat_judge::limits::range;
use wingbeat_math::Vec3;
use wingbeat_robot::Robot;

/// Sums over the strips of a robot and the samples of a flight.
#[derive(Clone, Debug, Default)]
pub(super) struct FlowPast {
    /// Time, s, and quarter chords in W, m, of the sample before.
    before: Option<(f64, Vec<Vec3<f64>>)>,
    /// Sums of V c dA and dA, m4/s and m2.
    sums: [f64; 2],
    /// Largest speed of a strip, m/s.
    pub fastest_m_s: f64,
}

impl FlowPast {
    /// Takes the quarter chords at the time `t`, s, of all strips of `robot`, in W, m.
    pub fn see(&mut self, robot: &Robot, t: f64, quarter_chords: impl Iterator<Item = Vec3<f64>>) {
        let now: Vec<Vec3<f64>> = quarter_chords.collect();
        if let Some((then, before)) = &self.before
            && t > *then
        {
            let wind = robot.wind_over_time().mean();
            let strips = robot.surfaces().flat_map(|(_, aero)| (0..aero.strips()).map(move |i| (aero, i)));
            for ((aero, i), (from, to)) in strips.zip(before.iter().zip(&now)) {
                if aero.covers(i) {
                    let (chord, area) = (aero.chord(i), aero.chord(i) * aero.widths()[i]);
                    let speed = ((*to - *from) * (1.0 / (t - then)) - wind).norm();
                    self.sums[0] += speed * chord * area;
                    self.sums[1] += area;
                    self.fastest_m_s = self.fastest_m_s.max(speed);
                }
            }
        }
        self.before = Some((t, now));
    }

    /// Mean Reynolds number of the strips, over their areas, in a fluid of `density`, kg/m3; none without air.
    ///
    /// Equation: range.reynolds
    /// `rho / mu sum V c dA / sum dA, V of the quarter chord from sample to sample through the mean wind`
    /// Source: definition; viscosity of air at 20 degrees C, from 100 kg/m3 on of water.
    /// Test: `small_slow_wings_are_told_in_flight_and_trim`.
    pub fn reynolds(&self, density: f64) -> Option<f64> {
        let [sum, area] = self.sums;
        (density > 0.0 && area > 0.0).then(|| density / range::viscosity(density) * sum / area)
    }
}

//! Adaptation in flight to an unknown air: the acceleration that the controller's model misses, by the phase of the gait, and the rate of the crank that takes over what the other commands hold for long.

use super::family::OrbitReference;
use super::feedback::{MISSED, waves};
use crate::guide::history::STEP;
use crate::orbit::{Cycle, Deviations, Failure, FoundOrbit, Free, Point, search_from};
use crate::simulate::{AXES, Column, Stepper};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_ocp::plant::{Channel, Fault, Plant};
use wingbeat_robot::{Pacer, Robot};

/// Share by which the pace of the orbit beside the first is higher.
const FASTER: f64 = 0.02;

/// How the controller adapts to an unknown air.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct AdaptSpec {
    /// Time in which the rate of the crank takes over what the other commands hold, s: a few cycles. The robot needs an actuator
    /// that moves its crank. Without it the crank keeps to the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crank_s: Option<f64>,
    /// Time constant with which the mean of the acceleration that the model misses is learned, s; its harmonics take twice as long.
    /// The commands that meet it at least cost are fed forward. It takes the true state. Without it nothing is learned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missed_s: Option<f64>,
    /// Harmonics of the cycle by which it is learned, beside its mean.
    #[serde(default = "two")]
    pub harmonics: usize,
}

fn two() -> usize {
    2
}

/// Most harmonics: a cycle has twenty updates.
const MAX_HARMONICS: f64 = 9.0;
const TIME: Range = Range::between(0.01, 1000.0);

ranges!(AdaptSpec { crank_s: TIME, missed_s: TIME, harmonics: Range::between(0.0, MAX_HARMONICS) });

impl AdaptSpec {
    /// All that can be said without looking for orbits.
    pub fn check(&self, robot: &Robot) -> Result<(), Error> {
        self.in_range()?;
        if self.crank_s.is_none() && self.missed_s.is_none() {
            return Err(Error::invalid("", "neither", "crank_s, missed_s, or both"));
        }
        if let Some(time) = self.crank_s.filter(|_| robot.pacer().is_none()) {
            let allowed = "none: the robot has no actuator that moves its crank";
            return Err(Error::invalid("crank_s", time, allowed));
        }
        Ok(())
    }

    /// Harmonics of what is learned, where something is.
    pub fn learned(&self) -> Option<usize> {
        self.missed_s.map(|_| self.harmonics)
    }
}

/// How the orbit of the start changes with the rate of the crank, at the same speed and climb.
#[derive(Clone, Debug)]
pub(super) struct CrankTangent {
    /// Change of what deviates, at every step of a cycle, per rad/s of the crank.
    pub steps: Vec<Vec<f64>>,
    /// Change of the commands.
    pub commands: Vec<f64>,
}

impl CrankTangent {
    /// From the orbit `found`, whose reference is `reference`, and one whose crank turns faster with other commands of `free`.
    pub fn new(
        cycle: &Cycle,
        free: &[Free],
        found: &FoundOrbit,
        reference: &OrbitReference,
    ) -> Result<Self, Failure> {
        let orbit = &found.orbit;
        let guess = Point { pace: orbit.point.pace * (1.0 + FASTER), ..orbit.point.clone() };
        let held: Vec<Free> = free.iter().filter(|free| **free != Free::Frequency).cloned().collect();
        let other = search_from(cycle, &orbit.course, &held, guess, &mut |_, _| ControlFlow::Continue(()))?;
        let faster = cycle.rate(other.orbit.point.pace) - cycle.rate(orbit.point.pace);
        let other = OrbitReference::new(cycle, &Deviations::new(cycle), &other)?;
        let change = |(to, from): (&f64, &f64)| (to - from) / faster;
        let steps = other.steps.iter().zip(&reference.steps);
        let mut commands: Vec<f64> = other.commands.iter().zip(&reference.commands).map(change).collect();
        if let Some(pacer) = cycle.robot().pacer() {
            commands[pacer.input] = 1.0 / pacer.gain;
        }
        Ok(Self {
            steps: steps.map(|(to, from)| to.iter().zip(from).map(change).collect()).collect(),
            commands,
        })
    }
}

/// What is learned in flight.
pub(super) struct Adaptation<'a> {
    spec: AdaptSpec,
    period: f64,
    deviations: Deviations,
    crank: Option<Crank>,
    missed: Option<Missed<'a>>,
}

/// The rate of the crank that is added to that of the reference.
struct Crank {
    pacer: Pacer,
    channel: Channel,
    /// rad/s.
    added: f64,
}

/// The acceleration that the model misses.
struct Missed<'a> {
    model: Stepper<&'a Robot>,
    harmonics: usize,
    /// Of each axis the mean, then cosine and sine of each harmonic: m/s2 along heading axes, rad/s2 along B.
    waves: Vec<f64>,
    /// Time and cycles of the last update, and whether there was one.
    last: Option<(f64, f64)>,
}

impl<'a> Adaptation<'a> {
    pub fn new(spec: AdaptSpec, robot: &'a Robot, period: f64, deviations: &Deviations) -> Self {
        let crank = spec.crank_s.and_then(|_| robot.pacer()).map(|pacer| Crank {
            channel: robot.inputs()[pacer.input].clone(),
            pacer,
            added: 0.0,
        });
        let missed = spec.learned().map(|harmonics| Missed {
            model: Stepper::new(robot, 0.0, &vec![0.0; robot.states().len()]),
            harmonics,
            waves: vec![0.0; MISSED * waves(harmonics, 0.0).len()],
            last: None,
        });
        Self { spec, period, deviations: deviations.clone(), crank, missed }
    }

    /// Rate of the crank beyond that of the reference, rad/s.
    pub fn added(&self) -> f64 {
        self.crank.as_ref().map_or(0.0, |crank| crank.added)
    }

    /// The columns of what is learned.
    pub fn columns(&self) -> Vec<Column> {
        let crank = self.crank.iter().map(|_| Column::new("orbit_crank_added", "rad/s", ""));
        let missed = self.missed.iter().flat_map(|_| {
            AXES.map(|axis| Column::new(format!("orbit_missed_acceleration_{axis}"), "m/s2", "H"))
                .into_iter()
                .chain(AXES.map(|axis| Column::new(format!("orbit_missed_turning_{axis}"), "rad/s2", "B")))
        });
        crank.chain(missed).collect()
    }

    /// Their numbers: of what is missed the means over a cycle, in the units of the columns.
    pub fn numbers(&self) -> Vec<f64> {
        let missed =
            self.missed.iter().flat_map(|missed| missed.waves.chunks_exact(missed.waves.len() / MISSED));
        self.crank.iter().map(|crank| crank.added).chain(missed.map(|own| own[0])).collect()
    }

    /// What is learned of the acceleration that is missed, by wave of the phase, m/s2 and rad/s2.
    pub fn waves(&self) -> Option<&[f64]> {
        self.missed.as_ref().map(|missed| &missed.waves[..])
    }

    /// Equation: guide.missed_acceleration
    /// `c <- c + m (a - c b) b / (b b), a = (s - model(s before, u))/T, b = (1, cos n phase, sin n phase), m = 1 - exp(-T (1 + N)/tau)`
    /// Source: De Luca & Mattone 2003, residual of the momentum; Widrow & Hoff 1960, least mean squares; m by the mean over a cycle.
    /// Test: `what_the_model_misses_is_found_by_phase`.
    ///
    /// Learns from the state `x` at the time `t` and the phase `cycles`: the velocity (m/s) and the angular rate (rad/s) that
    /// the model does not account for since the last update, over the time between, by the phase half way. Over a cycle b b =
    /// 1 + N and the mean of b b' is 1 for the mean and 1/2 for each wave of the N harmonics, so that the mean has the time
    /// constant tau and the waves have 2 tau. After a fault of the model nothing is learned until the update after the next.
    pub fn learn(&mut self, t: f64, cycles: f64, x: &[f64], held: &[f64]) -> Result<(), Fault> {
        let (Some(missed), Some(time)) = (&mut self.missed, self.spec.missed_s) else { return Ok(()) };
        if let Some((since, before)) = missed.last.take().filter(|(since, _)| t > *since) {
            missed.model.set_inputs(held);
            let steps = ((t - since) / STEP).ceil();
            for _ in 0..steps as usize {
                missed.model.step((t - since) / steps)?;
            }
            let numbers = |x: &[f64]| {
                let mut s = vec![0.0; self.deviations.len()];
                self.deviations.of(x, &mut s);
                s
            };
            let (now, expected) = (numbers(x), numbers(missed.model.state()));
            let basis = waves(missed.harmonics, 0.5 * (before + cycles));
            let share = share(t - since, missed.harmonics, time);
            for (axis, own) in missed.waves.chunks_exact_mut(basis.len()).enumerate() {
                let place = missed_place(axis);
                let acceleration = (now[place] - expected[place]) / (t - since);
                towards(own, &basis, acceleration, share);
            }
        }
        missed.model.reset(t, x);
        missed.last = Some((t, cycles));
        Ok(())
    }

    /// Equation: guide.mid_ranging
    /// `w' = -g R (u - u_0) / (tau g R g), g = du/dw along orbits of one course`
    /// Source: Allison & Isaksson 1998, mid-ranging; gradient of the commands' cost along the orbits.
    /// Test: `the_crank_takes_over_what_other_commands_hold`.
    ///
    /// Moves the rate of the crank down the gradient of the cost of the commands `held` beyond those `asked`, in the units of
    /// their channels, each measured by its limit, along the orbits of one course, on which the air carries the robot alike.
    pub fn pace(&mut self, tangent: &CrankTangent, inputs: &[Channel], asked: &[f64], held: &[f64]) {
        let (Some(crank), Some(time)) = (&mut self.crank, self.spec.crank_s) else { return };
        let own = crank.pacer.input;
        let (mut along, mut size) = (0.0, 0.0);
        for (i, channel) in inputs.iter().enumerate().filter(|(i, _)| *i != own) {
            let gain = tangent.commands[i] / (channel.high * channel.high);
            along += gain * (held[i] - asked[i]);
            size += gain * tangent.commands[i];
        }
        let wanted = crank.added - self.period / time * along / size;
        let told = crank.channel.clamp(asked[own] + wanted / crank.pacer.gain);
        crank.added = (told - asked[own]) * crank.pacer.gain;
    }
}

/// Share of an error that an update after `interval` s takes away, so that the mean over a cycle has the time constant `time` s.
fn share(interval: f64, harmonics: usize, time: f64) -> f64 {
    1.0 - (-interval * (1 + harmonics) as f64 / time).exp()
}

/// Moves the coefficients `own` of `basis` by the share `share` of the way towards a series that is `seen` here.
fn towards(own: &mut [f64], basis: &[f64], seen: f64, share: f64) {
    let known: f64 = own.iter().zip(basis).map(|(c, b)| c * b).sum();
    let size: f64 = basis.iter().map(|b| b * b).sum();
    let by = share * (seen - known) / size;
    own.iter_mut().zip(basis).for_each(|(c, b)| *c += by * b);
}

/// Place among what deviates of the axis `axis` of what is missed.
pub(super) fn missed_place(axis: usize) -> usize {
    match axis {
        0..3 => Deviations::VELOCITY.start + axis,
        _ => Deviations::RATE.start + axis - 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time in which the coefficient `place` of a series that is 1 there comes to 1 - 1/e, s.
    fn time_constant(place: usize, harmonics: usize, time: f64) -> f64 {
        let (parts, cycle) = (20, 0.12);
        let interval = cycle / f64::from(parts);
        let mut own = vec![0.0; waves(harmonics, 0.0).len()];
        let found = (1..100_000).find(|k| {
            let basis = waves(harmonics, (f64::from(*k) - 0.5) / f64::from(parts));
            towards(&mut own, &basis, basis[place], share(interval, harmonics, time));
            own[place] >= 1.0 - (-1.0f64).exp()
        });
        f64::from(found.unwrap()) * interval
    }

    #[test]
    fn the_mean_is_learned_in_its_time_and_harmonics_in_twice_that() {
        for time in [0.09, 0.2, 1.0] {
            for harmonics in 0..4 {
                // An update ends up to one part, 6 ms, after the time, and beats with the waves.
                let mean = time_constant(0, harmonics, time);
                assert!((mean - time).abs() < 0.01, "{mean} for {time} with {harmonics}");
                for place in 1..=2 * harmonics {
                    let wave = time_constant(place, harmonics, time);
                    assert!(
                        (wave - 2.0 * time).abs() < 0.03,
                        "{wave} for 2 x {time} with {place} of {harmonics}"
                    );
                }
            }
        }
    }
}

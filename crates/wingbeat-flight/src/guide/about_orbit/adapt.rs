//! Adaptation in flight to an air that the controller is not told: the acceleration that its model misses, by the phase of the
//! gait, and the rate of the crank that takes over what the other commands hold for long.

use super::family::Reference;
use super::feedback::{MISSED, waves};
use crate::guide::history::STEP;
use crate::orbit::{Cycle, Deviations, Failure, Found, Free, Point, search_from};
use crate::simulate::{AXES, Column, Stepper};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_ocp::plant::{Channel, Fault, Plant};
use wingbeat_robot::{Pacer, Robot};

/// Share by which the pace of the orbit beside the first is higher.
const FASTER: f64 = 0.02;

/// How the controller adapts to an air that it is not told.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct AdaptSpec {
    /// Time in which the rate of the crank takes over what the other commands hold, s: a few cycles. The robot needs an actuator
    /// that moves its crank. Without it the crank keeps to the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crank_s: Option<f64>,
    /// Time in which the acceleration that the model misses is learned, s: a few cycles. The least-norm commands for it are fed
    /// forward. Without it nothing is learned.
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
pub(super) struct Tangent {
    /// Change of what deviates, at every step of a cycle, per rad/s of the crank.
    pub steps: Vec<Vec<f64>>,
    /// Change of the commands.
    pub commands: Vec<f64>,
}

impl Tangent {
    /// From the orbit `found`, whose reference is `reference`, and one whose crank turns faster with other commands of `free`.
    pub fn new(cycle: &Cycle, free: &[Free], found: &Found, reference: &Reference) -> Result<Self, Failure> {
        let orbit = &found.orbit;
        let guess = Point { pace: orbit.point.pace * (1.0 + FASTER), ..orbit.point.clone() };
        let held: Vec<Free> = free.iter().filter(|free| **free != Free::Frequency).cloned().collect();
        let other = search_from(cycle, &orbit.course, &held, guess, &mut |_, _| ControlFlow::Continue(()))?;
        let faster = cycle.rate(other.orbit.point.pace) - cycle.rate(orbit.point.pace);
        let other = Reference::new(cycle, &Deviations::new(cycle), &other)?;
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

    /// Their numbers: of what is missed the means over a cycle.
    pub fn numbers(&self) -> Vec<f64> {
        let missed =
            self.missed.iter().flat_map(|missed| missed.waves.chunks_exact(missed.waves.len() / MISSED));
        self.crank.iter().map(|crank| crank.added).chain(missed.map(|own| own[0])).collect()
    }

    /// What is learned of the acceleration that is missed.
    pub fn waves(&self) -> Option<&[f64]> {
        self.missed.as_ref().map(|missed| &missed.waves[..])
    }

    /// Equation: guide.missed_acceleration
    /// `c <- c + m (a - c b) b / (b b), a = (s - model(s before, u))/T, b = (1, cos n phase, sin n phase)`
    /// Source: De Luca & Mattone 2003, residual of the momentum; Widrow & Hoff 1960, least mean squares.
    /// Test: `what_the_model_misses_is_found_by_phase`.
    ///
    /// Learns from the state `x` at the time `t` and the phase `cycles`: the velocity and the angular rate that the model
    /// does not account for since the last update, over the time between, by the phase half way.
    pub fn learn(&mut self, t: f64, cycles: f64, x: &[f64], held: &[f64]) -> Result<(), Fault> {
        let (Some(missed), Some(time)) = (&mut self.missed, self.spec.missed_s) else { return Ok(()) };
        if let Some((since, before)) = missed.last.filter(|(since, _)| t > *since) {
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
            let size: f64 = basis.iter().map(|b| b * b).sum();
            let share = 1.0 - (-(t - since) * basis.len() as f64 / time).exp();
            for (axis, own) in missed.waves.chunks_exact_mut(basis.len()).enumerate() {
                let place = missed_place(axis);
                let acceleration = (now[place] - expected[place]) / (t - since);
                let known: f64 = own.iter().zip(&basis).map(|(c, b)| c * b).sum();
                let by = share * (acceleration - known) / size;
                own.iter_mut().zip(&basis).for_each(|(c, b)| *c += by * b);
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
    /// Moves the rate of the crank down the gradient of the cost of the commands `held` beyond those `asked`, each measured by
    /// its limit, along the orbits of one course, on which the air carries the robot alike.
    pub fn pace(&mut self, tangent: &Tangent, inputs: &[Channel], asked: &[f64], held: &[f64]) {
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

/// Place among what deviates of the axis `axis` of what is missed.
pub(super) fn missed_place(axis: usize) -> usize {
    match axis {
        0..3 => Deviations::VELOCITY.start + axis,
        _ => Deviations::RATE.start + axis - 3,
    }
}

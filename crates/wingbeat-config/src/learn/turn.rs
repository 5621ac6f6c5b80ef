//! The banking turn: roll, pitch and angular rate of a manoeuvre.

use super::{Task, View};
use crate::{Chosen, Scenario};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use wingbeat_flight::guide::{Manoeuvre, Reference, Turn, Weights, angle_error};
use wingbeat_math::Error;
use wingbeat_math::{Quat, Random, Vec3};
use wingbeat_ocp::plant::{Channel, Plant};
use wingbeat_robot::{Layout, Robot};

/// Errors of roll and pitch beyond which the turn is lost, rad. *Choice.*
const LOST: f64 = PI / 3.0;
/// Largest angular rate, rad/s, and speed, m/s, that are observed; beyond them the turn is lost. *Choice.*
const FASTEST: [f64; 2] = [60.0, 30.0];
/// How roll, pitch and yaw (rad), velocity (m/s) and angular rate (rad/s) vary at the start, uniformly to both
/// sides. *Choice.*
const SPREAD: [f64; 3] = [PI / 36.0, 0.1, 0.5];
/// Largest displacement and rate of an element that are observed, as parts of its stroke and, per second, of it.
const STROKE: [f64; 2] = [4.0, 400.0];

/// Holds the attitude that a manoeuvre asks, rewarded by the cost of the predictive controller: 1 for a step flown,
/// less the squares of the weighted errors of roll, pitch and angular rate and of the inputs.
///
/// Observed are angles, rates, the body's velocity in its own axes, the phase, the structure and what is asked;
/// neither place nor heading, and nothing of the air.
#[derive(Debug)]
pub struct BankingTurn {
    manoeuvre: Turn,
    weights: Weights,
    duration_s: f64,
    layout: Layout,
    channels: Vec<Channel>,
    /// Middle of each input's range over half of it.
    middles: Vec<f64>,
}

impl BankingTurn {
    /// The turn of a scenario that has the shipped manoeuvre and controller.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key that is missing.
    pub fn of(scenario: &Scenario) -> Result<Self, Error> {
        scenario.without_lattice()?;
        let missing = |key: &str, what: &str| Error::invalid(key, "none, or one of another kind", what);
        let manoeuvre = scenario.spec.manoeuvre.as_ref().and_then(Chosen::shipped);
        let controller = scenario.spec.controller.as_ref().and_then(Chosen::shipped);
        let manoeuvre =
            manoeuvre.ok_or_else(|| missing("manoeuvre", "the shipped manoeuvre: it is rewarded"))?;
        let controller = controller.ok_or_else(|| {
            missing("controller", "the shipped controller: its weights are those of the reward")
        })?;
        Ok(Self {
            manoeuvre: manoeuvre.clone(),
            weights: controller.weights.clone(),
            duration_s: scenario.spec.flight.duration_s,
            layout: *scenario.robot().layout(),
            channels: channels(scenario.robot()),
            middles: scenario.robot().inputs().iter().map(|c| (c.low + c.high) / (c.high - c.low)).collect(),
        })
    }

    /// Attitude and angular rate with what is asked of them.
    fn state(&self, view: &View) -> ([f64; 3], Vec3, Reference) {
        let attitude = Quat::from_wxyz(&view.x[self.layout.attitude..]);
        let rate = Vec3::from_slice(&view.x[self.layout.rate..]);
        (attitude.matrix().roll_pitch_yaw().0, rate, self.manoeuvre.reference(view.t))
    }
}

fn channels(robot: &Robot) -> Vec<Channel> {
    let [fastest_rate, fastest] = FASTEST;
    let within = |name: &str, unit, frame, most: f64| Channel::limited(name, unit, frame, -most, most);
    let axes = |name: &str, unit, most| {
        ["x", "y", "z"].map(|axis| within(&format!("{name}_{axis}"), unit, "B", most))
    };
    let mut channels = vec![within("roll", "rad", "WB", PI), within("pitch", "rad", "WB", FRAC_PI_2)];
    channels.extend(axes("w_WB_B", "rad/s", fastest_rate));
    channels.extend(axes("v_WB_B", "m/s", fastest));
    channels.extend([
        within("roll_reference", "rad", "WB", PI),
        within("pitch_reference", "rad", "WB", FRAC_PI_2),
    ]);
    channels.extend(axes("w_reference", "rad/s", fastest_rate));
    channels.extend([within("sin_phase", "", "", 1.0), within("cos_phase", "", "", 1.0)]);
    let [displacement, rate] = STROKE;
    let structure = robot.layout().structure;
    let elements = robot.strokes().iter().enumerate();
    let most = |stroke: &[f64; 2], factor: f64| factor * stroke[0].abs().max(stroke[1].abs());
    let states = robot.states();
    let count = robot.strokes().len();
    channels.extend(
        elements.clone().map(|(i, stroke)| limited(&states[structure + i], most(stroke, displacement))),
    );
    channels.extend(elements.map(|(i, stroke)| limited(&states[structure + count + i], most(stroke, rate))));
    channels
        .extend(robot.inputs().iter().map(|input| within(&format!("action_{}", input.name), "", "", 1.0)));
    channels
}

fn limited(state: &Channel, most: f64) -> Channel {
    Channel { low: -most, high: most, ..state.clone() }
}

impl Task for BankingTurn {
    fn observation(&self) -> &[Channel] {
        &self.channels
    }

    fn observe(&self, view: &View, values: &mut [f64]) {
        let ([roll, pitch, _], rate, asked) = self.state(view);
        let layout = &self.layout;
        let attitude = Quat::from_wxyz(&view.x[layout.attitude..]).matrix();
        let velocity = attitude.transpose() * Vec3::from_slice(&view.x[layout.velocity..]);
        let (sin, cos) = view.phase.rem_euclid(TAU).sin_cos();
        let structure = &view.x[layout.structure..layout.joints];
        let seen = [roll, pitch]
            .into_iter()
            .chain(rate.0)
            .chain(velocity.0)
            .chain([asked.roll, asked.pitch])
            .chain(asked.w.0)
            .chain([sin, cos])
            .chain(structure.iter().copied())
            .chain(view.action.iter().copied());
        for ((value, seen), channel) in values.iter_mut().zip(seen).zip(&self.channels) {
            *value = channel.clamp(seen);
        }
    }

    fn terms(&self) -> &[&'static str] {
        &["flown", "roll", "pitch", "rate", "input"]
    }

    fn reward(&self, view: &View, terms: &mut [f64]) {
        let ([roll, pitch, _], rate, asked) = self.state(view);
        let square = |weight: f64, error: f64| -(weight * error).powi(2);
        let errors = rate - asked.w;
        terms[0] = 1.0;
        terms[1] = square(self.weights.roll, angle_error(roll, asked.roll));
        terms[2] = square(self.weights.pitch, angle_error(pitch, asked.pitch));
        terms[3] =
            errors.0.iter().zip(self.weights.rates()).map(|(error, weight)| square(weight, *error)).sum();
        let inputs = view.action.iter().zip(&self.middles);
        terms[4] = inputs.map(|(action, middle)| square(self.weights.input, action + middle)).sum();
    }

    fn failed(&self, view: &View) -> bool {
        let ([roll, pitch, _], rate, asked) = self.state(view);
        let velocity = Vec3::from_slice(&view.x[self.layout.velocity..]);
        let held = angle_error(roll, asked.roll).abs() <= LOST
            && angle_error(pitch, asked.pitch).abs() <= LOST
            && rate.0.iter().all(|rate| rate.abs() <= FASTEST[0])
            && velocity.0.iter().all(|velocity| velocity.abs() <= FASTEST[1]);
        !held
    }

    fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn vary(&self, x: &mut [f64], spread: f64, random: &mut Random) {
        let [angle, velocity, rate] = SPREAD.map(|most| most * spread);
        let layout = &self.layout;
        let attitude = Quat::from_wxyz(&x[layout.attitude..]).matrix().roll_pitch_yaw().0;
        let [roll, pitch, yaw] = attitude.map(|mean| mean + random.between(-angle, angle));
        Quat::from_roll_pitch_yaw(roll, pitch, yaw).store_wxyz(&mut x[layout.attitude..]);
        for (first, most) in [(layout.velocity, velocity), (layout.rate, rate)] {
            for value in &mut x[first..first + 3] {
                *value += random.between(-most, most);
            }
        }
    }
}

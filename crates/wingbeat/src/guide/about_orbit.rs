//! Flight about orbits: references by the phase of the gait, and periodic feedback.

use super::controllers::{ControllerSpec, Task};
use crate::Error;
use crate::math::interpolation::lerp;
use crate::orbit::{
    Course, Cycle, Deviations, Failure, Found, Free, Interval, PARTS, Point, intervals, search, search_from,
};
use crate::parallel;
use crate::plant::Plant;
use crate::range::{Range, ranges};
use crate::robot::Robot;
use crate::simulate::{Column, Controller, Estimator, Measurement, TrueState, Update};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Phases of a cycle at which the feedback is made.
const PHASES: usize = PARTS;
/// Integration step of orbits and feedback, s.
const STEP: f64 = 5e-4;
/// Largest step of the bank from orbit to orbit, rad.
const BANK_STEP: f64 = 0.05;
/// Cycles after which the feedback of an orbit must have settled.
const CYCLES: usize = 80;
/// Change of the feedback over a cycle at which it has, relative.
const SETTLED: f64 = 1e-5;
/// Largest height off at which the integral of the height grows, m.
const INTEGRATED: f64 = 0.1;
/// Guess of the mean pitch, rad.
const PITCH: f64 = -0.2;

/// A periodic linear-quadratic regulator about level flight and a turn, `[controller.orbit]`: it finds the orbits itself, at
/// the frequency of the robot's gait, and leads from one into the other.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AboutOrbitSpec {
    /// Time between updates, s; best near a twentieth of a cycle.
    pub period_s: f64,
    /// Speed of level flight, m/s.
    pub speed_m_s: f64,
    /// Bank of the turn, deg; positive is right wing down.
    #[serde(default)]
    pub bank_deg: f64,
    /// Speed in the turn, m/s; that of level flight where not given.
    #[serde(default)]
    pub turn_speed_m_s: Option<f64>,
    /// Begin of the roll-in, s.
    #[serde(default)]
    pub turn_start_s: f64,
    /// Duration of the roll-in, s.
    #[serde(default = "second")]
    pub roll_in_s: f64,
    /// Regulators that are used, by name or by that of a pair: the first two hold level flight.
    pub free: Vec<String>,
    /// Deviations that cost as much as a full command.
    #[serde(default)]
    pub weights: OrbitWeights,
}

fn second() -> f64 {
    1.0
}

/// Deviations that each cost as much as a full command.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OrbitWeights {
    /// Height, m.
    pub height_m: f64,
    /// Integral of the height, m s.
    pub height_integral_m_s: f64,
    /// Velocity along each heading axis, m/s.
    pub velocity_m_s: f64,
    /// Roll and pitch, deg.
    pub angle_deg: f64,
    /// Angular rate, rad/s.
    pub rate_rad_s: f64,
}

impl Default for OrbitWeights {
    fn default() -> Self {
        Self { height_m: 0.03, height_integral_m_s: 0.03, velocity_m_s: 0.5, angle_deg: 6.0, rate_rad_s: 5.0 }
    }
}

ranges!(AboutOrbitSpec {
    period_s: Range::POSITIVE,
    speed_m_s: Range::between(0.1, 100.0),
    bank_deg: Range::inside(-80.0, 80.0),
    turn_speed_m_s: Range::between(0.1, 100.0),
    turn_start_s: Range::NOT_NEGATIVE,
    roll_in_s: Range::POSITIVE,
});
ranges!(OrbitWeights {
    height_m: Range::POSITIVE,
    height_integral_m_s: Range::POSITIVE,
    velocity_m_s: Range::POSITIVE,
    angle_deg: Range::POSITIVE,
    rate_rad_s: Range::POSITIVE,
});

/// An orbit as a reference: what may deviate, at every step of a cycle, and the commands held.
struct Reference {
    steps: Vec<Vec<f64>>,
    inputs: Vec<f64>,
}

/// Feedback at each phase: commands by deviations, the integral of the height first.
type Gains = Vec<DMatrix<f64>>;

/// The controller.
struct AboutOrbit<'a> {
    robot: &'a Robot,
    cycle: Cycle<'a>,
    spec: AboutOrbitSpec,
    deviations: Deviations,
    /// Orbits from level flight to the turn.
    family: Vec<Reference>,
    /// Feedback about the first and the last of them.
    gains: [Gains; 2],
    inputs: Vec<usize>,
    /// Integral of the height's deviation, m s, and the time up to which it is known.
    integral: f64,
    held: Vec<f64>,
    share: f64,
    height_error: f64,
}

impl ControllerSpec for AboutOrbitSpec {
    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn build<'a>(&self, task: Task<'a>) -> Result<Box<dyn Controller + 'a>, Error> {
        self.in_range()?;
        self.weights.in_range().map_err(|e| e.within("weights"))?;
        let cycle = Cycle::new(task.model, STEP)?;
        let orbits = self.orbits(&cycle, task.model)?.map_err(|failure| {
            Error::invalid(
                "",
                failure,
                "a speed and bank at which the robot has an orbit at its gait's frequency",
            )
        })?;
        let mut inputs: Vec<usize> = self.free(task.model, true)?.iter().flat_map(numbers).collect();
        inputs.sort_unstable();
        inputs.dedup();
        let deviations = Deviations::new(&cycle);
        let ends = [&orbits[0], &orbits[orbits.len() - 1]];
        let gains = parallel::map(&ends, |_, found| {
            let intervals = intervals(&cycle, &found.orbit.point, PHASES, &inputs)?;
            let limits: Vec<f64> = inputs.iter().map(|i| task.model.inputs()[*i].high).collect();
            Ok(self.gains(&intervals, cycle.section().len(), &limits, found.orbit.end.duration))
        });
        let broken = |fault: crate::plant::Fault| Error::invalid("", fault, "orbits that can be flown");
        let mut gains = gains.into_iter().collect::<Result<Vec<_>, _>>().map_err(broken)?.into_iter();
        let missing = || Error::invalid("weights", "given", "weights with which the feedback settles");
        let mut settled = || gains.next().flatten().ok_or_else(missing);
        let gains = [settled()?, settled()?];
        let references = orbits.iter().map(|found| reference(&cycle, &deviations, &found.orbit.point));
        let family = references.collect::<Result<Vec<_>, _>>().map_err(broken)?;
        let held = family[0].inputs.clone();
        Ok(Box::new(AboutOrbit {
            robot: task.model,
            spec: self.clone(),
            deviations,
            family,
            gains,
            inputs,
            integral: 0.0,
            held,
            share: 0.0,
            height_error: 0.0,
            cycle,
        }))
    }
}

/// Numbers of the inputs that are free.
fn numbers(free: &Free) -> Vec<usize> {
    match free {
        Free::Frequency => Vec::new(),
        Free::Inputs(direction) => direction.iter().map(|(i, _)| *i).collect(),
    }
}

impl AboutOrbitSpec {
    fn free(&self, robot: &Robot, turning: bool) -> Result<Vec<Free>, Error> {
        let names = if turning { &self.free[..] } else { &self.free[..self.free.len().min(2)] };
        let mut all = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let free = Free::named(robot, name, turning).filter(|free| !free.contains(&Free::Frequency));
            let unknown =
                || Error::invalid(format!("free[{i}]"), format!("{name:?}"), Free::names(robot).join(", "));
            all.extend(free.ok_or_else(unknown)?);
        }
        if all.len() < 2 {
            return Err(Error::invalid(
                "free",
                format!("{:?}", self.free),
                "two regulators or pairs, or more",
            ));
        }
        Ok(all)
    }

    /// Orbits from level flight to the turn.
    fn orbits(&self, cycle: &Cycle, robot: &Robot) -> Result<Result<Vec<Found>, Failure>, Error> {
        let (level, turning) = (self.free(robot, false)?, self.free(robot, true)?);
        let mut z = vec![0.0; cycle.section().len()];
        (z[0], z[4]) = (self.speed_m_s, PITCH);
        let joints = robot.start_coordinates();
        z[8..][..joints.len()].copy_from_slice(&joints);
        let guess = Point { z, pace: 1.0, inputs: vec![0.0; robot.inputs().len()] };
        let mut tell = |_: usize, _: f64| ControlFlow::Continue(());
        let course = |share: f64| Course {
            speed: lerp(self.speed_m_s, self.turn_speed_m_s.unwrap_or(self.speed_m_s), share),
            climb: 0.0,
            bank: share * self.bank_deg.to_radians(),
        };
        let found = match search(cycle, &course(0.0), &level, guess, &mut tell) {
            Ok(found) => found,
            Err(failure) => return Ok(Err(failure)),
        };
        let mut family = vec![found];
        let count = (self.bank_deg.to_radians().abs() / BANK_STEP).ceil() as usize;
        for k in 1..=count {
            let from = family[k - 1].orbit.point.clone();
            match search_from(cycle, &course(k as f64 / count as f64), &turning, from, &mut tell) {
                Ok(found) => family.push(found),
                Err(failure) => return Ok(Err(failure)),
            }
        }
        Ok(Ok(family))
    }

    /// Equation: guide.periodic_regulator
    ///
    /// Feedback K_k at each phase that minimises sum s' Q s + u' R u over all time: backwards over cycles
    /// K = (R + B'PB)^-1 B'PA, P = Q + A'P(A - B K) until K is the same a cycle earlier; `None` where it does not settle. The
    /// state is the integral of the height before the deviations. The states of the air take part in the prediction and
    /// are left out of the feedback: they are not measured.
    fn gains(&self, all: &[Interval], coordinates: usize, limits: &[f64], duration: f64) -> Option<Gains> {
        let (n, m) = (all[0].a.nrows() + 1, limits.len());
        let w = &self.weights;
        let mut cost = vec![0.0; n];
        cost[0] = w.height_integral_m_s.powi(-2);
        cost[1] = w.height_m.powi(-2);
        cost[2..5].fill(w.velocity_m_s.powi(-2));
        cost[5..7].fill(w.angle_deg.to_radians().powi(-2));
        cost[7..10].fill(w.rate_rad_s.powi(-2));
        let q = DMatrix::from_diagonal(&cost.clone().into());
        let r = DMatrix::from_diagonal(&limits.iter().map(|l| l.powi(-2)).collect::<Vec<_>>().into());
        let interval = duration / all.len() as f64;
        let augmented = all.iter().map(|i| {
            let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, m));
            (a[(0, 0)], a[(0, 1)]) = (1.0, interval);
            a.view_mut((1, 1), (n - 1, n - 1)).copy_from(&i.a);
            b.view_mut((1, 0), (n - 1, m)).copy_from(&i.b);
            (a, b)
        });
        let augmented: Vec<_> = augmented.collect();
        let mut p = q.clone();
        let mut gains: Gains = vec![DMatrix::zeros(m, n); all.len()];
        for _ in 0..CYCLES {
            let mut change: f64 = 0.0;
            for (k, (a, b)) in augmented.iter().enumerate().rev() {
                let pb = &p * b;
                let gain = (&r + b.transpose() * &pb).cholesky()?.solve(&(pb.transpose() * a));
                change = change.max((&gain - &gains[k]).amax() / gain.amax());
                p = &q + a.transpose() * &p * (a - b * &gain);
                p = (&p + p.transpose()) * 0.5;
                gains[k] = gain;
            }
            if change < SETTLED {
                // Height and coordinates of the body, then the elements; neither elastic joints nor air.
                let measured = |column: usize| !self.unmeasured(column, coordinates);
                for gain in &mut gains {
                    for column in (0..n).filter(|&c| !measured(c)) {
                        gain.column_mut(column).fill(0.0);
                    }
                }
                return Some(gains);
            }
        }
        None
    }

    /// Whether the column of the feedback is a state of elastic joints or air. The coordinates begin at column 2.
    fn unmeasured(&self, column: usize, coordinates: usize) -> bool {
        (2 + 8..2 + coordinates).contains(&column)
    }
}

/// What may deviate at every step of the orbit at `point`.
fn reference(
    cycle: &Cycle,
    deviations: &Deviations,
    point: &Point,
) -> Result<Reference, crate::plant::Fault> {
    let mut steps = Vec::with_capacity(cycle.steps() + 1);
    let mut add = |x: &[f64]| {
        let mut s = vec![0.0; deviations.len()];
        deviations.of(cycle, x, &mut s);
        steps.push(s);
    };
    add(&cycle.start(point));
    cycle.fly(&point.z, point.pace, &point.inputs, |_, _, x| {
        add(x);
        Ok(())
    })?;
    Ok(Reference { steps, inputs: point.inputs.clone() })
}

impl AboutOrbit<'_> {
    /// Share of the turn at the time `t`: 0 before, 1 after, without jumps of the rate in between.
    fn turned(&self, t: f64) -> f64 {
        let s = ((t - self.spec.turn_start_s) / self.spec.roll_in_s).clamp(0.0, 1.0);
        s * s * (3.0 - 2.0 * s)
    }

    /// The reference at `share` of the turn and `cycles` of the gait's phase: deviating numbers and commands.
    fn asked(&self, share: f64, cycles: f64) -> (Vec<f64>, Vec<f64>) {
        let place = share * (self.family.len() - 1) as f64;
        let k = (place as usize).min(self.family.len().saturating_sub(2));
        let (one, other) = (&self.family[k], &self.family[(k + 1).min(self.family.len() - 1)]);
        let between = place - k as f64;
        let step = cycles.rem_euclid(1.0) * (one.steps.len() - 1) as f64;
        let i = (step as usize).min(one.steps.len() - 2);
        let at =
            |orbit: &Reference, j: usize| lerp(orbit.steps[i][j], orbit.steps[i + 1][j], step - i as f64);
        let numbers = (0..self.deviations.len()).map(|j| lerp(at(one, j), at(other, j), between)).collect();
        let commands = one.inputs.iter().zip(&other.inputs).map(|(a, b)| lerp(*a, *b, between)).collect();
        (numbers, commands)
    }

    /// The feedback there.
    fn gain(&self, share: f64, cycles: f64) -> DMatrix<f64> {
        let phase = cycles.rem_euclid(1.0) * PHASES as f64;
        let k = (phase as usize).min(PHASES - 1);
        let at = |gains: &Gains| {
            &gains[k] * (1.0 - (phase - k as f64)) + &gains[(k + 1) % PHASES] * (phase - k as f64)
        };
        at(&self.gains[0]) * (1.0 - share) + at(&self.gains[1]) * share
    }
}

impl Controller for AboutOrbit<'_> {
    fn update(&mut self, t: f64, measurement: &Measurement) -> Update {
        let mut x = vec![0.0; self.robot.states().len()];
        if TrueState.estimate(t, measurement, &self.held, &mut x).is_err() {
            return Update::Kept;
        }
        // Phase 0 of the orbits is where the robot's gait starts.
        let cycles = (self.robot.phase(t) - self.robot.phase(0.0)) / TAU;
        let share = self.turned(t);
        let (asked, mut commands) = self.asked(share, cycles);
        let mut s = vec![0.0; self.deviations.len()];
        self.deviations.of(&self.cycle, &x, &mut s);
        let error: Vec<f64> = s.iter().zip(&asked).map(|(s, asked)| s - asked).collect();
        if error[0].abs() < INTEGRATED {
            self.integral += error[0] * self.spec.period_s;
        }
        let gain = self.gain(share, cycles);
        for (row, &input) in self.inputs.iter().enumerate() {
            let feedback: f64 = error.iter().enumerate().map(|(j, e)| gain[(row, j + 1)] * e).sum();
            let command = commands[input] - feedback - gain[(row, 0)] * self.integral;
            commands[input] = self.robot.inputs()[input].clamp(command);
        }
        (self.held, self.share, self.height_error) = (commands, share, error[0]);
        Update::Fresh
    }

    fn input(&self, _: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.held);
    }

    fn columns(&self) -> Vec<Column> {
        vec![Column::new("orbit_share", "", ""), Column::new("orbit_height_error", "m", "W")]
    }

    fn diagnostics(&self, row: &mut Vec<f64>) {
        row.extend([self.share, self.height_error]);
    }
}

//! The flow over a cycle, with exact derivatives.

use super::course::Course;
use super::section::{Direction, OrbitSection};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use wingbeat_math::{Dynamics, EqualSteps, Jet, Quat, RK4, Scalar, Vec3, Workspace, parallel};
use wingbeat_ocp::plant::{Early, Fault, Plant};
use wingbeat_robot::{CycleScalar, Robot};

/// Steps of a stroke are a multiple of this number, so that it has as many equal parts.
pub const PARTS: usize = 20;

/// Fewest steps of a cycle in which an orbit is looked for on the way to one in more.
const COARSEST: usize = 60;

/// What may be chosen beside the state.
#[derive(Clone, Debug, PartialEq)]
pub enum Free {
    /// Frequency of the gait.
    Frequency,
    /// Held commands: numbers of inputs with their shares.
    Inputs(Direction),
}

/// Name of the frequency among what is free.
const FREQUENCY: &str = "frequency";
/// What the names of commands begin with.
const COMMAND: &str = "command_";

impl Free {
    /// What `name` frees: `frequency`; a regulator; of a pair without its side both, alike in straight flight and each
    /// by itself in a turn. `None` where there is no such name, and for the regulator that paces the crank: held by itself it would
    /// turn the gait at another rate than the cycle's.
    pub fn named(robot: &Robot, name: &str, turning: bool) -> Option<Vec<Self>> {
        if name == FREQUENCY {
            return Some(vec![Self::Frequency]);
        }
        let paces = robot.pacer().map(|pacer| pacer.input);
        let input = |name: String| robot.inputs().iter().position(|input| input.name == name);
        let find = |name: String| input(name).filter(|found| Some(*found) != paces);
        if let Some(input) = find(format!("{COMMAND}{name}")) {
            return Some(vec![Self::Inputs(vec![(input, 1.0)])]);
        }
        let [left, right] = ["left", "right"].map(|side| find(format!("{COMMAND}{name}_{side}")));
        let (left, right) = (left?, right?);
        Some(if turning {
            vec![Self::Inputs(vec![(left, 1.0)]), Self::Inputs(vec![(right, 1.0)])]
        } else {
            vec![Self::Inputs(vec![(left, 1.0), (right, 1.0)])]
        })
    }

    /// The names there are, of a pair first that of both.
    pub fn names(robot: &Robot) -> Vec<String> {
        let paces = robot.pacer().map(|pacer| &robot.inputs()[pacer.input].name);
        let free = || robot.inputs().iter().filter(|input| Some(&input.name) != paces);
        let inputs = || free().map(|c| c.name.trim_start_matches(COMMAND));
        let is_pair = |pair: &&str| inputs().any(|other| other.strip_suffix("_right") == Some(*pair));
        let pairs = inputs().filter_map(|name| name.strip_suffix("_left")).filter(is_pair);
        std::iter::once(FREQUENCY).chain(pairs).chain(inputs()).map(str::to_owned).collect()
    }
}

/// Where a cycle begins and what is held over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Coordinates of the [`OrbitSection`], in the units of their states.
    pub z: Vec<f64>,
    /// Frequency over that of the robot's gait.
    pub pace: f64,
    /// Held commands, in the units of their channels.
    pub inputs: Vec<f64>,
}

/// Where a cycle ends.
#[derive(Clone, Debug)]
pub struct End<S: Scalar = f64> {
    /// Coordinates of the section, in the units of their states.
    pub z: Vec<S>,
    /// Growth of the heading, rad.
    pub heading: S,
    /// Displacement in W, the heading at the start being zero, m.
    pub displacement: Vec3<S>,
    /// Duration of the cycle, s.
    pub duration: S,
    /// Mean roll over the cycle, rad.
    pub mean_roll: S,
}

/// One cycle of a robot in a fixed number of Runge-Kutta steps.
pub struct Cycle<'a> {
    robot: &'a Robot,
    section: OrbitSection,
    steps: usize,
    /// Displacements of the elements at rest per unit of the held commands, by rows.
    rest: Vec<f64>,
}

pub(super) struct CycleFlow<'a, S: Scalar, F> {
    pub robot: &'a Robot,
    pub pace: S,
    pub u: &'a [S],
    pub each: F,
}

impl<S: CycleScalar, F: FnMut(usize, S, &[S]) -> Result<(), Fault>> Dynamics<S, Fault>
    for CycleFlow<'_, S, F>
{
    fn slope(&mut self, t: S, x: &[S], dx: &mut [S]) -> Result<(), Fault> {
        let clock = Jet::new(t * self.pace, self.pace, S::ZERO);
        S::rates_by_clock(self.robot, t, &clock, x, self.u, dx)
    }
    fn after_step(&mut self, k: usize, t: S, x: &mut [S]) -> Result<ControlFlow<()>, Fault> {
        settle(self.robot, t.value(), x)?;
        (self.each)(k + 1, t, x)?;
        Ok(ControlFlow::Continue(()))
    }
}

/// Makes the attitude of the state `x` at the time `t` one of length 1.
///
/// # Errors
/// [`Fault::NotFinite`].
pub(super) fn settle<S: Scalar>(robot: &Robot, t: f64, x: &mut [S]) -> Result<(), Fault> {
    let a = robot.layout().attitude;
    Quat::from_wxyz(&x[a..]).normalized().store_wxyz(&mut x[a..]);
    match x.iter().position(|x| !x.value().is_finite()) {
        Some(state) => Err(Fault::NotFinite { state, time: t }),
        None => Ok(()),
    }
}

impl<'a> Cycle<'a> {
    /// Cycles of `robot` in steps of about `step` s at its own frequency; the number of steps stays.
    ///
    /// # Errors
    /// [`Error::Invalid`](wingbeat_math::Error::Invalid) where the wings do not flap, and those of [`OrbitSection::new`].
    pub fn new(robot: &'a Robot, step: f64) -> Result<Self, wingbeat_math::Error> {
        let section = OrbitSection::new(robot)?;
        let frequency = robot.frequency_hz();
        if !(frequency > 0.0) {
            return Err(wingbeat_math::Error::invalid("gait.frequency_hz", frequency, "a frequency above 0"));
        }
        let parts = PARTS * robot.strokes_per_cycle();
        let steps = (1.0 / (frequency * step * parts as f64)).ceil() as usize * parts;
        Ok(Self { robot, section, steps, rest: robot.rest_gains() })
    }

    /// The same cycle in steps twice as long; `None` where they would be too few.
    pub(super) fn coarser(&self) -> Option<Self> {
        let steps = self.steps / 2;
        let (section, rest) = (self.section.clone(), self.rest.clone());
        (steps >= COARSEST).then_some(Self { robot: self.robot, section, steps, rest })
    }

    /// The same cycle in so many `steps` for each of `parts` equal parts of it.
    pub(super) fn in_steps(&self, parts: usize, steps: usize) -> Self {
        let (section, rest) = (self.section.clone(), self.rest.clone());
        Self { robot: self.robot, section, steps: parts * steps, rest }
    }

    /// The robot.
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }
    /// Its coordinates.
    pub fn section(&self) -> &OrbitSection {
        &self.section
    }
    /// Whether left and right take part alone in a flight along `course`: a turn, or any flight of a robot whose sides differ.
    pub fn coupled(&self, course: &Course) -> bool {
        course.turns() || !self.section.alike()
    }
    /// Equal parts of a cycle at which feedback is made.
    pub fn parts(&self) -> usize {
        PARTS * self.robot.strokes_per_cycle()
    }
    /// Steps of a cycle.
    pub fn steps(&self) -> usize {
        self.steps
    }
    /// Duration at `pace`, s.
    pub fn duration<S: Scalar>(&self, pace: S) -> S {
        (pace * self.robot.frequency_hz()).recip()
    }

    /// The state at which `point` begins, in the units of its channels.
    pub fn start(&self, point: &Point) -> Vec<f64> {
        self.state(&point.z, &point.inputs)
    }

    fn state<S: Scalar>(&self, z: &[S], inputs: &[S]) -> Vec<S> {
        let l = self.robot.layout();
        let mut structure = vec![S::ZERO; l.joints - l.structure];
        let commands = inputs.len().max(1);
        for (y, gains) in structure.iter_mut().zip(self.rest.chunks_exact(commands)) {
            *y = gains.iter().zip(inputs).fold(S::ZERO, |sum, (g, u)| sum + *u * *g);
        }
        let mut x = vec![S::ZERO; l.len];
        self.section.state(z, &structure, &mut x);
        x
    }

    /// Flies a cycle from the coordinates `z` with a crank `pace` as a factor on its rate and held `inputs`, in the units of
    /// their channels; `each` sees the state after every step.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable on the way.
    pub fn fly<S: CycleScalar>(
        &self,
        z: &[S],
        pace: S,
        inputs: &[S],
        mut each: impl FnMut(usize, S, &[S]) -> Result<(), Fault>,
    ) -> Result<End<S>, Fault> {
        let mut x = self.state(z, inputs);
        let duration = self.duration(pace);
        let steps = EqualSteps::new(S::ZERO, duration * (1.0 / self.steps as f64), self.steps);
        let mut work = Workspace::new(x.len(), RK4.b.len());
        // The trapezoidal rule.
        let mut rolls = z[OrbitSection::ROLL] * 0.5;
        let mut seen = |k: usize, t: S, x: &[S]| {
            let weight = if k == self.steps { 0.5 } else { 1.0 };
            rolls += self.section.roll(x) * weight;
            each(k, t, x)
        };
        let mut flow = CycleFlow { robot: self.robot, pace, u: inputs, each: &mut seen };
        RK4.integrate(&mut flow, steps, &mut x, &mut work)?;
        let mean_roll = rolls * (1.0 / self.steps as f64);
        let mut end = vec![S::ZERO; z.len()];
        let heading = self.section.coordinates(&x, &mut end);
        let displacement = Vec3::from_slice(&x[self.robot.layout().position..]);
        Ok(End { z: end, heading, displacement, duration, mean_roll })
    }

    /// Flies `point`.
    ///
    /// # Errors
    /// As [`fly`](Self::fly).
    pub fn end(&self, point: &Point) -> Result<End, Fault> {
        self.fly(&point.z, point.pace, &point.inputs, |_, _, _| Ok(()))
    }

    /// The end of a cycle with derivatives, compiled here whatever [`differentiate`](Self::differentiate) makes of it.
    fn end_in_early(&self, z: &[Early], pace: Early, inputs: &[Early]) -> Result<End<Early>, Fault> {
        self.fly(z, pace, inputs, |_, _, _| Ok(()))
    }

    /// `of` the end of a cycle from `point`, with its derivatives along `directions` of the coordinates, then along `free`:
    /// values in the units of `of`, and one row per number with a column per direction.
    ///
    /// # Errors
    /// As [`fly`](Self::fly).
    pub fn differentiate(
        &self,
        point: &Point,
        directions: &[Direction],
        free: &[Free],
        of: impl Fn(&[Early], &End<Early>) -> Vec<Early> + Sync,
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), Fault> {
        let columns = directions.len() + free.len();
        let firsts: Vec<usize> = (0..columns.max(1)).step_by(Early::LANES).collect();
        let flown = parallel::map(&firsts, |_, first| {
            let constant =
                |values: &[f64]| values.iter().map(|v| Early::constant(*v)).collect::<Vec<Early>>();
            let (mut z, mut inputs) = (constant(&point.z), constant(&point.inputs));
            let mut pace = Early::constant(point.pace);
            for column in *first..columns.min(first + Early::LANES) {
                let lane = column - first;
                let seed = |to: &mut [Early], direction: &Direction| {
                    direction.iter().for_each(|(i, share)| to[*i].eps[lane] = *share);
                };
                match column.checked_sub(directions.len()) {
                    None => seed(&mut z, &directions[column]),
                    Some(i) => match &free[i] {
                        Free::Frequency => pace.eps[lane] = 1.0,
                        Free::Inputs(direction) => seed(&mut inputs, direction),
                    },
                }
            }
            let end = self.end_in_early(&z, pace, &inputs)?;
            Ok(of(&z, &end))
        });
        let flown: Vec<Vec<Early>> = flown.into_iter().collect::<Result<_, Fault>>()?;
        let values: Vec<f64> = flown[0].iter().map(|o| o.re).collect();
        let row = |i: usize| {
            let lanes = flown.iter().flat_map(|outcome| outcome[i].eps);
            lanes.take(columns).collect::<Vec<f64>>()
        };
        let rows = (0..values.len()).map(row).collect();
        Ok((values, rows))
    }

    /// The regulator that paces the crank and what it is told for `pace` (a factor on the crank's rate), in the unit of its
    /// channel.
    pub fn pacing(&self, pace: f64) -> Option<(usize, f64)> {
        let pacer = self.robot.pacer()?;
        Some((pacer.input, (self.rate(pace) - self.rate(1.0)) / pacer.gain))
    }

    /// Rate of the crank at `pace`, rad/s.
    pub fn rate(&self, pace: f64) -> f64 {
        TAU * self.robot.frequency_hz() * pace
    }

    /// Name, unit and range of what is free.
    pub(super) fn described(&self, free: &Free) -> (String, &'static str, [f64; 2]) {
        match free {
            Free::Frequency => {
                let range = self.robot.residual_frequencies().unwrap_or([0.2, 100.0]);
                ("frequency".into(), "Hz", range)
            }
            Free::Inputs(direction) => {
                let channel = &self.robot.inputs()[direction[0].0];
                (channel.name.clone(), channel.unit, [channel.low, channel.high])
            }
        }
    }

    /// What counts as one of what is free in a step of least norm: half of a command's range, for the frequency what
    /// its regulator commands so, or without one its own value.
    pub(super) fn size(&self, free: &Free) -> f64 {
        let half = |input: usize| 0.5 * (self.robot.inputs()[input].high - self.robot.inputs()[input].low);
        match free {
            Free::Inputs(direction) => half(direction[0].0),
            Free::Frequency => {
                self.robot.pacer().map_or(1.0, |pacer| half(pacer.input) * pacer.gain.abs() / self.rate(1.0))
            }
        }
    }

    /// Value of what is free at `point`, in its unit.
    pub(super) fn value(&self, free: &Free, point: &Point) -> f64 {
        match free {
            Free::Frequency => self.robot.frequency_hz() * point.pace,
            Free::Inputs(direction) => point.inputs[direction[0].0] / direction[0].1,
        }
    }
}

//! Commands that keep the parts of the robot clear of each other: what the regulator asks, changed as little as that takes.

use nalgebra::DMatrix;
use wingbeat_math::Error;
use wingbeat_ocp::plant::{Early, Fault, Plant};
use wingbeat_ocp::realtime::{ActiveSet, QpEnd, QuadraticProgram};
use wingbeat_robot::Robot;

/// Looks at the clearances between two updates.
const LOOKS: usize = 3;
/// Rounds in which limits that turn out to be missed are added.
const ROUNDS: usize = 6;
/// Clearance by which a limit may be missed, m.
const MISSED: f64 = 2e-5;
/// Limits are told to the program in mm.
const PER_M: f64 = 1e3;

/// Keeps to a clearance over the cycle ahead.
pub(super) struct Governor<'a> {
    robot: &'a Robot,
    /// Clearance to keep, m.
    clearance: f64,
    /// Numbers of the inputs that may change.
    inputs: Vec<usize>,
    /// Time between two looks, s.
    look: f64,
    /// What the state of the elements is at the next look: by itself, and by the commands in between.
    by_state: DMatrix<f64>,
    by_command: DMatrix<f64>,
    /// What a change of the next update's commands does to the state of the elements at each look.
    reach: Vec<DMatrix<f64>>,
    /// Largest change of a command at the last update, as a share of its limit.
    pub changed: f64,
}

/// Clearances over the cycle ahead, and the elements' states they are for.
struct Ahead {
    states: Vec<Vec<f64>>,
    clearances: Vec<Vec<f64>>,
}

impl<'a> Governor<'a> {
    /// That of `robot`, which keeps a `clearance` (m) by its `inputs`, updated every `period` s.
    pub fn new(robot: &'a Robot, clearance: f64, inputs: &[usize], period: f64) -> Self {
        let (n, m) = (robot.response().elements(), robot.inputs().len());
        let look = period / LOOKS as f64;
        let mut flow = DMatrix::zeros(2 * n + m, 2 * n + m);
        for i in 0..n {
            flow[(i, n + i)] = look;
            (0..2 * n).for_each(|j| flow[(n + i, j)] = look * robot.response().state_gain(i, j));
            (0..m).for_each(|j| flow[(n + i, 2 * n + j)] = look * robot.response().command_gain(i, j));
        }
        let flow = flow.exp();
        let by_state = flow.view((0, 0), (2 * n, 2 * n)).into_owned();
        let by_command = flow.view((0, 2 * n), (2 * n, m)).into_owned();
        let chosen = by_command.select_columns(inputs);
        let looks = LOOKS + (1.0 / (robot.frequency_hz() * look)).ceil() as usize;
        let mut reach: Vec<DMatrix<f64>> = Vec::with_capacity(looks);
        for k in 0..looks {
            let before = reach.last().map_or_else(|| DMatrix::zeros(2 * n, inputs.len()), |s| &by_state * s);
            reach.push(if k < LOOKS { before + &chosen } else { before });
        }
        Self { robot, clearance, inputs: inputs.to_vec(), look, by_state, by_command, reach, changed: 0.0 }
    }

    /// That a robot can keep a clearance (m) by its commands alone.
    pub fn check(robot: &Robot, clearance: f64) -> Result<(), Error> {
        let allowed = if robot.clearances().is_empty() {
            "none for a robot without clearances"
        } else if !robot.start_coordinates().is_empty() {
            "none for a robot whose joints or crank move by themselves: their clearance is no matter of commands alone"
        } else {
            return Ok(());
        };
        Err(Error::invalid("clearance_m", clearance, allowed))
    }

    /// Equation: guide.command_governor
    /// `min (v - u)'(R + B'PB)(v - u), c_j(v) >= min(c_min, c_j(u_0)), low <= v <= high; c_j the clearances over the cycle ahead
    /// under v for one update, then u_0`
    /// Source: Garone, Di Cairano & Kolmanovsky 2017, Reference and command governors, Automatica 75; the cost is that of
    /// guide.periodic_regulator.
    /// Test: `a_governor_keeps_the_wings_apart`.
    ///
    /// Changes the commands `asked` at the time `t` as little as the clearances over the cycle ahead take, by the `hessian` of the
    /// regulator's cost in the inputs. `elements` are displacements and rates of the elements, `retreat` the commands u_0 of the
    /// orbit, all in the units of their channels. The joints follow the commands alone, whatever the air does: where the commands
    /// after this update are those of the orbit, which an update later may be asked again, what is kept now can be kept then. Where
    /// the orbit's commands themselves come closer, it is as close as they do.
    ///
    /// # Errors
    /// The [`Fault`] that makes the gait unusable on the way.
    pub fn keep(
        &mut self,
        t: f64,
        elements: &[f64],
        hessian: &DMatrix<f64>,
        retreat: &[f64],
        asked: &mut [f64],
    ) -> Result<(), Fault> {
        self.changed = 0.0;
        let mut ahead = self.ahead(t, elements, retreat, asked)?;
        if ahead.clearances.iter().flatten().all(|c| *c >= self.clearance - MISSED) {
            return Ok(());
        }
        let back = self.ahead(t, elements, retreat, retreat)?;
        let limit = |look: usize, pair: usize| back.clearances[look][pair].min(self.clearance);
        let mut program = self.program(hessian, asked);
        let mut solver = ActiveSet::new(self.inputs.len());
        let wanted = asked.to_vec();
        for _ in 0..ROUNDS {
            let mut met = true;
            for look in 0..self.reach.len() {
                for pair in 0..ahead.clearances[look].len() {
                    let short = limit(look, pair) - ahead.clearances[look][pair];
                    if short > MISSED {
                        met = false;
                        let slope = self.slope(t, look, pair, &ahead.states[look])?;
                        let known: f64 =
                            slope.iter().zip(&self.inputs).map(|(g, i)| g * (asked[*i] - wanted[*i])).sum();
                        program.rows.extend(slope.iter().map(|g| g * PER_M));
                        program.row_low.push((short + known) * PER_M);
                        program.row_high.push(f64::INFINITY);
                    }
                }
            }
            if met {
                break;
            }
            match solver.solve(&program) {
                QpEnd::Solved => {
                    self.inputs.iter().zip(&solver.z).for_each(|(i, z)| asked[*i] = wanted[*i] + z)
                }
                // Linear in between, the limits may contradict each other: the orbit's commands meet them.
                QpEnd::Infeasible { .. } | QpEnd::Trouble => {
                    self.inputs.iter().for_each(|i| asked[*i] = retreat[*i]);
                    break;
                }
            }
            ahead = self.ahead(t, elements, retreat, asked)?;
        }
        let channels = self.robot.inputs();
        let changed = self.inputs.iter().map(|i| (asked[*i] - wanted[*i]).abs() / channels[*i].high);
        self.changed = changed.fold(0.0, f64::max);
        Ok(())
    }

    /// The program without limits of clearance: changes of the commands `asked`, within their channels.
    fn program(&self, hessian: &DMatrix<f64>, asked: &[f64]) -> QuadraticProgram {
        let mut program = QuadraticProgram::new(self.inputs.len(), 0);
        program.hessian.copy_from_slice(hessian.as_slice());
        for (k, input) in self.inputs.iter().enumerate() {
            let channel = &self.robot.inputs()[*input];
            program.low[k] = channel.low - asked[*input];
            program.high[k] = channel.high - asked[*input];
        }
        program
    }

    /// The cycle ahead under the commands `first` for one update, then `after`.
    fn ahead(&self, t: f64, elements: &[f64], after: &[f64], first: &[f64]) -> Result<Ahead, Fault> {
        let pairs = self.robot.clearances().len();
        let (mut states, mut clearances) = (Vec::new(), Vec::new());
        let mut state = DMatrix::from_column_slice(elements.len(), 1, elements);
        let [first, after] =
            [first, after].map(|u| &self.by_command * DMatrix::from_column_slice(u.len(), 1, u));
        for look in 0..self.reach.len() {
            state = &self.by_state * state + if look < LOOKS { &first } else { &after };
            let mut values = vec![0.0; pairs];
            self.robot.smooth_clearances(self.time(t, look), state.as_slice(), &mut values)?;
            states.push(state.as_slice().to_vec());
            clearances.push(values);
        }
        Ok(Ahead { states, clearances })
    }

    fn time(&self, t: f64, look: usize) -> f64 {
        t + (look + 1) as f64 * self.look
    }

    /// What the clearance of `pair` at `look` gains per change of each input, m over the unit of its channel.
    fn slope(&self, t: f64, look: usize, pair: usize, state: &[f64]) -> Result<Vec<f64>, Fault> {
        let n = state.len() / 2;
        let mut by_element = vec![0.0; n];
        let mut values = vec![Early::from(0.0); self.robot.clearances().len()];
        let mut seeded: Vec<Early> = state.iter().map(|y| Early::constant(*y)).collect();
        for first in (0..n).step_by(Early::LANES) {
            let lanes = first..n.min(first + Early::LANES);
            lanes.clone().for_each(|i| seeded[i].eps[i - first] = 1.0);
            self.robot.smooth_clearances(Early::from(self.time(t, look)), &seeded, &mut values)?;
            lanes.for_each(|i| {
                by_element[i] = values[pair].eps[i - first];
                seeded[i].eps[i - first] = 0.0;
            });
        }
        let reach = &self.reach[look];
        let gain = |k: usize| by_element.iter().enumerate().map(|(i, g)| g * reach[(i, k)]).sum();
        Ok((0..self.inputs.len()).map(gain).collect())
    }
}

//! Commands that keep the parts of the robot clear of each other: what the regulator asks, changed as little as that takes.

use nalgebra::{DMatrix, DVector};
use std::cell::OnceCell;
use wingbeat_math::Error;
use wingbeat_math::range::Range;
use wingbeat_ocp::plant::{Early, Fault, Plant};
use wingbeat_ocp::realtime::{ActiveSet, QpEnd, QuadraticProgram};
use wingbeat_robot::Robot;

/// Instants of a cycle at which the clearances can be looked at, and of how many one is always. *Choices*: a dip between two of the first
/// is a twentieth of a millimetre where wings of 20 g come closest, as much as is allowed for it.
const PER_CYCLE: f64 = 200.0;
const SELDOM: usize = 4;
/// Rounds in which limits that turn out to be missed are added.
const ROUNDS: usize = 6;
/// Share of the clearance by which a limit may be missed.
const MISSED: f64 = 0.005;
/// Limits are told to the program in mm.
const PER_M: f64 = 1e3;

/// Keeps to a clearance over the cycle ahead.
pub(super) struct Governor<'a> {
    robot: &'a Robot,
    /// Clearance to keep, m.
    clearance: f64,
    /// Numbers of the inputs that may change.
    inputs: Vec<usize>,
    /// Time between two looks, s, and how many there are to an update.
    look: f64,
    to_update: usize,
    /// What the state of the elements is at the next look: by itself, and by the commands in between.
    by_state: DMatrix<f64>,
    by_command: DMatrix<f64>,
    /// What a change of the next update's commands does to the state of the elements at each look.
    reach: Vec<DMatrix<f64>>,
    /// Largest change of a command at the last update, as a share of its limit.
    pub changed: f64,
    /// Updates so far after which parts still came closer in the cycle ahead.
    pub not_kept: usize,
}

/// The cycle ahead: the elements' states at every look, and the clearances where they were looked at.
struct CycleAhead {
    states: Vec<DVector<f64>>,
    clearances: Vec<OnceCell<Vec<f64>>>,
}

impl<'a> Governor<'a> {
    /// That of `robot`, which keeps a `clearance` (m) by its `inputs`, updated every `period` s.
    pub fn new(robot: &'a Robot, clearance: f64, inputs: &[usize], period: f64) -> Self {
        let (n, m) = (robot.response().elements(), robot.inputs().len());
        let often = period * robot.frequency_hz() * PER_CYCLE / SELDOM as f64;
        let to_update = SELDOM * (often.ceil() as usize).max(1);
        let look = period / to_update as f64;
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
        let cycle = (1.0 / (robot.frequency_hz() * look * SELDOM as f64)).ceil() as usize;
        let looks = to_update + SELDOM * cycle;
        let mut reach: Vec<DMatrix<f64>> = Vec::with_capacity(looks);
        for k in 0..looks {
            let before = reach.last().map_or_else(|| DMatrix::zeros(2 * n, inputs.len()), |s| &by_state * s);
            reach.push(if k < to_update { before + &chosen } else { before });
        }
        let inputs = inputs.to_vec();
        let (changed, not_kept) = (0.0, 0);
        Self { robot, clearance, inputs, look, to_update, by_state, by_command, reach, changed, not_kept }
    }

    /// Its numbers in a record: largest change of a command, the clearance, m, and the updates at which it was not kept.
    pub fn numbers(&self) -> [f64; 3] {
        [self.changed, self.clearance, self.not_kept as f64]
    }

    /// That a robot can keep a clearance (m) by its commands alone.
    pub fn check(robot: &Robot, clearance: f64) -> Result<(), Error> {
        let allowed = if robot.clearances().is_empty() {
            "none for a robot without clearances"
        } else if !robot.start_coordinates().is_empty() {
            "none for a robot whose joints or crank move by themselves: their clearance is no matter of commands alone"
        } else {
            return Range::over(0.0, reach(robot)?).check("clearance_m", clearance);
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
        if self.short(&ahead).is_empty() {
            return Ok(());
        }
        let back = self.ahead(t, elements, retreat, retreat)?;
        let mut program = self.program(hessian, asked);
        let mut solver = ActiveSet::new(self.inputs.len());
        let wanted = asked.to_vec();
        for _ in 0..ROUNDS {
            let mut met = true;
            for Short { look, pair, by } in self.short(&ahead) {
                // No further than the orbit's commands go.
                let can = self.seen(&back, t, look)?[pair] - self.seen(&ahead, t, look)?[pair];
                let short = by.min(can);
                if short > MISSED * self.clearance {
                    met = false;
                    let slope = self.slope(t, look, pair, ahead.states[look].as_slice())?;
                    let known: f64 =
                        slope.iter().zip(&self.inputs).map(|(g, i)| g * (asked[*i] - wanted[*i])).sum();
                    program.rows.extend(slope.iter().map(|g| g * PER_M));
                    program.row_low.push((short + known) * PER_M);
                    program.row_high.push(f64::INFINITY);
                }
            }
            if met {
                break;
            }
            match solver.solve(&program) {
                QpEnd::Solved => {
                    self.inputs.iter().zip(&solver.z).for_each(|(i, z)| asked[*i] = wanted[*i] + z);
                    ahead = self.ahead(t, elements, retreat, asked)?;
                }
                // Linear in between, the limits may contradict each other: the orbit's commands meet them.
                QpEnd::Infeasible { .. } | QpEnd::Trouble => {
                    self.inputs.iter().for_each(|i| asked[*i] = retreat[*i]);
                    ahead = back;
                    break;
                }
            }
        }
        self.not_kept += usize::from(!self.keeps(&ahead, t)?);
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

    /// The cycle ahead under the commands `first` for one update, then `after`, looked at wherever it may come too close.
    fn ahead(&self, t: f64, elements: &[f64], after: &[f64], first: &[f64]) -> Result<CycleAhead, Fault> {
        let mut state = DVector::from_column_slice(elements);
        let [first, after] = [first, after].map(|u| &self.by_command * DVector::from_column_slice(u));
        let next = |look: usize| {
            state = &self.by_state * &state + if look < self.to_update { &first } else { &after };
            state.clone()
        };
        let states: Vec<DVector<f64>> = (0..self.reach.len()).map(next).collect();
        let clearances = states.iter().map(|_| OnceCell::new()).collect();
        let ahead = CycleAhead { states, clearances };
        let last = self.reach.len() / SELDOM - 1;
        let look = |k: usize| k * SELDOM + SELDOM - 1;
        for k in 0..=last {
            self.seen(&ahead, t, look(k))?;
        }
        for k in 0..=last {
            // By eight times the dip of a parabola there, before the first look and since the last.
            let near = (0..self.robot.clearances().len()).any(|pair| {
                let at = |k: usize| ahead.clearances[look(k)].get().map_or(f64::INFINITY, |all| all[pair]);
                let bent = |k: usize| bend(k.clamp(1, (last - 1).max(1)), last, &at);
                let since = k.saturating_sub(1);
                at(k).min(at(since)) - bent(k).max(bent(since)) < self.clearance
            });
            if near {
                (look(k) + 1 - SELDOM..look(k)).try_for_each(|look| self.seen(&ahead, t, look).map(drop))?;
            }
        }
        Ok(ahead)
    }

    /// The clearances of the cycle `ahead` at a look after the time `t`.
    fn seen<'s>(&self, ahead: &'s CycleAhead, t: f64, look: usize) -> Result<&'s [f64], Fault> {
        let cell = &ahead.clearances[look];
        if cell.get().is_none() {
            let mut values = vec![0.0; self.robot.clearances().len()];
            self.robot.smooth_clearances(self.time(t, look), ahead.states[look].as_slice(), &mut values)?;
            _ = cell.set(values);
        }
        Ok(cell.get().map_or(&[], Vec::as_slice))
    }

    /// Whether the parts themselves keep the clearance wherever the cycle `ahead` of the time `t` was found to come closer.
    fn keeps(&self, ahead: &CycleAhead, t: f64) -> Result<bool, Fault> {
        for Short { look, pair, .. } in self.short(ahead) {
            let least = self.robot.least_clearances(self.time(t, look), ahead.states[look].as_slice())?;
            if least[pair] < self.clearance * (1.0 - MISSED) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Where the cycle `ahead` comes closer than is asked, what a parabola through three looks falls below them by included.
    fn short(&self, ahead: &CycleAhead) -> Vec<Short> {
        let mut found = Vec::new();
        let last = ahead.clearances.len() - 1;
        for (look, seen) in ahead.clearances.iter().enumerate() {
            for (pair, clearance) in seen.get().into_iter().flatten().enumerate() {
                let at = |k: usize| ahead.clearances[k].get().map_or(f64::NAN, |all| all[pair]);
                let beside = look.saturating_sub(1).max(1)..=(look + 1).min(last.saturating_sub(1));
                let dip = beside.map(|k| 0.125 * bend(k, last, &at)).fold(0.0, f64::max);
                let by = self.clearance + dip - clearance;
                if by > MISSED * self.clearance {
                    found.push(Short { look, pair, by });
                }
            }
        }
        found
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

/// Largest distance of an edge of the surfaces from the body's origin as the gait starts, m, which no clearance exceeds; 1 m of a robot
/// without surfaces.
fn reach(robot: &Robot) -> Result<f64, Error> {
    let still = robot.at_rest(0.0);
    let still = still.map_err(|fault| Error::invalid("robot", fault, "a robot that can be evaluated"))?;
    let ends = still.outlines.iter().flat_map(|outline| outline.ribs.iter().flatten());
    // To a millimetre.
    Ok(ends.map(|end| (end.norm() * PER_M).ceil() / PER_M).reduce(f64::max).unwrap_or(1.0))
}

/// A look at which a pair comes closer than is asked, and by how much, m.
struct Short {
    look: usize,
    pair: usize,
    by: f64,
}

/// Second difference of the numbers `at` looks about the look `k` of up to the `last`, where it is positive; 0 where one was not looked at.
/// Between two looks a parabola falls below the lower one by an eighth of it at most.
fn bend(k: usize, last: usize, at: &dyn Fn(usize) -> f64) -> f64 {
    if k == 0 || k >= last {
        return 0.0;
    }
    (at(k - 1) - 2.0 * at(k) + at(k + 1)).max(0.0)
}

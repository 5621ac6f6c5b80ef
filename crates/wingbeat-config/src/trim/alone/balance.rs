//! Balance in the mean: a gait whose lift, thrust and pitching moment, averaged over a cycle of the free body, vanish against the weight.

use super::super::search::VarySpec;
use crate::{Document, Scenario};
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::ops::ControlFlow;
use wingbeat_flight::orbit::{Course, Cycle, OrbitSection, Point, drift, settle};
use wingbeat_math::{GRAVITY, parallel};

/// Most steps, and steps that may fail one after another.
const STEPS: usize = 30;
const FAILURES: usize = 6;
/// Cycles that settle swing and lags at the start and after each step.
const SETTLING: usize = 12;
const AFTER_STEP: usize = 4;
/// Cycles of settling before differences of settled cycles are taken: it goes on alike on both sides of a difference. *Choice.*
const BEFORE_DIFFERENCE: usize = 2;
/// What counts as one of the pitch, rad, of the logarithm of the pace, and of a number as a share of its range: steps of least norm
/// weigh them so, and none goes further in one step. *Choices.*
const PITCH: f64 = 0.15;
const PACE: f64 = 0.2;
const SHARE: f64 = 0.2;
/// Steepest mean nose up and down, rad. *Choice*: beyond it the flight is a hover.
const PITCHES: [f64; 2] = [-1.0, 0.4];
/// Largest and smallest pace. *Choice.*
const PACES: f64 = 3.0;
/// Damping of the first step, and after a step that fails at least ten times this; least damping of those after steps that gain. *Choices.*
const LEAST_DAMPING: [f64; 2] = [1e-3, 1e-6];
/// Step of the differences, in the sizes above.
const DIFFERENCE: f64 = 1e-4;
/// Mean accelerations that count as balanced along slopes of one cycle and of settled ones, over gravity; those from which Newton's
/// method mostly finds the orbit where no step lessens them, and from which it may. *Choices.*
const BALANCED: [f64; 2] = [0.01, 1e-3];
const NEAR: f64 = 0.03;
const NEARLY: f64 = 0.15;

/// A gait on its way to balance.
#[derive(Clone, Debug)]
pub(super) struct BalancingGait {
    /// Shares of the ranges.
    pub x: Vec<f64>,
    pub point: Point,
    pub pitch: f64,
}

/// Where the search for balance ends: a gait, and what it lacks unless that is little.
pub(super) struct Balanced {
    pub gait: BalancingGait,
    pub lacks: Option<String>,
}

/// What is balanced: a scenario and the ranges of its numbers.
pub(super) struct Balance<'a> {
    pub document: &'a Document,
    pub vary: &'a [VarySpec],
    /// Length by which angular accelerations count, m.
    pub length: f64,
}

/// A gait and its mean accelerations over gravity.
type Weighed = (BalancingGait, Vector3<f64>);

impl Balance<'_> {
    /// The scenario with numbers at the shares `x` of their ranges.
    pub fn scenario(&self, x: &[f64]) -> Result<Scenario, String> {
        let varied = self.vary.iter().zip(x);
        let document = varied.fold(self.document.clone(), |document, (vary, x)| {
            document.set(format!("{}={:?}", vary.key, vary.at(*x)))
        });
        Scenario::new(document).map_err(|error| error.to_string())
    }

    /// `of` a cycle of the gait with numbers `x`.
    fn with<T>(&self, x: &[f64], of: impl FnOnce(&Cycle, &Course) -> Result<T, String>) -> Result<T, String> {
        let scenario = self.scenario(x)?;
        let cycle = scenario.cycle().map_err(|error| error.to_string())?;
        let course = scenario.trim_spec().map_err(|error| error.to_string())?.course();
        of(&cycle, &course)
    }

    /// The gait after `cycles` of settling, and what is off balance then.
    fn settled(&self, mut gait: BalancingGait, cycles: usize) -> Result<Weighed, String> {
        let x = gait.x.clone();
        self.with(&x, |cycle, course| {
            for _ in 0..cycles {
                settle(cycle, course, gait.pitch, &mut gait.point).map_err(|failure| failure.to_string())?;
            }
            let off = self.off(cycle, &gait.point)?;
            Ok((gait, off))
        })
    }

    /// Mean accelerations over gravity.
    ///
    /// Equation: trim.mean_balance
    /// `(dvx, dvz, l dq) / (g T)`
    /// Source: momentum over a cycle.
    /// Test: `a_robot_alone_is_trimmed`.
    fn off(&self, cycle: &Cycle, point: &Point) -> Result<Vector3<f64>, String> {
        let [ahead, up, turning] = drift(cycle, point).map_err(|failure| failure.to_string())?;
        let off = Vector3::new(ahead, up, turning * self.length);
        let off = off / (GRAVITY * cycle.duration(point.pace));
        if off.iter().all(|o| o.is_finite()) { Ok(off) } else { Err("the gait grows without bound".into()) }
    }

    /// `gait` moved by `step`, in the sizes of the unknowns.
    fn moved(&self, gait: &BalancingGait, step: &[f64]) -> BalancingGait {
        let mut next = gait.clone();
        let pitch = (gait.pitch + PITCH * step[0]).clamp(PITCHES[0], PITCHES[1]);
        next.point.z[OrbitSection::PITCH] += pitch - gait.pitch;
        next.pitch = pitch;
        next.point.pace = (gait.point.pace * (PACE * step[1]).exp()).clamp(1.0 / PACES, PACES);
        for (x, step) in next.x.iter_mut().zip(&step[2..]) {
            *x = (*x + SHARE * step).clamp(0.0, 1.0);
        }
        next
    }

    /// Differences of what is off balance by each unknown, forward or where its range ends backward, each after `cycles` of settling.
    ///
    /// Without settling a cycle begins in the swing of the gait before: its drift is that of a robot which sinks, once heave is damped within
    /// a cycle, and not that of the mean motion which is asked.
    fn slopes(&self, gait: &BalancingGait, cycles: usize) -> Result<DMatrix<f64>, String> {
        let count = 2 + gait.x.len();
        let columns: Vec<usize> = (0..count).collect();
        let off = |gait: BalancingGait| Ok::<_, String>(self.settled(gait, cycles)?.1);
        // What is left to settle is the same on both sides of a difference.
        let here = off(gait.clone())?;
        let column = |_: usize, &i: &usize| -> Result<Vector3<f64>, String> {
            let sign = if i >= 2 && gait.x[i - 2] > 0.5 { -1.0 } else { 1.0 };
            let mut step = vec![0.0; count];
            step[i] = sign * DIFFERENCE;
            Ok((off(self.moved(gait, &step))? - here) / (sign * DIFFERENCE))
        };
        let columns: Vec<Vector3<f64>> =
            parallel::map(&columns, column).into_iter().collect::<Result<_, _>>()?;
        Ok(DMatrix::from_fn(3, count, |i, j| columns[j][i]))
    }

    /// How far each unknown may go on, down and up, in its size.
    fn room(&self, gait: &BalancingGait) -> Vec<[f64; 2]> {
        let pitch = PITCHES.map(|end| (end - gait.pitch) / PITCH);
        let pace = [-PACES.ln(), PACES.ln()].map(|end| (end - gait.point.pace.ln()) / PACE);
        let shares = gait.x.iter().map(|x| [-x / SHARE, (1.0 - x) / SHARE]);
        let ends = [pitch, pace].into_iter().chain(shares);
        ends.map(|[low, high]| [low.max(-1.0), high.min(1.0)]).collect()
    }

    /// The gait after a step along `slopes` that lessens what is `off`; none where none of some more and more damped does.
    fn better(
        &self,
        gait: &BalancingGait,
        off: &Vector3<f64>,
        slopes: &DMatrix<f64>,
        damping: &mut f64,
    ) -> Option<Weighed> {
        let room = self.room(gait);
        for _ in 0..FAILURES {
            let step = least(slopes, off, *damping, &room);
            match self.settled(self.moved(gait, &step), AFTER_STEP) {
                Ok((next, left)) if left.norm() < 0.99 * off.norm() => {
                    *damping = (0.2 * *damping).max(LEAST_DAMPING[1]);
                    return Some((next, left));
                }
                _ => *damping = 10.0 * damping.max(LEAST_DAMPING[0]),
            }
        }
        None
    }

    /// A gait near `start` that is balanced, or nearly; `tell` hears the iteration and the relative imbalance.
    ///
    /// # Errors
    /// What stays off balance, or why the model cannot be evaluated.
    pub fn near(
        &self,
        start: BalancingGait,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<Balanced, String> {
        let (mut gait, mut off) = self.settled(start, SETTLING)?;
        // Slopes of one cycle cost least; the last steps, and those after the first along which nothing gains, take those of settled cycles.
        let (mut damping, mut cycles) = (LEAST_DAMPING[0], 0);
        for iteration in 1..=STEPS {
            if tell(iteration, off.amax()).is_break() {
                return Err("stopped".into());
            }
            if cycles == 0 && off.amax() < BALANCED[0] {
                cycles = BEFORE_DIFFERENCE;
            }
            if off.amax() < BALANCED[1] {
                break;
            }
            let slopes = self.slopes(&gait, cycles)?;
            match self.better(&gait, &off, &slopes, &mut damping) {
                Some(next) => (gait, off) = next,
                None if cycles == 0 => (cycles, damping) = (BEFORE_DIFFERENCE, LEAST_DAMPING[0]),
                None => break,
            }
        }
        let [ahead, up, turning] = [off[0], off[1], off[2]];
        let lacks = (off.amax() > NEAR).then(|| {
            format!(
                "no balance in the mean: {ahead:+.2} g ahead, {up:+.2} g up, {turning:+.2} g of pitching are left at {:.2} Hz and {:.0} deg \
                 nose up",
                self.frequency(&gait).unwrap_or(f64::NAN),
                -gait.pitch.to_degrees()
            )
        });
        match lacks {
            Some(lacks) if off.amax() > NEARLY => Err(lacks),
            lacks => Ok(Balanced { gait, lacks }),
        }
    }

    /// Frequency of a gait, Hz.
    fn frequency(&self, gait: &BalancingGait) -> Result<f64, String> {
        self.with(&gait.x, |cycle, _| Ok(1.0 / cycle.duration(gait.point.pace)))
    }
}

/// The damped step of least norm, dimensionless, that takes off `off`, within `room` (shares of the ranges): unknowns that
/// would leave it stop at its end and the others take over.
pub fn least(slopes: &DMatrix<f64>, off: &Vector3<f64>, damping: f64, room: &[[f64; 2]]) -> Vec<f64> {
    let count = room.len();
    let mut step = vec![0.0; count];
    let mut fixed = vec![false; count];
    for _ in 0..count {
        let mut left = -off;
        let mut gram = Matrix3::identity() * damping;
        for j in 0..count {
            let column = Vector3::from_column_slice(slopes.column(j).as_slice());
            if fixed[j] { left -= column * step[j] } else { gram += column * column.transpose() }
        }
        let Some(force) = gram.lu().solve(&left) else { break };
        let mut clean = true;
        for j in (0..count).filter(|j| !fixed[*j]).collect::<Vec<_>>() {
            let wanted = Vector3::from_column_slice(slopes.column(j).as_slice()).dot(&force);
            step[j] = wanted.clamp(room[j][0], room[j][1]);
            if step[j] != wanted {
                (fixed[j], clean) = (true, false);
            }
        }
        if clean {
            break;
        }
    }
    step
}

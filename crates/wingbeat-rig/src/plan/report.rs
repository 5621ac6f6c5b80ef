//! A finished plan, its check on the samples, and its report.

use super::usage::{LimitKind, Peak, binding, peaks};
use super::{Clearance, PlacedTurn, PlacementWorkspace, TurnSpec, Untracked};
use crate::JointTrajectory;
use crate::arm::{LimitProfile, SerialArm};
use std::fmt::Write;
use wingbeat_math::Error;

/// Sampling rate of a planned motion, 1/s.
const RATE: f64 = 1000.0;

/// A turn that the arm can fly within every limit.
#[derive(Clone, Debug)]
pub struct TurnPlan {
    /// Where and in which posture.
    pub placed: PlacedTurn,
    /// Joint motion at 1 kHz.
    pub trajectory: JointTrajectory,
    /// Every peak against its limit.
    pub peaks: Vec<Peak>,
    /// Smallest distances.
    pub clearance: Clearance,
    /// Smallest singular value of the Jacobian, m/rad.
    pub singularity_margin: f64,
    /// Begin and end of the steady turn, s.
    pub measured: (f64, f64),
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// No place in the workspace lets the arm follow the path.
    Unreachable,
    /// The best place found still breaks a limit.
    Limit {
        /// The limit most broken.
        peak: Peak,
        /// Name of the joint, or `tool`.
        joint: String,
        /// Fastest speed at which the same motion keeps every limit, m/s; 0 where none is known.
        feasible_speed: f64,
    },
    /// The best place found comes too near to something.
    Near {
        /// The distances.
        clearance: Clearance,
        /// Smallest singular value, m/rad.
        singularity_margin: f64,
    },
    /// The path left the workspace between two coarse samples.
    Untracked(Untracked),
}

impl PlacementWorkspace<'_> {
    /// Places the turn, samples it at 1 kHz and checks the samples against
    /// every limit.
    ///
    /// # Errors
    /// Bad numbers in the turn.
    pub fn plan(&self, spec: &TurnSpec) -> Result<Result<TurnPlan, Refusal>, Error> {
        Ok(match self.place(spec)? {
            Some(placed) => self.finish(placed),
            None => Err(Refusal::Unreachable),
        })
    }

    /// Samples a placed turn at 1 kHz and checks it.
    ///
    /// # Errors
    /// The first limit or margin that the samples break.
    pub fn finish(&self, placed: PlacedTurn) -> Result<TurnPlan, Refusal> {
        let samples = (placed.path.duration() * RATE).round() as usize;
        let instants = self.follow(&placed, samples).map_err(Refusal::Untracked)?;
        let rows = |f: fn(&wingbeat_math::Jet) -> f64| {
            instants.iter().map(|i| i.q[..self.arm.dof()].iter().map(f).collect()).collect()
        };
        let trajectory = JointTrajectory {
            joints: self.arm.joints.iter().map(|j| j.name.clone()).collect(),
            step: 1.0 / RATE,
            position: rows(|q| q.x),
            velocity: rows(|q| q.d),
            acceleration: rows(|q| q.dd),
        };
        let plan = TurnPlan {
            peaks: peaks(self.arm, self.profile, Some(self.payload), &instants),
            clearance: instants.iter().fold(Clearance::FREE, |c, i| c.min(i.clearance)),
            singularity_margin: instants.iter().fold(f64::INFINITY, |m, i| m.min(i.margin)),
            measured: placed.path.measured(),
            trajectory,
            placed,
        };
        self.check(plan)
    }

    fn check(&self, plan: TurnPlan) -> Result<TurnPlan, Refusal> {
        let near = plan.clearance.smallest() < self.margins.clearance;
        if near || plan.singularity_margin < self.margins.singularity {
            let (clearance, singularity_margin) = (plan.clearance, plan.singularity_margin);
            return Err(Refusal::Near { clearance, singularity_margin });
        }
        let mut all = plan.peaks.clone();
        all.extend(sampled_peaks(self.profile, &plan.trajectory));
        match binding(&all) {
            Some(peak) if peak.share() > 1.0 => {
                // What does not go with the speed is not kept at another one either, as far as is known.
                let stays = all.iter().any(|peak| peak.kind.order() == 0 && peak.share() > 1.0);
                let headroom = all.iter().map(Peak::headroom).fold(f64::INFINITY, f64::min);
                let headroom = if stays { 0.0 } else { headroom };
                let joint = joint_name(self.arm, peak);
                let feasible_speed = headroom * plan.placed.path.turn().speed;
                Err(Refusal::Limit { peak: *peak, joint, feasible_speed })
            }
            _ => Ok(plan),
        }
    }
}

/// Peaks of velocity, acceleration and jerk that the receiver of the samples
/// sees: differences of the positions alone.
pub fn sampled_peaks(profile: &LimitProfile, trajectory: &JointTrajectory) -> Vec<Peak> {
    let (velocity, acceleration) = trajectory.differenced().peaks();
    let jerk = trajectory.peak_jerk();
    let mut all = Vec::new();
    for j in 0..trajectory.joints.len() {
        let mut add = |kind, value, limit| all.push(Peak { joint: Some(j), kind, value, limit });
        add(LimitKind::Velocity, velocity[j], profile.velocity[j]);
        add(LimitKind::Acceleration, acceleration[j], profile.acceleration[j]);
        add(LimitKind::Jerk, jerk[j], profile.jerk[j]);
    }
    all
}

fn joint_name(arm: &SerialArm, peak: &Peak) -> String {
    peak.joint.map_or_else(|| "tool".into(), |j| arm.joints[j].name.clone())
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Unreachable => {
                write!(
                    f,
                    "no place in the workspace lets the arm follow the path; shorten it or narrow the turn"
                )
            }
            Self::Limit { peak, joint, feasible_speed } => {
                let (words, unit) = peak.kind.words();
                write!(
                    f,
                    "{joint}: {words} {:.3} {unit} exceeds the limit {:.3} {unit}",
                    peak.value, peak.limit
                )?;
                match *feasible_speed > 0.0 {
                    true => write!(f, "; the same motion keeps every limit at {feasible_speed:.3} m/s"),
                    false => Ok(()),
                }
            }
            Self::Near { clearance, singularity_margin } => write!(
                f,
                "too near: table {:.3} m, arm {:.3} m, wings {:.3} m, singularity margin {singularity_margin:.3}",
                clearance.table, clearance.arm, clearance.wings
            ),
            Self::Untracked(Untracked::OutOfReach { t, distance, limit }) => {
                let held = limit.map_or(String::new(), |j| format!(" (joint {} on its limit)", j + 1));
                write!(f, "out of reach by {distance:.3} m at t = {t:.3} s{held}")
            }
            Self::Untracked(Untracked::Singular { t }) => write!(f, "the arm is singular at t = {t:.3} s"),
        }
    }
}

impl TurnPlan {
    /// The plan in words and numbers.
    pub fn report(&self, arm: &SerialArm, profile: &LimitProfile) -> String {
        let mut text = String::new();
        let turn = self.placed.path.turn();
        let [x, y, z] = self.placed.placement.path.origin.0;
        let _ = writeln!(
            text,
            "turn at {} m/s, roll {:.1} deg, nose up {:.1} deg, radius {:.3} m, yaw rate {:.3} rad/s",
            turn.speed,
            turn.roll.to_degrees(),
            -turn.pitch.to_degrees(),
            turn.radius,
            -turn.roll.signum() * turn.speed / turn.radius,
        );
        let _ = writeln!(
            text,
            "run-up {:.3} s, {}, roll-in {:.3} s, steady {:.3} s, run-down {:.3} s",
            turn.run_up,
            straight(turn.straight),
            turn.roll_in,
            turn.measured,
            turn.run_down
        );
        let _ =
            writeln!(text, "centre of the turn ({x:.3}, {y:.3}) m, height {z:.3} m in the arm's base frame");
        let _ = writeln!(
            text,
            "in the run file: centre_m = [{x}, {y}], height_m = {z}, radius_m = {}, run_up_s = {:.3}, \
             straight_s = {:.3}, roll_in_s = {:.3}, run_down_s = {:.3}",
            turn.radius, turn.run_up, turn.straight, turn.roll_in, turn.run_down
        );
        let _ = writeln!(
            text,
            "{:.3} s at 1 kHz, steady turn from {:.3} to {:.3} s",
            self.trajectory.duration(),
            self.measured.0,
            self.measured.1
        );
        let _ = writeln!(text, "limit profile {} ({})", profile.name, profile.source);
        for peak in self.peaks.iter().filter(|p| p.limit.is_finite()) {
            let (words, unit) = peak.kind.words();
            let _ = writeln!(
                text,
                "  {:8} {words:17} {:8.3} of {:8.3} {unit:7} {:5.1} %",
                joint_name(arm, peak),
                peak.value,
                peak.limit,
                100.0 * peak.share()
            );
        }
        if let Some(peak) = binding(&self.peaks) {
            let (words, _) = peak.kind.words();
            let share = 100.0 * peak.share();
            let _ = writeln!(text, "binding: {words} of {} at {share:.1} %", joint_name(arm, peak));
        }
        let c = &self.clearance;
        let _ = writeln!(
            text,
            "clearance: table {:.3} m, arm to itself {:.3} m, wings to arm {:.3} m; singularity margin {:.3}",
            c.table, c.arm, c.wings, self.singularity_margin
        );
        text
    }
}

/// The time of straight flight at full speed, s, in words; below zero the roll-in begins before full speed.
fn straight(time: f64) -> String {
    if time < 0.0 {
        return format!("roll-in from {:.3} s before full speed on", -time);
    }
    format!("straight {time:.3} s")
}

#[cfg(test)]
mod tests {
    use super::straight;

    #[test]
    fn no_time_is_negative() {
        assert_eq!(
            [0.05, -0.226].map(straight),
            ["straight 0.050 s", "roll-in from 0.226 s before full speed on"]
        );
    }
}

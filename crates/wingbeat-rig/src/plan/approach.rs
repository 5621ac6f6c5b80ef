//! The way from the arm's present pose to the begin of a motion: straight in joint space, in least time.

use super::report::sampled_peaks;
use super::usage::{Peak, binding, peaks};
use super::{Clearance, PlacementWorkspace, Refusal, TrackInstant, clearance};
use crate::arm::{LimitProfile, MAX_JOINTS};
use crate::{FrameMotion, JointTrajectory};
use std::f64::consts::TAU;
use wingbeat_math::Error;
use wingbeat_math::Jet;

/// Sampling rate, 1/s.
const RATE: f64 = 1000.0;
/// Share of each limit that is used: samples and differences of them stay below.
const USED: f64 = 0.98;
/// Where a profile leaves acceleration or jerk open: times in which full speed and full
/// acceleration are reached, s (choice).
const OPEN: [f64; 2] = [0.5, 0.1];

/// Largest position of a joint, rad: ten thousand turns. A number of 64 bits knows it to 7e-12 rad, the rest of a division
/// by a whole turn to the 1e4 times larger error of 2 pi in it, a thousandth of a degree at most.
pub const LARGEST_POSITION: f64 = 1e4 * TAU;

/// A motion from rest to rest.
#[derive(Clone, Debug)]
pub struct ArmApproach {
    /// Joint motion at 1 kHz.
    pub trajectory: JointTrajectory,
    /// Every peak against its limit.
    pub peaks: Vec<Peak>,
    /// Smallest distances.
    pub clearance: Clearance,
}

/// Rest to rest over the length 1 in least time under limits of rate, acceleration and jerk:
/// jerk, none, -jerk, none, -jerk, none, jerk (Biagiotti & Melchiorri 2008, section 3.4).
#[derive(Clone, Copy, Debug, PartialEq)]
struct JerkProfile {
    /// Times of each jerk, of the whole speeding-up, and of steady speed, s.
    jerking: f64,
    rising: f64,
    steady: f64,
}

impl JerkProfile {
    fn new(rate: f64, acceleration: f64, jerk: f64) -> Self {
        let jerking = (acceleration / jerk).min((rate / jerk).sqrt());
        let rising = jerking + rate / (jerk * jerking);
        let steady = 1.0 / rate - rising;
        if steady >= 0.0 {
            return Self { jerking, rising, steady };
        }
        if 2.0 * acceleration.powi(3) <= jerk * jerk {
            let jerking = acceleration / jerk;
            let rising = 0.5 * jerking + (0.25 * jerking * jerking + 1.0 / acceleration).sqrt();
            return Self { jerking, rising, steady: 0.0 };
        }
        let jerking = (0.5 / jerk).cbrt();
        Self { jerking, rising: 2.0 * jerking, steady: 0.0 }
    }

    fn duration(&self) -> f64 {
        2.0 * self.rising + self.steady
    }

    /// Share of the way with its rates at `t`.
    ///
    /// Equation: rig.double_s
    /// `s''' in {j, 0, -j} over Tj, Ta - 2 Tj, Tj, Tv, mirrored; j Tj (Ta - Tj) (Ta + Tv) = 1`
    /// Source: Biagiotti & Melchiorri 2008, section 3.4.
    /// Test: `the_way_is_whole_and_no_limit_is_broken`.
    fn at(&self, t: f64) -> Jet {
        let total = self.duration();
        if t > 0.5 * total {
            let mirrored = self.at(total - t);
            return Jet::new(1.0 - mirrored.x, mirrored.d, -mirrored.dd);
        }
        let (tj, ta) = (self.jerking, self.rising);
        // Jerk from the length 1 = rate (rising + steady), rate = jerk tj (ta - tj).
        let jerk = 1.0 / ((ta + self.steady) * tj * (ta - tj));
        let (mut s, mut left) = (Jet::default(), t.max(0.0));
        for (time, j) in [(tj, jerk), (ta - 2.0 * tj, 0.0), (tj, -jerk), (f64::INFINITY, 0.0)] {
            let h = left.min(time);
            let (x, d, dd) = (s.x, s.d, s.dd);
            s = Jet::new(x + h * (d + h * (dd / 2.0 + h * j / 6.0)), d + h * (dd + h * j / 2.0), dd + h * j);
            left -= h;
        }
        s
    }
}

impl PlacementWorkspace<'_> {
    /// The straight joint motion from rest at `from` to rest at `to` (rad), in least time under
    /// the limits, whole milliseconds long. Joints without end take the shorter way.
    ///
    /// # Errors
    /// A pose outside the joint limits.
    pub fn approach(&self, from: &[f64], to: &[f64]) -> Result<Result<ArmApproach, Refusal>, Error> {
        self.check_pose(from)?;
        let way = self.arm.joints.iter().zip(from).zip(to).map(|((joint, from), to)| {
            let way = to - from;
            if joint.continuous() { way - TAU * (way / TAU).round() } else { way }
        });
        let way: Vec<f64> = way.collect();
        let profile = shared_profile(self.profile, &way);
        let mut slower = 1.0;
        let mut approach = self.sampled(from, &way, &profile, slower);
        // What binds the tool, not the joints, is kept by moving slower.
        let headroom = approach.all_peaks(self.profile).iter().map(Peak::headroom).fold(1.0, f64::min);
        if headroom < 1.0 {
            slower = 1.001 / headroom;
            approach = self.sampled(from, &way, &profile, slower);
        }
        Ok(self.checked(approach))
    }

    fn check_pose(&self, from: &[f64]) -> Result<(), Error> {
        let dof = self.arm.dof();
        if from.len() != dof || from.iter().any(|q| !q.is_finite()) {
            return Err(Error::invalid("from", format!("{from:?}"), format!("{dof} finite joint positions")));
        }
        if let Some(joint) = from.iter().position(|q| q.abs() > LARGEST_POSITION) {
            let key = format!("from.{}", self.arm.joints[joint].name);
            let allowed = format!("angles of at most {:e} deg", LARGEST_POSITION.to_degrees());
            return Err(Error::invalid(key, format!("{:e} deg", from[joint].to_degrees()), allowed));
        }
        match self.arm.beyond_limits(from, 0.02) {
            None => Ok(()),
            Some((joint, _)) => {
                let j = &self.arm.joints[joint];
                let allowed = format!("{:.1} to {:.1} deg", j.low.to_degrees(), j.high.to_degrees());
                Err(Error::invalid(format!("from.{}", j.name), from[joint].to_degrees(), allowed))
            }
        }
    }

    fn sampled(&self, from: &[f64], way: &[f64], profile: &Option<JerkProfile>, slower: f64) -> ArmApproach {
        let least = profile.map_or(0.0, |profile| profile.duration() * slower);
        let samples = (least * RATE).ceil() as usize;
        // Times stretch so that the last sample is the end.
        let stretch = if samples > 0 { samples as f64 / RATE / (least / slower) } else { 1.0 };
        let instant = |k: usize| {
            let t = k as f64 / RATE;
            let s = profile.map_or(Jet::default(), |profile| profile.at(t / stretch));
            let q: [Jet; MAX_JOINTS] = std::array::from_fn(|j| match way.get(j) {
                None => Jet::default(),
                Some(way) => {
                    Jet::new(from[j] + way * s.x, way * s.d / stretch, way * s.dd / (stretch * stretch))
                }
            });
            self.instant(t, q)
        };
        let instants: Vec<TrackInstant> = (0..=samples).map(instant).collect();
        let rows = |f: fn(&Jet) -> f64| {
            instants.iter().map(|i| i.q[..self.arm.dof()].iter().map(f).collect()).collect()
        };
        ArmApproach {
            trajectory: JointTrajectory {
                joints: self.arm.joints.iter().map(|j| j.name.clone()).collect(),
                step: 1.0 / RATE,
                position: rows(|q| q.x),
                velocity: rows(|q| q.d),
                acceleration: rows(|q| q.dd),
            },
            peaks: peaks(self.arm, self.profile, Some(self.payload), &instants),
            clearance: instants.iter().fold(Clearance::FREE, |c, i| c.min(i.clearance)),
        }
    }

    fn instant(&self, t: f64, q: [Jet; MAX_JOINTS]) -> TrackInstant {
        let tool = self.arm.tool_pose(&q);
        let frames = self.arm.frames(&q.map(|q| q.x));
        let body = tool.values() * self.body;
        let clearance = clearance(self.arm, &frames, &body, self.envelope, self.table);
        TrackInstant { t, q, margin: f64::INFINITY, clearance, tool: FrameMotion::from_jets(&tool) }
    }

    fn checked(&self, approach: ArmApproach) -> Result<ArmApproach, Refusal> {
        if approach.clearance.smallest() < self.margins.clearance {
            let clearance = approach.clearance;
            return Err(Refusal::Near { clearance, singularity_margin: f64::INFINITY });
        }
        match binding(&approach.all_peaks(self.profile)) {
            Some(peak) if peak.share() > 1.0 => {
                let joint = peak.joint.map_or("tool".into(), |j| self.arm.joints[j].name.clone());
                Err(Refusal::Limit { peak: *peak, joint, feasible_speed: 0.0 })
            }
            _ => Ok(approach),
        }
    }
}

impl ArmApproach {
    /// Peaks of the motion and of what the receiver of the samples sees.
    fn all_peaks(&self, profile: &LimitProfile) -> Vec<Peak> {
        let mut all = self.peaks.clone();
        if self.trajectory.len() > 3 {
            all.extend(sampled_peaks(profile, &self.trajectory));
        }
        all
    }

    /// The motion in words and numbers.
    pub fn report(&self, profile: &LimitProfile) -> String {
        let used = binding(&self.peaks).map_or(0.0, |peak| 100.0 * peak.share());
        let c = &self.clearance;
        format!(
            "from the present pose: {:.3} s at 1 kHz, straight in joint space, limit profile {} used to {used:.1} %\n\
             clearance: table {:.3} m, arm to itself {:.3} m, wings to arm {:.3} m\n",
            self.trajectory.duration(),
            profile.name,
            c.table,
            c.arm,
            c.wings
        )
    }
}

/// Limits of the share of the way that keep every joint within its own; none when no joint moves.
fn shared_profile(limits: &LimitProfile, way: &[f64]) -> Option<JerkProfile> {
    let least = |limit: &[f64]| {
        let of =
            |(limit, way): (&f64, &f64)| if way.abs() > 1e-9 { limit / way.abs() } else { f64::INFINITY };
        USED * limit.iter().zip(way).map(of).fold(f64::INFINITY, f64::min)
    };
    let rate = least(&limits.velocity);
    if !rate.is_finite() {
        return None;
    }
    let chosen = |limit: &[f64], choice: f64| {
        if limit.iter().any(|limit| limit.is_infinite()) { least(limit).min(choice) } else { least(limit) }
    };
    let acceleration = chosen(&limits.acceleration, rate / OPEN[0]);
    let jerk = chosen(&limits.jerk, acceleration / OPEN[1]);
    Some(JerkProfile::new(rate, acceleration, jerk))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rate, acceleration and jerk limits whose profiles reach all three, two, or one of them.
    const LIMITS: [[f64; 3]; 5] =
        [[0.5, 1.0, 10.0], [0.5, 10.0, 2.0], [50.0, 1.0, 10.0], [50.0, 100.0, 2.0], [1.0, 1.2, 3.0]];

    #[test]
    fn the_way_is_whole_and_no_limit_is_broken() {
        for [rate, acceleration, jerk] in LIMITS {
            let profile = JerkProfile::new(rate, acceleration, jerk);
            let total = profile.duration();
            let steps = 4000;
            let at = |k: i32| profile.at(total * f64::from(k) / f64::from(steps));
            assert!(at(0).x.abs() < 1e-15 && (at(steps).x - 1.0).abs() < 1e-12, "{profile:?}");
            let (mut most, mut before) = ([0.0_f64; 3], at(0));
            for k in 1..=steps {
                let now = at(k);
                let h = total / f64::from(steps);
                // The rates are the derivatives of the way.
                assert!((now.x - before.x - 0.5 * h * (now.d + before.d)).abs() < 1e-6, "{profile:?} {k}");
                let j = (now.dd - before.dd) / h;
                most = [most[0].max(now.d), most[1].max(now.dd.abs()), most[2].max(j.abs())];
                before = now;
            }
            let limits = [rate, acceleration, jerk];
            assert!(most.iter().zip(limits).all(|(m, l)| *m <= l * (1.0 + 1e-6)), "{most:?} {limits:?}");
            // Least time: what is not jerk-limited ends on a limit of rate or acceleration.
            assert!(most.iter().zip(limits).any(|(m, l)| *m > 0.999 * l), "{most:?} {limits:?}");
        }
    }

    #[test]
    fn wide_limits_leave_the_jerk_alone() {
        // x = j t^3 / 3 at half time: T = 4 (1 / (2 j))^(1/3).
        let profile = JerkProfile::new(1e3, 1e3, 2.0);
        assert!((profile.duration() - 4.0 * 0.25_f64.cbrt()).abs() < 1e-12);
    }
}

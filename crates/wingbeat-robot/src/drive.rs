//! The crank of the gait under its drive, and what drive and regulators give to the joints.

use super::joints::Displaced;
use super::mechanism::{JointDrive, Spring};
use super::{Joints, MAX_ELEMENTS, Robot};
use crate::body::{Coordinates, LinkMotion, MAX_LINKS};
use crate::{CrankMotor, MotorWork};
use arrayvec::ArrayVec;
use wingbeat_math::{Jet, Meets, Scalar};
use wingbeat_ocp::plant::Fault;

/// How joints move with what the dynamics decide beside their own coordinates.
pub(super) struct Ratios<S> {
    /// dq/dphase of every joint, the displacements of the structure held; empty at a constant rate.
    pub crank: ArrayVec<S, MAX_LINKS>,
    /// dq/dy of the joints of every element with an inertia, one element after the other.
    pub loaded: ArrayVec<S, MAX_LINKS>,
    /// Efforts of the actuators of these elements and of springs on pins along them, N m or N.
    pub pushes: ArrayVec<S, MAX_ELEMENTS>,
    /// Effort of springs on pins along a crank under a motor, N m.
    pub crank_push: S,
}

impl<S: Scalar> Ratios<S> {
    /// None yet.
    #[inline]
    pub fn new() -> Self {
        Self { crank: ArrayVec::new(), loaded: ArrayVec::new(), pushes: ArrayVec::new(), crank_push: S::ZERO }
    }

    /// None again.
    pub fn clear(&mut self) {
        let Self { crank, loaded, pushes, crank_push } = self;
        crank.clear();
        loaded.clear();
        pushes.clear();
        *crank_push = S::ZERO;
    }
}

impl<P: Scalar> Robot<P> {
    /// Coordinates that the dynamics decide: elastic and free joints, then the crank under a motor.
    #[inline]
    pub(super) fn degrees(&self) -> usize {
        self.mechanism.coordinates.len() + usize::from(self.motor.is_some())
    }

    /// The motor that turns the crank, if the crank does not turn at a constant rate.
    pub fn motor(&self) -> Option<&CrankMotor<P>> {
        self.motor.as_ref()
    }

    /// Phase of the gait with its rate: the crank's under a motor, whose acceleration is left out.
    /// `structure` as for [`Robot::joints`].
    #[inline(always)]
    pub(super) fn crank<S: Scalar + Meets<P>>(&self, clock: &Jet<S>, structure: &[S]) -> Jet<S> {
        if self.motor.is_none() {
            let Jet { x, d, dd } = *clock;
            let (rate, start) = (self.phase_rate, self.phase_start);
            return Jet::new(x * rate + start, d * rate, dd * rate);
        }
        let (count, states) = (self.degrees(), &structure[2 * self.elements.len()..]);
        Jet::new(states[count - 1], states[2 * count - 1], S::ZERO)
    }

    /// Phase of the gait as far as elements displace the crank.
    #[inline(always)]
    pub(super) fn phase_of<S: Scalar + Meets<P>>(
        &self,
        clock: &Jet<S>,
        structure: &[S],
        displacements: &[Jet<S>],
    ) -> Jet<S> {
        let mut phase = self.crank(clock, structure);
        for &i in &self.moved.crank {
            phase += displacements[i];
        }
        phase
    }

    /// Coordinates of the driven joints at the phase `phase`, the structure displaced: a joint of mean m and
    /// series q(phase) is at m + (1 + s) (q - m) + y.
    ///
    /// Equation: robot.scaled_series
    /// `q = m + (1 + s) (q_gait - m) + y, m the mean of the series`
    /// Source: choice.
    /// Test: `a_series_is_scaled_about_its_mean_and_the_crank_runs_ahead`.
    #[inline(always)]
    pub(super) fn driven<S: Scalar + Meets<P>>(
        &self,
        phase: Jet<S>,
        displacements: &[Jet<S>],
        joints: &mut Joints<S>,
    ) -> Result<(), Fault> {
        self.drive(phase, displacements, joints)?;
        for &(i, joint) in &self.moved.scaled {
            if let JointDrive::Series(series, _) = &self.mechanism.drives[joint] {
                let swing = joints[joint].shifted(-series.mean_rad);
                joints[joint] += swing * displacements[i];
            }
        }
        for &(i, joint) in &self.moved.joints {
            joints[joint] += displacements[i];
        }
        Ok(())
    }

    /// Equation: robot.crank_ratios
    /// `q_j' = dq_j/dphase phase', crank bears sum_j dq_j/dphase tau_j; J phase'' = tau_crank - that`
    /// Source: virtual work.
    /// Test: `the_crank_bears_its_joints`.
    ///
    /// Ratios dq_j/dphase of the joints to the crank, the displacements held: what one unit of the
    /// crank's rate turns or slides each joint, so that by virtual work the crank bears
    /// sum_j dq_j/dphase tau_j.
    pub(super) fn ratios<S: Scalar + Meets<P>>(
        &self,
        phase: S,
        displacements: &[Jet<S>],
        ratios: &mut ArrayVec<S, MAX_LINKS>,
    ) -> Result<(), Fault> {
        let mut held = [Jet::ZERO; MAX_ELEMENTS];
        for (held, y) in held.iter_mut().zip(displacements) {
            held.x = y.x;
        }
        let mut turned = Joints::new();
        self.driven(Jet::new(phase, S::ONE, S::ZERO), &held, &mut turned)?;
        ratios.extend(turned.iter().map(|q| q.d));
        Ok(())
    }

    /// How far elements displace the rest of the spring of the coordinate `c`: a displacement, of any type.
    #[inline]
    pub(super) fn rest_displaced<T: Copy + Default + std::ops::AddAssign>(
        &self,
        c: usize,
        displacements: &[T],
    ) -> T {
        let mut sum = T::default();
        for (element, y) in self.elements.iter().zip(displacements) {
            if element.moves.contains(&Displaced::Rest(self.mechanism.coordinates[c])) {
                sum += *y;
            }
        }
        sum
    }

    /// Adds the crank to the coordinates, the last of them.
    pub(super) fn add_crank<S: Scalar + Meets<P>>(
        &self,
        links: &[LinkMotion<S>],
        ratios: &Ratios<S>,
        coordinates: &mut Coordinates<S>,
    ) {
        let crank = self.mechanism.coordinates.len();
        if !self.mechanism.pin_springs.is_empty() {
            coordinates.add_own(crank, ratios.crank_push, S::ZERO);
        }
        for (joint, drive) in self.mechanism.drives.iter().enumerate() {
            if drive.cranked() {
                coordinates.add_joint(crank, &self.mechanism.tree, joint, ratios.crank[joint], links);
            }
        }
    }
}

impl Robot {
    /// Power that the efforts of the joints take from drive and regulators, W, by virtual work:
    /// a joint's rate is dq/dphase phase' by the drive and, the phase held, that of its displacements by
    /// the regulators; what they give to springs on pins is told.
    ///
    /// Equation: robot.power_split
    /// `sum_j tau_j q_j' = sum_j tau_j dq_j/dphase phase' + sum_j tau_j (q_j' at phase held)`
    /// Source: virtual work.
    /// Test: `drive_and_regulators_share_the_power_of_the_joints`.
    pub(super) fn power_split(
        &self,
        phase: Jet,
        structure: &[f64],
        displacements: &[Jet; MAX_ELEMENTS],
        torques: &[f64],
        [of_drive, of_regulators]: [f64; 2],
    ) -> Result<[f64; 2], Fault> {
        let (mut ratios, mut displaced) = (ArrayVec::new(), Joints::new());
        self.ratios(phase.x, displacements, &mut ratios)?;
        self.driven(Jet::new(phase.x, 0.0, 0.0), displacements, &mut displaced)?;
        let drive: f64 = torques.iter().zip(&ratios).map(|(torque, ratio)| torque * ratio).sum();
        let regulators: f64 = torques.iter().zip(&displaced).map(|(torque, q)| torque * q.d).sum();
        Ok([
            drive * phase.d + of_drive,
            regulators + of_regulators + self.rest_power(structure, displacements),
        ])
    }

    /// Power that moves the rests of the springs, W: -k (q - rest) rest' of each.
    pub(super) fn rest_power(&self, structure: &[f64], displacements: &[Jet; MAX_ELEMENTS]) -> f64 {
        let states = &structure[2 * self.elements.len()..];
        let moved = |(c, spring): (usize, &Spring)| {
            let Jet { x, d, .. } = self.rest_displaced(c, displacements);
            -(states[c] - spring.numbers.rest - x) * spring.numbers.stiffness * d
        };
        self.mechanism.springs().enumerate().map(moved).sum()
    }

    /// What the motor does, the crank at `phase`, at a share of its supply voltage.
    pub(super) fn motor_work(&self, phase: Jet, supply: f64) -> Option<MotorWork> {
        self.motor.map(|motor| motor.work(phase.x, phase.d, supply))
    }

    /// Phase of the gait of the carried robot in the state `x`, and what the motor does where one turns the crank;
    /// `clock` as for [`Robot::carried`].
    pub fn carried_crank(&self, clock: &Jet, x: &[f64]) -> (f64, Option<MotorWork>) {
        let phase = self.crank(clock, x);
        (phase.x, self.motor_work(phase, clock.d))
    }
}

impl<P: Scalar> JointDrive<P> {
    /// Whether the crank turns the joint.
    #[inline]
    pub(super) fn cranked(&self) -> bool {
        matches!(self, Self::Series(..) | Self::Linkage(..))
    }
}

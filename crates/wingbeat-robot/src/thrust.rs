//! Thrusters: forces on the body that follow their commands.

use super::Robot;
use super::spec::ThrusterSpec;
use wingbeat_math::{Scalar, Vec3, Wrench};

/// Where a thruster pushes the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thruster {
    /// Number of the element that is its thrust, and of its command.
    pub element: usize,
    /// Place from the body's origin, in B, m.
    pub place: Vec3,
    /// Unit vector of the force, in B.
    pub direction: Vec3,
}

impl Thruster {
    /// Thrusters after `elements` of the structure.
    pub(super) fn all(specs: &[ThrusterSpec], elements: usize) -> Vec<Self> {
        let one = |(i, spec): (usize, &ThrusterSpec)| Self {
            element: elements + i,
            place: Vec3(spec.place_m),
            direction: Vec3(spec.direction).unit(),
        };
        specs.iter().enumerate().map(one).collect()
    }

    /// Wrench, N and N m in B, of `thrust` (N) about the body's origin.
    pub fn wrench<S: Scalar>(&self, thrust: S) -> Wrench<S> {
        Wrench::at(Vec3::constant(self.place), Vec3::constant(self.direction) * thrust)
    }
}

impl<P: Scalar> Robot<P> {
    /// The thrusters.
    pub fn thrusters(&self) -> &[Thruster] {
        &self.thrusters
    }

    /// Wrench of the thrusters on the body, in B about its origin; `structure` holds the displacements of the elements.
    ///
    /// Equation: robot.thrust
    /// `F = sum T_i d_i, M = sum r_i x T_i d_i; T'' = (2/lag)^2 (u - T) - (4/lag) T'`
    /// Source: definition; mean delay `lag`.
    /// Test: `thrusters_push_the_body_and_lag_their_commands`.
    pub(super) fn thrust<S: Scalar>(&self, structure: &[S]) -> Wrench<S> {
        let each = self.thrusters.iter().map(|thruster| thruster.wrench(structure[thruster.element]));
        each.fold(Wrench::ZERO, |sum, wrench| sum + wrench)
    }
}

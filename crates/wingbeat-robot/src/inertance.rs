//! What lets a stiff structure keep to the steps of all the rest: an inertance between the joints that are on springs.

use super::mechanism::JointDrive;
use super::numbers::SpringNumbers;
use super::{Robot, Scalar};
use wingbeat_ocp::plant::{Fault, Plant};

/// Inertance between the joints on springs.
#[derive(Clone, Debug, Default)]
pub(super) struct Inertance {
    /// Its time, s.
    pub time: f64,
    /// Second rates of the joints by efforts along them, by rows, in SI units: the inverse of what inertia they have where the robot rests.
    compliance: Vec<f64>,
}

impl<P: Scalar> Robot<P> {
    /// Inertances between the joints on springs, kg m2 or kg, each with both of its joints: P C P, P = t (t k + c)/2 of each spring.
    pub(super) fn inertances(&self) -> impl Iterator<Item = ([usize; 2], P)> {
        let (Inertance { time, compliance }, count) = (&self.inertance, self.mechanism.coordinates.len());
        let springs = || self.mechanism.springs().map(|spring| spring.inertance(*time)).enumerate();
        let row = move |(i, own): (usize, P)| {
            springs().zip(&compliance[i * count..]).map(move |((j, other), by)| ([i, j], own * other * *by))
        };
        springs().filter(|_| !compliance.is_empty()).flat_map(row)
    }

    /// The time of its inertance, s: see [`with_inertance`](Robot::with_inertance).
    pub fn inertance_s(&self) -> f64 {
        self.inertance.time
    }
}

impl Robot {
    /// The same robot with an inertance between its joints on springs and about the hinges of its flaps: a resistance to second rates, as of
    /// inerters between the parts, of the time `time` s; 0 for none. Membranes are damped for at least that time.
    ///
    /// However stiff and damped the structure is, nothing of it is then faster than 1/t. What deflects slowly deflects as without, a vibration
    /// with the angular frequency w is slowed by the share (w t)^4/8, and momentum is kept.
    ///
    /// Equation: robot.inertance
    /// `B = P S^-1 P, P = t (t K + C)/2, S the inertia along the joints; (S + B) s^2 + C s + K = 0 gives s of at most the size 1/t`
    /// Source: own derivation: on an eigenvector of inertia 1, stiffness k and damping c the resistance is at least p^2, p = t (t k + c)/2, by
    /// Schwarz's inequality. In the place of mass scaling by the stiffness, t^2 K, whose share is (w t)^2/2 (Olovsson, Simonsson & Unosson
    /// 2005, Int. J. Numer. Meth. Engng 63).
    /// Test: `no_vibration_is_faster_than_its_inertance_lets_it`.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable at rest.
    pub fn with_inertance(mut self, time: f64) -> Result<Self, Fault> {
        self.inertance = Inertance::default();
        self.covering.aero.set_inertance(time);
        if time > 0.0 {
            self.inertance = Inertance { time, compliance: self.compliance()? };
        }
        Ok(self)
    }

    /// The state at the origin at rest, its joints where they start.
    pub fn still(&self) -> Vec<f64> {
        let mut x = vec![0.0; self.layout.len];
        x[self.layout.attitude] = 1.0;
        let coordinates = self.start_coordinates();
        x[self.layout.joints..][..coordinates.len()].copy_from_slice(&coordinates);
        x
    }

    /// Second rates of joints on springs by efforts along them where the robot rests, by rows: they are linear in the efforts.
    fn compliance(&self) -> Result<Vec<f64>, Fault> {
        let (x, u, count) = (self.still(), vec![0.0; self.inputs.len()], self.mechanism.coordinates.len());
        let first = self.layout.joints + self.degrees();
        let mut pushed = self.clone();
        let mut rates = |at: Option<usize>| {
            for (c, joint) in self.mechanism.coordinates.iter().enumerate() {
                if let JointDrive::Elastic(spring) = &mut pushed.mechanism.drives[*joint] {
                    let stiffness = if at == Some(c) { 1.0 } else { 0.0 };
                    spring.numbers =
                        SpringNumbers { stiffness, rest: spring.start + 1.0, ..SpringNumbers::default() };
                }
            }
            let mut dx = vec![0.0; x.len()];
            pushed.rates_in_numbers(0.0, &x, &u, &mut dx)?;
            Ok(dx[first..first + count].to_vec())
        };
        let free = rates(None)?;
        let columns = (0..count).map(|c| rates(Some(c))).collect::<Result<Vec<_>, Fault>>()?;
        Ok((0..count * count).map(|k| columns[k % count][k / count] - free[k / count]).collect())
    }

    /// Places in the state of what vibrates on springs: coordinates and rates of elastic and free joints, angles and momenta of flaps.
    pub fn elastic_states(&self) -> Vec<usize> {
        let (l, count, degrees) = (&self.layout, self.mechanism.coordinates.len(), self.degrees());
        let joints = [0, degrees].into_iter().flat_map(|first| l.joints + first..l.joints + first + count);
        let flaps = self.covering.aero.surfaces().iter().flat_map(|surface| {
            let own = surface.aero().flap().map_or(0..0, |model| model.swinging_states());
            let first = l.aero + surface.states().start;
            first + own.start..first + own.end
        });
        joints.chain(flaps).collect()
    }
}

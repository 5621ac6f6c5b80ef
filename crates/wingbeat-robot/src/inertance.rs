//! What lets a stiff structure keep to the steps of all the rest: an inertance between the joints that are on springs.

use super::mechanism::{JointDrive, Mechanism};
use super::numbers::SpringNumbers;
use super::{Robot, Scalar};
use wingbeat_math::linear::{lu_factor, lu_solve};
use wingbeat_ocp::plant::{Fault, Plant};

/// Inertance between the joints on springs.
#[derive(Clone, Debug)]
pub(super) struct Inertance<P: Scalar = f64> {
    /// Its time, s.
    pub time: f64,
    /// Second rates of the joints by efforts along them, by rows, in SI units: the inverse of what inertia they have where the robot rests.
    compliance: Vec<f64>,
    /// The inertances, by rows, kg m2 or kg; empty where there are none.
    matrix: Vec<P>,
}

impl<P: Scalar> Inertance<P> {
    /// None.
    pub fn none() -> Self {
        Self { time: 0.0, compliance: Vec::new(), matrix: Vec::new() }
    }

    /// The same for the springs of `mechanism`: B = P C (1 + P C)^-1 P, C the compliance.
    pub fn of<Q: Scalar>(&self, mechanism: &Mechanism<Q>) -> Inertance<Q> {
        let springs: Vec<Q> = mechanism.springs().map(|spring| spring.impulse(self.time)).collect();
        let (n, compliance) = (springs.len(), &self.compliance);
        let mut matrix = vec![Q::ZERO; compliance.len()];
        if !compliance.is_empty() {
            let pushed = |i: usize, j: usize| springs[i] * compliance[i * n + j];
            let one = |i: usize, j: usize| if i == j { Q::ONE } else { Q::ZERO };
            let mut whole: Vec<Q> = (0..n * n).map(|k| pushed(k / n, k % n) + one(k / n, k % n)).collect();
            let mut solved: Vec<Q> = (0..n * n).map(|k| one(k / n, k % n) * springs[k / n]).collect();
            let mut pivots = vec![0; n];
            if lu_factor(&mut whole, n, &mut pivots) {
                lu_solve(&whole, n, &pivots, &mut solved, n);
                let entry = |i: usize, j: usize| {
                    (0..n).fold(Q::ZERO, |sum, l| sum + pushed(i, l) * solved[l * n + j])
                };
                matrix = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            }
        }
        Inertance { time: self.time, compliance: compliance.clone(), matrix }
    }
}

impl<P: Scalar> Robot<P> {
    /// Inertances between the joints on springs, kg m2 or kg, each with both of its joints.
    pub(super) fn inertances(&self) -> impl Iterator<Item = ([usize; 2], P)> {
        let count = self.mechanism.coordinates.len();
        self.inertance.matrix.iter().enumerate().map(move |(k, of)| ([k / count, k % count], *of))
    }

    /// The time of its inertance, s: see [`set_inertance`](Robot::set_inertance).
    pub fn inertance_s(&self) -> f64 {
        self.inertance.time
    }
}

impl Robot {
    /// Gives it an inertance between its joints on springs and about the hinges of its flaps: a resistance to second rates, as of inerters
    /// between the parts, of the time `time` s; 0 for none.
    ///
    /// However stiff and damped the structure is, nothing of it is then faster than 1/t. A vibration with the angular frequency w is slowed by
    /// the share (w t)^4/2 where that is small; motion with the angular frequency W errs by the share (W t)^2 where springs are stiff, and by W t
    /// where dampers are. Statics and momentum are as without.
    ///
    /// Equation: robot.inertance
    /// `B = P (S + P)^-1 P, P = t (t K + C), S the inertia along the joints; (S + B) s^2 + C s + K = 0 gives s of at most the size 1/t`
    /// Source: own derivation: on an eigenvector of inertia 1, stiffness k and damping c the resistance is at least p^2/(1 + p), p = t (t k + c),
    /// by Schwarz's inequality. For stiff springs it is mass scaling by the stiffness, t^2 K, which slows slow vibrations by (w t)^2/2 (Olovsson,
    /// Simonsson & Unosson 2005, Int. J. Numer. Meth. Engng 63).
    /// Test: `no_vibration_is_faster_than_its_inertance_lets_it`.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable at rest; the robot is then as it was.
    pub fn set_inertance(&mut self, time: f64) -> Result<(), Fault> {
        let before = (self.inertance.clone(), self.inertance.time);
        self.inertance = Inertance::none();
        self.covering.aero.set_inertance(time);
        let compliance = if time > 0.0 { self.compliance() } else { Ok(Vec::new()) };
        match compliance {
            Ok(compliance) => {
                self.inertance.time = time;
                self.inertance.compliance = compliance;
                self.inertance = self.inertance.of(&self.mechanism);
                Ok(())
            }
            Err(fault) => {
                self.covering.aero.set_inertance(before.1);
                self.inertance = before.0;
                Err(fault)
            }
        }
    }

    /// The state at the origin at rest, in the units of its channels, its joints where they start.
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

//! Structure elements that the wings push back: paper eq. (6) with loads.

use super::drive::Ratios;
use super::joints::{Displaced, Placed};
use super::mechanism::{JointDrive, Mechanism};
use super::spec::RobotSpec;
use super::{Joints, MAX_ELEMENTS, Robot};
use crate::body::{Coordinates, LinkMotion, MAX_LINKS};
use wingbeat_math::range::Range;
use wingbeat_math::{DeclaredQuantity, Error, Jet, Meets, Scalar};
use wingbeat_ocp::plant::{Fault, MAX_COORDINATES};

/// Inertia of an element as its joints or its length meet it.
pub(super) const INERTIA: DeclaredQuantity = DeclaredQuantity::within("kg m2", Range::POSITIVE, 0.0, 1e6);

/// An element that bears what its joints bear.
#[derive(Clone, Debug)]
pub(super) struct Loaded<P = f64> {
    /// Number of the element.
    pub element: usize,
    /// The joints that it moves.
    joints: Vec<usize>,
    /// kg m2 of an angle, kg of a length.
    pub inertia: P,
}

impl Loaded {
    /// Those of the structure that have an inertia.
    ///
    /// # Errors
    /// [`Error::Invalid`] where one moves neither joints nor lengths, or there are more than the dynamics hold.
    pub fn all(spec: &RobotSpec, elements: &[Placed], mechanism: &Mechanism) -> Result<Vec<Self>, Error> {
        let mut all = Vec::new();
        for (element, of) in spec.structure.elements.iter().enumerate() {
            let Some(inertia) = of.inertia else { continue };
            let key = || format!("structure.elements[{element}].inertia");
            let mut joints = Vec::new();
            for moved in &elements[element].moves {
                match *moved {
                    Displaced::Joint(joint) | Displaced::Scale(joint) => joints.push(joint),
                    Displaced::Length(wing, _) => {
                        let of_wing = |drive: &JointDrive| matches!(drive, JointDrive::Linkage(side, _) if *side == wing);
                        let drives = mechanism.drives.iter().enumerate();
                        joints.extend(drives.filter(|(_, drive)| of_wing(drive)).map(|(joint, _)| joint));
                    }
                    Displaced::Rest(_) | Displaced::Crank | Displaced::Thrust(_) => {
                        let allowed = "only with driven joints or link lengths, which bear the wings";
                        return Err(Error::invalid(key(), inertia, allowed));
                    }
                }
            }
            joints.sort_unstable();
            joints.dedup();
            all.push(Self { element, joints, inertia });
        }
        let cranked = mechanism.drives.iter().filter(|drive| drive.cranked()).count();
        let shares: usize = all.iter().map(|loaded| loaded.joints.len()).sum();
        let coordinates = mechanism.coordinates.len();
        let many = !all.is_empty() && coordinates + 1 + all.len() > MAX_COORDINATES;
        if many || coordinates + cranked + shares > MAX_LINKS {
            let most = MAX_COORDINATES - 1;
            let allowed =
                format!("at most {most} elements with an inertia and elastic or free joints together");
            return Err(Error::invalid("structure.elements", format!("{} of them", all.len()), allowed));
        }
        Ok(all)
    }
}

impl<P: Copy> Loaded<P> {
    /// The same with another inertia.
    pub fn with<Q>(&self, inertia: Q) -> Loaded<Q> {
        Loaded { element: self.element, joints: self.joints.clone(), inertia }
    }
}

impl<P: Scalar> Robot<P> {
    /// Takes the accelerations that elements with an inertia would have by themselves out of the `displacements`, and notes what pushes
    /// them so: the efforts of their actuators.
    #[inline]
    pub(super) fn press<S: Scalar + Meets<P>>(
        &self,
        displacements: &mut [Jet<S>; MAX_ELEMENTS],
        ratios: &mut Ratios<S>,
    ) {
        for loaded in &self.loaded {
            let own = std::mem::replace(&mut displacements[loaded.element].dd, S::ZERO);
            ratios.pushes.push(own * loaded.inertia);
        }
    }

    /// Ratios dq_j/dy of the joints to elements with an inertia, the phase `phase` and the other elements held.
    ///
    /// Equation: robot.loaded_element
    /// `m y'' = m (K (P omega - y) - C y') + sum_j dq_j/dy tau_j, tau_j what joint j bears of air, weight and inertia`
    /// Source: paper eq. (mimic_dynamics) with loads by virtual work; without m the elements follow as if it were endless.
    /// Test: `an_element_with_an_inertia_swings_as_its_actuator_and_link_do`.
    #[inline]
    pub(super) fn loaded_ratios<S: Scalar + Meets<P>>(
        &self,
        phase: S,
        displacements: &[Jet<S>],
        ratios: &mut Ratios<S>,
    ) -> Result<(), Fault> {
        for loaded in &self.loaded {
            let mut moved = [Jet::ZERO; MAX_ELEMENTS];
            for (moved, y) in moved.iter_mut().zip(displacements) {
                moved.x = y.x;
            }
            moved[loaded.element].d = S::ONE;
            let mut turned = Joints::new();
            self.driven(Jet::new(phase, S::ZERO, S::ZERO), &moved, &mut turned)?;
            ratios.loaded.extend(loaded.joints.iter().map(|joint| turned[*joint].d));
        }
        Ok(())
    }

    /// Adds the elements with an inertia to the coordinates, behind joints and crank.
    #[inline]
    pub(super) fn add_loaded<S: Scalar + Meets<P>>(
        &self,
        links: &[LinkMotion<S>],
        ratios: &Ratios<S>,
        coordinates: &mut Coordinates<S>,
    ) {
        let mut given = ratios.loaded.iter();
        for (k, (loaded, push)) in self.loaded.iter().zip(&ratios.pushes).enumerate() {
            let coordinate = self.degrees() + k;
            coordinates.add_own(coordinate, *push, S::from(loaded.inertia));
            for (&joint, ratio) in loaded.joints.iter().zip(given.by_ref()) {
                coordinates.add_joint(coordinate, &self.mechanism.tree, joint, *ratio, links);
            }
        }
    }

    /// Gives the joints of elements with an inertia the second rates found, of all coordinates.
    pub(super) fn let_loaded_go<S: Scalar>(
        &self,
        joints: &mut Joints<S>,
        ratios: &Ratios<S>,
        second_rates: &[S],
    ) {
        let mut given = ratios.loaded.iter();
        for (loaded, rate) in self.loaded.iter().zip(&second_rates[self.degrees()..]) {
            for (&joint, ratio) in loaded.joints.iter().zip(given.by_ref()) {
                joints[joint].dd += *ratio * *rate;
            }
        }
    }
}

//! The robot as a drawing needs it: links, joints, centres of mass and outlines at one instant.

use super::Robot;
use super::dynamics::Evaluation;
use super::observe::Observation;
use super::placement::PanelMeeting;
use super::sections::SurfaceSection;
use super::stance::lines_apart;
use crate::body::{JointKind, LinkMotion};
use wingbeat_aero::{Loads, Surface, flap_hinge, flap_points, membrane_points};
use wingbeat_math::{Mat3, Vec3};
use wingbeat_ocp::plant::Fault;

/// One link in B.
#[derive(Clone, Debug)]
pub struct LinkPlace {
    /// Its name, that of its joint.
    pub name: String,
    /// The link that carries it; none for the body.
    pub parent: Option<usize>,
    /// Whether its joint turns or slides.
    pub kind: JointKind,
    /// Origin of the link: its joint, m.
    pub origin: Vec3,
    /// R_BL.
    pub rotation: Mat3,
    /// Axis of the joint, a unit vector.
    pub axis: Vec3,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub com: Vec3,
}

/// A surface at its stations, from left tip to right tip.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Name.
    pub name: String,
    /// Leading and trailing edge, from the body origin, m.
    pub ribs: Vec<[Vec3; 2]>,
    /// Whether there is surface between one rib and the next.
    pub covered: Vec<bool>,
    /// Of a membrane or a flap the points of each rib at [`MEMBRANE_DRAWN`](wingbeat_aero::MEMBRANE_DRAWN), likewise; none of a rigid surface.
    pub raised: Vec<[Vec3; 3]>,
    /// Which of these points is the hinge of a flap.
    pub hinge: Option<usize>,
}

/// The robot at one instant, in B.
#[derive(Clone, Debug)]
pub struct Skeleton {
    /// Links in the order of the tree.
    pub links: Vec<LinkPlace>,
    /// Mass of the body, kg, and its centre, m.
    pub body: (f64, Vec3),
    /// Centre of mass of all, m.
    pub center_of_mass: Vec3,
    /// The surfaces.
    pub outlines: Vec<Outline>,
}

impl Robot {
    /// `skeleton` with a gap on each hinge on which the chord lines of the panels that meet lie further apart than the share `least` of
    /// them; surfaces that bend stay as they are.
    #[must_use]
    pub fn parted(&self, mut skeleton: Skeleton, least: f64) -> Skeleton {
        let Skeleton { links, outlines, .. } = &mut skeleton;
        for (outline, laid) in
            outlines.iter_mut().zip(&self.covering.laid).filter(|(o, _)| o.raised.is_empty())
        {
            let mut arcs = laid.stations.clone();
            for PanelMeeting { at, left, lines } in laid.placement.meetings() {
                let ribs = lines.map(|(link, ends)| match link.map(|i| &links[i]) {
                    Some(link) => ends.map(|end| link.origin + link.rotation * end),
                    None => ends,
                });
                let Some(i) = arcs.iter().position(|arc| *arc == at).filter(|_| lines_apart(ribs) > least)
                else {
                    continue;
                };
                // From left to right the outer one comes first on the left.
                let [inner, outer] = ribs;
                let pair = if left { [outer, inner] } else { [inner, outer] };
                arcs.insert(i, at);
                outline.ribs.splice(i..=i, pair);
                outline.covered.insert(i, false);
            }
        }
        skeleton
    }

    /// The robot at (t, x, u).
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn skeleton(&self, t: f64, x: &[f64], u: &[f64]) -> Result<Skeleton, Fault> {
        let (mut dx, mut e) = (vec![0.0; x.len()], Evaluation::empty());
        self.evaluate(t, x, u, &[], &mut dx, &mut e)?;
        Ok(self.drawn(x, &e.base, &e.links))
    }

    /// As [`observe`](Self::observe), with the robot as a drawing needs it by the same evaluation. The observation takes `strips`, those of
    /// one before or [`Loads::boxed`], and writes over them.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn observe_drawn(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        strips: Box<Loads<f64>>,
    ) -> Result<(Skeleton, Observation), Fault> {
        let draw = |base: &LinkMotion, links: &[LinkMotion]| self.drawn(x, base, links);
        self.look((t, x, u), &[], strips, draw)
    }

    /// The robot in the state `x` with body and links where they are.
    fn drawn(&self, x: &[f64], base: &LinkMotion, links: &[LinkMotion]) -> Skeleton {
        let tree = &self.mechanism.tree;
        let numbers = tree.numbers();
        let place = |i: usize| {
            let (motion, body) = (&links[i], &numbers[i + 1]);
            LinkPlace {
                name: tree.name(i).into(),
                parent: tree.parent(i),
                kind: tree.kind(i),
                origin: motion.position,
                rotation: motion.rotation,
                axis: tree.axis(i, motion),
                mass: body.mass,
                com: motion.point(body.com),
            }
        };
        let edges = |s: &SurfaceSection| s.edges(s.link.map_or(base, |i| &links[i]));
        let outline = |(k, laid): (usize, &super::surface::Laid)| {
            let mut ribs: Vec<[Vec3; 2]> = laid.ribs.iter().map(edges).collect();
            // In a vacuum there is none.
            let raised = self.covering.aero.surfaces().get(k).map_or_else(Vec::new, |surface: &Surface| {
                let states = &x[self.layout.aero..][surface.states()];
                let aero = surface.aero();
                if let Some(flap) = aero.flap() {
                    return flap_points(&mut ribs, &laid.stations, aero, flap.flaps_of(states));
                }
                let heights = aero.membrane().map(|membrane| membrane.camber_of(states));
                heights.map_or_else(Vec::new, |heights| membrane_points(&ribs, &laid.stations, aero, heights))
            });
            let hinge = self.covering.aero.surfaces().get(k).and_then(|surface| flap_hinge(surface.aero()));
            Outline { name: laid.name.clone(), ribs, covered: laid.covered.clone(), raised, hinge }
        };
        Skeleton {
            links: (0..tree.links()).map(place).collect(),
            body: (numbers[0].mass, numbers[0].com),
            center_of_mass: tree.center_of_mass(links),
            outlines: self.covering.laid.iter().enumerate().map(outline).collect(),
        }
    }

    /// The robot with its body at rest, `t` s after the start of its gait, regulators at rest.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn at_rest(&self, t: f64) -> Result<Skeleton, Fault> {
        let mut x = vec![0.0; self.layout.len];
        x[self.layout.attitude] = 1.0;
        let coordinates = self.start_coordinates();
        x[self.layout.joints..][..coordinates.len()].copy_from_slice(&coordinates);
        self.skeleton(t, &x, &vec![0.0; self.inputs.len()])
    }
}

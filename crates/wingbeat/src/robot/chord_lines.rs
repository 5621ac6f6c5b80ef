//! Chord lines of a robot's surfaces in W, wherever along the span they are asked for.

use super::drive::Ratios;
use super::sections::{Carriers, Riding, Section};
use super::{Joints, Links, Robot};
use crate::aero::{SectionMotion, Sections};
use crate::body::{Coordinates, LinkMotion};
use crate::math::{Jet, Quat, Vec3};
use crate::plant::Fault;

impl Robot {
    /// Places and velocities of the chord lines of the surface number `surface` at the arc coordinates `arcs` (m, left positive) in
    /// the state `x` at `t` s, in W, in place of what `out` holds; the rest of a section's motion is left zero. A chord line on a hinge
    /// belongs to the inner link.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    ///
    /// # Panics
    /// When there is no such surface.
    pub fn chord_lines(
        &self,
        t: f64,
        x: &[f64],
        surface: usize,
        arcs: &[f64],
        out: &mut Vec<SectionMotion<f64>>,
    ) -> Result<(), Fault> {
        let l = &self.layout;
        let attitude = Quat::from_wxyz(&x[l.attitude..]).matrix();
        let velocity = attitude.transpose_mul(Vec3::from_slice(&x[l.velocity..]));
        let rate = Vec3::from_slice(&x[l.rate..]);
        let structure = &x[l.structure..];
        let inputs = vec![0.0; self.inputs.len()];
        let mut rates = vec![0.0; l.joints - l.structure];
        let (mut joints, mut ratios) = (Joints::new(), Ratios::new());
        self.joints(&Jet::new(t, 1.0, 0.0), structure, &inputs, &mut rates, &mut joints, &mut ratios)?;
        let mut links = Links::new();
        self.links(&joints, velocity, rate, &mut links);
        let base = LinkMotion::base(velocity, rate);
        let still = Coordinates::none();
        let mut carriers = Carriers::none(&still);
        carriers.follow(&base, &self.carriers, &links, Vec3::ZERO);
        let placement = &self.covering.laid[surface].placement;
        let sections: Vec<Section> = arcs.iter().map(|s| placement.section(*s, &self.carriers)).collect();
        let riding = Riding { sections: &sections, carriers: &carriers };
        let origin = Vec3::from_slice(&x[l.position..]);
        out.clear();
        out.extend((0..sections.len()).map(|i| {
            let section = riding.section(i);
            SectionMotion {
                le: origin + attitude * section.le,
                te: origin + attitude * section.te,
                v_le: attitude * section.v_le,
                v_te: attitude * section.v_te,
                ..SectionMotion::default()
            }
        }));
        Ok(())
    }
}

//! Chord lines of a robot's surfaces in W, wherever along the span they are asked for.

use super::{Robot, Stance};
use wingbeat_aero::SectionMotion;
use wingbeat_ocp::plant::Fault;

impl Robot {
    /// Places and velocities of the chord lines of the surface number `surface` at the arc coordinates `arcs` (m, left positive) of
    /// a robot as it is `at`, in W, in place of what `out` holds; accelerations are left zero. A chord line on a
    /// hinge belongs to the inner link.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    ///
    /// # Panics
    /// When there is no such surface.
    pub fn chord_lines(
        &self,
        at: &Stance,
        surface: usize,
        arcs: &[f64],
        out: &mut Vec<SectionMotion<f64>>,
    ) -> Result<(), Fault> {
        let (origin, attitude) = (at.origin, at.attitude);
        self.riding_at(at, surface, arcs, |riding| {
            out.clear();
            out.extend((0..arcs.len()).map(|i| {
                let section = riding.at(i);
                SectionMotion {
                    le: origin + attitude * section.le,
                    te: origin + attitude * section.te,
                    v_le: attitude * section.v_le,
                    v_te: attitude * section.v_te,
                    span: attitude * section.span,
                    w: attitude * section.w,
                    ..SectionMotion::default()
                }
            }));
        })
    }
}

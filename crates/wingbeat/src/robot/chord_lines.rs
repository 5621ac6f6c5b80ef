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
        let mut carriers = Carriers::new(&base, Vec3::ZERO, &still);
        carriers.follow(&self.carriers, &links, Vec3::ZERO);
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

#[cfg(test)]
mod tests {
    use crate::math::Vec3;
    use crate::plant::Plant;
    use crate::scenario::Scenario;

    #[test]
    fn chord_lines_are_those_of_the_outline_and_move_as_they_say() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
        let scenario = Scenario::load(path.as_ref(), &["start.yaw_deg=20.0".into()]).unwrap();
        let (robot, mut x) = (scenario.robot(), scenario.start());
        let u = vec![0.0; robot.inputs().len()];
        x[robot.layout().structure..robot.layout().aero].iter_mut().enumerate().for_each(|(i, y)| {
            *y = 0.02 * (i as f64 - 3.0);
        });
        let t = 0.07;
        let seen = robot.observe(t, &x, &u).unwrap();
        let outlines = scenario.spec.robot.outlines().unwrap();
        let planform = &outlines[0].planform;
        let tip = planform.half_span();
        let arcs = [tip, 0.5 * tip, 0.3 * tip, -0.7 * tip, -tip];
        let mut lines = Vec::new();
        robot.chord_lines(t, &x, 0, &arcs, &mut lines).unwrap();
        let place = Vec3::from_slice(&x[robot.layout().position..]);
        for (line, end) in [(&lines[0], &seen.outlines[0][0]), (&lines[4], seen.outlines[0].last().unwrap())]
        {
            assert!((line.le - (place + seen.attitude * end[1])).norm() < 1e-14);
            assert!((line.te - (place + seen.attitude * end[2])).norm() < 1e-14);
        }
        // The velocities are those that the rates of the states give.
        let mut dx = vec![0.0; x.len()];
        robot.rates(t, &x, &u, &mut dx).unwrap();
        let h = 1e-5;
        let moved = |h: f64| {
            let x: Vec<f64> = x.iter().zip(&dx).map(|(x, dx)| x + h * dx).collect();
            let mut lines = Vec::new();
            robot.chord_lines(t + h, &x, 0, &arcs, &mut lines).unwrap();
            lines
        };
        for (line, (after, before)) in lines.iter().zip(moved(h).iter().zip(&moved(-h))) {
            let by_difference = (after.te - before.te) * (0.5 / h);
            assert!(
                (line.v_te - by_difference).norm() < 1e-5 * line.v_te.norm(),
                "{line:?} {by_difference:?}"
            );
        }
    }
}

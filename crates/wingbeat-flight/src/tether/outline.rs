//! The wing as a drawing needs it.

use super::{Bent, Tether};
use wingbeat_aero::{flap_hinge, flap_points, membrane_points};
use wingbeat_math::{Jet, Vec3, Wrench};
use wingbeat_robot::Outline;

/// What has bent a wing at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shape<'a> {
    /// Coordinates of its spar, in the units of its strains; nothing of a rigid wing, and of one that is not bent.
    pub spar: &'a [f64],
    /// Heights of its membrane over the chord, strip by strip; nothing of a rigid one.
    pub heights: [&'a [f64]; 2],
    /// Angles of its flap, strip by strip, rad; nothing without one.
    pub flaps: &'a [f64],
}

impl Tether {
    /// Arcs from the left tip to the right at which the wing is drawn, m: `ribs` equal steps a half, or the edges of the strips of a wing
    /// with a spar, which tells its place there.
    pub fn drawn_arcs(&self, ribs: usize) -> Vec<f64> {
        let span = self.wing.planform().half_span();
        let Some(spar) = &self.spar else {
            return (0..=2 * ribs).map(|k| span * (1.0 - k as f64 / ribs as f64)).collect();
        };
        let edges = self.aero.arcs().iter().map(|arc| arc.abs());
        let mut half: Vec<f64> = edges.chain([0.0, spar.root_m, span]).filter(|arc| *arc <= span).collect();
        wingbeat_math::order::descend(&mut half);
        half.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * span);
        let right: Vec<f64> = half.iter().rev().skip(1).map(|arc| -arc).collect();
        half.into_iter().chain(right).collect()
    }

    /// The wing of that `shape` at the time `t`, in W, at the arcs `arcs` of [`drawn_arcs`](Self::drawn_arcs).
    pub fn outline(&self, t: f64, arcs: &[f64], shape: Shape) -> Outline {
        let (body, angles): (_, Vec<Jet<f64>>) = (self.motion.body(t).frame(), self.motion.angles(t));
        let still = vec![0.0; shape.spar.len()];
        let bent = Bent { q: [shape.spar.to_vec(), still.clone(), still], root: Wrench::ZERO };
        let bent = (!shape.spar.is_empty()).then_some(&bent);
        let sections = self.sections_at(arcs, &body, &angles, bent);
        let mut ribs: Vec<[Vec3; 2]> = sections.iter().map(|section| [section.le, section.te]).collect();
        let planform = self.wing.planform();
        let there = |arc: f64| planform.covers(arc) && (arc == 0.0 || self.side.holds(arc.signum()));
        let covered = arcs.windows(2).map(|pair| there(0.5 * (pair[0] + pair[1]))).collect();
        let raised = match shape.heights[0] {
            [] if shape.flaps.is_empty() => Vec::new(),
            [] => flap_points(&mut ribs, arcs, &self.aero, shape.flaps),
            _ => membrane_points(&ribs, arcs, &self.aero, shape.heights),
        };
        let hinge = flap_hinge(&self.aero).filter(|_| !raised.is_empty());
        Outline { name: "wing".into(), ribs, covered, raised, hinge }
    }
}

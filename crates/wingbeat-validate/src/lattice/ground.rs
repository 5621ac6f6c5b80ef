//! Wings over a ground.

use super::span::{HalfWingOutline, SPAN, elliptic, laid};
use super::wings::{CHORD, lan, rectangle};
use crate::Error;
use std::sync::Arc;
use wingbeat::aero::SectionMotion;
use wingbeat::math::Vec3;
use wingbeat::tether::Coordinate;
use wingbeat_lattice::{
    FlappingWing, Lattice, LatticeLoads, LatticeSettings, LatticeSurface, MovingSections, Scene, WakeMotion,
};

/// Lift and drag of the wake of a steady wing, N, in a wind of 1 m/s along the plane.
fn steady(wing: &FlappingWing) -> Result<[f64; 2], Error> {
    let settings =
        LatticeSettings { longest_distance_m: f64::INFINITY, ..LatticeSettings::new(1e4 * CHORD, 1e-3) };
    let mut lattice = Lattice::new(Scene::new(wing, lan(6, 24), true)?, settings)?;
    lattice.step()?;
    let force = lattice.step()?.joukowski.force;
    let far = lattice.wake_drag().ok_or_else(|| Error::NoAnswer("no wind".into()))?;
    Ok([force[2], far])
}

fn pitched(wing: FlappingWing, incidence: f64, height: Option<f64>) -> FlappingWing {
    let mut motion = wing.motion.clone();
    motion.nose_up = Coordinate::Constant(incidence);
    FlappingWing { motion, ground: height.map(|height| -height), ..wing }
}

/// Drag of the wake over the lift squared of an elliptic wing of AR 8, `height` spans high.
pub(crate) fn elliptic_over(height: Option<f64>) -> Result<f64, Error> {
    let outline: HalfWingOutline = elliptic;
    let [lift, drag] = steady(&pitched(laid(outline)?, 1e-3, height.map(|height| height * SPAN)))?;
    Ok(drag / (lift * lift))
}

/// Steady lift of a rectangle of AR 4, `height` chords high.
pub(crate) fn rectangle_over(incidence: f64, height: Option<f64>) -> Result<f64, Error> {
    Ok(steady(&pitched(rectangle(4.0)?, incidence, height))?[0])
}

/// Sections mirrored at a plane.
struct Mirrored {
    of: Arc<dyn MovingSections>,
    height: f64,
}

impl MovingSections for Mirrored {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        self.of.sections(t, arcs, out);
        let point = |p: Vec3| Vec3::new(p[0], p[1], 2.0 * self.height - p[2]);
        let along = |v: Vec3| Vec3::new(v[0], v[1], -v[2]);
        for s in out {
            (s.le, s.te, s.v_le, s.v_te) = (point(s.le), point(s.te), along(s.v_le), along(s.v_te));
        }
    }
}

/// Largest difference of a panel's force over a plane from that of a mirrored pair, over the largest, from a sudden start with a free wake.
pub(crate) fn rectangle_pair(height: f64) -> Result<f64, Error> {
    let settings =
        LatticeSettings { wake: WakeMotion::Free, ..LatticeSettings::new(0.25 * CHORD, 0.05 * CHORD) };
    let wing = |height| Ok::<_, Error>(Scene::new(&pitched(rectangle(4.0)?, 0.1, height), lan(4, 12), true)?);
    let mut pair = wing(None)?;
    let image = |surface: &LatticeSurface| LatticeSurface {
        layout: surface.layout.clone(),
        sections: Arc::new(Mirrored { of: surface.sections.clone(), height: -height }),
    };
    let images: Vec<LatticeSurface> = pair.surfaces.iter().map(image).collect();
    pair.surfaces.extend(images);
    let (mut over, mut pair) = (Lattice::new(wing(Some(height))?, settings)?, Lattice::new(pair, settings)?);
    let forces = |loads: &LatticeLoads| loads.panels[0].joukowski.clone();
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for _ in 0..16 {
        for (a, b) in forces(&over.step()?).iter().zip(&forces(&pair.step()?)) {
            (worst, largest) = (worst.max((*a - *b).norm()), largest.max(a.norm()));
        }
    }
    Ok(worst / largest)
}

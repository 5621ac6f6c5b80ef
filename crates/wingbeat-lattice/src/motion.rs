//! Wings that move as prescribed.

use crate::Error;
use crate::layout::{PanelLayout, Spacing};
use std::sync::Arc;
use wingbeat::aero::{Aero, ChordBend, SectionMotion};
use wingbeat::math::{Dual, Vec3};
use wingbeat::tether::{Coordinate, Motion, Side, Tether, Wing};

/// Where the sections of a wing are at any time, in W.
pub trait MovingSections: Send + Sync {
    /// Puts the motion of the sections at the arc coordinates `arcs` (m, left positive) at `t` s in place of what `out` holds.
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>);

    /// Puts how these sections are bent, with the rates (1/s and rad/s), in place of what `out` holds; nothing where they are straight. The sections then
    /// also have their spans and angular rates.
    fn bends(&self, _t: f64, _arcs: &[f64], out: &mut Vec<ChordBend<Dual<1>>>) {
        out.clear();
    }
}

/// A hinged wing in prescribed motion.
#[derive(Clone, Debug)]
struct Tethered {
    wing: Wing,
    motion: Motion,
}

impl MovingSections for Tethered {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let (body, angles) = (self.motion.body(t).frame(), self.motion.angles(t));
        out.clear();
        out.extend(arcs.iter().map(|arc| self.wing.section(*arc, &body, &angles)));
    }
}

/// A piece of wing with its panels.
#[derive(Clone)]
pub struct LatticeSurface {
    /// Its panels.
    pub layout: PanelLayout,
    /// Its motion.
    pub sections: Arc<dyn MovingSections>,
}

/// Surfaces in a wind.
#[derive(Clone)]
pub struct Scene {
    /// The pieces of wing.
    pub surfaces: Vec<LatticeSurface>,
    /// Velocity of the air in W, m/s.
    pub wind: Vec3,
    /// Density of the air, kg/m3.
    pub density_kg_m3: f64,
    /// True when the surfaces are the left half of what the plane y = 0 mirrors.
    pub symmetric: bool,
    /// Height of a plane that the air does not cross, m in W.
    pub ground: Option<f64>,
}

/// How fine panels are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panels {
    /// Along the chord.
    pub chordwise: usize,
    /// Strips along the whole span.
    pub spanwise: usize,
    /// How strips lie.
    pub spacing: Spacing,
}

/// A hinged wing in prescribed motion in a wind.
#[derive(Clone, Debug)]
pub struct FlappingWing {
    /// Its geometry.
    pub wing: Wing,
    /// Its motion, an angle for each hinge.
    pub motion: Motion,
    /// Velocity of the air in W, m/s.
    pub wind: Vec3,
    /// Density of the air, kg/m3.
    pub density_kg_m3: f64,
    /// Height of a plane that the air does not cross, m in W.
    pub ground: Option<f64>,
}

/// Refuses membranes and flaps, whose motion nobody gives.
pub(crate) fn require_rigid(aero: &Aero) -> Result<(), Error> {
    match (aero.membrane(), aero.flap()) {
        (Some(_), _) => Err(Error::Bent { key: "membrane" }),
        (_, Some(_)) => Err(Error::Bent { key: "flap" }),
        (None, None) => Ok(()),
    }
}

/// Refuses sections that lift at no incidence.
pub(crate) fn require_flat(aero: &Aero) -> Result<(), Error> {
    let zero_lift = match aero {
        Aero::LiftingLine(line) => line.settings().section.zero_lift_angle_rad,
        Aero::Strip(model) => model.settings().section.zero_lift_angle_rad,
    };
    match zero_lift {
        0.0 => Ok(()),
        _ => {
            let (key, value) = ("zero_lift_angle_deg", zero_lift.to_degrees());
            Err(Error::Setting { key, value, allowed: "0: the panels are flat".into() })
        }
    }
}

impl TryFrom<&Tether> for FlappingWing {
    type Error = Error;

    /// The wing, motion and wind of a case.
    ///
    /// # Errors
    /// A half of a wing; sections that lift at no incidence; a wing that bends.
    fn try_from(tether: &Tether) -> Result<Self, Error> {
        let half = |side| Err(Error::Half { side });
        match tether.side {
            Side::Both => {}
            Side::Left => return half("left"),
            Side::Right => return half("right"),
        }
        require_rigid(&tether.aero)?;
        require_flat(&tether.aero)?;
        if tether.spar.is_some() {
            return Err(Error::Bent { key: "spar" });
        }
        Ok(Self {
            wing: tether.wing.clone(),
            motion: tether.motion.clone(),
            wind: tether.wind,
            density_kg_m3: tether.reference.density_kg_m3,
            ground: tether.ground.as_ref().map(|plane| plane.height_m),
        })
    }
}

/// Instants at which the speed of trailing edges is looked at.
const LOOKS: usize = 64;

impl Scene {
    /// Rms speed of the trailing edges through the air over `duration` s, m/s.
    pub fn edge_speed(&self, duration: f64) -> f64 {
        let (mut sum, mut count, mut edges) = (0.0, 0.0, Vec::new());
        for k in 0..LOOKS {
            for surface in &self.surfaces {
                let t = duration * k as f64 / LOOKS as f64;
                surface.sections.sections(t, &surface.layout.arcs, &mut edges);
                sum += edges.iter().map(|edge| (edge.v_te - self.wind).norm_squared()).sum::<f64>();
                count += edges.len() as f64;
            }
        }
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// The wing whole, or its left half when wind and motion are symmetric and `halved` allows it.
    ///
    /// # Errors
    /// Panels that cannot be laid out.
    pub fn new(flapping: &FlappingWing, panels: Panels, halved: bool) -> Result<Self, Error> {
        let FlappingWing { wing, motion, wind, density_kg_m3, ground } = flapping;
        let symmetric = halved && panels.spanwise.is_multiple_of(2) && flapping.is_symmetric();
        let hinges = wing.hinges().iter().flat_map(|h| std::iter::once(h.arc_m).chain(h.to_arc_m));
        let inner = |arc: &f64| *arc < wing.planform().half_span();
        let mut arcs: Vec<f64> = hinges.filter(inner).chain(symmetric.then_some(0.0)).collect();
        wingbeat::math::order::ascend(&mut arcs);
        arcs.dedup();
        let Panels { chordwise, spanwise, spacing } = panels;
        let whole = PanelLayout::of(wing.planform(), &arcs, chordwise, spanwise, spacing)?;
        let left: Vec<PanelLayout> = whole.iter().filter_map(PanelLayout::left_half).collect();
        let strips = |layouts: &[PanelLayout]| layouts.iter().map(PanelLayout::strips).sum::<usize>();
        let symmetric = symmetric && 2 * strips(&left) == strips(&whole);
        let sections: Arc<dyn MovingSections> =
            Arc::new(Tethered { wing: wing.clone(), motion: motion.clone() });
        let surface = |layout| LatticeSurface { layout, sections: sections.clone() };
        let layouts = if symmetric { left } else { whole };
        let surfaces = layouts.into_iter().map(surface).collect();
        Ok(Self { surfaces, wind: *wind, density_kg_m3: *density_kg_m3, symmetric, ground: *ground })
    }
}

impl FlappingWing {
    /// Whether left and right move alike in a wind without side.
    fn is_symmetric(&self) -> bool {
        let level = matches!(self.motion.roll, Coordinate::Constant(roll) if roll == 0.0);
        level && self.wing.hinges().iter().all(|hinge| hinge.side == Side::Both) && self.wind[1] == 0.0
    }
}

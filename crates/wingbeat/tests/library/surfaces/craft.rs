//! Rigid surfaces placed in space.

use wingbeat::aero::{
    Aero, LagSet, LiftLaw, LiftingLine, LiftingLineSettings, Planform, PlanformStation, ProfileDrag,
    SectionMotion, SectionSettings, StripModel, StripSettings, Surfaces,
};
use wingbeat::math::{Scalar, Vec3};

const NO_DRAG: ProfileDrag = ProfileDrag { cd0: 0.0, cd90: 0.0 };

/// A rectangle, its leading edge on the line of arcs.
pub fn rectangle(span: f64, chord: f64) -> Planform {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -chord };
    Planform::new(&[station(0.0), station(0.5 * span)]).unwrap()
}

/// Preset `full` without profile drag in air of unit density.
pub fn full(planform: &Planform, strips: usize) -> Aero {
    full_with(planform, strips, LiftLaw::Linear, LagSet::Three)
}

/// The same with another law and set of lags.
pub fn full_with(planform: &Planform, strips: usize, law: LiftLaw, lags: LagSet) -> Aero {
    let settings = StripSettings {
        strips,
        lags,
        regularisation_m_s: 1e-6,
        section: SectionSettings { law, drag: NO_DRAG, density_kg_m3: 1.0, ..Default::default() },
        ..Default::default()
    };
    Aero::Strip(StripModel::new(planform, settings).unwrap())
}

/// Preset `paper` without profile drag.
pub fn paper(planform: &Planform, nodes: usize) -> Aero {
    let settings = LiftingLineSettings {
        nodes,
        section: SectionSettings { drag: NO_DRAG, density_kg_m3: 1.0, ..Default::default() },
        ..Default::default()
    };
    Aero::LiftingLine(LiftingLine::new(planform, settings).unwrap())
}

/// Where a flat surface lies and how it moves as one piece.
#[derive(Clone, Copy)]
pub struct Placed<S: Scalar> {
    /// Middle of the leading edge.
    pub at: Vec3<S>,
    /// Velocity and acceleration of the whole.
    pub velocity: Vec3<S>,
    pub acceleration: Vec3<S>,
    /// Nose-up pitch, rad.
    pub pitch: S,
}

impl<S: Scalar> Placed<S> {
    pub fn at(at: Vec3<S>) -> Self {
        Self { at, velocity: Vec3::ZERO, acceleration: Vec3::ZERO, pitch: S::ZERO }
    }

    pub fn lifted(of: &Placed<f64>) -> Self {
        let lifted = |v: Vec3<f64>| Vec3(v.0.map(S::from));
        Self {
            at: lifted(of.at),
            velocity: lifted(of.velocity),
            acceleration: lifted(of.acceleration),
            pitch: S::from(of.pitch),
        }
    }

    pub fn pitched(self, pitch: f64) -> Self {
        Self { pitch: S::from(pitch), ..self }
    }

    pub fn sections(&self, arcs: &[f64], planform: &Planform) -> Vec<SectionMotion<S>> {
        let (s, c) = self.pitch.sin_cos();
        let ahead = Vec3([c, S::ZERO, s]);
        let across = Vec3([S::ZERO, S::ONE, S::ZERO]);
        let section = |&arc: &f64| {
            let (leading, trailing) = planform.edges(arc);
            let point = |x: f64| self.at + ahead * S::from(x) + across * S::from(arc);
            SectionMotion {
                le: point(leading),
                te: point(trailing),
                v_le: self.velocity,
                v_te: self.velocity,
                a_le: self.acceleration,
                a_te: self.acceleration,
                span: -across,
                ..SectionMotion::default()
            }
        };
        arcs.iter().map(section).collect()
    }
}

/// Placed surfaces.
pub struct Craft {
    pub surfaces: Surfaces,
    pub outlines: Vec<Planform>,
    pub placed: Vec<Placed<f64>>,
}

impl Craft {
    pub fn new(parts: Vec<(&str, Aero, Planform, Placed<f64>)>) -> Self {
        let surfaces = parts.iter().map(|(name, aero, ..)| (name.to_string(), aero.clone()));
        Self {
            surfaces: Surfaces::new(surfaces).unwrap(),
            outlines: parts.iter().map(|part| part.2.clone()).collect(),
            placed: parts.iter().map(|part| part.3).collect(),
        }
    }

    /// Motions of the sections of all surfaces.
    pub fn sections<S: Scalar>(&self) -> Vec<SectionMotion<S>> {
        self.sections_of(&self.placed.iter().map(Placed::lifted).collect::<Vec<_>>())
    }

    /// The same, otherwise placed.
    pub fn sections_of<S: Scalar>(&self, placed: &[Placed<S>]) -> Vec<SectionMotion<S>> {
        let parts = self.surfaces.surfaces().iter().zip(&self.outlines).zip(placed);
        parts
            .flat_map(|((surface, outline), placed)| placed.sections(surface.aero().arcs(), outline))
            .collect()
    }
}

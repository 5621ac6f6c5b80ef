//! A folding wing in prescribed motion, twice differentiable in time.

use wingbeat::aero::{Planform, PlanformStation, SectionMotion};
use wingbeat::math::{Jet, Mat3, Scalar, Vec3};

/// Arc coordinate of the elbow, m.
pub const ELBOW: f64 = 0.11;

/// Coordinates of the motion.
#[derive(Clone, Copy)]
pub struct Wing<S: Scalar> {
    pub position: Vec3<Jet<S>>,
    /// Shoulder and elbow angle, tips up, and nose-down pitch, rad.
    pub shoulder: Jet<S>,
    pub elbow: Jet<S>,
    pub pitch: Jet<S>,
}

/// Tapered, swept half wing with its root on the plane of symmetry.
pub fn planform() -> Planform {
    let station =
        |arc_m, leading_edge_m, trailing_edge_m| PlanformStation { arc_m, leading_edge_m, trailing_edge_m };
    Planform::new(&[station(0.0, 0.03, -0.06), station(ELBOW, 0.035, -0.07), station(0.25, 0.0, -0.05)])
        .unwrap()
}

impl<S: Scalar> Wing<S> {
    pub fn still(shoulder: f64, elbow: f64) -> Self {
        Self { position: Vec3::ZERO, shoulder: shoulder.into(), elbow: elbow.into(), pitch: Jet::ZERO }
    }

    /// Every coordinate in harmonics of the phase.
    pub fn cyclic(phase: S, omega: f64) -> Self {
        let angle = Jet::new(phase, S::from(omega), S::ZERO);
        let wave = |amplitude: f64, harmonic: f64, lag: f64| (angle * harmonic + lag).sin() * amplitude;
        Self {
            position: Vec3::new(wave(0.02, 1.0, 0.3), Jet::ZERO, wave(0.03, 1.0, 2.0)),
            shoulder: wave(0.6, 1.0, 0.0),
            elbow: wave(0.5, 1.0, 1.9) - 0.6,
            pitch: wave(0.25, 1.0, 1.2) - 0.1,
        }
    }

    pub fn section(&self, arc: f64, planform: &Planform) -> SectionMotion<S> {
        let side = if arc == 0.0 { 0.0 } else { arc.signum() };
        let inner = arc.abs().min(ELBOW);
        let outer = arc.abs() - inner;
        let along = |angle: Jet<S>, length: f64| {
            let (s, c) = angle.sin_cos();
            Vec3([Jet::ZERO, c * (side * length), s * length])
        };
        let line = along(self.shoulder, inner) + along(self.shoulder + self.elbow, outer);
        let turn = Mat3::rotation_y(self.pitch);
        let at = |x: f64| self.position + turn * (Vec3([Jet::from(x), Jet::ZERO, Jet::ZERO]) + line);
        let (leading, trailing) = planform.edges(arc);
        let (le, te) = (at(leading), at(trailing));
        let part = |v: Vec3<Jet<S>>, f: fn(Jet<S>) -> S| Vec3(v.0.map(f));
        SectionMotion {
            le: part(le, |j| j.x),
            te: part(te, |j| j.x),
            v_le: part(le, |j| j.d),
            v_te: part(te, |j| j.d),
            a_le: part(le, |j| j.dd),
            a_te: part(te, |j| j.dd),
            ..SectionMotion::default()
        }
    }

    pub fn sections(&self, arcs: &[f64], planform: &Planform) -> Vec<SectionMotion<S>> {
        arcs.iter().map(|&s| self.section(s, planform)).collect()
    }
}

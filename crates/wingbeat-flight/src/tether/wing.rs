//! The geometry of a hinged wing in prescribed motion.

use wingbeat_aero::{Planform, SectionMotion};
use wingbeat_math::Error;
use wingbeat_math::{Jet, Mat3, Scalar, Vec3};
use wingbeat_structure::turning;

/// What a hinge turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HingeKind {
    /// About the chordwise axis, tip up: shoulder.
    Flap,
    /// About the chordwise axis, outer panel up: elbow.
    Fold,
    /// About the span, nose up.
    Twist,
    /// About the normal, tip forward.
    Sweep,
}

/// Which half of the wing.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Both, as mirror images.
    #[default]
    Both,
    /// The left one.
    Left,
    /// The right one.
    Right,
}

impl Side {
    /// True for a section whose arc (m) has the sign of `sign`.
    pub fn holds(self, sign: f64) -> bool {
        match self {
            Self::Both => true,
            Self::Left => sign > 0.0,
            Self::Right => sign < 0.0,
        }
    }
}

/// A hinge line across the wing; all that lies outboard turns with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hinge {
    /// What it turns.
    pub kind: HingeKind,
    /// Which half has it.
    pub side: Side,
    /// Arc at which it lies, m.
    pub arc_m: f64,
    /// For a twist that grows evenly from `arc_m` to here, m.
    pub to_arc_m: Option<f64>,
    /// Place of a twist or sweep axis ahead of the hinge line, m.
    pub ahead_m: f64,
}

/// Prescribed motion of the body on its tether, with rates.
#[derive(Clone, Copy, Debug)]
pub struct TetheredBody<S: Scalar> {
    /// Forward, m.
    pub surge: Jet<S>,
    /// Up, m.
    pub heave: Jet<S>,
    /// Nose up, rad.
    pub nose_up: Jet<S>,
    /// Right wing down, rad.
    pub roll: Jet<S>,
    /// Place of the pitch axis ahead of the hinge line, m.
    pub axis_ahead_m: f64,
}

impl<S: Scalar> TetheredBody<S> {
    /// At rest at the origin.
    pub fn rest() -> Self {
        let zero = Jet::ZERO;
        Self { surge: zero, heave: zero, nose_up: zero, roll: zero, axis_ahead_m: 0.0 }
    }

    /// R_WB and the place of the body origin in W.
    pub fn frame(&self) -> Frame<S> {
        let turn = Mat3::rotation_y(-self.nose_up) * Mat3::rotation_x(self.roll);
        let axis = ahead(self.axis_ahead_m);
        let origin = Vec3([self.surge, Jet::ZERO, self.heave]) + axis - turn * axis;
        Frame { turn, origin }
    }
}

fn ahead<S: Scalar>(x: f64) -> Vec3<Jet<S>> {
    Vec3([Jet::from(x), Jet::ZERO, Jet::ZERO])
}

/// A moving frame: rotation to W and origin in W.
#[derive(Clone, Copy, Debug)]
pub struct Frame<S: Scalar> {
    /// Rotation to W.
    pub turn: Mat3<Jet<S>>,
    /// Origin in W, m.
    pub origin: Vec3<Jet<S>>,
}

impl<S: Scalar> Frame<S> {
    /// The same at rest.
    #[must_use]
    pub fn still(&self) -> Self {
        let still = |j: Jet<S>| Jet::new(j.x, S::ZERO, S::ZERO);
        Self { turn: self.turn.each(still), origin: self.origin.each(still) }
    }
}

/// A planform with hinges.
#[derive(Clone, Debug)]
pub struct Wing {
    planform: Planform,
    hinges: Vec<Hinge>,
}

impl Wing {
    /// A wing with hinges from body to tip.
    ///
    /// # Errors
    /// [`Error::Invalid`] when hinges do not ascend along the half span.
    pub fn new(planform: Planform, hinges: Vec<Hinge>) -> Result<Self, Error> {
        let span = planform.half_span();
        let mut before = 0.0;
        for (i, hinge) in hinges.iter().enumerate() {
            if !(hinge.arc_m >= before && hinge.arc_m < span) {
                let allowed = format!("{before} (the hinge before) to less than {span} (the tip)");
                let error = Error::invalid(format!("hinges[{i}].arc_m"), hinge.arc_m, allowed);
                let others = i.checked_sub(1).map(|before| format!("hinges[{before}].arc_m"));
                return Err(error.against(others).against(["half_span"]));
            }
            before = hinge.arc_m;
            if let Some(to) = hinge.to_arc_m
                && !(hinge.kind == HingeKind::Twist && to > hinge.arc_m && to <= span)
            {
                let allowed = format!("only for a twist; more than arc_m, up to {span}");
                let error = Error::invalid(format!("hinges[{i}].to_arc_m"), to, allowed);
                return Err(error.against([format!("hinges[{i}].arc_m"), "half_span".into()]));
            }
        }
        Ok(Self { planform, hinges })
    }

    /// The flat outline.
    pub fn planform(&self) -> &Planform {
        &self.planform
    }
    /// The hinges, body to tip.
    pub fn hinges(&self) -> &[Hinge] {
        &self.hinges
    }

    /// Motion of the section at `arc` in W, about W's origin, for the body
    /// frame and the hinge angles (rad): each hinge turns what lies outboard
    /// of it; jets carry exact rates and accelerations. A section on a hinge belongs to the inner side, but the
    /// middle of the wing to halves that both twist there: they leave no other section between them.
    ///
    /// Equation: tether.section_motion
    /// `hinges turn what lies outboard of them; jets carry rates and accelerations`
    /// Source: rigid-body kinematics.
    /// Test: `rates_are_those_of_the_positions`.
    pub fn section<S: Scalar>(&self, arc: f64, body: &Frame<S>, angles: &[Jet<S>]) -> SectionMotion<S> {
        let (Frame { turn, origin }, twist) = self.link(arc, body, angles);
        let (_, chord) = turned(turn.column(2), turn.column(0), -twist);
        let (leading, trailing) = self.planform.edges(arc);
        let edges = [origin + chord.scaled(leading), origin + chord.scaled(trailing)];
        motion(turn, edges)
    }

    /// Frame of the link at `arc` with its origin on the hinge line there, and the twist (rad) of the section in it.
    pub(super) fn link<S: Scalar>(&self, arc: f64, body: &Frame<S>, angles: &[Jet<S>]) -> (Frame<S>, Jet<S>) {
        let side = if arc == 0.0 { 0.0 } else { arc.signum() };
        let Frame { turn, mut origin } = *body;
        let [mut forward, mut left, mut up] = [turn.column(0), turn.column(1), turn.column(2)];
        let (mut reached, mut twist) = (0.0, Jet::ZERO);
        let whole = |h: &Hinge| h.kind == HingeKind::Twist && h.side == Side::Both && h.arc_m == 0.0;
        let outboard =
            |h: &Hinge| (self.planform.beyond(arc.abs(), h.arc_m) && h.side.holds(side)) || whole(h);
        for (hinge, &angle) in self.hinges.iter().zip(angles).filter(|(h, _)| outboard(h)) {
            origin += left.scaled(side * (hinge.arc_m - reached));
            reached = hinge.arc_m;
            if let Some(to) = hinge.to_arc_m {
                twist += angle * ((arc.abs() - hinge.arc_m) / (to - hinge.arc_m)).min(1.0);
                continue;
            }
            let before = forward;
            match hinge.kind {
                HingeKind::Flap | HingeKind::Fold => (left, up) = turned(left, up, angle * side),
                HingeKind::Twist => (up, forward) = turned(up, forward, -angle),
                HingeKind::Sweep => (forward, left) = turned(forward, left, angle * -side),
            }
            if hinge.ahead_m != 0.0 && matches!(hinge.kind, HingeKind::Twist | HingeKind::Sweep) {
                origin += (before - forward).scaled(hinge.ahead_m);
            }
        }
        origin += left.scaled(side * (arc.abs() - reached));
        (Frame { turn: Mat3::from_columns(forward, left, up), origin }, twist)
    }
}

/// The directions `a` and `b`, at right angles, turned by `angle` from `a` to `b`.
#[inline]
fn turned<S: Scalar>(a: Vec3<Jet<S>>, b: Vec3<Jet<S>>, angle: Jet<S>) -> (Vec3<Jet<S>>, Vec3<Jet<S>>) {
    let (sin, cos) = angle.sin_cos();
    (a * cos + b * sin, b * cos - a * sin)
}

/// A section from its link's rotation and its edges.
#[inline]
pub(super) fn motion<S: Scalar>(
    turn: Mat3<Jet<S>>,
    [leading, trailing]: [Vec3<Jet<S>>; 2],
) -> SectionMotion<S> {
    let [w, alpha] = turning(&turn);
    SectionMotion {
        le: leading.each(|j| j.x),
        te: trailing.each(|j| j.x),
        v_le: leading.each(|j| j.d),
        v_te: trailing.each(|j| j.d),
        a_le: leading.each(|j| j.dd),
        a_te: trailing.each(|j| j.dd),
        span: -turn.column(1).each(|j| j.x),
        w,
        alpha,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_aero::PlanformStation;

    fn wing() -> Wing {
        let station = |arc_m, leading_edge_m, trailing_edge_m| PlanformStation {
            arc_m,
            leading_edge_m,
            trailing_edge_m,
        };
        let planform = Planform::new(&[station(0.0, 0.03, -0.08), station(0.2, 0.05, -0.02)]).unwrap();
        let hinge = |kind, arc_m, to_arc_m| Hinge { kind, side: Side::Both, arc_m, to_arc_m, ahead_m: 0.01 };
        let hinges = vec![
            hinge(HingeKind::Sweep, 0.02, None),
            hinge(HingeKind::Flap, 0.02, None),
            hinge(HingeKind::Twist, 0.02, Some(0.2)),
            hinge(HingeKind::Fold, 0.09, None),
            hinge(HingeKind::Twist, 0.12, None),
        ];
        Wing::new(planform, hinges).unwrap()
    }

    fn at(t: f64, arc: f64) -> SectionMotion<f64> {
        let wave = |n: f64, a: f64| (Jet::new(n * t + n, n, 0.0)).sin() * a;
        let body = TetheredBody {
            surge: wave(2.0, 0.1),
            heave: wave(3.0, 0.2),
            nose_up: wave(4.0, 0.3),
            roll: wave(5.0, 0.2),
            axis_ahead_m: 0.04,
        };
        let angles = [wave(3.0, 0.3), wave(5.0, 0.7), wave(7.0, 0.2), wave(6.0, 0.5), wave(4.0, 0.1)];
        wing().section(arc, &body.frame(), &angles)
    }

    #[test]
    fn rates_are_those_of_the_positions() {
        let h = 1e-5;
        for arc in [0.0, 0.01, 0.05, -0.05, 0.11, -0.19] {
            let [a, b, c] = [0.4 - h, 0.4, 0.4 + h].map(|t| at(t, arc));
            let difference = |p: Vec3, q: Vec3| (p - q) * (0.5 / h);
            assert!((difference(c.le, a.le) - b.v_le).norm() < 1e-7);
            assert!((difference(c.v_te, a.v_te) - b.a_te).norm() < 1e-6);
            assert!((difference(c.span, a.span) - b.w.cross(b.span)).norm() < 1e-7);
            assert!((difference(c.w, a.w) - b.alpha).norm() < 1e-6);
            assert!((b.te - b.le).dot(b.span).abs() < 1e-15 && (b.span.norm() - 1.0).abs() < 1e-14);
        }
    }

    /// Sweep, flap and twist at the root are stroke, deviation and rotation in a stroke plane that the body's pitch inclines: the span lies
    /// at azimuth and elevation, the chord turns out of the plane about it.
    #[test]
    fn sweep_flap_and_twist_at_the_root_are_the_angles_of_an_insect() {
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -0.01 };
        let planform = Planform::new(&[station(0.0), station(0.1)]).unwrap();
        let hinge = |kind| Hinge { kind, side: Side::Both, arc_m: 0.0, to_arc_m: None, ahead_m: 0.0 };
        let kinds = [HingeKind::Sweep, HingeKind::Flap, HingeKind::Twist];
        let wing = Wing::new(planform, kinds.map(hinge).to_vec()).unwrap();
        let ([stroke, deviation, rotation], inclined) = ([0.7_f64, -0.2, 2.1], 0.9_f64);
        let body = TetheredBody { nose_up: Jet::from(-inclined), ..TetheredBody::<f64>::rest() };
        let section = wing.section(0.08, &body.frame(), &[stroke, deviation, rotation].map(Jet::from));
        let ((sp, cp), (sd, cd), (sr, cr)) = (stroke.sin_cos(), deviation.sin_cos(), rotation.sin_cos());
        let in_plane = |[x, y, z]: [f64; 3]| {
            let (sin, cos) = inclined.sin_cos();
            Vec3::new(cos * x + sin * z, y, cos * z - sin * x)
        };
        let span = [cd * sp, cd * cp, sd];
        let ahead = [cp, -sp, 0.0];
        let normal = [-sd * sp, -sd * cp, cd];
        let chord = [0, 1, 2].map(|k| cr * ahead[k] + sr * normal[k]);
        assert!((section.le - in_plane(span) * 0.08).norm() < 1e-15);
        assert!((section.te - section.le + in_plane(chord) * 0.01).norm() < 1e-15);
    }

    #[test]
    fn positive_angles_mean_what_they_say() {
        let wing = wing();
        let flat = TetheredBody::<f64>::rest();
        let tip = |i: usize| {
            let mut angles = [Jet::ZERO; 5];
            angles[i] = Jet::from(0.1);
            let [l, r] = [0.19, -0.19].map(|arc| wing.section(arc, &flat.frame(), &angles));
            assert!((l.le[0] - r.le[0]).abs() < 1e-15 && (l.le[2] - r.le[2]).abs() < 1e-15);
            assert!((l.le[1] + r.le[1]).abs() < 1e-15);
            l
        };
        assert!(tip(0).le[0] > 0.05 && tip(1).le[2] > 0.01 && tip(3).le[2] > 0.005);
        for twist in [2, 4] {
            let section = tip(twist);
            assert!(section.le[2] > section.te[2]);
        }
        let up = TetheredBody { nose_up: Jet::from(0.1), ..flat };
        assert!(wing.section(0.0, &up.frame(), &[Jet::ZERO; 5]).le[2] > 0.0);
        let down = TetheredBody { roll: Jet::from(0.1), ..flat };
        assert!(wing.section(-0.1, &down.frame(), &[Jet::ZERO; 5]).le[2] < 0.0);
    }
}

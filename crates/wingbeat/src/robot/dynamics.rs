//! Equations of motion: joints follow gait and structure exactly, so each
//! evaluation is one 6x6 solve for the body's acceleration.

use super::sections::Riding;
use super::{JOINTS, MAX_ELEMENTS, Robot};
use crate::body::LinkMotion;
use crate::math::linear::solve_symmetric;
use crate::math::{GRAVITY, Jet, Mat3, Over, Quat, Scalar, Vec3, Wrench, lift};
use crate::plant::{Channel, Fault, Plant};

/// Everything one evaluation computes on the way to the rates; what the states of the air do
/// not enter is in `G`.
pub(super) struct Evaluation<G: Scalar, S: Over<G> = G> {
    /// R_WB.
    pub attitude: Mat3<G>,
    /// Joint angles, rates and accelerations.
    pub joints: [Jet<G>; JOINTS.len()],
    /// Links with the body's own acceleration left out.
    pub links: [LinkMotion<G>; JOINTS.len()],
    /// The body as a link.
    pub base: LinkMotion<G>,
    /// Acceleration of the body origin and angular acceleration, inertial, in B.
    pub acceleration: [S; 6],
}

impl Plant for Robot {
    fn states(&self) -> &[Channel] {
        &self.states
    }
    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }
    fn attitude(&self) -> Option<usize> {
        Some(self.layout.attitude)
    }
    fn late_states(&self) -> usize {
        self.layout.aero
    }
    fn rates<S: Scalar>(&self, t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        self.evaluate(t, x, u, dx).map(|_| ())
    }
    fn rates_by_late<S: Over<f64>>(
        &self,
        t: f64,
        early: &[f64],
        late: &[S],
        u: &[f64],
        dx: &mut [S],
    ) -> Result<(), Fault> {
        self.evaluate_parts(t, early, late, u, dx).map(|_| ())
    }
}

impl Robot {
    /// Rates and all that led to them.
    #[inline(always)]
    pub(super) fn evaluate<S: Scalar>(
        &self,
        t: S,
        x: &[S],
        u: &[S],
        dx: &mut [S],
    ) -> Result<Evaluation<S>, Fault> {
        let (early, air) = x.split_at(self.layout.aero);
        self.evaluate_parts(t, early, air, u, dx)
    }

    /// The same, given the states of body and structure and those of the air.
    #[inline(always)]
    fn evaluate_parts<G: Scalar, S: Over<G>>(
        &self,
        t: G,
        x: &[G],
        air: &[S],
        u: &[G],
        dx: &mut [S],
    ) -> Result<Evaluation<G, S>, Fault> {
        let l = &self.layout;
        let q = Quat::from_wxyz(&x[l.attitude..]);
        let attitude = q.matrix();
        let v_w = Vec3::from_slice(&x[l.velocity..]);
        let w = Vec3::from_slice(&x[l.rate..]);
        let v = attitude.transpose_mul(v_w);

        let joints = self.joints(t, &x[l.structure..], u, &mut dx[l.structure..l.aero])?;
        let mut links = [LinkMotion::default(); JOINTS.len()];
        self.tree.motions(&joints, v, w, &mut links);
        let base = LinkMotion::base(v, w);

        let (wind, wind_dot) = self.wind(t, attitude);
        let riding = Riding::new(&self.sections, &base, &links, wind_dot);
        let (air, added_mass) = self.aero.evaluate_sum(&riding, wind, air, &mut dx[l.aero..]);

        let (mut mass, bias) = self.tree.inertia_and_bias(w, &links);
        let gravity = self.tree.gravity(self.gravity(attitude), &links);
        let net = air + (gravity + self.body_drag(v - wind) + -bias).lifted();
        let mut rhs = [S::ZERO; 6];
        net.force.store(&mut rhs);
        net.moment.store(&mut rhs[3..]);
        for (row, added) in mass.iter_mut().zip(&added_mass) {
            for (m, a) in row.iter_mut().zip(added) {
                *m += *a;
            }
        }
        let acceleration = solve_symmetric(mass, rhs).ok_or(Fault::MassMatrix { time: t.value() })?;

        v_w.lifted().store(&mut dx[l.position..]);
        let mut turning = [G::ZERO; 4];
        q.rate(w).store_wxyz(&mut turning);
        lift(&turning, &mut dx[l.attitude..]);
        attitude.times(Vec3::from_slice(&acceleration)).store(&mut dx[l.velocity..]);
        Vec3::from_slice(&acceleration[3..]).store(&mut dx[l.rate..]);
        Ok(Evaluation { attitude, joints, links, base, acceleration })
    }

    /// Joint angles with rates and accelerations: gait plus structure response.
    /// `dx` receives the rates of the structure's states.
    fn joints<G: Scalar, S: Over<G>>(
        &self,
        t: G,
        structure: &[G],
        u: &[G],
        dx: &mut [S],
    ) -> Result<[Jet<G>; JOINTS.len()], Fault> {
        self.joints_on(&Jet::new(t, G::ONE, G::ZERO), structure, u, dx)
    }

    /// The same with a gait whose clock shows `clock` and may run up or stand still.
    pub(super) fn joints_on<G: Scalar, S: Over<G>>(
        &self,
        clock: &Jet<G>,
        structure: &[G],
        u: &[G],
        dx: &mut [S],
    ) -> Result<[Jet<G>; JOINTS.len()], Fault> {
        let mut displacements = [Jet::ZERO; MAX_ELEMENTS];
        self.response.displacements(structure, u, &mut displacements);
        self.response.rates(&displacements, dx);
        let phase = *clock * self.phase_rate + self.phase_start;
        let mut lengths = [[Jet::ZERO; 3]; 2];
        for (i, moves) in self.displaced.iter().enumerate() {
            for (wing, link) in moves.iter().filter_map(|d| d.link_length()) {
                lengths[wing][link] += displacements[i];
            }
        }
        let mut joints = [Jet::ZERO; JOINTS.len()];
        for wing in 0..2 {
            let angles = self.gait.angles(phase, &lengths[wing])?;
            joints[4 * wing + 1] = angles.shoulder;
            joints[4 * wing + 2] = angles.elbow;
        }
        for (i, moves) in self.displaced.iter().enumerate() {
            for joint in moves.iter().filter_map(|d| d.joint()) {
                joints[joint] += displacements[i];
            }
        }
        Ok(joints)
    }

    /// Velocity and acceleration of the air, resolved in B.
    pub(super) fn wind<S: Scalar>(&self, t: S, attitude: Mat3<S>) -> (Vec3<S>, Vec3<S>) {
        let (velocity, acceleration) = self.air.wind.at(t);
        (attitude.transpose_mul(velocity), attitude.transpose_mul(acceleration))
    }

    /// Gravity in B, m/s2.
    pub(super) fn gravity<S: Scalar>(&self, attitude: Mat3<S>) -> Vec3<S> {
        attitude.transpose_mul(Vec3::new(S::ZERO, S::ZERO, S::from(-GRAVITY)))
    }

    /// Drag of the body at its origin, F_i = -rho/2 A_i |v_i| v_i along each body
    /// axis; `v` is the velocity against the air, in B.
    pub(super) fn body_drag<S: Scalar>(&self, v: Vec3<S>) -> Wrench<S> {
        let mut drag = Wrench::ZERO;
        for i in 0..3 {
            let scale = -0.5 * self.air.density * self.drag_area[i];
            drag.force[i] = v[i] * v[i].smooth_abs(DRAG_WIDTH) * scale;
        }
        drag
    }
}

/// Speed below which the body's drag is rounded off, m/s.
const DRAG_WIDTH: f64 = 1e-3;

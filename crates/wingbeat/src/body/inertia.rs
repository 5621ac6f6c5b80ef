//! Mass, centre of mass and inertia of one rigid body.

use super::motion::LinkMotion;
use crate::Error;
use crate::math::{Mat3, Scalar, Vec3, Wrench};

/// Constant inertia of a rigid body, with its principal axes found once so that
/// turning it into other axes takes two outer products.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Inertia {
    pub(super) mass: f64,
    /// Centre of mass in link axes, m.
    pub(super) com: Vec3,
    /// Principal moments about the centre of mass, kg m2.
    moments: Vec3,
    /// Second and third principal axis in link axes.
    axes: [Vec3; 2],
}

impl Inertia {
    /// Checks and stores; `inertia` is about the centre of mass, in link axes.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the mass is negative or not finite, or the inertia is
    /// not symmetric, or its principal moments are negative or break the triangle inequality.
    pub(super) fn new(mass: f64, com: Vec3, inertia: Mat3) -> Result<Self, Error> {
        if !(mass >= 0.0 && mass.is_finite()) {
            return Err(Error::invalid("mass_kg", mass, "a finite number, zero or more"));
        }
        if !com.is_finite() {
            return Err(Error::invalid("com_m", format!("{:?}", com.0), "finite numbers"));
        }
        let (moments, axes) = principal_axes(inertia).ok_or_else(|| {
            Error::invalid("inertia_kg_m2", format!("{:?}", inertia.0), "a symmetric matrix")
        })?;
        let [a, b, c] = moments.0;
        let tolerance = -1e-9 * (a + b + c).abs();
        if [a, b, c, a + b - c, b + c - a, c + a - b].iter().any(|&x| x < tolerance) {
            let allowed = "positive semi-definite, each principal moment at most the sum of the others";
            return Err(Error::invalid("inertia_kg_m2", format!("{:?}", inertia.0), allowed));
        }
        Ok(Self { mass, com, moments, axes: [axes.column(1), axes.column(2)] })
    }

    /// True when neither mass nor inertia is there.
    pub(super) fn is_massless(&self) -> bool {
        self.mass == 0.0 && self.moments == Vec3::ZERO
    }

    /// Equation: body.inertia_turned
    ///
    /// Inertia about the centre of mass in body axes,
    /// I = I1 1 + (I2 - I1) u2 u2' + (I3 - I1) u3 u3', `r` = R_BL.
    #[inline]
    pub(super) fn about_com<S: Scalar>(&self, r: &Mat3<S>) -> Mat3<S> {
        let mut sum = Mat3::diagonal(Vec3([S::from(self.moments[0]); 3]));
        for (u, moment) in self.axes.iter().zip(&self.moments.0[1..]) {
            let (u, k) = (r.mul_constant(*u), moment - self.moments[0]);
            for i in 0..3 {
                let scaled = u[i] * k;
                for j in 0..=i {
                    sum.0[i][j] += scaled * u[j];
                }
            }
        }
        symmetrised(sum)
    }
}

/// Copies the lower triangle over the upper.
#[inline]
fn symmetrised<S: Scalar>(mut m: Mat3<S>) -> Mat3<S> {
    (m.0[0][1], m.0[0][2], m.0[1][2]) = (m.0[1][0], m.0[2][0], m.0[2][1]);
    m
}

/// Principal moments and axes (columns) of a symmetric matrix by cyclic Jacobi
/// rotations (Golub & Van Loan, 8.5). None when not symmetric or not finite.
fn principal_axes(m: Mat3) -> Option<(Vec3, Mat3)> {
    let scale = m.0.iter().flatten().fold(0.0, |s: f64, x| s.max(x.abs()));
    let asymmetry = (0..3)
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .any(|(i, j)| !((m.0[i][j] - m.0[j][i]).abs() <= 1e-12 * scale));
    if asymmetry || !m.0.iter().flatten().all(|x| x.is_finite()) {
        return None;
    }
    let (mut a, mut axes) = (m, Mat3::IDENTITY);
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(30) {
        if a.0[p][q] == 0.0 {
            continue;
        }
        let angle = 0.5 * (2.0 * a.0[p][q]).atan2(a.0[q][q] - a.0[p][p]);
        let (s, c) = angle.sin_cos();
        let mut turn = Mat3::IDENTITY;
        (turn.0[p][p], turn.0[q][q], turn.0[p][q], turn.0[q][p]) = (c, c, s, -s);
        a = turn.transpose() * a * turn;
        axes = axes * turn;
    }
    Some((Vec3([a.0[0][0], a.0[1][1], a.0[2][2]]), axes))
}

/// What one body needs to move: the wrench about the body origin is
/// `inertia [a0; w_dot] + bias`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reaction<S: Scalar> {
    /// Centre of mass from the body origin.
    pub(super) com: Vec3<S>,
    /// Inertia about the body origin.
    pub(super) about_origin: Mat3<S>,
    /// Wrench of the accelerations without the base's.
    pub(super) bias: Wrench<S>,
}

impl Inertia {
    /// Equation: body.newton_euler
    ///
    /// Newton-Euler about the body origin: F = m a_c,
    /// T = c x F + I w' + w x I w.
    #[inline]
    pub(super) fn reaction<S: Scalar>(&self, motion: &LinkMotion<S>) -> Reaction<S> {
        let com = motion.point(self.com);
        let spin = self.about_com(&motion.rotation);
        let force = motion.acceleration_at(com).scaled(self.mass);
        let gyroscopic = motion.rate.cross(spin * motion.rate);
        let moment = com.cross(force) + spin * motion.rate_dot + gyroscopic;
        Reaction { com, about_origin: self.steiner(spin, com), bias: Wrench { force, moment } }
    }

    /// Parallel-axis theorem: I + m (c'c 1 - c c').
    #[inline]
    fn steiner<S: Scalar>(&self, mut spin: Mat3<S>, c: Vec3<S>) -> Mat3<S> {
        let square = c.norm_squared() * self.mass;
        for i in 0..3 {
            let scaled = c[i] * self.mass;
            spin.0[i][i] += square;
            for j in 0..=i {
                spin.0[i][j] -= scaled * c[j];
            }
        }
        symmetrised(spin)
    }
}

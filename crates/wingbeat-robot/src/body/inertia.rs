//! Mass, centre of mass and inertia of one rigid body.

use super::motion::LinkMotion;
use wingbeat_math::Error;
use wingbeat_math::range::Range;
use wingbeat_math::require;
use wingbeat_math::{DeclaredQuantity, Mat3, Meets, Parameters, Scalar, Vec3, Walk, Wrench, polar};

/// Constant inertia of a rigid body, with its principal axes found once so that
/// turning it into other axes takes two outer products.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LinkInertia<P: Scalar> {
    pub(super) mass: P,
    /// Centre of mass in link axes, m.
    pub(super) com: Vec3<P>,
    /// Principal moments about the centre of mass, kg m2.
    pub(super) moments: Vec3<P>,
    /// Second and third principal axis in link axes.
    axes: [Vec3; 2],
    /// Inertia about the link origin in link axes, kg m2.
    about_origin: Symmetric<P>,
}

/// Mass, centre of mass and moments of one rigid body, each of which may carry derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyNumbers<P: Scalar = f64> {
    /// Mass, kg.
    pub mass: P,
    /// Centre of mass, in the body's own axes, m.
    pub com: Vec3<P>,
    /// Principal moments about the centre of mass, kg m2: of a diagonal inertia its entries.
    pub moments: Vec3<P>,
}

/// Mass of a body.
pub const MASS: DeclaredQuantity = DeclaredQuantity::within("kg", Range::NOT_NEGATIVE, 0.0, 1e3);
/// Principal moment of inertia of a body.
pub const INERTIA: DeclaredQuantity = DeclaredQuantity::within("kg m2", Range::NOT_NEGATIVE, 0.0, 1e6);
/// A coordinate of a point.
pub const PLACE: DeclaredQuantity = DeclaredQuantity::free("m");

/// A link without mass keeps none: its numbers have no names.
impl<P: Scalar> Parameters<P> for BodyNumbers<P> {
    type In<Q: Scalar> = BodyNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> BodyNumbers<Q> {
        if self.mass.is_zero() && self.moments.is_zero() {
            let mut fixed = |v: Vec3<P>| Vec3(v.0.map(|x| at.fixed(x)));
            let (com, moments) = (fixed(self.com), fixed(self.moments));
            return BodyNumbers { mass: at.fixed(self.mass), com, moments };
        }
        BodyNumbers {
            mass: at.number("mass_kg", &MASS, self.mass),
            com: at.vector("com_m", &polar(PLACE), self.com),
            moments: at.vector("inertia_kg_m2", &[INERTIA; 3], self.moments),
        }
    }
}

/// A symmetric 3x3 matrix: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Symmetric<S: Scalar>(pub(super) [S; 6]);

impl<S: Scalar> Symmetric<S> {
    /// The same as a scalar that meets these numbers holds it.
    #[inline]
    fn met<T: Scalar + Meets<S>>(&self) -> Symmetric<T> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Symmetric([T::from(xx), T::from(yy), T::from(zz), T::from(xy), T::from(xz), T::from(yz)])
    }
    /// Product with a vector.
    #[inline]
    pub(super) fn apply(&self, v: &Vec3<S>) -> Vec3<S> {
        let ([xx, yy, zz, xy, xz, yz], [x, y, z]) = (&self.0, &v.0);
        let row = |a: S, b: S, c: S| (a * *x).plus_product(b, *y).plus_product(c, *z);
        Vec3([row(*xx, *xy, *xz), row(*xy, *yy, *yz), row(*xz, *yz, *zz)])
    }

    /// Adds the outer product of two parallel vectors.
    #[inline]
    pub(super) fn add_product(&mut self, a: &Vec3<S>, b: &Vec3<S>) {
        let ([ax, ay, az], [x, y, z]) = (a.0, b.0);
        let [xx, yy, zz, xy, xz, yz] = &mut self.0;
        *xx = xx.plus_product(ax, x);
        *yy = yy.plus_product(ay, y);
        *zz = zz.plus_product(az, z);
        *xy = xy.plus_product(ax, y);
        *xz = xz.plus_product(ax, z);
        *yz = yz.plus_product(ay, z);
    }

    /// Adds another matrix.
    #[inline]
    pub(super) fn add(&mut self, o: &Self) {
        for i in 0..6 {
            self.0[i] += o.0[i];
        }
    }

    /// With its upper half.
    #[inline]
    pub(super) fn full(&self) -> Mat3<S> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }
}

/// Principal moments of `inertia` (kg m2) and their axes, of what some distribution of mass has.
///
/// # Errors
/// [`Error::Invalid`] when it is not symmetric, or its principal moments are negative or break the triangle inequality.
pub fn principal_moments(inertia: Mat3) -> Result<(Vec3, Mat3), Error> {
    let (moments, axes) = principal_axes(inertia)
        .ok_or_else(|| Error::invalid("inertia_kg_m2", format!("{:?}", inertia.0), "a symmetric matrix"))?;
    let [a, b, c] = moments.0;
    let tolerance = -1e-9 * (a + b + c).abs();
    if [a, b, c, a + b - c, b + c - a, c + a - b].iter().any(|&x| x < tolerance) {
        let allowed = "positive semi-definite, each principal moment at most the sum of the others";
        return Err(Error::invalid("inertia_kg_m2", format!("{:?}", inertia.0), allowed));
    }
    Ok((moments, axes))
}

impl LinkInertia<f64> {
    /// Checks and stores; `inertia` is about the centre of mass, in link axes.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the mass is negative or not finite, or the inertia is
    /// not symmetric, or its principal moments are negative or break the triangle inequality.
    pub(super) fn new(mass: f64, com: Vec3, inertia: Mat3) -> Result<Self, Error> {
        require::not_negative("mass_kg", mass)?;
        if !com.is_finite() {
            return Err(Error::invalid("com_m", format!("{:?}", com.0), "finite numbers"));
        }
        let (moments, axes) = principal_moments(inertia)?;
        Ok(Self::about(mass, com, moments, [axes.column(1), axes.column(2)]))
    }

    /// True when neither mass nor inertia is there.
    pub(super) fn is_massless(&self) -> bool {
        self.mass == 0.0 && self.moments == Vec3::ZERO
    }
}

impl<P: Scalar> LinkInertia<P> {
    fn about(mass: P, com: Vec3<P>, moments: Vec3<P>, axes: [Vec3; 2]) -> Self {
        let mut body = Self { mass, com, moments, axes, about_origin: Symmetric::default() };
        body.about_origin = body.steiner(body.about_com(&Mat3::IDENTITY), &com);
        body
    }

    /// The same axes with the numbers of `body`.
    pub(super) fn with<Q: Scalar>(&self, body: &BodyNumbers<Q>) -> LinkInertia<Q> {
        LinkInertia::about(body.mass, body.com, body.moments, self.axes)
    }

    /// Its numbers.
    pub(super) fn numbers(&self) -> BodyNumbers<P> {
        BodyNumbers { mass: self.mass, com: self.com, moments: self.moments }
    }

    /// Equation: body.inertia_turned
    /// `I = I1 1 + (I2 - I1) u2 u2' + (I3 - I1) u3 u3'`
    /// Source: principal axes.
    /// Test: `free_joints_agree_with_pinocchio`.
    ///
    /// Inertia about the centre of mass in body axes,
    /// I = I1 1 + (I2 - I1) u2 u2' + (I3 - I1) u3 u3', `r` = R_BL.
    #[inline]
    pub(super) fn about_com<S: Scalar + Meets<P>>(&self, r: &Mat3<S>) -> Symmetric<S> {
        let (first, zero) = (S::from(self.moments[0]), S::ZERO);
        let mut sum = Symmetric([first, first, first, zero, zero, zero]);
        for i in 0..2 {
            let u = r.mul_constant::<f64>(self.axes[i]);
            sum.add_product(&u.scaled(self.moments[i + 1] - self.moments[0]), &u);
        }
        sum
    }

    /// Parallel-axis theorem: I + m (c'c 1 - c c').
    #[inline]
    fn steiner<S: Scalar + Meets<P>>(&self, mut about_com: Symmetric<S>, c: &Vec3<S>) -> Symmetric<S> {
        about_com.add_product(&c.scaled(-self.mass), c);
        let square = c.norm_squared() * self.mass;
        for diagonal in &mut about_com.0[..3] {
            *diagonal += square;
        }
        about_com
    }
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
    pub(super) about_origin: Symmetric<S>,
    /// Wrench of the accelerations without the base's.
    pub(super) bias: Wrench<S>,
}

/// Bodies that move as one, about the body origin, in B.
#[derive(Clone, Copy, Debug)]
pub(super) struct CompositeBody<P: Scalar, S: Scalar> {
    /// kg.
    pub(super) mass: P,
    /// Sum of mass times position, kg m.
    pub(super) first_moment: Vec3<S>,
    /// Inertia, kg m2.
    pub(super) about_origin: Symmetric<S>,
}

impl<P: Scalar> LinkInertia<P> {
    /// Equation: body.newton_euler
    /// `F = m a_c, T = c x F + I w' + w x I w`
    /// Source: Newton-Euler.
    /// Test: `momentum_is_kept_in_vacuum`.
    ///
    /// Newton-Euler about the body origin: F = m a_c,
    /// T = c x F + I w' + w x I w.
    #[inline(always)]
    pub(super) fn reaction<S: Scalar + Meets<P>>(&self, motion: &LinkMotion<S>) -> Reaction<S> {
        let (com, about_com, bias) = self.needed(motion);
        Reaction { com, about_origin: self.steiner(about_com, &com), bias }
    }

    /// Its centre of mass from the body origin (m, B), inertia about it, and the wrench about the body origin that the motion needs.
    #[inline(always)]
    pub(super) fn needed<S: Scalar + Meets<P>>(
        &self,
        motion: &LinkMotion<S>,
    ) -> (Vec3<S>, Symmetric<S>, Wrench<S>) {
        let com = motion.point(self.com);
        let about_com = self.about_com(&motion.rotation);
        let force = motion.acceleration_at(com).scaled(self.mass);
        let gyroscopic = motion.rate.cross(about_com.apply(&motion.rate));
        let moment = com.cross(force) + about_com.apply(&motion.rate_dot) + gyroscopic;
        (com, about_com, Wrench { force, moment })
    }

    /// [`LinkInertia::reaction`] of the base, whose axes are B: F = m w x (w x c), T = w x I w.
    #[inline]
    pub(super) fn reaction_of_base<S: Scalar + Meets<P>>(&self, w_b: &Vec3<S>) -> Reaction<S> {
        let com = self.com.met();
        let about_origin = self.about_origin.met();
        let force = w_b.cross(w_b.cross(com)).scaled(self.mass);
        let moment = w_b.cross(about_origin.apply(w_b));
        Reaction { com, about_origin, bias: Wrench { force, moment } }
    }
}

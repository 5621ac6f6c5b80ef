//! Coordinates that the dynamics decide: elastic and free joints, cranks under a motor. Loads meet
//! them by virtual work.

use super::MAX_LINKS;
use super::dynamics::BaseAcceleration;
use super::inertia::CompositeBody;
use super::motion::LinkMotion;
use super::tree::Tree;
use arrayvec::ArrayVec;
use wingbeat_math::{Meets, Over, Scalar, Vec3, Wrench, append_copies};
use wingbeat_ocp::plant::{MAX_COORDINATES, MAX_DEGREES};

/// What the rate of one coordinate does through one joint.
#[derive(Clone, Copy, Debug)]
struct Share<S: Scalar> {
    coordinate: usize,
    /// Links that move, as bits.
    links: u64,
    /// Their motion about the body origin per unit rate, in B.
    field: BaseAcceleration<S>,
}

/// The coordinates at one instant: how each moves the links, resolved in B about the body origin.
#[derive(Clone, Debug)]
pub struct Coordinates<S: Scalar = f64> {
    count: usize,
    shares: ArrayVec<Share<S>, MAX_LINKS>,
    /// Efforts and inertias of coordinates beside those of the links.
    own: ArrayVec<(usize, [S; 2]), MAX_COORDINATES>,
}

impl<S: Scalar> Coordinates<S> {
    /// No coordinate.
    #[inline]
    pub fn none() -> Self {
        Self { count: 0, shares: ArrayVec::new(), own: ArrayVec::new() }
    }

    /// No coordinate again.
    pub fn clear(&mut self) {
        let Self { count, shares, own } = self;
        *count = 0;
        shares.clear();
        own.clear();
    }

    /// Number of coordinates.
    #[inline]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of joints that were added.
    #[inline]
    pub fn shares(&self) -> usize {
        self.shares.len()
    }

    /// Lets the rate of `coordinate` turn `joint` of `tree` at `ratio` times itself, dimensionless.
    ///
    /// # Panics
    /// When a tree's joint is added more often than there are links.
    pub fn add_joint<P: Scalar>(
        &mut self,
        coordinate: usize,
        tree: &Tree<P>,
        joint: usize,
        ratio: S,
        motions: &[LinkMotion<S>],
    ) {
        let BaseAcceleration { origin, angular } = tree.nodes[joint].field(&motions[joint]);
        let field = BaseAcceleration { origin: origin * ratio, angular: angular * ratio };
        self.count = self.count.max(coordinate + 1);
        self.shares.push(Share { coordinate, links: tree.nodes[joint].carried, field });
    }

    /// Gives `coordinate` an inertia of its own beside that of the links, kg m2 of an angle, kg of a length, and an effort along it, N m
    /// or N.
    ///
    /// # Panics
    /// When there are more of them than coordinates.
    pub fn add_own(&mut self, coordinate: usize, effort: S, inertia: S) {
        self.count = self.count.max(coordinate + 1);
        self.own.push((coordinate, [effort, inertia]));
    }

    /// What moves `link` about the body origin: per joint a coordinate and the motion per unit of its rate, in B.
    #[inline]
    pub fn moving(&self, link: usize) -> impl Iterator<Item = (usize, &BaseAcceleration<S>)> {
        self.shares.iter().filter(move |s| s.links >> link & 1 == 1).map(|s| (s.coordinate, &s.field))
    }

    /// Adds the generalised forces (W over the unit of the rate) of `wrench` on `link` (N and N m, about the body origin, in B)
    /// to `forces`, one per coordinate: Q_c = field_c . wrench.
    pub fn project<T: Over<S>>(&self, link: usize, wrench: &Wrench<T>, forces: &mut [T]) {
        for (coordinate, field) in self.moving(link) {
            forces[coordinate] += field.power(wrench);
        }
    }

    /// The field of all coordinates with the rates `rates` on `link`, m/s2 and rad/s2 in B.
    pub fn combined(&self, link: usize, rates: &[S]) -> BaseAcceleration<S> {
        let still = BaseAcceleration { origin: Vec3::ZERO, angular: Vec3::ZERO };
        self.moving(link).fold(still, |sum, (coordinate, field)| sum.plus(field, rates[coordinate]))
    }
}

impl<S: Scalar> BaseAcceleration<S> {
    /// This field plus `k` times another.
    #[inline]
    fn plus(&self, other: &Self, k: S) -> Self {
        Self { origin: self.origin + other.origin * k, angular: self.angular + other.angular * k }
    }
}

impl<P: Scalar> Tree<P> {
    /// Equation: body.coordinate_inertia
    /// `M_cx = sum_links F_c . I F_x, Q_c = F_c . (m g - bias), F the field of motion about the body origin`
    /// Source: composite rigid bodies; Featherstone 2008, section 6.2.
    /// Test: `coordinates_and_articulated_bodies_agree_in_vacuum`.
    ///
    /// Rows and columns 6.. of the mass matrix on [acceleration of the body origin; angular
    /// acceleration; second rates of the coordinates], M_cx = F_c . I F_x with the fields F and the inertia I of
    /// the links that both move, added to `mass`; and weight less reaction, F_c . (m g - bias), added to `forces`
    /// (composite rigid bodies: Featherstone 2008, section 6.2, projected on the coordinates). Without `mass` the forces alone.
    ///
    /// `motions` comes from [`Tree::motions`] with no second rates of the coordinates; `g_b` is
    /// gravity in B.
    #[inline(never)]
    pub fn coordinate_inertia<S: Scalar + Meets<P>>(
        &self,
        motions: &[LinkMotion<S>],
        g_b: Vec3<S>,
        coordinates: &Coordinates<S>,
        mut mass: Option<&mut [[S; MAX_DEGREES]]>,
        forces: &mut [S],
    ) {
        for &(coordinate, [effort, inertia]) in &coordinates.own {
            forces[coordinate] += effort;
            if let Some(mass) = &mut mass {
                mass[6 + coordinate][6 + coordinate] += inertia;
            }
        }
        let shares = &coordinates.shares;
        let mut carried = ArrayVec::<(CompositeBody<P, S>, Wrench<S>), MAX_LINKS>::new();
        append_copies(&mut carried, (CompositeBody::NONE, Wrench::ZERO), shares.len());
        let moved = shares.iter().fold(0, |all, share| all | share.links);
        for (link, (node, motion)) in self.nodes.iter().zip(motions).enumerate() {
            let Some(inertia) = node.inertia.as_ref().filter(|_| moved >> link & 1 == 1) else { continue };
            let reaction = inertia.reaction(motion);
            let weight = g_b.scaled(inertia.mass);
            let load = Wrench { force: weight, moment: reaction.com.cross(weight) } + -reaction.bias;
            for (_, (body, sum)) in shares.iter().zip(&mut carried).filter(|(s, _)| s.links >> link & 1 == 1)
            {
                *sum += load;
                if mass.is_some() {
                    body.add(inertia.mass, &reaction);
                }
            }
        }
        for (k, (row, (body, load))) in shares.iter().zip(&carried).enumerate() {
            forces[row.coordinate] += row.field.power(load);
            let Some(mass) = &mut mass else { continue };
            let (needed, r) = (body.needed(&row.field), 6 + row.coordinate);
            for i in 0..3 {
                mass[r][i] += needed.force[i];
                mass[i][r] += needed.force[i];
                mass[r][i + 3] += needed.moment[i];
                mass[i + 3][r] += needed.moment[i];
            }
            for (l, column) in shares.iter().enumerate() {
                // Links that two joints of a tree carry are all those of one of the two; of two that carry the same the first counts.
                if row.links & !column.links != 0 || (row.links == column.links && l < k) {
                    continue;
                }
                let (share, c) = (column.field.power(&needed), 6 + column.coordinate);
                mass[r][c] += share;
                if l != k {
                    mass[c][r] += share;
                }
            }
        }
    }
}

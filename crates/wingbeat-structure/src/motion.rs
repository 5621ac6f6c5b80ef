//! The equations of motion of a beam, as residuals that hold for any scalar.

use crate::beam::{Beam, Node};
use crate::group::{Pair, Place, drawn_back};
use nalgebra::DMatrix;
use wingbeat_math::{Dual, Jet, Mat3, Scalar, Vec3, Wrench};

/// Directions of derivative per pass.
const LANES: usize = 8;
/// Coordinates of a free root.
const ROOT: usize = 6;

/// The place of the root with its rates.
pub type Swung = Place<Jet<f64>>;

impl Swung {
    /// At rest.
    pub fn still(place: &Place) -> Self {
        Place::constant(place)
    }

    /// Turning about the origin at the constant rate `rate` (rad/s, W), `t` s after it was at `place`.
    pub fn turning(place: &Place, rate: Vec3, t: f64) -> Self {
        let turn = rate.each(|w| Jet::new(w * t, w, 0.0));
        let turned = Place::constant(&Place::IDENTITY).moved(&Pair { turn, push: Vec3([Jet::ZERO; 3]) });
        Self { p: turned.r * place.p.each(Jet::constant), r: turned.r * place.r.each(Jet::constant) }
    }
}

/// A force and a moment at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Number of the node.
    pub node: usize,
    /// Force, N.
    pub force: Vec3,
    /// Moment about the node, N m.
    pub moment: Vec3,
    /// True when it turns with the section, in whose axes it is then given; else in W.
    pub follows: bool,
}

impl Load {
    /// A force that keeps its direction, N in W.
    pub fn dead(node: usize, force: Vec3) -> Self {
        Self { node, force, moment: Vec3::ZERO, follows: false }
    }
    /// A force that turns with the section, N in its axes.
    pub fn following(node: usize, force: Vec3) -> Self {
        Self { follows: true, ..Self::dead(node, force) }
    }
}

/// How a beam is held and loaded at one instant.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Where the root is, or, where it is free, from where its own coordinates count.
    pub root: Swung,
    /// Whether the root is free: six coordinates before the strains, displacement in W and rotation vector.
    pub free: bool,
    /// Acceleration of gravity in W, m/s2.
    pub gravity: Vec3,
    /// Loads at nodes.
    pub loads: Vec<Load>,
    /// Damping over stiffness, s.
    pub damping_s: f64,
}

impl Default for Setting {
    fn default() -> Self {
        let root = Swung::still(&Place::IDENTITY);
        Self { root, free: false, gravity: Vec3::ZERO, loads: Vec::new(), damping_s: 0.0 }
    }
}

/// Energies of a beam, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Of motion.
    pub kinetic: f64,
    /// Of strain.
    pub elastic: f64,
    /// Of weight, from W's origin.
    pub weight: f64,
}

impl Energy {
    /// The sum, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.weight
    }
}

/// Axial vector of a b'.
#[inline]
fn axial<S: Scalar>(a: &Mat3<S>, b: &Mat3<S>) -> Vec3<S> {
    let product = |i: usize, j: usize| Vec3(a.0[i]).dot(Vec3(b.0[j]));
    Vec3([product(2, 1), product(0, 2), product(1, 0)])
}

/// Angular rate (rad/s) and acceleration (rad/s2) in W: the axial vectors of R' R^T and of R'' R^T + R' R'^T.
#[inline]
pub fn turning<S: Scalar>(r: &Mat3<Jet<S>>) -> [Vec3<S>; 2] {
    let [x, d, dd] = [r.each(|j| j.x), r.each(|j| j.d), r.each(|j| j.dd)];
    [axial(&d, &x), axial(&dd, &x) + axial(&d, &d)]
}

/// What moves a node as it moves, less its weight: force and moment about the node, in W (Newton, Euler).
fn inertial<S: Scalar>(node: &Node, at: &Place<Jet<S>>, gravity: Vec3) -> Pair<S> {
    if node.mass == 0.0 && node.inertia.0.iter().flatten().all(|x| *x == 0.0) {
        return Pair::ZERO;
    }
    let constant = |v: Vec3| v.each(S::from);
    let r = at.r.each(|j| j.x);
    let [w, alpha] = turning(&at.r);
    let arm = r * constant(node.moment);
    let a = at.p.each(|j| j.dd) + constant(-gravity);
    let force = a * S::from(node.mass) + alpha.cross(arm) + w.cross(w.cross(arm));
    let inertia = node.inertia.each(S::from);
    let turned = |v: Vec3<S>| r * (inertia * r.transpose_mul(v));
    Pair { turn: turned(alpha) + w.cross(turned(w)) + arm.cross(a), push: force }
}

impl Beam {
    /// Number of all coordinates.
    pub fn unknowns(&self, free: bool) -> usize {
        self.coordinates() + if free { ROOT } else { 0 }
    }

    /// Places of all nodes, m, with their rates.
    pub fn motion<S: Scalar>(&self, setting: &Setting, q: &[S], v: &[S], a: &[S]) -> Vec<Place<Jet<S>>> {
        let jets: Vec<Jet<S>> = (0..q.len()).map(|i| Jet::new(q[i], v[i], a[i])).collect();
        let lift = |j: Jet<f64>| Jet::new(S::from(j.x), S::from(j.d), S::from(j.dd));
        let mut root = Place { p: setting.root.p.each(lift), r: setting.root.r.each(lift) };
        let strains = if setting.free {
            root.p += Vec3([jets[0], jets[1], jets[2]]);
            root = root.moved(&Pair { turn: Vec3([jets[3], jets[4], jets[5]]), push: Vec3([Jet::ZERO; 3]) });
            &jets[ROOT..]
        } else {
            &jets[..]
        };
        self.places(&root, strains)
    }

    /// Inertia, stiffness and damping less the loads, by coordinate, in J over the units of these, which is zero in a motion;
    /// `others` are further loads on the nodes, in W about them. Returns what holds the root, in W about it.
    ///
    /// Loads are summed from the tip inboard, so that each step gives its coordinates the work of all that lies outboard.
    ///
    /// Equation: structure.motion
    /// `sum over nodes of J'(m a - f) + K (q + b q') = 0, J by the tangents of the exponentials`
    /// Source: d'Alembert and virtual work; Simo 1985; Cesnik & Brown 2002 and Boyer et al. 2021 for strains as unknowns.
    /// Test: `derivatives_balance_and_momentum_hold`.
    pub fn residual<S: Scalar>(
        &self,
        setting: &Setting,
        [q, v, a]: [&[S]; 3],
        others: &[Wrench<S>],
        out: &mut [S],
    ) -> Wrench<S> {
        self.balance(setting, &self.motion(setting, q, v, a), [q, v], others, out)
    }

    /// [`residual`](Self::residual) where the places of the nodes are known, as [`motion`](Self::motion) gives them.
    pub fn balance<S: Scalar>(
        &self,
        setting: &Setting,
        places: &[Place<Jet<S>>],
        [q, v]: [&[S]; 2],
        others: &[Wrench<S>],
        out: &mut [S],
    ) -> Wrench<S> {
        let first = if setting.free { ROOT } else { 0 };
        let turn = if setting.free { Vec3([q[3], q[4], q[5]]) } else { Vec3([S::ZERO; 3]) };
        let (q, v) = (&q[first..], &v[first..]);
        let (head, strains) = out.split_at_mut(first);
        self.elastic(q, v, setting.damping_s, strains);
        let mut carried = Pair::ZERO;
        let position = |k: usize| places[k].p.each(|j: Jet<S>| j.x);
        for k in (0..self.nodes.len()).rev() {
            carried = carried.plus(self.borne(setting, k, &places[k], others), 1.0);
            if k == 0 {
                break;
            }
            self.pass_inward(k - 1, &places[k], &carried, q, strains);
            carried.turn += (position(k) - position(k - 1)).cross(carried.push);
        }
        if setting.free {
            let r = places[0].r.each(|j| j.x);
            // The rotation vector turns the root's own axes.
            let own = Pair { turn: r.transpose_mul(carried.turn), push: Vec3([S::ZERO; 3]) };
            let step = Pair { turn, push: Vec3([S::ZERO; 3]) };
            carried.push.store(&mut head[..3]);
            drawn_back(&step, &own).turn.store(&mut head[3..]);
        }
        Wrench { force: carried.push, moment: carried.turn }
    }

    /// Load of the node `k` itself: its inertia less what acts on it.
    fn borne<S: Scalar>(
        &self,
        setting: &Setting,
        k: usize,
        at: &Place<Jet<S>>,
        others: &[Wrench<S>],
    ) -> Pair<S> {
        let mut sum = inertial(&self.nodes[k], at, setting.gravity);
        for load in setting.loads.iter().filter(|load| load.node == k) {
            let r = at.r.each(|j| j.x);
            let turned = |v: Vec3| if load.follows { r * v.each(S::from) } else { v.each(S::from) };
            sum = sum.plus(Pair { turn: turned(load.moment), push: turned(load.force) }, -1.0);
        }
        match others.get(k) {
            Some(other) => sum.plus(Pair { turn: other.moment, push: other.force }, -1.0),
            None => sum,
        }
    }

    /// Adds the work of `carried`, about the node at the end of step `k`, on the coordinates of that step.
    fn pass_inward<S: Scalar>(
        &self,
        k: usize,
        end: &Place<Jet<S>>,
        carried: &Pair<S>,
        q: &[S],
        out: &mut [S],
    ) {
        let step = &self.steps[k];
        let r = end.r.each(|j| j.x);
        let own = Pair { turn: r.transpose_mul(carried.turn), push: r.transpose_mul(carried.push) };
        let moments = self.moments_of(step, q);
        let load = drawn_back(&Self::motion_along(&moments), &own);
        let [mean, slope] = &moments;
        let parts = [load.plus(load.through(slope), -1.0), load.through(mean)];
        let size = self.strains.len() * self.order;
        let out = &mut out[step.element * size..][..size];
        for (part, row) in parts.iter().zip(&step.rows) {
            for (kind, out) in self.strains.iter().zip(out.chunks_exact_mut(self.order)) {
                let component = part.component(*kind as usize);
                out.iter_mut().zip(row).for_each(|(out, p)| *out += component * *p);
            }
        }
    }

    /// K (q + damping v).
    fn elastic<S: Scalar>(&self, q: &[S], v: &[S], damping: f64, out: &mut [S]) {
        let size = self.strains.len() * self.order;
        for (e, stiffness) in self.stiffness.iter().enumerate() {
            for (i, row) in stiffness.chunks_exact(size).enumerate() {
                let mut sum = S::ZERO;
                for (j, k) in row.iter().enumerate().filter(|(_, k)| **k != 0.0) {
                    let at = e * size + j;
                    sum += (q[at] + v[at] * damping) * *k;
                }
                out[e * size + i] = sum;
            }
        }
    }

    /// Derivatives of the residual, J over the units of two coordinates, by coordinates, their rates and their accelerations,
    /// exact.
    pub fn tangents(&self, setting: &Setting, at: [&[f64]; 3], others: &[Wrench<f64>]) -> [DMatrix<f64>; 3] {
        self.first_tangents(setting, at, others)
    }

    /// The tangent stiffness at rest in the coordinates `q`: derivatives of the residual by them, J over the units of two
    /// coordinates.
    pub fn tangent_stiffness(&self, setting: &Setting, q: &[f64]) -> DMatrix<f64> {
        let zero = vec![0.0; q.len()];
        let [stiffness] = self.first_tangents(setting, [q, &zero, &zero], &[]);
        stiffness
    }

    /// The first `K` of [`tangents`](Self::tangents).
    fn first_tangents<const K: usize>(
        &self,
        setting: &Setting,
        [q, v, a]: [&[f64]; 3],
        others: &[Wrench<f64>],
    ) -> [DMatrix<f64>; K] {
        let n = q.len();
        let mut all = [0; K].map(|_| DMatrix::zeros(n, n));
        let others: Vec<Wrench<Dual<LANES>>> = others
            .iter()
            .map(|w| Wrench { force: w.force.each(Dual::constant), moment: w.moment.each(Dual::constant) })
            .collect();
        let mut out = vec![Dual::<LANES>::ZERO; n];
        for first in (0..K * n).step_by(LANES) {
            let seeded = |values: &[f64], which: usize| -> Vec<Dual<LANES>> {
                let seed = |(i, value): (usize, &f64)| {
                    let mut x = Dual::constant(*value);
                    if let Some(lane) = (which * n + i).checked_sub(first).filter(|lane| *lane < LANES) {
                        x.eps[lane] = 1.0;
                    }
                    x
                };
                values.iter().enumerate().map(seed).collect()
            };
            let [q, v, a] = [seeded(q, 0), seeded(v, 1), seeded(a, 2)];
            self.residual(setting, [&q, &v, &a], &others, &mut out);
            for lane in 0..LANES.min(K * n - first) {
                let (which, column) = ((first + lane) / n, (first + lane) % n);
                out.iter().enumerate().for_each(|(row, x)| all[which][(row, column)] = x.eps[lane]);
            }
        }
        all
    }

    /// Energies, J, with the strain coordinates `q` and their rates `v`.
    pub fn energy(&self, setting: &Setting, q: &[f64], v: &[f64]) -> Energy {
        let zero = vec![0.0; q.len()];
        let places = self.motion(setting, q, v, &zero);
        let mut energy = Energy::default();
        for (node, at) in self.nodes.iter().zip(&places) {
            let ([w, _], speed, r) = (turning(&at.r), at.p.each(|j| j.d), at.r.each(|j| j.x));
            let arm = r * node.moment;
            let own = r.transpose_mul(w);
            energy.kinetic += 0.5 * node.mass * speed.norm_squared()
                + speed.dot(w.cross(arm))
                + 0.5 * own.dot(node.inertia * own);
            energy.weight -= setting.gravity.dot(at.p.each(|j| j.x) * node.mass + arm);
        }
        let strains = &q[if setting.free { ROOT } else { 0 }..];
        let mut force = vec![0.0; strains.len()];
        self.elastic(strains, strains, 0.0, &mut force);
        energy.elastic = 0.5 * force.iter().zip(strains).map(|(f, q)| f * q).sum::<f64>();
        energy
    }

    /// Momentum, kg m/s, and angular momentum about W's origin, kg m2/s, in W.
    pub fn momentum(&self, setting: &Setting, q: &[f64], v: &[f64]) -> [Vec3; 2] {
        let zero = vec![0.0; q.len()];
        let mut sums = [Vec3::ZERO; 2];
        for (node, at) in self.nodes.iter().zip(&self.motion(setting, q, v, &zero)) {
            let ([w, _], speed, r) = (turning(&at.r), at.p.each(|j| j.d), at.r.each(|j| j.x));
            let (arm, p) = (r * node.moment, at.p.each(|j| j.x));
            let push = speed * node.mass + w.cross(arm);
            sums[0] += push;
            sums[1] += p.cross(push) + arm.cross(speed) + r * (node.inertia * r.transpose_mul(w));
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CrossSection, Grid, SectionStation, Strain};
    use wingbeat_math::Random;

    fn beam() -> Beam {
        let mut section = CrossSection::isotropic(400.0, [3.0, 2.0, 5.0]).with_mass(
            0.7,
            Vec3::new(0.002, 0.03, -0.02),
            Mat3::diagonal(Vec3::new(3e-3, 1e-3, 2e-3)),
        );
        (section.stiffness[0][1], section.stiffness[1][0]) = (0.4, 0.4);
        let stations = [0.0, 1.5].map(|arc_m| SectionStation { arc_m, section });
        Beam::new(&stations, &[], &Grid { elements: 2, order: 2, strains: Strain::ALL, arcs: vec![] })
            .unwrap()
    }

    fn setting(free: bool) -> Setting {
        let root = Place { p: Vec3::new(0.2, -0.1, 0.3), ..Place::IDENTITY };
        Setting { root: Swung::still(&root), free, gravity: Vec3::new(0.3, -1.0, 9.0), ..Setting::default() }
    }

    fn drawn(random: &mut Random, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| size * random.normal()).collect()
    }

    /// Without loads the residual's power is the growth of energy, and its free root feels the growth of momentum.
    #[test]
    fn derivatives_balance_and_momentum_hold() {
        let beam = beam();
        let mut random = Random::new(5);
        for free in [false, true] {
            let setting = setting(free);
            let n = beam.unknowns(free);
            let [q, v, a] = [0.3, 0.5, 0.7].map(|size| drawn(&mut random, n, size));
            let mut out = vec![0.0; n];
            let root = beam.residual(&setting, [&q, &v, &a], &[], &mut out);
            let moved = |t: f64| -> [Vec<f64>; 2] {
                let at = |i: usize| [q[i] + t * v[i] + 0.5 * t * t * a[i], v[i] + t * a[i]];
                [0, 1].map(|k| (0..n).map(|i| at(i)[k]).collect())
            };
            let h = 5e-4;
            let slope =
                |f: &dyn Fn(f64) -> f64| (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
            let energy = |t: f64| {
                let [q, v] = moved(t);
                beam.energy(&setting, &q, &v).total()
            };
            let power: f64 = out.iter().zip(&v).map(|(r, v)| r * v).sum();
            assert!((power / slope(&energy) - 1.0).abs() < 1e-8, "{free} {power} {}", slope(&energy));
            let weight = setting.gravity * beam.mass();
            for axis in 0..3 {
                let momentum = |t: f64| {
                    let [q, v] = moved(t);
                    beam.momentum(&setting, &q, &v)[0][axis]
                };
                let grown = slope(&momentum) - weight[axis];
                assert!((root.force[axis] - grown).abs() < 1e-7 * grown.abs().max(1.0), "{free} {axis}");
            }
            let tangents = beam.tangents(&setting, [&q, &v, &a], &[]);
            for j in 0..n {
                let column = |which: usize, t: f64| {
                    let mut at = [q.clone(), v.clone(), a.clone()];
                    at[which][j] += t;
                    let mut out = vec![0.0; n];
                    beam.residual(&setting, [&at[0], &at[1], &at[2]], &[], &mut out);
                    out
                };
                for (which, tangent) in tangents.iter().enumerate() {
                    let largest = tangent.column(j).amax().max(1e-3);
                    for i in 0..n {
                        let difference = slope(&|t| column(which, t)[i]);
                        assert!((difference - tangent[(i, j)]).abs() < 1e-7 * largest, "{which} {i} {j}");
                    }
                }
            }
        }
    }
}

//! Periodic feedback about an orbit.

use super::adapt::missed_place;
use super::spec::OrbitWeights;
use crate::orbit::{Deviations, Interval};
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::f64::consts::TAU;
use wingbeat_math::interpolation::lerp;
use wingbeat_structure::spectrum;

/// Cycles after which the feedback of an orbit must have settled.
const CYCLES: usize = 80;
/// Change of the feedback over a cycle at which it has, relative.
const SETTLED: f64 = 1e-5;
/// Cycles after which what is fed forward must have settled: the slowest deviation, the integral of the height, decays by it.
const CYCLES_AHEAD: usize = 400;
/// Place of the integral of the height in the state of the controller, and from which on the deviations are.
pub const INTEGRAL: usize = 0;
pub const DEVIATIONS: usize = 1;
/// Share of itself that is added to the cost of each deviation alone, so that rounding leaves the costs a root.
const ROUNDING: f64 = 1e-10;

/// Numbers of the state of a controller that knows a path: after the deviations come what is missing along the path,
/// what is off to its left, m, and the heading off that of the orbit along the path, rad.
pub const OFF_PATH: usize = 3;

/// A matrix at each phase, linear in between.
#[derive(Clone, Debug)]
struct Periodic(Vec<DMatrix<f64>>);

/// Commands by deviations, the integral of the height first, and the least cost from deviations on.
#[derive(Clone, Debug)]
pub(super) struct Feedback {
    gains: Periodic,
    roots: Periodic,
    /// R + B'PB, half the second derivative of the cost by the commands of an interval.
    hessians: Periodic,
    /// Commands by the waves of the acceleration that the model misses, where it is learned.
    ahead: Option<Periodic>,
    interval: f64,
}

/// The cost of deviations from an orbit until they are gone: |L' s|^2.
pub(super) struct CostToGo {
    /// L.
    pub root: DMatrix<f64>,
    /// Time between the updates over which the controller sums its cost, s.
    pub interval: f64,
}

impl Feedback {
    /// Equation: guide.periodic_regulator
    /// `K = (R + B'PB)^-1 B'PA, P = Q + A'P(A - B K) backwards over the cycle until it repeats`
    /// Source: Bittanti & Colaneri 2009, Periodic Systems, ch. 7.
    /// Test: `intervals_add_up_to_the_cycle_and_the_feedback_holds_the_orbit`.
    ///
    /// Feedback K_k at each phase that minimises sum s' Q s + u' R u over all time: backwards over cycles K = (R + B'PB)^-1
    /// B'PA, P = Q + A'P(A - B K) until K is the same a cycle earlier; `None` where it does not settle. The state is the
    /// integral of the height before the deviations, of which `coordinates` after the height are those of an orbit. `limits`
    /// are those of the commands, in the units of these, and `duration` (s) is that of a cycle. The states of air and elastic
    /// joints take part in the prediction and are left out of the feedback: they are not measured. With a `path` place and
    /// heading beside it are part of the state, and its distances along and across cost as much as a full command each.
    pub fn new(
        w: &OrbitWeights,
        path: Option<[f64; 2]>,
        all: &[Interval],
        coordinates: usize,
        limits: &[f64],
        duration: f64,
        learned: Option<usize>,
    ) -> Option<Self> {
        let (deviating, m) = (all[0].a.nrows(), limits.len());
        let beside = DEVIATIONS + deviating;
        let n = beside + path.map_or(0, |_| OFF_PATH);
        let mut q = costs_of(w, n);
        for (i, size) in (beside..n).zip(path.unwrap_or_default()) {
            q[(i, i)] = size.powi(-2);
        }
        let r = effort(limits);
        let interval = duration / all.len() as f64;
        let mean = MeanPath::of(all);
        let augmented = all.iter().enumerate().map(|(k, i)| {
            let (mut a, mut b) = with_integral(i, interval, n);
            let at = DEVIATIONS;
            if path.is_some() {
                let (own, by_rest) = mean.beside(i, k);
                a.view_mut((beside, beside), (OFF_PATH, OFF_PATH)).copy_from(&own);
                a.view_mut((beside, at), (OFF_PATH, deviating)).copy_from(&(by_rest * &i.ground_a));
                b.view_mut((beside, 0), (OFF_PATH, m)).copy_from(&(by_rest * &i.ground_b));
            }
            (a, b)
        });
        let augmented: Vec<_> = augmented.collect();
        let mut p = q.clone();
        let mut gains: Vec<DMatrix<f64>> = vec![DMatrix::zeros(m, n); all.len()];
        let mut costs = gains.clone();
        for _ in 0..CYCLES {
            let mut change: f64 = 0.0;
            for (k, (a, b)) in augmented.iter().enumerate().rev() {
                let (gain, before) = back(a, b, &q, &r, &p)?;
                change = change.max((&gain - &gains[k]).amax() / gain.amax());
                (p, gains[k]) = (before, gain);
                costs[k].clone_from(&p);
            }
            if change < SETTLED {
                let ahead = learned.map(|harmonics| {
                    ahead(&augmented, &gains, &costs, &r, interval, harmonics).map(Periodic)
                });
                let hessian = |(k, (_, b)): (usize, &(_, DMatrix<f64>))| {
                    &r + b.transpose() * &costs[(k + 1) % costs.len()] * b
                };
                let hessians = Periodic(augmented.iter().enumerate().map(hessian).collect());
                gains.iter_mut().for_each(|gain| measured(gain, coordinates));
                let roots = costs.into_iter().map(root).collect::<Option<_>>()?;
                let ahead = match ahead {
                    Some(made) => Some(made?),
                    None => None,
                };
                return Some(Self {
                    gains: Periodic(gains),
                    roots: Periodic(roots),
                    hessians,
                    ahead,
                    interval,
                });
            }
        }
        None
    }

    /// Equation: guide.held_multiplier
    /// `largest magnitude of the eigenvalues of prod_k (A_k - B_k K_k)`
    /// Source: Floquet 1883, of the closed loop.
    /// Test: `a_bound_is_periodic_and_held`.
    ///
    /// By what ratio the slowest deviation decays over a cycle under the feedback, the integral of the height among them; infinite
    /// where it is not found.
    pub fn multiplier(&self, all: &[Interval]) -> f64 {
        let n = self.gains.0[0].ncols();
        let over = all.iter().zip(&self.gains.0).fold(DMatrix::identity(n, n), |product, (of, gain)| {
            let (a, b) = with_integral(of, self.interval, n);
            (a - b * gain) * product
        });
        let found = spectrum(&over);
        found.map_or(f64::INFINITY, |all| all.iter().map(|value| value.norm()).fold(0.0, f64::max))
    }

    /// Commands by deviations, in the units of both, at `cycles` of the gait's phase.
    pub fn at(&self, cycles: f64) -> DMatrix<f64> {
        self.gains.at(cycles)
    }

    /// Cost of a change of the commands over an interval that starts there, dimensionless over their units squared.
    pub fn hessian(&self, cycles: f64) -> DMatrix<f64> {
        self.hessians.at(cycles)
    }

    /// Commands by the waves of what the model misses, in the units of commands over those of accelerations.
    pub fn ahead(&self, cycles: f64) -> Option<DMatrix<f64>> {
        self.ahead.as_ref().map(|ahead| ahead.at(cycles))
    }

    /// The cost of deviations there, dimensionless.
    pub fn cost(&self, cycles: f64) -> CostToGo {
        CostToGo { root: self.roots.at(cycles), interval: self.interval }
    }
}

/// Costs of the deviations of the body, the integral of the height first, among `n` numbers.
pub(super) fn costs_of(w: &OrbitWeights, n: usize) -> DMatrix<f64> {
    let mut q = DMatrix::zeros(n, n);
    q[(INTEGRAL, INTEGRAL)] = w.height_integral_m_s.powi(-2);
    for (i, size) in (DEVIATIONS..n).zip(w.sizes()) {
        q[(i, i)] = size.powi(-2);
    }
    q
}

/// Costs of commands with these limits.
pub(super) fn effort(limits: &[f64]) -> DMatrix<f64> {
    DMatrix::from_diagonal(&limits.iter().map(|l| l.powi(-2)).collect::<Vec<_>>().into())
}

/// A and B of an interval of `length` s with the integral of the height before the deviations, among `n` numbers.
pub(super) fn with_integral(of: &Interval, length: f64, n: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let (deviating, m) = of.b.shape();
    let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, m));
    let at = DEVIATIONS;
    (a[(INTEGRAL, INTEGRAL)], a[(INTEGRAL, at + Deviations::HEIGHT)]) = (1.0, length);
    a.view_mut((at, at), (deviating, deviating)).copy_from(&of.a);
    b.view_mut((at, 0), (deviating, m)).copy_from(&of.b);
    (a, b)
}

/// Gain over an interval and the least cost from its begin on, by that from its end on; `None` where it has no sense.
pub(super) fn back(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    p: &DMatrix<f64>,
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let pb = p * b;
    let gain = (r + b.transpose() * &pb).cholesky()?.solve(&(pb.transpose() * a));
    let before = q + a.transpose() * p * (a - b * &gain);
    let before = (&before + before.transpose()) * 0.5;
    Some((gain, before))
}

/// Leaves out of `gain` the states of air and elastic joints, of which an orbit has `coordinates` with those of the body: they are not
/// measured.
pub(super) fn measured(gain: &mut DMatrix<f64>, coordinates: usize) {
    let body = DEVIATIONS + Deviations::BODY;
    (body..DEVIATIONS + 1 + coordinates).for_each(|column| gain.column_mut(column).fill(0.0));
}

impl CostToGo {
    /// The share `share` of the way from this one to `other`.
    pub fn towards(self, other: Self, share: f64) -> Self {
        Self {
            root: self.root * (1.0 - share) + other.root * share,
            interval: lerp(self.interval, other.interval, share),
        }
    }
}

impl Periodic {
    /// That at `cycles` of the gait's phase, linear between phases.
    fn at(&self, cycles: f64) -> DMatrix<f64> {
        let phase = cycles.rem_euclid(1.0) * self.0.len() as f64;
        let k = (phase as usize).min(self.0.len() - 1);
        let share = phase - k as f64;
        &self.0[k] * (1.0 - share) + &self.0[(k + 1) % self.0.len()] * share
    }
}

/// Axes of an acceleration that the model misses: along heading axes, then about those of B.
pub const MISSED: usize = 6;

/// 1, then cosine and sine of each of `harmonics` of the phase, dimensionless.
pub fn waves(harmonics: usize, cycles: f64) -> Vec<f64> {
    let wave = |n: usize| {
        let (sin, cos) = (TAU * n as f64 * cycles).sin_cos();
        [cos, sin]
    };
    std::iter::once(1.0).chain((1..=harmonics).flat_map(wave)).collect()
}

/// Equation: guide.disturbance_feedforward
/// `u = -(R + B'PB)^-1 B'(P d + q), q <- (A - B K)'(P d + q) backwards over the cycle until it repeats`
/// Source: Anderson & Moore 1990, Optimal Control, ch. 4: linear term of the cost to go.
/// Test: `what_the_model_misses_is_fed_forward_at_least_cost`.
///
/// Commands at each phase by the waves of an acceleration d that repeats with the cycle: those that minimise the cost of the
/// regulator in the long run, beside its feedback. `costs` are those at the start of each interval.
fn ahead(
    augmented: &[(DMatrix<f64>, DMatrix<f64>)],
    gains: &[DMatrix<f64>],
    costs: &[DMatrix<f64>],
    r: &DMatrix<f64>,
    interval: f64,
    harmonics: usize,
) -> Option<Vec<DMatrix<f64>>> {
    let (parts, n) = (augmented.len(), costs[0].nrows());
    let each = waves(harmonics, 0.0).len();
    let pushed = |k: usize| {
        let basis = waves(harmonics, (k as f64 + 0.5) / parts as f64);
        let mut d = DMatrix::zeros(n, MISSED * each);
        for axis in 0..MISSED {
            for (j, b) in basis.iter().enumerate() {
                d[(DEVIATIONS + missed_place(axis), axis * each + j)] = b * interval;
                if axis == 2 {
                    d[(DEVIATIONS + Deviations::HEIGHT, axis * each + j)] = 0.5 * b * interval * interval;
                }
            }
        }
        d
    };
    let pushed: Vec<_> = (0..parts).map(pushed).collect();
    let factors = augmented.iter().enumerate().map(|(k, (_, b))| {
        let p = &costs[(k + 1) % parts];
        (r + b.transpose() * p * b).cholesky()
    });
    let factors: Vec<_> = factors.collect::<Option<_>>()?;
    let mut q: DMatrix<f64> = DMatrix::zeros(n, MISSED * each);
    let mut commands = vec![DMatrix::zeros(r.nrows(), MISSED * each); parts];
    for _ in 0..CYCLES_AHEAD {
        let mut change: f64 = 0.0;
        for k in (0..parts).rev() {
            let (a, b) = &augmented[k];
            let w = &costs[(k + 1) % parts] * &pushed[k] + &q;
            let next = -factors[k].solve(&(b.transpose() * &w));
            change = change.max((&next - &commands[k]).amax() / next.amax());
            commands[k] = next;
            q = (a - b * &gains[k]).transpose() * w;
        }
        if change < SETTLED {
            return Some(commands);
        }
    }
    None
}

/// L of P = L L' for a P without negative eigenvalues.
fn root(mut p: DMatrix<f64>) -> Option<DMatrix<f64>> {
    for i in 0..p.nrows() {
        p[(i, i)] += p[(i, i)] * ROUNDING + f64::MIN_POSITIVE;
    }
    p.cholesky().map(|factor| factor.unpack())
}

/// The mean path of an orbit over the ground: an arc of a circle.
pub(super) struct MeanPath {
    /// At equal parts of a cycle how far the orbit is ahead along it, to its left, m, and heads off it, rad.
    pub off: Vec<[f64; OFF_PATH]>,
    /// Left positive, 1/m.
    curvature: f64,
}

impl MeanPath {
    /// From places over the ground (m) and headings (rad) at equal parts of a cycle. A chord heads half as far from either end
    /// of its arc as that turns; the mean over the cycle is neither ahead nor beside.
    pub fn new(orbit: &[[f64; OFF_PATH]]) -> Self {
        let parts = orbit.len() - 1;
        let ([x, y, first], [end_x, end_y, last]) = (orbit[0], orbit[parts]);
        let (turned, chord) = (last - first, (end_x - x).hypot(end_y - y));
        let begin = (end_y - y).atan2(end_x - x) - 0.5 * turned;
        let curvature = 2.0 * (0.5 * turned).sin() / chord;
        // The length of a chord that turns by an angle, as a share of the arc's.
        let shorter = |turned: f64| if turned == 0.0 { 1.0 } else { (0.5 * turned).sin() / (0.5 * turned) };
        let arc = chord / shorter(turned);
        let off = |(k, [at_x, at_y, heading]): (usize, &[f64; OFF_PATH])| {
            let share = k as f64 / parts as f64;
            let (course, chord) = (begin + turned * share, arc * share * shorter(turned * share));
            let (sin, cos) = (begin + 0.5 * turned * share).sin_cos();
            let (x, y) = (at_x - x - chord * cos, at_y - y - chord * sin);
            let (sin, cos) = course.sin_cos();
            [x * cos + y * sin, y * cos - x * sin, heading - course]
        };
        let mut off: Vec<_> = orbit.iter().enumerate().map(off).collect();
        for axis in 0..2 {
            let mean = off[..parts].iter().map(|off| off[axis]).sum::<f64>() / parts as f64;
            off.iter_mut().for_each(|off| off[axis] -= mean);
        }
        Self { off, curvature }
    }

    fn of(all: &[Interval]) -> Self {
        let mut orbit = vec![[0.0; OFF_PATH]];
        for interval in all {
            let ([dx, dy, turned], [x, y, heading]) = (interval.ground, orbit[orbit.len() - 1]);
            let (sin, cos) = f64::sin_cos(heading);
            orbit.push([x + dx * cos - dy * sin, y + dx * sin + dy * cos, heading + turned]);
        }
        Self::new(&orbit)
    }

    /// How far it heads off its mean path at the part `k`.
    fn heads(&self, k: usize) -> f64 {
        self.off[k][OFF_PATH - 1]
    }

    /// Equation: guide.off_path
    /// `p' = C (p + B (e (-y, x) + dp)), e' = e + de in axes that go with the orbit; beside the path e is less by
    /// its curvature times the arc`
    /// Source: Frenet frame; own derivation.
    /// Test: `what_is_off_a_path_grows_as_it_does_beside_a_circle`.
    ///
    /// What is missing along the path, what is off to its left and the heading off it after the interval `k`: by the same
    /// before it, and by place and heading in heading axes of its begin that deviations and commands add. In axes that go
    /// with the orbit, p' = C (p + B (e (-y, x) + dp)), e' = e + de, with B from heading axes to those of the path and C by what
    /// the path turns; beside the path at an arc a further on, e is the heading off the path there and its curvature times a.
    fn beside(&self, interval: &Interval, k: usize) -> (Matrix3<f64>, Matrix3<f64>) {
        let [x, y, turned] = interval.ground;
        let turn = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
        };
        let turned = turned - (self.heads(k + 1) - self.heads(k));
        let (mut to_orbit, mut to_path) = (Matrix3::identity(), Matrix3::identity());
        (to_orbit[(2, 0)], to_path[(2, 0)]) = (self.curvature, -self.curvature);
        let (back, aside) = (to_path * turn(-turned), turn(self.heads(k)));
        let mut own = Matrix3::identity();
        own.set_column(2, &(aside * Vector3::new(-y, x, 1.0)));
        (back * own * to_orbit, back * aside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that goes on circles of its own, its heading off its course by a swing; how it is beside the first of them.
    #[test]
    fn what_is_off_a_path_grows_as_it_does_beside_a_circle() {
        let (parts, turn, chord) = (4, 0.3, 0.2);
        let curvature = 2.0 * (0.5 * turn * parts as f64).sin() / {
            // The chord of all parts.
            chord * (0.5 * turn * parts as f64).sin() / f64::sin(0.5 * turn)
        };
        // Where the body heads off its course at the begins of the parts.
        let off = |k: usize| [0.1, 0.25, -0.05, 0.15][k % 4];
        let interval = |k: usize| {
            let course = 0.5 * turn - off(k);
            Interval {
                a: DMatrix::zeros(0, 0),
                b: DMatrix::zeros(0, 0),
                ground: [chord * course.cos(), chord * course.sin(), turn + off(k + 1) - off(k)],
                ground_a: DMatrix::zeros(3, 0),
                ground_b: DMatrix::zeros(3, 0),
            }
        };
        let all: Vec<_> = (0..parts).map(interval).collect();
        let mean = MeanPath::of(&all);
        assert!((mean.curvature - curvature).abs() < 1e-12);
        let radius = 1.0 / curvature;
        for k in 0..parts {
            assert!(mean.off[k][0].abs() < 1e-12 && mean.off[k][1].abs() < 1e-12, "on a circle itself");
            assert!((mean.heads(k) - off(k)).abs() < 1e-12);
            let (own, _) = mean.beside(&all[k], k);
            // Of a body beside a circle about the origin that is passed at angle 0 as the interval begins.
            let after = |[along, cross, heading]: [f64; 3]| {
                let angle = along / radius;
                let course = angle + 0.5 * std::f64::consts::PI;
                let [x, y, turned] = all[k].ground;
                let (sin, cos) = f64::sin_cos(course + off(k) + heading);
                let out = radius - cross;
                let place = [out * angle.cos() + x * cos - y * sin, out * angle.sin() + x * sin + y * cos];
                let angle = place[1].atan2(place[0]);
                let heading = course + off(k) + heading + turned;
                let course = angle + 0.5 * std::f64::consts::PI;
                [angle * radius, radius - place[0].hypot(place[1]), heading - course - off(k + 1)]
            };
            let still = after([0.0; 3]);
            assert!((still[0] - turn * radius).abs() < 1e-12 && still[1].abs() < 1e-12, "{still:?}");
            for j in 0..OFF_PATH {
                let mut begin = [0.0; OFF_PATH];
                begin[j] = 1e-6;
                let end = after(begin);
                for i in 0..OFF_PATH {
                    let slope = (end[i] - still[i]) / 1e-6;
                    assert!((slope - own[(i, j)]).abs() < 1e-5, "{k}: {i} by {j}: {slope} {}", own[(i, j)]);
                }
            }
        }
    }

    #[test]
    fn a_matrix_without_rank_has_a_root() {
        let p = DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let root = root(p.clone()).unwrap();
        assert!((&root * root.transpose() - p).amax() < 1e-8);
    }

    /// A commanded body that a push of every phase of the cycle meets: whatever else is added to what is fed forward costs more.
    #[test]
    fn what_the_model_misses_is_fed_forward_at_least_cost() {
        let (parts, n, m, interval) = (4, DEVIATIONS + Deviations::BODY, 3, 0.1);
        let mut random = wingbeat_math::Random::new(2);
        let mut draw =
            |rows, columns, size: f64| DMatrix::from_fn(rows, columns, |_, _| size * random.normal());
        let augmented: Vec<_> =
            (0..parts).map(|_| (DMatrix::identity(n, n) * 0.7 + draw(n, n, 0.05), draw(n, m, 0.3))).collect();
        let (q, r) = (DMatrix::<f64>::identity(n, n), DMatrix::<f64>::identity(m, m) * 2.0);
        let (mut p, mut gains) = (q.clone(), vec![DMatrix::zeros(m, n); parts]);
        let mut costs = gains.clone();
        for _ in 0..200 {
            for (k, (a, b)) in augmented.iter().enumerate().rev() {
                let gain = (&r + b.transpose() * &p * b).cholesky().unwrap().solve(&(b.transpose() * &p * a));
                p = &q + a.transpose() * &p * (a - b * &gain);
                (gains[k], costs[k]) = (gain, p.clone());
            }
        }
        let fed = ahead(&augmented, &gains, &costs, &r, interval, 1).unwrap();
        // A push of each axis by its mean and first harmonic, as coefficients.
        let waves_of = draw(MISSED * 3, 1, 1.0);
        let cost = |added: &[DMatrix<f64>]| {
            let (mut s, mut sum) = (DMatrix::zeros(n, 1), 0.0);
            for cycle in 0..60 {
                for k in 0..parts {
                    let (a, b) = &augmented[k];
                    let u = &fed[k] * &waves_of + &added[k] - &gains[k] * &s;
                    if cycle == 59 {
                        sum += (s.transpose() * &q * &s + u.transpose() * &r * &u)[(0, 0)];
                    }
                    s = a * s + b * u;
                    let basis = waves(1, (k as f64 + 0.5) / parts as f64);
                    for axis in 0..MISSED {
                        let push: f64 = (0..3).map(|j| basis[j] * waves_of[(axis * 3 + j, 0)]).sum();
                        s[(DEVIATIONS + missed_place(axis), 0)] += push * interval;
                        if axis == 2 {
                            s[(DEVIATIONS + Deviations::HEIGHT, 0)] += 0.5 * push * interval * interval;
                        }
                    }
                }
            }
            sum
        };
        let nothing = vec![DMatrix::zeros(m, 1); parts];
        let least = cost(&nothing);
        assert!(least > 1e-3);
        for _ in 0..5 {
            let beside: Vec<_> = (0..parts).map(|_| draw(m, 1, 1e-3)).collect();
            let other: Vec<_> = beside.iter().map(|b| -b).collect();
            let (one, two) = (cost(&beside) - least, cost(&other) - least);
            // Stationary: the change is quadratic, the same on both sides.
            assert!(one > 0.0 && two > 0.0 && (one - two).abs() < 0.02 * (one + two), "{one} {two}");
        }
    }
}

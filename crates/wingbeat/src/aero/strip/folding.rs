//! How fast the wash of the chord doublets changes as the wing folds.
//!
//! The air that a strip carries depends on how the others lie to it. Its force is the rate of its impulse, so that the rates
//! of the rings' wash belong to it: without them a wing that folds as it beats is left with a mean force of several
//! hundredths of its lift, which the impulse of the air cannot have over a cycle.
//!
//! Strips of one rigid link keep their wash on one another; a wing that moves as a whole needs none of this.

use super::cores::Cores;
use super::influence::{Column, INVERSE_4PI, Line, Matrix, multiply, multiply_transposed, segment_square};
use super::motion::{Edges, Strips, Vectors};
use super::{Flow, StripModel};
use crate::math::{Meets, Scalar, Vec3};

/// A point or vector with its rate.
#[derive(Clone, Copy)]
pub(super) struct Moving<S: Scalar> {
    pub at: Vec3<S>,
    pub rate: Vec3<S>,
}

impl<S: Scalar> Moving<S> {
    #[inline(always)]
    fn to(self, other: Self) -> Self {
        Self { at: other.at - self.at, rate: other.rate - self.rate }
    }
    #[inline(always)]
    pub fn scaled<P: Copy>(self, scale: P) -> Self
    where
        S: Meets<P>,
    {
        Self { at: self.at.scaled(scale), rate: self.rate.scaled(scale) }
    }
}

/// A straight line with its rate.
#[derive(Clone, Copy)]
struct MovingLine<S: Scalar> {
    at: Line<S>,
    rate: Line<S>,
}

impl<S: Scalar> MovingLine<S> {
    fn new(point: Moving<S>, direction: Moving<S>) -> Self {
        let moment = point.rate.cross(direction.at) + point.at.cross(direction.rate);
        Self { at: Line::new(point.at, direction.at), rate: Line { direction: direction.rate, moment } }
    }
    /// n . (d x r) and its rate.
    #[inline(always)]
    fn turn(&self, n: &Self) -> [S; 2] {
        [self.at.turn(&n.at), self.rate.turn(&n.at) + self.at.turn(&n.rate)]
    }
}

/// A vortex between two points: its line, the square of its length, and half the rate of that.
struct Segment<S: Scalar> {
    line: MovingLine<S>,
    length2: S,
    half_rate: S,
}

impl<S: Scalar> Segment<S> {
    fn new(from: Moving<S>, to: Moving<S>) -> Self {
        let along = from.to(to);
        Self {
            line: MovingLine::new(from, along),
            length2: along.at.norm_squared(),
            half_rate: along.at.dot(along.rate),
        }
    }

    /// Rate of turn s y^3 / (a b (y^4 + core)), s = a + b, y = (s^2 - d^2)/2, the normal wash of the segment at the
    /// distances a and b from its ends.
    ///
    /// Equation: aero.strip.segment_rate
    #[inline(always)]
    fn wash_rate<P: Scalar>(&self, n: &MovingLine<S>, [a, b]: [Distance<S>; 2], core: P) -> S
    where
        S: Meets<P>,
    {
        let [turn, turn_rate] = self.line.turn(n);
        let (s, s_rate) = (a.length + b.length, a.rate + b.rate);
        let y = segment_square(self.length2, [a.length, b.length]);
        let y_rate = s * s_rate - self.half_rate;
        let (y2, inverse) = (y * y, a.inverse * b.inverse);
        let y4 = y2 * y2;
        let share = (y4 + core).recip();
        let fade = y2 * y * share;
        let fade_rate = y2 * share * (share * (S::from(core * 3.0) - y4)) * y_rate;
        let shrinking = a.rate * a.inverse + b.rate * b.inverse;
        let strength_rate = (s_rate - s * shrinking) * fade + s * fade_rate;
        (turn_rate * (s * fade) + turn * strength_rate) * inverse
    }
}

/// The distance of a target from the end of a segment, its inverse and its rate.
#[derive(Clone, Copy)]
struct Distance<S> {
    length: S,
    inverse: S,
    rate: S,
}

impl<S: Scalar> Distance<S> {
    #[inline(always)]
    fn new<P>(from: Moving<S>, to: Moving<S>, least: P) -> Self
    where
        S: Meets<P>,
    {
        let r = from.to(to);
        let length2 = r.at.norm_squared() + least;
        let inverse = length2.sqrt().recip();
        Self { length: length2 * inverse, inverse, rate: r.at.dot(r.rate) * inverse }
    }
}

/// Distances of all targets from one end, by component.
struct Distances<S, const N: usize>([Column<S, N>; 3]);

impl<S: Scalar, const N: usize> Distances<S, N> {
    const ZERO: Self = Self([[S::ZERO; N]; 3]);

    #[inline(always)]
    fn get(&self, i: usize) -> Distance<S> {
        Distance { length: self.0[0][i], inverse: self.0[1][i], rate: self.0[2][i] }
    }
    #[inline(always)]
    fn set(&mut self, i: usize, distance: Distance<S>) {
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (distance.length, distance.inverse, distance.rate);
    }
}

/// What one edge is to all targets: the distances of its ends and the rate of the wash of its leg.
struct Beside<S, const N: usize> {
    bound: Distances<S, N>,
    trailing: Distances<S, N>,
    leg: Column<S, N>,
}

impl<S: Scalar, const N: usize> Beside<S, N> {
    const ZERO: Self = Self { bound: Distances::ZERO, trailing: Distances::ZERO, leg: [S::ZERO; N] };
}

/// The targets: 3/4 chord points and the normals through them over 4 pi, with their rates.
struct Targets<'a, P: Scalar, S: Scalar, const N: usize> {
    cores: &'a Cores<P>,
    point: [Vectors<S, N>; 2],
    normal: [Vectors<S, N>; 2],
    moment: [Vectors<S, N>; 2],
}

impl<'a, P: Scalar, S: Scalar + Meets<P>, const N: usize> Targets<'a, P, S, N> {
    fn new(cores: &'a Cores<P>, edges: &Edges<S, N>, strips: &Strips<S, N>, fraction: &[P]) -> Self {
        let pair = [Vectors::ZERO; 2];
        let mut targets = Self { cores, point: pair, normal: pair, moment: pair };
        for i in 0..N {
            let point = edges.control(i, fraction[i]).scaled(cores.scale);
            let [at, rate] = [&strips.normal, &strips.normal_rate]
                .map(|of| of.get(i).scaled(cores.strength * INVERSE_4PI));
            let normal = MovingLine::new(point, Moving { at, rate });
            for (k, line) in [normal.at, normal.rate].into_iter().enumerate() {
                targets.normal[k].set(i, line.direction);
                targets.moment[k].set(i, line.moment);
            }
            targets.point[0].set(i, point.at);
            targets.point[1].set(i, point.rate);
        }
        targets
    }

    #[inline(always)]
    fn point(&self, i: usize) -> Moving<S> {
        Moving { at: self.point[0].get(i), rate: self.point[1].get(i) }
    }
    #[inline(always)]
    fn normal(&self, i: usize) -> MovingLine<S> {
        let [at, rate] =
            [0, 1].map(|k| Line { direction: self.normal[k].get(i), moment: self.moment[k].get(i) });
        MovingLine { at, rate }
    }

    /// The leg between the ends of edge `j`.
    #[inline(never)]
    fn beside(&self, [bound, trailing]: [Moving<S>; 2], j: usize, out: &mut Beside<S, N>) {
        let (leg, cores) = (Segment::new(bound, trailing), &self.cores.edges[j]);
        for i in 0..N {
            let p = self.point(i);
            let ends = [Distance::new(bound, p, cores.least), Distance::new(trailing, p, cores.least)];
            out.leg[i] = leg.wash_rate(&self.normal(i), ends, cores.leg[i]);
            out.bound.set(i, ends[0]);
            out.trailing.set(i, ends[1]);
        }
    }

    /// Rates of the wash of the ring of strip `j` between two edges.
    #[inline(never)]
    fn ring(
        &self,
        [left, right]: [[Moving<S>; 2]; 2],
        [beside_left, beside_right]: [&Beside<S, N>; 2],
        j: usize,
        out: &mut Column<S, N>,
    ) {
        let (front, rear) = (Segment::new(left[0], right[0]), Segment::new(right[1], left[1]));
        let cores = &self.cores.strips[j];
        for i in 0..N {
            let n = self.normal(i);
            let ends = [beside_left.bound.get(i), beside_right.bound.get(i)];
            let ahead = front.wash_rate(&n, ends, cores.front[i]);
            let ends = [beside_right.trailing.get(i), beside_left.trailing.get(i)];
            let behind = rear.wash_rate(&n, ends, cores.rear[i]);
            out[i] = ahead + behind + (beside_right.leg[i] - beside_left.leg[i]);
        }
    }
}

impl<P: Scalar> StripModel<P> {
    /// K' by columns: rates of the wash of the chord doublets.
    ///
    /// Equation: aero.strip.folding
    #[inline(never)]
    pub(super) fn fold<S: Scalar + Meets<P>, const N: usize>(
        &self,
        edges: &Edges<S, N>,
        flow: &mut Flow<S, N>,
    ) {
        let (n, scale) = (self.settings.strips, self.cores.scale);
        let targets = Targets::new(&self.cores, edges, &flow.strips, &self.tables.fraction);
        let ends = |j: usize| edges.ends(j, n).map(|end| end.scaled(scale));
        let rates = flow.doublet_rate.insert([[S::ZERO; N]; N]);
        let mut beside = [Beside::ZERO, Beside::ZERO];
        targets.beside(ends(0), 0, &mut beside[0]);
        for j in 0..n {
            targets.beside(ends(j + 1), j + 1, &mut beside[(j + 1) % 2]);
            let pair = [&beside[j % 2], &beside[(j + 1) % 2]];
            let column = &mut rates[j];
            targets.ring([ends(j), ends(j + 1)], pair, j, column);
            for rate in column {
                *rate *= self.lags.doublet;
            }
        }
    }

    /// K' diag(d) v, K' the `rate`: what folding adds to a wash whose doublets follow v.
    pub(super) fn folded<S: Scalar + Meets<P>, const N: usize>(
        &self,
        rate: &Matrix<S, N>,
        v: &Column<S, N>,
    ) -> Column<S, N> {
        let mut jump = *v;
        for i in 0..N {
            jump[i] *= self.tables.doublet[i];
        }
        multiply(rate, &jump, self.settings.strips)
    }

    /// Its transpose, diag(d) K'^T v.
    pub(super) fn folded_transposed<S: Scalar + Meets<P>, const N: usize>(
        &self,
        rate: &Matrix<S, N>,
        v: &Column<S, N>,
    ) -> Column<S, N> {
        let mut sum = multiply_transposed(rate, v, self.settings.strips);
        for i in 0..N {
            sum[i] *= self.tables.doublet[i];
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::StripSettings;
    use super::super::influence::invert;
    use super::*;
    use crate::aero::{Planform, PlanformStation, SectionMotion};
    use crate::math::Dual;

    const N: usize = 8;
    type Time = Dual<1>;

    fn model() -> StripModel {
        let station =
            |arc_m| PlanformStation { arc_m, leading_edge_m: 0.03, trailing_edge_m: 0.2 * arc_m - 0.09 };
        let planform = Planform::new(&[0.0, 0.1, 0.2].map(station)).unwrap();
        let set = StripSettings {
            strips: N,
            hinge_arcs_m: vec![0.0, 0.1],
            folding_rates: true,
            ..Default::default()
        };
        StripModel::new(&planform, set).unwrap()
    }

    /// A wing that beats, folds, pitches and stretches at the time `t`.
    fn flow_at(model: &StripModel, t: f64) -> Flow<f64, N> {
        let t = Time::variable(t, 0);
        let point = |x: f64, arc: f64| -> Vec3<Time> {
            let (inner, outer) = (arc.abs().min(0.1), (arc.abs() - 0.1).max(0.0));
            let (beat, fold) = ((t * 3.0).sin() * 0.5, (t * 3.0).cos() * 0.6 - 0.5);
            let along = beat.cos() * inner + (beat + fold).cos() * outer;
            let up = beat.sin() * inner + (beat + fold).sin() * outer + (t * 2.0).sin() * (arc * x);
            Vec3([Time::from(x) + t * (0.3 * arc * arc), along * arc.signum(), up])
        };
        let part = |v: Vec3<Time>| (Vec3(v.0.map(|x| x.re)), Vec3(v.0.map(|x| x.eps[0])));
        let section = |(&arc, &(leading, trailing)): (&f64, &(f64, f64))| {
            let ((le, v_le), (te, v_te)) = (part(point(leading, arc)), part(point(trailing, arc)));
            SectionMotion { le, te, v_le, v_te, ..SectionMotion::default() }
        };
        let sections: Vec<_> = model.arcs().iter().zip(&model.grid.outline).map(section).collect();
        let mut edges = Edges::<f64, N>::ZERO;
        edges.fill(&sections[..], N);
        let mut flow = Flow::STILL;
        model.flow(&edges, Vec3::new(-2.0, 0.0, 0.2), &mut flow);
        flow
    }

    #[test]
    fn rates_of_the_doublets_are_those_of_the_folding_wing() {
        let (model, t, h) = (model(), 0.4, 1e-5);
        let relations = |t: f64| {
            let mut matrix = flow_at(&model, t).relief;
            invert(&mut matrix, N);
            matrix
        };
        let (here, before, after) = (flow_at(&model, t), relations(t - h), relations(t + h));
        let mut largest: f64 = 0.0;
        for j in 0..N {
            for i in 0..N {
                let exact = (before[j][i] - after[j][i]) / (2.0 * h);
                let rate = here.doublet_rate.as_ref().unwrap()[j][i] * model.tables.doublet[j];
                assert!((rate - exact).abs() < 1e-7, "{j} on {i}: {rate} {exact}");
                largest = largest.max(exact.abs());
            }
        }
        assert!(largest > 0.1);
    }
}

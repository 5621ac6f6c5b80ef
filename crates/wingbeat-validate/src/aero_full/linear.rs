//! Response of a wing to small motions, by exact linearisation about steady flow.

use super::wings::Still;
use crate::Error;
use wingbeat::aero::{Aero, Loads};
use wingbeat::math::{Jet, Scalar, Vec3, linear};
use wingbeat::plant::Early;
use wingbeat::tether::TetheredBody;

/// A complex number (real, imaginary).
pub type Complex = (f64, f64);

/// A small motion q(t) of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidMotion {
    /// Heave, positive down: unit rate gives unit upwash.
    Plunge,
    /// Nose-up pitch about the axis, m ahead of the hinge line.
    Pitch(f64),
    /// Flapping up about a hinge that the wing has on both sides.
    Flap(FlapHinge),
}

/// A hinge of a wing about which it flaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlapHinge {
    /// Its place among the wing's hinges.
    pub place: usize,
    /// Its arc, m.
    pub arc_m: f64,
}

/// x' = A x + B [q, q', q''], y = C x + D [q, q', q''], with y the upward force and then those of
/// the strips.
#[derive(Clone, Debug)]
pub struct SmallMotion {
    states: usize,
    a: Vec<f64>,
    b: [Vec<f64>; 3],
    c: Vec<f64>,
    d: [Vec<f64>; 3],
}

type D = Early;
/// What a derivative is taken by.
#[derive(Clone, Copy, PartialEq)]
enum DerivativeDirection {
    State(usize),
    /// The derivative of q of this order.
    Order(usize),
}
/// Derivatives of the state rates and of the outputs.
type DerivativeColumn = (Vec<f64>, Vec<f64>);

impl SmallMotion {
    /// Linearises `model` on the wing at rest in a wind of 1 m/s from ahead.
    pub fn new(model: &Aero, wing: &Still, motion: RigidMotion) -> Self {
        let n = model.states();
        let mut columns = Vec::with_capacity(n + 3);
        let directions: Vec<DerivativeDirection> =
            (0..n).map(DerivativeDirection::State).chain((0..3).map(DerivativeDirection::Order)).collect();
        for together in directions.chunks(D::LANES) {
            let mut x = vec![D::ZERO; n];
            for (lane, direction) in together.iter().enumerate() {
                if let DerivativeDirection::State(i) = direction {
                    x[*i] = D::variable(0.0, lane);
                }
            }
            columns.extend(derivatives(model, wing, motion, together, &x));
        }
        let orders = columns.split_off(n);
        let [i0, i1, i2] = std::array::from_fn(|order| orders[order].clone());
        let outputs = i0.1.len();
        let at = |rows: usize, pick: fn(&DerivativeColumn) -> &Vec<f64>| -> Vec<f64> {
            (0..rows).flat_map(|i| columns.iter().map(move |column| pick(column)[i])).collect()
        };
        let (a, c) = (at(n, |column| &column.0), at(outputs, |column| &column.1));
        Self { states: n, a, b: [i0.0, i1.0, i2.0], c, d: [i0.1, i1.1, i2.1] }
    }

    /// Outputs per unit amplitude of q at the angular frequency `omega`, rad/s.
    pub fn response(&self, omega: f64) -> Result<Vec<Complex>, Error> {
        let powers = [(1.0, 0.0), (0.0, omega), (-omega * omega, 0.0)];
        let x = self.states_at(omega, |i| mix(&self.b, i, &powers))?;
        let output = |o: usize| {
            let row = &self.c[o * self.states..(o + 1) * self.states];
            let add = |y: Complex, (c, x): (&f64, &Complex)| (y.0 + c * x.0, y.1 + c * x.1);
            row.iter().zip(&x).fold(mix(&self.d, o, &powers), add)
        };
        Ok((0..self.d[0].len()).map(output).collect())
    }

    /// Steady outputs, in the caller's units, per unit of derivative `order` of q held.
    pub fn steady(&self, order: usize) -> Result<Vec<f64>, Error> {
        let x = self.states_at(0.0, |i| (self.b[order][i], 0.0))?;
        Ok(self.outputs(&x.iter().map(|s| s.0).collect::<Vec<_>>(), order))
    }

    /// Outputs, in the caller's units, at the times `t` (ascending, s) after derivative `order` of q jumps to 1 at t = 0.
    pub fn step(&self, order: usize, t: &[f64]) -> Vec<Vec<f64>> {
        let mut x = vec![0.0; self.states];
        let mut now = 0.0;
        let fastest = (0..self.states).map(|i| self.a[i * self.states + i].abs()).fold(0.0, f64::max);
        t.iter()
            .map(|&end| {
                let steps = ((end - now) * fastest * 5.0).ceil().max(1.0) as usize;
                for _ in 0..steps {
                    self.advance(&mut x, order, (end - now) / steps as f64);
                }
                now = end;
                self.outputs(&x, order)
            })
            .collect()
    }

    /// One step of the Taylor series to h^4, for constant input.
    fn advance(&self, x: &mut [f64], order: usize, h: f64) {
        let mut term: Vec<f64> = self.rates(x).iter().zip(&self.b[order]).map(|(a, b)| a + b).collect();
        for k in 1..=4 {
            let scale = h / f64::from(k);
            term.iter_mut().for_each(|v| *v *= scale);
            x.iter_mut().zip(&term).for_each(|(x, v)| *x += v);
            term = self.rates(&term);
        }
    }

    /// A x.
    fn rates(&self, x: &[f64]) -> Vec<f64> {
        self.a.chunks_exact(self.states).map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
    }

    fn outputs(&self, x: &[f64], order: usize) -> Vec<f64> {
        let rows = self.c.chunks_exact(self.states).zip(&self.d[order]);
        rows.map(|(row, d)| d + row.iter().zip(x).map(|(c, x)| c * x).sum::<f64>()).collect()
    }

    /// (i omega - A)^-1 b, as a real system of twice the size.
    fn states_at(&self, omega: f64, b: impl Fn(usize) -> Complex) -> Result<Vec<Complex>, Error> {
        let n = self.states;
        let size = 2 * n;
        let (mut m, mut rhs) = (vec![0.0; size * size], vec![0.0; size]);
        for i in 0..n {
            for j in 0..n {
                m[i * size + j] = -self.a[i * n + j];
                m[(n + i) * size + n + j] = -self.a[i * n + j];
            }
            m[i * size + n + i] = -omega;
            m[(n + i) * size + i] = omega;
            (rhs[i], rhs[n + i]) = b(i);
        }
        let mut pivots = vec![0; size];
        if !linear::lu_factor(&mut m, size, &mut pivots) {
            return Err(Error::NoAnswer(format!("i {omega} - A is singular")));
        }
        linear::lu_solve(&m, size, &pivots, &mut rhs, 1);
        Ok((0..n).map(|i| (rhs[i], rhs[n + i])).collect())
    }
}

/// Entry `i` of the columns times the powers of i omega.
fn mix(columns: &[Vec<f64>; 3], i: usize, powers: &[Complex; 3]) -> Complex {
    columns.iter().zip(powers).fold((0.0, 0.0), |y, (v, p)| (y.0 + v[i] * p.0, y.1 + v[i] * p.1))
}

/// q = 0, with derivatives along those `directions` that are of it.
fn seeded(directions: &[DerivativeDirection]) -> Jet<D> {
    let lane =
        |order| directions.iter().position(|direction| *direction == DerivativeDirection::Order(order));
    let unit = |order| lane(order).map_or(D::ZERO, |lane| D::variable(0.0, lane));
    Jet::new(unit(0), unit(1), unit(2))
}

/// The columns of the linearisation by `directions`, of which the states `x` carry theirs.
fn derivatives(
    model: &Aero,
    still: &Still,
    motion: RigidMotion,
    directions: &[DerivativeDirection],
    x: &[D],
) -> Vec<DerivativeColumn> {
    let (q, count) = (seeded(directions), directions.len());
    let mut angles: Vec<_> = still.angles.iter().map(|a| Jet::from(a.x)).collect();
    let body = match motion {
        RigidMotion::Plunge => TetheredBody { heave: -q, ..TetheredBody::rest() },
        RigidMotion::Pitch(axis_ahead_m) => TetheredBody { nose_up: q, axis_ahead_m, ..TetheredBody::rest() },
        RigidMotion::Flap(hinge) => {
            angles[hinge.place] += q;
            TetheredBody::rest()
        }
    };
    let frame = body.frame();
    let sections: Vec<_> = model.arcs().iter().map(|&arc| still.wing.section(arc, &frame, &angles)).collect();
    let mut dx = vec![D::ZERO; x.len()];
    let mut loads = Loads::<D>::default();
    model.evaluate_in_early(&sections, Vec3::new(-D::ONE, D::ZERO, D::ZERO), x, &mut dx, &mut loads);
    let strips = loads.strip[..loads.strips].iter().map(|strip| strip.total().force[2]);
    let outputs: Vec<D> = [loads.wrench.force[2]].into_iter().chain(strips).collect();
    let column = |all: &[D], lane: usize| all.iter().map(|number| number.eps[lane]).collect();
    (0..count).map(|lane| (column(&dx, lane), column(&outputs, lane))).collect()
}

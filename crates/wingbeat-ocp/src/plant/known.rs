//! Derivatives that follow from those which an evaluation carries.

use super::MAX_DEGREES;
use std::ops::Range;
use wingbeat_math::rows::fused;
use wingbeat_math::{Dual, Mat3, Vec3};

/// What a plant knows of its derivatives without carrying them through an evaluation: those by inputs that enter by accelerations
/// alone, and those by the accelerations of gravity and of the air, with which those by the attitude follow from those by the
/// velocity.
#[derive(Clone, Debug)]
pub struct Known {
    /// df/du, n x m, row-major, in the unit of the row's state over that of the column's input, per s.
    pub inputs: Vec<f64>,
    /// Derivatives of f by the accelerations of gravity and of the air, both in B, n x 6, row-major: per m/s2.
    pub fields: Vec<f64>,
    /// Whether derivatives by late states are wanted.
    pub wants_late: bool,
    /// df/dx of the late states, n x their number, row-major, in the unit of the row's state over that of the column's, per s; empty where
    /// they are not known.
    pub late: Vec<f64>,
    /// Velocity of the air in W, m/s.
    pub wind: Vec3,
    /// Accelerations of gravity and of the air in W, m/s2.
    pub accelerations: [Vec3; 2],
    /// Accelerations that the plant's dynamics decide at this point: along the axes of B in m/s2 and rad/s2, then the second rates of its
    /// coordinates in their units over s2.
    pub degrees: Vec<f64>,
    /// Mass matrix on them, row-major, in SI units; empty where the plant does not tell it.
    pub mass: Vec<f64>,
    /// States of the plant whose rates fall with these accelerations, and by how much, in the units of the rates over those of the
    /// accelerations.
    pub falling: Vec<(usize, [f64; MAX_DEGREES])>,
    /// States of the plant that have no row here, in ascending runs: whoever asks does without them, and their rows would be all zero.
    pub left_out: Vec<Range<usize>>,
    /// Row of the position.
    pub position: usize,
    /// Row of the velocity.
    pub velocity: usize,
    /// Row of the angular rate.
    pub rate: usize,
}

impl Known {
    /// Room for a plant of `states` states and `inputs` inputs.
    pub fn new(states: usize, inputs: usize) -> Self {
        Self {
            inputs: Vec::with_capacity(states * inputs),
            fields: Vec::with_capacity(states * 6),
            wants_late: false,
            late: Vec::with_capacity(states * states),
            wind: Vec3::ZERO,
            accelerations: [Vec3::ZERO; 2],
            degrees: Vec::with_capacity(MAX_DEGREES),
            mass: Vec::with_capacity(MAX_DEGREES * MAX_DEGREES),
            falling: Vec::with_capacity(states),
            left_out: Vec::with_capacity(states),
            position: 0,
            velocity: 0,
            rate: 0,
        }
    }

    /// Sets all derivatives of `states` states, less those left out, by `inputs` inputs and by uniform accelerations to zero, and leaves none
    /// by late states.
    pub fn clear(&mut self, states: usize, inputs: usize) {
        let states = states - self.left_out.iter().map(Range::len).sum::<usize>();
        for (values, width) in [(&mut self.inputs, inputs), (&mut self.fields, 6)] {
            values.clear();
            values.resize(states * width, 0.0);
        }
        self.late.clear();
    }

    /// Row of the derivatives of a state that is not left out.
    pub fn row(&self, state: usize) -> usize {
        let before = self.left_out.iter().filter(|run| run.end <= state);
        state - before.map(Range::len).sum::<usize>()
    }

    /// Writes the derivatives of the rates `f` at the state `x` by `K` coordinates c of the attitude into the columns from `at` on of
    /// A (n x n, row-major), whose columns of the velocity are known; `rotation` is R_WB with its derivatives. The rates know the
    /// attitude by R'(v - wind), by accelerations R'g of gravity and air, and by v' = R a, so that
    /// df/dc = df/dv R (dR'/dc)(v - wind) / s + sum df/dg (dR'/dc) g, dv'/dc = that + (dR/dc) a, with R R' = s.
    /// The rates of the attitude itself are left to the caller.
    ///
    /// Equation: ocp.turned_columns
    /// `df/dc = df/dv R (dR'/dc)(v - wind)/s + sum df/dg (dR'/dc) g, dv'/dc = that + (dR/dc) a, R R' = s`
    /// Source: chain rule.
    /// Test: `what_has_no_derivative_is_left_out_and_nothing_else`.
    pub fn turn<const K: usize>(
        &self,
        rotation: &Mat3<Dual<K>>,
        (x, f): (&[f64], &[f64]),
        at: usize,
        a: &mut [f64],
    ) {
        let r = rotation.each(|entry| entry.re);
        let inverse = r.column(0).norm_squared().recip();
        let against = Vec3::from_slice(&x[self.velocity..]) - self.wind;
        let acceleration = r.transpose_mul(Vec3::from_slice(&f[self.velocity..])) * inverse;
        let changes: [_; K] = std::array::from_fn(|k| {
            let change = rotation.each(|entry| entry.eps[k]);
            let felt = self.accelerations.map(|field| change.transpose_mul(field));
            (r * change.transpose_mul(against) * inverse, felt, change * acceleration)
        });
        // What each component of the velocity and of the fields adds to the columns, side by side.
        let mut by = [[0.0; K]; 9];
        for (k, (velocity, [gravity, air], _)) in changes.iter().enumerate() {
            for i in 0..3 {
                (by[i][k], by[3 + i][k], by[6 + i][k]) = (velocity[i], gravity[i], air[i]);
            }
        }
        for (i, fields) in self.fields.as_chunks::<6>().0.iter().enumerate() {
            let (row, mut sum) = (&mut a[i * x.len()..][..x.len()], [0.0; K]);
            if !(self.position..self.position + 3).contains(&i) {
                for (value, by) in row[self.velocity..][..3].iter().chain(fields).zip(&by) {
                    for k in 0..K {
                        sum[k] = fused(*value, by[k], sum[k]);
                    }
                }
            }
            row[at..][..K].copy_from_slice(&sum);
        }
        for (i, row) in a.chunks_exact_mut(x.len()).skip(self.velocity).take(3).enumerate() {
            for (value, (.., turned)) in row[at..].iter_mut().zip(&changes) {
                *value += turned[i];
            }
        }
    }
}

//! A transcription: the weights of a running cost and the defect of an interval.

use crate::plant::Fault;
use wingbeat_math::Scalar;
use wingbeat_math::interpolation::{hermite, lerp};

/// Times, states, inputs and rates at the two ends of an interval.
#[derive(Clone, Copy, Debug)]
pub struct IntervalEnds<'a, S: Scalar> {
    /// Time at the start, s.
    pub t: S,
    /// Length, s.
    pub h: S,
    /// States at both ends, n each, in the units of their channels.
    pub x: [&'a [S]; 2],
    /// Inputs at both ends, one for each channel and in the units of these.
    pub u: [&'a [S]; 2],
    /// Rates f(t, x, u) at both ends, n each, in the units of the states per s.
    pub f: [&'a [S]; 2],
}

/// State, input and rates at the middle of an interval; made once, reused.
#[derive(Clone, Debug)]
pub struct Midpoint<S: Scalar> {
    /// State, n, in the units of the states.
    pub x: Vec<S>,
    /// Input, one number for each channel and in its unit.
    pub u: Vec<S>,
    /// Rates, n, in the units of the states per s.
    pub f: Vec<S>,
}

impl<S: Scalar> Midpoint<S> {
    /// Storage for `states` states and `inputs` inputs.
    pub fn new(states: usize, inputs: usize) -> Self {
        Self { x: vec![S::ZERO; states], u: vec![S::ZERO; inputs], f: vec![S::ZERO; states] }
    }
}

/// How the dynamics hold on an interval with unknowns at its two ends. The
/// input is linear in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transcription {
    /// x quadratic, rates linear between the ends: order 2.
    Trapezoid,
    /// x cubic, rates exact at both ends and in the middle: order 4
    /// (Hargraves & Paris 1987; third-order Lobatto).
    HermiteSimpson,
}

impl Transcription {
    /// Order of accuracy: the error at a fixed time falls as h^order.
    pub fn order(self) -> i32 {
        match self {
            Self::Trapezoid => 2,
            Self::HermiteSimpson => 4,
        }
    }

    /// Quadrature of a running cost on an interval of length 1, as shares of the length: (abscissa, weight) of each point.
    pub fn quadrature(self) -> &'static [(f64, f64)] {
        match self {
            Self::Trapezoid => &[(0.0, 0.5), (1.0, 0.5)],
            Self::HermiteSimpson => &[(0.0, 1.0 / 6.0), (0.5, 2.0 / 3.0), (1.0, 1.0 / 6.0)],
        }
    }

    /// Writes the defect of `interval` (n, in the units of the states): what the end state lacks. `rates` evaluates f(t, x, u)
    /// and is called once, in the middle, by Hermite-Simpson, and never by the trapezoid; its point stays in `middle`.
    ///
    /// Trapezoid: x1 - x0 - h/2 (f0 + f1).
    /// Hermite-Simpson: x1 - x0 - h/6 (f0 + 4 fc + f1).
    ///
    /// Equation: ocp.defect
    /// `x1 - x0 - h/6 (f0 + 4 fc + f1); trapezoid x1 - x0 - h/2 (f0 + f1)`
    /// Source: Hargraves & Paris 1987; Betts 2010, ch. 4; Paper section IV.
    /// Test: `defects_vanish_one_order_above_the_method`.
    pub fn defect<S: Scalar>(
        self,
        interval: &IntervalEnds<S>,
        rates: impl FnOnce(S, &[S], &[S], &mut [S]) -> Result<(), Fault>,
        middle: &mut Midpoint<S>,
        defect: &mut [S],
    ) -> Result<(), Fault> {
        let IntervalEnds { t, h, x: [x0, x1], f: [f0, f1], .. } = *interval;
        match self {
            Self::Trapezoid => {
                for i in 0..defect.len() {
                    defect[i] = x1[i] - x0[i] - h * 0.5 * (f0[i] + f1[i]);
                }
            }
            Self::HermiteSimpson => {
                interval.middle(middle);
                rates(t + h * 0.5, &middle.x, &middle.u, &mut middle.f)?;
                for i in 0..defect.len() {
                    defect[i] = x1[i] - x0[i] - h * (1.0 / 6.0) * (f0[i] + middle.f[i] * 4.0 + f1[i]);
                }
            }
        }
        Ok(())
    }

    /// Value and slope (in its unit and that per s) of the interpolated state component `i` at the fraction `s` in [0, 1] of
    /// the interval.
    pub fn state<S: Scalar>(self, interval: &IntervalEnds<S>, s: S, i: usize) -> (S, S) {
        let IntervalEnds { h, x: [x0, x1], f: [f0, f1], .. } = *interval;
        match self {
            Self::Trapezoid => {
                let slope = lerp(f0[i], f1[i], s);
                (x0[i] + s * h * 0.5 * (f0[i] + slope), slope)
            }
            Self::HermiteSimpson => hermite(s * h, h, [x0[i], x1[i]], [f0[i], f1[i]]),
        }
    }
}

impl<S: Scalar> IntervalEnds<'_, S> {
    /// Midpoint of the cubic through both ends:
    /// xc = (x0 + x1)/2 + h/8 (f0 - f1), uc = (u0 + u1)/2.
    ///
    /// Equation: ocp.midpoint
    /// `xc = (x0 + x1)/2 + h/8 (f0 - f1), uc = (u0 + u1)/2`
    /// Source: Hargraves & Paris 1987; Paper section IV.
    /// Test: `defects_vanish_one_order_above_the_method`.
    pub fn middle(&self, middle: &mut Midpoint<S>) {
        let IntervalEnds { h, x: [x0, x1], u: [u0, u1], f: [f0, f1], .. } = *self;
        for (i, x) in middle.x.iter_mut().enumerate() {
            *x = (x0[i] + x1[i]) * 0.5 + h * 0.125 * (f0[i] - f1[i]);
        }
        for (j, u) in middle.u.iter_mut().enumerate() {
            *u = (u0[j] + u1[j]) * 0.5;
        }
    }

    /// Interpolated input component `j`, in the unit of the input, at the fraction `s` in [0, 1].
    pub fn input(&self, s: S, j: usize) -> S {
        lerp(self.u[0][j], self.u[1][j], s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest defect of x' = x + u, x = e^t, u = 0 sampled exactly on [0, h].
    fn defect_of_exponential(transcription: Transcription, h: f64) -> f64 {
        let ends = [1.0, h.exp()];
        let interval = IntervalEnds {
            t: 0.0,
            h,
            x: [&ends[..1], &ends[1..]],
            u: [&[0.0], &[0.0]],
            f: [&ends[..1], &ends[1..]],
        };
        let mut defect = [0.0];
        let rates = |_: f64, x: &[f64], u: &[f64], dx: &mut [f64]| {
            dx[0] = x[0] + u[0];
            Ok(())
        };
        transcription.defect(&interval, rates, &mut Midpoint::new(1, 1), &mut defect).unwrap();
        defect[0].abs()
    }

    #[test]
    fn defects_vanish_one_order_above_the_method() {
        for method in [Transcription::Trapezoid, Transcription::HermiteSimpson] {
            let order = (defect_of_exponential(method, 0.2) / defect_of_exponential(method, 0.1)).log2();
            assert!((order - method.order() as f64 - 1.0).abs() < 0.1, "{method:?}: {order}");
        }
    }

    #[test]
    fn quadratures_integrate_to_their_order() {
        for method in [Transcription::Trapezoid, Transcription::HermiteSimpson] {
            let power = method.order() - 1;
            let sum: f64 = method.quadrature().iter().map(|(s, w)| w * s.powi(power)).sum();
            assert!((sum - 1.0 / (power + 1) as f64).abs() < 1e-15);
        }
    }

    #[test]
    fn interpolants_meet_the_ends() {
        let interval =
            IntervalEnds { t: 0.0, h: 0.5, x: [&[1.0], &[2.0]], u: [&[0.0], &[4.0]], f: [&[3.0], &[1.0]] };
        let (start, slope) = Transcription::HermiteSimpson.state(&interval, 0.0, 0);
        assert!((start - 1.0).abs() < 1e-15 && (slope - 3.0).abs() < 1e-15);
        // The trapezoid's defect is zero here, so its quadratic meets the end too.
        for method in [Transcription::Trapezoid, Transcription::HermiteSimpson] {
            let (end, slope) = method.state(&interval, 1.0, 0);
            assert!((end - 2.0).abs() < 1e-15 && (slope - 1.0).abs() < 1e-15);
        }
        assert_eq!(interval.input(0.25, 0), 1.0);
    }
}

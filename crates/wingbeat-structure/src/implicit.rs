//! Implicit steps of stiff systems by two stages: Gauss's rule, which conserves quadratic invariants, and Radau's, which lets motions die
//! away that the steps do not resolve. Both are stable for any step.

use nalgebra::{DMatrix, DVector, Dyn, LU};

/// State and rates of a system of second and of first order at one instant. Coordinates and states are in the caller's units,
/// rates in those per s.
#[derive(Clone, Debug, Default)]
pub struct Stage {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Their rates.
    pub v: Vec<f64>,
    /// Their accelerations.
    pub a: Vec<f64>,
    /// States of first order.
    pub x: Vec<f64>,
    /// Their rates.
    pub w: Vec<f64>,
}

/// Where the two stages of a step lie and how they count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// Of order four; keeps energy and momentum, and so also what the steps do not resolve.
    #[default]
    Gauss,
    /// Radau IIA, of order three: what is much faster than a step is at rest after it.
    Radau,
}

/// Equations F(t, q, v, a, x, w) = 0, as many as accelerations and rates. Coordinates and equations are in the caller's units,
/// times in s.
pub trait Implicit {
    /// The rule of its steps.
    fn rule(&self) -> Rule {
        Rule::Gauss
    }
    /// Sizes of the coordinates and of the states of first order, in the caller's units, below which they are rounding: changes of smaller
    /// ones are measured by these.
    fn least(&self) -> [f64; 2] {
        [f64::MIN_POSITIVE; 2]
    }
    /// Writes F.
    fn residual(&self, t: f64, at: &Stage, out: &mut [f64]);
    /// Derivatives of F by q, v, a, x and w.
    fn tangents(&self, t: f64, at: &Stage) -> [DMatrix<f64>; 5];
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepped {
    /// Whether its equations were solved.
    pub converged: bool,
    /// Newton steps.
    pub iterations: usize,
}

/// Factors of the matrix of a step, kept while they serve.
pub type StepFactors = Option<(f64, LU<f64, Dyn, Dyn>)>;

/// Most Newton steps of one step in time.
const MOST: usize = 30;
/// Newton steps beyond which the tangents are taken anew in the next step.
const SLOW: usize = 6;
/// Change by a Newton step of what the step in time adds to coordinates and states, over their size, at which it is taken.
const TOLERANCE: f64 = 1e-14;
/// The same where it does not become less: rounding of a stiff structure, whose accelerations are small differences.
const ROUNDED: f64 = 1e-11;

/// Coefficients of the stages, A, their weights b and places c.
struct Table {
    a: [[f64; 2]; 2],
    b: [f64; 2],
    c: [f64; 2],
}

impl Rule {
    /// Equation: structure.gauss
    /// `A = [1/4, 1/4 - r; 1/4 + r, 1/4], b = 1/2, c = 1/2 -+ r, r = sqrt(3)/6`
    /// Source: Butcher 1964; Hairer, Lubich & Wanner 2006, II.1.3.
    /// Test: `steps_are_of_fourth_order_and_keep_the_energy_of_a_spring`.
    ///
    /// Equation: structure.radau
    /// `A = [5/12, -1/12; 3/4, 1/4], b = [3/4, 1/4], c = [1/3, 1]`
    /// Source: Ehle 1969; Hairer & Wanner 1996, IV.5.
    /// Test: `a_spring_that_is_not_resolved_comes_to_rest`.
    fn table(self) -> Table {
        match self {
            Self::Gauss => {
                let r = 3.0_f64.sqrt() / 6.0;
                Table { a: [[0.25, 0.25 - r], [0.25 + r, 0.25]], b: [0.5; 2], c: [0.5 - r, 0.5 + r] }
            }
            Self::Radau => {
                Table { a: [[5.0 / 12.0, -1.0 / 12.0], [0.75, 0.25]], b: [0.75, 0.25], c: [1.0 / 3.0, 1.0] }
            }
        }
    }
}

/// Advances `at` from `t` by `h`, both in s. Its accelerations and rates are where the search begins and become those of the last
/// stage.
pub fn step(system: &impl Implicit, t: f64, h: f64, at: &mut Stage, factors: &mut StepFactors) -> Stepped {
    let Table { a, b, c } = system.rule().table();
    let (n, m) = (at.q.len(), at.x.len());
    let size = n + m;
    let square: [[f64; 2]; 2] =
        std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * a[0][j] + a[i][1] * a[1][j]));
    let fresh = factors.as_ref().is_none_or(|(length, _)| *length != h);
    if fresh {
        *factors = factored(system, t, h, at, &a, &square).map(|lu| (h, lu));
    }
    let mut rates: Vec<f64> = [&at.a[..], &at.w, &at.a, &at.w].concat();
    let mut stages = [at.clone(), at.clone()];
    let mut out = vec![0.0; 2 * size];
    let (mut iterations, mut converged, mut before) = (0, false, f64::INFINITY);
    while let (false, true, Some((_, lu))) = (converged, iterations < MOST, factors.as_ref()) {
        for (i, stage) in stages.iter_mut().enumerate() {
            let rate = |j: usize, k: usize| rates[j * size + k];
            for k in 0..n {
                stage.a[k] = rate(i, k);
                stage.v[k] = at.v[k] + h * (a[i][0] * rate(0, k) + a[i][1] * rate(1, k));
                let bent = square[i][0] * rate(0, k) + square[i][1] * rate(1, k);
                stage.q[k] = at.q[k] + h * c[i] * at.v[k] + h * h * bent;
            }
            for k in 0..m {
                stage.w[k] = rate(i, n + k);
                stage.x[k] = at.x[k] + h * (a[i][0] * rate(0, n + k) + a[i][1] * rate(1, n + k));
            }
            system.residual(t + c[i] * h, stage, &mut out[i * size..][..size]);
        }
        iterations += 1;
        let Some(change) = lu.solve(&DVector::from_column_slice(&out)) else { break };
        if !change.iter().all(|x| x.is_finite()) {
            break;
        }
        rates.iter_mut().zip(change.iter()).for_each(|(rate, change)| *rate -= change);
        let largest_of = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let mut largest = 0.0_f64;
        for (rates, change) in rates.chunks_exact(size).zip(change.as_slice().chunks_exact(size)) {
            let [least_moved, least_flowed] = system.least();
            let moved = largest_of(&at.q) + h * largest_of(&at.v) + h * h * largest_of(&rates[..n]);
            let flowed = largest_of(&at.x) + h * largest_of(&rates[n..]);
            largest = largest.max(h * h * largest_of(&change[..n]) / moved.max(least_moved));
            largest = largest.max(h * largest_of(&change[n..]) / flowed.max(least_flowed));
        }
        // Only the tangents of this very step tell rounding from slow convergence.
        let stays = largest > 0.5 * before;
        converged = largest < TOLERANCE || (fresh && stays && largest < ROUNDED);
        if stays && !fresh && !converged {
            break;
        }
        before = largest;
    }
    if !converged && !fresh {
        // Once more with tangents of its own.
        *factors = None;
        return step(system, t, h, at, factors);
    }
    if iterations > SLOW {
        *factors = None;
    }
    for k in 0..n {
        let [one, two] = [rates[k], rates[size + k]];
        let bent = (b[0] * a[0][0] + b[1] * a[1][0]) * one + (b[0] * a[0][1] + b[1] * a[1][1]) * two;
        at.q[k] += h * at.v[k] + h * h * bent;
        at.v[k] += h * (b[0] * one + b[1] * two);
    }
    (0..m).for_each(|k| at.x[k] += h * (b[0] * rates[n + k] + b[1] * rates[size + n + k]));
    at.a.copy_from_slice(&rates[size..size + n]);
    at.w.copy_from_slice(&rates[size + n..]);
    Stepped { converged, iterations }
}

/// The matrix of a step, with the tangents at its beginning.
fn factored(
    system: &impl Implicit,
    t: f64,
    h: f64,
    at: &Stage,
    a: &[[f64; 2]; 2],
    square: &[[f64; 2]; 2],
) -> Option<LU<f64, Dyn, Dyn>> {
    let (n, size) = (at.q.len(), at.q.len() + at.x.len());
    let [by_q, by_v, by_a, by_x, by_w] = system.tangents(t, at);
    let matrix = DMatrix::from_fn(2 * size, 2 * size, |row, column| {
        let (i, j, r, k) = (row / size, column / size, row % size, column % size);
        let own = if i == j { 1.0 } else { 0.0 };
        if k < n {
            own * by_a[(r, k)] + h * a[i][j] * by_v[(r, k)] + h * h * square[i][j] * by_q[(r, k)]
        } else {
            own * by_w[(r, k - n)] + h * a[i][j] * by_x[(r, k - n)]
        }
    });
    matrix.iter().all(|x| x.is_finite()).then(|| matrix.lu())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x'' = -1e4 x, and w' = -(w - x) beside it.
    struct StiffSpring(Rule);
    impl Implicit for StiffSpring {
        fn rule(&self) -> Rule {
            self.0
        }
        fn residual(&self, _: f64, at: &Stage, out: &mut [f64]) {
            (out[0], out[1]) = (at.a[0] + 1e4 * at.q[0], at.w[0] + at.x[0] - at.q[0]);
        }
        fn tangents(&self, _: f64, _: &Stage) -> [DMatrix<f64>; 5] {
            let column = |a, b| DMatrix::from_column_slice(2, 1, &[a, b]);
            [column(1e4, -1.0), column(0.0, 0.0), column(1.0, 0.0), column(0.0, 1.0), column(0.0, 1.0)]
        }
    }

    fn run(rule: Rule, steps: usize, end: f64) -> Stage {
        let mut at = Stage { q: vec![1.0], v: vec![0.0], a: vec![-1e4], x: vec![0.0], w: vec![1.0] };
        let (h, mut factors) = (end / steps as f64, None);
        for i in 0..steps {
            assert!(step(&StiffSpring(rule), i as f64 * h, h, &mut at, &mut factors).converged);
        }
        at
    }

    #[test]
    fn steps_are_of_fourth_order_and_keep_the_energy_of_a_spring() {
        let exact = (100.0_f64 * 0.1).cos();
        for (rule, known) in [(Rule::Gauss, 4.0), (Rule::Radau, 3.0)] {
            let error = |steps| (run(rule, steps, 0.1).q[0] - exact).abs();
            let order = (error(80) / error(160)).log2();
            assert!((order - known).abs() < 0.2, "{rule:?} {order}");
        }
        // Steps of ten radians of the spring.
        let at = run(Rule::Gauss, 100, 10.0);
        assert!((at.q[0].powi(2) + (at.v[0] / 100.0).powi(2) - 1.0).abs() < 1e-10, "{at:?}");
    }

    /// Steps of ten and of a thousand radians: R(z) of Radau IIA is of order 2/|z|.
    #[test]
    fn a_spring_that_is_not_resolved_comes_to_rest() {
        for step in [0.1, 10.0] {
            let at = run(Rule::Radau, 20, 20.0 * step);
            assert!(at.q[0].hypot(at.v[0] / 100.0) < 1e-12, "{step} {at:?}");
        }
    }
}

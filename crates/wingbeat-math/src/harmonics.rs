//! Harmonics of samples by least squares.

use crate::linear::{lu_factor, lu_solve};
use std::f64::consts::TAU;

/// Pivot of the normal equations, over the number of samples, below which they do not determine a harmonic; samples
/// that lie evenly have 1/2. *Choice.*
const UNDETERMINED: f64 = 1e-6;

/// `mean + sum_n cos[n] cos((n+1) 2 pi f t) + sin[n] sin((n+1) 2 pi f t)`. The mean and the amplitudes are in the caller's
/// units, those of the samples; f is in Hz and t in s.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics {
    /// Mean.
    pub mean: f64,
    /// Cosine amplitudes from the first harmonic on.
    pub cos: Vec<f64>,
    /// Sine amplitudes from the first harmonic on.
    pub sin: Vec<f64>,
}

impl Harmonics {
    /// The harmonics up to `count` of `frequency` nearest to the samples `y` at `t`, by least squares; none where the
    /// samples do not determine them.
    ///
    /// Equation: tether.harmonics
    /// `mean, cos_n, sin_n that minimise the squares of what is left`
    /// Source: Gauss; normal equations.
    /// Test: `harmonics_are_found_in_uneven_samples_of_several_cycles`.
    pub fn fitted(frequency: f64, t: &[f64], y: &[f64], count: usize) -> Option<Self> {
        Self::fitted_each(frequency, t, &[y], count)?.pop()
    }

    /// The same of each of several rows of samples at the same `t`.
    pub fn fitted_each(frequency: f64, t: &[f64], all: &[&[f64]], count: usize) -> Option<Vec<Self>> {
        let size = 2 * count + 1;
        let (mut right, mut sums) = (vec![0.0; size * all.len()], vec![(0.0, 0.0); size]);
        let mut kept = vec![(1.0, 0.0); size];
        for (i, t) in t.iter().enumerate() {
            let phase = TAU * (frequency * t).fract();
            // Of one row the waves need not be kept.
            if let [y] = all {
                waves(phase, &mut sums, |k, cos, sin| {
                    if k <= count {
                        right[k] += cos * y[i];
                        right[if k > 0 { count + k } else { 0 }] += sin * y[i];
                    }
                });
                continue;
            }
            waves(phase, &mut sums, |k, cos, sin| kept[k] = (cos, sin));
            for (right, y) in right.chunks_exact_mut(size).zip(all) {
                let (along, across) = right.split_at_mut(count + 1);
                along.iter_mut().zip(&kept).for_each(|(sum, wave)| *sum += wave.0 * y[i]);
                across.iter_mut().zip(&kept[1..]).for_each(|(sum, wave)| *sum += wave.1 * y[i]);
            }
        }
        let mut normal = normal(&sums);
        let mut pivots = vec![0; size];
        let known = lu_factor(&mut normal, size, &mut pivots)
            && (0..size).all(|i| normal[i * size + i].abs() > UNDETERMINED * t.len() as f64);
        let solved = |right: &mut [f64]| {
            lu_solve(&normal, size, &pivots, right, 1);
            Self { mean: right[0], cos: right[1..=count].to_vec(), sin: right[count + 1..].to_vec() }
        };
        known.then(|| right.chunks_exact_mut(size).map(solved).collect())
    }

    /// The sum at `cycles` of the fundamental.
    pub fn at(&self, cycles: f64) -> f64 {
        let (step_sin, step_cos) = (TAU * cycles.fract()).sin_cos();
        let (mut c, mut s, mut sum) = (step_cos, step_sin, self.mean);
        for (cos, sin) in self.cos.iter().zip(&self.sin) {
            sum += cos * c + sin * s;
            (c, s) = (c * step_cos - s * step_sin, s * step_cos + c * step_sin);
        }
        sum
    }

    /// The sums of each of `all` at the places `cycles`, in cycles of their fundamental, in the unit of what was fitted.
    pub fn each_at(all: &[Self], cycles: &[f64]) -> Vec<Vec<f64>> {
        let most = all.iter().map(|one| one.cos.len()).max().unwrap_or(0);
        let (mut sums, mut waves) =
            (vec![Vec::with_capacity(cycles.len()); all.len()], vec![(0.0, 0.0); most]);
        for cycles in cycles {
            let (step_sin, step_cos) = (TAU * cycles.fract()).sin_cos();
            let (mut c, mut s) = (step_cos, step_sin);
            for wave in &mut waves {
                *wave = (c, s);
                (c, s) = (c * step_cos - s * step_sin, s * step_cos + c * step_sin);
            }
            for (one, sums) in all.iter().zip(&mut sums) {
                let mut sum = one.mean;
                for ((cos, sin), (c, s)) in one.cos.iter().zip(&one.sin).zip(&waves) {
                    sum += cos * c + sin * s;
                }
                sums.push(sum);
            }
        }
        sums
    }
}

/// Adds cos(k x) and sin(k x) to the sums, k from 0 on, and hands them on.
#[inline(always)]
fn waves(x: f64, sums: &mut [(f64, f64)], mut each: impl FnMut(usize, f64, f64)) {
    let (step_sin, step_cos) = x.sin_cos();
    let (mut cos, mut sin) = (1.0, 0.0);
    for (k, sum) in sums.iter_mut().enumerate() {
        *sum = (sum.0 + cos, sum.1 + sin);
        each(k, cos, sin);
        (cos, sin) = (cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin);
    }
}

/// Sums of the products of 1, cos(k x) and sin(k x), k up to n, from those of cos(k x) and sin(k x), k up to 2 n.
fn normal(sums: &[(f64, f64)]) -> Vec<f64> {
    let (size, count) = (sums.len(), sums.len() / 2);
    let cos = |k: usize| sums[k].0;
    let product = |i: usize, j: usize| match (i.checked_sub(count + 1), j.checked_sub(count + 1)) {
        (None, None) => cos(i.abs_diff(j)) + cos(i + j),
        (Some(m), Some(n)) => cos(m.abs_diff(n)) - cos(m + n + 2),
        (None, Some(n)) => mixed(sums, i, n + 1),
        (Some(m), None) => mixed(sums, j, m + 1),
    };
    (0..size * size).map(|at| 0.5 * product(at / size, at % size)).collect()
}

/// Twice the sum of cos(m x) sin(n x).
fn mixed(sums: &[(f64, f64)], m: usize, n: usize) -> f64 {
    let apart = sums[m.abs_diff(n)].1;
    sums[m + n].1 + if n < m { -apart } else { apart }
}

//! The discrete Fourier transform of even samples.

use std::f64::consts::TAU;

/// Squares of the magnitudes of `X[k] = sum_n x[n] exp(-2 pi i k n / N)` for k from 0 to N / 2, N the least power of two
/// that is at least `length` and the number of samples; zeros stand behind the samples.
///
/// Radix-2 decimation in time: J. W. Cooley, J. W. Tukey, "An algorithm for the machine calculation of complex Fourier
/// series", Math. Comput. 19 (1965) 297-301.
pub fn power_spectrum(samples: &[f64], length: usize) -> Vec<f64> {
    let size = samples.len().max(length).max(2).next_power_of_two();
    let shift = usize::BITS - size.trailing_zeros();
    let mut of: Vec<(f64, f64)> = vec![(0.0, 0.0); size];
    for (n, x) in samples.iter().enumerate() {
        of[n.reverse_bits() >> shift] = (*x, 0.0);
    }
    let turn: Vec<(f64, f64)> = (0..size / 2)
        .map(|k| {
            let (sin, cos) = (TAU * k as f64 / size as f64).sin_cos();
            (cos, -sin)
        })
        .collect();
    let mut half = 1;
    while half < size {
        let step = size / (2 * half);
        for block in of.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let (cos, sin) = turn[k * step];
                let turned = (b.0 * cos - b.1 * sin, b.0 * sin + b.1 * cos);
                *b = (a.0 - turned.0, a.1 - turned.1);
                *a = (a.0 + turned.0, a.1 + turned.1);
            }
        }
        half *= 2;
    }
    of[..=size / 2].iter().map(|(re, im)| re * re + im * im).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_sum_that_defines_it() {
        let samples: Vec<f64> =
            (0..23).map(|n| (0.7 * f64::from(n)).sin() + 0.1 * f64::from(n * n % 7)).collect();
        let power = power_spectrum(&samples, 40);
        assert_eq!(power.len(), 33);
        for (k, found) in power.iter().enumerate() {
            let (re, im) = samples.iter().enumerate().fold((0.0, 0.0), |(re, im), (n, x)| {
                let (sin, cos) = (TAU * (k * n) as f64 / 64.0).sin_cos();
                (re + x * cos, im - x * sin)
            });
            assert!((found - (re * re + im * im)).abs() < 1e-10, "{k}");
        }
    }

    #[test]
    fn nothing_has_no_power() {
        assert_eq!(power_spectrum(&[], 0), [0.0, 0.0]);
    }
}

//! Legendre polynomials and Gauss points.

/// Values at `x` in [-1, 1] of the first `count` Legendre polynomials, dimensionless.
pub fn legendre(x: f64, count: usize) -> Vec<f64> {
    let mut values = vec![1.0, x];
    for n in 1..count.saturating_sub(1) {
        let n = n as f64;
        let at = values.len();
        values.push(((2.0 * n + 1.0) * x * values[at - 1] - n * values[at - 2]) / (n + 1.0));
    }
    values.truncate(count);
    values
}

/// Places in [-1, 1] and weights of the Gauss-Legendre rule of `count` points, ascending, by Newton's method
/// (Abramowitz & Stegun 25.4.29).
pub fn gauss(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let mut points: Vec<(f64, f64)> = (0..count)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let values = legendre(x, count + 1);
                slope = n * (x * values[count] - values[count - 1]) / (x * x - 1.0);
                let change = values[count] / slope;
                x -= change;
                if change.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect();
    points.reverse();
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_points_integrate_polynomials_of_twice_their_number() {
        for count in 1..12 {
            for power in 0..2 * count {
                let sum: f64 = gauss(count).iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = if power % 2 == 0 { 2.0 / (power + 1) as f64 } else { 0.0 };
                assert!((sum - exact).abs() < 1e-14, "{count} {power} {sum}");
            }
        }
        assert_eq!(legendre(0.5, 3), [1.0, 0.5, -0.125]);
    }
}

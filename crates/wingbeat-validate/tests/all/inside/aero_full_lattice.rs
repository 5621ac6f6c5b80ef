use std::f64::consts::PI;

use wingbeat_validate::aero_full::lattice::*;

#[test]
fn steady_slope_is_that_of_a_finer_lattice() {
    // Slope of AR 4, validation/lifting_surface/steady.csv.
    let loading = loading(4.0, 0.0, 6, 16).unwrap();
    let step = PI / 17.0;
    let weights = (1..=8).map(|j| 2.0 * step * (f64::from(j) * step).sin());
    let slope: f64 = loading.force.iter().zip(weights).map(|(f, w)| f.0 * w).sum::<f64>() / 2.0;
    assert!((slope / 3.612014 - 1.0).abs() < 0.005, "{slope}");
}

#[test]
fn far_behind_the_downwash_drags_like_the_trefftz_plane() {
    // Induced drag 0.5 sum(Gamma w dy) of the loading's own wake far behind, for nearly elliptic loading L^2/(pi q b^2).
    let loading = loading(6.0, 0.0, 6, 32).unwrap();
    let step = PI / 33.0;
    let width = |j: usize| 6.0 * 0.5 * step * (j as f64 * step).sin();
    let wash = downwash(6.0, 1e4, 6, 32).unwrap();
    let sums = (1..=16).fold((0.0, 0.0), |sum, j| {
        let gamma = loading.circulation[j - 1].0 * width(j);
        (sum.0 + 2.0 * gamma, sum.1 + 2.0 * 0.5 * gamma * wash[j - 1].1)
    });
    let elliptic = sums.0 * sums.0 / (0.5 * PI * 36.0);
    assert!(sums.1 > elliptic && sums.1 < 1.06 * elliptic, "{sums:?} {elliptic}");
}

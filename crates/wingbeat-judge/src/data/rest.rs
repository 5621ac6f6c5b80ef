//! Whether what is taken for a rest is one.

/// Scatter in the quarter of `rest` where it is largest, about the mean of the rest, over that of `moving` about its own, dimensionless; values that
/// are no numbers count as missing. None where nothing moves. A channel that is quiet at rest tells whether it was one: others may be noise
/// throughout.
pub fn rest_scatter(rest: &[f64], moving: &[f64]) -> Option<f64> {
    let (at_rest, after) = (mean(rest), scatter(moving, mean(moving)));
    let quarters = rest.chunks(rest.len().div_ceil(4).max(1));
    let most = quarters.map(|quarter| scatter(quarter, at_rest)).fold(0.0, f64::max);
    (after > 0.0).then(|| most / after)
}

/// Mean of the values that are numbers, in their unit.
pub fn mean(values: &[f64]) -> f64 {
    let finite = || values.iter().filter(|value| value.is_finite());
    finite().sum::<f64>() / finite().count() as f64
}

/// Root mean square of what the values that are numbers lie off `mean`; 0 where none is one.
fn scatter(values: &[f64], mean: f64) -> f64 {
    let finite = || values.iter().filter(|value| value.is_finite());
    (finite().map(|value| (value - mean).powi(2)).sum::<f64>() / finite().count().max(1) as f64).sqrt()
}

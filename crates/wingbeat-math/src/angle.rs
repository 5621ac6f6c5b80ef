//! Angles that go round.

use std::f64::consts::TAU;

/// The whole turns, rad, without which `angle` lies within half a turn of `near`.
pub fn whole_turns(angle: f64, near: f64) -> f64 {
    TAU * ((angle - near) / TAU).round()
}

/// The pitch, rad, of the body frame x forward, y left, z up, about whose y axis nose down is positive, from how far the nose is
/// up, deg, as documents give it. Zero stays zero without a sign.
pub fn pitch_of_nose_up(deg: f64) -> f64 {
    0.0 - deg.to_radians()
}

/// An angle over time, rad, without jumps by whole turns; gaps that are not finite are bridged by straight lines.
pub fn unwrapped(mut angles: Vec<f64>) -> Vec<f64> {
    let mut last: Option<usize> = None;
    for row in 0..angles.len() {
        if !angles[row].is_finite() {
            continue;
        }
        if let Some(before) = last {
            angles[row] -= whole_turns(angles[row], angles[before]);
            let (from, step) = (angles[before], angles[row] - angles[before]);
            for k in before + 1..row {
                angles[k] = from + step * (k - before) as f64 / (row - before) as f64;
            }
        }
        last = Some(row);
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_taken_out_and_gaps_bridged() {
        let true_angle = |k: usize| 0.9 * k as f64 - 2.0;
        let mut seen: Vec<f64> = (0..40).map(|k| true_angle(k).sin().atan2(true_angle(k).cos())).collect();
        (seen[5], seen[6]) = (f64::NAN, f64::INFINITY);
        let straight = unwrapped(seen);
        assert!(straight.iter().enumerate().all(|(k, angle)| (angle - true_angle(k)).abs() < 1e-12));
        assert!(unwrapped(Vec::new()).is_empty());
        assert!(unwrapped(vec![f64::NAN, 1.0])[0].is_nan(), "nothing stands before the first value");
    }
}

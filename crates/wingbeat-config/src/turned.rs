//! The mean roll of a flight that turns for a part of its time.

use std::f64::consts::TAU;

/// Share of the largest bank from which on a cycle is of the turn. *Choice.*
const TURNING: f64 = 0.98;
/// Least bank of a turn, rad. *Choice*: beyond what flapping asks of a straight flight.
const LEAST_BANK: f64 = 0.05;
/// Cycles that a turn lasts at least. *Choice*: a gust makes a straight flight bank for less than one.
const LASTS: f64 = 2.0;
/// Part of a cycle, rad, that rounding takes from a whole one. *Choice.*
const ROUNDING: f64 = 1e-6;

/// Mean roll, rad, over the whole cycles over which the mean bank `asked` is nearly the largest; none without such a turn to one side, where
/// all cycles are of it, where it lasts less than two, and where there is no whole one. Where `phase` (rad) stands still, every sample counts as a cycle.
///
/// `mean of R over the ends of cycles with |A| >= .98 max |A|, R and A the means of roll and asked roll over the cycle before`
/// Source: own derivation. In a stroke the asked roll itself swings, so that instants of a large one are the crests alone.
/// Test: `the_swing_of_a_stroke_leaves_the_mean_roll_of_a_turn_as_it_is`.
pub(super) fn mean_roll(phase: &[f64], roll: &[f64], asked: &[f64]) -> Option<f64> {
    let (rolls, banks) = (cycle_means(phase, roll), cycle_means(phase, asked));
    let size = |bank: &f64| bank.abs();
    let largest = *banks.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
    let turning = |bank: f64| bank.abs() >= TURNING * largest.abs();
    let one_sided = banks.iter().all(|bank| !turning(*bank) || bank.signum() == largest.signum());
    let in_turn = || rolls.iter().zip(&banks).filter(|(_, bank)| turning(**bank)).map(|(roll, _)| *roll);
    let count = in_turn().count();
    let lasts = match phase {
        [first, .., last] if last > first => {
            let whole = phase.len() - banks.len();
            let steps = phase[whole..].windows(2).zip(&banks[1..]).filter(|(_, bank)| turning(**bank));
            steps.map(|(phase, _)| phase[1] - phase[0]).sum::<f64>() >= LASTS * TAU
        }
        _ => true,
    };
    let part =
        largest.is_finite() && largest.abs() >= LEAST_BANK && one_sided && lasts && count < rolls.len();
    part.then(|| in_turn().sum::<f64>() / count as f64)
}

/// Means of `values` over the cycle of `phase` (rad) that ends at each sample, of those that have a whole one before them, by the trapezoidal
/// rule; the values themselves where the phase stands still.
fn cycle_means(phase: &[f64], values: &[f64]) -> Vec<f64> {
    let ([first, .., last], true) = (phase, phase.len() == values.len()) else { return Vec::new() };
    if last <= first {
        return values.to_vec();
    }
    // Integrals up to each sample.
    let mut sums = vec![0.0; values.len()];
    for k in 1..values.len() {
        sums[k] = sums[k - 1] + 0.5 * (values[k - 1] + values[k]) * (phase[k] - phase[k - 1]);
    }
    let mut k = 0;
    let over = |end: usize| {
        let begin = (phase[end] - TAU).max(*first);
        while k + 2 < phase.len() && phase[k + 1] <= begin {
            k += 1;
        }
        let way = begin - phase[k];
        let slope = (values[k + 1] - values[k]) / (phase[k + 1] - phase[k]).max(f64::MIN_POSITIVE);
        let before = sums[k] + way * (values[k] + 0.5 * slope * way);
        (sums[end] - before) / TAU
    };
    let whole = phase.partition_point(|phase| phase - first < TAU - ROUNDING);
    (whole..phase.len()).map(over).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rolls of a flight of `cycles` cycles of 50 samples and a bit: level, then banked by `bank` with a swing of `swing`, rad.
    fn flight(cycles: f64, bank: f64, swing: f64) -> [Vec<f64>; 2] {
        let phase: Vec<f64> = (0..(50.3 * cycles) as usize).map(|k| k as f64 * TAU / 50.3).collect();
        let turn = |phase: f64| if phase < 0.5 * cycles * TAU { 0.0 } else { bank };
        let roll = phase.iter().map(|phase| turn(*phase) + swing * phase.sin()).collect();
        [phase, roll]
    }

    #[test]
    fn the_swing_of_a_stroke_leaves_the_mean_roll_of_a_turn_as_it_is() {
        for (bank, swing) in [(0.5, 0.0), (0.5, 0.06), (-0.5, 0.2)] {
            let [phase, roll] = flight(20.0, bank, swing);
            let mean = mean_roll(&phase, &roll, &roll).unwrap();
            assert!((mean - bank).abs() < 5e-4, "{bank} {swing}: {mean}");
        }
    }

    #[test]
    fn what_is_no_turn_for_a_part_of_the_flight_has_no_mean_roll() {
        let [phase, level] = flight(20.0, 0.0, 0.04);
        assert_eq!(mean_roll(&phase, &level, &level), None);
        let [phase, short] = flight(0.9, 0.5, 0.0);
        assert_eq!(mean_roll(&phase, &short, &short), None);
        let [phase, mut both] = flight(20.0, 0.5, 0.06);
        both.iter_mut().take(200).for_each(|roll| *roll = -0.5);
        assert_eq!(mean_roll(&phase, &both, &both), None);
        // A gust on a straight path: the asked bank swells and ebbs.
        let [phase, _] = flight(20.0, 0.0, 0.0);
        let gust: Vec<f64> =
            phase.iter().map(|phase| 0.3 * (-(phase - 60.0).powi(2) / 200.0).exp()).collect();
        assert_eq!(mean_roll(&phase, &gust, &gust), None);
        assert_eq!(mean_roll(&phase, &[0.5; 3], &[0.5; 3]), None);
        assert_eq!(mean_roll(&[1.0; 4], &[0.1, 0.1, 0.5, 0.6], &[0.0, 0.0, 0.5, 0.5]), Some(0.55));
    }
}

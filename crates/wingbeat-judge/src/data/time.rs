//! When the samples were taken: order and gaps.

use super::{Finding, Series};
use crate::limits::data::{BACKWARD, LOST, NOT_FINITE};

/// A step longer than so many usual ones is a gap; jitter of a clock stays below. *Choice.*
const GAP: f64 = 3.5;
/// Fewer samples tell no usual step. *Choice.*
const FEW: usize = 16;

/// Steps that go back and samples that are missing.
pub fn findings(series: &Series) -> Vec<Finding> {
    let phase = series.phase;
    let wrong = phase.iter().filter(|p| !p.is_finite()).count();
    if wrong > 0 {
        let text = format!("{wrong} times are not finite: mend the file");
        return vec![Finding::new("data.time", &NOT_FINITE, series.what, wrong as f64, text)];
    }
    let back = phase.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    if back > 0 {
        let text = format!(
            "time does not go ahead at {back} of {} samples: sort them, or cut the file",
            phase.len()
        );
        return vec![Finding::new("data.time", &BACKWARD, series.what, back as f64, text)];
    }
    lost(series).into_iter().collect()
}

/// Samples that are missing in gaps of otherwise even samples.
fn lost(series: &Series) -> Option<Finding> {
    let mut steps: Vec<f64> = series.phase.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < FEW {
        return None;
    }
    let gaps: Vec<f64> = {
        let middle = steps.len() / 2;
        let usual = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        steps
            .into_iter()
            .filter(|step| *step > GAP * usual)
            .map(|step| (step / usual).round() - 1.0)
            .collect()
    };
    let lost: f64 = gaps.iter().sum();
    let share = lost / (lost + series.phase.len() as f64);
    let text = format!(
        "about {lost:.0} samples are missing in {} gaps, {:.1} % of all: curves through the gaps are invented; \
         record again, or cut the file to its whole part",
        gaps.len(),
        100.0 * share
    );
    (lost > 0.0).then(|| Finding::new("data.lost", &LOST, series.what, share, text))
}

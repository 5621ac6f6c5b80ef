//! The last whole stroke of a record.

use std::f64::consts::TAU;
use std::ops::Range;

use wingbeat::simulate::Record;

use crate::own_joints;

/// Rows of the last whole cycle of the joint that turns most, from one upward crossing of its mean to the next.
///
/// None when the record holds no whole cycle, or the phase of its gait stands still.
pub fn last(record: &Record) -> Option<Range<usize>> {
    let rests = |phase: &[f64]| phase.first() == phase.last();
    if record.values("phase").is_some_and(rests) {
        return None;
    }
    let turning = own_joints::left(record).filter(|(joint, _)| joint.turns);
    let (_, column) = turning.max_by(|a, b| a.0.range().total_cmp(&b.0.range()))?;
    let angle = &column.values;
    if angle.iter().any(|angle| !angle.is_finite()) {
        return None;
    }
    let mean = angle.iter().sum::<f64>() / angle.len() as f64;
    let upward = |&i: &usize| angle[i - 1] < mean && angle[i] >= mean;
    let crossings: Vec<usize> = (1..angle.len()).filter(upward).collect();
    match crossings[..] {
        [.., from, to] => Some(from..to + 1),
        _ => None,
    }
}

/// Rows of the last whole cycle by the phase of the gait, and their phases, cycles from its start: from 0 to 1. None when the record
/// has no phase (rad, not wrapped), or no whole cycle of it.
pub fn phased(record: &Record) -> Option<(Range<usize>, Vec<f64>)> {
    let cycles: Vec<f64> = record.values("phase")?.iter().map(|phase| phase / TAU).collect();
    // Rounding must not cost the last row of a record that ends with a cycle.
    let end = (cycles.last()? + ROUNDED).floor();
    let within = |cycle: &&f64| **cycle >= end - 1.0 - ROUNDED && **cycle <= end + ROUNDED;
    let first = cycles.iter().position(|cycle| within(&cycle))?;
    let rows = first..first + cycles[first..].iter().take_while(within).count();
    let whole = cycles[0] <= end - 1.0 + ROUNDED && rows.len() > 2;
    whole.then(|| (rows.clone(), cycles[rows].iter().map(|cycle| cycle - (end - 1.0)).collect()))
}

/// What rounding may take from a number of cycles.
const ROUNDED: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::simulate::Column;

    #[test]
    fn a_gait_has_its_phase() {
        let mut record = Record::new(vec![Column::new("phase", "rad", "")], 0).unwrap();
        (0..=250).for_each(|i| record.append(&[0.4 + f64::from(i) * TAU / 100.0]));
        let (rows, phases) = phased(&record).unwrap();
        assert_eq!((rows.start, rows.len()), (94, 100));
        assert!(phases[0] >= 0.0 && phases[0] < 0.01 && phases[99] <= 1.0, "{} {}", phases[0], phases[99]);
        let short = Record::new(vec![Column::new("phase", "rad", "")], 0).unwrap();
        assert_eq!(phased(&short), None);
    }

    #[test]
    fn a_sine_has_its_period() {
        let mut record =
            Record::new(["arm_left", "torque_arm_left"].map(|name| Column::new(name, "rad", "")).to_vec(), 0)
                .unwrap();
        (0..1000)
            .for_each(|i| record.append(&[(f64::from(i) * std::f64::consts::TAU / 90.0 - 0.5).sin(), 0.0]));
        assert_eq!(last(&record).unwrap().len(), 91);
    }

    #[test]
    fn wings_at_rest_have_no_cycle() {
        let mut record =
            Record::new(["arm_left", "torque_arm_left"].map(|name| Column::new(name, "rad", "")).to_vec(), 0)
                .unwrap();
        (0..100).for_each(|_| record.append(&[0.1, 0.0]));
        assert_eq!(last(&record), None);
    }
}

//! The last whole stroke of a record.

use std::ops::Range;

use wingbeat::simulate::Record;

use crate::own_joints;

/// Rows of the last whole cycle of the joint that turns most, from one upward crossing of its mean to the next.
///
/// None when the record holds no whole cycle.
pub fn last(record: &Record) -> Option<Range<usize>> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::simulate::Column;

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

//! The last whole stroke of a record.

use std::ops::Range;

use wingbeat::simulate::Record;

/// Rows of the last whole cycle of `shoulder_left`, from one upward crossing of its mean to the next.
///
/// None when the record holds no whole cycle.
pub fn last(record: &Record) -> Option<Range<usize>> {
    let angle = record.values("shoulder_left")?;
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
        let mut record = Record::new(vec![Column::new("shoulder_left", "rad", "")], 0).unwrap();
        (0..1000).for_each(|i| record.append(&[(f64::from(i) * std::f64::consts::TAU / 90.0 - 0.5).sin()]));
        assert_eq!(last(&record).unwrap().len(), 91);
    }

    #[test]
    fn wings_at_rest_have_no_cycle() {
        let mut record = Record::new(vec![Column::new("shoulder_left", "rad", "")], 0).unwrap();
        (0..100).for_each(|_| record.append(&[0.1]));
        assert_eq!(last(&record), None);
    }
}

//! Roll and heading as they are drawn.

use wingbeat::judge::limits;
use wingbeat::math::unwrapped;
use wingbeat::simulate::Record;

use crate::{Error, needed};

/// Roll and heading of every row, rad, and no number where they say nothing.
#[derive(Clone, Debug)]
pub struct TurnsOfBody {
    /// Right wing down positive, rad, with a gap where it passes half a turn.
    pub roll: Vec<f64>,
    /// Left positive, rad, on beyond half a turn.
    pub heading: Vec<f64>,
}

impl TurnsOfBody {
    /// Those of `record`; both have gaps where the nose points straight up or down, or passes the vertical.
    ///
    /// # Errors
    /// A record without `roll`, `pitch` and `yaw`.
    pub fn of(record: &Record) -> Result<Self, Error> {
        let [roll, pitch, yaw] = ["roll", "pitch", "yaw"].map(|name| needed(record, name));
        let (roll, pitch, yaw) = (roll?, pitch?, yaw?);
        let upright = upright(roll, pitch);
        let told = roll.iter().zip(&upright).map(|(roll, told)| if *told { *roll } else { f64::NAN });
        Ok(Self { roll: parted(told.collect()), heading: headings(yaw, &upright) })
    }
}

/// Whether roll and heading say something: not where the nose points straight up or down, or has passed the vertical since the row before.
fn upright(roll: &[f64], pitch: &[f64]) -> Vec<bool> {
    let leaps = |row: usize| row > 0 && (roll[row] - roll[row - 1]).cos() < 0.0;
    let steep = |pitch: f64| pitch.to_degrees().abs() > limits::flight::VERTICAL.value;
    pitch.iter().enumerate().map(|(row, pitch)| !steep(*pitch) && !leaps(row)).collect()
}

/// Headings without jumps by whole turns, anew after each gap.
fn headings(yaw: &[f64], upright: &[bool]) -> Vec<f64> {
    let rows: Vec<(f64, bool)> = yaw.iter().copied().zip(upright.iter().copied()).collect();
    let stretch = |rows: &[(f64, bool)]| {
        let told = rows[0].1;
        unwrapped(rows.iter().map(|(yaw, _)| if told { *yaw } else { f64::NAN }).collect())
    };
    rows.chunk_by(|a, b| a.1 == b.1).flat_map(stretch).collect()
}

/// Angles with a gap where one leaps from half a turn to the other side.
fn parted(mut angles: Vec<f64>) -> Vec<f64> {
    for i in (1..angles.len()).rev() {
        if (angles[i] - angles[i - 1]).abs() > std::f64::consts::PI {
            angles[i] = f64::NAN;
        }
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use wingbeat::simulate::Column;

    /// A loop in pitch: roll and heading leap by half a turn where the nose passes the vertical.
    #[test]
    fn a_loop_leaves_gaps_in_place_of_leaps() {
        let columns = ["roll", "pitch", "yaw"].map(|name| Column::new(name, "rad", "WB"));
        let mut record = Record::new(columns.into(), 6).unwrap();
        for row in [
            [0.0, -1.2, 3.0],
            [0.0, -1.5, 0.0],
            [PI, -1.4, 0.0],
            [PI, -1.0, -3.0],
            [-PI, -0.5, 3.0],
            [-PI, 0.5, 3.1],
        ] {
            record.append(&row);
        }
        let TurnsOfBody { roll, heading } = TurnsOfBody::of(&record).unwrap();
        // The last leap of roll is a whole turn, which is none, and drawn with a gap.
        assert_eq!(
            roll.iter().map(|roll| roll.is_nan()).collect::<Vec<_>>(),
            [false, true, true, false, true, false]
        );
        assert!(heading[0] == 3.0 && heading[1].is_nan() && heading[2].is_nan() && heading[3] == -3.0);
        assert!((heading[5] - (3.1 - 2.0 * PI)).abs() < 1e-12, "{heading:?}");
        let roll = parted(vec![2.9, 3.1, -3.1, -2.9]);
        assert!(roll[2].is_nan() && (roll[0], roll[1], roll[3]) == (2.9, 3.1, -2.9));
    }
}

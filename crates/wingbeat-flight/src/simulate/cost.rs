//! What a flight costs: the power of its joints, and what carries the weight.

use super::record::{Column, Record};
use std::f64::consts::TAU;
use wingbeat_robot::{Observation, Robot, WeightPart, WeightShares};

/// Strokes that rounding may lack.
const ROUNDING: f64 = 1e-9;

/// Columns of the powers from which a cost is taken.
const POWERS: [&str; 2] = ["joint_power", "separate_power"];
/// What the names of the columns of the shares begin with.
const SHARE: &str = "weight_";

/// Power and shares of the weight, of an instant or as means over a flight or a cycle.
///
/// With the power P_i = torque times rate of each driven joint, and the power that moves the rests of springs as one more:
/// positive = mean of max(0, sum_i P_i), separate = mean of sum_i max(0, P_i), net = mean of sum_i P_i.
///
/// Equation: flight.cost
/// `positive = mean max(0, sum P_i); separate = mean sum max(0, P_i); net = mean sum P_i; P_i = t_i q_i'`
/// Source: Weis-Fogh 1973, J. Exp. Biol. 59 (one drive or one for each joint, without elastic storage).
/// Test: `the_three_powers_of_two_joints_that_work_against_each_other`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// What one drive for all joints gives that takes nothing back, W.
    pub positive_power: f64,
    /// What drives give that share nothing and take nothing back, W.
    pub separate_power: f64,
    /// What drives give that take back all that joints give, W.
    pub net_power: f64,
    /// Upward forces over the weight, by part.
    pub shares: WeightShares,
}

impl Cost {
    fn at([power, separate_power]: [f64; 2], shares: WeightShares) -> Self {
        Self { positive_power: power.max(0.0), separate_power, net_power: power, shares }
    }

    /// Of one instant of a robot of `mass` kg.
    pub fn of(seen: &Observation, mass: f64) -> Self {
        Self::at([seen.power, seen.separate_power], seen.weight_shares(mass))
    }

    /// The means; none of nothing.
    pub fn mean(of: impl Iterator<Item = Self>) -> Option<Self> {
        let (mut sum, mut count) = (Self::default(), 0.0);
        for Self { positive_power, separate_power, net_power, shares } in of {
            sum.positive_power += positive_power;
            sum.separate_power += separate_power;
            sum.net_power += net_power;
            sum.shares.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share);
            count += 1.0;
        }
        let over = |sum: f64| sum / count;
        (count > 0.0).then(|| Self {
            positive_power: over(sum.positive_power),
            separate_power: over(sum.separate_power),
            net_power: over(sum.net_power),
            shares: sum.shares.map(over),
        })
    }

    /// The mean over the last whole strokes among the rows of a record from `first` on, over all of them where there is no whole stroke;
    /// none where it lacks a column or a row.
    pub fn of_record(record: &Record, first: usize) -> Option<Self> {
        let first = whole_strokes(record, first)?;
        let from = |name: &str| record.values(name)?.get(first..);
        let powers = [from(POWERS[0])?, from(POWERS[1])?];
        let shares: Vec<&[f64]> =
            WeightPart::ALL.iter().map(|part| from(&Self::column(*part))).collect::<Option<_>>()?;
        let row = |k: usize| Self::at(powers.map(|of| of[k]), std::array::from_fn(|part| shares[part][k]));
        Self::mean((0..powers[0].len()).map(row))
    }

    /// Name of the column of a share.
    pub fn column(part: WeightPart) -> String {
        format!("{SHARE}{}", part.name())
    }

    /// Columns of the shares, in the order of [`WeightPart::ALL`].
    pub fn columns() -> impl Iterator<Item = Column> {
        WeightPart::ALL.into_iter().map(|part| Column::new(Self::column(part), "", "W"))
    }

    /// Upward force of all parts over the weight.
    pub fn carried(&self) -> f64 {
        self.shares.iter().sum()
    }
}

/// The first row of the last whole strokes among those from `first` on, `first` itself where there is no whole stroke; none where the record
/// lacks the phase or the row.
pub fn whole_strokes(record: &Record, first: usize) -> Option<usize> {
    Some(first + before_whole_strokes(record.values("phase")?.get(first..)?))
}

/// Rows before the last whole strokes of a record that holds one.
fn before_whole_strokes(phase: &[f64]) -> usize {
    let [first, .., last] = phase else { return 0 };
    let strokes = ((last - first) / TAU + ROUNDING).floor();
    if strokes < 1.0 {
        return 0;
    }
    // The row that is whole strokes before the last one is the same instant of the stroke, and counts once.
    let begin = last - TAU * (strokes - ROUNDING);
    phase.partition_point(|phase| *phase <= begin)
}

/// Columns of the springs on pins of the linkage: their angles and the power that they get; none without springs.
pub fn pin_columns(robot: &Robot) -> impl Iterator<Item = Column> {
    let power = robot.has_pin_springs().then(|| Column::new("pin_power", "W", ""));
    robot.pin_names().map(|name| Column::new(name, "rad", "")).chain(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_powers_of_two_joints_that_work_against_each_other() {
        // 3 W and -1 W, then -2 W and 1 W.
        let instants = [[2.0, 3.0], [-1.0, 1.0]].map(|powers| Cost::at(powers, Default::default()));
        let mean = Cost::mean(instants.into_iter()).unwrap();
        assert_eq!((mean.positive_power, mean.separate_power, mean.net_power), (1.0, 2.0, 0.5));
        assert_eq!(Cost::mean(std::iter::empty()), None);
    }

    #[test]
    fn parts_of_a_stroke_do_not_count() {
        let phase: Vec<f64> = (0..=130).map(|k| 1.0 + f64::from(k) * TAU / 50.0).collect();
        let first = before_whole_strokes(&phase);
        assert_eq!((first, phase.len() - first), (31, 100));
        assert_eq!(before_whole_strokes(&phase[..40]), 0);
        assert_eq!(before_whole_strokes(&[0.0; 9]), 0);
    }
}

//! The joints of the robot that a record is of, by their own names.

use wingbeat::math::DEGREES;
use wingbeat::simulate::{Column, Record};

use crate::commands::pair;

const MILLIMETRES: f64 = 1e3;
/// A joint that the drive turns is drawn over time where it moves at least this share of what moves most.
const MOVES: f64 = 0.3;

/// A joint of a robot, or both of a pair.
pub struct RecordJoint<'a> {
    /// Its name without a side.
    pub name: String,
    /// Whether it turns; else it slides.
    pub turns: bool,
    /// Its columns with their sides; the side of a joint that is no pair is its name.
    pub sides: Vec<(String, &'a Column)>,
    /// Whether the dynamics decide how it moves.
    free: bool,
}

impl RecordJoint<'_> {
    /// Whether a drive or an actuator moves it; else the dynamics decide how it moves.
    pub fn is_driven(&self) -> bool {
        !self.free
    }

    /// From SI to what is drawn: degrees or millimetres.
    pub fn scale(&self) -> f64 {
        if self.turns { DEGREES } else { MILLIMETRES }
    }

    /// Title of a panel with it alone.
    pub fn title(&self) -> String {
        let what = if self.turns { "angle [°]" } else { "travel [mm]" };
        format!("{} {what}", self.name)
    }

    /// How far it moves, rad or m.
    pub fn range(&self) -> f64 {
        let range = |column: &Column| {
            let (low, high) =
                column.values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
            high - low
        };
        self.sides.iter().map(|(_, column)| range(column)).fold(0.0, f64::max)
    }
}

/// All joints, in the order of the record: the columns that have one of their effort, `torque_<joint>`.
pub fn all(record: &Record) -> Vec<RecordJoint<'_>> {
    let mut joints: Vec<RecordJoint> = Vec::new();
    let is_joint = |column: &&Column| record.values(&format!("torque_{}", column.name)).is_some();
    for column in record.columns().iter().filter(is_joint) {
        let (name, side) = pair(&column.name);
        let free = record.values(&format!("coordinate_{}", column.name)).is_some();
        let turns = column.unit != "m";
        let side = if side == "command" { name.clone() } else { side.to_owned() };
        match joints.iter_mut().find(|joint| joint.name == name) {
            Some(joint) => joint.sides.push((side, column)),
            None => joints.push(RecordJoint { name, turns, sides: vec![(side, column)], free }),
        }
    }
    joints
}

/// Those that are worth a panel: of the driven ones those that move much, and all whose motion the dynamics decide.
pub fn moving(record: &Record) -> Vec<RecordJoint<'_>> {
    let mut joints = all(record);
    let most = |turns: bool| {
        joints.iter().filter(|j| j.turns == turns).map(RecordJoint::range).fold(f64::MIN_POSITIVE, f64::max)
    };
    let most = [most(false), most(true)];
    joints.retain(|joint| joint.free || joint.range() >= MOVES * most[usize::from(joint.turns)]);
    joints
}

/// The joints of the left side and of the middle, each with its column.
pub fn left(record: &Record) -> impl Iterator<Item = (RecordJoint<'_>, &Column)> {
    all(record).into_iter().filter_map(|joint| {
        let (_, column) = joint.sides.iter().find(|(side, _)| side != "right")?;
        let column = *column;
        Some((joint, column))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(joints: &[(&str, &str, f64)], free: &[&str]) -> Record {
        let wave = |size: f64| (0..9).map(|k| size * f64::from(k).sin()).collect();
        let of =
            |name: String, unit: &str, size| Column { values: wave(size), ..Column::new(name, unit, "") };
        let positions = joints.iter().map(|(name, unit, size)| of((*name).into(), unit, *size));
        let efforts = joints.iter().map(|(name, ..)| of(format!("torque_{name}"), "N m", 1.0));
        let free = free.iter().map(|name| of(format!("coordinate_{name}"), "rad", 1.0));
        Record::new(positions.chain(efforts).chain(free).collect(), 0).unwrap()
    }

    #[test]
    fn joints_are_known_by_their_efforts_and_not_by_their_names() {
        let joints = [
            ("arm_left", "rad", 1.0),
            ("arm_right", "rad", 1.0),
            ("hand_left", "rad", 0.1),
            ("hand_right", "rad", 0.1),
            ("feather_left", "rad", 0.1),
            ("slider", "m", 0.02),
        ];
        let record = record(&joints, &["feather_left"]);
        let names = |joints: &[RecordJoint]| {
            joints.iter().map(|j| (j.name.clone(), j.sides.len())).collect::<Vec<_>>()
        };
        let own = |name: &str, sides| (name.to_owned(), sides);
        let every = [own("arm", 2), own("hand", 2), own("feather", 1), own("slider", 1)];
        assert_eq!(names(&all(&record)), every);
        // The hand moves little, and nothing but the drive moves it.
        assert_eq!(names(&moving(&record)), [own("arm", 2), own("feather", 1), own("slider", 1)]);
        let left: Vec<String> = left(&record).map(|(_, column)| column.name.clone()).collect();
        assert_eq!(left, ["arm_left", "hand_left", "feather_left", "slider"]);
        let titles: Vec<String> = moving(&record).iter().map(RecordJoint::title).collect();
        assert_eq!(titles, ["arm angle [°]", "feather angle [°]", "slider travel [mm]"]);
    }

    #[test]
    fn joints_at_rest_have_no_panel() {
        assert!(moving(&record(&[("arm_left", "rad", 0.0), ("arm_right", "rad", 0.0)], &[])).is_empty());
    }
}

//! The state figure: roll and pitch with what is asked, heading, position, and the robot's joints over time.

use wingbeat::math::DEGREES;
use wingbeat::robot::{BROADSIDE, Robot};
use wingbeat::simulate::{Column, Record};

use crate::attitude::TurnsOfBody;
use crate::own_joints::{RecordJoint, moving};
use crate::panel::{FigurePanel, PanelCurve, stacked, two_stacks};
use crate::write::Figure;
use crate::{Error, FigureTargets, needed, style, weight};

/// Height of all panels at most, px: with head and foot that of a page.
const PAGE: f64 = 6.0 * style::PANEL;
/// The same of two stacks on a slide, px.
const WIDE: f64 = 880.0;

/// Roll and pitch, heading, position, what carries the weight, and the robot's joints over time.
///
/// Roll and heading are [`TurnsOfBody`]. Needs `t`, `roll`, `pitch`, `yaw`, `p_WB_x`, `p_WB_y`, `p_WB_z`, and draws the shares of the weight
/// where they are there, and the joints that are there and move. Where there are `roll_reference` and `pitch_reference` they are
/// drawn fine, or the roll of the orbit, from which a flight about one records its error. The title says what the goal asks: a root mean
/// square over the flight, and so no band that a curve could leave.
pub fn states(record: &Record, asked: FigureTargets) -> Result<Figure, Error> {
    let panels = panels(record, asked)?;
    let height = style::PANEL.min(PAGE / panels.len() as f64);
    Ok(Figure::new("states", stacked(panels, "time [s]", height)))
}

/// The same in two stacks, for a slide.
pub fn states_wide(record: &Record, asked: FigureTargets) -> Result<Figure, Error> {
    let panels = panels(record, asked)?;
    let height = WIDE / panels.len().div_ceil(2) as f64;
    Ok(Figure::new("states", two_stacks(panels, "time [s]", height)))
}

fn panels(record: &Record, asked: FigureTargets) -> Result<Vec<FigurePanel>, Error> {
    let t = needed(record, "t")?;
    let TurnsOfBody { roll, heading } = TurnsOfBody::of(record)?;
    let mut attitude = FigurePanel::new("roll and pitch [°]", Vec::new());
    let followed = [("roll", "roll (right wing down +)", DEGREES), ("pitch", "pitch (nose up +)", -DEGREES)];
    let mut references = Vec::new();
    for (index, (angle, name, scale)) in followed.into_iter().enumerate() {
        let own = scaled(record, angle, scale)?;
        let asked = scaled(record, &format!("{angle}_reference"), scale).or_else(|_| {
            // The pitch of an orbit would cover that of its flight, stroke for stroke.
            let off = scaled(record, "orbit_roll_error", scale).ok().filter(|_| angle == "roll");
            let off = off.ok_or_else(|| Error::Column("roll_reference".into()))?;
            Ok::<Vec<f64>, Error>(own.iter().zip(off).map(|(own, off)| own - off).collect())
        });
        let own = if angle == "roll" { degrees(&roll) } else { own };
        attitude.curves.push(PanelCurve::new(name, t, own, index));
        if let Ok(reference) = asked {
            let name = if references.is_empty() { "references" } else { "" };
            references.push(PanelCurve::reference(name, t, reference));
        }
    }
    if let Some(goal) = asked.goal.filter(|_| !references.is_empty()) {
        let [roll, pitch, settled] =
            [goal.roll_within_deg, goal.pitch_within_deg, goal.settle_s].map(style::number);
        attitude.title += &format!("; goal from {settled} s on: rms errors within {roll}° and {pitch}°");
    }
    attitude.curves.extend(references);
    let heading = PanelCurve::new("yaw (left +)", t, degrees(&heading), 2);
    let places = [("p_WB_x", "x"), ("p_WB_y", "y (left +)"), ("p_WB_z", "z (up +)")];
    let places = places.iter().enumerate();
    let places =
        places.map(|(i, (column, name))| Ok(PanelCurve::new(*name, t, scaled(record, column, 1.0)?, i)));
    let mut panels = vec![
        attitude,
        FigurePanel::new("heading [°]", vec![heading]),
        FigurePanel::new("position [m]", places.collect::<Result<_, Error>>()?),
    ];
    panels.extend(weight::panel(record, asked.robot.map_or(BROADSIDE, Robot::broadside_words)));
    panels.extend(moving(record).iter().map(|joint| panel(joint, t)));
    Ok(panels)
}

/// The joint over time; of a pair the left one broad, which the right one may cover.
fn panel(joint: &RecordJoint, t: &[f64]) -> FigurePanel {
    let curve = |(number, (side, column)): (usize, &(String, &Column))| {
        let values = column.values.iter().map(|value| joint.scale() * value).collect();
        let covered = number == 0 && joint.sides.len() > 1;
        let weight = if covered { style::BROAD } else { style::CURVE };
        let index = style::SIDES.iter().find(|(name, _)| name == side).map_or(0, |(_, index)| *index);
        PanelCurve { weight, ..PanelCurve::new(side, t, values, index) }
    };
    FigurePanel::new(joint.title(), joint.sides.iter().enumerate().map(curve).collect())
}

fn degrees(angles: &[f64]) -> Vec<f64> {
    angles.iter().map(|angle| angle * DEGREES).collect()
}

fn scaled(record: &Record, column: &str, factor: f64) -> Result<Vec<f64>, Error> {
    Ok(needed(record, column)?.iter().map(|value| factor * value).collect())
}

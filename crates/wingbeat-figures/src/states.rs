//! The state figure: roll and pitch with what is asked, heading, position, and the robot's joints over time.

use wingbeat::math::unwrapped;
use wingbeat::scenario::GoalSpec;
use wingbeat::simulate::{Column, Record};

use crate::own_joints::{RecordJoint, moving};
use crate::panel::{FigurePanel, PanelCurve, stacked, two_stacks};
use crate::write::Figure;
use crate::{Error, needed, style, weight};

/// Height of all panels at most, px: with head and foot that of a page.
const PAGE: f64 = 6.0 * style::PANEL;
/// The same of two stacks on a slide, px.
const WIDE: f64 = 880.0;

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Roll and pitch, heading, position, what carries the weight, and the robot's joints over time.
///
/// The heading goes on beyond half a turn. Needs `t`, `roll`, `pitch`, `yaw`, `p_WB_x`, `p_WB_y`, `p_WB_z`, and draws the shares of the weight
/// where they are there, and the joints that are there and move. Where there are `roll_reference` and `pitch_reference` they are
/// drawn fine, and about them, from its settling time on, the errors that `goal` allows as a root mean square.
pub fn states(record: &Record, goal: Option<&GoalSpec>) -> Result<Figure, Error> {
    let panels = panels(record, goal)?;
    let height = style::PANEL.min(PAGE / panels.len() as f64);
    Ok(Figure::new("states", stacked(panels, "time [s]", height)))
}

/// The same in two stacks, for a slide.
pub fn states_wide(record: &Record, goal: Option<&GoalSpec>) -> Result<Figure, Error> {
    let panels = panels(record, goal)?;
    let height = WIDE / panels.len().div_ceil(2) as f64;
    Ok(Figure::new("states", two_stacks(panels, "time [s]", height)))
}

fn panels(record: &Record, goal: Option<&GoalSpec>) -> Result<Vec<FigurePanel>, Error> {
    let t = needed(record, "t")?;
    let mut attitude = FigurePanel::new("roll and pitch [°]", Vec::new());
    let within = |of: fn(&GoalSpec) -> f64| goal.map(|goal| (goal.settle_s, of(goal)));
    let asked = [within(|goal| goal.roll_within_deg), within(|goal| goal.pitch_within_deg)];
    let followed = [("roll", "roll (right wing down +)", DEGREES), ("pitch", "pitch (nose up +)", -DEGREES)];
    let mut references = Vec::new();
    for (index, ((angle, name, scale), goal)) in followed.into_iter().zip(asked).enumerate() {
        attitude.curves.push(PanelCurve::new(name, t, scaled(record, angle, scale)?, index));
        if let Ok(reference) = scaled(record, &format!("{angle}_reference"), scale) {
            attitude.bands.extend(goal.and_then(|goal| band(t, &reference, goal)));
            let name = if index == 0 { "references" } else { "" };
            references.push(PanelCurve::reference(name, t, reference));
        }
    }
    attitude.curves.extend(references);
    if !attitude.bands.is_empty() {
        attitude.title = "roll and pitch [°]; shaded: rms errors within the goal".into();
    }
    let yaw = unwrapped(needed(record, "yaw")?.to_vec()).iter().map(|angle| angle * DEGREES).collect();
    let heading = PanelCurve::new("yaw (left +)", t, yaw, 2);
    let places = [("p_WB_x", "x"), ("p_WB_y", "y (left +)"), ("p_WB_z", "z (up +)")];
    let places = places.iter().enumerate();
    let places =
        places.map(|(i, (column, name))| Ok(PanelCurve::new(*name, t, scaled(record, column, 1.0)?, i)));
    let mut panels = vec![
        attitude,
        FigurePanel::new("heading [°]", vec![heading]),
        FigurePanel::new("position [m]", places.collect::<Result<_, Error>>()?),
    ];
    panels.extend(weight::panel(record));
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

fn scaled(record: &Record, column: &str, factor: f64) -> Result<Vec<f64>, Error> {
    Ok(needed(record, column)?.iter().map(|value| factor * value).collect())
}

/// `within` below and above the reference from `settle` on; none where the record ends before.
fn band(t: &[f64], reference: &[f64], (settle, within): (f64, f64)) -> Option<Vec<(f64, f64, f64)>> {
    let rows = t.iter().zip(reference).filter(|(t, _)| **t >= settle);
    let edges: Vec<_> = rows.map(|(t, angle)| (*t, angle - within, angle + within)).collect();
    (edges.len() > 1).then_some(edges)
}

//! The state figure: orientation, position, shoulder and elbow angles over time.

use wingbeat::simulate::Record;

use crate::panel::{Curve, Panel, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Orientation, position, shoulder and elbow angles over time.
///
/// Needs `t`, `roll`, `pitch`, `yaw`, `p_WB_x`, `p_WB_y`, `p_WB_z`, and draws of `shoulder_left`, `shoulder_right`,
/// `elbow_left`, `elbow_right` those that are there. Where there is `roll_reference` it is drawn fine.
pub fn states(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let angles = |names: &[(&str, &str)]| -> Result<Vec<Curve>, Error> {
        curves(record, t, names, 180.0 / std::f64::consts::PI)
    };
    let mut orientation = angles(&[("roll", "roll"), ("pitch", "pitch (nose up −)"), ("yaw", "yaw")])?;
    if record.values("roll_reference").is_some() {
        let reference = angles(&[("roll_reference", "roll reference")])?;
        let drawn = |curve| Curve { colour: style::INK.into(), weight: style::FINE, ..curve };
        orientation.extend(reference.into_iter().map(drawn));
    }
    let position = curves(record, t, &[("p_WB_x", "x"), ("p_WB_y", "y"), ("p_WB_z", "z (up)")], 1.0)?;
    let mut panels = vec![panel("orientation [°]", orientation), panel("position [m]", position)];
    for (joint, label) in [("shoulder", "shoulder angle [°]"), ("elbow", "elbow angle [°]")] {
        let (left, right) = (format!("{joint}_left"), format!("{joint}_right"));
        if record.values(&left).is_some() && record.values(&right).is_some() {
            let mut sides = angles(&[(&left, "left"), (&right, "right")])?;
            sides[0].weight = style::BROAD;
            panels.push(panel(label, sides));
        }
    }
    Ok(Figure { name: "states", scene: stacked(panels, "time [s]", style::PANEL) })
}

fn curves(record: &Record, t: &[f64], names: &[(&str, &str)], factor: f64) -> Result<Vec<Curve>, Error> {
    let curve = |(index, (column, name)): (usize, &(&str, &str))| {
        let y = needed(record, column)?.iter().map(|value| factor * value).collect();
        Ok(Curve::new(*name, t, y, index))
    };
    names.iter().enumerate().map(curve).collect()
}

fn panel(label: &str, curves: Vec<Curve>) -> Panel {
    Panel { title: label.into(), curves, limits: None, zero: true }
}

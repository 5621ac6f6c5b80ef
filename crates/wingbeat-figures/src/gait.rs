//! A planned gait over its cycle beside the robot's own.

use wingbeat::simulate::Record;

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, own_joints, style};

/// What the curves of the plan are: the gait as the robot flies it from rest, whose record this is.
const REPLAY: &str = "replay";
/// What the robot's own gait is called.
const OWN: &str = "own gait";

/// Joint angles, power and force over the cycle of the replayed plan with their means; the robot's own gait paler, at the same share of its own
/// cycle.
///
/// Needs `t`, `drive_power`, `power_to_air`, `force_up`, `force_forward`; draws the robot's joints, of pairs the left ones, and `own_<column>` where it is there.
pub fn gait(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    if t.len() < 2 {
        return Err(Error::Rows { rows: t.len(), needed: 2 });
    }
    let period = t[t.len() - 1] - t[0];
    let x: Vec<f64> = t.iter().map(|now| (now - t[0]) / period).collect();
    let cycle = GaitCycle { record, x };
    let mut angles = Vec::new();
    let turning = own_joints::left(record).filter(|(joint, _)| joint.turns);
    for (index, (joint, column)) in turning.enumerate() {
        angles.extend(cycle.pair(&joint.name, &column.name, joint.scale(), index)?);
    }
    let panels = vec![
        FigurePanel::new("joint angles of the replay [°], up, forward, nose up", angles),
        FigurePanel::new("drive power [W]", cycle.with_means("drive_power", 0)?),
        FigurePanel::new("power to the air [W]", cycle.with_means("power_to_air", 1)?),
        FigurePanel::new("upward force of the air [N]", cycle.with_means("force_up", 2)?),
        FigurePanel::new("forward force of the air [N]", cycle.with_means("force_forward", 4)?),
    ];
    let own = record.columns().iter().any(|column| column.name.starts_with("own_"));
    let beside = if own { "; own gait: share of its own cycle" } else { "" };
    let label = format!("share of the cycle of {period:.4} s{beside}");
    Ok(Figure::new("gait", stacked(panels, &label, style::PANEL)))
}

struct GaitCycle<'a> {
    record: &'a Record,
    x: Vec<f64>,
}

impl GaitCycle<'_> {
    /// A column, and the own gait's paler beneath.
    fn pair(&self, name: &str, column: &str, factor: f64, index: usize) -> Result<Vec<PanelCurve>, Error> {
        let scaled = |values: &[f64]| values.iter().map(|v| factor * v).collect::<Vec<f64>>();
        let own = self.record.values(&format!("own_{column}")).map(|own| {
            let name = if name == REPLAY { OWN.into() } else { format!("{name}, {OWN}") };
            let curve = PanelCurve::new(name, &self.x, scaled(own), index);
            PanelCurve { colour: style::tint(index), ..curve }
        });
        let plan = PanelCurve::new(name, &self.x, scaled(needed(self.record, column)?), index);
        Ok(own.into_iter().chain([plan]).collect())
    }

    /// The same with fine lines at the means.
    fn with_means(&self, column: &str, index: usize) -> Result<Vec<PanelCurve>, Error> {
        let curves = self.pair(REPLAY, column, 1.0, index)?;
        let means = curves.iter().map(|curve| {
            let inner = &curve.y[..curve.y.len() - 1];
            let mean = inner.iter().sum::<f64>() / inner.len() as f64;
            let name = format!("{}, mean {mean:.4}", curve.name);
            let ends = [self.x[0], self.x[self.x.len() - 1]];
            PanelCurve {
                colour: curve.colour.clone(),
                weight: style::FINE,
                ..PanelCurve::new(name, &ends, vec![mean; 2], 0)
            }
        });
        let means: Vec<PanelCurve> = means.collect();
        Ok(curves.into_iter().chain(means).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::simulate::Column;

    #[test]
    fn a_cycle_is_drawn_with_and_without_the_own_gait() {
        let names = ["t", "arm_left", "torque_arm_left", "drive_power", "power_to_air"];
        let all = names.into_iter().chain(["force_up", "force_forward"]);
        let column = |name: &str| Column { values: vec![0.0, 0.5, 1.0], ..Column::new(name, "", "") };
        let plain: Vec<Column> = all.map(column).collect();
        let both = plain.iter().cloned().chain([column("own_drive_power")]).collect();
        for (columns, own) in [(plain, false), (both, true)] {
            let figure = gait(&Record::new(columns, 0).unwrap()).unwrap();
            assert_eq!(figure.name, "gait");
            let text = figure.svg();
            assert!(
                text.contains(">replay<") && text.contains("replay, mean") && !text.contains("plan"),
                "{text}"
            );
            assert_eq!(
                (text.contains(">own gait<"), text.contains("of its own cycle")),
                (own, own),
                "{text}"
            );
        }
        let bare = Record::new(vec![column("t")], 0).unwrap();
        assert!(matches!(gait(&bare), Err(Error::Column(_))));
    }
}

//! A planned motion of an arm, joint by joint, against its limits.

use wingbeat::math::DEGREES;
use wingbeat::rig::JointTrajectory;
use wingbeat::rig::arm::{LimitProfile, SerialArm};

use crate::panel::{FigurePanel, PanelCurve, stacked_with};
use crate::style;
use crate::write::Figure;

/// Positions, and rates and accelerations as shares of the limits of `profile`, or by themselves where it has none;
/// dashed lines at the ends of the steady turn.
pub fn joint_histories(
    arm: &SerialArm,
    motion: &JointTrajectory,
    profile: &LimitProfile,
    measured: (f64, f64),
) -> Figure {
    let t: Vec<f64> = (0..motion.len()).map(|i| i as f64 * motion.step).collect();
    let curves = |rows: &[Vec<f64>], scale: &dyn Fn(usize) -> f64| -> Vec<PanelCurve> {
        let one = |(j, name): (usize, &String)| {
            PanelCurve::new(name, &t, rows.iter().map(|row| scale(j) * row[j]).collect(), j)
        };
        motion.joints.iter().enumerate().map(one).collect()
    };
    let panel = |what: &str, unit: &str, rows: &[Vec<f64>], limits: &[f64]| -> FigurePanel {
        if limits.iter().all(|limit| limit.is_finite()) {
            let shares = curves(rows, &|j| 100.0 / limits[j]);
            return FigurePanel {
                limits: Some((-100.0, 100.0)),
                ..FigurePanel::new(format!("{what} [% of the limit]"), shares)
            };
        }
        FigurePanel::new(format!("{what} [{unit}], without limit"), curves(rows, &|_| DEGREES))
    };
    let panels = vec![
        FigurePanel::new(format!("positions of {} [°]", arm.name), curves(&motion.position, &|_| DEGREES)),
        panel(&format!("rates, profile {}", profile.name), "°/s", &motion.velocity, &profile.velocity),
        panel("accelerations", "°/s²", &motion.acceleration, &profile.acceleration),
        FigurePanel::new("speed of the tool [m/s]", vec![tool_speed(arm, motion, &t)]),
    ];
    let scene =
        stacked_with(panels, "time [s]; dashed: steady turn", style::PANEL, &[measured.0, measured.1]);
    Figure::new("joints", scene)
}

/// Speed of the tool, by the rates of the joints.
fn tool_speed(arm: &SerialArm, motion: &JointTrajectory, t: &[f64]) -> PanelCurve {
    let speed =
        |&t: &f64| arm.tool_pose(&motion.at(t)).origin.0.map(|p| p.d.powi(2)).iter().sum::<f64>().sqrt();
    PanelCurve::new("tool", t, t.iter().map(speed).collect(), 0)
}

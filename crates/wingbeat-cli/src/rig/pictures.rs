//! The figures of a planned run: snapshots of arm and flapping robot, and joint histories.

use wingbeat::rig::plan::TurnPlan;
use wingbeat::scenario::RigRun;
use wingbeat_figures::{Drawing, Figure, joint_histories};

use crate::error::Error;
use crate::run_folder::RunFolder;

/// Snapshots, evenly over the motion.
const SNAPSHOTS: usize = 7;
/// Points of the path of the body.
const PATH: usize = 200;

/// Draws the planned run into `figures/NAME`; what cannot be drawn is said and left out.
pub fn draw(folder: &RunFolder, run: &RigRun, plan: &TurnPlan) -> Result<(), Error> {
    let place = folder.folder(&format!("figures/{}", run.spec.name))?;
    let joints = joint_histories(&run.arm, &plan.trajectory, &run.profile, plan.measured);
    let snapshots = snapshots(run, plan).map_err(wingbeat_figures::Error::Picture);
    for figure in [Ok(joints), snapshots] {
        crate::fly::left_out(figure.and_then(|figure| wingbeat_figures::write(&place, &figure)))?;
    }
    Ok(())
}

/// Arm and robot at even times over the motion, the wings at the phase that they have then; the path of the body.
pub fn snapshots(run: &RigRun, plan: &TurnPlan) -> Result<Figure, String> {
    let motion = &plan.trajectory;
    let posture =
        |t: f64| -> Vec<f64> { motion.at(t)[..run.arm.dof()].iter().map(|joint| joint.x).collect() };
    let body = |t: f64| run.arm.tool_pose(&posture(t)) * run.mount.cell * run.mount.body;
    let mut drawing = Drawing::new();
    drawing.table(run.spec.rig.table_m, 0.4);
    let duration = motion.duration();
    for i in 0..SNAPSHOTS {
        let t = duration * i as f64 / (SNAPSHOTS - 1) as f64;
        let tool = drawing.arm(&run.arm, &posture(t), false);
        let robot = run.robot.at_rest(t).map_err(|fault| fault.to_string())?;
        let at = drawing.mounted(&robot, &run.mount, &tool, false);
        drawing.label(at.origin.0, format!("{t:.2} s"));
    }
    let point = |i: usize| body(duration * i as f64 / PATH as f64).origin.0;
    drawing.path((0..=PATH).map(point).collect());
    let (begin, end) = plan.measured;
    drawing.note(&format!(
        "{SNAPSHOTS} instants from rest to rest, steady turn from {begin:.2} to {end:.2} s, wings at {} Hz; line: path of the body.",
        run.frequency(),
    ));
    Ok(drawing.snapshots("snapshots", &format!("banking turn {} on {}", run.spec.name, run.arm.name)))
}

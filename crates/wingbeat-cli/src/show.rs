//! `wingbeat show`: labelled views of a robot or a rig from its file.

use std::path::Path;
use std::time::Instant;

use wingbeat::rig::arm::MAX_JOINTS;
use wingbeat::robot::Skeleton;
use wingbeat::scenario::{Document, RigRun, Scenario};
use wingbeat_figures::{Drawing, Figure};
use wingbeat_io::urdf_as_toml;

use crate::args::Show;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::run_folder::{RunFolder, named_after};
use crate::say;

/// A scenario around a robot that is only looked at.
const AROUND: &str = "name = \"show\"\n[air]\ndensity_kg_m3 = 1.225\nwind_m_s = [0.0, 0.0, 0.0]\n[aero]\nlaw = \"linear\"\n\
                      [flight]\nduration_s = 1e-3\nstep_s = 1e-3\nrecord_every_s = 1e-3\n";
/// A run around a rig that is only looked at.
const ON_A_STAND: &str = "name = \"show\"\n[hold]\ntilts_deg = [[0.0, 0.0]]\neach_s = 1.0\n";

/// Draws the file's robot or rig.
pub fn show(arguments: &Show) -> Result<(), Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let options = &arguments.run;
    let figure = figure(arguments)?;
    let name = named_after(&arguments.file, options.out.as_deref())?;
    let folder = RunFolder::create(options.out.as_deref(), &name, options.force)?;
    wingbeat_figures::write(&folder.folder("figures")?, &figure)
        .map_err(|error| Error::Input(format!("the figure cannot be written: {error}")))?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    say::unless(options.quiet, || format!("{}\n", shown.join("figures/show.png").display()))
}

fn figure(arguments: &Show) -> Result<Figure, Error> {
    let path = arguments.file.as_path();
    let document = Document::file(path)?.overridden(&arguments.run.overrides);
    let is = |key: &str| document.written(key).is_some();
    if is("runs") {
        return Err(Error::Input(format!("{}: a list of runs; show one of them", path.display())));
    }
    if is("rig") {
        return rig(RigRun::new(document, &urdf_as_toml)?, arguments);
    }
    if is("mount") {
        let run = Document::text("show", ON_A_STAND)?.put("rig", document)?;
        return rig(RigRun::new(run, &urdf_as_toml)?, arguments);
    }
    let scenario = match is("flight") {
        true => document,
        false => Document::text("show", AROUND)?.put("robot", document)?,
    };
    let scenario = match arguments.phase {
        Some(phase) => scenario.set(format!("start.phase_rad={phase:?}")),
        None => scenario,
    };
    robot(&Scenario::new(scenario)?, path)
}

/// Refuses a model that cannot be evaluated.
fn seen(robot: Result<Skeleton, wingbeat::plant::Fault>) -> Result<Skeleton, Error> {
    robot.map_err(|fault| Error::Input(format!("the robot cannot be drawn there: {fault}")))
}

fn robot(scenario: &Scenario, path: &Path) -> Result<Figure, Error> {
    let robot = scenario.robot();
    let skeleton = seen(robot.at_rest(0.0))?;
    let mut drawing = Drawing::new();
    drawing.robot(&skeleton, &wingbeat::rig::Pose::IDENTITY, true);
    drawing.frame("body B: x forward, y left, z up", &wingbeat::rig::Pose::IDENTITY);
    drawing.note(&format!(
        "{}: {:.1} g, {} links, phase of the gait {:.3} rad, regulators at rest. Left wing blue, right wing orange; \
         hinge axes dashed, centres of mass grey.",
        path.file_name().unwrap_or_default().to_string_lossy(),
        1e3 * robot.mass(),
        skeleton.links.len(),
        robot.phase(0.0),
    ));
    Ok(drawing.views("show", &format!("robot {}", scenario.spec.robot.name)))
}

fn rig(run: RigRun, arguments: &Show) -> Result<Figure, Error> {
    let mut q = vec![0.0; run.arm.dof()];
    let mut posture = "all joints at zero".to_owned();
    let mut t = 0.0;
    if let Some(joints) = &arguments.joints_deg {
        if joints.len() != run.arm.dof() || joints.iter().any(|joint| !joint.is_finite()) {
            let (given, wanted) = (joints.len(), run.arm.dof());
            return Err(Error::Input(format!(
                "--joints-deg: {given} given, {wanted} finite numbers allowed"
            )));
        }
        q = joints.iter().map(|deg| deg.to_radians()).collect();
        posture = format!("joints at {joints:?} deg");
    } else if run.spec.turn.is_some() {
        let plan = run.plan().map_err(|error| run.explain(&error))?;
        let plan = plan.map_err(|refusal| Error::Input(format!("{}: {refusal}", run.spec.name)))?;
        t = 0.5 * (plan.measured.0 + plan.measured.1);
        q = plan.placed.middle[..run.arm.dof().min(MAX_JOINTS)].to_vec();
        posture = format!("in the middle of the steady turn, t = {t:.3} s");
    }
    let mut drawing = Drawing::new();
    drawing.table(run.spec.rig.table_m, 0.4);
    let tool = drawing.arm(&run.arm, &q, true);
    drawing.frame("base: x, y, z", &wingbeat::rig::Pose::IDENTITY);
    drawing.mounted(&seen(run.robot.at_rest(t))?, &run.mount, &tool, true);
    let cell = &run.spec.rig.cell;
    drawing.note(&format!(
        "arm {}, load cell of {} N at {} Hz, robot {:.1} g; {posture}. Axes of the joints dashed.",
        run.arm.name,
        cell.calibration.range()[2],
        cell.rate_hz,
        1e3 * run.robot.mass(),
    ));
    Ok(drawing.views("show", &format!("rig of {}", run.spec.name)))
}

//! `wingbeat show`: labelled views of a robot, a case or a rig from its file.

use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

use wingbeat::judge::limits::range::APART;
use wingbeat::math::SEA_LEVEL_DENSITY;
use wingbeat::rig::Pose;
use wingbeat::rig::arm::MAX_JOINTS;
use wingbeat::robot::{Robot, Skeleton};
use wingbeat::scenario::{Document, RigRun, Scenario, TetherCase};
use wingbeat::tether::Shape;
use wingbeat_figures::{Drawing, Figure};
use wingbeat_io::urdf_as_toml;

use crate::args::Show;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::run_folder::{RunFolder, named_after};
use crate::say;
use crate::tether::CaseTables;

/// A scenario around a robot that is only looked at.
pub fn around() -> String {
    format!(
        "name = \"show\"\n[air]\ndensity_kg_m3 = {SEA_LEVEL_DENSITY}\nwind_m_s = [0.0, 0.0, 0.0]\n[aero]\nlaw = \"linear\"\n[flight]\n\
         duration_s = 1e-3\nstep_s = 1e-3\nrecord_every_s = 1e-3\n"
    )
}
/// A run around a rig that is only looked at.
const ON_A_STAND: &str = "name = \"show\"\n[hold]\ntilts_deg = [[0.0, 0.0]]\neach_s = 1.0\n";

/// Ribs of each half of a case's wing.
const RIBS: usize = 24;

/// Draws the file's robot, case or rig.
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

/// The view of the file.
pub fn figure(arguments: &Show) -> Result<Figure, Error> {
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
    if arguments.joints_deg.is_some() {
        return Err(Error::Input("--joints-deg: allowed for the arm of a rig or a run".into()));
    }
    if is("wing") && is("wind") {
        return case(document, arguments);
    }
    let scenario = match is("flight") {
        true => document,
        false => Document::text("show", &around())?.put("robot", document)?,
    };
    finite_phase(arguments.phase.unwrap_or(0.0))?;
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
    let skeleton = robot.parted(seen(robot.at_rest(0.0))?, APART.value);
    let mut drawing = Drawing::new();
    drawing.robot(&skeleton, &wingbeat::rig::Pose::IDENTITY, true);
    drawing.frame("body B: x forward, y left, z up", &wingbeat::rig::Pose::IDENTITY);
    drawing.note(&format!(
        "{}: {:.1} g, {} links, phase of the gait {:.3} rad, actuators at rest. Left wing blue, right wing orange; \
         hinge axes dashed, centres of mass grey.{}",
        path.file_name().unwrap_or_default().to_string_lossy(),
        1e3 * robot.mass(),
        skeleton.links.len(),
        robot.phase(0.0),
        unloaded(robot),
    ));
    Ok(drawing.views("show", &format!("robot {}", scenario.spec.robot.name)))
}

/// What is said of a robot of which parts give way under loads, which it is drawn without.
fn unloaded(robot: &Robot) -> &'static str {
    let elastic = (0..robot.joint_names().count()).any(|joint| robot.is_elastic(joint));
    let soft = robot.surfaces().any(|(_, aero)| aero.membrane().is_some() || aero.flap().is_some());
    if elastic || soft { " Without loads: membranes flat, flaps and elastic joints at rest." } else { "" }
}

/// Refuses a phase that is no number, by its option.
fn finite_phase(phase: f64) -> Result<(), Error> {
    match phase.is_finite() {
        true => Ok(()),
        false => Err(Error::Input(format!("--phase {phase}: allowed is a finite number, rad"))),
    }
}

/// The wing of a case at the phase asked for, in W.
fn case(document: Document, arguments: &Show) -> Result<Figure, Error> {
    let tables = CaseTables::default();
    let case = TetherCase::new(document, &|path| tables.read(path))?;
    let (tether, frequency) = (&case.tether, case.spec.time.frequency_hz);
    let phase = arguments.phase.unwrap_or(0.0);
    finite_phase(phase)?;
    let t = phase / (TAU * frequency);
    let (body, angles) = (tether.motion.body(t).frame(), tether.motion.angles(t));
    let section = |arc: f64| {
        let section = tether.wing.section(arc, &body, &angles);
        [section.le, section.te]
    };
    let planform = tether.wing.planform();
    let steady = tether.spar.as_ref().map(|spar| spar.steady(tether));
    let bent = steady.as_ref().filter(|steady| steady.found).map_or(&[][..], |steady| &steady.q);
    let shape = Shape { spar: bent, ..Shape::default() };
    let outline = tether.outline(t, &tether.drawn_arcs(RIBS), shape);
    let mut drawing = Drawing::new();
    drawing.outline(&outline, &Pose::IDENTITY);
    for (hinge, spec) in tether.wing.hinges().iter().zip(&case.spec.wing.hinges) {
        let sides =
            [1.0, -1.0].into_iter().filter(|side| hinge.side.holds(*side) && tether.side.holds(*side));
        for edges in sides.map(|side| section(side * hinge.arc_m)) {
            drawing.path(edges.iter().map(|edge| edge.0).collect());
            drawing.label(edges[0].0, format!("hinge {}", spec.name));
        }
    }
    drawing.frame("W: x forward, y left, z up", &Pose::IDENTITY);
    drawing.note(&format!(
        "{}: wind {} m/s, {frequency:.4} Hz, phase {phase:.3} rad, area {:.5} m2, half span {:.4} m. Left wing blue, right \
         wing orange; a line across the wing at each hinge.{}{}",
        arguments.file.file_name().unwrap_or_default().to_string_lossy(),
        case.spec.wind.speed_m_s,
        planform.area(),
        planform.half_span(),
        match &steady {
            Some(steady) if steady.found => " The spar is bent as at rest in the wind at phase 0.",
            Some(_) => " No shape of the spar at rest in the wind was found: it is drawn unbent.",
            None => "",
        },
        if tether.aero.membrane().is_some() { " The membrane is drawn flat." } else { "" },
    ));
    Ok(drawing.views("show", &format!("case {}", case.spec.name)))
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
        "arm {}, load cell of {} N at {} Hz, robot {:.1} g; {posture}. Axes of the joints dashed.{}",
        run.arm.name,
        cell.calibration.range()[2],
        cell.rate_hz,
        1e3 * run.robot.mass(),
        unloaded(&run.robot),
    ));
    Ok(drawing.views("show", &format!("rig of {}", run.spec.name)))
}

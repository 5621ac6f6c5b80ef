//! Documents around a robot or a case of the user's, and the robot to begin from.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::orbit::Free;
use wingbeat::robot::Outline;
use wingbeat::scenario::{Document, DocumentKind, Scenario, TetherCase};

use super::{head, is_taken, name_of, put};
use crate::args::New;
use crate::error::Error;
use crate::say;
use crate::show::AROUND;
use crate::tether::Tables;

/// Standard gravity, m/s2.
const GRAVITY: f64 = 9.806_65;
/// Lift coefficient of the speed to begin from. *Choice*: well below stall.
const LIFT: f64 = 0.6;

/// Writes what `text` makes of the document's name and folder, and what to do next.
pub fn write(
    arguments: &New,
    kind: &str,
    text: impl FnOnce(&str, &Path) -> Result<String, Error>,
) -> Result<(), Error> {
    let path = arguments.path.clone().unwrap_or_else(|| PathBuf::from(format!("{kind}.toml")));
    let name = name_of(&path)?;
    let taken = is_taken(&path, arguments.force)?;
    let text = text(name.trim_end_matches(".toml"), path.parent().unwrap_or(Path::new("")))?;
    put(&path, &text, taken)?;
    let shown = path.display();
    let next = match kind {
        "robot" => format!(
            "next: wingbeat show {shown}\nthen: wingbeat new scenario --robot {shown}, wingbeat new trim --robot {shown}"
        ),
        "scenario" => format!("next: wingbeat fly {shown}"),
        "trim" => format!("next: wingbeat trim {shown}"),
        _ => format!("next: name your files in data, then wingbeat calibrate {shown} --information"),
    };
    say::say(&format!("{shown}: written\n{next}\n"))
}

/// The least robot that flies.
pub fn minimal(name: &str, _: &Path) -> Result<String, Error> {
    let text = include_str!("../../documents/minimal_robot.toml");
    Ok(head(DocumentKind::Robot) + &text.replace("name = \"minimal\"", &format!("name = \"{name}\"")))
}

/// A file as a document in `folder` names it, a TOML text in quotes.
fn seen(file: &Path, folder: &Path) -> Result<String, Error> {
    let here = folder.as_os_str().is_empty() || folder == Path::new(".");
    let path =
        if here { file.to_path_buf() } else { fs::canonicalize(file).map_err(|e| Error::file(file, e))? };
    let text = path
        .to_str()
        .ok_or_else(|| Error::Input(format!("{}: allowed is a name in UTF-8", path.display())))?;
    Ok(toml::Value::from(text.replace('\\', "/")).to_string())
}

/// Area of an outline between its ribs, m2: half of the cross product of the diagonals of each quadrilateral.
fn area(outline: &Outline) -> f64 {
    let covered = outline.ribs.windows(2).zip(&outline.covered).filter(|(_, covered)| **covered);
    covered.map(|(ribs, _)| 0.5 * (ribs[1][1] - ribs[0][0]).cross(ribs[1][0] - ribs[0][1]).norm()).sum()
}

/// A flight of the robot in a file without controller, or the search of its periodic flight.
pub fn flight(name: &str, robot: &Path, folder: &Path, trim: bool) -> Result<String, Error> {
    let document = Document::text("new", AROUND)?.put("robot", Document::file(robot)?)?;
    let scenario = Scenario::new(document)?;
    let model = scenario.robot();
    let still = model.at_rest(0.0).map_err(|fault| Error::Input(format!("{}: {fault}", robot.display())))?;
    let lifting: f64 = still.outlines.iter().map(area).sum();
    // Level flight of the largest part of the weight that the wings carry: m g = rho V^2 S CL / 2.
    let speed = (2.0 * model.mass() * GRAVITY / (1.225 * lifting * LIFT)).sqrt();
    let speed = if speed.is_finite() { (10.0 * speed).round().max(1.0) / 10.0 } else { 5.0 };
    let mut text = head(DocumentKind::Scenario);
    text += &format!(
        "name = \"{name}\"\nrobot = {robot}\n\n[air]\ndensity_kg_m3 = 1.225        # ISA, sea level\n\n\
         [aero]\npreset = \"full\"              # strips with unsteady loads and wash; or \"paper\", a lifting line\n\
         law = \"stall\"                # or \"linear\", \"lev\"\n\n[aero.full]\nstrips = 9                   # along the span\n\n\
         [start]\nvelocity_m_s = [{speed:.1}, 0.0, 0.0]   # about where the area of all surfaces carries the weight at CL {LIFT}\n\
         nose_up_deg = 3.0\n\n",
        robot = seen(robot, folder)?,
    );
    if trim {
        let names = Free::names(model);
        let Some(chosen) = names.get(1) else {
            let what = "its frequency alone can be chosen, allowed is a robot with a command too: structure.elements, or a \
                        motor (docs/robots.md)";
            return Err(Error::Input(format!("{}: {what}", robot.display())));
        };
        let others = names[1..].join(", ");
        text += &format!(
            "# The periodic flight at this speed: `frequency` and a command are chosen so that lift, thrust and moment balance.\n\
             [trim]\nspeed_m_s = {speed:.1}\nfree = [\"frequency\", \"{chosen}\"]   # commands of this robot: {others}\n\n",
        );
    }
    text += "[flight]\nduration_s = 2.0\nstep_s = 5e-4\nrecord_every_s = 2e-3\n";
    Ok(text)
}

/// A fit of a case to measurements of its wing.
pub fn calibration(name: &str, case: &Path, folder: &Path) -> Result<String, Error> {
    let tables = Tables::default();
    TetherCase::new(Document::file(case)?, &|path| tables.read(path))?;
    Ok(format!(
        "{}name = \"{name}\"\n\n[[cases]]\ncase = {}\n\
         # Columns t (s) or phase (cycles), and loads in body axes: force_x, force_y, force_z (N), moment_x, moment_y, moment_z (N m).\n\
         # Whole cycles, at least two: their scatter is the noise.\ndata = [\"measured.csv\"]\n\
         # Other names, units and signs of columns:\n\
         # set = [\"compare.channels.force_z=down_mN\", \"compare.scale.force_z=-1e-3\"]\n\n\
         # What is fitted; `wingbeat calibrate {name}.toml --names` lists all.\n\
         [[parameters]]\nname = \"surfaces.wing.lift_slope_per_rad\"\n\n[[parameters]]\nname = \"surfaces.wing.cd0\"\nhigh = 0.5\n\n\
         [[parameters]]\nname = \"surfaces.wing.added_mass_scale\"\n",
        head(DocumentKind::Calibration),
        seen(case, folder)?,
    ))
}

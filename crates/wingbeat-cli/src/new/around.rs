//! Documents around a robot or a case of the user's, and the robot to begin from.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::math::SEA_LEVEL_DENSITY;
use wingbeat::scenario::{Document, DocumentKind, RobotTrim, Scenario, TetherCase};

use super::{as_word, head, is_taken, name_of, put};
use crate::args::New;
use crate::error::Error;
use crate::say;
use crate::show;
use crate::tether::CaseTables;

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
    let shown = as_word(&path);
    let next = match kind {
        "robot" => format!(
            "next: wingbeat show {shown}\nthen: wingbeat new scenario --robot {shown}, wingbeat new trim --robot {shown}"
        ),
        "scenario" => format!("next: wingbeat fly {shown}"),
        "trim" => format!("next: wingbeat trim {shown}"),
        _ => format!("next: name your files in data, then wingbeat calibrate {shown} --information"),
    };
    say::say(&format!("{}: written\n{next}\n", path.display()))
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

/// Fewest and most strips that a scenario begins with. *Choice.*
const FEW: usize = 9;
const MANY: usize = 32;

/// Whether a robot can be built on so many strips.
fn flies(robot: &Document, strips: usize) -> bool {
    let around = Document::text("new", &show::around()).and_then(|around| around.put("robot", robot.clone()));
    let set = |around: Document| {
        around.set("aero.preset=full".to_owned()).set(format!("aero.full.strips={strips}"))
    };
    around.is_ok_and(|around| Scenario::new(set(around)).is_ok())
}

/// A flight of the robot in a file without controller, or the search of its periodic flight.
pub fn flight(name: &str, robot: &Path, folder: &Path, trim: bool) -> Result<String, Error> {
    let document = Document::file(robot)?;
    let scenario = Scenario::new(Document::text("new", &show::around())?.put("robot", document.clone())?)?;
    // A robot without surfaces flies too.
    let speed = scenario.guessed_speed().map_or(5.0, |speed| (10.0 * speed).round().max(1.0) / 10.0);
    let trim = match trim {
        true => Some(RobotTrim::new(document.clone(), &[], 0.0)?),
        false => None,
    };
    trim.as_ref().map_or(Ok(()), RobotTrim::can_be_held)?;
    // Nine where the hinges, spars and webs of the robot allow it.
    let strips = match &trim {
        Some(trim) => trim.scenario.spec.aero.full.strips,
        None => (FEW..=MANY).find(|strips| flies(&document, *strips)).unwrap_or(FEW),
    };
    let beyond = trim.as_ref().map(RobotTrim::beyond_file).transpose()?.flatten();
    let file = seen(robot, folder)?;
    let named = match beyond {
        None => format!("robot = {file}\n"),
        Some(_) => "# Actuators are assumed: below, in [robot].\n".into(),
    };
    let mut text = head(DocumentKind::Scenario);
    text += &format!(
        "name = \"{name}\"\n{named}\n[air]\ndensity_kg_m3 = {SEA_LEVEL_DENSITY}        # ISA, sea level\n\n\
         [aero]\npreset = \"full\"              # strips with unsteady loads and wash; or \"paper\", a lifting line\n\
         law = \"stall\"                # or \"linear\", \"lev\"\n\n[aero.full]\nstrips = {strips}                   # along the span\n\n\
         [start]\nvelocity_m_s = [{speed:.1}, 0.0, 0.0]   # about where the surfaces, as they stand at the start, carry the weight at CL .6\n\
         nose_up_deg = 3.0\n\n",
    );
    if let Some(trim) = &trim {
        text += &format!(
            "# The periodic flight at this speed: `frequency` and a command are chosen so that lift, thrust and moment balance.\n\
             # From the robot's file alone, with speed and gait searched: wingbeat trim {file}\n\
             [trim]\nspeed_m_s = {speed:.1}\nfree = {:?}   # straight flight takes the first two\n\n",
            trim.free(),
        );
    }
    text += "[flight]\nduration_s = 2.0\nstep_s = 5e-4\nrecord_every_s = 2e-3\n";
    if let Some(beyond) = beyond {
        text += &format!("\n[robot]\nbase = {file}\n\n{beyond}");
    }
    Ok(text)
}

/// A fit of a case to measurements of its wing.
pub fn calibration(name: &str, case: &Path, folder: &Path) -> Result<String, Error> {
    let tables = CaseTables::default();
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

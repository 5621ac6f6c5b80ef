//! Joint trajectories to and from the files of arm controllers.

mod kinova_json;
mod kortex_csv;
mod ros_yaml;

pub use kinova_json::{kinova_json, parse_kinova_json};
pub use kortex_csv::{kortex_csv, parse_kortex_csv};
pub use ros_yaml::{parse_ros_yaml, ros_yaml};

use std::path::Path;

use wingbeat::math::whole_turns;
use wingbeat::rig::JointTrajectory;
use wingbeat::rig::arm::SerialArm;

use crate::table::unended;
use crate::{Error, text};

/// A trajectory read from a file, with what a person should know of it.
#[derive(Clone, Debug, Default)]
pub struct ImportedTrajectory {
    /// The trajectory, in rad.
    pub trajectory: JointTrajectory,
    /// What was assumed or looks odd.
    pub warnings: Vec<String>,
}

/// Positions this far (rad) beyond a limit are let pass with a warning:
/// recorded poses lie a hair outside.
const HAIR: f64 = 0.02;

/// Reads a trajectory by the file's extension (`yaml`/`yml` ROS 2, `csv` Kortex,
/// `json` Kinova Web App) and checks its positions against the arm.
///
/// # Errors
/// An unknown extension, a file that does not hold a trajectory, a wrong number
/// of joints, or a position far outside its limits.
pub fn read_trajectory(path: &Path, arm: &SerialArm) -> Result<ImportedTrajectory, Error> {
    let content = text(path)?;
    let parsed = match path.extension().and_then(|e| e.to_str()) {
        Some("yaml" | "yml") => parse_ros_yaml(&content),
        Some("csv") => parse_kortex_csv(&content),
        Some("json") => parse_kinova_json(&content),
        other => Err(format!("extension {}: allowed are yaml, yml, csv, json", other.unwrap_or("missing"))),
    };
    parsed.and_then(|imported| against(imported, arm)).map_err(|what| Error::format(path, what))
}

/// Checks an imported trajectory against the joints of `arm`.
///
/// # Errors
/// A wrong number of joints, or a position far outside its limits.
pub fn against(mut imported: ImportedTrajectory, arm: &SerialArm) -> Result<ImportedTrajectory, String> {
    let joints = imported.trajectory.joints.len();
    if joints != arm.dof() {
        return Err(format!("{joints} joints; the arm {} has {}", arm.name, arm.dof()));
    }
    let mut worst: Vec<(f64, usize)> = vec![(0.0, 0); joints];
    for (row, q) in imported.trajectory.position.iter().enumerate() {
        for (j, joint) in arm.joints.iter().enumerate() {
            let beyond = (joint.low - q[j]).max(q[j] - joint.high);
            if beyond > worst[j].0 {
                worst[j] = (beyond, row);
            }
        }
    }
    for (joint, (beyond, row)) in arm.joints.iter().zip(worst) {
        let words = format!(
            "point {row}: {} lies {beyond:.4} rad outside its limits [{}, {}]",
            joint.name, joint.low, joint.high
        );
        if beyond > HAIR {
            return Err(words);
        }
        if beyond > 0.0 {
            imported.warnings.push(words);
        }
    }
    Ok(imported)
}

/// Most values of a file that a parser keeps whole, each of which takes some hundred bytes there (*choice*: four times
/// the longest trajectory that the arm takes).
const MOST_ENTRIES: usize = 1 << 22;

/// Refuses a text with more values than are read, counted by what stands between them.
fn entries(text: &str) -> Result<(), String> {
    let between = |byte: &u8| matches!(byte, b',' | b'\n' | b'[' | b'{' | b':');
    let found = text.bytes().filter(|byte| between(byte)).count();
    if found <= MOST_ENTRIES {
        Ok(())
    } else {
        Err(format!("{found} values; read are at most {MOST_ENTRIES}"))
    }
}

/// Refuses a text whose last line does not end: its last number may be cut.
fn whole(text: &str) -> Result<(), String> {
    let lines = text.bytes().filter(|byte| *byte == b'\n').count();
    if text.is_empty() || text.ends_with('\n') { Ok(()) } else { Err(unended(lines + 1)) }
}

/// Turns degrees into radians when the numbers can only be degrees, and says so.
/// A `declared` unit is believed, unless the numbers contradict it.
fn to_radians(imported: &mut ImportedTrajectory, declared: Option<Unit>) {
    let t = &mut imported.trajectory;
    let largest = t.position.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    // No arm's recorded joint winds further than three turns.
    let looks = if largest > 6.0 * std::f64::consts::PI { Unit::Degrees } else { Unit::Radians };
    let unit = match declared {
        Some(Unit::Radians) if looks == Unit::Degrees => {
            imported.warnings.push(format!("largest angle {largest:.1}: read as degrees, not as radians"));
            Unit::Degrees
        }
        Some(unit) => unit,
        None => {
            imported.warnings.push(format!("no unit stated; largest angle {largest:.3}: read as {looks:?}"));
            looks
        }
    };
    if unit == Unit::Degrees {
        for x in t.position.iter_mut().chain(&mut t.velocity).chain(&mut t.acceleration).flatten() {
            *x = x.to_radians();
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Degrees,
    Radians,
}

/// Takes whole turns out of the steps from point to point.
fn unwind(rows: &mut [Vec<f64>]) {
    for k in 1..rows.len() {
        let (before, after) = rows.split_at_mut(k);
        for (x, last) in after[0].iter_mut().zip(&before[k - 1]) {
            *x -= whole_turns(*x, *last);
        }
    }
}

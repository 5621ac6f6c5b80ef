//! The 1 kHz table of Kortex pre-computed trajectories, in degrees.

use std::fmt::Write;

use wingbeat::rig::JointTrajectory;

use super::ros_yaml::equal_step;
use super::{ImportedTrajectory, Unit, to_radians, whole};

/// Longest pre-computed trajectory, s.
const LONGEST: f64 = 30.0;

/// The table: time, then position, velocity and acceleration of every joint, in
/// degrees. The first row is the pose that the arm must already hold.
///
/// # Errors
/// A trajectory that the arm would refuse: a step other than 1 ms, more than
/// 30 s, or no rates.
pub fn kortex_csv(trajectory: &JointTrajectory) -> Result<String, String> {
    if (trajectory.step - 1e-3).abs() > 1e-9 {
        return Err(format!(
            "step {} s: a pre-computed trajectory has steps of exactly 1 ms",
            trajectory.step
        ));
    }
    if trajectory.duration() > LONGEST {
        return Err(format!(
            "{:.3} s: a pre-computed trajectory lasts at most {LONGEST} s",
            trajectory.duration()
        ));
    }
    if trajectory.velocity.len() != trajectory.len() || trajectory.acceleration.len() != trajectory.len() {
        return Err("a pre-computed trajectory needs velocities and accelerations".into());
    }
    let mut text = String::from("time_s");
    for unit in ["deg", "deg_s", "deg_s2"] {
        for joint in &trajectory.joints {
            let _ = write!(text, ",{joint}_{unit}");
        }
    }
    for (k, position) in trajectory.position.iter().enumerate() {
        let _ = write!(text, "\n{}.{:03}", k / 1000, k % 1000);
        for x in position.iter().chain(&trajectory.velocity[k]).chain(&trajectory.acceleration[k]) {
            let _ = write!(text, ",{:.9}", x.to_degrees());
        }
    }
    text.push('\n');
    Ok(text)
}

/// Reads a table whose first column is time; then positions, and where present
/// velocities and accelerations of the same joints. A header is optional.
///
/// # Errors
/// What is wrong, without the file's name.
pub fn parse_kortex_csv(text: &str) -> Result<ImportedTrajectory, String> {
    whole(text)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut header: Vec<String> = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (line, record) in reader.records().enumerate() {
        let record = record.map_err(|error| error.to_string())?;
        let numbers: Result<Vec<f64>, _> = record.iter().map(str::parse::<f64>).collect();
        match numbers {
            Ok(numbers) => rows.push(numbers),
            Err(_) if line == 0 => header = record.iter().map(String::from).collect(),
            Err(error) => return Err(format!("line {}: {error}", line + 1)),
        }
    }
    let width = rows.first().map_or(0, Vec::len);
    let joints = joint_count(width, &header)?;
    let named = |j: usize| header.get(j + 1).map(|name| name.trim_end_matches("_deg").to_string());
    let part = |from: usize| -> Vec<Vec<f64>> {
        if width < from + joints {
            return Vec::new();
        }
        rows.iter().map(|row| row[from..from + joints].to_vec()).collect()
    };
    let trajectory = JointTrajectory {
        joints: (0..joints).map(|j| named(j).unwrap_or_else(|| format!("joint_{}", j + 1))).collect(),
        step: equal_step(&rows.iter().map(|row| row[0]).collect::<Vec<_>>())?,
        position: part(1),
        velocity: part(1 + joints),
        acceleration: part(1 + 2 * joints),
    };
    trajectory.check().map_err(|error| error.to_string())?;
    let mut imported = ImportedTrajectory { trajectory, warnings: Vec::new() };
    if rows[0][0] != 0.0 {
        imported.warnings.push(format!("time begins at {} s; the arm wants 0", rows[0][0]));
    }
    to_radians(&mut imported, declared(&header));
    Ok(imported)
}

/// Number of joints of a table `width` columns wide.
fn joint_count(width: usize, header: &[String]) -> Result<usize, String> {
    let values = width.saturating_sub(1);
    let before_velocities = header.iter().skip(1).position(|name| name.ends_with("_s"));
    match before_velocities {
        Some(joints) if joints > 0 && values.is_multiple_of(joints) => Ok(joints),
        _ if values >= 18 && values.is_multiple_of(3) => Ok(values / 3),
        _ if (1..=8).contains(&values) => Ok(values),
        _ => Err(format!(
            "{width} columns: allowed are time and 1 to 8 joints, or time and three values per joint"
        )),
    }
}

fn declared(header: &[String]) -> Option<Unit> {
    let any = |word: &str| header.iter().skip(1).any(|name| name.to_lowercase().contains(word));
    match (any("deg"), any("rad")) {
        (true, false) => Some(Unit::Degrees),
        (false, true) => Some(Unit::Radians),
        _ => None,
    }
}

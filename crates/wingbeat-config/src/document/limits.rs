//! What every number of every document may be, by the unit that ends its key, and how large documents may be.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::string::FromUtf8Error;

/// Largest file, bytes. *Choice*: a scenario with a planned track has less than one million.
pub const LARGEST_FILE: u64 = 8 << 20;
/// Most bytes that the texts of a document take together: each later one is as long as all before it. *Choice.*
pub const LARGEST_DOCUMENT: usize = 128 << 20;
/// Most names in a path. *Choice*: the deepest key of a robot has eight.
pub const DEEPEST: usize = 32;
/// Most files of which each is based on the next. *Choice*: no shipped document has more than five.
pub const MOST_BASES: usize = 16;
/// Largest magnitude, in its own unit, of a number whose key names no unit: its powers are finite.
pub const LARGEST: f64 = 1e12;

/// Units and largest magnitudes by the end of the key, longer ends first. *Choices*, far beyond any robot, rig or wing tunnel,
/// such that powers and products of several stay finite and no picture or table grows without bound.
const BY_UNIT: [(&str, &str, f64); 28] = [
    ("_w_kg", "W/kg", 1e5),
    ("_kg_m2", "kg m2", 1e6),
    ("_kg_m3", "kg/m3", 1e5),
    ("_rad_s", "rad/s", 1e6),
    ("_rad_s2", "rad/s2", 1e9),
    ("_rad_s3", "rad/s3", LARGEST),
    ("_m_s2", "m/s2", 1e6),
    ("_n_m2", "N m2", 1e6),
    ("_kg_m", "kg/m", 1e4),
    ("_n_m_a", "N m/A", LARGEST),
    ("_n_m", "N m", 1e6),
    ("_per_s", "1/s", 1e6),
    ("_per_s2", "1/s2", LARGEST),
    ("_per_rad", "1/rad", 1e4),
    ("_m_s", "m/s", 1e4),
    ("_deg_s", "deg/s", 1e6),
    ("_deg", "deg", 3600.0),
    ("_n_rad", "N/rad", 1e4),
    ("_rad", "rad", 1e4),
    ("_hz", "Hz", 1e7),
    ("_m2", "m2", 1e6),
    ("_mm", "mm", 1e6),
    ("_kg", "kg", 1e5),
    ("_n", "N", 1e6),
    ("_v", "V", 1e5),
    ("_w", "W", 1e8),
    ("_s", "s", 1e7),
    ("_m", "m", 1e4),
];

/// Unit and largest magnitude of the number at `path`. The unit is that of the innermost key that names one:
/// `body.nose_up_deg.constant` is an angle.
fn row(path: &str) -> Option<(&'static str, f64)> {
    let keys = path.split('.').rev().map(|key| key.split(['[', '"']).next().unwrap_or_default());
    keys.filter(|key| !key.is_empty()).find_map(|key| by_end(key).map(|(_, unit, most)| (unit, most)))
}

/// The end of `key` that names a unit, the unit, and the largest magnitude. An inertia per length is a mass times a length, a density of an
/// area a mass over it, the integral of a height a length times a time.
fn by_end(key: &str) -> Option<(&'static str, &'static str, f64)> {
    let (end, unit, most) = *BY_UNIT.iter().find(|(end, ..)| key.ends_with(end))?;
    let unit = match key {
        _ if key.ends_with("inertia_kg_m") => "kg m",
        _ if key.ends_with("density_kg_m2") => "kg/m2",
        _ if key.ends_with("integral_m_s") => "m s",
        _ => unit,
    };
    Some((end, unit, most))
}

/// Largest magnitude that any document may give the number at `path`, in the unit that ends it: `body.nose_up_deg.constant`.
pub fn largest(path: &str) -> f64 {
    row(path).map_or(LARGEST, |(_, largest)| largest)
}

/// Unit of the number at `path` by the ends of its keys; empty where none names one.
pub fn unit(path: &str) -> &'static str {
    row(path).map_or("", |(unit, _)| unit)
}

/// The quantity that a key names, in words and with its unit: of `wing.hinges[0].angle_deg.fourier.sin[0]`,
/// `hinges[0] angle, sin[0] [deg]`; of `surfaces.wing.cd0`, `wing cd0`.
pub fn spoken(path: &str) -> String {
    let plain = path.replace('"', "");
    let parts: Vec<(&str, &str)> =
        plain.split('.').map(|part| part.split_at(part.find('[').unwrap_or(part.len()))).collect();
    let found = parts.iter().enumerate().rev().find_map(|(at, (name, _))| Some((at, by_end(name)?)));
    let (at, end, unit) = match found {
        Some((at, (end, unit, _))) => (at, end, format!(" [{unit}]")),
        None => (parts.len() - 1, "", String::new()),
    };
    let before = parts[..at].iter().rfind(|(name, _)| *name != "fourier");
    let before = before.map_or(String::new(), |(name, index)| format!("{name}{index} "));
    let name = parts[at].0.strip_suffix(end).unwrap_or_default();
    let rest: String = parts[at + 1..]
        .iter()
        .filter(|(name, index)| *name != "fourier" || !index.is_empty())
        .map(|(name, index)| format!(", {name}{index}"))
        .collect();
    format!("{before}{name}{}{rest}", parts[at].1).replace('_', " ") + &unit
}

/// The text of a plain file of at most `LARGEST_FILE` bytes, or of a pipe of the shell; what else is not a regular file
/// may have no end.
///
/// # Errors
/// What the system says, or what the file is not.
pub fn text_of(path: &Path) -> io::Result<String> {
    String::from_utf8(bytes_of(path)?)
        .map_err(|error| io::Error::other(format!("it is no UTF-8 text: {error}")))
}

/// As [`text_of`], of what other programs write: what is no UTF-8 is read as Latin-1, whose letters are those of code page 1252.
///
/// # Errors
/// What the system says.
pub fn old_text_of(path: &Path) -> io::Result<String> {
    let latin = |error: FromUtf8Error| error.as_bytes().iter().map(|byte| char::from(*byte)).collect();
    Ok(String::from_utf8(bytes_of(path)?).unwrap_or_else(latin))
}

/// The bytes of such a file.
fn bytes_of(path: &Path) -> io::Result<Vec<u8>> {
    let pipe = ["/dev/stdin", "/dev/fd", "/proc/self/fd"].iter().any(|pipes| path.starts_with(pipes));
    let data = std::fs::metadata(path)?;
    let is_text = data.is_file() || (pipe && !data.is_dir());
    if !is_text {
        return Err(io::Error::other("not a regular file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST_FILE + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(io::Error::other(format!("more than {LARGEST_FILE} bytes, the most that is read")));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_key_names_its_whole_unit() {
        let keys = [
            "spar.bending_n_m2",
            "spar.couplings_n_m2[0]",
            "spar.inertia_kg_m",
            "spar.mass_kg_m",
            "rate_n_m",
            "flap.stiffness_n_rad",
            "weights.height_integral_m_s",
        ];
        assert_eq!(keys.map(unit), ["N m2", "N m2", "kg m", "kg/m", "N m", "N/rad", "m s"]);
        assert_eq!(spoken("stations[1].inertia_kg_m"), "stations[1] inertia [kg m]");
        assert_eq!(spoken("robot.gait.fourier.frequency_hz"), "gait frequency [Hz]");
    }
}

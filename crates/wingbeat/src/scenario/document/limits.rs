//! What every number of every document may be, by the unit that ends its key, and how large documents may be.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Largest file, bytes. *Choice*: a scenario with a planned track has less than one million.
pub const LARGEST_FILE: u64 = 8 << 20;
/// Most bytes that the texts of a document take together: each later one is as long as all before it. *Choice.*
pub const LARGEST_DOCUMENT: usize = 128 << 20;
/// Most names in a path. *Choice*: the deepest key of a robot has eight.
pub const DEEPEST: usize = 32;
/// Largest magnitude of a number whose key names no unit: its powers are finite.
const LARGEST: f64 = 1e12;

/// Largest magnitudes by the end of the key, longer ends first. *Choices*, far beyond any robot, rig or wing tunnel,
/// such that powers and products of several stay finite and no picture or table grows without bound.
const BY_UNIT: [(&str, f64); 20] = [
    ("_kg_m2", 1e6),
    ("_kg_m3", 1e5),
    ("_rad_s", 1e6),
    ("_rad_s2", 1e9),
    ("_m_s2", 1e6),
    ("_n_m", 1e6),
    ("_per_s", 1e6),
    ("_m_s", 1e4),
    ("_deg_s", 1e6),
    ("_deg", 3600.0),
    ("_rad", 1e4),
    ("_hz", 1e7),
    ("_m2", 1e6),
    ("_mm", 1e6),
    ("_kg", 1e5),
    ("_n", 1e6),
    ("_v", 1e5),
    ("_w", 1e8),
    ("_s", 1e7),
    ("_m", 1e4),
];

/// Largest magnitude of the number at `path`. The unit is that of the innermost key that names one:
/// `body.nose_up_deg.constant` is an angle.
pub fn largest(path: &str) -> f64 {
    let keys = path.split('.').rev().map(|key| key.split('[').next().unwrap_or_default());
    let of = |key: &str| BY_UNIT.iter().find(|(end, _)| key.ends_with(end)).map(|(_, largest)| *largest);
    keys.filter(|key| !key.is_empty()).find_map(of).unwrap_or(LARGEST)
}

/// The text of a plain file of at most [`LARGEST_FILE`] bytes, or of a pipe of the shell; what else is not a regular file
/// may have no end.
///
/// # Errors
/// What the system says, or what the file is not.
pub fn text_of(path: &Path) -> io::Result<String> {
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
    String::from_utf8(bytes).map_err(|error| io::Error::other(format!("it is no UTF-8 text: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_the_innermost_key_counts() {
        assert_eq!(largest("robot.wing.planform_shift_m"), 1e4);
        assert_eq!(largest("body.nose_up_deg.fourier.cos[2]"), 3600.0);
        assert_eq!(largest("start.velocity_m_s[0]"), 1e4);
        assert_eq!(largest("robot.body.inertia_kg_m2[1]"), 1e6);
        assert_eq!(largest("draws[0].low"), LARGEST);
        assert_eq!(largest("controller.weights.roll"), LARGEST);
    }

    #[test]
    fn what_may_have_no_end_is_not_read() {
        let why = |path: &str| text_of(Path::new(path)).unwrap_err().to_string();
        assert_eq!(why("/dev/zero"), "not a regular file");
        assert_eq!(why("/"), "not a regular file");
    }
}

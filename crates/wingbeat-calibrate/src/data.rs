//! Files of samples, and what tells one from another.

use std::fs;
use std::path::Path;

use crate::measured::MeasuredPass;
use crate::{CalibrationFailure, CalibrationFile, Error};
use serde::Serialize;
use wingbeat::scenario::{RigRun, SPAN_KEYS};
use wingbeat::simulate::Record;
use wingbeat_io::urdf_as_toml;

/// A file of samples.
#[derive(Clone, Debug, Serialize)]
pub struct DataFile {
    /// Path as given.
    pub file: String,
    /// FNV-1a of its bytes, 64 bits, hexadecimal.
    pub fnv1a64: String,
}

/// The files of samples of a calibration.
pub struct SampleFiles(pub Vec<DataFile>);

impl SampleFiles {
    /// Those that the calibration names.
    ///
    /// # Errors
    /// Files that cannot be read, and one named twice.
    pub fn of(calibration: &CalibrationFile) -> Result<Self, Error> {
        let mut files: Vec<DataFile> = Vec::new();
        let given = calibration.spec.runs.iter().map(|run| &run.data);
        let given = given.chain(calibration.spec.cases.iter().map(|case| &case.data)).flatten();
        for ((key, path), given) in calibration.files().into_iter().zip(given) {
            let bytes = fs::read(&path)
                .map_err(|source| calibration.wrong_file(&key, format!("{}: {source}", path.display())))?;
            let file = given.display().to_string();
            let fnv1a64 = format!("{:016x}", fnv1a64(&bytes));
            if let Some(other) = files.iter().find(|other| other.fnv1a64 == fnv1a64) {
                let what = format!("holds the very bytes of {}: one pass counts once", other.file);
                return Err(calibration.wrong_file(&key, what).into());
            }
            files.push(DataFile { file, fnv1a64 });
        }
        Ok(Self(files))
    }

    /// What a run to be resumed must have in common: the calibration, the samples, and what its runs and cases resolve to, with the
    /// files that they name and the defaults of the program.
    ///
    /// # Errors
    /// Bad runs and cases.
    pub fn identity(&self, calibration: &CalibrationFile) -> Result<String, CalibrationFailure> {
        let data = self.0.iter().map(|file| format!("# data {} fnv1a64 {}\n", file.file, file.fnv1a64));
        let resolved = calibration.resolved_runs(&urdf_as_toml)?;
        let runs = resolved.iter().map(|(name, resolved)| {
            let chosen = span_keys(resolved);
            format!("# {name} fnv1a64 {:016x}{chosen}\n", fnv1a64(resolved.as_bytes()))
        });
        Ok(data.chain(runs).fold(calibration.resolved.clone(), |text, line| text + &line))
    }
}

/// What bears along the span in a resolved run or case, as its table of aerodynamics gives it.
fn span_keys(resolved: &str) -> String {
    let given = |line: &&str| line.split_once(" = ").is_some_and(|(key, _)| SPAN_KEYS.contains(&key));
    resolved.lines().filter(given).map(|line| format!(", {line}")).collect()
}

/// Fowler, Noll and Vo's hash 1a.
fn fnv1a64(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

/// The samples of a file, read as `run` says.
///
/// # Errors
/// Files that hold no samples as the run says.
pub fn read(path: &Path, run: &RigRun) -> Result<MeasuredPass, Error> {
    let name = path.display().to_string();
    // What the reader says of the command line holds for the run's overrides.
    let wrong = |error: wingbeat_io::Error| {
        let said = error.to_string().replace("--set ", "in the run's set ");
        Error::data(&name, said.strip_prefix(&format!("{name}: ")).unwrap_or(&said))
    };
    let input = &run.spec.process.input;
    let table = wingbeat_io::samples::read_samples(path, input).map_err(wrong)?;
    MeasuredPass::of(&name, table.import(input).map_err(wrong)?.record)
}

/// The columns of a CSV file; the text says what is wrong with it.
pub(crate) fn table(path: &Path) -> Result<Record, String> {
    wingbeat_io::samples::read_measured(path).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_reference() {
        // Noll's test vectors.
        assert_eq!(fnv1a64(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a64(b"foobar"), 0x8594_4171_f739_67e8);
    }
}

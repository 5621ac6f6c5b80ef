//! `wingbeat tether CASE --compare FILE`.

use std::path::Path;

use wingbeat::scenario::{MeasuredComparison, TetherCase};
use wingbeat::simulate::Record;
use wingbeat::tether::{CycleFit, TetherRun};
use wingbeat_io::samples::read_measured;

use crate::error::Error;

/// A measured file whose channels and times fit the case.
pub struct MeasuredFile<'a> {
    path: &'a Path,
    record: Record,
    channels: Vec<(String, String)>,
}

impl<'a> MeasuredFile<'a> {
    /// Reads and checks a file, before the wing moves.
    pub fn open(path: &'a Path, case: &TetherCase) -> Result<Self, Error> {
        let record = read_measured(path)?;
        let channels = case.channels(&record)?;
        case.measured_phase(&record).map_err(|error| refused(path, &error))?;
        Ok(Self { path, record, channels })
    }

    /// Compares the run of the case with the file.
    pub fn compare(&self, case: &TetherCase, run: &TetherRun) -> Result<MeasuredComparison, Error> {
        let compared = case.compare(run, &self.record, &self.channels);
        compared.map_err(|error| refused(self.path, &error))
    }
}

fn refused(path: &Path, error: &wingbeat::Error) -> Error {
    Error::Input(format!("{}: {error}", path.display()))
}

/// Lags, gains, offsets and what is left, in words.
pub fn text(comparison: &MeasuredComparison) -> String {
    let mut text = format!(
        "\nmeasured(phase) = offset + gain x computed(phase - lag), a least-squares fit\n\n{:<22}{:>12}{:>9}{:>9}{:>12}{:>12}{:>12}{:>12}\n",
        "", "measured", "cycles", "lag", "gain", "offset", "rms before", "rms after",
    );
    for channel in &comparison.channels {
        let CycleFit { lag_cycles, gain, offset, rms_before, rms, .. } = channel.fit;
        text += &format!(
            "{:<22}{:>12}{:>9}{lag_cycles:>9.4}{gain:>12.5}{offset:>12.5}{rms_before:>12.5}{rms:>12.5}\n",
            channel.computed, channel.measured, channel.cycles,
        );
    }
    text + "lag in cycles, positive where the measured cycle comes later; offset and rms in the measured unit\n"
}

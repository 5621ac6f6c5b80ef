//! What a load cell reads at rest, taken from the begin of a file.

use serde::Serialize;
use wingbeat::judge::data::{mean, rest_scatter};
use wingbeat::judge::unit::is_load;
use wingbeat_io::samples::Plain;

use crate::error::Error;

/// Fewest samples of a rest, and of what follows it. *Choice.*
const FEWEST: usize = 8;

/// A channel at rest.
#[derive(Serialize)]
struct RestReading {
    /// Its name.
    name: String,
    /// Its unit.
    unit: String,
    /// Mean, which is subtracted.
    mean: f64,
}

/// The rest at the begin of a file.
#[derive(Serialize)]
pub struct RestSummary {
    /// How long it lasts, s.
    duration_s: f64,
    /// Scatter in the quarter of the rest where it is largest over that of what follows, in the channel of a load where that is least.
    pub scatter_fraction: f64,
    /// What each channel reads.
    channels: Vec<RestReading>,
}

impl RestSummary {
    /// Takes the first `seconds` s of `plain` away, and what its channels read in them from what follows.
    pub fn taken(plain: &mut Plain, seconds: f64, file: &str) -> Result<Self, Error> {
        let begin = plain.time.first().copied().unwrap_or_default();
        let count = plain.time.iter().take_while(|t| **t - begin < seconds).count();
        let left = plain.time.len() - count;
        if !(seconds > 0.0 && count >= FEWEST && left >= FEWEST) {
            let span = plain.time.last().unwrap_or(&begin) - begin;
            return Err(Error::Input(format!(
                "--rest {seconds:?}: allowed is a time above 0 s that holds {FEWEST} samples and leaves as many of the {span:.3} s of {file}"
            )));
        }
        // A temperature does not tell whether the wings rest.
        let known = plain.channels.iter().any(|column| is_load(&column.name, &column.unit));
        let mut scatter_fraction = f64::INFINITY;
        let mut channels = Vec::new();
        for column in &mut plain.channels {
            let mean = mean(&column.values[..count]);
            if !mean.is_finite() {
                return Err(Error::Input(format!(
                    "--rest {seconds:?}: {} of {file} has no number in it",
                    column.name
                )));
            }
            let (rest, moving) = column.values.split_at(count);
            if let Some(fraction) = rest_scatter(rest, moving)
                && (!known || is_load(&column.name, &column.unit))
            {
                scatter_fraction = scatter_fraction.min(fraction);
            }
            column.values.drain(..count);
            column.values.iter_mut().for_each(|value| *value -= mean);
            channels.push(RestReading { name: column.name.clone(), unit: column.unit.clone(), mean });
        }
        plain.time.drain(..count);
        Ok(Self { duration_s: seconds, scatter_fraction, channels })
    }

    /// The readings in a line.
    pub fn text(&self) -> String {
        let of = |r: &RestReading| format!("{} {:.5} {}", r.name, r.mean, r.unit).trim_end().to_owned();
        let all = self.channels.iter().map(of).collect::<Vec<_>>().join(", ");
        format!("rest, first {} s, subtracted: {all}\n", self.duration_s)
    }
}

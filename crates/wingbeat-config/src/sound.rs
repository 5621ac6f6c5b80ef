//! How far the record of a flight that broke down can be believed.

use crate::recorder::Recorded;
use wingbeat_flight::simulate::{Ending, Record};
use wingbeat_judge::Warning;
use wingbeat_judge::limits::range::SOUND_M_S;
use wingbeat_ocp::plant::Fault;

/// Sizes, by unit, beyond which a sample says nothing: the speed of sound, where flow is no longer incompressible; the rate of a
/// link of 0.1 m whose tip moves at it; and powers, forces and moments that no robot of these models gives. *Choices.*
const MOST: [(&str, f64); 5] =
    [("m/s", SOUND_M_S), ("rad/s", 10.0 * SOUND_M_S), ("W", 1e4), ("N", 1e3), ("N m", 1e3)];

/// True for an end at which numbers grew without bound, so that the samples before it are no flight either.
fn grew(ending: &Ending) -> bool {
    matches!(ending, Ending::Fault(fault) if fault.is_not_finite() || matches!(fault, Fault::NotRecorded { .. }))
}

impl Recorded {
    /// Cuts the samples off that say nothing of a flight that ended so, and with them the means over all; true where there may be some.
    pub(super) fn cut(&mut self, ending: &Ending) -> bool {
        if !grew(ending) {
            return false;
        }
        let rows = rows(&self.record);
        let last = self.record.values("t").and_then(|t| t.get(..rows)?.last().copied());
        self.record = self.record.head(rows);
        self.strips = self.strips.take().map(|strips| {
            let before = |t: &[f64]| t.partition_point(|t| last.is_some_and(|last| *t <= last));
            strips.head(strips.values("t").map_or(0, before))
        });
        self.means = None;
        true
    }
}

/// Rows of a record before the first sample that says nothing.
pub fn rows(record: &Record) -> usize {
    let most = |unit: &str| MOST.iter().find(|(of, _)| *of == unit).map(|(_, most)| *most);
    let bounded = record.columns().iter().filter_map(|column| Some((&column.values, most(&column.unit)?)));
    let first = |(values, most): (&Vec<f64>, f64)| values.iter().position(|value| !(value.abs() <= most));
    bounded.filter_map(first).min().unwrap_or_else(|| record.rows())
}

/// What is said of numbers that are left out; `last` is the time of the last sample that counts, s.
pub(super) fn left_out(last: Option<f64>) -> Warning {
    let until = match last {
        Some(last) => {
            format!("the path is that up to t = {last:.4} s, the last sample that is physically possible")
        }
        None => "no sample is of a size that can be".into(),
    };
    let text = format!("numbers grew without bound: means are left out, and {until}");
    let warning = Warning::new("flight.left_out", text);
    last.map_or(warning.clone(), |last| warning.size(last))
}

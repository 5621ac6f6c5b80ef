//! One thing that is wrong with data.

use super::{Cause, Purpose};
use crate::limits::data::{GAIN, SCATTER};
use crate::limits::{JudgedLimit, RunLimits};
use crate::verdict::{Judge, Warning};

/// What was found of a channel, how large it is, and what mends it.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// A name that does not change, `data.what`.
    pub id: &'static str,
    /// The limit that it breaks.
    pub limit: &'static JudgedLimit,
    /// The channel and its file, in words.
    pub about: String,
    /// Name of the channel; empty where it is all of them, or their time.
    pub channel: String,
    /// Its size, in the unit of the limit.
    pub size: f64,
    /// What was found, why it matters, and what helps.
    pub text: String,
    /// The key that mends it, where the reader of the data has one.
    pub key: Option<String>,
    /// Whether the data are suspect, or a warning is enough.
    pub serious: bool,
    /// One over the error of its size, where that is known.
    pub(super) certain: f64,
}

impl Finding {
    /// A finding of `size`, in the unit of the limit, about a channel.
    pub fn new(
        id: &'static str,
        limit: &'static JudgedLimit,
        about: impl Into<String>,
        size: f64,
        text: impl Into<String>,
    ) -> Self {
        let serious = limit.status.is_some();
        let (about, channel) = (about.into(), String::new());
        Self { id, limit, about, channel, size, text: text.into(), key: None, serious, certain: 0.0 }
    }

    /// The same of the channel called `name`.
    pub(super) fn in_channel(self, name: &str) -> Self {
        Self { channel: name.into(), ..self }
    }

    /// Whether it says that cycles are so different in size that the mean cycle is that of none of them.
    pub fn has_no_mean_cycle(&self, limits: &RunLimits) -> bool {
        self.limit.id == SCATTER.id && self.breaks(limits)
    }

    /// The same where the mean cycle is what is asked for: cycles of which it is none are not explained by wings that rest or start.
    pub fn of_mean_cycle(self, limits: &RunLimits) -> Self {
        Self { serious: self.serious || self.has_no_mean_cycle(limits), ..self }
    }

    /// Whether it says that a channel has no signal of its own: it is dead, or was stuck.
    pub fn is_silence(&self) -> bool {
        matches!(self.id, "data.dead" | "data.stuck")
    }

    /// That what was measured has another gain by the factor `size`.
    pub fn scaled(about: impl Into<String>, size: f64, text: impl Into<String>) -> Self {
        Self::new("data.scaled", &GAIN, about, size, text)
    }

    /// Whether it lies beyond its limit.
    pub fn breaks(&self, limits: &RunLimits) -> bool {
        !self.limit.allows(self.size, limits.of(self.limit).0)
    }

    /// The same with the key that mends it.
    #[must_use]
    pub fn mended_by(self, key: Option<String>) -> Self {
        Self { key: key.or(self.key), ..self }
    }

    /// The same as a warning, where the reader reports what is found in other words too.
    #[must_use]
    pub fn noted(self) -> Self {
        Self { serious: false, ..self }
    }

    /// The same as a warning where `cause` explains it and `purpose` allows that.
    pub(super) fn explained(self, cause: Cause, purpose: Purpose) -> Self {
        if purpose.allows(cause) { self.noted() } else { self }
    }

    /// What was found, of what, and the key that mends it.
    pub fn words(&self) -> String {
        let key = self.key.as_ref().map_or(String::new(), |key| format!(" ({key})"));
        format!("{}: {}{key}", self.about, self.text)
    }

    /// It as a warning.
    pub fn warning(&self) -> Warning {
        let warning = Warning::new(self.id, self.words()).size(self.size);
        self.key.iter().fold(warning, |warning, key| warning.key(key.clone()))
    }

    /// Adds it to a verdict: a warning, and where it is serious the status of its limit.
    pub fn put(self, judge: &mut Judge) {
        judge.warn(self.warning());
        if self.serious {
            judge.hold_about(self.limit, self.size, &format!("of {}", self.about));
        }
    }
}

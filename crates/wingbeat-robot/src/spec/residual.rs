//! What a model of the air leaves of measured loads, as a file says it.

use crate::residual::{MOST_HARMONICS, MOST_TERMS, Term};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wingbeat_math::CHANNELS;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// A wrench on the body by phase of the gait and velocity against the air: what the model of the air leaves of measured loads.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct ResidualSpec {
    /// Preset of the model that leaves it; another one is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// Law of that model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// Flapping frequency at which it was measured, Hz; the robot's gait flaps within 1 % of it, or not at all.
    pub frequency_hz: f64,
    /// Place whose velocity counts, from the body's origin in body axes, m: at the wings, for their load depends on what they meet.
    #[serde(default)]
    pub place_m: [f64; 3],
    /// Lowest velocity against the air at which it was measured, along x, y, z of the body, m/s; below it stays as it is there.
    pub low_m_s: [f64; 3],
    /// Highest velocity, m/s; above it stays as it is there.
    pub high_m_s: [f64; 3],
    /// Products of the velocity's components u, v, w along x, y, z of the body, m/s: `"1"`, `"u"`, `"uw"`, `"ww"`.
    pub terms: Vec<String>,
    /// By channel of the load about the body's origin in body axes, `Fx` to `Tz`, N and N m: a row for the mean, then one for the cosine and
    /// one for the sine of each harmonic of the gait's phase; each row with a factor for each of `terms`.
    pub loads: BTreeMap<String, Vec<Vec<f64>>>,
}

ranges!(ResidualSpec {
    frequency_hz: Range::over(0.0, 1000.0),
    place_m: Range::between(-10.0, 10.0),
    low_m_s: Range::between(-100.0, 100.0),
    high_m_s: Range::between(-100.0, 100.0),
    loads: Range::between(-1e6, 1e6),
});

impl ResidualSpec {
    /// Checks ranges, names and sizes.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        for (i, (low, high)) in self.low_m_s.iter().zip(self.high_m_s).enumerate() {
            if *low > high {
                return Err(Error::invalid(
                    format!("low_m_s[{i}]"),
                    low,
                    format!("at most {high}, high_m_s"),
                ));
            }
        }
        if !(1..=MOST_TERMS).contains(&self.terms.len()) {
            return Err(Error::invalid("terms", self.terms.len(), format!("1 to {MOST_TERMS} terms")));
        }
        if let Some(i) = self.terms.iter().position(|term| Term::named(term).is_none()) {
            let allowed = "\"1\", or one to three of the letters u, v, w, as in \"uw\"";
            return Err(Error::invalid(format!("terms[{i}]"), format!("{:?}", self.terms[i]), allowed));
        }
        let again =
            |i: &usize| self.terms[..*i].iter().any(|own| Term::named(own) == Term::named(&self.terms[*i]));
        if let Some(i) = (1..self.terms.len()).find(again) {
            let given = format!("{:?}", self.terms[i]);
            return Err(Error::invalid(format!("terms[{i}]"), given, "each product once"));
        }
        if self.loads.is_empty() {
            return Err(Error::invalid("loads", "none", "at least one channel, Fx to Tz"));
        }
        for (channel, rows) in &self.loads {
            let key = || format!("loads.{channel}");
            if !CHANNELS.iter().any(|(name, _)| name == channel) {
                let names: Vec<&str> = CHANNELS.iter().map(|(name, _)| *name).collect();
                return Err(Error::invalid(
                    "loads",
                    format!("{channel:?}"),
                    wingbeat_math::names::one_of(channel, &names),
                ));
            }
            if rows.len() % 2 == 0 || rows.len() > 1 + 2 * MOST_HARMONICS {
                let allowed = format!(
                    "an odd number of rows, the mean and two for each of at most {MOST_HARMONICS} harmonics"
                );
                return Err(Error::invalid(key(), format!("{} rows", rows.len()), allowed));
            }
            if let Some(row) = rows.iter().position(|row| row.len() != self.terms.len()) {
                let allowed = format!("{}, one for each of terms", self.terms.len());
                return Err(Error::invalid(
                    format!("{}[{row}]", key()),
                    format!("{} factors", rows[row].len()),
                    allowed,
                ));
            }
        }
        Ok(())
    }
}

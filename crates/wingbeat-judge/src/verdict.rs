//! The verdict on one result, and how it comes about.

use crate::limits::{JudgedLimit, RunLimits, Sense, asked};
use crate::status::Status;
use serde::Serialize;

/// One quantity that was held against its limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// Name of the limit.
    pub id: &'static str,
    /// The run, the course or the file that it is of, where several are judged together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// The value of the result, in `unit`; absent when it is not a finite number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The limit, in `unit`.
    pub limit: f64,
    /// `at_most` or `at_least`.
    pub allowed: &'static str,
    /// Unit of both; empty for a pure number.
    pub unit: &'static str,
    /// True when the document gave the limit.
    pub overridden: bool,
    /// True when the value is allowed.
    pub met: bool,
}

/// What a reader of the result must know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// A name that does not change, `kind.what`.
    pub id: &'static str,
    /// What was found, why it matters, and what helps.
    pub text: String,
    /// How large it is, in its unit, which the text names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
    /// The key of the document that mends it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
}

impl Warning {
    /// A warning in words.
    pub fn new(id: &'static str, text: impl Into<String>) -> Self {
        Self { id, text: text.into(), size: None, key: None }
    }

    /// The same with its size, in its unit.
    pub fn size(self, size: f64) -> Self {
        Self { size: size.is_finite().then_some(size), ..self }
    }

    /// The same with the key that mends it.
    pub fn key(self, key: impl Into<String>) -> Self {
        Self { key: Some(key.into()), ..self }
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "warning ({}): {}", self.id, self.text)
    }
}

/// The verdict on a result, as `summary.json` has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// What the result is.
    pub status: Status,
    /// Why it is not `ok`; absent when it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What the status rests on.
    pub judged: Vec<Judged>,
    /// What a reader must know.
    pub warnings: Vec<Warning>,
}

impl Verdict {
    /// Why the result is not judged; none where it is.
    pub fn why_not_judged(&self) -> Option<&str> {
        self.reason.as_deref().filter(|_| self.status == Status::NotJudged)
    }

    /// The verdict on the run, the course or the file of this name, where it is one of several.
    pub fn of(mut self, name: &str) -> Self {
        self.judged.iter_mut().for_each(|judged| judged.of = Some(name.to_owned()));
        self
    }

    /// The verdict on several results, each by its name: the worst status, every reason and warning with the name before it, each value
    /// with the name beside it, the worst first.
    pub fn together<'a>(all: impl IntoIterator<Item = (&'a str, &'a Self)>) -> Self {
        let mut all: Vec<_> = all.into_iter().collect();
        all.sort_by_key(|(_, verdict)| std::cmp::Reverse(verdict.status));
        let named = |name: &str, text: &str| match name {
            "" => text.to_owned(),
            _ => format!("{name}: {text}"),
        };
        let reasons = all.iter().filter_map(|(name, of)| Some(named(name, of.reason.as_deref()?)));
        let reason = reasons.reduce(|all, next| format!("{all}; {next}"));
        let held = |(name, of): &(&str, &'a Self)| {
            let of = (*of).clone();
            if name.is_empty() { of.judged } else { of.of(name).judged }
        };
        let judged = all.iter().flat_map(held).collect();
        let warning = |(name, of): &(&str, &'a Self)| {
            let name = (*name).to_owned();
            of.warnings.iter().map(move |w| Warning { text: named(&name, &w.text), ..w.clone() })
        };
        let warnings = all.iter().flat_map(warning).collect();
        Self { status: all.first().map_or(Status::Ok, |(_, of)| of.status), reason, judged, warnings }
    }
}

/// Collects findings and gives the verdict.
#[derive(Clone, Debug)]
pub struct Judge<'a> {
    limits: &'a RunLimits,
    status: Status,
    reasons: Vec<(Status, String)>,
    judged: Vec<Judged>,
    warnings: Vec<Warning>,
}

impl<'a> Judge<'a> {
    /// Nothing found yet.
    pub fn new(limits: &'a RunLimits) -> Self {
        Self { limits, status: Status::Ok, reasons: Vec::new(), judged: Vec::new(), warnings: Vec::new() }
    }

    /// Holds `value`, in the unit of the limit, against `limit`; true when it is allowed. A limit that only a document gives is off
    /// without it.
    pub fn hold(&mut self, limit: &'static JudgedLimit, value: f64) -> bool {
        self.hold_about(limit, value, "")
    }

    /// The same where words say of what, and what helps: "of channel fx; set `[tare]`".
    pub fn hold_about(&mut self, limit: &'static JudgedLimit, value: f64, about: &str) -> bool {
        let (bound, overridden) = self.limits.of(limit);
        self.take(limit, (bound, overridden), value, about)
    }

    /// Holds `value`, in the unit of the limit, against `limit` where there is one.
    pub fn hold_if(&mut self, limit: &'static JudgedLimit, value: Option<f64>) {
        if let Some(value) = value {
            self.hold(limit, value);
        }
    }

    /// The same of each value of a table, against all its limits.
    pub fn hold_each(&mut self, table: &[(&[&'static JudgedLimit], Option<f64>)]) {
        for (limits, value) in table {
            limits.iter().for_each(|limit| self.hold_if(limit, *value));
        }
    }

    /// Holds `value`, in the unit of the limit, against `bound`, which the document's task states; `limit` says the rest.
    pub fn hold_to(&mut self, limit: &'static JudgedLimit, bound: f64, value: f64) -> bool {
        self.take(limit, (bound, false), value, "")
    }

    fn take(
        &mut self,
        limit: &'static JudgedLimit,
        (bound, overridden): (f64, bool),
        value: f64,
        about: &str,
    ) -> bool {
        if bound.is_infinite() {
            return true;
        }
        let met = limit.allows(value, bound);
        self.judged.push(Judged {
            id: limit.id,
            of: None,
            value: value.is_finite().then_some(value),
            limit: bound,
            allowed: match limit.sense {
                Sense::AtMost => "at_most",
                Sense::AtLeast => "at_least",
            },
            unit: limit.unit,
            overridden,
            met,
        });
        if !met {
            let text = words(limit, value, bound, about);
            match limit.status {
                Some(status) => self.find(status, text),
                None => self.warn(Warning::new(limit.id, text).size(value)),
            }
        }
        met
    }

    /// A finding that no limit measures.
    pub fn find(&mut self, status: Status, reason: impl Into<String>) {
        self.status = self.status.max(status);
        self.reasons.push((status, reason.into()));
    }

    /// Names the `key` of the document that mends what the last warning is of.
    pub fn mended_by(&mut self, key: &str) {
        if let Some(last) = self.warnings.last_mut() {
            last.key = Some(key.to_owned());
        }
    }

    /// Adds a warning.
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// The verdict: the worst status found, with all reasons, the worst first.
    pub fn verdict(self) -> Verdict {
        let Self { status, mut reasons, judged, warnings, .. } = self;
        reasons.sort_by_key(|(status, _)| std::cmp::Reverse(*status));
        let reasons: Vec<String> = reasons.into_iter().map(|(_, words)| words).collect();
        let reason = (!reasons.is_empty()).then(|| reasons.join("; "));
        Verdict { status, reason, judged, warnings }
    }
}

/// What is off, its value, what is allowed.
fn words(limit: &JudgedLimit, value: f64, bound: f64, about: &str) -> String {
    let unit = if limit.unit.is_empty() { String::new() } else { format!(" {}", limit.unit) };
    let side = match limit.sense {
        Sense::AtMost => "at most",
        Sense::AtLeast => "at least",
    };
    let about = if about.is_empty() { String::new() } else { format!(" {about}") };
    let meaning = if about.starts_with(" (") { limit.meaning.trim_end_matches(',') } else { limit.meaning };
    let key = if asked::ALL.contains(limit) { "" } else { "limits." };
    let allowed = number(bound);
    let shown = Some(number(value)).filter(|shown| *shown != allowed || value == bound);
    let shown = shown.unwrap_or_else(|| beside(value, bound));
    format!("{meaning}{about} is {shown}{unit}, allowed is {side} {allowed}{unit} ({key}{})", limit.id)
}

/// A number with so many digits that it does not read as the other.
fn beside(value: f64, other: f64) -> String {
    let near = |read: f64| (read - value).abs() < 0.1 * (value - other).abs();
    let mut digits = (2..17).map(|digits| format!("{value:.digits$}"));
    digits.find(|text| text.parse().is_ok_and(near)).unwrap_or_else(|| value.to_string())
}

/// A number with three digits or so, in powers of ten where it is very large or small.
fn number(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if value == 0.0 || !value.is_finite() => format!("{value}"),
        _ if !(1e-3..1e5).contains(&size) => format!("{value:.2e}"),
        _ if size < 10.0 => format!("{value:.3}").trim_end_matches('0').trim_end_matches('.').to_owned(),
        _ => format!("{value:.1}").trim_end_matches('0').trim_end_matches('.').to_owned(),
    }
}

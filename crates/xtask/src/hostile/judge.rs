//! What holds in the folder of a case after a step.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;

use super::case::CaseOutcome;
use super::place::CaseFolder;
use super::readers::{boxes, json};
use super::{pictures, snapshot};

/// What holds.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FolderClaims {
    /// Folders and exactly what lies in them, once a box that ran has ended.
    holds: BTreeMap<String, Vec<String>>,
    absent: Vec<String>,
    present: Vec<String>,
    /// Files of the same bytes.
    same: Vec<[String; 2]>,
    /// Files that are the same in `a` and `b`.
    again: Vec<String>,
    /// Summaries that are the same but for times.
    same_summary: Vec<[String; 2]>,
    /// Files and what they say.
    contains: BTreeMap<String, String>,
    /// Files and what they do not say.
    lacks: BTreeMap<String, String>,
    facts: Vec<Fact>,
    /// A folder whose pictures tell the truth.
    pictures: Option<String>,
    /// The summary of a recording in which every sample is in a count.
    accounted: Option<String>,
}

/// What stands in a JSON file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fact {
    #[serde(default = "summary")]
    file: String,
    /// The place of the value, `/status`.
    at: String,
    /// It is one of these.
    is: Option<Vec<Value>>,
    begins: Option<String>,
    /// Words of it.
    says: Option<String>,
    lacks: Option<String>,
    above: Option<f64>,
    below: Option<f64>,
    /// Number of its items.
    count: Option<usize>,
}

fn summary() -> String {
    "a/summary.json".into()
}

impl FolderClaims {
    /// True when a box that still runs must end before the judgement.
    pub fn ends_the_box(&self) -> bool {
        !self.holds.is_empty()
    }

    /// Judges.
    pub fn judge(&self, place: &CaseFolder) -> CaseOutcome {
        self.files(place)?;
        self.facts.iter().try_for_each(|fact| fact.judge(place))?;
        if let Some(folder) = &self.pictures {
            pictures::looked_at(place, folder)?;
        }
        match &self.accounted {
            Some(file) => boxes::accounted(&json(place, file)?),
            None => Ok(()),
        }
    }

    fn files(&self, place: &CaseFolder) -> CaseOutcome {
        for (folder, names) in &self.holds {
            place.holds(folder, &names.iter().map(String::as_str).collect::<Vec<_>>())?;
        }
        if let Some(name) = self.absent.iter().find(|name| place.path(name).exists()) {
            return Err(format!("left {name}"));
        }
        if let Some(name) = self.present.iter().find(|name| !place.path(name).exists()) {
            return Err(format!("no {name}"));
        }
        self.same.iter().try_for_each(|[a, b]| place.same(a, b))?;
        self.again.iter().try_for_each(|file| place.same(&format!("a/{file}"), &format!("b/{file}")))?;
        self.same_summary.iter().try_for_each(|[a, b]| snapshot::same_summary(place, a, b))?;
        for (wanted, words) in [(true, &self.contains), (false, &self.lacks)] {
            for (file, word) in words {
                if place.read(file)?.contains(word) != wanted {
                    let how = if wanted { "does not say" } else { "says" };
                    return Err(format!("{file} {how} {word:?}"));
                }
            }
        }
        Ok(())
    }
}

impl Fact {
    fn judge(&self, place: &CaseFolder) -> CaseOutcome {
        let Self { file, at, .. } = self;
        let value = json(place, file)?.pointer(at).cloned().unwrap_or_default();
        let (text, number) = (value.to_string(), value.as_f64());
        let said = value.as_str().map_or(text.as_str(), |text| text);
        let is = |wanted: &Value| match (number, wanted.as_f64()) {
            (Some(number), Some(wanted)) => number == wanted,
            _ => value == *wanted,
        };
        let holds = self.is.as_ref().is_none_or(|all| all.iter().any(is))
            && self.begins.as_ref().is_none_or(|word| said.starts_with(word.as_str()))
            && self.says.as_ref().is_none_or(|word| said.contains(word.as_str()))
            && self.lacks.as_ref().is_none_or(|word| !said.contains(word.as_str()))
            && self.above.is_none_or(|low| number.is_some_and(|number| number > low))
            && self.below.is_none_or(|high| number.is_some_and(|number| number < high))
            && self.count.is_none_or(|count| value.as_array().is_some_and(|items| items.len() == count));
        if holds { Ok(()) } else { Err(format!("{file}: {at} is {text}")) }
    }
}

//! Every key of every document, from its schema.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;
use wingbeat::scenario::{DocumentKind, unit};

use super::{root, schemas, shipped};

/// One key.
pub struct Key {
    /// From the top of the document; `[]` stands for any number of a list.
    pub path: String,
    /// What it means, with the meanings of what can be chosen.
    pub meaning: String,
    /// Unit of its numbers.
    pub unit: &'static str,
    /// What stands there.
    pub form: String,
    /// Ends of the range of its numbers.
    pub ends: [Option<RangeEnd>; 2],
    /// That range in words.
    pub range: String,
    /// What holds where it is not given.
    pub default: String,
}

/// What may stand in a file of its own and is part of a robot: no kind of document.
const PART: &str = "/ResidualSpec";

/// The keys of a kind of document.
pub fn keys(kind: DocumentKind) -> Vec<Key> {
    let schema = schemas().of(kind);
    let mut walk = SchemaWalk { root: &schema, keys: Vec::new() };
    walk.table(&schema, "", None);
    with_files(walk.keys, kind)
}

/// The same with the keys of the tables that name a file in place of an outline or an angle, behind what they stand for.
fn with_files(keys: Vec<Key>, kind: DocumentKind) -> Vec<Key> {
    let files = schemas().of_files(kind);
    let below = |definition: &str, path: &str| {
        let mut walk = SchemaWalk { root: &files, keys: Vec::new() };
        walk.table(&files["definitions"][definition], path, None);
        walk.keys
    };
    let of_file = |key: &Key| match key.path.strip_suffix("[].trailing_edge_m") {
        Some(outline) => below("OutlineFile", outline),
        None if key.path.ends_with("zero_lift_angle_deg") => below("AirfoilFile", &key.path),
        None => Vec::new(),
    };
    let each = |key: Key| {
        let more = of_file(&key);
        std::iter::once(key).chain(more)
    };
    keys.into_iter().flat_map(each).collect()
}

struct SchemaWalk<'a> {
    root: &'a Value,
    keys: Vec<Key>,
}

impl<'a> SchemaWalk<'a> {
    /// What a reference stands for.
    fn resolved(&self, schema: &'a Value) -> &'a Value {
        if let Some(name) = schema["$ref"].as_str().and_then(|reference| reference.rsplit('/').next()) {
            return self.resolved(&self.root["definitions"][name]);
        }
        match schema["allOf"].as_array().map(Vec::as_slice) {
            Some([one]) => self.resolved(one),
            _ => schema,
        }
    }

    /// The keys of a table; `chosen` is the meaning of a table with one key, one of several to choose from.
    fn table(&mut self, schema: &'a Value, path: &str, chosen: Option<&str>) {
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        for (name, property) in schema["properties"].as_object().into_iter().flatten() {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            let value = self.resolved(property);
            let own = property["description"].as_str().or(value["description"].as_str());
            let meaning = chosen.or(own).unwrap_or_default().to_owned() + &self.choices(value);
            let form = self.form(value);
            let (unit, ends) = match form.contains("number") {
                true => (unit(&path), ends(value)),
                false => ("", [None; 2]),
            };
            let default = match (&property["default"], &value["default"]) {
                _ if chosen.is_some() => "one of these".into(),
                _ if required.contains(&name.as_str()) => "required".into(),
                (Value::Null, Value::Null) => "none".into(),
                (Value::Null, inner) => written(inner),
                (outer, _) => written(outer),
            };
            self.keys.push(Key {
                path: path.clone(),
                meaning,
                unit,
                form,
                ends,
                range: range(ends),
                default,
            });
            self.below(value, &path);
        }
    }

    /// The keys of the tables in a value.
    fn below(&mut self, value: &'a Value, path: &str) {
        if value["properties"].is_object() {
            return self.table(value, path, None);
        }
        if value["items"].is_object() {
            return self.below(self.resolved(&value["items"]), &format!("{path}[]"));
        }
        for choice in list(value, "oneOf") {
            self.table(self.resolved(choice), path, choice["description"].as_str());
        }
        let is_part = |choice: &Value| {
            choice["additionalProperties"].is_object()
                || choice["$ref"].as_str().is_some_and(|name| name.ends_with(PART))
        };
        if !is_file(value) || list(value, "anyOf").iter().any(is_part) {
            let tables = list(value, "anyOf").iter().map(|choice| self.resolved(choice));
            let tables: Vec<&Value> = tables.filter(|table| table["properties"].is_object()).collect();
            tables.into_iter().for_each(|table| self.table(table, path, None));
        }
    }

    /// What stands there, in words.
    fn form(&self, value: &'a Value) -> String {
        if is_file(value) {
            return "file, or the table itself".into();
        }
        let choices = list(value, "anyOf");
        let plain = |choice: &Value| choice["type"].is_string() && choice["type"] != "object";
        if !choices.is_empty() && choices.iter().all(plain) {
            return choices.iter().map(|choice| self.form(choice)).collect::<Vec<_>>().join(" or ");
        }
        if let Some(shipped) = choices.first() {
            return self.form(self.resolved(shipped)) + ", or a table under a name of your own";
        }
        let names = self.names(value);
        if !names.is_empty() {
            return names.iter().map(|name| format!("`\"{name}\"`")).collect::<Vec<_>>().join(" or ");
        }
        if !list(value, "oneOf").is_empty() {
            return "table".into();
        }
        match value["type"].as_str() {
            Some("string") => "text".into(),
            Some("boolean") => "`true` or `false`".into(),
            Some("integer") => "whole number".into(),
            Some("number") => "number".into(),
            Some("array") => {
                let items = self.form(self.resolved(&value["items"]));
                match (value["minItems"].as_u64(), value["maxItems"].as_u64()) {
                    (Some(least), Some(most)) if least == most => format!("{least} of: {items}"),
                    (None, Some(most)) => format!("list of at most {most}: {items}"),
                    _ => format!("list of: {items}"),
                }
            }
            _ if value["additionalProperties"].is_object() => {
                format!("table of: {} by name", self.form(self.resolved(&value["additionalProperties"])))
            }
            _ => "table".into(),
        }
    }

    /// The names of which one is chosen.
    fn names(&self, value: &'a Value) -> Vec<&'a str> {
        let chosen = list(value, "oneOf").iter().filter_map(|choice| {
            choice["const"].as_str().or_else(|| choice["enum"].as_array()?.first()?.as_str())
        });
        let listed = list(value, "enum").iter().filter_map(Value::as_str);
        chosen.chain(listed).chain(value["const"].as_str()).collect()
    }

    /// The meanings of the names of which one is chosen.
    fn choices(&self, value: &'a Value) -> String {
        let meaning = |choice: &Value| {
            let name = choice["const"].as_str().or_else(|| choice["enum"].as_array()?.first()?.as_str())?;
            Some(format!(" `{name}`: {}", choice["description"].as_str()?))
        };
        list(value, "oneOf").iter().filter_map(meaning).collect()
    }
}

fn list<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().map_or(&[], Vec::as_slice)
}

/// Whether a file may be named there.
fn is_file(value: &Value) -> bool {
    list(value, "anyOf").first().is_some_and(|choice| choice["type"] == "string")
}

/// Where a range ends, and whether the end itself is in it.
#[derive(Clone, Copy)]
pub struct RangeEnd {
    pub at: f64,
    pub closed: bool,
}

/// The ends of the range of a key's numbers, by their schema.
fn ends(value: &Value) -> [Option<RangeEnd>; 2] {
    let numbers = if value["items"].is_object() { &value["items"] } else { value };
    let end = |closed: &str, open: &str| {
        let of = |name: &str, closed| Some(RangeEnd { at: numbers[name].as_f64()?, closed });
        of(open, false).or(of(closed, true))
    };
    [end("minimum", "exclusiveMinimum"), end("maximum", "exclusiveMaximum")]
}

/// The range in words.
fn range([low, high]: [Option<RangeEnd>; 2]) -> String {
    let number = |at: f64| if at.abs() < 1e5 { at.to_string() } else { format!("{at:e}") };
    match (low, high) {
        (Some(low), Some(high)) if low.at == -high.at && low.closed && high.closed => {
            format!("±{}", number(high.at))
        }
        (Some(low), Some(high)) => {
            let above = if low.closed { "" } else { "above " };
            let below = if high.closed { "" } else { "below " };
            format!("{above}{} to {below}{}", number(low.at), number(high.at))
        }
        (Some(low), None) => format!("at least {}", number(low.at)),
        (None, Some(high)) => format!("at most {}", number(high.at)),
        (None, None) => String::new(),
    }
}

/// A default as a document would give it.
fn written(default: &Value) -> String {
    match default {
        Value::Object(_) => "by its keys".into(),
        Value::Array(items) if items.is_empty() => "`[]`".into(),
        other => format!("`{other}`"),
    }
}

#[test]
fn every_key_has_a_meaning_and_every_shipped_key_is_in_the_reference() {
    for kind in DocumentKind::ALL {
        let keys = keys(kind);
        for key in &keys {
            assert!(key.meaning.len() > 3, "{} {}: no doc comment", kind.name(), key.path);
        }
        let paths: BTreeSet<&str> = keys.iter().map(|key| key.path.as_str()).collect();
        for document in shipped::all().iter().filter(|document| document.kind == kind) {
            shipped::walk(&document.table, "", &mut |path, _| {
                let parent = path.rsplit_once('.').map_or("", |(parent, _)| parent);
                let by_name = keys.iter().any(|key| key.path == parent && key.form.ends_with("by name"));
                let known = paths.contains(path) || by_name;
                assert!(known, "{}: {path} is no key", document.file);
            });
        }
    }
}

#[test]
fn every_field_of_every_spec_is_in_the_reference() {
    let mut names = BTreeSet::new();
    for kind in DocumentKind::ALL {
        names.extend(
            keys(kind)
                .into_iter()
                .flat_map(|key| key.path.split(['.', '[', ']']).map(str::to_owned).collect::<Vec<_>>()),
        );
    }
    let mut fields = 0;
    let mut see = |text: &str| {
        for spec in text.split("schemars::JsonSchema)]").skip(1) {
            let body: Vec<&str> = spec.lines().take_while(|line| line.trim() != "}").collect();
            let body = body.join("\n");
            // What a run writes is no key of a document.
            if body.contains("Summary {\n") {
                continue;
            }
            for line in body.lines().filter(|line| !line.trim_start().starts_with("//")) {
                let field = line.trim().trim_start_matches("pub ").split_once(": ").map(|(name, _)| name);
                let field = field.filter(|name| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'));
                if let Some(field) = field {
                    fields += 1;
                    assert!(names.contains(field), "{field} is in no table of docs/reference.md");
                }
            }
        }
    };
    for part in ["aero", "robot", "flight", "rig", "config"] {
        for_sources(&root().join(format!("crates/wingbeat-{part}/src")), &mut see);
    }
    assert!(fields > 250, "{fields} fields found");
}

fn for_sources(folder: &Path, see: &mut impl FnMut(&str)) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            for_sources(&path, see);
        } else if path.extension().is_some_and(|e| e == "rs") {
            see(&fs::read_to_string(&path).unwrap());
        }
    }
}

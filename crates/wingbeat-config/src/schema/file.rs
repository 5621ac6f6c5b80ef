//! JSON Schemas of files: of documents that may be based on others, and may then leave out every key.

use serde_json::{Map, Value, json};
use wingbeat_math::order::filled;

use super::{DocumentKind, Schemas};
use crate::document::{AIRFOIL_KEY, BASE, OUTLINE_KEY, WITHOUT};

/// The keys in whose place a table may name a file, the type of what stands there else, and the definition of the table.
const NAMED: [(&str, &str, &str); 2] =
    [(OUTLINE_KEY, "array", "OutlineFile"), (AIRFOIL_KEY, "number", "AirfoilFile")];
/// Definitions of what may be a document of its own: a file, or a table in its place.
const DOCUMENTS: [&str; 6] =
    ["ScenarioSpec", "RobotSpec", "TetherSpec", "RigRunSpec", "RigSpec", "ArmConfig"];

impl Schemas {
    /// The schema of the files of a kind of document, as [`DocumentKind::schema_of_files`] says.
    pub fn of_files(&self, kind: DocumentKind) -> Value {
        let Value::Object(mut whole) = self.of(kind) else { return Value::Null };
        let definitions = whole.remove("definitions");
        let mut all = Map::new();
        for (name, definition) in definitions.iter().filter_map(Value::as_object).flatten() {
            let Value::Object(definition) = definition else { continue };
            let part = part(definition);
            if DOCUMENTS.contains(&name.as_str()) {
                all.insert(of_whole(name), definition.clone().into());
                all.insert(of_part(name), based(part).into());
                all.insert(name.clone(), either(of_part(name), of_whole(name)));
            } else {
                all.insert(of_part(name), part.into());
                all.insert(name.clone(), definition.clone().into());
            }
        }
        let mut file = based(part(&whole));
        let whole: Map<_, _> = filled(whole.into_iter().filter(|(key, _)| !key.starts_with('$')));
        all.insert(of_whole("Document"), whole.into());
        file.insert("if".into(), has_base());
        file.insert("else".into(), reference(&of_whole("Document")));
        file.insert("definitions".into(), all.into());
        self.with_files(file.into())
    }

    /// The schema of files, in which a table that names a file may stand for an outline or an angle.
    fn with_files(&self, mut file: Value) -> Value {
        for (key, kind, name) in NAMED {
            if !takes_files(&mut file, key, kind, name) {
                continue;
            }
            let Some(table) = self.tables.get(name) else { continue };
            if let Some(all) = file["definitions"].as_object_mut() {
                all.extend(self.below(table));
                all.insert(name.into(), table.clone());
            }
        }
        file
    }
}

/// Lets each `key` below be a table; whether there is one.
fn takes_files(schema: &mut Value, key: &str, kind: &str, name: &str) -> bool {
    let mut found = false;
    if let Some(own) = schema.get_mut("properties").and_then(|keys| keys.get_mut(key))
        && is_of(&own["type"], kind)
    {
        let plain = own.take();
        let description = plain["description"].clone();
        *own = json!({ "description": description, "anyOf": [plain, reference(name)] });
        found = true;
    }
    let mut below = |value: &mut Value| found |= takes_files(value, key, kind, name);
    match schema {
        Value::Object(table) => table.values_mut().for_each(&mut below),
        Value::Array(items) => items.iter_mut().for_each(&mut below),
        _ => {}
    }
    found
}

/// Whether a schema's type is `kind`, or `kind` or nothing.
fn is_of(given: &Value, kind: &str) -> bool {
    given == kind || given.as_array().is_some_and(|kinds| kinds.iter().any(|one| one == kind))
}

fn of_whole(name: &str) -> String {
    format!("{name}.whole")
}

fn of_part(name: &str) -> String {
    format!("{name}.part")
}

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/definitions/{name}") })
}

fn has_base() -> Value {
    json!({ "required": [BASE], "properties": { BASE: { "type": "string" } } })
}

/// A document that is based on another has the form of `part`, others that of `whole`.
fn either(part: String, whole: String) -> Value {
    json!({ "if": has_base(), "then": reference(&part), "else": reference(&whole) })
}

/// The schema of a table of which every key may be left out.
fn part(schema: &Map<String, Value>) -> Map<String, Value> {
    let kept = schema.iter().filter(|(key, _)| *key != "required");
    filled(kept.map(|(key, value)| (key.clone(), part_of(key, value))))
}

fn part_of(key: &str, value: &Value) -> Value {
    match value {
        Value::Object(schema) => part(schema).into(),
        Value::Array(schemas) => schemas.iter().map(|schema| part_of(key, schema)).collect(),
        Value::String(name) if key == "$ref" => of_part(name).into(),
        other => other.clone(),
    }
}

/// The schema of a document, with the keys by which it is based on another.
fn based(mut schema: Map<String, Value>) -> Map<String, Value> {
    let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) else { return schema };
    let base = "The file that this document is based on, relative to it: what the document says changes or adds to it.";
    let mut file = json!({ "description": base, "type": "string" });
    if let Some(own) = properties.remove(BASE) {
        file = json!({ "anyOf": [file, own] });
    }
    properties.insert(BASE.into(), file);
    let without =
        "Keys of the base that the document does not have; items of lists are called by their name.";
    let keys = json!({ "description": without, "type": "array", "items": { "type": "string" } });
    properties.insert(WITHOUT.into(), keys);
    schema
}

//! JSON Schemas of files: of documents that may be based on others, and may then leave out every key.

use serde_json::{Map, Value, json};

use super::DocumentKind;
use crate::document::{BASE, WITHOUT};

/// Definitions of what may be a document of its own: a file, or a table in its place.
const DOCUMENTS: [&str; 6] =
    ["ScenarioSpec", "RobotSpec", "TetherSpec", "RigRunSpec", "RigSpec", "ArmConfig"];

impl DocumentKind {
    /// The JSON Schema of the files of such documents: [`schema`](Self::schema), where a document with the key `base`
    /// need not give any key.
    pub fn schema_of_files(self) -> Value {
        let Value::Object(mut whole) = self.schema() else { return Value::Null };
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
        let whole: Map<_, _> = whole.into_iter().filter(|(key, _)| !key.starts_with('$')).collect();
        all.insert(of_whole("Document"), whole.into());
        file.insert("if".into(), has_base());
        file.insert("else".into(), reference(&of_whole("Document")));
        file.insert("definitions".into(), all.into());
        file.into()
    }
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
    kept.map(|(key, value)| (key.clone(), part_of(key, value))).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_with_a_base_may_leave_out_keys_and_one_without_may_not() {
        let schema = DocumentKind::Scenario.schema_of_files();
        assert_eq!(schema["if"]["required"], json!(["base"]));
        assert_eq!(schema["required"], Value::Null);
        assert_eq!(schema["definitions"]["AirSpec.part"]["required"], Value::Null);
        assert_eq!(schema["properties"]["air"]["allOf"][0]["$ref"], "#/definitions/AirSpec.part");
        let whole = &schema["definitions"]["Document.whole"];
        assert!(whole["required"].as_array().unwrap().contains(&json!("air")));
        assert_eq!(whole["properties"]["air"]["allOf"][0]["$ref"], "#/definitions/AirSpec");
        assert_eq!(schema["definitions"]["AirSpec"]["required"], json!(["density_kg_m3"]));
    }
}

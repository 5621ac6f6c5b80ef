//! Whether a value meets a schema, as far as the schemas of the documents go.

use serde_json::Value;
use wingbeat::scenario::DocumentKind;

use super::{schemas, shipped};

/// Why `value` does not meet `schema`, whose definitions are in `root`.
fn fault(root: &Value, schema: &Value, value: &Value) -> Option<String> {
    let choices = |name: &str| schema[name].as_array().map_or(&[][..], Vec::as_slice);
    let inner = |schema| fault(root, schema, value);
    if let Some(reference) = schema["$ref"].as_str() {
        return inner(&root["definitions"][reference.rsplit('/').next()?]);
    }
    if schema["if"].is_object() {
        let branch = if inner(&schema["if"]).is_none() { "then" } else { "else" };
        if let Some(why) = inner(&schema[branch]) {
            return Some(why);
        }
    }
    if let Some(why) = choices("allOf").iter().find_map(inner) {
        return Some(why);
    }
    for name in ["anyOf", "oneOf"] {
        let met = choices(name).iter().filter(|choice| inner(choice).is_none()).count();
        if !choices(name).is_empty() && met == 0 {
            return Some(format!("{value} meets none of {name}: {:?}", inner(&choices(name)[0])));
        }
    }
    if !schema["const"].is_null() && schema["const"] != *value {
        return Some(format!("{value} is not {}", schema["const"]));
    }
    if !choices("enum").is_empty() && !choices("enum").contains(value) {
        return Some(format!("{value} is none of {}", schema["enum"]));
    }
    let right = match schema["type"].as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("integer") => value.is_i64() || value.is_u64(),
        Some("number") => value.is_number(),
        _ => true,
    };
    if !right {
        return Some(format!("{value} is no {}", schema["type"]));
    }
    bounds(schema, value).or_else(|| items(root, schema, value)).or_else(|| properties(root, schema, value))
}

fn bounds(schema: &Value, value: &Value) -> Option<String> {
    let number = value.as_f64()?;
    let low = schema["minimum"].as_f64().is_some_and(|least| number < least);
    let high = schema["maximum"].as_f64().is_some_and(|most| number > most);
    (low || high).then(|| format!("{number} is out of range"))
}

fn items(root: &Value, schema: &Value, value: &Value) -> Option<String> {
    let items = value.as_array()?;
    let count = items.len() as u64;
    let few = schema["minItems"].as_u64().is_some_and(|least| count < least);
    let many = schema["maxItems"].as_u64().is_some_and(|most| count > most);
    let counted = (few || many).then(|| format!("{count} items"));
    counted.or_else(|| items.iter().find_map(|item| fault(root, &schema["items"], item)))
}

fn properties(root: &Value, schema: &Value, value: &Value) -> Option<String> {
    let table = value.as_object()?;
    let required = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    if let Some(missing) = required.into_iter().find(|key| !table.contains_key(*key)) {
        return Some(format!("{missing} is missing"));
    }
    let other = &schema["additionalProperties"];
    table.iter().find_map(|(key, value)| match &schema["properties"][key] {
        Value::Null if *other == Value::Bool(false) => Some(format!("{key} is not known")),
        Value::Null => fault(root, other, value).map(|why| format!("{key}: {why}")),
        property => fault(root, property, value).map(|why| format!("{key}: {why}")),
    })
}

#[test]
fn shipped_documents_meet_their_schema_and_misspelt_ones_do_not_by_this_reference() {
    for document in shipped::all() {
        let (whole, file) = (schemas().of(document.kind), schemas().of_files(document.kind));
        let written: toml::Table = document.text.parse().unwrap();
        for (schema, table) in [(whole, &document.table), (file, &written)] {
            let mut value = serde_json::to_value(table).unwrap();
            assert_eq!(fault(&schema, &schema, &value), None, "{}", document.file);
            value["nmae"] = "x".into();
            assert!(fault(&schema, &schema, &value).is_some(), "{}", document.file);
        }
    }
    let schema = schemas().of(DocumentKind::Scenario);
    let text = include_str!("../../documents/banking_turn.toml");
    let file = schemas().of_files(DocumentKind::Scenario);
    let based = serde_json::json!({ "base": "a.toml", "air": {}, "robot": { "base": "b.toml", "without": ["gait"] } });
    assert_eq!(fault(&file, &file, &based), None);
    assert!(fault(&schema, &schema, &based).is_some());
    assert!(fault(&file, &file, &serde_json::json!({ "name": "a", "air": {} })).is_some());
    for (right, wrong) in [
        ("law = \"linear\"", "law = \"liner\""),
        ("density_kg_m3 = 1.225", "density_kg_m3 = 1e99"),
        ("density_kg_m3 = 1.225", "density = 1.225"),
        ("wind_m_s = [0.0, 0.0, 0.0]", "wind_m_s = [0.0, 0.0]"),
        ("iterations = 1", "iterations = -1"),
        ("roll = 5.0", "rol = 5.0"),
    ] {
        assert!(text.contains(right), "{right}");
        let table: toml::Table = text.replace(right, wrong).parse().unwrap();
        let value = serde_json::to_value(&table).unwrap();
        assert!(fault(&schema, &schema, &value).is_some(), "{wrong}");
        assert!(fault(&file, &file, &value).is_some(), "{wrong}");
    }
}

//! Schemas made from the specs.

use std::borrow::Cow;

use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use wingbeat_flight::guide::{AboutOrbitSpec, CommandsSpec, HoverSpec, MpcSpec, Turn};
use wingbeat_rig::arm::ArmConfig;
use wingbeat_robot::RobotSpec;

use super::{DocumentKind, Schemas};
use crate::chosen::{Chosen, Named};
use crate::document::{AirfoilFile, OutlineFile};
use crate::measure::{Measure, Measured, measures};
use crate::rig_spec::RunList;
use crate::{CalibrationSpec, RigRunSpec, RigSpec, ScenarioSpec, Summary, SweepSpec, TetherSpec, largest};

impl Schemas {
    /// Makes all from the specs.
    ///
    /// # Panics
    /// When two kinds have different definitions of one name.
    pub fn made() -> Self {
        let mut made =
            Self { documents: Map::new(), definitions: Map::new(), tables: Map::new(), summary: summary() };
        for kind in DocumentKind::ALL {
            let mut schema = document(kind);
            schema.insert("title".into(), kind.name().into());
            let schema = made.without_definitions(schema);
            made.documents.insert(kind.name().into(), schema);
        }
        for (name, mut table) in [
            ("OutlineFile", generator().into_root_schema_for::<OutlineFile>()),
            ("AirfoilFile", generator().into_root_schema_for::<AirfoilFile>()),
        ] {
            table.remove("$schema");
            let table = made.without_definitions(table);
            made.tables.insert(name.into(), table);
        }
        made
    }

    /// The schema without its definitions, which are kept with those of all.
    fn without_definitions(&mut self, mut schema: Schema) -> Value {
        if let Some(Value::Object(definitions)) = schema.remove("definitions") {
            for (name, definition) in definitions {
                let known = self.definitions.get(&name).is_none_or(|known| *known == definition);
                assert!(known, "two definitions are called {name}");
                self.definitions.insert(name, definition);
            }
        }
        schema.to_value()
    }
}

fn generator() -> SchemaGenerator {
    SchemaSettings::draft07().with_transform(tidy).into_generator()
}

fn document(kind: DocumentKind) -> Schema {
    let generator = generator();
    match kind {
        DocumentKind::Scenario => generator.into_root_schema_for::<ScenarioSpec>(),
        DocumentKind::Robot => generator.into_root_schema_for::<RobotSpec>(),
        DocumentKind::Case => generator.into_root_schema_for::<TetherSpec>(),
        DocumentKind::Sweep => generator.into_root_schema_for::<SweepSpec>(),
        DocumentKind::Run => generator.into_root_schema_for::<RigRunSpec>(),
        DocumentKind::Runs => generator.into_root_schema_for::<RunList>(),
        DocumentKind::Rig => generator.into_root_schema_for::<RigSpec>(),
        DocumentKind::Arm => generator.into_root_schema_for::<ArmConfig>(),
        DocumentKind::Calibration => generator.into_root_schema_for::<CalibrationSpec>(),
    }
}

/// What `summary.json` of a flight can hold.
fn summary() -> Value {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<Summary>().into()
}

impl JsonSchema for Named {
    fn schema_name() -> Cow<'static, str> {
        "Named".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A table under the name of its kind, one of the program's own.",
            "type": "object",
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": { "type": "object" },
        })
    }
}

impl JsonSchema for Measured {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Measured".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = |measure: &Measure| {
            let schema = json!({ "type": ["number", "null"], "description": measure.meaning });
            (measure.key.to_owned(), schema)
        };
        let properties: Map<_, _> = measures().map(number).collect();
        json_schema!({ "type": "object", "properties": properties })
    }
}

/// The kinds beside a table that ships, which ship under a name of their own.
pub trait ShippedKinds {
    /// Their names and schemas.
    fn beside(_: &mut SchemaGenerator) -> Vec<(&'static str, Schema)> {
        Vec::new()
    }
}

impl ShippedKinds for Turn {}

impl ShippedKinds for MpcSpec {
    fn beside(generator: &mut SchemaGenerator) -> Vec<(&'static str, Schema)> {
        vec![
            ("orbit", generator.subschema_for::<AboutOrbitSpec>()),
            ("hover", generator.subschema_for::<HoverSpec>()),
            ("commands", generator.subschema_for::<CommandsSpec>()),
        ]
    }
}

impl<T: JsonSchema + ShippedKinds> JsonSchema for Chosen<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("Chosen{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let shipped = generator.subschema_for::<T>();
        let beside = T::beside(generator);
        if beside.is_empty() {
            let named = generator.subschema_for::<Named>();
            return json_schema!({ "anyOf": [shipped, named] });
        }
        let names: Vec<&str> = beside.iter().map(|(name, _)| *name).collect();
        let mut named = <Named as JsonSchema>::json_schema(generator);
        named.insert("propertyNames".into(), json!({ "not": { "enum": names } }));
        let tables: Map<String, Value> =
            beside.into_iter().map(|(name, schema)| (name.into(), schema.to_value())).collect();
        let kinds = json_schema!({ "type": "object", "properties": tables, "additionalProperties": false });
        json_schema!({ "anyOf": [shipped, kinds, named] })
    }
}

/// TOML has no null; descriptions are plain text; numbers have the ranges of their units.
fn tidy(schema: &mut Schema) {
    transform_subschemas(&mut tidy, schema);
    let Some(object) = schema.as_object_mut() else { return };
    if let Some(Value::String(text)) = object.get_mut("description") {
        *text = plain(text);
    }
    if object.get("default").is_some_and(Value::is_null) {
        object.remove("default");
    }
    if let Some(Value::Array(types)) = object.get_mut("type") {
        types.retain(|name| name != "null");
        if let [one] = types.as_slice() {
            let one = one.clone();
            object.insert("type".into(), one);
        }
    }
    if let Some(Value::Array(choices)) = object.get_mut("anyOf") {
        choices.retain(|choice| *choice != json!({ "type": "null" }));
        if choices.len() == 1 {
            let one = object.remove("anyOf").unwrap_or_default();
            object.insert("allOf".into(), one);
        }
    }
    if let Some(Value::Object(properties)) = object.get_mut("properties") {
        let bounded = properties.iter_mut().filter(|(key, _)| *key != "seed");
        bounded.for_each(|(key, property)| limit(property, largest(key)));
    }
}

/// Bounds the numbers of a property, alone or in lists.
fn limit(schema: &mut Value, largest: f64) {
    let Some(object) = schema.as_object_mut() else { return };
    let (number, whole) = match object.get("type").and_then(Value::as_str) {
        Some("number") => (true, false),
        Some("integer") => (false, !object.contains_key("maximum")),
        _ => (false, false),
    };
    if number && !["minimum", "exclusiveMinimum"].iter().any(|end| object.contains_key(*end)) {
        object.insert("minimum".into(), (-largest).into());
    }
    if (number || whole) && !["maximum", "exclusiveMaximum"].iter().any(|end| object.contains_key(*end)) {
        object.insert("maximum".into(), largest.into());
    }
    if let Some(items) = object.get_mut("items") {
        limit(items, largest);
    }
}

/// The text of a doc comment without its line ends and links.
pub fn plain(text: &str) -> String {
    let paragraphs: Vec<String> = text.split("\n\n").map(|paragraph| paragraph.replace('\n', " ")).collect();
    let text = paragraphs.join("\n\n");
    let mut parts = text.split("[`");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let Some((name, rest)) = part.split_once("`]") else {
            plain += "[`";
            plain += part;
            continue;
        };
        let rest =
            rest.strip_prefix('(').and_then(|rest| rest.split_once(')')).map_or(rest, |(_, rest)| rest);
        plain = plain + "`" + name + "`" + rest;
    }
    plain
}

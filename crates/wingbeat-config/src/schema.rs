//! JSON Schemas of the documents, from the specs that read them.

mod file;

use std::borrow::Cow;

use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::chosen::{Chosen, Named};
use super::rig_spec::RunList;
use super::{CalibrationSpec, RigRunSpec, RigSpec, ScenarioSpec, SweepSpec, TetherSpec, largest};
use wingbeat_flight::guide::{AboutOrbitSpec, CommandsSpec, HoverSpec, MpcSpec, Turn};
use wingbeat_rig::arm::ArmConfig;
use wingbeat_robot::RobotSpec;

/// What a document can be of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DocumentKind {
    /// A flight.
    Scenario,
    /// A robot.
    Robot,
    /// A wing in prescribed motion.
    Case,
    /// Many flights of a scenario.
    Sweep,
    /// A run on the rig.
    Run,
    /// A list of runs on the rig.
    Runs,
    /// The rig: robot, arm, load cell.
    Rig,
    /// The arm of a rig.
    Arm,
    /// A fit to runs on the rig.
    Calibration,
}

impl DocumentKind {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::Scenario,
        Self::Robot,
        Self::Case,
        Self::Sweep,
        Self::Run,
        Self::Runs,
        Self::Rig,
        Self::Arm,
        Self::Calibration,
    ];

    /// The kind in one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Robot => "robot",
            Self::Case => "case",
            Self::Sweep => "sweep",
            Self::Run => "run",
            Self::Runs => "runs",
            Self::Rig => "rig",
            Self::Arm => "arm",
            Self::Calibration => "calibration",
        }
    }

    /// The kind called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The JSON Schema (draft 7, which every editor knows) of such documents, once they are read: keys, meanings, types, defaults,
    /// and ranges: those of the specs, else the largest magnitudes by unit. What depends on several keys at once is checked when a document is read.
    pub fn schema(self) -> Value {
        let settings = SchemaSettings::draft07().with_transform(tidy);
        let generator = settings.into_generator();
        let mut schema = match self {
            Self::Scenario => generator.into_root_schema_for::<ScenarioSpec>(),
            Self::Robot => generator.into_root_schema_for::<RobotSpec>(),
            Self::Case => generator.into_root_schema_for::<TetherSpec>(),
            Self::Sweep => generator.into_root_schema_for::<SweepSpec>(),
            Self::Run => generator.into_root_schema_for::<RigRunSpec>(),
            Self::Runs => generator.into_root_schema_for::<RunList>(),
            Self::Rig => generator.into_root_schema_for::<RigSpec>(),
            Self::Arm => generator.into_root_schema_for::<ArmConfig>(),
            Self::Calibration => generator.into_root_schema_for::<CalibrationSpec>(),
        };
        schema.insert("title".into(), self.name().into());
        schema.to_value()
    }
}

pub(super) use wingbeat_robot::file_or;

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

/// The kinds beside a table that ships, which ship under a name of their own.
pub trait Beside {
    /// Their names and schemas.
    fn beside(_: &mut SchemaGenerator) -> Vec<(&'static str, Schema)> {
        Vec::new()
    }
}

impl Beside for Turn {}

impl Beside for MpcSpec {
    fn beside(generator: &mut SchemaGenerator) -> Vec<(&'static str, Schema)> {
        vec![
            ("orbit", generator.subschema_for::<AboutOrbitSpec>()),
            ("hover", generator.subschema_for::<HoverSpec>()),
            ("commands", generator.subschema_for::<CommandsSpec>()),
        ]
    }
}

impl<T: JsonSchema + Beside> JsonSchema for Chosen<T> {
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
        let tables: serde_json::Map<String, Value> =
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

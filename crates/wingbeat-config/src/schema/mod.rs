//! JSON Schemas of the documents, made from the specs that read them and kept as text, which every build prints.

mod file;
#[cfg(feature = "schema")]
mod made;

use std::collections::BTreeSet;
use std::sync::OnceLock;

use serde_json::{Map, Value};

#[cfg(feature = "schema")]
pub use made::plain;
#[cfg(feature = "schema")]
pub(super) use wingbeat_robot::file_or;

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

    /// What reads such a document, in words.
    pub fn readers(self) -> &'static str {
        match self {
            Self::Scenario => "`wingbeat fly`",
            Self::Robot => "`wingbeat trim` and by the key `robot` of a scenario",
            Self::Case => "`wingbeat tether`",
            Self::Sweep => "`wingbeat sweep`",
            Self::Run | Self::Runs => "`wingbeat rig simulate`",
            Self::Rig => "the key `rig` of a run",
            Self::Arm => "the key `arm` of a rig",
            Self::Calibration => "`wingbeat calibrate`",
        }
    }

    /// The kind of a document with these `keys`, of which it has those that `has` tells: all are known to it, and none is missing.
    pub(crate) fn with_keys<'a>(
        has: &dyn Fn(&str) -> bool,
        keys: &mut dyn Iterator<Item = &'a str>,
    ) -> Option<Self> {
        let keys: Vec<&str> = keys.collect();
        let kept = Schemas::kept();
        Self::ALL.into_iter().find(|kind| {
            let schema = kept.documents.get(kind.name());
            let part = |name: &str| schema.and_then(|schema| schema.get(name));
            let known = part("properties").and_then(Value::as_object);
            let needed = part("required").and_then(Value::as_array);
            keys.iter().all(|key| known.is_some_and(|known| known.contains_key(*key)))
                && needed.is_some_and(|needed| needed.iter().filter_map(Value::as_str).all(has))
        })
    }

    /// The kind called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The JSON Schema (draft 7, which every editor knows) of such documents, once they are read: keys, meanings, types, defaults,
    /// and ranges: those of the specs, else the largest magnitudes by unit. What depends on several keys at once is checked when a document is read.
    pub fn schema(self) -> Value {
        Schemas::kept().of(self)
    }

    /// The JSON Schema of the files of such documents: [`schema`](Self::schema), where a document with the key `base`
    /// need not give any key.
    pub fn schema_of_files(self) -> Value {
        Schemas::kept().of_files(self)
    }
}

/// Whether `a` and `b` are two of several tables of which a document has one, as are `line` and `helix` of `path.curve`.
pub(crate) fn are_alternatives(a: &str, b: &str) -> bool {
    static CHOICES: OnceLock<Vec<Vec<String>>> = OnceLock::new();
    let choices = CHOICES.get_or_init(|| Schemas::kept().choices());
    let is_one = |choice: &Vec<String>, name: &str| choice.iter().any(|one| one == name);
    a != b && choices.iter().any(|choice| is_one(choice, a) && is_one(choice, b))
}

/// The schemas of all kinds, and of what a flight's summary holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Schemas {
    /// By kind, without definitions.
    documents: Map<String, Value>,
    /// Definitions of all kinds.
    definitions: Map<String, Value>,
    /// Of the tables that may name a file in place of a value, by the name of their definition.
    tables: Map<String, Value>,
    summary: Value,
}

impl Schemas {
    /// Those that were made when the library was released; `cargo xtask reference` makes them again.
    pub fn kept() -> Self {
        Self::read(include_str!("kept.json"))
    }

    /// The names of the tables of each definition of which a document has one alone.
    fn choices(&self) -> Vec<Vec<String>> {
        let alone = |one: &Value| {
            let needed = one.get("required")?.as_array()?;
            let known = one.get("properties")?.as_object()?;
            match needed.as_slice() {
                [name] if known.len() == 1 => name.as_str().map(str::to_owned),
                _ => None,
            }
        };
        let choice = |schema: &Value| schema.get("oneOf")?.as_array()?.iter().map(alone).collect();
        self.definitions.values().filter_map(choice).collect()
    }

    fn read(text: &str) -> Self {
        let mut parts: Map<String, Value> = serde_json::from_str(text).unwrap_or_default();
        let mut part = |name: &str| parts.remove(name).unwrap_or_default();
        let table = |part: Value| if let Value::Object(table) = part { table } else { Map::new() };
        Self {
            documents: table(part("documents")),
            definitions: table(part("definitions")),
            tables: table(part("tables")),
            summary: part("summary"),
        }
    }

    /// The text that is kept: a line for each definition.
    pub fn text(&self) -> String {
        let lines = |table: &Map<String, Value>| {
            let lines: Vec<String> = table
                .iter()
                .map(|(name, schema)| format!("{}:{schema}", Value::from(name.as_str())))
                .collect();
            format!("{{\n{}\n}}", lines.join(",\n"))
        };
        let [documents, definitions, tables] = [&self.documents, &self.definitions, &self.tables].map(lines);
        format!(
            "{{\"definitions\":{definitions},\n\"documents\":{documents},\n\"summary\":{},\n\"tables\":{tables}}}\n",
            self.summary
        )
    }

    /// The schema of a kind of document, as [`DocumentKind::schema`] says.
    pub fn of(&self, kind: DocumentKind) -> Value {
        let mut schema = self.documents.get(kind.name()).cloned().unwrap_or_default();
        let definitions = self.below(&schema);
        if !definitions.is_empty()
            && let Some(schema) = schema.as_object_mut()
        {
            schema.insert("definitions".into(), definitions.into());
        }
        schema
    }

    /// What `summary.json` of a flight can hold.
    pub fn summary(&self) -> &Value {
        &self.summary
    }

    /// The definitions that a schema names, and those that they name.
    fn below(&self, schema: &Value) -> Map<String, Value> {
        let mut left = BTreeSet::new();
        named(schema, &mut left);
        let mut all = Map::new();
        while let Some(name) = left.pop_first() {
            let Some(definition) = self.definitions.get(&name).filter(|_| !all.contains_key(&name)) else {
                continue;
            };
            named(definition, &mut left);
            all.insert(name, definition.clone());
        }
        all
    }
}

/// Puts the names of the definitions that a schema refers to among `names`.
fn named(schema: &Value, names: &mut BTreeSet<String>) {
    match schema {
        Value::Object(table) => {
            let name = table.get("$ref").and_then(Value::as_str);
            names.extend(name.and_then(|name| name.strip_prefix("#/definitions/")).map(str::to_owned));
            table.values().for_each(|value| named(value, names));
        }
        Value::Array(items) => items.iter().for_each(|item| named(item, names)),
        _ => {}
    }
}

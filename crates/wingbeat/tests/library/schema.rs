//! Schemas of the documents.

use serde_json::{Value, json};
use wingbeat::scenario::{DocumentKind, Schemas};

#[test]
fn the_schemas_that_the_program_prints_are_those_of_the_specs() {
    let (kept, made) = (Schemas::kept(), Schemas::made());
    assert!(kept == made, "the kept schemas are stale: run `cargo xtask reference`");
    assert!(DocumentKind::ALL.iter().all(|kind| kept.of(*kind)["properties"].is_object()));
}

#[test]
fn an_outline_may_be_stations_or_a_file() {
    for (kind, holder) in [(DocumentKind::Case, "TetheredWingSpec"), (DocumentKind::Robot, "WingSpec")] {
        let schema = kind.schema_of_files();
        let planform = &schema["definitions"][holder]["properties"]["planform"];
        assert_eq!(planform["anyOf"][0]["type"], "array", "{planform}");
        assert_eq!(planform["anyOf"][1]["$ref"], "#/definitions/OutlineFile");
        assert!(schema["definitions"]["OutlineFile"]["properties"]["unit"].is_object());
    }
    assert_eq!(DocumentKind::Arm.schema_of_files()["definitions"]["OutlineFile"], Value::Null);
}

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

#[test]
fn a_schema_says_keys_meanings_defaults_and_ranges() {
    let schema = DocumentKind::Scenario.schema();
    let air = &schema["definitions"]["AirSpec"];
    assert_eq!(air["additionalProperties"], false);
    assert_eq!(air["required"], json!(["density_kg_m3"]));
    assert_eq!(air["properties"]["gust_m_s"]["default"], 0.0);
    assert_eq!(air["properties"]["wind_m_s"]["items"]["maximum"], 1e4);
    let deviation = &schema["definitions"]["DrydenSpec"]["properties"]["deviation_m_s"]["items"];
    assert_eq!((&deviation["minimum"], &deviation["maximum"]), (&json!(0.0), &json!(100.0)));
    for gait in schema["definitions"]["GaitSpec"]["oneOf"].as_array().unwrap() {
        let kind = gait["properties"].as_object().unwrap().values().next().unwrap();
        assert_eq!(kind["properties"]["frequency_hz"]["minimum"], 0.0, "{kind}");
    }
    let case = DocumentKind::Case.schema();
    let of = |table: &str, key: &str| case["definitions"][table]["properties"][key].clone();
    assert_eq!(of("WindSpec", "density_kg_m3")["exclusiveMinimum"], 0.0);
    assert_eq!(of("HingeSpec", "arc_m")["minimum"], 0.0);
    assert!(schema["properties"]["goal"]["description"].as_str().unwrap().starts_with("What counts"));
    assert!(!schema.to_string().contains("null"), "TOML has no null");
}

//! Shipped scenarios with their robots, compiled in.

use wingbeat::scenario::{ConfigError, Document, Scenario};

use crate::Error;

/// Name of a scenario, its text, name of its robot, its text.
pub type Shipped = (&'static str, &'static str, &'static str, &'static str);

/// A shipped scenario and the robot that it names.
macro_rules! shipped {
    ($scenario:literal, $robot:literal) => {
        (
            $scenario,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/", $scenario, ".toml")),
            $robot,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/", $robot, ".toml")),
        )
    };
}
pub(crate) use shipped;

/// The scenario, built.
///
/// # Errors
/// What is refused, with `overrides`.
pub fn scenario((name, text, robot, of_robot): Shipped, overrides: &[&str]) -> Result<Scenario, Error> {
    let refused = |e: ConfigError| Error::reference(name, e.to_string());
    let at = |folder: &str, name: &str| format!("{}/../../{folder}/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let robot = Document::text(&at("robots", robot), of_robot).map_err(refused)?;
    let document = Document::text(&at("scenarios", name), text)
        .map_err(refused)?
        .put("robot", robot)
        .map_err(refused)?;
    Scenario::new(overrides.iter().fold(document, |d, text| d.set(*text))).map_err(refused)
}

//! Shipped scenarios with their robots, compiled in.

use std::io;
use std::path::{Path, PathBuf};

use wingbeat::scenario::{ConfigError, Document, Scenario};

use crate::Error;

/// Name of a shipped scenario.
pub type Shipped = &'static str;

/// Names and texts of files.
macro_rules! files {
    ($($name:literal)*) => {
        &[$((
            concat!($name, ".toml"),
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../", $name, ".toml")),
        )),*]
    };
}

/// The shipped scenarios and robots.
const FILES: &[(&str, &str)] = files![
    "scenarios/aerobat_elastic"
    "scenarios/aerobat_membrane"
    "scenarios/any_air_bank15_beta"
    "scenarios/any_air_bank30_20g"
    "scenarios/as_printed_fourier"
    "scenarios/as_printed_fourier_converged"
    "scenarios/as_printed_linkage"
    "scenarios/as_printed_linkage_converged"
    "scenarios/bank15_20g"
    "scenarios/bank15_20g_lev"
    "scenarios/bank15_beta"
    "scenarios/bank15_beta_lev"
    "scenarios/bank30_20g"
    "scenarios/bank30_20g_lev"
    "scenarios/bank30_beta"
    "scenarios/bank30_beta_lev"
    "scenarios/bank45_20g"
    "scenarios/bank45_20g_lev"
    "scenarios/bank45_beta"
    "scenarios/bank45_beta_lev"
    "scenarios/banking_turn"
    "scenarios/banking_turn_beta"
    "scenarios/banking_turn_short"
    "scenarios/banking_turn_stall"
    "scenarios/bounding_20g"
    "scenarios/climb"
    "scenarios/cruise_20g"
    "scenarios/cruise_20g_lev"
    "scenarios/cruise_20g_margin"
    "scenarios/cruise_44g"
    "scenarios/cruise_44g_lev"
    "scenarios/cruise_beta"
    "scenarios/cruise_beta_lev"
    "scenarios/cruise_linkage"
    "scenarios/decelerate"
    "scenarios/dive_45_20g"
    "scenarios/dive_pullout"
    "scenarios/estimator_20g"
    "scenarios/flap_glide"
    "scenarios/four_wings"
    "scenarios/gait_search_airs"
    "scenarios/gait_search_beta"
    "scenarios/glide"
    "scenarios/glider"
    "scenarios/hover"
    "scenarios/hover_guarded"
    "scenarios/land_20g"
    "scenarios/least_power_gait"
    "scenarios/launch_20g"
    "scenarios/level_20g"
    "scenarios/linkage_bank15"
    "scenarios/linkage_bank30"
    "scenarios/loaded_bank15"
    "scenarios/membrane_bank15"
    "scenarios/motor_flapper"
    "scenarios/paper_plan"
    "scenarios/paper_turn"
    "scenarios/paper_turn_clear"
    "scenarios/paper_turn_one_speed"
    "scenarios/passive_20g"
    "scenarios/passive_20g_margin"
    "scenarios/passive_bank15"
    "scenarios/passive_bank15_20g"
    "scenarios/passive_bank30_20g"
    "scenarios/passive_level_20g"
    "scenarios/passive_linkage"
    "scenarios/path_figure8"
    "scenarios/predictive_20g"
    "scenarios/predictive_figure8"
    "scenarios/reorientation"
    "scenarios/roll_in"
    "scenarios/sail_glide"
    "scenarios/soft_20g"
    "scenarios/soft_bank15"
    "robots/aerobat_beta"
    "robots/aerobat_elastic"
    "robots/aerobat_membrane"
    "robots/aerobat_paper"
    "robots/aerobat_printed"
    "robots/any_air_20g"
    "robots/any_air_beta"
    "robots/bounding_20g"
    "robots/cruise_20g"
    "robots/cruise_20g_lev"
    "robots/cruise_20g_margin"
    "robots/cruise_44g"
    "robots/cruise_44g_lev"
    "robots/cruise_beta"
    "robots/cruise_beta_lev"
    "robots/cruise_beta_lev_setpoints"
    "robots/cruise_beta_margin"
    "robots/cruise_linkage"
    "robots/flap_glider"
    "robots/flip_20g"
    "robots/four_wings"
    "robots/glider"
    "robots/guarded_20g"
    "robots/loaded_20g"
    "robots/motor_flapper"
    "robots/paper_turn"
    "robots/paper_turn_clear"
    "robots/paper_turn_one_speed"
    "robots/passive_20g"
    "robots/passive_20g_margin"
    "robots/passive_linkage"
    "robots/roomy_20g"
    "robots/sail_glider"
    "robots/soft_20g"
    "robots/soft_20g_margin"
];

/// A file of those that are compiled in.
pub fn text_of(path: &Path) -> io::Result<String> {
    let found = FILES.iter().find(|(name, _)| path.ends_with(name));
    found.map(|(_, text)| (*text).to_owned()).ok_or_else(|| io::ErrorKind::NotFound.into())
}

/// Where a file of the repository lies.
pub fn path_of(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file).with_extension("toml")
}

/// A shipped robot, `aerobat_paper`, with its text changed by `change`.
///
/// # Errors
/// What is refused.
pub fn robot(name: &str, change: &dyn Fn(String) -> String) -> Result<Document, Error> {
    let refused = |e: ConfigError| Error::reference(name, e.to_string());
    Document::among(&path_of(&format!("robots/{name}")), &|path| text_of(path).map(change)).map_err(refused)
}

/// The document of a shipped scenario, with its robot.
///
/// # Errors
/// What is refused.
pub fn document(name: &str) -> Result<Document, Error> {
    let refused = |e: ConfigError| Error::reference(name, e.to_string());
    let document = Document::among(&path_of(&format!("scenarios/{name}")), &text_of).map_err(refused)?;
    let of_robot = document.written("robot").map(|(file, _)| file.replace('"', "")).unwrap_or_default();
    let of_robot = Path::new(&of_robot).file_stem().unwrap_or_default().to_string_lossy();
    document.put("robot", robot(&of_robot, &|text| text)?).map_err(refused)
}

/// The scenario, built.
///
/// # Errors
/// What is refused, with `overrides`.
pub fn scenario(name: &str, overrides: &[&str]) -> Result<Scenario, Error> {
    let document = overrides.iter().fold(document(name)?, |document, text| document.set(*text));
    Scenario::new(document).map_err(|e| Error::reference(name, e.to_string()))
}

/// The scenario of a text that is based on a shipped one, built.
///
/// # Errors
/// What is refused, with `overrides`.
pub fn based(base: &str, text: &str, overrides: &[&str]) -> Result<Scenario, Error> {
    let refused = |e: ConfigError| Error::reference(base, e.to_string());
    let own = format!("base = \"{base}.toml\"\nname = \"{base}_based\"\n{text}\n");
    let read = |path: &Path| if path.ends_with("based.toml") { Ok(own.clone()) } else { text_of(path) };
    let document = Document::among(&path_of("scenarios/based"), &read).map_err(refused)?;
    let document = overrides.iter().fold(document, |document, text| document.set(*text));
    Scenario::new(document).map_err(refused)
}

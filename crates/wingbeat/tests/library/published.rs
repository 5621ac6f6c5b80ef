//! What a scenario and its controller are made from.

use std::path::Path;
use wingbeat::scenario::{Document, Scenario, Sweep, what_a_controller_knows};

#[test]
fn published_numbers_stand_only_beside_their_own_case() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let published = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
        let scenario = Scenario::load(&path, &overrides).unwrap();
        assert_eq!(scenario.spec.paper.is_some(), scenario.resolved.contains("[paper]"));
        scenario.spec.paper.is_some()
    };
    assert!(published(&[]));
    assert!(published(&["name=again", "flight.record_every_s=2e-3", "paper.roll_deg=14.0"]));
    assert!(published(&["aero.preset=paper"]));
    assert!(!published(&["aero.preset=full"]));
    assert!(!published(&["flight.duration_s=0.1"]));
    assert!(!published(&["name=again", "robot.body.mass_kg=0.03"]));
}

/// What a sweep draws are conditions of the published case; what it sets for all flights makes another.
#[test]
fn a_sweep_of_another_case_has_no_published_end() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sweeps/end_points.toml");
    let published = |overrides: &[&str]| {
        let document = overrides.iter().fold(Document::file(&path).unwrap(), |d, text| d.set(*text));
        Sweep::new(document, &|_| Err("no tables".into())).unwrap().paper().is_some()
    };
    assert!(published(&[]) && published(&["runs=3", "scenario.flight.record_every_s=2e-3"]));
    assert!(!published(&["scenario.flight.duration_s=3"]) && !published(&["set=[\"flight.duration_s=3\"]"]));
}

fn key(file: &str, overrides: &[&str]) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(file);
    let document = overrides.iter().fold(Document::file(&path).unwrap(), |d, text| d.set(*text));
    what_a_controller_knows(&Scenario::new(document).unwrap().spec).unwrap()
}

#[test]
fn whatever_a_controller_knows_makes_another_one() {
    for (file, known) in [
        ("estimator_20g.toml", "sensors.height.bias_m=0.0123"),
        ("estimator_20g.toml", "robot.body.mass_kg=0.0201"),
        ("estimator_20g.toml", "controller.orbit.estimator.missed_s=0.11"),
        ("estimator_20g.toml", "air.density_kg_m3=1.2"),
        ("banking_turn.toml", "air.wind_m_s=[0.0, 0.001, 0.0]"),
        ("path_figure8.toml", "path.lead_m=4.5"),
        ("banking_turn.toml", "flight.flapping=false"),
    ] {
        assert_ne!(key(file, &[]), key(file, &[known]), "{known}");
    }
    for unknown in [
        "seed=77",
        "air.gust_m_s=0.2",
        "mismatch.density=0.97",
        "goal={settle_s=1.1, roll_within_deg=9.0, pitch_within_deg=9.0}",
        "name=other",
    ] {
        assert_eq!(key("estimator_20g.toml", &[]), key("estimator_20g.toml", &[unknown]), "{unknown}");
    }
}

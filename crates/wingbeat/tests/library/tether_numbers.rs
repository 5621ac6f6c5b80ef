//! Numbers of a calibration in a tethered wing.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::scenario::{Document, TetherCase};

const PLATE: &str = r#"
name = "plate"
wing.planform = [
    { arc_m = 0.0, leading_edge_m = 0.25, trailing_edge_m = -0.75 },
    { arc_m = 2.0, leading_edge_m = 0.25, trailing_edge_m = -0.75 },
]
body.nose_up_deg.constant = 4.0
wind = { speed_m_s = 1.0, density_kg_m3 = 1.225 }
aero.law = "linear"
time = { frequency_hz = 0.5, cycles = 1, steps_per_cycle = 16 }
"#;

fn case(overrides: &[&str]) -> Result<TetherCase, String> {
    let no_tables = &|_: &Path| Err("no tables here".to_owned());
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    let document = Document::text("plate", PLATE).unwrap().overridden(&overrides);
    TetherCase::new(document, no_tables).map_err(|error| error.to_string())
}

fn loads(overrides: &[&str]) -> Vec<f64> {
    let run = case(overrides).unwrap().tether.run(|_| ControlFlow::Continue(()));
    run.loads.values("force_wind_lift").unwrap().to_vec()
}

#[test]
fn a_tether_takes_the_wings_numbers_and_the_airs() {
    let plain = loads(&[]);
    let same =
        loads(&[r#"numbers={ "links.twist.mass_kg" = 0.1, "gait.phase_rad" = 0.2, "mount.mass_kg" = 0.1 }"#]);
    assert_eq!(plain, same, "numbers of what a wing alone has not");
    let drag = |overrides: &[&str]| {
        let run = case(overrides).unwrap().tether.run(|_| ControlFlow::Continue(()));
        *run.loads.values("force_wind_drag").unwrap().last().unwrap()
    };
    let by_number = drag(&[r#"numbers={ "surfaces.wing.cd0" = 0.05 }"#]);
    assert!((by_number - drag(&["wing.cd0=0.05"])).abs() < 1e-12 && by_number > 1.5 * drag(&[]));
    let thin = loads(&[r#"numbers={ "air.density_kg_m3" = 0.6125 }"#]);
    assert!(plain.iter().zip(&thin).all(|(plain, thin)| (plain - 2.0 * thin).abs() < 1e-9));
}

#[test]
fn names_that_a_tether_does_not_know_are_refused_with_those_it_does() {
    let refused = |numbers: &str| case(&[&format!("numbers={numbers}")]).map(drop).unwrap_err();
    let unknown = refused(r#"{ "surfaces.tail.cd0" = 0.05 }"#);
    assert!(unknown.contains("surfaces.tail.cd0") && unknown.contains("surfaces.wing.cd0"), "{unknown}");
    let wide = refused(r#"{ "surfaces.wing.cd0" = 5.0 }"#);
    assert!(wide.contains("0 to 2"), "{wide}");
}

//! `wingbeat wake RUN`: along a flight, the lattice's circulations and the model's.

use std::fs;

use crate::{entries, root, scratch, wingbeat};

fn summary(folder: &std::path::Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn a_flight_leaves_its_wake_before_and_in_the_turn() {
    let folder = scratch("wake-flight");
    let scenario = root().join("scenarios/banking_turn.toml").display().to_string();
    // Unfolded and slow in its stroke, so that the wings stay apart.
    let set = [
        "--set=flight.duration_s=0.7",
        "--set=manoeuvre.turn_start_s=0.35",
        "--set=start.velocity_m_s=[4.0, 0.0, 0.0]",
        "--set=robot.gait.fourier.shoulder={ mean_rad = 0.1, harmonics = [{ amplitude_rad = 0.3, phase_rad = 0.0 }] }",
        "--set=robot.gait.fourier.elbow={ mean_rad = 0.0, harmonics = [] }",
    ];
    let flown = wingbeat(&folder, &[&["fly", &scenario, "--out", "run", "--quiet"], &set[..]].concat());
    assert!(folder.join("run/record.parquet").is_file(), "{flown:?}");
    let small = ["--chordwise", "3", "--spanwise", "12", "--cycles", "1", "--prescribed"];
    let output = wingbeat(&folder, &[&["wake", "run", "--out", "a"], &small[..]].concat());
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(
        output.status.success() && text.contains("banked") && text.contains("left over right"),
        "{output:?}"
    );
    let names = entries(&folder.join("a"));
    for name in ["scenario.toml", "level_record.parquet", "banked_middle_of_upstroke.vtk"] {
        assert!(names.contains(&name.to_owned()), "{names:?}");
    }
    let told = summary(&folder.join("a"));
    let number = |key: &str| told.pointer(key).and_then(serde_json::Value::as_f64).unwrap();
    assert!(number("/circulation_error") < 1e-12 && number("/down_over_up/left") > 0.0);
    assert!(
        (number("/stretches/0/to_s") - 0.35).abs() < 1e-9 && (number("/stretches/1/to_s") - 0.7).abs() < 1e-9
    );
    // The circulations of preset paper, by the same code.
    let output = wingbeat(&folder, &[&["wake", "run", "--out", "b", "--model"], &small[..]].concat());
    assert!(output.status.success(), "{output:?}");
    assert!(summary(&folder.join("b"))["circulations"] == "of the model that flew");
    for (more, says) in [
        (&["--at", "0.1"][..], "allowed are"),
        (&["--at", "0.7", "--cycles", "9"], "9 cycles until 0.7 s"),
        (&["--cycles", "0"], "--cycles 0: allowed is 1 or more"),
        (&["--steps", "0"], "--steps 0: allowed is 1 or more"),
        (&["--set", "air.density_kg_m3=1.0"], "has been flown"),
    ] {
        let output = wingbeat(&folder, &[&["wake", "run", "--out", "c"], more].concat());
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(
            output.status.code() == Some(2) && (text.contains(says) || text.contains("cycles until")),
            "{text}"
        );
        assert!(!folder.join("c").exists());
    }
    // Three lags have no bound circulation.
    let strips = [&set[..3], &["--set=aero.preset=full"]].concat();
    wingbeat(&folder, &[&["fly", &scenario, "--out", "full", "--quiet"], &strips[..]].concat());
    let output = wingbeat(&folder, &["wake", "full", "--out", "d", "--model", "--cycles", "1"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && text.contains("sum of wash lags"), "{text}");
}

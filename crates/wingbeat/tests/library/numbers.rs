//! Numbers that a robot is given by name: what they may be, and what a mismatch makes of them.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::scenario::Scenario;

fn shipped(file: &str, overrides: &[&str]) -> Result<Scenario, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(file);
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_string()).collect();
    Scenario::load(&path, &overrides).map_err(|error| error.to_string())
}

/// The last row of a flight of .1 s.
fn end(file: &str, overrides: &[&str]) -> Vec<f64> {
    let all = [overrides, &["flight.duration_s=0.1"]].concat();
    let run = shipped(file, &all).unwrap().fly(|_| ControlFlow::Continue(())).unwrap();
    run.record
        .columns()
        .iter()
        .map(|column| *run.record.values(&column.name).unwrap().last().unwrap())
        .collect()
}

#[test]
fn a_mismatch_acts_on_numbers_given_by_name() {
    // Scenario, numbers, and the mismatch that shifts or scales them.
    for (file, numbers, mismatch) in [
        ("glide.toml", "{'body.com_m[0]'=0.0}", "mismatch.com_x_m=0.02"),
        ("glide.toml", "{'air.density_kg_m3'=1.2}", "mismatch.density=0.9"),
        ("glide.toml", "{'surfaces.wing.cd0'=0.03}", "mismatch.profile_drag=1.5"),
        ("glide.toml", "{'surfaces.wing.cd90'=1.9}", "mismatch.broadside_drag=1.5"),
        ("glide.toml", "{'body.mass_kg'=0.02}", "mismatch.mass=1.1"),
        ("cruise_20g.toml", "{'body.inertia_kg_m2[1]'=2.2e-5}", "mismatch.inertia=1.1"),
        (
            "cruise_20g.toml",
            "{'links.shoulder.driven.harmonics[0].amplitude_rad'=0.6}",
            "mismatch.gait_amplitude=0.9",
        ),
        ("cruise_linkage.toml", "{'linkage.l1_m'=0.0076}", "mismatch.gait_amplitude=0.9"),
    ] {
        let numbers = format!("robot.numbers={numbers}");
        let (without, with) = (end(file, &[&numbers]), end(file, &[&numbers, mismatch]));
        assert_ne!(without, with, "{file}: {mismatch} beside {numbers}");
    }
}

#[test]
fn what_an_encoder_shows_does_not_move_the_start_of_a_flight() {
    let start = ["start.phase_rad=2.0", "flight.duration_s=0.02"];
    let own = end("glide.toml", &start);
    for table in ["robot.numbers", "mismatch.numbers"] {
        let shown = format!("{table}={{'gait.phase_rad'=0.03}}");
        assert_eq!(own, end("glide.toml", &[start[0], start[1], &shown]), "{table}");
    }
    assert_ne!(own, end("glide.toml", &["start.phase_rad=2.1", start[1]]));
    let told = |table: &str, numbers: &str| {
        let scenario =
            shipped("glide.toml", &[start[0], start[1], &format!("{table}={{{numbers}}}")]).unwrap();
        let warnings = scenario.fly(|_| ControlFlow::Continue(())).unwrap().summary.warnings;
        warnings.into_iter().find(|warning| warning.id == "fit.rig_alone")
    };
    for table in ["robot.numbers", "mismatch.numbers"] {
        let told = told(table, "'gait.phase_rad'=0.03, 'mount.mass_kg'=0.1, 'body.mass_kg'=0.02").unwrap();
        assert!(told.text.ends_with("which no flight takes: gait.phase_rad, mount.mass_kg"), "{told:?}");
        assert_eq!(told.key.as_deref(), Some(table));
    }
    assert!(told("robot.numbers", "'body.mass_kg'=0.02").is_none());
    let told =
        shipped("glide.toml", &["robot.numbers={'gait.phase_rate_rad_s'=20.0}"]).map(drop).unwrap_err();
    assert!(
        told.contains("gait.linkage.frequency_hz") || told.contains("gait.fourier.frequency_hz"),
        "{told}"
    );
}

/// Name and value of the numbers of the flown robot.
fn flown(overrides: &[&str]) -> Vec<(String, f64)> {
    shipped("banking_turn_short.toml", overrides).unwrap().robot().named_numbers()
}

#[test]
fn a_bandwidth_scales_stiffness_and_damping_of_a_number_as_of_a_key() {
    let known = shipped("banking_turn_short.toml", &[]).unwrap();
    let stiffness = |numbers: &[(String, f64)], end: &str| -> Vec<f64> {
        let of = numbers.iter().filter(|(name, _)| name.starts_with("structure.") && name.ends_with(end));
        of.map(|(_, value)| *value).collect()
    };
    let named = known.robot().named_numbers();
    let (name, k) = named.iter().find(|(name, _)| name.ends_with("stiffness_per_s2")).unwrap();
    let numbers = format!("robot.numbers={{{name:?}={}}}", 2.0 * k);
    let slow = flown(&["mismatch.regulator_bandwidth=0.5"]);
    let given = flown(&[&numbers, "mismatch.regulator_bandwidth=0.5"]);
    for (end, factor) in [("stiffness_per_s2", 0.25), ("damping_per_s", 0.5)] {
        let (own, slow) = (stiffness(&named, end), stiffness(&slow, end));
        assert!(own.iter().zip(&slow).all(|(own, slow)| (slow - factor * own).abs() < 1e-12 * own), "{end}");
        assert_eq!(stiffness(&given, end)[1..], slow[1..]);
    }
    assert_eq!(stiffness(&given, "stiffness_per_s2")[0], 0.5 * k);
}

#[test]
fn a_stiffness_scales_all_that_gives_way_and_the_damping_that_follows() {
    let named = |file: &str, overrides: &[&str]| shipped(file, overrides).unwrap().robot().named_numbers();
    // What changes, by the end of its name; all else stays.
    for (file, scaled) in [
        ("soft_20g.toml", &["stiffness", "damping", "spar.bending_n_m2", "spar.torsion_n_m2"] as &[&str]),
        ("sail_glide.toml", &["membrane.stiffness_n_m"]),
        ("flap_glide.toml", &["flap.stiffness_n_rad"]),
        ("aerobat_elastic.toml", &["elastic.stiffness"]),
    ] {
        let (own, other) = (named(file, &[]), named(file, &["mismatch.stiffness=1.5"]));
        let mut found = 0;
        for ((name, own), (_, other)) in own.iter().zip(&other) {
            let factor = if scaled.iter().any(|end| name.ends_with(end)) { 1.5 } else { 1.0 };
            found += usize::from(factor != 1.0 && *own != 0.0);
            assert!((other - factor * own).abs() <= 1e-12 * own.abs(), "{file}: {name} {own} {other}");
        }
        assert!(found >= scaled.len(), "{file}: {found}");
    }
    // As the file's own key has it.
    let by_key = named(
        "soft_20g.toml",
        &["robot.links.twist.spar.bending_n_m2=0.076", "robot.links.twist.spar.torsion_n_m2=0.124"],
    );
    let by_factor = named("soft_20g.toml", &["mismatch.stiffness=2"]);
    for ((name, key), (_, factor)) in by_key.iter().zip(&by_factor) {
        assert!((key - factor).abs() <= 1e-12 * key.abs(), "{name}: {key} {factor}");
    }
    let stiff = shipped("cruise_20g.toml", &["mismatch.stiffness=2"]).unwrap_err();
    assert!(stiff.contains("mismatch.stiffness = 2: allowed is 1 where the robot has no spring"), "{stiff}");
}

#[test]
fn numbers_of_the_mismatch_come_first_and_its_factors_after() {
    let mass = |overrides: &[&str]| {
        let numbers = shipped("glide.toml", overrides).unwrap().robot().named_numbers();
        numbers.iter().find(|(name, _)| name == "body.mass_kg").unwrap().1
    };
    let known = "robot.numbers={'body.mass_kg'=0.02}";
    assert_eq!(mass(&[known, "mismatch.mass=2.0"]), 0.04);
    assert_eq!(mass(&[known, "mismatch={mass=2.0, numbers={'body.mass_kg'=0.03}}"]), 0.06);
}

#[test]
fn numbers_that_no_robot_has_are_refused_where_they_are_given() {
    let file = std::env::temp_dir().join(format!("wingbeat_numbers_{}.toml", std::process::id()));
    let inertia = "\"body.mass_kg\" = 0.02\n\"body.inertia_kg_m2[0]\" = 1e-9\n\"body.inertia_kg_m2[1]\" = 1e-9\n\
                   \"body.inertia_kg_m2[2]\" = 1.0\n";
    std::fs::write(&file, inertia).unwrap();
    let of_file = format!("robot.numbers={}", file.display());
    let refused = |overrides: &[&str]| shipped("glide.toml", overrides).unwrap_err();
    let told = refused(&[&of_file]);
    std::fs::remove_file(&file).unwrap();
    let place = format!("{}:4: robot.numbers.\"body.inertia_kg_m2[2]\" = 1", file.display());
    assert!(told.contains(&place) && told.contains("sum of the other two"), "{told}");

    let inline = "{'body.inertia_kg_m2[0]'=1e-9, 'body.inertia_kg_m2[1]'=1e-9, 'body.inertia_kg_m2[2]'=1.0}";
    for (overrides, key) in [
        (format!("robot.numbers={inline}"), "robot.numbers.\"body.inertia_kg_m2[2]\" = 1"),
        (format!("mismatch.numbers={inline}"), "mismatch.numbers.\"body.inertia_kg_m2[2]\" = 1"),
        ("robot.numbers={'surfaces.wing.planform[1].arc_m'=-0.1}".into(), "planform[1].arc_m\" = -0.1"),
        ("robot.numbers={'body.mass_kg'=0.0}".into(), "robot.numbers.\"body.mass_kg\" = 0"),
    ] {
        let told = refused(&[&overrides]);
        assert!(told.contains(key), "{overrides}: {told}");
    }
}

#[test]
fn held_wings_have_no_motor_and_none_of_its_numbers() {
    let numbers = "robot.numbers={'motor.efficiency'=0.7, 'body.mass_kg'=0.02}";
    let still = shipped("motor_flapper.toml", &[numbers, "flight.flapping=false"]).unwrap();
    assert!(still.robot().named_numbers().iter().all(|(name, _)| !name.starts_with("motor.")));
}

#[test]
fn numbers_are_called_by_the_names_of_their_elements_and_panels() {
    let named = |file: &str| -> Vec<String> {
        let numbers = shipped(file, &[]).unwrap().robot().named_numbers();
        numbers.into_iter().map(|(name, _)| name).collect()
    };
    let has = |names: &[String], name: &str| names.iter().any(|other| other == name);
    let of_paper = named("banking_turn_short.toml");
    for name in ["structure.elements.twist_left.stiffness_per_s2", "surfaces.wing.panels.elbow.from_arc_m"] {
        assert!(has(&of_paper, name), "{name}: {of_paper:?}");
    }
    assert!(has(&named("cruise_20g.toml"), "links.shoulder_left.driven.harmonics[0].amplitude_rad"));
    let placed = |name: &&String| name.starts_with("structure.elements[") || name.contains("panels[");
    assert_eq!(of_paper.iter().find(placed), None);
}

#[test]
fn a_name_of_before_is_answered_with_that_of_today() {
    for (file, old, new) in [
        (
            "banking_turn_short.toml",
            "surfaces.wing.panels[2].from_arc_m",
            "surfaces.wing.panels.elbow.from_arc_m",
        ),
        ("banking_turn_short.toml", "surfaces.wing.section_slope", "surfaces.wing.lift_slope_per_rad"),
        (
            "cruise_20g.toml",
            "links.shoulder.series.harmonics[0].amplitude_rad",
            "links.shoulder.driven.harmonics[0].amplitude_rad",
        ),
    ] {
        let told = shipped(file, &[&format!("robot.numbers={{'{old}'=0.5}}")]).map(drop).unwrap_err();
        assert!(told.contains(&format!("its new name, \"{new}\"")), "{old}: {told}");
    }
    let first = shipped("banking_turn_short.toml", &[]).unwrap();
    let element = first.spec.robot.structure.elements[0].name.clone();
    let told =
        shipped("banking_turn_short.toml", &["robot.numbers={'structure.elements[0].damping_per_s'=60.0}"]);
    let told = told.map(drop).unwrap_err();
    assert!(told.contains(&format!("\"structure.elements.{element}.damping_per_s\"")), "{told}");
}

#[test]
fn overrides_set_numbers_by_name() {
    let mass = |value: &str| {
        let scenario = shipped("glide.toml", &[&format!("robot.numbers.\"body.mass_kg\"={value}")]).unwrap();
        scenario.robot().named_numbers().into_iter().find(|(name, _)| name == "body.mass_kg").unwrap().1
    };
    assert_eq!((mass("0.02"), mass("0.03")), (0.02, 0.03));
}

/// The numbers of a spar are those of its file, in any order, and so are derivatives by them.
#[test]
fn a_number_of_a_spar_is_that_of_all_its_springs() {
    let springs = |overrides: &[&str]| shipped("soft_20g.toml", overrides).unwrap().robot().numbers().springs;
    let own = shipped("soft_20g.toml", &[]).unwrap();
    let listed = own.robot().named_numbers();
    let keys = ["bending_n_m2", "torsion_n_m2", "damping_s"].map(|key| format!("links.twist.spar.{key}"));
    for (key, value) in keys.iter().zip([0.038, 0.062, 2e-4]) {
        let found = listed.iter().find(|(name, _)| name == key).unwrap().1;
        assert!((found / value - 1.0).abs() < 1e-14, "{key}: {found}");
    }
    let file = "robot.links[2].spar";
    let in_file = springs(&[
        &format!("{file}.bending_n_m2=0.05"),
        &format!("{file}.torsion_n_m2=0.07"),
        &format!("{file}.damping_s=3e-4"),
    ]);
    let values = [0.05, 0.07, 3e-4];
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let given: Vec<(&str, f64)> = order.iter().map(|&k| (keys[k].as_str(), values[k])).collect();
        let numbers = own.robot().given(&given).unwrap();
        for (a, b) in numbers.springs.iter().zip(&in_file) {
            assert!((a.stiffness / b.stiffness - 1.0).abs() < 1e-13, "{order:?}: {a:?}, {b:?}");
            assert!((a.damping / b.damping - 1.0).abs() < 1e-13, "{order:?}: {a:?}, {b:?}");
        }
        assert_eq!(numbers.springs.len(), in_file.len());
    }
    let numbers = "robot.numbers={'links.twist.spar.bending_n_m2'=0.05}";
    let alone = springs(&[&format!("{file}.bending_n_m2=0.05")]);
    assert!(
        springs(&[numbers]).iter().zip(&alone).all(|(a, b)| (a.stiffness / b.stiffness - 1.0).abs() < 1e-13)
    );

    // Springs that are not those of one beam have no number in common.
    let apart =
        own.robot().adjusted(&[("links.twist_bend1.elastic.stiffness", 1.0)]).unwrap().named_numbers();
    let has = |key: &String| apart.iter().any(|(name, _)| name == key);
    assert_eq!(keys.each_ref().map(has), [false, true, false]);

    let names: Vec<&str> = keys.iter().map(String::as_str).collect();
    let varied = own.robot().varied(&names).unwrap().numbers().springs;
    for (k, value) in [0.038, 0.062, 2e-4].into_iter().enumerate() {
        let [less, more] = [1.0 - 1e-4, 1.0 + 1e-4]
            .map(|share| own.robot().given(&[(names[k], share * value)]).unwrap().springs);
        for (i, spring) in varied.iter().enumerate() {
            let slope = |less: f64, more: f64| (more - less) / (2e-4 * value);
            let (stiffness, damping) =
                (slope(less[i].stiffness, more[i].stiffness), slope(less[i].damping, more[i].damping));
            assert!((spring.stiffness.eps[k] - stiffness).abs() <= 1e-9 * (1.0 + stiffness.abs()));
            assert!((spring.damping.eps[k] - damping).abs() <= 1e-9 * (1.0 + damping.abs()));
        }
    }

    for (numbers, text) in [
        ("links.twist.spar.bending_n_m2'=0.0", "0.000000001 to 1000000"),
        ("links.elbow.spar.bending_n_m2'=0.1", "links.twist.spar.bending_n_m2"),
        (
            "links.twist.spar.bending_n_m2'=0.05, 'links.twist_bend1.elastic.stiffness'=1.0",
            "which stands for it",
        ),
        (
            "links.twist_1_left.elastic.damping'=1e-3, 'links.twist.spar.damping_s'=1e-4",
            "which stands for it",
        ),
    ] {
        let told =
            shipped("soft_20g.toml", &[&format!("robot.numbers={{'{numbers}}}")]).map(drop).unwrap_err();
        assert!(told.contains(text), "{told}");
    }
}

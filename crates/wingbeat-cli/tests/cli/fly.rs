//! `wingbeat fly` as a user meets it: run folders, messages, exit codes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::{entries, root, scratch, wingbeat};

/// Flies a tenth of a second of the glide.
fn glide(folder: &Path, more: &[&str]) -> Output {
    let scenario = root().join("scenarios/glide.toml");
    let mut arguments = vec!["fly", scenario.to_str().unwrap(), "--set", "flight.duration_s=0.1"];
    arguments.extend(more);
    wingbeat(folder, &arguments)
}

#[test]
fn a_run_folder_is_whole_and_reproduces_itself() {
    let folder = scratch("fly-whole");
    let output = glide(&folder, &["--out", "a", "--seed", "7"]);
    assert!(output.status.success(), "{output:?}");
    let names =
        ["figures", "manifest.json", "record.parquet", "report.html", "scenario.toml", "summary.json"];
    assert_eq!(entries(&folder.join("a")), names);
    assert!(entries(&folder.join("a/figures")).contains(&"states.png".into()));
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("altitude change") && table.contains("run folder: a"), "{table}");
    let manifest = fs::read_to_string(folder.join("a/manifest.json")).unwrap();
    assert!(manifest.contains("\"seed\": 7"), "{manifest}");

    let again = wingbeat(&folder, &["fly", "a/scenario.toml", "--out", "b", "--quiet"]);
    assert!(again.status.success() && again.stdout.is_empty(), "{again:?}");
    let bytes = |run: &str| fs::read(folder.join(run).join("record.parquet")).unwrap();
    assert!(bytes("a") == bytes("b"));
}

#[test]
fn without_out_runs_count_up_and_an_earlier_run_is_replaced_only_by_force() {
    let folder = scratch("fly-count");
    for _ in 0..2 {
        assert!(glide(&folder, &["--quiet"]).status.success());
    }
    assert_eq!(entries(&folder.join("runs")), ["glide", "glide-2"]);
    let refused = glide(&folder, &["--quiet", "--out", "runs/glide"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--force"));
    assert!(glide(&folder, &["--quiet", "--out", "runs/glide", "--force"]).status.success());
    assert_eq!(entries(&folder.join("runs")), ["glide", "glide-2"]);
}

/// The example of the page on robots with joints of other names, and a tail that the gait moves.
fn arm_hand_and_tail() -> String {
    let page = fs::read_to_string(root().join("docs/robots.md")).unwrap();
    let block = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let own = ["name = \"wing\"\nside", "parent = \"wing\"", "link = \"wing\""];
    let named =
        own.iter().fold(block.to_owned(), |text, word| text.replace(word, &word.replace("wing", "arm")));
    let tail = "[[links]]\nname = \"tail\"\norigin_m = [-0.12, 0.0, 0.0]\naxis = [0.0, -1.0, 0.0]\nmass_kg = 0.001\n\
                com_m = [-0.02, 0.0, 0.0]\ninertia_kg_m2 = [1e-7, 1e-7, 2e-7]\n\
                driven = { mean_rad = 0.1, harmonics = [{ amplitude_rad = 0.2, phase_rad = 0.0 }] }\n\n[[surfaces]]";
    let on_body = "{ link = \"body\", origin_m = [-0.12, 0.0, 0.0] }";
    assert!(named.contains(on_body));
    named.replacen("[[surfaces]]", tail, 1).replace(on_body, "{ link = \"tail\" }")
}

#[test]
fn figures_show_the_joints_that_a_robot_has_by_their_names() {
    let folder = scratch("fly-joints");
    fs::write(folder.join("robot.toml"), arm_hand_and_tail()).unwrap();
    let scenario = "name = \"own\"\nrobot = \"robot.toml\"\nair.density_kg_m3 = 1.225\naero = { preset = \"full\", law = \"stall\" }\n\
                    start.velocity_m_s = [6.0, 0.0, 0.0]\nflight = { duration_s = 0.6, step_s = 5e-4, record_every_s = 2e-3 }\n";
    fs::write(folder.join("own.toml"), scenario).unwrap();
    // It dives.
    let dives = "limits.flight.weight_carried=-1.0";
    let output = wingbeat(&folder, &["fly", "own.toml", "--out", "a", "--quiet", "--set", dives]);
    assert!(output.status.success(), "{output:?}");
    let figure = |name: &str| fs::read_to_string(folder.join("a/figures").join(name)).unwrap();
    for joint in ["arm angle", "hand angle", "tail angle"] {
        assert!(figure("states.svg").contains(joint), "{joint}");
    }
    for name in entries(&folder.join("a/figures")).iter().filter(|name| name.ends_with(".svg")) {
        let text = figure(name);
        assert!(!["shoulder", "elbow"].iter().any(|other| text.contains(other)), "{name}");
    }
}

/// Each kind of bad input: what is set, and words of the one message.
const BAD: [(&str, &[&str]); 12] = [
    ("flight.speed=1", &["unknown key flight.speed", "duration_s"]),
    ("flight.duration_s=fast", &["flight.duration_s = fast", "a number"]),
    ("robot.body.mass_kg=-0.01", &["robot.body.mass_kg = -0.01", "allowed is"]),
    ("robot.body.mass_kg=nan", &["robot.body.mass_kg = nan", "finite"]),
    ("air.density_kg_m3=-1.2", &["air.density_kg_m3 = -1.2", "allowed is"]),
    ("robot=none.toml", &["robot", "none.toml", "No such file"]),
    ("aero.paper.nodes=2", &["aero.paper.nodes = 2", "3"]),
    ("flight.step_s=0", &["flight.step_s = 0", "above 0"]),
    ("flight.record_every_s=1e-5", &["flight.record_every_s", "whole number of steps"]),
    ("aero.law=tangent", &["aero.law = tangent", "linear", "stall"]),
    ("name", &["KEY=VALUE"]),
    ("name.x=1", &["name.x", "allowed is"]),
];

#[test]
fn bad_input_is_one_message_with_exit_code_2_and_no_folder() {
    let folder = scratch("fly-bad");
    for (set, words) in BAD {
        let output = glide(&folder, &["--set", set]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{set}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        for word in words.iter().chain([&"--set"]) {
            assert!(message.contains(word), "{set}: `{word}` is not in: {message}");
        }
        assert!(entries(&folder).is_empty(), "{set}: {:?}", entries(&folder));
    }
}

/// Documents of other kinds than the verb reads, and what the one message says.
const OTHERS: [[&str; 3]; 6] = [
    ["fly", "cases/pitch.toml", "this is a case, which is read by `wingbeat tether`"],
    ["fly", "robots/cruise_20g.toml", "this is a robot, which is read by `wingbeat trim`"],
    ["fly", "rigs/runs/bench.toml", "this is a run, which is read by `wingbeat rig simulate`"],
    ["trim", "cases/pitch.toml", "this is a case, which is read by `wingbeat tether`"],
    ["tether", "scenarios/glide.toml", "this is a scenario, which is read by `wingbeat fly`"],
    ["calibrate", "scenarios/glide.toml", "this is a scenario, which is read by `wingbeat fly`"],
];

#[test]
fn a_document_of_another_kind_is_told_with_what_reads_it() {
    let folder = scratch("fly-others");
    for [verb, file, words] in OTHERS {
        let path = root().join(file);
        let output = wingbeat(&folder, &[verb, path.to_str().unwrap()]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(file) && message.contains(words), "{verb} {file}: {message}");
        assert!(entries(&folder).is_empty(), "{:?}", entries(&folder));
    }
}

/// Copies scenario and robot of the banking turn, with `from` replaced by `to` in `file`.
fn edited(folder: &Path, file: &str, from: &str, to: &str) {
    for path in ["scenarios/banking_turn.toml", "robots/aerobat_paper.toml"] {
        let mut text = fs::read_to_string(root().join(path)).unwrap();
        if path == file {
            assert!(text.contains(from), "{from} is not in {path}");
            text = text.replacen(from, to, 1);
        }
        let path = folder.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

/// Mistakes in a file: the file, what is replaced by what, and the message.
const MISTAKES: [[&str; 4]; 5] = [
    ["robots/aerobat_paper.toml", "mass_kg = 0.010", "mass_kg = -0.010", "robot.body.mass_kg = -0.010"],
    [
        "robots/aerobat_paper.toml",
        "mass_kg = 0.010           # lab code\n",
        "",
        "robot.body.mass_kg is missing",
    ],
    ["scenarios/banking_turn.toml", "step_s = 1e-4", "step_s = 0.0", "flight.step_s = 0.0"],
    [
        "scenarios/banking_turn.toml",
        "aerobat_paper",
        "aerobat_plan",
        "robot = \"../robots/aerobat_plan.toml\"",
    ],
    ["scenarios/banking_turn.toml", "name = ", "nam = ", "unknown key nam = \"banking_turn\""],
];

#[test]
fn the_message_names_file_and_line() {
    let folder = scratch("fly-lines");
    for [file, from, to, words] in MISTAKES {
        let text = fs::read_to_string(root().join(file)).unwrap();
        let before = text.find(from).unwrap_or_else(|| panic!("{from} is not in {file}"));
        let line = 1 + text[..before].lines().count() - usize::from(!text[..before].ends_with('\n'));
        // A missing key is looked for at the head of its table, the line above.
        let line = if to.is_empty() { line - 1 } else { line };
        edited(&folder, file, from, to);
        let output = wingbeat(&folder, &["fly", "scenarios/banking_turn.toml"]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        let expected = format!("error: {file}:{line}: {words}");
        assert!(message.starts_with(&expected), "{message}\nexpected {expected}");
        assert_eq!(entries(&folder), ["robots", "scenarios"]);
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_flight_leaves_nothing() {
    let folder = scratch("fly-interrupted");
    let scenario = root().join("scenarios/glide.toml");
    let mut child = Command::new(env!("CARGO_BIN_EXE_wingbeat"))
        .args(["fly", scenario.to_str().unwrap(), "--set", "flight.duration_s=500", "--quiet"])
        .current_dir(&folder)
        .spawn()
        .unwrap();
    while !folder.join("runs").exists() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signal.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(entries(&folder).is_empty());
}

/// The numbers of summary.json, wherever they stand, by their way.
fn numbers(value: &serde_json::Value, way: String, out: &mut Vec<(String, f64)>) {
    match value {
        serde_json::Value::Object(all) => all.iter().for_each(|(k, v)| numbers(v, format!("{way}/{k}"), out)),
        serde_json::Value::Array(all) => all.iter().for_each(|v| numbers(v, format!("{way}/"), out)),
        other => out.extend(other.as_f64().map(|number| (way, number))),
    }
}

#[test]
fn a_flight_whose_numbers_grow_without_bound_says_nothing_of_them() {
    let folder = scratch("fly-grew");
    let scenario = root().join("scenarios/banking_turn.toml");
    // A structure four hundred times as quick is beyond what the steps can follow.
    let coarse = ["mismatch.regulator_bandwidth=400", "flight.record_every_s=1e-4", "flight.duration_s=0.05"];
    let mut arguments = vec!["fly", scenario.to_str().unwrap(), "--out", "a"];
    arguments.extend(coarse.iter().flat_map(|key| ["--set", key]));
    let output = wingbeat(&folder, &arguments);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.join("a/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "failed", "{summary}");
    for key in ["drive_power_w", "regulator_power_given_w", "roll_mean_deg", "mean_speed_m_s", "step_error_m"]
    {
        assert!(summary[key].is_null(), "{key}: {summary}");
    }
    let warned = summary["warnings"].as_array().unwrap();
    assert!(warned.iter().any(|warning| warning["id"] == "flight.left_out"), "{warned:?}");
    let mut all = Vec::new();
    numbers(&summary, String::new(), &mut all);
    let huge = all.iter().find(|(way, number)| !way.starts_with("/controller") && number.abs() > 1e4);
    assert!(huge.is_none(), "{huge:?}");
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(!table.contains("NaN") && !table.split_whitespace().any(|word| word.len() > 40), "{table}");
}

#[test]
fn numbers_of_a_rejected_fit_are_said_wherever_they_are_given() {
    let folder = scratch("fly-fit");
    let rejected = "{verdict = {status = \"suspect_data\", reason = \"a dead channel\"}}";
    for (out, key) in [("a", "robot.numbers"), ("b", "mismatch.numbers")] {
        let set = format!("{key}={rejected}");
        let output = glide(&folder, &["--set", &set, "--out", out]);
        assert!(output.status.success(), "{output:?}");
        let summary: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.join(out).join("summary.json")).unwrap())
                .unwrap();
        let warned = summary["warnings"].as_array().unwrap();
        let of_fit: Vec<_> = warned.iter().filter(|warning| warning["id"] == "fit.rejected").collect();
        assert!(of_fit.len() == 1 && of_fit[0]["key"] == key, "{warned:?}");
        assert!(of_fit[0]["text"].as_str().unwrap().contains("a dead channel"), "{warned:?}");
    }
}

#[test]
fn numbers_of_another_model_are_said() {
    let folder = scratch("fly-model");
    let told = |model: &str| {
        let set = format!("robot.numbers={{model = {{{model}}}}}");
        let output = glide(&folder, &["--set", &set, "--force", "--out", "o"]);
        assert!(output.status.success(), "{output:?}");
        let all = warned(&folder, "o").into_iter();
        all.filter(|[id, _]| id == "fit.other_model").map(|[_, text]| text).collect::<Vec<_>>()
    };
    let apart = told("robot = \"a wing\", preset = \"as_printed\", law = \"lev3d\"");
    assert!(apart.len() == 1 && apart[0].contains("robot \"a wing\", here"), "{apart:?}");
    assert!(apart[0].contains("preset \"as_printed\", here") && apart[0].contains("law \"lev3d\", here"));
    let long = told(&format!("robot = \"{}\", preset = \"paper\", law = \"stall\"", "r".repeat(100_000)));
    assert!(
        long.len() == 1 && long[0].len() < 500 && long[0].contains("rrr...\", here"),
        "{}",
        long[0].len()
    );
    let resolved: toml::Table = fs::read_to_string(folder.join("o/scenario.toml")).unwrap().parse().unwrap();
    let word = |table: &str, key: &str| resolved[table][key].as_str().unwrap().to_owned();
    let own = [("robot", "name"), ("aero", "preset"), ("aero", "law")].map(|(table, key)| word(table, key));
    let [robot, preset, law] = own;
    assert_eq!(told(&format!("robot = \"{robot}\", preset = \"{preset}\", law = \"{law}\"")), [""; 0]);
    // Numbers of a wing alone name no robot.
    let alone = format!("preset = \"{preset}\", law = \"{law}\"");
    assert_eq!(told(&alone), [""; 0]);
    // What tells wings is their span.
    let planform = resolved["robot"]["wing"]["planform"].as_array().unwrap();
    let span = planform.last().unwrap()["arc_m"].as_float().unwrap();
    assert_eq!(told(&format!("{alone}, half_span_m = {:?}", 1.1 * span)), [""; 0]);
    let other = told(&format!("{alone}, half_span_m = {:?}", 2.0 * span));
    assert!(other.len() == 1 && other[0].contains("half span of"), "{other:?}");
}

/// Ids and texts of the warnings in the summary of the run folder `out`.
fn warned(folder: &Path, out: &str) -> Vec<[String; 2]> {
    let summary = fs::read_to_string(folder.join(out).join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let warnings = summary["warnings"].as_array().unwrap().iter();
    warnings.map(|warning| ["id", "text"].map(|key| warning[key].as_str().unwrap().to_owned())).collect()
}

/// Makes `mini.toml`, a small robot, and `sc.toml`, in which it flies.
fn small_scenario(folder: &Path) {
    assert!(wingbeat(folder, &["new", "robot", "--minimal", "mini.toml"]).status.success());
    assert!(wingbeat(folder, &["new", "scenario", "--robot", "mini.toml", "sc.toml"]).status.success());
}

/// Flies it for a moment into the folder `o`, whatever becomes of it.
fn fly_shortly(folder: &Path, set: &[&str]) {
    let mut arguments = vec!["fly", "sc.toml", "--quiet", "--no-report", "--force", "--out", "o"];
    arguments.extend(["flight.duration_s=0.02"].iter().chain(set).flat_map(|set| ["--set", set]));
    let answer = wingbeat(folder, &arguments);
    assert!(answer.status.code() != Some(2), "{}", String::from_utf8_lossy(&answer.stderr));
}

#[test]
fn degrees_in_place_of_radians_are_asked_about() {
    let folder = scratch("fly-degrees");
    small_scenario(&folder);
    let told = |set: &[&str]| {
        fly_shortly(&folder, set);
        let ids = warned(&folder, "o").into_iter().map(|[id, _]| id);
        ids.filter(|id| id.starts_with("range.joint_")).collect::<Vec<_>>()
    };
    assert_eq!(told(&[]), [""; 0]);
    assert_eq!(told(&["robot.links[1].driven.mean_rad=-30"]), ["range.joint_angle_rad"]);
    assert_eq!(told(&["robot.links[2].driven.mean_rad=5"]), ["range.joint_angle_rad"]);
    assert_eq!(told(&["robot.links[0].driven.harmonics[0].phase_rad=90"]), ["range.joint_phase_rad"]);
}

#[test]
fn refusals_name_their_override_and_their_help() {
    let folder = scratch("fly-refusals");
    small_scenario(&folder);
    let said = |arguments: &[&str]| {
        let output = wingbeat(&folder, arguments);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let strips = said(&["fly", "sc.toml", "--set", "aero.full.strips=32"]);
    assert!(strips.contains("--set aero.full.strips=32"), "{strips}");
    fs::write(folder.join("n.toml"), "# By hand.\n\n\"body.mass_kg\" = 0.02\n\"surfaces.wing.cd9\" = 1.0\n")
        .unwrap();
    let name = said(&["fly", "sc.toml", "--set", "robot.numbers=n.toml"]);
    assert!(name.contains("n.toml:4: robot.numbers = \"surfaces.wing.cd9\""), "{name}");
    let density = said(&["fly", "sc.toml", "--set", "air.density_kg_m3=nan"]);
    assert!(density.contains("allowed is a finite number") && !density.contains("magnitude"), "{density}");
    let trim = said(&["trim", "sc.toml"]);
    assert!(trim.contains("wingbeat new trim"), "{trim}");
    let new = wingbeat(&folder, &["new", "case", "a b.toml"]);
    let new = String::from_utf8(new.stdout).unwrap();
    assert!(new.contains("next: wingbeat tether 'a b.toml'"), "{new}");
}

#[test]
fn overrides_without_effect_are_told() {
    let folder = scratch("fly-in-vain");
    small_scenario(&folder);
    let told = |id: &str, set: &[&str]| {
        fly_shortly(&folder, set);
        let texts = warned(&folder, "o").into_iter().filter(|warning| warning[0] == id);
        texts.map(|[_, text]| text).collect::<Vec<_>>()
    };
    let numbers = r#"robot.numbers={"surfaces.wing.cd0"=0.03,"air.density_kg_m3"=1.0}"#;
    let twice = |set: &[&str]| told("numbers.given_twice", set);
    assert_eq!(twice(&[numbers]), [""; 0]);
    assert_eq!(twice(&["robot.surfaces[0].cd0=1.5"]), [""; 0]);
    assert_eq!(twice(&[numbers, "robot.body.mass_kg=0.03"]), [""; 0]);
    let both = twice(&[numbers, "robot.surfaces[0].cd0=1.5", "air.density_kg_m3=1.3"]);
    assert_eq!(both.len(), 2, "{both:?}");
    for (text, parts) in both.iter().zip([
        ["surfaces.wing.cd0 = 0.03 (--set robot.numbers=", "--set robot.surfaces[0].cd0=1.5"],
        ["air.density_kg_m3 = 1 (--set robot.numbers=", "--set air.density_kg_m3=1.3"],
    ]) {
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
    // Of the robot that flies beside the one that is known.
    let flies = r#"mismatch.numbers={"surfaces.wing.cd0"=0.04}"#;
    assert_eq!(twice(&[flies, "mismatch.mass=1.1"]), [""; 0]);
    let of_flown = twice(&[flies, "robot.surfaces[0].cd0=1.5"]);
    assert!(
        of_flown.len() == 1 && of_flown[0].starts_with("mismatch.numbers gives surfaces.wing.cd0 = 0.04"),
        "{of_flown:?}"
    );
    assert!(of_flown[0].contains("of the robot that flies"), "{of_flown:?}");
    let unheard = |set: &[&str]| told("aero.unheard", set).len();
    assert_eq!(unheard(&["aero.preset=paper", "aero.full.lags=five"]), 1);
    assert_eq!(unheard(&["aero.preset=full", "aero.full.lags=five"]), 0);
    assert_eq!(unheard(&["aero.preset=full", "aero.paper.nodes=20"]), 1);
    assert_eq!(unheard(&["aero.preset=paper", "aero.paper.nodes=20"]), 0);
    assert_eq!(unheard(&["aero.law=stall", "aero.critical_suction=0.2"]), 1);
    assert_eq!(unheard(&["aero.law=lev", "aero.critical_suction=0.2"]), 0);
    assert_eq!(unheard(&["aero.preset=full", "aero={paper={nodes=20},law=\"stall\"}"]), 1);
}

#[test]
fn the_power_of_a_flight_is_above_the_ideal_one() {
    let folder = scratch("fly-ideal");
    let scenario = root().join("scenarios/cruise_20g.toml");
    let fly = |set: &str| {
        let scenario = scenario.to_str().unwrap();
        let shown = ["--quiet", "--no-report", "--force", "--out", "o"];
        wingbeat(&folder, &[&["fly", scenario, "--set", set], &shown[..]].concat()).status.code()
    };
    assert_eq!(fly("flight.duration_s=2.0"), Some(0));
    let summary = fs::read_to_string(folder.join("o/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let judged = summary["judged"].as_array().unwrap();
    let ideal = judged.iter().find(|row| row["id"] == "flight.ideal_power_fraction").unwrap();
    let value = ideal["value"].as_f64().unwrap();
    assert!(value > 0.0 && value < 0.31, "{value}");
    assert_eq!(fly(&format!("limits.flight.ideal_power_fraction={}", 0.9 * value)), Some(3));
}

/// A flap whose mass is taken out of the pieces of a spar that have no inertia about the span: no step is short enough.
#[test]
fn pieces_of_a_spar_without_inertia_are_named() {
    let folder = scratch("fly-inertia");
    assert!(wingbeat(&folder, &["new", "robot", "r.toml", "--minimal"]).status.success());
    let text = fs::read_to_string(folder.join("r.toml")).unwrap();
    let text = text
        .replace(
            "inertia_kg_m2 = [1.2e-6, 5e-7, 1.6e-6]\n",
            "inertia_kg_m2 = [1.2e-6, 5e-7, 1.6e-6]\nspar = { length_m = 0.12, segments = 3, bending_n_m2 = 2e-2, \
             torsion_n_m2 = 1e-2, mass_kg_m = 0.005 }\n",
        )
        .replace(
            "name = \"wing\"\n",
            "name = \"wing\"\nflap = { chord_fraction = 0.2, stiffness_n_rad = 1.0, areal_density_kg_m2 = 0.1 }\n",
        );
    assert!(text.contains("spar = {") && text.contains("flap = {"), "{text}");
    fs::write(folder.join("r.toml"), text).unwrap();
    assert!(wingbeat(&folder, &["new", "scenario", "s.toml", "--robot", "r.toml"]).status.success());
    let set = ["--set", "flight.duration_s=0.01", "--no-report", "--out", "a"];
    let output = wingbeat(&folder, &[&["fly", "s.toml"], &set[..]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("mass matrix") && said.contains("inertia_kg_m of its spar"), "{said}");
    assert!(!said.contains("shorter flight.step_s"), "{said}");
}

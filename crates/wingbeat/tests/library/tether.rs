//! Tethered wings from their case files.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::judge::Status;
use wingbeat::math::{Random, Vec3};
use wingbeat::scenario::{Convergence, ConvergenceCell, ConvergenceRun, Document, TetherCase};
use wingbeat::simulate::{Ending, Record};
use wingbeat::tether::{Shape, Tether, TetherRun};

/// Aerodynamic presets.
const PRESETS: [&str; 2] = ["paper", "full"];

fn case(name: &str, overrides: &[&str]) -> TetherCase {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases").join(name);
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    let none = |_: &std::path::Path| Err::<Record, String>("no table".into());
    TetherCase::load(&path.with_extension("toml"), &overrides, &none).unwrap()
}

fn run(name: &str, overrides: &[&str]) -> TetherRun {
    let run = case(name, overrides).tether.run(|_| ControlFlow::Continue(()));
    assert_eq!(run.ending, Ending::Complete, "{name}");
    run
}

fn mean(run: &TetherRun, name: &str) -> f64 {
    run.means.iter().find(|m| m.name == name).unwrap().mean
}

#[test]
fn every_case_runs_with_every_preset() {
    for name in ["step", "plunge", "pitch", "flap_f1", "flap_f2", "flap_fold", "scherer", "aerobat_stand"] {
        for preset in PRESETS {
            let run = run(name, &[&format!("aero.preset={preset}")]);
            let finite = run.loads.columns().iter().all(|c| c.values.iter().all(|v| v.is_finite()));
            assert!(finite, "{name} {preset}");
        }
    }
}

#[test]
fn a_sudden_start_ends_near_the_steady_lift() {
    let run = run("step", &["aero.preset=paper"]);
    let lift = run.loads.values("CL").unwrap();
    let alpha = 5.0_f64.to_radians();
    // Lifting line of the rectangle of aspect ratio 4, 200 terms; the start is Wagner's half.
    let steady = 4.0283867 * alpha;
    assert!((lift[lift.len() - 1] / steady - 1.0).abs() < 0.02, "{}", lift[lift.len() - 1] / steady);
    assert!((lift[0] / (std::f64::consts::PI * alpha) - 1.0).abs() < 0.02, "{}", lift[0]);
}

/// Halves shorter than their chord have no section further from the root than that.
#[test]
fn short_halves_that_pass_through_each_other_cross() {
    let crossing = |half_span: f64, hinge: &str| {
        let text = format!(
            "name = \"short\"\nwing.planform = [\n{{ arc_m = 0.0, leading_edge_m = 0.03, trailing_edge_m = -0.07 }},\n\
             {{ arc_m = {half_span:?}, leading_edge_m = 0.03, trailing_edge_m = -0.07 }},\n]\nwing.hinges = [{hinge}]\n\
             wind = {{ speed_m_s = 2.0, density_kg_m3 = 1.225 }}\naero = {{ preset = \"full\", law = \"stall\" }}\n\
             time = {{ frequency_hz = 2.0, cycles = 2, steps_per_cycle = 100 }}\n"
        );
        let none = |_: &std::path::Path| Err::<Record, String>("no table".into());
        TetherCase::new(Document::text("short", &text).unwrap(), &none).unwrap().tether.crossing_fraction()
    };
    let flap = |most: f64| {
        format!("{{ name = \"flap\", kind = \"flap\", arc_m = 0.0, angle_deg.fourier.sin = [{most:?}] }}")
    };
    // Beyond 90 deg of a sine of 120 deg: acos(90/120)/pi on either side.
    let share = (90.0_f64 / 120.0).acos() * 2.0 / std::f64::consts::PI;
    for half_span in [0.08, 0.3] {
        let told = crossing(half_span, &flap(120.0));
        assert!((told - share).abs() < 0.05, "{half_span} m: {told}, not {share}");
        assert_eq!(crossing(half_span, &flap(89.0)), 0.0, "{half_span} m");
        // About a line ahead of the leading edge the roots overlap all the time.
        let swept = |ahead: f64| {
            let hinge = "name = \"sweep\", kind = \"sweep\", arc_m = 0.0, angle_deg.constant = -40.0";
            crossing(half_span, &format!("{{ {hinge}, ahead_m = {ahead:?} }}"))
        };
        assert_eq!((swept(0.0), swept(0.2)), (0.0, 1.0), "{half_span} m");
    }
}

/// A small wing that sweeps and turns its leading edge up and over.
const REVERSAL: &str = r#"
name = "reversal"
[wing]
planform = [
  { arc_m = 0.0, leading_edge_m = 0.0003, trailing_edge_m = -0.0006 },
  { arc_m = 0.0014, leading_edge_m = 0.0003, trailing_edge_m = -0.0009 },
  { arc_m = 0.0029, leading_edge_m = 0.0, trailing_edge_m = -0.0003 },
]
[[wing.hinges]]
name = "stroke"
kind = "sweep"
arc_m = 0.0
angle_deg = { fourier = { mean = 5.0, cos = [62.0] } }
[[wing.hinges]]
name = "rotation"
kind = "twist"
arc_m = 0.0002
angle_deg = { fourier = { mean = 90.0, sin = [42.0] } }
[wind]
speed_m_s = 1.0
density_kg_m3 = 1.2
[aero]
preset = "full"
law = "stall"
[aero.full]
strips = 10
regularisation_m_s = 0.05
[time]
frequency_hz = 190.0
cycles = 2
steps_per_cycle = 240
"#;

#[test]
fn peaks_that_move_with_the_steps_are_not_resolved() {
    let document = Document::text("reversal", REVERSAL).unwrap();
    let case = TetherCase::new(document, &|_| Err::<Record, String>("no table".into())).unwrap();
    let simulate = |tether: &Tether| tether.run(|_| ControlFlow::Continue(()));
    let run = simulate(&case.tether);
    let change = case.step_change(&run, |other| Ok::<_, String>(simulate(other))).unwrap().unwrap();
    assert!(change.mean < 0.05 && change.peak > 0.5, "{change:?}");
    let summary = case.summary(&run, Some(change), None);
    assert_eq!(summary.step_change_of_peaks, Some(change.peak));
    assert_eq!(summary.verdict.status, Status::NotResolved);
    assert!(summary.verdict.warnings.iter().any(|warning| warning.id == "tether.steps_of_peaks"));
    let flap = self::case("flap_f2", &[]);
    let run = simulate(&flap.tether);
    let change = flap.step_change(&run, |other| Ok::<_, String>(simulate(other))).unwrap().unwrap();
    assert!(change.peak < 0.005, "{change:?}");
    assert_eq!(flap.summary(&run, Some(change), None).verdict.status, Status::Ok);
}

#[test]
fn a_wing_that_hardly_leaves_its_wake_is_told() {
    // Small motion in a wind of 1 m/s on a chord of 1 m, whose speed is the root of 1 + (k h)^2 / 2 with 2 k = 1 and h = 0.05.
    for preset in PRESETS.iter().chain(&["as_printed"]) {
        let slow = case("plunge", &[&format!("aero.preset={preset}")]);
        let speed: f64 = 1.0 + 0.5 * 0.05_f64.powi(2);
        let [chord, mean] = slow.tether.mean_chord_and_speed();
        assert!(
            (chord - 1.0).abs() < 1e-12 && (mean - speed.sqrt()).abs() < 1e-12,
            "{preset}: {chord}, {mean}"
        );
    }
    let few = ["time.steps_per_cycle=32", "time.cycles=2"];
    for (frequency, told) in [("time.frequency_hz=0.6", false), ("time.frequency_hz=0.7", true)] {
        let case = case("plunge", &[few[0], few[1], frequency]);
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let verdict = case.summary(&run, None, None).verdict;
        let of = verdict.judged.iter().find(|judged| judged.id == "tether.reduced_frequency");
        assert_eq!(!of.unwrap().met, told, "{frequency}: {of:?}");
    }
    for (speed, told) in [("wind.speed_m_s=0.015", false), ("wind.speed_m_s=0.01", true)] {
        let case = case("plunge", &[few[0], few[1], speed, "time.frequency_hz=0.001"]);
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let verdict = case.summary(&run, None, None).verdict;
        let of = verdict.judged.iter().find(|judged| judged.id == "tether.reynolds");
        assert_eq!(!of.unwrap().met, told, "{speed}: {of:?}");
    }
    for (density, told) in [("wind.density_kg_m3=0.06", false), ("wind.density_kg_m3=0.001225", true)] {
        let case = case("plunge", &[few[0], few[1], density]);
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let verdict = case.summary(&run, None, None).verdict;
        let of = verdict.judged.iter().find(|judged| judged.id == "range.density_kg_m3");
        assert_eq!(!of.unwrap().met, told, "{density}: {of:?}");
        let warned = verdict.warnings.iter().any(|warning| warning.id == "range.density_kg_m3");
        assert_eq!(warned, told, "{density}");
    }
}

/// A film on a symmetric wing bulges alike on both sides, wherever ribs lie beside the strips.
#[test]
fn a_sail_is_as_symmetric_as_its_wing() {
    let film = "thickness_m=1e-4,modulus_pa=1.5e6,density_kg_m3=950.0,prestrain=0.05,ribs_m=[0.0,0.2]";
    for strips in [8, 16, 32] {
        let set = [format!("aero.full.strips={strips}"), format!("wing.membrane={{{film}}}")];
        let run = run("flap_f2", &[set[0].as_str(), set[1].as_str(), "time.cycles=1"]);
        let camber = run.strips.values("camber").unwrap();
        let last = &camber[camber.len() - strips..];
        let most = last.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
        assert!(most > 1e-3, "{strips}: {most}");
        for i in 0..strips / 2 {
            let apart = (last[i] - last[strips - 1 - i]).abs();
            assert!(apart < 1e-9 * most, "{strips}, strip {i}: {apart} of {most}");
        }
    }
}

/// The first cycle begins at rest, and none before it says how far it is from the next.
#[test]
fn one_cycle_of_a_motion_that_repeats_is_not_judged() {
    let status = |name: &str, cycles: &str| {
        let case = case(name, &[cycles, "time.steps_per_cycle=96"]);
        case.summary(&case.tether.run(|_| ControlFlow::Continue(())), None, None).verdict.status
    };
    assert_eq!(status("flap_f1", "time.cycles=1"), Status::NotJudged);
    assert_eq!(status("step", "time.cycles=1"), Status::Ok);
    assert_ne!(status("flap_f1", "time.cycles=2"), Status::NotJudged);
}

#[test]
fn wind_from_behind_is_told() {
    for (speed, status) in [("wind.speed_m_s=1.5", Status::Ok), ("wind.speed_m_s=-1.5", Status::Outside)] {
        let case = case("step", &[speed, "aero.law=lev", "time.steps_per_cycle=100"]);
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let verdict = case.summary(&run, None, None).verdict;
        assert_eq!(verdict.status, status, "{speed}: {verdict:?}");
    }
}

/// Every law is asked whether its angles of attack are those that it holds for; one that knows separation was measured up to 45 deg.
#[test]
fn a_wing_past_what_its_law_holds_for_is_told() {
    let judged = |law: &str, incidence: f64| {
        let overrides = [format!("aero.law={law}"), format!("body.nose_up_deg.constant={incidence}")];
        let overrides = overrides.each_ref().map(String::as_str);
        let case = case("step", &[&overrides[..], &["time.steps_per_cycle=100"]].concat());
        let verdict = case.summary(&case.tether.run(|_| ControlFlow::Continue(())), None, None).verdict;
        let mut warnings = verdict.warnings.into_iter();
        (warnings.find(|warning| warning.id == "range.stall_fraction").map(|told| told.key), verdict.status)
    };
    let by_law = Some("aero.law".to_owned());
    for law in ["linear", "stall"] {
        assert_eq!(judged(law, 5.0), (None, Status::Ok), "{law}");
        assert_eq!(judged(law, 20.0), (Some(by_law.clone()), Status::Ok), "{law}");
        assert_eq!(judged(law, 90.0), (Some(by_law.clone()), Status::Outside), "{law}");
    }
    // No other law holds where these do not.
    for law in ["lev", "lev3d"] {
        assert_eq!(judged(law, 40.0), (None, Status::Ok), "{law}");
        assert_eq!(judged(law, 90.0), (Some(None), Status::Outside), "{law}");
    }
}

#[test]
fn hinges_that_crowd_the_strips_are_told() {
    for (strips, arc, told) in [(6, 0.01, true), (16, 0.01, false), (6, 0.1125, false)] {
        let set = [
            format!("aero.full.strips={strips}"),
            format!("wing.hinges[1].arc_m={arc}"),
            "time.steps_per_cycle=32".into(),
        ];
        let case = case("flap_fold", &set.each_ref().map(String::as_str));
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let warnings = case.summary(&run, None, None).verdict.warnings;
        let found = |id: &str| warnings.iter().any(|warning| warning.id == id);
        assert_eq!(found("aero.strips_crowded"), told, "{strips} strips, hinge at {arc}: {warnings:?}");
        assert!(!found("aero.few_strips"), "{warnings:?}");
    }
}

#[test]
fn few_strips_are_told() {
    let case = case("flap_f2", &["aero.full.strips=3", "time.steps_per_cycle=32"]);
    let run = case.tether.run(|_| ControlFlow::Continue(()));
    let warnings = case.summary(&run, None, None).verdict.warnings;
    let told = warnings.iter().find(|warning| warning.id == "aero.few_strips").unwrap();
    assert_eq!((told.size, told.key.as_deref()), (Some(3.0), Some("aero.full.strips")), "{told:?}");
}

#[test]
fn a_twist_that_does_not_grow_along_the_span_is_told() {
    for (kind, end, told) in [("fold", None, false), ("twist", None, true), ("twist", Some(0.2), false)] {
        let mut set = vec!["time.steps_per_cycle=32".to_owned(), format!("wing.hinges[1].kind={kind}")];
        set.extend(end.map(|end| format!("wing.hinges[1].to_arc_m={end}")));
        let case = case("flap_fold", &set.iter().map(String::as_str).collect::<Vec<_>>());
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let warnings = case.summary(&run, None, None).verdict.warnings;
        assert_eq!(
            warnings.iter().any(|warning| warning.id == "aero.open_twist"),
            told,
            "{kind}: {warnings:?}"
        );
    }
}

/// Trailing edges turn about the hinge line by the angles of the strips; what lies ahead of it stays.
#[test]
fn a_tethered_flap_is_drawn_turned() {
    let flap = "wing.flap={chord_fraction=0.3,stiffness_n_rad=1.0,areal_density_kg_m2=0.1}";
    let tether = case("flap_f2", &[flap]).tether;
    let arcs = tether.drawn_arcs(8);
    let flat = tether.outline(0.0, &arcs, Shape::default());
    let angle = 0.2_f64;
    let flaps = vec![angle; tether.aero.strips()];
    let turned = tether.outline(0.0, &arcs, Shape { flaps: &flaps, ..Shape::default() });
    assert_eq!((flat.hinge, flat.raised.len()), (None, 0));
    assert!(turned.hinge.is_some() && turned.raised.len() == arcs.len());
    for ([le, te], [edge, tail]) in flat.ribs.iter().zip(&turned.ribs) {
        let (chord, moved) = ((*te - *le).norm(), (*tail - *te).norm());
        assert!((*edge - *le).norm() < 1e-15);
        assert!((moved - 0.3 * chord * 2.0 * (0.5 * angle).sin()).abs() < 1e-12, "{moved}");
    }
}

#[test]
fn the_impulse_of_the_circulation_turns_with_the_section() {
    let (degrees, frequency, speed) = (2.0_f64, 3.5, 1.5);
    let flap = "wing.hinges[0].angle_deg={fourier={sin=[2.0]}}";
    let [without, with] = [false, true].map(|turns| {
        let set = format!("aero.full.turning_impulse={turns}");
        run("flap_f2", &[flap, "aero.law=linear", "aero.full.edge_suction=false", &set])
    });
    let column = |run: &TetherRun, name: &str| run.strips.values(name).unwrap().to_vec();
    let vectors = |run: &TetherRun, name: &str| -> Vec<Vec3> {
        let [x, y, z] = ["x", "y", "z"].map(|axis| column(run, &format!("{name}_{axis}")));
        (0..x.len()).map(|k| Vec3::new(x[k], y[k], z[k])).collect()
    };
    let [off, on] = [&without, &with].map(|run| vectors(run, "force"));
    let (circulatory, place) = (vectors(&without, "force_circulatory"), vectors(&without, "quarter_chord"));
    let (t, chord) = (column(&without, "t"), column(&without, "chord"));
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for k in 0..t.len() {
        let along = Vec3::new(0.0, place[k][1], place[k][2]).unit();
        let normal = Vec3::new(0.0, -along[2], along[1]) * along[1].signum();
        let omega = std::f64::consts::TAU * frequency;
        let rate = degrees.to_radians() * omega * (omega * t[k]).cos();
        // The lift is rho V G dy and the impulse rho b G dy.
        let impulse = circulatory[k].dot(normal) / speed * 0.5 * chord[k];
        let expected = along * (-impulse * rate);
        error = error.max((on[k] - off[k] - expected).norm());
        largest = largest.max(expected.norm());
    }
    assert!(largest > 1e-6 && error < 0.02 * largest, "{error} of {largest} N");
}

#[test]
fn a_half_wing_at_a_wall_carries_half_the_load() {
    let (whole, half) = (run("flap_fold", &[]), run("flap_fold", &["wing.side=left"]));
    for name in ["force_x", "force_z", "moment_y"] {
        let (a, b) = (whole.loads.values(name).unwrap(), half.loads.values(name).unwrap());
        assert!(a.iter().zip(b).all(|(a, b)| (a - 2.0 * b).abs() < 1e-12), "{name}");
    }
    assert!((mean(&whole, "CL") - mean(&half, "CL")).abs() < 1e-12);
    assert!(mean(&half, "moment_x").abs() > 1e-3);
}

#[test]
fn a_body_that_moves_forward_is_a_wind_from_ahead() {
    let surge = "body.surge_m.table={file=\"x\",column=\"y\"}";
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let read = |_: &std::path::Path| {
        let mut table = wingbeat::simulate::Record::new(
            ["t", "y"].map(|name| wingbeat::simulate::Column::new(name, "", "")).to_vec(),
            2,
        )
        .unwrap();
        table.append(&[0.0, 0.0]);
        table.append(&[1.0, 1.5]);
        Ok(table)
    };
    let overrides = [surge, "wind.speed_m_s=0", "reference.speed_m_s=1.5"].map(String::from);
    let moving =
        TetherCase::load(&path, &overrides, &read).unwrap().tether.run(|_| ControlFlow::Continue(()));
    let still = run("flap_f2", &["wind.incidence_deg=0"]);
    for name in ["force_x", "force_z", "moment_y"] {
        let (a, b) = (moving.loads.values(name).unwrap(), still.loads.values(name).unwrap());
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-10), "{name}");
    }
}

#[test]
fn a_periodic_table_moves_like_its_function() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let read = |_: &std::path::Path| {
        let columns = ["t", "shoulder"].map(|name| wingbeat::simulate::Column::new(name, "", "")).to_vec();
        let mut table = wingbeat::simulate::Record::new(columns, 65).unwrap();
        for i in 0..=64 {
            let phase = f64::from(i) / 64.0;
            table.append(&[phase / 3.5, 35.0 * (std::f64::consts::TAU * phase).sin()]);
        }
        Ok(table)
    };
    let table = "wing.hinges[0].angle_deg={table={file=\"x.csv\",column=\"shoulder\",periodic=true}}";
    let splined = TetherCase::load(&path, &[table.into()], &read).unwrap();
    let splined = splined.tether.run(|_| ControlFlow::Continue(()));
    let exact = run("flap_f2", &[]);
    let (a, b) = (splined.loads.values("force_z").unwrap(), exact.loads.values("force_z").unwrap());
    let largest = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-3 * largest));
}

/// A body that moves in every way, and hinges of every kind on one side or both.
const ALL_MOVE: [&str; 8] = [
    "body.surge_m={fourier={sin=[0.02]}}",
    "body.heave_m={fourier={cos=[0.03]}}",
    "body.nose_up_deg={fourier={mean=5,sin=[6]}}",
    "body.roll_deg={fourier={sin=[0,7]}}",
    "body.pitch_axis_ahead_m=0.02",
    "wing.hinges[0].side=left",
    "time.cycles=2",
    "time.steps_per_cycle=128",
];

/// Further hinges of the case `flap_fold`.
const MORE_HINGES: &str = "wing.hinges=[\
    {name=\"sweep\",kind=\"sweep\",arc_m=0.0,angle_deg={fourier={sin=[12]}}},\
    {name=\"shoulder\",kind=\"flap\",arc_m=0.0,angle_deg={fourier={sin=[30]}}},\
    {name=\"grow\",kind=\"twist\",arc_m=0.02,to_arc_m=0.25,ahead_m=0.01,angle_deg={fourier={cos=[15]}}},\
    {name=\"elbow\",kind=\"fold\",arc_m=0.1125,angle_deg={fourier={mean=-25,cos=[-25]}}},\
    {name=\"tip\",kind=\"twist\",side=\"right\",arc_m=0.2,angle_deg={fourier={sin=[20]}}}]";

/// Largest magnitude of a column.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

#[test]
fn power_is_that_of_body_and_hinges() {
    for preset in PRESETS {
        for (side, middle) in [("both", "odd"), ("both", "even"), ("left", "even")] {
            let strips = if middle == "odd" { 13 } else { 12 };
            let own = if side == "left" { "both" } else { "right" };
            let mut overrides = vec![MORE_HINGES.replace("\"right\"", &format!("\"{own}\""))];
            // A half keeps its mirror plane: it neither rolls, nor has a hinge of one side.
            let breaks = |set: &&str| side == "left" && (set.contains("roll") || set.contains("side"));
            overrides.extend(ALL_MOVE.into_iter().filter(|set| !breaks(set)).map(str::to_owned));
            overrides.push(format!("wing.side={side}"));
            overrides.push(format!("aero.preset={preset}"));
            overrides.push(format!(
                "aero.{}={strips}",
                if preset == "paper" { "paper.nodes" } else { "full.strips" }
            ));
            let run = run("flap_fold", &overrides.iter().map(String::as_str).collect::<Vec<_>>());
            let columns = run.loads.columns().iter();
            let parts: Vec<&[f64]> =
                columns.filter(|c| c.name.starts_with("power_")).map(|c| c.values.as_slice()).collect();
            assert_eq!(parts.len(), if side == "both" { 9 } else { 6 });
            let total = run.loads.values("power").unwrap();
            let apart = |i: usize| (total[i] - parts.iter().map(|part| part[i]).sum::<f64>()).abs();
            let worst = (0..total.len()).map(apart).fold(0.0, f64::max) / largest(total);
            assert!(worst < 1e-10 && largest(total) > 0.01, "{preset} {side} {strips}: {worst:e}");
        }
    }
}

/// Torques about a shoulder in the middle are moments about the body's x axis, which the strips' forces at their
/// points give without the wing's kinematics; power is minus force times velocity where nothing turns.
#[test]
fn torques_and_powers_are_those_of_the_forces() {
    let flapping = run("flap_f2", &["wing.side=left"]);
    let (torque, moment) = ("torque_shoulder_left", "moment_x");
    let (torque, moment) = (flapping.loads.values(torque).unwrap(), flapping.loads.values(moment).unwrap());
    let worst = torque.iter().zip(moment).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12 * largest(moment), "{worst:e}");

    let heaving = run("plunge", &[]);
    let column = |name: &str| heaving.loads.values(name).unwrap();
    let rate = std::f64::consts::TAU * 0.15915494309189535;
    let (power, force, t) = (column("power"), column("force_z"), column("t"));
    for i in 0..power.len() {
        let expected = 0.05 * rate * (rate * t[i]).sin() * force[i];
        assert!((power[i] - expected).abs() < 1e-10 * largest(power), "{} {expected}", power[i]);
    }
    let strips = |name: &str| heaving.strips.values(name).unwrap();
    let sum: f64 = strips("power").iter().rev().take(16).sum();
    assert!((sum - power[power.len() - 1]).abs() < 1e-12 * largest(power));
    assert!(strips("chord").iter().all(|chord| (chord - 1.0).abs() < 1e-12));
    assert!((largest(strips("velocity_z")) - 0.05 * rate).abs() < 1e-4 * rate);
}

/// Of a flat wing that does not twist nothing but the suction of the edge pulls along the chord.
#[test]
fn the_suction_of_the_edge_is_told_by_strip_and_wing() {
    for law in ["linear", "lev"] {
        let run = run("flap_f2", &["time.cycles=1", &format!("aero.law={law}")]);
        let (loads, strips) = (&run.loads, &run.strips);
        let count = strips.rows() / loads.rows();
        for part in ["suction", "vortex", "separated"] {
            for axis in ["x", "y", "z"] {
                let name = format!("force_{part}_{axis}");
                let (whole, each) = (loads.values(&name).unwrap(), strips.values(&name).unwrap());
                for (row, strips) in each.chunks(count).enumerate() {
                    let off = strips.iter().sum::<f64>() - whole[row];
                    assert!(off.abs() < 1e-14, "{law} {name}, row {row}: {off}");
                }
            }
        }
        let [suction, chordwise] =
            ["suction", "circulatory"].map(|part| loads.values(&format!("force_{part}_x")).unwrap());
        let off = suction.iter().zip(chordwise).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12 * largest(suction), "{law}: {off}");
        assert_eq!(largest(loads.values("force_vortex_z").unwrap()) > 0.0, law == "lev");
    }
}

#[test]
fn the_efficiency_of_a_plunging_wing_is_that_of_its_means() {
    let heaving = run("plunge", &["time.cycles=8"]);
    let efficiency = heaving.efficiency.unwrap();
    assert!((efficiency - mean(&heaving, "thrust") / mean(&heaving, "power")).abs() < 1e-14);
    // Energy is left in the wake: Garrick's plunging wing of infinite span reaches .63 at k = .5.
    assert!((0.2..0.8).contains(&efficiency), "{efficiency}");
    assert_eq!(run("step", &[]).efficiency, None);
}

#[test]
fn the_last_cycle_is_compared_with_the_one_before() {
    let short = run("flap_f2", &["time.cycles=2"]).periodicity.unwrap().change;
    let long = run("flap_f2", &["time.cycles=8"]).periodicity.unwrap().change;
    assert!(short > 1e-3 && long < 0.1 * short, "{short} {long}");
    assert_eq!(run("step", &[]).periodicity, None);
    let case = case("flap_f2", &["time.cycles=8"]);
    let run = case.tether.run(|_| ControlFlow::Continue(()));
    assert_eq!(case.summary(&run, None, None).verdict.status.name(), "ok");
}

/// A record of the column `name` over `when` at the given points.
fn table(when: &str, name: &str, points: impl Iterator<Item = (f64, f64)>) -> Record {
    let columns = [when, name].map(|name| wingbeat::simulate::Column::new(name, "", "")).to_vec();
    let mut table = Record::new(columns, 0).unwrap();
    points.for_each(|(t, y)| table.append(&[t, y]));
    table
}

/// The case `flap_f2` with its shoulder from a table; `keys` are further keys of the table.
fn tabled(record: &Record, keys: &str, more: &[&str]) -> Result<TetherCase, String> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let read = |_: &std::path::Path| Ok(record.clone());
    let key = format!("wing.hinges[0].angle_deg={{table={{file=\"x.csv\",column=\"shoulder\",{keys}}}}}");
    let mut overrides = vec![key];
    overrides.extend(more.iter().map(|text| (*text).to_owned()));
    TetherCase::load(&path, &overrides, &read).map_err(|error| error.to_string())
}

fn peak_lift(case: &TetherCase) -> f64 {
    let run = case.tether.run(|_| ControlFlow::Continue(()));
    run.means.iter().find(|m| m.name == "force_wind_lift").unwrap().high
}

#[test]
fn noise_on_a_table_is_smoothed_away() {
    let mut random = wingbeat::math::Random::new(5);
    let mut noisy = |rows: u32| {
        let point = |i: u32| {
            let t = f64::from(i) / 500.0;
            (t, 35.0 * (std::f64::consts::TAU * 3.5 * t).sin() + 0.15 * random.normal())
        };
        table("t", "shoulder", (0..rows).map(point))
    };
    let exact = peak_lift(&case("flap_f2", &[]));
    let (one, many) = (noisy(142), noisy(1000));
    let rough = peak_lift(&tabled(&one, "periodic=true", &[]).unwrap());
    assert!(rough > 2.0 * exact, "{rough} {exact}");
    for record in [one, many] {
        let case = tabled(&record, "harmonics=3", &[]).unwrap();
        let smooth = peak_lift(&case);
        assert!((smooth / exact - 1.0).abs() < 0.05, "{smooth} {exact}");
        let left = &case.smoothed[0];
        assert_eq!((left.key.as_str(), left.samples), ("wing.hinges[0].angle_deg", record.rows()));
        assert!((left.residual_rms / 0.15 - 1.0).abs() < 0.15 && left.residual_largest > 0.3, "{left:?}");
    }
}

#[test]
fn a_table_by_phase_or_at_another_frequency_is_the_same_motion() {
    let angle = |phase: f64| 35.0 * (std::f64::consts::TAU * phase).sin();
    let phases = || (0..=64).map(|i| f64::from(i) / 64.0);
    let expected = peak_lift(&case("flap_f2", &["time.frequency_hz=4.0"]));
    for (record, keys) in [
        (table("phase", "shoulder", phases().map(|p| (p, angle(p)))), "by=\"phase\""),
        (table("phase", "shoulder", phases().map(|p| (p, angle(p) / 7.0))), "by=\"phase\",scale=7.0"),
        (table("t", "shoulder", phases().map(|p| (p / 2.5, angle(p)))), "periodic=true,frequency_hz=2.5"),
        (table("t", "shoulder", phases().map(|p| (p / 2.5, angle(p)))), "harmonics=1,frequency_hz=2.5"),
    ] {
        let lift = peak_lift(&tabled(&record, keys, &["time.frequency_hz=4.0"]).unwrap());
        assert!((lift / expected - 1.0).abs() < 2e-3, "{keys}: {lift} {expected}");
    }
    let record = table("phase", "shoulder", phases().map(|p| (p, angle(p))));
    for (keys, part) in [
        ("periodic=true", "file = t: allowed is one of phase, shoulder"),
        ("by=\"phase\",frequency_hz=2.0", "a phase has no frequency"),
        ("by=\"phase\",harmonics=60", "do not determine so many"),
        ("harmonics=0", "1 to 64"),
        ("frequency_hz=2.0", "only of a table that repeats"),
    ] {
        let message = tabled(&record, keys, &[]).unwrap_err();
        assert!(message.contains(part), "{keys}: {message}");
    }
    // In the words of the file, not of the spline.
    let twice =
        table("phase", "shoulder", (0..=64).map(|i| (f64::from(i) / 32.0, angle(f64::from(i) / 32.0))));
    let turned = table("phase", "shoulder", [0.0, 0.25, 0.5, 0.4, 0.75].map(|p| (p, angle(p))).into_iter());
    for (record, parts) in [
        (
            &twice,
            ["at most one cycle of a table that repeats, 1.000000 cycles", "phase spans 2.000000 cycles"],
        ),
        (&turned, ["a column phase that ascends", "row 4 has 0.4 cycles after 0.5 cycles"]),
    ] {
        let message = tabled(record, "by=\"phase\"", &[]).unwrap_err();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
}

#[test]
fn few_strips_or_steps_are_not_halved() {
    for (set, part) in [
        ("aero.full.strips=5", "aero.full.strips = 5: allowed is 6 or more"),
        ("time.steps_per_cycle=15", "time.steps_per_cycle = 15: allowed is 16 or more"),
    ] {
        let message = case("flap_f2", &[set]).levels().unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn strips_and_steps_converge_with_their_orders() {
    let own = case("flap_f2", &["time.steps_per_cycle=96", "time.cycles=4"]);
    let levels = own.levels().unwrap();
    assert_eq!((levels.strips, levels.steps_per_cycle), ([8, 16, 32], [48, 96, 192]));
    let none = |_: &std::path::Path| Err::<Record, String>("no table".into());
    let one = |cell: ConvergenceCell| {
        let run = own.refined(cell, &none).unwrap().tether.run(|_| ControlFlow::Continue(()));
        ConvergenceRun::of(cell, &run, 1.0)
    };
    let table = Convergence::new(levels, levels.cells().into_iter().map(one).collect());
    assert_eq!(table.cells.len(), 9);
    let (plain, again) = (table.cells[4], own.tether.run(|_| ControlFlow::Continue(())));
    assert_eq!(
        (plain.strips, plain.steps_per_cycle, plain.mean_lift_n),
        (16, 96, mean(&again, "force_wind_lift"))
    );
    for quantity in &table.quantities {
        // What moves by less than a thousandth has no order.
        let ordered = quantity.order_strips.is_some_and(|order| (1.0..3.0).contains(&order));
        assert!(ordered || quantity.spread < 1e-3, "{quantity:?}");
        // The largest of the samples lies beside the peak, by less in turn.
        if !quantity.quantity.starts_with("peak") {
            assert!((3.0..5.0).contains(&quantity.order_steps.unwrap()), "{quantity:?}");
        }
    }
    assert!(table.spread > 1e-4 && table.spread < 0.1, "{table:?}");
    assert_eq!(table.status == "converged", table.spread <= 0.02, "{}", table.verdict);
}

#[test]
fn measured_loads_are_compared_with_computed_ones() {
    let own = case(
        "flap_f2",
        &["compare.channels={force_wind_lift=\"Fz\",power=\"P\"}", "compare.frequency_hz=2.0"],
    );
    let run = own.tether.run(|_| ControlFlow::Continue(()));
    let cycle = |name: &str, phase: f64| {
        let values = run.last_cycle(name).unwrap();
        values[(phase.rem_euclid(1.0) * values.len() as f64).round() as usize % values.len()]
    };
    let columns = ["t", "Fz", "P"].map(|name| wingbeat::simulate::Column::new(name, "", "")).to_vec();
    let mut measured = Record::new(columns, 0).unwrap();
    for i in 0..=480 {
        let phase = f64::from(i) / 192.0;
        let lift = 1e3 * cycle("force_wind_lift", phase - 24.0 / 192.0) + 7.0;
        measured.append(&[phase / 2.0, lift, 0.9 * cycle("power", phase)]);
    }
    let channels = own.channels(&measured).unwrap();
    let compared = own.compare(&run, &measured, &channels).unwrap();
    let [lift, power] = &compared.channels[..] else { panic!("two channels") };
    assert_eq!((lift.measured.as_str(), lift.cycles), ("Fz", 2));
    assert!(
        (lift.fit.lag_cycles - 0.125).abs() < 1e-3 && (lift.lag_s.unwrap() - 0.0625).abs() < 1e-3,
        "{lift:?}"
    );
    assert!((lift.fit.gain / 1e3 - 1.0).abs() < 1e-3 && (lift.fit.offset - 7.0).abs() < 0.5, "{lift:?}");
    assert!(lift.fit.rms < 2e-3 * lift.fit.range, "{lift:?}");
    assert!(power.fit.lag_cycles.abs() < 1e-3 && (power.fit.gain - 0.9).abs() < 1e-3, "{power:?}");
    assert_eq!((compared.cycle.rows(), compared.cycle.columns().len()), (360, 11));
    let other = compared.found.iter().find(|finding| finding.id == "data.other_frequency").unwrap();
    assert!(other.words().contains("3.5000 Hz, the measured motion at 2.0000 Hz"), "{}", other.words());
    let scaled = case("flap_f2", &["compare.channels={power=\"P\"}", "compare.scale.force_x=2.0"]);
    let message = scaled.channels(&measured).unwrap_err().to_string();
    assert!(message.contains("compare.scale.force_x") && message.contains("is compared: power"), "{message}");

    let refuse = |text: &str, record: &Record| {
        let own = case("flap_f2", &[text]);
        let channels = own.channels(record).map_err(|error| error.to_string());
        channels
            .and_then(|channels| own.compare(&run, record, &channels).map(drop).map_err(|e| e.to_string()))
    };
    let bad = |columns: &str, points: &[(f64, f64)]| table(columns, "power", points.iter().copied());
    for (text, record, part) in [
        ("compare.channels={lift=\"Fz\"}", &measured, "under a column of the loads"),
        ("compare.channels={force_z=\"Fx\"}", &measured, "a column of the file: Fz, P"),
        ("compare.by=time", &measured, "no column of one name"),
        ("compare.by=phase", &bad("t", &[(0.0, 1.0)]), "one called phase"),
        ("compare.by=time", &bad("t", &[(0.0, 1.0), (0.0, 2.0)]), "row 2 of the data, column t = 0"),
        ("compare.by=time", &bad("t", &[(0.0, 1.0), (0.01, 2.0)]), "at least one whole cycle"),
    ] {
        let message = refuse(text, record).unwrap_err();
        assert!(message.contains(part), "{text}: {message}");
    }
}

#[test]
fn bad_cases_are_refused_with_their_place() {
    let refuse = |text: &str| {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_fold.toml");
        let none = |_: &std::path::Path| Err::<Record, String>("no such file".into());
        TetherCase::load(&path, &[text.into()], &none).unwrap_err().to_string()
    };
    for (text, part) in [
        ("wing.hinges[1].arc_m=0.5", "arc_m"),
        ("wing.hinges[1].name=\"shoulder\"", "wing.hinges[1].name = \"shoulder\": allowed is a name"),
        ("time.frequency_hz=0", "above 0"),
        (
            "wing.membrane={thickness_m=1e-4, modulus_pa=1e6, density_kg_m3=1e3, ribs_m=[0.0, 5.0]}",
            "wing.membrane.ribs_m[1] = 5.0: allowed is 0 to the tip",
        ),
        ("time.cycles=100000000000", "at most 500000 steps"),
        ("time.steps_per_cycle=2", "at least 8"),
        ("wind.speed_m_s=0", "wind.speed_m_s = 0"),
        ("wing.colour=1", "colour"),
        ("compare.scale.force_z=nan", "compare.scale.force_z = nan: allowed is a finite number"),
        ("compare.scale.force_z=1e300", "compare.scale.force_z = 1e300: allowed is a finite number"),
        ("compare.scale.force_z=0", "compare.scale.force_z = 0: allowed is 1e-9 to 1e9, of either sign"),
        ("compare.scale.force_z=-1e-300", "allowed is 1e-9 to 1e9, of either sign"),
        ("compare.scale.force_z=-1.1e9", "allowed is 1e-9 to 1e9, of either sign"),
        ("compare.scale.force_z=\"text\"", "compare.scale.force_z"),
        ("body.heave_m={table={file=\"a.csv\",column=\"h\"}}", "no such file"),
    ] {
        let message = refuse(text);
        assert!(message.contains(part), "{text}: {message}");
    }
}

/// Largest change of the force from one step to the next over the last cycle, and the largest force, N.
fn jump_and_size(run: &TetherRun, steps: usize) -> (f64, f64) {
    let axes = ["force_x", "force_y", "force_z"].map(|name| run.loads.values(name).unwrap());
    let rows = run.loads.rows() - steps - 1..run.loads.rows();
    let norm = |d: [f64; 3]| d.iter().map(|v| v * v).sum::<f64>().sqrt();
    let jump = |i: usize| norm(std::array::from_fn(|k| axes[k][i + 1] - axes[k][i]));
    let size = |i: usize| norm(std::array::from_fn(|k| axes[k][i]));
    ((rows.start..rows.end - 1).map(jump).fold(0.0, f64::max), rows.map(size).fold(0.0, f64::max))
}

/// Still air, law `stall`: both lags of an outer strip change sign together while it moves
/// broadside on, which must not read as attached flow.
#[test]
fn a_strip_broadside_on_stays_separated_while_its_lags_change_sign() {
    let overrides = [
        "aero.law=stall",
        "wind.speed_m_s=0",
        "reference.speed_m_s=1",
        "aero.full.regularisation_m_s=0.1",
        "wing.hinges[0].angle_deg={fourier={sin=[40]}}",
        "wing.hinges[1].angle_deg={fourier={mean=-51,cos=[-51]}}",
        "time.cycles=2",
        "time.steps_per_cycle=1600",
    ];
    let (jump, size) = jump_and_size(&run("flap_fold", &overrides), 1600);
    assert!(jump < 0.02 * size, "{jump} of {size}");
}

/// Over drawn winds and folds: the largest change from step to step is halved with the step.
#[test]
fn any_wind_and_fold_gives_finite_forces_that_are_continuous_in_time() {
    let mut random = Random::new(1);
    for _ in 0..12 {
        let speed = [0.0, 0.3, 1.5, 6.0][random.bits() as usize % 4];
        let incidence = random.between(-180.0, 180.0);
        let sideslip = random.between(-180.0, 180.0);
        let (flap, fold) = (random.between(0.0, 60.0), random.between(0.0, 55.0));
        let law = ["linear", "stall"][random.bits() as usize % 2];
        let preset = PRESETS[random.bits() as usize % PRESETS.len()];
        let regularisation = [0.02, 0.1][random.bits() as usize % 2];
        let at = |steps: usize| {
            let overrides = [
                format!("aero.preset={preset}"),
                format!("aero.law={law}"),
                format!("wind.speed_m_s={speed:?}"),
                format!("wind.incidence_deg={incidence:?}"),
                format!("wind.sideslip_deg={sideslip:?}"),
                format!("wing.hinges[0].angle_deg={{fourier={{sin=[{flap:?}]}}}}"),
                format!("wing.hinges[1].angle_deg={{fourier={{mean=-{fold:?},cos=[-{fold:?}]}}}}"),
                "reference.speed_m_s=1.0".into(),
                format!("aero.{preset}.regularisation_m_s={regularisation:?}"),
                "time.cycles=2".into(),
                format!("time.steps_per_cycle={steps}"),
            ];
            let overrides: Vec<&str> = overrides.iter().map(String::as_str).collect();
            (jump_and_size(&run("flap_fold", &overrides), steps), overrides.join(" "))
        };
        let (((coarse, size), drawn), ((fine, _), _)) = (at(800), at(1600));
        assert!(coarse.is_finite() && size.is_finite(), "{drawn}");
        assert!(fine <= 0.75 * coarse + 1e-6 * size + 1e-12, "{coarse} {fine} of {size}: {drawn}");
    }
}

/// Over a ground a wing lifts more the nearer it is, and one that dips through it is told; what would not feel it is refused.
#[test]
fn a_tethered_wing_feels_the_ground() {
    let level = "wind.incidence_deg=0.0";
    let over = |height: &str| {
        let ground = format!("wind.ground_m={height}");
        let case = case("flap_f1", &[level, "body.nose_up_deg.constant=5.0", "time.cycles=2", &ground]);
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let verdict = case.summary(&run, None, None).verdict;
        let judged = verdict.judged.iter().find(|judged| judged.id == "tether.ground_distance_m").unwrap();
        let reason = verdict.reason.unwrap_or_default();
        let outside = reason.contains("tether.ground_distance_m");
        let low = verdict.judged.iter().find(|judged| judged.id == "tether.ground_chords").unwrap();
        assert_eq!(low.met, low.value.unwrap() >= 0.25);
        assert_eq!(low.met, !reason.contains("tether.ground_chords"));
        assert_eq!(judged.met, !outside);
        (mean(&run, "force_wind_lift"), judged.met)
    };
    let free =
        mean(&run("flap_f1", &[level, "body.nose_up_deg.constant=5.0", "time.cycles=2"]), "force_wind_lift");
    let [(near, ok), (higher, _), (far, _), (_, through)] = ["-0.06", "-0.12", "-1e4", "-0.01"].map(over);
    assert!(near > 1.02 * higher && higher > 1.02 * free, "{near} {higher} {free}");
    assert!((far / free - 1.0).abs() < 1e-6, "{far} {free}");
    assert!(ok && !through);
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases");
    for (file, keys) in [
        ("flap_f1", ["wind.ground_m=-1.0", "wind.density_kg_m3=1.0"]),
        ("plunge", ["wind.ground_m=-1.0", "aero.preset=paper"]),
        ("plunge", ["wind.ground_m=nan", level]),
        ("pazy", ["wind.ground_m=-1.0", level]),
    ] {
        let none = |_: &std::path::Path| Err::<Record, String>("no table".into());
        let keys = keys.map(String::from);
        let error = TetherCase::load(&path.join(file).with_extension("toml"), &keys, &none).err();
        let error = error.map(|error| error.to_string());
        assert!(
            error.as_ref().is_some_and(|error| error.contains("wind.ground_m")),
            "{file} {keys:?}: {error:?}"
        );
    }
}

#[test]
fn a_preset_that_lacks_a_term_of_the_strips_says_so() {
    let warned = |preset: &str, key: &str| {
        let set = [format!("aero.preset={preset}"), format!("aero.full.{key}")];
        let case = case("flap_f2", &set.each_ref().map(String::as_str));
        let run = case.tether.run(|_| ControlFlow::Continue(()));
        let summary = case.summary(&run, None, None);
        let found = summary.verdict.warnings.into_iter().find(|warning| warning.id == "aero.unheard");
        found.map(|warning| warning.text)
    };
    for key in ["turning_impulse", "edge_suction", "side_edges"] {
        let text = warned("paper", &format!("{key}=true")).unwrap();
        assert!(text.contains(&format!("aero.full.{key} = true")) && text.contains("`paper`"), "{text}");
        assert_eq!(warned("full", &format!("{key}=true")), None);
        let not = warned("paper", &format!("{key}=false"));
        assert_eq!(not.is_some(), key != "side_edges", "{not:?}");
    }
}

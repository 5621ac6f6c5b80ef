//! Class 3: what is not finite, not judged or not resolved is said; every number has a range.

use serde_json::Value;

use super::case::{Case, Judged, refused};
use super::place::Place;
use super::runs::{GLIDE, HOLD};

const TURN: &str = "{root}/scenarios/banking_turn.toml";
const STEP: &str = "{root}/cases/step.toml";
const STAND: &str = "{root}/cases/aerobat_stand.toml";
const FOLD: &str = "{root}/cases/flap_fold.toml";
const FLAP: &str = "{root}/cases/flap_f1.toml";
const GAIT: &str = "{root}/scenarios/least_power_gait.toml";
const BANK: &str = "{root}/rigs/runs/roll15_speed08.toml";

/// Numbers out of their range: what they are called, the words of the command, the override.
const RANGES: [(&str, &[&str], &str); 35] = [
    ("clearance", &["rig", "plan", BANK], "rig.clearance_m=-1"),
    ("clearance_simulated", &["rig", "simulate", BANK], "rig.clearance_m=-1e-9"),
    ("singularity", &["rig", "plan", BANK], "rig.singularity_margin=-1"),
    ("table", &["rig", "plan", BANK], "rig.table_m=1e9"),
    ("half_span", &["rig", "plan", BANK], "rig.envelope.half_span_m=0"),
    ("half_span_negative", &["rig", "plan", BANK], "rig.envelope.half_span_m=-0.2"),
    ("envelope_front", &["rig", "plan", BANK], "rig.envelope.front_m=-1"),
    ("envelope_low", &["rig", "plan", BANK], "rig.envelope.low_rad=9"),
    ("turn_roll", &["rig", "plan", BANK], "turn.roll_deg=1e300"),
    ("turn_roll_90", &["rig", "plan", BANK], "turn.roll_deg=90"),
    ("turn_pitch", &["rig", "plan", BANK], "turn.pitch_deg=1e9"),
    ("turn_speed", &["rig", "plan", BANK], "turn.speed_m_s=-1"),
    ("turn_radius", &["rig", "plan", BANK], "turn.radius_m=0"),
    ("mount_mass", &["rig", "plan", BANK], "rig.mount.link.mass_kg=-1"),
    ("frequency", &["rig", "simulate", "hold.toml"], "frequency_hz=-1"),
    ("noise", &["rig", "simulate", "hold.toml"], "rig.cell.noise_steps=-1"),
    ("roll", &["fly", TURN], "manoeuvre.roll_deg=1e300"),
    ("roll_12", &["fly", TURN], "manoeuvre.roll_deg=1e12"),
    ("yaw_rate", &["fly", TURN], "manoeuvre.yaw_rate_rad_s=1e9"),
    ("period", &["fly", TURN], "controller.period_s=0"),
    ("weight", &["fly", TURN], "controller.weights.roll=-1"),
    ("goal", &["fly", TURN], "goal.roll_within_deg=-1"),
    ("settle", &["fly", TURN], "goal.settle_s=-1"),
    ("density", &["fly", "glide.toml"], "air.density_kg_m3=0"),
    ("stall_angle", &["fly", "glide.toml"], "aero.stall_angle_deg=-5"),
    ("gust", &["fly", "glide.toml"], "air.gust_m_s=-1"),
    ("slope", &["fly", "glide.toml"], "aero.lift_slope_per_rad=2"),
    ("zero_lift", &["fly", "glide.toml"], "aero.zero_lift_angle_deg=31"),
    ("suction", &["fly", "glide.toml"], "aero.critical_suction=1"),
    ("body_mass", &["fly", TURN], "robot.body.mass_kg=0"),
    ("inertia", &["fly", TURN], "robot.body.inertia_kg_m2[1]=-1e-9"),
    ("regulator_frequency", &["fly", TURN], "robot.structure.frequency_hz=0"),
    ("mismatch", &["fly", TURN], "mismatch.mass=0"),
    ("steps", &["tether", STEP], "time.steps_per_cycle=2"),
    ("frequency_zero", &["tether", STEP], "time.frequency_hz=0"),
];

/// The cases.
pub fn cases() -> Vec<Case> {
    let files = [("glide.toml", GLIDE), ("hold.toml", HOLD)];
    let range = |(name, words, set): &(&str, &[&str], &str)| {
        let arguments: Vec<&str> = words.iter().copied().chain(["--set", set]).collect();
        let key = set.split_once('=').map_or("", |(key, _)| key);
        refused(3, &format!("range_{name}"), &files, &arguments, &[key, "allowed is"])
    };
    let mut all: Vec<Case> = RANGES.iter().map(range).collect();
    all.extend(statuses());
    all
}

/// A run into `a`, whose summary `judge` looks at.
fn summed(
    name: &str,
    words: &'static [&'static str],
    code: i32,
    judge: fn(&Value) -> Result<(), &'static str>,
) -> Case {
    Case::new(3, name, move |place| {
        place.write("glide.toml", GLIDE)?;
        let words: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
        place.run(&words)?.exits(code)?;
        let summary = summary(place)?;
        judge(&summary).map_err(|what| format!("{what}: {}", brief(&summary)))
    })
}

fn summary(place: &Place) -> Result<Value, String> {
    serde_json::from_str(&place.read("a/summary.json")?).map_err(|error| error.to_string())
}

fn brief(summary: &Value) -> String {
    let of = |key: &str| format!("{key} {}", summary[key]);
    ["status", "reason", "warnings", "step_error_m", "step_change", "judged"].map(of).join(", ")
}

fn warns(summary: &Value, word: &str) -> bool {
    summary["warnings"]
        .as_array()
        .is_some_and(|all| all.iter().any(|w| w.as_str().is_some_and(|w| w.contains(word))))
}

fn when(holds: bool, what: &'static str) -> Result<(), &'static str> {
    if holds { Ok(()) } else { Err(what) }
}

fn goal(place: &Place, more: &str) -> Judged {
    place.write(
        "goal.toml",
        &format!("{GLIDE}goal = {{ settle_s = 0.0, roll_within_deg = 5.0, pitch_within_deg = 9.0 }}\n{more}"),
    )
}

fn statuses() -> Vec<Case> {
    vec![
        summed(
            "coarse_mesh_is_said",
            &["plan", GAIT, "--set", "plan.least_power.intervals=4", "--set", "plan.least_power.meshes=1"],
            3,
            |s| when(s["solver"].as_str().is_some_and(|text| text.starts_with("mesh too coarse")), "solver"),
        ),
        refused(
            3,
            "key_beside_a_choice",
            &[],
            &["plan", GAIT, "--set", "plan.intervals=3"],
            &["--set plan.intervals=3", "unknown key plan.intervals", "roll_in, least_power"],
        ),
        summed("short_flight_is_not_judged", &["fly", TURN, "--set", "flight.duration_s=0.1"], 0, |s| {
            when(s["status"] == "not_judged" && s["judged"].as_array().is_some_and(Vec::is_empty), "status")
        }),
        Case::new(3, "goal_without_manoeuvre_is_not_judged", |place| {
            goal(place, "")?;
            place.run(&["fly", "goal.toml", "--quiet", "--out", "a"])?.exits(0)?;
            let s = summary(place)?;
            when(s["status"] == "not_judged" && warns(&s, "manoeuvre"), "status")
                .map_err(|e| format!("{e}: {}", brief(&s)))
        }),
        Case::new(3, "judged_goal_is_named", |place| {
            goal(
                place,
                "manoeuvre = { turn_start_s = 9.0, roll_deg = 0.0, pitch_deg = 5.0, yaw_rate_rad_s = 0.0 }\n",
            )?;
            place.run(&["fly", "goal.toml", "--quiet", "--out", "a"])?.exits(0)?;
            let s = summary(place)?;
            let named = s["judged"].as_array().is_some_and(|all| all.len() == 2);
            when(s["status"] == "ok" && named, "judged").map_err(|e| format!("{e}: {}", brief(&s)))
        }),
        Case::new(3, "goals_beside_the_attitude", |place| {
            let goals = [
                ("altitude_within_m = 1e-9", "altitude", 3, "off_target"),
                ("speed_between_m_s = [9.0, 10.0]", "speed", 3, "off_target"),
                ("speed_between_m_s = [1.0, 10.0]\ngoal.altitude_within_m = 1.0", "", 0, "not_judged"),
                ("clearance_m = 9.0", "clearance", 3, "off_target"),
            ];
            for (i, (text, word, code, status)) in goals.into_iter().enumerate() {
                let goal = "goal.settle_s = 0.0\ngoal.roll_within_deg = 5.0\ngoal.pitch_within_deg = 9.0";
                place.write("goal.toml", &format!("{GLIDE}{goal}\ngoal.{text}\n"))?;
                let out = format!("a{i}");
                place.run(&["fly", "goal.toml", "--quiet", "--out", &out])?.exits(code)?.says(&[word])?;
                let s = place.read(&format!("{out}/summary.json"))?;
                if !s.contains(status) {
                    return Err(format!("{text}: {s}"));
                }
            }
            Ok(())
        }),
        summed("no_goal_is_ok", &["fly", "glide.toml"], 0, |s| when(s["status"] == "ok", "status")),
        summed(
            "step_too_coarse",
            &[
                "fly",
                "{root}/scenarios/motor_flapper.toml",
                "--set",
                "flight.step_s=5e-3",
                "--set",
                "flight.record_every_s=1e-2",
            ],
            0,
            |s| when(warns(s, "flight.step_s"), "no caution"),
        )
        .long(),
        summed("step_fine_enough", &["fly", "glide.toml", "--set", "flight.duration_s=1"], 0, |s| {
            when(
                !warns(s, "flight.step_s") && s["step_error_m"].as_f64().is_some_and(|e| e < 1e-3),
                "caution",
            )
        })
        .long(),
        summed("turn_step_fine_enough", &["fly", TURN, "--set", "flight.duration_s=0.5"], 0, |s| {
            when(!warns(s, "flight.step_s"), "caution")
        })
        .long(),
        summed("tether_10_steps", &["tether", STAND, "--set", "time.steps_per_cycle=10"], 3, |s| {
            when(s["status"] == "not_resolved" && warns(s, "time.steps_per_cycle"), "status")
        }),
        summed("tether_8_steps", &["tether", FOLD, "--set", "time.steps_per_cycle=8"], 3, |s| {
            when(s["status"] == "not_resolved" && warns(s, "time.steps_per_cycle"), "status")
        }),
        summed("tether_20_steps", &["tether", STAND, "--set", "time.steps_per_cycle=20"], 0, |s| {
            when(
                s["status"] == "ok" && s["step_change"].as_f64().is_some_and(|change| change < 0.02),
                "status",
            )
        }),
        summed("tether_enough_steps", &["tether", FLAP], 0, |s| {
            when(!warns(s, "time.steps_per_cycle"), "caution")
        }),
        summed("tether_step_enough_steps", &["tether", STEP], 0, |s| {
            when(!warns(s, "time.steps_per_cycle"), "caution")
        }),
        summed(
            "late_updates_count",
            &["fly", TURN, "--set", "flight.duration_s=0.05", "--set", "controller.iterations=100"],
            0,
            |s| {
                let c = &s["controller"];
                let slow = c["median_us"]
                    .as_f64()
                    .is_some_and(|us| us > 1e6 * c["period_s"].as_f64().unwrap_or(0.0));
                when(!slow || c["late"].as_u64() > Some(0), "late = 0 beside slow updates")
            },
        ),
        summed(
            "not_finite_is_a_status",
            &["fly", "glide.toml", "--set", "robot.body.drag_area_m2=[1e6, 1e6, 1e6]"],
            3,
            |s| when(s["status"] == "not_finite" || s["status"] == "fault", "status"),
        ),
        summed("tether_not_finite", &["tether", STEP, "--set", "time.frequency_hz=1e-300"], 3, |s| {
            when(s["status"].as_str().is_some_and(|status| status.starts_with("not_finite")), "status")
        }),
    ]
}

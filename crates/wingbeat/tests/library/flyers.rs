//! Robots of many kinds, flown from their files alone.

mod flown;
mod glider;

use flown::{Flown, fly, scenario, shipped};
use std::f64::consts::FRAC_PI_2;
use wingbeat::plant::Plant;
use wingbeat::scenario::Document;

/// Two pairs in antiphase: what one lifts the other lowers, so that the robot nods where pairs in phase heave.
#[test]
fn two_pairs_of_wings_in_antiphase_nod_more_and_heave_less() {
    let antiphase = fly(shipped("four_wings", &[]));
    let in_phase = fly(shipped("four_wings", &["robot.links[1].driven.lag_rad=0.0".into()]));
    let (fore, hind) = (antiphase.column("fore_left"), antiphase.column("hind_left"));
    assert!(fore.iter().zip(hind).all(|(f, h)| (f + h - 0.3).abs() < 1e-12), "the pairs beat in antiphase");
    let cycle = |name: &str| [&antiphase, &in_phase].map(|flown| flown.ripple(name, 1.0 / 8.0));
    let (heave, nod) = (cycle("com_z"), cycle("pitch"));
    assert!(heave[0] < 0.8 * heave[1], "heave within a cycle {heave:?} m");
    assert!(nod[0] > 1.5 * nod[1], "pitch within a cycle {nod:?} rad");
    for flown in [&antiphase, &in_phase] {
        flown.assert_symmetric();
        flown.assert_momentum_balance(1.0, 6.0);
    }
    let share = antiphase.share_of_weight(2.0, 6.0);
    assert!((share - 1.0).abs() < 0.1, "the wings carry {share} of the weight");
    let pitch = antiphase.column("pitch");
    assert!(pitch.iter().all(|p| p.abs() < 0.6), "the tail holds the attitude");
}

/// A film as thick as a hand bends as a plate and outweighs the link whose mass holds its own; wings of film fly as shipped, and turn.
#[test]
fn a_membrane_is_as_thin_and_light_as_one() {
    let thick = ["robot.surfaces[0].membrane.thickness_m=0.1".into(), "flight.duration_s=0.1".into()];
    let run = shipped("sail_glide", &thick).fly(|_| std::ops::ControlFlow::Continue(())).unwrap();
    let told = run.summary.reason.clone().unwrap_or_default();
    for limit in ["membrane.mass_fraction", "membrane.bending_outside_fraction"] {
        assert!(told.contains(limit), "{limit}: {told}");
    }
    // Its film outweighs the body that holds it: what it moves then need not be integrable.
    use wingbeat::judge::Status;
    assert!(matches!(run.summary.status, Status::Outside | Status::Failed), "{:?}", run.summary.status);
    // One that follows its load later than the flight lasts, where nothing flaps; and one at twice its length.
    for (set, limit) in
        [("damping_s=1.0", "membrane.lag_outside_rad"), ("prestrain=1.0", "membrane.strain_outside")]
    {
        let set = [format!("robot.surfaces[0].membrane.{set}"), "flight.duration_s=0.5".into()];
        let run = shipped("sail_glide", &set).fly(|_| std::ops::ControlFlow::Continue(())).unwrap();
        assert_eq!(run.summary.status, Status::Outside, "{set:?}");
        let told = run.summary.reason.clone().unwrap_or_default();
        assert!(told.contains(limit), "{limit}: {told}");
    }
    let turn = "controller.orbit.legs=[{ start_s = 0.1, duration_s = 0.2, bank_deg = 15.0 }]";
    let flown = fly(shipped("membrane_bank15", &[turn.into(), "flight.duration_s=0.4".into()]));
    let skin = flown.run.summary.membrane.unwrap();
    assert!(
        skin.camber_max > 0.005 && skin.bending_fraction < 1e-4 && skin.slack_fraction == 0.0,
        "{skin:?}"
    );
    let seen = flown.scenario.robot().membrane_over_link().unwrap();
    assert!(seen > 0.01 && seen < 0.5, "{seen}");
}

/// The part of its weight that is left out would rule a flap without a spring.
#[test]
fn a_flap_without_a_spring_is_outside() {
    use wingbeat::judge::Status;
    let free = ["robot.surfaces[0].flap.stiffness_n_rad=0".into(), "flight.duration_s=0.02".into()];
    let run = shipped("flap_glide", &free).fly(|_| std::ops::ControlFlow::Continue(())).unwrap();
    let told = run.summary.reason.clone().unwrap_or_default();
    assert!(run.summary.status == Status::Outside && told.contains("flap.weight_outside_fraction"), "{told}");
}

/// A turn on wings that bend and twist, about its orbits and by a plan whose intervals resolve the bending.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn wings_that_bend_turn() {
    let plan = [
        "flight.duration_s=4.0",
        "controller.orbit.predictive.intervals=5",
        "controller.orbit.predictive.interval_s=0.004",
        "controller.orbit.predictive.terminal=\"regulator\"",
    ];
    for set in [&plan[..1], &plan[..]] {
        let set: Vec<String> = set.iter().map(|text| (*text).into()).collect();
        let flown = fly(shipped("soft_bank15", &set));
        let summary = &flown.run.summary;
        assert!(summary.height_max_error_m.unwrap() < 0.005 && summary.roll_rms_error_deg.unwrap() < 1.0);
        assert!(summary.least_clearance_m.unwrap() > 0.01);
        let bend = Flown::range(flown.column("coordinate_twist_bend1_left"));
        assert!(bend > 0.02, "the wings bend by {bend} rad");
    }
}

/// Wings of arm, hand and feathered tip, and a tail.
fn three_links(feather_phase: f64) -> String {
    format!(
        r#"
name = "three_links"
[body]
mass_kg = 0.024
inertia_kg_m2 = [1.5e-5, 1.2e-4, 1.3e-4]
drag_area_m2 = [0.0005, 0.002, 0.002]
[gait.fourier]
frequency_hz = 6.0
[[links]]
name = "arm"
side = "mirrored"
origin_m = [0.01, 0.02, 0.0]
mass_kg = 0.001
com_m = [-0.01, 0.04, 0.0]
inertia_kg_m2 = [5e-7, 4e-7, 9e-7]
driven = {{ mean_rad = 0.1, harmonics = [{{ amplitude_rad = 0.5, phase_rad = 0.0 }}] }}
[[links]]
name = "hand"
side = "mirrored"
parent = "arm"
origin_m = [0.0, 0.08, 0.0]
mass_kg = 0.001
com_m = [-0.01, 0.05, 0.0]
inertia_kg_m2 = [5e-7, 4e-7, 9e-7]
driven = {{ mean_rad = -0.1, harmonics = [{{ amplitude_rad = 0.25, phase_rad = 0.0 }}], lag_rad = 0.8 }}
[[links]]
name = "feather"
side = "mirrored"
parent = "hand"
origin_m = [0.0, 0.10, 0.0]
axis = [0.0, -1.0, 0.0]
mass_kg = 0.001
com_m = [-0.01, 0.05, 0.0]
inertia_kg_m2 = [5e-7, 4e-7, 9e-7]
driven = {{ harmonics = [{{ amplitude_rad = 0.3, phase_rad = {feather_phase:?} }}] }}
[[links]]
name = "tail"
origin_m = [-0.22, 0.0, 0.0]
orientation_deg = [0.0, 5.0, 0.0]
[[surfaces]]
name = "wing"
cd0 = 0.03
cd90 = 2.0
planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.025, trailing_edge_m = -0.075 }},
  {{ arc_m = 0.30, leading_edge_m = 0.025, trailing_edge_m = -0.055 }},
]
panels = [
  {{ link = "body", origin_m = [0.01, 0.0, 0.0] }},
  {{ link = "arm", from_arc_m = 0.02 }},
  {{ link = "hand", from_arc_m = 0.10 }},
  {{ link = "feather", from_arc_m = 0.20 }},
]
[[surfaces]]
name = "tail"
cd0 = 0.03
cd90 = 2.0
strips = 6
planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.015, trailing_edge_m = -0.045 }},
  {{ arc_m = 0.11, leading_edge_m = 0.015, trailing_edge_m = -0.045 }},
]
panels = [{{ link = "tail" }}]
"#
    )
}

const CRUISE: &str = r#"
[air]
density_kg_m3 = 1.225
wind_m_s = [0.0, 0.0, 0.0]
[aero]
preset = "full"
law = "stall"
[start]
velocity_m_s = [4.0, 0.0, 0.0]
roll_deg = 0.0
nose_up_deg = 5.0
yaw_deg = 0.0
phase_rad = 0.0
[flight]
duration_s = 2.0
step_s = 2e-4
record_every_s = 2e-3
"#;

/// A tip that turns nose down in the downstroke drives the robot ahead; one that does the reverse brakes it.
#[test]
fn wings_of_three_links_fly_and_their_tips_drive() {
    let long = ["flight.duration_s=4.0".to_string()];
    let [driving, braking] = [("driving", -FRAC_PI_2), ("braking", FRAC_PI_2)]
        .map(|(name, phase)| fly(scenario(name, &three_links(phase), CRUISE, &long)));
    for flown in [&driving, &braking] {
        flown.assert_symmetric();
        flown.assert_momentum_balance(0.5, 2.0);
    }
    let share = driving.share_of_weight(1.0, 4.0);
    assert!((share - 1.0).abs() < 0.15, "the wings carry {share} of the weight");
    let gain = [&driving, &braking].map(|flown| flown.energy_height_gain(1.0, 4.0));
    assert!(gain[0] > gain[1] + 1.0, "gain of height and speed {gain:?} m");
    let [arm, hand, feather] =
        ["arm_left", "hand_left", "feather_left"].map(|joint| Flown::range(driving.column(joint)));
    assert!((arm - 1.0).abs() < 1e-3 && (hand - 0.5).abs() < 1e-3 && (feather - 0.6).abs() < 1e-3);
}

/// Two wings on links of their own, `left` and `right` m long, each beating about its root.
fn differing(left: f64, right: f64) -> String {
    let wing = |name: &str, side: &str, length: f64, sign: f64| {
        format!(
            r#"
[[links]]
name = "{name}_arm"
origin_m = [0.0, {y:?}, 0.0]
axis = [{sign:?}, 0.0, 0.0]
mass_kg = {mass:e}
com_m = [0.0, {com:e}, 0.0]
inertia_kg_m2 = [1e-6, 2e-7, 1.1e-6]
driven = {{ mean_rad = 0.1, harmonics = [{{ amplitude_rad = 0.2, phase_rad = 0.0 }}] }}
[[surfaces]]
name = "{name}"
span = "{side}"
cd0 = 0.03
cd90 = 2.0
strips = 8
planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.02, trailing_edge_m = -0.06 }},
  {{ arc_m = {length:?}, leading_edge_m = 0.02, trailing_edge_m = -0.06 }},
]
panels = [{{ link = "{name}_arm", direction = [0.0, {sign:?}, 0.0] }}]
"#,
            y = sign * 0.01,
            mass = 0.005 * length,
            com = sign * 0.5 * length,
        )
    };
    format!(
        r#"
name = "differing"
[body]
mass_kg = 0.03
inertia_kg_m2 = [6e-5, 1.2e-4, 1.5e-4]
[gait.fourier]
frequency_hz = 6.0
[[links]]
name = "tail"
origin_m = [-0.22, 0.0, 0.0]
orientation_deg = [0.0, 5.0, 0.0]
[[surfaces]]
name = "tail"
cd0 = 0.03
cd90 = 2.0
strips = 6
planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.015, trailing_edge_m = -0.045 }},
  {{ arc_m = 0.11, leading_edge_m = 0.015, trailing_edge_m = -0.045 }},
]
panels = [{{ link = "tail" }}]
{}{}"#,
        wing("port", "left", left, 1.0),
        wing("starboard", "right", right, -1.0)
    )
}

/// The longer wing rises; equal ones keep level, and images of one another roll to opposite sides.
#[test]
fn wings_that_differ_roll_towards_the_shorter() {
    let short = ["flight.duration_s=0.4".to_string()];
    let flown =
        |name: &str, left: f64, right: f64| fly(scenario(name, &differing(left, right), CRUISE, &short));
    let (equal, long_left, long_right) =
        (flown("equal", 0.3, 0.3), flown("long_left", 0.32, 0.28), flown("long_right", 0.28, 0.32));
    equal.assert_symmetric();
    let last = |flown: &Flown, name: &str| *flown.column(name).last().unwrap();
    let roll = last(&long_left, "roll");
    assert!(roll > 0.1, "right wing down: {roll} rad");
    for (name, sign) in [("roll", -1.0), ("pitch", 1.0), ("yaw", -1.0), ("p_WB_y", -1.0), ("p_WB_z", 1.0)] {
        let (a, b) = (last(&long_left, name), last(&long_right, name));
        assert!((a - sign * b).abs() < 1e-9, "{name}: {a} {b}");
    }
    for flown in [&equal, &long_left] {
        flown.assert_momentum_balance(0.05, 0.39);
    }
}

/// The ends of panels name the columns of a record: a surface called as the side of another is refused.
#[test]
fn surfaces_whose_columns_would_clash_are_refused_by_key() {
    let text = differing(0.3, 0.3).replace("name = \"port\"", "name = \"left\"");
    let error = flown::refused("clash", &text, CRUISE);
    assert!(error.contains("robot.surfaces[1].name = left") && error.contains("left_tip"), "{error}");
}

/// The Aerobat of the paper held by hinges of growing stiffness: the stiffest flies as the rigid one, and
/// stiff hinges turn in proportion to their flexibility.
#[test]
fn an_elastic_twist_hinge_gives_way_under_the_air() {
    let preset = ["aero.preset=paper".into(), "aero.law=linear".into()];
    let start = ["start.velocity_m_s=[1.5, 0.0, 0.0]", "start.nose_up_deg=15.0", "flight.duration_s=0.5"];
    let common = || preset.iter().cloned().chain(start.map(String::from));
    let file = |name: &str| {
        let robot = Document::file(&flown::root().join(format!("robots/{name}.toml"))).unwrap();
        robot.resolved().unwrap()
    };
    let elastic = |stiffness: f64| {
        let stiff = [
            format!("robot.links[2].elastic.stiffness={stiffness}"),
            format!("robot.links[2].elastic.damping={}", 2e-2 * (stiffness * 6.3e-6_f64).sqrt()),
        ];
        let overrides: Vec<String> = common().chain(stiff).collect();
        fly(scenario(&format!("hinge_{stiffness}"), &file("aerobat_elastic"), CRUISE, &overrides))
    };
    let overrides: Vec<String> = common().collect();
    let rigid = fly(scenario("rigid", &file("aerobat_paper"), CRUISE, &overrides));
    let (soft, stiff, stiffer) = (elastic(0.05), elastic(2.0), elastic(4.0));
    let twist = [&soft, &stiff, &stiffer].map(|flown| Flown::range(flown.column("twist_left")));
    assert!(twist[0] > 0.05 && twist[0] < 1.5, "the hinge of 0.05 N m/rad turns by {} rad", twist[0]);
    assert!((twist[1] / twist[2] - 2.0).abs() < 0.2, "flexibility sets the twist: {twist:?}");
    let distance = |flown: &Flown| {
        let off = |name: &str| flown.column(name).last().unwrap() - rigid.column(name).last().unwrap();
        ["p_WB_x", "p_WB_y", "p_WB_z"].map(off).iter().map(|d| d * d).sum::<f64>().sqrt()
    };
    let away = [&soft, &stiff, &stiffer].map(distance);
    assert!(
        away[2] < 0.6 * away[1] && away[1] < away[0] && away[2] < 0.02,
        "from the rigid flight {away:?} m"
    );
    for flown in [&soft, &stiffer] {
        flown.assert_symmetric();
        flown.assert_momentum_balance(0.05, 0.45);
    }
}

/// A surface has its own model and law; what it does not say the scenario says.
#[test]
fn a_tail_flies_another_model_and_law_than_the_wing() {
    let asked = ["flight.duration_s=0.2", "robot.surfaces[1].preset=paper", "robot.surfaces[1].law=lev"];
    let flown = fly(shipped("glider", &asked.map(String::from)));
    assert_eq!(flown.run.summary.aero_preset, "wing full, tail paper, fin full");
    assert_eq!(flown.run.summary.lift_law, "wing linear, tail lev, fin linear");
    let states: Vec<&str> = flown.scenario.robot().states().iter().map(|c| c.name.as_str()).collect();
    assert!(states.contains(&"tail_vortex_0") && states.contains(&"tail_circulation_0"), "{states:?}");
    assert!(states.contains(&"wash_lag1_0") && !states.contains(&"vortex_0"), "{states:?}");
}

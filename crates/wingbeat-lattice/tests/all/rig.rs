//! Runs on the rig in the lattice.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use wingbeat::math::{Mat3, Vec3};
use wingbeat::rig::Outcome;
use wingbeat::scenario::{Document, RigRun, TetherCase};
use wingbeat_lattice::{FlappingWing, Lattice, LatticeSettings, Panels, Scene, Spacing, doors};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The run on the bench with `set`.
fn bench(set: &[String]) -> Result<RigRun, String> {
    let overrides = set.iter().map(String::as_str).collect::<Vec<_>>();
    let document = Document::file(&root().join("rigs/runs/bench.toml")).map_err(|error| error.to_string())?;
    let document = overrides.iter().fold(document, |document, set| document.set(*set));
    let run = RigRun::new(document, &|_, _| None).map_err(|error| error.to_string())?;
    Ok(run.through(&doors()))
}

fn simulated(run: &RigRun) -> Outcome {
    run.simulate(&run.carrier(None), 0, |_| {}).unwrap().unwrap_or_else(|fault| panic!("{fault}"))
}

/// Rate of the cell, Hz, its samples in a step of the lattice, and steps of a stroke.
const RATE: f64 = 3500.0;
const EVERY: usize = 20;
const STEPS: usize = 50;
const FREQUENCY: f64 = RATE / (EVERY * STEPS) as f64;

fn lattice() -> [String; 3] {
    let step = EVERY as f64 / RATE;
    [
        format!("rig.cell.rate_hz={RATE:?}"),
        format!("lattice={{ step_s = {step:?}, core_chords = 0.02 }}"),
        "rig.rest_s=0.0".into(),
    ]
}

/// Aerobat's wing held at 15 deg in a wind, once on the rig and once as the case `aerobat_stand`.
#[test]
fn on_the_rig_the_lattice_bears_what_it_bears_in_a_case_of_the_same_motion() {
    let robot = root().join("robots/aerobat_paper.toml");
    let own = [
        format!("rig.robot={}", robot.display()),
        format!("frequency_hz={FREQUENCY:?}"),
        "rig.spin_up_s=0.0".into(),
        "rig.air.wind_m_s=[-0.8, 0.0, 0.0]".into(),
        "rig.aero={ preset = \"full\", law = \"linear\" }".into(),
        // Nothing but attached flow, and the gait of the case.
        "rig.robot.wing.cd0=0.0".into(),
        "rig.robot.wing.cd90=0.0".into(),
        "rig.robot.body.drag_area_m2=[0.0, 0.0, 0.0]".into(),
        "rig.robot.wing.planform_shift_m=-0.042".into(),
        "rig.robot.gait.fourier.elbow={ mean_rad = -0.65, harmonics = [{ amplitude_rad = -0.65, phase_rad = 3.9269908169872414 }] }"
            .into(),
        format!("hold={{ tilts_deg = [[0.0, -15.0]], each_s = {:?} }}", 2.0 / FREQUENCY),
    ];
    let run = bench(&[&own[..], &lattice()].concat()).unwrap();
    let outcome = simulated(&run);
    let coupling = outcome.coupling.unwrap();
    assert_eq!(coupling.steps, 2 * STEPS);
    let forces: Vec<&[f64]> =
        ["air_Fx", "air_Fy", "air_Fz"].iter().map(|name| outcome.record.values(name).unwrap()).collect();

    let case = Document::file(&root().join("cases/aerobat_stand.toml")).unwrap();
    let case =
        TetherCase::new(case.set("aero.law=linear"), &|_: &Path| Err("no tables here".into())).unwrap();
    let panels = Panels { chordwise: 4, spanwise: 24, spacing: Spacing::Lan };
    let scene = Scene::new(&FlappingWing::try_from(&case.tether).unwrap(), panels, false).unwrap();
    let planform = &run.spec.rig.robot.outlines().unwrap()[0].planform;
    let core = 0.02 * planform.area() / (2.0 * planform.half_span());
    let mut lattice = Lattice::new(scene, LatticeSettings::new(EVERY as f64 / RATE, core)).unwrap();
    let attitude = Mat3::from_roll_pitch_yaw(0.0, (-15.0_f64).to_radians(), 0.0);
    let (mut largest, mut apart) = (0.0_f64, 0.0_f64);
    for k in 0..=2 * STEPS {
        let force = attitude.transpose_mul(lattice.step().unwrap().joukowski.force);
        if k < STEPS {
            continue;
        }
        let here = Vec3(std::array::from_fn(|axis| forces[axis][k * EVERY]));
        (largest, apart) = (largest.max(force.norm()), apart.max((force - here).norm()));
    }
    // The wings of the rig are at rest at the first instant, those of the case are not.
    assert!(apart < 1e-4 * largest, "{apart} of {largest} N");
    let stalled = outcome.stalled.stalled();
    assert!(stalled > 0.5 && stalled < 1.0, "{stalled}");
}

/// A crank under a motor turns by what the lattice bears: the added mass of the models changes nothing.
#[test]
fn what_the_air_turns_is_found_together_with_the_lattice() {
    let robot = root().join("robots/motor_flapper.toml");
    let own = [
        format!("rig.robot={}", robot.display()),
        "rig.aero.law=linear".into(),
        "rig.aero.preset=full".into(),
        "hold.each_s=0.3".into(),
    ];
    let turned = |set: &str| {
        let run = bench(&[&own[..], &lattice(), &[set.into()]].concat()).unwrap();
        let outcome = simulated(&run);
        let coupling = outcome.coupling.unwrap();
        assert!(coupling.iterations > coupling.steps && coupling.most < 12, "{coupling:?}");
        outcome.record.values("phase").unwrap().to_vec()
    };
    let with = turned("rig.aero.added_mass=true");
    let without = turned("rig.aero.added_mass=false");
    let (end, last) = (with.last().unwrap() - with[0], without.last().unwrap() - without[0]);
    assert!(end > 0.1 * TAU && (last / end - 1.0).abs() < 2e-3, "{end} {last} rad");
}

#[test]
fn what_the_lattice_cannot_do_on_the_rig_is_refused() {
    let says = |message: String, words: &[&str]| {
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    };
    let brief = ["rig.rest_s=0.0", "hold.each_s=0.1", "rig.cell.rate_hz=3500.0"].map(String::from);
    let with = |set: &str| bench(&[&brief[..], &[set.into()]].concat());
    says(
        with("lattice.step_s=0.0005").map(drop).unwrap_err(),
        &["lattice.step_s", "whole number of samples"],
    );
    let none = with("lattice={ step_s = 0.004, spanwise = 0 }").map(drop).unwrap_err();
    says(none, &["lattice.spanwise", "1 to 400"]);
    let run = with("lattice.step_s=0.004").unwrap();
    let shut = RigRun::load(&root().join("rigs/runs/bench.toml"), &["lattice.step_s=0.004".into()]).unwrap();
    says(
        shut.simulate(&run.carrier(None), 0, |_| {}).map(drop).unwrap_err().to_string(),
        &["wingbeat_lattice::doors()"],
    );
    let long = [
        brief[0].clone(),
        brief[2].clone(),
        "hold.each_s=10.0".into(),
        "lattice={ step_s = 0.002, spanwise = 100 }".into(),
    ];
    let long = bench(&long).unwrap();
    says(
        long.simulate(&long.carrier(None), 0, |_| {}).map(drop).unwrap_err().to_string(),
        &["rings of the wake", "lattice.longest_age_s"],
    );
    let cambered = bench(
        &[&brief[..], &["lattice.step_s=0.004".into(), "rig.aero.zero_lift_angle_deg=-2.0".into()]].concat(),
    );
    let cambered = cambered.unwrap();
    says(
        cambered.simulate(&cambered.carrier(None), 0, |_| {}).map(drop).unwrap_err().to_string(),
        &["zero_lift_angle_deg", "the panels are flat"],
    );
}

#[test]
fn without_wind_and_at_rest_nothing_but_the_weight_is_borne() {
    let set = ["hold.each_s=0.1", "frequency_hz=0.0", "rig.air.wind_m_s=[0.0, 0.0, 0.0]"].map(String::from);
    let run = bench(&[&set[..], &lattice()].concat()).unwrap();
    let outcome = simulated(&run);
    for name in ["air_Fx", "air_Fy", "air_Fz", "air_Tx", "air_Ty", "air_Tz"] {
        assert!(outcome.record.values(name).unwrap().iter().all(|load| load.abs() < 1e-12), "{name}");
    }
}

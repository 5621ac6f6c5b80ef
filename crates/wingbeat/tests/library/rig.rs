//! A robot carried on the rig.

use std::f64::consts::TAU;
use std::path::Path;

use wingbeat::judge::{Status, Verdict};
use wingbeat::math::{GRAVITY, Jet, Mat3, Vec3};
use wingbeat::plant::Plant;
use wingbeat::robot::BodyMotion;
use wingbeat::scenario::RigRun;

#[test]
fn a_robot_at_rest_bears_its_weight_on_the_stand() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rigs/runs/roll15_speed08.toml");
    let run = RigRun::load(&file, &["rig.air.density_kg_m3=1e-30".into()]).unwrap();
    let attitude = Mat3::from_roll_pitch_yaw(0.3, -0.2, 1.0);
    let zero = Vec3::ZERO;
    let body =
        BodyMotion { attitude, velocity: zero, rate: zero, acceleration: zero, angular_acceleration: zero };
    let x = vec![0.0; run.robot.carried_states()];
    let u = vec![0.0; run.robot.inputs().len()];
    let loads = run.robot.carried_in_numbers(&Jet::default(), &body, &x, &u, &mut x.clone()).unwrap();
    let weight = Vec3([0.0, 0.0, -GRAVITY * run.robot.mass()]);
    assert!((attitude * loads.total().force - weight).norm() < 1e-12);
}

/// A cell at 7 kHz takes 2.3 samples of a stroke at 3 kHz.
#[test]
fn a_gait_too_fast_for_the_cell_is_refused() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rigs/runs/roll15_speed08.toml");
    let at = |hz: f64| RigRun::load(&file, &[format!("frequency_hz={hz}")]).map(|_| ());
    let refused = at(3000.0).unwrap_err().to_string();
    assert!(refused.contains("frequency_hz = 3000: allowed is 0 to 350"), "{refused}");
    assert!(at(300.0).is_ok() && at(0.0).is_ok());
}

/// The motor is without voltage before the start, and turns the crank by torque and load after it.
#[test]
fn a_motor_turns_the_crank_on_the_rig() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let robot = root.join("robots/motor_flapper.toml");
    let brief = ["rig.cell.rate_hz=3500.0", "hold.each_s=2.0", "rig.rest_s=0.2"];
    let overrides: Vec<String> =
        brief.map(String::from).into_iter().chain([format!("rig.robot={}", robot.display())]).collect();
    let run = RigRun::load(&root.join("rigs/runs/bench.toml"), &overrides).unwrap();
    let carrier = run.carrier(None);
    let record = run.simulate(&carrier, 0, |_| {}).unwrap().unwrap().record;
    let [t, phase, rate, torque, shaft, electrical] =
        ["t", "phase", "crank_rate", "motor_torque", "motor_power", "electrical_power"]
            .map(|name| record.values(name).unwrap());
    let number = |name: &str| {
        let numbers = run.robot.named_numbers();
        numbers.iter().find(|(of, _)| of == name).map(|(_, value)| *value).unwrap()
    };
    let (gear, free) = (number("motor.gear_ratio"), number("motor.no_load_speed_rad_s"));
    for k in 0..t.len() {
        // Power of the shaft, and heat of the winding, never negative.
        assert!((shaft[k] - torque[k] * rate[k] * gear).abs() < 1e-12);
        assert!(t[k] > 0.0 || electrical[k] == 0.0, "no supply before the start");
        assert!(electrical[k] - shaft[k] > -1e-12, "at {} s", t[k]);
    }
    // The phase is the integral of the rate, by trapezoids.
    let turned: f64 = (1..t.len()).map(|k| 0.5 * (rate[k] + rate[k - 1]) * (t[k] - t[k - 1])).sum();
    assert!((turned - (phase[t.len() - 1] - phase[0])).abs() < 1e-4 * turned);
    // It settles at a speed of its own, below that without load, and not the gait's.
    let late = t.partition_point(|t| *t < 1.0);
    let mean = (phase[t.len() - 1] - phase[late]) / (t[t.len() - 1] - t[late]);
    let (gait, free) = (TAU * run.frequency(), free / gear);
    assert!(mean > 0.1 * free && mean < free && (mean / gait - 1.0).abs() > 0.02, "{mean} of {free} rad/s");
}

#[test]
fn a_soft_robot_is_judged_on_the_rig() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let simulated = |robot: &str, also: &[&str]| {
        let robot = format!("rig.robot={}", root.join("robots").join(robot).display());
        let brief = ["rig.cell.rate_hz=3500.0", "hold.each_s=0.6", "rig.rest_s=0.1", "rig.aero.preset=full"];
        let overrides =
            brief.iter().chain(also).map(|set| (*set).to_owned()).chain([robot]).collect::<Vec<_>>();
        let run = RigRun::load(&root.join("rigs/runs/bench.toml"), &overrides).unwrap();
        run.simulated(1, |_| ()).unwrap().verdict
    };
    let told = |verdict: &Verdict, id: &str| verdict.judged.iter().find(|judged| judged.id == id).cloned();
    let stiff = simulated("soft_20g.toml", &[]);
    assert!(
        told(&stiff, "spar.angle_deg").unwrap().met && told(&stiff, "flap.angle_deg").is_none(),
        "{stiff:?}"
    );
    let weak = simulated(
        "soft_20g.toml",
        &["rig.robot.links[2].spar.bending_n_m2=5e-4", "rig.robot.links[2].spar.torsion_n_m2=5e-4"],
    );
    assert!(
        !told(&weak, "spar.angle_outside_deg").unwrap().met && weak.status == Status::Outside,
        "{weak:?}"
    );
    let film = simulated("aerobat_membrane.toml", &[]);
    assert!(told(&film, "membrane.camber_fraction").unwrap().value > Some(0.0), "{film:?}");
    assert!(["membrane.slack_fraction", "membrane.strain"].iter().all(|id| told(&film, id).is_some()));
    let late = simulated("aerobat_membrane.toml", &["rig.robot.surfaces[0].membrane.damping_s=0.1"]);
    let lag = |verdict: &Verdict| told(verdict, "membrane.lag_rad").unwrap();
    assert!(lag(&film).met && !lag(&late).met, "{late:?}");
}

#[test]
fn a_pose_that_no_joint_can_have_is_an_error() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let run = RigRun::load(&root.join("rigs/runs/roll15_speed08.toml"), &[]).unwrap();
    let plan = run.plan().unwrap().unwrap_or_else(|refusal| panic!("{refusal}"));
    let begin = plan.trajectory.position[0].clone();
    assert!(run.approach(&begin, &plan).unwrap().is_ok());
    for huge in [1e6, 1e300, -1e300, f64::MAX, f64::INFINITY, f64::NAN] {
        for joint in 0..begin.len() {
            let mut from = begin.clone();
            from[joint] = huge;
            let message = run.approach(&from, &plan).unwrap_err().to_string();
            assert!(message.starts_with("from"), "{message}");
        }
    }
}

/// By force or frequency the pose of the wings is not known, and a motor's crank turns as the loads let it.
#[test]
fn inertia_is_not_taken_away_without_the_phase_of_the_gait() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let bench = |sets: &[&str]| {
        let overrides: Vec<String> = sets.iter().map(|set| (*set).into()).collect();
        RigRun::load(&root.join("rigs/runs/bench.toml"), &overrides).map(|_| ()).map_err(|e| e.to_string())
    };
    let inertia = "process.steps.robot_inertia=true";
    for phase in ["force", "frequency"] {
        let refused = bench(&[inertia, &format!("process.phase=\"{phase}\"")]).unwrap_err();
        for key in ["process.steps.robot_inertia", "process.phase = encoder", "process.input.columns.phase"] {
            assert!(refused.contains(key), "{refused}");
        }
    }
    let encoder = "process.phase=\"encoder\"";
    assert_eq!(bench(&[inertia, encoder]), Ok(()));
    assert_eq!(bench(&[inertia, "frequency_hz=0.0"]), Ok(()), "the wings rest");
    let robot = format!("rig.robot={}", root.join("robots/motor_flapper.toml").display());
    let refused = bench(&[inertia, encoder, &robot]).unwrap_err();
    assert!(refused.contains("a motor turns this robot's crank"), "{refused}");
}

//! A robot carried on the rig.

use std::f64::consts::TAU;
use std::path::Path;

use wingbeat::judge::{Status, Verdict};
use wingbeat::math::{GRAVITY, Jet, Mat3, Vec3};
use wingbeat::plant::Plant;
use wingbeat::rig::process::recorded_motion;
use wingbeat::robot::BodyMotion;
use wingbeat::scenario::{Processed, RigRun};
use wingbeat::simulate::{Column, Record};

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
    assert_eq!(bench(&[inertia, encoder, &robot]), Ok(()), "the encoder shows how the motor turns the crank");
}

/// The bench for some seconds, by its encoder.
fn bench(sets: &[&str]) -> RigRun {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let zero = "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]";
    let ideal = ["bias", "drift_per_s"].map(|key| format!("rig.cell.{key}={zero}"));
    let common =
        ["process.phase=\"encoder\"", "rig.rest_s=0.5", "rig.cell.noise_steps=0.0", &ideal[0], &ideal[1]];
    let overrides: Vec<String> = common.iter().chain(sets).map(|set| (*set).into()).collect();
    RigRun::load(&root.join("rigs/runs/bench.toml"), &overrides).unwrap()
}

/// What processing makes of the simulated bench.
fn processed(run: &RigRun) -> Processed {
    let carrier = run.carrier(None);
    let record = run.simulate(&carrier, 1, |_| ()).unwrap().unwrap().record;
    run.process(record, &carrier, run.window(None, &carrier)).unwrap().unwrap()
}

fn range(of: &[f64]) -> f64 {
    of.iter().copied().fold(f64::MIN, f64::max) - of.iter().copied().fold(f64::MAX, f64::min)
}

/// An encoder shows 0 where the wings are at `gait.phase_rad`: the wings of the model are where they were, and the loads come as much earlier.
#[test]
fn a_gait_that_begins_elsewhere_is_processed_as_it_is_simulated() {
    let brief =
        ["rig.cell.rate_hz=1750.0", "rig.cell.filter_hz=500.0", "hold.each_s=3.0", "process.bins=160"];
    let sets = [
        &brief[..],
        &["process.steps.robot_inertia=true", "hold.tilts_deg=[[30.0, 0.0]]", "process.window_s=[1.0, 3.0]"],
    ]
    .concat();
    let own = processed(&bench(&sets));
    let eighth = format!("rig.robot.numbers={{\"gait.phase_rad\"={:?}}}", TAU / 8.0);
    let moved = processed(&bench(&[&sets[..], &[eighth.as_str()]].concat()));
    for (channel, most) in [(2, 0.03), (4, 0.03)] {
        let (a, b) = (&own.cycles[channel].mean, &moved.cycles[channel].mean);
        let bins = a.len();
        let apart = (0..bins).map(|k| (a[(k + bins / 8) % bins] - b[k]).abs()).fold(0.0, f64::max);
        assert!(apart < most * range(a), "{channel}: {apart} of {}", range(a));
        let against = moved.against_model().unwrap()[channel];
        assert!(against.rmse < 0.05 * against.range, "{channel}: {against:?}");
    }
}

/// A motor's crank turns unevenly: the encoder shows it, so that the inertia of the wings is taken away, and the model beats as they did.
#[test]
fn the_crank_of_a_motor_is_processed_as_its_encoder_shows_it() {
    let motor = "rig.robot.drive={motor={stall_torque_n_m=6e-3, no_load_speed_rad_s=1300.0, gear_ratio=60.0, efficiency=0.8, \
                 rotor_inertia_kg_m2=4e-9, crank_inertia_kg_m2=1e-6}}";
    let stiff =
        ["rig.cell.resonance_hz=3000.0", "rig.cell.filter_hz=3400.0", "hold.each_s=2.0", "frequency_hz=3.3"];
    let vacuum =
        [&stiff[..], &[motor, "rig.air.density_kg_m3=1e-30", "process.window_s=[1.0, 2.0]"]].concat();
    let whole = processed(&bench(&vacuum));
    let left = processed(&bench(&[&vacuum[..], &["process.steps.robot_inertia=true"]].concat()));
    let [of, is] = [&whole, &left].map(|done| range(&done.cycles[2].mean));
    assert!(of > 0.1 && is < 0.01 * of, "{is} N of {of} N");
    // In air, beside the model that was simulated.
    let air = processed(&bench(&[&stiff[..], &[motor, "process.window_s=[1.0, 2.0]"]].concat()));
    let against = air.against_model().unwrap()[2];
    assert!(against.rmse < 0.02 * against.range, "{against:?}");
}

#[test]
fn overrides_that_numbers_of_the_rig_make_vain_are_told() {
    let numbers = r#"rig.robot.numbers={"body.mass_kg"=0.03,"mount.mass_kg"=0.02}"#;
    let told = |sets: &[&str]| -> Vec<String> {
        let run = bench(sets);
        run.of_fit()
            .filter(|warning| warning.id == "numbers.given_twice")
            .map(|warning| warning.text)
            .collect()
    };
    assert_eq!(told(&[numbers, "rig.robot.body.com_m=[0.0, 0.0, 0.0]"]), [""; 0]);
    assert_eq!(told(&["rig.robot.body.mass_kg=0.02"]), [""; 0]);
    for (set, name) in [
        ("rig.robot.body.mass_kg=0.02", "body.mass_kg = 0.03"),
        ("rig.mount.link.mass_kg=0.05", "mount.mass_kg = 0.02"),
    ] {
        let all = told(&[numbers, set]);
        assert!(all.len() == 1 && all[0].contains(name) && all[0].contains(set), "{set}: {all:?}");
    }
}

/// A file that begins when the arm already moves holds the same motion.
#[test]
fn a_recorded_motion_keeps_its_time() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rigs/runs/roll15_speed08.toml");
    let arm = RigRun::load(&file, &[]).unwrap().arm;
    let names = ["t", "q1", "q2", "q3", "q4", "q5", "q6"];
    let record = |times: &mut dyn Iterator<Item = f64>| {
        let mut record = Record::new(names.map(|name| Column::new(name, "", "")).to_vec(), 1).unwrap();
        for t in times {
            let q = |j: usize| 0.2 * (2.0 * t + j as f64).sin();
            record.append(&[t, q(0), q(1), q(2), q(3), q(4), q(5)]);
        }
        record
    };
    let step = 1.0 / 7000.0;
    let all: Vec<f64> = (-7000..21_000).map(|k| f64::from(k) * step).collect();
    let motion = |from: f64, jitter: f64| {
        let moved = |(k, t): (usize, &f64)| t + jitter * step * (k as f64).sin();
        let mut times = all.iter().enumerate().map(moved).filter(|t| *t >= from);
        recorded_motion(&record(&mut times), &arm, 2.5).unwrap()
    };
    let whole = motion(-1.0, 0.0);
    for other in [motion(0.4, 0.0), motion(-1.0, 0.3)] {
        for (k, row) in whole.position.iter().enumerate().skip(800).take(1500) {
            let at = k as f64 * whole.step / other.step;
            let (before, share) = (at as usize, at.fract());
            for (j, q) in row.iter().enumerate() {
                let [a, b] = [0, 1].map(|more| other.position[before + more][j]);
                assert!((a + (b - a) * share - q).abs() < 1e-5, "{k} {j}: {a} {q}");
            }
        }
    }
}

//! Flight in unknown air: what it learns, what that gains, and gaits found for several airs.

use std::ops::ControlFlow;
use std::path::Path;

use wingbeat::judge::Status;
use wingbeat::math::GRAVITY;
use wingbeat::scenario::{Run, Scenario, Summary};

fn loaded(name: &str, overrides: &[&str]) -> Result<Scenario, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenarios/{name}.toml"));
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Scenario::load(&path, &overrides).map_err(|error| error.to_string())
}

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    loaded(name, overrides).unwrap_or_else(|e| panic!("{e}"))
}

fn flown(name: &str, overrides: &[&str]) -> Run {
    scenario(name, overrides).fly(|_| ControlFlow::Continue(())).unwrap()
}

/// Mean of a column from `since` s on.
fn mean(run: &Run, name: &str, since: f64) -> f64 {
    let (t, values) = (run.record.values("t").unwrap(), run.record.values(name).unwrap());
    let kept: Vec<f64> = t.iter().zip(values).filter(|(t, _)| **t >= since).map(|(_, v)| *v).collect();
    kept.iter().sum::<f64>() / kept.len() as f64
}

/// A robot 5 % heavier than its model is held by 5 % more force than that expects, which would throw it up by g/20; without added mass,
/// whose force would follow that acceleration.
#[test]
fn what_the_model_misses_is_found_by_phase() {
    let heavy = ["flight.duration_s=2.4", "mismatch.mass=1.05", "aero.added_mass=false"];
    let adapted = flown("level_20g", &[&heavy[..], &["controller.orbit.adapt={missed_s=0.12}"]].concat());
    let missed = mean(&adapted, "orbit_missed_acceleration_z", 1.6);
    let expected = -0.05 * GRAVITY;
    // The series has two harmonics: what it leaves out scatters by a tenth.
    assert!((missed - expected).abs() < 0.15 * expected.abs(), "{missed} for {expected}");
    for aside in ["acceleration_y", "turning_x", "turning_z"] {
        let value = mean(&adapted, &format!("orbit_missed_{aside}"), 1.6);
        assert!(value.abs() < 1e-3, "{aside} {value}");
    }
    // Without adaptation the integral of the height has not done its work yet.
    let plain = flown("level_20g", &heavy);
    let [off, without] = [&adapted, &plain].map(|run| run.summary.height_max_error_m.unwrap());
    assert!(off < 0.5 * without, "{off} {without}");
    assert!(plain.record.values("orbit_missed_turning_x").is_none());
}

/// In thin air the crank turns faster, and the other commands cost less for it.
#[test]
fn the_crank_takes_over_what_other_commands_hold() {
    let thin = ["flight.duration_s=2.4", "mismatch.density=0.9"];
    let adapted = flown("level_20g", &[&thin[..], &["controller.orbit.adapt={crank_s=0.2}"]].concat());
    let plain = flown("level_20g", &thin);
    let cost = |run: &Run| -> f64 {
        let limits = [("stroke", 0.4), ("twist", 0.15), ("swing", 0.4)];
        limits
            .iter()
            .map(|(name, limit)| (mean(run, &format!("command_{name}_left"), 1.6) / limit).powi(2))
            .sum()
    };
    let added = mean(&adapted, "orbit_crank_added", 1.6);
    assert!(added > 0.4 && added < 1.5, "{added}");
    assert!(cost(&adapted) < 0.75 * cost(&plain), "{} {}", cost(&adapted), cost(&plain));
    assert!((mean(&adapted, "command_crank", 1.6) - added).abs() < 0.1);
    assert!(adapted.summary.height_max_error_m.unwrap() < 0.01);
}

#[test]
fn adaptation_that_cannot_be_is_refused() {
    let refused = |name: &str, adapt: &str| {
        let given = format!("controller.orbit.adapt={adapt}");
        loaded(name, &[&given]).err().unwrap_or_default()
    };
    assert!(
        refused("level_20g", "{}").contains("crank_s, missed_s, or both"),
        "{}",
        refused("level_20g", "{}")
    );
    assert!(refused("level_20g", "{crank_s=nan}").contains("crank_s"));
    assert!(refused("level_20g", "{missed_s=0.0}").contains("missed_s"));
    assert!(refused("level_20g", "{missed_s=0.2, harmonics=10}").contains("harmonics"));
    assert!(refused("bank15_beta_lev", "{crank_s=0.2}").is_empty());
    let beside = "{missed_s=0.2}";
    assert!(refused("predictive_20g", beside).contains("predictive"));
    assert!(refused("estimator_20g", beside).contains("estimator"));
}

/// Told law `lev` and flown under `stall`, the commands of the regulator alone let the skins of the wings, 3 mm thick, touch. With a governor they
/// keep what is asked between its looks too: a turn has no reserve of the smooth minimum over left and right.
#[test]
fn a_governor_keeps_the_wings_apart() {
    let untold = ["aero.law=lev", "mismatch.aero={preset='full', law='stall'}"];
    let turn = [
        "controller.orbit.clearance_m=0.008",
        "controller.orbit.legs=[{start_s=0.0, duration_s=0.15, bank_deg=5.0}]",
        "flight.duration_s=0.7",
        "flight.record_every_s=2.5e-4",
    ];
    let kept = flown("any_air_bank30_20g", &[&untold[..], &turn].concat());
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ungoverned.toml");
    let governed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/any_air_bank30_20g.toml");
    let text =
        format!("base = {governed:?}\nwithout = [\"controller.orbit.clearance_m\"]\nname = \"free\"\n");
    std::fs::write(&path, text).unwrap();
    let level = ["controller.orbit.legs=[]", "flight.duration_s=0.5"];
    let level: Vec<String> = untold.iter().chain(&level).map(|text| (*text).to_owned()).collect();
    let free = Scenario::load(&path, &level).unwrap_or_else(|e| panic!("{e}"));
    let free = free.fly(|_| ControlFlow::Continue(())).unwrap();
    let [clear, crossed] = [&kept, &free].map(|run| run.summary.least_clearance_m.unwrap());
    assert!(clear >= 0.008 && crossed < 0.003, "{clear} {crossed}");
    let changed = kept.record.values("orbit_governed").unwrap().iter().copied().fold(0.0, f64::max);
    assert!(changed > 0.01 && free.summary.governed.is_none(), "{changed}");
    assert!(kept.summary.height_max_error_m.unwrap() < 0.05);
    let governed = kept.summary.governed.unwrap();
    assert_eq!((governed.asked_m, governed.short_fraction), (0.008, 0.0));
    let short = kept.summary.judged.iter().find(|judged| judged.id == "flight.clearance_short_fraction");
    assert!(short.unwrap().met);
}

/// More than the shoulders are apart of the middle plane: the judge says that it is not kept, and at how many updates.
#[test]
fn a_clearance_that_is_not_kept_is_told() {
    let brief = ["controller.orbit.clearance_m=0.03", "controller.orbit.legs=[]", "flight.duration_s=0.1"];
    let run = flown("any_air_bank30_20g", &brief);
    let governed = run.summary.governed.unwrap();
    assert!((governed.not_kept, governed.not_kept_fraction) == (run.summary.controller.updates, 1.0));
    let least = run.summary.least_clearance_m.unwrap();
    assert!((governed.short_fraction - (1.0 - least / 0.03)).abs() < 1e-12 && least < 0.021, "{governed:?}");
    assert_eq!(run.summary.status, Status::OffTarget);
    assert!(run.summary.reason.unwrap().contains("controller.orbit.clearance_m"));
    let warned = run.summary.warnings.iter().any(|w| w.id == "flight.clearance_not_kept_fraction");
    assert!(warned, "{:?}", run.summary.warnings);
}

#[test]
fn a_clearance_that_cannot_be_kept_is_refused() {
    let refused =
        |name: &str| loaded(name, &["controller.orbit.clearance_m=0.004"]).err().unwrap_or_default();
    assert!(refused("predictive_20g").contains("soft limit"), "{}", refused("predictive_20g"));
    assert!(
        refused("passive_bank15_20g").contains("move by themselves"),
        "{}",
        refused("passive_bank15_20g")
    );
    assert!(refused("dive_45_20g").contains("none beside dive"), "{}", refused("dive_45_20g"));
    assert!(refused("bank15_20g").is_empty());
    for (value, allowed) in [("-0.5", "above 0"), ("0.0", "above 0"), ("1.0", "above 0, at most 0.203")] {
        let told = loaded("any_air_bank30_20g", &[&format!("controller.orbit.clearance_m={value}")]);
        let told = told.err().unwrap_or_default();
        assert!(
            told.contains("controller.orbit.clearance_m = ") && told.contains(allowed),
            "{value}: {told}"
        );
    }
}

/// The power of a search over airs is the mean of their orbits, each found by itself.
#[test]
fn a_gait_is_searched_in_several_airs() {
    let other = ["aero.law=lev", "trim.speed_m_s=3.7"];
    let search = "trim.search={goal='power', limits={}, iterations=1, airs=[['aero.law=lev', 'trim.speed_m_s=3.7']], \
                  vary=[{key='robot.body.com_m[0]', low=-0.004, high=0.0}]}";
    let found = scenario("cruise_20g", &["trim.step_s=1e-3", search]);
    let search = found.gait_search().unwrap().unwrap();
    let row = search.row(0, &mut |_| ControlFlow::Continue(())).unwrap();
    let column = |name: &str| row[search.columns().iter().position(|c| c.name == name).unwrap()];
    let com = format!("robot.body.com_m[0]={:?}", column("robot.body.com_m[0]"));
    let power = |overrides: &[&str]| {
        let all = [&["trim.step_s=1e-3", &com], overrides].concat();
        let trimmed = scenario("cruise_20g", &all).trim(&mut |_| ControlFlow::Continue(())).unwrap();
        trimmed.summary.power_w_kg.unwrap()
    };
    let expected = 0.5 * (power(&[]) + power(&other));
    assert!((column("power_w_kg") - expected).abs() < 1e-3 * expected, "{} {expected}", column("power_w_kg"));
    let wrong = "trim.search={goal='power', limits={}, airs=[['aero.law=lift']], \
                 vary=[{key='robot.body.com_m[0]', low=-0.004, high=0.0}]}";
    let both = "trim.search={goal='power', limits={}, airs=[['aero.law=lev'], ['robot.body.com_m=[0.0, 0.0, 0.0]']], \
                vary=[{key='robot.body.com_m[0]', low=-0.004, high=0.0}]}";
    let told = loaded("cruise_20g", &[both]).err().unwrap_or_default();
    assert!(told.contains("trim.search.airs[1]") && told.contains("vary[0]"), "{told}");
    let scenario = scenario("cruise_20g", &[wrong]);
    let told = scenario.gait_search().err().map(|e| e.to_string()).unwrap_or_default();
    assert!(told.contains("trim.search.airs[0]") && told.contains("aero.law=lift"), "{told}");
}

/// Turbulence moves the flight, follows its seed, and says where it is not what it stands for.
#[test]
fn turbulence_blows_as_its_seed_says() {
    let given = "air.dryden={airspeed_m_s=4.05, deviation_m_s=[0.2, 0.2, 0.1], length_m=[2.0, 2.0, 1.0]}";
    let short = ["flight.duration_s=0.5", given];
    let [one, again, other] =
        ["seed=3", "seed=3", "seed=4"].map(|seed| flown("level_20g", &[short[0], short[1], seed]));
    let height = |run: &Run| run.record.values("p_WB_z").unwrap().to_vec();
    assert_eq!(height(&one), height(&again));
    assert!(height(&one) != height(&other) && one.summary.status == Status::Ok, "{:?}", one.summary.reason);
    assert!(one.summary.warnings.iter().all(|w| !w.id.contains("turbulence")), "{:?}", one.summary.warnings);
    let wild = "air.dryden={airspeed_m_s=1.0, deviation_m_s=[1.2, 0.2, 0.1], length_m=[2.0, 2.0, 1.0]}";
    let wild = flown("level_20g", &["flight.duration_s=0.3", wild]).summary;
    for id in ["flight.turbulence_over_airspeed", "flight.turbulence_speed"] {
        assert!(wild.warnings.iter().any(|warning| warning.id == id), "{id}: {:?}", wild.warnings);
    }
    let value = |summary: &Summary, id: &str| {
        summary.judged.iter().find(|judged| judged.id == id).and_then(|judged| judged.value).unwrap()
    };
    assert_eq!(wild.status, Status::Outside);
    assert!((value(&wild, "flight.turbulence_beyond_airspeed") - 1.2).abs() < 1e-12);
    assert!(value(&wild, "flight.turbulence_other_speed") > 2.0);
    // At 3.42 m/s against a wind of 0.5 m/s the air passes by at 3.90 m/s.
    let calm = "air.dryden={airspeed_m_s=3.9, deviation_m_s=[0.0, 0.0, 0.0], length_m=[2.0, 2.0, 1.0]}";
    let [against, still] = ["air.wind_m_s=[-0.5, 0.0, 0.0]", "air.wind_m_s=[0.0, 0.0, 0.0]"].map(|wind| {
        let run = flown("glide", &["flight.duration_s=0.4", calm, wind]);
        value(&run.summary, "flight.turbulence_speed")
    });
    assert!(against < 0.02 && still > 0.06, "{against} {still}");
    let refused =
        |dryden: &str| loaded("level_20g", &[&format!("air.dryden={dryden}")]).err().unwrap_or_default();
    for (dryden, key) in [
        ("{airspeed_m_s=4.0}", "altitude_m and wind_6m_m_s"),
        ("{airspeed_m_s=0.0, altitude_m=10.0, wind_6m_m_s=1.0}", "airspeed_m_s"),
        ("{airspeed_m_s=4.0, altitude_m=1.0, wind_6m_m_s=1.0}", "altitude_m"),
        ("{airspeed_m_s=4.0, deviation_m_s=[nan, 0.1, 0.1], length_m=[1.0, 1.0, 1.0]}", "deviation_m_s[0]"),
        ("{airspeed_m_s=4.0, deviation_m_s=[0.1, 0.1, 0.1], length_m=[1.0, 0.0, 1.0]}", "length_m[1]"),
        ("{airspeed_m_s=100.0, deviation_m_s=[0.1, 0.1, 0.1], length_m=[1.0, 0.001, 1.0]}", "nodes"),
    ] {
        let told = refused(dryden);
        assert!(told.contains("air.dryden") && told.contains(key), "{dryden}: {told}");
    }
}

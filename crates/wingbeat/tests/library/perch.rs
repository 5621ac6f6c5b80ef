//! A perch, the claw that meets it, and a landing that is planned and held.

use std::ops::ControlFlow;
use std::path::Path;

use wingbeat::aero::LiftLaw;
use wingbeat::judge::Status;
use wingbeat::math::{Dual, Vec3};
use wingbeat::plant::Plant;
use wingbeat::robot::{Contact, Perch, PerchShape, Robot};
use wingbeat::scenario::{Run, Scenario};

fn loaded(name: &str, overrides: &[&str]) -> Result<Scenario, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenarios/{name}.toml"));
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Scenario::load(&path, &overrides).map_err(|error| error.to_string())
}

fn flown(name: &str, overrides: &[&str]) -> Run {
    let scenario = loaded(name, overrides).unwrap_or_else(|e| panic!("{e}"));
    scenario.fly(|_| ControlFlow::Continue(())).unwrap()
}

/// A robot in a vacuum below a ceiling that it reaches 0.1 s after the throw; its claw is its centre of mass, so that hits are central.
fn thrown(overrides: &[&str]) -> Run {
    let brief = ["flight.duration_s=0.2", "flight.step_s=5e-5", "flight.record_every_s=5e-5"];
    let still = loaded("reorientation", &brief).unwrap();
    let seen = still.robot().observe(0.0, &still.start(), &[0.0; 2]).unwrap();
    let Vec3([x, y, z]) = seen.center_of_mass;
    let height = 2.0 * 0.1 - 0.5 * 9.80665 * 0.01 + z;
    let perch = format!(
        "perch={{place_m=[0.0, 0.0, {height}], kind='ceiling', claw_m=[{x}, {y}, {z}], capture_m=0.05, speed_within_m_s=0.1, attitude_within_deg=20.0, restitution=0.6, friction=0.3, contact_s=0.002}}"
    );
    let own = ["start.velocity_m_s=[0.0, 0.0, 2.0]", &perch];
    flown("reorientation", &[&brief, &own[..], overrides].concat())
}

/// Velocity before and after the hit.
fn before_and_after(run: &Run) -> [Vec3; 2] {
    let force = run.record.values("perch_force").unwrap();
    let (first, last) = (force.iter().position(|f| *f > 0.0), force.iter().rposition(|f| *f > 0.0));
    let at =
        |row: usize| Vec3(["x", "y", "z"].map(|a| run.record.values(&format!("v_WB_W_{a}")).unwrap()[row]));
    [at(first.unwrap() - 1), at(last.unwrap() + 1)]
}

/// A central hit leaves the share of the speed that is asked, but for what gravity adds in 2 ms; one at a slant slides, and friction takes
/// its coefficient times the change of the speed towards the ceiling.
#[test]
fn a_claw_bounces_off_by_its_restitution() {
    let [before, after] = before_and_after(&thrown(&[]));
    assert!((before[2] - 1.02).abs() < 0.01, "{before:?}");
    assert!((after[2] + 0.6 * before[2]).abs() < 0.02, "{before:?} {after:?}");
    let slanted = thrown(&["start.velocity_m_s=[3.0, 0.0, 2.0]"]);
    let [before, after] = before_and_after(&slanted);
    let (along, towards) = (before[0] - after[0], before[2] - after[2]);
    assert!((along / towards - 0.3).abs() < 0.01, "{along} {towards}");
    let perch = slanted.summary.perch.unwrap();
    assert!(perch.touched && !perch.caught && perch.largest_force_n > 1.0, "{perch:?}");
    // The surface of the body lies above the claw and goes through the ceiling before it.
    assert_eq!(slanted.summary.status, Status::Outside);
}

/// Upside down, rising past a bar and slower and slower, the claw latches as soon as its speed is within the limit, and the flight is whole.
#[test]
fn a_claw_latches_within_its_limits_and_ends_the_flight() {
    let bar = "perch={place_m=[0.0, 0.0, 0.03], capture_m=0.05, speed_within_m_s=0.5, attitude_within_deg=20.0, radius_m=0.001}";
    let over = ["start.nose_up_deg=170.0", "start.velocity_m_s=[0.0, 0.0, 0.7]"];
    let caught = flown("reorientation", &[&over[..], &[bar]].concat());
    let (summary, perch) = (&caught.summary, caught.summary.perch.as_ref().unwrap());
    assert!(perch.caught && perch.touched, "{perch:?}");
    // 0.7 m/s less 0.2 m/s of a fall: 20 ms.
    assert!((summary.duration_s - 0.0204).abs() < 1e-3 && perch.touch_s == summary.duration_s, "{perch:?}");
    assert!((perch.pitch_error_deg + 10.0).abs() < 1.0 && perch.speed_m_s <= 0.5, "{perch:?}");
    assert_eq!(summary.status, Status::Ok, "{:?}", summary.reason);
    let ids: Vec<&str> = summary.judged.iter().map(|judged| judged.id).collect();
    for id in ["perch.capture_m", "perch.speed_within_m_s", "perch.attitude_within_deg"] {
        assert!(ids.contains(&id), "{ids:?}");
    }
    let upright =
        flown("reorientation", &["start.velocity_m_s=[0.0, 0.0, 0.7]", bar, "flight.duration_s=0.2"]);
    let perch = upright.summary.perch.unwrap();
    assert!(!perch.caught && (perch.attitude_error_deg - 180.0).abs() < 5.0, "{perch:?}");
    assert_eq!(upright.summary.status, Status::Outside, "the body goes through the bar");
    assert!(upright.summary.reason.unwrap().contains("perch.attitude_within_deg"));
}

/// Where and how fast the claw latches is found within a step: it does not depend on the records.
#[test]
fn a_claw_latches_at_an_instant_that_records_do_not_move() {
    let bar = "perch={place_m=[0.0, 0.0, 0.05], capture_m=0.05, speed_within_m_s=0.5, attitude_within_deg=20.0, radius_m=0.001}";
    let caught = |every: &str| {
        let every = format!("flight.record_every_s={every}");
        let over = ["start.nose_up_deg=170.0", "start.velocity_m_s=[0.0, 0.0, 0.7]", "flight.step_s=2.5e-4"];
        let run = flown("reorientation", &[&over[..], &[bar, &every]].concat());
        let perch = run.summary.perch.unwrap();
        assert!(perch.caught && perch.touch_s == run.summary.duration_s, "{perch:?}");
        // It latches because it has become slow.
        assert!((perch.speed_m_s - 0.5).abs() < 1e-9, "{perch:?}");
        assert_eq!(run.record.values("t").unwrap().last(), Some(&perch.touch_s));
        [perch.touch_s, perch.distance_m, perch.speed_m_s, perch.pitch_error_deg]
    };
    let [seldom, often, always] = ["1e-3", "5e-4", "2.5e-4"].map(caught);
    for other in [often, always] {
        assert!(seldom.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-9), "{seldom:?} {other:?}");
    }
    // Between the steps.
    let steps = seldom[0] / 2.5e-4;
    assert!((steps - steps.round()).abs() > 1e-3, "{seldom:?}");
}

/// Whatever the state at the instant of the latch is rounded to, the claw has latched and the flight is whole.
#[test]
fn a_claw_that_latches_stays_latched() {
    let bar = "perch={place_m=[0.0, 0.0, 0.03], capture_m=0.2, speed_within_m_s=3.0, attitude_within_deg=20.0, radius_m=0.001, \
               claw_m=[-0.03, 0.0, -0.03], length_m=0.01}";
    for i in 20..32 {
        let rate = format!("start.rate_rad_s=[0.3, -5.{i}, 0.2]");
        let over =
            ["start.nose_up_deg=157.0", "start.velocity_m_s=[0.0, 0.0, 0.3]", "flight.duration_s=0.05"];
        let run = flown("reorientation", &[&over[..], &[bar, "flight.step_s=2.5e-4", &rate]].concat());
        let perch = run.summary.perch.unwrap();
        assert!(perch.caught && perch.attitude_error_deg <= 20.0, "{rate}: {perch:?}");
        assert_ne!(run.summary.status, Status::Interrupted, "{rate}");
    }
}

/// A bar that the wings pass through, or nearly touch, is told; one that is far is not.
#[test]
fn wings_keep_clear_of_the_perch_or_are_told() {
    let beside = |place: &str, more: &str| {
        let perch = format!(
            "perch={{place_m={place}, capture_m=0.001, speed_within_m_s=0.01, attitude_within_deg=1.0, radius_m=0.002{more}}}"
        );
        let brief = ["flight.duration_s=0.02", "start.velocity_m_s=[0.0, 0.0, 0.0]", &perch];
        let run = flown("reorientation", &brief);
        let perch = run.summary.perch.unwrap();
        let judged =
            run.summary.judged.iter().find(|judged| judged.id == "flight.perch_clearance_m").unwrap();
        assert_eq!(judged.value, perch.least_clearance_m);
        (judged.value.unwrap(), run.summary.status)
    };
    let (far, status) = beside("[0.0, 0.0, 1.0]", "");
    assert!(far > 0.7 && far < 1.0 && status == Status::OffTarget, "{far} {status:?}");
    // A long bar through the body's surface is pierced by it: minus its radius.
    let (through, status) = beside("[0.01, 0.0, 0.03]", ", direction=[0.0, 0.0, 1.0]");
    assert!((through + 0.002).abs() < 1e-12 && status == Status::Outside, "{through} {status:?}");
    let (below, status) = beside("[0.0, 0.0, 0.004]", ", kind='ceiling', claw_m=[0.0, 0.0, -0.1]");
    assert!(below < 0.0 && status == Status::Outside, "{below} {status:?}");
}

/// A landing that its own verdict calls impossible is caught, but not held.
#[test]
fn a_catch_through_the_perch_is_not_held() {
    let bar = |place: &str, direction: &str, velocity: &str| {
        let bar = format!(
            "perch={{place_m={place}, direction={direction}, length_m=0.3, capture_m=0.05, speed_within_m_s=0.8, attitude_within_deg=20.0, radius_m=0.001}}"
        );
        let velocity = format!("start.velocity_m_s={velocity}");
        let over = ["start.nose_up_deg=170.0", "flight.duration_s=0.02", &velocity];
        flown("reorientation", &[&over[..], &[&bar]].concat()).summary
    };
    let hold = wingbeat::scenario::Hold {
        roll_within_deg: 180.0,
        pitch_within_deg: 180.0,
        height_within_m: None,
        cross_rms_within_m: None,
        clearance_m: 0.0,
    };
    let clear = bar("[0.0, 0.0, 0.06]", "[0.0, 1.0, 0.0]", "[0.0, 0.0, 0.7]");
    // Upright, it stands in a wing.
    let through = bar("[0.0, 0.053, 0.0]", "[0.0, 0.0, 1.0]", "[0.0, 0.3, 0.1]");
    for (summary, held) in [(&clear, true), (&through, false)] {
        assert!(summary.perch.as_ref().unwrap().caught, "{:?}", summary.perch);
        assert_eq!(hold.met(summary), Some(held), "{:?} {:?}", summary.status, summary.perch);
    }
    assert_eq!(through.status, Status::Outside, "{:?}", through.reason);
    assert!(clear.turn_roll_mean_deg.is_none());
}

#[test]
fn a_perch_that_cannot_be_is_refused() {
    let refused = |key: &str, value: &str| {
        let perch =
            "perch={place_m=[0.0, 0.0, 1.0], capture_m=0.05, speed_within_m_s=0.5, attitude_within_deg=20.0}";
        loaded("reorientation", &[perch, &format!("perch.{key}={value}")]).err().unwrap_or_default()
    };
    for (key, value, allowed) in [
        ("capture_m", "0.0", "0.0001 to 1"),
        ("capture_m", "nan", "finite"),
        ("speed_within_m_s", "-1.0", "0.001 to 20"),
        ("attitude_within_deg", "181.0", "0.1 to 180"),
        ("restitution", "0.0", "0.2 to 1"),
        ("friction", "-0.1", "0 to 10"),
        ("contact_s", "1e-6", "ten steps of the flight"),
        ("direction", "[0.0, 0.0, 0.0]", "a direction"),
        ("place_m", "[0.0, 0.0, 0.0]", "does not begin at"),
        ("place_m", "[0.0, nan, 0.0]", "finite"),
        ("kind", "'branch'", "bar"),
    ] {
        let told = refused(key, value);
        assert!(told.contains(allowed) && told.contains(&format!("perch.{key}")), "{key} = {value}: {told}");
    }
    let ceiling = "perch={place_m=[0.0, 0.0, -1.0], kind='ceiling', capture_m=0.05, speed_within_m_s=0.5, attitude_within_deg=180.0}";
    let told = loaded("reorientation", &[ceiling]).err().unwrap_or_default();
    assert!(told.contains("perch.place_m") && told.contains("beyond"), "{told}");
    let seldom = [
        "perch={place_m=[0.0, 0.0, 1.0], capture_m=0.05, speed_within_m_s=0.5, attitude_within_deg=20.0}",
        "flight.record_every_s=0.01",
    ];
    let told = loaded("reorientation", &seldom).err().unwrap_or_default();
    assert!(told.contains("perch.contact_s") && told.contains("flight.record_every_s"), "{told}");
    let landing = |overrides: &[&str]| loaded("bank15_20g", overrides).err().unwrap_or_default();
    let without = landing(&["controller.orbit.landing.cycles=6", "controller.orbit.legs=[]"]);
    assert!(without.contains("[perch]"), "{without}");
    let told = landing(&["controller.orbit.landing.cycles=1", "controller.orbit.legs=[]"]);
    assert!(told.contains("2 to 20"), "{told}");
    let told = landing(&["controller.orbit.landing={cycles=6, iterations=0}", "controller.orbit.legs=[]"]);
    assert!(told.contains("1 to 1000"), "{told}");
    assert!(landing(&["controller.orbit.landing.cycles=6"]).contains("none beside landing"));
    // The controller of `bank15_20g` knows law `stall`.
    for laws in ["['stall']", "['linear']", "['lev', 'lev']", "['lev', 'lev3d', 'stall', 'linear']"] {
        let given = format!("controller.orbit.landing={{cycles=6, laws={laws}}}");
        let told = landing(&[&given, "controller.orbit.legs=[]"]);
        assert!(told.contains("controller.orbit.landing.laws"), "{laws}: {told}");
    }
    let told = landing(&["controller.orbit.landing={cycles=6, laws=['soft']}", "controller.orbit.legs=[]"]);
    assert!(told.contains("lev3d"), "{told}");
}

/// Half a loop from 3.2 m/s to the perch within what the claw latches at, in still air as planned, and in gusts.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn a_landing_ends_upside_down_at_the_perch() {
    for gusts in [&[][..], &["air.gust_m_s=0.3", "seed=4"]] {
        let run = flown("land_20g", gusts);
        let perch = run.summary.perch.unwrap();
        assert!(perch.caught, "{gusts:?} {perch:?}");
        if gusts.is_empty() {
            // Body and wings pass the bar, which the plan knows.
            let least = [perch.least_clearance_m.unwrap(), run.summary.least_clearance_m.unwrap()];
            assert!(least[0] > 3e-3 && least[1] > 3e-3, "{least:?}");
            assert_eq!(run.summary.status, Status::Ok);
        }
        let nose = run.record.values("pitch").unwrap();
        assert!(nose.iter().any(|pitch| *pitch < -1.4), "it goes over by the nose");
    }
}

/// A robot that is put under another law has the rates of one that was built under it.
#[test]
fn a_robot_under_another_law_is_as_one_built_under_it() {
    let still = "aero.law=";
    let robots = ["stall", "lev"].map(|law| loaded("bank15_20g", &[&format!("{still}{law}")]).unwrap());
    let [stall, lev] = [robots[0].robot(), robots[1].robot()];
    let moved = stall.under(LiftLaw::Lev).unwrap();
    let x = moved.named_as(stall, &robots[0].start());
    assert_eq!(x.len(), lev.states().len());
    let names = |robot: &Robot| robot.states().iter().map(|state| state.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&moved), names(lev));
    let rates = |robot: &Robot| {
        let (mut dx, u) = (vec![0.0; x.len()], vec![0.0; robot.inputs().len()]);
        robot.rates(0.03, &x, &u, &mut dx).unwrap();
        dx
    };
    assert_eq!(rates(&moved), rates(lev));
    let back = moved.under(LiftLaw::Stall).unwrap();
    assert_eq!(names(&back), names(stall));
    assert_eq!(back.named_as(&moved, &x), robots[0].start());
}

/// The derivatives of the distance from a bar are those of differences, for every piece that is nearest on the way.
#[test]
fn a_perch_pushes_by_its_exact_slope() {
    let robot = loaded("land_20g", &["flight.duration_s=0.1"]).unwrap();
    let (robot, start) = (robot.model(), robot.start());
    let l = *robot.layout();
    let shape = PerchShape::Bar { axis: Vec3::new(0.0, 1.0, 0.0), half_length: 0.1, radius: 0.001 };
    let contact = Contact { restitution: 0.5, friction: 0.5, duration: 0.01 };
    let mut compared = 0;
    for (i, place) in [[0.05, 0.0, 0.03], [-0.12, 0.05, 0.02], [0.0, 0.02, -0.08]].into_iter().enumerate() {
        let perch = Perch::new(Vec3(place), shape, Vec3::new(-0.06, 0.0, -0.06), contact, robot.mass());
        let t = 0.013 * i as f64;
        let directions =
            [l.position, l.position + 2, l.attitude + 1, l.attitude + 2, l.structure, l.structure + 2];
        for along in directions {
            let moved = |by: f64| {
                let mut x = start.clone();
                x[along] += by;
                robot.clearance_from(&perch, t, &x).unwrap()
            };
            let by = 1e-6;
            let (ahead, behind) = ((moved(by) - moved(0.0)) / by, (moved(0.0) - moved(-by)) / by);
            // Where two pieces are as near, as left and right of a bar across, there is no slope.
            if (ahead - behind).abs() > 1e-4 {
                continue;
            }
            compared += 1;
            let expected = 0.5 * (ahead + behind);
            let mut x: Vec<Dual<1>> = start.iter().map(|x| Dual::constant(*x)).collect();
            x[along].eps[0] = 1.0;
            let found = robot.clearance_from(&perch, Dual::constant(t), &x).unwrap();
            assert!((found.re - moved(0.0)).abs() < 1e-12);
            assert!((found.eps[0] - expected).abs() < 1e-6, "{place:?} {along}: {} {expected}", found.eps[0]);
        }
    }
    assert!(compared > 9, "{compared}");
}

/// Half a loop under a law that the controller does not know: within a cycle it takes the law that holds for the one that does.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn the_law_that_holds_is_found_as_it_lands() {
    for (law, other) in [("stall", 0.0), ("lev", 1.0)] {
        let air = format!("mismatch.aero={{preset='full', law='{law}', full={{strips=9}}}}");
        let run = flown("land_20g", &[&air, "air.gust_m_s=0.3", "mismatch.mass=1.02", "seed=2"]);
        let (t, others) =
            (run.record.values("t").unwrap(), run.record.values("orbit_landing_other_laws").unwrap());
        for (t, others) in t.iter().zip(others).filter(|(t, _)| **t > 0.12) {
            assert!((others - other).abs() < 0.1, "law {law}: {others} at {t} s");
        }
        let perch = run.summary.perch.unwrap();
        assert!(perch.caught, "law {law}: {perch:?}");
    }
}

//! The wrench that a model leaves of measured loads: where it acts, how it is evaluated, what is refused of it.

use std::path::Path;
use wingbeat::math::{Dual, Jet, Quat, Vec3};
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::{Residual, ResidualSpec};
use wingbeat::scenario::Scenario;

/// Fx = 1 + .2 u, with .1 w in its first cosine; Ty = -.05 u w in its second sine.
const SAID: &str = "{ frequency_hz = 9.0, place_m = [-0.1, 0.0, 0.02], low_m_s = [2.0, 0.0, -3.0], high_m_s = [6.0, 0.0, 1.0], terms = [\"1\", \"u\", \"w\", \"uw\"], \
     loads = { Fx = [[1.0, 0.2, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0], [0.0, 0.0, 0.0, 0.0]], \
     Ty = [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, -0.05]] } }";

fn said() -> ResidualSpec {
    let table: toml::Table = toml::from_str(&format!("residual = {SAID}")).unwrap();
    table["residual"].clone().try_into().unwrap()
}

fn scenario(residual: &str) -> Result<Scenario, String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/bank15_beta_lev.toml");
    let mut overrides = vec!["flight.duration_s=0.05".into()];
    if !residual.is_empty() {
        overrides.push(format!("robot.residual={residual}"));
    }
    Scenario::load(&file, &overrides).map_err(|error| error.to_string())
}

const RATE: f64 = std::f64::consts::TAU * 9.0;

#[test]
fn a_wrench_is_its_sum_of_waves_and_terms() {
    let residual = Residual::new(&said()).unwrap();
    let at = |phase: f64, rate: f64, v: [f64; 3]| residual.wrench(&Jet::new(phase, rate, 0.0), Vec3(v));
    let (p, u, w) = (0.7_f64, 4.0, -1.5);
    let seen = at(p, RATE, [u, 0.3, w]);
    let (x, turning) = (1.0 + 0.2 * u + 0.1 * w * p.cos(), -0.05 * u * w * (2.0 * p).sin());
    assert!((seen.force - Vec3([x, 0.0, 0.0])).norm() < 1e-14, "{seen:?}");
    assert!((seen.moment - Vec3([0.0, turning, 0.0])).norm() < 1e-14, "{seen:?}");
    // Beyond the velocities at which it was measured it stays as it is there; it grows with the rate of the wings, and still ones have none.
    assert_eq!(at(p, RATE, [9.0, 5.0, 2.0]), at(p, RATE, [6.0, 0.0, 1.0]));
    assert!((at(p, 0.5 * RATE, [u, 0.0, w]).force[0] - 0.5 * x).abs() < 1e-14);
    assert_eq!(at(p, 0.0, [u, 0.0, w]).force.norm(), 0.0);
    // Its derivatives are those of differences.
    let vary =
        |x: f64, k: usize| Dual::<3> { re: x, eps: std::array::from_fn(|i| f64::from(u8::from(i == k))) };
    let zero = Dual::<3>::constant(0.0);
    let dual = residual
        .wrench(&Jet::new(vary(p, 0), Dual::constant(RATE), zero), Vec3([vary(u, 1), zero, vary(w, 2)]));
    for k in 0..3 {
        let by = |h: f64| {
            let of = |i: usize| if i == k { h } else { 0.0 };
            at(p + of(0), RATE, [u + of(1), 0.0, w + of(2)])
        };
        let difference = by(1e-6) + -by(-1e-6);
        assert!((difference.force[0] * 5e5 - dual.force[0].eps[k]).abs() < 1e-9);
        assert!((difference.moment[1] * 5e5 - dual.moment[1].eps[k]).abs() < 1e-9);
    }
}

#[test]
fn it_acts_on_the_flying_body_and_closes_its_balance() {
    let [without, with] = ["", SAID].map(|residual| scenario(residual).unwrap());
    let [a, b] = [&without, &with].map(Scenario::robot);
    let (x, u) = (without.start(), vec![0.0; a.inputs().len()]);
    let (t, l) = (0.013, *a.layout());
    let [seen_without, seen] = [a, b].map(|robot| robot.observe(t, &x, &u).unwrap());
    let attitude = Quat::from_wxyz(&x[l.attitude..]).matrix();
    // The velocity is that of the place, which the pitch rate moves: -5.9 rad/s times .1 m upward.
    let of_body = attitude.transpose_mul(Vec3::from_slice(&x[l.velocity..]));
    let turning = Vec3::from_slice(&x[l.rate..]).cross(Vec3([-0.1, 0.0, 0.02]));
    assert!(turning[2] < -0.5, "{turning:?}");
    let v = of_body + turning;
    let rate = std::f64::consts::TAU * b.frequency_hz();
    let expected = Residual::new(&said()).unwrap().wrench(&Jet::new(b.phase(t), rate, 0.0), v);
    let added = seen.body_drag + -seen_without.body_drag;
    assert!((added.force - expected.force).norm() < 1e-12 && (added.moment - expected.moment).norm() < 1e-12);
    assert!(expected.force.norm() > 1.0 && expected.moment.norm() > 1e-3);
    // All that acts and the inertia cancel; the power of the joints is the rate of the energy less that of the air.
    let sum = seen.parts().iter().skip(1).fold(seen.parts()[0] + seen.thrust, |sum, part| sum + *part);
    assert!(sum.force.norm() < 1e-9 && sum.moment.norm() < 1e-9, "{sum:?}");
    let energy = |h: f64| {
        let mut dx = vec![0.0; x.len()];
        b.rates_in_numbers(t, &x, &u, &mut dx).unwrap();
        let moved: Vec<f64> = x.iter().zip(&dx).map(|(x, d)| x + h * d).collect();
        b.observe(t + h, &moved, &u).unwrap().energy
    };
    let gained = (energy(1e-6) - energy(-1e-6)) / 2e-6;
    let fed = seen.power + seen.air_power - seen.dissipation;
    assert!((gained - fed).abs() < 1e-4 * fed.abs().max(1.0), "{gained} {fed}");
}

#[test]
fn plans_know_its_derivatives() {
    let with = scenario(SAID).unwrap();
    let (robot, x) = (with.robot(), with.start());
    let u = vec![0.0; robot.inputs().len()];
    let (n, l) = (x.len(), robot.layout());
    let mut exact = Linearisation::new(n, u.len());
    exact.evaluate(robot, 0.013, &x, &u).unwrap();
    for state in [l.velocity + 2, l.rate + 1, l.attitude + 2] {
        let rates = |h: f64| {
            let (mut moved, mut dx) = (x.clone(), vec![0.0; x.len()]);
            moved[state] += h;
            robot.rates_in_numbers(0.013, &moved, &u, &mut dx).unwrap();
            dx[l.rate + 1]
        };
        let difference = (rates(1e-6) - rates(-1e-6)) / 2e-6;
        let slope = exact.a[(l.rate + 1) * n + state];
        assert!(
            (slope - difference).abs() < 2e-5 * (1.0 + difference.abs()),
            "{state}: {slope} {difference}"
        );
    }
}

#[test]
fn what_is_no_wrench_is_refused_with_its_key() {
    let refused = |from: &str, to: &str| scenario(&SAID.replace(from, to)).err().unwrap_or_default();
    for (from, to, told) in [
        ("frequency_hz = 9.0", "frequency_hz = 7.0", "robot.residual.frequency_hz = 7"),
        ("frequency_hz = 9.0", "frequency_hz = 0.0", "robot.residual.frequency_hz = 0"),
        ("\"uw\"]", "\"ux\"]", "robot.residual.terms[3] = \"ux\""),
        ("\"uw\"]", "\"uwww\"]", "robot.residual.terms[3]"),
        ("\"uw\"]", "\"uw\", \"ww\"]", "robot.residual.loads.Fx[0] = 4 factors"),
        ("Fx =", "Fq =", "robot.residual.loads"),
        ("[1.0, 0.2, 0.0, 0.0], ", "", "robot.residual.loads.Fx = 2 rows"),
        ("low_m_s = [2.0", "low_m_s = [7.0", "robot.residual.low_m_s[0] = 7"),
        ("[1.0, 0.2", "[nan, 0.2", "robot.residual.loads.Fx[0][0]"),
        ("\"w\", \"uw\"]", "\"uw\", \"wu\"]", "robot.residual.terms[3] = \"wu\""),
        ("frequency_hz = 9.0", "law = \"stall\", frequency_hz = 9.0", "robot.residual.law = \"stall\""),
        ("frequency_hz = 9.0", "preset = \"paper\", frequency_hz = 9.0", "robot.residual.preset = \"paper\""),
    ] {
        let seen = refused(from, to);
        assert!(seen.contains(told), "{to}: {seen}");
    }
}

#[test]
fn another_air_has_no_wrench_and_a_free_frequency_stays_where_it_was_measured() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/bank15_beta_lev.toml");
    let flown = |more: &str| {
        let overrides = ["flight.duration_s=0.05".into(), format!("robot.residual={SAID}"), more.to_owned()];
        let scenario = Scenario::load(&file, &overrides).unwrap();
        scenario.robot().residual_frequencies()
    };
    let [low, high] = flown("flight.record_every_s=1e-3").unwrap();
    assert!((low - 8.91).abs() < 1e-9 && (high - 9.09).abs() < 1e-9);
    assert_eq!(flown("mismatch.aero={ preset = \"full\", law = \"lev\" }"), None);
    assert_eq!(flown("mismatch.numbers={}"), None);
    assert!(flown("mismatch.mass=1.1").is_some());
}

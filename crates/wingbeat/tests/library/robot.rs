//! The flying robot as a whole: symmetry, momentum, power, derivatives.

use std::ops::ControlFlow;
use wingbeat::aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, Planform, ProfileDrag, SectionSettings, StripModel,
    StripSettings,
};
use wingbeat::math::{Quat, Vec3};
use wingbeat::plant::{Linearisation, LocalChart, Plant};
use wingbeat::robot::{Air, Robot, RobotSpec, Varying, Wind};
use wingbeat::scenario::Document;
use wingbeat::simulate::{Held, Moment, Observed, Stepper};

fn spec(name: &str) -> RobotSpec {
    let path = format!("{}/../../robots/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Document::file(path.as_ref()).unwrap().robot().unwrap()
}

fn robot(name: &str, density: f64) -> Robot {
    let spec = spec(name);
    let wing = spec.wing.as_ref().unwrap();
    let planform = Planform::new(&wing.planform).unwrap();
    let settings = LiftingLineSettings {
        section: SectionSettings {
            density_kg_m3: density,
            law: LiftLaw::Stall,
            drag: ProfileDrag { cd0: wing.cd0, cd90: wing.cd90 },
            ..Default::default()
        },
        ..LiftingLineSettings::default()
    };
    let aero = Aero::LiftingLine(LiftingLine::new(&planform, settings).unwrap());
    Robot::new(&spec, vec![aero], Air { density, wind: Wind::steady(Vec3::ZERO) }, 0.3).unwrap()
}

/// The same with preset `full`, an odd number of strips.
fn robot_of_strips(name: &str, law: LiftLaw) -> Robot {
    let spec = spec(name);
    let wing = spec.wing.as_ref().unwrap();
    let planform = Planform::new(&wing.planform).unwrap();
    let settings = StripSettings {
        strips: 9,
        section: SectionSettings { law, ..Default::default() },
        ..StripSettings::default()
    };
    let aero = Aero::Strip(StripModel::new(&planform, settings).unwrap());
    Robot::new(&spec, vec![aero], Air { density: 1.225, wind: Wind::steady(Vec3::ZERO) }, 0.3).unwrap()
}

fn flying(robot: &Robot, roll: f64) -> Vec<f64> {
    let l = robot.layout();
    let mut x = vec![0.0; l.len];
    Quat::from_roll_pitch_yaw(roll, -0.26, 0.0).store_wxyz(&mut x[l.attitude..]);
    x[l.velocity] = 1.5;
    x
}

#[test]
fn masses_are_those_of_the_robots() {
    assert!((robot("aerobat_paper", 1.2).mass() - 0.020).abs() < 1e-12);
    assert!((robot("aerobat_beta", 1.2).mass() - 0.045).abs() < 1e-12);
}

#[test]
fn a_symmetric_state_stays_symmetric() {
    for name in ["aerobat_paper", "aerobat_beta"] {
        let robot = robot(name, 1.225);
        let (x, l) = (flying(&robot, 0.0), *robot.layout());
        let mut dx = vec![0.0; x.len()];
        robot.rates_in_numbers(0.02, &x, &vec![0.0; robot.inputs().len()], &mut dx).unwrap();
        assert!(dx[l.velocity + 1].abs() < 1e-9, "{name}: side acceleration {}", dx[l.velocity + 1]);
        assert!(dx[l.rate].abs() < 1e-8 && dx[l.rate + 2].abs() < 1e-8, "{name}: {:?}", &dx[l.rate..][..3]);
        assert!(dx[l.velocity + 2].abs() > 0.1);
    }
}

/// In air, the work of the joints and of the air is the change of energy. Without
/// air the joints alone account for it.
#[test]
fn joint_power_is_the_rate_of_energy_in_vacuum() {
    let robot = robot("aerobat_paper", 1e-300);
    let u = [0.2, -0.1, 0.1, 0.3, -0.2, 0.1, 0.25, -0.2];
    let (h, steps) = (1e-4, 400);
    let (mut energies, mut powers) = (Vec::new(), Vec::new());
    let mut watch = Held(|_, at: Moment| {
        let o = robot.observed(at)?;
        energies.push(o.energy);
        powers.push(o.power);
        Ok(ControlFlow::Continue(()))
    });
    let mut stepper = Stepper::new(&robot, 0.0, &flying(&robot, 0.1));
    stepper.set_inputs(&u);
    stepper.run(h, steps, &mut watch).check().unwrap();
    // Simpson's rule over the whole flight.
    let simpson: f64 = (0..=steps)
        .map(|i| powers[i] * if i == 0 || i == steps { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 })
        .sum();
    let (joint_work, change) = (simpson * h / 3.0, energies[steps] - energies[0]);
    let scale = energies.iter().fold(0.0, |m: f64, e| m.max((e - energies[0]).abs()));
    assert!((joint_work - change).abs() < 1e-6 * scale, "work {joint_work} change {change}");
}

#[test]
fn rates_in_the_local_chart_have_exact_derivatives() {
    derivatives_are_exact(&robot("aerobat_paper", 1.225));
    for law in LiftLaw::ALL {
        derivatives_are_exact(&robot_of_strips("aerobat_paper", law));
    }
}

fn derivatives_are_exact(robot: &Robot) {
    let mut x = flying(robot, 0.2);
    let aero = robot.layout().aero;
    x[aero..].iter_mut().enumerate().for_each(|(i, v)| *v = 0.02 * (i as f64).sin());
    let mut chart = LocalChart::new(robot);
    chart.center_at(&flying(robot, 0.1));
    let (n, m) = (chart.states().len(), chart.inputs().len());
    let (mut local, u) = (vec![0.0; n], vec![0.1; m]);
    chart.localise(&x, &mut local);
    let mut exact = Linearisation::new(n, m);
    exact.evaluate(&chart, 0.01, &local, &u).unwrap();
    let (mut up, mut down) = (vec![0.0; n], vec![0.0; n]);
    for j in 0..n {
        let h = 1e-6;
        let mut shifted = local.clone();
        shifted[j] += h;
        chart.rates_in_numbers(0.01, &shifted, &u, &mut up).unwrap();
        shifted[j] -= 2.0 * h;
        chart.rates_in_numbers(0.01, &shifted, &u, &mut down).unwrap();
        for i in 0..n {
            let difference = (up[i] - down[i]) / (2.0 * h);
            let scale = 1.0 + exact.a[i * n + j].abs() + exact.f[i].abs() * 1e-3;
            assert!((exact.a[i * n + j] - difference).abs() < 2e-5 * scale, "row {i} column {j}");
        }
    }
}

#[test]
fn numbers_of_a_mirrored_pair_share_a_name() {
    let robot = robot("aerobat_paper", 1.2);
    let heavier = robot.adjusted(&[("links.twist.mass_kg", 0.005), ("links.twist.com_m[1]", 0.06)]).unwrap();
    assert!((heavier.mass() - 0.022).abs() < 1e-12);
    let value = |name: &str| heavier.named_numbers().into_iter().find(|(n, _)| n == name).unwrap().1;
    assert_eq!((value("links.twist_left.com_m[1]"), value("links.twist_right.com_m[1]")), (0.06, -0.06));

    // A symmetric state stays so; the mass of the whole grows by both.
    let varied =
        robot.varied(&["links.twist.mass_kg", "links.twist_left.mass_kg", "surfaces.wing.cd0"]).unwrap();
    let mass: Vec<f64> = varied
        .numbers()
        .bodies
        .iter()
        .fold(vec![0.0; 3], |sum, body| sum.iter().zip(body.mass.eps).map(|(s, e)| s + e).collect());
    assert_eq!(mass, [2.0, 1.0, 0.0]);

    let text = robot.varied(&["links.hand.mass_kg"]).map(|_| ()).unwrap_err().to_string();
    assert!(text.contains("links.hand.mass_kg") && text.contains("links.twist_left.mass_kg"), "{text}");
}

#[test]
fn varied_numbers_leave_the_values_alone() {
    for robot in [robot("aerobat_paper", 1.2), robot_of_strips("aerobat_paper", LiftLaw::Lev)] {
        let varied = robot.varied(&["surfaces.wing.critical_suction", "air.density_kg_m3"]).unwrap();
        let x = flying(&robot, 0.3);
        let (u, mut plain) = (vec![0.1; robot.inputs().len()], vec![0.0; x.len()]);
        robot.rates_in_numbers(0.05, &x, &u, &mut plain).unwrap();
        let lift = |values: &[f64]| values.iter().map(|v| Varying::constant(*v)).collect::<Vec<_>>();
        let mut with = lift(&plain);
        varied.rates_in_varying(0.05, &lift(&x), &lift(&u), &mut with).unwrap();
        for (a, b) in with.iter().zip(&plain) {
            assert!((a.re - b).abs() <= 1e-11 * (1.0 + b.abs()), "{} {b}", a.re);
        }
        assert!(with.iter().any(|d| d.eps[1] != 0.0));
    }
}

/// A name that is blank, taken, or that of a column of the record is refused where it stands.
#[test]
fn names_of_parts_are_their_own_and_no_column_of_the_record() {
    let scenarios = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
    let glider = wingbeat::scenario::Document::file(&scenarios.join("glider.toml")).unwrap();
    let robot = std::fs::read_to_string(scenarios.join("../robots/glider.toml")).unwrap();
    let refused = |from: &str, to: &str| {
        let text = wingbeat::scenario::Document::text("robot.toml", &robot.replace(from, to)).unwrap();
        let document = glider.clone().put("robot", text).unwrap();
        wingbeat::scenario::Scenario::new(document)
            .err()
            .map_or_else(|| panic!("{to} is taken"), |e| e.to_string())
    };
    let line = |of: &str| 1 + robot.lines().position(|line| line == of).unwrap();
    let joint = line("name = \"elevator\"");
    for (name, column) in [("roll", "roll"), ("t", "t"), ("phase", "phase"), ("com_x", "com_x")] {
        let said = format!(
            "robot.toml:{joint}: robot.links[0].name = \"{name}\": allowed is another name: the record of a flight has a \
             column {column} already"
        );
        assert_eq!(refused("\"elevator\"", &format!("\"{name}\"")), said);
    }
    let base = "allowed is another name: body is the floating base";
    let said = format!("robot.toml:{joint}: robot.links[0].name = \"body\": {base}");
    assert_eq!(refused("\"elevator\"", "\"body\""), said);
    let blank = "allowed is a name that is not blank";
    for (name, from, to, key) in [
        ("", "name = \"elevator\"\n", "name = \"\"\n", "links[0]"),
        (" ", "name = \"tail\"", "name = \" \"", "surfaces[1]"),
        ("", "{ name = \"elevator\"", "{ name = \"\"", "structure.elements[0]"),
    ] {
        let said = refused(from, to);
        assert!(
            said.starts_with("robot.toml:")
                && said.ends_with(&format!(": robot.{key}.name = \"{name}\": {blank}")),
            "{said}"
        );
    }
    let fin = line("name = \"fin\"");
    let taken =
        "robot.surfaces[2].name = \"tail\": allowed is a name of its own: surfaces[1].name is the same";
    assert_eq!(refused("name = \"fin\"", "name = \"tail\""), format!("robot.toml:{fin}: {taken}"));
}

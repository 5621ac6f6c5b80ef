//! Springs on the pins of the linkage: work, energy, statics, names and refusals.

use super::mechanism::{Preset, moving, robot};
use std::ops::ControlFlow;
use wingbeat::body::{Linkage, LinkageDimensions, LinkagePin};
use wingbeat::guide::Stand;
use wingbeat::judge::Status;
use wingbeat::math::{Jet, Mat3, RK4, Scalar, Vec3, Workspace};
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::{Air, BodyMotion, Robot, Wind};
use wingbeat::scenario::{Document, RigRun, Scenario};

const BETA: &str = include_str!("../../../../robots/aerobat_beta.toml");
const SPRINGS: &str = "springs = [
  { pin = \"elbow\", stiffness = 2e-3, damping = 1e-5 },
  { pin = \"coupler_rod\", stiffness = 1e-3, rest = 0.3 },
  { pin = \"bell_crank\", stiffness = 3e-3, damping = 2e-5, limit = 0.5 },
]\n";
const MOTOR: &str = "[drive.motor]\nstall_torque_n_m = 6e-3\nno_load_speed_rad_s = 2500.0\ngear_ratio = 60.0\n\
                     rotor_inertia_kg_m2 = 4e-9\ncrank_inertia_kg_m2 = CRANK\n";

/// Aerobat with `springs` in its linkage, its crank under a motor of the inertia `crank` kg m2, its lengths on elements that weigh
/// `mass` kg.
fn text(springs: &str, crank: Option<f64>, mass: Option<f64>) -> String {
    let (before, _) = BETA.split_once("[structure]").unwrap();
    let before = before.replace("frequency_hz = 3.5 ", &format!("{springs}frequency_hz = 3.5 "));
    let inertia = mass.map_or(String::new(), |mass| format!(", inertia = {mass:?}"));
    let elements = ["l3b_left", "l5a_left", "l5b_right"]
        .map(|length| format!("  {{ name = \"{length}\", moves = [\"{length}\"]{inertia} }},\n"));
    let motor = crank.map_or(String::new(), |crank| MOTOR.replace("CRANK", &format!("{crank:?}")));
    format!(
        "{before}{motor}[structure]\nfrequency_hz = 12.0\ndamping = 0.4\nelements = [\n{}]\n",
        elements.concat()
    )
}

fn aerobat(springs: &str, crank: Option<f64>, mass: Option<f64>) -> Robot {
    robot(&text(springs, crank, mass), Preset::Paper, 1.2)
}

/// In flight with all in motion: lengths by tenths of a millimetre, the crank at a rate of its own.
fn in_flight(robot: &Robot) -> Vec<f64> {
    let (l, mut x) = (*robot.layout(), moving(robot));
    x[l.structure..l.joints].iter_mut().for_each(|x| *x *= 4e-3);
    if let Some([angle, rate]) = l.crank {
        (x[angle], x[rate]) = (1.1, 20.0);
    }
    x
}

fn rates_under(robot: &Robot, x: &[f64], u: &[f64]) -> Vec<f64> {
    let mut dx = vec![0.0; x.len()];
    robot.rates_in_numbers(0.05, x, u, &mut dx).unwrap();
    dx
}

fn rates(robot: &Robot, x: &[f64]) -> Vec<f64> {
    rates_under(robot, x, &U)
}

const U: [f64; 3] = [4e-4, -3e-4, 2e-4];

#[test]
fn pins_turn_as_the_bodies_that_they_join() {
    use LinkagePin::*;
    let linkage = Linkage::new(LinkageDimensions::default()).unwrap();
    for k in 0..50 {
        let pose = linkage.pose(Jet::new(0.13 * f64::from(k), 22.0, 5.0), [Jet::ZERO; 3]).unwrap();
        let angle = |pin: LinkagePin| pin.angle(&pose.directions, linkage.pin_middle(pin));
        let sums = [
            (angle(Shoulder) + angle(Elbow), pose.radius),
            (
                angle(Shoulder) + angle(CouplerRod) + angle(RodBellCrank),
                angle(BellCrank) + angle(CouplerHumerus),
            ),
            (angle(BellCrank) + angle(BellCrankRod) + angle(RodRadius), pose.radius),
        ];
        for (one, other) in sums {
            let turns = (one.x - other.x) / std::f64::consts::TAU;
            assert!((turns - turns.round()).abs() < 1e-12, "{k}: {turns}");
            assert!((one.d - other.d).abs() < 1e-11 && (one.dd - other.dd).abs() < 1e-8, "{k}");
        }
    }
}

/// On a heavy crank and heavy elements a spring's effort along them is their inertia times what it adds to their accelerations: the
/// slope of the energy stored, by differences.
#[test]
fn springs_on_pins_load_crank_and_lengths_by_virtual_work() {
    let (crank, mass) = (1e3, 1e7);
    let undamped = SPRINGS.replace("damping", "# damping");
    let undamped: String = undamped.replace(", # damping = 1e-5", "").replace(", # damping = 2e-5", "");
    let [with, without] = [undamped.as_str(), ""].map(|springs| aerobat(springs, Some(crank), Some(mass)));
    let (l, x) = (*with.layout(), in_flight(&with));
    // Commands under which the actuators alone would leave the elements as they are.
    let settled =
        |e: usize| x[l.structure + e] + 0.8 * x[l.structure + 3 + e] / (12.0 * std::f64::consts::TAU);
    let u = [0, 1, 2].map(settled);
    let [moved, still] = [&with, &without].map(|robot| rates_under(robot, &x, &u));
    let stored = |at: usize, by: f64| {
        let mut x = x.clone();
        x[at] += by;
        let [with, without] = [&with, &without].map(|robot| robot.observe(0.05, &x, &U).unwrap().energy);
        with - without
    };
    let elements = (l.joints - l.structure) / 2;
    let [angle, rate] = l.crank.unwrap();
    let all = (0..elements).map(|e| (l.structure + e, l.structure + elements + e, mass, 1e-6));
    for (at, rate, inertia, h) in all.chain([(angle, rate, crank, 1e-4)]) {
        let slope = (8.0 * (stored(at, h) - stored(at, -h)) - (stored(at, 2.0 * h) - stored(at, -2.0 * h)))
            / (12.0 * h);
        let effort = inertia * (moved[rate] - still[rate]);
        assert!((effort + slope).abs() < 5e-6 * slope.abs() && slope != 0.0, "{at}: {effort} {slope}");
    }
}

#[test]
fn drives_dampers_and_springs_on_pins_account_for_the_energy() {
    for (crank, mass) in [(None, None), (None, Some(0.05)), (Some(1e-5), None), (Some(1e-5), Some(0.05))] {
        let robot = aerobat(SPRINGS, crank, mass);
        let (t, h) = (0.05, 1e-5);
        let seen = robot.observe(t, &in_flight(&robot), &U).unwrap();
        let energy = |h: f64| {
            let mut x = in_flight(&robot);
            let mut work = Workspace::new(x.len(), RK4.b.len());
            RK4.step(|t, x, dx| robot.rates_in_numbers(t, x, &U, dx), t, h, &mut x, &mut work).unwrap();
            robot.observe(t + h, &x, &U).unwrap().energy
        };
        let slope = (8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h))) / (12.0 * h);
        let power = seen.power + seen.air_power - seen.dissipation;
        assert!((slope - power).abs() < 1e-7 * power.abs().max(0.1), "{crank:?} {mass:?}: {slope} {power}");
        let parts = seen.drive_power + seen.regulator_power;
        assert!((parts - seen.power).abs() < 1e-9 * seen.power.abs(), "{parts} {}", seen.power);
    }
}

/// Over a turn of a crank under a motor, lengths on elements that the loads push: the change of the energy is what drive and actuators
/// give and the air and the dampers take, by Simpson's rule over the steps.
#[test]
fn the_energy_of_a_cycle_closes() {
    // Lighter elements are pushed beyond the ranges of their lengths, where these stop all at once.
    let robot = aerobat(SPRINGS, Some(1e-5), Some(200.0));
    let (mut x, steps) = (in_flight(&robot), 4000);
    let step = 1.0 / (robot.frequency_hz() * f64::from(steps));
    let mut work = Workspace::new(x.len(), RK4.b.len());
    let (mut given, mut size, mut energies) = (0.0, 0.0, [0.0; 2]);
    for k in 0..=steps {
        let t = f64::from(k) * step;
        let seen = robot.observe(t, &x, &U).unwrap();
        let power = seen.power + seen.air_power - seen.dissipation;
        let weight = if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) } * step / 3.0;
        given += weight * power;
        size += weight * (seen.power.abs() + seen.air_power.abs() + seen.dissipation);
        if k == 0 || k == steps {
            energies[usize::from(k > 0)] = seen.energy;
        }
        if k < steps {
            RK4.step(|t, x, dx| robot.rates_in_numbers(t, x, &U, dx), t, step, &mut x, &mut work).unwrap();
        }
    }
    let missing = energies[1] - energies[0] - given;
    assert!(missing.abs() < 1e-8 * size, "{missing} of {size}");
}

/// At a constant rate the crank gives the springs over a turn what the dampers take, and in between more either way.
#[test]
fn over_a_cycle_springs_give_back_what_they_take() {
    let [with, without] = [SPRINGS, ""].map(|springs| aerobat(springs, None, None));
    let (mut x, cycle, count) = (in_flight(&with), 1.0 / with.frequency_hz(), 400);
    let l = *with.layout();
    x[l.structure..l.joints].fill(0.0);
    let mut sums = [0.0; 3];
    for k in 0..count {
        let t = cycle * f64::from(k) / f64::from(count);
        let [a, b] = [&with, &without].map(|robot| robot.observe(t, &x, &U).unwrap());
        let given = a.drive_power - b.drive_power;
        for (sum, part) in sums.iter_mut().zip([given, a.dissipation, given.abs()]) {
            *sum += part / f64::from(count);
        }
        assert_eq!(a.regulator_power, b.regulator_power);
    }
    let [mean, lost, size] = sums;
    assert!(lost > 0.0 && size > 2.0 * lost, "{sums:?}");
    assert!((mean - lost).abs() < 1e-10 * size, "{sums:?}");
}

#[test]
fn springs_of_no_stiffness_change_no_bit() {
    let idle =
        "springs = [{ pin = \"elbow\", stiffness = 0.0 }, { pin = \"rod_radius\", stiffness = 0.0 }]\n";
    for (crank, mass) in [(None, None), (Some(1e-5), Some(0.05))] {
        let [with, without] = [idle, ""].map(|springs| aerobat(springs, crank, mass));
        let x = in_flight(&with);
        assert_eq!(rates(&with, &x), rates(&without, &x));
        let [a, b] = [&with, &without].map(|robot| robot.observe(0.05, &x, &U).unwrap());
        assert_eq!(
            (a.power, a.energy, a.drive_power, a.dissipation),
            (b.power, b.energy, b.drive_power, b.dissipation)
        );
        assert_eq!((a.pins.len(), b.pins.len()), (4, 0));
    }
}

/// A length on an element with an inertia, the crank still, gravity along the hinges, no air: its actuator and the spring hold each other.
#[test]
fn a_spring_moves_a_length_to_where_statics_says() {
    let (mass, stiffness, command) = (0.05, 2e-3, 3e-4);
    let springs = format!("springs = [{{ pin = \"elbow\", stiffness = {stiffness:?}, rest = -0.2 }}]\n");
    let text = text(&springs, None, None)
        .replace("frequency_hz = 3.5 ", "frequency_hz = 0.0 ")
        .replace("[\"l3b_left\"]", &format!("[\"l3b_left\"], inertia = {mass:?}"));
    let robot = robot(&text, Preset::Paper, 1.2).in_vacuum();
    let nose_up = BodyMotion::steady(Mat3([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), Vec3::ZERO);
    let pull = |y: f64| {
        let mut x = robot.carried_still();
        x[0] = y;
        let mut dx = vec![0.0; x.len()];
        robot.carried(&Jet::default(), &nose_up, &x, &[command, 0.0, 0.0], &mut dx).unwrap();
        dx[3]
    };
    let (mut low, mut high) = (-5e-4, 2e-3);
    assert!(pull(low) > 0.0 && pull(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if pull(middle) > 0.0 { low = middle } else { high = middle }
    }
    let y = 0.5 * (low + high);
    let linkage = Linkage::new(LinkageDimensions::default()).unwrap();
    let pose =
        linkage.pose(Jet::from(robot.phase(0.0)), [Jet::new(y, 1.0, 0.0), Jet::ZERO, Jet::ZERO]).unwrap();
    let elbow = pose.radius - pose.humerus;
    let actuator = mass * (12.0 * std::f64::consts::TAU).powi(2) * (command - y);
    let spring = stiffness * (elbow.x + 0.2) * elbow.d;
    assert!((actuator - spring).abs() < 1e-9 * spring.abs(), "{actuator} {spring}");
    assert!((y / command - 1.0).abs() > 0.05, "{y} moved by the spring");
}

#[test]
fn derivatives_through_springs_on_pins_are_exact() {
    for (crank, mass) in [(Some(1e-5), None), (Some(1e-5), Some(0.05))] {
        let robot = aerobat(SPRINGS, crank, mass);
        let (x, n, m) = (in_flight(&robot), robot.states().len(), robot.inputs().len());
        let mut exact = Linearisation::new(n, m);
        exact.evaluate(&robot, 0.05, &x, &U).unwrap();
        let l = robot.layout();
        let [angle, rate] = l.crank.unwrap();
        for (j, h) in
            [(l.structure, 1e-8), (l.structure + 4, 1e-6), (angle, 1e-6), (rate, 1e-5), (l.velocity, 1e-6)]
        {
            let at = |by: f64| {
                let mut x = x.clone();
                x[j] += by;
                rates(&robot, &x)
            };
            let (up, down) = (at(h), at(-h));
            for i in 0..n {
                let (difference, exact) = ((up[i] - down[i]) / (2.0 * h), exact.a[i * n + j]);
                let scale = 1.0 + exact.abs() + 1e-3 * up[i].abs() / h * 1e-6;
                assert!((difference - exact).abs() < 1e-5 * scale, "d{i}/d{j}: {difference} {exact}");
            }
        }
    }
}

#[test]
fn numbers_of_springs_on_pins_have_names() {
    let robot = aerobat(SPRINGS, Some(1e-5), None);
    let names: Vec<String> = robot.named_numbers().into_iter().map(|(name, _)| name).collect();
    let of = |end: &str| format!("linkage.springs.coupler_rod.{end}");
    assert!(["stiffness", "damping", "rest"].iter().all(|end| names.contains(&of(end))), "{names:?}");
    let x = in_flight(&robot);
    for (key, h) in [("stiffness", 1e-5), ("damping", 1e-6), ("rest", 1e-4)].map(|(end, h)| (of(end), h)) {
        let own = robot.named_numbers().iter().find(|(name, _)| *name == key).unwrap().1;
        let at = |value: f64| rates(&robot.adjusted(&[(&key, value)]).unwrap(), &x);
        let (up, down) = (at(own + h), at(own.max(h) - h));
        let width = own + h - (own.max(h) - h);
        let varied = robot.varied(&[&key]).unwrap();
        let [state, command] = [x.as_slice(), &U]
            .map(|of| of.iter().map(|x| wingbeat::robot::Varying::constant(*x)).collect::<Vec<_>>());
        let mut dx = state.clone();
        varied.state_rates(wingbeat::robot::Varying::constant(0.05), &state, &command, &mut dx).unwrap();
        let [_, rate] = robot.layout().crank.unwrap();
        let (difference, exact) = ((up[rate] - down[rate]) / width, dx[rate].eps[0]);
        assert!(
            exact != 0.0 && (difference - exact).abs() < 1e-6 * exact.abs(),
            "{key}: {difference} {exact}"
        );
    }
    let file = aerobat(&SPRINGS.replace("1e-3, rest", "4e-3, rest"), Some(1e-5), None);
    assert_eq!(rates(&file, &x), rates(&robot.adjusted(&[(&of("stiffness"), 4e-3)]).unwrap(), &x));
    let wound = robot.adjusted(&[(&of("rest"), 9.0)]).map(drop).unwrap_err().to_string();
    assert!(wound.contains("linkage.springs.coupler_rod.rest") && wound.contains("half a turn"), "{wound}");
}

/// A wing's springs take back what those of the other give: apart they cost more than together, where both sides move apart.
#[test]
fn drives_that_share_nothing_feed_the_springs_of_each_wing() {
    let robot = aerobat(SPRINGS, None, None);
    let x = in_flight(&robot);
    let [with, without] =
        [&robot, &aerobat("", None, None)].map(|robot| robot.observe(0.05, &x, &U).unwrap());
    let l = robot.layout();
    let clock = Jet::new(0.05, 1.0, 0.0);
    let work = robot.carried_pins(&clock, (&x[l.structure..], &U)).unwrap();
    assert!((work.by_wing[0] - work.by_wing[1]).abs() > 1e-3 * work.by_wing[0].abs());
    let both = work.by_wing[0] + work.by_wing[1];
    assert!((both - work.given[0] - work.given[1]).abs() < 1e-12 && (both - with.pin_power).abs() < 1e-12);
    let added = with.separate_power - without.separate_power;
    let exact: f64 = work.by_wing.iter().map(|power| power.max(0.0)).sum();
    assert!((added - exact).abs() < 1e-12, "{added} {exact}");
}

/// The springs of a run on the rig, crank at an even rate: its record has angles and power, and over cycles the power is the rate of the energy
/// stored with what dampers lose; the summary is that of a flight.
#[test]
fn springs_on_a_rig_are_told_as_those_of_a_flight() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let spring = "{ pin = 'coupler_rod', stiffness = STIFF, damping = 2e-5, limit = 2.0 }";
    let open = |stiffness: &str| {
        let springs = format!("rig.robot.gait.linkage.springs=[{}]", spring.replace("STIFF", stiffness));
        let set = [
            format!("rig.robot={}", root.join("robots/aerobat_beta.toml").display()),
            springs,
            "rig.cell.rate_hz=3500.0".into(),
            "rig.rest_s=0.1".into(),
        ];
        let document = Document::file(&root.join("rigs/runs/bench.toml")).unwrap();
        let document = set.iter().fold(document, |document, set| document.set(set.as_str()));
        RigRun::new(document, &|_, _| None).unwrap()
    };
    let run = open("1e-3");
    let simulated = run.simulated(0, |_| {}).unwrap();
    let record = simulated.record.as_ref().unwrap();
    let column = |name: &str| record.values(name).unwrap();
    let (t, power) = (column("t"), column("pin_power"));
    let angles = ["pin_coupler_rod_left", "pin_coupler_rod_right"].map(column);
    let rest =
        aerobat(&format!("springs = [{}]\n", "{ pin = \"coupler_rod\", stiffness = 1e-3 }"), None, None)
            .named_numbers()
            .into_iter()
            .find(|(name, _)| name == "linkage.springs.coupler_rod.rest")
            .unwrap()
            .1;
    let stored = |k: usize| angles.iter().map(|angle| 0.5e-3 * (angle[k] - rest).powi(2)).sum::<f64>();
    let (first, last) = (t.iter().position(|t| *t >= 0.5).unwrap(), t.len() - 1);
    let (mut given, mut lost) = (0.0, 0.0);
    for k in first..last {
        let h = t[k + 1] - t[k];
        given += 0.5 * h * (power[k] + power[k + 1]);
        lost += angles.iter().map(|angle| 2e-5 * (angle[k + 1] - angle[k]).powi(2) / h).sum::<f64>();
    }
    let size = power[first..].iter().fold(0.0_f64, |most, power| most.max(power.abs()));
    let off = (given - lost - (stored(last) - stored(first))).abs();
    assert!(lost > 0.0 && off < 1e-3 * given.abs().max(1e-3 * size), "{given} {lost} {off}");
    let pins = simulated.summary(&run).pin_springs.unwrap();
    assert!((pins.power_max_w - power.iter().copied().fold(0.0, f64::max)).abs() < 1e-15);
    assert!(pins.power_mean_w > 0.0 && pins.deflection_max_deg > 1.0 && pins.limit_fraction.unwrap() < 1.0);
    let wound = open("1e11").simulated(0, |_| {}).unwrap();
    assert!(wound.verdict.reason.unwrap().contains("trim.peak_power_w_kg"));
}

/// What no drive gives is told in a flight that is shorter than a cycle.
#[test]
fn absurd_springs_end_a_short_flight_outside() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/cruise_linkage.toml");
    let status = |stiffness: &str| {
        let springs = format!("robot.gait.linkage.springs=[{{pin='coupler_rod', stiffness={stiffness}}}]");
        let set = ["flight.duration_s=0.02".to_owned(), springs];
        let run = Scenario::load(&path, &set).unwrap().fly(|_| ControlFlow::Continue(())).unwrap();
        (run.summary.status, run.summary.reason.unwrap_or_default())
    };
    let (absurd, reason) = status("1e11");
    assert!(absurd == Status::Outside && reason.contains("trim.peak_power_w_kg"), "{absurd} {reason}");
    assert_eq!(status("1e-3").0, Status::NotJudged);
}

#[test]
fn a_rest_in_the_middle_of_the_travel_follows_the_linkage() {
    let springs = "springs = [{ pin = \"bell_crank\", stiffness = 1e-3 }]\n";
    let turned = [("linkage.turned_deg", 64.178)];
    let robot = aerobat(springs, Some(1e-5), None);
    let own = |robot: &Robot| {
        let numbers = robot.named_numbers();
        numbers.into_iter().find(|(name, _)| name == "linkage.springs.bell_crank.rest").unwrap().1
    };
    let by_number = robot.adjusted(&turned).unwrap();
    let before = own(&robot);
    assert!((own(&by_number) - before).abs() > 1e-3, "{before}");
    // A rest that was given stays.
    let given = aerobat(&springs.replace("1e-3 }", "1e-3, rest = 0.3 }"), Some(1e-5), None);
    assert_eq!(own(&given.adjusted(&turned).unwrap()), 0.3);
}

#[test]
fn springs_that_no_linkage_has_are_refused_by_key() {
    let refused = |springs: &str| {
        let air = Air { density: 1.2, wind: Wind::steady(Vec3::ZERO) };
        match Document::text("robot", &text(springs, None, None)).and_then(|document| document.robot()) {
            Ok(spec) => Robot::new(&spec, Vec::new(), air, 0.0).unwrap_err().to_string(),
            Err(error) => error.to_string(),
        }
    };
    for (springs, words) in [
        ("{ pin = \"crank\", stiffness = 1e-3 }", &["crank", "shoulder", "coupler_rod", "rod_radius"][..]),
        ("{ pin = \"elbow\", stiffness = -1e-3 }", &["gait.linkage.springs[0].stiffness"]),
        ("{ pin = \"elbow\", stiffness = 1e-3, limit = 0.0 }", &["gait.linkage.springs[0].limit"]),
        (
            "{ pin = \"elbow\", stiffness = 1e-3, limit = 1e11 }",
            &["gait.linkage.springs[0].limit", "3.14159"],
        ),
        ("{ pin = \"elbow\", stiffness = nan }", &["gait.linkage.springs[0].stiffness"]),
        (
            "{ pin = \"elbow\", stiffness = 1e-3, rest = 9.0 }",
            &["gait.linkage.springs[0].rest", "half a turn"],
        ),
        (
            "{ pin = \"elbow\", stiffness = 1e-3 }, { pin = \"elbow\", stiffness = 1e-3 }",
            &["gait.linkage.springs[1].pin", "no spring yet"],
        ),
    ] {
        let message = refused(&format!("springs = [{springs}]\n"));
        assert!(words.iter().all(|word| message.contains(word)), "{springs}: {message}");
    }
    let refused =
        Stand::new(&aerobat(SPRINGS, None, None), Vec3::new(3.0, 0.0, 0.0), 0.0).err().unwrap().to_string();
    assert!(refused.starts_with("robot.gait.linkage.springs"), "{refused}");
}

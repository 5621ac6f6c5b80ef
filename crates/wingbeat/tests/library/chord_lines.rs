//! Chord lines of a robot beside its recorded outline.

use wingbeat::math::Vec3;
use wingbeat::plant::Plant;
use wingbeat::scenario::Scenario;

#[test]
fn chord_lines_are_those_of_the_outline_and_move_as_they_say() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
    let scenario = Scenario::load(path.as_ref(), &["start.yaw_deg=20.0".into()]).unwrap();
    let (robot, mut x) = (scenario.robot(), scenario.start());
    let u = vec![0.0; robot.inputs().len()];
    x[robot.layout().structure..robot.layout().aero].iter_mut().enumerate().for_each(|(i, y)| {
        *y = 0.02 * (i as f64 - 3.0);
    });
    let t = 0.07;
    let seen = robot.observe(t, &x, &u).unwrap();
    let outlines = scenario.spec.robot.outlines().unwrap();
    let planform = &outlines[0].planform;
    let tip = planform.half_span();
    let arcs = [tip, 0.5 * tip, 0.3 * tip, -0.7 * tip, -tip];
    let mut lines = Vec::new();
    robot.chord_lines(&robot.stance(t, &x), 0, &arcs, &mut lines).unwrap();
    let place = Vec3::from_slice(&x[robot.layout().position..]);
    for (line, end) in [(&lines[0], &seen.outlines[0][0]), (&lines[4], seen.outlines[0].last().unwrap())] {
        assert!((line.le - (place + seen.attitude * end[1])).norm() < 1e-14);
        assert!((line.te - (place + seen.attitude * end[2])).norm() < 1e-14);
    }
    // The velocities are those that the rates of the states give.
    let mut dx = vec![0.0; x.len()];
    robot.rates_in_numbers(t, &x, &u, &mut dx).unwrap();
    let h = 1e-5;
    let moved = |h: f64| {
        let x: Vec<f64> = x.iter().zip(&dx).map(|(x, dx)| x + h * dx).collect();
        let mut lines = Vec::new();
        robot.chord_lines(&robot.stance(t + h, &x), 0, &arcs, &mut lines).unwrap();
        lines
    };
    for (line, (after, before)) in lines.iter().zip(moved(h).iter().zip(&moved(-h))) {
        let by_difference = (after.te - before.te) * (0.5 / h);
        assert!((line.v_te - by_difference).norm() < 1e-5 * line.v_te.norm(), "{line:?} {by_difference:?}");
    }
}

/// On a spar that is not bent a web is that of the rigid plate; on one that is, the chord lines of two pieces differ at their joint by what
/// they differ by without it.
#[test]
fn a_web_goes_on_over_the_pieces_of_a_spar() {
    let lines = |name: &str, web: f64, bent: f64, arcs: &[f64]| {
        let path = format!("{}/../../scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let mut set = vec![
            "start.velocity_m_s=[3.5, 0.0, -0.4]".to_owned(),
            "start.nose_up_deg=9.0".into(),
            "start.rate_rad_s=[0.0, -2.0, 0.0]".into(),
            format!("robot.surfaces[0].panels[2].web_m={web}"),
        ];
        if name == "soft_20g" {
            let gait = "robot.links.elbow.driven.mean_rad=-0.1737";
            set.extend(["robot.links[2].spar.segments=4", "aero.full.strips=24", gait].map(String::from));
        }
        let scenario = Scenario::load(path.as_ref(), &set).unwrap();
        let (robot, mut x, layout) = (scenario.robot(), scenario.start(), *scenario.robot().layout());
        let joints = &mut x[layout.joints..layout.aero];
        let coordinates = joints.len() / 2;
        joints[..coordinates]
            .iter_mut()
            .enumerate()
            .for_each(|(i, angle)| *angle = bent * (1.0 + 0.1 * i as f64));
        let mut lines = Vec::new();
        robot.chord_lines(&robot.stance(0.05, &x), 0, arcs, &mut lines).unwrap();
        lines
    };
    let web = 0.0544457;
    let arcs: Vec<f64> = (1..40).flat_map(|k| [0.005 * k as f64, -0.005 * k as f64]).collect();
    for (soft, rigid) in lines("soft_20g", web, 0.0, &arcs).iter().zip(lines("cruise_20g", web, 0.0, &arcs)) {
        for (a, b) in
            [(soft.le, rigid.le), (soft.te, rigid.te), (soft.v_le, rigid.v_le), (soft.v_te, rigid.v_te)]
        {
            assert!((a - b).norm() < 1e-12, "{soft:?} {rigid:?}");
        }
    }
    // The first two joints lie within the web.
    for joint in [0.0707 + 0.0165, 0.0707 + 0.0495] {
        let beside = [joint - 1e-7, joint + 1e-7];
        let jump = |web: f64| {
            let found = lines("soft_20g", web, 0.05, &beside);
            [found[1].le - found[0].le, found[1].te - found[0].te]
        };
        let (with, without) = (jump(web), jump(0.0));
        assert!(without[1].norm() > 1e-3, "{without:?}");
        for (a, b) in with.iter().zip(&without) {
            assert!((*a - *b).norm() < 1e-6, "{with:?} {without:?}");
        }
    }
}

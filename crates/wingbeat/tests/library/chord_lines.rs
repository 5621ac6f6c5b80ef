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

use std::f64::consts::PI;
use std::path::Path;

use wingbeat_config::inside::AirfoilFile;

/// Both sides of a NACA four-digit section of 12 % thickness, at cosine stations from the nose on (NACA Rep. 460).
fn naca(camber: f64, at: f64) -> [Vec<[f64; 2]>; 2] {
    let side = |sign: f64| {
        let point = |k: usize| {
            let x = 0.5 * (1.0 - (PI * k as f64 / 80.0).cos());
            let (z, slope) = if x < at {
                (camber / (at * at) * (2.0 * at * x - x * x), 2.0 * camber / (at * at) * (at - x))
            } else {
                let rest = (1.0 - at) * (1.0 - at);
                (camber / rest * (1.0 - 2.0 * at + 2.0 * at * x - x * x), 2.0 * camber / rest * (at - x))
            };
            let thick = 0.6
                * (0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x.powi(2) + 0.2843 * x.powi(3)
                    - 0.1015 * x.powi(4));
            let (sin, cos) = slope.atan().sin_cos();
            [x - sign * thick * sin, z + sign * thick * cos]
        };
        (0..=80).map(point).collect::<Vec<_>>()
    };
    [side(1.0), side(-1.0)]
}

fn lines(points: impl Iterator<Item = [f64; 2]>) -> String {
    points.map(|[x, y]| format!(" {x:.6} {y:.6}\n")).collect()
}

fn angle(text: &str) -> Result<f64, String> {
    let toml = AirfoilFile::toml(Path::new("a.dat"), text, "wing.section.zero_lift_angle_deg");
    toml.map(|toml| toml[2..].parse().unwrap()).map_err(|wrong| wrong.to_string())
}

/// Thin-airfoil theory gives the camber lines of NACA 2412 and 4412 -2.077 and -4.153 deg (Abbott & von Doenhoff 1959, ch. 4). The
/// middle between the sides at equal x is off those lines by the slope of half the thickness squared, here up to 4 % of the angle.
#[test]
fn selig_and_lednicer_files_give_the_angle_of_thin_airfoil_theory() {
    for (camber, expected) in [(0.02, -2.077), (0.04, -4.153), (0.0, 0.0_f64)] {
        let [upper, lower] = naca(camber, 0.4);
        let selig = format!("NACA\n{}", lines(upper.iter().rev().chain(&lower[1..]).copied()));
        let [above, below] = [&upper, &lower].map(|side| lines(side.iter().copied()));
        let lednicer = format!("NACA\n 81. 81.\n\n{above}\n{below}");
        for text in [selig, lednicer] {
            let found = angle(&text).unwrap();
            assert!((found - expected).abs() <= 0.04 * f64::abs(expected), "{found}, not {expected}");
        }
    }
}

/// A section turned nose up, deg.
fn turned(angle_deg: f64) -> String {
    let [upper, lower] = naca(0.02, 0.4);
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let turn = |point: &[f64; 2]| [point[0] * cos + point[1] * sin, point[1] * cos - point[0] * sin];
    lines(upper.iter().rev().chain(&lower[1..]).map(turn))
}

#[test]
fn a_pair_before_the_points_counts_only_what_follows() {
    let expected = angle(&turned(0.0)).unwrap();
    let [upper, lower] = naca(0.02, 0.4);
    let hundred = lines(upper.iter().rev().chain(&lower[1..]).map(|[x, y]| [100.0 * x, 100.0 * y]));
    for text in [
        format!("4412 12\n{}", turned(0.0)),
        format!("100 2\n{}", turned(0.0)),
        format!("23012 of a book\nx y\n{}", turned(0.0)),
        hundred.clone(),
    ] {
        assert!((angle(&text).unwrap() - expected).abs() < 1e-3, "{text}");
    }
    // A blunt end of 4 mm in millimetres: its first point is no count.
    let end = upper[80][1];
    let blunt = |sign: f64| move |[x, y]: &[f64; 2]| [100.0 * x, 100.0 * y + sign * (2.0 - 100.0 * end) * x];
    let sides = upper.iter().rev().map(blunt(1.0)).chain(lower[1..].iter().map(blunt(-1.0)));
    let inside = lines(sides.skip(1).take(159));
    assert!((angle(&format!("100 2\n{inside}100 -2\n")).unwrap() - expected).abs() < 0.05);
    // Turned a little it is read, and its angle is of the x axis.
    assert!((angle(&turned(0.9)).unwrap() - expected + 0.9).abs() < 0.05);
    let immense = naca(0.0, 0.4)
        .map(|side| side.into_iter().map(|[x, y]| [1e-300 * x, 9e4 * x * (1.0 - x) + y]).collect::<Vec<_>>());
    let [upper, lower] = immense;
    let text: String = upper.iter().rev().chain(&lower[1..]).map(|[x, y]| format!("{x:e} {y:e}\n")).collect();
    let error = angle(&text).unwrap_err();
    assert!(
        error.contains("a.dat:1: ") && error.contains("zero-lift angle is between -30 and 30"),
        "{error}"
    );
}

#[test]
fn what_is_no_section_is_refused_by_line() {
    let [upper, lower] = naca(0.02, 0.4);
    let selig = lines(upper.iter().rev().chain(&lower[1..]).copied());
    for (text, said) in [
        (
            String::new(),
            "a.dat:1: wing.section.zero_lift_angle_deg.airfoil = 0 points: allowed is coordinates",
        ),
        (
            format!("{selig}nan 0\n"),
            "a.dat:162: wing.section.zero_lift_angle_deg.airfoil = nan 0: allowed is x and y",
        ),
        (
            format!("n\n{selig}0.5 0.0\n"),
            "a.dat:163: wing.section.zero_lift_angle_deg.airfoil = 0.5 0: allowed is x that",
        ),
        (
            format!("n\n81 79\n{selig}"),
            "a.dat:2: wing.section.zero_lift_angle_deg.airfoil = 81 79: allowed is the numbers",
        ),
        (lines(upper.into_iter()), "five points or more on each side"),
        ("1 0\n".repeat(20_002), "at most 20000 points"),
        ("1 0\n".repeat(12), "five points or more"),
        (selig.replacen("1.0", "1.O", 1), "a.dat:1: wing.section.zero_lift_angle_deg.airfoil = 1.O"),
        (format!("n\n1.0000x 0\n{selig}"), "a.dat:2: "),
        (format!("n\nl.00000 0.00\n{selig}"), "a.dat:2: "),
        (turned(10.0), "a chord along the x axis, within 1 deg; from end to end it rises by -"),
    ] {
        let error = angle(&text).unwrap_err();
        assert!(error.contains(said), "{error}\nnot: {said}");
    }
}

//! Zero-lift angles from coordinates of sections: `zero_lift_angle_deg = { airfoil = "naca2412.dat" }` stands for the angle of the
//! camber line in the file.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use wingbeat_aero::ThinSection;

use super::{ConfigError, Place, Problem, Wrong};

/// The key of the angle.
pub const KEY: &str = "zero_lift_angle_deg";
/// Fewest and most points of one side of a section. *Choice.*
const FEWEST: usize = 5;
const MOST: usize = 10_000;
/// Stations of the camber line, closer at both ends. *Choice.*
const STATIONS: usize = 200;
/// How far x may fall back on a side, over the chord: round a cambered nose it does a little. *Choice.*
const NOSE: f64 = 0.01;
/// How far short of the chord's end a side may end, over the chord. *Choice.*
const SHORT: f64 = 0.05;

/// A section in a file of coordinates, as Selig's or Lednicer's collections have them.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AirfoilFile {
    /// The file, relative to the document: a name, then x and y of each point, from the trailing edge over the upper side to the leading
    /// edge and back (Selig), or the numbers of points and each side from the leading edge (Lednicer). The chord is the x axis.
    pub airfoil: PathBuf,
}

/// The line at fault, what it says, what is allowed.
type Fault = (usize, String, String);

/// A point of a section, with its line in the file.
type Point = (usize, [f64; 2]);

impl AirfoilFile {
    /// The angle of the section in the `text` of `file` as TOML, `v=...`; `key` is that of the angle.
    pub fn toml(file: &Path, text: &str, key: &str) -> Result<String, ConfigError> {
        let camber = camber(text).map_err(|(line, value, allowed)| {
            let place = Place::Line(file.into(), line);
            let value = Some(value);
            Wrong::new(place, format!("{key}.airfoil"), value, Problem::Value(allowed))
        })?;
        Ok(format!("v={:?}", ThinSection::of_camber(&camber).zero_lift_angle_rad.to_degrees() + 0.0))
    }
}

/// The middle between the sides of a section over its chord, from 0 to 1; else the line at fault, what it says, what is allowed.
fn camber(text: &str) -> Result<Vec<[f64; 2]>, Fault> {
    let (points, counts) = points(text)?;
    let mut sides = match counts {
        Some(upper) => [points[..upper].to_vec(), points[upper..].to_vec()],
        None => {
            let nose =
                (0..points.len()).min_by(|a, b| points[*a].1[0].total_cmp(&points[*b].1[0])).unwrap_or(0);
            [points[..=nose].iter().rev().copied().collect(), points[nose..].to_vec()]
        }
    };
    let all = || sides.iter().flatten().map(|(_, point)| point[0]);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let chord = high - low;
    for side in &sides {
        let (line, [x, y]) = side.last().copied().unwrap_or((1, [0.0, 0.0]));
        let refuse = |line, x, y, allowed: &str| Err((line, format!("{x} {y}"), allowed.to_owned()));
        if side.len() < FEWEST || !(chord > 0.0) {
            return refuse(
                line,
                x,
                y,
                "five points or more on each side of a section, between its leading and trailing edge",
            );
        }
        let mut furthest = side[0].1[0];
        for &(line, [x, y]) in side {
            if x < furthest - NOSE * chord {
                return refuse(line, x, y, "x that falls to the leading edge and grows from there");
            }
            furthest = furthest.max(x);
        }
        let first = side[0].1[0];
        if high - x > SHORT * chord || first - low > SHORT * chord {
            return refuse(line, x, y, "sides that both reach from the leading to the trailing edge");
        }
    }
    for side in &mut sides {
        let mut furthest = f64::NEG_INFINITY;
        side.retain(|(_, [x, _])| {
            *x > furthest && {
                furthest = *x;
                true
            }
        });
    }
    let at = |side: &[Point], x: f64| {
        let k = side.partition_point(|(_, point)| point[0] < x).clamp(1, side.len() - 1);
        let (a, b) = (side[k - 1].1, side[k].1);
        let share = ((x - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
        a[1] + (b[1] - a[1]) * share
    };
    let station = |k: usize| {
        let share = 0.5 * (1.0 - (PI * k as f64 / STATIONS as f64).cos());
        let x = low + chord * share;
        [share, 0.5 * (at(&sides[0], x) + at(&sides[1], x)) / chord]
    };
    Ok((0..=STATIONS).map(station).collect())
}

/// The points of a file, and how many are on the first side where it says so.
fn points(text: &str) -> Result<(Vec<Point>, Option<usize>), Fault> {
    let (mut points, mut counts) = (Vec::new(), None);
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let cells: Vec<&str> =
            line.split(|c: char| c.is_whitespace() || c == ',').filter(|cell| !cell.is_empty()).collect();
        let numbers: Vec<f64> = cells.iter().filter_map(|cell| cell.parse().ok()).collect();
        let refuse = |allowed: String| Err((index + 1, line.trim().to_owned(), allowed));
        match numbers[..] {
            _ if cells.is_empty() => {}
            [x, y] if cells.len() == 2 && points.is_empty() && counts.is_none() && x >= 2.0 && y >= 2.0 => {
                if !(x.fract() == 0.0 && y.fract() == 0.0 && x.max(y) <= MOST as f64) {
                    return refuse(format!("the numbers of points of both sides, at most {MOST}"));
                }
                counts = Some((x as usize, y as usize, index + 1));
            }
            // No section is as much larger than its chord of 1, 100 or so many millimetres.
            [x, y] if cells.len() == 2 && x.abs() <= 1e5 && y.abs() <= 1e5 => {
                points.push((index + 1, [x, y]))
            }
            _ if points.is_empty() && counts.is_none() => {}
            _ => return refuse("x and y of a point, two finite numbers".into()),
        }
        if points.len() > 2 * MOST {
            return refuse(format!("at most {} points", 2 * MOST));
        }
    }
    let last = (text.lines().count().max(1), format!("{} points", points.len()));
    match counts {
        Some((upper, lower, line)) if upper + lower != points.len() => {
            let said = format!("{} points", points.len());
            Err((
                line,
                format!("{upper} {lower}"),
                format!("the numbers of points that follow; there are {said}"),
            ))
        }
        _ if points.len() < 2 * FEWEST => {
            Err((last.0, last.1, "coordinates of a section: a name, then x and y of each point".into()))
        }
        _ => Ok((points, counts.map(|(upper, ..)| upper))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        ] {
            let error = angle(&text).unwrap_err();
            assert!(error.contains(said), "{error}\nnot: {said}");
        }
    }
}

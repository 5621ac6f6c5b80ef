//! Zero-lift angles from coordinates of sections: `zero_lift_angle_deg = { airfoil = "naca2412.dat" }` stands for the angle of the
//! camber line in the file.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use wingbeat_aero::{ThinSection, ZERO_LIFT_ANGLE};

use super::{ConfigError, KeyProblem, ValuePlace, Wrong};

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
/// Largest angle of the line from the leading to the trailing edge off the x axis, deg. *Choice.*
const TURNED_DEG: f64 = 1.0;

/// A section in a file of coordinates, as Selig's or Lednicer's collections have them.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AirfoilFile {
    /// The file, relative to the document: a name, then x and y of each point, from the trailing edge over the upper side to the leading
    /// edge and back (Selig), or the numbers of points and each side from the leading edge (Lednicer). The chord is the x axis, within
    /// 1 deg.
    pub airfoil: PathBuf,
}

/// The line at fault, what it says, what is allowed.
type LineFault = (usize, String, String);

/// A point of a section, with its line in the file.
type ProfilePoint = (usize, [f64; 2]);

impl AirfoilFile {
    /// The angle of the section in the `text` of `file` as TOML, `v=...`; `key` is that of the angle.
    pub fn toml(file: &Path, text: &str, key: &str) -> Result<String, ConfigError> {
        let angle_deg = angle_deg(text).map_err(|(line, value, allowed)| {
            let place = ValuePlace::Line(file.into(), line);
            let value = Some(value);
            Wrong::new(place, format!("{key}.airfoil"), value, KeyProblem::Value(allowed))
        })?;
        Ok(format!("v={angle_deg:?}"))
    }
}

/// The zero-lift angle of a section, deg.
fn angle_deg(text: &str) -> Result<f64, LineFault> {
    let camber = camber(text)?;
    let angle = ThinSection::of_camber(&camber).zero_lift_angle_rad.to_degrees() + 0.0;
    let why = |_| format!("a section whose zero-lift angle is {}", ZERO_LIFT_ANGLE.range.allowed());
    let refused = ZERO_LIFT_ANGLE.range.check("", angle).map_err(why);
    refused.map_err(|allowed| (1, format!("{angle:.2} deg"), allowed)).map(|()| angle)
}

/// The middle between the sides of a section over its chord, from 0 to 1; else the line at fault, what it says, what is allowed.
fn camber(text: &str) -> Result<Vec<[f64; 2]>, LineFault> {
    let (points, upper) = points(text)?;
    let mut sides = match upper {
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
    sides.iter().try_for_each(|side| check(side, low, high))?;
    for side in &mut sides {
        let mut furthest = f64::NEG_INFINITY;
        side.retain(|(_, [x, _])| {
            *x > furthest && {
                furthest = *x;
                true
            }
        });
    }
    let at = |side: &[ProfilePoint], x: f64| {
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
    let camber: Vec<[f64; 2]> = (0..=STATIONS).map(station).collect();
    let rise_deg = (camber[STATIONS][1] - camber[0][1]).atan().to_degrees();
    if rise_deg.abs() > TURNED_DEG {
        let allowed = format!(
            "a chord along the x axis, within {TURNED_DEG} deg; from end to end it rises by {rise_deg:.2} deg"
        );
        return Err((points[0].0, format!("{} {}", points[0].1[0], points[0].1[1]), allowed));
    }
    Ok(camber)
}

/// Refuses a side that does not go from the leading edge, near `low`, to the trailing edge, near `high`.
fn check(side: &[ProfilePoint], low: f64, high: f64) -> Result<(), LineFault> {
    let chord = high - low;
    let refuse =
        |(line, [x, y]): ProfilePoint, allowed: &str| Err((line, format!("{x} {y}"), allowed.to_owned()));
    let last = side.last().copied().unwrap_or((1, [0.0, 0.0]));
    if side.len() < FEWEST || !(chord > 0.0) {
        let allowed = "five points or more on each side of a section, between its leading and trailing edge";
        return refuse(last, allowed);
    }
    let first = side[0].1[0];
    let mut furthest = first;
    for &point in side {
        let x = point.1[0];
        if x < furthest - NOSE * chord {
            return refuse(point, "x that falls to the leading edge and grows from there");
        }
        furthest = furthest.max(x);
    }
    if high - last.1[0] > SHORT * chord || first - low > SHORT * chord {
        return refuse(last, "sides that both reach from the leading to the trailing edge");
    }
    Ok(())
}

/// The points of a file, and how many are on the first side where it says so.
fn points(text: &str) -> Result<(Vec<ProfilePoint>, Option<usize>), LineFault> {
    let (mut points, mut named) = (Vec::new(), false);
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let cells: Vec<&str> =
            line.split(|c: char| c.is_whitespace() || c == ',').filter(|cell| !cell.is_empty()).collect();
        let numbers: Vec<f64> = cells.iter().filter_map(|cell| cell.parse().ok()).collect();
        let refuse = |allowed: String| Err((index + 1, line.trim().to_owned(), allowed));
        match numbers[..] {
            _ if cells.is_empty() => {}
            // No section is as much larger than its chord of 1, 100 or so many millimetres.
            [x, y] if cells.len() == 2 && x.abs() <= 1e5 && y.abs() <= 1e5 => {
                points.push((index + 1, [x, y]))
            }
            _ if points.is_empty() && is_words(&cells, named) => named = true,
            _ => return refuse("x and y of a point, two finite numbers".into()),
        }
        if points.len() > 2 * MOST {
            return refuse(format!("at most {} points", 2 * MOST));
        }
    }
    let upper = counts(&mut points, named)?;
    if points.len() < 2 * FEWEST {
        let said = (text.lines().count().max(1), format!("{} points", points.len()));
        return Err((said.0, said.1, "coordinates of a section: a name, then x and y of each point".into()));
    }
    Ok((points, upper))
}

/// Whether a line before the points, which is none of them, is their name, or where they are `named` a heading without numbers.
fn is_words(cells: &[&str], named: bool) -> bool {
    let begins_number = |cell: &&str| {
        let digits = cell.trim_start_matches(['+', '-', '.']);
        digits.starts_with(|c: char| c.is_ascii_digit()) || cell.parse::<f64>().is_ok()
    };
    // Of two cells with a point for decimals in one that begins as a number, one is damaged.
    let is_damaged = cells.len() == 2 && cells.iter().any(|cell| begins_number(cell) && cell.contains('.'));
    if named { !cells.iter().any(begins_number) } else { !is_damaged }
}

/// Takes from before the points two whole numbers that are none: those of the points of both sides, the first of which it gives, or a
/// name like `4412 12`. A file `named` before has no second name.
fn counts(points: &mut Vec<ProfilePoint>, named: bool) -> Result<Option<usize>, LineFault> {
    let Some(&(line, [x, y])) = points.first() else { return Ok(None) };
    if x.fract() != 0.0 || y.fract() != 0.0 || x < 2.0 || y < 2.0 {
        return Ok(None);
    }
    let rest = points.len() - 1;
    if x + y == rest as f64 {
        points.remove(0);
        return Ok(Some(x as usize));
    }
    let furthest = points[1..].iter().fold(f64::NEG_INFINITY, |most, (_, point)| most.max(point[0]));
    if x <= (1.0 + SHORT) * furthest {
        return Ok(None);
    }
    if named {
        let allowed = format!("the numbers of points that follow; there are {rest} points");
        return Err((line, format!("{x} {y}"), allowed));
    }
    points.remove(0);
    Ok(None)
}

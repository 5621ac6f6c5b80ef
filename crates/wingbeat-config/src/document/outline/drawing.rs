//! The lines and curves of a drawing in ASCII DXF, as points. Groups and entities are those of Autodesk's DXF Reference.

use std::f64::consts::TAU;

use super::{Length, OutlineFault};

/// Most points of a drawing. *Choice*: ten for each station that is read.
const MOST_POINTS: usize = 100_000;
/// Largest magnitude of a number. *Choice.*
const LARGEST: f64 = 1e9;
/// Largest turn of a straight piece of an arc: its polygon has 5e-5 less area than the circle. *Choice.*
const PIECE_RAD: f64 = TAU / 360.0;
/// Straight pieces of each span of a spline. *Choice.*
const SPLINE_PIECES: usize = 32;
/// Largest degree of a spline. *Choice*: CAD programs draw 3, at most 5.
const MOST_DEGREE: usize = 15;
/// Entities that are no part of an outline.
const WRITING: [&str; 12] = [
    "TEXT",
    "MTEXT",
    "DIMENSION",
    "LEADER",
    "MULTILEADER",
    "POINT",
    "HATCH",
    "VIEWPORT",
    "ATTDEF",
    "XLINE",
    "RAY",
    "IMAGE",
];

/// A point of the drawing.
pub type DrawingPoint = [f64; 2];

/// A line or curve of the drawing.
pub struct DrawingCurve<'a> {
    /// The line of the file on which it begins.
    pub line: usize,
    /// Its layer.
    pub layer: &'a str,
    /// Its points in the unit of the drawing, first to last; of a closed one the first again.
    pub points: Vec<DrawingPoint>,
}

/// What is read of a drawing.
pub struct DxfDrawing<'a> {
    /// Its unit, and the line of the file that says it.
    pub unit: Option<(Length, usize)>,
    /// Its curves.
    pub curves: Vec<DrawingCurve<'a>>,
}

/// A group: line of the file, code, value.
type DxfGroup<'a> = (usize, i32, &'a str);

/// Reads a drawing.
pub fn read(text: &str) -> Result<DxfDrawing<'_>, OutlineFault> {
    let groups = groups(text)?;
    let mut drawing = DxfDrawing { unit: None, curves: Vec::new() };
    let starts: Vec<usize> = (0..groups.len()).filter(|i| groups[*i].1 == 0).collect();
    let part = |k: usize| &groups[starts[k]..starts.get(k + 1).copied().unwrap_or(groups.len())];
    let (mut section, mut k, mut points) = ("", 0, 0);
    while k < starts.len() {
        let (entity, kind) = (part(k), groups[starts[k]].2);
        k += 1;
        match (kind, section) {
            ("SECTION", _) => {
                section = value(entity, 2).unwrap_or_default();
                if section == "HEADER" {
                    drawing.unit = unit(entity)?;
                }
            }
            ("ENDSEC", _) => section = "",
            (_, "ENTITIES") => {
                let mut vertices = Vec::new();
                while kind == "POLYLINE" && k < starts.len() && groups[starts[k]].2 == "VERTEX" {
                    vertices.push(part(k));
                    k += 1;
                }
                // Entities of the sheet are no part of the drawing on it.
                let of_sheet = value(entity, 67) == Some("1");
                if of_sheet || WRITING.contains(&kind) || kind == "SEQEND" {
                    continue;
                }
                let curve = points_of(kind, entity, &vertices, MOST_POINTS - points)?;
                if !curve.iter().flatten().all(|value| value.is_finite()) {
                    return Err(fault(entity[0], format!("{kind} whose points are finite")));
                }
                points += curve.len();
                if points > MOST_POINTS {
                    return Err(too_many(entity));
                }
                let layer = value(entity, 8).unwrap_or("0");
                drawing.curves.push(DrawingCurve { line: entity[0].0, layer, points: curve });
            }
            _ => {}
        }
    }
    Ok(drawing)
}

/// The groups of a file: a line with the code, then one with the value.
fn groups(text: &str) -> Result<Vec<DxfGroup<'_>>, OutlineFault> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let mut groups = Vec::new();
    while let Some((line, code)) = lines.next() {
        let Ok(number) = code.parse() else {
            if code.is_empty() && lines.all(|(_, rest)| rest.is_empty()) {
                break;
            }
            return Err(fault((line, 0, code), "the group code of an ASCII DXF file, a whole number".into()));
        };
        groups.push((line, number, lines.next().map_or("", |(_, value)| value)));
    }
    Ok(groups)
}

fn fault(at: DxfGroup, allowed: String) -> OutlineFault {
    OutlineFault { line: at.0, key: "file", value: at.2.to_owned(), allowed }
}

/// The first value with that code.
fn value<'a>(entity: &[DxfGroup<'a>], code: i32) -> Option<&'a str> {
    entity.iter().find(|group| group.1 == code).map(|group| group.2)
}

/// The unit that the header says; none where it says that it has none.
fn unit(header: &[DxfGroup]) -> Result<Option<(Length, usize)>, OutlineFault> {
    let mut after = header.iter().skip_while(|group| group.2 != "$INSUNITS").skip(1);
    let Some(&(line, _, code)) = after.next() else { return Ok(None) };
    let unit = match code {
        "0" => return Ok(None),
        "1" => Length::In,
        "4" => Length::Mm,
        "5" => Length::Cm,
        "6" => Length::M,
        _ => {
            let allowed = "1 (in), 4 (mm), 5 (cm), 6 (m), or 0 (none) with the key `unit`".to_owned();
            return Err(OutlineFault { line, key: "unit", value: format!("$INSUNITS {code}"), allowed });
        }
    };
    Ok(Some((unit, line)))
}

/// All numbers with that code.
fn numbers(entity: &[DxfGroup], code: i32) -> Result<Vec<f64>, OutlineFault> {
    let of = |group: &&DxfGroup| group.1 == code;
    let read = |group: &DxfGroup| {
        let number = group.2.parse().ok().filter(|number: &f64| number.abs() <= LARGEST);
        let allowed = || format!("a finite number, {LARGEST:e} or less in magnitude");
        number.ok_or_else(|| fault((group.0 + 1, code, group.2), allowed()))
    };
    entity.iter().filter(of).map(read).collect()
}

/// The number with that code.
fn number(entity: &[DxfGroup], code: i32, otherwise: Option<f64>) -> Result<f64, OutlineFault> {
    let first = numbers(entity, code)?.first().copied().or(otherwise);
    first.ok_or_else(|| fault(entity[0], format!("{} with group {code}", entity[0].2)))
}

/// All points with those codes.
fn points(entity: &[DxfGroup], x: i32, y: i32) -> Result<Vec<DrawingPoint>, OutlineFault> {
    let (xs, ys) = (numbers(entity, x)?, numbers(entity, y)?);
    if xs.len() != ys.len() {
        return Err(fault(entity[0], format!("as many groups {x} as {y}")));
    }
    Ok(xs.into_iter().zip(ys).map(|(x, y)| [x, y]).collect())
}

fn too_many(entity: &[DxfGroup]) -> OutlineFault {
    fault(entity[0], format!("at most {MOST_POINTS} points in a drawing"))
}

/// The points of an entity, of a polyline at most `most`; `vertices` are its own.
fn points_of(
    kind: &str,
    entity: &[DxfGroup],
    vertices: &[&[DxfGroup]],
    most: usize,
) -> Result<Vec<DrawingPoint>, OutlineFault> {
    // Seen from behind, the plane of an entity is mirrored (group 230, z of its normal).
    let normal = number(entity, 230, Some(1.0))?;
    if (normal.abs() - 1.0).abs() > 1e-6 {
        return Err(fault(entity[0], format!("{kind} in the plane of the drawing, group 230 of 1 or -1")));
    }
    let own_plane = |mut points: Vec<DrawingPoint>| {
        points.iter_mut().for_each(|point| point[0] *= normal);
        points
    };
    let polyline = |corners: Vec<(DrawingPoint, f64)>| {
        let closed = number(entity, 70, Some(0.0))? as i64 & 1 == 1;
        let count: usize = corners.iter().map(|(_, bulge)| pieces(turn(*bulge))).sum();
        if count > most { Err(too_many(entity)) } else { Ok(own_plane(rounded(&corners, closed))) }
    };
    Ok(match kind {
        "LINE" => vec![
            [number(entity, 10, None)?, number(entity, 20, None)?],
            [number(entity, 11, None)?, number(entity, 21, None)?],
        ],
        "LWPOLYLINE" => polyline(corners(entity)?)?,
        "POLYLINE" => {
            let corner = |vertex: &&[DxfGroup]| {
                let place = [number(vertex, 10, None)?, number(vertex, 20, None)?];
                Ok((place, number(vertex, 42, Some(0.0))?))
            };
            polyline(vertices.iter().map(corner).collect::<Result<Vec<_>, OutlineFault>>()?)?
        }
        "ARC" | "CIRCLE" => {
            let radius = number(entity, 40, None)?;
            let (from, to) = match kind {
                "ARC" => (number(entity, 50, None)?.to_radians(), number(entity, 51, None)?.to_radians()),
                _ => (0.0, TAU),
            };
            let place = [number(entity, 10, None)?, number(entity, 20, None)?];
            own_plane(turned(place, [radius, 0.0], [0.0, radius], from, to))
        }
        "ELLIPSE" => {
            let major = [number(entity, 11, None)?, number(entity, 21, None)?];
            let ratio = number(entity, 40, None)? * normal;
            let place = [number(entity, 10, None)?, number(entity, 20, None)?];
            let minor = [-major[1] * ratio, major[0] * ratio];
            turned(place, major, minor, number(entity, 41, Some(0.0))?, number(entity, 42, Some(TAU))?)
        }
        "SPLINE" => spline(entity)?,
        _ => {
            let allowed = "LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE, ELLIPSE or SPLINE; explode blocks";
            return Err(fault((entity[0].0 + 1, 0, kind), allowed.into()));
        }
    })
}

/// The corners of a light polyline, each with the bulge of what follows it.
fn corners(entity: &[DxfGroup]) -> Result<Vec<(DrawingPoint, f64)>, OutlineFault> {
    let mut corners: Vec<(DrawingPoint, f64)> =
        points(entity, 10, 20)?.into_iter().map(|point| (point, 0.0)).collect();
    let mut k = 0;
    for (i, group) in entity.iter().enumerate() {
        match group.1 {
            10 => k += 1,
            42 if k > 0 => corners[k - 1].1 = number(&entity[i..=i], 42, None)?,
            _ => {}
        }
    }
    Ok(corners)
}

/// A polyline with its round pieces: a bulge is the tangent of a quarter of the angle, positive to the left.
fn rounded(corners: &[(DrawingPoint, f64)], closed: bool) -> Vec<DrawingPoint> {
    let mut points: Vec<DrawingPoint> = corners.first().iter().map(|corner| corner.0).collect();
    let ends = corners.iter().skip(1).chain(corners.first().filter(|_| closed));
    for (&(from, bulge), &(to, _)) in corners.iter().zip(ends) {
        if bulge != 0.0 {
            let chord = [to[0] - from[0], to[1] - from[1]];
            let aside = (1.0 - bulge * bulge) / (4.0 * bulge);
            let middle =
                [0.5 * (from[0] + to[0]) - chord[1] * aside, 0.5 * (from[1] + to[1]) + chord[0] * aside];
            let start = [from[0] - middle[0], from[1] - middle[1]];
            let angle = turn(bulge);
            let side = [-start[1], start[0]];
            let pieces = pieces(angle);
            points.extend((1..pieces).map(|k| on(middle, start, side, angle * k as f64 / pieces as f64)));
        }
        points.push(to);
    }
    points
}

/// The angle of a bulge, rad.
fn turn(bulge: f64) -> f64 {
    4.0 * bulge.atan()
}

fn pieces(angle: f64) -> usize {
    (angle.abs() / PIECE_RAD).ceil().max(1.0) as usize
}

fn on(middle: DrawingPoint, cosine: DrawingPoint, sine: DrawingPoint, angle: f64) -> DrawingPoint {
    let (s, c) = angle.sin_cos();
    [middle[0] + c * cosine[0] + s * sine[0], middle[1] + c * cosine[1] + s * sine[1]]
}

/// A round curve anticlockwise from one angle to another, rad; a whole turn where they are equal.
fn turned(
    middle: DrawingPoint,
    cosine: DrawingPoint,
    sine: DrawingPoint,
    from: f64,
    to: f64,
) -> Vec<DrawingPoint> {
    let angle = (to - from).rem_euclid(TAU);
    let angle = if angle < 1e-9 { TAU } else { angle };
    let pieces = pieces(angle);
    (0..=pieces).map(|k| on(middle, cosine, sine, from + angle * k as f64 / pieces as f64)).collect()
}

/// A spline by its control points, knots and weights.
fn spline(entity: &[DxfGroup]) -> Result<Vec<DrawingPoint>, OutlineFault> {
    let (control, knots, mut weights) = (points(entity, 10, 20)?, numbers(entity, 40)?, numbers(entity, 41)?);
    let degree = number(entity, 71, Some(3.0))? as usize;
    weights.resize(control.len().max(weights.len()), 1.0);
    let sound = (1..=MOST_DEGREE).contains(&degree)
        && control.len() > degree
        && control.len() < MOST_POINTS / SPLINE_PIECES
        && knots.len() == control.len() + degree + 1
        && weights.iter().all(|weight| *weight > 0.0)
        && knots.is_sorted();
    if !sound {
        let allowed = format!(
            "SPLINE with more control points than its degree, at most {}, ascending knots, as many as points and degree and 1, and \
             positive weights",
            MOST_POINTS / SPLINE_PIECES
        );
        return Err(fault(entity[0], allowed));
    }
    let mut points = Vec::new();
    for span in degree..control.len() {
        let (from, to) = (knots[span], knots[span + 1]);
        if to > from {
            let pieces = SPLINE_PIECES - usize::from(span + 1 < control.len());
            let at = |k: usize| from + (to - from) * k as f64 / SPLINE_PIECES as f64;
            points.extend((0..=pieces).map(|k| de_boor(degree, span, at(k), &knots, &control, &weights)));
        }
    }
    Ok(points)
}

/// The point of a rational B-spline at the parameter `t` between the knots `span` and `span` + 1, by de Boor's recursion on
/// (w x, w y, w) (de Boor 1972, J. Approx. Theory 6, 50).
fn de_boor(
    degree: usize,
    span: usize,
    t: f64,
    knots: &[f64],
    control: &[DrawingPoint],
    weights: &[f64],
) -> DrawingPoint {
    let mut d = [[0.0; 3]; MOST_DEGREE + 1];
    for (j, d) in d.iter_mut().take(degree + 1).enumerate() {
        let i = span - degree + j;
        *d = [control[i][0] * weights[i], control[i][1] * weights[i], weights[i]];
    }
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let i = span - degree + j;
            let share = (t - knots[i]) / (knots[i + degree + 1 - r] - knots[i]);
            let before = d[j - 1];
            d[j].iter_mut().zip(before).for_each(|(now, before)| *now = before + share * (*now - before));
        }
    }
    let [x, y, weight] = d[degree];
    [x / weight, y / weight]
}

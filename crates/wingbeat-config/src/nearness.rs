//! How near the surfaces of a robot come to each other: their mutual wash is that of lifting lines some part of a chord apart.

use wingbeat_aero::Aero;
use wingbeat_judge::Warning;
use wingbeat_math::{Jet, Mat3, Vec3};
use wingbeat_robot::{BodyMotion, Robot, Stance};

/// Cosine of the angle between two plates up to which they are side by side: a fin on a tail is not. *Choice*: 45 deg.
const PARALLEL: f64 = 0.7;
/// Distance of quarter chords over the larger chord up to which plates lie on one another. Equal plates a twentieth of their chord apart are
/// unstable at 0.4, and were stable over 2.85 s at 0.5.
const OVERLAPS: f64 = 0.5;
/// Distance of the ends of two surfaces over the larger chord there, up to which they are one wing in two pieces. *Choice.*
const MEETS: f64 = 0.1;
/// Part of a strip's width beyond its edges that counts as its own, where a wing is bent there. *Choice.*
const BEYOND: f64 = 0.1;
/// Shares of a chord from which the distance is taken.
const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// The chord lines at the edges of the strips of a surface, leading edge first, m.
struct Plate<'a> {
    aero: &'a Aero,
    lines: Vec<[Vec3<f64>; 2]>,
}

/// The place at a share of the chord line.
fn at([leading, trailing]: [Vec3<f64>; 2], share: f64) -> Vec3<f64> {
    leading + (trailing - leading) * share
}

impl<'a> Plate<'a> {
    /// Surface number `surface` of `robot`; none where it cannot be laid.
    fn new(robot: &Robot, aero: &'a Aero, surface: usize, stance: &Stance) -> Option<Self> {
        let mut found = Vec::new();
        robot.chord_lines(stance, surface, aero.arcs(), &mut found).ok()?;
        Some(Self { aero, lines: found.iter().map(|line| [line.le, line.te]).collect() })
    }

    /// The middle chord line of strip `i`, and its normal.
    fn strip(&self, i: usize) -> ([Vec3<f64>; 2], Vec3<f64>) {
        let [from, to] = [self.lines[i], self.lines[i + 1]];
        let middle = [0, 1].map(|k| (from[k] + to[k]) * 0.5);
        (middle, (middle[1] - middle[0]).cross(at(to, 0.25) - at(from, 0.25)))
    }

    /// Strips that carry a wing.
    fn covered(&self) -> impl Iterator<Item = usize> {
        (0..self.aero.strips()).filter(|i| self.aero.covers(*i))
    }

    /// Least distance of this plate's chords from the other plate where both lie on one another, over the larger chord.
    fn over(&self, other: &Self) -> f64 {
        let mut least = f64::INFINITY;
        for i in self.covered() {
            let (line, normal) = self.strip(i);
            for j in other.covered() {
                let (beside, against) = other.strip(j);
                let chord = (line[1] - line[0]).norm().max((beside[1] - beside[0]).norm());
                if normal.dot(against).abs() < PARALLEL * normal.norm() * against.norm() {
                    continue;
                }
                let [from, to] = [other.lines[j], other.lines[j + 1]];
                let (start, span) = (at(from, 0.25), at(to, 0.25) - at(from, 0.25));
                let quarter = at(line, 0.25);
                let part = (quarter - start).dot(span) / span.norm_squared();
                // Beside the strip are others, or the end of the plate.
                if !(-BEYOND..=1.0 + BEYOND).contains(&part) {
                    continue;
                }
                let nearest = start + span * part.clamp(0.0, 1.0);
                if (quarter - nearest).norm() > OVERLAPS * chord {
                    continue;
                }
                let along = beside[1] - beside[0];
                for share in SHARES {
                    let point = at(line, share);
                    let part = ((point - start).dot(span) / span.norm_squared()).clamp(0.0, 1.0);
                    let off = point - (from[0] + (to[0] - from[0]) * part);
                    let down = (off.dot(along) / along.norm_squared()).clamp(0.0, 1.0);
                    least = least.min((off - along * down).norm() / chord);
                }
            }
        }
        least
    }

    /// Whether an end of this plate lies on an end of the other one, which goes on in its plane.
    fn meets(&self, other: &Self) -> bool {
        let ends = |plate: &Self| {
            let last = plate.lines.len() - 1;
            [(plate.lines[0], plate.strip(0).1), (plate.lines[last], plate.strip(last - 1).1)]
        };
        ends(self).iter().any(|(line, normal)| {
            ends(other).iter().any(|(beside, against)| {
                let chord = (line[1] - line[0]).norm().max((beside[1] - beside[0]).norm());
                let parallel = normal.dot(*against).abs() > PARALLEL * normal.norm() * against.norm();
                parallel && (at(*line, 0.25) - at(*beside, 0.25)).norm() < MEETS * chord
            })
        })
    }
}

/// The plates of the surfaces of `robot` that wash each other, with their names.
fn plates<'a>(robot: &'a Robot, stance: &Stance) -> Vec<(&'a str, Plate<'a>)> {
    let strips = |(_, (_, aero)): &(usize, (&str, &Aero))| matches!(aero, Aero::Strip(_));
    let of = |(k, (name, aero))| Some((name, Plate::new(robot, aero, k, stance)?));
    robot.surfaces().enumerate().filter(strips).filter_map(of).collect()
}

/// Least distance of the chords of two surfaces of `robot` that lie on one another at the time `t`, s, in the state `x`, over the larger chord;
/// none where none do.
pub(super) fn surfaces_apart(robot: &Robot, t: f64, x: &[f64]) -> Option<f64> {
    let plates = plates(robot, &robot.stance(t, x));
    let pairs = plates
        .iter()
        .enumerate()
        .flat_map(|(i, (_, a))| plates[i + 1..].iter().map(move |(_, b)| a.over(b).min(b.over(a))));
    pairs.filter(|apart| apart.is_finite()).reduce(f64::min)
}

/// The warning that two surfaces of `robot` are one wing in two pieces: halves of 4, 8 and 16 strips lift 12.5, 10 and 8 % less than the whole
/// wing of aspect ratio 8.
pub(super) fn in_pieces(robot: &Robot) -> Option<Warning> {
    let body = BodyMotion::steady(Mat3::IDENTITY, Vec3::ZERO);
    let still = robot.carried_still();
    let stance = robot.carried_stance(&Jet::new(0.0, 1.0, 0.0), Vec3::ZERO, &body, &still);
    let plates = plates(robot, &stance);
    let mut pairs = plates.iter().enumerate().flat_map(|(i, a)| plates[i + 1..].iter().map(move |b| (a, b)));
    let ((one, _), (other, _)) = pairs.find(|((_, a), (_, b))| a.meets(b))?;
    let text = format!(
        "surfaces {one} and {other} meet at their ends, and lift some 10 % less than one surface in their place, whose panels may be on several links"
    );
    Some(Warning::new("aero.wing_in_pieces", text).key("robot.surfaces"))
}

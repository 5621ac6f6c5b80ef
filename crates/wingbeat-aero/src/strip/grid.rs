//! Where the strips lie on the wing and what of them never changes.

use crate::Planform;
use std::f64::consts::PI;
use wingbeat_math::interpolation::piecewise_linear;
use wingbeat_math::{CubicSpline, Error, Scalar};

/// Constants of the strips, from left tip to right tip.
#[derive(Clone, Debug)]
pub(super) struct StripGrid<P = f64> {
    /// Arc coordinates of the edges, m, positive on the left wing.
    pub arcs: Vec<P>,
    /// Arc coordinates of the control sections, m.
    pub control_arcs: Vec<P>,
    /// Place of the control section between the strip's edges, 0 to 1.
    pub fraction: Vec<P>,
    /// Whether there is wing, not a gap.
    pub covered: Vec<bool>,
    /// Leading and trailing edge at the edges of the strips, m ahead of the hinge line.
    pub outline: Vec<(P, P)>,
    /// Chord of the control section between the edges, on straight lines, m.
    pub between: Vec<P>,
    /// How far ahead of these lines the leading and the trailing edge of the strip lie, m.
    pub bulge: Vec<[P; 2]>,
    /// Chord of the strip, m: `between` with the bulges.
    pub chord: Vec<P>,
    /// Arc coordinate of the left tip, m.
    pub tip: P,
    /// Chord at the left and at the right tip, m; 0 at the root of a one-sided surface, which stands on something.
    pub tip_chords: [P; 2],
    /// Width perpendicular to the chord, m.
    pub width: Vec<P>,
    /// Cosine of the sweep of the half-chord line.
    pub cos_half: Vec<P>,
    /// Cosine of the sweep of the three-quarter-chord line.
    pub cos_three_quarter: Vec<P>,
    /// Mean chord, m.
    pub mean_chord: P,
    /// Distance between the quarter-chord points of the tips of the flat wing, m.
    pub tip_to_tip: P,
    /// Arc span over mean chord.
    pub aspect: P,
    /// Whether widths jump at hinges: see [`StripSpacing::crowded`].
    pub crowded: bool,
}

/// How Lan's angles move where an edge of theirs is to lie on each hinge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngleMap {
    /// By straight lines between hinges, so that the widths of strips jump there.
    Straight,
    /// By a natural cubic spline through hinges and tips, where it ascends; else as `Straight`.
    Smooth,
}

/// Least slope of a spline that takes the place of straight lines, over the least of theirs. *Choice*: narrower strips would
/// crowd beside wide ones.
const LEAST_SLOPE: f64 = 0.25;

impl<P: Scalar> StripGrid<P> {
    /// Lays `strips` strips, with hinges at `hinge_arcs` (m along the wing); `fills`: they carry what the outline has beyond the straight lines between their edges.
    ///
    /// A corner of the outline between two edges is cut off by these lines: Aerobat's 16 strips would have 2.4 % less area than
    /// it. The mean of what is cut off, by length of arc, moves the edges of the strip's own section; vortices stay on the lines.
    ///
    /// Equation: aero.strip.bulge
    /// `edge of a strip = its straight line at the control section + (mean of the outline - mean of the line)`
    /// Source: choice: the area of the outline at its place.
    /// Test: `strips_have_the_area_that_corners_of_the_outline_hold`.
    pub fn new(planform: &Planform<P>, strips: usize, hinge_arcs: &[P], fills: bool) -> Result<Self, Error> {
        let laid = spacing(planform, strips, hinge_arcs, AngleMap::Smooth)?;
        let StripSpacing { edges, fractions: fraction, crowded } = laid;
        let arcs: Vec<P> = edges.iter().map(|s| -*s).collect();
        let outline: Vec<(P, P)> = arcs.iter().map(|&s| planform.edges(s)).collect();
        // The chord direction is -x on the flat planform: widths are differences of arc.
        let width: Vec<P> = arcs.windows(2).map(|a| a[0] - a[1]).collect();
        let between: Vec<P> = (0..strips)
            .map(|i| {
                let at = |j: usize| outline[j].0 - outline[j].1;
                at(i) + fraction[i] * (at(i + 1) - at(i))
            })
            .collect();
        let bulge: Vec<[P; 2]> = (0..strips)
            .map(|i| if fills { planform.bulge(arcs[i + 1], arcs[i]) } else { [P::ZERO; 2] })
            .collect();
        let chord: Vec<P> =
            between.iter().zip(&bulge).map(|(c, [ahead, behind])| *c + *ahead - *behind).collect();
        let cosine = |x: f64| -> Vec<P> {
            let ahead = |(le, te): (P, P)| le + (te - le) * x;
            (0..strips)
                .map(|i| {
                    let run = ahead(outline[i + 1]) - ahead(outline[i]);
                    width[i] / width[i].hypot(run)
                })
                .collect()
        };
        let control_arcs: Vec<P> = (0..strips).map(|i| arcs[i] - fraction[i] * width[i]).collect();
        let covered: Vec<bool> = control_arcs.iter().map(|s| planform.covers(*s)).collect();
        let kept = |i: usize| if covered[i] { width[i] } else { P::ZERO };
        let area = chord.iter().enumerate().fold(P::ZERO, |sum, (i, c)| sum + *c * kept(i));
        let span = (0..strips).fold(P::ZERO, |sum, i| sum + kept(i));
        let mean_chord = area / span;
        let quarter = |(le, te): (P, P)| le + (te - le) * 0.25;
        Ok(Self {
            tip_to_tip: (arcs[0] - arcs[strips]).hypot(quarter(outline[0]) - quarter(outline[strips])),
            control_arcs,
            fraction,
            cos_half: cosine(0.5),
            cos_three_quarter: cosine(0.75),
            tip: planform.half_span(),
            tip_chords: {
                let tip = planform.half_span();
                let chord = |s: P| if planform.from_root(s).is_zero() { P::ZERO } else { planform.chord(s) };
                [chord(tip), chord(-tip)]
            },
            mean_chord,
            aspect: span / mean_chord,
            crowded,
            covered,
            arcs,
            outline,
            between,
            bulge,
            chord,
            width,
        })
    }
}

impl<P: Scalar> StripGrid<P> {
    /// Half width of the narrower strip beside each edge, at most half the chord, m: a core that grows
    /// with a wide strip would reach its own bound vortex.
    pub fn half_widths(&self) -> impl Iterator<Item = P> {
        let last = self.width.len() - 1;
        let least = |a: P, b: P| if b < a { b } else { a };
        let half = move |i: usize| least(self.width[i], self.chord[i]) * 0.5;
        (0..=last + 1).map(move |j| least(half(j.min(last)), half(j.saturating_sub(1))))
    }
}

/// Most strips among which enough for the hinges are looked for. *Choice.*
const MOST_ASKED: usize = 500;

/// Angles of the edges of `strips` strips before hinges move them.
fn edge_angles(strips: usize) -> Vec<f64> {
    let n = strips as f64;
    (0..=strips).map(|j| (2 * j + 1) as f64 * PI / (2.0 * n + 2.0)).collect()
}

/// A stretch of arc with its strips, from the right tip on.
struct ArcPiece<P> {
    from: P,
    to: P,
    strips: usize,
}

/// The pieces of wing and the gaps between them: strips by length on the pieces, one on each
/// gap, and in the middle what is left.
fn pieces<P: Scalar>(planform: &Planform<P>, strips: usize) -> Result<Vec<ArcPiece<P>>, Error> {
    let (tip, gaps) = (planform.half_span(), planform.gaps());
    let mut bounds: Vec<P> = gaps.iter().flat_map(|g| [g.from_arc_m, g.to_arc_m]).collect();
    bounds.retain(|s| s.value() > 0.0);
    bounds.push(tip);
    let for_wing =
        (strips as f64 - 2.0 * gaps.len() as f64).max(0.0) / (2.0 * planform.covered_half_span().value());
    let side = bounds.windows(2).map(|b| {
        let covered = planform.covers((b[0] + b[1]) * 0.5);
        let share = if covered { (for_wing * (b[1] - b[0]).value()).floor().max(1.0) } else { 1.0 };
        ArcPiece { from: b[0], to: b[1], strips: share as usize }
    });
    let side: Vec<ArcPiece<P>> = side.collect();
    let outer: usize = 2 * side.iter().map(|p| p.strips).sum::<usize>();
    if outer >= strips {
        return Err(Error::invalid("strips", strips, format!("at least {}: one on every piece", outer + 1)));
    }
    let mirrored = |p: &ArcPiece<P>| ArcPiece { from: -p.to, to: -p.from, strips: p.strips };
    let mut all: Vec<ArcPiece<P>> = side.iter().rev().map(mirrored).collect();
    all.push(ArcPiece { from: -bounds[0], to: bounds[0], strips: strips - outer });
    all.extend(side);
    Ok(all)
}

/// Where strips lie along the span.
#[derive(Clone, Debug)]
pub struct StripSpacing<P = f64> {
    /// Arc coordinates of the edges from the right tip to the left one, m.
    pub edges: Vec<P>,
    /// Place of the control point in each strip, 0 to 1.
    pub fractions: Vec<P>,
    /// Whether hinges move the edges by straight lines where a spline was asked for, since it would have left no room for a strip.
    pub crowded: bool,
}

/// Lays strips between the tips, an edge of theirs on each hinge; arcs are in m.
///
/// # Errors
/// [`Error::Invalid`] when a hinge lies beyond the tip or the strips are too few for hinges and gaps.
#[inline(never)]
pub fn spacing<P: Scalar>(
    planform: &Planform<P>,
    strips: usize,
    hinge_arcs: &[P],
    map: AngleMap,
) -> Result<StripSpacing<P>, Error> {
    let pieces = pieces(planform, strips)?;
    let tip = planform.half_span();
    let mut hinges = Vec::new();
    for (k, &arc) in hinge_arcs.iter().enumerate() {
        let at = planform.coordinates(arc);
        if !(arc.value() >= 0.0 && at.iter().all(|s| s.abs() < tip)) {
            let allowed = format!("0 to less than the half span {}", tip.value());
            return Err(
                Error::invalid(format!("hinge_arcs_m[{k}]"), arc.value(), allowed).against(["half_span"])
            );
        }
        // Edges are laid from the right tip, where the arc coordinate is negative, to the left one.
        hinges.extend(at.iter().map(|s| -*s));
    }
    wingbeat_math::order::ascend_by(&mut hinges, |item| item.value());
    hinges.dedup_by(|a, b| *a == *b);
    let (mut edges, mut fractions) = (Vec::with_capacity(strips + 1), Vec::with_capacity(strips));
    let mut crowded = false;
    for piece in &pieces {
        if planform.covers((piece.from + piece.to) * 0.5) {
            let laid = piece.spacing(&hinges, strips, map).map_err(|e| {
                let arcs = (0..hinge_arcs.len()).map(|k| format!("hinge_arcs_m[{k}]"));
                e.against(arcs).against(["half_span"])
            })?;
            edges.extend(laid.edges);
            fractions.extend(laid.fractions);
            crowded |= laid.crowded;
        } else {
            // Between the outermost edges of its neighbours.
            let step = (piece.to - piece.from) / piece.strips as f64;
            edges.extend((1..piece.strips).map(|j| piece.from + step * j as f64));
            fractions.extend(std::iter::repeat_n(P::from(0.5), piece.strips));
        }
    }
    Ok(StripSpacing { edges, fractions, crowded })
}

impl<P: Scalar> ArcPiece<P> {
    /// Strip edges and the place of the control point in each strip: with t = (s - middle) over
    /// the half length, edges -cos((2j+1) pi/(2N+2)), control points -cos(i pi/(N+1)),
    /// i = 1..N; a map of the angle puts an edge on each hinge.
    ///
    /// Lan's sum over such nodes is exact for the downwash of all sines of the angle that N strips resolve. It keeps its order where
    /// the map m is smooth with all its continuations past the tips: s = -cos m must be even there, so m(-t) = -m(t) and m - t is
    /// odd and periodic. The cubic spline of an odd periodic function through knots is the natural one between the tips. Where the
    /// map has corners, widths jump, and the sum at the strips beside them errs by as much as one strip's share.
    ///
    /// Equation: aero.strip.spacing
    /// `edges -cos((2j+1) pi/(2N+2)), control points -cos(i pi/(N+1)); a natural cubic spline of the angle puts an edge on each hinge;
    /// each piece between gaps by itself`
    /// Source: Lan 1974, J. Aircraft 11(9); the spline: own derivation.
    /// Test: `the_lift_of_a_folded_wing_converges_with_its_strips`.
    fn spacing(&self, hinges: &[P], strips: usize, map: AngleMap) -> Result<StripSpacing<P>, Error> {
        let n = self.strips as f64;
        let edge = edge_angles(self.strips);
        let middle: Vec<f64> = (1..=self.strips).map(|i| i as f64 * PI / (n + 1.0)).collect();
        let (from, to) = self.hinge_map(&edge, hinges, strips)?;
        let spline = (map == AngleMap::Smooth).then(|| Spline::through(&from, &to)).transpose()?;
        let spline = spline.filter(|spline| spline.ascends(edge.iter().chain(&middle)));
        let straight = |angle: f64| {
            let knots: Vec<P> = from.iter().map(|knot| P::from(*knot)).collect();
            piecewise_linear(&knots, &to, P::from(angle))
        };
        let moved = |angle: f64| -spline.as_ref().map_or_else(|| straight(angle), |s| s.at(angle)).cos();
        let edge: Vec<P> = edge.into_iter().map(moved).collect();
        let between = |(t, e): (P, &[P])| (t - e[0]) / (e[1] - e[0]);
        let fractions = middle.into_iter().map(moved).zip(edge.windows(2)).map(between).collect();
        let (centre, half) = self.middle();
        let crowded = map == AngleMap::Smooth && spline.is_none();
        Ok(StripSpacing { edges: edge.iter().map(|t| centre + half * *t).collect(), fractions, crowded })
    }

    /// Its middle, and half its length, m.
    fn middle(&self) -> (P, P) {
        ((self.from + self.to) * 0.5, (self.to - self.from) * 0.5)
    }

    /// Knots of the angle map: an edge moves onto each hinge.
    fn hinge_map(&self, edge: &[f64], hinges: &[P], strips: usize) -> Result<(Vec<f64>, Vec<P>), Error> {
        let (centre, half) = self.middle();
        let inside = hinges.iter().filter(|s| **s > self.from && **s < self.to);
        let angles: Vec<P> = inside.map(|s| (-(*s - centre) / half).acos()).collect();
        let values: Vec<f64> = angles.iter().map(|angle| angle.value()).collect();
        let Some(taken) = self.hinge_edges(edge, &values) else {
            let enough = (self.strips + 1..=MOST_ASKED)
                .find(|more| self.hinge_edges(&edge_angles(*more), &values).is_some())
                .map_or(String::new(), |more| format!(", {} or more", strips + more - self.strips));
            let allowed = format!("enough that every hinge has an edge of its own{enough}");
            return Err(Error::invalid("strips", strips, allowed));
        };
        let from = taken.iter().map(|&j| edge[j]);
        let to = std::iter::once(P::ZERO).chain(angles).chain([P::from(PI)]).collect();
        Ok((std::iter::once(0.0).chain(from).chain([PI]).collect(), to))
    }

    /// The edge of each hinge: in increasing order with the least squared difference of angle, the same
    /// on both sides of the plane of symmetry. The outermost edges stay at the ends of the piece.
    fn hinge_edges(&self, edge: &[f64], angles: &[f64]) -> Option<Vec<usize>> {
        let last = edge.len() - 1;
        let paired = |(a, b): (&f64, &f64)| (a + b - PI).abs() < 1e-9;
        let middle = self.from.value() + self.to.value();
        let alike = angles.iter().zip(angles.iter().rev()).all(paired);
        // A one-sided surface has its hinges where they are.
        let one_sided = middle == 0.0 && !alike;
        let lean = if one_sided { angles.iter().map(|angle| angle - 0.5 * PI).sum() } else { middle };
        let alone = |angles: &[f64]| -> Option<Vec<usize>> {
            in_order(&edge[1..last], angles).map(|taken| taken.iter().map(|j| j + 1).collect())
        };
        if lean < 0.0 || (one_sided && lean == 0.0) {
            return alone(angles);
        }
        let mirrored = |taken: &[usize]| -> Vec<usize> { taken.iter().rev().map(|j| last - j).collect() };
        if lean > 0.0 {
            let other: Vec<f64> = angles.iter().rev().map(|angle| PI - angle).collect();
            return alone(&other).map(|taken| mirrored(&taken));
        }
        let side = angles.len() / 2;
        let mut middle = Vec::new();
        let mut first_past = edge.len() / 2;
        if angles.len() % 2 == 1 {
            // With an odd number of strips there is no edge in the middle: one of the two beside it.
            let nearer = |j: usize| (edge[j] - angles[side]).abs();
            middle.push(if nearer(last / 2) <= nearer(last.div_ceil(2)) {
                last / 2
            } else {
                last.div_ceil(2)
            });
            first_past = last / 2;
        }
        let left = in_order(edge.get(1..first_past).unwrap_or(&[]), &angles[..side])?;
        let left: Vec<usize> = left.iter().map(|j| j + 1).collect();
        Some([&left[..], &middle, &mirrored(&left)].concat())
    }
}

/// A natural cubic spline of the angle. It is linear in the values at its knots, which may carry derivatives: the sum of as
/// many splines that are one at a knot and zero at the others.
struct Spline<P> {
    at_knots: Vec<(CubicSpline, P)>,
    /// Least slope of the straight lines between the knots.
    straight: f64,
}

impl<P: Scalar> Spline<P> {
    fn through(from: &[f64], to: &[P]) -> Result<Self, Error> {
        let unit = |k: usize| -> Vec<f64> { (0..from.len()).map(|j| f64::from(u8::from(j == k))).collect() };
        let at_knot = |(k, value): (usize, &P)| CubicSpline::natural(from, &unit(k)).map(|s| (s, *value));
        let slopes = from.windows(2).zip(to.windows(2)).map(|(x, y)| (y[1] - y[0]).value() / (x[1] - x[0]));
        Ok(Self {
            straight: slopes.fold(f64::INFINITY, f64::min),
            at_knots: to.iter().enumerate().map(at_knot).collect::<Result<_, _>>()?,
        })
    }

    fn at(&self, angle: f64) -> P {
        self.at_knots.iter().fold(P::ZERO, |sum, (unit, value)| sum + *value * unit.at(angle).x)
    }

    /// Whether it leaves room for a strip everywhere.
    fn ascends<'a>(&self, angles: impl Iterator<Item = &'a f64>) -> bool {
        let slope =
            |angle: f64| self.at_knots.iter().map(|(unit, to)| unit.at(angle).d * to.value()).sum::<f64>();
        angles.copied().map(slope).all(|slope| slope >= LEAST_SLOPE * self.straight)
    }
}

/// Sums of squared angles, rad2, that differ by less are the same: the choice must not depend on rounding.
const TIE: f64 = 1e-12;

/// Indices of `edge` for each of `angles`, increasing, with the least sum of squared differences.
fn in_order(edge: &[f64], angles: &[f64]) -> Option<Vec<usize>> {
    // The least sum, and the indices, of the angles so far with the last one at each edge or before.
    let mut best = vec![Some((0.0, Vec::new())); edge.len() + 1];
    for angle in angles {
        let mut next: Vec<Option<(f64, Vec<usize>)>> = vec![None; edge.len() + 1];
        for (j, e) in edge.iter().enumerate() {
            let here = best[j].as_ref().map(|(sum, taken)| {
                (sum + (e - angle).powi(2), taken.iter().copied().chain([j]).collect::<Vec<_>>())
            });
            next[j + 1] = match (next[j].clone(), here) {
                (Some(before), Some(here)) => Some(if here.0 < before.0 - TIE { here } else { before }),
                (before, here) => here.or(before),
            };
        }
        best = next;
    }
    best.pop()?.map(|(_, taken)| taken)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PlanformStation, Span};

    /// Aerobat's outline with its shoulders and elbows.
    fn aerobat(strips: usize) -> Result<StripGrid, Error> {
        StripGrid::new(&aerobat_planform(), strips, &[0.0207, 0.0707], true)
    }

    fn aerobat_planform() -> Planform {
        let rows = [
            [0.0, 0.0635, -0.0956],
            [0.0707, 0.0765, -0.111],
            [0.1547, 0.118, 0.0171],
            [0.2027, 0.101, 0.081],
        ];
        let stations = rows.map(|[arc_m, leading_edge_m, trailing_edge_m]| PlanformStation {
            arc_m,
            leading_edge_m,
            trailing_edge_m,
        });
        Planform::new(&stations).unwrap()
    }

    #[test]
    fn too_few_strips_are_told_how_many_are_enough() {
        let enough = (1..20).find(|strips| aerobat(*strips).is_ok()).unwrap();
        let told = aerobat(enough - 1).unwrap_err().to_string();
        assert!(told.contains(&format!("edge of its own, {enough} or more")), "{told}");
    }

    #[test]
    fn strips_have_the_area_that_corners_of_the_outline_hold() {
        let area = |grid: &StripGrid, chord: &[f64]| -> f64 {
            chord.iter().zip(&grid.width).map(|(chord, width)| chord * width).sum()
        };
        for strips in [9, 12, 16, 32] {
            let grid = aerobat(strips).unwrap();
            // What the straight lines cut off, beside the corners alone.
            let planform = aerobat_planform();
            let of_lines: f64 = (0..strips)
                .map(|i| {
                    let [from, to] =
                        [grid.outline[i], grid.outline[i + 1]].map(|(leading, trailing)| leading - trailing);
                    grid.width[i] * 0.5 * (from + to)
                })
                .sum();
            let [outline, _] = planform.chord_integrals(grid.arcs[strips], grid.arcs[0]);
            let gained = area(&grid, &grid.chord) - area(&grid, &grid.between);
            assert!((gained - (outline - of_lines)).abs() < 1e-12, "{strips}: {gained}");
            let bent = grid.bulge.iter().filter(|bulge| bulge[0] != 0.0 || bulge[1] != 0.0).count();
            assert!((2..=5).contains(&bent), "{strips}: {bent}");
            for ([a, b], [c, d]) in grid.bulge.iter().zip(grid.bulge.iter().rev()) {
                assert!((a - c).abs() + (b - d).abs() < 1e-15, "{strips}");
            }
        }
        let rectangle = [0.0, 0.1, 0.2].map(|arc_m| PlanformStation {
            arc_m,
            leading_edge_m: 0.02,
            trailing_edge_m: -0.03,
        });
        let grid = StripGrid::new(&Planform::new(&rectangle).unwrap(), 8, &[], true).unwrap();
        assert!(grid.chord.iter().zip(&grid.between).all(|(a, b)| (a - b).abs() < 1e-16));
    }

    #[test]
    fn hinges_take_edges_in_order_and_alike_on_both_sides() {
        for strips in [6, 7, 8, 9, 10, 12, 13, 14, 16, 32] {
            let grid = aerobat(strips).unwrap();
            for (a, b) in grid.arcs.iter().zip(grid.arcs.iter().rev()) {
                assert!((a + b).abs() < 1e-15, "{strips} strips: {a} and {b}");
            }
            for (a, b) in grid.control_arcs.iter().zip(grid.control_arcs.iter().rev()) {
                assert!((a + b).abs() < 1e-15, "{strips} strips: control at {a} and {b}");
            }
            assert!(grid.width.iter().all(|width| *width > 0.0), "{strips} strips");
            for hinge in [0.0207, 0.0707] {
                let on_hinge = grid.arcs.iter().filter(|arc| (arc.abs() - hinge).abs() < 1e-15).count();
                assert_eq!(on_hinge, 2, "{strips} strips, hinge at {hinge}");
            }
        }
        let refused = aerobat(4).unwrap_err().to_string();
        assert!(refused.starts_with("strips = 4") && refused.contains("every hinge"), "{refused}");
    }

    #[test]
    fn hinges_of_one_sided_surfaces_mirror_each_other() {
        let stations =
            [0.0, 0.2].map(|arc_m| PlanformStation { arc_m, leading_edge_m: 0.02, trailing_edge_m: -0.03 });
        let half = |span: Span, hinges: &[f64]| {
            StripGrid::new(&Planform::new(&stations).unwrap().spanning(span).unwrap(), 8, hinges, true)
                .unwrap()
        };
        for hinges in [&[0.05][..], &[0.1], &[0.03, 0.15], &[0.02, 0.08, 0.1]] {
            let [left, right] = [Span::Left, Span::Right].map(|span| half(span, hinges));
            for (a, b) in left.arcs.iter().zip(right.arcs.iter().rev()) {
                assert!((a + b).abs() < 1e-15, "{hinges:?}: {a} and {b}");
            }
            for hinge in hinges {
                assert!(
                    left.arcs.iter().any(|arc| (arc + 0.1 - hinge).abs() < 1e-15),
                    "{hinge} of {hinges:?}"
                );
            }
        }
    }

    #[test]
    fn a_tapered_surface_has_its_tips_where_it_ends_and_none_at_its_root() {
        let station =
            |arc_m, leading_edge_m| PlanformStation { arc_m, leading_edge_m, trailing_edge_m: -0.03 };
        let planform = Planform::new(&[station(0.0, 0.05), station(0.2, 0.01)]).unwrap();
        let tips = |span| {
            let planform = planform.clone().spanning(span).unwrap();
            StripGrid::new(&planform, 8, &[], true).unwrap().tip_chords
        };
        for (span, expected) in
            [(Span::Symmetric, [0.04, 0.04]), (Span::Left, [0.04, 0.0]), (Span::Right, [0.0, 0.04])]
        {
            let found = tips(span);
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-15), "{span:?}: {found:?}");
        }
    }

    #[test]
    fn angles_move_smoothly_onto_hinges_where_strips_keep_their_room() {
        let stations =
            [0.0, 1.0].map(|arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -0.3 });
        let planform = Planform::new(&stations).unwrap();
        let widths = |hinges: &[f64], map| {
            let edges = spacing(&planform, 24, hinges, map).unwrap().edges;
            edges.windows(2).map(|e| e[1] - e[0]).collect::<Vec<_>>()
        };
        // Steps of the angle are equal where it does not move: the largest jump from one to the next.
        let jump = |map| {
            let edges = spacing(&planform, 24, &[0.45], map).unwrap().edges;
            let angles: Vec<f64> = edges.iter().map(|edge| edge.acos()).collect();
            let steps: Vec<f64> = angles.windows(2).map(|a| (a[1] - a[0]).abs()).collect();
            steps.windows(2).map(|s| (s[1] / s[0]).ln().abs()).fold(0.0, f64::max)
        };
        let [straight, smooth] = [AngleMap::Straight, AngleMap::Smooth].map(jump);
        assert!(straight > 0.03 && smooth < 0.5 * straight, "{smooth} for {straight}");
        // Hinges that lie so that a spline would fold back keep the straight lines.
        let close = [0.02, 0.6, 0.62];
        assert_eq!(widths(&close, AngleMap::Straight), widths(&close, AngleMap::Smooth));
    }

    #[test]
    fn the_nearest_edges_are_taken_where_they_are_in_order() {
        let edge = [0.1, 0.5, 1.0, 1.6];
        assert_eq!(in_order(&edge, &[0.45, 1.1]), Some(vec![1, 2]));
        // Both are nearest to 0.5: the pair with the least squares.
        assert_eq!(in_order(&edge, &[0.52, 0.6]), Some(vec![1, 2]));
        assert_eq!(in_order(&edge, &[0.3, 0.5]), Some(vec![0, 1]));
        assert_eq!(in_order(&edge[..1], &[0.3, 0.5]), None);
        assert_eq!(in_order(&[], &[]), Some(vec![]));
    }
}

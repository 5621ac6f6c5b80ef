//! Where the strips lie on the wing and what of them never changes.

use crate::Error;
use crate::aero::{MAX_STRIPS, Planform};
use crate::math::interpolation::piecewise_linear;
use std::f64::consts::PI;

/// Constants of the strips, from left tip to right tip.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Arc coordinates of the edges, m, positive on the left wing.
    pub arcs: Vec<f64>,
    /// Arc coordinates of the control sections, m.
    pub control_arcs: Vec<f64>,
    /// Place of the control section between the strip's edges, 0 to 1.
    pub fraction: Vec<f64>,
    /// Chord, m.
    pub chord: Vec<f64>,
    /// Width perpendicular to the chord, m.
    pub width: Vec<f64>,
    /// Cosine of the sweep of the half-chord line.
    pub cos_half: Vec<f64>,
    /// Cosine of the sweep of the three-quarter-chord line.
    pub cos_three_quarter: Vec<f64>,
    /// Mean chord, m.
    pub mean_chord: f64,
    /// Arc span over mean chord.
    pub aspect: f64,
}

impl Grid {
    pub fn new(planform: &Planform, strips: usize, hinge_arcs: &[f64]) -> Result<Self, Error> {
        let (edges, fraction) = spacing(strips, planform.half_span(), hinge_arcs)?;
        let arcs: Vec<f64> = edges.iter().map(|e| -e * planform.half_span()).collect();
        let outline: Vec<(f64, f64)> = arcs.iter().map(|&s| planform.edges(s)).collect();
        // The chord direction is -x on the flat planform: widths are differences of arc.
        let width: Vec<f64> = arcs.windows(2).map(|a| a[0] - a[1]).collect();
        let chord: Vec<f64> = (0..strips)
            .map(|i| {
                let at = |j: usize| outline[j].0 - outline[j].1;
                at(i) + fraction[i] * (at(i + 1) - at(i))
            })
            .collect();
        let cosine = |x: f64| -> Vec<f64> {
            let ahead = |(le, te): (f64, f64)| le + x * (te - le);
            (0..strips)
                .map(|i| {
                    let run = ahead(outline[i + 1]) - ahead(outline[i]);
                    width[i] / width[i].hypot(run)
                })
                .collect()
        };
        let area: f64 = chord.iter().zip(&width).map(|(c, w)| c * w).sum();
        let span: f64 = width.iter().sum();
        let mean_chord = area / span;
        Ok(Self {
            control_arcs: (0..strips).map(|i| arcs[i] - fraction[i] * width[i]).collect(),
            fraction,
            cos_half: cosine(0.5),
            cos_three_quarter: cosine(0.75),
            mean_chord,
            aspect: span / mean_chord,
            arcs,
            chord,
            width,
        })
    }
}

impl Grid {
    /// Half width of the narrower strip beside each edge, m.
    pub fn half_widths(&self) -> impl Iterator<Item = f64> {
        let last = self.width.len() - 1;
        (0..=last + 1).map(move |j| 0.5 * self.width[j.min(last)].min(self.width[j.saturating_sub(1)]))
    }
}

/// Strip edges on [-1, 1] and the place of the control point in each strip.
///
/// Edges -cos((2j+1) pi/(2N+2)), control points -cos(i pi/(N+1)), i = 1..N; a
/// piecewise-linear map of the angle puts an edge on each hinge.
///
/// Equation: aero.strip.spacing
fn spacing(strips: usize, half_span: f64, hinge_arcs: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Error> {
    if strips == 0 || strips > MAX_STRIPS {
        return Err(Error::invalid("strips", strips, format!("1 to {MAX_STRIPS}")));
    }
    let n = strips as f64;
    let mut edge: Vec<f64> = (0..=strips).map(|j| (2 * j + 1) as f64 * PI / (2.0 * n + 2.0)).collect();
    let mut middle: Vec<f64> = (1..=strips).map(|i| i as f64 * PI / (n + 1.0)).collect();
    let (from, to) = hinge_map(&edge, half_span, hinge_arcs)?;
    for angle in edge.iter_mut().chain(&mut middle) {
        *angle = piecewise_linear(&from, &to, *angle);
    }
    let edge: Vec<f64> = edge.iter().map(|t| -t.cos()).collect();
    let fraction =
        middle.iter().zip(edge.windows(2)).map(|(t, e)| (-t.cos() - e[0]) / (e[1] - e[0])).collect();
    Ok((edge, fraction))
}

/// Knots of the angle map: the edge nearest to each hinge moves onto it.
fn hinge_map(edge: &[f64], half_span: f64, hinge_arcs: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let mut hinges: Vec<f64> = Vec::new();
    for (k, &arc) in hinge_arcs.iter().enumerate() {
        if !(arc >= 0.0 && arc < half_span) {
            let allowed = format!("0 to less than the half span {half_span}");
            return Err(Error::invalid(format!("hinge_arcs_m[{k}]"), arc, allowed));
        }
        hinges.push(arc / half_span);
        if arc > 0.0 {
            hinges.push(-arc / half_span);
        }
    }
    hinges.sort_by(f64::total_cmp);
    hinges.dedup();
    let (mut from, mut to) = (vec![0.0], vec![0.0]);
    for s in hinges {
        let angle = (-s).acos();
        let nearest = edge.iter().copied().min_by(|a, b| (a - angle).abs().total_cmp(&(b - angle).abs()));
        let nearest = nearest.unwrap_or(angle);
        if nearest <= from[from.len() - 1] {
            let allowed = "enough that every hinge has an edge of its own";
            return Err(Error::invalid("strips", edge.len() - 1, allowed));
        }
        from.push(nearest);
        to.push(angle);
    }
    from.push(PI);
    to.push(PI);
    Ok((from, to))
}

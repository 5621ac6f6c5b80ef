//! The flat outline of the wing by arc length from the middle.

use crate::Error;
use crate::math::interpolation::piecewise_linear;

/// Leading and trailing edge at one spanwise position of the half wing.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanformStation {
    /// Arc length from the plane of symmetry, m.
    pub arc_m: f64,
    /// Leading edge ahead of the hinge line, m (forward positive).
    pub leading_edge_m: f64,
    /// Trailing edge ahead of the hinge line, m (forward positive; usually negative).
    pub trailing_edge_m: f64,
}

/// A symmetric wing given by stations with straight edges between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Planform {
    arcs: Vec<f64>,
    leading: Vec<f64>,
    trailing: Vec<f64>,
}

impl Planform {
    /// Checks and stores the stations of the half wing, ascending from the middle.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there are fewer than two stations, arcs do not
    /// start at zero and ascend, or a chord is not positive.
    pub fn new(stations: &[PlanformStation]) -> Result<Self, Error> {
        let fail = |key: String, value: f64, allowed: &str| Err(Error::invalid(key, value, allowed));
        if stations.len() < 2 {
            let given = format!("{} stations", stations.len());
            return Err(Error::invalid("planform", given, "at least two stations"));
        }
        if stations[0].arc_m != 0.0 {
            return fail("planform[0].arc_m".into(), stations[0].arc_m, "0: the plane of symmetry");
        }
        for (i, s) in stations.iter().enumerate() {
            if i > 0 && !(s.arc_m > stations[i - 1].arc_m) {
                return fail(format!("planform[{i}].arc_m"), s.arc_m, "more than the station before");
            }
            if !(s.leading_edge_m - s.trailing_edge_m > 0.0) {
                return fail(
                    format!("planform[{i}].leading_edge_m"),
                    s.leading_edge_m,
                    "ahead of the trailing edge",
                );
            }
        }
        Ok(Self {
            arcs: stations.iter().map(|s| s.arc_m).collect(),
            leading: stations.iter().map(|s| s.leading_edge_m).collect(),
            trailing: stations.iter().map(|s| s.trailing_edge_m).collect(),
        })
    }

    /// Half span along the arc, m.
    pub fn half_span(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }
    /// Leading and trailing edge ahead of the hinge line at the arc coordinate
    /// `s` (either side), m.
    pub fn edges(&self, s: f64) -> (f64, f64) {
        let at = |ys| piecewise_linear(&self.arcs, ys, s.abs());
        (at(&self.leading), at(&self.trailing))
    }
    /// Chord at the arc coordinate `s`, m.
    pub fn chord(&self, s: f64) -> f64 {
        let (leading, trailing) = self.edges(s);
        leading - trailing
    }
    /// Area of both halves, m2 (trapezoids between stations).
    pub fn area(&self) -> f64 {
        self.arcs.windows(2).map(|a| (a[1] - a[0]) * (self.chord(a[0]) + self.chord(a[1]))).sum()
    }
}

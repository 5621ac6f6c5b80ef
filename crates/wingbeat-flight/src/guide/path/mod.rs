//! Paths over the ground: curves by their curvature or through points, and where on them a robot is.

mod curve;

pub use curve::{CurveSpec, FigureEightSpec, HelixSpec, LaneChangeSpec, LineSpec, PointsSpec};

use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::interpolation::lerp;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Scalar, Vec3};

/// Arc between the stations of a path, m.
const STATION: f64 = 0.02;
/// Most stations: 20 km.
const MAX_STATIONS: f64 = 1e6;

/// What is flown along: a straight line in the direction of the begin, then a curve, then straight on.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct PathSpec {
    /// Length of the line before the curve, m.
    #[serde(default)]
    pub lead_m: f64,
    /// The curve.
    pub curve: CurveSpec,
}

ranges!(PathSpec { lead_m: Range::between(0.0, 1000.0) });

/// A station of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Place, m.
    pub place: Vec3,
    /// Heading of the tangent over the ground, rad, left positive, not wrapped.
    pub heading: f64,
    /// Curvature over the ground, 1/m, left positive.
    pub curvature: f64,
}

/// A path by stations at equal arcs over the ground.
#[derive(Clone, Debug)]
pub struct Path {
    stations: Vec<Station>,
}

/// Where a place lies beside a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOffset {
    /// Arc of the nearest point over the ground, m.
    pub arc: f64,
    /// Distance to the left of it, m.
    pub cross: f64,
}

impl PathSpec {
    /// Keys of the numbers that shape the curve.
    pub fn keys(&self) -> Vec<String> {
        self.curve.keys().into_iter().map(|key| format!("curve.{key}")).collect()
    }

    /// The path.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn build(&self) -> Result<Path, Error> {
        self.in_range()?;
        let lead = (self.lead_m / STATION).round() as usize;
        let start = Station { place: Vec3::ZERO, heading: 0.0, curvature: 0.0 };
        let straight = |k: usize| Station { place: Vec3::new(k as f64 * STATION, 0.0, 0.0), ..start };
        let mut stations: Vec<Station> = (0..=lead).map(straight).collect();
        let curve = self.curve.stations(STATION, MAX_STATIONS).map_err(|e| e.within("curve"))?;
        let from = stations[lead].place;
        stations.extend(curve.into_iter().skip(1).map(|s| Station { place: s.place + from, ..s }));
        Ok(Path { stations })
    }
}

impl Path {
    /// Length over the ground, m.
    pub fn length(&self) -> f64 {
        (self.stations.len() - 1) as f64 * STATION
    }

    /// Largest magnitude of the curvature, 1/m.
    pub fn sharpest(&self) -> f64 {
        self.stations.iter().map(|s| s.curvature.abs()).fold(0.0, f64::max)
    }

    /// The path at the arc `arc`, m; straight on before and after it, level after.
    pub fn at(&self, arc: f64) -> Station {
        let last = self.stations.len() - 1;
        let beyond = |s: Station, by: f64| Station {
            place: s.place + Vec3::new(s.heading.cos(), s.heading.sin(), 0.0) * by,
            curvature: 0.0,
            ..s
        };
        if arc <= 0.0 {
            return beyond(self.stations[0], arc);
        }
        if arc >= self.length() {
            return beyond(self.stations[last], arc - self.length());
        }
        let k = ((arc / STATION) as usize).min(last - 1);
        let (a, b, share) = (&self.stations[k], &self.stations[k + 1], arc / STATION - k as f64);
        Station {
            place: a.place * (1.0 - share) + b.place * share,
            heading: lerp(a.heading, b.heading, share),
            curvature: lerp(a.curvature, b.curvature, share),
        }
    }

    /// The point of the path nearest to `place` over the ground, looked for from the arc `from` (m) on.
    ///
    /// Equation: guide.path_beside
    /// `(p - P(s)) . T(s) = 0 by Newton, slope -(1 - k e); e = (p - P) . N`
    /// Source: Frenet frame.
    /// Test: `what_lies_beside_is_found_again`.
    pub fn beside(&self, place: Vec3, from: f64) -> PathOffset {
        let mut arc = from;
        for _ in 0..20 {
            let station = self.at(arc);
            let (along, cross) = station.offset(place);
            // Newton for (place - P(s)) . T(s) = 0, whose slope is -(1 - curvature cross).
            let step = along / stretch(station.curvature * cross);
            arc += step.clamp(-0.5, 0.5);
            if step.abs() < 1e-9 {
                break;
            }
        }
        PathOffset { arc, cross: self.at(arc).offset(place).1 }
    }
}

/// Way along a line beside a path per way along the path, from the product of curvature and distance: 1 less that, and no
/// less than keeps clear of the centre.
pub(super) fn stretch(aside: f64) -> f64 {
    (1.0 - aside).max(0.2)
}

impl Station {
    /// `place` from the station, along its tangent and to its left, m.
    pub fn offset<S: Scalar>(&self, place: Vec3<S>) -> (S, S) {
        let ([x, y, _], (s, c)) = ((place - Vec3::constant(self.place)).0, self.heading.sin_cos());
        (x * c + y * s, y * c - x * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(curve: &str) -> Path {
        let spec: PathSpec = toml::from_str(&format!("lead_m = 2.0\ncurve = {curve}")).unwrap();
        spec.build().unwrap()
    }

    #[test]
    fn a_figure_of_eight_ends_where_and_as_it_begins_and_crosses_itself_there() {
        let eight = path("{ figure_eight = { radius_m = 4.0 } }");
        let (start, end, middle) =
            (eight.at(2.0), eight.at(eight.length()), eight.at(2.0 + 0.5 * (eight.length() - 2.0)));
        assert!((end.place - start.place).norm() < 1e-3 && (end.heading - start.heading).abs() < 1e-3);
        assert!((middle.place - start.place).norm() < 0.02, "{:?}", middle.place);
        assert!((eight.sharpest() - 0.25).abs() < 1e-4);
    }

    #[test]
    fn curves_have_the_sizes_that_they_say() {
        let lane = path("{ lane_change = { length_m = 10.0, aside_m = -1.5 } }");
        let end = lane.at(lane.length());
        assert!((end.place[1] + 1.5).abs() < 1e-3 && end.heading.abs() < 1e-6, "{end:?}");
        let helix = path("{ helix = { radius_m = -5.0, turns = 2.0, rise_m = 3.0 } }");
        let end = helix.at(helix.length());
        assert!((end.place[2] - 3.0).abs() < 1e-6 && (helix.sharpest() - 0.2).abs() < 1e-9, "{end:?}");
        assert!((end.heading + 2.0 * std::f64::consts::TAU).abs() < 1e-3, "{end:?}");
        let points = "[[4.0, 1.0, 0.2], [8.0, -1.0, 0.0], [12.0, 0.0, 0.1]]";
        let through = path(&format!("{{ points = {{ points_m = {points} }} }}"));
        for point in [[4.0, 1.0, 0.2], [8.0, -1.0, 0.0]] {
            let place = Vec3(point) + Vec3::new(2.0, 0.0, 0.0);
            let near = through.beside(place, place[0]);
            assert!(
                near.cross.abs() < 2e-3 && (through.at(near.arc).place[2] - point[2]).abs() < 2e-3,
                "{near:?}"
            );
        }
    }

    #[test]
    fn the_tangent_is_the_rate_of_the_place_and_the_curvature_that_of_the_heading() {
        for curve in [
            "{ figure_eight = { radius_m = 4.0 } }",
            "{ helix = { radius_m = 5.0, turns = 1.0 } }",
            "{ points = { points_m = [[4.0, 1.0, 0.0], [8.0, -1.0, 0.0], [12.0, 0.0, 0.0]] } }",
        ] {
            let path = path(curve);
            let mut arc = 1.0;
            while arc < path.length() - 0.1 {
                let (a, b) = (path.at(arc), path.at(arc + 0.04));
                let middle = path.at(arc + 0.02);
                let along = (b.place - a.place) * (1.0 / 0.04);
                assert!(
                    (along[1].atan2(along[0]) - middle.heading).rem_euclid(std::f64::consts::TAU).sin().abs()
                        < 2e-3
                );
                assert!((along[0].hypot(along[1]) - 1.0).abs() < 2e-3, "{curve} {arc}");
                assert!(((b.heading - a.heading) / 0.04 - middle.curvature).abs() < 2e-2, "{curve} {arc}");
                arc += 0.37;
            }
        }
    }

    #[test]
    fn what_lies_beside_is_found_again() {
        let path = path("{ figure_eight = { radius_m = 4.0 } }");
        let mut from = 0.0;
        while from < path.length() {
            let station = path.at(from);
            let left = Vec3::new(-station.heading.sin(), station.heading.cos(), 0.0);
            let found = path.beside(station.place + left * 0.3, from - 0.2);
            assert!((found.cross - 0.3).abs() < 1e-3 && (found.arc - from).abs() < 2e-2, "{from}: {found:?}");
            from += 0.51;
        }
    }
}

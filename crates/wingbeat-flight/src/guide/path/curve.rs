//! The curves that paths are made of.

use super::Station;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_math::{CubicSpline, Vec3};

/// First zero of the Bessel function J0: the swing of the heading at which a sine-generated curve closes.
const CLOSING: f64 = 2.404_825_557_695_773;
/// Lengths of curves, m.
const LENGTH: Range = Range::over(0.0, 10_000.0);
/// Most points.
const MAX_POINTS: usize = 1000;

/// A curve over the ground.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CurveSpec {
    /// Straight on.
    Line(LineSpec),
    /// To another line beside the first.
    LaneChange(LaneChangeSpec),
    /// Circles that climb or descend.
    Helix(HelixSpec),
    /// Circles to the left and to the right in turn.
    FigureEight(FigureEightSpec),
    /// Smoothly through points.
    Points(PointsSpec),
}

/// Straight on.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LineSpec {
    /// Length, m.
    pub length_m: f64,
}

/// To another line beside the first; the heading swings out and back as sin^2 of the arc.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LaneChangeSpec {
    /// Length along the curve, m.
    pub length_m: f64,
    /// Distance of the lines, left positive, m; at most half of the length.
    pub aside_m: f64,
}

/// Circles at an even climb; the curvature grows and goes smoothly over a radius of arc.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct HelixSpec {
    /// Radius, m; positive to the left.
    pub radius_m: f64,
    /// Number of turns.
    pub turns: f64,
    /// Height gained over all of it, m.
    #[serde(default)]
    pub rise_m: f64,
}

/// A figure of eight, to the left first, that begins and ends where it crosses itself: the sine-generated curve that
/// closes.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct FigureEightSpec {
    /// Least radius, m.
    pub radius_m: f64,
    /// How often it is flown.
    #[serde(default = "once")]
    pub laps: usize,
}

/// A natural cubic spline from the begin through points, by the lengths of its chords.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointsSpec {
    /// Points from where the curve begins, in W, m: two or more.
    pub points_m: Vec<[f64; 3]>,
}

fn once() -> usize {
    1
}

ranges!(LineSpec { length_m: LENGTH });
ranges!(LaneChangeSpec { length_m: LENGTH, aside_m: Range::between(-5000.0, 5000.0) });
ranges!(HelixSpec {
    radius_m: Range::between(-1000.0, 1000.0),
    turns: Range::over(0.0, 100.0),
    rise_m: Range::between(-1000.0, 1000.0),
});
ranges!(FigureEightSpec { radius_m: Range::over(0.0, 1000.0), laps: Range::between(1.0, 100.0) });

impl CurveSpec {
    /// Keys of its numbers.
    pub(super) fn keys(&self) -> Vec<String> {
        let of = |curve: &str, keys: &[&str]| keys.iter().map(|key| format!("{curve}.{key}")).collect();
        match self {
            Self::Line(_) => of("line", &["length_m"]),
            Self::LaneChange(_) => of("lane_change", &["length_m", "aside_m"]),
            Self::Helix(_) => of("helix", &["radius_m", "turns", "rise_m"]),
            Self::FigureEight(_) => of("figure_eight", &["radius_m", "laps"]),
            Self::Points(spec) => {
                let axes = |i: usize| (0..3).map(move |j| format!("points.points_m[{i}][{j}]"));
                (0..spec.points_m.len()).flat_map(axes).collect()
            }
        }
    }

    /// Stations from the origin along x, every `step` m, at most `most` of them.
    pub(super) fn stations(&self, step: f64, most: f64) -> Result<Vec<Station>, Error> {
        match self {
            Self::Line(line) => {
                line.in_range().map_err(|e| e.within("line"))?;
                limited("line.length_m", line.length_m, step, most)?;
                Ok(by_heading(line.length_m, step, |_| (0.0, 0.0)))
            }
            Self::LaneChange(lane) => lane.stations(step, most).map_err(|e| e.within("lane_change")),
            Self::Helix(helix) => helix.stations(step, most).map_err(|e| e.within("helix")),
            Self::FigureEight(eight) => eight.stations(step, most).map_err(|e| e.within("figure_eight")),
            Self::Points(points) => points.stations(step, most).map_err(|e| e.within("points")),
        }
    }
}

fn limited(key: &str, length: f64, step: f64, most: f64) -> Result<(), Error> {
    if length / step <= most {
        return Ok(());
    }
    Err(Error::invalid(key, length, format!("a curve of at most {} m", most * step)))
}

/// Stations every `step` m of a level curve of `length` m whose heading and curvature are functions of the arc; the place
/// is their integral by Simpson's rule.
fn by_heading(length: f64, step: f64, of: impl Fn(f64) -> (f64, f64)) -> Vec<Station> {
    let count = (length / step).round().max(1.0) as usize;
    let tangent = |s: f64| {
        let (sin, cos) = of(s).0.sin_cos();
        Vec3::new(cos, sin, 0.0)
    };
    let mut place = Vec3::ZERO;
    let mut stations = Vec::with_capacity(count + 1);
    for k in 0..=count {
        let s = k as f64 * step;
        let (heading, curvature) = of(s);
        stations.push(Station { place, heading, curvature });
        place += (tangent(s) + tangent(s + 0.5 * step) * 4.0 + tangent(s + step)) * (step / 6.0);
    }
    stations
}

impl FigureEightSpec {
    /// Equation: guide.figure_eight
    /// `heading j (1 - cos(2 pi s/L)), curvature sin(2 pi s/L)/r, L = 2 pi j r, j the first zero of J0, so that the
    /// curve closes`
    /// Source: Langbein & Leopold 1966, USGS Prof. Paper 422-H (sine-generated curves); own derivation of the
    /// closing.
    /// Test: `a_figure_of_eight_ends_where_and_as_it_begins_and_crosses_itself_there`.
    fn stations(&self, step: f64, most: f64) -> Result<Vec<Station>, Error> {
        self.in_range()?;
        let lap = CLOSING * TAU * self.radius_m;
        let length = lap * self.laps as f64;
        limited("radius_m", length, step, most)?;
        Ok(by_heading(length, step, |s| {
            let (sin, cos) = (TAU * s / lap).sin_cos();
            (CLOSING * (1.0 - cos), sin / self.radius_m)
        }))
    }
}

impl LaneChangeSpec {
    fn stations(&self, step: f64, most: f64) -> Result<Vec<Station>, Error> {
        self.in_range()?;
        limited("length_m", self.length_m, step, most)?;
        let length = self.length_m;
        let lane = |swing: f64| {
            by_heading(length, step, move |s| {
                let (sin, cos) = (PI * s / length).sin_cos();
                (swing * sin * sin, swing * TAU / length * sin * cos)
            })
        };
        let aside = |swing: f64| lane(swing).last().map_or(0.0, |s| s.place[1]);
        if self.aside_m.abs() > 0.5 * length {
            let error = Error::invalid("aside_m", self.aside_m, "at most half of length_m");
            return Err(error.against(["length_m"]));
        }
        // The distance grows with the swing up to more than that.
        let (mut low, mut high) = (-2.0, 2.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if aside(middle) < self.aside_m { low = middle } else { high = middle }
        }
        Ok(lane(0.5 * (low + high)))
    }
}

impl HelixSpec {
    fn stations(&self, step: f64, most: f64) -> Result<Vec<Station>, Error> {
        self.in_range()?;
        if !(self.radius_m.abs() > 1e-3) {
            return Err(Error::invalid("radius_m", self.radius_m, "1e-3 or more in magnitude"));
        }
        // Over a ramp of the curvature the heading grows by half of what it does over a circle's arc.
        let (curvature, ramp) = (1.0 / self.radius_m, self.radius_m.abs());
        let length = TAU * self.turns * ramp + ramp;
        limited("turns", length, step, most)?;
        if length < 2.0 * ramp {
            return Err(Error::invalid("turns", self.turns, "a sixth of a turn or more"));
        }
        // 3 a^2 - 2 a^3 of the share a of a ramp, and its integral a^3 - a^4/2.
        let grown = |s: f64| {
            let a = (s / ramp).clamp(0.0, 1.0);
            (a * a * (3.0 - 2.0 * a), ramp * a * a * a * (1.0 - 0.5 * a) + (s - ramp).max(0.0))
        };
        let mut stations = by_heading(length, step, |s| {
            let ((up, before), (down, after)) = (grown(s), grown(s - (length - ramp)));
            (curvature * (before - after), curvature * (up - down))
        });
        let last = (stations.len() - 1) as f64;
        for (k, station) in stations.iter_mut().enumerate() {
            station.place[2] = self.rise_m * k as f64 / last;
        }
        Ok(stations)
    }
}

/// Largest turn of a path from station to station, rad: sharper ones are cusps, where the curve runs back. *Choice.*
const SHARPEST: f64 = 0.5;

impl PointsSpec {
    fn stations(&self, step: f64, most: f64) -> Result<Vec<Station>, Error> {
        let points = &self.points_m;
        if points.len() < 2 || points.len() > MAX_POINTS {
            return Err(Error::invalid("points_m", points.len(), format!("2 to {MAX_POINTS} points")));
        }
        let mut chords = vec![0.0];
        let mut columns = [vec![0.0], vec![0.0], vec![0.0]];
        let mut before = Vec3::ZERO;
        for (i, point) in points.iter().enumerate() {
            require::finite(&format!("points_m[{i}]"), point)?;
            let [x, y, _] = (Vec3(*point) - before).0;
            let chord = x.hypot(y);
            if !(chord > 10.0 * step) {
                let allowed = format!("more than {} m over the ground from the point before", 10.0 * step);
                return Err(Error::invalid(format!("points_m[{i}]"), format!("{point:?}"), allowed));
            }
            chords.push(chords[i] + chord);
            limited("points_m", chords[i + 1], step, 0.5 * most)?;
            columns.iter_mut().zip(point).for_each(|(column, value)| column.push(*value));
            before = Vec3(*point);
        }
        let [x, y, z] = columns.map(|column| CubicSpline::natural(&chords, &column));
        let splines = [x?, y?, z?];
        let end = chords[points.len()];
        let (mut at, mut stations, mut heading) = (0.0, Vec::new(), 0.0);
        while at <= end {
            let [x, y, z] = splines.each_ref().map(|spline| spline.at(at));
            let speed = x.d.hypot(y.d).max(1e-6);
            let direction = y.d.atan2(x.d);
            let turn = (direction - heading + PI).rem_euclid(TAU) - PI;
            if turn.abs() > SHARPEST && !stations.is_empty() {
                let point = chords.iter().skip(2).position(|chord| at <= *chord).unwrap_or(0);
                let allowed = "points between which the path nowhere turns back on itself";
                let key = format!("points_m[{point}]");
                return Err(Error::invalid(key, format!("{:?}", points[point]), allowed));
            }
            heading += turn;
            let curvature = (x.d * y.dd - y.d * x.dd) / speed.powi(3);
            stations.push(Station { place: Vec3::new(x.x, y.x, z.x), heading, curvature });
            // The midpoint rule for equal arcs over the ground.
            let half = at + 0.5 * step / speed;
            let [x, y, _] = splines.each_ref().map(|spline| spline.at(half.min(end)));
            at += step / x.d.hypot(y.d).max(1e-6);
        }
        Ok(stations)
    }
}

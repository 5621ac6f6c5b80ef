//! One contour made of the curves of a drawing, and its stations along the span.

use super::drawing::{DrawingCurve, DrawingPoint};
use super::{Length, MOST, OutlineFault};

/// How far apart the ends of curves that join may lie, over the size of the drawing. *Choice.*
const JOINED: f64 = 1e-4;
/// Points closer along the span than this share of it lie at one station.
const AT_ONE: f64 = 1e-9;
/// Length along the span of a step of an edge, over the span. *Choice.*
const STEP: f64 = 1e-4;
/// Chord of an end that the drawing closes to a point, over the largest chord: a strip needs one. *Choice.*
const POINTED: f64 = 0.01;
/// Most curves of a contour. *Choice.*
const MOST_CURVES: usize = 5000;

/// A contour whose points are (along the span, forward).
pub struct Contour {
    pub line: usize,
    points: Vec<DrawingPoint>,
}

impl Contour {
    /// Joins the curves, whose points are (along the span, forward), end to end; a contour that is open at the root or at the tip is closed
    /// there by a straight line.
    pub fn joined(mut curves: Vec<DrawingCurve>, layers: &str) -> Result<Self, OutlineFault> {
        let line = curves.iter().map(|curve| curve.line).min().unwrap_or(1);
        let fault = |line, allowed| OutlineFault { line, key: "file", value: "outline".into(), allowed };
        if curves.len() > MOST_CURVES {
            return Err(fault(line, format!("at most {MOST_CURVES} curves")));
        }
        let near = JOINED * size(&curves);
        curves.retain(|curve| curve.points.iter().any(|point| apart(*point, curve.points[0]) > near));
        let Some(DrawingCurve { line: begin, layer, mut points }) = curves.pop() else {
            return Err(fault(line, "lines or curves that make one contour".into()));
        };
        let closed = |points: &[DrawingPoint]| apart(points[0], points[points.len() - 1]) <= near;
        // From its last point on, then from its first one.
        for _ in 0..2 {
            let ends = |curve: &DrawingCurve| [curve.points[0], curve.points[curve.points.len() - 1]];
            let follows = |curve: &DrawingCurve, end| {
                !closed(&curve.points) && ends(curve).iter().any(|point| apart(*point, end) <= near)
            };
            while !closed(&points)
                && let Some(i) = curves.iter().position(|curve| follows(curve, points[points.len() - 1]))
            {
                let mut next = curves.swap_remove(i).points;
                if apart(next[0], points[points.len() - 1]) > near {
                    next.reverse();
                }
                points.extend(next.into_iter().skip(1));
            }
            points.reverse();
        }
        if let Some(left) = curves.iter().min_by_key(|curve| curve.line) {
            let allowed = format!(
                "one contour, and this curve of layer {} is no part of that on line {begin} of layer {layer}; `layer` chooses among {layers}",
                left.layer
            );
            return Err(fault(left.line, allowed));
        }
        if closed(&points) {
            points.pop();
        } else {
            close(&mut points, near).map_err(|allowed| fault(line, allowed))?;
        }
        Ok(Self { line, points })
    }

    fn fault(&self, key: &'static str, allowed: String) -> OutlineFault {
        OutlineFault { line: self.line, key, value: "outline".into(), allowed }
    }

    /// The stations from the middle to the tip as (arc, leading edge, trailing edge), in the unit of the drawing.
    pub fn stations(&self, unit: Length) -> Result<Vec<[f64; 3]>, OutlineFault> {
        let (low, high) = self.reach(unit)?;
        let (a, b) = self.edges(low, high)?;
        let mut arcs: Vec<f64> = a.iter().chain(&b).map(|point| point[0]).collect();
        wingbeat_math::order::ascend(&mut arcs);
        arcs.dedup_by(|next, before| *next - *before <= AT_ONE * (high - low));
        if arcs.len() > MOST {
            return Err(self.fault("file", format!("at most {MOST} stations")));
        }
        let mut stations: Vec<[f64; 3]> =
            arcs.iter().map(|arc| [arc - low, at(&a, *arc), at(&b, *arc)]).collect();
        widen(&mut stations, unit).map_err(|allowed| self.fault("file", allowed))?;
        Ok(stations)
    }

    /// From where to where the outline reaches along the span.
    fn reach(&self, unit: Length) -> Result<(f64, f64), OutlineFault> {
        let (low, high) = reach(&self.points);
        let span = high - low;
        if !(span > 0.0) {
            return Err(self.fault("span", "the axis along which the outline extends".into()));
        }
        if low.abs() > JOINED * span {
            let allowed = format!(
                "the point of the drawing in the middle of the body on the hinge line; the outline of the half wing reaches from {low} \
                 to {high} {} along the span beside it",
                unit.name()
            );
            return Err(self.fault("origin", allowed));
        }
        Ok((low, high))
    }

    /// Both edges from root to tip.
    fn edges(&self, low: f64, high: f64) -> Result<(Vec<DrawingPoint>, Vec<DrawingPoint>), OutlineFault> {
        let turns = |point: DrawingPoint| {
            let allowed = format!("an outline with two edges; it turns back along the span at {}", point[0]);
            self.fault("file", allowed)
        };
        let n = self.points.len();
        let [a, b] = [1, n - 1].map(|step| self.edge(low, high, step).map_err(&turns));
        let ((a, from), (b, to)) = (a?, b?);
        // What lies between the ends of both edges is the tip.
        let mut tip = (0..n).map(|k| (from + k) % n).take_while(|i| *i != to);
        match tip.find(|i| high - self.points[*i][0] > AT_ONE * (high - low)) {
            Some(i) => Err(turns(self.points[i])),
            None => Ok((a, b)),
        }
    }

    /// The edge from root to tip in steps of `step` points, ascending along the span, and the number of its last point; else where it
    /// turns back.
    fn edge(&self, low: f64, high: f64, step: usize) -> Result<(Vec<DrawingPoint>, usize), DrawingPoint> {
        let (n, span) = (self.points.len(), high - low);
        let near = AT_ONE * span;
        let from = (0..n).find(|i| self.points[*i][0] - low <= near).unwrap_or(0);
        let (mut edge, mut reached, mut last): (Vec<DrawingPoint>, f64, usize) = (Vec::new(), low, from);
        for k in 0..n {
            last = (from + k * step) % n;
            let point = self.points[last];
            if point[0] < reached - near {
                return Err(point);
            }
            if point[0] - low <= near {
                // Of the root the last point: what leads there is the root itself.
                edge = vec![[low, point[1]]];
            } else if point[0] - reached <= near {
                edge.retain(|before| before[0] <= reached);
                edge.push([reached + STEP * span, point[1]]);
            } else {
                edge.retain(|before| before[0] < point[0]);
                edge.push(point);
                reached = point[0];
            }
            if high - point[0] <= near {
                break;
            }
        }
        Ok((edge, last))
    }
}

/// Puts leading edges before trailing ones, and gives ends that close to a point a chord; else what is allowed.
fn widen(stations: &mut [[f64; 3]], unit: Length) -> Result<(), String> {
    let larger = |most: f64, chord: f64| if chord.abs() > most.abs() { chord } else { most };
    let widest = stations.iter().map(|station| station[1] - station[2]).fold(0.0, larger);
    if widest < 0.0 {
        stations.iter_mut().for_each(|station| station.swap(1, 2));
    }
    let (least, last) = (POINTED * widest.abs(), stations.len() - 1);
    for (k, station) in stations.iter_mut().enumerate() {
        let chord = station[1] - station[2];
        let place = || format!("at {} {} along the span, station {k}", station[0], unit.name());
        if chord < -AT_ONE * widest.abs() {
            return Err(format!("edges that do not cross; they have crossed {}", place()));
        }
        if (k == 0 || k == last) && chord < least {
            let middle = 0.5 * (station[1] + station[2]);
            [station[1], station[2]] = [middle + 0.5 * least, middle - 0.5 * least];
        } else if !(chord > 0.0) {
            return Err(format!("edges that do not meet between root and tip; they do {}", place()));
        }
    }
    Ok(())
}

/// Puts the ends of an open contour onto the line at the root or at the tip, where a straight line closes it; else what is allowed.
fn close(points: &mut [DrawingPoint], near: f64) -> Result<(), String> {
    let (low, high) = reach(points);
    let last = points.len() - 1;
    let ends = [points[0][0], points[last][0]];
    let at = [low, high].into_iter().find(|arc| ends.iter().all(|end| (end - arc).abs() <= near));
    let at = at.ok_or_else(|| {
        let [a, b] = ends;
        format!("a closed contour, or one that is open along the root or the tip; its ends lie at {a} and {b} along the span")
    })?;
    (points[0][0], points[last][0]) = (at, at);
    Ok(())
}

/// From where to where points reach along the span.
fn reach(points: &[DrawingPoint]) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
        (low.min(point[0]), high.max(point[0]))
    })
}

/// The larger side of the rectangle about curves.
fn size(curves: &[DrawingCurve]) -> f64 {
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let side = |k: usize| {
        let of = |pick: fn(f64, f64) -> f64, start| all().fold(start, |most, point| pick(most, point[k]));
        of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)
    };
    side(0).max(side(1)).max(0.0)
}

fn apart(a: DrawingPoint, b: DrawingPoint) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The edge at `arc`, straight between its points.
fn at(edge: &[DrawingPoint], arc: f64) -> f64 {
    let k = edge.partition_point(|point| point[0] < arc).clamp(1, edge.len() - 1);
    let ([s, x], [t, y]) = (edge[k - 1], edge[k]);
    x + (y - x) * ((arc - s) / (t - s)).clamp(0.0, 1.0)
}

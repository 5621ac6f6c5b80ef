//! Broken lines as strokes of their own: readers of SVG disagree on where a pattern of strokes and gaps begins. Lines end at
//! points that are not finite.

use crate::canvas::{Canvas, Colour, PaperPoint, PathData, Primitive};
use crate::style;

/// Shortest pattern, px: a shorter one is a whole line.
const SHORTEST: f64 = 0.5;
/// Most strokes of a line, which is whole where it would take more.
const MOST: f64 = 20_000.0;

/// Every broken line of the scene as one path of its strokes.
pub fn cut(mut scene: Canvas) -> Canvas {
    scene.elements = scene.elements.into_iter().map(one).collect();
    scene
}

fn one(element: Primitive) -> Primitive {
    match element {
        Primitive::Line { x1, y1, x2, y2, stroke, stroke_width, stroke_dasharray: Some(dashes) } => {
            path(&[(x1, y1), (x2, y2)], &dashes, stroke, stroke_width)
        }
        Primitive::PolyLine { points, stroke, stroke_width, stroke_dasharray: Some(dashes) } => {
            path(&points, &dashes, stroke, stroke_width)
        }
        Primitive::PolyLine { points, stroke, stroke_width, stroke_dasharray: None }
            if !points.iter().all(is_finite) =>
        {
            path(&points, "", stroke, stroke_width)
        }
        other => other,
    }
}

fn path(points: &[PaperPoint], dashes: &str, stroke: Colour, stroke_width: f64) -> Primitive {
    // A broad line keeps its gaps open.
    let broad = (stroke_width / style::CURVE).max(1.0);
    let pattern: Vec<f64> = lengths(dashes).iter().map(|length| broad * length).collect();
    let pieces = strokes(points, &pattern);
    Primitive::Path(Box::new(PathData { pieces, fill: Colour::None, stroke, stroke_width, opacity: None }))
}

/// Strokes and gaps of an SVG pattern, px; an odd number of them is taken twice.
fn lengths(dashes: &str) -> Vec<f64> {
    let once: Vec<f64> = dashes.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
    if once.len() % 2 == 1 { once.repeat(2) } else { once }
}

fn is_finite(point: &PaperPoint) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// The strokes of a broken line through `points`, which points that are not finite part.
fn strokes(points: &[PaperPoint], pattern: &[f64]) -> Vec<Vec<PaperPoint>> {
    points.split(|point| !is_finite(point)).flat_map(|piece| strokes_of_piece(piece, pattern)).collect()
}

/// Those of a piece; the pattern runs on from point to point.
fn strokes_of_piece(points: &[PaperPoint], pattern: &[f64]) -> Vec<Vec<PaperPoint>> {
    let Some(first) = points.first() else { return Vec::new() };
    let period: f64 = pattern.iter().sum();
    let length: f64 = points.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
    if period < SHORTEST || length / period > MOST {
        return vec![points.to_vec()];
    }
    let (mut all, mut stroke) = (Vec::new(), vec![*first]);
    let (mut part, mut left) = (0, pattern[0]);
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let (length, mut done) = (distance(from, to), 0.0);
        while done + left < length {
            done += left;
            let share = done / length;
            let turn = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            stroke.push(turn);
            if part % 2 == 0 {
                all.push(std::mem::take(&mut stroke));
            }
            part = (part + 1) % pattern.len();
            left = pattern[part];
            stroke = vec![turn];
        }
        left -= length - done;
        stroke.push(to);
    }
    if part % 2 == 0 {
        all.push(stroke);
    }
    all
}

fn distance(a: PaperPoint, b: PaperPoint) -> f64 {
    (b.0 - a.0).hypot(b.1 - a.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(stroke: &[PaperPoint]) -> f64 {
        stroke.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
    }

    #[test]
    fn the_pattern_runs_on_over_short_pieces() {
        let points: Vec<PaperPoint> = (0..=990).map(|k| (0.1 * f64::from(k), 0.0)).collect();
        let cut = strokes(&points, &lengths("10 3 2 3"));
        assert_eq!(cut.len(), 11);
        for (k, stroke) in cut[..10].iter().enumerate() {
            let wanted = if k % 2 == 0 { (9.0 * k as f64, 10.0) } else { (9.0 * k as f64 + 4.0, 2.0) };
            assert!((stroke[0].0 - wanted.0).abs() < 1e-9 && (length(stroke) - wanted.1).abs() < 1e-9);
        }
    }

    #[test]
    fn corners_and_long_pieces_keep_the_pattern() {
        let cut = strokes(&[(0.0, 0.0), (10.0, 0.0), (10.0, 30.0)], &lengths("8 4"));
        assert_eq!(cut.len(), 4);
        assert_eq!(cut[1], [(10.0, 2.0), (10.0, 10.0)]);
        assert_eq!(strokes(&[(0.0, 0.0), (9.0, 0.0)], &lengths("5")).len(), 1);
    }

    #[test]
    fn points_that_are_not_finite_part_a_line() {
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, f64::NAN), (3.0, 0.0), (4.0, 0.0)];
        let pieces = [vec![(0.0, 0.0), (1.0, 0.0)], vec![(3.0, 0.0), (4.0, 0.0)]];
        assert_eq!(strokes(&points, &lengths("")), pieces);
        assert_eq!(strokes(&points, &lengths("8 4")), pieces);
    }

    #[test]
    fn what_cannot_be_broken_is_whole() {
        let points = [(0.0, 0.0), (5.0, 0.0)];
        assert_eq!(strokes(&points, &lengths("0 0")), [points.to_vec()]);
        assert_eq!(strokes(&points, &lengths("")), [points.to_vec()]);
        assert!(strokes(&[(f64::NAN, 0.0)], &lengths("2 2")).is_empty());
        let far = [(0.0, 0.0), (1e9, 0.0)];
        assert_eq!(strokes(&far, &lengths("2 2")), [far.to_vec()]);
    }
}

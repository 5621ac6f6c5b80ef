//! What moves: the robot frame by frame, as the code that flew it places it.

use wingbeat::math::Vec3;

/// Frames a second that a page shows.
pub const RATE: f64 = 200.0;
/// Fewest frames of a record that has as many rows: a short cycle is looked at slowly.
const LEAST: f64 = 400.0;
/// Most frames: a minute at [`RATE`].
pub const MOST: usize = 12_000;
/// Farthest place that is drawn, m.
const FARTHEST: f64 = 1e4;

/// Half the length, and the radius, of the spindle that stands for the body, as shares of the reach: our choice.
pub const SPINDLE_SIZE: [f64; 2] = [0.34, 0.075];
/// Its rings from the sharp nose on: place along its half length, and radius as a share of the largest.
pub const SPINDLE: [[f64; 2]; 5] = [[1.0, 0.02], [0.45, 0.75], [0.0, 1.0], [-0.7, 0.6], [-1.0, 0.15]];

/// A point over the frames, m or N.
pub type PointTrack = [Vec<f64>; 3];

/// A surface over the frames, in B.
#[derive(Clone, Debug, Default)]
pub struct SurfaceTrack {
    /// Name.
    pub name: String,
    /// Leading and trailing edge of each rib, from left tip to right tip.
    pub ribs: Vec<[PointTrack; 2]>,
    /// Whether there is surface between a rib and the next.
    pub covered: Vec<bool>,
    /// Of each panel 0 on the left, 1 on the right, 2 on neither.
    pub side: Vec<usize>,
    /// Points of a membrane or a flap above each rib, of [`Outline::raised`](wingbeat::robot::Outline::raised); none of a rigid surface.
    pub raised: Vec<[PointTrack; 3]>,
    /// Which of these points is the hinge of a flap.
    pub hinge: Option<usize>,
    /// Its strips, from left to right.
    pub strips: Vec<StripTrack>,
}

/// A strip over the frames, in B.
#[derive(Clone, Debug, Default)]
pub struct StripTrack {
    /// Where it lies: number of the rib to its left, and the share of the way to the next.
    pub rib: f64,
    /// Point at 1/4 chord.
    pub quarter_chord: PointTrack,
    /// Force of the air, N.
    pub force: PointTrack,
    /// Moment of the air about that point, N m; none where the strips of a record do not tell it.
    pub moment: PointTrack,
    /// Circulation, m2/s; none where the model has none.
    pub circulation: Vec<f64>,
}

/// A named force over the frames, in B.
#[derive(Clone, Debug)]
pub struct ForceTrack {
    /// Its name.
    pub name: String,
    /// Where it is drawn from: a place in B, m; the centre of mass where none.
    pub place: Option<[f64; 3]>,
    /// The force, N.
    pub force: PointTrack,
}

/// A line through moving points, in W.
#[derive(Clone, Debug)]
pub struct LineTrack {
    /// What it is.
    pub name: &'static str,
    /// Weight, px.
    pub weight: f64,
    /// Its points.
    pub points: Vec<PointTrack>,
}

/// All that moves.
#[derive(Clone, Debug, Default)]
pub struct RunMotion {
    /// Time of each frame, s.
    pub t: Vec<f64>,
    /// The body's origin in W, m.
    pub position: PointTrack,
    /// Attitude of the body, the unit quaternion w, x, y, z of R_WB.
    pub attitude: [Vec<f64>; 4],
    /// Centre of mass, in B, m.
    pub com: PointTrack,
    /// The surfaces.
    pub surfaces: Vec<SurfaceTrack>,
    /// Forces by source.
    pub sources: Vec<ForceTrack>,
    /// Arm and sting, or a perch.
    pub lines: Vec<LineTrack>,
    /// Places that a path asks for, in W.
    pub path: Option<PointTrack>,
    /// Corners of the table that the arm stands on, in W, m.
    pub table: Option<[[f64; 3]; 4]>,
    /// Velocity of the air, in W, m/s.
    pub wind: [f64; 3],
    /// What the circulation of the strips is; none where there is none to show.
    pub circulation: Option<&'static str>,
    /// Whether it begins again at its end.
    pub repeats: bool,
    /// Whether the body goes somewhere; else it is held.
    pub free: bool,
    /// Whether there is a wing alone, without a body.
    pub bare: bool,
    /// Height of the ground, or of a ceiling, in W, m.
    pub ground: Option<f64>,
}

/// The rows of the times `t` that are shown, of which the first `sound` can be.
pub fn rows(t: &[f64], sound: usize) -> Vec<usize> {
    let ascends = |i: &usize| *i == 0 || t[*i] > t[*i - 1];
    let sound = (0..sound.min(t.len())).take_while(|i| t[*i].is_finite() && ascends(i)).count();
    let Some(last) = sound.checked_sub(1) else { return Vec::new() };
    let span = t[last] - t[0];
    let frames = (RATE * span).max(LEAST).min((MOST - 1) as f64);
    let step = span / frames;
    let mut rows: Vec<usize> = Vec::new();
    for i in 0..sound {
        let next = t[0] + rows.len() as f64 * step;
        if t[i] >= next - 1e-6 * step && rows.len() < MOST {
            rows.push(i);
        }
    }
    rows
}

/// Number of rows that come before the first whose place cannot be drawn.
pub fn sound(columns: &[&[f64]]) -> usize {
    let rows = columns.first().map_or(0, |column| column.len());
    let drawn = |i: &usize| columns.iter().all(|column| column[*i].abs() <= FARTHEST);
    (0..rows).take_while(drawn).count()
}

/// Corners, m, of the rings of a spindle about `centre`, `around` each and of a size that goes with `reach` (all in m), in the
/// axes of the body.
pub fn spindle(centre: Vec3, reach: f64, around: u16) -> Vec<Vec<Vec3>> {
    let [l, r] = SPINDLE_SIZE.map(|share| share * reach);
    let corner = |[x, w]: [f64; 2], k: u16| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(around);
        centre + Vec3([l * x, r * w * angle.cos(), r * w * angle.sin()])
    };
    SPINDLE.iter().map(|ring| (0..around).map(|k| corner(*ring, k)).collect()).collect()
}

/// Adds a frame to a track, in the unit of the track.
pub fn push(track: &mut PointTrack, value: Vec3) {
    track.iter_mut().zip(value.0).for_each(|(column, value)| column.push(value));
}

/// A unit vector along `v`; zero where that has no length.
pub fn direction(v: Vec3) -> Vec3 {
    v * (1.0 / v.norm().max(1e-300))
}

/// The point of a track in frame `i`, in the unit of the track.
pub fn at(track: &PointTrack, i: usize) -> Vec3 {
    Vec3(std::array::from_fn(|axis| track[axis][i]))
}

impl RunMotion {
    /// Every column, in an order that depends on what moves alone.
    fn columns(&mut self) -> Vec<&mut Vec<f64>> {
        let mut all: Vec<&mut Vec<f64>> = vec![&mut self.t];
        let tracks = [&mut self.position, &mut self.com].into_iter().chain(&mut self.path);
        all.extend(tracks.flatten());
        all.extend(&mut self.attitude);
        for surface in &mut self.surfaces {
            all.extend(surface.ribs.as_flattened_mut().as_flattened_mut());
            all.extend(surface.raised.as_flattened_mut().as_flattened_mut());
            for strip in &mut surface.strips {
                all.extend(strip.quarter_chord.iter_mut().chain(&mut strip.force).chain(&mut strip.moment));
                all.push(&mut strip.circulation);
            }
        }
        all.extend(self.sources.iter_mut().flat_map(|source| &mut source.force));
        all.extend(self.lines.iter_mut().flat_map(|line| &mut line.points).flatten());
        all
    }

    /// Adds the frames of `more` of the same robot; true where it is that.
    pub fn extend(&mut self, mut more: Self) -> bool {
        let (all, new) = (self.columns(), more.columns());
        let same = all.len() == new.len();
        all.into_iter().zip(new).for_each(|(column, more)| column.append(more));
        same
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.t.len()
    }

    /// Largest distance of a rib's edge from the body's origin, m; 0.1 where there is none.
    pub fn reach(&self) -> f64 {
        let edges = self.surfaces.iter().flat_map(|surface| surface.ribs.iter().flatten());
        let squares = edges.flat_map(|edge| (0..edge[0].len()).map(|i| at(edge, i).norm()));
        Some(squares.fold(0.0, f64::max)).filter(|reach| *reach > 0.0 && reach.is_finite()).unwrap_or(0.1)
    }

    /// The point `p` of B in W in frame `i`, m.
    pub fn in_world(&self, i: usize, p: Vec3) -> Vec3 {
        at(&self.position, i) + self.turned(i, p)
    }

    /// The vector `v` of B in W in frame `i`: v + 2 w (u x v) + 2 u x (u x v) of the quaternion (w, u).
    pub fn turned(&self, i: usize, v: Vec3) -> Vec3 {
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| self.attitude[k][i]);
        let u = Vec3([x, y, z]);
        let cross = u.cross(v);
        v + cross * (2.0 * w) + u.cross(cross) * 2.0
    }
}

impl SurfaceTrack {
    /// Points along rib `k` from the leading to the trailing edge in frame `i`, in B, m: its edges, and of a membrane what lies
    /// between.
    pub fn along(&self, k: usize, i: usize) -> Vec<Vec3> {
        let [leading, trailing] = &self.ribs[k];
        let between = self.raised.get(k).map_or(&[][..], |points| points);
        std::iter::once(leading).chain(between).chain([trailing]).map(|track| at(track, i)).collect()
    }

    /// Says of each strip where it lies between the ribs as they are in the first frame: nearest to its point at 1/4 chord.
    pub fn place_strips(&mut self) {
        let quarter = |rib: &[PointTrack; 2]| at(&rib[0], 0) * 0.75 + at(&rib[1], 0) * 0.25;
        if self.ribs.is_empty() || self.ribs[0][0][0].is_empty() {
            self.strips.clear();
            return;
        }
        let line: Vec<Vec3> = self.ribs.iter().map(quarter).collect();
        for strip in &mut self.strips {
            let point = at(&strip.quarter_chord, 0);
            let mut nearest = (f64::INFINITY, 0.0);
            for (k, ends) in line.windows(2).enumerate() {
                let along = ends[1] - ends[0];
                let share = ((point - ends[0]).dot(along) / along.dot(along).max(1e-300)).clamp(0.0, 1.0);
                let away = (ends[0] + along * share - point).norm();
                if away < nearest.0 {
                    nearest = (away, k as f64 + share);
                }
            }
            strip.rib = nearest.1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_as_many_as_can_be_shown() {
        let t: Vec<f64> = (0..=5000).map(|i| 1e-3 * f64::from(i)).collect();
        assert_eq!(rows(&t, t.len()).len(), 1001);
        assert!(rows(&t, 0).is_empty());
        let million: Vec<f64> = (0..1_000_000).map(|i| 1e-3 * f64::from(i)).collect();
        let shown = rows(&million, million.len());
        assert!(shown.len() <= MOST && *shown.last().unwrap() > 999_000, "{}", shown.len());
        assert_eq!(rows(&[0.0, 1.0, f64::NAN, 3.0], 4), [0, 1]);
        assert_eq!(sound(&[&[0.0, 1e300, 0.0]]), 1);
    }
}

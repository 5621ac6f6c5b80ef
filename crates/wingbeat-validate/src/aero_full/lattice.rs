//! A linear vortex lattice of a wing in small motion with its harmonic wake: what the tables do not hold.

use super::linear::{Complex, RigidMotion};
use crate::Error;
use std::f64::consts::PI;
use wingbeat::math::Vec3;
use wingbeat::math::linear::{lu_factor, lu_solve};

/// Length of the wake, mean chords.
const WAKE: f64 = 40.0;

/// Leading and trailing edge of a section, m, x forward and y to the left.
pub(super) type SectionChord = [Vec3; 2];

/// Loading at the control points of one half of the span, from the tip inwards.
#[derive(Clone, Debug)]
pub struct Loading {
    /// Circulation over speed, chord and upwash angle.
    pub circulation: Vec<Complex>,
    /// Force per span over dynamic pressure, chord and upwash angle.
    pub force: Vec<Complex>,
}

/// A wing that its left and right half mirror, flat between the edges of its strips, in a wind of 1 m/s from ahead; panels
/// even along the chord, vortices at 1/4 and flow tangent at 3/4 of each panel.
pub(super) struct HarmonicLattice {
    /// Panels along a chord.
    pub chordwise: usize,
    /// The edges of the strips from the left tip to the right one, an odd number.
    pub edges: Vec<SectionChord>,
    /// Where between their edges the control sections of the strips of the left half lie, 0 to 1, from the tip inwards.
    pub fractions: Vec<f64>,
    /// Mean chord, m.
    pub chord: f64,
    /// Angular frequency, rad/s.
    pub omega: f64,
}

/// The share `place` of the way from leading to trailing edge.
fn along([leading, trailing]: SectionChord, place: f64) -> Vec3 {
    leading + (trailing - leading) * place
}

/// The normal velocity n . v at `p` of a horseshoe of unit circulation that comes from behind to the first of its `ends`
/// and leaves from the second: bound vortex n . (r1 x r2) (a + b) / (4 pi a b (a b + r1.r2)), legs
/// n . (u x r) / (4 pi r (r - u.r)), u straight back.
fn horseshoe([left, right]: [Vec3; 2], p: Vec3, n: Vec3) -> f64 {
    let (from_left, from_right) = (p - left, p - right);
    let (a, b) = (from_left.norm(), from_right.norm());
    let bound = n.dot(from_left.cross(from_right)) * (a + b) / (a * b * (a * b + from_left.dot(from_right)));
    let leg = |r: Vec3, length: f64| {
        let beside2 = r[1] * r[1] + r[2] * r[2];
        // r - u.r, without the difference where it cancels.
        let less = if r[0] < 0.0 { beside2 / (length - r[0]) } else { length + r[0] };
        (n[1] * r[2] - n[2] * r[1]) / (length * less)
    };
    (bound + leg(from_right, b) - leg(from_left, a)) / (4.0 * PI)
}

impl HarmonicLattice {
    /// A rectangle of unit chord and the aspect ratio `aspect` on Lan's stations.
    fn rectangle(aspect: f64, chordwise: usize, spanwise: usize, omega: f64) -> Self {
        let step = PI / (spanwise + 1) as f64;
        let place = |t: f64| 0.5 * aspect * (t * step).cos();
        let line = |j: usize| [0.0, -1.0].map(|x| Vec3::new(x, place(j as f64 + 0.5), 0.0));
        let fraction = |j: usize| {
            let [a, b, control] = [0.5, 1.5, 1.0].map(|past| place(j as f64 + past));
            (a - control) / (a - b)
        };
        Self {
            chordwise,
            edges: (0..=spanwise).map(line).collect(),
            fractions: (0..spanwise / 2).map(fraction).collect(),
            chord: 1.0,
            omega,
        }
    }

    /// Place of vortex `i` over the chord; half a panel behind is its control point.
    fn place(&self, i: usize) -> f64 {
        (i as f64 + 0.25) / self.chordwise as f64
    }

    /// Control section of strip `j`.
    fn station(&self, j: usize) -> SectionChord {
        let [left, right] = [self.edges[j], self.edges[j + 1]];
        [0, 1].map(|end| left[end] + (right[end] - left[end]) * self.fractions[j])
    }

    /// Length of a panel of strip `j`, m.
    fn panel(&self, j: usize) -> f64 {
        let [leading, trailing] = self.station(j);
        (leading - trailing).norm() / self.chordwise as f64
    }

    /// Ends of vortex `i` of strip `j`, `behind` m further back.
    fn ends(&self, j: usize, i: usize, behind: f64) -> [Vec3; 2] {
        [j, j + 1].map(|edge| along(self.edges[edge], self.place(i)) - Vec3::new(behind, 0.0, 0.0))
    }

    fn normal(&self, j: usize) -> Vec3 {
        let [[leading, trailing], [next, _]] = [self.edges[j], self.edges[j + 1]];
        (trailing - leading).cross(next - leading).unit()
    }

    /// Normal velocity at `p` of the horseshoe of strip `j` and of its mirror image.
    fn pair(&self, j: usize, i: usize, behind: f64, (p, n): (Vec3, Vec3)) -> f64 {
        let ends = self.ends(j, i, behind);
        let mirrored = |v: Vec3| Vec3::new(v[0], -v[1], v[2]);
        horseshoe(ends, p, n) + horseshoe(ends, mirrored(p), mirrored(n))
    }

    /// How far behind the last row of the wing the rows of the wake lie, m.
    fn wake_rows(&self) -> Vec<f64> {
        let (mut rows, panel) = (vec![0.0], self.chord / self.chordwise as f64);
        if self.omega == 0.0 {
            rows.push(WAKE * self.chord);
        }
        let mut at = 0.0;
        while self.omega != 0.0 && at < WAKE * self.chord {
            at += (0.05 * (at + 0.25 * panel - 0.5 * self.chord)).min(0.1 * self.chord).max(panel);
            rows.push(at);
        }
        rows
    }

    /// Normal velocity of the wake that carries e^(-i omega x) behind the last ring. Its vortices stand at 1/4 of
    /// the wake's panels like the wing's; a ring holds what left at the border between two.
    fn wake(&self, j: usize, rows: &[f64], target: (Vec3, Vec3)) -> Complex {
        let mut at_start = self.pair(j, self.chordwise, 0.0, target);
        rows.windows(2).fold((0.0, 0.0), |sum, row| {
            let at_end = self.pair(j, self.chordwise, row[1], target);
            let phase = -self.omega * (row[0] + 0.25 * self.panel(j) + 0.75 * (row[1] - row[0]));
            let ring = at_start - at_end;
            at_start = at_end;
            (sum.0 + ring * phase.cos(), sum.1 + ring * phase.sin())
        })
    }

    /// Ring strengths, chordwise within each strip, for each of so many `columns` of which `wash` tells the upwash at a point.
    fn solve(
        &self,
        columns: usize,
        wash: impl Fn(usize, Vec3) -> Complex,
    ) -> Result<Vec<Vec<Complex>>, Error> {
        let (nc, ns) = (self.chordwise, self.fractions.len());
        let (n, rows) = (nc * ns, self.wake_rows());
        let (mut m, mut rhs) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * columns]);
        for row in 0..n {
            let (p, normal) = (
                along(self.station(row / nc), self.place(row % nc) + 0.5 / nc as f64),
                self.normal(row / nc),
            );
            for column in 0..columns {
                let (re, im) = wash(column, p);
                rhs[row * columns + column] = -normal[2] * re;
                rhs[(n + row) * columns + column] = -normal[2] * im;
            }
            for j in 0..ns {
                let mut front = self.pair(j, 0, 0.0, (p, normal));
                for i in 0..nc {
                    let next = self.pair(j, i + 1, 0.0, (p, normal));
                    let ring = std::mem::replace(&mut front, next) - next;
                    let tail = if i + 1 == nc { self.wake(j, &rows, (p, normal)) } else { (0.0, 0.0) };
                    let column = j * nc + i;
                    m[row * 2 * n + column] = ring + tail.0;
                    m[(n + row) * 2 * n + n + column] = ring + tail.0;
                    m[row * 2 * n + n + column] = -tail.1;
                    m[(n + row) * 2 * n + column] = tail.1;
                }
            }
        }
        let mut pivots = vec![0; 2 * n];
        if !lu_factor(&mut m, 2 * n, &mut pivots) {
            return Err(Error::NoAnswer("the lattice is singular".into()));
        }
        lu_solve(&m, 2 * n, &pivots, &mut rhs, columns);
        let ring = |i: usize, column: usize| (rhs[i * columns + column], rhs[(n + i) * columns + column]);
        Ok((0..columns).map(|column| (0..n).map(|i| ring(i, column)).collect()).collect())
    }

    /// Force per span over dynamic pressure of each strip, m: 2 [Gamma + i omega sum(G dx)], Kutta-Joukowski of the bound
    /// vortices and the rate of the jump. A ring holds the jump at the end of its panel, so the sum is the trapezoid's: half of the last
    /// ring lies on the wing.
    fn force(&self, rings: &[Complex]) -> Vec<Complex> {
        let of = |(j, strip): (usize, &[Complex])| {
            let (end, panel) = (strip[strip.len() - 1], self.omega * self.panel(j));
            let start = (-0.5 * end.0, -0.5 * end.1);
            let sum = strip.iter().fold(start, |s, g| (s.0 + g.0, s.1 + g.1));
            (2.0 * (end.0 - panel * sum.1), 2.0 * (end.1 + panel * sum.0))
        };
        rings.chunks_exact(self.chordwise).enumerate().map(of).collect()
    }

    /// Vertical force of the whole wing per unit of each small motion, N in air of 1 kg/m3.
    ///
    /// # Errors
    /// [`Error::NoAnswer`] when the lattice is singular.
    pub fn lift(&self, motions: &[RigidMotion]) -> Result<Vec<Complex>, Error> {
        let sum = |strips: Vec<Complex>| strips.iter().fold((0.0, 0.0), |sum, f| (sum.0 + f.0, sum.1 + f.1));
        Ok(self.strip_lift(motions)?.into_iter().map(sum).collect())
    }

    /// Vertical force of each strip of the left half, from the tip inwards, and of its image, per unit of each small motion, N in air
    /// of 1 kg/m3. Of a wing that flaps its panels lie flat.
    ///
    /// # Errors
    /// [`Error::NoAnswer`] when the lattice is singular.
    pub fn strip_lift(&self, motions: &[RigidMotion]) -> Result<Vec<Vec<Complex>>, Error> {
        let wash = |motion: usize, p: Vec3| match motions[motion] {
            RigidMotion::Plunge => (0.0, self.omega),
            RigidMotion::Pitch(axis) => (1.0, self.omega * (axis - p[0])),
            RigidMotion::Flap(hinge) => (0.0, -self.omega * (p[1].abs() - hinge.arc_m).max(0.0)),
        };
        let width = |j: usize| self.edges[j][0][1] - self.edges[j + 1][0][1];
        let strips = |rings: Vec<Complex>| {
            let forces = self.force(&rings).into_iter().enumerate();
            forces.map(|(j, f)| (f.0 * width(j), f.1 * width(j))).collect()
        };
        Ok(self.solve(motions.len(), wash)?.into_iter().map(strips).collect())
    }
}

/// Loading of a rectangular wing of aspect ratio `aspect` that plunges at the reduced
/// frequency `k`, on `chordwise` x `spanwise` panels.
///
/// # Errors
/// [`Error::NoAnswer`] when the lattice is singular.
pub fn loading(aspect: f64, k: f64, chordwise: usize, spanwise: usize) -> Result<Loading, Error> {
    let lattice = HarmonicLattice::rectangle(aspect, chordwise, spanwise, 2.0 * k);
    let rings = lattice.solve(1, |_, _| (1.0, 0.0))?.remove(0);
    let strips = rings.chunks_exact(chordwise);
    Ok(Loading {
        circulation: strips.map(|strip| strip[chordwise - 1]).collect(),
        force: lattice.force(&rings),
    })
}

/// Places, in chords, across the span of a rectangular wing of aspect ratio `aspect` in steady flow, from one tip
/// to the middle, and the downwash there, per speed and incidence, at `behind` chords behind its leading edge in its plane, on
/// `chordwise` x `spanwise` panels.
///
/// # Errors
/// [`Error::NoAnswer`] when the lattice is singular.
pub fn downwash(
    aspect: f64,
    behind: f64,
    chordwise: usize,
    spanwise: usize,
) -> Result<Vec<(f64, f64)>, Error> {
    let lattice = HarmonicLattice::rectangle(aspect, chordwise, spanwise, 0.0);
    let rings = lattice.solve(1, |_, _| (1.0, 0.0))?.remove(0);
    let upwash = |y: f64| -> f64 {
        let target = (Vec3::new(-behind, y, 0.0), Vec3::new(0.0, 0.0, 1.0));
        let vortices = rings.iter().enumerate().map(|(column, ring)| {
            let (j, i) = (column / chordwise, column % chordwise);
            // A ring of the last row is open: its wake is a horseshoe.
            let rear = if i + 1 == chordwise { 0.0 } else { lattice.pair(j, i + 1, 0.0, target) };
            ring.0 * (lattice.pair(j, i, 0.0, target) - rear)
        });
        vortices.sum()
    };
    let places = (0..lattice.fractions.len()).map(|j| lattice.station(j)[0][1]);
    // In the order of the right half, which mirrors the left one.
    Ok(places.map(|y| (-y, -upwash(y))).collect())
}

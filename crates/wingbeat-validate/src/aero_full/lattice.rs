//! A linear vortex lattice of a plunging rectangular wing with its harmonic wake: the span loading
//! that the circulation tables do not hold.

use super::linear::Complex;
use crate::Error;
use std::f64::consts::PI;
use wingbeat::math::linear::{lu_factor, lu_solve};

/// Length of the wake, chords.
const WAKE: f64 = 40.0;

/// Loading at the control points of one half of the span, from the tip inwards.
#[derive(Clone, Debug)]
pub struct Loading {
    /// Circulation over speed, chord and upwash angle.
    pub circulation: Vec<Complex>,
    /// Force per span over dynamic pressure, chord and upwash angle.
    pub force: Vec<Complex>,
}

/// A rectangular wing of unit chord in unit speed, panels even along the chord, Lan's
/// stations along the span, vortices at 1/4 and flow tangent at 3/4 of each panel.
struct Lattice {
    chordwise: usize,
    edges: Vec<f64>,
    stations: Vec<f64>,
    omega: f64,
}

impl Lattice {
    fn new(aspect: f64, chordwise: usize, spanwise: usize, omega: f64) -> Self {
        let step = PI / (spanwise + 1) as f64;
        let place = |t: f64| -0.5 * aspect * (t * step).cos();
        Self {
            chordwise,
            edges: (0..=spanwise).map(|j| place(j as f64 + 0.5)).collect(),
            stations: (1..=spanwise / 2).map(|j| place(j as f64)).collect(),
            omega,
        }
    }

    /// Place of vortex `i` and, half a panel behind, of its control point.
    fn vortex(&self, i: usize) -> f64 {
        (i as f64 + 0.25) / self.chordwise as f64
    }

    /// Upwash at (x, y) of a horseshoe between the edges of strip `j` and of its mirror image,
    /// bound at `front`: w = [K(Y2) - K(Y1)] / 4 pi, K(Y) = (1 + sqrt(X^2 + Y^2)/X)/Y.
    fn horseshoe(&self, j: usize, front: f64, x: f64, y: f64) -> f64 {
        let run = x - front;
        let half = |edge: f64| (1.0 + run.hypot(y - edge) / run) / (y - edge);
        let last = self.edges.len() - 1;
        let pair = |j: usize| half(self.edges[j + 1]) - half(self.edges[j]);
        (pair(j) + pair(last - 1 - j)) / (4.0 * PI)
    }

    /// Upwash of the wake that carries e^(-i omega x) behind the last ring. Its vortices stand at 1/4 of
    /// the wake's panels like the wing's; a ring holds what left at the border between two.
    fn wake(&self, j: usize, x: f64, y: f64) -> Complex {
        let panel = 1.0 / self.chordwise as f64;
        let mut start = self.vortex(self.chordwise);
        let (first, mut at_start) = (start, self.horseshoe(j, start, x, y));
        let mut sum = (0.0, 0.0);
        while start < WAKE {
            let length = (0.05 * (start - 1.5)).max(panel).min(0.1);
            let at_end = self.horseshoe(j, start + length, x, y);
            let phase = -self.omega * (start - first + 0.25 * panel + 0.75 * length);
            let ring = at_start - at_end;
            sum = (sum.0 + ring * phase.cos(), sum.1 + ring * phase.sin());
            (start, at_start) = (start + length, at_end);
        }
        sum
    }

    /// Ring strengths for unit upwash, chordwise within each strip.
    fn solve(&self) -> Result<Vec<Complex>, Error> {
        let (nc, ns) = (self.chordwise, self.stations.len());
        let n = nc * ns;
        let (mut m, mut rhs) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n]);
        for (row, value) in rhs.iter_mut().enumerate().take(n) {
            let (y, x) = (self.stations[row / nc], self.vortex(row % nc) + 0.5 / nc as f64);
            *value = -1.0;
            for j in 0..ns {
                for i in 0..nc {
                    let ring =
                        self.horseshoe(j, self.vortex(i), x, y) - self.horseshoe(j, self.vortex(i + 1), x, y);
                    let tail = if i + 1 == nc { self.wake(j, x, y) } else { (0.0, 0.0) };
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
        lu_solve(&m, 2 * n, &pivots, &mut rhs, 1);
        Ok((0..n).map(|i| (rhs[i], rhs[n + i])).collect())
    }
}

/// Loading of a rectangular wing of aspect ratio `aspect` that plunges at the reduced
/// frequency `k`, on `chordwise` x `spanwise` panels.
///
/// # Errors
/// [`Error::NoAnswer`] when the lattice is singular.
pub fn loading(aspect: f64, k: f64, chordwise: usize, spanwise: usize) -> Result<Loading, Error> {
    let lattice = Lattice::new(aspect, chordwise, spanwise, 2.0 * k);
    let rings = lattice.solve()?;
    let strips = rings.chunks_exact(chordwise);
    let panel = lattice.omega / chordwise as f64;
    // Force 2 [Gamma + i omega sum(G dx)]: Kutta-Joukowski of the bound vortices and the rate of the jump.
    let force = |strip: &[Complex]| {
        let sum = strip.iter().fold((0.0, 0.0), |s, g| (s.0 + g.0, s.1 + g.1));
        let end = strip[chordwise - 1];
        (2.0 * (end.0 - panel * sum.1), 2.0 * (end.1 + panel * sum.0))
    };
    Ok(Loading {
        circulation: strips.clone().map(|strip| strip[chordwise - 1]).collect(),
        force: strips.map(force).collect(),
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
    let lattice = Lattice::new(aspect, chordwise, spanwise, 0.0);
    let rings = lattice.solve()?;
    let upwash = |y: f64| -> f64 {
        let vortices = rings.iter().enumerate().map(|(column, ring)| {
            let (j, i) = (column / chordwise, column % chordwise);
            // A ring of the last row is open: its wake is a horseshoe.
            let next = lattice.vortex(i + 1);
            let rear = if i + 1 == chordwise { 0.0 } else { lattice.horseshoe(j, next, behind, y) };
            ring.0 * (lattice.horseshoe(j, lattice.vortex(i), behind, y) - rear)
        });
        vortices.sum()
    };
    Ok(lattice.stations.iter().map(|&y| (y, -upwash(y))).collect())
}

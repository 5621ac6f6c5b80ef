//! Panels and vortex rings of a surface at one instant.

use crate::kernel::VortexGrid;
use crate::motion::LatticeSurface;
use crate::settings::OVER;
use std::f64::consts::PI;
use wingbeat::aero::{ChordBend, SectionMotion};
use wingbeat::math::{Dual, Vec3};

/// Place of a panel's bound vortex along its chord.
pub(crate) const VORTEX: f64 = 0.25;
/// Place of a panel's control point along its chord.
const CONTROL: f64 = 0.75;
/// Share of a step's way behind the trailing edge at which the last rings end where that way is a panel's chord: as their bound
/// vortices stand at 1/4 of a panel, the first vortex of the wake stands at 1/4 of its own.
const BEHIND: f64 = 0.25;

/// Euler's digamma function of `x` above 0, dimensionless: by its recurrence, and from 6 on by its asymptotic series.
fn digamma(mut x: f64) -> f64 {
    let mut sum = 0.0;
    while x < 6.0 {
        sum -= x.recip();
        x += 1.0;
    }
    let square = (x * x).recip();
    sum + x.ln() - 0.5 / x - square * (1.0 / 12.0 - square * (1.0 / 120.0 - square / 252.0))
}

/// Share of a step's way behind the trailing edge at which the last rings end, `ratio` that way over the chord of a panel,
/// dimensionless. Sheets of even strength on both sides of the last control point induce nothing there. Their vortices, a panel
/// or a step's way apart, do the same where psi(y) = psi(1/2) - ln(ratio), y the distance of the first of the wake over its way: sums of
/// 1/(y + n) are -psi(y) and a term that both share. Below a quarter they would end on the wing, and end at its edge.
///
/// Equation: lattice.first_vortex
/// `psi(y) = psi(1/2) - ln(ratio), share = y - 1/(4 ratio), at least 0`
/// Source: own derivation; 1/4 where the ratio is 1.
/// Test: `lift_in_plunge_is_that_of_theodorsen_with_the_default_core`.
fn behind(ratio: f64) -> f64 {
    if !(ratio > BEHIND) {
        return 0.0;
    }
    let right = digamma(0.5) - ratio.ln();
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if digamma(middle) < right { &mut low } else { &mut high }) = middle;
    }
    (low - BEHIND / ratio).max(0.0)
}

/// Share of the way from the leading edge to the row that left it a step ago at which the newest vortex of its sheet stands: that is a
/// quarter of a step behind the edge where rows leave it at an even pace. *Choice.*
const AHEAD: f64 = 0.2;

/// A vortex or a leg of one: where a force acts on it.
#[derive(Clone, Copy, Debug)]
pub struct VortexElement {
    /// Its middle, m.
    pub at: Vec3,
    /// Velocity of its middle, m/s.
    pub velocity: Vec3,
    /// From its begin to its end, m.
    pub along: Vec3,
}

/// The trailing edge at an edge of the strips.
#[derive(Clone, Copy, Debug)]
pub struct Rear {
    /// Place, m.
    pub at: Vec3,
    /// A unit vector out over it, in the plane of the strips beside it.
    pub outward: Vec3,
}

impl Rear {
    /// Widest core, m, at `p` (m) by how far that lies over the wing, as where air comes in over the edge; 0 behind it.
    pub fn over(&self, p: Vec3) -> f64 {
        OVER * (self.at - p).dot(self.outward).max(0.0)
    }
}

/// A control point.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Place, m.
    pub at: Vec3,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Unit normal of its panel, up.
    pub normal: Vec3,
    /// Area of its panel, m2.
    pub area: f64,
    /// Arc coordinate, m.
    pub arc: f64,
}

/// How a surface lies at an instant. Panels are numbered by row from the leading edge, in a row from left to right.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Panels along the chord.
    pub chordwise: usize,
    /// Strips.
    pub strips: usize,
    /// The strips' edges.
    pub edges: Vec<SectionMotion<f64>>,
    /// How their chord lines are bent, with the rates; none where they are straight.
    bends: Vec<ChordBend<Dual<1>>>,
    /// Vortex rings: a row of vertices per row of panels, the trailing edge, where the last rings bend, and their ends. With a
    /// peer's conventions the last rings are flat.
    pub bound: VortexGrid,
    /// The ends of the last rings, where the wake begins.
    pub trailing: VortexGrid,
    /// Control points.
    pub controls: Vec<Control>,
    /// Bound vortices, from left to right, by panel.
    pub fronts: Vec<VortexElement>,
    /// Legs of the rings on the wing, from front to rear, by row, one more than strips in each.
    pub legs: Vec<VortexElement>,
    /// Circulations that the last rings had a step ago, m2/s.
    pub shed: Vec<f64>,
    /// Where the leading edge sheds, vortex rings between the first bound vortices and the sheet that leaves it: vertices at these,
    /// at the leading edge, and at the sheet. Their share of the first bound vortices stands on [`bound`](Self::bound).
    pub nose: VortexGrid,
    /// Their ends, where the sheet begins.
    pub heads: VortexGrid,
    /// Jump of the potential across the sheet at the leading edge, which is all that has left it, by strip, m2/s.
    pub jumps: Vec<f64>,
    pub(crate) fractions: Vec<f64>,
    pub(crate) arcs: Vec<f64>,
    mean_chord: f64,
    core: f64,
    wake_core: f64,
    rounded: bool,
    sheds: bool,
}

/// What a point of a section is and does.
#[derive(Clone, Copy)]
struct MovingPoint {
    at: Vec3,
    velocity: Vec3,
}

/// The point at the share `x` of the chord of a section.
fn on_chord(section: &SectionMotion<f64>, x: f64) -> MovingPoint {
    let mix = |a: Vec3, b: Vec3| a + (b - a) * x;
    MovingPoint { at: mix(section.le, section.te), velocity: mix(section.v_le, section.v_te) }
}

/// The same of a section that is bent: p = p_le + a c + b n, n as long as the chord c and square to it and to the span, with the rates of a
/// and b and those of c and n, which turn with the section.
fn on_bend(section: &SectionMotion<f64>, bend: &ChordBend<Dual<1>>, x: f64) -> MovingPoint {
    let [a, b] = bend.at(Dual::constant(x));
    let (chord, turning) = (section.te - section.le, section.v_te - section.v_le);
    let up = chord.cross(section.span);
    let rate = section.w.cross(up) * b.re + chord * a.eps[0] + up * b.eps[0];
    MovingPoint { at: section.le + chord * a.re + up * b.re, velocity: section.v_le + turning * a.re + rate }
}

impl Mesh {
    /// The mesh of `surface`; bound vortices have cores of the radius `core` m, 0 for none, the wake begins with `wake_core` m. Where
    /// `rounded`, the cores of bound vortices depend on where they are felt; `sheds` says whether the leading edge does.
    pub fn new(surface: &LatticeSurface, core: f64, wake_core: f64, rounded: bool, sheds: bool) -> Self {
        let layout = &surface.layout;
        Self {
            chordwise: layout.chordwise,
            strips: layout.strips(),
            fractions: layout.fractions.clone(),
            arcs: layout.arcs.clone(),
            shed: vec![0.0; layout.strips()],
            core,
            wake_core,
            rounded,
            sheds,
            jumps: vec![0.0; if sheds { layout.strips() } else { 0 }],
            ..Self::default()
        }
    }

    /// Moves the mesh to where `surface` is at `t` s, in the wind `wind` m/s, `step` s before the next instant. With `chased`
    /// velocities are those that led from the edges before to these.
    pub fn update(&mut self, surface: &LatticeSurface, t: f64, wind: Vec3, step: f64, chased: bool) {
        let before = chased.then(|| std::mem::take(&mut self.edges));
        surface.sections.sections(t, &self.arcs, &mut self.edges);
        if let Some(before) = before {
            for (j, edge) in self.edges.iter_mut().enumerate() {
                let from = before.get(j).map_or((edge.le, edge.te), |before| (before.le, before.te));
                (edge.v_le, edge.v_te) =
                    ((edge.le - from.0) * step.recip(), (edge.te - from.1) * step.recip());
            }
        }
        surface.sections.bends(t, &self.arcs, &mut self.bends);
        let chords: f64 = self.edges.iter().map(|edge| (edge.te - edge.le).norm()).sum();
        self.mean_chord = chords / self.edges.len() as f64;
        self.place_rings(wind, step);
        self.place_controls();
        self.place_elements();
        if chased {
            self.reach_ends();
        }
    }

    /// The point at the share `x` of the chord of the edge `j`.
    fn at(&self, j: usize, x: f64) -> MovingPoint {
        match self.bends.get(j) {
            Some(bend) => on_bend(&self.edges[j], bend, x),
            None => on_chord(&self.edges[j], x),
        }
    }

    /// The trailing edge of the edge `j`.
    fn tail(&self, j: usize) -> MovingPoint {
        match self.bends.is_empty() {
            true => {
                let SectionMotion { te, v_te, .. } = self.edges[j];
                MovingPoint { at: te, velocity: v_te }
            }
            false => self.at(j, 1.0),
        }
    }

    /// Whether the last edge lies in the plane of symmetry.
    pub(crate) fn reaches_middle(&self) -> bool {
        self.arcs.last() == Some(&0.0)
    }

    /// Mean chord, m.
    pub fn mean_chord(&self) -> f64 {
        self.mean_chord
    }

    /// The trailing edge by edge of the strips, from left to right.
    pub(crate) fn rear(&self) -> Vec<Rear> {
        let outward = |j: usize| self.over_edge(j, Vec3::ZERO).0;
        let of = |j: usize| {
            let beside = [j.saturating_sub(1), j.min(self.strips - 1)];
            Rear { at: self.tail(j).at, outward: (outward(beside[0]) + outward(beside[1])).unit() }
        };
        (0..=self.strips).map(of).collect()
    }

    /// Where [`controls`](Self::controls), [`fronts`](Self::fronts) and [`legs`](Self::legs) lie along the arc, m, one after another.
    pub(crate) fn places(&self) -> impl Iterator<Item = f64> {
        let along = self.arcs.windows(2).enumerate();
        let fronts = along.map(|(j, pair)| pair[0] + (pair[1] - pair[0]) * self.front_fraction(j));
        let fronts = (0..self.chordwise).flat_map(move |_| fronts.clone());
        let legs = (0..self.legs.len() / self.arcs.len()).flat_map(|_| self.arcs.iter().copied());
        self.controls.iter().map(|c| c.arc).chain(fronts).chain(legs)
    }

    /// Cosine of the angle between the wing and the way square to the trailing edge of strip `j` on which the air leaves it in the wind `wind`
    /// m/s, dimensionless; 0 where it comes in there or rests.
    pub(crate) fn leaving(&self, j: usize, wind: Vec3) -> f64 {
        let (outward, through) = self.over_edge(j, wind);
        let out = through.dot(outward);
        if out > 0.0 { out / out.hypot(through.dot(self.rear_normal(j))) } else { 0.0 }
    }

    /// Unit normal of the last panel of strip `j`.
    fn rear_normal(&self, j: usize) -> Vec3 {
        self.controls[self.panels() - self.strips + j].normal
    }

    /// A unit vector in the last panel of strip `j` out over its trailing edge, square to it, and twice the air's velocity there in the wind
    /// `wind`, m/s.
    fn over_edge(&self, j: usize, wind: Vec3) -> (Vec3, Vec3) {
        let (left, right) = (self.tail(j), self.tail(j + 1));
        // From left to right, with the normal up.
        let outward = (right.at - left.at).cross(self.rear_normal(j)).unit();
        (outward, wind * 2.0 - left.velocity - right.velocity)
    }

    /// Number of panels.
    pub fn panels(&self) -> usize {
        self.chordwise * self.strips
    }

    /// The corner between row `i` and strip `j` of panels, m.
    pub fn corner(&self, i: usize, j: usize) -> Vec3 {
        self.at(j, i as f64 / self.chordwise as f64).at
    }

    /// The middle of the panel of row `i` and strip `j`, m, and its velocity, m/s.
    pub(crate) fn middle(&self, i: usize, j: usize) -> (Vec3, Vec3) {
        let x = (i as f64 + 0.5) / self.chordwise as f64;
        let [left, right] = [j, j + 1].map(|j| self.at(j, x));
        ((left.at + right.at) * 0.5, (left.velocity + right.velocity) * 0.5)
    }

    /// How places at the share `x` of the chord of the edge `side` go with both heights of its bend and with the angle, m, up being that of the
    /// strip `j` beside it; nowhere where it is straight.
    pub(crate) fn raised(&self, j: usize, side: usize, x: f64) -> [Vec3; 3] {
        let Some(bend) = self.bends.get(side) else { return [Vec3::ZERO; 3] };
        let [camber, forward] = [0, 1].map(|k| Dual::<3>::variable(bend.heights[k].re, k));
        let angle = Dual::variable(bend.angle.re, 2);
        let bend = ChordBend { heights: [camber, forward], angle, hinge: bend.hinge };
        let [a, b] = bend.at(Dual::constant(x));
        let chord = self.edges[side].te - self.edges[side].le;
        let [left, right] = [j, j + 1].map(|j| self.edges[j].le + self.edges[j].te);
        let up = chord.cross(right - left).unit() * chord.norm();
        std::array::from_fn(|k| chord * a.eps[k] + up * b.eps[k])
    }

    /// Places (m) and velocities (m/s) in the middle of the strip `j` at the share `x` of its chord: as it is bent, and on the straight
    /// chord.
    pub(crate) fn moved(&self, j: usize, x: f64) -> [[Vec3; 2]; 2] {
        let middle = |[a, b]: [MovingPoint; 2]| [(a.at + b.at) * 0.5, (a.velocity + b.velocity) * 0.5];
        [middle([j, j + 1].map(|j| self.at(j, x))), middle([j, j + 1].map(|j| on_chord(&self.edges[j], x)))]
    }

    /// Whether chord lines are bent.
    pub(crate) fn is_bent(&self) -> bool {
        !self.bends.is_empty()
    }

    fn place_rings(&mut self, wind: Vec3, step: f64) {
        let (m, count) = (self.chordwise as f64, self.edges.len());
        let [mut front, mut ends] = [&mut self.bound, &mut self.trailing].map(|grid| {
            grid.columns = count;
            std::mem::take(&mut grid.points)
        });
        front.clear();
        ends.clear();
        for i in 0..self.chordwise {
            front.extend((0..count).map(|j| self.at(j, (i as f64 + VORTEX) / m).at));
        }
        let tails = || (0..count).map(|j| self.tail(j));
        if self.core == 0.0 {
            front.extend(tails().map(|tail| tail.at));
        }
        ends.extend(tails().zip(&self.edges).map(|(tail, edge)| {
            let way = (wind - tail.velocity) * step;
            let share = match self.core == 0.0 {
                true => behind(way.norm() * m / (edge.te - edge.le).norm()),
                false => BEHIND,
            };
            tail.at + way * share
        }));
        front.extend_from_slice(&ends);
        let bound = &mut self.bound;
        (bound.points, self.trailing.points) = (front, ends);
        let square = if self.rounded { 1.0 } else { self.core * self.core };
        bound.arcs.clone_from(&self.arcs);
        bound.soften(|_, _| square, |_, _| square);
        self.soften_ends(self.wake_core, &[]);
    }

    /// Gives the ends of the last rings cores of the radius `core` m, and over the wing, whose edge is `rear`, at most those of
    /// `Rear::over`; none behind it.
    pub fn soften_ends(&mut self, core: f64, rear: &[Rear]) {
        let most: Vec<f64> = rear.iter().zip(&self.trailing.points).map(|(rear, p)| rear.over(*p)).collect();
        let radius = |j: usize| most.iter().skip(j).take(2).fold(core, |least, most| least.min(*most));
        self.trailing.soften(|_, j| radius(j).powi(2), |_, _| 0.0);
    }

    /// Lays the rings of the nose, whose ends are at first above or below the leading edge, where the air leaves it, and then the share
    /// `AHEAD` of the way to the row `last` that left it a step ago; they have cores of `core` m.
    pub fn place_nose(&mut self, last: Option<&[Vec3]>, core: f64, wind: Vec3, step: f64) {
        let edges = &self.edges;
        let (controls, strips) = (&self.controls, self.strips);
        let first = |j: usize| {
            let through = wind - edges[j].v_le;
            let beside = [j.saturating_sub(1), j.min(strips - 1)].map(|j| controls[j].normal);
            let normal = (beside[0] + beside[1]).unit();
            normal * (BEHIND * step * through.norm().copysign(through.dot(normal)))
        };
        let ends = |(j, edge): (usize, &SectionMotion<f64>)| {
            edge.le + last.map_or_else(|| first(j), |last| (last[j] - edge.le) * AHEAD)
        };
        let (nose, heads) = (&mut self.nose, &mut self.heads);
        heads.columns = edges.len();
        heads.points.clear();
        heads.points.extend(edges.iter().enumerate().map(ends));
        nose.columns = edges.len();
        nose.points.clear();
        nose.points.extend_from_slice(&self.bound.points[..edges.len()]);
        nose.points.extend(edges.iter().map(|edge| edge.le));
        nose.points.extend_from_slice(&heads.points);
        nose.arcs.clone_from(&self.arcs);
        nose.soften(|_, _| 1.0, |_, _| 1.0);
        heads.soften(|_, _| core * core, |_, _| 0.0);
    }

    /// The suction parameter A0 of strip `j` times the speed V of the undisturbed air square to the edge: its shares per circulation of the
    /// first bound vortex and of all bound vortices, 1/m. On a thin aerofoil (Glauert 1926) the vorticity is
    /// 2 V (A0 cot(t/2) + A1 sin t + ...), and that of all is pi c V (A0 + A1/2).
    /// On m even panels with vortices at 1/4 the first has 2 sqrt(pi) V dx r (A0 + A1/(2 m)), r = G(m + 1/2)/G(m) with Euler's function,
    /// exactly where the wash is a straight line along the chord (of A0 by the inverse of Cauchy's matrix; of A1 found on 4, 8 and 16
    /// panels); for many panels r is sqrt(m) (1 - 1/(8 m)).
    ///
    /// Equation: lattice.edge_suction
    /// `G_0 = 2 sqrt(pi) V dx r (A0 + A1/(2 m)), r = G(m + 1/2)/G(m) with Euler's function, of m panels; sum of G = pi c V (A0 + A1/2)`
    /// Source: Glauert 1926; first vortex on m even panels: own derivation.
    /// Test: `first_vortices_have_the_suction_of_thin_aerofoils`.
    pub fn edge_velocity_per_circulation(&self, j: usize) -> [f64; 2] {
        let (m, width) = (self.chordwise as f64, self.edge_panel_length(j));
        let ratio = (1..self.chordwise).fold(0.5 * PI.sqrt(), |r, m| r * (m as f64 + 0.5) / m as f64);
        let [first, all] = [2.0 * PI.sqrt() * width * ratio, PI * width * m];
        match self.chordwise {
            1 => [first.recip(), 0.0],
            _ => [m / (first * (m - 1.0)), -1.0 / (all * (m - 1.0))],
        }
    }

    /// Length of the first panel of strip `j` square to the leading edge, m.
    pub fn edge_panel_length(&self, j: usize) -> f64 {
        self.controls[j].area / (self.edges[j + 1].le - self.edges[j].le).norm()
    }

    /// The suction parameter A0 of strip `j` in the wind `wind` (m/s): its shares per circulation of the first bound vortex and of all bound
    /// vortices, s/m2; zero where the leading edge does not move through the air.
    pub fn suction_per_circulation(&self, j: usize, wind: Vec3) -> [f64; 2] {
        let (left, right) = (&self.edges[j], &self.edges[j + 1]);
        let edge = right.le - left.le;
        let through = wind - (left.v_le + (right.v_le - left.v_le) * self.fractions[j]);
        let speed = through.cross(edge).norm() / edge.norm();
        if speed > 0.0 { self.edge_velocity_per_circulation(j).map(|share| share / speed) } else { [0.0; 2] }
    }

    fn place_controls(&mut self) {
        let m = self.chordwise as f64;
        self.controls.clear();
        for i in 0..self.chordwise {
            for (j, fraction) in self.fractions.iter().enumerate() {
                let [left, right] = [j, j + 1].map(|j| self.at(j, (i as f64 + CONTROL) / m));
                let forward = self.corner(i + 1, j) - self.corner(i, j + 1);
                let back = self.corner(i + 1, j + 1) - self.corner(i, j);
                let twice = forward.cross(back);
                self.controls.push(Control {
                    at: left.at + (right.at - left.at) * *fraction,
                    velocity: left.velocity + (right.velocity - left.velocity) * *fraction,
                    normal: match self.bends.is_empty() {
                        true => twice.unit(),
                        false => self.tilted((i, j), right.at - left.at),
                    },
                    area: 0.5 * twice.norm(),
                    arc: self.arcs[j] + (self.arcs[j + 1] - self.arcs[j]) * *fraction,
                });
            }
        }
    }

    /// The normal of the panel of row `i` and strip `j`: that of the straight panel, tilted as the bent chord lines are around its control
    /// point, between the shares of the chord half a panel before and behind it; `across` leads from left to right there on the bent wing, so
    /// that a bend which grows along the span tilts it too. At the point itself the hinge of a flap would count a quarter of a panel too late.
    ///
    /// Equation: lattice.bent_normal
    /// `n = n_straight + unit(s x l) - unit(c x l_0), s along the bent chord lines, c along the straight ones, l across between the bent ones, l_0 between the straight ones`
    /// Source: thin-aerofoil theory: the slope of the camber line in the wash (Katz & Plotkin 2001, section 5.4); its mean a choice.
    /// Test: `bent_panels_lift_as_thin_aerofoil_theory_says`.
    fn tilted(&self, (i, j): (usize, usize), across: Vec3) -> Vec3 {
        let m = self.chordwise as f64;
        let corner = |i: usize, j: usize| on_chord(&self.edges[j], i as f64 / m).at;
        let forward = corner(i + 1, j) - corner(i, j + 1);
        let straight = forward.cross(corner(i + 1, j + 1) - corner(i, j)).unit();
        let [from, to] = [-0.5, 0.5].map(|share| (i as f64 + CONTROL + share) / m);
        let [left, right] = [j, j + 1].map(|j| on_chord(&self.edges[j], (i as f64 + CONTROL) / m).at);
        let (mut bent, mut flat) = (Vec3::ZERO, Vec3::ZERO);
        for (j, share) in [(j, 1.0 - self.fractions[j]), (j + 1, self.fractions[j])] {
            let (section, bend) = (&self.edges[j], &self.bends[j]);
            let (chord, ends) = (section.te - section.le, [from, to].map(|x| bend.at(Dual::constant(x))));
            let [along, above] = [0, 1].map(|k| ends[1][k].re - ends[0][k].re);
            bent += (chord * along + chord.cross(section.span) * above) * share;
            flat += chord * ((to - from) * share);
        }
        let tilt = bent.cross(across).unit() - flat.cross(right - left).unit();
        if tilt.norm() == 0.0 { straight } else { (straight + tilt).unit() }
    }

    /// Where between the edges of strip `j` the air of its bound vortices is taken: where Lan's sums over strips are exact, as at its
    /// control points; vortices with cores, as another program has them, in the middle.
    pub(crate) fn front_fraction(&self, j: usize) -> f64 {
        if self.core == 0.0 { self.fractions[j] } else { 0.5 }
    }

    fn place_elements(&mut self) {
        let m = self.chordwise as f64;
        let element = |a: MovingPoint, b: MovingPoint, fraction: f64| VortexElement {
            at: a.at + (b.at - a.at) * fraction,
            velocity: a.velocity + (b.velocity - a.velocity) * fraction,
            along: b.at - a.at,
        };
        let fractions: Vec<f64> = (0..self.strips).map(|j| self.front_fraction(j)).collect();
        let [mut fronts, mut legs] = [&mut self.fronts, &mut self.legs].map(std::mem::take);
        fronts.clear();
        legs.clear();
        let count = self.edges.len();
        for i in 0..self.chordwise {
            let x = (i as f64 + VORTEX) / m;
            let end = (x + 1.0 / m).min(1.0);
            let front = |(j, f): (usize, &f64)| element(self.at(j, x), self.at(j + 1, x), *f);
            fronts.extend(fractions.iter().enumerate().map(front));
            legs.extend((0..count).map(|j| element(self.at(j, x), self.at(j, end), 0.5)));
        }
        if self.sheds {
            legs.extend((0..count).map(|j| element(self.at(j, 0.0), self.at(j, VORTEX / m), 0.5)));
        }
        (self.fronts, self.legs) = (fronts, legs);
    }

    /// Lets the last legs reach to the ends of their rings, with what is behind the trailing edge.
    fn reach_ends(&mut self) {
        let row = self.legs.len() - self.trailing.points.len();
        for (j, end) in self.trailing.points.iter().enumerate() {
            let (leg, from) = (&mut self.legs[row + j], self.bound.points[row + j]);
            (leg.at, leg.along) = ((from + *end) * 0.5, *end - from);
        }
    }

    /// The ends of the last rings, from left to right, as they move with the trailing edge.
    pub fn ends(&self) -> impl Iterator<Item = VortexElement> {
        self.trailing.points.windows(2).enumerate().map(|(j, ends)| VortexElement {
            at: (ends[0] + ends[1]) * 0.5,
            velocity: (self.tail(j).velocity + self.tail(j + 1).velocity) * 0.5,
            along: ends[1] - ends[0],
        })
    }

    /// Puts the circulations of the rings, by panel, m2/s, on the segments: on the bound grid without the ends of the last rings,
    /// and on these.
    ///
    /// Equation: lattice.rings
    /// `front G_ij - G_i-1,j; legs G_i,j-1 - G_ij`
    /// Source: Katz & Plotkin 2001, section 12.3.
    /// Test: `rectangles_have_the_slope_of_the_lifting_surface`.
    pub fn set_circulations(&mut self, rings: &[f64]) {
        let (m, n) = (self.chordwise, self.strips);
        let ring = |i: usize, j: usize| rings[i * n + j];
        let (bound, trailing) = (&mut self.bound, &mut self.trailing);
        bound.across.clear();
        bound.along.clear();
        for i in 0..m {
            bound.across.extend((0..n).map(|j| ring(i, j) - if i > 0 { ring(i - 1, j) } else { 0.0 }));
        }
        let rows = bound.rows();
        bound.across.resize(rows * n, 0.0);
        for i in (0..rows - 1).map(|row| row.min(m - 1)) {
            bound.along.extend((0..=n).map(|j| {
                let [left, right] = [j.checked_sub(1), (j < n).then_some(j)];
                left.map_or(0.0, |j| ring(i, j)) - right.map_or(0.0, |j| ring(i, j))
            }));
        }
        trailing.along.clear();
        trailing.across.clear();
        trailing.across.extend((0..n).map(|j| -ring(m - 1, j)));
        if self.sheds {
            self.set_jumps();
        }
    }

    /// Puts the jumps at the leading edge on the first bound vortices and on the rings of the nose.
    fn set_jumps(&mut self) {
        let (n, jumps) = (self.strips, &self.jumps);
        self.bound.across[..n].iter_mut().zip(jumps).for_each(|(first, jump)| *first -= jump);
        let beside = |j: usize| if j < n { jumps[j] } else { 0.0 };
        let leg = |j: usize| beside(j) - if j > 0 { jumps[j - 1] } else { 0.0 };
        let (nose, heads) = (&mut self.nose, &mut self.heads);
        nose.across.clear();
        nose.across.resize(nose.rows() * n, 0.0);
        nose.along.clear();
        nose.along.extend((1..nose.rows()).flat_map(|_| (0..=n).map(leg)));
        heads.along.clear();
        heads.across.clone_from(jumps);
    }
}

/// Widths of trailing edges over which the air comes in, and of all, summed over steps, m.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EdgeInflow([f64; 2]);

impl EdgeInflow {
    /// Adds those of `meshes` in the wind `wind` m/s.
    pub(crate) fn add(&mut self, meshes: &[Mesh], wind: Vec3) {
        for mesh in meshes {
            for (j, arcs) in mesh.arcs.windows(2).enumerate() {
                let (outward, through) = mesh.over_edge(j, wind);
                let width = (arcs[1] - arcs[0]).abs();
                self.0[0] += if through.dot(outward) < 0.0 { width } else { 0.0 };
                self.0[1] += width;
            }
        }
    }

    /// The share of the first, dimensionless.
    pub(crate) fn share(self) -> f64 {
        self.0[0] / self.0[1].max(f64::MIN_POSITIVE)
    }
}

impl VortexGrid {
    /// Sets the cores from the squared radii (m2) of the segments across and along, by row and column.
    pub fn soften(&mut self, across: impl Fn(usize, usize) -> f64, along: impl Fn(usize, usize) -> f64) {
        let n = self.columns;
        self.core_across.clear();
        self.core_along.clear();
        for (r, row) in self.points.chunks_exact(n).enumerate() {
            let pairs = row.windows(2).enumerate();
            self.core_across.extend(pairs.map(|(j, pair)| across(r, j) * (pair[1] - pair[0]).norm_squared()));
            if let Some(next) = self.points.get((r + 1) * n..(r + 2) * n) {
                let pairs = row.iter().zip(next).enumerate();
                self.core_along.extend(pairs.map(|(j, (a, b))| along(r, j) * (*b - *a).norm_squared()));
            }
        }
    }
}

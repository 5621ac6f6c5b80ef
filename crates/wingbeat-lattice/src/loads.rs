//! Forces on the panels, by Joukowski and by Bernoulli.

use crate::influence::mirrored;
use crate::mesh::{Mesh, VORTEX, VortexElement};
use crate::motion::Scene;
use std::f64::consts::PI;
use wingbeat::math::{Vec3, Wrench};

/// What the loads need of the air.
pub struct SurfaceAir<'a> {
    /// Velocities at the control points, bound vortices and legs of every surface, and with other conventions at the ends of the
    /// last rings, m/s.
    pub velocities: &'a [Vec3],
    /// Rates of the rings' circulations, by surface and panel, m2/s2.
    pub rates: &'a [f64],
    /// Rates of the jumps at the leading edges that shed, by surface and strip, m2/s2.
    pub jump_rates: &'a [f64],
    /// Density, kg/m3.
    pub density: f64,
}

/// Forces on the panels of a surface, N, resolved in W.
#[derive(Clone, Debug, Default)]
pub struct PanelLoads {
    /// By Joukowski, with the suction of the leading edge, by panel, N in W.
    pub joukowski: Vec<Vec3>,
    /// By Bernoulli, along the panels' normals, by panel, N in W.
    pub bernoulli: Vec<Vec3>,
    /// Suction of the leading edge that Bernoulli lacks, by strip, N in W.
    pub suction: Vec<Vec3>,
    /// Force and moment about W's origin by Joukowski, by strip, N and N m.
    pub strips: Vec<Wrench<f64>>,
    /// Virtual work of Bernoulli's forces by edge of the strips, per unit of both heights of its bend over the chord and of its angle,
    /// N m; nothing where chord lines are straight.
    pub bends: Vec<[f64; 3]>,
}

/// Loads of an instant, resolved in W, about W's origin, the mirror image of a half included.
#[derive(Clone, Debug, Default)]
pub struct LatticeLoads {
    /// Time, s.
    pub time: f64,
    /// By surface.
    pub panels: Vec<PanelLoads>,
    /// Sum by Joukowski, N and N m.
    pub joukowski: Wrench<f64>,
    /// Sum by Bernoulli with the suction of the leading edge, N and N m.
    pub bernoulli: Wrench<f64>,
    /// Share of the suction in that.
    pub suction: Wrench<f64>,
    /// Power that the wings take from the air by Joukowski, W.
    pub power: f64,
}

/// A surface with what acts on it.
struct LoadedSurface<'a> {
    mesh: &'a Mesh,
    rings: &'a [f64],
    rates: &'a [f64],
    /// Rates of the jumps at the leading edge, where it sheds.
    jump_rates: &'a [f64],
    /// Velocities of the air relative to the wing at control points, bound vortices, legs, and the ends of the last rings.
    controls: Vec<Vec3>,
    fronts: Vec<Vec3>,
    legs: Vec<Vec3>,
    ends: Vec<Vec3>,
    /// Cosines of [`Mesh::leaving`].
    leaving: Vec<f64>,
    density: f64,
    emulates: bool,
    /// Whether the last legs lie between the wing and its mirror image, whose legs undo them.
    undone: bool,
}

impl LatticeLoads {
    /// The loads of all surfaces with the circulations `rings`.
    pub(crate) fn new(
        time: f64,
        meshes: &[Mesh],
        mut rings: &[f64],
        air: &SurfaceAir<'_>,
        scene: &Scene,
        emulates: bool,
    ) -> Self {
        let mut loads = Self { time, ..Self::default() };
        let (mut velocities, mut rates, mut jump_rates) = (air.velocities, air.rates, air.jump_rates);
        let mut sums = [Wrench::ZERO; 3];
        let mut power = 0.0;
        for mesh in meshes {
            let (own_rings, own_rates) = (take(&mut rings, mesh.panels()), take(&mut rates, mesh.panels()));
            let relative = |at: &[Vec3], own: &mut dyn Iterator<Item = Vec3>| -> Vec<Vec3> {
                at.iter().zip(own).map(|(air, own)| *air - own).collect()
            };
            let mut next = |count: usize| take(&mut velocities, count);
            let loaded = LoadedSurface {
                mesh,
                rings: own_rings,
                rates: own_rates,
                jump_rates: take(&mut jump_rates, mesh.jumps.len()),
                controls: relative(next(mesh.panels()), &mut mesh.controls.iter().map(|c| c.velocity)),
                fronts: relative(next(mesh.fronts.len()), &mut mesh.fronts.iter().map(|e| e.velocity)),
                legs: relative(next(mesh.legs.len()), &mut mesh.legs.iter().map(|e| e.velocity)),
                ends: if emulates {
                    relative(next(mesh.strips), &mut mesh.ends().map(|e| e.velocity))
                } else {
                    Vec::new()
                },
                leaving: (0..mesh.strips).map(|j| mesh.leaving(j, scene.wind)).collect(),
                density: air.density,
                emulates,
                undone: scene.symmetric && mesh.reaches_middle(),
            };
            loads.panels.push(loaded.panels(&mut sums, &mut power));
        }
        if scene.symmetric {
            sums = sums.map(with_image);
            power *= 2.0;
        }
        loads.power = power;
        [loads.joukowski, loads.bernoulli, loads.suction] = sums;
        loads
    }

    /// Whether every force is finite.
    pub fn is_finite(&self) -> bool {
        [self.joukowski, self.bernoulli].iter().all(|w| w.force.is_finite() && w.moment.is_finite())
    }
}

/// The first `count` of a slice, which keeps the rest.
fn take<'a, T>(slice: &mut &'a [T], count: usize) -> &'a [T] {
    let (own, rest) = slice.split_at(count);
    *slice = rest;
    own
}

/// A wrench with that of its mirror image at the plane y = 0, whose moments about x and z turn the other way.
fn with_image(w: Wrench<f64>) -> Wrench<f64> {
    Wrench { force: w.force + mirrored(w.force), moment: w.moment - mirrored(w.moment) }
}

impl LoadedSurface<'_> {
    fn ring(&self, i: usize, j: usize) -> f64 {
        self.rings[i * self.mesh.strips + j]
    }

    /// The jump before the bound vortex of a panel: of the ring before it, at the leading edge of what has left it.
    fn before(&self, i: usize, j: usize) -> f64 {
        if i > 0 { self.ring(i - 1, j) } else { self.mesh.jumps.get(j).copied().unwrap_or(0.0) }
    }

    /// Circulation of the bound vortex of a panel.
    fn front(&self, i: usize, j: usize) -> f64 {
        self.ring(i, j) - self.before(i, j)
    }

    /// Circulation of the leg `j` between two columns of `rings`, from front to rear.
    fn leg_of(&self, j: usize, rings: impl Fn(usize) -> f64) -> f64 {
        let n = self.mesh.strips;
        if self.undone && j == n {
            return 0.0;
        }
        let left = if j > 0 { rings(j - 1) } else { 0.0 };
        left - if j < n { rings(j) } else { 0.0 }
    }

    /// Circulation of the leg `j` of the ring row `i`, from front to rear.
    fn leg(&self, i: usize, j: usize) -> f64 {
        self.leg_of(j, |j| self.ring(i, j))
    }

    /// The same of what lies before the bound vortices of the row `i`.
    fn leg_before(&self, i: usize, j: usize) -> f64 {
        self.leg_of(j, |j| self.before(i, j))
    }

    /// Share of a leg's force that the panel on one side of it bears.
    fn share(&self, j: usize) -> f64 {
        if j == 0 || j == self.mesh.strips { 1.0 } else { 0.5 }
    }

    /// Adds the forces to `sums`: Joukowski, Bernoulli with suction, suction; to `power` that of the first.
    fn panels(&self, sums: &mut [Wrench<f64>; 3], power: &mut f64) -> PanelLoads {
        let (m, n) = (self.mesh.chordwise, self.mesh.strips);
        let mut panels = PanelLoads { strips: vec![Wrench::ZERO; n], ..PanelLoads::default() };
        for i in 0..m {
            for j in 0..n {
                let (joukowski, taken) = self.joukowski(i, j);
                *power += taken;
                let bernoulli = self.bernoulli(i, j);
                panels.joukowski.push(joukowski.force);
                panels.bernoulli.push(bernoulli.force);
                panels.strips[j] += joukowski;
                sums[0] += joukowski;
                sums[1] += bernoulli;
            }
        }
        for j in 0..n {
            let suction = self.suction(j);
            panels.suction.push(suction.force);
            sums[1] += suction;
            sums[2] += suction;
        }
        if self.mesh.is_bent() {
            panels.bends = self.work_on_bends();
        }
        panels
    }

    /// Force of the air of the relative velocity `v` on a vortex: rho Gamma v x l.
    fn on_vortex(&self, element: &VortexElement, v: Vec3, circulation: f64) -> Wrench<f64> {
        Wrench::at(element.at, v.cross(element.along) * (self.density * circulation))
    }

    /// Force of the growing jump of potential, rho A d(phi)/dt n at the middle of the panel. The jump on a panel is that of the ring
    /// before it up to its bound vortex, and of its own ring behind. Bound vortices stand for the sheet up to half a panel behind them,
    /// the last ones up to the last control point; on the quarter of a panel behind that stands the sheet that is being shed, of the strength
    /// -dG/dt/V where the air leaves at the speed V, and bears V cos e of it, e the angle between its way and the wing.
    ///
    /// Equation: lattice.unsteady_force
    /// `rho A n d/dt(3/4 G_i + 1/4 G_i-1), (3 - cos e)/4 in the place of 3/4 in the last row`
    /// Source: Katz & Plotkin 2001, section 13.12; shares own: the ring before reaches to the bound vortex, and Kutta's condition at the edge.
    /// Test: `a_long_wing_starts_as_wagner_says`.
    fn grown(&self, i: usize, j: usize) -> (Vec3, Vec3) {
        let n = self.mesh.strips;
        let at_edge = || self.jump_rates.get(j).copied().unwrap_or(0.0);
        let before = if i > 0 { self.rates[(i - 1) * n + j] } else { at_edge() };
        let own = self.rates[i * n + j];
        let share = if i + 1 == self.mesh.chordwise { 0.75 - 0.25 * self.leaving[j] } else { 0.75 };
        let rate = if self.emulates { own } else { share * own + 0.25 * before };
        let control = &self.mesh.controls[i * n + j];
        let (middle, _) = self.mesh.middle(i, j);
        (middle, control.normal * (self.density * rate * control.area))
    }

    fn growth(&self, i: usize, j: usize) -> Wrench<f64> {
        let (middle, force) = self.grown(i, j);
        Wrench::at(middle, force)
    }

    /// Force on a panel by Joukowski: on its bound vortex, on its share of the legs beside it, and of the growth of its rings; the power
    /// of these at the places where they act.
    ///
    /// Equation: lattice.joukowski
    /// `rho G v x l on bound vortices and legs, and the unsteady force`
    /// Source: Joukowski 1906; Saffman 1992, section 3.1.
    /// Test: `both_ways_to_the_force_agree`.
    fn joukowski(&self, i: usize, j: usize) -> (Wrench<f64>, f64) {
        let n = self.mesh.strips;
        let at = i * n + j;
        let front = &self.mesh.fronts[at];
        let mut sum = self.on_vortex(front, self.fronts[at], self.front(i, j));
        let growth = self.growth(i, j);
        let mut power = sum.force.dot(front.velocity) + growth.force.dot(self.mesh.middle(i, j).1);
        for side in [j, j + 1] {
            let mut bear = |row: usize, circulation: f64| {
                let leg = row * (n + 1) + side;
                let element = &self.mesh.legs[leg];
                let load = self.on_vortex(element, self.legs[leg], self.share(side) * circulation);
                power += load.force.dot(element.velocity);
                sum += load;
            };
            bear(i, self.leg(i, side));
            // The legs of the nose come after the others.
            if i == 0 && !self.mesh.jumps.is_empty() {
                bear(self.mesh.chordwise, self.leg_before(0, side));
            }
        }
        if self.emulates && i + 1 == self.mesh.chordwise {
            let change = self.mesh.trailing.across[j] + self.mesh.shed[j];
            if let Some(end) = self.mesh.ends().nth(j) {
                let load = self.on_vortex(&end, self.ends[j], change);
                power += load.force.dot(end.velocity);
                sum += load;
            }
        }
        (sum + growth, power)
    }

    /// Force on a panel by Bernoulli: rho [(v x g).n + d(phi)/dt] A n, g A the sum of circulation times length of the vortices on
    /// it and v the relative velocity at its control point; the jump of pressure acts along the normal.
    ///
    /// Equation: lattice.bernoulli
    /// `rho [(v x sum G l).n + A d(phi)/dt] n, v at the control point`
    /// Source: unsteady Bernoulli; Katz & Plotkin 2001, section 13.12.
    /// Test: `both_ways_to_the_force_agree`.
    fn bernoulli(&self, i: usize, j: usize) -> Wrench<f64> {
        let mut sum = Wrench::ZERO;
        self.pressed(i, j, |place, force, _, _| sum += Wrench::at(place, force));
        sum
    }

    /// Shows `bear` the parts of the force on a panel by Bernoulli: where each acts (m), the force (N), the share of the chord at which that is,
    /// and the shares of both edges of the strip in the place.
    fn pressed(&self, i: usize, j: usize, mut bear: impl FnMut(Vec3, Vec3, f64, [f64; 2])) {
        let n = self.mesh.strips;
        let at = i * n + j;
        let (control, v) = (&self.mesh.controls[at], self.controls[at]);
        let along = |circulation: f64, length: Vec3| {
            let normal = v.cross(length).dot(control.normal);
            control.normal * (self.density * circulation * normal)
        };
        let [vortex, middle] = [VORTEX, 0.5].map(|share| (i as f64 + share) / self.mesh.chordwise as f64);
        let (front, right) = (&self.mesh.fronts[at], self.mesh.front_fraction(j));
        bear(front.at, along(self.front(i, j), front.along), vortex, [1.0 - right, right]);
        for (side, shares) in [(j, [1.0, 0.0]), (j + 1, [0.0, 1.0])] {
            let [from, to] = [i, i + 1].map(|i| self.mesh.corner(i, side));
            let circulation = 0.75 * self.leg(i, side) + 0.25 * self.leg_before(i, side);
            bear((from + to) * 0.5, along(self.share(side) * circulation, to - from), middle, shares);
        }
        let (place, force) = self.grown(i, j);
        bear(place, force, middle, [0.5; 2]);
    }

    /// What the forces by Bernoulli do along the bends of the strips' edges; the suction of the leading edge does nothing there, which no bend
    /// moves.
    ///
    /// Equation: lattice.bent_work
    /// `Q_k = sum over panels F . dp/db_k, b both heights of aero.chord_bend over the chord and its angle`
    /// Source: virtual work of the pressure on the panels.
    /// Test: `pressure_bears_on_bends_as_thin_aerofoil_theory_says`.
    fn work_on_bends(&self) -> Vec<[f64; 3]> {
        let mut work = vec![[0.0; 3]; self.mesh.edges.len()];
        for (i, j) in (0..self.mesh.chordwise).flat_map(|i| (0..self.mesh.strips).map(move |j| (i, j))) {
            self.pressed(i, j, |_, force, x, shares| {
                for (side, share) in [j, j + 1].into_iter().zip(shares) {
                    let raised = self.mesh.raised(j, side, x);
                    (0..3).for_each(|k| work[side][k] += share * force.dot(raised[k]));
                }
            });
        }
        work
    }

    /// Suction of the leading edge of strip `j`, in its plane and square to the edge: vorticity that grows as C/sqrt(x) towards an
    /// edge pulls by pi rho C^2/4 per length (Garrick 1936), and C is 2 V A0 sqrt(c) of a thin aerofoil, whose V A0 the bound vortices tell
    /// by [`Mesh::edge_velocity_per_circulation`]. Of many panels that is rho G_0^2/(4 dx), of six 4 % more.
    ///
    /// Equation: lattice.suction
    /// `pi rho c (V A0)^2 per length of the edge, V A0 by lattice.edge_suction`
    /// Source: Garrick 1936, NACA Rep. 567.
    /// Test: `drag_of_pressure_and_suction_is_that_of_the_wake`.
    fn suction(&self, j: usize) -> Wrench<f64> {
        let mesh = self.mesh;
        let [left, right] = [j, j + 1].map(|j| mesh.edges[j].le);
        let edge = right - left;
        let forward = mesh.controls[j].normal.cross(edge);
        let chord = mesh.chordwise as f64 * mesh.edge_panel_length(j);
        let all = self.ring(mesh.chordwise - 1, j) - self.before(0, j);
        let [of_first, of_all] = mesh.edge_velocity_per_circulation(j);
        let strength = self.front(0, j) * of_first + all * of_all;
        let pull = PI * self.density * chord * strength.powi(2) * edge.norm();
        Wrench::at((left + right) * 0.5, forward * (pull / forward.norm()))
    }
}

//! The lattice stepped in time.

use crate::Error;
use crate::influence::{InducingGrids, Influence, Mirrors};
use crate::kernel::{Crossing, PointLocation};
use crate::loads::{LatticeLoads, SurfaceAir};
use crate::mesh::Mesh;
use crate::motion::Scene;
use crate::settings::{LatticeSettings, WakeMotion};
use crate::shedding::{RingFactors, Shedding};
use crate::spread;
use crate::wake::Wake;
use wingbeat::math::Vec3;
use wingbeat::math::linear::{lu_factor, lu_solve};

/// Surfaces with their wakes, stepped from rest.
pub struct Lattice {
    scene: Scene,
    settings: LatticeSettings,
    meshes: Vec<Mesh>,
    wakes: Vec<Wake>,
    influence: Influence,
    /// Circulations of the rings now and at the three instants before, by surface and panel, m2/s.
    rings: [Vec<f64>; 4],
    /// Instants solved.
    solved: usize,
    /// What leaves the leading edges, where they shed.
    shedding: Option<Shedding>,
    /// The wakes and sheets as they come to the instant that is being solved, while several motions are tried there.
    arriving: Option<[Vec<Wake>; 2]>,
    /// Points of the first of the trials of an instant, which choose the sums of all: those of the loads, and those beside sheets.
    first: [Vec<Vec3>; 2],
}

/// Most panels: their matrix has the square of it. *Choice.*
const MOST_PANELS: usize = 4000;

/// Refuses what cannot be stepped.
fn check(scene: &Scene) -> Result<(), Error> {
    let refused = |key, value, allowed: String| Err(Error::Setting { key, value, allowed });
    if let Some(value) = (0..3).map(|axis| scene.wind[axis]).find(|speed| !speed.is_finite()) {
        return refused("wind", value, "finite".into());
    }
    if let Some(height) = scene.ground {
        if !height.is_finite() {
            return refused("ground", height, "a finite height".into());
        }
        if scene.wind[2] != 0.0 {
            return refused("wind", scene.wind[2], "0 upward, where a ground is not crossed".into());
        }
    }
    let mut panels: usize = 0;
    for layout in scene.surfaces.iter().map(|surface| &surface.layout) {
        if layout.arcs.len() != layout.strips() + 1 {
            let allowed = format!("{}, one more than strips", layout.strips() + 1);
            return refused("layout.arcs", layout.arcs.len() as f64, allowed);
        }
        panels = panels.saturating_add(layout.chordwise.saturating_mul(layout.strips()));
    }
    match panels {
        0..=MOST_PANELS => Ok(()),
        _ => refused("panels", panels as f64, format!("at most {MOST_PANELS}")),
    }
}

impl Lattice {
    /// A lattice at rest in still air that meets its wind and motion at t = 0.
    ///
    /// # Errors
    /// Settings that are not allowed, a wind that is not finite, panels whose edges are not one more than strips, or more than
    /// 4000 of them.
    pub fn new(scene: Scene, settings: LatticeSettings) -> Result<Self, Error> {
        settings.check()?;
        check(&scene)?;
        let wake_core = settings.core.radius_m;
        let bound_core = if settings.emulates() { wake_core } else { 0.0 };
        let (crosses, sheds) = (settings.crossing > 0.0, settings.critical_suction.is_some());
        let mesh = |surface| Mesh::new(surface, bound_core, wake_core, crosses || sheds, sheds);
        let mut meshes: Vec<Mesh> = scene.surfaces.iter().map(mesh).collect();
        for (mesh, surface) in meshes.iter_mut().zip(&scene.surfaces) {
            mesh.update(surface, 0.0, scene.wind, settings.step_s, false);
            if wake_core > mesh.mean_chord() {
                let allowed = format!("above 0 and at most {:.6} m, the mean chord", mesh.mean_chord());
                return Err(Error::Setting { key: "core.radius_m", value: wake_core, allowed });
            }
        }
        let panels = meshes.iter().map(Mesh::panels).sum();
        let near = meshes.first().map_or(0.0, Mesh::mean_chord);
        let crossing = Crossing { share: settings.crossing, near, wake: wake_core };
        let (crossing, fast_from) = (crosses.then_some(crossing), settings.fast_from);
        let influence = Influence::new(Mirrors::of(&scene), settings.emulates(), crossing, fast_from);
        let wakes = meshes.iter().map(|_| Wake::default()).collect();
        let rings = std::array::from_fn(|_| vec![0.0; panels]);
        let shedding = settings.critical_suction.map(|critical| Shedding::new(critical, &meshes));
        Ok(Self {
            scene,
            settings,
            meshes,
            wakes,
            influence,
            rings,
            solved: 0,
            shedding,
            arriving: None,
            first: Default::default(),
        })
    }

    /// Solves the next instant, returns its loads and carries the wake on to the one after it.
    ///
    /// # Errors
    /// Circulations that are not determined, or numbers that are not finite.
    pub fn step(&mut self) -> Result<LatticeLoads, Error> {
        let t = self.time();
        self.leave(t)?;
        self.first = Default::default();
        let loads = self.arrive(t)?;
        self.solved += 1;
        Ok(loads)
    }

    /// Solves the next instant and stays there, so that it can be solved for another motion of the surfaces, until
    /// [`keep`](Self::keep).
    ///
    /// # Errors
    /// Circulations that are not determined, or numbers that are not finite.
    pub fn attempt(&mut self) -> Result<LatticeLoads, Error> {
        let t = self.time();
        match &self.arriving {
            Some([wakes, sheets]) => {
                self.wakes.clone_from(wakes);
                if let Some(shedding) = &mut self.shedding {
                    shedding.sheets.clone_from(sheets);
                }
            }
            None => {
                self.leave(t)?;
                self.first = Default::default();
                self.arriving = Some([self.wakes.clone(), self.sheets().to_vec()]);
            }
        }
        self.arrive(t)
    }

    /// Goes on from the last motion that [`attempt`](Self::attempt) solved.
    pub fn keep(&mut self) {
        self.solved += usize::from(self.arriving.take().is_some());
    }

    /// The instant to be solved next, s.
    fn time(&self) -> f64 {
        self.solved as f64 * self.settings.step_s
    }

    /// Velocity of the air from now on, m/s in W.
    pub fn set_wind(&mut self, wind: Vec3) {
        self.scene.wind = wind;
    }

    /// The loads of the instant `t` s, to which the wakes have come.
    fn arrive(&mut self, t: f64) -> Result<LatticeLoads, Error> {
        self.join(t)?;
        if !self.settings.emulates() {
            self.soften(true);
        }
        let (points, places) = self.places();
        let [first, beside] = &mut self.first;
        if first.is_empty() {
            first.clone_from(&points);
        }
        let (first, mut beside) = (std::mem::take(first), std::mem::take(beside));
        let mut air = self.influence.velocities_by(&points, &first, &places, &self.sources(false, true));
        air.iter_mut().for_each(|v| *v += self.scene.wind);
        self.solve(t, &air)?;
        let own = self.influence.velocities(&points, &places, &self.sources(true, false));
        air.iter_mut().zip(own).for_each(|(v, own)| *v += own);
        if !self.settings.emulates() {
            let mut at = 0;
            for (mesh, change) in self.meshes.iter().zip(spread::changes(&self.meshes, &self.influence)) {
                let first = at + mesh.panels();
                air[first..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
                at = first + mesh.fronts.len() + mesh.legs.len();
            }
        }
        if self.shedding.is_some() {
            let mut at = 0;
            let changes =
                spread::changes_by_sheets(&self.meshes, self.sheets(), &self.influence, &mut beside);
            for (mesh, change) in self.meshes.iter().zip(changes) {
                let first = at + mesh.panels() + mesh.fronts.len();
                air[first..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
                at = first + mesh.legs.len();
            }
        }
        self.first = [first, beside];
        let rates = self.rates(&self.rings);
        let jump_rates = self.shedding.as_ref().map_or_else(Vec::new, |own| self.rates(&own.jumps));
        let density = self.scene.density_kg_m3;
        let air = SurfaceAir { velocities: &air, rates: &rates, jump_rates: &jump_rates, density };
        let loads =
            LatticeLoads::new(t, &self.meshes, &self.rings[0], &air, &self.scene, self.settings.emulates());
        if !loads.is_finite() {
            return Err(Error::NotFinite { time: t, what: "load" });
        }
        self.soften(false);
        Ok(loads)
    }

    /// Gives the vortices of the wakes the cores that wings feel, or those that they have for each other.
    fn soften(&mut self, on_wings: bool) {
        let LatticeSettings { core, step_s, .. } = self.settings;
        for (wake, mesh) in self.wakes.iter_mut().zip(&mut self.meshes) {
            let rear = if on_wings { mesh.rear() } else { Vec::new() };
            wake.soften(&core, step_s, &rear);
            mesh.soften_ends(core.radius_m, &rear);
        }
    }

    /// The next instant with the circulations `rings` of another model, by surface and panel (m2/s), in place of those that keep the
    /// flow tangent: they are shed and carried as those are.
    ///
    /// # Errors
    /// As many circulations as there are panels are needed; numbers that are not finite.
    pub fn step_with(&mut self, rings: &[f64]) -> Result<(), Error> {
        let t = self.time();
        let panels = self.rings[0].len();
        if rings.len() != panels {
            let allowed = format!("{panels}, the number of panels");
            return Err(Error::Setting { key: "rings", value: rings.len() as f64, allowed });
        }
        if !rings.iter().all(|ring| ring.is_finite()) {
            return Err(Error::NotFinite { time: t, what: "circulation" });
        }
        self.leave(t)?;
        self.join(t)?;
        self.put(rings.to_vec());
        self.solved += 1;
        Ok(())
    }

    /// Puts the circulations on the rings of the surfaces.
    fn put(&mut self, rings: Vec<f64>) {
        let mut rest = &rings[..];
        for mesh in &mut self.meshes {
            let (own, others) = rest.split_at(mesh.panels());
            mesh.set_circulations(own);
            rest = others;
        }
        self.rings[0] = rings;
    }

    /// Brings the wakes to the instant `t` s.
    fn leave(&mut self, t: f64) -> Result<(), Error> {
        if self.solved > 0 {
            self.carry_wakes(t)?;
            self.rings.rotate_right(1);
            if let Some(shedding) = &mut self.shedding {
                shedding.jumps.rotate_right(1);
            }
        }
        Ok(())
    }

    /// Brings the surfaces to the instant `t` s and joins the wakes to them.
    fn join(&mut self, t: f64) -> Result<(), Error> {
        let (wind, step) = (self.scene.wind, self.settings.step_s);
        let mut first = 0;
        let chased = self.settings.emulates();
        for ((surface, mesh), wake) in self.scene.surfaces.iter().zip(&mut self.meshes).zip(&mut self.wakes) {
            mesh.update(surface, t, wind, step, chased);
            let (panels, strips) = (mesh.panels(), mesh.strips);
            let last = &self.rings[1][first + panels - strips..first + panels];
            if self.solved > 0 {
                mesh.shed.copy_from_slice(last);
            }
            wake.join(&mesh.trailing.points, (self.solved > 0).then_some(last));
            // A whole number of steps may come out just below it.
            let rows = self.settings.longest_age_s / step + 1e-9;
            wake.truncate(rows.min(1e9) as usize, self.settings.longest_distance_m);
            wake.set_segments();
            wake.soften(&self.settings.core, step, &[]);
            first += panels;
        }
        if let Some(Shedding { sheets, jumps, .. }) = &mut self.shedding {
            let mut shed = &jumps[1][..];
            for (mesh, sheet) in self.meshes.iter_mut().zip(sheets) {
                let (own, rest) = shed.split_at(mesh.strips);
                shed = rest;
                mesh.place_nose(sheet.last_row(), self.settings.sheet_core_m, wind, step);
                Shedding::join(sheet, mesh, (self.solved > 0).then_some(own));
                let rows = self.settings.longest_age_s / step + 1e-9;
                sheet.truncate(rows.min(1e9) as usize, self.settings.longest_distance_m);
                sheet.set_segments();
                sheet.soften(&self.settings.sheet_core(), step, &[]);
            }
        }
        let finite = |mesh: &Mesh| mesh.controls.iter().all(|c| (c.normal + c.at + c.velocity).is_finite());
        match self.meshes.iter().all(finite) {
            true => Ok(()),
            false => Err(Error::Singular { time: t }),
        }
    }

    /// Carries the wakes on from the instant before `t` s.
    fn carry_wakes(&mut self, t: f64) -> Result<(), Error> {
        let step = self.settings.step_s;
        let wakes = self.wakes.iter().chain(self.sheets());
        let points: Vec<Vec3> = wakes.flat_map(|wake| wake.grid.points.iter().copied()).collect();
        let mut velocities = match self.settings.wake {
            WakeMotion::Prescribed => vec![Vec3::ZERO; points.len()],
            WakeMotion::Free => {
                let places = vec![PointLocation::Wake; points.len()];
                let softened =
                    self.shedding.as_ref().map(|_| self.influence.softened(self.settings.sheet_core_m));
                let influence = softened.as_ref().unwrap_or(&self.influence);
                influence.velocities(&points, &places, &self.sources(true, true))
            }
        };
        velocities.iter_mut().for_each(|v| *v += self.scene.wind);
        if !velocities.iter().all(|v| v.is_finite()) {
            return Err(Error::NotFinite { time: t, what: "velocity of the wake" });
        }
        let first_order = self.settings.emulates() || self.settings.wake == WakeMotion::Prescribed;
        let wind = self.scene.wind;
        let mut carry = |wake: &mut Wake| {
            let rest = velocities.split_off(wake.grid.points.len());
            let own = std::mem::replace(&mut velocities, rest);
            let fastest = own.iter().fold(0.0_f64, |most, v| most.max((*v - wind).norm()));
            wake.carry(own, step, first_order);
            fastest
        };
        self.wakes.iter_mut().for_each(|wake| {
            carry(wake);
        });
        if let Some(Shedding { sheets, farthest, .. }) = &mut self.shedding {
            *farthest = sheets.iter_mut().map(carry).fold(*farthest, |most, v| most.max(v * step));
        }
        Ok(())
    }

    /// What induces velocities: bound rings with the ends of the last ones, wakes.
    fn sources(&self, bound: bool, wake: bool) -> InducingGrids<'_> {
        let meshes = self.meshes.iter().filter(|_| bound);
        let wakes = self.wakes.iter().chain(self.sheets()).filter(|_| wake).map(|wake| &wake.grid);
        let sheds = self.shedding.is_some();
        let noses = self.meshes.iter().enumerate().filter(|_| bound && sheds);
        let heads = noses.clone().map(|(_, mesh)| &mesh.heads);
        InducingGrids {
            bound: meshes
                .clone()
                .map(|mesh| &mesh.bound)
                .enumerate()
                .chain(noses.map(|(i, mesh)| (i, &mesh.nose)))
                .collect(),
            cored: meshes.map(|mesh| &mesh.trailing).chain(heads).chain(wakes).collect(),
        }
    }

    /// Where velocities are wanted: of every surface its control points, bound vortices and legs, with other conventions also the
    /// ends of the last rings. Beside the points stands where they lie.
    fn places(&self) -> (Vec<Vec3>, Vec<PointLocation>) {
        let ends = self.settings.emulates();
        let of = |mesh: &Mesh| {
            let mut places: Vec<Vec3> = mesh.controls.iter().map(|c| c.at).collect();
            places.extend(mesh.fronts.iter().chain(&mesh.legs).map(|e| e.at));
            places.extend(mesh.ends().filter(|_| ends).map(|e| e.at));
            places
        };
        let points = self.meshes.iter().flat_map(of).collect();
        let of = |(surface, mesh): (usize, &Mesh)| {
            let on: Vec<PointLocation> = mesh.places().map(|arc| PointLocation::On(surface, arc)).collect();
            on.into_iter()
                .chain(mesh.ends().filter(|_| ends).map(|_| PointLocation::Wake))
                .collect::<Vec<_>>()
        };
        (points, self.meshes.iter().enumerate().flat_map(of).collect())
    }

    /// Circulations that keep the flow tangent to every panel: sum_j a_ij G_j = -(air - panel) . n, the air without the rings.
    ///
    /// Equation: lattice.tangency
    /// `sum_j a_ij G_j = -(air - panel) . n at 3/4 of each panel`
    /// Source: Katz & Plotkin 2001, section 13.12.
    /// Test: `rectangles_have_the_slope_of_the_lifting_surface`.
    fn solve(&mut self, t: f64, air: &[Vec3]) -> Result<(), Error> {
        let mut matrix = self.influence.coefficients(&self.meshes);
        let n = self.rings[0].len();
        let (mut right, mut first) = (Vec::with_capacity(n), 0);
        for mesh in &self.meshes {
            let controls = mesh.controls.iter().zip(&air[first..]);
            right.extend(controls.map(|(c, air)| -(*air - c.velocity).dot(c.normal)));
            first += mesh.panels() + mesh.fronts.len() + mesh.legs.len();
            first += if self.settings.emulates() { mesh.strips } else { 0 };
        }
        let noses = self.shedding.as_ref().map(|own| own.held(&self.influence, &self.meshes, &mut right));
        let mut pivots = vec![0; n];
        if !lu_factor(&mut matrix, n, &mut pivots) {
            return Err(Error::Singular { time: t });
        }
        lu_solve(&matrix, n, &pivots, &mut right, 1);
        if let (Some(shedding), Some(noses)) = (&mut self.shedding, noses) {
            let factors = RingFactors { matrix: &matrix, pivots: &pivots };
            shedding.shed(&self.meshes, self.scene.wind, &factors, noses, &mut right);
            shedding.put(&mut self.meshes);
        }
        if !right.iter().all(|ring| ring.is_finite()) {
            return Err(Error::Singular { time: t });
        }
        self.put(right);
        Ok(())
    }

    /// Rates of circulations now and at the instants `before` by backward differences of as high an order, m2/s2. The first instant, when
    /// all starts at once, has none.
    ///
    /// Equation: lattice.rates
    /// `(11 G_n - 18 G_n-1 + 9 G_n-2 - 2 G_n-3)/(6 h) of rings, (3 G_n - 4 G_n-1 + G_n-2)/(2 h) of jumps at leading edges`
    /// Source: backward differences.
    /// Test: `a_long_wing_starts_as_wagner_says`.
    fn rates(&self, circulations: &[Vec<f64>]) -> Vec<f64> {
        let per_step = self.settings.step_s.recip();
        let emulated = self.settings.emulates();
        let order = if emulated { 1 } else { self.solved.min(circulations.len() - 1) };
        let weights: &[f64] = match order {
            0 => &[],
            1 => &[1.0, -1.0],
            2 => &[1.5, -2.0, 0.5],
            _ => &[11.0 / 6.0, -3.0, 1.5, -1.0 / 3.0],
        };
        let rate = |i: usize| {
            per_step * weights.iter().zip(circulations).map(|(weight, ring)| weight * ring[i]).sum::<f64>()
        };
        (0..circulations[0].len()).map(rate).collect()
    }

    /// The surfaces as they lay at the last instant solved.
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }
    /// Their wakes.
    pub fn wakes(&self) -> &[Wake] {
        &self.wakes
    }
    /// The sheets that leave their leading edges, where these shed.
    pub fn sheets(&self) -> &[Wake] {
        self.shedding.as_ref().map_or(&[], |shedding| &shedding.sheets)
    }
    /// Suction parameters of the leading edges, by surface and strip, where these shed, dimensionless.
    pub fn suction(&self) -> &[f64] {
        self.shedding.as_ref().map_or(&[], |shedding| &shedding.suction)
    }
    /// Share of the strips that shed at the last instant.
    pub fn shed_share(&self) -> f64 {
        self.shedding.as_ref().map_or(0.0, Shedding::share)
    }
    /// Largest way of a vortex of the sheets in a step so far, m.
    pub fn farthest(&self) -> f64 {
        self.shedding.as_ref().map_or(0.0, |shedding| shedding.farthest)
    }
    /// What it is stepped with.
    pub fn settings(&self) -> &LatticeSettings {
        &self.settings
    }
    /// What is stepped.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }
    /// Circulations of the rings, by surface and panel, m2/s.
    pub fn rings(&self) -> &[f64] {
        &self.rings[0]
    }
    /// Velocities of the air at `points`, m/s.
    pub fn velocities(&self, points: &[Vec3]) -> Vec<Vec3> {
        let places = vec![PointLocation::Wake; points.len()];
        let mut air = self.influence.velocities(points, &places, &self.sources(true, true));
        air.iter_mut().for_each(|v| *v += self.scene.wind);
        air
    }

    /// Largest circulation around a strip and its wake, over the largest ring: a vortex sheet that began at rest has none, as long
    /// as nothing of the wake is left out.
    ///
    /// Equation: lattice.kelvin
    /// `bound and shed circulation of a strip sum to zero`
    /// Source: Kelvin 1869.
    /// Test: `circulation_is_kept_and_halves_make_the_whole`.
    pub fn circulation_error(&self) -> f64 {
        let largest = self.rings[0].iter().fold(0.0_f64, |most, ring| most.max(ring.abs()));
        let mut worst: f64 = 0.0;
        let mut sheets = self.sheets().iter();
        for (mesh, wake) in self.meshes.iter().zip(&self.wakes) {
            let sheet = sheets.next().map_or(&[][..], |sheet| &sheet.grid.across);
            for j in 0..mesh.strips {
                let of = |across: &[f64]| across.iter().skip(j).step_by(mesh.strips).sum::<f64>();
                let wing = of(&mesh.bound.across) + of(&mesh.trailing.across) + of(&mesh.heads.across);
                let sum = wing + of(&wake.grid.across) + of(sheet);
                worst = worst.max(sum.abs());
            }
        }
        if largest > 0.0 { worst / largest } else { 0.0 }
    }
}

//! Surfaces laid over links: where their sections ride, and which links bear the loads of the strips.

use super::Robot;
use super::mechanism::Mechanism;
use super::placement::{Placement, PlacementNumbers};
use super::sections::{Borne, BorneParts, Carriers, Riding, SurfaceSection, Web};
use super::spec::{PanelSpec, RobotSpec, SurfaceSpec, WingSpec};
use crate::body::MAX_LINKS;
use arrayvec::ArrayVec;
use wingbeat_aero::{
    Aero, CD90, Coupling, FlapSpec, ImpulseRates, LiftLaw, MAX_SECTIONS, MAX_STRIPS, MembraneSpec, Planform,
    Preset, ProfileDrag, SectionMotion, SectionSpec, Sections, Span, StripModel, SurfaceNumbers, Surfaces,
    Wrench,
};
use wingbeat_math::Error;
use wingbeat_math::{Meets, Over, Parameters, Scalar, Vec3, append_copies};
use wingbeat_ocp::plant::MAX_DEGREES;

/// What a scenario needs to know of a surface to choose its aerodynamic model.
#[derive(Clone, Debug)]
pub struct SurfaceOutline {
    /// Name.
    pub name: String,
    /// Key in the robot file.
    pub key: String,
    /// Outline.
    pub planform: Planform,
    /// Arc lengths from the root at which it passes from link to link, m.
    pub hinges: Vec<f64>,
    /// Lengths beyond these over which it passes over, m.
    pub webs: Vec<f64>,
    /// Profile drag coefficient along the wind.
    pub cd0: f64,
    /// Drag coefficient of the plate broadside on, where given.
    pub cd90: Option<f64>,
    /// What it says of its section.
    pub section: SectionSpec,
    /// Its membrane.
    pub membrane: Option<MembraneSpec>,
    /// Its flap.
    pub flap: Option<FlapSpec>,
    /// Aerodynamic model asked for.
    pub preset: Option<Preset>,
    /// Lift law asked for.
    pub law: Option<LiftLaw>,
    /// Strips or nodes asked for.
    pub strips: Option<usize>,
}

impl SurfaceOutline {
    /// Profile drag under `law`: one that separates needs a force broadside, by default that of a flat plate.
    pub fn drag(&self, law: LiftLaw) -> ProfileDrag {
        let plate = if law.separates() { CD90.default } else { 0.0 };
        ProfileDrag { cd0: self.cd0, cd90: self.cd90.unwrap_or(plate) }
    }
}

impl Robot {
    /// Largest mass of the membrane on a link over the mass of that link, which has to hold it; none without a membrane.
    pub fn membrane_over_link(&self) -> Option<f64> {
        self.borne_over_link(|aero| aero.membrane().map(StripModel::membrane_masses))
    }

    /// The same of the flaps.
    pub fn flap_over_link(&self) -> Option<f64> {
        self.borne_over_link(|aero| aero.flap().map(StripModel::flap_masses))
    }

    /// Largest sum over a link of the masses (kg) of the strips on it, which `of` tells, over the mass of that link.
    fn borne_over_link(&self, of: impl Fn(&Aero) -> Option<Vec<f64>>) -> Option<f64> {
        let bodies = self.numbers().bodies;
        let models = self.surfaces().map(|(_, aero)| aero);
        let masses = models.flat_map(|aero| of(aero).unwrap_or_else(|| vec![0.0; aero.strips()]));
        let mut borne = vec![0.0; bodies.len()];
        for (mount, mass) in self.covering.mounts.iter().zip(masses) {
            borne[mount.link.map_or(0, |link| link + 1)] += mass;
        }
        let shares = borne.iter().zip(&bodies).filter(|(mass, _)| **mass > 0.0);
        shares.map(|(mass, body)| mass / body.mass).reduce(f64::max)
    }

    /// The surfaces of `spec`, of which the robot was built, with the outlines that the robot's numbers say.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key of the robot file.
    pub fn surface_outlines(&self, spec: &RobotSpec) -> Result<Vec<SurfaceOutline>, Error> {
        let mut outlines = spec.outlines()?;
        let placements = self.covering.placements.iter();
        for ((outline, (_, aero)), placement) in outlines.iter_mut().zip(self.surfaces()).zip(placements) {
            outline.hinges = placement.panels[1..].iter().map(|panel| panel.from_arc).collect();
            outline.webs = placement.panels[1..].iter().map(|panel| panel.web).collect();
            if let Some(planform) = &aero.numbers().outline {
                outline.planform.clone_from(planform);
            }
        }
        Ok(outlines)
    }
}

impl RobotSpec {
    /// The surfaces in order: that of `wing`, then the others.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key of the robot file.
    pub fn outlines(&self) -> Result<Vec<SurfaceOutline>, Error> {
        self.check_spars()?;
        let wing = self.wing.as_ref().map(|w| ("wing".into(), w.surface()));
        let others = self.surfaces.iter().enumerate();
        let others = others.map(|(i, s)| (format!("surfaces[{i}]"), self.over_spars(s.clone())));
        let outline = |(key, surface): (String, SurfaceSpec)| {
            let planform = surface.outline().map_err(|e| e.within(&key))?;
            surface
                .flap
                .iter()
                .try_for_each(|flap| flap.end_within(&planform))
                .map_err(|e| e.within(&key))?;
            Ok(SurfaceOutline {
                planform,
                hinges: surface.panels[1..].iter().map(|p| p.from_arc_m).collect(),
                webs: surface.panels[1..].iter().map(|p| p.web_m).collect(),
                cd0: surface.cd0,
                cd90: surface.cd90,
                section: surface.section,
                membrane: surface.membrane,
                flap: surface.flap,
                preset: surface.preset,
                law: surface.law,
                strips: surface.strips,
                name: surface.name,
                key,
            })
        };
        wing.into_iter().chain(others).map(outline).collect()
    }

    /// The surfaces as the file gives them, that of `wing` first.
    pub(super) fn all_surfaces(&self) -> impl Iterator<Item = SurfaceSpec> {
        let others = self.surfaces.iter().map(|surface| self.over_spars(surface.clone()));
        self.wing.iter().map(WingSpec::surface).chain(others)
    }
}

impl WingSpec {
    /// The surface of the pair of wings.
    pub(super) fn surface(&self) -> SurfaceSpec {
        let [x, root, z] = self.shoulder_m;
        let panel = |name: &str, link: &str, from_arc_m: f64, origin_m: [f64; 3]| PanelSpec {
            name: Some(name.into()),
            link: link.into(),
            from_arc_m,
            origin_m,
            direction: None,
            web_m: 0.0,
            piece: false,
        };
        SurfaceSpec {
            name: "wing".into(),
            span: Span::Symmetric,
            cd0: self.cd0,
            cd90: Some(self.cd90),
            section: self.section,
            membrane: self.membrane.clone(),
            flap: self.flap,
            preset: None,
            law: None,
            strips: None,
            planform_shift_m: self.planform_shift_m,
            planform: self.planform.clone(),
            gaps: self.gaps.clone(),
            panels: vec![
                panel("body", "body", 0.0, [x, 0.0, z]),
                panel("shoulder", "shoulder", root, [0.0; 3]),
                panel("elbow", "twist", root + self.proximal.length_m, [0.0; 3]),
            ],
        }
    }
}

/// Which links bear the load of a strip.
#[derive(Clone, Copy, Debug)]
struct Mount<P: Scalar = f64> {
    /// The link of the control section; `None` is the body.
    link: Option<usize>,
    /// Where the edges ride on different links: the sections of both edges, and the share of the second.
    edges: Option<([usize; 2], P)>,
}

/// How a surface lies on the robot.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    pub name: String,
    pub symmetric: bool,
    /// Names of the panels, from the root on.
    pub panels: Vec<String>,
    /// Sections at the ends of the panels with their names, from left to right.
    pub outline: Vec<(String, SurfaceSection)>,
    /// Its geometry.
    pub placement: Placement,
    /// Arcs at which it is drawn, from left to right, m: stations of the outline, of a membrane or a flap strips and
    /// of a membrane ribs besides.
    pub stations: Vec<f64>,
    /// Sections there.
    pub ribs: Vec<SurfaceSection>,
    /// Whether there is surface between one of them and the next.
    pub covered: Vec<bool>,
}

/// Adds the sections of a surface and what bears its strips.
fn ride<P: Scalar>(
    placement: &Placement<P>,
    aero: &Aero<P>,
    carriers: &[usize],
    (sections, webs): (&mut Vec<SurfaceSection<P>>, &mut Vec<Option<Web<P>>>),
    mounts: &mut Vec<Mount<P>>,
) {
    let at = |s: &P| placement.section(*s, carriers);
    let first = sections.len();
    sections.extend(aero.arcs().iter().map(at));
    // Nodes of preset `paper` are sections of their own links.
    let strips = matches!(aero, Aero::Strip(_));
    webs.extend(aero.arcs().iter().map(|s| placement.web(*s, carriers).filter(|_| strips)));
    mounts.extend(aero.strip_arcs().iter().enumerate().map(|(i, s)| {
        let (edges, share) = aero.strip_sections(i);
        let edges = edges.map(|edge| first + edge);
        let web = edges.iter().any(|edge| webs[*edge].is_some());
        let apart = web || sections[edges[0]].link != sections[edges[1]].link;
        Mount { link: at(s).link, edges: apart.then_some((edges, share)) }
    }));
}

/// Nothing where nothing lies between links.
fn only_some<P: Scalar>(webs: Vec<Option<Web<P>>>) -> Vec<Option<Web<P>>> {
    if webs.iter().any(Option::is_some) { webs } else { Vec::new() }
}

/// All surfaces of a robot with their aerodynamic models.
#[derive(Clone, Debug)]
pub(super) struct Covering<P: Scalar = f64> {
    pub aero: Surfaces<P>,
    pub laid: Vec<Laid>,
    sections: Vec<SurfaceSection<P>>,
    /// Those of them that lie between two links; empty where none does.
    webs: Vec<Option<Web<P>>>,
    mounts: Vec<Mount<P>>,
    /// Numbers of the surfaces' places.
    pub placements: Vec<PlacementNumbers<P>>,
}

/// Loads on links, and on the body last, about the body origin, in B.
pub(super) type External<S> = ArrayVec<Wrench<S>, { MAX_LINKS + 1 }>;

impl Laid {
    /// Name of a panel; none where another has it too.
    pub fn panel(&self, place: usize) -> Option<&str> {
        let name = self.panels.get(place)?;
        (self.panels.iter().filter(|other| *other == name).count() == 1).then_some(name)
    }

    /// Names of the ends of the panels, with the surface's name before unless it is the `first`.
    pub fn outline_names(&self, first: bool) -> Vec<String> {
        let prefix = if first { String::new() } else { format!("{}_", self.name) };
        self.outline.iter().map(|(name, _)| format!("{prefix}{name}")).collect()
    }

    /// Refuses ends of panels that share a name with each other or with those of the surfaces `before`.
    fn check_names(&self, before: &[Self]) -> Result<(), Error> {
        let names = self.outline_names(before.is_empty());
        if let Some(twice) = (1..names.len()).find(|&i| names[..i].contains(&names[i])) {
            let allowed = "panels of which each end has a name of its own";
            return Err(Error::invalid("panels", &names[twice], allowed));
        }
        let taken = before.iter().enumerate().flat_map(|(i, s)| s.outline_names(i == 0));
        match taken.into_iter().find(|name| names.contains(name)) {
            Some(clash) => {
                let allowed = format!("another name: its panels would share the columns of {clash:?}");
                Err(Error::invalid("name", &self.name, allowed))
            }
            None => Ok(()),
        }
    }
}

impl Covering {
    /// Lays the surfaces of `spec` over `mechanism`, of which `carriers` carry them, with one model each.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key of the surface.
    pub fn new(
        spec: &RobotSpec,
        mechanism: &Mechanism,
        carriers: &[usize],
        models: Vec<Aero>,
    ) -> Result<Self, Error> {
        let outlines = spec.outlines()?;
        assert_eq!(outlines.len(), models.len(), "one aerodynamic model per surface");
        let (mut laid, mut sections, mut webs, mut mounts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for ((surface, outline), aero) in spec.all_surfaces().zip(&outlines).zip(&models) {
            let placement = Placement::new(&surface, mechanism).map_err(|e| e.within(&outline.key))?;
            let at = |s: &f64| placement.section(*s, carriers);
            ride(&placement, aero, carriers, (&mut sections, &mut webs), &mut mounts);
            let mut stations = placement.stations();
            if let Some(model) = aero.membrane().or_else(|| aero.flap()) {
                stations.extend(aero.strip_arcs().iter().chain(model.membrane_ribs()));
                wingbeat_math::order::descend(&mut stations);
                stations.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            }
            let placed = Laid {
                name: surface.name.clone(),
                symmetric: surface.span == Span::Symmetric,
                panels: surface.panels.iter().map(PanelSpec::begin).collect(),
                outline: placement
                    .ends(&surface.panels)
                    .into_iter()
                    .map(|(s, name)| (name, at(&s)))
                    .collect(),
                ribs: stations.iter().map(at).collect(),
                covered: stations.windows(2).map(|s| outline.planform.covers(0.5 * (s[0] + s[1]))).collect(),
                stations,
                placement,
            };
            placed.check_names(&laid).map_err(|e| e.within(&outline.key))?;
            laid.push(placed);
        }
        let named = outlines.into_iter().map(|outline| outline.name).zip(models);
        let placements = spec.all_surfaces().map(|surface| surface.placement()).collect();
        let webs = only_some(webs);
        Ok(Self { aero: Surfaces::new(named)?, laid, sections, webs, mounts, placements })
    }
}

impl<P: Scalar> Covering<P> {
    /// The same surfaces with other numbers, and on other places of the links, of which `carriers` carry them. What is
    /// drawn of them stays.
    ///
    /// # Errors
    /// [`Error::Invalid`] when strips or nodes do not fit an outline.
    pub fn with<Q: Scalar>(
        &self,
        numbers: &[SurfaceNumbers<Q>],
        placements: &[PlacementNumbers<Q>],
        carriers: &[usize],
    ) -> Result<Covering<Q>, Error> {
        let aero = self.aero.with(numbers)?;
        let (mut sections, mut webs, mut mounts) = (Vec::new(), Vec::new(), Vec::new());
        for (((laid, numbers), place), surface) in
            self.laid.iter().zip(numbers).zip(placements).zip(aero.surfaces())
        {
            let drawn = || laid.placement.planform.map(Q::from);
            let planform = numbers.outline.clone().unwrap_or_else(drawn);
            let placement = Placement::laid(planform, place, &laid.placement.links());
            ride(&placement, surface.aero(), carriers, (&mut sections, &mut webs), &mut mounts);
        }
        let (laid, webs) = (self.laid.clone(), only_some(webs));
        Ok(Covering { aero, laid, sections, webs, mounts, placements: placements.to_vec() })
    }

    /// Takes the air from the surfaces; what is drawn of them stays.
    pub fn strip(&mut self) {
        self.aero = Surfaces::none();
        self.sections.clear();
        self.webs.clear();
        self.mounts.clear();
    }

    /// The sections of all surfaces riding on `carriers`.
    pub fn riding<'a, S: Scalar + Meets<P>>(&'a self, carriers: &'a Carriers<'a, S>) -> Riding<'a, P, S> {
        Riding { sections: &self.sections, webs: &self.webs, carriers }
    }

    /// Sum of the loads (N and N m) and the added mass (kg, kg m and kg m2), in B, with the state rates in `dx`; the
    /// coordinates of `carriers` take their part in `coupled`. Places carry the derivatives of `K` alone.
    #[inline(always)]
    pub fn sum<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, S: Over<G> + Over<K> + Meets<P>>(
        &self,
        carriers: &Carriers<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        coupled: Option<MechanismLoads<'_, G, S>>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        let riding = self.riding(carriers);
        let Some(MechanismLoads { mass, external, impulses }) = coupled else {
            return self.aero.sum_over_places::<K, G, S>(&riding, wind, x, dx, None);
        };
        let mut strips = ArrayVec::<Wrench<S>, MAX_STRIPS>::new();
        append_copies(&mut strips, Wrench::ZERO, self.strips());
        let coupling = Coupling { mass, strips: &mut strips, impulses };
        let sum = self.aero.sum_over_places::<K, G, S>(&riding, wind, x, dx, Some(coupling));
        self.share(&riding, &strips, external);
        sum
    }

    /// Sets states that follow the impulse of the air to that impulse, under the wind `wind` (m/s, B).
    pub fn settle<S: Scalar + Meets<P>>(&self, carriers: &Carriers<S>, wind: Vec3<S>, x: &mut [S]) {
        self.aero.settle(&self.riding(carriers), wind, x);
    }

    /// Motion of all sections, behind those of `motions`.
    pub fn motions<S: Scalar + Meets<P>>(
        &self,
        carriers: &Carriers<S>,
        motions: &mut ArrayVec<SectionMotion<S>, MAX_SECTIONS>,
    ) {
        let riding = self.riding(carriers);
        for i in 0..self.sections.len() {
            motions.push(riding.section(i));
        }
    }

    /// Number of strips of all surfaces.
    pub fn strips(&self) -> usize {
        self.mounts.len()
    }

    /// Adds the loads (N and N m, B) of the strips to the links that bear them.
    pub fn share<G: Scalar + Meets<P>, S: Over<G>>(
        &self,
        riding: &Riding<P, G>,
        strips: &[Wrench<S>],
        external: &mut External<S>,
    ) {
        let body = external.len() - 1;
        for (i, load) in strips.iter().enumerate().take(self.mounts.len()) {
            self.share_strip(i, riding, load, |link, load| external[link.unwrap_or(body)] += load);
        }
    }

    /// Tells the links, or the body, what they bear of the load (N and N m, B) of the strip `i`.
    #[inline(always)]
    pub fn share_strip<G: Scalar + Meets<P>, S: Over<G>>(
        &self,
        i: usize,
        riding: &Riding<P, G>,
        load: &Wrench<S>,
        mut bear: impl FnMut(Option<usize>, Wrench<S>),
    ) {
        let mount = &self.mounts[i];
        let Some((edges, share)) = mount.edges else {
            bear(mount.link, *load);
            return;
        };
        between_edges(riding, (edges, G::from(share)), mount.link, load, &mut bear);
    }
}

/// What the coordinates of the mechanism take from all surfaces.
pub(super) struct MechanismLoads<'a, G: Scalar, S: Scalar> {
    /// Mass matrix of body and coordinates; none where nobody asks for it.
    pub mass: Option<&'a mut [[G; MAX_DEGREES]]>,
    /// Loads on the links, the body last.
    pub external: &'a mut External<S>,
    /// What the rates of followed impulses lack, where there are any.
    pub impulses: Option<&'a mut ImpulseRates<G>>,
}

/// Tells links what they bear of the load of a strip between the sections `edges`, the second with the share `share`, and of the couple
/// about the chord `own`, the strip's own link. The strip moves with v = sum(f_k v_k) at mid chord and pitches with
/// q = -sum(f_k c_k') . n / c, c_k the chord lines on links of which its own is the sum and f_k their shares, so that by virtual work the
/// force F acts as f_k F at the mid chords and the couple T about the strip's axis as f_k T n x c_k / c.
///
/// Equation: robot.strip_shares
/// `f_k F at the mid chords, f_k T n x c_k / c; f_k the shares of chord lines on links, (1 - f) and f of both edges`
/// Source: virtual work.
/// Test: `elastic_joints_bear_the_efforts_of_their_springs`.
#[inline(never)]
pub(super) fn between_edges<P: Scalar, G: Scalar + Meets<P>, S: Over<G>>(
    riding: &Riding<P, G>,
    (edges, share): ([usize; 2], G),
    own: Option<usize>,
    load: &Wrench<S>,
    bear: &mut dyn FnMut(Option<usize>, Wrench<S>),
) {
    let mut parts = BorneParts::<G>::new();
    let [first, second] =
        [(0, G::ONE - share), (1, share)].map(|(k, share)| riding.bear(edges[k], share, &mut parts));
    let across = (second[0] - first[0]) + (second[1] - first[1]);
    let chord_of = |part: &Borne<G>| part.ends[1] - part.ends[0];
    let force_of = |part: &Borne<G>| {
        let force = load.force.scaled(part.share);
        Wrench { force, moment: (part.ends[0] + chord_of(part).scaled(0.5)).cross_over(force) }
    };
    let mut chord = chord_of(&parts[0]).scaled(parts[0].share);
    for part in &parts[1..] {
        chord += chord_of(part).scaled(part.share);
    }
    let normal = chord.cross(across).unit();
    let inverse_chord = chord.norm().recip();
    let couple = parts.iter().fold(load.moment, |sum, part| sum - force_of(part).moment);
    let nose_up = (normal.cross(chord) * inverse_chord).dot_over(couple);
    let mut rest = couple;
    for part in &parts {
        let turning = (normal.cross(chord_of(part)) * inverse_chord).times(nose_up * part.share);
        rest -= turning;
        let Wrench { force, moment } = force_of(part);
        bear(part.link, Wrench { force, moment: moment + turning });
    }
    bear(own, Wrench::couple(rest));
}

//! The surfaces of one robot: wings, tails, fins, each with its own preset, strips and law.
//!
//! The surfaces stand one behind the other in everything that goes in and out: sections, states,
//! strips. One surface alone is evaluated as it is, to the last bit.
//!
//! Surfaces of preset `full` wash over each other: what is bound at once, what has been shed when it
//! arrives, told by states of each pair that follow the states of the surfaces. Preset `paper` neither sees
//! others nor is seen: its lifting line is planar by definition. No surface feels the air that another
//! carries along (added mass between surfaces): in two dimensions a tail of .6 chords, one chord behind a wing that
//! is accelerated, would feel .042 of its own added mass, the wing .015 of its own from the tail's.
//!
//! Strips end a little short of the outline, as at a tip. Two surfaces whose outlines abut leave a slit, which costs
//! a wing cut in two halves of eight strips a tenth of its lift; placed so that their last edges meet they lift like
//! one wing within two per cent.

use super::strip::{ARRIVAL_LAGS, ByStates, Others, Source, Vortices};
use super::{
    Aero, Coupling, Ground, LiftLaw, Loads, MAX_STRIPS, MAX_SURFACES, SectionFields, SectionMotion, Sections,
    StripModel, SurfaceNumbers, Wrench,
};
use std::ops::Range;
use wingbeat_math::Error;
use wingbeat_math::{Meets, Over, Scalar, Vec3};
use wingbeat_ocp::plant::Channel;

/// One surface and its place among the others.
#[derive(Clone, Debug)]
pub struct Surface<P: Scalar = f64> {
    name: String,
    aero: Aero<P>,
    sections: Range<usize>,
    strips: Range<usize>,
    states: Range<usize>,
    /// The surfaces that wash over it, and the states that carry their circulation here.
    sources: Vec<Source<P>>,
    arrivals: Range<usize>,
}

impl<P: Scalar> Surface<P> {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Its preset, law and strips.
    pub fn aero(&self) -> &Aero<P> {
        &self.aero
    }
    /// Its sections among those of all surfaces.
    pub fn sections(&self) -> Range<usize> {
        self.sections.clone()
    }
    /// Its strips among those of all surfaces, as in [`Loads`].
    pub fn strips(&self) -> Range<usize> {
        self.strips.clone()
    }
    /// Its own states among all.
    pub fn states(&self) -> Range<usize> {
        self.states.clone()
    }
}

/// Up to [`MAX_SURFACES`] surfaces with at most [`MAX_STRIPS`] strips together.
#[derive(Clone, Debug)]
pub struct Surfaces<P: Scalar = f64> {
    surfaces: Vec<Surface<P>>,
    arcs: Vec<P>,
    strip_arcs: Vec<P>,
    /// Whether they see their mirror images at a ground.
    grounded: bool,
}

impl From<Aero> for Surfaces {
    /// The one surface `wing`.
    fn from(aero: Aero) -> Self {
        let mut surfaces = Self::none();
        surfaces.add("wing".into(), aero);
        surfaces
    }
}

impl Surfaces {
    /// Named surfaces in the given order.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there are too many, too many strips, or two of one name.
    pub fn new(surfaces: impl IntoIterator<Item = (String, Aero)>) -> Result<Self, Error> {
        Self::all_of(surfaces.into_iter().collect())
    }

    /// The surfaces, compiled once.
    fn all_of(surfaces: Vec<(String, Aero)>) -> Result<Self, Error> {
        let mut all = Self::none();
        for (name, aero) in surfaces {
            if name.is_empty() || all.surfaces.iter().any(|other| other.name == name) {
                let key = format!("surfaces[{}].name", all.surfaces.len());
                return Err(Error::invalid(key, format!("\"{name}\""), "a name of its own"));
            }
            all.add(name, aero);
        }
        let (count, strips) = (all.surfaces.len(), all.strips());
        if count > MAX_SURFACES {
            return Err(Error::invalid("surfaces", count, format!("at most {MAX_SURFACES} surfaces")));
        }
        if strips > MAX_STRIPS {
            let given = format!("{strips} strips of all surfaces");
            return Err(Error::invalid("surfaces", given, format!("at most {MAX_STRIPS}")));
        }
        all.pair();
        Ok(all)
    }

    /// The same surfaces under another law.
    ///
    /// # Errors
    /// As [`Aero::under`].
    pub fn under(&self, law: LiftLaw) -> Result<Self, Error> {
        let under = |own: &Surface| Ok((own.name.clone(), own.aero.under(law)?));
        let all = Self::new(self.surfaces.iter().map(under).collect::<Result<Vec<_>, Error>>()?)?;
        Ok(if self.grounded { all.over_ground() } else { all })
    }
}

impl<P: Scalar> Surfaces<P> {
    /// No surface.
    pub fn none() -> Self {
        Self { surfaces: Vec::new(), arcs: Vec::new(), strip_arcs: Vec::new(), grounded: false }
    }

    /// The same over a ground or under a ceiling, of which [`Sections::ground`] tells the place: states follow that carry the
    /// circulation of every image to each surface of preset `full`.
    #[must_use]
    pub fn over_ground(mut self) -> Self {
        self.grounded = true;
        self.pair();
        self
    }

    /// Lets every surface that can see the others.
    #[inline(never)]
    fn pair(&mut self) {
        let shedding = |(k, surface): (usize, &Surface<P>)| {
            let source = surface.aero.source(surface.sections.start, surface.strips.start)?;
            Some((k, source))
        };
        let sources: Vec<(usize, Source<P>)> =
            self.surfaces.iter().enumerate().filter_map(shedding).collect();
        let mut first = self.own_states();
        for (k, surface) in self.surfaces.iter_mut().enumerate() {
            if sources.iter().any(|(own, _)| *own == k) {
                let others = sources.iter().filter(|(own, _)| *own != k);
                surface.sources = others.map(|(_, source)| source.clone()).collect();
                let images = sources.iter().filter(|_| self.grounded);
                surface.sources.extend(images.map(|(_, source)| source.image()));
            }
            let count: usize = surface.sources.iter().map(Source::arrivals).sum();
            surface.arrivals = first..first + count;
            first += count;
        }
    }

    fn add(&mut self, name: String, aero: Aero<P>) {
        let after = |first: usize, count: usize| first..first + count;
        let states = self.own_states();
        let surface = Surface {
            sections: after(self.arcs.len(), aero.arcs().len()),
            strips: after(self.strip_arcs.len(), aero.strips()),
            states: after(states, aero.states()),
            sources: Vec::new(),
            arrivals: 0..0,
            name,
            aero,
        };
        self.arcs.extend_from_slice(surface.aero.arcs());
        self.strip_arcs.extend_from_slice(surface.aero.strip_arcs());
        self.surfaces.push(surface);
    }

    /// The same surfaces with other numbers than their settings say, one set for each.
    ///
    /// # Errors
    /// [`Error::Invalid`] when strips or nodes do not fit an outline.
    ///
    /// # Panics
    /// When there are not as many.
    #[inline(never)]
    pub fn with<Q: Scalar>(&self, numbers: &[SurfaceNumbers<Q>]) -> Result<Surfaces<Q>, Error> {
        assert_eq!(numbers.len(), self.surfaces.len(), "numbers of every surface");
        let mut all = Surfaces::none();
        for (surface, numbers) in self.surfaces.iter().zip(numbers) {
            all.add(surface.name.clone(), surface.aero.with(numbers)?);
        }
        all.grounded = self.grounded;
        all.pair();
        Ok(all)
    }

    /// The same surfaces whose membranes move as they are given, and the states that are: see [`StripModel::with_shapes_given`].
    #[must_use]
    pub fn with_shapes_given(&self) -> (Self, Vec<Range<usize>>) {
        let mut all = Self { grounded: self.grounded, ..Self::none() };
        let mut given = Vec::new();
        for surface in &self.surfaces {
            all.add(surface.name.clone(), surface.aero.with_shapes_given());
            let end = all.own_states();
            let count =
                all.surfaces.last().and_then(|last| last.aero.membrane()).map_or(0, StripModel::given);
            given.extend((count > 0).then(|| end - count..end));
        }
        all.pair();
        (all, given)
    }

    /// Gives the flaps of all surfaces the inertance of `time` s: [`StripModel::set_inertance`].
    pub fn set_inertance(&mut self, time: f64) {
        for surface in &mut self.surfaces {
            if let Aero::Strip(model) = &mut surface.aero {
                model.set_inertance(time);
            }
        }
    }

    /// Number of states of the surfaces themselves.
    fn own_states(&self) -> usize {
        self.surfaces.last().map_or(0, |surface| surface.states.end)
    }

    /// The surfaces in order.
    pub fn surfaces(&self) -> &[Surface<P>] {
        &self.surfaces
    }
    /// The surface with the given strip of all.
    ///
    /// # Panics
    /// When there is no such strip.
    pub fn of_strip(&self, strip: usize) -> &Surface<P> {
        let owns = |surface: &&Surface<P>| surface.strips.contains(&strip);
        self.surfaces.iter().find(owns).expect("a strip of one of the surfaces")
    }
    /// Arc coordinates where [`SectionMotion`]s are wanted, m: those of [`Aero::arcs`] for each surface in turn.
    pub fn arcs(&self) -> &[P] {
        &self.arcs
    }
    /// Arc coordinates of the strips' middles on their surfaces, m.
    pub fn strip_arcs(&self) -> &[P] {
        &self.strip_arcs
    }
    /// Number of strips.
    pub fn strips(&self) -> usize {
        self.strip_arcs.len()
    }
    /// Number of states: of each surface in turn, then those that carry circulation to each surface from
    /// each of the others.
    pub fn states(&self) -> usize {
        self.own_states() + self.surfaces.iter().map(|surface| surface.arrivals.len()).sum::<usize>()
    }
    /// Names and units of the states, in order. Names of all surfaces but the first begin with the surface's;
    /// what travels is called `tail_from_wing_lag1_0`, from a mirror image `tail_from_wing_image_lag1_0`.
    #[inline(never)]
    pub fn channels(&self) -> Vec<Channel> {
        let prefixed = |(k, surface): (usize, &Surface<P>)| {
            let mut channels = surface.aero.channels();
            if k > 0 {
                channels.iter_mut().for_each(|c| c.name = format!("{}_{}", surface.name, c.name));
            }
            channels
        };
        let own = self.surfaces.iter().enumerate().flat_map(prefixed);
        own.chain(self.surfaces.iter().flat_map(|surface| self.arriving(surface))).collect()
    }
    /// Names and units of what travels to a surface.
    fn arriving(&self, surface: &Surface<P>) -> Vec<Channel> {
        let from = |source: &Source<P>| {
            let image = if source.is_image() { "_image" } else { "" };
            let name = format!("{}_from_{}{image}_lag", surface.name, self.of_strip(source.first_strip).name);
            let strips = source.arrivals() / ARRIVAL_LAGS;
            (0..source.arrivals())
                .map(|i| Channel::free(format!("{name}{}_{}", i / strips + 1, i % strips), "m2/s", ""))
                .collect::<Vec<_>>()
        };
        surface.sources.iter().flat_map(from).collect()
    }
    /// The state that stands for state `i` in the mirror image, each surface being its own image.
    pub fn mirrored(&self, i: usize) -> usize {
        self.image(i).map_or(i, |(_, image)| image)
    }
    /// Name of the surface to whose air state `i` belongs, its own or that which has arrived elsewhere, and the state that stands for
    /// it in the mirror image of that surface.
    pub fn image(&self, i: usize) -> Option<(&str, usize)> {
        for surface in &self.surfaces {
            if surface.states.contains(&i) {
                let image = surface.states.start + surface.aero.mirrored(i - surface.states.start);
                return Some((&surface.name, image));
            }
            let mut first = surface.arrivals.start;
            for source in &surface.sources {
                if (first..first + source.arrivals()).contains(&i) {
                    return Some((
                        &self.of_strip(source.first_strip).name,
                        first + source.mirrored(i - first),
                    ));
                }
                first += source.arrivals();
            }
        }
        None
    }

    /// Whether states of a surface follow the impulse of its air.
    #[inline]
    pub fn follow_impulses(&self) -> bool {
        self.surfaces.iter().any(|surface| surface.aero.follows_impulse())
    }

    /// Whether a surface has a flap.
    pub fn have_flaps(&self) -> bool {
        self.surfaces.iter().any(|surface| surface.aero.flap().is_some())
    }

    /// Whether [`settle`](Self::settle) sets states.
    pub fn settles(&self) -> bool {
        self.surfaces.iter().any(|surface| surface.aero.settles())
    }

    /// As [`Aero::settle`] for all surfaces.
    pub fn settle<S: Scalar + Meets<P>>(&self, sections: &impl Sections<S>, wind: Vec3<S>, x: &mut [S]) {
        for surface in &self.surfaces {
            let own = Following { all: sections, first: surface.sections.start };
            surface.aero.settle(&own, wind, &mut x[surface.states()]);
        }
    }

    /// State rates and loads of the sections at [`arcs`](Self::arcs) in air that moves with `wind`
    /// (resolved in B). See [`Loads`] for the body acceleration.
    pub fn evaluate<S: Scalar + Meets<P>>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) {
        self.evaluate_over(None, sections, wind, x, dx, loads);
    }

    /// The same over the `ground`, which surfaces that are [over one](Self::over_ground) feel.
    pub fn evaluate_over<S: Scalar + Meets<P>>(
        &self,
        ground: Option<Ground<S>>,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) {
        self.evaluate_under((ground, Vec3::ZERO, false), sections, wind, x, dx, loads);
    }

    /// The same under gravity (m/s2, B), which flaps feel; where the motions of the sections are `complete`, as
    /// [`Sections::complete`] has it, without the added mass.
    pub fn evaluate_under<S: Scalar + Meets<P>>(
        &self,
        (ground, gravity, complete): (Option<Ground<S>>, Vec3<S>, bool),
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) {
        loads.clear();
        let sections = HeavySections { all: sections, gravity, complete };
        if let ([only], false) = (&self.surfaces[..], self.grounded) {
            (loads.wrench, loads.added_mass) = only.aero.append(&sections, wind, x, dx, None, loads);
            return;
        }
        let vortices = self.vortices(&sections, wind, x, ground);
        let mut sum = Sum::ZERO;
        for surface in &self.surfaces {
            let own = Following { all: &sections, first: surface.sections.start };
            let states = surface.states();
            let (dx, arriving) = dx.split_at_mut(self.own_states());
            let others = self.others(surface, &vortices, x, arriving);
            sum.add(surface.aero.append(&own, wind, &x[states.clone()], &mut dx[states], others, loads));
        }
        (loads.wrench, loads.added_mass) = (sum.wrench, sum.added_mass);
    }

    /// The vortices of the surfaces that others can see, and their mirror images at the `ground`.
    fn vortices<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        sections: &impl Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        ground: Option<Ground<G>>,
    ) -> (Vortices<G, S>, Option<Vortices<G, S>>) {
        let mut vortices = Vortices::NONE;
        for surface in &self.surfaces {
            if let (Aero::Strip(model), false) = (&surface.aero, surface.sources.is_empty()) {
                let own = Following { all: sections, first: surface.sections.start };
                let place = [surface.sections.start, surface.strips.start];
                model.shed(&own, wind, &x[surface.states()], place, &mut vortices);
            }
        }
        let images = ground.map(|ground| {
            let mut images = vortices.clone();
            images.mirror(&ground, self.arcs.len());
            images
        });
        (vortices, images)
    }

    /// What `surface` sees; `arriving` are the rates behind those of the surfaces' own states.
    fn others<'a, G: Scalar, S: Scalar>(
        &self,
        surface: &'a Surface<P>,
        (vortices, images): &'a (Vortices<G, S>, Option<Vortices<G, S>>),
        x: &'a [S],
        arriving: &'a mut [S],
    ) -> Option<Others<'a, P, G, S>> {
        if surface.sources.is_empty() {
            return None;
        }
        let (at, own) = (surface.arrivals.clone(), self.own_states());
        let dx = &mut arriving[at.start - own..at.end - own];
        Some(Others { vortices, images: images.as_ref(), sources: &surface.sources, x: &x[at], dx })
    }

    /// As [`evaluate`](Self::evaluate) for the sum alone: the wrench and the
    /// added-mass matrix. The states may carry more derivatives than the motion. `coupling` receives
    /// what the coordinates of `sections` take from all surfaces.
    pub fn evaluate_sum<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        sections: &impl Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        coupling: Option<Coupling<'_, G, S>>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        self.sum_over_places::<G, G, S>(sections, wind, x, dx, coupling)
    }

    /// As [`evaluate_sum`](Self::evaluate_sum) where the places of the sections carry the derivatives of `K` alone, which spares
    /// those of all that places decide.
    pub fn sum_over_places<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, S: Over<G> + Over<K> + Meets<P>>(
        &self,
        sections: &impl Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        mut coupling: Option<Coupling<'_, G, S>>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        if let ([only], false) = (&self.surfaces[..], self.grounded) {
            // As one of several, so that there is one copy of the model for either case.
            return only.aero.sum::<K, G, S>(
                &Following { all: sections, first: 0 },
                wind,
                x,
                dx,
                None,
                coupling,
            );
        }
        let vortices = self.vortices(sections, wind, x, sections.ground());
        let mut sum = Sum::ZERO;
        for surface in &self.surfaces {
            let own = Following { all: sections, first: surface.sections.start };
            let states = surface.states();
            let (dx, arriving) = dx.split_at_mut(self.own_states());
            let others = self.others(surface, &vortices, x, arriving);
            let coupling = coupling.as_mut().map(|all| {
                let mut impulses = all.impulses.as_deref_mut();
                if let Some(impulses) = impulses.as_mut() {
                    impulses.first_state = states.start;
                }
                let mass = all.mass.as_deref_mut();
                Coupling { mass, strips: &mut all.strips[surface.strips()], impulses }
            });
            let (x, dx) = (&x[states.clone()], &mut dx[states]);
            sum.add(surface.aero.sum::<K, G, S>(&own, wind, x, dx, others, coupling));
        }
        (sum.wrench, sum.added_mass)
    }
}

impl Surfaces {
    /// As [`evaluate_sum`](Self::evaluate_sum) with the derivatives by all states in `out`; none where these surfaces do not give them: where they
    /// are several, over a ground, of `paper` as printed, or of `full` with membranes or more than 16 strips.
    pub fn by_states(
        &self,
        sections: &impl Sections<f64>,
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
        coupling: Coupling<'_, f64, f64>,
        out: &mut ByStates,
    ) -> Option<(Wrench<f64>, [[f64; 6]; 6])> {
        let sections = Following { all: sections, first: 0 };
        Some(match self.alone_by_states()? {
            Aero::LiftingLine(line) => line.by_states(&sections, wind, x, dx, coupling, out),
            Aero::Strip(model) => model.by_states(&sections, wind, x, dx, coupling, out),
        })
    }

    /// Whether [`by_states`](Self::by_states) gives derivatives.
    pub fn know_by_states(&self) -> bool {
        self.alone_by_states().is_some()
    }

    fn alone_by_states(&self) -> Option<&Aero> {
        let ([Surface { aero, .. }], false) = (&self.surfaces[..], self.grounded) else { return None };
        let knows = match aero {
            Aero::LiftingLine(line) => line.knows_by_states(),
            Aero::Strip(model) => model.knows_by_states(),
        };
        knows.then_some(aero)
    }
}

/// Sections under gravity, m/s2 in B.
struct HeavySections<'a, S: Scalar> {
    all: &'a [SectionMotion<S>],
    gravity: Vec3<S>,
    complete: bool,
}

impl<S: Scalar> Sections<S> for HeavySections<'_, S> {
    fn section(&self, i: usize) -> SectionMotion<S> {
        self.all[i]
    }
    fn gravity(&self) -> Vec3<S> {
        self.gravity
    }
    fn complete(&self) -> bool {
        self.complete
    }
}

/// The sections of all surfaces from one on.
struct Following<'a, T: ?Sized> {
    all: &'a T,
    first: usize,
}

impl<S: Scalar, T: Sections<S> + ?Sized> Sections<S> for Following<'_, T> {
    #[inline(always)]
    fn section(&self, i: usize) -> SectionMotion<S> {
        self.all.section(self.first + i)
    }
    #[inline(always)]
    fn on_link(&self, i: usize) -> SectionMotion<S> {
        self.all.on_link(self.first + i)
    }
    fn coordinates(&self) -> usize {
        self.all.coordinates()
    }
    fn ground(&self) -> Option<Ground<S>> {
        self.all.ground()
    }
    fn gravity(&self) -> Vec3<S> {
        self.all.gravity()
    }
    fn complete(&self) -> bool {
        self.all.complete()
    }
    fn fields(&self, i: usize, fields: &mut SectionFields<S>) -> u32 {
        self.all.fields(self.first + i, fields)
    }
}

/// Wrench and added mass of the surfaces so far.
struct Sum<G: Scalar, S: Scalar> {
    wrench: Wrench<S>,
    added_mass: [[G; 6]; 6],
}

impl<G: Scalar, S: Scalar> Sum<G, S> {
    const ZERO: Self = Self { wrench: Wrench::ZERO, added_mass: [[G::ZERO; 6]; 6] };

    fn add(&mut self, (wrench, added_mass): (Wrench<S>, [[G; 6]; 6])) {
        self.wrench += wrench;
        for i in 0..6 {
            for j in 0..6 {
                self.added_mass[i][j] += added_mass[i][j];
            }
        }
    }
}

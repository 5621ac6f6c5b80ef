//! The robot under loads on its links that come from beyond its own model of the air.

use super::dynamics::Evaluation;
use super::observe::{Moving, Observation};
use super::sections::{CarrierRoom, Carriers};
use super::surface::{External, between_edges};
use super::{BodyMotion, CarriedLoads, Links, Robot, Stance};
use crate::body::Coordinates;
use arrayvec::ArrayVec;
use wingbeat_aero::{ForceDetail, Loads, StripLoads};
use wingbeat_math::{Jet, Vec3, Wrench};
use wingbeat_ocp::plant::Fault;

/// Loads of air from beyond the robot's models.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BeyondLoads {
    /// On the links in the order of the tree, the body last, about the body origin, in B, N and N m; none, or one for each.
    pub links: External<f64>,
    /// On what bends the chords of the surfaces, N m by the heights over the chord and the angles, in the order of
    /// [`Robot::bent_chords`]; none, or one for each.
    pub bends: Vec<f64>,
}

impl BeyondLoads {
    /// None.
    pub const NONE: Self = Self { links: External::new_const(), bends: Vec::new() };

    /// Number by number (N, N m) what `with` makes of those of both.
    #[must_use]
    pub fn with(&self, other: &Self, with: impl Fn(f64, f64) -> f64) -> Self {
        let three = |a: Vec3, b: Vec3| Vec3::new(with(a[0], b[0]), with(a[1], b[1]), with(a[2], b[2]));
        let both = |(a, b): (&Wrench<f64>, &Wrench<f64>)| Wrench {
            force: three(a.force, b.force),
            moment: three(a.moment, b.moment),
        };
        Self {
            links: self.links.iter().zip(&other.links).map(both).collect(),
            bends: self.bends.iter().zip(&other.bends).map(|(a, b)| with(*a, *b)).collect(),
        }
    }
}

/// `air` with the loads `beyond`, if there are any.
fn with_beyond(air: StripLoads<f64>, beyond: &[Wrench<f64>]) -> StripLoads<f64> {
    if beyond.is_empty() {
        return air;
    }
    let StripLoads { circulatory, induced_drag, added_mass, profile_drag } = air;
    let sum = beyond.iter().fold(circulatory + induced_drag + added_mass, |sum, load| sum + *load);
    StripLoads { circulatory: sum, profile_drag, ..StripLoads::default() }
}

impl Robot {
    /// As [`Plant::rates`](wingbeat_ocp::plant::Plant::rates), with the loads `beyond`.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn rates_beyond(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &BeyondLoads,
        dx: &mut [f64],
    ) -> Result<(), Fault> {
        self.evaluate(t, x, u, &beyond.links, dx, &mut Evaluation::empty())?;
        let air = self.layout.aero;
        self.yield_to(&beyond.bends, &x[air..], &mut dx[air..]);
        Ok(())
    }

    /// As [`observe`](Self::observe), under the loads `beyond` (N and N m): with them the loads of the surfaces but for the
    /// profile drag are one sum, written as circulatory. The observation takes `strips`, those of one before or
    /// [`Loads::boxed`], and writes over them.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn observe_beyond(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &BeyondLoads,
        strips: Box<Loads<f64>>,
    ) -> Result<Observation, Fault> {
        let ((), mut seen) = self.look((t, x, u), &beyond.links, strips, |_, _| ())?;
        seen.air = with_beyond(seen.air, &beyond.links);
        if !beyond.bends.is_empty() {
            self.see_yielding((t, x, u), beyond, &mut seen)?;
        }
        if !beyond.links.is_empty() {
            // The sum has neither suction nor vortex of its own.
            seen.detail = ForceDetail { plate: seen.detail.plate, ..ForceDetail::default() };
        }
        Ok(seen)
    }

    /// Number of loads that [`rates_beyond`](Self::rates_beyond) takes: the links and the body.
    pub fn bearers(&self) -> usize {
        self.mechanism.tree.links() + 1
    }

    /// Loads of the surfaces' own models but for the profile drag, as they are while the loads `beyond` act; of what bends, all that it bears
    /// but `beyond`.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn attached_loads(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &BeyondLoads,
    ) -> Result<BeyondLoads, Fault> {
        let mut dx = vec![0.0; x.len()];
        let (mut e, mut links) = (Evaluation::empty(), Links::new());
        let mut seen = Moving::still(&mut e, &mut links);
        self.moving((t, x, u), &beyond.links, &mut dx, &mut seen)?;
        let Moving { e, base, moving, wind: [wind, wind_dot], .. } = &seen;
        let still = Coordinates::none();
        let mut room = CarrierRoom::new();
        let mut carriers = Carriers::within(&mut room, &still);
        carriers.follow(base, &self.carriers, moving, [*wind_dot, self.gravity(e.attitude)]);
        carriers.ground = self.ground_below(e.attitude, x[self.layout.position + 2]);
        let aero = self.layout.aero;
        let mut loads = Loads::default();
        let mut motions = ArrayVec::new();
        self.covering.motions(&carriers, &mut motions);
        let (x, dx) = (&x[aero..], &mut dx[aero..]);
        self.covering.aero.evaluate_under(
            (carriers.ground, carriers.gravity, true),
            &motions,
            *wind,
            x,
            dx,
            &mut loads,
        );
        let bends = self.held_bends(&beyond.bends, x, dx);
        Ok(BeyondLoads { links: self.attached(&carriers, &loads), bends })
    }

    /// Places in the state of the flying robot of what bends the chords of its surfaces: heights of membranes and angles of flaps.
    pub fn bent_chords(&self) -> impl Iterator<Item = usize> {
        (0..self.covering.aero.surfaces().len()).flat_map(|k| self.bent_states_of(k))
    }

    /// Gives what bends under a momentum of its own, as flaps do, the loads of the end of a stretch of time, the second of `ends`, from its
    /// begin on: a load that goes straight over the stretch would swing. For a mode that the air beyond gives the mass M, the damping c
    /// and the stiffness k, none negative, and the robot a mass that moves evenly faster over a stretch of the length h, the roots l from
    /// stretch to stretch are with an even load those of `robot.held_load`, none of which lies outside the unit circle; without M the one
    /// is (c/h - k/2)/(c/h + k/2), so that what panels do not see rings where h exceeds 2 c/k. A swing at the rate w loses by w h/4 of the
    /// critical damping. With a straight load l solves M/h^2 (l + 1)(l - 1)^2/2 + c/h l (l + 1)(l - 1)/2 + k l (l^2 + 4 l + 1)/6 = 0,
    /// whose left side is k/3 at -1 and negative far below: one root lies outside.
    /// Membranes yield by their rates, for which straight loads have the roots of the first.
    ///
    /// Equation: robot.held_load
    /// `M/h^2 (l - 1)^2 + c/h l (l - 1) + k l (l + 1)/2 = 0`
    /// Source: own derivation: implicit Euler for the rates, their mean or constant acceleration for the angles.
    /// Test: `flaps_stay_still_on_any_panels`.
    pub fn hold_momenta(&self, [begin, end]: &mut [BeyondLoads; 2]) {
        let mut first = 0;
        for surface in self.covering.aero.surfaces() {
            let range = first..first + surface.aero().bent_states().len();
            first = range.end;
            if surface.aero().flap().is_some() && !begin.bends.is_empty() {
                begin.bends[range.clone()].copy_from_slice(&end.bends[range]);
            }
        }
    }

    /// Lets the chords yield to the loads `bends` on top of those of the strips' air: adds to the rates `dx` of the air in the state `x`.
    fn yield_to(&self, mut bends: &[f64], x: &[f64], dx: &mut [f64]) {
        if bends.is_empty() {
            return;
        }
        for surface in self.covering.aero.surfaces() {
            let Some(model) = surface.aero().bent() else { continue };
            let (own, rest) = bends.split_at(model.bent_states().len());
            model.yield_to(own, &x[surface.states()], &mut dx[surface.states()]);
            bends = rest;
        }
    }

    /// What chords in the state `x` of the air bear but the loads `bends`, while they yield to these; `dx` are the rates without them.
    fn held_bends(&self, bends: &[f64], x: &[f64], dx: &mut [f64]) -> Vec<f64> {
        self.yield_to(bends, x, dx);
        let (mut held, mut first) = (vec![0.0; self.bent_chords().count()], 0);
        for surface in self.covering.aero.surfaces() {
            let Some(model) = surface.aero().bent() else { continue };
            let (states, next) = (surface.states(), first + model.bent_states().len());
            model.bent_efforts(&x[states.clone()], &dx[states], &mut held[first..next]);
            first = next;
        }
        held.iter_mut().zip(bends).for_each(|(held, beyond)| *held -= beyond);
        held
    }

    /// How the chords are bent in the state `x` of the air with the rates `dx`, and how fast, in the order of [`bent_chords`](Self::bent_chords).
    pub(super) fn bends_of(&self, x: &[f64], dx: &[f64]) -> Vec<[f64; 2]> {
        let first = self.layout.aero;
        self.bent_chords().map(|place| [x[place - first], dx[place - first]]).collect()
    }

    /// Corrects what membranes get and lose in `seen`, which yield to the loads `beyond` too.
    fn see_yielding(
        &self,
        (t, x, u): (f64, &[f64], &[f64]),
        beyond: &BeyondLoads,
        seen: &mut Observation,
    ) -> Result<(), Fault> {
        let mut dx = vec![0.0; x.len()];
        self.rates_beyond(t, x, u, beyond, &mut dx)?;
        let (x, dx) = (&x[self.layout.aero..], &dx[self.layout.aero..]);
        let (mut given, mut lost) = (0.0, 0.0);
        for surface in self.covering.aero.surfaces() {
            let Some(model) = surface.aero().membrane() else { continue };
            let (x, dx) = (&x[surface.states()], &dx[surface.states()]);
            let still = vec![0.0; dx.len()];
            let mut efforts = [0, 1].map(|_| vec![0.0; model.bent_states().len()]);
            for (dx, efforts) in [dx, &still].into_iter().zip(&mut efforts) {
                model.bent_efforts(x, dx, efforts);
            }
            for ((rate, all), stored) in dx[model.bent_states()].iter().zip(&efforts[0]).zip(&efforts[1]) {
                given += all * rate;
                lost += (all - stored) * rate;
            }
        }
        if self.covering.aero.surfaces().iter().any(|surface| surface.aero().membrane().is_some()) {
            let work = &mut seen.strips.membrane;
            seen.air_power += given - work.given;
            seen.dissipation += lost - work.lost;
            (work.given, work.lost) = (given, lost);
        }
        Ok(())
    }

    /// `loads` of the strips but for the profile drag, on links and body.
    fn attached(&self, carriers: &Carriers<f64>, loads: &Loads<f64>) -> External<f64> {
        let strips = loads.strip[..loads.strips].iter();
        let attached: Vec<Wrench<f64>> =
            strips.map(|strip| strip.circulatory + strip.induced_drag + strip.added_mass).collect();
        let mut external = External::new();
        external.extend(std::iter::repeat_n(Wrench::ZERO, self.bearers()));
        self.covering.share(&self.covering.riding(carriers), &attached, &mut external);
        external
    }

    /// [`attached_loads`](Self::attached_loads) of a robot that is carried, as for [`carried`](Self::carried).
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn carried_attached_loads(
        &self,
        clock: &Jet,
        body: &BodyMotion,
        (x, u): (&[f64], &[f64]),
        beyond: &BeyondLoads,
    ) -> Result<BeyondLoads, Fault> {
        let (mut links, mut dx) = (External::new(), vec![0.0; x.len()]);
        let seen = |carriers: &Carriers<f64>, loads: &Loads<f64>| links = self.attached(carriers, loads);
        self.carry(clock, body, (x, u), &beyond.links, &mut dx, seen)?;
        let air = self.layout.aero - self.layout.structure;
        let bends = self.held_bends(&beyond.bends, &x[air..], &mut dx[air..]);
        Ok(BeyondLoads { links, bends })
    }

    /// As [`carried`](Self::carried), under the loads `beyond` as [`rates_beyond`](Self::rates_beyond) takes them: with them the loads
    /// of the surfaces but for the profile drag are one sum, written as circulatory.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn carried_beyond(
        &self,
        clock: &Jet,
        body: &BodyMotion,
        (x, u): (&[f64], &[f64]),
        beyond: &BeyondLoads,
        dx: &mut [f64],
    ) -> Result<CarriedLoads, Fault> {
        let mut loads = self.carry(clock, body, (x, u), &beyond.links, dx, |_, _| ())?;
        loads.air = with_beyond(loads.air, &beyond.links);
        let air = self.layout.aero - self.layout.structure;
        self.yield_to(&beyond.bends, &x[air..], &mut dx[air..]);
        Ok(loads)
    }

    /// Adds to `external`, the loads on links and body of a robot as it is `at`, what these bear of loads on strips of the
    /// surface number `surface` between the arc coordinates `arcs` (m), which are about the body origin, in B.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    ///
    /// # Panics
    /// When there is no such surface.
    pub fn bear(
        &self,
        at: &Stance,
        (surface, arcs): (usize, &[f64]),
        strips: &[Wrench<f64>],
        external: &mut [Wrench<f64>],
    ) -> Result<(), Fault> {
        let body = external.len() - 1;
        self.riding_at(at, surface, arcs, |riding| {
            for (j, load) in strips.iter().enumerate() {
                let links = [j, j + 1].map(|i| riding.sections[i].link);
                let web = [j, j + 1].iter().any(|i| riding.is_web(*i));
                if links[0] == links[1] && !web {
                    external[links[0].unwrap_or(body)] += *load;
                    continue;
                }
                let middle = 0.5 * (arcs[j] + arcs[j + 1]);
                let own = self.covering.laid[surface].placement.section(middle, &self.carriers).link;
                between_edges(riding, ([j, j + 1], 0.5), own, load, &mut |link, load| {
                    external[link.unwrap_or(body)] += load;
                });
            }
        })
    }
}

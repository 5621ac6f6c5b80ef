//! The robot under loads on its links that come from beyond its own model of the air.

use super::dynamics::Evaluation;
use super::observe::{Moving, Observation};
use super::sections::Carriers;
use super::surface::{External, between_edges};
use super::{BodyMotion, CarriedLoads, Links, Robot, Stance};
use crate::body::Coordinates;
use arrayvec::ArrayVec;
use wingbeat_aero::{ForceDetail, Loads, StripLoads};
use wingbeat_math::{Jet, Wrench};
use wingbeat_ocp::plant::Fault;

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
    /// As [`Plant::rates`](wingbeat_ocp::plant::Plant::rates), with the loads `beyond` (N and N m) on the links in the order of
    /// the tree, the body last, about the body origin, in B; none, or one for each.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn rates_beyond(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &[Wrench<f64>],
        dx: &mut [f64],
    ) -> Result<(), Fault> {
        self.evaluate(t, x, u, beyond, dx, &mut Evaluation::empty())
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
        beyond: &[Wrench<f64>],
        strips: Box<Loads<f64>>,
    ) -> Result<Observation, Fault> {
        let ((), mut seen) = self.look((t, x, u), beyond, strips, |_, _| ())?;
        seen.air = with_beyond(seen.air, beyond);
        if !beyond.is_empty() {
            // The sum has neither suction nor vortex of its own.
            seen.detail = ForceDetail { plate: seen.detail.plate, ..ForceDetail::default() };
        }
        Ok(seen)
    }

    /// Number of loads that [`rates_beyond`](Self::rates_beyond) takes: the links and the body.
    pub fn bearers(&self) -> usize {
        self.mechanism.tree.links() + 1
    }

    /// Loads of the surfaces' own models but for the profile drag, as they are while the loads `beyond` act, on links and body:
    /// N and N m about the body origin, in B.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn attached_loads(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &[Wrench<f64>],
    ) -> Result<Vec<Wrench<f64>>, Fault> {
        let mut dx = vec![0.0; x.len()];
        let (mut e, mut links) = (Evaluation::empty(), Links::new());
        let mut seen = Moving::still(&mut e, &mut links);
        self.moving((t, x, u), beyond, &mut dx, &mut seen)?;
        let Moving { e, base, moving, wind: [wind, wind_dot], .. } = &seen;
        let still = Coordinates::none();
        let mut carriers = Carriers::none(&still);
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
        Ok(self.attached(&carriers, &loads))
    }

    /// `loads` of the strips but for the profile drag, on links and body.
    fn attached(&self, carriers: &Carriers<f64>, loads: &Loads<f64>) -> Vec<Wrench<f64>> {
        let strips = loads.strip[..loads.strips].iter();
        let attached: Vec<Wrench<f64>> =
            strips.map(|strip| strip.circulatory + strip.induced_drag + strip.added_mass).collect();
        let mut external = External::new();
        external.extend(std::iter::repeat_n(Wrench::ZERO, self.bearers()));
        self.covering.share(&self.covering.riding(carriers), &attached, &mut external);
        external.to_vec()
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
        beyond: &[Wrench<f64>],
    ) -> Result<Vec<Wrench<f64>>, Fault> {
        let mut attached = Vec::new();
        let seen = |carriers: &Carriers<f64>, loads: &Loads<f64>| attached = self.attached(carriers, loads);
        self.carry(clock, body, (x, u), beyond, &mut vec![0.0; x.len()], seen)?;
        Ok(attached)
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
        beyond: &[Wrench<f64>],
        dx: &mut [f64],
    ) -> Result<CarriedLoads, Fault> {
        let mut loads = self.carry(clock, body, (x, u), beyond, dx, |_, _| ())?;
        loads.air = with_beyond(loads.air, beyond);
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
                if links[0] == links[1] {
                    external[links[0].unwrap_or(body)] += *load;
                    continue;
                }
                let middle = 0.5 * (arcs[j] + arcs[j + 1]);
                let own = self.covering.laid[surface].placement.section(middle, &self.carriers).link;
                let (shares, rest) = between_edges(&[riding.at(j), riding.at(j + 1)], 0.5, load);
                for (link, load) in links.into_iter().zip(shares) {
                    external[link.unwrap_or(body)] += load;
                }
                external[own.unwrap_or(body)] += Wrench::couple(rest);
            }
        })
    }
}

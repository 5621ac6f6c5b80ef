//! The robot under loads on its links that come from beyond its own model of the air.

use super::drive::Ratios;
use super::dynamics::Evaluation;
use super::observe::{Moving, Observation};
use super::sections::{Carriers, Riding, Section};
use super::surface::{External, between_edges};
use super::{Joints, Links, Robot};
use crate::aero::{Loads, StripLoads};
use crate::body::{Coordinates, LinkMotion};
use crate::math::{Jet, Mat3, Quat, Vec3, Wrench};
use crate::plant::Fault;

impl Robot {
    /// As [`Plant::rates`](crate::plant::Plant::rates), with the loads `beyond` on the links in the order of the tree, the body
    /// last, about the body origin, in B; none, or one for each.
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

    /// As [`observe`](Self::observe), under the loads `beyond`: with them the loads of the surfaces but for the profile drag are one
    /// sum, written as circulatory.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn observe_beyond(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &[Wrench<f64>],
    ) -> Result<Observation, Fault> {
        let mut seen = self.look(t, x, u, beyond)?;
        if !beyond.is_empty() {
            let StripLoads { circulatory, induced_drag, added_mass, profile_drag } = seen.air;
            let sum = beyond.iter().fold(circulatory + induced_drag + added_mass, |sum, load| sum + *load);
            seen.air = StripLoads { circulatory: sum, profile_drag, ..StripLoads::default() };
        }
        Ok(seen)
    }

    /// Number of loads that [`rates_beyond`](Self::rates_beyond) takes: the links and the body.
    pub fn bearers(&self) -> usize {
        self.mechanism.tree.links() + 1
    }

    /// Loads of the surfaces' own models but for the profile drag, as they are while the loads `beyond` act, on links and body.
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
        let Moving { base, moving, wind: [wind, wind_dot], .. } = self.moving((t, x, u), beyond, &mut dx)?;
        let still = Coordinates::none();
        let mut carriers = Carriers::none(&still);
        carriers.follow(&base, &self.carriers, &moving, wind_dot);
        let (aero, covering) = (self.layout.aero, &self.covering);
        let mut loads = Loads::default();
        let motions = covering.motions(&carriers);
        covering.aero.evaluate(&motions, wind, &x[aero..], &mut dx[aero..], &mut loads);
        let attached: Vec<Wrench<f64>> = loads.strip[..loads.strips]
            .iter()
            .map(|strip| strip.circulatory + strip.induced_drag + strip.added_mass)
            .collect();
        let mut external = External::new();
        external.extend(std::iter::repeat_n(Wrench::ZERO, self.bearers()));
        covering.share(&covering.riding(&carriers), &attached, &mut external);
        Ok(external.to_vec())
    }

    /// Adds to `external`, the loads on links and body, what these bear of loads on strips of the surface number `surface`
    /// between the arc coordinates `arcs` (m), which are about the body origin, in B.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    ///
    /// # Panics
    /// When there is no such surface.
    pub fn bear(
        &self,
        t: f64,
        x: &[f64],
        (surface, arcs): (usize, &[f64]),
        strips: &[Wrench<f64>],
        external: &mut [Wrench<f64>],
    ) -> Result<(), Fault> {
        let body = external.len() - 1;
        self.riding_at(t, x, surface, arcs, |riding, _| {
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

    /// `then` with the sections of the surface number `surface` at the arc coordinates `arcs`, riding on links whose accelerations
    /// are left out, and with the attitude.
    pub(super) fn riding_at<T>(
        &self,
        t: f64,
        x: &[f64],
        surface: usize,
        arcs: &[f64],
        then: impl FnOnce(&Riding<f64, f64>, Mat3) -> T,
    ) -> Result<T, Fault> {
        let l = &self.layout;
        let attitude = Quat::from_wxyz(&x[l.attitude..]).matrix();
        let velocity = attitude.transpose_mul(Vec3::from_slice(&x[l.velocity..]));
        let rate = Vec3::from_slice(&x[l.rate..]);
        let structure = &x[l.structure..];
        let inputs = vec![0.0; self.inputs.len()];
        let mut rates = vec![0.0; l.joints - l.structure];
        let (mut joints, mut ratios) = (Joints::new(), Ratios::new());
        self.joints(&Jet::new(t, 1.0, 0.0), structure, &inputs, &mut rates, &mut joints, &mut ratios)?;
        let mut links = Links::new();
        self.links(&joints, velocity, rate, &mut links);
        let base = LinkMotion::base(velocity, rate);
        let still = Coordinates::none();
        let mut carriers = Carriers::none(&still);
        carriers.follow(&base, &self.carriers, &links, Vec3::ZERO);
        let placement = &self.covering.laid[surface].placement;
        let sections: Vec<Section> = arcs.iter().map(|s| placement.section(*s, &self.carriers)).collect();
        Ok(then(&Riding { sections: &sections, carriers: &carriers }, attitude))
    }
}

//! What a robot's numbers have to fulfil, whoever gave them.

use super::Robot;
use super::numbers::{Numbers, StopNumbers};
use super::placement::PanelNumbers;
use wingbeat_math::Error;
use wingbeat_math::require::{positive, principal_inertias};
use wingbeat_math::{NamedNumber, Parameters};

impl Robot {
    /// Refuses numbers that no robot has; keys of errors are their names.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub(super) fn check_numbers(&self, numbers: &Numbers) -> Result<(), Error> {
        numbers.named(&self.labels()).iter().try_for_each(NamedNumber::check)?;
        self.check_bodies(numbers)?;
        self.check_stops(numbers)?;
        self.check_surfaces(numbers)
    }

    /// Each body has principal inertias that a body can have, and the central one a mass.
    fn check_bodies(&self, numbers: &Numbers) -> Result<(), Error> {
        positive("body.mass_kg", numbers.bodies[0].mass)?;
        let mut bodies = self.body_names().zip(&numbers.bodies);
        bodies.try_for_each(|(name, body)| {
            principal_inertias("inertia_kg_m2", body.moments.0).map_err(|e| e.within(&name))
        })
    }

    /// The lower stop of a joint lies below the upper one.
    fn check_stops(&self, numbers: &Numbers) -> Result<(), Error> {
        let springs = self.mechanism.coordinates.iter().zip(&numbers.springs);
        for (&joint, spring) in springs {
            let Some(StopNumbers { low, high, .. }) = spring.stops else { continue };
            if !(low < high) {
                let key = |end: &str| format!("links.{}.elastic.stops.{end}", self.tree().name(joint));
                let error = Error::invalid(key("low"), low, format!("less than stops.high = {high}"));
                return Err(error.against([key("high")]));
            }
        }
        Ok(())
    }

    /// Outlines have a chord everywhere, and panels follow one another from the root to the tip.
    fn check_surfaces(&self, numbers: &Numbers) -> Result<(), Error> {
        let laid = self.covering.laid.iter();
        for ((laid, surface), placement) in laid.zip(&numbers.surfaces).zip(&numbers.placements) {
            let within = |e: Error| e.within(&format!("surfaces.{}", laid.name));
            let outline = surface.outline.as_ref().unwrap_or(&laid.placement.planform);
            outline.check().map_err(within)?;
            let tip = outline.station_arcs().last().copied().unwrap_or_default();
            let panels = placement.panels.iter().enumerate();
            let key = |i: usize| {
                let label = laid.panel(i);
                label.map_or_else(|| format!("panels[{i}]"), |name| format!("panels.{name}"))
            };
            panels
                .map(|(i, panel)| {
                    let from = |i: usize| placement.panels.get(i).map(|panel| panel.from_arc);
                    let pieces = placement.panels[i + 1..].iter().take_while(|panel| panel.piece).count();
                    (i, panel, i.checked_sub(1).and_then(from), from(i + 1 + pieces))
                })
                .try_for_each(|(i, panel, before, next)| {
                    panel.check([before, next], tip).map_err(|e| e.within(&key(i)))
                })
                .map_err(within)?;
        }
        Ok(())
    }
}

impl PanelNumbers {
    /// Refuses a panel that does not follow the one that begins at the arc length `before`, or that begins beyond the `tip`, one whose web
    /// is longer than it is up to the `next`, and one without a direction across x.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub(super) fn check(&self, [before, next]: [Option<f64>; 2], tip: f64) -> Result<(), Error> {
        let (from, [x, y, z]) = (self.from_arc, self.direction.0);
        if !(before.map_or(from == 0.0, |before| from > before) && from < tip) {
            let allowed = before.map_or("0: the root".into(), |b| format!("more than {b}, less than {tip}"));
            return Err(Error::invalid("from_arc_m", from, allowed));
        }
        let room = before.map_or(0.0, |_| next.unwrap_or(tip) - from);
        if !(self.web == 0.0 || (self.web > 0.0 && self.web < room)) {
            let allowed = format!("0, or less than the panel's length {room}; 0 of the first");
            return Err(Error::invalid("web_m", self.web, allowed));
        }
        if x != 0.0 || !(y * y + z * z > 0.0) {
            let allowed = "a direction across x: [0, y, z]";
            let error = Error::invalid("direction", format!("{:?}", self.direction.0), allowed);
            return Err(error.against([0, 1, 2].map(|i| format!("direction[{i}]"))));
        }
        Ok(())
    }
}

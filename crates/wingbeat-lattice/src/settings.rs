//! What a lattice is stepped with.

use crate::Error;

/// Lamb's constant: the core of a laminar line vortex, the radius of largest speed, grows as sqrt(4 a nu t).
const LAMB: f64 = 1.25643;

/// Core of the sheets that leave the leading edges, mean chords. *Choice*: with half of it lift is the same to 3 % until a sheet meets
/// the wing, and noisy thereafter.
pub(crate) const SHEET_CORE: f64 = 0.1;

/// Most of a core where wings feel it, over the way along the wake from the trailing edge. *Choice*: it takes 1 % at most of what a vortex
/// does at control points before it, and 0.2 % of the lift of a plate in plunge. What lies over the wing, as where air comes in over the
/// edge, has wider ones ([`OVER`]).
pub(crate) const CLOSE: f64 = 0.1;
/// Most of such a core over how far it lies over the wing. *Choice*: without it loads are noise where air comes in over the edge, and steeper ones
/// let steps that are tried for a robot jump.
pub(crate) const OVER: f64 = 8.0;

/// How vortices of the wake are rounded off: rc^2 = radius^2 + 4 a (nu + squire |Gamma|) age.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Core {
    /// At the trailing edge, m.
    pub radius_m: f64,
    /// Kinematic viscosity nu of the air, m2/s.
    pub viscosity_m2_s: f64,
    /// Share of the circulation, after Squire, in the viscosity of a turbulent core.
    pub squire: f64,
}

impl Core {
    /// Squared radius, m2, `age` s after shedding, of a vortex of the circulation `strength`, m2/s.
    ///
    /// Equation: lattice.core_growth
    /// `rc^2 = r0^2 + 4 a (nu + a1 abs(Gamma)) age, a = 1.25643`
    /// Source: Lamb 1932; Squire 1965, Aeronaut. Q. 16.
    /// Test: `cores_grow_as_lamb_and_squire_say`.
    pub fn square(&self, age: f64, strength: f64) -> f64 {
        let viscosity = self.viscosity_m2_s + self.squire * strength.abs();
        self.radius_m * self.radius_m + 4.0 * LAMB * viscosity * age.max(0.0)
    }
}

/// How the wake moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WakeMotion {
    /// With the wind alone.
    #[default]
    Prescribed,
    /// With the local velocity of the air.
    Free,
}

/// Whose conventions are followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Conventions {
    /// Bound vortices without cores, exact velocities of the wing, rates and wake of second order.
    #[default]
    Own,
    /// Those of PteraSoftware 5.1.0: the core of the wake on bound vortices too, velocities and rates by backward differences,
    /// Euler steps of the wake, the rate of every ring over its whole panel, forces on the ends of the last rings.
    PteraSoftware,
}

/// What a lattice is stepped with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeSettings {
    /// Step, s. The wake resolves best when the way of a step is a panel's chord.
    pub step_s: f64,
    /// How the wake moves.
    pub wake: WakeMotion,
    /// Rounding of the wake's vortices.
    pub core: Core,
    /// Age at which the wake ends, s.
    pub longest_age_s: f64,
    /// Distance behind the trailing edge at which the wake ends, m.
    pub longest_distance_m: f64,
    /// Whose conventions are followed.
    pub conventions: Conventions,
    /// Where parts of a wing pass through each other: radius of the cores that bound vortices have there, over the distance along the
    /// arc beyond a mean chord; 0 for none.
    pub crossing: f64,
    /// Segments of a wake from which its velocities are summed by multipoles.
    pub fast_from: usize,
    /// Largest suction parameter of the leading edge, dimensionless: what is above is shed there. None for attached flow.
    pub critical_suction: Option<f64>,
    /// Radius of the cores of the sheets that leave the leading edges, m; where these feel bound vortices, of those too.
    pub sheet_core_m: f64,
}

impl LatticeSettings {
    /// Steps of `step_s` s with a prescribed wake without end, whose vortices have cores of `core_m` m.
    pub fn new(step_s: f64, core_m: f64) -> Self {
        Self {
            step_s,
            wake: WakeMotion::Prescribed,
            core: Core { radius_m: core_m, viscosity_m2_s: 0.0, squire: 0.0 },
            longest_age_s: f64::INFINITY,
            longest_distance_m: f64::INFINITY,
            conventions: Conventions::Own,
            crossing: 0.0,
            fast_from: usize::MAX,
            critical_suction: None,
            sheet_core_m: core_m,
        }
    }

    /// The same with PteraSoftware's conventions on a wing of the mean chord `chord_m`: cores of 3 % of the chord that grow in air of
    /// the viscosity `viscosity_m2_s` by Squire's 1e-4.
    pub fn like_pterasoftware(self, chord_m: f64, viscosity_m2_s: f64) -> Self {
        let core = Core { radius_m: 0.03 * chord_m, viscosity_m2_s, squire: 1e-4 };
        Self { core, conventions: Conventions::PteraSoftware, ..self }
    }

    /// How vortices of the sheets that leave the leading edges are rounded off.
    pub(crate) fn sheet_core(&self) -> Core {
        Core { radius_m: self.sheet_core_m, ..self.core }
    }

    /// The same with leading edges of a wing of the mean chord `chord_m` that bear suction up to `critical_suction`, where it is given.
    pub(crate) fn shedding(self, critical_suction: Option<f64>, chord_m: f64) -> Self {
        Self { critical_suction, sheet_core_m: SHEET_CORE * chord_m, ..self }
    }

    /// Whether another program's conventions are followed.
    pub(crate) fn emulates(&self) -> bool {
        self.conventions == Conventions::PteraSoftware
    }

    /// Refuses what cannot be stepped.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let positive = [
            ("step_s", self.step_s, self.step_s.is_finite()),
            ("core.radius_m", self.core.radius_m, self.core.radius_m.is_finite()),
            ("sheet_core_m", self.sheet_core_m, self.sheet_core_m.is_finite()),
            ("longest_age_s", self.longest_age_s, true),
            ("longest_distance_m", self.longest_distance_m, true),
        ];
        for (key, value, bounded) in positive {
            if !(value > 0.0 && bounded) {
                return Err(Error::Setting { key, value, allowed: "above 0".into() });
            }
        }
        for (key, value) in [
            ("core.viscosity_m2_s", self.core.viscosity_m2_s),
            ("core.squire", self.core.squire),
            ("crossing", self.crossing),
            ("critical_suction", self.critical_suction.unwrap_or(0.0)),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Setting { key, value, allowed: "0 or more".into() });
            }
        }
        match self.critical_suction.filter(|_| self.emulates()) {
            Some(value) => {
                let allowed = "none with PteraSoftware's conventions".into();
                Err(Error::Setting { key: "critical_suction", value, allowed })
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cores_grow_as_lamb_and_squire_say() {
        let core = Core { radius_m: 3e-3, viscosity_m2_s: 1.5e-5, squire: 1e-4 };
        assert_eq!(core.square(0.0, 5.0), 9e-6);
        // The speed of Lamb's vortex, (1 - exp(-r^2/(4 nu t)))/r, is largest where exp(x) = 1 + 2 x, x = r^2/(4 nu t).
        assert!((LAMB.exp() - 1.0 - 2.0 * LAMB).abs() < 1e-4);
        let grown = core.square(2.0, -0.1) - 9e-6;
        assert!((grown - 4.0 * LAMB * 2.5e-5 * 2.0).abs() < 1e-15);
    }
}

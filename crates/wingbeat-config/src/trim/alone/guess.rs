//! Where the search for a robot's flight begins: scaling laws.

use crate::{ConfigError, Scenario};
use wingbeat_judge::limits::trim;
use wingbeat_math::{Error, GRAVITY};
use wingbeat_robot::Outline;

/// Lift coefficient of the speed to begin from. *Choice*: well below stall.
const LIFT: f64 = 0.6;
/// Room that the wings are to keep, as a share of the span, and of what they have as the gait starts. *Choices*: a bank takes about
/// 20 mm of a span of .4 m.
const ROOM: [f64; 2] = [0.05, 0.7];

/// What the laws take.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// kg.
    pub mass: f64,
    /// Full span of the widest surface, m.
    pub span: f64,
    /// Area of all surfaces as seen from above, m2.
    pub area: f64,
    /// That of the largest surface, m2.
    pub wing: f64,
    /// kg/m3.
    pub density: f64,
    /// Clearance that the wings are to keep, m.
    pub room: f64,
}

impl Size {
    /// Speed at which the area carries the weight, m/s.
    ///
    /// Equation: trim.guess_speed
    /// `sqrt(2 m g / (rho S C_L)), C_L = .6`
    /// Source: definition of the lift coefficient; the coefficient is a choice.
    /// Test: `a_guess_follows_the_scaling_laws`.
    pub fn speed(&self) -> f64 {
        (2.0 * self.mass * GRAVITY / (self.density * self.area * LIFT)).sqrt()
    }

    /// Frequency at which birds of this size cruise, Hz; S is the area of the largest surface.
    ///
    /// Equation: trim.guess_frequency
    /// `m^(3/8) g^(1/2) b^(-23/24) S^(-1/3) rho^(-3/8)`
    /// Source: Pennycuick 1996, J. Exp. Biol. 199, 1613.
    /// Test: `a_guess_follows_the_scaling_laws`.
    pub fn frequency(&self) -> f64 {
        self.mass.powf(0.375)
            * GRAVITY.sqrt()
            * self.span.powf(-23.0 / 24.0)
            * self.wing.powf(-1.0 / 3.0)
            * self.density.powf(-0.375)
    }
}

/// Area of an outline between its ribs as seen from above, m2: half of the cross product of the diagonals of each quadrilateral, of which
/// a fin has none.
fn area(outline: &Outline) -> f64 {
    let covered = outline.ribs.windows(2).zip(&outline.covered).filter(|(_, covered)| **covered);
    covered.map(|(ribs, _)| 0.5 * (ribs[1][1] - ribs[0][0]).cross(ribs[1][0] - ribs[0][1])[2].abs()).sum()
}

impl Scenario {
    /// What scaling laws take of the robot, its wings as its gait starts.
    pub(super) fn size(&self) -> Result<Size, Error> {
        let still = self.model.at_rest(0.0);
        let still = still.map_err(|fault| Error::invalid("robot", fault, "a robot that can be evaluated"))?;
        let areas: Vec<f64> = still.outlines.iter().map(area).collect();
        let (area, wing) = (areas.iter().sum::<f64>(), areas.iter().copied().fold(0.0, f64::max));
        let widest = still.outlines.iter().map(|outline| {
            let tips = outline.ribs.iter().map(|rib| rib[0][1]);
            tips.clone().fold(0.0, f64::max) - tips.fold(0.0, f64::min)
        });
        let span = widest.fold(0.0, f64::max);
        if !(area > 0.0 && span > 0.0) {
            return Err(Error::invalid("robot.surfaces", "no area", "a surface that carries"));
        }
        let seen = self.model.observe(0.0, &self.start_of(&self.model), &self.held_commands());
        let least =
            seen.map_or(f64::INFINITY, |seen| seen.clearances.iter().copied().fold(f64::INFINITY, f64::min));
        let room = (ROOM[0] * span).min(ROOM[1] * least).max(trim::SKIN.value);
        Ok(Size { mass: self.model.mass(), span, area, wing, density: self.spec.air.density_kg_m3, room })
    }

    /// Speed at which all surfaces of the robot carry its weight at a lift coefficient of .6, m/s.
    ///
    /// # Errors
    /// A robot without surfaces.
    pub fn guessed_speed(&self) -> Result<f64, ConfigError> {
        Ok(self.size().map_err(|error| self.explain(&error))?.speed())
    }
}

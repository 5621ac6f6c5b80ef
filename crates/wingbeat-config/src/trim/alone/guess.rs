//! Where the search for a robot's flight begins: scaling laws.

use wingbeat_math::GRAVITY;

/// Lift coefficient of the speed to begin from. *Choice*: well below stall.
const LIFT: f64 = 0.6;

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

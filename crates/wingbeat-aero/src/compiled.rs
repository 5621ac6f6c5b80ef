//! The models in the numbers that other crates ask for, compiled once and here: a crate that calls generic code compiles a
//! copy of its own.

use super::{Aero, Loads, SectionMotion, Surfaces};
use wingbeat_math::Vec3;
use wingbeat_ocp::plant::Early;

impl Aero {
    /// [`evaluate`](Self::evaluate) in plain numbers.
    ///
    /// # Panics
    /// As `evaluate`.
    pub fn evaluate_in_numbers(
        &self,
        sections: &[SectionMotion<f64>],
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
        loads: &mut Loads<f64>,
    ) {
        self.evaluate(sections, wind, x, dx, loads);
    }

    /// [`evaluate`](Self::evaluate) with the derivatives that one pass of a [`Linearisation`](wingbeat_ocp::plant::Linearisation)
    /// carries.
    ///
    /// # Panics
    /// As `evaluate`.
    pub fn evaluate_in_early(
        &self,
        sections: &[SectionMotion<Early>],
        wind: Vec3<Early>,
        x: &[Early],
        dx: &mut [Early],
        loads: &mut Loads<Early>,
    ) {
        self.evaluate(sections, wind, x, dx, loads);
    }
}

impl Surfaces {
    /// [`evaluate`](Self::evaluate) in plain numbers.
    ///
    /// # Panics
    /// As `evaluate`.
    pub fn evaluate_in_numbers(
        &self,
        sections: &[SectionMotion<f64>],
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
        loads: &mut Loads<f64>,
    ) {
        self.evaluate(sections, wind, x, dx, loads);
    }
}

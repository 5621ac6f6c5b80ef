//! The models in the numbers that other crates ask for, compiled once and here: a crate that calls generic code compiles a
//! copy of its own.

use super::{Aero, Loads, SectionMotion, StripModel, SurfaceNumbers, Surfaces};
use wingbeat_math::{Dual, Error, Vec3, Wrench};
use wingbeat_ocp::plant::{Channel, Early};

/// Surfaces with other numbers of theirs, and one surface.
type WithNumbers<Q> = (
    fn(&Surfaces, &[SurfaceNumbers<Q>]) -> Result<Surfaces<Q>, Error>,
    fn(&Aero, &SurfaceNumbers<Q>) -> Result<Aero<Q>, Error>,
    fn(&Surfaces<Q>) -> Vec<Channel>,
);

/// What other crates build models by: named here, it is compiled here, where it is not inlined.
#[used]
static BUILDS: (WithNumbers<f64>, WithNumbers<Dual<4>>) =
    ((Surfaces::with, Aero::with, Surfaces::channels), (Surfaces::with, Aero::with, Surfaces::channels));

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

    /// The rates alone, as [`evaluate_sum`](Self::evaluate_sum) finds them, in plain numbers.
    ///
    /// # Panics
    /// As `evaluate_sum`.
    pub fn rates_in_numbers(&self, sections: &[SectionMotion<f64>], wind: Vec3, x: &[f64], dx: &mut [f64]) {
        self.evaluate_sum(&sections, wind, x, dx, None);
    }

    /// [`evaluate_sum`](Self::evaluate_sum) in plain numbers, without the coupling of accelerations.
    ///
    /// # Panics
    /// As `evaluate_sum`.
    pub fn sum_in_numbers(
        &self,
        sections: &[SectionMotion<f64>],
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
    ) -> (Wrench<f64>, [[f64; 6]; 6]) {
        self.evaluate_sum(&sections, wind, x, dx, None)
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

impl Aero<Dual<4>> {
    /// [`evaluate`](Self::evaluate) with the derivatives by four numbers of the model.
    ///
    /// # Panics
    /// As `evaluate`.
    pub fn evaluate_in_varying(
        &self,
        sections: &[SectionMotion<Dual<4>>],
        wind: Vec3<Dual<4>>,
        x: &[Dual<4>],
        dx: &mut [Dual<4>],
        loads: &mut Loads<Dual<4>>,
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

    /// [`evaluate_sum`](Self::evaluate_sum) in plain numbers, without the coupling of accelerations.
    ///
    /// # Panics
    /// As `evaluate_sum`.
    pub fn sum_in_numbers(
        &self,
        sections: &[SectionMotion<f64>],
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
    ) -> (Wrench<f64>, [[f64; 6]; 6]) {
        self.evaluate_sum(&sections, wind, x, dx, None)
    }
}

impl StripModel {
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

    /// [`evaluate_sum`](Self::evaluate_sum) in plain numbers, without the coupling of accelerations.
    ///
    /// # Panics
    /// As `evaluate_sum`.
    pub fn sum_in_numbers(
        &self,
        sections: &[SectionMotion<f64>],
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
    ) -> (Wrench<f64>, [[f64; 6]; 6]) {
        self.evaluate_sum(&sections, wind, x, dx, None)
    }
}

//! Membranes and flaps under loads from beyond the strips' own air: what they bear, and how they yield to it.

use super::StripModel;
use super::membrane::MODES;

/// Share of the mass of the first shape that stands for that of each, by the mean squares of the shapes.
const MASS: [f64; MODES] = [1.0, 1.0 / 7.0];

/// The skin of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinSheet {
    /// Mass over area, kg/m2.
    pub areal_density: f64,
    /// Share of the chord from which on it moves against the chord, dimensionless.
    pub from: f64,
}

impl StripModel {
    /// The skin that moves against the chord, where [`bends`](Self::bends) says that one does; none of a rigid surface.
    pub fn sheet(&self) -> Option<SkinSheet> {
        if let Some(membrane) = &self.membrane {
            return Some(SkinSheet { areal_density: membrane.areal_density, from: 0.0 });
        }
        let areal_density = self.numbers.flap.as_ref()?.areal_density;
        Some(SkinSheet { areal_density, from: 1.0 - self.settings.flap?.chord_fraction })
    }

    /// Whether the bent state number `k`, as [`bent_states`](Self::bent_states) has them, is free: strips beside a flap are not.
    pub fn bends(&self, k: usize) -> bool {
        self.hinges.as_ref().is_none_or(|hinges| hinges.has(k))
    }

    /// Writes to `efforts` what springs, tensions and their damping bear in the state `x` with the rates `dx`, in the order of the bent states: N m by
    /// the heights over the chord and the angles. Of a membrane dU/dh + tau K h', U what it stores and h' tau K h' what it loses.
    ///
    /// Equation: aero.bent_efforts
    /// `dU/dh + (1/2) dD/dh', U = aero.membrane.stored, D = h' tau K h'; of a flap k (beta - beta_0) + k tau beta'`
    /// Source: virtual work.
    /// Test: `a_membrane_bears_the_slope_of_its_energy_and_a_flap_its_spring`.
    pub fn bent_efforts(&self, x: &[f64], dx: &[f64], efforts: &mut [f64]) {
        let (n, places) = (self.settings.strips, self.bent_states());
        let (values, rates) = (&x[places.clone()], &dx[places]);
        let Some(membrane) = &self.membrane else {
            for (k, effort) in efforts.iter_mut().enumerate() {
                let [bent, damped] = self.hinge_spring(k, values[k], rates[k]);
                *effort = if self.bends(k) { bent + damped } else { 0.0 };
            }
            return;
        };
        membrane.efforts(Self::shapes(values, n), Self::shapes(rates, n), |[m, i], [stored, lost, _]| {
            efforts[m * n + i] = stored + lost;
        });
    }

    /// Both shapes in `of`, those of `n` strips.
    fn shapes(of: &[f64], n: usize) -> [&[f64]; MODES] {
        std::array::from_fn(|m| &of[m * n..][..n])
    }

    /// Lets membranes and flaps yield to `loads`, N m in the order of the bent states, which come on top of those of the strips' own air: adds
    /// to the rates `dx` in the state `x`. A flap's momentum takes them whole; a membrane yields against its own damping and, within that
    /// time, against the mass that its parabola feels.
    ///
    /// Equation: aero.bent_yield
    /// `h' += Q/(tau K_ii + mu_i/tau), mu of the parabola as in aero.camber_mass, of the second shape a seventh; p' += Q of a flap`
    /// Source: choice: what a coupling with other air yields by does not enter what it comes to.
    /// Test: `a_membrane_bears_the_slope_of_its_energy_and_a_flap_its_spring`.
    pub fn yield_to(&self, loads: &[f64], x: &[f64], dx: &mut [f64]) {
        let (n, places) = (self.settings.strips, self.bent_states());
        let Some(membrane) = &self.membrane else {
            for (k, load) in loads.iter().enumerate().filter(|(k, _)| self.bends(*k)) {
                dx[places.start + n + k] += load;
            }
            return;
        };
        let heights = Self::shapes(&x[places.clone()], n);
        membrane.efforts(heights, heights, |[m, i], [_, _, damped]| {
            let chord = self.tables.chord[i];
            let mass = self.camber_mass(i, membrane) * MASS[m] * chord * chord;
            dx[places.start + m * n + i] += loads[m * n + i] / (damped + mass / membrane.damping);
        });
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        FlapSpec, Loads, MembraneSpec, Planform, PlanformStation, SectionMotion, StripModel, StripSettings,
    };
    use wingbeat_math::Vec3;

    /// A wing of 1 m chord and 10 m span on four strips, with `settings` besides.
    fn wing(settings: StripSettings) -> StripModel {
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
        let settings = StripSettings { strips: 4, ..settings };
        StripModel::new(&Planform::new(&[station(0.0), station(5.0)]).unwrap(), settings).unwrap()
    }

    /// What the wing stores at rest with its bent states at `values`, J.
    fn stored(model: &StripModel, values: &[f64]) -> f64 {
        let section = |y: &f64| SectionMotion {
            le: Vec3([0.5, *y, 0.0]),
            te: Vec3([-0.5, *y, 0.0]),
            span: Vec3([0.0, -1.0, 0.0]),
            ..Default::default()
        };
        let sections: Vec<_> = model.arcs().iter().map(section).collect();
        let (mut x, mut loads) = (vec![0.0; model.states()], Loads::default());
        x[model.bent_states()].copy_from_slice(values);
        model.evaluate(&sections, Vec3::ZERO, &x, &mut vec![0.0; model.states()], &mut loads);
        loads.membrane.stored
    }

    #[test]
    fn a_membrane_bears_the_slope_of_its_energy_and_a_flap_its_spring() {
        let membrane = MembraneSpec {
            thickness_m: 1e-3,
            modulus_pa: 1e5,
            density_kg_m3: 100.0,
            prestrain: 0.05,
            prestrain_span: None,
            poisson_ratio: 0.3,
            damping_s: 0.02,
            ribs_m: vec![0.0, 5.0],
        };
        let flap = FlapSpec {
            chord_fraction: 0.25,
            stiffness_n_rad: 2.0,
            areal_density_kg_m2: 0.1,
            damping_s: 0.01,
            rest_deg: 0.0,
            from_arc_m: 2.0,
            to_arc_m: None,
        };
        let models = [
            wing(StripSettings { membrane: Some(membrane), ..Default::default() }),
            wing(StripSettings { flap: Some(flap), ..Default::default() }),
        ];
        for model in models {
            let places = model.bent_states();
            let values: Vec<f64> = (0..places.len())
                .map(|k| if model.bends(k) { 0.01 + 0.002 * k as f64 } else { 0.0 })
                .collect();
            let (mut x, still) = (vec![0.0; model.states()], vec![0.0; model.states()]);
            x[places.clone()].copy_from_slice(&values);
            let efforts = |dx: &[f64]| {
                let mut efforts = vec![0.0; places.len()];
                model.bent_efforts(&x, dx, &mut efforts);
                efforts
            };
            let held = efforts(&still);
            for k in 0..values.len() {
                let at = |by: f64| {
                    let mut values = values.clone();
                    values[k] += by;
                    stored(&model, &values)
                };
                let slope = if model.bends(k) { (at(1e-5) - at(-1e-5)) / 2e-5 } else { 0.0 };
                assert!((held[k] - slope).abs() < 1e-6 * slope.abs().max(1e-3), "{k}: {} {slope}", held[k]);
            }
            // Damping takes no more than it is given, and a flap's momentum all.
            let loads: Vec<f64> = (0..values.len()).map(|k| f64::from(u8::from(model.bends(k)))).collect();
            let mut rates = still.clone();
            model.yield_to(&loads, &x, &mut rates);
            match model.is_membrane() {
                true => {
                    let taken = efforts(&rates);
                    let work = |of: &[f64]| -> f64 {
                        of.iter().zip(&rates[places.clone()]).map(|(load, rate)| load * rate).sum()
                    };
                    let damped: Vec<f64> = taken.iter().zip(&held).map(|(all, held)| all - held).collect();
                    let [lost, given] = [work(&damped), work(&loads)];
                    assert!(lost > 0.05 * given && lost < given, "{lost} {given}");
                }
                false => assert_eq!(&rates[places.end..], &loads[..]),
            }
        }
    }
}

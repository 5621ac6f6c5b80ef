//! Membranes and flaps under loads from beyond the strips' own air: what they bear, and how they yield to it.

use super::StripModel;
use super::membrane::MODES;
use crate::MAX_STRIPS;
use arrayvec::ArrayVec;
use wingbeat_math::Dual;

/// Numbers of the strips, one for each.
type BentColumn<S> = ArrayVec<S, MAX_STRIPS>;

/// Share of the mass of the first shape that stands for that of each, by the mean squares of the shapes.
const MASS: [f64; MODES] = [1.0, 1.0 / 7.0];

/// The skin of a surface at an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinSheet {
    /// Mass over area, kg/m2.
    pub areal_density: f64,
    /// Share of the chord from which on it moves against the chord, dimensionless.
    pub from: f64,
}

impl StripModel {
    /// The skin that moves against the chord at the arc `arc`, m; none where nothing does.
    pub fn sheet_at(&self, arc: f64) -> Option<SkinSheet> {
        if let Some(membrane) = &self.membrane {
            return Some(SkinSheet { areal_density: membrane.areal_density, from: 0.0 });
        }
        let (spec, flap) = (self.settings.flap?, self.numbers.flap.as_ref()?);
        let from = 1.0 - spec.chord_fraction;
        spec.covers(arc.abs()).then_some(SkinSheet { areal_density: flap.areal_density, from })
    }

    /// Whether the bent state number `k`, as [`bent_states`](Self::bent_states) has them, is free: strips beside a flap are not.
    pub fn bends(&self, k: usize) -> bool {
        self.hinges.as_ref().is_none_or(|hinges| hinges.has(k))
    }

    /// What springs, tensions and their damping bear in the state `x` with the rates `dx`, in the order of the bent states: N m by the heights
    /// over the chord and the angles. Of a membrane dU/dh + tau K h', U what it stores and h' tau K h' what it loses.
    ///
    /// Equation: aero.bent_efforts
    /// `dU/dh + (1/2) dD/dh', U = aero.membrane.stored, D = h' tau K h'; of a flap k (beta - beta_0) + k tau beta'`
    /// Source: virtual work.
    /// Test: `a_membrane_bears_the_slope_of_its_energy_and_a_flap_its_spring`.
    pub fn bent_efforts(&self, x: &[f64], dx: &[f64]) -> Vec<f64> {
        let places = self.bent_states();
        let (values, rates) = (&x[places.clone()], &dx[places]);
        let Some(membrane) = &self.membrane else {
            let efforts = |(k, (angle, rate)): (usize, (&f64, &f64))| {
                let [bent, damped] = self.hinge_spring(k, *angle, *rate);
                if self.bends(k) { bent + damped } else { 0.0 }
            };
            return values.iter().zip(rates).enumerate().map(efforts).collect();
        };
        let seeded = |of: &[f64], place: usize| Self::shapes(of, |k| if k == place { 1.0 } else { 0.0 });
        let effort = |place: usize| {
            let none = values.len();
            let (fixed, moved) = (seeded(values, none), seeded(values, place));
            let stored = membrane.stored(moved.each_ref().map(|shape| &shape[..]));
            let lost = membrane.lost(
                fixed.each_ref().map(|shape| &shape[..]),
                seeded(rates, place).each_ref().map(|shape| &shape[..]),
            );
            stored.eps[0] + 0.5 * lost.eps[0]
        };
        (0..values.len()).map(effort).collect()
    }

    /// Both shapes of all strips with the derivatives `seed`.
    fn shapes(of: &[f64], seed: impl Fn(usize) -> f64) -> [BentColumn<Dual<1>>; MODES] {
        let n = of.len() / MODES;
        std::array::from_fn(|m| (m * n..(m + 1) * n).map(|k| Dual { re: of[k], eps: [seed(k)] }).collect())
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
        let values = &x[places.clone()];
        let heights: [&[f64]; MODES] = std::array::from_fn(|m| &values[m * n..][..n]);
        for (k, load) in loads.iter().enumerate() {
            let (m, i) = (k / n, k % n);
            let mut unit = [[0.0; MAX_STRIPS]; MODES];
            unit[m][i] = 1.0;
            let damped = membrane.lost(heights, unit.each_ref().map(|shape| &shape[..n]));
            let chord = self.tables.chord[i];
            let mass = self.camber_mass(i, membrane) * MASS[m] * chord * chord;
            dx[places.start + k] += load / (damped + mass / membrane.damping);
        }
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
            let held = model.bent_efforts(&x, &still);
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
                    let taken = model.bent_efforts(&x, &rates);
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

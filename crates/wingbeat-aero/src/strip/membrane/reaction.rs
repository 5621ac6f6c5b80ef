//! What a membrane that gives way does to the wing that holds it, and what it stores and loses.

use super::super::influence::StripColumn;
use super::super::response::StripResponse;
use super::super::{StripFlow, StripModel};
use super::{Camber, Membrane};
use crate::Loads;
use wingbeat_math::{Meets, Over, Scalar};

/// Share of the impulse of the air by the motion of the chord that the parabola feels: the mean of sin^2 t by the pressure, 3/4.
const SHARED_AIR: f64 = 0.75;

impl<P: Scalar> StripModel<P> {
    /// Mass S = (3/4) m_a f + (2/3) m of strip `i` that both chord and parabola move, kg: m_a = pi rho b^2 dy, f the share of a unit normal
    /// speed of the whole wing that its neighbours leave, m the mass of the membrane.
    pub(super) fn shared_mass<K: Scalar + Meets<P>, G: Scalar, const N: usize>(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        membrane: &Membrane<P>,
    ) -> K {
        flow.unit_left[i] * (self.carried_mass(i) * SHARED_AIR) + self.film_mass(i, membrane)
    }

    /// Adds the reaction of the parabolas to the impulses on the strips, N s, and their rates, N. The rate h_1' is followed by a state v
    /// within the membrane's own damping time, and the wing bears the rate of -S v n: lift -3/4 pi rho b^2 h_1'' in plane
    /// flow, and (1/2) pi rho b^2 V h_2'/c by the slope of the second shape. The offset h n of the mass is left out.
    ///
    /// Equation: aero.camber_reaction
    /// `v' = (h_1' - v)/tau; impulse -S v + (1/2) pi rho b^2 dy V h_2/c, S = 3/4 pi rho b^2 dy f + 2/3 m; force d(P n)/dt`
    /// Source: lift of an accelerating camber by thin-aerofoil theory (Theodorsen 1935; Peters, Hsieh & Torrero 2007), own derivation; tau
    /// a choice.
    /// Test: `a_membrane_without_air_keeps_the_momentum_of_its_wing`.
    #[inline(never)]
    pub(in super::super) fn push_back<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        camber: &Camber<'_, S, N>,
        impulses: [&mut StripColumn<S, N>; 2],
    ) {
        let Some(membrane) = &self.membrane else { return };
        let [impulse, rate] = impulses;
        for i in 0..self.settings.strips {
            let shared = G::from(self.shared_mass(i, flow, membrane));
            impulse[i] += camber.slope[0][i] - camber.followed[0][i] * shared;
            rate[i] += camber.slope[1][i] - camber.followed[1][i] * shared;
        }
    }

    /// Adds what the membrane gets, stores and loses in the state `x` with the rates `dx` to `loads`.
    pub(in super::super) fn note_membrane<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        response: &StripResponse<'_, S, N>,
        (x, dx): (&[S], &[S]),
        loads: &mut Loads<S>,
    ) {
        let (Some(membrane), Some(camber)) = (&self.membrane, response.camber) else { return };
        let work = &mut loads.membrane;
        work.given += camber.given.unwrap_or(S::ZERO);
        work.stored += membrane.stored(self.cambers(x));
        work.lost += membrane.lost(self.cambers(x), self.cambers(dx));
        for i in 0..self.settings.strips {
            let momentum = camber.followed[0][i] * self.film_mass(i, membrane);
            work.momentum += flow.strips.normal.get(i).times(momentum);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        Loads, MembraneSpec, Planform, PlanformStation, SectionMotion, SectionSettings, StripModel,
        StripSettings,
    };
    use wingbeat_math::{RK4, Vec3, Workspace};

    /// A film of 0.1 kg/m2, 1 m by 10 m, on strips free along their normal; the air weighs what is given, kg/m3.
    fn film(density_kg_m3: f64) -> StripModel {
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
        let membrane = MembraneSpec {
            thickness_m: 1e-3,
            modulus_pa: 1e5,
            density_kg_m3: 100.0,
            prestrain: 0.05,
            prestrain_span: None,
            poisson_ratio: 0.3,
            damping_s: 0.02,
            ribs_m: Vec::new(),
        };
        let settings = StripSettings {
            strips: 4,
            section: SectionSettings { density_kg_m3, ..Default::default() },
            membrane: Some(membrane),
            ..Default::default()
        };
        StripModel::new(&Planform::new(&[station(0.0), station(5.0)]).unwrap(), settings).unwrap()
    }

    fn sections(model: &StripModel, speed: f64) -> Vec<SectionMotion<f64>> {
        let velocity = Vec3([0.0, 0.0, speed]);
        let section = |y: &f64| SectionMotion {
            le: Vec3([0.5, *y, 0.0]),
            te: Vec3([-0.5, *y, 0.0]),
            span: Vec3([0.0, -1.0, 0.0]),
            v_le: velocity,
            v_te: velocity,
            ..Default::default()
        };
        model.arcs().iter().map(section).collect()
    }

    /// A wing of 3 kg whose bulge is let go: what it gains of momentum the film lacks.
    #[test]
    fn a_membrane_without_air_keeps_the_momentum_of_its_wing() {
        let (model, mass) = (film(1e-12), 3.0);
        let n = model.states();
        let at = model.channels().iter().position(|c| c.name == "camber_0").unwrap();
        let mut x = vec![0.0; n + 1];
        x[1 + at..1 + at + model.strips()].fill(0.06);
        let evaluate = |x: &[f64], dx: &mut [f64]| {
            let mut loads = Loads::default();
            model.evaluate(&sections(&model, x[0]), Vec3::ZERO, &x[1..], &mut dx[1..], &mut loads);
            dx[0] = loads.wrench.force[2] / (mass + loads.added_mass[2][2]);
            loads.membrane.momentum[2]
        };
        let rates = |_: f64, x: &[f64], dx: &mut [f64]| -> Result<(), std::convert::Infallible> {
            evaluate(x, dx);
            Ok(())
        };
        let (mut work, mut rest, mut largest) = (Workspace::new(n + 1, 4), 0.0_f64, 0.0_f64);
        for k in 0..400 {
            RK4.step(rates, k as f64 * 1e-3, 1e-3, &mut x, &mut work).unwrap();
            let film = evaluate(&x, &mut vec![0.0; n + 1]);
            rest = rest.max((mass * x[0] + film).abs());
            largest = largest.max(film.abs());
        }
        assert!(largest > 1e-2 && rest < 1e-10 * largest, "{rest} {largest}");
    }
}

//! Rates with derivatives about accelerations that are known: what is out of balance there is solved for by the mass matrix at hand,
//! which needs no derivatives of its own.

use super::Robot;
use super::dynamics::{DegreeMatrix, Evaluation, InstantInertia};
use super::sections::Carriers;
use arrayvec::ArrayVec;
use wingbeat_math::linear::solve_symmetric_leading;
use wingbeat_math::{Jet, Over, Scalar, Vec3};
use wingbeat_ocp::plant::{Early, Fault, Known, MAX_DEGREES, PartsInEarly};

impl Robot {
    /// See [`Plant::rates_about`](wingbeat_ocp::plant::Plant::rates_about). With the accelerations a that are known, every part moves
    /// as it does, and the loads that remain, R, vanish but for their derivatives. Accelerations are a + M^-1 R, M the mass
    /// matrix. Places in B carry the derivatives of `K` alone.
    ///
    /// Equation: robot.balanced_rates
    /// `M da = dR at the accelerations a held, R their loads less inertia; followed impulses P' - B da`
    /// Source: implicit function theorem.
    /// Test: `what_has_no_derivative_is_left_out_and_nothing_else`.
    #[inline(never)]
    pub(super) fn balanced_rates<K: Scalar>(
        &self,
        known: &Known,
        at: PartsInEarly<'_>,
        dx: [&mut [Early]; 2],
    ) -> Result<(), Fault>
    where
        Early: Over<K>,
    {
        Evaluation::within(|out| self.balanced_in::<K>(out, known, at, dx))
    }

    /// The same in the room `out`.
    #[inline(always)]
    fn balanced_in<K: Scalar>(
        &self,
        out: &mut Evaluation<Early>,
        known: &Known,
        (t, [early, air], u): PartsInEarly<'_>,
        [dx, air_rates]: [&mut [Early]; 2],
    ) -> Result<(), Fault>
    where
        Early: Over<K>,
    {
        let (l, count) = (&self.layout, self.degrees());
        let structure = &early[l.structure..];
        let clock = Jet::new(Early::from(t), Early::ONE, Early::ZERO);
        let held = (&[][..], InstantInertia::Held(&known.degrees));
        let (body, setting) = self.instant((clock.x, &clock), early, u, held, dx, out)?;
        let Evaluation { links, base, coordinates, carriers, .. } = out;
        let mut carriers = Carriers::within(carriers, coordinates);
        carriers.follow(base, &self.carriers, links, [setting.wind_dot, setting.gravity]);
        (carriers.ground, carriers.complete) =
            (self.ground_below(setting.attitude, early[l.position + 2]), true);
        let mut left = [Early::ZERO; MAX_DEGREES];
        let forces = &mut left[6..];
        self.mechanism.tree.coordinate_inertia(links, setting.gravity, coordinates, None, forces);
        self.add_efforts(structure, Early::ONE, forces);
        for ([i, j], inertance) in self.inertances() {
            forces[i] -= Early::from(inertance * known.degrees[6 + j]);
        }
        if let Some(motor) = &self.motor {
            forces[count - 1] -= Early::from(motor.inertia() * known.degrees[5 + count]);
        }
        let states = (air, &mut *air_rates);
        let (load, _) = self.bear_air::<K, _, _>(&carriers, setting.wind, states, (None, None), forces);
        let net = load + body;
        net.force.store(&mut left);
        net.moment.store(&mut left[3..]);
        let mut mass = DegreeMatrix::<f64>::new();
        for known in known.mass.chunks_exact(6 + count) {
            let mut row = [0.0; MAX_DEGREES];
            row[..6 + count].copy_from_slice(known);
            mass.push(row);
        }
        let changes =
            solve_symmetric_leading(6 + count, &mut mass, left).ok_or(Fault::MassMatrix { time: t })?;
        for (state, by) in &known.falling {
            for i in 0..6 + count {
                air_rates[*state - l.aero] -= changes[i] * by[i];
            }
        }
        let accelerations: ArrayVec<Early, MAX_DEGREES> =
            known.degrees.iter().zip(&changes).map(|(held, change)| *change + *held).collect();
        setting.attitude.times(Vec3::from_slice(&accelerations)).store(&mut dx[l.velocity..]);
        Vec3::from_slice(&accelerations[3..]).store(&mut dx[l.rate..]);
        self.store_coordinate_rates(structure, &accelerations[6..], &mut dx[l.structure..]);
        Ok(())
    }
}

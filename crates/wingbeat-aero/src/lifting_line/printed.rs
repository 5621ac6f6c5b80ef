//! Preset `as_printed`: equations (1) to (4) of the paper as they stand.
//!
//! (1) G = (1/2) a0 c0 U sum a_n sin(n theta)
//! (2) w_ind = -(a0 c0 U / 4 S) sum n a_n sin(n theta) / sin(theta)
//! (3) c_l = a0 [(c0/c) sum a_n sin(n theta) + (c0/U) sum a_n' sin(n theta)]
//! (4) c_l = (a0/U) [w(0) Phi(t) + int w'(s) Phi(t - s) ds], t the reduced time: int v / b, v the velocity of the section's
//!     quarter chord perpendicular to the sweep; U t / b where the free stream is much faster
//!
//! A choice stands in for what the equations leave open: U is the airspeed of the middle of the wing at half chord. The
//! lift acts at the quarter chord and is turned by the wash, `lift_tilt`.
//! The nodal form keeps G and has G' = (1/2) a0 c0 (U sum a_n' sin + U' sum a_n sin); (3) has the first term only, so both
//! agree as long as U is constant.

use super::LiftingLine;
use crate::Sections;
use wingbeat_math::{Meets, Over, Scalar, Vec3};

impl<P: Scalar> LiftingLine<P> {
    /// The one airspeed of the wing, m/s, smooth at rest; none outside preset `as_printed`.
    #[inline]
    pub(super) fn stream<G: Scalar>(
        &self,
        sections: &(impl Sections<G> + ?Sized),
        wind: Vec3<G>,
    ) -> Option<G> {
        if !self.settings.as_printed {
            return None;
        }
        let velocity = sections.on_link(self.strips()).velocity(0.5) - wind;
        let floor = self.settings.regularisation_m_s;
        Some((velocity.dot(velocity) + floor * floor).sqrt())
    }

    /// G per airspeed and series, a0 c0 / 2, m.
    #[inline]
    fn root_circulation(&self) -> P {
        self.numbers.section_slope * (self.layout.root_chord * 0.5)
    }

    /// Circulation of the state `x` of a node, m2/s.
    #[inline]
    pub(super) fn circulation<S: Scalar + Meets<P>>(&self, stream: Option<S>, x: S) -> S {
        stream.map_or(x, |speed| x * (speed * self.root_circulation()))
    }

    /// Wash of the wake, m/s, of what [`LiftingLine::induced_wash`] makes of the states of all nodes.
    #[inline(always)]
    pub(super) fn wake_wash<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(&self, speed: G, induced: S) -> S {
        if !self.settings.as_printed {
            return induced;
        }
        induced * (speed * self.root_circulation())
    }

    /// Rate of the series g at node `i`: (3) with (4), g' = w_e / c0 - (U/c) g.
    ///
    /// Equation: aero.printed.series
    /// `g' = w_e / c0 - (U/c) g, g = sum a_n sin(n theta), G = a0 c0 U g / 2: without the term of U'`
    /// Source: Paper eqs. (1), (3), (4).
    /// Test: `in_a_constant_stream_the_printed_form_is_the_nodal_one`.
    #[inline]
    pub(super) fn printed_rate<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        i: usize,
        speed: G,
        effective_wash: S,
        series: S,
    ) -> S {
        effective_wash * self.layout.root_chord.recip() - series * (speed * self.nodes[i].inverse_chord)
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        JONES_RATES, LiftTilt, LiftingLine, LiftingLineSettings, Loads, Planform, PlanformStation,
        SectionMotion,
    };
    use wingbeat_math::{Dual, RK4, Scalar, Vec3, Workspace};

    /// Both forms of a tapered wing without what the printed equations lack.
    fn forms() -> [LiftingLine; 2] {
        let nodal = LiftingLineSettings { nodes: 8, ..LiftingLineSettings::default() };
        [nodal, nodal.printed()]
            .map(|set| LiftingLine::with_chords(0.2, |s| 0.16 - 0.4 * s.abs(), set).unwrap())
    }

    #[test]
    fn in_a_constant_stream_the_printed_form_is_the_nodal_one() {
        let end = |line: &LiftingLine| {
            let m = line.strips();
            let (mut x, mut effective) = (vec![0.0; 3 * m], vec![0.0; m]);
            let mut work = Workspace::new(3 * m, 4);
            for k in 0..200 {
                let rates = |t: f64, x: &[f64], dx: &mut [f64]| {
                    let wash: Vec<f64> = (0..m).map(|i| 0.3 + 0.1 * i as f64 * (22.0 * t).cos()).collect();
                    line.rates_in_wash(&[0.8; 8], &wash, x, dx, &mut effective);
                    Ok::<(), ()>(())
                };
                RK4.step(rates, k as f64 * 1e-3, 1e-3, &mut x, &mut work).unwrap();
            }
            effective
        };
        let [nodal, printed] = forms();
        for (a, b) in end(&nodal).into_iter().zip(end(&printed)) {
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
        assert_eq!((nodal.arcs().len(), printed.arcs().len(), printed.node_arcs().len()), (8, 9, 8));
    }

    /// A swept wing that slides: its lags run by the part of the velocity across the line of its quarter chords.
    #[test]
    fn its_lags_run_by_the_velocity_across_the_sweep() {
        let station =
            |arc_m, x| PlanformStation { arc_m, leading_edge_m: x + 0.05, trailing_edge_m: x - 0.15 };
        let planform = Planform::new(&[station(0.0, 0.0), station(0.4, 0.3)]).unwrap();
        let set =
            LiftingLineSettings { nodes: 6, regularisation_m_s: 1e-9, ..LiftingLineSettings::default() };
        let line = LiftingLine::new(&planform, set.printed()).unwrap();
        let velocity = Vec3::new(1.0, 0.4, -0.3);
        let section = |&arc: &f64| {
            let (le, te) = planform.edges(arc);
            let at = |x: f64| Vec3::new(x, arc, 0.0);
            let span = Vec3::new(0.0, -1.0, 0.0);
            SectionMotion {
                le: at(le),
                te: at(te),
                v_le: velocity,
                v_te: velocity,
                span,
                ..Default::default()
            }
        };
        let sections: Vec<_> = line.arcs().iter().map(section).collect();
        let (mut dx, mut loads) = (vec![0.0; 18], Loads::default());
        line.evaluate(&sections[..], Vec3::ZERO, &[0.0; 18], &mut dx, &mut loads);
        for (i, arc) in line.node_arcs().iter().enumerate() {
            let along = Vec3::new(0.75 * arc.signum(), 1.0, 0.0) * 0.8;
            let speed = (velocity - along * velocity.dot(along)).norm();
            // The wash is .3 m/s and the semi-chord .1 m.
            let rate = JONES_RATES[0] * speed / 0.1 * 0.3;
            assert!((dx[6 + i] - rate).abs() < 1e-12, "{} {rate}", dx[6 + i]);
        }
    }

    #[test]
    fn its_loads_are_lift_alone_and_their_derivatives_are_exact() {
        let [_, printed] = forms();
        let moving = |t: Dual<1>| -> Vec<SectionMotion<Dual<1>>> {
            let section = |&arc: &f64| {
                let at = |x: f64| Vec3([Dual::from(x), Dual::from(arc), Dual::from(0.0)]);
                let v = Vec3([t * 0.7 + 0.9, Dual::from(0.1), t.sin() * (3.0 * arc)]);
                let span = Vec3::constant(Vec3::new(0.0, -1.0, 0.0));
                SectionMotion { le: at(0.06), te: at(-0.09), v_le: v, v_te: v, span, ..Default::default() }
            };
            printed.arcs().iter().map(section).collect()
        };
        let x: Vec<Dual<1>> = (0..24_u8).map(|i| Dual::from(0.02 * f64::from(i) - 0.1)).collect();
        let run = |t: Dual<1>| {
            let mut loads = Loads::default();
            printed.evaluate(&moving(t)[..], Vec3::ZERO, &x, &mut vec![Dual::from(0.0); 24], &mut loads);
            loads
        };
        let (exact, h) = (run(Dual::variable(0.4, 0)), 1e-6);
        let [up, down] = [0.4 + h, 0.4 - h].map(|t| run(Dual::from(t)).wrench.force[2].re);
        let slope = exact.wrench.force[2].eps[0];
        assert!((slope - (up - down) / (2.0 * h)).abs() < 1e-6 * slope.abs().max(1.0), "{slope}");
        let upright = LiftingLineSettings { lift_tilt: LiftTilt::None, ..*printed.settings() };
        let upright = LiftingLine::with_chords(0.2, |s| 0.16 - 0.4 * s.abs(), upright).unwrap();
        let mut loads = Loads::default();
        let motions = moving(Dual::from(0.4));
        upright.evaluate(&motions[..], Vec3::ZERO, &x, &mut vec![Dual::from(0.0); 24], &mut loads);
        for (strip, turned) in loads.strip[..8].iter().zip(&exact.strip) {
            let (own, other) = (strip.circulatory.force, turned.circulatory.force);
            assert!(strip.induced_drag.force.norm().re < 1e-15 * own.norm().re);
            assert!(turned.induced_drag.force.norm().re > 1e-3 * other.norm().re);
        }
        for strip in &exact.strip[..8] {
            for part in [&strip.profile_drag, &strip.added_mass] {
                assert_eq!(part.force.norm().re, 0.0);
            }
            assert!(strip.circulatory.force[2].re != 0.0);
        }
    }
}

//! Forces and moments of the strips from their washes and impulses.

use super::influence::{StripColumn, column, lanes, large, plain, sum};
use super::motion::{Strips, Vectors};
use super::response::{LeadingEdges, StripResponse};
use super::settings::SpanForce;
use super::{StripFlow, StripModel};
use crate::section::{SectionForce, pitch_suction, suction_share};
use crate::{ForceDetail, Loads, ProfileDrag, StripLoads, Wrench};
use wingbeat_math::{Meets, Over, Scalar, Vec3};

/// Forces in the planes of all sections, N, and how far ahead of mid chord they act, m.
#[derive(Clone, Copy)]
struct InPlane<S: Scalar, const N: usize> {
    chordwise: StripColumn<S, N>,
    normal: StripColumn<S, N>,
    ahead: StripColumn<S, N>,
}

impl<S: Scalar, const N: usize> InPlane<S, N> {
    const ZERO: Self = Self { chordwise: [S::ZERO; N], normal: [S::ZERO; N], ahead: [S::ZERO; N] };

    #[inline(always)]
    fn at(&self, i: usize) -> SectionForce<S> {
        SectionForce::in_plane(self.chordwise[i], self.normal[i], self.ahead[i])
    }
}

/// Where the lift points.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Directed {
    /// As the wash of motion alone directs it.
    Plainly,
    /// As the wash of wake and lags turns it.
    Turned,
}

impl<K: Scalar, G: Over<K>, const N: usize> Strips<K, G, N> {
    /// A force of section `i` as a wrench about the body origin.
    #[inline(always)]
    pub(super) fn wrench<S: Over<K>>(&self, i: usize, force: SectionForce<S>) -> Wrench<S> {
        force.wrench(self.half.get(i), self.chordwise.get(i), self.normal.get(i), self.across.get(i))
    }
}

impl<P: Scalar> StripModel<P> {
    /// Sum of the loads of all strips; `loads` receives them by strip and source, `by_strip` their sums.
    #[inline(never)]
    pub(super) fn load_strips<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        response: &StripResponse<'_, S, N>,
        loads: Option<&mut Loads<S>>,
        by_strip: Option<&mut [Wrench<S>]>,
    ) -> Wrench<S> {
        let strips = &flow.strips;
        let lift = self.circulatory(strips, response, Directed::Turned);
        let drag = self.profile_drag(strips, response.attached, self.numbers.drag());
        let load = |i: usize| {
            let carried =
                self.carried_air(i, flow, response) + self.beside(i, flow, response, lift.chordwise[i]);
            let force = lift.at(i) + carried + drag.at(i);
            strips.wrench(i, if self.has_side_edge(i) { force + self.side_edge(i, response) } else { force })
        };
        let total = if const { plain::<S>() } {
            let (mut force, mut moment) = (Vectors::ZERO, Vectors::ZERO);
            for i in 0..N {
                let wrench = load(i);
                force.set(i, wrench.force);
                moment.set(i, wrench.moment);
            }
            if let Some(out) = by_strip {
                for (i, load) in out.iter_mut().enumerate().take(self.settings.strips) {
                    *load = Wrench { force: force.get(i), moment: moment.get(i) };
                }
            }
            let total = |of: &Vectors<S, N>| Vec3([sum(&of.0[0]), sum(&of.0[1]), sum(&of.0[2])]);
            Wrench { force: total(&force), moment: total(&moment) }
        } else {
            let mut total = Wrench::ZERO;
            let mut out = by_strip.into_iter().flatten();
            for i in 0..self.settings.strips.min(N) {
                let wrench = load(i);
                total += wrench;
                if let Some(out) = out.next() {
                    *out = wrench;
                }
            }
            total
        };
        if let Some(loads) = loads {
            self.break_down(flow, response, [&lift, &drag], loads);
        }
        total
    }

    /// Writes the loads by strip and source to the last strips of `loads`.
    fn break_down<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        response: &StripResponse<'_, S, N>,
        [lift, drag]: [&InPlane<S, N>; 2],
        loads: &mut Loads<S>,
    ) {
        let first = loads.strips - self.settings.strips;
        let plain = self.circulatory(&flow.strips, response, Directed::Plainly);
        if let Some(detail) = &mut loads.detail {
            self.detail(&flow.strips, response, &plain, &mut detail[first..]);
        }
        for i in 0..self.settings.strips {
            let at = first + i;
            let wrench = |force: SectionForce<S>| flow.strips.wrench(i, force);
            let along_chord = wrench(plain.at(i));
            let beside = self.beside(i, flow, response, lift.chordwise[i]);
            let edges = if self.has_side_edge(i) { beside + self.side_edge(i, response) } else { beside };
            loads.strip[at] = StripLoads {
                circulatory: along_chord + wrench(edges),
                induced_drag: wrench(lift.at(i)) + -along_chord,
                added_mass: wrench(self.carried_air(i, flow, response)),
                profile_drag: wrench(drag.at(i)),
            };
            if self.grid.covered[i] {
                loads.incidence[at] = response.lift_wash[i].atan2(S::from(flow.strips.along[i]));
                loads.separated[at] = S::ONE - response.attached[i];
                loads.suction_lost[at] = response.edges.as_ref().map_or(S::ZERO, |e| S::ONE - e.held[i]);
            }
            loads.wash[at] = response.wash[i];
            let height = |m: usize| {
                response.camber.and_then(|camber| camber.of_chord[m].get(i)).copied().unwrap_or(S::ZERO)
            };
            (loads.camber[at], loads.camber_forward[at]) = (height(0), height(1));
            loads.circulation[at] = response.circulation[i];
            loads.quarter_chord[at] = flow.strips.quarter.get(i).lifted();
        }
    }

    /// Writes the parts of the circulatory force `plain` and of the profile drag.
    fn detail<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        strips: &Strips<K, G, N>,
        response: &StripResponse<'_, S, N>,
        plain: &InPlane<S, N>,
        detail: &mut [ForceDetail<S>],
    ) {
        let plate = self.profile_drag(strips, response.attached, self.numbers.drag().of_plate());
        for (i, part) in detail.iter_mut().enumerate().take(self.settings.strips) {
            let (chordwise, normal) = (strips.chordwise.get(i), strips.normal.get(i));
            let vortex = response.edges.as_ref().map_or(S::ZERO, |e| self.vortex_force(i, response, e));
            let vortex =
                if self.has_side_edge(i) { vortex + self.side_edge(i, response).normal } else { vortex };
            *part = ForceDetail {
                suction: chordwise.times(plain.chordwise[i]),
                vortex: normal.times(vortex),
                plate: chordwise.times(plate.chordwise[i]) + normal.times(plate.normal[i]),
            };
        }
    }

    /// Normal force of the vortex of strip `i`, N: as much of it as the flow stays attached.
    #[inline(always)]
    fn vortex_force<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        response: &StripResponse<'_, S, N>,
        edges: &LeadingEdges<S, N>,
    ) -> S {
        edges.vortex[i] * response.attached[i] * self.tables.drag_scale[i]
    }

    /// Forces at 1/4 chord, N, as the wash of motion alone directs them, or as the wash of
    /// wake and lags turns them.
    /// F = rho dy g lw [V |uc|/Ve n - W s e_c], Ve = sqrt(uc^2 + W^2 + delta^2), with the attached
    /// share of the lift, of which the suction s takes another share; so it does of what pitching adds.
    ///
    /// Equation: aero.strip.force
    /// `rho dy g lw [V abs(uc)/Ve n - s W e_c], Ve = sqrt(uc^2 + W^2 + delta^2)`
    /// Source: Kutta-Joukowski and leading-edge suction, turned by the wash; s of the attached share and of the
    /// flow's direction a choice.
    /// Test: `sums_agree_and_breakdown_adds_up`.
    fn circulatory<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        strips: &Strips<K, G, N>,
        response: &StripResponse<'_, S, N>,
        directed: Directed,
    ) -> InPlane<S, N> {
        let (attached, delta2, n) = (response.attached, self.floor * self.floor, self.settings.strips);
        let lift: StripColumn<S, N> =
            column(n, |i| response.lift_wash[i] * attached[i] * self.tables.lift_scale[i]);
        let (pitches, slope_share) = (self.settings.section.pitch_suction, self.tables.slope_share);
        let pitching = |i: usize| {
            let section = (self.tables.mass[i], slope_share, self.tables.chord[i] * 0.5);
            pitch_suction(section, strips.pitch[i], response.wash[i], response.lift_wash[i]) * attached[i]
        };
        let turned = directed == Directed::Turned && self.settings.force_tilt;
        let wash: StripColumn<S, N> =
            column(n, |i| if turned { response.turning_wash[i] } else { S::from(strips.wash[i]) });
        let inverse: StripColumn<S, N> =
            column(n, |i| (wash[i].squared() + (strips.along[i].squared() + delta2)).sqrt().recip());
        let shares: StripColumn<S, N> = column(n, |i| {
            let suction = suction_share(inverse[i] * strips.along[i]);
            if response.edges.is_none() { suction * attached[i] } else { suction }
        });
        let chordwise = |i: usize| {
            let suction = lift[i] * wash[i];
            let suction = if pitches { suction + pitching(i) } else { suction + S::ZERO };
            -(suction * shares[i])
        };
        let normal = |i: usize| {
            let along2 = strips.along[i].squared() + delta2;
            lift[i] * (strips.speed[i] * along2.sqrt()) * inverse[i]
        };
        let ahead = |i: usize| S::from(self.tables.chord[i] * 0.25);
        let mut force;
        if const { large::<S>() } {
            let (chordwise, normal) = (column(n, chordwise), column(n, normal));
            force = InPlane { chordwise, normal, ahead: column(n, ahead) };
        } else {
            force = InPlane::ZERO;
            for i in 0..lanes::<S, N>(n) {
                force.chordwise[i] = chordwise(i);
            }
            for i in 0..lanes::<S, N>(n) {
                force.normal[i] = normal(i);
                force.ahead[i] = ahead(i);
            }
        }
        if let Some(edges) = &response.edges {
            self.cap_suction(strips, response, edges, &shares, &mut force);
            if let Some(camber) = &response.camber {
                let edge: [&[S]; 4] = [&camber.flat, &camber.nose, &edges.held, attached];
                let washes: [&[S]; 3] = [response.lift_wash, &wash, &shares];
                self.keep_slopes(edge, washes, &mut force.chordwise);
            }
        }
        force
    }

    /// What law `lev` makes of the linear forces: the held share h of the suction stays, with it that share of the
    /// carried air's own chord force P q, which is part of the suction, and the vortex pushes along the normal.
    fn cap_suction<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        strips: &Strips<K, G, N>,
        response: &StripResponse<'_, S, N>,
        edges: &LeadingEdges<S, N>,
        shares: &StripColumn<S, N>,
        force: &mut InPlane<S, N>,
    ) {
        for i in 0..lanes::<S, N>(self.settings.strips) {
            let (attached, held) = (response.attached[i], edges.held[i]);
            force.chordwise[i] *= held;
            force.normal[i] += self.vortex_force(i, response, edges);
            if self.settings.section.pitch_suction {
                let carried = response.impulse[i] * strips.pitch[i];
                force.chordwise[i] -= carried * (S::ONE - shares[i] * attached * held);
            }
        }
    }

    /// Profile drag of the sections in the wind of motion.
    fn profile_drag<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        strips: &Strips<K, G, N>,
        attached: &StripColumn<S, N>,
        drag: ProfileDrag<P>,
    ) -> InPlane<S, N> {
        let (n, delta2) = (self.settings.strips, self.floor * self.floor);
        let section = |i: usize| {
            let section =
                drag.section(&self.polar, strips.along[i], strips.wash_half[i], attached[i], delta2);
            let scale = self.tables.drag_scale[i];
            let ahead = (S::from(0.5) - section.centre) * self.tables.chord[i];
            [section.chordwise * scale, section.normal * scale, ahead]
        };
        if const { large::<S>() } {
            let sections: [_; N] = std::array::from_fn(|i| if i < n { section(i) } else { [S::ZERO; 3] });
            let [chordwise, normal, ahead] = [0, 1, 2].map(|k| column(n, |i| sections[i][k]));
            return InPlane { chordwise, normal, ahead };
        }
        let mut force = InPlane::ZERO;
        for i in 0..lanes::<S, N>(n) {
            [force.chordwise[i], force.normal[i], force.ahead[i]] = section(i);
        }
        force
    }

    /// Force of the carried air at 1/2 chord, and its couple: F = d(P n)/dt, the impulse carried
    /// across (Kirchhoff) and the moment of the pitching section
    /// -rho dy ma f [(b/2) V q + (b^2/8) q'], f the normal speed left of a unit one.
    ///
    /// Equation: aero.strip.carried_air
    /// `F = d(P n)/dt, couple v_span e_span x P n, nose-up -rho dy ma f [(b/2) V q + (b^2/8) q']`
    /// Source: Kirchhoff 1869; Theodorsen 1935, NACA Rep. 496.
    /// Test: `loads_are_affine_in_the_body_acceleration`.
    #[inline(always)]
    fn carried_air<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        response: &StripResponse<'_, S, N>,
    ) -> SectionForce<S> {
        let (strips, impulse) = (&flow.strips, response.impulse[i]);
        let normal_rate = strips.normal_rate.get(i);
        let mut force = SectionForce {
            chordwise: impulse * strips.chordwise.get(i).dot_over(normal_rate),
            normal: response.impulse_rate[i],
            across: impulse * strips.across.get(i).dot_over(normal_rate),
            nose_up: S::ZERO,
            about_chord: impulse * strips.drift[i],
        };
        if let Some(behind) = &self.tables.behind {
            force.nose_up = -(force.normal * behind[i]);
        }
        if self.settings.section.section_moment {
            let b = self.tables.chord[i] * 0.5;
            let moment =
                strips.speed[i] * strips.pitch[i] * (b * 0.5) + strips.pitch_rate[i] * (b * b * 0.125);
            force.nose_up -= S::from(moment * self.section_mass(i, flow));
        }
        // That of a flap is its inertia too.
        if let Some(camber) = &response.camber
            && (self.settings.section.section_moment || self.hinges.is_some())
        {
            force.nose_up += camber.couple[i];
            force.about_chord += camber.about_chord[i];
        }
        force
    }

    /// What the circulation bears beside the plane of section `i`, whose suction is `suction`, by the settings.
    #[inline(always)]
    fn beside<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        response: &StripResponse<'_, S, N>,
        suction: S,
    ) -> SectionForce<S> {
        match self.span_force {
            SpanForce::Edges => self.along_span(i, flow, response, suction),
            SpanForce::Impulse => self.turned_circulation(i, flow, response),
            SpanForce::Nothing => SectionForce::in_plane(S::ZERO, S::ZERO, S::ZERO),
        }
    }

    /// Spanwise force of the impulse of the bound circulation as a section turns about its chord, and its couple as it drifts along
    /// its span. The jump of potential that a circulation G spreads over the chord has the impulse rho dy b G n, which turns with the
    /// normal. What turns towards the chord, -2 m w_l q, is part of Garrick's suction (`aero.pitch_suction`); this is what turns
    /// towards the span, where the edges of the tips and the folds bear it. None without `turning_impulse`, and with
    /// `edge_suction`, in whose place edges bear it (`aero.strip.along_span`).
    ///
    /// A plate bears nothing along its span but the suction of its edges. The impulse has this in two parts: the one that turns, and
    /// rho G w tan(sweep) dy, w the wash, of the wake that leaves a swept trailing edge. The second is left out: on rectangular wings there
    /// is none; on wings that taper to a point the two cancel but for the tilt of the suction of a swept leading edge, and the first alone
    /// is too large (rows `trim.lattice.*.turned`).
    ///
    /// Equation: aero.strip.turned_circulation
    /// `F = rho dy b G (e_span . dn/dt) e_span, couple v_span e_span x rho dy b G n, G = g lw`
    /// Source: impulse of a vortex sheet: Saffman 1992, section 3.2; own derivation.
    /// Test: `the_impulse_of_the_circulation_turns_with_the_section`.
    #[inline(always)]
    fn turned_circulation<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        response: &StripResponse<'_, S, N>,
    ) -> SectionForce<S> {
        let mut force = SectionForce::in_plane(S::ZERO, S::ZERO, S::ZERO);
        let strips = &flow.strips;
        let circulation = response.lift_wash[i] * response.attached[i] * self.tables.lift_scale[i];
        let impulse = circulation * (self.tables.chord[i] * 0.5);
        force.across = impulse * strips.across.get(i).dot_over(strips.normal_rate.get(i));
        force.about_chord = impulse * strips.drift[i];
        force
    }

    /// Added mass that resists pitching of the section, kg.
    #[inline(always)]
    pub(super) fn section_mass<K: Scalar + Meets<P>, G: Scalar, const N: usize>(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
    ) -> K {
        flow.unit_left[i] * self.tables.mass[i]
    }
}

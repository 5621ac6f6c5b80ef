//! The flow at one node: what its forces follow from, and the rates of its states.

use super::nodes::LineNode;
use super::{LagSpeed, LiftTilt, LiftingLine};
use crate::SectionMotion;
use crate::law::{Attachment, Polar, lev};
use crate::section::{SectionFlow, SectionForce, pitch_suction, suction_share};
use wingbeat_math::{Meets, Over, Scalar, Vec3};

/// What the forces of a node follow from; what the motion alone decides is in `G`.
pub(super) struct NodeFlow<G: Scalar, S: Over<G>> {
    /// Wash of motion, m/s.
    pub(super) w: G,
    /// Wash of motion and induced wash, m/s.
    pub(super) wash: S,
    /// Effective wash, lags included, m/s.
    pub(super) effective: S,
    /// The wash by which the lift is turned, m/s.
    pub(super) turning: S,
    /// Smooth airspeed of motion, m/s.
    pub(super) speed: G,
    /// Smooth |uc|, m/s.
    pub(super) along: G,
    /// 1 / airspeed with the wash by which the lift is turned, s/m.
    pub(super) inverse: S,
    /// Smooth airspeed that the lift is counted with over that of motion: 1 but in preset `as_printed`.
    pub(super) streaming: G,
    /// Share of attached lift.
    pub(super) attached: S,
    /// Share of leading-edge suction.
    pub(super) suction: S,
    /// Leading-edge suction that pitching adds, N.
    pub(super) pitching: S,
    /// What the leading edge holds; all where it has no limit.
    pub(super) edge: Option<LimitedEdge<G, S>>,
}

/// A leading edge that holds a limited suction: law `lev`.
#[derive(Clone, Copy)]
pub(super) struct LimitedEdge<G: Scalar, S: Over<G>> {
    /// Share of the suction that it holds.
    pub(super) held: S,
    /// Normal force of the vortex, N.
    pub(super) vortex: S,
    /// Chord force of the carried air, part of the suction that is limited, N.
    pub(super) carried: G,
}

impl<G: Scalar, S: Over<G>> NodeFlow<G, S> {
    /// The lift rho (U G + c G') perpendicular to the wind that includes
    /// induced and lag wash W: L (|uc| n - s W e_c) / Ve.
    ///
    /// Equation: aero.lifting_line.force
    /// `L (abs(uc) n - s W e_c) / Ve, L = rho (U G + c G')`
    /// Source: unsteady Kutta-Joukowski, turned by the wash.
    /// Test: `sums_agree_and_breakdown_adds_up`.
    #[inline]
    pub(super) fn lift<P: Scalar>(&self, node: &LineNode<P>) -> SectionForce<S>
    where
        S: Meets<P>,
    {
        let turned = self.effective * self.attached * node.lift * self.speed * self.inverse;
        let ahead = S::from(node.half_chord * 0.5);
        self.at_edge(turned * self.turning, turned * self.along, ahead)
    }

    /// The same lift perpendicular to the wind of motion alone.
    #[inline]
    pub(super) fn lift_without_turning<P: Scalar>(&self, node: &LineNode<P>) -> SectionForce<S>
    where
        S: Meets<P>,
    {
        let lift = self.effective * self.attached * node.lift * self.streaming;
        let ahead = S::from(node.half_chord * 0.5);
        self.at_edge(lift * self.w, lift * self.along, ahead)
    }

    /// The linear suction `forward` and the `normal` force as the leading edge holds the one and its vortex adds to
    /// the other.
    #[inline]
    fn at_edge(&self, forward: S, normal: S, ahead: S) -> SectionForce<S> {
        let Some(edge) = self.edge else {
            return SectionForce::in_plane(-((forward + self.pitching) * self.suction), normal, ahead);
        };
        let share = self.suction * edge.held;
        let lost = (S::ONE - share * self.attached) * edge.carried;
        let forward = (forward + self.pitching) * share + lost;
        SectionForce::in_plane(-forward, normal + edge.vortex, ahead)
    }
}

impl<P: Scalar> LiftingLine<P> {
    /// State rates of node `i` and the flow that its forces follow from; of preset `as_printed` the one airspeed and the speed of the reduced time;
    /// `induced` is what [`LiftingLine::induced_wash`] makes of the states `x`.
    #[inline(always)]
    pub(super) fn flow<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        i: usize,
        section: &SectionFlow<G>,
        (printed, induced): (Option<[G; 2]>, S),
        x: &[S],
        dx: &mut [S],
    ) -> NodeFlow<G, S> {
        let set = &self.settings;
        let (uc, w) = (section.uc, section.w_three_quarter);
        let uc2 = uc * uc + set.regularisation_m_s * set.regularisation_m_s;
        let local = (uc2 + w * w).sqrt();
        let speed = printed.map_or(local, |[stream, _]| stream);
        let wash = self.wake_wash(speed, induced) + w;
        let effective = self.lag(i, printed.map_or(speed, |[_, travelled]| travelled), wash, x, dx);
        let inverse = (effective * effective + uc2).sqrt().recip();
        let sine = effective * inverse;
        let law = set.section.law.about();
        let attached = match law.attachment {
            Attachment::Lagging { state, .. } => S::ONE - x[(3 + state) * self.strips() + i],
            Attachment::Whole | Attachment::AtOnce => self.polar.attached_share(sine * sine),
        };
        dx[i] = self.circulation_rate(i, speed, effective * attached, x[i]);
        let mut suction = suction_share(inverse * uc);
        if !law.edge_vortex {
            suction *= attached;
        }
        let mut pitching = S::ZERO;
        if set.section.pitch_suction {
            let strip = (self.nodes[i].mass, self.slope_share, self.nodes[i].half_chord);
            pitching = pitch_suction(strip, section.pitch_rate, S::from(w), effective) * attached;
        }
        let mut flow = NodeFlow {
            w,
            wash,
            effective,
            turning: effective,
            speed,
            along: uc2.sqrt(),
            inverse,
            streaming: G::ONE,
            attached,
            suction,
            pitching,
            edge: None,
        };
        if printed.is_some() {
            flow.streaming = speed * local.recip();
            self.tilt_printed(&mut flow, (uc, uc2), local);
        }
        if let Attachment::Lagging { state, chords } = law.attachment {
            let at = (3 + state) * self.strips() + i;
            let rate = speed * self.nodes[i].inverse_chord;
            let still = self.polar.separated_share(sine * sine);
            dx[at] = Polar::<P>::separation_rate(x[at], still, rate, chords);
        }
        if law.edge_vortex {
            self.advance_edge(i, section, &mut flow, x, dx);
        }
        flow
    }

    /// The one airspeed `stream` of the printed equations with the speed of the reduced time of node `i`. By the paper's
    /// definition that is the velocity of its quarter chord perpendicular to the line of the quarter chords, whose slope x'
    /// is that of the flat outline: v^2 = (uc + x' v_across)^2 / (1 + x'^2) + w^2 at 1/4 chord, smooth at rest.
    ///
    /// Equation: aero.printed.reduced_time
    /// `v^2 = (uc + x' v_across)^2 / (1 + x'^2) + w^2 at 1/4 chord, x' the slope of the line of the quarter chords`
    /// Source: Paper, definition of v_e; Pythagoras.
    /// Test: `its_lags_run_by_the_velocity_across_the_sweep`.
    #[inline]
    pub(super) fn section_speed<G: Scalar + Meets<P>>(
        &self,
        i: usize,
        stream: G,
        motion: &SectionMotion<G>,
        wind: Vec3<G>,
    ) -> [G; 2] {
        if self.settings.lag_speed == LagSpeed::Stream {
            return [stream; 2];
        }
        let (node, floor) = (&self.nodes[i], self.settings.regularisation_m_s);
        let chord = (motion.te - motion.le) * G::from(node.inverse_edge);
        let velocity = motion.velocity(0.25) - wind;
        let along = (velocity.dot(motion.span) * node.sweep - velocity.dot(chord)) * node.sweep_cosine;
        let up = velocity.dot(chord.cross(motion.span));
        [stream, (along * along + up * up + floor * floor).sqrt()]
    }

    /// Turns the lift of the printed equations, which say nothing of suction in reversed flow, by the wash that is asked for.
    #[inline]
    fn tilt_printed<G: Scalar, S: Over<G>>(&self, flow: &mut NodeFlow<G, S>, (uc, uc2): (G, G), local: G) {
        match self.settings.lift_tilt {
            LiftTilt::Wash => {}
            LiftTilt::Downwash => {
                flow.turning = flow.wash;
                flow.inverse = (flow.wash * flow.wash + uc2).sqrt().recip();
                flow.suction = suction_share(flow.inverse * uc);
            }
            LiftTilt::None => {
                (flow.turning, flow.inverse, flow.suction) =
                    (S::from(flow.w), S::from(local.recip()), S::ONE);
            }
        }
    }

    /// Law `lev` at node `i`: the linear suction over rho c dy / 2 is a0 (w_e - b q/2)^2.
    ///
    /// Equation: aero.lifting_line.edge_suction
    /// `c_s V^2 = a0 (w_e - b q/2)^2, incidence of s_0 by w_e`
    /// Source: Garrick 1936.
    /// Test: `duals_agree_with_central_differences`.
    #[inline]
    fn advance_edge<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        i: usize,
        section: &SectionFlow<G>,
        flow: &mut NodeFlow<G, S>,
        x: &[S],
        dx: &mut [S],
    ) {
        let (node, set, m) = (&self.nodes[i], &self.settings, self.strips());
        let turn =
            if set.section.pitch_suction { section.pitch_rate * (node.half_chord * 0.5) } else { G::ZERO };
        let cosine = flow.inverse * section.uc;
        let wash = flow.effective - turn;
        let suction = wash.squared() * suction_share(cosine) * self.numbers.section_slope;
        let edge = lev::edge(&self.polar, suction, wash, flow.speed.squared(), set.regularisation_m_s);
        let (vortex, rate) = (3 * m + i, flow.speed * node.inverse_chord);
        dx[vortex] = lev::vortex_rate(x[vortex], edge.lost, rate);
        let carried = if set.section.pitch_suction && set.section.added_mass { node.mass } else { P::ZERO };
        flow.edge = Some(LimitedEdge {
            held: edge.held,
            vortex: x[vortex] * flow.attached * node.drag,
            carried: section.w_half * section.pitch_rate * carried,
        });
    }
}

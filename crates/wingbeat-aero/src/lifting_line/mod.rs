//! Preset `paper`: the unsteady lifting line of both wings and the body strip,
//! in nodal-circulation form.
//!
//! The state per node is the circulation G [m2/s] and two Wagner lags l1, l2
//! [m/s], ordered [G of all nodes, l1 of all, l2 of all], nodes from left tip
//! to right tip. The paper's Fourier coefficients a_n follow from G by a sine
//! transform; unlike them G needs no division by the airspeed and loses no
//! term when the airspeed changes.
//!
//! Preset `as_printed` keeps the paper's equations (1) to (4) as they stand: the first state of a node is
//! g = sum a_n sin(n theta), the series at the node, and G = a0 c0 U g / 2 with one airspeed U for the wing. Its lags run by
//! the velocity of each section.

mod flow;
mod late;
mod layout;
mod nodes;
mod printed;
mod settings;
#[cfg(test)]
mod tests;

pub use settings::{LagSpeed, LiftTilt, LiftingLineSettings};

use super::law::Polar;
use super::section::{SectionFlow, SectionForce, ZeroLift};
use super::{
    Coupling, ForceDetail, LiftLaw, Loads, Planform, ProfileDrag, SectionMotion, SectionSettings, Sections,
    StripLoads, SurfaceNumbers, Wrench,
};
use flow::NodeFlow;
use layout::NodeLayout;
use nodes::LineNode;
use std::f64::consts::PI;
use wingbeat_math::Error;
use wingbeat_math::{Meets, Over, Scalar, Vec3};
use wingbeat_ocp::plant::Channel;

/// Jones' two-term fit of Wagner's function (NACA Rep. 681, 1940): weights.
pub const JONES_WEIGHTS: [f64; 2] = [0.165, 0.335];
/// Jones' rates per semi-chord of travel, 1 over that travel and so dimensionless.
pub const JONES_RATES: [f64; 2] = [0.0455, 0.3];

/// The unsteady lifting line; constant after construction.
#[derive(Clone, Debug)]
pub struct LiftingLine<P: Scalar = f64> {
    settings: LiftingLineSettings,
    layout: NodeLayout<P>,
    nodes: Vec<LineNode<P>>,
    zero_lift: ZeroLift<P>,
    polar: Polar<P>,
    numbers: SurfaceNumbers<P>,
    /// Weight of the wash that acts at once.
    at_once: P,
    /// Lift slope of the section over that of a thin plate.
    slope_share: P,
}

/// What the lags leave of the weight of the wash.
fn at_once<P: Scalar>(numbers: &SurfaceNumbers<P>) -> P {
    numbers.lags.iter().fold(P::ONE, |rest, lag| rest - lag.weight)
}

impl LiftingLine {
    /// The lifting line of a planform.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is outside its range.
    pub fn new(planform: &Planform, settings: LiftingLineSettings) -> Result<Self, Error> {
        settings.check()?;
        let numbers = SurfaceNumbers { outline: Some(planform.clone()), ..settings.numbers() };
        Self::laid(NodeLayout::smooth(planform, &settings)?, numbers, settings)
    }

    /// The lifting line of a planform with kinks and hinges: nodes stand for cells that end at the hinges, arcs of
    /// the half wing, m, and hold the means of the chord.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is outside its range or there are too few nodes for the hinges.
    pub fn hinged(
        planform: &Planform,
        hinge_arcs: &[f64],
        settings: LiftingLineSettings,
    ) -> Result<Self, Error> {
        settings.check()?;
        let outline = Some(planform.clone());
        let numbers = SurfaceNumbers { outline, hinges: hinge_arcs.to_vec(), ..settings.numbers() };
        Self::laid(NodeLayout::hinged(planform, hinge_arcs, &settings)?, numbers, settings)
    }

    /// The lifting line of a wing of the given half span (m) and chord (m) by arc (m), its quarter chords in one line.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is outside its range.
    pub fn with_chords(
        half_span: f64,
        chord: impl Fn(f64) -> f64,
        settings: LiftingLineSettings,
    ) -> Result<Self, Error> {
        settings.check()?;
        let layout = NodeLayout::of_chords(half_span, |arc| [chord(arc), 0.0], &settings);
        Self::laid(layout, settings.numbers(), settings)
    }
}

impl<P: Scalar> LiftingLine<P> {
    #[inline(never)]
    fn laid(
        layout: NodeLayout<P>,
        numbers: SurfaceNumbers<P>,
        settings: LiftingLineSettings,
    ) -> Result<Self, Error> {
        let nodes: Vec<_> = layout.cells.iter().map(|cell| LineNode::new(cell, &numbers)).collect();
        let area = layout.cells.iter().fold(P::ZERO, |sum, cell| sum + cell.area);
        let span = layout.cells.iter().fold(P::ZERO, |sum, cell| sum + cell.area / cell.chord);
        Ok(Self {
            nodes,
            zero_lift: ZeroLift::new(numbers.zero_lift_angle),
            polar: Polar::new(settings.section.law, &numbers, span * span / area),
            at_once: at_once(&numbers),
            slope_share: numbers.section_slope / (2.0 * PI),
            layout,
            numbers,
            settings,
        })
    }

    /// The same line with other numbers than the settings say.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the nodes do not fit an outline.
    #[inline(never)]
    pub fn with<Q: Scalar>(&self, numbers: &SurfaceNumbers<Q>) -> Result<LiftingLine<Q>, Error> {
        let layout = match &numbers.outline {
            None => self.layout.map(|number| Q::from(number.value())),
            Some(outline) if self.layout.alternating => NodeLayout::smooth(outline, &self.settings)?,
            Some(outline) => NodeLayout::hinged(outline, &numbers.hinges, &self.settings)?,
        };
        LiftingLine::laid(layout, numbers.clone(), self.settings)
    }

    /// The same line under another law.
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub fn under(&self, law: LiftLaw) -> Result<Self, Error> {
        let section = SectionSettings { law, ..self.settings.section };
        Self::laid(
            self.layout.clone(),
            self.numbers.clone(),
            LiftingLineSettings { section, ..self.settings },
        )
    }

    /// The numbers in use.
    pub fn numbers(&self) -> &SurfaceNumbers<P> {
        &self.numbers
    }
    /// What it was made of.
    pub fn settings(&self) -> &LiftingLineSettings {
        &self.settings
    }
    /// Where [`SectionMotion`]s are wanted: arc coordinates of the nodes, m, left (positive) to right; of preset
    /// `as_printed` also the middle of the wing, behind them.
    pub fn arcs(&self) -> &[P] {
        &self.layout.arcs
    }
    /// Arc coordinates of the nodes, m.
    pub fn node_arcs(&self) -> &[P] {
        &self.layout.arcs[..self.nodes.len()]
    }
    /// Quadrature weights of the nodes for quantities that vanish at the tips
    /// like the circulation, m.
    pub fn widths(&self) -> &[P] {
        &self.layout.widths
    }
    /// Chord at node `i`, m.
    pub fn chord(&self, i: usize) -> P {
        self.nodes[i].half_chord * 2.0
    }
    /// Mean over the area of the size of the sweep of the line of the quarter chords, rad. The line itself is straight: its wash knows no sweep.
    pub fn mean_sweep(&self) -> P {
        let cells = &self.layout.cells;
        let [sum, area] = cells.iter().fold([P::ZERO; 2], |[sum, area], cell| {
            [sum + cell.sweep.abs().atan2(P::ONE) * cell.area, area + cell.area]
        });
        sum / area
    }
    /// Number of nodes.
    pub fn strips(&self) -> usize {
        self.nodes.len()
    }
    /// Number of states: three per node, and those of the law.
    pub fn states(&self) -> usize {
        (3 + self.settings.section.law.states().len()) * self.nodes.len()
    }
    /// Names and units of the states, in order.
    #[inline(never)]
    pub fn channels(&self) -> Vec<Channel> {
        let first = if self.settings.as_printed { ("series", "") } else { ("circulation", "m2/s") };
        let own = [first, ("lag1", "m/s"), ("lag2", "m/s")];
        own.into_iter()
            .chain(self.settings.section.law.states().iter().map(|state| (state.name, state.unit)))
            .flat_map(|(name, unit)| {
                (0..self.strips()).map(move |i| Channel::free(format!("{name}_{i}"), unit, ""))
            })
            .collect()
    }

    /// Wash (m/s, along the normal) that the trailing vorticity of the
    /// circulation `gamma` induces at node `i`: -sum_j D_ij G_j. D of even angles vanishes
    /// between different nodes an even number apart.
    ///
    /// Equation: aero.lifting_line.induced_wash
    /// `w_i = -sum_j D_ij G_j`
    /// Source: Prandtl; Glauert 1926; Multhopp 1938; Paper eqs. (1)-(2).
    /// Test: `rectangles_have_glauerts_slope`.
    #[inline(always)]
    fn induced_wash<S: Scalar + Meets<P>>(&self, i: usize, gamma: &[S]) -> S {
        let row = &self.layout.influence[i * gamma.len()..(i + 1) * gamma.len()];
        if !self.layout.alternating {
            return -(0..gamma.len()).fold(S::ZERO, |sum, j| sum.plus_met(gamma[j], row[j]));
        }
        let mut sum = gamma[i] * row[i];
        for j in ((i + 1) % 2..gamma.len()).step_by(2) {
            sum = sum.plus_met(gamma[j], row[j]);
        }
        -sum
    }

    /// State rates for airspeed (m/s) and wash of motion (m/s) given at each
    /// node, attached flow, without any regularisation. Writes the effective
    /// wash: the lift per span is rho U G + rho c G' = rho U a0 (c/2) w_eff.
    /// Preset `as_printed` knows one airspeed: that of every node, its lags included.
    pub fn rates_in_wash<S: Scalar + Meets<P>>(
        &self,
        airspeed: &[S],
        wash: &[S],
        x: &[S],
        dx: &mut [S],
        effective_wash: &mut [S],
    ) {
        let m = self.strips();
        for i in 0..m {
            let w = wash[i] + self.wake_wash(airspeed[i], self.induced_wash(i, &x[..m]));
            effective_wash[i] = self.lag(i, airspeed[i], w, x, dx);
            dx[i] = self.circulation_rate(i, airspeed[i], effective_wash[i], x[i]);
        }
    }

    /// Wagner lags of node `i`: l_k' = eps_k (U/b) (w - l_k); returns the
    /// effective wash (1 - psi_1 - psi_2) w + psi_1 l_1 + psi_2 l_2
    /// (Duhamel's integral of Wagner's function with Jones' fit).
    ///
    /// Equation: aero.lifting_line.lags
    /// `l_k' = eps_k (U/b) (w - l_k)`
    /// Source: Wagner 1925; Jones 1940, NACA Rep. 681; Paper eq. (4).
    /// Test: `a_sudden_start_follows_wagner_and_begins_at_half`.
    #[inline(always)]
    fn lag<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        i: usize,
        speed: G,
        w: S,
        x: &[S],
        dx: &mut [S],
    ) -> S {
        let (node, m) = (&self.nodes[i], self.strips());
        let mut effective = w * self.at_once;
        for k in 0..2 {
            let lag = x[(k + 1) * m + i];
            dx[(k + 1) * m + i] = (w - lag) * (speed * node.lag_rates[k]);
            effective = effective.plus_met(lag, self.numbers.lags[k].weight);
        }
        effective
    }

    /// G' = (U/c) (a0 c w_eff / 2 - G): the unsteady Kutta-Joukowski lift
    /// rho (U G + c G') equals Duhamel's.
    ///
    /// Equation: aero.lifting_line.circulation
    /// `G' = (U/c) (a0 c w_eff / 2 - G)`
    /// Source: Boutet & Dimitriadis 2018; Paper eq. (3).
    /// Test: `steady_elliptic_wing_has_prandtls_slope_at_any_speed`.
    #[inline]
    fn circulation_rate<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        i: usize,
        speed: G,
        effective_wash: S,
        gamma: S,
    ) -> S {
        let node = &self.nodes[i];
        if self.settings.as_printed {
            return self.printed_rate(i, speed, effective_wash, gamma);
        }
        (effective_wash * node.circulation - gamma) * (speed * node.inverse_chord)
    }

    /// State rates and loads. `sections` at [`arcs`](Self::arcs), `wind` is the
    /// velocity of the air resolved in B. See [`Loads`] for the body acceleration.
    pub fn evaluate<S: Scalar + Meets<P>>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) {
        loads.clear();
        (loads.wrench, loads.added_mass) = self.append(sections, wind, x, dx, loads);
    }

    /// Writes the loads by node behind the strips that `loads` holds; returns the sum.
    #[inline(never)]
    pub(super) fn append<S: Scalar + Meets<P>>(
        &self,
        sections: &(impl Sections<S> + ?Sized),
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) -> (Wrench<S>, [[S; 6]; 6]) {
        let mut wrench = Wrench::ZERO;
        let mut added_mass = [[S::ZERO; 6]; 6];
        let mut matrix = (!sections.complete()).then_some(&mut added_mass);
        loads.extend_rigid(self.strips());
        let stream = self.stream(sections, wind);
        for i in 0..self.strips() {
            let node = &self.nodes[i];
            let section = SectionFlow::new(&sections.on_link(i), wind, node.inverse_edge, self.zero_lift);
            let printed = stream.map(|stream| self.section_speed(i, stream, &sections.on_link(i), wind));
            let induced = self.induced_wash(i, &x[..self.strips()]);
            let flow = self.flow(i, &section, (printed, induced), x, dx);
            let strip = self.by_source(node, &section, &flow, matrix.as_deref_mut());
            wrench += strip.total();
            loads.strip.push(strip);
            if let Some(detail) = &mut loads.detail {
                detail.push(self.detail(node, &section, &flow));
            }
            loads.incidence.push(flow.wash.atan2(section.uc));
            loads.wash.push(flow.wash);
            loads.separated.push(S::ONE - flow.attached);
            loads.suction_lost.push(flow.edge.map_or(S::ZERO, |edge| S::ONE - edge.held));
            loads.circulation.push(self.circulation(stream, x[i]));
            loads.quarter_chord.push(sections.on_link(i).point(0.25));
        }
        mirror_upper(&mut added_mass);
        (wrench, added_mass)
    }

    /// As [`evaluate`](Self::evaluate) for the sum alone: the wrench and the
    /// added-mass matrix. The states may carry more derivatives than the motion. `coupling` receives
    /// what the coordinates of `sections` take.
    #[inline(never)]
    pub fn evaluate_sum<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        sections: &(impl Sections<G> + ?Sized),
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        coupling: Option<Coupling<G, S>>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        self.sum_in(sections, wind, (x, dx), coupling, |i| self.induced_wash(i, &x[..self.strips()]))
    }

    /// The same in the wash that `induced` tells of each node.
    #[inline(always)]
    fn sum_in<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        sections: &(impl Sections<G> + ?Sized),
        wind: Vec3<G>,
        (x, dx): (&[S], &mut [S]),
        mut coupling: Option<Coupling<G, S>>,
        induced: impl Fn(usize) -> S,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        let mut sum = (Wrench::ZERO, [[G::ZERO; 6]; 6]);
        let (wrench, added_mass) = &mut sum;
        let stream = self.stream(sections, wind);
        // Of plain numbers the matrix costs less than to ask.
        let weighed = const { size_of::<G>() <= size_of::<f64>() } || !sections.complete();
        for i in 0..self.strips() {
            let node = &self.nodes[i];
            let section = SectionFlow::new(&sections.on_link(i), wind, node.inverse_edge, self.zero_lift);
            let printed = stream.map(|stream| self.section_speed(i, stream, &sections.on_link(i), wind));
            let flow = self.flow(i, &section, (printed, induced(i)), x, dx);
            let matrix = weighed.then_some(&mut *added_mass);
            let force = flow.lift(node)
                + self.profile_drag(node, &section, &flow, self.numbers.drag())
                + self.carried_air(node, &section, flow.speed, matrix);
            let load = section.wrench(force);
            *wrench += load;
            if let Some(coupling) = &mut coupling {
                if let Some(matrix) = &mut coupling.mass {
                    let (mass, inertia) = self.carried_masses(node);
                    section.add_coupled_inertia(mass, inertia, i, sections, self.zero_lift, matrix);
                }
                coupling.strips[i] = load;
            }
        }
        if weighed {
            mirror_upper(added_mass);
        }
        sum
    }

    /// Forces of one node by source.
    #[inline]
    fn by_source<S: Scalar + Meets<P>>(
        &self,
        node: &LineNode<P>,
        section: &SectionFlow<S>,
        flow: &NodeFlow<S, S>,
        added_mass: Option<&mut [[S; 6]; 6]>,
    ) -> StripLoads<S> {
        let lift = section.wrench(flow.lift(node));
        let circulatory = section.wrench(flow.lift_without_turning(node));
        StripLoads {
            circulatory,
            induced_drag: Wrench {
                force: lift.force - circulatory.force,
                moment: lift.moment - circulatory.moment,
            },
            added_mass: section.wrench(self.carried_air(node, section, flow.speed, added_mass)),
            profile_drag: section.wrench(self.profile_drag(node, section, flow, self.numbers.drag())),
        }
    }

    /// Parts of the circulatory force and of the profile drag of one node.
    fn detail<S: Scalar + Meets<P>>(
        &self,
        node: &LineNode<P>,
        section: &SectionFlow<S>,
        flow: &NodeFlow<S, S>,
    ) -> ForceDetail<S> {
        let plate = self.profile_drag(node, section, flow, self.numbers.drag().of_plate());
        let vortex = flow.edge.map_or(S::ZERO, |edge| edge.vortex);
        ForceDetail {
            suction: section.chordwise * flow.lift_without_turning(node).chordwise,
            vortex: section.normal * vortex,
            plate: section.wrench(plate).force,
        }
    }

    #[inline]
    fn profile_drag<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        node: &LineNode<P>,
        section: &SectionFlow<G>,
        flow: &NodeFlow<G, S>,
        drag: ProfileDrag<P>,
    ) -> SectionForce<S> {
        let set = &self.settings;
        let delta2 = set.regularisation_m_s * set.regularisation_m_s;
        let drag = drag.section(&self.polar, section.uc, section.w_half, flow.attached, delta2);
        let ahead = (S::from(0.5) - drag.centre) * (node.half_chord * 2.0);
        SectionForce::in_plane(drag.chordwise * node.drag, drag.normal * node.drag, ahead)
    }

    /// Force and couple of the carried air, its inertia added to the matrix, if there is one.
    #[inline(always)]
    fn carried_air<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        node: &LineNode<P>,
        section: &SectionFlow<G>,
        speed: G,
        matrix: Option<&mut [[G; 6]; 6]>,
    ) -> SectionForce<S> {
        let (mass, inertia) = self.carried_masses(node);
        let turned = if self.settings.section.section_moment { node.mass } else { P::ZERO };
        let mut force = section.added_mass(mass);
        force.nose_up = section.section_moment(turned, node.half_chord, speed);
        if let Some(matrix) = matrix {
            section.add_inertia(mass, inertia, matrix);
        }
        force.lifted()
    }

    /// Mass (kg) of the air that a node carries along its normal, and inertia (kg m2) of the air that
    /// it turns.
    #[inline]
    fn carried_masses(&self, node: &LineNode<P>) -> (P, P) {
        let set = &self.settings;
        let mass = if set.section.added_mass { node.mass } else { P::ZERO };
        let turned = if set.section.section_moment { node.mass } else { P::ZERO };
        (mass, turned * node.half_chord * node.half_chord / 8.0)
    }
}

/// Copies the upper triangle to the lower one.
#[inline]
fn mirror_upper<S: Scalar>(matrix: &mut [[S; 6]; 6]) {
    for i in 1..6 {
        for j in 0..i {
            matrix[i][j] = matrix[j][i];
        }
    }
}

//! A flap on each strip: a hinge moment by the pressure difference against a spring, and what the flap does to wash and wing.
//!
//! States are the angle and the momentum that belongs to it, so that no acceleration of the wing has to be known: beta' follows from the
//! momentum and the motion of the chord, and the acceleration beta'' with which the flap pushes back takes of the wing's inertia what the
//! free hinge does not bear.

use super::influence::StripColumn;
use super::membrane::Camber;
use super::motion::Strips;
use super::{StripFlow, StripModel};
use crate::flap::HingeFunctions;
use crate::{FlapSpec, Loads};
use arrayvec::ArrayVec;
use std::f64::consts::PI;
use wingbeat_math::{Meets, Over, Scalar};

/// What each strip carries for it.
pub(super) const STATES: [(&str, &str); BLOCKS] = [("flap", "rad"), ("flap_momentum", "N m s")];
/// Number of its states per strip.
pub(super) const BLOCKS: usize = 2;

/// The hinges laid on strips.
#[derive(Clone, Debug)]
pub(super) struct Hinges {
    of: HingeFunctions,
    /// Chord of the flap over that of the strip.
    fraction: f64,
    /// The strips that have a flap.
    on: Vec<bool>,
}

/// Masses of air and flap: what couples the flap to heave, kg m, and to pitch about mid chord, kg m2, and what resists it, kg m2.
#[derive(Clone, Copy)]
struct Masses<K> {
    heave: K,
    pitch: K,
    own: K,
}

/// The flap of a strip as it moves.
#[derive(Clone, Copy)]
struct MovingFlap<K, S> {
    angle: S,
    rate: S,
    masses: Masses<K>,
}

/// Those of all strips; none where there is no flap.
pub(super) struct Flaps<K, S, const N: usize>(ArrayVec<Option<MovingFlap<K, S>>, N>);

impl Hinges {
    /// On strips with their middles at the arcs `arcs` from the root (m), where `covered` says that there is a wing.
    pub fn new<P: Scalar>(spec: &FlapSpec, arcs: &[P], covered: &[bool]) -> Self {
        let on = arcs.iter().zip(covered).map(|(arc, covered)| *covered && spec.covers(arc.value()));
        let fraction = spec.chord_fraction;
        Self { of: HingeFunctions::new(fraction), fraction, on: on.collect() }
    }

    /// Whether strip `i` has a flap.
    pub fn has(&self, i: usize) -> bool {
        self.on[i]
    }

    /// Number of strips that have a flap.
    pub fn count(&self) -> usize {
        self.on.iter().filter(|on| **on).count()
    }
}

impl<P: Scalar> StripModel<P> {
    /// Whether strips have a flap.
    pub fn has_flap(&self) -> bool {
        self.hinges.is_some()
    }

    /// Where the flaps begin among the states.
    pub(super) fn flap_states(&self) -> usize {
        self.states() - BLOCKS * self.settings.strips
    }

    /// Where angles and momenta of its flaps lie among the states; none without one.
    pub fn swinging_states(&self) -> std::ops::Range<usize> {
        let first = if self.has_flap() { self.flap_states() } else { self.states() };
        first..self.states()
    }

    /// Angles of the flaps of the strips in the state `x`, rad; nothing without one.
    pub fn flaps_of<'a>(&self, x: &'a [f64]) -> &'a [f64] {
        let from = if self.has_flap() { self.flap_states() } else { x.len() };
        x.get(from..from + self.settings.strips).unwrap_or_default()
    }

    /// Mass of the flap of each strip, kg; nothing without one.
    pub fn flap_masses(&self) -> Vec<f64> {
        let (Some(hinges), Some(flap)) = (&self.hinges, &self.numbers.flap) else { return Vec::new() };
        let area = |i: usize| self.tables.chord[i] * self.grid.width[i] * hinges.fraction;
        let mass = |(i, on): (usize, &bool)| if *on { (area(i) * flap.areal_density).value() } else { 0.0 };
        hinges.on.iter().enumerate().map(mass).collect()
    }

    /// Largest angle by which its weight would turn the flap of a strip against its spring, m g r/k, rad; none without a flap.
    pub fn flap_sag(&self) -> Option<f64> {
        let (hinges, flap) = (self.hinges.as_ref()?, self.numbers.flap.as_ref()?);
        let sag = |(i, _): (usize, &bool)| {
            let chord = self.tables.chord[i] * hinges.fraction;
            let weight = (flap.areal_density * chord * chord).value() * 0.5 * wingbeat_math::GRAVITY;
            weight / flap.stiffness.value()
        };
        hinges.on.iter().enumerate().filter(|(_, on)| **on).map(sag).reduce(f64::max)
    }

    /// Masses of the flap of strip `i`; none where it has no flap. The flap is an even sheet of the chord l: S = m l/2, I = m l^2/3. The chord c
    /// between edges on two links changes as these turn. The pitch rate q is of that chord, so that q c has the rate q' c; distances
    /// along the chord grow with c.
    fn flap_mass<K: Scalar + Meets<P>, G: Scalar, const N: usize>(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
    ) -> Option<Masses<K>> {
        let hinges = self.hinges.as_ref()?;
        if !hinges.on[i] {
            return None;
        }
        let (chord, of) = (self.tables.chord[i], &hinges.of);
        let (b, moment) = (chord * 0.5, self.flap_moment(i));
        let own = moment * (chord * (hinges.fraction * 2.0 / 3.0));
        let about = own + moment * b * of.place;
        let carried = if self.settings.section.added_mass { self.section_mass(i, flow) } else { K::ZERO };
        let [heave, pitch, turning] = of.masses;
        let turns = if self.settings.section.section_moment { pitch } else { 0.0 };
        let quarter = flow.strips.half.get(i) - flow.strips.quarter.get(i);
        let stretch = quarter.norm() * (b.recip() * 2.0);
        Some(Masses {
            heave: carried * (b * heave) + moment,
            pitch: (carried * (b * b * turns) + about) * stretch,
            own: self.with_hinge(i, carried * (b * b * turning) + own),
        })
    }

    /// Inertia of the flap of strip `i` about its hinge, kg m2, with that of `robot.inertance`: I + p^2/(I + p), p = t (t k + c).
    fn with_hinge<K: Scalar + Meets<P>>(&self, i: usize, own: K) -> K {
        let Some(spring) = self.numbers.flap.as_ref().filter(|_| self.inertance > 0.0) else { return own };
        let lasting = spring.damping + self.inertance;
        let impulse = spring.stiffness * lasting * (self.grid.width[i] * self.inertance);
        own + (own + impulse).recip() * (impulse * impulse)
    }

    /// Static moment of the flap of strip `i` about its hinge, kg m.
    fn flap_moment(&self, i: usize) -> P {
        let (Some(hinges), Some(flap)) = (&self.hinges, &self.numbers.flap) else { return P::ZERO };
        let length = self.tables.chord[i] * hinges.fraction;
        flap.areal_density * length * length * (self.grid.width[i] * 0.5)
    }

    /// Weight of the flap of strip `i` times its arm, N m, along the normal, the chord and across.
    fn flap_weight<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
    ) -> [G; 3] {
        let strips = &flow.strips;
        let axes = [strips.normal.get(i), strips.chordwise.get(i), strips.across.get(i)];
        axes.map(|axis| axis.dot_over(flow.gravity) * self.flap_moment(i))
    }

    /// The flaps in the state `x`: beta' = (p - m_w w - m_q q)/m_b, w the wash of the chord at its middle.
    ///
    /// Equation: aero.flap_momentum
    /// `p = m_b beta' + m_w w + m_q q; p' = hinge moment without accelerations; m_w = -T1 rho b^3 dy f + S, m_q = 2 T13 rho b^4 dy f + I + S
    /// c b, m_b = -(T3/pi) rho b^4 dy f + I`
    /// Source: Theodorsen 1935, NACA Rep. 496; Lagrange's momentum of the hinge, own derivation; f as in aero.strip.carried_air.
    /// Test: `a_flap_keeps_energy_and_momentum_with_its_wing`.
    #[inline(never)]
    pub(super) fn flaps<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        x: &[S],
    ) -> Option<Flaps<K, S, N>> {
        self.hinges.as_ref()?;
        let (n, at) = (self.settings.strips, self.flap_states());
        let moving = |i: usize| {
            let masses = self.flap_mass(i, flow)?;
            let momentum = x[at + n + i] - self.driven(i, flow, &masses);
            Some(MovingFlap { angle: x[at + i], rate: momentum * masses.own.recip(), masses })
        };
        Some(Flaps((0..n).map(moving).collect()))
    }

    /// Part m_w w + m_q q of the momentum of a flap, N m s.
    fn driven<K: Scalar + Meets<P>, G: Over<K>, const N: usize>(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        masses: &Masses<K>,
    ) -> G {
        flow.strips.wash_half[i] * masses.heave + flow.strips.pitch[i] * masses.pitch
    }

    /// Sets the flaps to rest in their hinges, whatever the wing does.
    pub(super) fn settle_flaps<S: Scalar + Meets<P>, const N: usize>(
        &self,
        flow: &StripFlow<S, S, N>,
        x: &mut [S],
    ) {
        let (n, at) = (self.settings.strips, self.flap_states());
        for i in 0..n {
            x[at + n + i] = self.flap_mass(i, flow).map_or(S::ZERO, |masses| self.driven(i, flow, &masses));
        }
    }

    /// Moments of spring and damper of the flap of strip `i`, N m.
    #[inline(always)]
    pub(super) fn hinge_spring<S: Scalar + Meets<P>>(&self, i: usize, angle: S, rate: S) -> [S; 2] {
        let (Some(spring), width) = (&self.numbers.flap, self.grid.width[i]) else { return [S::ZERO; 2] };
        [
            (angle - spring.rest) * (spring.stiffness * width),
            rate * (spring.stiffness * spring.damping * width),
        ]
    }

    /// Speed along the chord, m/s, never negative.
    fn flap_wind<K: Scalar, G: Scalar, const N: usize>(&self, i: usize, strips: &Strips<K, G, N>) -> G {
        strips.along[i].smooth_abs(self.floor)
    }

    /// Adds what the flaps make of the wash at 3/4 chord: see [`HingeFunctions::new`].
    #[inline(never)]
    pub(super) fn wash_of_flaps<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        flaps: &Flaps<K, S, N>,
        wash: &mut [S],
    ) {
        let Some(hinges) = &self.hinges else { return };
        let [angle, rate] = hinges.of.wash;
        for (i, moving) in flaps.0.iter().enumerate() {
            if let Some(flap) = moving {
                let wind = self.flap_wind(i, &flow.strips);
                wash[i] += flap.angle * (wind * angle) + flap.rate * (self.tables.chord[i] * (0.5 * rate));
            }
        }
    }

    /// Rates of the flaps under the circulation that the `lift_wash` makes, and what they do to the strips: washes at the edge and couples of
    /// `camber`, whose `slope` holds impulses (N s) and their rates (N). The moments of circulation and vortex come with the lift; a plate in
    /// separated flow presses evenly. The weight of a turned flap has the couple -S beta n x g besides.
    ///
    /// Equation: aero.flap_hinge
    /// `p' = -k (beta - beta_0) - k tau beta' + S (turn of the normal in the air - n.g) + rho b^3 dy f [(2 T9 + T4/2) q + T4 T11/(2 pi) beta'] V -
    /// rho b^2 dy V^2 (T5 - T4 T10)/pi beta - (L + F_vortex) b T12/(2 pi) - F_plate b (1 - c)^2/4`
    /// Source: Theodorsen 1935, NACA Rep. 496; even pressure of the plate a choice, as in aero.camber_load.
    /// Test: `a_flap_at_rest_turns_and_lifts_as_glauert_says`.
    #[inline(never)]
    pub(super) fn turn_flaps<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        (flow, flaps): (&StripFlow<K, G, N>, &Flaps<K, S, N>),
        [attached, lift_wash]: [&StripColumn<S, N>; 2],
        x: &[S],
        dx: &mut [S],
        camber: &mut Camber<'_, S, N>,
    ) {
        let Some(hinges) = &self.hinges else { return };
        let (n, at, of) = (self.settings.strips, self.flap_states(), &hinges.of);
        let vortices = self.settings.section.law.about().edge_vortex.then(|| &x[self.law_states()..][..n]);
        for (i, moving) in flaps.0.iter().enumerate() {
            let Some(flap) = moving else {
                camber.flat[i] = lift_wash[i];
                (dx[at + i], dx[at + n + i]) = (S::ZERO, S::ZERO);
                continue;
            };
            let (wind, b, masses) =
                (self.flap_wind(i, &flow.strips), self.tables.chord[i] * 0.5, &flap.masses);
            let added = self.settings.section.added_mass;
            let carried = if added { self.section_mass(i, flow) } else { K::ZERO };
            let passing = wind * (carried * b);
            let pressed = attached[i] * (wind.squared() * (self.tables.lift_scale[i] * b * (0.5 / PI)));
            let [bent, damped] = self.hinge_spring(i, flap.angle, flap.rate);
            let of_air = flow.strips.pitch[i] * of.damped[1];
            let moment = (flap.rate * of.damped[0] + of_air) * passing
                - pressed * flap.angle * of.held
                - self.borne(i, &flow.strips, [attached[i], lift_wash[i]], vortices.map(|v| v[i])) * b;
            let weight = self.flap_weight(i, flow);
            let turned = flow.strips.turning(i) * self.flap_moment(i) - weight[0];
            let rate = moment - bent - damped + turned;
            let strips = &flow.strips;
            let known = strips.wash_half_rate[i] * masses.heave + strips.pitch_rate[i] * masses.pitch;
            let speeding = (rate - known) * masses.own.recip();
            (dx[at + i], dx[at + n + i]) = (flap.rate, rate);
            camber.flat[i] = lift_wash[i] - flap.angle * (wind * of.wash[0]);
            camber.nose[i] = flap.angle * (wind * (of.nose - of.wash[0]));
            camber.slope[0][i] = flap.rate * masses.heave + flap.angle * (wind * (carried * of.impulse));
            camber.slope[1][i] = speeding * masses.heave + flap.rate * (wind * (carried * of.impulse));
            let turning = flap.rate * (passing * of.couple[1]);
            let bending = pressed * flap.angle * of.couple[0];
            camber.couple[i] = -(speeding * masses.pitch + turning + bending + flap.angle * weight[1]);
            camber.about_chord[i] = flap.angle * weight[2];
        }
    }

    /// Force over the half chord that lift, vortex and plate bring to the hinge of strip `i`, up, N.
    fn borne<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, S: Over<G> + Over<K> + Meets<P>, const N: usize>(
        &self,
        i: usize,
        strips: &Strips<K, G, N>,
        [attached, lift_wash]: [S; 2],
        vortex: Option<S>,
    ) -> S {
        let Some(hinges) = &self.hinges else { return S::ZERO };
        let wind = self.flap_wind(i, strips);
        let lift = lift_wash * attached * (wind * self.tables.lift_scale[i]);
        let vortex = vortex.map_or(S::ZERO, |vortex| vortex * attached * self.tables.drag_scale[i]);
        let share = hinges.fraction * hinges.fraction;
        let plate = self.plate([strips.along[i], strips.wash_half[i]], attached);
        (lift + vortex) * hinges.of.lifted + plate * (self.tables.drag_scale[i] * share)
    }

    /// Takes of the inertia on the body's acceleration and angular acceleration what free hinges do not bear: -j j'/m_b of each, with
    /// j = [-m_w n; -m_w r x n + m_q e].
    ///
    /// Equation: aero.flap_relief
    /// `M - sum j j'/m_b, j the momentum of the hinge per unit rate of each coordinate`
    /// Source: elimination of beta'' from the equations of the hinges, own derivation.
    /// Test: `a_flap_keeps_energy_and_momentum_with_its_wing`.
    #[inline(never)]
    pub(super) fn relieve<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &mut StripFlow<K, G, N>,
    ) {
        for i in 0..self.settings.strips {
            let Some(masses) = self.flap_mass(i, flow) else { continue };
            let j = self.hinge_row(i, flow, &masses);
            let inverse = masses.own.recip();
            for r in 0..6 {
                for c in 0..6 {
                    flow.added_mass[r][c] -= j[r] * j[c] * inverse;
                }
            }
        }
    }

    /// Momentum of the hinge of strip `i` per unit of the body's rates.
    fn hinge_row<K: Scalar + Meets<P>, G: Over<K>, const N: usize>(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        masses: &Masses<K>,
    ) -> [K; 6] {
        let (normal, across) = (flow.strips.normal.get(i), flow.strips.across.get(i));
        let moment = flow.strips.half.get(i).cross(normal);
        let [force, turn] = [normal * -masses.heave, moment * -masses.heave + across * masses.pitch];
        let ([a, b, c], [d, e, f]) = (force.0, turn.0);
        [a, b, c, d, e, f]
    }

    /// The same of a coordinate that moves the strips with `field`, normal velocity (m/s) and pitch rate (rad/s) per unit rate: what the
    /// wing feels of it as impulse and as turned inertia, `felt`.
    #[inline(never)]
    pub(super) fn relieve_field<K: Scalar + Meets<P>, G: Over<K>, const N: usize>(
        &self,
        flow: &StripFlow<K, G, N>,
        [heave, pitch]: [&StripColumn<G, N>; 2],
        [carried, turned]: [&mut StripColumn<G, N>; 2],
    ) {
        for i in 0..self.settings.strips {
            let Some(masses) = self.flap_mass(i, flow) else { continue };
            let share = (pitch[i] * masses.pitch - heave[i] * masses.heave) * masses.own.recip();
            carried[i] += share * masses.heave;
            turned[i] -= share * masses.pitch;
        }
    }

    /// Adds the angles of the flaps in the state `x`, and what they store and lose, to `loads`.
    pub(super) fn note_flaps<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        x: &[S],
        loads: &mut Loads<S>,
    ) {
        let first = loads.strips - self.settings.strips;
        let (Some(spring), Some(flaps)) = (&self.numbers.flap, self.flaps(flow, x)) else { return };
        for (i, moving) in flaps.0.iter().enumerate() {
            let Some(flap) = moving else { continue };
            let (stiffness, bent) = (spring.stiffness * self.grid.width[i], flap.angle - spring.rest);
            loads.flap[first + i] = flap.angle;
            let (work, lost) = (&mut loads.membrane, flap.rate.squared() * (stiffness * spring.damping));
            // Loads and inertia together balance spring and weight.
            let [lift, _, _] = self.flap_weight(i, flow);
            let lifting = flow.strips.normal_rate.get(i).dot(flow.gravity) * self.flap_moment(i);
            work.given += bent * flap.rate * stiffness + lost + flap.rate * lift + flap.angle * lifting;
            work.stored += bent.squared() * (stiffness * 0.5) + flap.angle * lift;
            work.lost += lost;
            let momentum = flap.rate * self.flap_moment(i);
            work.momentum -= flow.strips.normal.get(i).times(momentum);
        }
    }
}

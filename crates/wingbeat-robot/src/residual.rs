//! What a model of the air leaves of measured loads, acting on the body.

use super::Robot;
use super::spec::ResidualSpec;
use arrayvec::ArrayVec;
use std::f64::consts::TAU;
use wingbeat_math::Error;
use wingbeat_math::{CHANNELS, Jet, Meets, Scalar, Vec3, Wrench};

/// Most terms: all products of three components up to the third power.
pub const MOST_TERMS: usize = 20;
/// Most harmonics.
pub const MOST_HARMONICS: usize = 40;
/// Highest power of a term.
const MOST_FACTORS: usize = 3;
/// Components of the velocity.
const COMPONENTS: [char; 3] = ['u', 'v', 'w'];
/// Share of the speed beyond the measured velocities that still counts as among them.
const BEYOND: f64 = 0.02;
/// Share by which the gait's frequency may differ from that of the measured loads.
pub const RESIDUAL_FREQUENCY: f64 = 0.01;

/// A product of components of the velocity against the air, in B: u^i v^j w^k.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term([usize; 3]);

impl Term {
    /// The term called `name`: `1`, `u`, `uw`, `ww`; none where that is neither `1` nor one to three of the letters u, v, w.
    pub fn named(name: &str) -> Option<Self> {
        let powers = COMPONENTS.map(|component| name.matches(component).count());
        let factors: usize = powers.iter().sum();
        let letters = factors == name.len() && (1..=MOST_FACTORS).contains(&factors);
        (letters || name == "1").then_some(Self(powers))
    }

    /// Its name.
    pub fn name(self) -> String {
        let letters = COMPONENTS.iter().zip(self.0);
        let name: String = letters.flat_map(|(letter, power)| std::iter::repeat_n(*letter, power)).collect();
        if name.is_empty() { "1".into() } else { name }
    }

    /// Its value at the velocity `v`, in B: a product of components, in m/s to the power of its factors.
    pub fn at<S: Scalar>(self, v: Vec3<S>) -> S {
        (0..3).fold(S::ONE, |product, i| (0..self.0[i]).fold(product, |product, _| product * v[i]))
    }
}

/// A wrench by phase of the gait and velocity, ready to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Rate of the gait's phase at which it was measured, rad/s.
    rate: f64,
    place: Vec3,
    low: [f64; 3],
    high: [f64; 3],
    terms: Vec<Term>,
    harmonics: usize,
    /// For each channel that has one: its number, and its factors row by row, term by term.
    channels: Vec<(usize, Vec<f64>)>,
}

impl Residual {
    /// Of a specification.
    ///
    /// # Errors
    /// Those of [`ResidualSpec::check`].
    pub fn new(spec: &ResidualSpec) -> Result<Self, Error> {
        spec.check()?;
        let channel = |(name, rows): (&String, &Vec<Vec<f64>>)| {
            let channel = CHANNELS.iter().position(|(known, _)| known == name)?;
            Some((channel, rows.concat()))
        };
        let rows = spec.loads.values().map(Vec::len).max().unwrap_or(1);
        Ok(Self {
            rate: TAU * spec.frequency_hz,
            place: Vec3(spec.place_m),
            low: spec.low_m_s,
            high: spec.high_m_s,
            terms: spec.terms.iter().filter_map(|name| Term::named(name)).collect(),
            harmonics: rows / 2,
            channels: spec.loads.iter().filter_map(channel).collect(),
        })
    }

    /// The wrench about the body's origin, in B, at a phase of the gait with its rate (rad, rad/s) and a velocity against the air in B, m/s:
    /// W = p'/(2 pi f) sum_r e_r(p) sum_j c_rj t_j(v), e_r = 1, cos p, sin p, cos 2p, ... with v held within the velocities at which it was
    /// measured. That it grows with the rate of the phase, so that still wings have none, is a *choice*.
    ///
    /// Equation: robot.residual_wrench
    /// `W = p'/(2 pi f) sum_r e_r(p) sum_j c_rj t_j(v), e = 1, cos p, sin p, cos 2p, ..., t products of the
    /// velocity's components at a place of the body, held within those measured`
    /// Source: definition; its growth with p' a choice.
    /// Test: `a_wrench_is_its_sum_of_waves_and_terms`.
    pub fn wrench<S: Scalar>(&self, phase: &Jet<S>, velocity: Vec3<S>) -> Wrench<S> {
        let held = Vec3([0, 1, 2].map(|i| velocity[i].clamped(self.low[i], self.high[i])));
        let terms: ArrayVec<S, MOST_TERMS> = self.terms.iter().map(|term| term.at(held)).collect();
        let mut waves: ArrayVec<S, { 1 + 2 * MOST_HARMONICS }> = ArrayVec::new();
        waves.push(S::ONE);
        let (sin, cos) = phase.x.sin_cos();
        let (mut s, mut c) = (S::ZERO, S::ONE);
        for _ in 0..self.harmonics {
            (s, c) = (s * cos + c * sin, c * cos - s * sin);
            waves.push(c);
            waves.push(s);
        }
        let mut loads = [S::ZERO; 6];
        for (channel, factors) in &self.channels {
            for (wave, row) in waves.iter().zip(factors.chunks_exact(terms.len())) {
                let of_row =
                    row.iter().zip(&terms).fold(S::ZERO, |sum, (factor, term)| sum + *term * *factor);
                loads[*channel] += *wave * of_row;
            }
        }
        let share = phase.d * (1.0 / self.rate);
        Wrench { force: Vec3::from_slice(&loads) * share, moment: Vec3::from_slice(&loads[3..]) * share }
    }

    /// Whether a velocity of its place, in B, is beyond those at which it was measured by 2 % of the speed (*choice*), or the rate of the gait's
    /// phase by 1 % of its own.
    fn is_beyond(&self, velocity: Vec3, rate: f64) -> bool {
        let room = BEYOND * velocity.norm();
        let out = |i: usize| !(self.low[i] - room..=self.high[i] + room).contains(&velocity[i]);
        (0..3).any(out) || (rate / self.rate - 1.0).abs() > RESIDUAL_FREQUENCY
    }
}

impl Robot {
    /// Whether the body, which moves with these against the air, in B, its gait at the rate `pace`, rad/s, is beyond what `robot.residual` was
    /// measured at; none without one.
    pub(super) fn beyond_residual(&self, [v, rate]: [Vec3; 2], pace: f64) -> Option<bool> {
        self.residual.as_ref().map(|residual| residual.is_beyond(v + rate.cross(residual.place), pace))
    }

    /// Names of preset and law of the first surface; none without a surface.
    pub fn model_of_air(&self) -> [String; 2] {
        let first = self.surfaces().next();
        first.map_or_else(Default::default, |(_, aero)| {
            [aero.preset().name().into(), aero.law().name().into()]
        })
    }

    /// Frequencies at which `robot.residual` holds, Hz; none without one.
    pub fn residual_frequencies(&self) -> Option<[f64; 2]> {
        let own = self.residual.as_ref()?.rate / TAU;
        Some([-1.0, 1.0].map(|side| own * (1.0 + side * RESIDUAL_FREQUENCY)))
    }

    /// Refuses a wrench that was measured at another frequency than the gait's, or that is what another model leaves.
    pub(super) fn check_residual(&self, spec: &ResidualSpec) -> Result<(), Error> {
        let (own, gait) = (spec.frequency_hz, self.frequency_hz());
        let holds = |[low, high]: [f64; 2]| (low..=high).contains(&gait);
        if gait > 0.0 && !self.residual_frequencies().is_some_and(holds) {
            let allowed = format!("the frequency of the gait, {gait} Hz, to 1 %: a wrench measured there");
            return Err(Error::invalid("residual.frequency_hz", own, allowed));
        }
        let [preset, law] = self.model_of_air();
        for (key, given, is) in [("preset", &spec.preset, preset), ("law", &spec.law, law)] {
            if let Some(given) = given.as_ref().filter(|given| **given != is) {
                let allowed =
                    format!("{is:?}, that of the robot's air: a wrench belongs to the model that leaves it");
                return Err(Error::invalid(format!("residual.{key}"), format!("{given:?}"), allowed));
            }
        }
        Ok(())
    }
}

impl<P: Scalar> Robot<P> {
    /// Load of the air on the body beside the surfaces: its drag, and what `robot.residual` says; `v` is the velocity against the air in B,
    /// `structure` as for [`Robot::joints`].
    pub(super) fn body_load<S: Scalar + Meets<P>>(
        &self,
        clock: &Jet<S>,
        (structure, u): (&[S], &[S]),
        (v, rate): (Vec3<S>, Vec3<S>),
    ) -> Wrench<S> {
        let drag = self.body_drag(v);
        let Some(residual) = &self.residual else { return drag };
        let mut displacements = [Jet::ZERO; super::MAX_ELEMENTS];
        self.response.displacements(structure, u, &mut displacements);
        let at_place = v + rate.cross(Vec3::constant(residual.place));
        drag + residual.wrench(&self.phase_of(clock, structure, &displacements), at_place)
    }
}

//! Springs on the pins of the linkage, the flexures of a compliant mechanism: they load the crank and the elements that change its
//! lengths by virtual work.

use super::drive::Ratios;
use super::mechanism::Spring;
use super::numbers::SpringNumbers;
use super::spec::PinSpringSpec;
use super::{MAX_ELEMENTS, Robot};
use crate::body::{Linkage, LinkagePin};
use arrayvec::ArrayVec;
use std::f64::consts::PI;
use wingbeat_math::{Error, Jet, Meets, Scalar};
use wingbeat_ocp::plant::Fault;

/// A spring on a pin of the linkages of both wings.
#[derive(Clone, Debug)]
pub(super) struct PinSpring<P: Scalar = f64> {
    pub pin: LinkagePin,
    pub spring: Spring<P>,
    /// Deflection from rest that it bears, rad.
    limit: Option<f64>,
    /// Middle of the pin's travel over a turn of the crank, rad.
    middle: f64,
}

/// Angles of the pins that have a spring, those of the left wing first, rad.
type PinAngles<S> = ArrayVec<Jet<S>, { 2 * LinkagePin::COUNT }>;

/// What the springs on the pins do at one instant.
#[derive(Clone, Debug, Default)]
pub struct PinWork {
    /// Angles of the pins, rad, in the order of [`Robot::pin_names`].
    pub angles: Vec<f64>,
    /// Energy stored, J.
    pub energy: f64,
    /// Power that the dampers take, W.
    pub dissipation: f64,
    /// Power that drive and actuators give to springs and dampers, W.
    pub given: [f64; 2],
    /// The same by wing, the left one first, W.
    pub by_wing: [f64; 2],
}

/// Largest deflection of pins from the rests of their springs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PinDeflection {
    /// Angle, rad.
    pub angle: f64,
    /// Largest share of the deflection that a spring bears; none where no limit is given.
    pub fraction: Option<f64>,
}

impl PinDeflection {
    /// The larger of both, number by number.
    #[must_use]
    pub fn largest(self, other: Self) -> Self {
        let fraction = match (self.fraction, other.fraction) {
            (Some(one), Some(another)) => Some(one.max(another)),
            (one, another) => one.or(another),
        };
        Self { angle: self.angle.max(other.angle), fraction }
    }
}

impl PinSpring {
    /// Those of a linkage.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key, beginning with the place in the list.
    pub fn all(specs: &[PinSpringSpec], linkage: &Linkage) -> Result<Vec<Self>, Error> {
        let of = |(i, spec): (usize, &PinSpringSpec)| {
            let PinSpringSpec { pin, stiffness, damping, limit, .. } = *spec;
            let middle = linkage.pin_middle(pin);
            let rest = spec.rest.unwrap_or(middle);
            let numbers = SpringNumbers { stiffness, damping, rest, stops: None };
            let spring = Self { pin, spring: Spring { numbers, start: rest }, limit, middle };
            spring.check_rest().map_err(|e| e.within(&format!("[{i}]")))?;
            Ok(spring)
        };
        specs.iter().enumerate().map(of).collect()
    }

    /// The same on a linkage of other dimensions; a rest in the middle of the travel stays there.
    pub fn on(&self, linkage: &Linkage) -> Self {
        let middle = linkage.pin_middle(self.pin);
        let Spring { mut numbers, mut start } = self.spring;
        if numbers.rest == self.middle {
            (numbers.rest, start) = (middle, middle);
        }
        Self { middle, spring: Spring { numbers, start }, ..self.clone() }
    }

    /// Refuses a rest that the pin cannot reach.
    pub fn check_rest(&self) -> Result<(), Error> {
        let (rest, middle) = (self.spring.numbers.rest, self.middle);
        if (rest - middle).abs() < PI {
            return Ok(());
        }
        let allowed = format!("within half a turn of the middle of the pin's travel, {middle:.4} rad");
        Err(Error::invalid("rest", rest, allowed))
    }
}

impl<P: Scalar> PinSpring<P> {
    /// Its deflection with the pin at `angle`, rad.
    fn deflection<S: Scalar + Meets<P>>(&self, angle: S) -> PinDeflection {
        let angle = (angle - self.spring.numbers.rest).value().abs();
        PinDeflection { angle, fraction: self.limit.map(|limit| angle / limit) }
    }

    /// The same with other numbers.
    pub fn with<Q: Scalar>(&self, numbers: &SpringNumbers<Q>) -> PinSpring<Q> {
        let spring = Spring { numbers: *numbers, start: self.spring.start };
        PinSpring { pin: self.pin, spring, limit: self.limit, middle: self.middle }
    }
}

impl<P: Scalar> Robot<P> {
    /// Angles of the pins that have a spring, the crank at `phase`, the structure displaced.
    fn pin_angles<S: Scalar + Meets<P>>(
        &self,
        phase: Jet<S>,
        displacements: &[Jet<S>],
    ) -> Result<PinAngles<S>, Fault> {
        let mut angles = PinAngles::new();
        self.poses(phase, displacements, |_, pose| {
            let of = |spring: &PinSpring<P>| spring.pin.angle(&pose.directions, spring.middle);
            angles.extend(self.mechanism.pin_springs.iter().map(of));
        })?;
        Ok(angles)
    }

    /// The springs of both sides, each with what belongs to it: an item of `angles`, in their order.
    fn each_pin_spring<'a, S: Copy>(
        &'a self,
        angles: &'a [S],
    ) -> impl Iterator<Item = (&'a PinSpring<P>, S)> + Clone {
        self.mechanism.pin_springs.iter().cycle().zip(angles.iter().copied())
    }

    /// Adds what springs and dampers on pins do along a crank under a motor and along elements with an inertia.
    ///
    /// Equation: robot.pin_springs
    /// `Q_x = sum_pins dtheta/dx tau, tau = -k (theta - rest) - c theta', x the crank's angle or a length of the linkage`
    /// Source: virtual work.
    /// Test: `springs_on_pins_load_crank_and_lengths_by_virtual_work`.
    #[inline]
    pub(super) fn load_by_pins<S: Scalar + Meets<P>>(
        &self,
        phase: &Jet<S>,
        displacements: &[Jet<S>],
        ratios: &mut Ratios<S>,
    ) -> Result<(), Fault> {
        if self.mechanism.pin_springs.is_empty() || (self.motor.is_none() && self.loaded.is_empty()) {
            return Ok(());
        }
        self.load_by_some(phase, displacements, ratios)
    }

    #[inline(never)]
    fn load_by_some<S: Scalar + Meets<P>>(
        &self,
        phase: &Jet<S>,
        displacements: &[Jet<S>],
        ratios: &mut Ratios<S>,
    ) -> Result<(), Fault> {
        let angles = self.pin_angles(*phase, displacements)?;
        let efforts: ArrayVec<S, { 2 * LinkagePin::COUNT }> = self
            .each_pin_spring(&angles)
            .map(|(of, angle)| of.spring.effort(angle.x, angle.d, S::ZERO))
            .collect();
        // The rates of the pins by the rate of one coordinate alone.
        let along = |crank: S, element: Option<usize>| -> Result<S, Fault> {
            let mut held = [Jet::ZERO; MAX_ELEMENTS];
            held.iter_mut().zip(displacements).for_each(|(held, y)| held.x = y.x);
            if let Some(element) = element {
                held[element].d = S::ONE;
            }
            let rates = self.pin_angles(Jet::new(phase.x, crank, S::ZERO), &held)?;
            Ok(rates.iter().zip(&efforts).fold(S::ZERO, |sum, (rate, effort)| sum + rate.d * *effort))
        };
        if self.motor.is_some() {
            ratios.crank_push = along(S::ONE, None)?;
        }
        for (loaded, push) in self.loaded.iter().zip(&mut ratios.pushes) {
            *push += along(S::ZERO, Some(loaded.element))?;
        }
        Ok(())
    }
}

impl Robot {
    /// Names of the pins that have a spring, as records have them: those of the left wing first.
    pub fn pin_names(&self) -> impl Iterator<Item = String> {
        let name = |side: &'static str| {
            self.mechanism.pin_springs.iter().map(move |of| format!("pin_{}{side}", of.pin.name()))
        };
        super::mechanism::SIDES.into_iter().flat_map(name)
    }

    /// The largest deflection of the pins that have a spring from their rests; `angles` in rad, in the order of
    /// [`pin_names`](Self::pin_names).
    pub fn pin_deflection(&self, angles: impl IntoIterator<Item = f64>) -> PinDeflection {
        let all =
            self.mechanism.pin_springs.iter().cycle().zip(angles).map(|(of, angle)| of.deflection(angle));
        all.fold(PinDeflection::default(), PinDeflection::largest)
    }

    /// Whether its linkage has springs on its pins.
    pub fn has_pin_springs(&self) -> bool {
        !self.mechanism.pin_springs.is_empty()
    }

    /// What the springs on the pins of a carried robot do in the state `x` under the inputs `u`; `clock` as for [`Robot::carried`].
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn carried_pins(&self, clock: &Jet, (x, u): (&[f64], &[f64])) -> Result<PinWork, Fault> {
        let mut displacements = [Jet::ZERO; MAX_ELEMENTS];
        self.response.displacements(x, u, &mut displacements);
        self.pin_work(self.phase_of(clock, x, &displacements), &displacements)
    }

    /// What the springs on the pins do, the crank at `phase`.
    pub(super) fn pin_work(&self, phase: Jet, displacements: &[Jet; MAX_ELEMENTS]) -> Result<PinWork, Fault> {
        // What is added to nothing must leave the sign of a zero.
        let mut work = PinWork { given: [-0.0; 2], ..PinWork::default() };
        if !self.has_pin_springs() {
            return Ok(work);
        }
        let angles = self.pin_angles(phase, displacements)?;
        let held = self.pin_angles(Jet::new(phase.x, 0.0, 0.0), displacements)?;
        for ((of, angle), held) in self.each_pin_spring(&angles).zip(&held) {
            let effort = of.spring.effort(angle.x, angle.d, 0.0);
            work.energy += of.spring.energy(angle.x, 0.0);
            work.dissipation += of.spring.dissipation(angle.d);
            work.given[0] -= effort * (angle.d - held.d);
            work.given[1] -= effort * held.d;
            let wing = work.angles.len() / self.mechanism.pin_springs.len();
            work.by_wing[wing] -= effort * angle.d;
            work.angles.push(angle.x);
        }
        Ok(work)
    }
}

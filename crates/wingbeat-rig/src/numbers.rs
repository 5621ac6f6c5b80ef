//! The numbers of mount and crank, which may carry derivatives.

use super::carrier::CellMount;
use std::collections::BTreeMap;
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::range::Range;
use wingbeat_math::{Declared, DeclaredQuantity, Jet, Mat3, NamedNumber, Parameters, Scalar, Vec3, Walk};
use wingbeat_robot::body::{MASS, PLACE};
use wingbeat_robot::check_given;

/// What a rig is beside what its file draws: how the body sits on the cell, what the mount weighs, how the crank runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigNumbers<P: Scalar = f64> {
    /// Body origin in the cell's frame beside where the rig has it, m.
    pub shift: Vec3<P>,
    /// Roll, pitch and yaw of the body beside the attitude that the rig has, rad.
    pub turn: Vec3<P>,
    /// Mass of the mount, kg.
    pub mass: P,
    /// Its centre in C, m.
    pub com: Vec3<P>,
    /// The crank runs ahead of the even phase that the encoder is taken to show by a cos(phase) + b sin(phase), rad.
    pub ripple: [P; 2],
}

impl RigNumbers {
    /// The mount as it is drawn, an even crank.
    pub fn of(mount: &CellMount) -> Self {
        let zero = Vec3::ZERO;
        Self { shift: zero, turn: zero, mass: mount.mass, com: mount.com, ripple: [0.0; 2] }
    }

    /// The same with those numbers of `given` that are the rig's.
    ///
    /// # Errors
    /// A name that begins as one of the rig's and is none.
    pub fn given(mut self, given: &BTreeMap<String, f64>) -> Result<Self, Error> {
        for (name, value) in given.iter().filter(|(name, _)| Self::names_one(name)) {
            self.set(name, *value)?;
        }
        let known = self.parameters();
        let given = |number: &NamedNumber| given.contains_key(&number.name);
        known.iter().filter(|number| given(number)).try_for_each(|number| {
            let key = format!("numbers.\"{}\"", number.name);
            let checked = check_given(&number.name, &number.quantity, number.value);
            checked.and_then(|()| number.check()).map_err(|e| e.renamed(&[(&number.name, key)]))
        })?;
        Ok(self)
    }

    /// Sets the number called `name`, in its declared unit.
    ///
    /// # Errors
    /// An unknown name.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), Error> {
        let known = self.parameters();
        if !known.iter().any(|number| number.name == name) {
            let known: Vec<&str> = known.iter().map(|number| number.name.as_str()).collect();
            return Err(Error::invalid("numbers", format!("{name:?}"), one_of(name, &known)));
        }
        let given = |number: Declared, own| if number.name == name { value } else { own };
        *self = self.map_named(&|_, _, _| None, |own| own, given);
        Ok(())
    }

    /// Its numbers with their names and what is declared of them.
    pub fn parameters(&self) -> Vec<NamedNumber> {
        self.named(&|_, _, _| None)
    }

    /// Whether `name` is one of the rig's, not of the robot's.
    pub fn names_one(name: &str) -> bool {
        wingbeat_robot::is_of_rig(name)
    }
}

/// Shift of the body beside where the rig has it.
const SHIFT: DeclaredQuantity = DeclaredQuantity::within("m", Range::between(-0.1, 0.1), -0.1, 0.1);
/// Turn of the body beside the attitude that the rig has.
const TURN: DeclaredQuantity = DeclaredQuantity::within("rad", Range::between(-0.5, 0.5), -0.5, 0.5);
/// Share of an uneven crank.
const RIPPLE: DeclaredQuantity = DeclaredQuantity::within("rad", Range::between(-0.3, 0.3), -0.3, 0.3);

impl<P: Scalar> Parameters<P> for RigNumbers<P> {
    type In<Q: Scalar> = RigNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> RigNumbers<Q> {
        RigNumbers {
            shift: at.vector("mount.shift_m", &[SHIFT; 3], self.shift),
            turn: at.vector("mount.turn_rad", &[TURN; 3], self.turn),
            mass: at.number("mount.mass_kg", &MASS, self.mass),
            com: at.vector("mount.com_m", &[PLACE; 3], self.com),
            ripple: at.array("crank.ripple_rad", &[RIPPLE; 2], self.ripple),
        }
    }
}

impl<P: Scalar> RigNumbers<P> {
    /// The mount with these numbers.
    pub fn mount(&self, drawn: &CellMount) -> CellMount<P> {
        let [roll, pitch, yaw] = self.turn.0;
        let turned = Mat3::<P>::constant(drawn.body.rotation) * Mat3::from_roll_pitch_yaw(roll, pitch, yaw);
        let origin = Vec3::<P>::constant(drawn.body.origin) + self.shift;
        CellMount {
            cell: drawn.cell,
            body: super::Pose { rotation: turned, origin },
            mass: self.mass,
            com: self.com,
            inertia: drawn.inertia,
        }
    }

    /// The gait's clock with the ripple of the crank over the phase that an encoder shows, zero at the begin; `rate` is that
    /// of the gait, rad/s.
    ///
    /// Equation: rig.crank_ripple
    /// `phase + a cos(phase) + b sin(phase)`
    /// Source: first harmonic of an uneven crank.
    /// Test: `the_crank_runs_ahead_by_its_ripple`.
    pub fn rippled(&self, clock: Jet, rate: f64) -> Jet<P> {
        let lifted = Jet::new(P::from(clock.x), P::from(clock.d), P::from(clock.dd));
        if rate == 0.0 {
            return lifted;
        }
        let (sin, cos) = (clock * rate).sin_cos();
        let ahead = |wave: Jet, share: P| Jet::new(share * wave.x, share * wave.d, share * wave.dd);
        lifted + ahead(cos / rate, self.ripple[0]) + ahead(sin / rate, self.ripple[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crank_runs_ahead_by_its_ripple() {
        let mount = CellMount {
            cell: crate::Pose::IDENTITY,
            body: crate::Pose::IDENTITY,
            mass: 0.1,
            com: Vec3::ZERO,
            inertia: Mat3::ZERO,
        };
        let mut numbers = RigNumbers::of(&mount);
        numbers.set("crank.ripple_rad[0]", 0.02).unwrap();
        numbers.set("crank.ripple_rad[1]", -0.01).unwrap();
        let phase = |t: f64| {
            let clock: Jet = numbers.rippled(Jet::new(t, 1.0, 0.0), 22.0);
            (22.0 * clock.x, 22.0 * clock.d)
        };
        let even: f64 = 22.0 * 0.07;
        let expected = even + 0.02 * even.cos() - 0.01 * even.sin();
        assert!((phase(0.07).0 - expected).abs() < 1e-14);
        let slope = (phase(0.07 + 1e-6).0 - phase(0.07 - 1e-6).0) / 2e-6;
        assert!((phase(0.07).1 - slope).abs() < 1e-6);
        assert!(numbers.set("crank.ripple_rad[2]", 0.0).unwrap_err().to_string().contains("mount.mass_kg"));
    }
}

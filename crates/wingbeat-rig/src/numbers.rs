//! The numbers of mount and crank, which may carry derivatives.

use super::carrier::Mount;
use std::collections::BTreeMap;
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::{Jet, Mat3, Scalar, Vec3};

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
    pub fn of(mount: &Mount) -> Self {
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
        Ok(self)
    }

    /// Sets the number called `name`.
    ///
    /// # Errors
    /// An unknown name.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), Error> {
        let mut named = self.by_name();
        if let Some((_, number)) = named.iter_mut().find(|(known, _)| known == name) {
            **number = value;
            return Ok(());
        }
        let known: Vec<&str> = named.iter().map(|(name, _)| name.as_str()).collect();
        Err(Error::invalid("numbers", format!("{name:?}"), one_of(name, &known)))
    }

    /// Names and values.
    pub fn named(&self) -> Vec<(String, f64)> {
        self.clone().by_name().into_iter().map(|(name, value)| (name, *value)).collect()
    }

    /// Whether `name` is one of the rig's, not of the robot's.
    pub fn names_one(name: &str) -> bool {
        wingbeat_robot::is_of_rig(name)
    }
}

impl<P: Scalar> RigNumbers<P> {
    /// The same numbers as constants of another scalar.
    pub fn constant(of: &RigNumbers) -> Self {
        let vector = Vec3::constant;
        Self {
            shift: vector(of.shift),
            turn: vector(of.turn),
            mass: P::from(of.mass),
            com: vector(of.com),
            ripple: of.ripple.map(P::from),
        }
    }

    /// All numbers by name.
    pub fn by_name(&mut self) -> Vec<(String, &mut P)> {
        let mut all: Vec<(String, &mut P)> = vec![("mount.mass_kg".into(), &mut self.mass)];
        let vectors = [("shift_m", &mut self.shift), ("turn_rad", &mut self.turn), ("com_m", &mut self.com)];
        for (key, vector) in vectors {
            all.extend(vector.0.iter_mut().enumerate().map(|(i, x)| (format!("mount.{key}[{i}]"), x)));
        }
        let ripple = self.ripple.iter_mut().enumerate();
        all.extend(ripple.map(|(i, x)| (format!("crank.ripple_rad[{i}]"), x)));
        all
    }

    /// The mount with these numbers.
    pub fn mount(&self, drawn: &Mount) -> Mount<P> {
        let [roll, pitch, yaw] = self.turn.0;
        let turned = Mat3::<P>::constant(drawn.body.rotation) * Mat3::from_roll_pitch_yaw(roll, pitch, yaw);
        let origin = Vec3::<P>::constant(drawn.body.origin) + self.shift;
        Mount {
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
        let mount = Mount {
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

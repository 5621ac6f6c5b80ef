//! How the robot that flies differs from the one its controller knows.

use super::AeroSpec;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::Vec3;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_robot::{GivenNumbers, Numbers, Robot, RobotSpec};

/// Factors and shifts of the flown robot alone, which act on it as its file and `robot.numbers` say it, and an air of its own.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct Mismatch {
    /// Factor on the air density.
    pub density: f64,
    /// Factor on the masses of body and links.
    pub mass: f64,
    /// Factor on their inertias about their own centres of mass; a spar is of several bodies.
    pub inertia: f64,
    /// Shift of the body's centre of mass forward, m.
    pub com_x_m: f64,
    /// Shift of the body's centre of mass to the left, m.
    pub com_y_m: f64,
    /// Shift of the body's centre of mass upward, m.
    pub com_z_m: f64,
    /// Factor on the amplitude of the gait; of a linkage, on its crank.
    pub gait_amplitude: f64,
    /// Factor on the natural frequency of the structure elements.
    pub regulator_bandwidth: f64,
    /// Factor on the stiffness of springs on joints and pins, spars, flaps and membranes. Damping that is given as a time follows it.
    pub stiffness: f64,
    /// Factor on the profile drag of the surfaces along the wind, cd0.
    pub profile_drag: f64,
    /// Factor on their drag broadside to the wind, cd90.
    pub broadside_drag: f64,
    /// Aerodynamics of the flown robot, in place of `aero`: another preset, law or grid. `robot.residual` belongs to `aero` and is left
    /// out. States of the air that the controller's model has and the flown robot lacks follow that model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aero: Option<AeroSpec>,
    /// Numbers of the flown robot by name, in place of `robot.numbers`; an empty table for those of the robot's file.
    /// `robot.residual` belongs to `robot.numbers` and is left out.
    /// The table may carry the `verdict` of the fit that wrote them: a flight with numbers of another one than `ok` says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "wingbeat_robot::numbers_table")]
    pub numbers: Option<GivenNumbers>,
}

impl Default for Mismatch {
    fn default() -> Self {
        Self {
            density: 1.0,
            mass: 1.0,
            inertia: 1.0,
            com_x_m: 0.0,
            com_y_m: 0.0,
            com_z_m: 0.0,
            gait_amplitude: 1.0,
            regulator_bandwidth: 1.0,
            stiffness: 1.0,
            profile_drag: 1.0,
            broadside_drag: 1.0,
            aero: None,
            numbers: None,
        }
    }
}

ranges!(Mismatch {
    density: Range::POSITIVE,
    mass: Range::POSITIVE,
    inertia: Range::POSITIVE,
    gait_amplitude: Range::POSITIVE,
    regulator_bandwidth: Range::POSITIVE,
    stiffness: Range::POSITIVE,
    profile_drag: Range::NOT_NEGATIVE,
    broadside_drag: Range::NOT_NEGATIVE,
});

impl Mismatch {
    /// Its keys.
    pub(super) const KEYS: [&str; 13] = [
        "density",
        "mass",
        "inertia",
        "com_x_m",
        "com_y_m",
        "com_z_m",
        "gait_amplitude",
        "regulator_bandwidth",
        "stiffness",
        "profile_drag",
        "broadside_drag",
        "aero",
        "numbers",
    ];

    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self, robot: &RobotSpec) -> Result<(), Error> {
        if robot.structure.a.is_some() && self.regulator_bandwidth != 1.0 {
            let allowed = "1 where the structure is given by its matrices";
            return Err(Error::invalid("regulator_bandwidth", self.regulator_bandwidth, allowed));
        }
        if self.stiffness != 1.0 && !robot.gives_way() {
            let allowed = "1 where the robot has no spring, spar, flap or membrane";
            return Err(Error::invalid("stiffness", self.stiffness, allowed));
        }
        if self.broadside_drag != 1.0 && robot.surfaces.iter().any(|surface| surface.cd90.is_none()) {
            let allowed = "1 where a surface of the robot says no cd90";
            return Err(Error::invalid("broadside_drag", self.broadside_drag, allowed));
        }
        if let Some(aero) = &self.aero {
            aero.check().map_err(|e| e.within("aero"))?;
        }
        require::finite("com_x_m", &[self.com_x_m])?;
        require::finite("com_y_m", &[self.com_y_m])?;
        require::finite("com_z_m", &[self.com_z_m])?;
        self.in_range()
    }

    /// What the flown robot's file says: numbers of its own take the place of those of the known robot.
    pub fn apply(&self, robot: &RobotSpec) -> RobotSpec {
        let mut real = robot.clone();
        if let Some(numbers) = &self.numbers {
            real.numbers = numbers.clone();
        }
        if self.aero.is_some() || self.numbers.is_some() {
            real.residual = None;
        }
        real
    }

    /// Makes the numbers of the flown `robot` of those that its file and `numbers` give it. Of the structure's elements the
    /// first `elements` are no thrusters.
    pub(super) fn deviate(&self, robot: &Robot, numbers: &mut Numbers, elements: usize) {
        robot.stiffen(numbers, self.stiffness);
        numbers.density *= self.density;
        for surface in &mut numbers.surfaces {
            surface.density *= self.density;
            surface.cd0 *= self.profile_drag;
            surface.cd90 *= self.broadside_drag;
        }
        for body in &mut numbers.bodies {
            body.mass *= self.mass;
            body.moments = body.moments * self.inertia;
        }
        numbers.bodies[0].com += Vec3::new(self.com_x_m, self.com_y_m, self.com_z_m);
        for harmonic in numbers.series.iter_mut().flat_map(|(series, _)| &mut series.harmonics) {
            harmonic.amplitude_rad *= self.gait_amplitude;
        }
        if let Some(dimensions) = &mut numbers.linkage {
            dimensions.l1_m *= self.gait_amplitude;
        }
        numbers.response.scale_frequency(self.regulator_bandwidth, elements);
    }
}

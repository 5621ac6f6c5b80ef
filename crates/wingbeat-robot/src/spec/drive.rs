//! What turns the crank of the gait.

use crate::body::{EFFICIENCY, GEAR_RATIO, Motor, NO_LOAD_SPEED, STALL_TORQUE};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// What turns the crank of the gait: without a motor it turns at the gait's frequency whatever the load.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveSpec {
    /// A motor that turns the cranks of all driven joints: angle and rate of the crank, which is the
    /// gait's phase, are states and start at the start's phase and the gait's frequency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorSpec>,
}

/// A direct-current motor behind a gearbox. Its torque-speed line is given by `stall_torque_n_m` and
/// `no_load_speed_rad_s`, or by `torque_constant_n_m_a`, `resistance_ohm` and `supply_v`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct MotorSpec {
    /// Torque of the shaft held still, N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stall_torque_n_m: Option<f64>,
    /// Speed of the free shaft, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_load_speed_rad_s: Option<f64>,
    /// Torque per current, N m/A; also voltage per speed, V s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_constant_n_m_a: Option<f64>,
    /// Resistance of the winding, ohm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resistance_ohm: Option<f64>,
    /// Voltage of the supply, V.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply_v: Option<f64>,
    /// Turns of the shaft per turn of the crank.
    pub gear_ratio: f64,
    /// Share of the power that passes the gearbox, above 0 and at most 1.
    #[serde(default = "lossless")]
    pub efficiency: f64,
    /// Inertia of the rotor about its axis, kg m2.
    pub rotor_inertia_kg_m2: f64,
    /// Inertia of cranks and gears about the crank's axis, all together, kg m2.
    #[serde(default)]
    pub crank_inertia_kg_m2: f64,
}

fn lossless() -> f64 {
    1.0
}

ranges!(MotorSpec {
    stall_torque_n_m: STALL_TORQUE.range,
    no_load_speed_rad_s: NO_LOAD_SPEED.range,
    torque_constant_n_m_a: Range::POSITIVE,
    resistance_ohm: Range::POSITIVE,
    supply_v: Range::POSITIVE,
    gear_ratio: GEAR_RATIO.range,
    efficiency: EFFICIENCY.range,
    rotor_inertia_kg_m2: Range::POSITIVE,
    crank_inertia_kg_m2: Range::NOT_NEGATIVE,
});

impl DriveSpec {
    /// Whether the crank turns at a constant rate.
    pub fn is_constant(&self) -> bool {
        self.motor.is_none()
    }

    /// The motor, if there is one.
    pub(crate) fn build(&self) -> Result<Option<Motor>, Error> {
        self.motor.as_ref().map(MotorSpec::build).transpose().map_err(|e| e.within("motor"))
    }
}

impl MotorSpec {
    fn build(&self) -> Result<Motor, Error> {
        self.in_range()?;
        let (stall_torque, no_load_speed) = self.line()?;
        let inertia = self.rotor_inertia_kg_m2 * self.gear_ratio.powi(2) + self.crank_inertia_kg_m2;
        let (gear_ratio, efficiency) = (self.gear_ratio, self.efficiency);
        Ok(Motor { stall_torque, no_load_speed, gear_ratio, efficiency, inertia })
    }

    /// Stall torque and no-load speed.
    fn line(&self) -> Result<(f64, f64), Error> {
        let line =
            [("stall_torque_n_m", self.stall_torque_n_m), ("no_load_speed_rad_s", self.no_load_speed_rad_s)];
        let constants = [
            ("torque_constant_n_m_a", self.torque_constant_n_m_a),
            ("resistance_ohm", self.resistance_ohm),
            ("supply_v", self.supply_v),
        ];
        let by_constants = constants.iter().any(|(_, value)| value.is_some());
        if let (true, Some((key, value))) = (by_constants, line.iter().find_map(|(k, v)| Some((k, (*v)?)))) {
            let allowed = "either the ends of the torque-speed line or the constants of the motor";
            return Err(Error::invalid(*key, value, allowed));
        }
        let given = |(key, value): (&str, Option<f64>)| {
            value.ok_or_else(|| Error::invalid(key, "missing", "a finite number above 0"))
        };
        if by_constants {
            let [kt, ohm, volt] = [given(constants[0])?, given(constants[1])?, given(constants[2])?];
            return Ok((kt * volt / ohm, volt / kt));
        }
        Ok((given(line[0])?, given(line[1])?))
    }
}

//! A direct-current motor that turns a crank through a gearbox.

use super::{Drive, Shaft, Turns};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{DeclaredQuantity, Meets, Parameters, Scalar, Walk};

/// Share of the stall torque over which the corner of the gearbox's friction is rounded off.
const TORQUE_ROUNDING: f64 = 1e-3;
/// Share of the no-load speed over which the friction changes its direction.
const SPEED_ROUNDING: f64 = 1e-3;

/// A motor with a straight torque-speed line, its gearbox, and what turns with them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor<P = f64> {
    /// Torque of the shaft held still at full supply, N m.
    pub stall_torque: P,
    /// Speed of the free shaft at full supply, rad/s.
    pub no_load_speed: P,
    /// Turns of the shaft per turn of the crank.
    pub gear_ratio: P,
    /// Share of the power that passes the gearbox, in (0, 1], either way.
    pub efficiency: P,
    /// Inertia of rotor and crank about the crank's axis, kg m2.
    pub inertia: P,
}

/// Torque of the shaft held still at full supply.
const STALL_TORQUE: DeclaredQuantity = DeclaredQuantity::within("N m", Range::POSITIVE, 0.0, 1e6);
/// Speed of the free shaft at full supply.
const NO_LOAD_SPEED: DeclaredQuantity = DeclaredQuantity::within("rad/s", Range::POSITIVE, 0.0, 1e6);
/// Turns of the shaft per turn of the crank.
const GEAR_RATIO: DeclaredQuantity = DeclaredQuantity::within("", Range::POSITIVE, 0.0, 1e6);
/// Share of the power that passes the gearbox.
const EFFICIENCY: DeclaredQuantity = DeclaredQuantity::within("", Range::over(0.0, 1.0), 1e-3, 1.0);
/// Inertia of rotor and crank about the crank's axis.
const CRANK_INERTIA: DeclaredQuantity = DeclaredQuantity::within("kg m2", Range::POSITIVE, 0.0, 1e6);

impl<P: Scalar> Parameters<P> for Motor<P> {
    type In<Q: Scalar> = Motor<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> Motor<Q> {
        Motor {
            stall_torque: at.number("stall_torque_n_m", &STALL_TORQUE, self.stall_torque),
            no_load_speed: at.number("no_load_speed_rad_s", &NO_LOAD_SPEED, self.no_load_speed),
            gear_ratio: at.number("gear_ratio", &GEAR_RATIO, self.gear_ratio),
            efficiency: at.number("efficiency", &EFFICIENCY, self.efficiency),
            inertia: at.number("inertia_kg_m2", &CRANK_INERTIA, self.inertia),
        }
    }
}

impl<P: Scalar> Motor<P> {
    /// Equation: body.motor_line
    /// `tau = tau_s (s - w / w_0), w = N w_crank; tau_s = k_t V / R, w_0 = V / k_t`
    /// Source: direct-current motor, V = R I + k_t w, tau = k_t I.
    /// Test: `the_line_runs_from_stall_to_no_load_and_heat_is_what_the_winding_takes`.
    ///
    /// Torque of the shaft, N m, at the crank's rate (rad/s) under the share `supply` of the supply
    /// voltage: tau = tau_s (s - w / w_0), w = N w_crank. By the constants of the motor tau = k_t I,
    /// V = R I + k_t w: tau_s = k_t V / R and w_0 = V / k_t.
    pub fn shaft_torque<S: Scalar + Meets<P>>(&self, crank_rate: S, supply: S) -> S {
        (supply - crank_rate * (self.gear_ratio / self.no_load_speed)) * self.stall_torque
    }
}

impl<P: Scalar> Turns<P> for Motor<P> {
    /// Equation: body.gearbox
    /// `N [tau - s ((1 - eta) p + (1/eta - 1) n)], s sign of the rate, p and n positive parts of s tau and -s tau`
    /// Source: efficiency either way; corners rounded off, a choice.
    /// Test: `the_gearbox_takes_its_share_either_way`.
    ///
    /// Torque on the crank, N m: N tau less the friction of the gearbox, which takes the share
    /// 1 - eta of the power that enters it, from the motor or from the crank,
    /// N [tau - s ((1 - eta) p + (1/eta - 1) n)], s the sign of the rate, p and n the positive parts of s tau
    /// and -s tau, all smooth. The torque that accelerates the rotor passes without friction.
    fn crank_torque<S: Scalar + Meets<P>>(&self, crank_rate: S, supply: S) -> S {
        let torque = self.shaft_torque(crank_rate, supply);
        let width = self.no_load_speed / self.gear_ratio * SPEED_ROUNDING;
        let sign = crank_rate / (crank_rate * crank_rate + width * width).sqrt();
        let along = torque * sign;
        let rounding = self.stall_torque * TORQUE_ROUNDING;
        let positive = |x: S| (x + (x * x + rounding * rounding).sqrt()) * 0.5;
        let friction =
            positive(along) * (-self.efficiency + 1.0) + positive(-along) * (self.efficiency.recip() - 1.0);
        (torque - sign * friction) * self.gear_ratio
    }

    fn inertia(&self) -> P {
        self.inertia
    }
}

impl Drive for MotorSpec {
    type Built = Motor;

    fn build(&self) -> Result<Motor, Error> {
        self.in_range()?;
        let (stall_torque, no_load_speed) = self.line()?;
        let inertia = self.rotor_inertia_kg_m2 * self.gear_ratio.powi(2) + self.crank_inertia_kg_m2;
        let (gear_ratio, efficiency) = (self.gear_ratio, self.efficiency);
        Ok(Motor { stall_torque, no_load_speed, gear_ratio, efficiency, inertia })
    }

    /// The electrical power is V I = s tau w_0.
    fn shaft(motor: &Motor, crank_rate: f64, supply: f64) -> Shaft {
        let torque = motor.shaft_torque(crank_rate, supply);
        let power = torque * crank_rate * motor.gear_ratio;
        Shaft { torque, power, electrical_power: supply * torque * motor.no_load_speed }
    }
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

impl MotorSpec {
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

#[cfg(test)]
mod tests {
    use super::super::CrankMotor;
    use super::*;
    use wingbeat_math::Dual;

    const MOTOR: Motor =
        Motor { stall_torque: 2e-3, no_load_speed: 3000.0, gear_ratio: 50.0, efficiency: 0.7, inertia: 1e-5 };

    #[test]
    fn the_gearbox_takes_its_share_either_way() {
        for (rate, supply) in [(20.0, 1.0), (40.0, 0.5), (-20.0, -1.0), (-20.0, 1.0)] {
            let work = CrankMotor::Motor(MOTOR).work(0.0, rate, supply);
            let crank = work.crank_torque * rate;
            let passed =
                if work.shaft_power > 0.0 { crank / work.shaft_power } else { work.shaft_power / crank };
            assert!((passed - 0.7).abs() < 1e-4, "{rate} {supply}: {passed}");
            assert!(crank < work.shaft_power);
        }
        let ideal = Motor { efficiency: 1.0, ..MOTOR };
        assert_eq!(ideal.crank_torque(20.0, 1.0), 50.0 * ideal.shaft_torque(20.0, 1.0));
    }

    #[test]
    fn the_line_runs_from_stall_to_no_load_and_heat_is_what_the_winding_takes() {
        assert_eq!(MOTOR.shaft_torque(0.0, 1.0), 2e-3);
        assert!(MOTOR.shaft_torque(60.0, 1.0).abs() < 1e-15);
        let (kt, ohm, volt) = (1e-3, 1.5, 3.0);
        let motor = Motor { stall_torque: kt * volt / ohm, no_load_speed: volt / kt, ..MOTOR };
        for supply in [1.0, 0.6] {
            let work = CrankMotor::Motor(motor).work(0.0, 31.0, supply);
            let current = work.shaft_torque / kt;
            assert!((work.electrical_power - supply * volt * current).abs() < 1e-12);
            let heat = work.electrical_power - work.shaft_power;
            assert!((heat - ohm * current * current).abs() < 1e-12, "{heat}");
        }
    }

    #[test]
    fn torque_is_smooth_through_standstill_and_no_load() {
        for rate in [0.0, 0.02, 59.99, 60.0, 60.05] {
            let torque = |rate: f64| MOTOR.crank_torque(rate, 1.0);
            let h = 1e-7;
            let difference = (torque(rate + h) - torque(rate - h)) / (2.0 * h);
            let exact = MOTOR.crank_torque(Dual::<1>::variable(rate, 0), Dual::ONE).eps[0];
            assert!((difference - exact).abs() < 1e-5 * exact.abs(), "{rate}: {difference} {exact}");
        }
    }
}

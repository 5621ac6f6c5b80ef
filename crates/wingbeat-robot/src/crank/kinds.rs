//! The table `[drive]` and the motors, made of their list.

/// Declares [`DriveSpec`](super::DriveSpec) with a table for each motor of the list, and [`CrankMotor`](super::CrankMotor) with an arm for
/// each.
macro_rules! motors {
    ($($(#[$doc:meta])* $key:ident: $module:ident::$spec:ident => $model:ident,)+) => {
        $(pub use $module::*;)+

        /// What turns the crank of the gait: without a motor it turns at the gait's frequency whatever the load.
        #[derive(Clone, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct DriveSpec {
            $(
                $(#[$doc])*
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub $key: Option<$module::$spec>,
            )+
        }

        impl DriveSpec {
            /// Names of the motors: their tables, and what the names of their numbers begin with.
            pub const NAMES: &[&str] = &[$(stringify!($key)),+];

            /// The names of those that are given.
            pub fn given(&self) -> Vec<&'static str> {
                let mut names = Vec::new();
                $(names.extend(self.$key.as_ref().map(|_| stringify!($key)));)+
                names
            }

            /// Whether the crank turns at a constant rate.
            pub fn is_constant(&self) -> bool {
                self.given().is_empty()
            }

            /// The motor, if there is one.
            pub(crate) fn build(&self) -> Result<Option<CrankMotor>, Error> {
                if let [one, another, ..] = self.given()[..] {
                    let allowed = format!("one motor; {one} is given too");
                    return Err(Error::invalid(another, "given", allowed));
                }
                $(
                    if let Some(spec) = &self.$key {
                        let built = Drive::build(spec).map_err(|error| error.within(stringify!($key)))?;
                        return Ok(Some(CrankMotor::$model(built)));
                    }
                )+
                Ok(None)
            }
        }

        /// What turns a crank.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum CrankMotor<P = f64> {
            $($(#[$doc])* $model($model<P>),)+
        }

        impl<P: Scalar> CrankMotor<P> {
            /// Torque on the crank, N m, at its rate, rad/s, under the share `supply` of the supply.
            #[inline]
            pub fn crank_torque<S: Scalar + Meets<P>>(&self, crank_rate: S, supply: S) -> S {
                match self {
                    $(Self::$model(motor) => motor.crank_torque(crank_rate, supply),)+
                }
            }

            /// Inertia of all that turns with the crank, about its axis, kg m2.
            #[inline]
            pub fn inertia(&self) -> P {
                match self {
                    $(Self::$model(motor) => motor.inertia(),)+
                }
            }
        }

        impl CrankMotor {
            /// All that it does at the crank's angle, rad, and rate, rad/s, under the share `supply` of the supply.
            pub fn work(&self, crank_angle: f64, crank_rate: f64, supply: f64) -> MotorWork {
                let shaft = match self {
                    $(Self::$model(motor) => $spec::shaft(motor, crank_rate, supply),)+
                };
                MotorWork {
                    crank_angle,
                    crank_rate,
                    crank_torque: self.crank_torque(crank_rate, supply),
                    shaft_torque: shaft.torque,
                    shaft_power: shaft.power,
                    electrical_power: shaft.electrical_power,
                    energy: 0.5 * self.inertia() * crank_rate * crank_rate,
                }
            }
        }

        impl<P: Scalar> Parameters<P> for CrankMotor<P> {
            type In<Q: Scalar> = CrankMotor<Q>;

            fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> CrankMotor<Q> {
                match self {
                    $(Self::$model(motor) => {
                        CrankMotor::$model(at.within(stringify!($key), |at| motor.walk(at)))
                    })+
                }
            }
        }
    };
}
pub(super) use motors;

//! The table `[sensors]`, made of the list of instruments.

use super::SensorSpec;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_ocp::plant::{Channel, Role};

/// Declares [`SensorSpec`], with a table for each instrument of the list, and what runs over them.
macro_rules! instruments {
    ($($(#[$doc:meta])* $key:ident: $module:ident::$spec:ident,)+) => {
        $(pub use $module::$spec;)+

        /// Standard deviations of white noise per measurement, and the delay of the
        /// measurement chain. States not named here are known exactly. Where there are instruments, they alone are told.
        #[derive(Clone, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
        #[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
        #[serde(deny_unknown_fields, default)]
        pub struct SensorSpec {
            /// Position, m.
            pub position_m: f64,
            /// Attitude, deg about each body axis.
            pub attitude_deg: f64,
            /// Velocity, m/s.
            pub velocity_m_s: f64,
            /// Angular rate, rad/s.
            pub rate_rad_s: f64,
            /// Displacements of the structure, in their own unit.
            pub displacement: f64,
            /// Age of the newest measurement in whole controller updates.
            pub delay_updates: usize,
            $(
                $(#[$doc])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $key: Option<$module::$spec>,
            )+
        }

        impl SensorSpec {
            /// Names of the tables of instruments.
            pub const INSTRUMENTS: &[&str] = &[$(stringify!($key)),+];

            /// The instruments there are, in the order of the tables.
            pub fn instruments(&self) -> Vec<Instrument> {
                self.named_instruments().into_iter().map(|(_, instrument)| instrument).collect()
            }

            /// The same, each with the name of its table.
            pub(super) fn named_instruments(&self) -> Vec<(&'static str, Instrument)> {
                let mut all = Vec::new();
                $(
                    let of_table = self.$key.iter().flat_map(Sensor::instruments);
                    all.extend(of_table.map(|instrument| (stringify!($key), instrument)));
                )+
                all
            }

            /// One ordinary instrument of each kind, by the name of its table: what a robot could have.
            pub(crate) fn examples() -> Vec<(&'static str, Vec<Instrument>)> {
                vec![$((stringify!($key), $module::$spec::ORDINARY.instruments())),+]
            }

            /// Refuses instruments out of range.
            fn check_instruments(&self) -> Result<(), Error> {
                $(
                    if let Some(instrument) = &self.$key {
                        Sensor::check(instrument).map_err(|error| error.within(stringify!($key)))?;
                    }
                )+
                Ok(())
            }
        }
    };
}
pub(super) use instruments;

/// Oldest measurement, in updates: all up to it are kept.
const MAX_DELAY: usize = 1000;

ranges!(SensorSpec {
    position_m: Range::NOT_NEGATIVE,
    attitude_deg: Range::NOT_NEGATIVE,
    velocity_m_s: Range::NOT_NEGATIVE,
    rate_rad_s: Range::NOT_NEGATIVE,
    displacement: Range::NOT_NEGATIVE,
    delay_updates: Range::between(0.0, MAX_DELAY as f64),
});

impl SensorSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.check_instruments()?;
        if !self.reads() {
            return Ok(());
        }
        let of_states = [
            ("position_m", self.position_m),
            ("attitude_deg", self.attitude_deg),
            ("velocity_m_s", self.velocity_m_s),
            ("rate_rad_s", self.rate_rad_s),
            ("displacement", self.displacement),
            ("delay_updates", self.delay_updates as f64),
        ];
        match of_states.into_iter().find(|(_, value)| *value != 0.0) {
            Some((key, value)) => {
                Err(Error::invalid(key, value, "0 beside instruments, which alone are told"))
            }
            None => Ok(()),
        }
    }

    /// Whether there are instruments, so that no state is told.
    pub fn reads(&self) -> bool {
        !self.instruments().is_empty()
    }

    /// Standard deviation of a channel; the attitude turns as a whole.
    pub(super) fn deviation(&self, channel: &Channel) -> f64 {
        match channel.role {
            Role::Position(_) => self.position_m,
            Role::Velocity(_) => self.velocity_m_s,
            Role::AngularRate(_) => self.rate_rad_s,
            Role::Displacement(_) => self.displacement,
            _ => 0.0,
        }
    }
}

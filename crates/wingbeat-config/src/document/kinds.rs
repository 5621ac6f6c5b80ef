//! Documents of whole kinds, read and written here: a crate that calls [`Document::parse`] or [`Document::value`] compiles readers and
//! writers of every table anew.

use wingbeat_robot::RobotSpec;

use super::{ConfigError, Document};
use crate::ScenarioSpec;

impl Document {
    /// The document as a robot.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse).
    pub fn robot(&self) -> Result<RobotSpec, ConfigError> {
        self.parse()
    }

    /// The merged document as a scenario.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse).
    pub fn scenario(&self) -> Result<ScenarioSpec, ConfigError> {
        self.parse()
    }

    /// A scenario as a document; errors call it `name`.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    pub fn of_scenario(name: &str, spec: &ScenarioSpec) -> Result<Self, ConfigError> {
        Self::value(name, spec)
    }
}

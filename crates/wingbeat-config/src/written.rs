//! Values as text.

use erased_serde::Serialize;

/// A value as TOML. What serde derives is compiled for every type that writes: here that is one, behind pointers.
///
/// # Errors
/// A value that TOML cannot hold.
pub fn toml(value: &dyn Serialize) -> Result<String, toml::ser::Error> {
    toml::to_string(value)
}

/// A value as TOML holds it.
///
/// # Errors
/// A value that TOML cannot hold.
pub fn tree(value: &dyn Serialize) -> Result<toml::Value, toml::ser::Error> {
    toml::Value::try_from(value)
}

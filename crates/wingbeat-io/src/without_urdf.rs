//! What stands for URDF files in a build that does not read them: messages that say so.

use std::path::Path;

use wingbeat::rig::arm::ArmConfig;

use crate::{Error, not_built};

/// Reads an arm, in a build with feature `urdf`.
///
/// # Errors
/// Always: this build reads no URDF file.
pub fn read_urdf(path: &Path, tip: Option<&str>) -> Result<ArmConfig, Error> {
    parse_urdf("", tip).map_err(|what| Error::format(path, what))
}

/// The same from the text of a file.
///
/// # Errors
/// Always: this build reads no URDF file.
pub fn parse_urdf(_: &str, _: Option<&str>) -> Result<ArmConfig, String> {
    Err(not_built("a URDF file"))
}

/// The arm of a file whose name ends in `.urdf`: refused. `None` for other files.
pub fn urdf_as_toml(path: &Path, _: Option<&str>) -> Option<Result<String, String>> {
    let urdf = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("urdf"));
    urdf.then(|| Err(not_built("a URDF file")))
}

//! What a run says of keys that none of its models hears.

use super::spec::AeroSpec;
use wingbeat_aero::{Aero, Preset};
use wingbeat_judge::Warning;

/// The key whose term the strip model alone has.
const TURNING_IMPULSE: &str = "aero.full.turning_impulse";

/// The warning that `aero` leaves out the turning impulse and none of `models` is the strip model of preset `full`.
pub(super) fn turning_impulse<'a>(
    aero: &AeroSpec,
    models: impl IntoIterator<Item = &'a Aero>,
) -> Option<Warning> {
    let presets: Vec<Preset> = models.into_iter().map(Aero::preset).collect();
    let deaf = !aero.full.turning_impulse && !presets.contains(&Preset::Full);
    let preset = presets.first().filter(|_| deaf)?.name();
    let text = format!("{TURNING_IMPULSE} = false has no effect: preset `{preset}` lacks the term");
    Some(Warning::new("aero.unheard", text).key(TURNING_IMPULSE))
}

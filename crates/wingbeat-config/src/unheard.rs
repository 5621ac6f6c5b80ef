//! What a run says of keys that none of its models hears.

use super::spec::{AeroSpec, FullAeroSpec};
use wingbeat_aero::{Aero, Preset};
use wingbeat_judge::Warning;

/// A key whose term the strip model alone has, the value that is not the default, and whether settings have it.
type StripKey = (&'static str, bool, fn(&FullAeroSpec) -> bool);

/// All of them.
const STRIP_KEYS: [StripKey; 2] = [
    ("aero.full.turning_impulse", false, |full| full.turning_impulse),
    ("aero.full.side_edges", true, |full| full.side_edges),
];

/// The warnings that `aero` changes a term and none of `models` is the strip model of preset `full`.
pub(super) fn strip_keys<'a>(
    aero: &AeroSpec,
    models: impl IntoIterator<Item = &'a Aero>,
) -> impl Iterator<Item = Warning> + use<'a> {
    let presets: Vec<Preset> = models.into_iter().map(Aero::preset).collect();
    let preset = presets.first().filter(|_| !presets.contains(&Preset::Full)).map(|preset| preset.name());
    let changed = STRIP_KEYS.map(|(key, value, of)| (of(&aero.full) == value).then_some((key, value)));
    changed.into_iter().flatten().filter_map(move |(key, value)| {
        let text = format!("{key} = {value} has no effect: preset `{}` lacks the term", preset?);
        Some(Warning::new("aero.unheard", text).key(key))
    })
}

//! Class 2: many keys, many overrides, names that are no text; the other cases are data, `ranges.toml` and `documents.toml`.

use std::fs;
use std::os::unix::ffi::OsStringExt;

use super::case::ScriptedCase;
use super::data::GLIDE;

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    vec![
        ScriptedCase::new(2, "file_many_keys", |place| {
            let keys: String = (0..300_000).map(|i| format!("k{i} = 1\n")).collect();
            place.write("bad.toml", &keys)?;
            let before = place.state()?;
            place.run(&["fly", "bad.toml"])?.exits(2)?.says(&["bad.toml", "unknown key"])?;
            place.unchanged(&before)
        }),
        ScriptedCase::new(2, "many_overrides", |place| {
            place.write_texts()?;
            place.write("big.toml", &format!("{GLIDE}# {}\n", "x".repeat(4 << 20)))?;
            let mut words = vec!["fly", "big.toml"];
            (0..200).for_each(|_| words.extend(["--set", "air.gust_m_s=0.0"]));
            place.run(&words)?.exits(2)?.says(&["fewer or shorter"]).map(drop)
        }),
        ScriptedCase::new(2, "not_text_file", |place| {
            let name = std::ffi::OsString::from_vec(b"a\xff.toml".to_vec());
            place.call(&["fly"]).argument(name).run()?.exits(2).map(drop)
        }),
        ScriptedCase::new(2, "not_text_set", |place| {
            place.write_texts()?;
            let set = std::ffi::OsString::from_vec(b"name=a\xff".to_vec());
            place.call(&["fly", "glide.toml", "--set"]).argument(set).run()?.exits(2).map(drop)
        }),
        ScriptedCase::new(2, "not_text_path", |place| {
            use std::os::unix::ffi::OsStrExt;
            let name = std::ffi::OsStr::from_bytes(b"a\xff.toml");
            place.write("glide.toml", GLIDE)?;
            let moved = fs::rename(place.path("glide.toml"), place.folder.join(name));
            moved.map_err(|error| error.to_string())?;
            place.call(&["fly", "--out", "a", "--quiet"]).argument(name.into()).run()?.exits(0)?;
            place.run(&["fly", "a/scenario.toml", "--out", "b", "--quiet"])?.exits(0).map(drop)
        }),
    ]
}

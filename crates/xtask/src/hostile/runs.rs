//! Class 1: names that are no text, a place that is taken meanwhile; the other cases are data, `places.toml`.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::time::Duration;

use super::case::ScriptedCase;

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    vec![not_text(), taken_meanwhile()]
}

/// A name that is not UTF-8 is refused before the flight.
fn not_text() -> ScriptedCase {
    ScriptedCase::new(1, "out_not_text", |place| {
        place.write_texts()?;
        let before = place.state()?;
        let call =
            place.call(&["fly", "glide.toml", "--out"]).argument(OsString::from_vec(b"a\xff".to_vec()));
        call.run()?.exits(2)?.says(&["--out", "UTF-8"])?;
        place.unchanged(&before)
    })
}

fn taken_meanwhile() -> ScriptedCase {
    ScriptedCase::new(1, "place_taken_meanwhile", |place| {
        place.write_texts()?;
        let call =
            place.call(&["fly", "glide.toml", "--quiet", "--out", "a", "--set", "flight.duration_s=3"]);
        let running = call.start()?;
        std::thread::sleep(Duration::from_millis(300));
        place.write("a/thesis.txt", "years of work")?;
        let before = place.state()?;
        running.end(Duration::from_secs(60))?;
        let thesis = place.path("a/thesis.txt");
        let kept = before.get(&thesis) == place.state()?.get(&thesis);
        match kept && !place.path("a/manifest.json").exists() {
            true => Ok(()),
            false => Err("wrote over a folder that came meanwhile".into()),
        }
    })
    .long()
}

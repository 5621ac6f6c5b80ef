//! A scripted case and its most frequent form.

use super::place::CaseFolder;

/// Why a case failed.
pub type CaseOutcome = Result<(), String>;

/// A script that is played in a folder of its own.
pub struct ScriptedCase {
    /// The class of what could go wrong.
    pub class: u8,
    /// Unique in its class, fit for a folder.
    pub name: String,
    /// Part of the tests: takes less than a second.
    pub quick: bool,
    /// Needs the machine to itself: times are judged.
    pub alone: bool,
    /// What is done and judged.
    pub play: Box<dyn Fn(&CaseFolder) -> CaseOutcome + Send + Sync>,
}

impl ScriptedCase {
    /// A short script.
    pub fn new(
        class: u8,
        name: impl Into<String>,
        play: impl Fn(&CaseFolder) -> CaseOutcome + Send + Sync + 'static,
    ) -> Self {
        Self { class, name: name.into(), quick: true, alone: false, play: Box::new(play) }
    }

    /// The same, too long for the tests.
    pub fn long(self) -> Self {
        Self { quick: false, ..self }
    }

    /// The same, run while no other case runs.
    pub fn alone(self) -> Self {
        Self { alone: true, ..self }
    }
}

/// A call that must be refused: `files` (name, text) are written, then the program is called with `arguments`; it
/// exits with 2, says each of `words`, and leaves the folder as it was. `{root}` stands for the repository in texts and
/// arguments.
pub fn refused(
    class: u8,
    name: &str,
    files: &[(&str, &str)],
    arguments: &[&str],
    words: &[&str],
) -> ScriptedCase {
    let own = |list: &[&str]| -> Vec<String> { list.iter().map(|word| (*word).to_owned()).collect() };
    let files: Vec<(String, String)> = files.iter().map(|(n, text)| ((*n).into(), (*text).into())).collect();
    let (arguments, words) = (own(arguments), own(words));
    ScriptedCase::new(class, name, move |place| {
        files.iter().try_for_each(|(name, text)| place.write(name, text))?;
        let before = place.state()?;
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        place.run(&arguments)?.exits(2)?.says(&words)?;
        place.unchanged(&before)
    })
}

//! The name of a run, which becomes that of a folder and of files.

use std::fmt;

use wingbeat_math::Error;

/// Longest name, bytes: systems allow 255, and names are lengthened (`.NAME-12.partial`). *Choice.*
const LONGEST: usize = 100;
/// Names of what a run folder holds beside the files called after runs.
const TAKEN: [&str; 8] =
    ["manifest", "summary", "figures", "envelope", "record", "report", "unfinished", "strips"];
/// Letters that some system or shell does not take in the name of a file.
const REFUSED: [char; 9] = ['/', '\\', ':', '*', '?', '"', '<', '>', '|'];

/// A name that is one folder below where it is put, on every system.
///
/// ```
/// use wingbeat_config::RunName;
///
/// assert_eq!(RunName::new("name", "turn 2")?.as_str(), "turn 2");
/// for bad in ["", "..", "a/b", "/a", ".a", "-a", "a\n", "a.", "con", "manifest"] {
///     assert!(RunName::new("name", bad).is_err(), "{bad}");
/// }
/// # Ok::<(), wingbeat_math::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunName(String);

impl RunName {
    /// Checks the `name` given under `key`.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key and what is allowed.
    pub fn new(key: &str, name: &str) -> Result<Self, Error> {
        match allowed(name) {
            None => Ok(Self(name.to_owned())),
            Some(allowed) => {
                Err(Error::invalid(key, format!("{name:?}"), format!("a name for a folder: {allowed}")))
            }
        }
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for RunName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// What is allowed in place of `name`; none when it is good.
fn allowed(name: &str) -> Option<String> {
    let stem = name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    let ends = |end: Option<char>, bad: &[char]| end.is_some_and(|c| c.is_whitespace() || bad.contains(&c));
    if name.is_empty() || name.len() > LONGEST {
        Some(format!("1 to {LONGEST} bytes long"))
    } else if name.contains(REFUSED) {
        Some("without any of / \\ : * ? \" < > |".into())
    } else if name.chars().any(|c| c.is_control() || is_unseen(c)) {
        Some("without control characters".into())
    } else if ends(name.chars().next(), &['.', '-']) || ends(name.chars().next_back(), &['.']) {
        Some("not beginning with a dot, a dash or a blank, not ending with a dot or a blank".into())
    } else if TAKEN.contains(&stem.as_str()) || is_device(&stem) {
        Some(format!("none of {} and the devices of other systems", TAKEN.join(", ")))
    } else {
        None
    }
}

/// Letters without a shape, which make two names look the same.
fn is_unseen(c: char) -> bool {
    matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// Names that Windows keeps for devices, whatever follows a dot.
fn is_device(stem: &str) -> bool {
    let numbered = |kind: &str| {
        stem.strip_prefix(kind)
            .is_some_and(|digit| digit.len() == 1 && digit.bytes().all(|b| b.is_ascii_digit()))
    };
    ["con", "prn", "aux", "nul"].contains(&stem) || numbered("com") || numbered("lpt")
}

//! A step of a case that is data: what is made, what is called, what must then hold.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use serde::Deserialize;

use super::case::CaseOutcome;
use super::judge::FolderClaims;
use super::place::{Call, CallEnd, CaseFolder, PATIENCE, Stdout};
use super::readers::boxes::Emulated;
use super::readers::pages;
use super::text::Text;

/// What a step leaves for those after it: the offset of a box's ports, and the box as long as it runs.
#[derive(Default)]
pub struct StepRemains {
    offset: String,
    emulated: Option<Emulated>,
}

/// What is done, in this order: files are made, a box is started, the program is called, and what holds is judged.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CaseStep {
    /// Files and what they hold.
    write: BTreeMap<String, Text>,
    /// Links and where they lead.
    link: BTreeMap<String, String>,
    folders: Vec<String>,
    /// Named pipes.
    pipes: Vec<String>,
    /// Files that go.
    remove: Vec<String>,
    /// The page that a box serves; `{offset}` in words of calls is that of its port.
    page: Option<Text>,
    /// Faults of an emulated box; `{offset}` is that of its ports.
    faults: Option<Vec<String>>,
    /// The words of a call of the program.
    run: Vec<Text>,
    /// The folder in which it is called.
    within: Option<String>,
    stdout: Stdout,
    /// What the shell does to the error stream.
    stderr: String,
    /// Largest file that it may write, blocks of 512 bytes.
    blocks: Option<u64>,
    /// A signal that is sent so long after the start.
    signal: Option<String>,
    after_ms: u64,
    /// The signal is answered in time.
    in_time: bool,
    /// So many calls at once, of which the exit codes are judged.
    at_once: Option<usize>,
    /// Exit codes that are allowed, -1 for an end by a signal, all where there are none; of several calls at once the codes of all, in order.
    #[serde(default = "done")]
    exit: Vec<i32>,
    /// Words of the error stream.
    says: Vec<String>,
    /// Words of the error stream of a call that exits with 2 and leaves everything as it was.
    refused: Option<Vec<String>>,
    /// Words of the output.
    prints: Vec<String>,
    /// Number of lines of the error stream that begin with `error`.
    errors: Option<usize>,
    /// Nothing that lay there is changed or removed.
    kept: bool,
    /// Nothing is changed, removed or added.
    unchanged: bool,
    /// What holds after it.
    then: FolderClaims,
}

fn done() -> Vec<i32> {
    vec![0]
}

impl CaseStep {
    /// Does it and judges.
    pub fn play(&self, place: &CaseFolder, kept: &mut StepRemains) -> CaseOutcome {
        self.make(place)?;
        self.serve(place, kept)?;
        if !self.run.is_empty() {
            self.called(place, &kept.offset)?;
        }
        if self.then.ends_the_box() {
            kept.emulated = None;
        }
        self.then.judge(place)
    }

    fn make(&self, place: &CaseFolder) -> CaseOutcome {
        let told =
            |what: &str, outcome: std::io::Result<()>| outcome.map_err(|error| format!("{what}: {error}"));
        for (name, text) in &self.write {
            place.write_bytes(name, &text.bytes()?)?;
        }
        for name in &self.folders {
            told(name, fs::create_dir_all(place.path(name)))?;
        }
        for (name, to) in &self.link {
            let _ = fs::remove_file(place.path(name));
            told(name, symlink(Path::new(to), place.path(name)))?;
        }
        for name in &self.pipes {
            let made = Command::new("mkfifo").arg(place.path(name)).status();
            if !made.is_ok_and(|status| status.success()) {
                return Err(format!("mkfifo {name} failed"));
            }
        }
        let remove =
            |path: &Path| if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        self.remove.iter().try_for_each(|name| told(name, remove(&place.path(name))))
    }

    fn serve(&self, place: &CaseFolder, kept: &mut StepRemains) -> CaseOutcome {
        if let Some(page) = &self.page {
            kept.offset = pages::serve_page(page.bytes()?)?;
        }
        if let Some(faults) = &self.faults {
            let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
            let emulated = Emulated::start(place, &faults)?;
            kept.offset.clone_from(&emulated.offset);
            kept.emulated = Some(emulated);
        }
        Ok(())
    }

    fn call<'a>(&self, place: &'a CaseFolder, words: &[String]) -> Call<'a> {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut call = place.call(&words).stdout(self.stdout).stderr(&self.stderr);
        if let Some(folder) = &self.within {
            call = call.within(folder);
        }
        if let Some(blocks) = self.blocks {
            call = call.blocks(blocks);
        }
        match &self.signal {
            Some(name) => call.signal(name, Duration::from_millis(self.after_ms)),
            None => call,
        }
    }

    fn called(&self, place: &CaseFolder, offset: &str) -> CaseOutcome {
        let folder = place.folder.to_string_lossy();
        let word = |text: &Text| -> Result<String, String> {
            let word = String::from_utf8(text.bytes()?).map_err(|error| error.to_string())?;
            Ok(word.replace("{offset}", offset).replace("{folder}", &folder))
        };
        let words = self.run.iter().map(word).collect::<Result<Vec<_>, _>>()?;
        let call = self.call(place, &words);
        if let Some(count) = self.at_once {
            return self.together(&call, count);
        }
        let before = place.state()?;
        self.judge(call.run()?)?;
        if self.unchanged || self.refused.is_some() {
            place.unchanged(&before)?;
        }
        if self.kept { place.kept(&before) } else { Ok(()) }
    }

    /// Calls at once; their exit codes are those that are wanted.
    fn together(&self, call: &Call, count: usize) -> CaseOutcome {
        let running = (0..count).map(|_| call.start()).collect::<Result<Vec<_>, _>>()?;
        let end = |one: super::place::Running| one.end(PATIENCE).map(|ended| ended.code.unwrap_or(-1));
        let mut codes = running.into_iter().map(end).collect::<Result<Vec<_>, _>>()?;
        codes.sort_unstable();
        if codes == self.exit { Ok(()) } else { Err(format!("exit codes {codes:?}, wanted {:?}", self.exit)) }
    }

    fn judge(&self, ended: CallEnd) -> CaseOutcome {
        let (exit, says) = match &self.refused {
            Some(says) => (&[2][..], says),
            None => (&self.exit[..], &self.says),
        };
        let ended = ended.exits_with(exit)?.says(says)?.prints(&self.prints)?;
        if let Some(errors) = self.errors {
            let lines = ended.stderr.lines().filter(|line| line.starts_with("error")).count();
            if lines != errors {
                return Err(format!("{lines} messages: {}", ended.stderr.trim()));
            }
        }
        if self.in_time { ended.in_time().map(drop) } else { Ok(()) }
    }
}

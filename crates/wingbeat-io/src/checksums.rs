//! Checksums of the files of a run, by which its reader knows that one of them changed afterwards.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flate2::Crc;
use serde_json::Value;

use crate::Error;

/// Bytes that are read at once.
const PIECE: usize = 1 << 18;
/// Largest manifest that is read, bytes: it names some 100 000 files.
const LARGEST: u64 = 16 << 20;
/// Folders above a file in which the manifest of its run is sought: runs have folders inside.
const ABOVE: usize = 3;

/// The cyclic redundancy check of ISO 3309 over what a file holds, in eight hexadecimal digits.
///
/// # Errors
/// A file that cannot be read.
pub fn checksum(path: &Path) -> io::Result<String> {
    let (mut file, mut sum) = (File::open(path)?, Crc::new());
    let mut piece = vec![0; PIECE];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(format!("{:08x}", sum.sum())),
            read => sum.update(&piece[..read]),
        }
    }
}

/// Refuses a file of a run that is not as its manifest says; one that no manifest names, or without a checksum, may be anything.
///
/// # Errors
/// The file, and that it changed.
pub fn unchanged(path: &Path) -> Result<(), Error> {
    let Some((manifest, name)) = manifest_of(path) else { return Ok(()) };
    let Some(before) = said(&manifest, &name) else { return Ok(()) };
    let now = checksum(path).map_err(|source| Error::file(path, source))?;
    if now == before {
        return Ok(());
    }
    let what = format!(
        "changed after its run was written: its checksum is {now}, {} says {before}; copy it out of the folder to use it as it is",
        manifest.display()
    );
    Err(Error::format(path, what))
}

/// The nearest manifest above a file, and what it calls the file.
fn manifest_of(path: &Path) -> Option<(PathBuf, String)> {
    let path = std::path::absolute(path).ok()?;
    path.ancestors().skip(1).take(ABOVE).find_map(|folder| {
        let manifest = folder.join("manifest.json");
        let parts = path.strip_prefix(folder).ok()?.components();
        let parts: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
        // While a run goes on, its files change.
        let whole = manifest.is_file() && !folder.join("unfinished.json").exists();
        whole.then(|| (manifest, parts.join("/")))
    })
}

/// The checksum that a manifest of ours has of a file.
fn said(manifest: &Path, name: &str) -> Option<String> {
    let small = fs::metadata(manifest).is_ok_and(|data| data.len() <= LARGEST);
    let text = small.then(|| fs::read_to_string(manifest).ok()).flatten()?;
    let listed: Value = serde_json::from_str(&text).ok()?;
    (listed["program"] == "wingbeat").then(|| listed["checksums"][name].as_str().map(str::to_owned)).flatten()
}

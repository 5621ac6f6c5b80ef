//! The rooms of the library form a ladder: a room uses only rooms named before it in lib.rs.

use std::fs;
use std::path::{Path, PathBuf};

/// Rooms that see less than what stands before them: the physics of air and of bodies meet in `robot` alone,
/// and optimal control knows no wing.
const NARROWER: [(&str, &[&str]); 2] = [("body", &["math", "plant"]), ("ocp", &["math", "plant"])];

/// The public modules of lib.rs, in order.
fn rooms(library: &str) -> Vec<&str> {
    library.lines().filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';')).collect()
}

/// The rooms that `room` may use.
fn allowed<'a>(room: &str, rooms: &[&'a str]) -> Vec<&'a str> {
    let below: Vec<&str> = rooms.iter().copied().take_while(|other| *other != room).collect();
    match NARROWER.iter().find(|(name, _)| *name == room) {
        Some((_, few)) => below.into_iter().filter(|other| few.contains(other)).collect(),
        None => below,
    }
}

/// The rooms named in `crate::room` or `crate::{room, ...}` in a line of code.
fn named<'a>(line: &str, rooms: &[&'a str]) -> Vec<&'a str> {
    let code = line.split("//").next().unwrap_or("");
    let mut found = Vec::new();
    for part in code.split("crate::").skip(1) {
        let group = part.strip_prefix('{').map(|inside| inside.split('}').next().unwrap_or(inside));
        let paths: Vec<&str> = group.map_or_else(|| vec![part], |inside| inside.split(',').collect());
        for path in paths {
            let path = path.trim();
            let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(path.len());
            found.extend(rooms.iter().filter(|room| **room == &path[..end]));
        }
    }
    found
}

/// What `text`, a file of `room`, uses and may not.
fn breaches(room: &str, text: &str, rooms: &[&str]) -> Vec<String> {
    let allowed = allowed(room, rooms);
    let upward = |name: &&str| *name != room && !allowed.contains(name);
    let line = |(number, line)| -> Vec<String> {
        let names = named(line, rooms).into_iter().filter(upward);
        names.map(|name| format!("line {}: {room} uses {name}", number + 1)).collect()
    };
    text.lines().enumerate().flat_map(line).collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn every_room_uses_only_rooms_named_before_it() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let library = fs::read_to_string(source.join("lib.rs")).unwrap();
    let rooms = rooms(&library);
    assert!(rooms.len() > 4, "lib.rs names {rooms:?}");
    let mut found = Vec::new();
    for path in files(&source) {
        let below = path.strip_prefix(&source).unwrap();
        let top = below.components().next().unwrap().as_os_str().to_string_lossy().replace(".rs", "");
        if rooms.contains(&top.as_str()) {
            let text = fs::read_to_string(&path).unwrap();
            found.extend(
                breaches(&top, &text, &rooms)
                    .into_iter()
                    .map(|breach| format!("{}, {breach}", below.display())),
            );
        }
    }
    assert!(found.is_empty(), "rooms reach upward:\n{}", found.join("\n"));
}

#[test]
fn a_breach_is_seen() {
    let rooms = ["math", "plant", "aero", "body", "robot", "ocp"];
    assert!(breaches("aero", "use crate::math::Vec3;\nuse crate::{Error, plant};", &rooms).is_empty());
    assert_eq!(breaches("aero", "\nuse crate::robot::Robot;", &rooms), ["line 2: aero uses robot"]);
    assert_eq!(breaches("math", "    let p: crate::plant::Plant;", &rooms).len(), 1);
    assert_eq!(breaches("body", "use crate::{aero::Loads, math};", &rooms), ["line 1: body uses aero"]);
    assert_eq!(breaches("ocp", "use crate::robot::Robot;", &rooms).len(), 1);
    assert!(breaches("aero", "// as crate::robot does", &rooms).is_empty());
}

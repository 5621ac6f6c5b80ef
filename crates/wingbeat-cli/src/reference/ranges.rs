//! The ranges of the reference are those that are checked.

use std::collections::{BTreeMap, BTreeSet};

use wingbeat::scenario::{ConfigError, Document, DocumentKind, RigRun, Scenario, Sweep, TetherCase};
use wingbeat::simulate::{Column, Record};

use super::keys::{Key, RangeEnd, keys};
use super::{root, shipped};

type Build = fn(Document) -> Result<(), ConfigError>;

fn scenario(document: Document) -> Result<(), ConfigError> {
    Scenario::new(document).map(drop)
}

fn case(document: Document) -> Result<(), ConfigError> {
    TetherCase::new(document, &|_| Ok(Record::new(vec![Column::new("t", "s", "")], 0).unwrap())).map(drop)
}

fn run(document: Document) -> Result<(), ConfigError> {
    RigRun::new(document, &|_, _| None).map(drop)
}

fn sweep(document: Document) -> Result<(), ConfigError> {
    Sweep::new(document, &|_| Err("no tables".into())).map(drop)
}

/// How documents of a kind are built, and what they name: key and kind.
fn builder(kind: DocumentKind) -> Option<(Build, &'static [(&'static str, DocumentKind)])> {
    use DocumentKind::{Arm, Case, Rig, Robot, Run, Scenario, Sweep};
    Some(match kind {
        Scenario => (scenario, &[("robot", Robot)]),
        Case => (case, &[]),
        Run => (run, &[("rig", Rig), ("rig.robot", Robot), ("rig.arm", Arm)]),
        Sweep => (sweep, &[]),
        _ => return None,
    })
}

/// The key of the reference that stands for `path`: `a[2].b[0]` is of `a[].b`.
fn general(path: &str) -> String {
    let mut parts = path.split('[');
    let first = parts.next().unwrap_or_default().to_owned();
    let text =
        parts.fold(first, |text, part| text + "[]" + part.split_once(']').map_or("", |(_, rest)| rest));
    text.trim_end_matches("[]").into()
}

/// The nearest numbers outside the range of a key.
fn outside(key: &Key) -> Vec<String> {
    let far = |end: RangeEnd, away: f64| match (key.form.contains("whole"), end.closed) {
        (true, _) => format!("{}", (end.at + away) as i64),
        (false, true) => format!("{:?}", end.at + away * (1e-9 * end.at.abs()).max(1e-9)),
        (false, false) => format!("{:?}", end.at),
    };
    let [low, high] = key.ends;
    low.map(|low| far(low, -1.0)).into_iter().chain(high.map(|high| far(high, 1.0))).collect()
}

#[test]
fn what_lies_outside_a_range_of_the_reference_is_refused() {
    let reference: BTreeMap<&str, Vec<Key>> =
        DocumentKind::ALL.into_iter().map(|kind| (kind.name(), keys(kind))).collect();
    let (mut seen, mut refused) = (BTreeSet::new(), 0);
    for shipped in shipped::all() {
        let Some((build, named)) = builder(shipped.kind) else { continue };
        let document = Document::file(&root().join(&shipped.file)).unwrap();
        let includes: Vec<&str> = named.iter().map(|(key, _)| *key).collect();
        let merged = document.clone().merged(&includes, &|_, _| None).unwrap();
        for path in merged.numbers() {
            let below = |(key, kind): &(&'static str, DocumentKind)| {
                Some((path.strip_prefix(key)?.strip_prefix('.')?.to_owned(), *kind))
            };
            let (key, kind) = named.iter().rev().find_map(below).unwrap_or((path.clone(), shipped.kind));
            let name = general(&key);
            let Some(key) = reference[kind.name()].iter().find(|known| known.path == name) else { continue };
            if !seen.insert((kind.name(), name.clone())) {
                continue;
            }
            for value in outside(key) {
                let set = format!("{path}={value}");
                let Err(error) = build(document.clone().set(set.as_str())) else {
                    panic!("{}: {set} is taken; the reference says {}", shipped.file, key.range);
                };
                let last = name.rsplit('.').next().unwrap_or_default();
                assert!(error.to_string().contains(last), "{set}: {error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 400, "{refused} numbers refused");
}

#[test]
fn keys_of_the_rig_have_their_own_range() {
    let range = |kind: DocumentKind, path: &str| {
        keys(kind).into_iter().find(|key| key.path == path).map(|key| key.range).unwrap_or_default()
    };
    assert_eq!(range(DocumentKind::Rig, "clearance_m"), "0 to 10000");
    assert_eq!(range(DocumentKind::Rig, "envelope.half_span_m"), "above 0 to 10000");
    assert_eq!(range(DocumentKind::Run, "turn.roll_deg"), "±60");
    assert_eq!(range(DocumentKind::Run, "process.bins"), "2 to 10000");
    assert_eq!(range(DocumentKind::Arm, "profiles[].tool_speed_m_s"), "above 0 to 10000");
}

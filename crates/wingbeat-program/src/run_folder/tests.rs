//! Run folders: whole or not at all, never over what is not theirs.

use super::*;

/// The manifest of a test.
#[derive(Serialize)]
struct TestManifest {
    seed: u64,
}

const ONE: TestManifest = TestManifest { seed: 1 };
const TWO: TestManifest = TestManifest { seed: 2 };

fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("wingbeat-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    fs::canonicalize(path).unwrap()
}

fn entries(path: &Path) -> usize {
    fs::read_dir(path).unwrap().count()
}

fn name() -> RunName {
    RunName::new("name", "x").unwrap()
}

fn create(out: &Path, force: bool) -> Result<RunFolder, Error> {
    RunFolder::create(Some(out), &name(), force)
}

fn seed(run: &Path) -> bool {
    fs::read_to_string(run.join(MANIFEST)).unwrap().contains("\"seed\": 2")
}

#[test]
fn a_run_appears_whole_or_not_at_all() {
    let parent = scratch("whole");
    let out = parent.join("made/a");
    let folder = create(&out, false).unwrap();
    folder.write("scenario.toml", "x = 1\n").unwrap();
    assert!(!out.exists());
    drop(folder);
    assert_eq!(entries(&parent), 0);
    create(&out, false).unwrap().finish(&ONE).unwrap();
    assert_eq!(entries(&parent.join("made")), 1);
    assert_eq!(entries(&out), 1);
    fs::remove_dir_all(parent).unwrap();
}

#[test]
fn only_force_replaces_a_run_and_nothing_replaces_other_files() {
    let parent = scratch("force");
    let out = parent.join("a");
    let first = create(&out, false).unwrap();
    first.folder("figures").unwrap();
    first.write("figures/one.svg", "").unwrap();
    first.finish(&ONE).unwrap();
    let refused = create(&out, false).unwrap_err();
    assert!(refused.to_string().contains("--force"), "{refused}");
    create(&out, true).unwrap().finish(&TWO).unwrap();
    assert!(seed(&out) && entries(&out) == 1 && entries(&parent) == 1);
    // A run that failed before it drew has an empty folder of figures.
    let failed = create(&out, true).unwrap();
    failed.folder("figures").unwrap();
    failed.finish(&ONE).unwrap();
    assert!(out.join("figures").is_dir());
    create(&out, true).unwrap().finish(&TWO).unwrap();
    assert!(seed(&out) && entries(&out) == 1 && entries(&parent) == 1);
    fs::create_dir(out.join("mine")).unwrap();
    assert!(create(&out, true).unwrap_err().to_string().contains("mine"));
    fs::remove_dir(out.join("mine")).unwrap();
    fs::write(out.join("notes.txt"), "mine").unwrap();
    let refused = create(&out, true).unwrap_err();
    assert!(refused.to_string().contains("notes.txt"), "{refused}");
    assert!(create(&parent, true).is_err());
    fs::remove_dir_all(parent).unwrap();
}

#[test]
fn what_comes_into_a_run_while_it_is_to_be_replaced_stays() {
    let parent = scratch("meanwhile");
    let out = parent.join("a");
    create(&out, false).unwrap().finish(&ONE).unwrap();
    let second = create(&out, true).unwrap();
    fs::write(out.join("notes.txt"), "mine").unwrap();
    assert_eq!(second.finish(&TWO).unwrap(), parent.join("a-2"));
    assert!(out.join("notes.txt").exists() && !seed(&out) && seed(&parent.join("a-2")));
    fs::remove_dir_all(parent).unwrap();
}

#[test]
fn an_interrupted_run_is_taken_up_only_by_its_like() {
    let parent = scratch("resume");
    let out = parent.join("a");
    let resume = |text: &str| RunFolder::resume(Some(&out), &name(), false, ("sweep.toml", text));
    // Of one that was cut off before anything was done nothing is waited for.
    drop(resume("other").unwrap());
    fs::write(parent.join(".a.partial/sweep.toml"), "oth").unwrap();
    resume("one").unwrap().write("log", "flown").unwrap();
    assert!(resume("one").unwrap().file("log").exists());
    assert!(resume("two").unwrap_err().to_string().contains(".a.partial"));
    assert!(create(&out, false).unwrap_err().to_string().contains("waits"));
    resume("one").unwrap().finish(&ONE).unwrap();
    assert_eq!(entries(&parent), 1);
    fs::remove_dir_all(parent).unwrap();
}

#[test]
fn what_a_killed_command_left_goes_and_what_a_living_one_writes_stays() {
    let parent = scratch("orphans");
    let out = parent.join("a");
    let left = parent.join(".a.partial");
    let mark = "{ \"program\": \"wingbeat\", \"resumes\": false }";
    fs::create_dir(&left).unwrap();
    fs::write(left.join(MARK), mark).unwrap();
    fs::write(left.join("record.parquet"), "half").unwrap();
    let living = create(&out, false).unwrap();
    assert!(!left.join("record.parquet").exists());
    let second = create(&out, false).unwrap_err();
    assert!(second.to_string().contains("another command"), "{second}");
    drop(living);
    assert_eq!(entries(&parent), 0);
    fs::create_dir(&left).unwrap();
    fs::write(left.join("thesis.txt"), "mine").unwrap();
    assert!(create(&out, true).unwrap_err().to_string().contains("other files"));
    assert!(left.join("thesis.txt").exists());
    fs::remove_dir_all(parent).unwrap();
}

#[test]
fn a_run_that_was_to_be_replaced_comes_back() {
    let parent = scratch("restore");
    let out = parent.join("a");
    create(&out, false).unwrap().finish(&ONE).unwrap();
    fs::rename(&out, parent.join(".a.replaced")).unwrap();
    create(&out, true).unwrap().finish(&TWO).unwrap();
    assert!(seed(&out) && entries(&parent) == 1);
    fs::remove_dir_all(parent).unwrap();
}

#[test]
fn an_unfinished_recording_is_never_thrown_away() {
    let parent = scratch("measured");
    let out = parent.join("a");
    let resume = |text: &str| RunFolder::resume_measured(&out, false, ("recording.json", text));
    resume("one").unwrap().write("raw", "rows").unwrap();
    assert!(resume("two").unwrap_err().to_string().contains(".a.partial"));
    assert!(resume("one").unwrap().file("raw").exists());
    fs::remove_dir_all(parent).unwrap();
}

#[test]
fn names_count_up_past_what_is_there_and_what_is_written() {
    let parent = scratch("names");
    let begin = || RunFolder::create_in(None, &parent, &name(), false).unwrap();
    fs::create_dir(parent.join("x")).unwrap();
    let (second, third) = (begin(), begin());
    assert_eq!(third.finish(&ONE).unwrap(), parent.join("x-3"));
    assert_eq!(second.finish(&ONE).unwrap(), parent.join("x-2"));
    assert_eq!(begin().finish(&ONE).unwrap(), parent.join("x-4"));
    fs::remove_dir_all(parent).unwrap();
}

//! Documents that are based on others.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::scenario::{ConfigError, Document, Scenario};

const BIRD: &str = "\
name = \"bird\"
[body]
mass_kg = 0.02
com_m = [0.0, 0.0, 0.1]
[[links]]
name = \"arm\"
at = { x = 1.0, y = 2.0 }
[[links]]
name = \"hand\"
parent = \"arm\"
[[knots]]
arc_m = 0.0
[[knots]]
arc_m = 1.0
";

/// A folder of one test with files.
fn folder(test: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("inherit-{test}"));
    for (path, text) in files {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

/// `text` in a file beside BIRD, as a table.
fn over_bird(test: &str, text: &str) -> Result<toml::Table, ConfigError> {
    let folder = folder(test, &[("bird.toml", BIRD), ("mine.toml", text)]);
    Document::file(&folder.join("mine.toml")).and_then(|document| document.parse())
}

/// The error of a document in `folder`, with paths as seen from there.
fn refused(folder: &Path, name: &str) -> String {
    let read = Document::load(&folder.join(name), &[], &["robot"]).and_then(|d| d.parse::<toml::Table>());
    read.unwrap_err().to_string().replace(&format!("{}/", folder.display()), "")
}

fn table(text: &str) -> toml::Table {
    text.parse().unwrap()
}

#[test]
fn tables_go_together_key_by_key_and_the_document_wins() {
    let mine = "base = \"bird.toml\"\nname = \"mine\"\n[body]\nmass_kg = 0.03\n[gait]\nfrequency_hz = 5.0\n";
    let expected = BIRD
        .replace("bird", "mine")
        .replace("mass_kg = 0.02", "mass_kg = 0.03")
        .replace("[[knots]]\narc_m = 0.0", "[gait]\nfrequency_hz = 5.0\n[[knots]]\narc_m = 0.0");
    assert_eq!(over_bird("tables", mine).unwrap(), table(&expected));
}

#[test]
fn items_change_those_of_their_name_and_other_lists_are_replaced() {
    let mine = "base = \"bird.toml\"\nknots = [{ arc_m = 3.0 }]\n[[links]]\nname = \"tail\"\n\
                [[links]]\nname = \"arm\"\nat.y = 3.0\n";
    let links = "[[links]]\nname = \"arm\"\nat = { x = 1.0, y = 3.0 }\n[[links]]\nname = \"hand\"\n\
                 parent = \"arm\"\n[[links]]\nname = \"tail\"\n[[knots]]\narc_m = 3.0\n";
    let body = &BIRD[..BIRD.find("[[links]]").unwrap()];
    assert_eq!(over_bird("items", mine).unwrap(), table(&format!("{body}{links}")));
    for list in ["links = []", "links = [\"arm\"]", "links = [{ name = \"arm\" }, { at = 1 }]"] {
        let found = over_bird("whole", &format!("base = \"bird.toml\"\n{list}\n")).unwrap();
        assert_eq!(found["links"], table(list)["links"], "{list}");
    }
}

#[test]
fn a_name_that_stands_twice_stays_twice() {
    let twice = "base = \"bird.toml\"\nlinks = [{ name = \"arm\", a = 1 }, { name = \"arm\", a = 2 }]\n";
    let found = over_bird("twice", twice).unwrap();
    let names: Vec<_> = found["links"].as_array().unwrap().iter().map(|link| link["name"].as_str()).collect();
    assert_eq!(names, [Some("arm"), Some("hand"), Some("arm")]);
}

#[test]
fn keys_of_the_base_can_be_left_out() {
    let mine =
        "base = \"bird.toml\"\nwithout = [\"body.com_m\", \"links.arm.at.x\", \"links.hand\", \"knots\"]\n";
    let expected = "name = \"bird\"\n[body]\nmass_kg = 0.02\n[[links]]\nname = \"arm\"\nat = { y = 2.0 }\n";
    assert_eq!(over_bird("without", mine).unwrap(), table(expected));
    for (without, place) in [
        ("[\"body.mass\"]", "mine.toml:2: without[0] = \"body.mass\""),
        ("[\"name\", \"links.0\"]", "mine.toml:2: without[1] = \"links.0\""),
        ("[\"\"]", "mine.toml:2: without[0] = \"\""),
        ("[1]", "mine.toml:2: without[0] = 1"),
    ] {
        let files =
            [("bird.toml", BIRD), ("mine.toml", &format!("base = \"bird.toml\"\nwithout = {without}\n"))];
        let allowed = "allowed is a key of the base, such as body.com_m or links.elbow.driven";
        assert_eq!(refused(&folder("left", &files), "mine.toml"), format!("{place}: {allowed}"));
    }
    let files = [("bird.toml", BIRD), ("mine.toml", "base = \"bird.toml\"\nwithout = \"name\"\n")];
    let expected = "mine.toml:2: without = \"name\": allowed is a list of keys of the base";
    assert_eq!(refused(&folder("no_list", &files), "mine.toml"), expected);
}

#[test]
fn a_base_has_a_base_and_each_leaves_out_keys_of_those_below() {
    let files = [
        ("bird.toml", BIRD),
        ("deep/b.toml", "base = \"../bird.toml\"\nwithout = [\"links.hand\"]\n[body]\nspan_m = 1.0\n"),
        (
            "c.toml",
            "base = \"deep/b.toml\"\nwithout = [\"body.com_m\", \"knots\", \"links\"]\nname = \"c\"\n",
        ),
    ];
    let folder = folder("chain", &files);
    let document = Document::file(&folder.join("c.toml")).unwrap();
    let found: toml::Table = document.parse().unwrap();
    assert_eq!(found, table("name = \"c\"\n[body]\nmass_kg = 0.02\nspan_m = 1.0\n"));
    assert_eq!(document.files().count(), 3);
    assert_eq!(document.folder("body.span_m"), folder.join("deep"));
    assert_eq!(document.folder("body.mass_kg"), folder);
}

#[test]
fn included_files_and_tables_in_their_place_have_bases_and_overrides_win() {
    let files = [
        ("robots/bird.toml", BIRD),
        ("robots/mine.toml", "base = \"bird.toml\"\n[body]\nmass_kg = 0.03\n"),
        ("flights/a.toml", "name = \"a\"\nrobot = \"../robots/mine.toml\"\n"),
        ("flights/b.toml", "base = \"a.toml\"\nname = \"b\"\n"),
        ("flights/c.toml", "base = \"a.toml\"\nrobot = { base = \"../robots/mine.toml\", body.com_m = 1 }\n"),
    ];
    let folder = folder("included", &files);
    let load = |name: &str, set: &[&str]| {
        let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
        Document::load(&folder.join("flights").join(name), &set, &["robot"]).unwrap()
    };
    let body = |document: &Document| document.parse::<toml::Table>().unwrap()["robot"]["body"].to_string();
    assert_eq!(body(&load("b.toml", &[])), "{ com_m = [0.0, 0.0, 0.1], mass_kg = 0.03 }");
    assert_eq!(body(&load("c.toml", &[])), "{ com_m = 1, mass_kg = 0.03 }");
    assert_eq!(body(&load("c.toml", &["robot.body.mass_kg=1"])), "{ com_m = 1, mass_kg = 1 }");
    let part = load("c.toml", &[]).part("robot").unwrap();
    assert_eq!(part.number("body.mass_kg"), Ok(0.03));
    let again = Document::text("again", &load("c.toml", &[]).resolved().unwrap()).unwrap();
    assert_eq!(body(&again), "{ com_m = 1, mass_kg = 0.03 }");
}

#[test]
fn errors_name_the_file_and_line_of_the_value() {
    let files = [("bird.toml", BIRD), ("mine.toml", "base = \"bird.toml\"\n\n[body]\nmass_kg = -1.0\n")];
    let document = Document::file(&folder("errors", &files).join("mine.toml")).unwrap();
    let line =
        |key: &str| document.written(key).unwrap().1.to_string().rsplit('/').next().unwrap().to_owned();
    assert_eq!(line("body.mass_kg"), "mine.toml:4");
    assert_eq!(line("body.com_m[2]"), "bird.toml:4");
    assert_eq!(line("links[1].parent"), "bird.toml:10");
}

#[test]
fn bases_that_are_no_files_or_go_round_are_refused() {
    let round = "a file that is not based on itself; these are: ";
    let cases = [
        ("nan", "base = nan\n", "allowed is the name of a file".to_owned()),
        ("list", "base = [\"bird.toml\"]\n", "allowed is the name of a file".into()),
        ("none", "base = \"\"\n", "not a regular file".into()),
        ("folder", "base = \".\"\n", "not a regular file".into()),
        ("missing", "\nbase = \"no.toml\"\n", "no.toml: No such file or directory".into()),
        ("itself", "base = \"mine.toml\"\n", format!("{round}mine.toml on mine.toml")),
        ("round", "base = \"other.toml\"\n", format!("{round}other.toml on mine.toml on other.toml")),
        ("robot", "[robot]\nbase = nan\n", "robot.base = nan: allowed is the name of a file".into()),
    ];
    for (test, text, expected) in cases {
        let folder = folder(test, &[("mine.toml", text), ("other.toml", "base = \"mine.toml\"\n")]);
        let message = refused(&folder, "mine.toml");
        assert!(message.contains(&expected), "{test}: {message}");
        assert!(message.contains("base = "), "{test}: {message}");
    }
    let not_toml = folder("not_toml", &[("mine.toml", "base = \"b.toml\"\n"), ("b.toml", "a = 1\nb = [\n")]);
    assert!(refused(&not_toml, "mine.toml").starts_with("b.toml:2: not TOML"));
    let alone = folder("alone", &[("mine.toml", "without = [\"name\"]\n")]);
    let found: toml::Table = Document::file(&alone.join("mine.toml")).unwrap().parse().unwrap();
    assert!(found.contains_key("without"), "it is refused as any key that is not known");
}

#[test]
fn a_thousand_bases_are_too_many() {
    let names: Vec<(String, String)> = (0..1000)
        .map(|i| (format!("{i}.toml"), format!("base = \"{}.toml\"\nk{i} = {i}\n", i + 1)))
        .collect();
    let files: Vec<(&str, &str)> = names.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let message = refused(&folder("thousand", &files), "0.toml");
    let expected =
        "16.toml:1: base = \"17.toml\": allowed is a chain of at most 16 files, each based on the next";
    assert_eq!(message, expected);
}

#[test]
fn an_override_cannot_change_the_base() {
    let glide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/glide.toml");
    let document = Document::file(&glide).unwrap().set("base=climb.toml");
    let message = Scenario::new(document).unwrap_err().to_string();
    assert!(message.contains("--set base=climb.toml: unknown key base"), "{message}");
}

#[test]
fn a_table_called_base_is_no_name_of_a_file() {
    let files = [
        ("arm.toml", "name = \"arm\"\n[base]\nz = 1\n"),
        ("mine.toml", "base = \"arm.toml\"\nname = \"mine\"\n"),
    ];
    let document = Document::file(&folder("arm", &files).join("mine.toml")).unwrap();
    assert_eq!(document.parse::<toml::Table>().unwrap(), table("name = \"mine\"\n[base]\nz = 1\n"));
}

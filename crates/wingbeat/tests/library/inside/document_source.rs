use std::path::Path;

use wingbeat_config::inside::{brief, joined};

#[test]
fn paths_are_seen_from_the_file_that_names_them() {
    assert_eq!(joined(Path::new("scenarios"), "../robots/a.toml"), Path::new("robots/a.toml"));
    assert_eq!(joined(Path::new(""), "../a.toml"), Path::new("../a.toml"));
    assert_eq!(joined(Path::new("x"), "/a.toml"), Path::new("/a.toml"));
}

#[test]
fn long_values_are_cut() {
    assert_eq!(brief("1.5"), "1.5");
    assert_eq!(brief("[1,\n2]"), "[1,...");
    assert_eq!(brief(&"x".repeat(80)).len(), 60);
}

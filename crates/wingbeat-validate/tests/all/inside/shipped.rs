use wingbeat_validate::shipped::*;

#[test]
fn every_shipped_file_is_compiled_in() {
    for folder in ["scenarios", "robots"] {
        for entry in path_of(folder).with_extension("").read_dir().unwrap() {
            let path = entry.unwrap().path();
            // Those of robots/any are read from the disk.
            assert!(path.is_dir() || text_of(&path).is_ok(), "{}", path.display());
        }
    }
}

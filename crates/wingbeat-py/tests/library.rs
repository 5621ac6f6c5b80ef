//! The extension is built with the tests, and exports what Python asks for.

use std::path::Path;

#[test]
fn the_extension_exports_its_entry() {
    let test = std::env::current_exe().expect("a test runs from a file");
    let folder = test.parent().expect("it lies in a folder");
    let names = ["lib_wingbeat.so", "lib_wingbeat.dylib", "_wingbeat.dll"];
    let library = names.iter().map(|name| folder.join(name)).find(|path| Path::exists(path));
    let bytes =
        std::fs::read(library.expect("the extension beside its test")).expect("a file that can be read");
    let entry = b"PyInit__wingbeat";
    assert!(bytes.windows(entry.len()).any(|window| window == entry));
}

use wingbeat_config::inside::{path, steps};

#[test]
fn paths_have_names_and_indices() {
    assert_eq!(steps("a.b[2].c"), ["a", "b", "2", "c"]);
    assert_eq!(steps("a.b.2"), ["a", "b", "2"]);
    assert_eq!(steps("a.\"b.c[0]\".d[1]"), ["a", "b.c[0]", "d", "1"]);
    assert_eq!(path(&steps("a.\"b.c[0]\"")), "a.\"b.c[0]\"");
}

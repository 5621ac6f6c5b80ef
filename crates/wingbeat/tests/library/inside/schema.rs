use wingbeat_config::inside::plain;

#[test]
fn links_of_doc_comments_become_names() {
    assert_eq!(plain("one of [`Doors`](super::Doors),\nor [`X`]; `a[0]`"), "one of `Doors`, or `X`; `a[0]`");
}

use wingbeat_validate::*;

#[test]
fn reads_comments_header_numbers_and_words() {
    let table = ReferenceTable::parse("t.csv", "# From a book.\nwing, AR\nrect, 4\nell, 8\n").unwrap();
    assert_eq!(table.source(), ["From a book."]);
    assert_eq!(table.column("AR").unwrap(), [4.0, 8.0]);
    assert_eq!(table.words("wing").unwrap(), ["rect", "ell"]);
    let error = table.column("ar").unwrap_err().to_string();
    assert_eq!(error, "validation/t.csv: no column ar; there are wing, AR");
    assert!(table.column("wing").is_err());
}

#[test]
fn a_table_may_have_no_header() {
    let table = ReferenceTable::parse("t.csv", "# a,b\n1,2\n3,4\n").unwrap();
    assert_eq!(table.len(), 2);
    assert_eq!(table.column_at(1).unwrap(), [2.0, 4.0]);
}

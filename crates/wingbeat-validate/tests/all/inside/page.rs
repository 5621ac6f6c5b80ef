use wingbeat_validate::page::*;

#[test]
fn numbers_are_short() {
    assert_eq!(significant(0.015_23, 3), "0.0152");
    assert_eq!(significant(15.46, 2), "15");
    assert_eq!(significant(1.0, 3), "1");
    assert_eq!(short(5.6e-14), "6e-14");
    assert_eq!(short(0.02), "0.02");
}

#[test]
fn a_missing_row_makes_no_page() {
    assert!(page(&[]).is_none());
}

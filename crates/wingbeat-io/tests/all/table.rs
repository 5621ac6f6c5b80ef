//! Records through CSV and back.

use wingbeat::simulate::{Column, Record};
use wingbeat_io::{read_csv, write_csv};

#[test]
fn numbers_come_back_with_all_their_digits() {
    let path = std::env::temp_dir().join(format!("wingbeat-table-{}.csv", std::process::id()));
    let mut record = Record::new(vec![Column::new("t", "s", ""), Column::new("f_x", "N", "B")], 2).unwrap();
    record.append(&[0.1, 1.0 / 3.0]);
    record.append(&[0.2, -4e-17]);
    write_csv(&path, &record).unwrap();
    assert!(std::fs::read_to_string(&path).unwrap().starts_with("t,f_x\n0.1,0.3333333333333333\n"));
    let back = read_csv(&path).unwrap();
    assert_eq!(back.values("f_x"), record.values("f_x"));
    std::fs::write(&path, "t,y\n0,1\n1,x\n").unwrap();
    let error = read_csv(&path).unwrap_err().to_string();
    assert!(error.ends_with("line 3, column y: `x` is not a number"), "{error}");
    std::fs::remove_file(path).unwrap();
}

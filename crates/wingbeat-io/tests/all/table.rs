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
    // Remarks are left out; a word among numbers, a gap and a column that is all gaps are refused.
    std::fs::write(&path, "t,y,note\n0,1,first\n1,2,4\n2,4,\n").unwrap();
    let error = read_csv(&path).unwrap_err().to_string();
    assert!(error.ends_with("line 2, column note: `first` is not a number"), "{error}");
    std::fs::write(&path, "note,t,y\nfirst,0,1\n,1,2\nlast one,2,4\n").unwrap();
    let read = read_csv(&path).unwrap();
    assert_eq!((read.columns().len(), read.values("y")), (2, Some(&[1.0, 2.0, 4.0][..])));
    for (text, cell) in [
        ("t,y\n0,#N/A\n1,#N/A\n", "#N/A"),
        ("t,y\n0,nan\n1,nan\n", "nan"),
        ("t,y\n0,\n1,\n", ""),
        ("a,b\nx,y\nz,u\n", "x"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = read_csv(&path).unwrap_err().to_string();
        assert!(error.ends_with(&format!("`{cell}` is not a number")), "{error}");
    }
    std::fs::remove_file(path).unwrap();
}

//! A record survives the way to disk and back, and its bytes depend on nothing else.

use std::fs;
use std::path::PathBuf;

use wingbeat::flight::{Column, Record};
use wingbeat_io::{read_parquet, write_parquet};

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn sample() -> Record {
    let limited = Column { low: -0.3, high: 0.3, ..Column::new("command_shoulder_left", "rad", "") };
    let columns = vec![Column::new("t", "s", ""), Column::new("p_WB_x", "m", "W"), limited];
    let mut record = Record::new(columns, 5000).unwrap();
    for i in 0..5000 {
        let t = 1e-3 * f64::from(i);
        record.append(&[t, (3.0 * t).sin(), if i == 7 { f64::NAN } else { -t }]);
    }
    record
}

#[test]
fn what_was_written_is_read() {
    let (record, path) = (sample(), folder("round").join("record.parquet"));
    write_parquet(&path, &record).unwrap();
    let read = read_parquet(&path).unwrap();
    assert_eq!(read.rows(), record.rows());
    for (a, b) in read.columns().iter().zip(record.columns()) {
        assert_eq!((&a.name, &a.unit, &a.frame, a.low, a.high), (&b.name, &b.unit, &b.frame, b.low, b.high));
        assert!(a.values.iter().zip(&b.values).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn the_same_record_gives_the_same_bytes() {
    let folder = folder("same");
    let bytes: Vec<_> = ["a.parquet", "b.parquet"]
        .map(|name| folder.join(name))
        .iter()
        .map(|path| {
            write_parquet(path, &sample()).unwrap();
            fs::read(path).unwrap()
        })
        .collect();
    assert!(bytes[0] == bytes[1]);
}

#[test]
fn an_empty_record_and_one_without_columns() {
    let path = folder("empty").join("record.parquet");
    for columns in [vec![Column::new("t", "s", "")], vec![]] {
        let record = Record::new(columns, 0).unwrap();
        write_parquet(&path, &record).unwrap();
        assert_eq!(read_parquet(&path).unwrap(), record);
    }
}

#[test]
fn what_is_not_a_record_is_refused_with_its_name() {
    let path = folder("bad").join("record.parquet");
    fs::write(&path, "not parquet").unwrap();
    assert!(read_parquet(&path).unwrap_err().to_string().contains("record.parquet"));
    assert!(read_parquet(&path.with_extension("none")).unwrap_err().to_string().contains("record.none"));
}

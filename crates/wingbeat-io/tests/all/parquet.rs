//! A record survives the way to disk and back, and its bytes depend on nothing else.

use std::fs;
use std::path::PathBuf;

use wingbeat::simulate::{Column, Record};
use wingbeat_io::{ParquetWriter, read_parquet, write_parquet};

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

#[test]
fn a_damaged_file_is_refused_or_read_but_never_the_end() {
    let folder = folder("damaged");
    let path = folder.join("record.parquet");
    let mut record = Record::new(vec![Column::new("t", "s", ""), Column::new("x", "m", "W")], 3).unwrap();
    (0..3).for_each(|i| record.append(&[f64::from(i), 0.5]));
    write_parquet(&path, &record).unwrap();
    let whole = fs::read(&path).unwrap();
    let damaged = folder.join("damaged.parquet");
    // The last 400 bytes hold the description of the chunks.
    for at in whole.len() - 400..whole.len() {
        for bit in [1, 0x80] {
            let mut bytes = whole.clone();
            bytes[at] ^= bit;
            fs::write(&damaged, bytes).unwrap();
            let _ = read_parquet(&damaged);
        }
    }
    for length in [0, 3, 12, whole.len() / 2, whole.len() - 1] {
        fs::write(&damaged, &whole[..length]).unwrap();
        assert!(read_parquet(&damaged).is_err());
    }
}

#[test]
fn parts_make_one_record() {
    let (record, path) = (sample(), folder("parts").join("record.parquet"));
    let mut writer = ParquetWriter::create(&path, &record).unwrap();
    writer.append(&record).unwrap();
    writer.append(&record).unwrap();
    writer.close().unwrap();
    let read = read_parquet(&path).unwrap();
    assert_eq!(read.rows(), 2 * record.rows());
    let (t, twice) = (record.values("t").unwrap(), read.values("t").unwrap());
    assert_eq!((&twice[..t.len()], &twice[t.len()..]), (t, t));
}

#[test]
fn files_that_fuzzing_found_are_refused() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/damaged");
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        assert!(read_parquet(&path).is_err(), "{}", path.display());
    }
}

#[test]
fn units_and_frames_are_where_pandas_looks_for_attributes() {
    let path = folder("pandas").join("record.parquet");
    write_parquet(&path, &sample()).unwrap();
    let bytes = fs::read(&path).unwrap();
    let has = |text: &str| bytes.windows(text.len()).any(|window| window == text.as_bytes());
    assert!(has("PANDAS_ATTRS"));
    let units = r#""units":{"command_shoulder_left":"rad","p_WB_x":"m","t":"s"}"#;
    assert!(has(&format!(r#"{{"frames":{{"p_WB_x":"W"}},{units}}}"#)));
}

//! Channels of a file whose meaning nobody told.

use std::fs;

use wingbeat_io::samples::{ChannelRequest, Plain, read_channels, read_measured};

fn read(name: &str, text: &str, asked: &ChannelRequest) -> Result<Plain, String> {
    let path = std::env::temp_dir().join(format!("wingbeat-plain-{}-{name}.csv", std::process::id()));
    fs::write(&path, text).unwrap();
    let answer = read_channels(&path).and_then(|table| table.plain(asked));
    fs::remove_file(&path).unwrap();
    answer.map_err(|error| error.to_string())
}

fn asked(rate: Option<f64>, units: &[&str]) -> ChannelRequest {
    ChannelRequest {
        rate,
        units: units.iter().map(|unit| (*unit).to_owned()).collect(),
        ..ChannelRequest::default()
    }
}

#[test]
fn six_columns_without_names_are_forces_and_moments() {
    let six = "1,2,3,4,5,6\n".repeat(5);
    let plain = read("six", &six, &asked(Some(1000.0), &["N", "N m"])).unwrap();
    let names: Vec<_> = plain.channels.iter().map(|c| format!("{} {}", c.name, c.unit)).collect();
    assert_eq!(names, ["Fx N", "Fy N", "Fz N", "Tx N m", "Ty N m", "Tz N m"]);
    assert_eq!((plain.time[4], plain.channels[5].values.clone()), (0.004, vec![6.0; 5]));
    let error = read("seven", &"1,2,3,4,5,6,7\n".repeat(5), &asked(Some(1e3), &[])).unwrap_err();
    assert!(error.contains("line 1: 7 columns without names"), "{error}");
}

#[test]
fn times_units_and_gaps_come_from_the_file() {
    let rows = (0..40).filter(|k| !(10..14).contains(k)).map(|k| format!("{k},{},7\n", 2 * k));
    let text = format!("t [ms],lift_N,strain\n{}", rows.collect::<String>());
    let plain = read("time", &text, &asked(None, &[])).unwrap();
    assert_eq!((plain.channels[0].name.as_str(), plain.channels[0].unit.as_str()), ("lift", "N"));
    assert_eq!((plain.channels[1].name.as_str(), plain.channels[1].unit.as_str()), ("strain", ""));
    assert_eq!((plain.missing, plain.time.len()), (4, 40));
    assert!(plain.channels[0].values[12].is_nan() && (plain.rate - 1000.0).abs() < 1e-6);
    let two = asked(Some(1e3), &["mN", "V"]);
    assert!(read("other", &text, &two).unwrap_err().contains("unit mN by --units, but N by the file"));
    assert!(read("three", &text, &asked(None, &["N"; 3])).unwrap_err().contains("3 for 2 channels"));
    let none = read("none", "lift_N\n1\n2\n3\n", &asked(None, &[])).unwrap_err();
    assert!(none.contains("no column of time; found lift_N: give the samples per second"), "{none}");
}

/// Rows that are missing between others go; a cell without a number is told.
#[test]
fn a_measured_file_with_cells_without_numbers_is_refused_by_its_column() {
    let path = std::env::temp_dir().join(format!("wingbeat-plain-{}-holes.csv", std::process::id()));
    let read = |hole: &str| {
        let rows = (0..40).filter(|k| !(10..14).contains(k));
        let row = |k: usize| {
            let lift = if [20, 30].contains(&k) { hole } else { "7" };
            format!("{k},{lift},{}\n", 2 * k)
        };
        fs::write(&path, format!("time_ms,lift_N,drag_N\n{}", rows.map(row).collect::<String>())).unwrap();
        read_measured(&path).map_err(|error| error.to_string())
    };
    assert_eq!(read("7").unwrap().rows(), 36);
    for hole in ["nan", ""] {
        let error = read(hole).unwrap_err();
        assert!(error.contains("2 of 40 values of `lift` are no numbers"), "{error}");
    }
    fs::remove_file(&path).unwrap();
}

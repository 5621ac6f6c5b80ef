//! Records as CSV.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat_io::{read_csv, write_csv};

fuzz_target!(|bytes: &[u8]| {
    let path = wingbeat_fuzz::file("input.csv", bytes);
    if let Ok(record) = read_csv(&path) {
        write_csv(&path, &record).expect("what was read can be written");
    }
});

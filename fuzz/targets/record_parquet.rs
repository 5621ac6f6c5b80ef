//! Records as Parquet.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat_io::{read_parquet, write_parquet};

// Only a panic that leaves the reader counts: it turns those of its decoder into errors.
fuzz_target!(init: std::panic::set_hook(Box::new(|_| ())), |bytes: &[u8]| {
    let path = wingbeat_fuzz::file("input.parquet", bytes);
    if let Ok(record) = read_parquet(&path) {
        write_parquet(&path, &record).expect("what was read can be written");
    }
});

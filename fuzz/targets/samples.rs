//! Files of samples of other programs: MATLAB, NumPy, HDF5, text.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat::rig::process::InputSpec;
use wingbeat_io::samples::read_samples;

// Only a panic that leaves the reader counts: it turns those of its decoders into errors.
fuzz_target!(init: std::panic::set_hook(Box::new(|_| ())), |bytes: &[u8]| {
    let path = wingbeat_fuzz::file("input.samples", bytes);
    let input = InputSpec::default();
    let _ = read_samples(&path, &input).and_then(|table| table.import(&input));
});

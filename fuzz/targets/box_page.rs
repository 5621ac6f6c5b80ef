//! Answers of the box's web server: head, body, scale factors.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat_fuzz as _;
use wingbeat_netft::parse_answer;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(scale) = parse_answer(bytes) {
        assert!(scale.per_newton > 0.0 && scale.per_newton_metre > 0.0);
    }
});

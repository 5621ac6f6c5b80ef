//! Answers of the box's web server: head, body, scale factors.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat::rig::netft::COUNTS_PER_UNIT;
use wingbeat_fuzz as _;
use wingbeat_netft::parse_answer;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(config) = parse_answer(bytes) {
        let [low, high] = COUNTS_PER_UNIT;
        let scale = config.scale;
        assert!([scale.per_newton, scale.per_newton_metre].iter().all(|per| (low..=high).contains(per)));
    }
});

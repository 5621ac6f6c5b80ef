//! Arms from URDF.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat_fuzz as _;
use wingbeat_io::parse_urdf;

fuzz_target!(|text: &str| {
    if let Ok(arm) = parse_urdf(text, None).and_then(|arm| arm.build().map_err(|error| error.to_string())) {
        arm.tool_pose(&vec![0.1; arm.dof()]);
    }
});

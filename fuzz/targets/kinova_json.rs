//! Joint-angle lists of the Kinova Web App.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat::rig::arm::ArmConfig;
use wingbeat_fuzz as _;
use wingbeat_io::trajectory::{against, parse_kinova_json};

fuzz_target!(|text: &str| {
    if let Ok(imported) = parse_kinova_json(text) {
        imported.trajectory.check().expect("what was read is whole");
        imported.trajectory.differenced();
        let arm = ArmConfig::kinova_gen3().build().expect("the arm of the rig");
        let _ = against(imported, &arm);
    }
});

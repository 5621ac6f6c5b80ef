//! Joint trajectories of ROS 2.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat::rig::arm::ArmConfig;
use wingbeat_fuzz as _;
use wingbeat_io::trajectory::{against, parse_ros_yaml};

fuzz_target!(|text: &str| {
    if let Ok(imported) = parse_ros_yaml(text) {
        imported.trajectory.check().expect("what was read is whole");
        imported.trajectory.differenced();
        let arm = ArmConfig::kinova_gen3().build().expect("the arm of the rig");
        let _ = against(imported, &arm);
    }
});

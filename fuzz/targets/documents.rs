//! Configurations: scenarios, runs on the rig, cases in the wind tunnel, sweeps.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat::scenario::{RigRun, Scenario, Sweep, TetherCase};

fuzz_target!(|bytes: &[u8]| {
    let path = wingbeat_fuzz::file("input.toml", bytes);
    let read = |path: &std::path::Path| Err(format!("{}: no tables here", path.display()));
    let messages = [
        Scenario::load(&path, &[]).err(),
        RigRun::load(&path, &[]).err(),
        TetherCase::load(&path, &[], &read).err(),
        Sweep::load(&path, &[], &read).err(),
    ];
    for message in messages.into_iter().flatten() {
        assert!(!message.to_string().is_empty());
    }
});

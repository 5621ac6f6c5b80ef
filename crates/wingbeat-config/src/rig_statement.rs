//! What processing did, in words.

use super::RigRun;
use wingbeat_rig::cell::CHANNELS;
use wingbeat_rig::process::{Corrected, CycleAverage, PhaseSource};

/// One line per step of processing of the window from `begin` to `end` (s), those left out included.
pub fn statement(
    run: &RigRun,
    measured: &Corrected,
    cycles: &CycleAverage,
    (begin, end): (f64, f64),
    own_motion: bool,
) -> Vec<String> {
    let steps = run.spec.process.steps;
    let step = |done: bool, name: &str, how: String| match done {
        true => format!("{name}: {how}"),
        false => format!("{name}: left out"),
    };
    let six = |values: &[f64; 6]| {
        let channels = CHANNELS.iter().zip(values);
        channels
            .map(|((name, unit), value)| format!("{name} {value:.5} {unit}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let motion = if own_motion { "as recorded" } else { "of the run's plan" };
    let by_encoder = run.spec.process.phase == PhaseSource::Encoder;
    let posed = if by_encoder { "" } else { ", the wings as they rest: no encoder tells their pose" };
    let frequency = run.frequency();
    let cutoff = steps.cutoff_multiple * frequency;
    let phase = match run.spec.process.phase {
        PhaseSource::Encoder => "the encoder".into(),
        PhaseSource::Force => {
            format!("the fundamental of Fz near {frequency} Hz, its largest value at phase 0")
        }
        PhaseSource::Frequency => format!("{frequency} Hz, phase 0 at t = 0"),
    };
    vec![
        step(steps.tare, "tare", format!("offset in the rest before the run: {}", six(&measured.offset))),
        step(steps.drift, "drift", format!("slope of that rest per s: {}", six(&measured.slope))),
        step(steps.gravity, "gravity", format!("weight of mount and robot by model, motion {motion}{posed}")),
        step(steps.mount_inertia, "inertia of the mount", format!("by model, motion {motion}")),
        step(
            steps.robot_inertia,
            "inertia of body and wings",
            "by model: what is left is aerodynamic".into(),
        ),
        step(steps.body_frame, "body frame", "turned and moved to the body's origin".into()),
        step(
            cutoff > 0.0,
            "filter",
            format!(
                "Butterworth of fourth order, both ways, {cutoff:.2} Hz = {} times the flapping frequency, of {:.1} \
                 samples/s",
                steps.cutoff_multiple, measured.rate
            ),
        ),
        format!(
            "phase average: {} cycles from {begin:.4} to {end:.4} s by {phase}; {} left out for missing samples",
            cycles.cycles, cycles.left_out
        ),
    ]
}

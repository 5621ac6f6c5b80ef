//! Work to be counted in instructions, which do not depend on what else the machine does: `running_times count NAME RUNS`
//! does the work `NAME` so often. `cargo xtask long instructions` takes the difference of two numbers of runs.

use std::hint::black_box;

use wingbeat::aero::Loads;
use wingbeat::math::Single8;
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::BeyondLoads;
use wingbeat::simulate::Measurement;

use super::scenario;

/// Does what `arguments` name; none where they name nothing.
pub fn count(arguments: &[String]) -> Option<()> {
    let [work, preset, strips, runs] = arguments else { return None };
    let (runs, strips): (usize, usize) = (runs.parse().ok()?, strips.parse().ok()?);
    let number = if preset == "paper" { "nodes" } else { "strips" };
    let overrides = [format!("aero.preset='{preset}'"), format!("aero.{preset}.{number}={strips}")];
    let file = match work.as_str() {
        "spars" => "soft_20g.toml",
        "rigid" => "cruise_20g.toml",
        _ => "banking_turn.toml",
    };
    let scenario = scenario(file, &overrides.each_ref().map(String::as_str));
    let (robot, x) = (scenario.robot(), scenario.start());
    let (mut dx, u) = (x.clone(), vec![0.01; robot.inputs().len()]);
    let mut linearisation = Linearisation::new(x.len(), u.len());
    let mut loads = Some(Loads::boxed());
    let mut controller = if work == "update" { scenario.controller().ok()? } else { None };
    let [x_lanes, u_lanes] =
        [&x, &u].map(|numbers| numbers.iter().map(|number| Single8::from(*number)).collect::<Vec<_>>());
    let mut dx_lanes = x_lanes.clone();
    for run in 0..runs {
        let (t, x, u) = (black_box(0.1), black_box(&x[..]), black_box(&u[..]));
        match work.as_str() {
            "evaluation" | "spars" | "rigid" => robot.rates_in_numbers(t, x, u, &mut dx).ok()?,
            "lanes" => {
                let (x, u) = (black_box(&x_lanes[..]), black_box(&u_lanes[..]));
                robot.rates_in_single8(Single8::from(t), x, u, &mut dx_lanes).ok()?;
            }
            "jacobian" => linearisation.evaluate(robot, t, x, u).ok()?,
            "inputs" => linearisation.evaluate_inputs(robot, t, x, u).ok()?,
            "update" => {
                // The state is the same each time: the plan moves on to it.
                let t = 0.005 * run as f64;
                black_box(controller.as_mut()?.update(t, &Measurement::new(t, robot.states(), x)));
            }
            "sample" => {
                loads = Some(
                    black_box(robot.observe_beyond(t, x, u, &BeyondLoads::NONE, loads.take()?).ok()?).strips,
                )
            }
            _ => return None,
        }
        black_box((&dx, &dx_lanes, &linearisation));
    }
    Some(())
}

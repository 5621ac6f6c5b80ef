//! Solves recorded instances of FLAPBODY-14 A on request: each line
//! `instance iterations` of the input is answered by the microseconds of the
//! processor taken from a cold start and the inputs found.

use cpu_time::ProcessTime;
use std::io::{BufRead, Write};
use wingbeat_validate::{Error, flapbody};

fn main() -> Result<(), Error> {
    let plant = flapbody::FlapBody::default();
    let instances = flapbody::instances()?;
    let mut solver = flapbody::solver(&plant)?;
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let numbers: Vec<usize> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [instance, iterations] = numbers[..] else {
            return Err(Error::NoAnswer(format!("`{line}` is not `instance iterations`")));
        };
        let case =
            instances.get(instance).ok_or_else(|| Error::NoAnswer(format!("no instance {instance}")))?;
        let begun = ProcessTime::now();
        solver.reset(&plant, &case.state);
        solver.solve(&plant, &case.problem, case.time, &case.state, iterations);
        let elapsed = begun.elapsed();
        print!("{:.3}", 1e6 * elapsed.as_secs_f64());
        for u in &solver.plan().u {
            print!(" {u:.17e}");
        }
        println!();
        let _ = std::io::stdout().flush();
    }
    Ok(())
}

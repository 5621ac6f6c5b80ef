//! Running time of the interior-point solver on FLAPBODY-14 B; `cargo xtask peers offline` sets it beside IPOPT's.
//!
//! Prints `name<TAB>seconds`: processor time of one solve, the least of three. Tolerances as IPOPT's defaults.

use cpu_time::ProcessTime;
use std::hint::black_box;

use wingbeat::ocp::interior_point::Options;
use wingbeat_validate::ocp_problems::flapbody::TurnIn;

fn main() {
    let options = Options { tolerance: 1e-8, complementarity: 1e-8, ..Options::default() };
    let mut least = f64::INFINITY;
    for _ in 0..3 {
        let start = ProcessTime::now();
        let solution = black_box(TurnIn::default().solve(100, &options));
        least = least.min(start.elapsed().as_secs_f64());
        eprintln!("{} after {} iterations, {:.10}", solution.status, solution.iterations, solution.objective);
    }
    println!("flapbody14_b\t{least:e}");
}

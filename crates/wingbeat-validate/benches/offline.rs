//! Running time of the interior-point solver on FLAPBODY-14 B; `cargo xtask peers offline` sets it beside IPOPT's.
//!
//! Prints `name<TAB>seconds`: processor time of one solve, the least of three. Tolerances as IPOPT's defaults.

use std::fs;
use std::hint::black_box;
use std::sync::OnceLock;
use std::time::Instant;

use wingbeat::ocp::interior_point::Options;
use wingbeat_validate::ocp_problems::flapbody::TurnIn;

/// Seconds this process has had of a processor; wall time where the system does not tell.
fn processor_time() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let text = fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let nanoseconds: Option<f64> = text.split_whitespace().next().and_then(|n| n.parse().ok());
    nanoseconds.map_or_else(|| START.get_or_init(Instant::now).elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

fn main() {
    let options = Options { tolerance: 1e-8, complementarity: 1e-8, ..Options::default() };
    let mut least = f64::INFINITY;
    for _ in 0..3 {
        let start = processor_time();
        let solution = black_box(TurnIn::default().solve(100, &options));
        least = least.min(processor_time() - start);
        eprintln!("{} after {} iterations, {:.10}", solution.status, solution.iterations, solution.objective);
    }
    println!("flapbody14_b\t{least:e}");
}

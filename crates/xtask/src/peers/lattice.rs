//! PteraSoftware's vortex lattice beside ours, and what a large free wake costs.

use std::path::Path;

use super::{ROUNDS, Times, circumstances, median, script, shown, table, times};
use crate::{documents, tools};

/// Sizes of the large wakes, rings.
const RINGS: [u32; 6] = [5_000, 10_000, 20_000, 50_000, 100_000, 200_000];

/// What the bench of the lattice prints, of its part `part` where one is named.
fn bench(part: &[&str]) -> Option<Times> {
    let own = ["bench", "--quiet", "--package", "wingbeat-lattice", "--bench", "speed", "--"];
    times(tools::cargo(&[&own[..], part].concat()))
}

/// Runs both sides in turns; prints the tables and puts them into docs/performance.md.
pub fn compare(python: &Path) -> bool {
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let peer = times(script(python, "pterasoftware_flap.py", &[]));
        let (Some(own), Some(peer)) = (bench(&[]), peer) else { return false };
        ours.push(own);
        theirs.push(peer);
    }
    let (Some(errors), Some(growth)) = (bench(&["errors"]), bench(&["growth"])) else { return false };
    let memory = median(&ours, "memory_mb").zip(growth.get("memory_large_mb").copied());
    let Some((memory, large)) = memory else { return false };
    let mut text = table(&ours, &theirs);
    text += &format!(
        "\n\nPer simulated second. Peak memory {memory:.1} MB. Lift of the free wake, rms over rms of the last cycle: \
         by multipoles against directly {:.1e}, against panels and steps twice as fine {:.1e}.\n\n",
        errors.get("fast_over_direct").copied().unwrap_or(f64::NAN),
        errors.get("coarse_over_fine").copied().unwrap_or(f64::NAN),
    );
    text += "| rings | direct | fast | rms error of velocity |\n|---:|---:|---:|---:|";
    for rings in RINGS {
        let value = |kind: &str| growth.get(&format!("{kind}_{rings}")).copied().unwrap_or(f64::NAN);
        let [direct, fast, error] = [value("direct"), value("fast"), value("error")];
        text += &format!("\n| {rings} | {} | {} | {error:.1e} |", shown(direct), shown(fast));
    }
    let exponent = |kind: &str| {
        let at = |rings: u32| growth.get(&format!("{kind}_{rings}")).copied().unwrap_or(f64::NAN);
        (at(200_000) / at(20_000)).log10()
    };
    text += &format!(
        "\n\nProcessor time of the velocities of all vertices. From 20 000 rings on it grows with their number to the power {:.2}, \
         directly {:.2}; peak memory {large:.0} MB.",
        exponent("fast"),
        exponent("direct")
    );
    println!("{text}");
    documents::put_into(
        "docs/performance.md",
        "lattice",
        &format!("{text}\n\n{}", circumstances(&["pterasoftware"])),
    )
}

//! The emulated box for other programs: prints what our recorder reads of it, then `ready RDT_PORT HTTP_PORT`, and
//! serves until its input ends.

use std::io::Read;
use std::net::{IpAddr, Ipv4Addr};

use wingbeat_netft::{Emulator, Error, Faults, RecordingOptions, Signal, read_config, record};

/// Added to the box's ports.
const OFFSET: u16 = 8120;
/// One period of the flapping signal at 7 kHz.
const PERIOD: u64 = 2000;

fn main() -> Result<(), Error> {
    let home = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let emulator = Emulator::start(home, OFFSET, Signal::Flapping, Faults::default())?;
    let scale = read_config(emulator.http)?.scale;
    let mut options = RecordingOptions::new(emulator.rdt);
    options.count = PERIOD;
    let folder = std::env::temp_dir().join(format!("wingbeat-netft-worker-{}", std::process::id()));
    record(&options, &scale, &folder, "raw", |row| {
        if let Some(row) = row {
            let wrench = scale.wrench(row.record.counts).map(|x| x.to_string()).join("\t");
            println!("{}\t{wrench}", row.record.ft_sequence);
        }
        true
    })?;
    drop(std::fs::remove_dir_all(folder));
    println!("ready {} {}", emulator.rdt.port(), emulator.http.port());
    let mut rest = String::new();
    drop(std::io::stdin().read_to_string(&mut rest));
    Ok(())
}

//! `wingbeat rig`.

mod display;
mod emulate;
mod faults;
pub mod pictures;
mod plan;
mod process;
mod record;
pub mod recorded;
mod runs;
mod simulate;

pub use process::process;
pub use simulate::simulate;

use crate::args::Rig;
use crate::error::Error;

/// Does what the subcommand asks.
pub fn rig(command: &Rig) -> Result<(), Error> {
    match command {
        Rig::Plan(arguments) => plan::plan(arguments),
        Rig::Simulate(arguments) => simulate::simulate(arguments),
        Rig::Process(arguments) => process::process(arguments),
        Rig::Record(arguments) => record::record(arguments),
        Rig::Emulate(arguments) => emulate::emulate(arguments),
    }
}

//! `wingbeat rig emulate`.

use std::time::Duration;

use wingbeat::rig::cell::CHANNELS;
use wingbeat::simulate::Record;
use wingbeat_io::read_parquet_columns;
use wingbeat_netft::{Emulator, Faults, LoadPattern, RecordNumbering, Sent, Signal};

use crate::args::{EmulatedLoads, EmulatedNumbers, RigEmulate};
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::say::say;

/// Names of faults, and their arguments.
const KEYS: [(&str, &str); 10] = [
    ("drop", "--drop"),
    ("duplicate", "--duplicate"),
    ("reorder", "--reorder"),
    ("delay", "--delay"),
    ("garbage", "--garbage"),
    ("saturation", "--saturation"),
    ("warning", "--warning"),
    ("serious", "--serious"),
    ("pace", "--pace"),
    ("port_offset", "--port-offset"),
];

/// Emulates the box until Ctrl-C.
pub fn emulate(arguments: &RigEmulate) -> Result<(), Error> {
    let interrupt = Interrupt::listen()?;
    let signal = match &arguments.play {
        None => Signal::Flapping,
        Some(file) => {
            Signal::Samples(samples(&read_parquet_columns(file, &CHANNELS.map(|(name, _)| name))?)?)
        }
    };
    let faults = Faults {
        drop: arguments.drop,
        duplicate: arguments.duplicate,
        reorder: arguments.reorder,
        delay: arguments.delay,
        garbage: arguments.garbage,
        saturation: arguments.saturation,
        warning: arguments.warning,
        serious: arguments.serious,
        stall_after: arguments.stall_after,
        restart_after: arguments.restart_after,
        restart_at: arguments.restart_at,
        die_after: arguments.die_after,
        jump_after: arguments.jump_after,
        pace: arguments.pace,
        sequence: arguments.sequence,
        numbers: numbers(arguments.numbers),
        loads: loads(arguments.loads),
        seed: arguments.seed,
    };
    let emulator = Emulator::start(arguments.bind, arguments.port_offset, signal, faults).map_err(
        |error| match error {
            wingbeat_netft::Error::Refused(error) => error.renamed(&KEYS).into(),
            error => Error::Input(error.to_string()),
        },
    )?;
    say(&format!("RDT on udp://{}, pages on http://{}; Ctrl-C ends\n", emulator.rdt, emulator.http))?;
    while interrupt.flow().is_continue() {
        std::thread::sleep(Duration::from_millis(100));
    }
    say(&words(&emulator.sent()))
}

fn numbers(asked: EmulatedNumbers) -> RecordNumbering {
    match asked {
        EmulatedNumbers::Counted => RecordNumbering::Counted,
        EmulatedNumbers::Random => RecordNumbering::Random,
        EmulatedNumbers::Backward => RecordNumbering::Backward,
        EmulatedNumbers::Frozen => RecordNumbering::Frozen,
        EmulatedNumbers::FrozenSamples => RecordNumbering::FrozenSamples,
    }
}

fn loads(asked: EmulatedLoads) -> LoadPattern {
    match asked {
        EmulatedLoads::Measured => LoadPattern::Measured,
        EmulatedLoads::Zero => LoadPattern::Zero,
        EmulatedLoads::StuckFz => LoadPattern::StuckFz,
        EmulatedLoads::Frozen => LoadPattern::Frozen,
    }
}

/// One line per count, `name value`.
fn words(sent: &Sent) -> String {
    let counts = [
        ("records", sent.records),
        ("dropped", sent.dropped),
        ("duplicated", sent.duplicated),
        ("reordered", sent.reordered),
        ("delayed", sent.delayed),
        ("garbage", sent.garbage),
        ("saturated", sent.saturated),
        ("warnings", sent.warnings),
        ("serious", sent.serious),
        ("stalls", sent.stalls),
        ("restarts", sent.restarts),
        ("jumps", sent.jumps),
    ];
    counts.iter().map(|(name, count)| format!("{name:10} {count}\n")).collect()
}

fn samples(record: &Record) -> Result<Vec<[f64; 6]>, Error> {
    let columns = CHANNELS.map(|(name, _)| record.values(name));
    if let Some(index) = columns.iter().position(Option::is_none) {
        return Err(Error::Input(format!("the record has no column {}", CHANNELS[index].0)));
    }
    let value = |i: usize, row: usize| columns[i].map_or(0.0, |values| values[row]);
    Ok((0..record.rows()).map(|row| std::array::from_fn(|i| value(i, row))).collect())
}

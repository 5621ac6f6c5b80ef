//! `wingbeat rig record`.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use wingbeat::rig::netft::{RDT_PORT, Scale};
use wingbeat_netft::{RecordingEnd, RecordingOptions, Report, read_config_while};

use super::display::Display;
use super::faults::Alarm;
use super::recorded::{self, RAW, RecordingSummary};
use crate::args::RigRecord;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::run_folder::RunFolder;
use crate::say;

/// The file that says what a recording is of.
const IDENTITY: &str = "recording.json";

/// Records until the time is over or Ctrl-C.
pub fn record(arguments: &RigRecord) -> Result<(), Error> {
    let start = Instant::now();
    // The offset is bounded where the arguments are read.
    let at = |port: u16| SocketAddr::new(arguments.address, port.saturating_add(arguments.port_offset));
    if !(arguments.frequency > 0.0 && arguments.frequency.is_finite()) {
        let hz = arguments.frequency;
        return Err(Error::Input(format!("--frequency {hz}: allowed is a finite number above 0")));
    }
    let options = options(arguments, at(RDT_PORT))?;
    let interrupt = Interrupt::listen()?;
    let config = read_config_while(at(80), &|| interrupt.flow().is_continue());
    interrupt.check()?;
    let config = config.map_err(refused)?;
    let scale = config.scale;
    let identity = identity(options.address, &scale);
    let folder = RunFolder::resume_measured(&arguments.out, arguments.force, (IDENTITY, &identity))?;
    interrupt.patient();
    let mut display = Display::new(scale, arguments.frequency, arguments.quiet);
    let mut alarm = Alarm::new();
    let report = wingbeat_netft::record(&options, &scale, folder.partial(), RAW, |row| {
        if let Some(row) = row {
            display.see(row);
        }
        for line in alarm.see(row) {
            display.bar.suspend(|| say::note(&line));
        }
        interrupt.flow().is_continue()
    });
    let nothing = recorded::rows(folder.partial()).is_ok_and(|rows| rows == 0);
    let report = match report {
        Ok(report) if !nothing => report,
        outcome => return Err(nothing_kept(folder, nothing, outcome, &interrupt)),
    };
    if let RecordingEnd::Disk(why) = &report.ending {
        return Err(unfinished(&folder, why));
    }
    display.bar.set_message("writing record.parquet");
    let summary = recorded::write(&folder, &report, &config).map_err(|why| unfinished(&folder, &why))?;
    let text = summary.words();
    let done = folder.write("report.txt", &text).and_then(|()| folder.write_json("summary.json", &summary));
    done.map_err(|why| unfinished(&folder, &why))?;
    let path = folder.finish(&Manifest::new(0, start.elapsed()))?;
    display.bar.finish_and_clear();
    for warning in &summary.verdict.warnings {
        say::note(&warning.to_string());
    }
    let printed = say::unless(arguments.quiet, || format!("{text}recording: {}\n", path.display()));
    ended(&summary, path).and(printed)
}

fn options(arguments: &RigRecord, address: SocketAddr) -> Result<RecordingOptions, Error> {
    let mut options = RecordingOptions::new(address);
    options.buffered = arguments.buffered;
    options.bias = arguments.bias;
    options.rotate_rows = arguments.rotate;
    options.duration =
        arguments.duration.map(Duration::try_from_secs_f64).transpose().map_err(|e| {
            Error::Input(format!("--duration {}: {e}", arguments.duration.unwrap_or_default()))
        })?;
    if arguments.fail_stop {
        options.reconnects = 0;
    }
    Ok(options)
}

fn identity(address: SocketAddr, scale: &Scale) -> String {
    let [force, torque] = [scale.per_newton, scale.per_newton_metre];
    format!(
        "{{\n  \"box\": \"{address}\",\n  \"counts_per_newton\": {force:?},\n  \
         \"counts_per_newton_metre\": {torque:?}\n}}\n"
    )
}

fn refused(error: wingbeat_netft::Error) -> Error {
    Error::Input(error.to_string())
}

/// Ends a recording that has no row, or could not go on.
fn nothing_kept(
    folder: RunFolder,
    nothing: bool,
    outcome: Result<Report, wingbeat_netft::Error>,
    interrupt: &Interrupt,
) -> Error {
    let error = match outcome {
        Ok(Report { ending: RecordingEnd::Disk(why), .. }) => {
            Error::Input(format!("no record was written: {why}"))
        }
        Ok(_) if interrupt.flow().is_break() => Error::Interrupted,
        Ok(Report { account, .. }) if account.malformed > 0 => Error::Input(format!(
            "the box sent {} datagrams, none of which is a record: is it a Net F/T box?",
            account.malformed
        )),
        Ok(report) => Error::Input(format!("the box sent no record in {:.1} s", report.head.as_secs_f64())),
        Err(error) => refused(error),
    };
    if nothing {
        folder.discard();
    }
    error
}

/// A recording that cannot be written to its end: the raw logs stay where the same command finds them.
fn unfinished(folder: &RunFolder, why: &dyn std::fmt::Display) -> Error {
    let rows = recorded::rows(folder.partial()).unwrap_or(0);
    let reason = format!(
        "{why}; {rows} records are safe in its raw logs: make room, and the same command goes on from there"
    );
    Error::Failed { status: "unfinished".into(), reason, folder: folder.partial().into() }
}

fn ended(summary: &RecordingSummary, folder: PathBuf) -> Result<(), Error> {
    Error::unless_usable(summary.verdict.status, summary.verdict.reason.as_deref(), &folder)
}

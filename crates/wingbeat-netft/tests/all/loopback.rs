//! Recorder against emulator on the loopback: every fault shows in its counter.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::time::Duration;

use wingbeat_netft::{
    Emulator, Faults, RecordingEnd, RecordingOptions, Report, Row, Sent, Signal, read_config, read_log,
    record,
};

/// All rows of a log.
fn rows(file: &std::path::Path) -> Vec<Row> {
    read_log(file).unwrap().map(Result::unwrap).collect()
}

fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("wingbeat-netft-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    path
}

/// Records `count` records of an emulator with `faults`; the last ones may be missing in its books.
fn run(
    name: &str,
    offset: u16,
    faults: Faults,
    set: impl Fn(&mut RecordingOptions),
) -> (Report, Sent, PathBuf) {
    let home = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let emulator = Emulator::start(home, offset, Signal::Flapping, faults).unwrap();
    let config = read_config(emulator.http).unwrap();
    let mut options = RecordingOptions::new(emulator.rdt);
    options.count = 7000;
    options.duration = Some(Duration::from_secs(20));
    set(&mut options);
    let path = folder(name);
    let report = record(&options, &config.scale, &path, "run", |_| true).unwrap();
    let sent = emulator.sent();
    (report, sent, path)
}

#[test]
fn a_clean_stream_is_recorded_whole() {
    let (report, _, path) = run("clean", 8001, Faults::default(), |_| {});
    assert_eq!(report.ending, RecordingEnd::Complete);
    let a = &report.account;
    assert_eq!((a.received, a.lost, a.duplicates, a.reordered, a.malformed), (7000, 0, 0, 0, 0));
    assert!((report.rate_hz - 7000.0).abs() < 200.0, "{}", report.rate_hz);
    assert_eq!(report.kernel_drops, 0);
    let rows = rows(&report.files[0]);
    assert_eq!(rows.len(), 7000);
    assert!(rows.windows(2).all(|w| w[1].record.rdt_sequence == w[0].record.rdt_sequence + 1));
    assert!(rows.iter().all(|row| row.kernel_ns > 0 && row.host_ns >= row.kernel_ns));
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn buffered_records_come_in_packs_and_logs_rotate() {
    let (report, _, path) = run("buffered", 8002, Faults::default(), |o| {
        o.buffered = true;
        o.rotate_rows = 3000;
    });
    assert_eq!((report.account.received, report.account.lost), (7000, 0));
    let lengths: Vec<_> = report.files.iter().map(|file| rows(file).len()).collect();
    assert_eq!(lengths, [3000, 3000, 1000]);
    std::fs::remove_dir_all(path).unwrap();
}

/// How many faults of the share `share` may have come after the last record of 7000 that was kept: the box
/// goes on until it hears the stop. Twice the expectation, and three.
fn after_the_last(sent: &Sent, share: f64) -> u64 {
    3 + (2.0 * share * sent.records.saturating_sub(7000) as f64) as u64
}

#[test]
fn drops_are_counted_exactly() {
    let faults = Faults { drop: 0.01, seed: 1, ..Default::default() };
    let (report, sent, path) = run("drop", 8003, faults, |_| {});
    let a = &report.account;
    assert!(sent.dropped > 30 && a.gaps > 30);
    assert_eq!(a.received, 7000);
    let after = 2 + after_the_last(&sent, 0.01);
    assert!(a.lost <= sent.dropped && sent.dropped - a.lost <= after, "{} {}", a.lost, sent.dropped);
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn duplicates_and_late_records_are_told_apart() {
    let faults = Faults { duplicate: 0.02, reorder: 0.02, seed: 2, ..Default::default() };
    let (report, sent, path) = run("order", 8004, faults, |_| {});
    let a = &report.account;
    assert_eq!(a.lost, 0);
    let after = after_the_last(&sent, 0.02);
    assert!(
        sent.duplicated.abs_diff(a.duplicates) <= after && a.duplicates > 80,
        "{} {}",
        sent.duplicated,
        a.duplicates
    );
    assert!(
        sent.reordered.abs_diff(a.reordered) <= after && a.reordered > 80,
        "{} {}",
        sent.reordered,
        a.reordered
    );
    let rows = rows(&report.files[0]);
    let mut numbers: Vec<_> = rows.iter().map(|row| row.record.rdt_sequence).collect();
    numbers.sort_unstable();
    assert!(numbers.windows(2).all(|w| w[1] == w[0] + 1));
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn garbage_saturation_and_delay_are_seen() {
    let faults = Faults { garbage: 0.02, saturation: 0.05, delay: 0.001, seed: 3, ..Default::default() };
    let (report, sent, path) = run("garbage", 8005, faults, |_| {});
    let a = &report.account;
    assert_eq!((a.received, a.lost), (7000, 0));
    assert!(sent.garbage.abs_diff(a.malformed) <= 3 && a.malformed > 80);
    assert!(sent.saturated.abs_diff(a.saturated) <= 20 && a.saturated > 200);
    assert!(sent.delayed > 0 && report.longest_silence >= Duration::from_millis(15));
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_stall_is_survived_or_ends_the_recording() {
    let faults = Faults { stall_after: 3000, ..Default::default() };
    let (report, _, path) = run("stall", 8006, faults, |o| o.stall = Duration::from_millis(200));
    assert_eq!((report.ending, report.account.received), (RecordingEnd::Complete, 7000));
    let a = &report.account;
    assert_eq!((report.stalls, a.restarts, a.reboots), (2, 2, 0));
    // The box goes on sampling while it does not send: two silences of at least 0.2 s and the pause of 0.1 s.
    let rows = rows(&report.files[0]);
    let span = rows[6999].record.ft_sequence - rows[0].record.ft_sequence + 1;
    assert_eq!((u64::from(span), a.lost), (a.received + a.unsent, 0));
    assert!(a.unsent > 2 * 2100, "{}", a.unsent);
    std::fs::remove_dir_all(path).unwrap();
    let (report, _, path) = run("silent", 8007, faults, |o| {
        o.stall = Duration::from_millis(200);
        o.reconnects = 0;
    });
    assert_eq!((report.ending, report.account.received), (RecordingEnd::Silent, 3000));
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_box_that_restarts_is_asked_again_until_it_answers() {
    let faults = Faults { restart_after: 3000, ..Default::default() };
    let (report, sent, path) = run("reboot", 8010, faults, |o| o.stall = Duration::from_millis(200));
    let a = &report.account;
    assert_eq!((report.ending, a.received, a.lost, a.duplicates), (RecordingEnd::Complete, 7000, 0, 0));
    assert_eq!((sent.restarts, report.stalls, a.restarts, a.reboots), (2, 2, 2, 2));
    assert!(report.longest_silence >= Duration::from_secs(1), "{:?}", report.longest_silence);
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_restart_whose_count_passes_the_old_one_is_booked_by_the_clock() {
    let faults = Faults { restart_after: 3000, restart_at: 30_000, ..Default::default() };
    let (report, _, path) = run("passing", 8014, faults, |o| o.stall = Duration::from_millis(200));
    let a = &report.account;
    assert_eq!((report.ending, a.received, a.reboots), (RecordingEnd::Complete, 7000, 2));
    let rows = rows(&report.files[0]);
    let seconds = (rows[6999].arrival_ns() - rows[0].arrival_ns()) as f64 * 1e-9;
    assert!((a.booked() as f64 / 7000.0 - seconds).abs() < 0.1, "{} {seconds}", a.booked());
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_jump_in_the_numbers_is_no_loss() {
    let faults = Faults { jump_after: 3000, ..Default::default() };
    let (report, sent, path) = run("jump", 8015, faults, |_| {});
    let a = &report.account;
    assert_eq!((a.received, a.lost, a.jumps, a.reboots, sent.jumps), (7000, 0, 1, 0, 1));
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn noise_alone_is_silence() {
    let faults = Faults { drop: 1.0, garbage: 1.0, ..Default::default() };
    let (report, _, path) = run("noise", 8016, faults, |o| {
        o.stall = Duration::from_millis(200);
        o.reconnects = 1;
    });
    assert_eq!((report.ending, report.account.received), (RecordingEnd::Silent, 0));
    assert!(report.account.malformed > 100 && report.stalls == 1, "{:?}", report.account);
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn the_tail_after_the_last_record_is_told() {
    let faults = Faults { die_after: 3000, ..Default::default() };
    let (report, _, path) = run("death", 8017, faults, |o| o.duration = Some(Duration::from_secs(2)));
    assert_eq!(report.account.received, 3000);
    assert!(report.tail.as_secs_f64() > 1.2 && report.head.as_secs_f64() < 0.3, "{report:?}");
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_slow_box_keeps_its_numbers_but_not_its_time() {
    let faults = Faults { pace: 0.2, ..Default::default() };
    let (report, _, path) = run("slow", 8018, faults, |o| o.duration = Some(Duration::from_secs(2)));
    assert_eq!((report.account.lost, report.account.rate()), (0, Some(7000.0)));
    assert!((report.rate_hz - 1400.0).abs() < 50.0, "{}", report.rate_hz);
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn faults_that_are_none_are_refused_by_their_key() {
    let home = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let start = |offset: u16, faults: Faults| {
        Emulator::start(home, offset, Signal::Flapping, faults).map(drop).unwrap_err().to_string()
    };
    assert!(start(8019, Faults { drop: 2.0, ..Default::default() }).contains("drop = 2"));
    assert!(start(8019, Faults { pace: f64::NAN, ..Default::default() }).contains("pace = NaN"));
    assert!(start(8019, Faults { garbage: -0.1, ..Default::default() }).contains("garbage = -0.1"));
    let marked = Faults { saturation: 0.6, serious: 0.6, ..Default::default() };
    assert!(start(8019, marked).contains("saturation = 0.6"));
    assert!(start(16384, Faults::default()).contains("port_offset = 16384"));
}

#[test]
fn numbers_wrap_without_a_gap() {
    let faults = Faults { sequence: u32::MAX - 3000, drop: 0.01, seed: 4, ..Default::default() };
    let (report, sent, path) = run("wrap", 8011, faults, |_| {});
    let a = &report.account;
    assert_eq!((a.received, a.restarts, a.duplicates, a.reordered), (7000, 0, 0, 0));
    let after = 2 + after_the_last(&sent, 0.01);
    assert!(a.lost <= sent.dropped && sent.dropped - a.lost <= after, "{} {}", a.lost, sent.dropped);
    let rows = rows(&report.files[0]);
    assert!(rows[0].record.rdt_sequence > u32::MAX - 3000 && rows[6999].record.rdt_sequence < 5000);
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn status_words_are_told_apart() {
    let faults = Faults { saturation: 0.05, warning: 0.1, serious: 0.02, seed: 5, ..Default::default() };
    let (report, sent, path) = run("status", 8012, faults, |_| {});
    let a = &report.account;
    assert_eq!((a.received, a.lost), (7000, 0));
    let pairs = [(sent.saturated, a.saturated), (sent.warnings, a.warnings), (sent.serious, a.serious)];
    assert!(pairs.iter().all(|(made, seen)| *seen > 80 && made >= seen && made - seen <= 60), "{pairs:?}");
    let marked = rows(&report.files[0]).iter().filter(|row| row.record.status == 0x8001_0000).count();
    assert_eq!(marked as u64, a.warnings);
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_silent_box_does_not_hold_the_recorder() {
    let faults = Faults { restart_after: 700, ..Default::default() };
    let home = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let emulator = Emulator::start(home, 8013, Signal::Flapping, faults).unwrap();
    let scale = read_config(emulator.http).unwrap().scale;
    let path = folder("idle");
    let began = std::time::Instant::now();
    // The observer is asked while nothing comes, so that Ctrl-C works.
    let mut idle = 0;
    let report = record(&RecordingOptions::new(emulator.rdt), &scale, &path, "run", |row| {
        idle += usize::from(row.is_none());
        idle < 3
    });
    assert_eq!((report.unwrap().account.received, idle), (700, 3));
    assert!(began.elapsed() < Duration::from_secs(5));
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn a_bias_is_confirmed() {
    let (report, _, path) = run("bias", 8008, Faults::default(), |o| o.bias = true);
    // The flapping signal swings about the load that was taken as zero.
    let residual = report.bias_residual.unwrap();
    assert!(residual < 0.6, "{residual}");
    assert_eq!(report.account.lost, 0);
    std::fs::remove_dir_all(path).unwrap();
}

#[test]
fn taken_ports_and_closed_folders_are_explained() {
    let home = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let refused = Emulator::start(home, 8009, Signal::Flapping, Faults::default()).unwrap();
    let clash = Emulator::start(home, 8009, Signal::Flapping, Faults::default()).unwrap_err();
    assert!(clash.to_string().contains("--port-offset"), "{clash}");
    let scale = read_config(refused.http).unwrap().scale;
    let nowhere =
        record(&RecordingOptions::new(refused.rdt), &scale, std::path::Path::new("/proc/no"), "run", |_| {
            true
        });
    assert!(nowhere.unwrap_err().to_string().contains("/proc/no"));
}

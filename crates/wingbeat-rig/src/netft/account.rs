//! The books of a stream of records: nothing is lost silently.

use super::{APART_S, BOX_RATE, RdtRecord, StatusClass, classify};

/// Records behind the latest of which it is remembered whether they came.
const WINDOW: u32 = 1 << 16;

/// Accounts for every record of the streams that a box sends one after another.
///
/// Within a stream `rdt_sequence` counts by one; a record that carries an earlier number but is not one of
/// those that came or are missing begins a new stream, and so does one whose number leapt ahead by more than the
/// clock of arrival allows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Account {
    /// Records taken for the first time.
    pub received: u64,
    /// Records that never came.
    pub lost: u64,
    /// Places in the sequence where some were missing.
    pub gaps: u64,
    /// Longest run of missing records.
    pub longest_gap: u64,
    /// Records that came again.
    pub duplicates: u64,
    /// Records that came after later ones.
    pub reordered: u64,
    /// Datagrams that are no records.
    pub malformed: u64,
    /// Records with a warning status.
    pub warnings: u64,
    /// Records with a saturated channel.
    pub saturated: u64,
    /// Records with a serious status.
    pub serious: u64,
    /// Streams begun anew.
    pub restarts: u64,
    /// Records between one stream and the next: by the box's own count, or by the clock where that count began anew.
    pub unsent: u64,
    /// New streams before which the box's own count began anew: it, and the clock, passed by more than half a second
    /// apart.
    pub reboots: u64,
    /// Places where the box's numbers leapt ahead without the time for it.
    pub jumps: u64,
    /// The record furthest on in the stream.
    latest: Option<Latest>,
    /// The stream was asked for again, and no record came since.
    asked: bool,
    /// Samples of the box from record to record.
    step: u32,
    /// The last [`WINDOW`] records by `rdt_sequence`.
    recent: Vec<Fate>,
}

/// Numbers of a record, and when it came, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Latest {
    rdt: u32,
    ft: u32,
    arrival_ns: u64,
}

impl Latest {
    fn of(record: &RdtRecord, arrival_ns: u64) -> Self {
        Self { rdt: record.rdt_sequence, ft: record.ft_sequence, arrival_ns }
    }

    /// Time since `earlier`, s.
    fn since(self, earlier: Self) -> f64 {
        (i128::from(self.arrival_ns) - i128::from(earlier.arrival_ns)) as f64 * 1e-9
    }

    /// Samples of the box since `earlier`, by its own count.
    fn samples_since(self, earlier: Self) -> i32 {
        self.ft.wrapping_sub(earlier.ft) as i32
    }
}

/// True when so many samples of the box and a time, s, may be the same.
fn agrees(samples: i32, seconds: f64) -> bool {
    (f64::from(samples) / BOX_RATE - seconds).abs() < APART_S + DRIFT * seconds.abs()
}

/// True when so many samples of the box take longer than a time, s.
fn leaps(samples: f64, seconds: f64) -> bool {
    samples / BOX_RATE > seconds.max(0.0) * (1.0 + DRIFT) + APART_S
}

/// Largest share by which two clocks differ (*choice*: ten times the error of a quartz clock of a PC).
const DRIFT: f64 = 1e-3;

/// What became of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// Before the first that came.
    Unknown,
    /// Counted as lost.
    Missing,
    /// Came with this `ft_sequence`.
    Came(u32),
}

/// Where a record stands in the stream.
enum RecordPlace {
    /// First that came of a stream.
    First,
    /// So far ahead of the latest that it is of another stream.
    Leapt,
    /// Ahead of the latest; so many are missing between.
    Ahead(u32),
    /// After later ones; true when it was counted as lost.
    Late(bool),
    /// One that came before.
    Again,
}

impl Account {
    /// Takes note of a record that came at `arrival_ns` by any clock; true when it is new.
    pub fn take(&mut self, record: &RdtRecord, arrival_ns: u64) -> bool {
        if !self.asked && matches!(self.place(record, arrival_ns), RecordPlace::Again) {
            self.duplicates += 1;
            return false;
        }
        self.take_new(record, arrival_ns);
        true
    }

    /// The stream was asked for again after a silence: a record with the numbers of an earlier one is no duplicate
    /// but of a box that counts anew, which may well come by the same numbers.
    pub fn asked(&mut self) {
        self.asked = true;
    }

    /// Takes note of a record that is known to be no duplicate, as those of a log.
    pub fn take_new(&mut self, record: &RdtRecord, arrival_ns: u64) {
        match self.place(record, arrival_ns) {
            RecordPlace::Late(missed) => {
                self.lost -= u64::from(missed);
                self.reordered += 1;
            }
            RecordPlace::First | RecordPlace::Again => self.begin(record, arrival_ns, false),
            RecordPlace::Leapt => self.begin(record, arrival_ns, true),
            RecordPlace::Ahead(missing) => self.advance(record, arrival_ns, missing),
        }
        self.asked = false;
        *self.slot(record.rdt_sequence) = Fate::Came(record.ft_sequence);
        self.received += 1;
        match classify(record.status) {
            StatusClass::Good => {}
            StatusClass::Warning => self.warnings += 1,
            StatusClass::Saturated => self.saturated += 1,
            StatusClass::Serious => self.serious += 1,
        }
    }

    /// Every record that should be there by the box's numbers: those that came, and those booked as missing.
    pub fn booked(&self) -> u64 {
        self.received + self.lost + self.unsent
    }

    /// The counts alone, without what is remembered of the stream.
    pub fn counts(&self) -> Self {
        self.since(&Self::default())
    }

    /// What was counted since `before`, an earlier state of this account. A record that came late takes back a loss that was counted
    /// before: no count falls below zero.
    pub fn since(&self, before: &Self) -> Self {
        let count = |of: fn(&Self) -> u64| of(self).saturating_sub(of(before));
        Self {
            received: count(|a| a.received),
            lost: count(|a| a.lost),
            gaps: count(|a| a.gaps),
            duplicates: count(|a| a.duplicates),
            reordered: count(|a| a.reordered),
            malformed: count(|a| a.malformed),
            warnings: count(|a| a.warnings),
            saturated: count(|a| a.saturated),
            serious: count(|a| a.serious),
            restarts: count(|a| a.restarts),
            unsent: count(|a| a.unsent),
            reboots: count(|a| a.reboots),
            jumps: count(|a| a.jumps),
            ..Self::default()
        }
    }

    /// Rate of the records that the box makes, Hz, by the samples from one to the next; none before the second.
    pub fn rate(&self) -> Option<f64> {
        (self.step > 0).then(|| BOX_RATE / f64::from(self.step))
    }

    fn place(&mut self, record: &RdtRecord, arrival_ns: u64) -> RecordPlace {
        let Some(latest) = self.latest else { return RecordPlace::First };
        let now = Latest::of(record, arrival_ns);
        let ahead = now.rdt.wrapping_sub(latest.rdt) as i32;
        if ahead > 0 {
            let samples = f64::from(ahead - 1) * f64::from(self.step.max(1));
            return if leaps(samples, now.since(latest)) {
                RecordPlace::Leapt
            } else {
                RecordPlace::Ahead(ahead as u32 - 1)
            };
        }
        if ahead.unsigned_abs() >= WINDOW {
            return RecordPlace::First;
        }
        // A late record of this stream is about as many samples back as its number says.
        let back = latest.ft.wrapping_sub(record.ft_sequence);
        let furthest = u64::from(self.step) * 2 * (u64::from(ahead.unsigned_abs()) + 1);
        let earlier = (back as i32) > 0 && (self.step == 0 || u64::from(back) <= furthest);
        match *self.slot(record.rdt_sequence) {
            Fate::Came(known) if known == record.ft_sequence => RecordPlace::Again,
            Fate::Missing if earlier => RecordPlace::Late(true),
            Fate::Unknown if earlier => RecordPlace::Late(false),
            _ => RecordPlace::First,
        }
    }

    /// A stream counts from 1: what it sent before the first record that came is lost, if that is near.
    fn begin(&mut self, record: &RdtRecord, arrival_ns: u64, leapt: bool) {
        let missing = record.rdt_sequence.wrapping_sub(1);
        let missing = if missing < WINDOW && !leapt { missing } else { 0 };
        let now = Latest::of(record, arrival_ns);
        if let Some(latest) = self.latest {
            let (samples, seconds) = (now.samples_since(latest), now.since(latest));
            let counted = samples > 0 && agrees(samples, seconds);
            self.restarts += 1;
            self.jumps += u64::from(leapt);
            self.reboots += u64::from(!counted && !leapt);
            let samples = if counted { f64::from(samples) } else { BOX_RATE * seconds };
            let between = (samples / f64::from(self.step.max(1))) as u64;
            self.unsent += between.saturating_sub(1 + u64::from(missing));
        }
        self.recent.clear();
        self.recent.resize(WINDOW as usize, Fate::Unknown);
        self.miss(record.rdt_sequence, missing);
        self.latest = Some(now);
    }

    fn advance(&mut self, record: &RdtRecord, arrival_ns: u64, missing: u32) {
        let now = Latest::of(record, arrival_ns);
        if missing > 0 {
            self.miss(record.rdt_sequence, missing);
        } else if let Some(latest) = self.latest {
            let samples = now.samples_since(latest);
            let leapt = leaps(f64::from(samples), now.since(latest));
            self.jumps += u64::from(leapt);
            if !leapt && samples > 0 {
                self.step = samples as u32;
            }
        }
        self.latest = Some(now);
    }

    /// So many before `rdt_sequence` are missing.
    fn miss(&mut self, rdt_sequence: u32, missing: u32) {
        self.gaps += u64::from(missing > 0);
        self.lost += u64::from(missing);
        self.longest_gap = self.longest_gap.max(u64::from(missing));
        for back in 1..=missing.min(WINDOW - 1) {
            *self.slot(rdt_sequence.wrapping_sub(back)) = Fate::Missing;
        }
    }

    fn slot(&mut self, rdt_sequence: u32) -> &mut Fate {
        &mut self.recent[(rdt_sequence % WINDOW) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nanoseconds of a sample of the box.
    const SAMPLE: u64 = 142_857;

    /// Takes records numbered in the stream and inside the box, as they come from `ns` on, one sample after another.
    fn take_at(account: &mut Account, ns: u64, numbers: impl IntoIterator<Item = (u32, u32)>) {
        for (k, (rdt_sequence, ft_sequence)) in numbers.into_iter().enumerate() {
            let record = RdtRecord { rdt_sequence, ft_sequence, ..Default::default() };
            account.take(&record, ns + k as u64 * SAMPLE);
        }
    }

    fn take(account: &mut Account, numbers: impl IntoIterator<Item = (u32, u32)>) {
        take_at(account, 0, numbers);
    }

    /// The numbers `list` of a stream that began at the box's sample `ft`.
    fn stream<'a>(ft: u32, list: &'a [u32]) -> impl Iterator<Item = (u32, u32)> + 'a {
        list.iter().map(move |n| (*n, ft.wrapping_add(*n)))
    }

    /// A second, ns.
    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn every_record_is_accounted_for() {
        let mut a = Account::default();
        take(&mut a, stream(50, &[1, 2, 5, 4, 4, 6, 3]));
        assert_eq!((a.received, a.lost, a.gaps, a.duplicates, a.reordered), (6, 0, 1, 1, 2));
        take(&mut a, stream(50, &[20]));
        assert_eq!((a.lost, a.longest_gap, a.restarts), (13, 13, 0));
        assert_eq!(a.booked(), 20);
    }

    #[test]
    fn sequences_wrap() {
        let mut a = Account::default();
        take(&mut a, stream(u32::MAX - 7, &[u32::MAX - 1, u32::MAX, 1, 0, 0, 2]));
        assert_eq!((a.received, a.lost, a.reordered, a.duplicates), (5, 0, 1, 1));
        let mut long = Account::default();
        take(&mut long, (0..200_000).map(|n: u32| (n.wrapping_sub(100_000), n.wrapping_sub(50_000))));
        assert_eq!((long.received, long.lost, long.restarts, long.duplicates), (200_000, 0, 0, 0));
    }

    #[test]
    fn a_new_stream_is_told_from_old_records_and_what_lies_between_is_counted() {
        let mut a = Account::default();
        take(&mut a, stream(1000, &[1, 2, 3, 4, 6]));
        // Record 5 of the new stream could be the missing one of the old; the box's own count tells.
        take_at(&mut a, 3 * SECOND / 7, stream(4000, &[5, 6, 7]));
        assert_eq!((a.received, a.lost, a.restarts, a.duplicates, a.reordered), (8, 1 + 4, 1, 0, 0));
        // 1007 to 4000.
        assert_eq!((a.unsent, a.reboots), (2994, 0));
        take_at(&mut a, 2 * SECOND, stream(0, &[1, 2, 3]));
        assert_eq!((a.received, a.restarts, a.reboots), (11, 2, 1));
        // By the clock: 2 s after the begin, 14000 samples.
        assert!(a.booked().abs_diff(14_000 + 3) < 8, "{a:?}");
    }

    #[test]
    fn a_restart_whose_count_passes_the_old_one_is_found_by_the_clock() {
        let mut a = Account::default();
        take(&mut a, (1..=1000).map(|n| (n, n)));
        // Two seconds later the box counts from 2188: its numbers alone say that 1188 samples passed.
        take_at(&mut a, 2 * SECOND, (1..=100).map(|n| (n, 2188 + n)));
        assert_eq!((a.received, a.restarts, a.reboots, a.jumps), (1100, 1, 1, 0));
        assert!(a.booked().abs_diff(14_100) < 3, "{a:?}");
    }

    #[test]
    fn numbers_that_leap_without_the_time_for_it_are_a_jump_and_nothing_is_lost() {
        let mut a = Account::default();
        take(&mut a, (1..=1000).map(|n| (n, n)));
        take_at(&mut a, 1000 * SAMPLE, (1..=1000).map(|n| (n + 2_000_000_000, n + 1000)));
        assert_eq!((a.received, a.lost, a.jumps, a.restarts, a.reboots), (2000, 0, 1, 1, 0));
        assert_eq!(a.booked(), 2000);
        take_at(&mut a, 2000 * SAMPLE, (1001..=2000).map(|n| (n + 2_000_000_000, n + 1_000_000_000)));
        assert_eq!((a.received, a.booked(), a.jumps, a.rate()), (3000, 3000, 2, Some(BOX_RATE)));
        let mut far = Account::default();
        take(&mut far, (0..100).map(|n: u32| (n * 20_000_000, n)));
        assert_eq!((far.received, far.lost, far.jumps), (100, 0, 99));
    }

    #[test]
    fn a_box_that_comes_by_the_same_numbers_again_is_believed_once_it_was_asked() {
        let mut a = Account::default();
        take(&mut a, stream(30, &[1, 2, 3]));
        take(&mut a, stream(30, &[1]));
        assert_eq!((a.received, a.duplicates), (3, 1));
        a.asked();
        take(&mut a, stream(30, &[1, 2, 3, 4, 4]));
        assert_eq!((a.received, a.duplicates, a.restarts, a.reboots), (7, 2, 1, 1));
        let mut replayed = Account::default();
        for (rdt_sequence, ft_sequence) in stream(30, &[1, 2, 3, 1, 2, 3, 4]) {
            replayed.take_new(&RdtRecord { rdt_sequence, ft_sequence, ..Default::default() }, 0);
        }
        assert_eq!((replayed.received, replayed.restarts, replayed.reboots), (7, 1, 1));
    }

    #[test]
    fn every_other_sample_of_a_slower_stream_is_none_missing() {
        let mut a = Account::default();
        let slower = |begin: u32| (1..=100).map(move |n| (n, 14 * (n + begin)));
        let take = |a: &mut Account, begin: u32| {
            for (rdt_sequence, ft_sequence) in slower(begin) {
                let record = RdtRecord { rdt_sequence, ft_sequence, ..Default::default() };
                a.take(&record, u64::from(ft_sequence) * SAMPLE);
            }
        };
        take(&mut a, 0);
        take(&mut a, 150);
        assert_eq!((a.received, a.lost, a.unsent, a.rate()), (200, 0, 50, Some(500.0)));
    }

    #[test]
    fn the_first_records_of_a_stream_may_come_late_or_never() {
        let mut a = Account::default();
        take(&mut a, stream(100, &[4, 2]));
        assert_eq!((a.received, a.lost, a.reordered), (2, 2, 1));
        let mut far = Account::default();
        take(&mut far, stream(9, &[1 << 20, (1 << 20) - 1]));
        assert_eq!((far.received, far.lost, far.reordered), (2, 0, 1));
    }
}

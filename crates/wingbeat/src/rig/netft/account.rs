//! The books of a stream of records: nothing is lost silently.

use super::{RdtRecord, StatusClass, classify};

/// Records behind the latest of which it is remembered whether they came.
const WINDOW: u32 = 1 << 16;

/// Accounts for every record of the streams that a box sends one after another.
///
/// Within a stream `rdt_sequence` counts by one; a record that carries an earlier number but is not one of
/// those that came or are missing begins a new stream.
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
    /// Samples of the box between one stream and the next, by its own count.
    pub unsent: u64,
    /// New streams before which the box's own count began anew, so that what lies between is not known.
    pub reboots: u64,
    /// Numbers (rdt, ft) of the record furthest on in the stream.
    latest: Option<(u32, u32)>,
    /// The stream was asked for again, and no record came since.
    asked: bool,
    /// Samples of the box from record to record.
    step: u32,
    /// The last [`WINDOW`] records by `rdt_sequence`.
    recent: Vec<Fate>,
}

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
enum Place {
    /// First that came of a stream.
    First,
    /// Ahead of the latest; so many are missing between.
    Ahead(u32),
    /// After later ones; true when it was counted as lost.
    Late(bool),
    /// One that came before.
    Again,
}

impl Account {
    /// Takes note of a record; true when it is new.
    pub fn take(&mut self, record: &RdtRecord) -> bool {
        if !self.asked && matches!(self.place(record), Place::Again) {
            self.duplicates += 1;
            return false;
        }
        self.take_new(record);
        true
    }

    /// The stream was asked for again after a silence: a record with the numbers of an earlier one is no duplicate
    /// but of a box that counts anew, which may well come by the same numbers.
    pub fn asked(&mut self) {
        self.asked = true;
    }

    /// Takes note of a record that is known to be no duplicate, as those of a log.
    pub fn take_new(&mut self, record: &RdtRecord) {
        match self.place(record) {
            Place::Late(missed) => {
                self.lost -= u64::from(missed);
                self.reordered += 1;
            }
            Place::First | Place::Again => self.begin(record),
            Place::Ahead(missing) => self.advance(record, missing),
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

    fn place(&mut self, record: &RdtRecord) -> Place {
        let Some((rdt, ft)) = self.latest else { return Place::First };
        let ahead = record.rdt_sequence.wrapping_sub(rdt) as i32;
        if ahead > 0 {
            return Place::Ahead(ahead as u32 - 1);
        }
        if ahead.unsigned_abs() >= WINDOW {
            return Place::First;
        }
        // A late record of this stream is about as many samples back as its number says.
        let back = ft.wrapping_sub(record.ft_sequence);
        let furthest = u64::from(self.step) * 2 * (u64::from(ahead.unsigned_abs()) + 1);
        let earlier = (back as i32) > 0 && (self.step == 0 || u64::from(back) <= furthest);
        match *self.slot(record.rdt_sequence) {
            Fate::Came(known) if known == record.ft_sequence => Place::Again,
            Fate::Missing if earlier => Place::Late(true),
            Fate::Unknown if earlier => Place::Late(false),
            _ => Place::First,
        }
    }

    /// A stream counts from 1: what it sent before the first record that came is lost, if that is near.
    fn begin(&mut self, record: &RdtRecord) {
        let missing = record.rdt_sequence.wrapping_sub(1);
        let missing = if missing < WINDOW { missing } else { 0 };
        if let Some((_, ft)) = self.latest {
            self.restarts += 1;
            match record.ft_sequence.wrapping_sub(ft) as i32 {
                ahead if ahead > 0 => {
                    let between = ahead as u32 / self.step.max(1);
                    self.unsent += u64::from(between.saturating_sub(1 + missing));
                }
                _ => self.reboots += 1,
            }
        }
        self.recent.clear();
        self.recent.resize(WINDOW as usize, Fate::Unknown);
        self.miss(record.rdt_sequence, missing);
        self.latest = Some((record.rdt_sequence, record.ft_sequence));
    }

    fn advance(&mut self, record: &RdtRecord, missing: u32) {
        if missing > 0 {
            self.miss(record.rdt_sequence, missing);
        } else if let Some((_, ft)) = self.latest {
            self.step = record.ft_sequence.wrapping_sub(ft).clamp(1, 7000);
        }
        self.latest = Some((record.rdt_sequence, record.ft_sequence));
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

    /// Takes records numbered in the stream and inside the box.
    fn take(account: &mut Account, numbers: impl IntoIterator<Item = (u32, u32)>) {
        for (rdt_sequence, ft_sequence) in numbers {
            account.take(&RdtRecord { rdt_sequence, ft_sequence, ..Default::default() });
        }
    }

    /// The numbers `list` of a stream that began at the box's sample `ft`.
    fn stream<'a>(ft: u32, list: &'a [u32]) -> impl Iterator<Item = (u32, u32)> + 'a {
        list.iter().map(move |n| (*n, ft.wrapping_add(*n)))
    }

    #[test]
    fn every_record_is_accounted_for() {
        let mut a = Account::default();
        take(&mut a, stream(50, &[1, 2, 5, 4, 4, 6, 3]));
        assert_eq!((a.received, a.lost, a.gaps, a.duplicates, a.reordered), (6, 0, 1, 1, 2));
        take(&mut a, stream(50, &[20]));
        assert_eq!((a.lost, a.longest_gap, a.restarts), (13, 13, 0));
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
        take(&mut a, stream(4000, &[5, 6, 7]));
        assert_eq!((a.received, a.lost, a.restarts, a.duplicates, a.reordered), (8, 1 + 4, 1, 0, 0));
        // 1007 to 4000.
        assert_eq!((a.unsent, a.reboots), (2994, 0));
        take(&mut a, stream(0, &[1, 2, 3]));
        assert_eq!((a.received, a.restarts, a.reboots), (11, 2, 1));
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
            replayed.take_new(&RdtRecord { rdt_sequence, ft_sequence, ..Default::default() });
        }
        assert_eq!((replayed.received, replayed.restarts, replayed.reboots), (7, 1, 1));
    }

    #[test]
    fn every_other_sample_of_a_slower_stream_is_none_missing() {
        let mut a = Account::default();
        take(&mut a, (1..=100).map(|n| (n, 14 * n)));
        take(&mut a, (1..=100).map(|n| (n, 14 * (n + 150))));
        assert_eq!((a.received, a.lost, a.unsent), (200, 0, 50));
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

    #[test]
    fn a_jump_takes_no_longer_than_the_window() {
        let mut a = Account::default();
        take(&mut a, (0..100).map(|n: u32| (n * 20_000_000, n)));
        assert_eq!((a.received, a.lost), (100, 99 * 19_999_999));
    }
}

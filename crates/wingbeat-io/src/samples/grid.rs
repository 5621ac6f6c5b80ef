//! Samples at equal steps of time: gaps stay open, whatever the order in which the rows came.

/// Where the rows of a file lie on a grid of equal steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampleGrid {
    /// Steps from the first sample, one per row kept.
    pub place: Vec<u32>,
    /// The rows kept, in the order of time.
    pub rows: Vec<u32>,
    /// Time of the first sample, s.
    pub start: f64,
    /// Samples per second.
    pub rate: f64,
    /// Rows that came again and are left out.
    pub duplicates: usize,
    /// Rows that stood behind later ones.
    pub late: usize,
}

/// Steps that a gap may have at most: a recording with longer ones is several.
const LONGEST_GAP: u32 = 1 << 22;
/// Samples by which a number may go back before it is one of a count that began anew: nine seconds of the box.
const FURTHEST_BACK: i32 = 1 << 16;

impl SampleGrid {
    /// Number of steps of the grid.
    pub fn len(&self) -> usize {
        self.place.last().map_or(0, |last| *last as usize + 1)
    }

    /// True when each of `rows` rows lies at its own number.
    pub fn is_whole(&self, rows: usize) -> bool {
        self.len() == rows && self.rows.len() == rows && self.late == 0
    }

    /// Rows that follow one another without a gap, `rate` in Hz.
    pub fn counted(rows: usize, rate: f64) -> Self {
        let all: Vec<u32> = (0..rows as u32).collect();
        Self { place: all.clone(), rows: all, rate, ..Self::default() }
    }

    /// By numbers that count the samples and wrap at 2^32, `rate` in Hz.
    pub fn numbered(sequence: &[f64], rate: f64) -> Result<Self, String> {
        let first = *sequence.first().ok_or("no samples")?;
        let mut ahead = 0_i64;
        let mut last = first as u32;
        let mut steps = Vec::with_capacity(sequence.len());
        for (row, number) in sequence.iter().enumerate() {
            if !(*number >= 0.0 && *number <= f64::from(u32::MAX)) {
                return Err(format!("sample {row}: {number} is no sequence number"));
            }
            let number = *number as u32;
            let step = number.wrapping_sub(last) as i32;
            if step < -FURTHEST_BACK || (number <= 1 && step <= -8) {
                return Err(format!(
                    "the numbers of the samples begin anew at sample {row}, {number} after {last}: cut the file \
                     there, or leave process.input.rate_hz out where it has a column of time"
                ));
            }
            ahead += i64::from(step);
            last = number;
            steps.push(ahead);
        }
        Self::placed(steps, 0.0, rate)
    }

    /// By times (of `unit` seconds each) that need not be exact. `unordered` rows are put in order; others may not go
    /// back.
    pub fn timed(time: &[f64], unit: f64, unordered: bool) -> Result<Self, String> {
        if let Some(row) = time.iter().position(|t| !t.is_finite()) {
            return Err(format!("sample {row} has no time"));
        }
        let back = (1..time.len()).find(|row| time[*row] < time[row - 1]);
        let (sorted, order) = match back {
            None => (time.to_vec(), None),
            Some(_) if unordered => {
                let mut order: Vec<u32> = (0..time.len() as u32).collect();
                wingbeat::math::order::ascend_by(&mut order, |item| time[*item as usize]);
                (order.iter().map(|row| time[*row as usize]).collect(), Some(order))
            }
            Some(row) => {
                let (now, before) = (unit * time[row], unit * time[row - 1]);
                return Err(format!(
                    "time goes back at sample {row}, from {before} s to {now} s: cut the file there"
                ));
            }
        };
        let step = step(&sorted)?;
        let gaps: Vec<f64> = sorted.windows(2).map(|pair| (pair[1] - pair[0]) / step).collect();
        let mut ahead = 0_i64;
        let mut steps = vec![0; time.len()];
        for (k, moved) in moves(&gaps).into_iter().enumerate() {
            ahead = ahead.saturating_add(moved);
            steps[order.as_ref().map_or(k + 1, |order| order[k + 1] as usize)] = ahead;
        }
        let span = unit * (sorted.last().unwrap_or(&0.0) - sorted[0]);
        if !(span > 0.0 && span.is_finite()) {
            return Err(format!("the times span {span} s"));
        }
        Self::placed(steps, unit * sorted[0], ahead as f64 / span)
    }

    fn placed(steps: Vec<i64>, start: f64, rate: f64) -> Result<Self, String> {
        if u32::try_from(steps.len()).is_err() {
            return Err(format!("{} samples", steps.len()));
        }
        let mut rows: Vec<u32> = (0..steps.len() as u32).collect();
        let late = (1..steps.len()).filter(|row| steps[*row] < steps[row - 1]).count();
        if late > 0 {
            rows.sort_by_key(|row| steps[*row as usize]);
        }
        let before = rows.len();
        rows.dedup_by_key(|row| steps[*row as usize]);
        let duplicates = before - rows.len();
        let first = rows.first().map_or(0, |row| steps[*row as usize]);
        let most = 16 * rows.len() as i64 + (1 << 16);
        let mut place: Vec<u32> = Vec::with_capacity(rows.len());
        for (k, row) in rows.iter().enumerate() {
            let ahead = steps[*row as usize].saturating_sub(first);
            let gap = ahead - i64::from(place.last().copied().unwrap_or(0));
            if gap > i64::from(LONGEST_GAP) {
                return Err(format!("{gap} samples are missing after sample {k}: cut the file there"));
            }
            if ahead > most {
                return Err("more than 15 of 16 samples are missing".into());
            }
            place.push(u32::try_from(ahead).map_err(|_| format!("{ahead} samples"))?);
        }
        Ok(Self { place, rows, start: start + first as f64 / rate, rate, duplicates, late })
    }
}

/// Part of how far a time stands from its place that the next places forget: clocks wander. *Choice.*
const FORGOTTEN: f64 = 1.0 / 64.0;
/// Times behind a gap that must confirm it: of times that come late together the last ones follow closely. *Choice.*
const CONFIRMED_BY: usize = 64;

/// Places by which each of the times goes on, from `gaps` in common steps. Not each gap is rounded by itself, as the jitter of two times would
/// add up to samples that nobody took, but what the times have gone in all; a gap is one if no later time takes it back.
fn moves(gaps: &[f64]) -> Vec<i64> {
    let mut off = 0.0;
    let of = |(k, gap): (usize, &f64)| {
        // A duplicate has the same time; jitter may bring others near.
        if *gap < 1e-6 {
            return 0;
        }
        let reached = off + gap;
        let moved = confirmed(gaps, k, reached);
        let left = reached - moved;
        // Times that come late together are far off until the last of them.
        off = if left > 1.0 { left } else { left * (1.0 - FORGOTTEN) };
        moved as i64
    };
    gaps.iter().enumerate().map(of).collect()
}

/// Places by which the gap `k` of `gaps`, in common steps, goes on, where it reaches so far: no more than the times behind it leave.
fn confirmed(gaps: &[f64], k: usize, reached: f64) -> f64 {
    let mut moved = reached.round().max(1.0);
    let (mut later, mut places) = (reached, 0.0);
    for gap in gaps[k + 1..].iter().filter(|gap| **gap >= 1e-6).take(CONFIRMED_BY) {
        if moved <= 1.0 {
            break;
        }
        later += gap;
        places += 1.0;
        moved = moved.min((later - places).round().max(1.0));
    }
    moved
}

/// Steps from which one is a gap, if the times behind it confirm that: over the median, which coarse times round down, and then over the step
/// that this gives. *Choice.*
const GAPS: [f64; 2] = [2.5, 1.5];

/// The common step of ascending times, s: the mean of those that are no gaps. Times that come late together count as they come.
fn step(time: &[f64]) -> Result<f64, String> {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < 2 {
        return Err(format!("{} samples", time.len()));
    }
    let still = steps.iter().filter(|step| **step <= 0.0).count();
    if 4 * still > steps.len() {
        return Err(format!("{still} of {} samples repeat the time of the one before", time.len()));
    }
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let of = |step: f64, gap: f64| {
        let gaps: Vec<f64> = time.windows(2).map(|pair| (pair[1] - pair[0]) / step).collect();
        let counts = |(k, own): &(usize, &f64)| **own < gap || confirmed(&gaps, *k, **own) <= 1.0;
        let (sum, count) =
            gaps.iter().enumerate().filter(counts).fold((0.0, 0.0), |(sum, count), (_, own)| {
                (sum + own, count + f64::from(u8::from(*own > 0.0)))
            });
        step * sum / count
    };
    Ok(GAPS.into_iter().fold(median, of))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_repeats_and_late_rows_are_found() {
        let grid = SampleGrid::numbered(&[4294967294.0, 4294967295.0, 1.0, 0.0, 1.0, 5.0], 7000.0).unwrap();
        assert_eq!((grid.place.clone(), grid.rows.clone()), (vec![0, 1, 2, 3, 7], vec![0, 1, 3, 2, 5]));
        assert!(!grid.is_whole(6) && SampleGrid::counted(6, 1.0).is_whole(6));
        assert_eq!((grid.duplicates, grid.late, grid.len()), (1, 1, 8));
        assert!(SampleGrid::numbered(&[1.0, 2e9], 7000.0).unwrap_err().contains("missing after sample 1"));
        assert!(SampleGrid::numbered(&[-1.0], 7000.0).is_err());
        let again: Vec<f64> = (1..=9).chain(1..=9).map(f64::from).collect();
        assert!(
            SampleGrid::numbered(&again, 7000.0).unwrap_err().contains("begin anew at sample 9, 1 after 9")
        );
    }

    #[test]
    fn coarsely_rounded_times_keep_their_rate() {
        // 7 kHz printed with four digits: steps of 0.1 and 0.2 ms.
        let time: Vec<f64> = (0..70_000).map(|k| (f64::from(k) / 0.7).round() * 1e-4).collect();
        let grid = SampleGrid::timed(&time, 1.0, false).unwrap();
        assert_eq!((grid.len(), grid.duplicates), (70_000, 0));
        assert!((grid.rate - 7000.0).abs() < 0.1, "{}", grid.rate);
    }

    #[test]
    fn a_gap_in_time_stays_open() {
        let time: Vec<f64> =
            (0..1000).filter(|k| !(300..340).contains(k)).map(|k| f64::from(k) * 1e-3).collect();
        let grid = SampleGrid::timed(&time, 1.0, false).unwrap();
        assert_eq!((grid.len(), grid.place[300]), (1000, 340));
        assert!((grid.rate - 1000.0).abs() < 1e-6);
    }

    #[test]
    fn jitter_and_late_samples_lose_none() {
        let mut seed = 5_u64;
        let mut even = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let jitter: Vec<f64> = (0..12_000).map(|k| 1e-3 * (f64::from(k) + 0.6 * (even() - 0.5))).collect();
        let late: Vec<f64> = (0..12_000)
            .map(|k| 1e-3 * (f64::from(k) + if even() < 0.02 { 0.5 + 0.4 * even() } else { 0.0 }))
            .collect();
        for (times, most) in [(&jitter, 1), (&late, 1)] {
            let grid = SampleGrid::timed(times, 1.0, false).unwrap();
            let missing = grid.len() - grid.place.len();
            assert!(missing <= most && (grid.rate - 1000.0).abs() < 0.1, "{missing} {}", grid.rate);
            // Of the same with three samples left out those are missing, where they were.
            let gone = |k: &usize| !(7000..7003).contains(k);
            let some: Vec<f64> = (0..times.len()).filter(gone).map(|k| times[k]).collect();
            let grid = SampleGrid::timed(&some, 1.0, false).unwrap();
            assert_eq!(grid.len() - grid.place.len(), 3 + missing);
            assert!(grid.place[7000] - grid.place[6999] >= 3, "{}", grid.place[7000] - grid.place[6999]);
        }
        // A clock that runs faster by 1e-4 and one that wanders lose none either.
        let wander = |k: u32| 1e-3 * (f64::from(k) + 3.0 * (f64::from(k) * 5e-4).sin());
        let grid = SampleGrid::timed(&(0..12_000).map(wander).collect::<Vec<_>>(), 1.0, false).unwrap();
        assert_eq!(grid.len(), 12_000);
    }

    #[test]
    fn single_samples_that_are_missing_are_no_longer_step() {
        let lost = |k: &u32| k % 200 != 17 + k / 200 * 37 % 100;
        let times: Vec<f64> = (0..12_000).filter(lost).map(|k| 1e-3 * f64::from(k)).collect();
        let grid = SampleGrid::timed(&times, 1.0, false).unwrap();
        assert_eq!((grid.len(), times.len()), (12_000, 11_940));
    }

    #[test]
    fn times_that_come_late_together_invent_no_samples() {
        for many in [2, 8, 16, 40] {
            let late = |k: u32| match k % 700 {
                place if place < many && k >= 700 => {
                    f64::from(k - place + many) - 0.02 * f64::from(many - place)
                }
                _ => f64::from(k),
            };
            let times: Vec<f64> = (0..12_000).map(|k| 1e-3 * late(k)).collect();
            let grid = SampleGrid::timed(&times, 1.0, false).unwrap();
            assert_eq!(grid.len(), 12_000, "{many}");
            // What is missing beside them still is.
            let gone: Vec<f64> =
                times.iter().copied().enumerate().filter(|(k, _)| k % 1500 != 1200).map(|(_, t)| t).collect();
            let grid = SampleGrid::timed(&gone, 1.0, false).unwrap();
            assert_eq!((grid.len(), gone.len()), (12_000, 11_992), "{many}");
        }
    }

    #[test]
    fn what_is_no_time_is_refused() {
        assert!(
            SampleGrid::timed(&[0.0, 0.1, 0.05, 0.2], 1.0, false).unwrap_err().contains("back at sample 2")
        );
        assert!(
            SampleGrid::timed(&[0.0, f64::NAN], 1.0, false).unwrap_err().contains("sample 1 has no time")
        );
        assert!(SampleGrid::timed(&[1.0; 50], 1.0, false).unwrap_err().contains("repeat"));
        assert!(SampleGrid::timed(&[], 1.0, false).is_err());
    }
}

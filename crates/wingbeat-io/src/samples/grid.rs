//! Samples at equal steps of time: gaps stay open, whatever the order in which the rows came.

/// Where the rows of a file lie on a grid of equal steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Steps from the first sample, one per row kept.
    pub place: Vec<usize>,
    /// The rows kept, in the order of time.
    pub rows: Vec<usize>,
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
const LONGEST_GAP: usize = 1 << 22;

impl Grid {
    /// Number of steps of the grid.
    pub fn len(&self) -> usize {
        self.place.last().map_or(0, |last| last + 1)
    }

    /// Rows that follow one another without a gap.
    pub fn counted(rows: usize, rate: f64) -> Self {
        Self { place: (0..rows).collect(), rows: (0..rows).collect(), rate, ..Self::default() }
    }

    /// By numbers that count the samples and wrap at 2^32.
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
            ahead += i64::from(number.wrapping_sub(last) as i32);
            last = number;
            steps.push(ahead);
        }
        Self::placed(&steps, 0.0, rate)
    }

    /// By times (s) that need not be exact. `unordered` rows are put in order; others may not go back.
    pub fn timed(time: &[f64], unordered: bool) -> Result<Self, String> {
        if let Some(row) = time.iter().position(|t| !t.is_finite()) {
            return Err(format!("sample {row} has no time"));
        }
        let mut order: Vec<usize> = (0..time.len()).collect();
        if unordered {
            order.sort_by(|a, b| time[*a].total_cmp(&time[*b]));
        } else if let Some(row) = (1..time.len()).find(|row| time[*row] < time[row - 1]) {
            let (now, before) = (time[row], time[row - 1]);
            return Err(format!(
                "time goes back at sample {row}, from {before} s to {now} s: cut the file there"
            ));
        }
        let sorted: Vec<f64> = order.iter().map(|row| time[*row]).collect();
        let step = step(&sorted)?;
        let mut ahead = 0_i64;
        let mut steps = vec![0; time.len()];
        for (k, pair) in sorted.windows(2).enumerate() {
            let gap = (pair[1] - pair[0]) / step;
            // A duplicate has the same time; jitter may bring others near.
            let moved = if gap < 1e-6 { 0 } else { gap.round().max(1.0) as i64 };
            ahead += moved;
            steps[order[k + 1]] = ahead;
        }
        let span = sorted.last().unwrap_or(&0.0) - sorted[0];
        Self::placed(&steps, sorted[0], ahead as f64 / span)
    }

    fn placed(steps: &[i64], start: f64, rate: f64) -> Result<Self, String> {
        let mut rows: Vec<usize> = (0..steps.len()).collect();
        rows.sort_by_key(|row| steps[*row]);
        let late = (1..steps.len()).filter(|row| steps[*row] < steps[row - 1]).count();
        let before = rows.len();
        rows.dedup_by_key(|row| steps[*row]);
        let duplicates = before - rows.len();
        let first = rows.first().map_or(0, |row| steps[*row]);
        let place: Vec<usize> = rows.iter().map(|row| (steps[*row] - first) as usize).collect();
        if let Some(k) = (1..place.len()).find(|k| place[*k] - place[k - 1] > LONGEST_GAP) {
            let gap = place[k] - place[k - 1];
            return Err(format!("{gap} samples are missing after sample {k}: cut the file there"));
        }
        let most = 16 * place.len() + (1 << 16);
        if place.last().is_some_and(|last| *last > most) {
            return Err("more than 15 of 16 samples are missing".into());
        }
        Ok(Self { place, rows, start: start + first as f64 / rate, rate, duplicates, late })
    }
}

/// The common step of ascending times, s: the mean of those that are no gaps.
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
    let (sum, count) = steps
        .iter()
        .filter(|step| **step < 2.5 * median)
        .fold((0.0, 0.0), |(sum, count), step| (sum + step, count + f64::from(u8::from(*step > 0.0))));
    Ok(sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_repeats_and_late_rows_are_found() {
        let grid = Grid::numbered(&[4294967294.0, 4294967295.0, 1.0, 0.0, 1.0, 5.0], 7000.0).unwrap();
        assert_eq!((grid.place.clone(), grid.rows.clone()), (vec![0, 1, 2, 3, 7], vec![0, 1, 3, 2, 5]));
        assert_eq!((grid.duplicates, grid.late, grid.len()), (1, 1, 8));
        assert!(Grid::numbered(&[1.0, 2e9], 7000.0).unwrap_err().contains("missing after sample 1"));
        assert!(Grid::numbered(&[-1.0], 7000.0).is_err());
    }

    #[test]
    fn coarsely_rounded_times_keep_their_rate() {
        // 7 kHz printed with four digits: steps of 0.1 and 0.2 ms.
        let time: Vec<f64> = (0..70_000).map(|k| (f64::from(k) / 0.7).round() * 1e-4).collect();
        let grid = Grid::timed(&time, false).unwrap();
        assert_eq!((grid.len(), grid.duplicates), (70_000, 0));
        assert!((grid.rate - 7000.0).abs() < 0.1, "{}", grid.rate);
    }

    #[test]
    fn a_gap_in_time_stays_open() {
        let time: Vec<f64> =
            (0..1000).filter(|k| !(300..340).contains(k)).map(|k| f64::from(k) * 1e-3).collect();
        let grid = Grid::timed(&time, false).unwrap();
        assert_eq!((grid.len(), grid.place[300]), (1000, 340));
        assert!((grid.rate - 1000.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_time_is_refused() {
        assert!(Grid::timed(&[0.0, 0.1, 0.05, 0.2], false).unwrap_err().contains("back at sample 2"));
        assert!(Grid::timed(&[0.0, f64::NAN], false).unwrap_err().contains("sample 1 has no time"));
        assert!(Grid::timed(&[1.0; 50], false).unwrap_err().contains("repeat"));
        assert!(Grid::timed(&[], false).is_err());
    }
}

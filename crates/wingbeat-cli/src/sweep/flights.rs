//! Flights of a sweep: what they say together.

use serde::Serialize;
use wingbeat::scenario::Hold;
use wingbeat::simulate::Record;
use wingbeat_figures::Figure;

/// The errors of the flights and what counts as held.
pub fn drawn(record: &Record, hold: Hold) -> Result<Figure, wingbeat_figures::Error> {
    wingbeat_figures::robustness(record, (hold.roll_within_deg, hold.pitch_within_deg))
}

/// `summary.json` of a sweep of flights.
#[derive(Debug, Serialize)]
pub struct Outcome {
    status: &'static str,
    flights: usize,
    held: usize,
    share_held: f64,
    /// Share held with 95 % confidence: Wilson 1927.
    share_held_low: f64,
    share_held_high: f64,
    roll_max_error_deg: [f64; 3],
    pitch_max_error_deg: [f64; 3],
    roll_within_deg: f64,
    pitch_within_deg: f64,
}

impl Outcome {
    pub fn new(record: &Record, hold: Hold) -> Self {
        let values = |name: &str| record.values(name).unwrap_or_default();
        let held = values("held").iter().filter(|held| **held == 1.0).count();
        let flights = record.rows();
        let (low, high) = wilson(held, flights);
        Self {
            status: "ok",
            flights,
            held,
            share_held: held as f64 / flights as f64,
            share_held_low: low,
            share_held_high: high,
            roll_max_error_deg: quantiles(values("roll_max_error")),
            pitch_max_error_deg: quantiles(values("pitch_max_error")),
            roll_within_deg: hold.roll_within_deg,
            pitch_within_deg: hold.pitch_within_deg,
        }
    }

    pub fn table(&self) -> String {
        let percent = |share: f64| 100.0 * share;
        let mut text = format!(
            "held {} of {} flights: {:.1} % (95 % confidence {:.1} to {:.1} %)\n\n{:<24}{:>9}{:>9}{:>9}{:>9}\n",
            self.held,
            self.flights,
            percent(self.share_held),
            percent(self.share_held_low),
            percent(self.share_held_high),
            "",
            "median",
            "90 %",
            "worst",
            "limit",
        );
        for (name, [median, most, worst], limit) in [
            ("roll, largest error", self.roll_max_error_deg, self.roll_within_deg),
            ("pitch, largest error", self.pitch_max_error_deg, self.pitch_within_deg),
        ] {
            text += &format!("{name:<24}{median:>9.2}{most:>9.2}{worst:>9.2}{limit:>9.2} deg\n");
        }
        text
    }
}

/// Median, 90th percentile and largest.
fn quantiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get(((sorted.len() as f64 * share).ceil() as usize).max(1) - 1);
    [0.5, 0.9, 1.0].map(|share| at(share).copied().unwrap_or(f64::NAN))
}

/// Interval of a share with 95 % confidence.
fn wilson(held: usize, flights: usize) -> (f64, f64) {
    const Z: f64 = 1.959964;
    let (n, p) = (flights as f64, held as f64 / flights as f64);
    let centre = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    ((centre - half) / scale, (centre + half) / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_share_is_wilsons() {
        let (low, high) = wilson(8, 10);
        assert!((low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4, "{low} {high}");
        assert!((wilson(10, 10).1 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn quantiles_are_values_of_the_list() {
        let values: Vec<f64> = (1..=10).map(f64::from).collect();
        assert_eq!(quantiles(&values), [5.0, 9.0, 10.0]);
    }
}

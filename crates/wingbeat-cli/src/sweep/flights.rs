//! Flights of a sweep: what they say together.

use serde::Serialize;
use wingbeat::scenario::Hold;
use wingbeat::simulate::Record;
use wingbeat_figures::Figure;

use crate::sweep::end_points::{self, Group};

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
    /// Flights in which no clearance fell below `clearance_m`.
    clear: usize,
    clearance_m: f64,
    /// Median, 10th percentile and least of the least clearances, m.
    least_clearance_m: [f64; 3],
    /// Under `[controller.orbit]`.
    height_max_error_m: [f64; 3],
    height_within_m: Option<f64>,
    /// Along a path.
    cross_rms_m: [f64; 3],
    cross_rms_within_m: Option<f64>,
    /// Where they end, by what words were drawn for them.
    end_points: Vec<Group>,
}

impl Outcome {
    pub fn new(record: &Record, hold: Hold, end_points: Vec<Group>) -> Self {
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
            clear: values("clear").iter().filter(|clear| **clear == 1.0).count(),
            clearance_m: hold.clearance_m,
            least_clearance_m: quantiles(&values("least_clearance").iter().map(|c| -c).collect::<Vec<_>>())
                .map(|c| -c),
            height_max_error_m: quantiles(values("height_max_error")),
            height_within_m: hold.height_within_m,
            cross_rms_m: quantiles(values("cross_rms")),
            cross_rms_within_m: hold.cross_rms_within_m,
            end_points,
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
        for (name, [median, most, worst], within) in [
            ("height, largest error", self.height_max_error_m, self.height_within_m),
            ("across the path, rms", self.cross_rms_m, self.cross_rms_within_m),
        ] {
            if let Some(within) = within {
                text += &format!("{name:<24}{median:>9.4}{most:>9.4}{worst:>9.4}{within:>9.4} m\n");
            }
        }
        let [median, most, worst] = self.least_clearance_m;
        if median.is_finite() {
            let (name, limit) = ("least clearance", self.clearance_m);
            text += &format!("{name:<24}{median:>9.4}{most:>9.4}{worst:>9.4}{limit:>9.4} m\n");
            text += &format!("clear {} of {} flights\n", self.clear, self.flights);
        }
        text + "\n" + &end_points::text(&self.end_points)
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

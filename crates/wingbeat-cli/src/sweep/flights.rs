//! Flights of a sweep: what they say together.

use std::collections::BTreeMap;

use serde::Serialize;
use wingbeat::scenario::{Hold, Sampling, Sweep, SweepCounts};
use wingbeat::simulate::Record;
use wingbeat_figures::Figure;

use crate::sweep::cases::labelled;
use crate::sweep::end_points::{self, EndPointGroup};

/// The errors of the flights and what counts as held.
pub fn drawn(record: &Record, hold: Hold) -> Result<Figure, wingbeat_figures::Error> {
    let others = [
        hold.height_within_m.map(|most| ("height_max_error", most, "height")),
        hold.cross_rms_within_m.map(|most| ("cross_rms", most, "distance across the path")),
    ];
    let others: Vec<_> = others.into_iter().flatten().collect();
    wingbeat_figures::robustness(record, (hold.roll_within_deg, hold.pitch_within_deg), &others)
}

/// Measures that are drawn over what a sweep varies, the first four that it has.
const MAPPED: [&str; 6] =
    ["altitude_change", "positive_power", "distance_x", "roll_mean", "distance_y", "least_clearance"];

/// Range of a measure, as a share of its size and in its unit, below which flights have it alike. *Choice.*
const ALIKE: f64 = 1e-6;

/// Measures over one key, or over the two of a grid; none of draws at random from more, whose other keys a map would hide.
pub fn mapped(record: &Record, sweep: &Sweep) -> Option<Result<Figure, wingbeat_figures::Error>> {
    let keys = labelled(sweep);
    let whole = sweep.spec.sampling == Sampling::Grid;
    if keys.len() != 1 && !(whole && keys.len() == 2) {
        return None;
    }
    // What no flight has, or all have alike, is no picture.
    let there = |name: &&str| {
        let values = || record.values(name).unwrap_or_default().iter().copied().filter(|v| v.is_finite());
        let (low, high) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        high - low > ALIKE * low.abs().max(high.abs()).max(1.0)
    };
    let measures: Vec<&str> = MAPPED.into_iter().filter(there).take(4).collect();
    (!measures.is_empty())
        .then(|| wingbeat_figures::map(record, &keys, &measures, (whole, &SweepCounts::usable_rows(record))))
}

/// `summary.json` of a sweep of flights.
#[derive(Debug, Serialize)]
pub struct FlightSweepSummary {
    flights: usize,
    held: usize,
    /// Flights of which one record or none is left to judge.
    held_not_judged: usize,
    /// None where one is not judged.
    share_held: Option<f64>,
    /// Share held with 95 % confidence: Wilson 1927. None of a grid and of flights that are all alike, which are no sample.
    share_held_low: Option<f64>,
    share_held_high: Option<f64>,
    /// Median, 90th percentile and largest, as all of three, over the completed flights that have the number: `counted` says how
    /// many.
    roll_max_error_deg: Quantiles,
    pitch_max_error_deg: Quantiles,
    roll_within_deg: f64,
    pitch_within_deg: f64,
    /// Completed flights in which no clearance fell below `clearance_m`.
    clear: usize,
    /// Flights to a perch whose claw latched, held or not; none without a perch.
    #[serde(skip_serializing_if = "Option::is_none")]
    caught: Option<usize>,
    clearance_m: f64,
    /// Median, 10th percentile and least of the least clearances, m.
    least_clearance_m: Quantiles,
    /// Positive power of all joints on one drive, over the mass, W/kg.
    positive_power_w_kg: Quantiles,
    /// Its mean over the completed flights, W/kg.
    positive_power_mean_w_kg: Option<f64>,
    /// Under `[controller.orbit]`.
    height_max_error_m: Quantiles,
    height_within_m: Option<f64>,
    /// Along a path.
    cross_rms_m: Quantiles,
    cross_rms_within_m: Option<f64>,
    /// Flights behind each of these, by the name of the column.
    counted: BTreeMap<&'static str, usize>,
    /// Where they end, by what words were drawn for them.
    end_points: Vec<EndPointGroup>,
}

impl FlightSweepSummary {
    pub fn new(record: &Record, hold: Hold, is_sample: bool, end_points: Vec<EndPointGroup>) -> Self {
        let values = |name: &str| record.values(name).unwrap_or_default();
        let count = |name: &str| values(name).iter().filter(|value| **value == 1.0).count();
        let of = |name: &str| {
            let rows = values(name).iter().zip(values("completed"));
            rows.filter(|(value, done)| **done == 1.0 && value.is_finite()).map(|(value, _)| *value).collect()
        };
        let (held, flights) = (count("held"), record.rows());
        let not_judged = values("held").iter().filter(|held| held.is_nan()).count();
        let interval = (is_sample && not_judged == 0).then(|| wilson(held, flights));
        let mut counted = BTreeMap::new();
        let mut quantiles = |name: &'static str| {
            let values: Vec<f64> = of(name);
            counted.insert(name, values.len());
            quantiles(values)
        };
        let (roll, pitch) = (quantiles("roll_max_error"), quantiles("pitch_max_error"));
        let (height, cross) = (quantiles("height_max_error"), quantiles("cross_rms"));
        let power = quantiles("positive_power");
        let clearances: Vec<f64> = of("least_clearance");
        counted.insert("least_clearance", clearances.len());
        Self {
            flights,
            held,
            held_not_judged: not_judged,
            share_held: (not_judged == 0).then(|| held as f64 / flights as f64),
            share_held_low: interval.map(|(low, _)| low),
            share_held_high: interval.map(|(_, high)| high),
            roll_max_error_deg: roll,
            pitch_max_error_deg: pitch,
            roll_within_deg: hold.roll_within_deg,
            pitch_within_deg: hold.pitch_within_deg,
            clear: count("clear"),
            caught: values("perch_caught")
                .iter()
                .any(|caught| caught.is_finite())
                .then(|| count("perch_caught")),
            clearance_m: hold.clearance_m,
            least_clearance_m: self::quantiles(clearances.iter().map(|c| -c).collect())
                .map(|c| c.map(|c| -c)),
            positive_power_w_kg: power,
            positive_power_mean_w_kg: mean(&of("positive_power")),
            height_max_error_m: height,
            height_within_m: hold.height_within_m,
            cross_rms_m: cross,
            cross_rms_within_m: hold.cross_rms_within_m,
            counted,
            end_points,
        }
    }

    pub fn table(&self) -> String {
        let percent = |share: f64| 100.0 * share;
        let interval = self.share_held_low.zip(self.share_held_high);
        let interval = interval.map_or(String::new(), |(low, high)| {
            format!(" (95 % confidence {:.1} to {:.1} %)", percent(low), percent(high))
        });
        let share = match self.share_held {
            Some(share) => format!("{:.1} %{interval}", percent(share)),
            None => format!("{} not judged", self.held_not_judged),
        };
        let mut text = format!(
            "held {} of {} flights: {share}\n\n{:<24}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
            self.held, self.flights, "", "flights", "median", "90 %", "worst", "limit",
        );
        let mut row = |name: &str, column: &str, of: Quantiles, limit: f64, unit: &str, digits: usize| {
            let cell = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.digits$}"));
            let [median, most, worst] = of.map(cell);
            let (counted, limit) = (self.counted.get(column).copied().unwrap_or(0), cell(Some(limit)));
            text += &format!("{name:<24}{counted:>9}{median:>9}{most:>9}{worst:>9}{limit:>9} {unit}\n");
        };
        row("roll, largest error", "roll_max_error", self.roll_max_error_deg, self.roll_within_deg, "deg", 2);
        row(
            "pitch, largest error",
            "pitch_max_error",
            self.pitch_max_error_deg,
            self.pitch_within_deg,
            "deg",
            2,
        );
        if let Some(within) = self.height_within_m {
            row("height off orbit, most", "height_max_error", self.height_max_error_m, within, "m", 4);
        }
        if let Some(within) = self.cross_rms_within_m {
            row("across the path, rms", "cross_rms", self.cross_rms_m, within, "m", 4);
        }
        let clearances = self.counted.get("least_clearance").copied().unwrap_or(0);
        if clearances > 0 {
            row("least clearance", "least_clearance", self.least_clearance_m, self.clearance_m, "m", 4);
            text += &format!("clear {} of the {clearances} flights completed\n", self.clear);
        }
        if let Some(caught) = self.caught {
            text += &format!("caught {caught} of the {} flights\n", self.flights);
        }
        if let ([Some(median), Some(most), Some(worst)], Some(mean)) =
            (self.positive_power_w_kg, self.positive_power_mean_w_kg)
        {
            text += &format!(
                "positive power {mean:.1} W/kg in the mean, median {median:.1}, 90 % {most:.1}, most {worst:.1}\n"
            );
        }
        text + "\n" + &end_points::text(&self.end_points)
    }
}

/// Three quantiles; none of no values.
type Quantiles = [Option<f64>; 3];

/// Median, 90th percentile and largest.
fn quantiles(mut sorted: Vec<f64>) -> Quantiles {
    wingbeat::math::order::ascend(&mut sorted);
    let at = |share: f64| sorted.get(((sorted.len() as f64 * share).ceil() as usize).max(1) - 1);
    [0.5, 0.9, 1.0].map(|share| at(share).copied())
}

/// The mean; none of no values.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
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
        assert_eq!(quantiles(values), [5.0, 9.0, 10.0].map(Some));
        assert_eq!(quantiles(Vec::new()), [None; 3]);
    }
}

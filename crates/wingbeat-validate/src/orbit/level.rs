//! What level flight takes with the shipped gaits, against what is asked of each.

use wingbeat::orbit::SKIN;

use super::trimmed;
use crate::shipped::Shipped;
use crate::{ComparisonRow, Error};

/// What is asked of a gait.
struct GaitDemand {
    of: Shipped,
    /// With the scenario's own strips: most power over the mass, W/kg.
    power: f64,
    /// Of a twist that is driven: highest frequency, Hz, and largest share of U^2 c dy beyond 20 deg.
    driven: Option<[f64; 2]>,
    /// Least room beyond the skin, m.
    room: f64,
    /// Numbers of strips at which it is asked to hold by itself and keep clear, the scenario's own first.
    strips: &'static [usize],
}

/// Room between the skins of wings whose twist is driven, m.
const DRIVEN_ROOM: f64 = 3e-3;

/// A gait whose twist is driven: most power, W/kg; highest frequency, Hz, and largest share beyond 20 deg.
pub(super) fn driven(of: Shipped, power: f64, limits: [f64; 2]) -> Result<Vec<ComparisonRow>, Error> {
    rows(&GaitDemand { of, power, driven: Some(limits), room: DRIVEN_ROOM, strips: &[9, 16, 24] })
}

/// A gait whose twist the air moves: most power, W/kg.
pub(super) fn passive(of: Shipped, power: f64) -> Result<Vec<ComparisonRow>, Error> {
    rows(&GaitDemand { of, power, driven: None, room: 0.0, strips: &[9, 16] })
}

fn rows(asked: &GaitDemand) -> Result<Vec<ComparisonRow>, Error> {
    let (name, source) = (asked.of, "what is asked of the flight");
    let (mut rows, mut shown) = (Vec::new(), Vec::new());
    for (i, strips) in asked.strips.iter().enumerate() {
        let flight = trimmed(asked.of, &[&format!("aero.full.strips={strips}")])?.summary;
        let mut row = |end: &str, metric: &str, value: Option<f64>, limit: f64, unit| {
            let (id, metric) = (format!("trim.{name}.{end}_{strips}"), format!("{metric}, {strips} strips"));
            rows.push(ComparisonRow::judged(&id, source, &metric, value.unwrap_or(f64::NAN), limit, unit));
        };
        if i == 0 {
            row("power", "power of the drive over the mass", flight.power_w_kg, asked.power, "W/kg");
        }
        match asked.driven {
            Some([frequency, stalled]) if i == 0 => {
                row("frequency", "frequency", flight.frequency_hz, frequency, "Hz");
                let metric = "share of U^2 c dy dt beyond 20 deg";
                row("stalled", metric, flight.stall_fraction_20, stalled, "");
                let off = flight.lift_over_weight.map(|lift| (lift - 1.0).abs());
                row("lift", "lift over weight less 1", off, 1e-3, "");
            }
            Some(_) => {}
            None => row("twist", "mean power put into the twist", flight.twist_power_w, 0.0, "W"),
        }
        if i == 0 && flight.lift_law == "lev" {
            let shares =
                [("separated", flight.separated_fraction), ("suction_lost", flight.suction_lost_fraction)];
            for (end, value) in shares {
                let (id, metric) = (
                    format!("trim.{name}.{end}"),
                    format!("share {}, {strips} strips", end.replace('_', " ")),
                );
                shown.push(ComparisonRow::shown(&id, source, &metric, value.unwrap_or(f64::NAN), ""));
            }
        }
        row("multiplier", "largest multiplier but the heading's", flight.largest_multiplier, 1.0, "");
        let room = SKIN + asked.room;
        let metric = format!("{:.0} mm less the least clearance", 1e3 * room);
        row("clearance", &metric, flight.least_clearance_m.map(|least| room - least), 0.0, "m");
    }
    rows.extend(shown);
    Ok(rows)
}

//! The numbers of a flight beside the paper's.

use std::borrow::Cow;

use wingbeat::judge::{Judged, limits};
use wingbeat::scenario::{CostLine, LawState, PaperResults, Summary};

/// A line: what, the paper's number, this run's, and its unit or a remark.
type Line = (Cow<'static, str>, Option<String>, String, &'static str);

/// The table *paper / this run*, with the cautions below; *this run* alone where nothing is published of the case.
pub fn table(summary: &Summary, paper: Option<&PaperResults>) -> String {
    let beside = |cell: &str| paper.map_or(String::new(), |_| format!("{cell:>9}  "));
    let mut text = format!("{:<24}{}{:>9}\n", "", beside("paper"), "this run");
    for (name, published, value, unit) in lines(summary, paper) {
        let published = beside(published.as_deref().unwrap_or("-"));
        text += format!("{name:<24}{published}{value:>9} {unit}").trim_end();
        text.push('\n');
    }
    text += &overridden(&summary.judged);
    for warning in &summary.warnings {
        text += &format!("\n{warning}\n");
    }
    text
}

/// The limits that the document gives in place of the usual ones, a line each.
pub fn overridden(judged: &[Judged]) -> String {
    let line = |judged: &Judged| {
        let usual = limits::all().find(|limit| limit.id == judged.id)?.value;
        let Judged { id, limit, unit, .. } = judged;
        Some(format!("\nlimit overridden: {id} = {limit} {unit}, usual is {usual} {unit}\n"))
    };
    judged.iter().filter(|judged| judged.overridden).filter_map(line).collect()
}

/// The mean of a state of a lift law; one without a unit is a share.
fn law_state(state: &LawState) -> Line {
    let (value, unit) = match state.unit {
        "" => (format!("{:.1}", 100.0 * state.mean), "%"),
        unit => (format!("{:.2}", state.mean), unit),
    };
    (format!("{}, mean", state.meaning).into(), None, value, unit)
}

fn lines(summary: &Summary, paper: Option<&PaperResults>) -> Vec<Line> {
    let number = |value: f64| if value.is_finite() { format!("{value:.2}") } else { "-".into() };
    let settled = |value: Option<f64>| value.map_or("-".into(), number);
    let watts = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.3}"));
    let shared = |value: Option<f64>| value.map_or("-".into(), |value| format!("{:.1}", 100.0 * value));
    let share = |value: f64| if value.is_finite() { format!("{:.1}", 100.0 * value) } else { "-".into() };
    let of = |take: fn(&PaperResults) -> f64| paper.map(take).map(number);
    let oscillation = paper.and_then(|p| p.pitch_oscillation_deg).map(|[from, to]| format!("{from} to {to}"));
    let side = if summary.distance_y_m < 0.0 { "m, to the right" } else { "m, to the left" };
    let controller = &summary.controller;
    let mut rows: Vec<Line> = vec![
        ("status".into(), None, summary.status.name().into(), ""),
        match summary.turn_roll_mean_deg {
            Some(roll) => ("roll in the turn, mean".into(), of(|p| p.roll_deg), number(roll), "deg"),
            None => ("roll, mean".into(), of(|p| p.roll_deg), settled(summary.roll_mean_deg), "deg"),
        },
        ("roll, rms error".into(), None, settled(summary.roll_rms_error_deg), "deg"),
        (
            "nose up, mean".into(),
            of(|p| p.nose_up_deg),
            settled(summary.pitch_mean_deg.map(|pitch| -pitch)),
            "deg",
        ),
        ("pitch, oscillation +-".into(), oscillation, settled(summary.pitch_half_amplitude_deg), "deg"),
        ("distance x".into(), of(|p| p.distance_x_m), number(summary.distance_x_m), "m"),
        ("distance y".into(), of(|p| p.distance_y_m), number(summary.distance_y_m.abs()), side),
        ("altitude change".into(), None, number(summary.altitude_change_m), "m"),
        ("yaw change".into(), None, number(summary.yaw_change_deg), "deg"),
        ("lift law".into(), None, summary.lift_law.clone(), ""),
        ("strips past stall".into(), None, shared(summary.stall_fraction), "%"),
        (
            "least clearance".into(),
            None,
            summary.least_clearance_m.map_or("-".into(), |c| number(1e3 * c)),
            "mm",
        ),
        (
            "clearance below zero".into(),
            None,
            summary.crossing_fraction.map_or("-".into(), share),
            "% of the time",
        ),
        ("inputs at a limit".into(), None, share(summary.input_saturation_fraction), "%"),
        ("controller updates".into(), None, controller.updates.to_string(), ""),
        ("controller failures".into(), None, controller.failures.to_string(), ""),
        ("updates past their period".into(), None, controller.late.to_string(), ""),
        ("update, median".into(), None, number(1e-3 * controller.median_us), "ms"),
        ("update, 99.9 %".into(), None, number(1e-3 * controller.p999_us), "ms"),
        ("real-time factor".into(), None, number(summary.real_time_factor), ""),
    ];
    let of_cost = |(name, value, unit): CostLine| -> Line { (name.into(), None, value, unit) };
    let cost = summary.cost.power_lines().into_iter().map(of_cost);
    let of_drives: [Line; 4] = [
        ("power of the drive".into(), None, watts(summary.drive_power_w), "W, on the joints"),
        ("power of the actuators".into(), None, watts(summary.regulator_power_w), "W, on the joints"),
        ("drive, without taking back".into(), None, watts(summary.drive_power_given_w), "W"),
        ("actuators, likewise".into(), None, watts(summary.regulator_power_given_w), "W"),
    ];
    let cost = cost.chain(of_drives).chain(summary.cost.weight_lines().into_iter().map(of_cost));
    let saturated = rows.iter().position(|row| row.0 == "inputs at a limit").unwrap_or(rows.len());
    rows.splice(saturated..saturated, cost.collect::<Vec<_>>());
    if let Some(error) = summary.height_max_error_m {
        let yaw = rows.iter().position(|row| row.0 == "yaw change").unwrap_or(rows.len());
        rows.insert(yaw, ("height, largest error".into(), None, number(1e3 * error), "mm"));
    }
    if controller.updates == 0 {
        let of_updates =
            ["controller failures", "updates past their period", "update, median", "update, 99.9 %"];
        rows.retain(|row| !of_updates.contains(&row.0.as_ref()));
    }
    if let Some(estimate) = &summary.estimate {
        let saturated = rows.iter().position(|row| row.0 == "inputs at a limit").unwrap_or(rows.len());
        let errors = [
            ("height, estimate's rms".into(), None, number(1e3 * estimate.height_rms_m), "mm"),
            ("roll, estimate's rms".into(), None, number(estimate.roll_rms_deg), "deg"),
            ("estimate within 3 sigma".into(), None, share(estimate.within_3_sigma), "% of the errors"),
        ];
        rows.splice(saturated..saturated, errors);
    }
    if let Some(lattice) = &summary.lattice {
        let law = rows.iter().position(|row| row.0 == "lift law").unwrap_or(rows.len());
        let of_lattice = [
            ("attached flow".into(), None, "assumed".into(), "by the vortex lattice, past stall too"),
            ("states tried a lattice step".into(), None, number(lattice.iterations_mean), ""),
            ("way in a lattice step".into(), None, number(lattice.way_panels), "chords of a panel"),
        ];
        rows.splice(law..law, of_lattice);
    }
    if let Some(hover) = &summary.hover {
        let saturated = rows.iter().position(|row| row.0 == "inputs at a limit").unwrap_or(rows.len());
        let errors = [
            ("from the place, rms".into(), None, number(1e3 * hover.place_rms_m), "mm"),
            ("attitude, rms".into(), None, number(hover.attitude_rms_deg), "deg"),
            ("attitude, largest".into(), None, number(hover.attitude_max_deg), "deg"),
            ("force of the air, error".into(), None, share(hover.air_force_error), "% of its mean"),
        ];
        rows.splice(saturated..saturated, errors);
    }
    if let Some(path) = &summary.path {
        let saturated = rows.iter().position(|row| row.0 == "inputs at a limit").unwrap_or(rows.len());
        let errors = [
            ("across the path, rms".into(), None, number(1e3 * path.cross_rms_m), "mm"),
            ("across, largest".into(), None, number(1e3 * path.cross_max_m), "mm"),
            ("along the path, rms".into(), None, number(1e3 * path.along_rms_m), "mm"),
        ];
        rows.splice(saturated..saturated, errors);
    }
    if !summary.law_states.is_empty() {
        let past = rows.iter().position(|row| row.0 == "strips past stall").map_or(rows.len(), |i| i + 1);
        let states = summary.law_states.iter().map(law_state);
        let lost = ("suction lost, mean".into(), None, shared(summary.suction_lost_fraction), "%");
        rows.splice(past..past, states.chain([lost]).collect::<Vec<_>>());
    }
    if let Some(beyond) = summary.beyond_residual_fraction {
        let past = rows.iter().position(|row| row.0 == "strips past stall").map_or(rows.len(), |i| i + 1);
        rows.insert(past, ("beyond robot.residual".into(), None, share(beyond), "% of the time"));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;
    use std::path::Path;
    use wingbeat::scenario::Scenario;

    fn flown(law: &str) -> Summary {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/glider.toml");
        let overrides = ["flight.duration_s=0.02".to_owned(), format!("aero.law={law}")];
        Scenario::load(&path, &overrides).unwrap().fly(|_| ControlFlow::Continue(())).unwrap().summary
    }

    #[test]
    fn the_states_of_a_law_are_told_whatever_the_law_is_called() {
        let summary = Summary { lift_law: "a law of one's own".into(), ..flown("lev") };
        let own = LawState { meaning: "bubble", unit: "m", mean: 0.25 };
        let shown = table(&Summary { law_states: vec![own], ..summary.clone() }, None);
        assert!(shown.contains("bubble, mean") && shown.contains("0.25 m"), "{shown}");
        let shown = table(&summary, None);
        let rows = ["vortex force, mean", "flow separated, mean", "suction lost, mean"];
        assert!(rows.iter().all(|row| shown.contains(row)), "{shown}");
        let separated = summary.law_states.iter().find(|state| state.meaning == "flow separated").unwrap();
        assert!(separated.mean > 0.0 && (separated.mean - summary.separated_fraction.unwrap()).abs() < 1e-9);
        let shown = table(&flown("stall"), None);
        assert!(rows.iter().all(|row| !shown.contains(row)), "{shown}");
    }
}

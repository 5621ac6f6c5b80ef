//! The numbers of a flight beside the paper's.

use std::borrow::Cow;

use wingbeat::judge::{Judged, Status, limits};
use wingbeat::scenario::{CostLine, LawState, PaperResults, Summary};

/// A line: what, the paper's number, this run's, and its unit or a remark.
type PaperLine = (Cow<'static, str>, Option<String>, String, &'static str);

/// The table *paper / this run*, with the cautions below; *this run* alone where nothing is published of the case.
pub fn table(summary: &Summary, paper: Option<&PaperResults>) -> String {
    let beside = |cell: &str| paper.map_or(String::new(), |_| format!("{cell:>9}  "));
    let mut text = format!("{:<24}{}{:>9}\n", "", beside("paper"), "this run");
    for (name, published, value, unit) in lines(summary, paper) {
        let published = beside(published.as_deref().unwrap_or("-"));
        text += format!("{name:<24}{published}{value:>9} {unit}").trim_end();
        text.push('\n');
    }
    // What was not judged is no error, and nothing else says it where no warning does.
    let said = |reason: &&String| summary.warnings.iter().any(|warning| warning.text == **reason);
    let open = summary.reason.as_ref().filter(|_| summary.status == Status::NotJudged);
    text += &open.filter(|reason| !said(reason)).map_or(String::new(), |reason| format!("\n{reason}\n"));
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
fn law_state(state: &LawState) -> PaperLine {
    let (value, unit) = match state.unit {
        "" => (format!("{:.1}", 100.0 * state.mean), "%"),
        unit => (format!("{:.2}", state.mean), unit),
    };
    (format!("{}, mean", state.meaning).into(), None, value, unit)
}

fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { "-".into() }
}

fn settled(value: Option<f64>) -> String {
    value.map_or("-".into(), number)
}

/// In per cent.
fn share(value: f64) -> String {
    if value.is_finite() { format!("{:.1}", 100.0 * value) } else { "-".into() }
}

/// A line of which the paper says nothing.
fn own(name: &'static str, value: String, unit: &'static str) -> PaperLine {
    (name.into(), None, value, unit)
}

fn lines(summary: &Summary, paper: Option<&PaperResults>) -> Vec<PaperLine> {
    let mut rows = course(summary, paper);
    rows.extend(air(summary));
    rows.extend(cost(summary));
    rows.extend(errors(summary));
    rows.extend(controller(summary));
    rows
}

/// Attitude and path.
fn course(summary: &Summary, paper: Option<&PaperResults>) -> Vec<PaperLine> {
    let of = |take: fn(&PaperResults) -> f64| paper.map(take).map(number);
    let oscillation = paper.and_then(|p| p.pitch_oscillation_deg).map(|[from, to]| format!("{from} to {to}"));
    let side = if summary.distance_y_m < 0.0 { "m, to the right" } else { "m, to the left" };
    let nose_up = settled(summary.pitch_mean_deg.map(|pitch| -pitch));
    // Half a loop has neither a mean roll nor an orbit.
    let height = summary.height_max_error_m.filter(|_| summary.perch.is_none());
    let height = height.map(|e| own("height off orbit, most", number(1e3 * e), "mm"));
    let roll = match summary.turn_roll_mean_deg {
        Some(roll) => Some(("roll in the turn, mean".into(), of(|p| p.roll_deg), number(roll), "deg")),
        None if summary.perch.is_some() => None,
        None => Some(("roll, mean".into(), of(|p| p.roll_deg), settled(summary.roll_mean_deg), "deg")),
    };
    let mut rows = vec![own("status", summary.status.name().into(), "")];
    rows.extend(roll);
    rows.extend([
        own("roll, rms error", settled(summary.roll_rms_error_deg), "deg"),
        ("nose up, mean".into(), of(|p| p.nose_up_deg), nose_up, "deg"),
        ("pitch, oscillation +-".into(), oscillation, settled(summary.pitch_half_amplitude_deg), "deg"),
        ("distance x".into(), of(|p| p.distance_x_m), number(summary.distance_x_m), "m"),
        ("distance y".into(), of(|p| p.distance_y_m), number(summary.distance_y_m.abs()), side),
        own("altitude change", number(summary.altitude_change_m), "m"),
    ]);
    rows.extend(height);
    if let Some(dive) = &summary.dive {
        let level = dive.level_after_s.map_or("-".into(), number);
        rows.extend([
            own("dive, height lost", number(dive.height_lost_m), "m"),
            own("nose down, largest", number(dive.nose_down_deg), "deg"),
            own("nose down, over a cycle", number(dive.nose_down_cycle_deg), "deg"),
            own("level again after", level, "s"),
        ]);
    }
    if let Some(perch) = &summary.perch {
        let became = if perch.caught { "caught" } else { "missed" };
        rows.extend([
            own("perch", became.into(), ""),
            own("claw from perch", number(1e3 * perch.distance_m), "mm"),
            own("speed of the claw", number(perch.speed_m_s), "m/s"),
            own("off hanging upside down", number(perch.attitude_error_deg), "deg"),
        ]);
        rows.extend(perch.least_clearance_m.map(|c| own("clear of the perch", number(1e3 * c), "mm")));
    }
    rows.push(own("yaw change", settled(summary.yaw_change_deg), "deg"));
    rows
}

/// Flow and clearance.
fn air(summary: &Summary) -> Vec<PaperLine> {
    let shared = |value: Option<f64>| value.map_or("-".into(), share);
    let mut rows = Vec::new();
    if let Some(lattice) = &summary.lattice {
        rows.extend([
            own("attached flow", "assumed".into(), "by the vortex lattice, past stall too"),
            own("states tried a lattice step", number(lattice.iterations_mean), ""),
            own("way in a lattice step", number(lattice.way_panels), "chords of a panel"),
        ]);
    }
    rows.push(own("lift law", summary.lift_law.clone(), ""));
    rows.push(own("strips past stall", shared(summary.stall_fraction), "%"));
    if let Some(beyond) = summary.beyond_residual_fraction {
        rows.push(own("beyond robot.residual", share(beyond), "% of the time"));
    }
    if !summary.law_states.is_empty() {
        rows.extend(summary.law_states.iter().map(law_state));
        rows.push(own("suction lost, mean", shared(summary.suction_lost_fraction), "%"));
    }
    let clearance = summary.least_clearance_m.map_or("-".into(), |c| number(1e3 * c));
    rows.push(own("least clearance", clearance, "mm"));
    rows.extend(summary.constant_clearance.as_ref().map(|parts| own("always that of", parts.clone(), "")));
    rows.push(own("clearance below zero", shared(summary.crossing_fraction), "% of the time"));
    rows
}

/// Power and what carries the weight.
fn cost(summary: &Summary) -> Vec<PaperLine> {
    let of_cost = |(name, value, unit): CostLine| own(name, value, unit);
    let measured = summary.measured.iter().filter(|(measure, value)| measure.always || value.is_some());
    let lines = measured.filter_map(|(measure, value)| {
        let (name, digits, unit) = measure.line?;
        Some(own(name, value.map_or("-".into(), |value| format!("{value:.digits$}")), unit))
    });
    let powers = summary.cost.power_lines().into_iter().map(of_cost).chain(lines);
    powers.chain(summary.cost.weight_lines().into_iter().map(of_cost)).collect()
}

/// How far estimate, hover and path are off.
fn errors(summary: &Summary) -> Vec<PaperLine> {
    let mut rows = Vec::new();
    if let Some(estimate) = &summary.estimate {
        rows.extend([
            own("height, estimate's rms", number(1e3 * estimate.height_rms_m), "mm"),
            own("roll, estimate's rms", number(estimate.roll_rms_deg), "deg"),
            own("estimate within 3 sigma", share(estimate.within_3_sigma), "% of the errors"),
        ]);
    }
    if let Some(hover) = &summary.hover {
        rows.extend([
            own("from the place, rms", number(1e3 * hover.place_rms_m), "mm"),
            own("attitude, rms", number(hover.attitude_rms_deg), "deg"),
            own("attitude, largest", number(hover.attitude_max_deg), "deg"),
            own("force of the air, error", share(hover.air_force_error), "% of its mean"),
        ]);
    }
    if let Some(path) = &summary.path {
        rows.extend([
            own("across the path, rms", number(1e3 * path.cross_rms_m), "mm"),
            own("across, largest", number(1e3 * path.cross_max_m), "mm"),
            own("along the path, rms", number(1e3 * path.along_rms_m), "mm"),
        ]);
    }
    rows
}

/// Commands and updates.
fn controller(summary: &Summary) -> Vec<PaperLine> {
    let controller = &summary.controller;
    let mut rows = vec![
        own("inputs at a limit", share(summary.input_saturation_fraction), "%"),
        own("controller updates", controller.updates.to_string(), ""),
    ];
    if controller.updates > 0 {
        rows.extend([
            own("controller failures", controller.failures.to_string(), ""),
            own("updates past their period or deadline", controller.late.to_string(), ""),
            own("update, median", number(1e-3 * controller.median_us), "ms"),
            own("update, 99.9 %", number(1e-3 * controller.p999_us), "ms"),
        ]);
    }
    if let Some(prepared) = &summary.prepared {
        rows.extend([
            own(
                "update, from its measurement to its commands, median",
                number(1e-3 * controller.answer_median_us),
                "ms",
            ),
            own("attitude off that prepared for, largest", number(prepared.missed_max_deg), "deg"),
        ]);
    }
    rows.push(own("real-time factor", number(summary.real_time_factor), ""));
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

    /// One row by drive and one by actuators, whose plain names are what these give.
    #[test]
    fn powers_have_plain_names_and_a_flight_that_is_not_judged_says_why() {
        let summary = flown("stall");
        let shown = table(&summary, None);
        assert!(shown.contains("not judged: flight.weight_carried; "), "{shown}");
        let rows: Vec<&str> = shown.lines().filter(|row| row.contains(" W, ")).collect();
        let given = summary.measured.get("drive_power_given_w").unwrap();
        assert_eq!(rows.len(), 2, "{rows:?}");
        assert!(rows[0].starts_with("power of the drive") && rows[0].contains(&format!("{given:.3} W")));
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

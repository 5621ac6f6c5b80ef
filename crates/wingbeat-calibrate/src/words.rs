//! What a calibration found, in words.

use crate::data::SampleFiles;
use crate::found::CalibrationResult;
use crate::{FittedParameter, Information, RunRole, rms};
use wingbeat::judge::Verdict;
use wingbeat::robot::FittedModel;

/// The information table as text: what the runs tell of the parameters before they are fitted.
pub fn information(of: &Information, parameters: &[FittedParameter]) -> String {
    let name = |k: usize| parameters[k].name.as_str();
    let mut text = format!(
        "relative standard error at the start values; fitted: all runs, other parameters fitted too; known: others known; best alone: \
         best run and channel\n\n{:<34}{:>12}{:>12}{:>12}  {}\n",
        "", "fitted", "known", "best alone", "run, channel"
    );
    for (k, together) in of.together.iter().enumerate() {
        let best = of.alone.iter().enumerate().min_by(|a, b| a.1[k].total_cmp(&b.1[k]));
        let (row, alone) = best.map_or((0, f64::INFINITY), |(row, errors)| (row, errors[k]));
        let (run, channel) = (&of.runs[row / of.channels], row % of.channels);
        let channel = wingbeat::rig::cell::CHANNELS.get(channel).map_or("", |(name, _)| *name);
        let known = of.known[k];
        text += &format!("{:<34}{together:>12.2e}{known:>12.2e}{alone:>12.2e}  {run}, {channel}\n", name(k));
    }
    for (j, i, correlation) in &of.close {
        text += &format!("close: {} and {}, correlation {correlation:.3}\n", name(*j), name(*i));
    }
    for group in &of.inseparable {
        let names: Vec<&str> = group.iter().map(|(k, _)| name(*k)).collect();
        text += &format!("not told apart: {}\n", names.join(", "));
    }
    text += &match &of.suffice {
        Some(runs) if runs.len() < of.runs.len() => {
            format!("{} of the {} runs tell every parameter to within its size\n", runs.len(), of.runs.len())
        }
        Some(runs) if runs.len() == 1 => "the run tells every parameter to within its size\n".into(),
        Some(_) => {
            format!("all {} runs are needed to tell every parameter to within its size\n", of.runs.len())
        }
        None => "the runs do not tell every parameter to within its size\n".into(),
    };
    text
}

/// The same as CSV: run, channel, then a column per parameter.
pub fn information_csv(found: &CalibrationResult) -> String {
    let of = &found.information;
    let names: Vec<&str> = found.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let mut text = format!("run,channel,{}\n", names.join(","));
    for (row, errors) in of.alone.iter().enumerate() {
        let channel = &found.channels()[row % of.channels];
        let numbers: Vec<String> = errors.iter().map(|error| wingbeat_io::shortest(*error)).collect();
        text += &format!("{},{channel},{}\n", of.runs[row / of.channels], numbers.join(","));
    }
    text
}

/// The report.
pub fn report(found: &CalibrationResult, verdict: &Verdict) -> String {
    let model = if found.model.is_empty() { String::new() } else { format!(": {}", found.model.join(", ")) };
    let mut text = format!("calibration {}{model}\n\n", found.name);
    text += &format!("status: {}\n", verdict.status);
    verdict.reason.iter().for_each(|reason| text += &format!("because: {reason}\n"));
    text.push('\n');
    text += &format!(
        "{:<34}{:>13}{:>13}{:>13}{:>13}  {}\n",
        "", "start", "value", "std. error", "(white)", "profile"
    );
    for (k, parameter) in found.parameters.iter().enumerate() {
        text += &format!(
            "{:<34}{:>13.6}{:>13.6}{:>13.2e}{:>13}  {}{}\n",
            parameter.name,
            parameter.start,
            found.values[k],
            found.errors[k],
            if found.white_errors[k] > 0.0 {
                format!("{:.2e}", found.white_errors[k])
            } else {
                "none".into()
            },
            found.label(k).word(),
            if found.values[k] <= parameter.low || found.values[k] >= parameter.high {
                ", at its bound"
            } else {
                ""
            }
        );
    }
    for (name, value) in &found.held {
        text += &format!("{name:<34}{value:>13.6}         held\n");
    }
    text += &format!(
        "\nstandard errors: cycles as clusters, with what the model cannot say and priors; (white): as if every sample were \
         independent\nreduced chi-squared with the noise of the cycles alone: {:.3}\n",
        found.chi_squared
    );
    if found.discrepancy.iter().any(|share| *share > 0.0) {
        let shares: Vec<String> = found
            .channels()
            .iter()
            .zip(&found.discrepancy)
            .map(|(channel, share)| format!("{channel} {:.1} %", 100.0 * share))
            .collect();
        text += &format!(
            "the model is wrong beyond the noise: what it cannot say, in parts of each channel's amplitude: {}\n",
            shares.join(", ")
        );
    }
    let over = found.channels().into_iter().zip(found.residual_over_noise());
    let over =
        over.map(
            |(channel, ratio)| {
                if ratio.is_nan() { format!("{channel} -") } else { format!("{channel} {ratio:.2}") }
            },
        );
    let over: Vec<String> = over.collect();
    text += &format!(
        "power of the residuals over that of the noise, 1 where only noise is left: {}\n",
        over.join(", ")
    );
    if let Some(colour) = found.residual_autocorrelation() {
        text += &format!(
            "correlation of the residuals with themselves one phase on, 0 where only noise is left: {colour:.2}\n"
        );
    }
    let costs: Vec<String> = found
        .starts
        .iter()
        .map(|fit| fit.as_ref().map_or("no answer".into(), |fit| format!("{:.6e}", fit.cost)))
        .collect();
    text += &format!("cost from each start: {}\n\n", costs.join(", "));
    text += &runs(found);
    text += &structures(found);
    text += &learned(found);
    text += &next_run(found);
    for caution in &found.cautions {
        text += &format!("\nnote: {caution}\n");
    }
    for warning in &verdict.warnings {
        text += &format!("\n{warning}\n");
    }
    text
}

/// Candidates that the report names.
const NAMED: usize = 12;

/// The candidates for a next run, the best first.
fn next_run(found: &CalibrationResult) -> String {
    let Some(best) = found.next.first() else { return String::new() };
    let too_much = |share: f64| match share > 1.0 {
        true => format!(", but its load is {share:.1} times the cell's range"),
        false => String::new(),
    };
    let mut text = format!(
        "\nnext run: {} lowers the standard error of {} from {:.2e} to {:.2e}{}\n",
        best.name,
        best.parameter,
        best.error_now,
        best.error_then,
        too_much(best.load_share)
    );
    for other in found.next[1..].iter().take(NAMED) {
        text +=
            &format!("          {} to {:.2e}{}\n", other.name, other.error_then, too_much(other.load_share));
    }
    if found.next.len() > NAMED + 1 {
        text += &format!("          and {} more (summary.json)\n", found.next.len() - NAMED - 1);
    }
    text
}

/// Rms by run and channel, before and after, with the coverage of the band.
fn runs(found: &CalibrationResult) -> String {
    let channels = found.channels();
    let mut text = format!("{:<34}", "rms before -> after");
    channels.iter().for_each(|channel| text += &format!("{channel:>20}"));
    text.push('\n');
    for run in &found.runs {
        let (before, after) = (rms(&run.observed, &run.before), rms(&run.observed, &run.after.cycle));
        let held = match run.observed.role {
            RunRole::Fitted => "",
            RunRole::HeldOut => " (held out)",
            RunRole::Residual => " (residual)",
        };
        text += &format!("{:<34}", format!("{}{held}", run.observed.name));
        for (before, after) in before.iter().zip(&after) {
            let told = format!("{before:.5} -> {after:.5}");
            text += &format!("{:>20}", if after.is_nan() { "-".into() } else { told });
        }
        text.push('\n');
        let is_measured = |channel: usize| run.observed.is_measured(channel);
        let covered = run.after.coverage(&run.observed, &run.after.deviations);
        let white = run.after.coverage(&run.observed, &run.after.white);
        text += &format!("{:<34}", "  in the 95 % band (white)");
        for (channel, (covered, white)) in covered.iter().zip(&white).enumerate() {
            let told = format!("{:.1} % ({:.1} %)", 100.0 * covered, 100.0 * white);
            text += &format!("{:>20}", if is_measured(channel) { told } else { "-".into() });
        }
        text.push('\n');
    }
    for (run, rms) in &found.left_out {
        text += &format!("{:<34}", format!("{} left out", found.runs[*run].observed.name));
        for rms in rms {
            text += &if rms.is_nan() { format!("{:>20}", "-") } else { format!("{rms:>20.5}") };
        }
        text.push('\n');
    }
    text
}

fn structures(found: &CalibrationResult) -> String {
    if found.rivals.len() < 2 {
        return String::new();
    }
    let mut text = format!(
        "\n{:<34}{:>14}{:>14}{:>14}\n",
        "structure, best first", "left out", "held out", "chi squared"
    );
    for rival in &found.rivals {
        let held = rival.held_out_share.map_or("-".into(), |share| format!("{:.2} %", 100.0 * share));
        text += &format!(
            "{:<34}{:>14}{:>14}{:>14.3}\n",
            rival.name,
            format!("{:.2} %", 100.0 * rival.left_out_share),
            held,
            rival.chi_squared
        );
    }
    text += "(rms error in parts of the measured rms, mean of the channels)\n";
    text
}

/// What the learned wrench says of the runs that it is learned from.
fn learned(found: &CalibrationResult) -> String {
    let Some(residual) = &found.residual else { return String::new() };
    let mut text = format!(
        "\nwhat the model leaves of {} runs, learned by phase and velocity ({}):\n{:<34}{:>14}{:>14}\n",
        residual.runs.len(),
        residual.spec.terms.join(", "),
        "",
        "left, rms",
        "run left out"
    );
    for channel in &residual.channels {
        let told = if channel.is_told() { "" } else { "  not told, left out" };
        let missed = format!("{:.1} %", 100.0 * channel.missed);
        text += &format!("{:<34}{:>14.5}{missed:>14}{told}\n", channel.name, channel.left);
    }
    text += "(left: rms of what the model leaves over the runs; run left out: what is missed of it of a run that it is not learned from)\n";
    text
}

/// Where a file of the run folder is from: `commit` is that of the program, `key` the key that names the file.
fn origin(found: &CalibrationResult, files: &SampleFiles, (commit, what, key): (&str, &str, &str)) -> String {
    let mut text = format!(
        "# {what}: wingbeat {} ({commit}), calibration {}.\n\
         # Of the model {}. In a scenario: --set robot.{key}=FILE; on the rig: --set rig.robot.{key}=FILE.\n",
        env!("CARGO_PKG_VERSION"),
        found.name,
        if found.model.is_empty() { "as the runs give it".into() } else { found.model.join(", ") },
    );
    for file in &files.0 {
        text += &format!("# data {} fnv1a64 {}\n", file.file, file.fnv1a64);
    }
    if files.0.is_empty() {
        text += "# data simulated by the calibration's own truth\n";
    }
    text
}

/// The learned wrench as a file that `robot.residual` names, none where no channel is told; `commit` is that of the program.
pub fn residual(found: &CalibrationResult, files: &SampleFiles, commit: &str) -> Option<String> {
    let spec = &found.residual.as_ref().filter(|residual| !residual.spec.loads.is_empty())?.spec;
    let mut text = origin(found, files, (commit, "What the model leaves of measured loads", "residual"));
    text += "# It belongs to the numbers of numbers.toml: give both.\n";
    text += &format!(
        "preset = {:?}\nlaw = {:?}\nfrequency_hz = {:?}\nplace_m = {:?}\nlow_m_s = {:?}\nhigh_m_s = {:?}\nterms = {:?}\n\n[loads]\n",
        spec.preset.as_deref().unwrap_or_default(),
        spec.law.as_deref().unwrap_or_default(),
        spec.frequency_hz,
        spec.place_m,
        spec.low_m_s,
        spec.high_m_s,
        spec.terms
    );
    for (channel, rows) in &spec.loads {
        text += &format!("{channel} = [\n");
        rows.iter().for_each(|row| text += &format!("  {row:?},\n"));
        text += "]\n";
    }
    Some(text)
}

/// Standard errors with their degrees of freedom and correlations of the parameters of which the data say anything, as a line of a file of numbers.
fn uncertainty(found: &CalibrationResult) -> String {
    let told: Vec<usize> =
        (0..found.errors.len()).filter(|k| found.errors[*k].is_finite() && found.errors[*k] > 0.0).collect();
    if told.is_empty() {
        return String::new();
    }
    let names: Vec<&str> = told.iter().map(|k| found.parameters[*k].name.as_str()).collect();
    let errors: Vec<f64> = told.iter().map(|k| found.errors[*k]).collect();
    let rows: Vec<Vec<f64>> =
        told.iter().map(|i| told.iter().map(|j| found.correlations[*i][*j]).collect()).collect();
    let freedom = found.freedom;
    let freedom =
        if freedom.is_finite() { format!(", degrees_of_freedom = {freedom:?}") } else { String::new() };
    format!(
        "uncertainty = {{ of = {names:?}, standard_error = {errors:?}, correlation = {rows:?}{freedom} }}\n"
    )
}

/// The numbers as a file that `robot.numbers` names; `commit` is that of the program.
pub fn numbers(found: &CalibrationResult, files: &SampleFiles, commit: &str, verdict: &Verdict) -> String {
    let mut text = origin(found, files, (commit, "Numbers of robot and rig, calibrated", "numbers"));
    text += &format!(
        "verdict = {{ status = {:?}, reason = {:?}, written = \"wingbeat {} ({commit})\" }}\n",
        verdict.status.name(),
        verdict.reason.as_deref().unwrap_or_default(),
        env!("CARGO_PKG_VERSION")
    );
    let FittedModel { robot, preset, law, half_span_m } = &found.fitted_with;
    let of = if robot.is_empty() { String::new() } else { format!("robot = {robot:?}, ") };
    let span = half_span_m.map_or(String::new(), |span| format!(", half_span_m = {span:?}"));
    text += &format!("model = {{ {of}preset = {preset:?}, law = {law:?}{span} }}\n");
    text += &uncertainty(found);
    for (k, parameter) in found.parameters.iter().enumerate() {
        text += &format!(
            "{:?} = {:?} # standard error {:.3e}, {}\n",
            parameter.name,
            found.values[k],
            found.errors[k],
            found.label(k).word()
        );
    }
    for (name, value) in &found.held {
        text += &format!("{name:?} = {value:?} # held\n");
    }
    text
}

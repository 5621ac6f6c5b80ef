//! The figures of a calibration.

use wingbeat::rig::cell::CHANNELS;
use wingbeat::scenario::spoken;
use wingbeat_calibrate::{CalibrationResult, FoundRun, HarmonicLayout, PHASES, phase_of};
use wingbeat_figures::calibration::{
    Overlay, ProfileCurve, ResidualSpectrum, correlations, information, overlay, profiles, residual_spectra,
};
use wingbeat_figures::write as write_figure;

use crate::error::Error;
use crate::run_folder::RunFolder;

/// Draws what can be drawn; what cannot is said and left out.
pub fn draw(folder: &RunFolder, found: &CalibrationResult) -> Result<(), Error> {
    let figures = folder.folder("figures")?;
    let told = crate::fly::left_out;
    let names: Vec<String> = found.parameters.iter().map(|parameter| spoken(&parameter.name)).collect();
    told(write_figure(&figures, &correlations(&names, found.correlations.clone())))?;
    told(write_figure(&figures, &profiles(profile_curves(found))))?;
    told(write_figure(&figures, &residual_spectra(spectra(found))))?;
    let told_by = &found.information;
    let channels = found.channels();
    let rows =
        told_by.runs.iter().flat_map(|run| channels.iter().map(move |channel| format!("{run} {channel}")));
    told(write_figure(&figures, &information(rows.collect(), names, told_by.alone.clone())))?;
    for (number, run) in found.runs.iter().enumerate() {
        let own = folder.folder(&format!("figures/{}", run.observed.name))?;
        told(write_figure(&own, &overlay(overlays(run, found.with_residual(number)))))?;
    }
    Ok(())
}

/// Channel with its unit.
fn title(channel: usize) -> String {
    let (name, unit) = CHANNELS[channel];
    format!("{name} [{unit}]")
}

/// `with_residual` are numbers of the cycle with the learned wrench.
fn overlays(run: &FoundRun, with_residual: Option<&[f64]>) -> Vec<Overlay> {
    let curves = run.curves();
    let channel = |channel: usize| {
        let of = |which: usize| curves.iter().map(|at| at[channel][which]).collect::<Vec<f64>>();
        Overlay {
            title: title(channel),
            measured: of(0),
            before: of(1),
            after: of(2),
            band: of(3).into_iter().zip(of(4)).collect(),
            with_residual: with_residual.map(|cycle| {
                (0..PHASES).map(|k| run.observed.layout.value(cycle, channel, phase_of(k))).collect()
            }),
        }
    };
    (0..run.observed.layout.channels).filter(|c| run.observed.is_measured(*c)).map(channel).collect()
}

fn profile_curves(found: &CalibrationResult) -> Vec<ProfileCurve> {
    let curve = |k: usize| {
        let profile = &found.profiles[k];
        ProfileCurve {
            name: spoken(&found.parameters[k].name),
            title: profile.label.word().into(),
            points: profile.values.iter().copied().zip(profile.cost.iter().copied()).collect(),
            fit: (found.values[k], found.errors[k]),
        }
    };
    (0..found.parameters.len()).map(curve).collect()
}

fn spectra(found: &CalibrationResult) -> Vec<ResidualSpectrum> {
    let runs: Vec<&FoundRun> = found.fitted().collect();
    let layout: HarmonicLayout = runs[0].observed.layout;
    let channel = |channel: usize| {
        let measured: Vec<&FoundRun> =
            runs.iter().copied().filter(|run| run.observed.is_measured(channel)).collect();
        let rms = |of: &dyn Fn(&FoundRun, usize) -> f64| -> Vec<f64> {
            let one = |k: usize| {
                let of = |run: &&FoundRun| if k > run.observed.layout.harmonics { 0.0 } else { of(run, k) };
                (measured.iter().map(of).sum::<f64>() / measured.len() as f64).sqrt()
            };
            (0..=layout.harmonics).map(one).collect()
        };
        let apart = |run: &FoundRun, cycle: &[f64], k: usize| -> f64 {
            let parts = if k == 0 { 0..1 } else { 2 * k - 1..2 * k + 1 };
            let one = |part: usize| {
                let at = run.observed.layout.at(channel, part);
                (cycle[at] - run.observed.mean[at]).powi(2)
            };
            parts.map(one).sum()
        };
        ResidualSpectrum {
            title: title(channel),
            before: rms(&|run, k| apart(run, &run.before, k)),
            after: rms(&|run, k| apart(run, &run.after.cycle, k)),
            noise: rms(&|run, k| if k == 0 { 1.0 } else { 2.0 } * run.noise[k][channel]),
        }
    };
    let measured = |channel: &usize| runs.iter().any(|run| run.observed.is_measured(*channel));
    (0..layout.channels).filter(measured).map(channel).collect()
}

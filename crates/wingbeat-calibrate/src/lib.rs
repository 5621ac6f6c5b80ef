//! Numbers of robot and rig from runs on the load cell, with what is known of them.
//!
//! A [`CycleModel`] predicts the cycles of runs and their derivatives by the [`FittedParameter`]s; [`ObservedCycles`] holds what was measured.
//! [`solve`] fits them by Levenberg-Marquardt, weighed by the scatter of the cycles and by what the model cannot say;
//! [`SolvedCalibration`] tells standard errors, profiles, bands and the error in runs left out. [`RigModel`] is the model of runs on the
//! rig; [`Information`] says before any fit what the runs can tell. [`CalibrationFile::prepared`] and [`PreparedCalibration::fit`] go all the way from a
//! file to [`CalibrationResult`].

mod band;
mod bins;
mod calibration;
mod checks;
mod data;
pub mod design;
mod doctor;
mod error;
mod find;
mod fit;
mod found;
mod harmonics;
mod information;
pub mod measured;
mod observed;
mod problem;
mod processed;
mod residual;
mod rig;
mod rival;
mod solve;
mod summary;
mod tare;
mod tethered;
mod tilts;
mod truth;
mod uncertainty;
mod verdict;
pub mod words;

pub use band::Predicted;
pub use calibration::{CalibrationFailure, CalibrationFile, ModelStructure};
pub use checks::{Disagreement, checked, disagreement};
pub use data::{DataFile, SampleFiles, read};
pub use error::Error;
pub use find::PreparedCalibration;
pub use fit::{Fit, FitEnding, FitProgress, FitWatch, Keep, LinearisedRuns};
pub use found::{CalibrationResult, FoundRun, columns};
pub use harmonics::{HarmonicLayout, project};
pub use information::{CLOSE, Information, channel_name};
pub use observed::{Common, ObservedCycles, RunRole, scatter};
pub use problem::{CycleModel, FitProblem, FittedParameter, Whitened};
pub use processed::{ProcessSummary, ProcessedFile, ProcessedTogether, SampleSource};
pub use residual::{LearnedChannel, LearnedResidual};
pub use rig::{RigModel, RigTarget, in_cell, respond};
pub use rival::{NextRun, Rival, expected_noise};
pub use solve::{FitPlan, FitStart, PHASES, SolvedCalibration, phase_of, rms, solve, solve_problem, starts};
pub use summary::CalibrationSummary;
pub use tethered::CaseTarget;
pub use tilts::Tilts;
pub use truth::{Clean, clean};
pub use uncertainty::{Covariances, Label, NORMAL_95, Profile, correlations, student_95};

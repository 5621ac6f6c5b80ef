//! Limits of a fit. All values are choices.

use super::JudgedLimit;
use crate::status::Status::{OffTarget, Outside, SuspectData};

/// What the fit explains of the variation over the cycle. A model that is wrong by 10 % of the loads explains 0.99, one that
/// is wrong by half of them 0.75.
pub const EXPLAINED: JudgedLimit =
    JudgedLimit::at_least("calibration.explained_fraction", 0.5, "", SuspectData)
        .on("share of the measured variation over the cycle that the fit explains");
/// An honest error of the model, of which a reader must know: residuals of a third of the loads.
pub const MODEL_ERROR: JudgedLimit = JudgedLimit::warn_below("calibration.model_error_explained_fraction", 0.9, "")
    .on("the model misses much of the loads: share of the measured variation over the cycle that the fit explains");
/// Rms residual of a channel after the fit over that before it, largest of all channels: one that the fit makes worse while it mends
/// others says that the model lacks what those others show.
pub const WORSE: JudgedLimit = JudgedLimit::at_most("calibration.channel_growth", 2.0, "", OffTarget)
    .on("growth of the residuals by the fit");
/// Growth of the residuals of a channel, of which a reader must know.
pub const WORSE_TOLD: JudgedLimit = JudgedLimit::warn_above("calibration.channel_growth_told", 1.1, "")
    .on("the fit makes a channel worse than it was: growth of the residuals");
/// Misfit over the noise of the cycles. With a misfit of 10 % of the loads this limit is a noise of 1e-7 of them, which no load
/// cell resolves: cycles that repeat so well are not measured.
pub const CHI_SQUARED: JudgedLimit = JudgedLimit::at_most("calibration.chi_squared", 1e12, "", SuspectData)
    .on(
        "the cycles scatter less than any load cell resolves, so they were not measured: reduced chi-squared",
    );
/// Misfit beyond the noise, after which intervals rest on what the fit estimates of the model's own error.
pub const BEYOND_NOISE: JudgedLimit =
    JudgedLimit::warn_above("calibration.beyond_noise_chi_squared", 4.0, "")
        .on("the model is wrong beyond the noise of the cycles: reduced chi-squared");
/// Misfit of ten times the noise: what the fit calls identified then makes up for what the model lacks. *Choice.*
pub const WRONG_MODEL: JudgedLimit =
    JudgedLimit::at_most("calibration.wrong_model_chi_squared", 100.0, "", Outside)
        .on("the model misses the loads by many times their noise, so that the values make up for what it lacks: reduced chi-squared");
/// Time shift that is left between measured and fitted cycles; runs are refused beyond it before the fit.
pub const PHASE: JudgedLimit = JudgedLimit::at_most("calibration.phase_deg", 5.0, "deg", SuspectData)
    .on("shift between the measured and the fitted cycle");
/// A shift that the residuals tell beside the parameters, which have taken what they can of it. *Choice*: noise alone reaches it in one of
/// 16000 runs.
pub const LATE: JudgedLimit = JudgedLimit::warn_above("calibration.shift_errors", 4.0, "").on(
    "loads come early or late, and the parameters make up for it (mend the time of the first sample, or fit the phase of runs on a rig; a wrong model \
     shifts them too): shift that is left over its standard error,",
);
/// The same in degrees, of shifts beyond those errors: as large as the tolerance of a clock before the fit.
pub const LEFT: JudgedLimit = JudgedLimit::at_most("calibration.shift_left_deg", 5.0, "deg", Outside).on(
    "the parameters make up for a late clock or a wrong law: shift that is left, known to more than limits.calibration.shift_errors of its errors,",
);
/// Circular correlation of what the fit leaves with itself one phase on, in deviations: 0 +- 1/sqrt(n W) of noise alone, with W numbers of
/// each of n channels, which of a force with eight harmonics reaches half in one of 50, of three in one of 5000.
pub const COLOURED: JudgedLimit = JudgedLimit::warn_above("calibration.residual_autocorrelation", 0.5, "")
    .on("the residual is not noise but a curve over the cycle: its correlation from one phase to the next");
/// Power of the residuals of a channel, its sign the other one, over that which the fit leaves, least of the channels that are missed
/// beyond the noise. Models whose drag is wrong by half keep its sign: they have 2 and more.
pub const REVERSED: JudgedLimit = JudgedLimit::warn_below("calibration.reversed_fraction", 0.25, "")
    .on("a channel is met better with its sign reversed: power of its residuals with the sign reversed over that which is left");
/// Parameters that the fit found: without any, the fit says nothing.
pub const IDENTIFIED: JudgedLimit =
    JudgedLimit::at_least("calibration.identified_fraction", 1e-3, "", OffTarget)
        .on("share of the parameters that the runs identify");
/// Parameters of which the runs tell a combination only.
pub const CORRELATION: JudgedLimit =
    JudgedLimit::warn_above("calibration.correlation", 0.98, "").on("largest correlation of two parameters");

/// All of them.
pub const ALL: [JudgedLimit; 14] = [
    EXPLAINED,
    MODEL_ERROR,
    WORSE,
    WORSE_TOLD,
    CHI_SQUARED,
    BEYOND_NOISE,
    WRONG_MODEL,
    PHASE,
    LATE,
    LEFT,
    COLOURED,
    REVERSED,
    IDENTIFIED,
    CORRELATION,
];

//! Limits of measured motion and loads, whichever verb reads them.
//!
//! Each is a choice. They lie where data of wrong making lie apart from right data that look odd in the corpus of
//! `tests/all/data.rs`; a reason stands at each.

use super::JudgedLimit;
use crate::status::Status::SuspectData;

/// A value that is no number cannot be averaged.
pub const NOT_FINITE: JudgedLimit = JudgedLimit::at_most("data.not_finite_samples", 0.0, "", SuspectData)
    .on("number of samples without a finite value");
/// A clock does not go back.
pub const BACKWARD: JudgedLimit = JudgedLimit::at_most("data.backward_steps", 0.0, "", SuspectData)
    .on("number of steps that do not go ahead in time");
/// Interpolation over a twentieth of the samples moves a mean by less than the noise of a load cell; more does not.
pub const LOST: JudgedLimit = JudgedLimit::at_most("data.lost_fraction", 0.05, "", SuspectData)
    .on("share of the samples that are missing in gaps");
/// The mean of every second cycle has 1.4 times the error of that of all, and its scatter is hardly known any more. *Choice.*
pub const CYCLES_LOST: JudgedLimit =
    JudgedLimit::at_most("data.cycles_left_out_fraction", 0.5, "", SuspectData)
        .on("share of the cycles that are left out as samples are missing in them");
/// The same as a warning: the error grows by 5 %. *Choice.*
pub const FEW_CYCLES_LOST: JudgedLimit = JudgedLimit::warn_above("data.cycles_left_out_told", 0.1, "")
    .on("share of the cycles that are left out as samples are missing in them");
/// Far below any load cell (1 uN) and any motion that moves air, in N, N m, m, deg or rad.
pub const TINY: JudgedLimit = JudgedLimit::at_least("data.smallest_amplitude", 1e-9, "", SuspectData)
    .on("largest absolute value of all channels");
/// Far above what a wing in a wind tunnel sees, in any of these units.
pub const HUGE: JudgedLimit = JudgedLimit::at_most("data.largest_magnitude", 1e9, "", SuspectData)
    .on("largest absolute value of a channel");
/// A load that follows the stroke passes through every value twice a cycle: it stays within one count for less than half of it.
pub const STUCK: JudgedLimit = JudgedLimit::at_most("data.stuck_cycles", 0.6, "", SuspectData)
    .on("longest time, in cycles, for which a channel keeps its value to one count,");
/// Noise reaches an extreme once; a smooth top of a quantised load does not end in a step to it.
pub const CLIPPED: JudgedLimit = JudgedLimit::at_most("data.clipped_fraction", 0.03, "", SuspectData)
    .on("share of the samples at the highest or lowest value, as if clipped,");
/// Of the range of the mean cycle, or of the mean where that is larger: a tare that moves by more changes means and phases.
pub const DRIFT: JudgedLimit = JudgedLimit::at_most("data.drift_fraction", 0.2, "", SuspectData)
    .on("change of the mean from the start to the end of the file, relative to the range of the cycle,");
/// F statistic of the harmonics against the noise: noise alone has 1 +- 0.4, and reaches 4 less than once in 1e4 files.
pub const SIGNAL: JudgedLimit = JudgedLimit::at_least("data.signal_over_noise", 4.0, "", SuspectData)
    .on("power of the periodic part over the power that noise alone would give it");
/// Noise alone reached 28 in the worst of a thousand files of six channels with 4000 samples (measured), and 36 in one of 3e6, as powers of
/// noise are distributed exponentially; a flapping wing has thousands.
pub const LINE: JudgedLimit = JudgedLimit::at_least("data.line_over_noise", 36.0, "", SuspectData)
    .on("power of the strongest line of the spectrum over that of the noise beside it");
/// A cycle ten times below the noise is lost in what the noise does to the tare and the phase.
pub const SHARE: JudgedLimit = JudgedLimit::at_least("data.signal_fraction", 0.01, "", SuspectData)
    .on("share of the power of the channel that repeats with the cycle");
/// What neither repeats with the cycle nor is noise: with more, means over cycles say little.
pub const APERIODIC: JudgedLimit = JudgedLimit::at_most("data.aperiodic_fraction", 0.3, "", SuspectData)
    .on("share of the power that is neither periodic nor noise");
/// The tolerance of `calibrate` for the frequency of a run; judged where the data tell it that well.
pub const FREQUENCY: JudgedLimit = JudgedLimit::at_most("data.frequency_fraction", 0.01, "", SuspectData)
    .on("relative difference between the frequency of the data and the one given");
/// Loads of a motion at another frequency: 10 % change the reduced frequency as much, and what the inertia gives by a fifth. *Choice.*
pub const OTHER_FREQUENCY: JudgedLimit = JudgedLimit::warn_above("data.other_frequency_fraction", 0.1, "")
    .on("relative difference between the frequency of a measured motion and that of the case beside it");
/// Noise that adds half to the acceleration adds as much to the loads.
pub const ROUGH: JudgedLimit = JudgedLimit::at_most("data.acceleration_noise_fraction", 0.5, "", SuspectData)
    .on("noise of the acceleration relative to the acceleration");
/// A model may be wrong by half and in phase; it does not turn a load round.
pub const REVERSED: JudgedLimit = JudgedLimit::at_least("data.correlation_least", -0.7, "", SuspectData)
    .on("correlation between the measured and the computed load");
/// What all changed channels must bring together, in parts of a full correlation, and each at least.
pub const SWAPPED: JudgedLimit = JudgedLimit::at_most("data.swap_gain", 0.5, "", SuspectData)
    .on("gain in correlation if channels are swapped");
/// Slope of the loads and drag differ by this between models; a cell's gain is known to 1 %.
pub const GAIN: JudgedLimit = JudgedLimit::warn_above("data.gain_fraction", 0.1, "")
    .on("difference from 1 of the ratio between measured and computed load");
/// The tolerance of `calibrate` for the phase of a run: what 5 deg do to a drag is as large as the drag of a plate.
pub const SHIFT: JudgedLimit = JudgedLimit::at_most("data.shift_deg", 5.0, "deg", SuspectData)
    .on("phase difference between the measured and the computed cycle");
/// A cycle that no lag makes like the computed one in any channel is of something else.
pub const UNRELATED: JudgedLimit = JudgedLimit::at_least("data.best_correlation", 0.3, "", SuspectData)
    .on("largest correlation of any channel with its computed load");
/// A channel that moves by a fiftieth of what is computed is not connected.
pub const DEAD: JudgedLimit = JudgedLimit::at_least("data.dead_fraction", 0.02, "", SuspectData)
    .on("range of the measured cycle relative to that of the computed one");
/// The inverse of that: a channel that has the shape of what is computed and moves by fifty times as much is in another unit.
pub const LARGEST: JudgedLimit = JudgedLimit::at_most("data.largest_gain", 50.0, "", SuspectData)
    .on("range of a measured cycle of the right shape relative to that of the computed one");
/// The loads of a flapping wing have a strong second harmonic: a stretch of a fifth of a cycle without a sample hides it.
pub const PHASE_GAP: JudgedLimit = JudgedLimit::at_most("data.phase_gap_cycles", 0.2, "", SuspectData)
    .on("longest stretch of the cycle in which no cycle has a sample");

/// What a cusp adds to what harmonics leave: right loads have 1, magnitudes of loads with noise of 3 % have 4.
pub const RECTIFIED: JudgedLimit = JudgedLimit::at_most("data.rectified_ratio", 2.5, "", SuspectData)
    .on("how much better harmonics fit the cycle when every second half wave is inverted");
/// What samples far from their phase add to the mean magnitude, in parts of the cycle's range: the gain of a load cell is known to
/// 1 %. White noise has none beyond eight deviations, and one spike of the range in 1000 samples adds 0.1 %.
pub const OUTLIERS: JudgedLimit = JudgedLimit::at_most("data.outliers_fraction", 0.01, "", SuspectData).on(
    "distance of the samples far from others of their phase, over all samples and the range of the cycle,",
);
/// A load that is sampled well never crosses its range in one step; a wrap leaps twice a cycle.
pub const WRAPPED: JudgedLimit = JudgedLimit::at_most("data.leaps_per_cycle", 0.2, "", SuspectData)
    .on("leaps per cycle of a smooth channel across its whole range,");
/// White noise has 1, its differences 1.5, and smooth loads a quarter.
pub const ALTERNATES: JudgedLimit = JudgedLimit::at_most("data.alternating_ratio", 3.0, "", SuspectData)
    .on("mean square of the steps from sample to sample over that of the steps to the second next");
/// Correlation of the second differences of one sample and the next: white noise has -2/3, and smooth loads 1.
pub const BY_TURNS: JudgedLimit = JudgedLimit::warn_below("data.alternating_correlation", -0.9, "")
    .on("correlation of the second differences from sample to sample");
/// Second differences across the ends of turns over those within: a line has 0.5 in turns of 3 samples and less in longer ones, white noise
/// 0.9 (their deviations, sqrt(5 / 6)), in files of 2000 samples within 10 % of it.
pub const TURNS: JudgedLimit = JudgedLimit::at_most("data.turns_ratio", 2.0, "", SuspectData)
    .on("second differences at the joins of two sources that take turns, over those within a turn,");
/// Third differences from which a channel is taken to leap, over their deviation: of white noise one of 1e15 is that large.
pub const LEAPS: JudgedLimit = JudgedLimit::at_most("data.turn_leaps_ratio", 8.0, "", SuspectData)
    .on("third differences where two sources take turns over those of the noise");
/// As much as may be lost or written twice: what runs backwards takes the part of the mean that is odd in time away.
pub const BACKWARDS: JudgedLimit = JudgedLimit::at_most("data.backwards_fraction", 0.05, "", SuspectData)
    .on("share of the cycles that run backwards in time");
/// Fourth moment of the samples of one phase over the square of their variance: two values have 1 (1.3 of 22
/// samples, or with the noise and the sizes of a load), a hum 1.5, even noise 1.8.
pub const TWO_SOURCES: JudgedLimit = JudgedLimit::at_least("data.scatter_kurtosis", 1.42, "", SuspectData)
    .on("kurtosis of the samples of one phase, where they scatter from one to the next,");
/// Rows that are put back in pairs are smooth again; those of a line near half the rate are not.
pub const PAIRS: JudgedLimit = JudgedLimit::at_least("data.pairs_fraction", 0.25, "", SuspectData)
    .on("power of the second differences with the rows of each pair exchanged, over that without,");
/// A converter whose bit is dead leaves out a half, a quarter, an eighth of its range, and falls back by as much where its counts go on.
pub const BIT: JudgedLimit = JudgedLimit::at_most("data.dead_bit_fraction", 0.05, "", SuspectData)
    .on("widest part of its range that a smooth channel never takes and falls back by beside it");
/// Two ranges of an amplifier that do not meet leave out what lies between them.
pub const HOLE: JudgedLimit = JudgedLimit::warn_above("data.hole_fraction", 0.05, "")
    .on("widest part of its range that a smooth channel leaps over and never takes");
/// Noise of a count never gives 32 samples in a row again: what is written twice adds no cycle, and breaks the phase. As much as may be lost.
pub const TWICE: JudgedLimit = JudgedLimit::at_most("data.written_twice_fraction", 0.05, "", SuspectData)
    .on("share of the stretches of a noisy channel that recur sample by sample");
/// The same of a channel whose noise is not known, but for whole cycles.
pub const COPIED: JudgedLimit = JudgedLimit::warn_above("data.copied_fraction", 0.2, "").on(
    "share of the stretches of a channel that come again sample by sample, later than in the next cycle,",
);
/// Smooth motions have up to 1.5 from 5 rows a cycle on, rounded and noisy ones less than 2: a spike of five times the acceleration makes
/// loads of five times the inertia.
pub const ENDS: JudgedLimit = JudgedLimit::at_most("data.ends_ratio", 5.0, "", SuspectData)
    .on("acceleration where the ends of a table of one cycle meet, over the largest inside");
/// A tenth of the power of the motion is left out. White noise of a tenth of the amplitude leaves 0.14, one harmonic of a triangle 0.12.
pub const LEFT: JudgedLimit = JudgedLimit::at_most("data.left_fraction", 0.35, "", SuspectData)
    .on("rms of what the harmonics leave of a table over the rms of their motion");
/// Where one load resembles the data at 0.9 and more, another one is missed by this only if it is another channel or noise: attached flow beside
/// stall leaves 0.49 (measured), white noise in place of one channel had 0.05 to 0.17.
pub const UNLIKE: JudgedLimit = JudgedLimit::warn_below("data.channel_correlation", 0.4, "")
    .on("largest correlation of a channel with its computed load at any phase");

/// In a channel that is mostly load the rest is quiet; wings that move in it scatter in all channels. *Choice.*
pub const REST: JudgedLimit = JudgedLimit::at_most("data.rest_fraction", 0.4, "", SuspectData)
    .on("scatter in the restless quarter of the rest that is subtracted over that of what follows, in the channel where it is least,");
/// A run of ten cycles whose file lacks more than one was cut, or its start is wrong.
pub const COVERED: JudgedLimit = JudgedLimit::warn_below("data.covered_fraction", 0.9, "")
    .on("share of the time that is averaged that the file covers");

/// A load that two or three values stand for has no shape; noise that toggles many brings it back, and of six the mean is right to some
/// per cent.
pub const COUNTS: JudgedLimit = JudgedLimit::at_least("data.counts", 2.5, "", SuspectData)
    .on("range of a channel in steps of its converter");
/// The same as a warning.
pub const FEW_COUNTS: JudgedLimit =
    JudgedLimit::warn_below("data.few_counts", 6.0, "").on("range of a channel in steps of its converter");
/// Even steps of a range put 1 / (2 sqrt(3) n) of it on it, rms: 7 % of the amplitude of a sine in 12 of them, and far more of its
/// acceleration.
pub const STEPS: JudgedLimit = JudgedLimit::warn_below("data.motion_steps", 12.0, "")
    .on("range of a motion in steps between which it stands still");
/// Loads that swing by 45 % of their size have this share beside the cycle; a mount that swings by a quarter of it 0.06.
pub const SWINGS: JudgedLimit = JudgedLimit::warn_above("data.swinging_fraction", 0.1, "")
    .on("share of the power that is neither periodic nor noise");
/// A gain that swings by 60 % of itself makes 0.42, one that is half for a third of the file 0.28, a wind that swells by a fifth 0.14: the
/// mean cycle is that of no stroke.
pub const SCATTER: JudgedLimit = JudgedLimit::at_most("data.size_scatter_fraction", 0.25, "", SuspectData)
    .on("how far the cycles of a channel differ in size, rms over their mean size,");
/// Less than two samples a cycle do not show that it is one (H. Nyquist, Trans. AIEE 47 (1928) 617-644).
pub const SAMPLES: JudgedLimit =
    JudgedLimit::at_least("data.samples_per_cycle", 2.0, "", SuspectData).on("number of samples of a cycle");
/// A curve through N samples of a cycle leaves (1 - f)^4 / ((1 - f)^4 + f^4) of harmonic h, f = h / N: of the second one 0.61 with 4.2, 0.84 with 5, 0.94
/// with 6, 0.99 with 8. *Choices.*
pub const CURVED: JudgedLimit =
    JudgedLimit::at_least("data.samples_per_cycle_of_loads", 5.0, "", SuspectData).on(
        "number of samples of a cycle, of which the mean one loses more than a sixth of its second harmonic,",
    );
/// Of 5 to 6 samples a cycle it loses 16 to 6 % of it.
pub const FEW_CURVED: JudgedLimit = JudgedLimit::warn_below("data.few_samples_per_cycle", 6.0, "")
    .on("the mean cycle loses part of its second harmonic (16 % with 5, 6 % with 6, 1 % with 8; sample faster): number of samples of a cycle");
/// Where the data alone tell the frequency, less than three samples of the strongest line let its second harmonic look like another
/// line below it.
pub const OF_LINE: JudgedLimit = JudgedLimit::at_least("data.samples_of_line", 3.0, "", SuspectData)
    .on("number of samples in a period of the strongest line");
/// Strokes of a steady crank make 0.06 (measured).
pub const DIFFERS: JudgedLimit = JudgedLimit::warn_above("data.size_differs_fraction", 0.2, "")
    .on("how far the cycles of a channel differ in size, rms over their mean size,");
/// Cycles that come early and late by a normal distribution of s rad lower the harmonic k of the mean by exp(-(k s)^2 / 2): 13 % of the
/// first and 42 % of the second at 30 deg.
pub const PHASES: JudgedLimit = JudgedLimit::at_most("data.phase_scatter_deg", 30.0, "deg", SuspectData)
    .on("how early and late the cycles of a channel come, rms,");
/// The same as a warning: 2 % of the first harmonic, 6 % of the second.
pub const EARLY: JudgedLimit = JudgedLimit::warn_above("data.phase_differs_deg", 10.0, "deg")
    .on("how early and late the cycles of a channel come, rms,");
/// Ten cycles at a frequency that is off by 0.3 % run away by 11 deg. It is said, as the mean loses nothing of note: sin(x) / x of half the
/// angle, 0.1 % of the first harmonic.
pub const RUNS: JudgedLimit = JudgedLimit::warn_above("data.phase_runs_deg", 8.0, "deg")
    .on("drift of the phase of the cycles of a channel from start to end, by a straight line,");
/// The same of loads that are held against computed ones: their mean comes half as early, which is the tolerance of a shift.
pub const RUN_AWAY: JudgedLimit = JudgedLimit::at_most("data.phase_run_away_deg", 10.0, "deg", SuspectData)
    .on("drift of the phase of the cycles of a load from start to end, by a straight line,");
/// Loads that grow by less from begin to end lie within what strokes of a steady crank do (measured: 6 to 20 %).
pub const TREND: JudgedLimit = JudgedLimit::warn_above("data.size_trend_fraction", 0.3, "")
    .on("change of the size of the cycles of a channel from start to end, by a straight line, over their mean size,");
/// A measured load of many counts hardly ever has one value twice; of 0.5 % of the samples a mean takes as much as of the error of a cell.
pub const REPEATED: JudgedLimit = JudgedLimit::at_most("data.repeated_fraction", 0.005, "", SuspectData)
    .on("share of the samples that carry one fixed value, as a code for missing samples does,");
/// Models miss the phase of a load by tens of degrees at most; beyond it one channel has another clock.
pub const LAGS: JudgedLimit = JudgedLimit::at_most("data.lag_spread_deg", 60.0, "deg", SuspectData)
    .on("difference of the phase between two channels of a file, each beside what is computed");
/// A cell is straight to a per cent; a load of another harmonic leaves more, but no bend explains it.
pub const BENT: JudgedLimit = JudgedLimit::warn_above("data.bent_fraction", 0.1, "")
    .on("rms of what a straight line leaves of a channel over that of the channel, where a bend explains it");

/// Half a range: the simulated runs that are shipped, whose rigs differ from their files, have 0.18 at most, a fixture that is 38 g heavier
/// than its file says 0.9 in a turn (measured).
pub const MEAN: JudgedLimit = JudgedLimit::warn_above("data.mean_fraction", 0.5, "")
    .on("difference of the mean of a channel from the computed one, relative to the computed range,");
/// A twentieth of the range moves a mean as much as a cell's gain and a fixture's weight do together. *Choice.*
pub const REST_DRIFT: JudgedLimit = JudgedLimit::warn_above("data.rest_drift_fraction", 0.05, "")
    .on("what a significant drift of the rest moves the tare by, relative to the range,");
/// As far as the frequency is looked for by force: no motor under load turns so far from where it is set.
pub const PHASE_RATE: JudgedLimit = JudgedLimit::at_most("data.phase_rate_fraction", 0.2, "", SuspectData)
    .on("relative difference between the rate of the encoder and the frequency given");
/// As much as a gain that is told: harmonic 8 has it at 3/10 of the resonance.
pub const RESONANCE: JudgedLimit = JudgedLimit::warn_above("data.resonance_fraction", 0.1, "")
    .on("what the resonance of the mount adds to the highest harmonic that is judged");

/// All of them.
pub const ALL: [JudgedLimit; 66] = [
    MEAN,
    REST_DRIFT,
    PHASE_RATE,
    RESONANCE,
    NOT_FINITE,
    BACKWARD,
    LOST,
    CYCLES_LOST,
    FEW_CYCLES_LOST,
    TINY,
    HUGE,
    STUCK,
    CLIPPED,
    DRIFT,
    SIGNAL,
    LINE,
    SHARE,
    APERIODIC,
    FREQUENCY,
    OTHER_FREQUENCY,
    ROUGH,
    REVERSED,
    SWAPPED,
    GAIN,
    SHIFT,
    UNRELATED,
    DEAD,
    LARGEST,
    PHASE_GAP,
    RECTIFIED,
    OUTLIERS,
    WRAPPED,
    ALTERNATES,
    ENDS,
    LEFT,
    UNLIKE,
    COVERED,
    REST,
    COUNTS,
    FEW_COUNTS,
    SWINGS,
    SCATTER,
    DIFFERS,
    TREND,
    REPEATED,
    COPIED,
    SAMPLES,
    CURVED,
    FEW_CURVED,
    OF_LINE,
    LAGS,
    BENT,
    BY_TURNS,
    PAIRS,
    TWO_SOURCES,
    HOLE,
    BIT,
    TWICE,
    PHASES,
    EARLY,
    RUNS,
    RUN_AWAY,
    TURNS,
    LEAPS,
    BACKWARDS,
    STEPS,
];

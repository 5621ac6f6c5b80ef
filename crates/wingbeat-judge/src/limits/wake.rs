//! Limits of a wake of the vortex lattice. All values are choices.

use super::JudgedLimit;
use crate::status::Status::{NotPeriodic, NotResolved, Outside};

/// A symmetric motion whose halves drift apart.
pub const DRIFTED: JudgedLimit = JudgedLimit::warn_above("wake.symmetry_fraction", 0.01, "").on(
    "left and right of a symmetric motion drift apart, the free wake is not resolved where it meets the wing or itself \
     (do the halves overlap? else try --prescribed, a larger --core or more --steps): largest difference of a ring and its mirror image over the largest ring",
);
/// Halves that have nothing to do with each other any more.
pub const LOST: JudgedLimit = JudgedLimit::at_most("wake.symmetry_lost_fraction", 0.5, "", NotResolved)
    .on("largest difference of a ring and its mirror image over the largest ring");
/// The sum of all circulations, which Kelvin's theorem keeps at zero: rounding leaves 1e-12.
pub const KELVIN: JudgedLimit = JudgedLimit::at_most("wake.circulation_error", 1e-6, "", NotResolved)
    .on("sum of all circulations over the largest one");
/// Of the cases `flap_f2` and `flap_fold` a single panel along the chord changes the mean drag by Bernoulli by three tenths, and the lift by
/// Joukowski by 6 and 11 %.
pub const ALONG: JudgedLimit = JudgedLimit::at_least("wake.panels_along_chord", 2.0, "", NotResolved)
    .on("number of panels along the chord");
/// One panel across halves the loads of `flap_f2`, four change their root mean square by 8 % (of 8 x 32 panels).
pub const ACROSS: JudgedLimit = JudgedLimit::at_least("wake.panels_along_span", 4.0, "", NotResolved)
    .on("number of panels along the span");
/// Of `flap_f2` and `flap_fold` under a prescribed wake the mean lift by Joukowski is that of 12 panels along the chord less 3 and 5 % with 2, 1.5 and
/// 1.8 % with 4, 0.9 and 1.0 % with 6; the mean drag, either way, less 1.5 to 2.2 %, 1.1 to 1.7 %, 0.7 to 1.0 %.
pub const FEW_ALONG: JudgedLimit = JudgedLimit::warn_below("wake.few_panels_along_chord", 4.0, "").on(
    "few panels (with 2 the mean lift of a wing that folds errs by 5 %): number of panels along the chord",
);
/// Likewise the mean lift is that of 32 panels across and 4 to 14 % with 4, 3 to 15 % with 5, 2 to 6 % with 6 and 7, 1 to 2 % with 8; the drag
/// by Bernoulli 6 to 20 % with 5, 3 % with 8.
pub const FEW_ACROSS: JudgedLimit = JudgedLimit::warn_below("wake.few_panels_along_span", 8.0, "")
    .on("few panels (lift of a flat wing errs by up to 15 % with 5, by 2 % with 8): number of panels along the span");
/// Of robots in flight, whose wings fold and twist, the weight carried over the first 0.4 s falls with the panels across: `cruise_20g` 0.92, 0.87, 0.82,
/// 0.795 with 12, 16, 24, 36, `soft_20g` 1.03, 0.75, 0.66 with 12, 16, 20, and from 24 to 36 over 0.6 s 0.559 to 0.548. *Choice.*
pub const FEW_OF_FLIGHT: JudgedLimit = JudgedLimit::warn_below("wake.few_panels_in_flight", 24.0, "").on(
    "few panels for wings that fold or twist, of which lift errs most (compare two numbers of them): number of panels along the span",
);
/// Wings feel narrow ones near the trailing edge whatever this is: of `flap_f2` under a prescribed wake one of a chord changes the mean drag by
/// 0.1 %. What is smeared is a wake that rolls up, or that wings meet again. *Choice.*
pub const CORE: JudgedLimit = JudgedLimit::warn_above("wake.core_fraction", 0.2, "").on(
    "vortices of the wake are smeared over a large part of the wing: radius of their cores over the mean chord",
);
/// Trailing edges that the air crosses inward: no Kutta condition holds there, and the wake that they shed passes through the wing. *Choice.*
pub const INFLOW: JudgedLimit = JudgedLimit::warn_above("wake.inflow_fraction", 0.01, "").on(
    "the air flows in over trailing edges, whose wake passes through the wing: loads need cores of a sixth of a panel's chord and more \
     (compare two sizes): share of trailing edges and steps",
);
/// Both ways to the force differ by 0.03 to 0.2 where the lattice is resolved (narrow wings have suction at their side edges), and by 1 and
/// more where thin cores meet bound vortices. *Choice.*
pub const APART: JudgedLimit = JudgedLimit::at_most("wake.force_apart_fraction", 0.5, "", NotResolved).on(
    "difference of the forces by Joukowski and by Bernoulli in the last cycle, root mean square, over that of the latter",
);

/// As [`tether.advance_ratio`](super::tether::ADVANCE), of prescribed wakes: of `flap_f2` in slow winds they differ from free ones by 2 % of the mean
/// drag at 0.21, 8 % at 0.12, 22 % at 0.06. *Choice.*
pub const STAYS: JudgedLimit = JudgedLimit::at_least("wake.prescribed_advance_ratio", 0.1, "", Outside).on(
    "a prescribed wake moves with the wind alone and stays where the wing comes by again (leave out `--prescribed`): way of the wind in a cycle over that of the tips",
);
/// Vortices that have left a leading edge and come near to others or to the wing in long steps.
pub const RUNS: JudgedLimit = JudgedLimit::warn_above("wake.sheet_way_chords", 0.5, "mean chords").on(
    "the sheets of the leading edges are coarse: largest way in a step of a vortex that has left one (try more --steps)",
);
/// Vortices that fly off.
pub const RUN_AWAY: JudgedLimit =
    JudgedLimit::at_most("wake.sheet_lost_chords", 5.0, "mean chords", NotResolved)
        .on("largest way in a step of a vortex that has left a leading edge");
/// Leading edges that were told to shed and bear all of their suction: the run is that of attached flow.
pub const SHEDS: JudgedLimit = JudgedLimit::warn_below("wake.shedding_fraction", 1e-6, "").on(
    "no leading edge sheds, as in attached flow (the critical suction is never reached): share of strips and instants of the last \
     cycle that shed",
);

/// Steps of a motion that repeats. On `flap_f2` with 3 x 12 panels the mean lift of 12, 16 and 24 steps is 3.2, 1.8 and 0.9 % above that
/// of 64; of 8 and of 4 steps, 5 and 11 %.
pub const STEPS: JudgedLimit =
    JudgedLimit::at_least("wake.steps_per_cycle", 12.0, "", NotResolved).on("number of steps of a cycle");
/// The same where the lift is within a few per cent.
pub const FEW_STEPS: JudgedLimit =
    JudgedLimit::warn_below("wake.few_steps_per_cycle", 24.0, "").on("number of steps of a cycle");
/// Steps of a motion that does not repeat, or of a wing at rest, from its start on. *Choice.*
pub const STEPS_IN_ALL: JudgedLimit =
    JudgedLimit::at_least("wake.steps", 12.0, "", NotResolved).on("number of steps from rest on");
/// A wing at rest, of which the flow from rest on is told. *Choice.*
pub const STARTED: JudgedLimit = JudgedLimit::warn_above("wake.started_fraction", 0.1, "").on(
    "the means are of a flow that starts (for a steady one take more time.cycles): change of the mean circulation within the last cycle, over it",
);
/// Ten times what the shipped cases reach in three cycles from rest; the free wake of `aerobat_stand`, which does not converge, has 0.02. *Choice.*
pub const CYCLES: JudgedLimit = JudgedLimit::at_most("wake.cycle_change_fraction", 0.05, "", NotPeriodic)
    .on("change of the mean force from the last cycle but one, over its root mean square,");

/// All of them.
pub const ALL: [JudgedLimit; 20] = [
    DRIFTED,
    LOST,
    KELVIN,
    ALONG,
    ACROSS,
    FEW_ALONG,
    FEW_ACROSS,
    FEW_OF_FLIGHT,
    CORE,
    INFLOW,
    APART,
    STAYS,
    RUNS,
    RUN_AWAY,
    SHEDS,
    STEPS,
    FEW_STEPS,
    STEPS_IN_ALL,
    STARTED,
    CYCLES,
];

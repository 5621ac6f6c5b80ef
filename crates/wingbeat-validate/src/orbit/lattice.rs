//! The shipped orbits replayed: by the law that found them, by law `linear` without profile drag, and by the vortex lattice, which is
//! attached and without friction too. What it and `linear` differ by the lifting line misses; what `linear` and the shipped law differ
//! by do stall and drag.

use std::ops::ControlFlow;

use wingbeat::aero::LiftLaw;
use wingbeat::math::interpolation::piecewise_linear;
use wingbeat::parallel;
use wingbeat::scenario::ScenarioSpec;

use super::replay::{CycleMeans, InstantLoads, LatticeFineness, OrbitMotion, extrapolated};
use crate::shipped::Shipped;
use crate::{CaseWatch, ComparisonRow, Error};

/// Level flights whose motion is replayed, the first drawn.
const REPLAYED: [Shipped; 8] = [
    "cruise_20g",
    "cruise_44g",
    "cruise_20g_margin",
    "passive_20g",
    "passive_20g_margin",
    "cruise_beta",
    "cruise_linkage",
    "passive_linkage",
];

/// What the rows are extrapolated from, on the wing of the strips that found the orbits. Their number in each strip and their cores are choices.
const COARSE: LatticeFineness = LatticeFineness { chordwise: 8, strips: 9, parts: 4, core: 0.08 };
const FINE: LatticeFineness = LatticeFineness { chordwise: 12, ..COARSE };
/// What narrower strips, half and twice the cores are worth, beside the coarse lattice.
const OTHERS: [LatticeFineness; 3] = [
    LatticeFineness { parts: 6, ..COARSE },
    LatticeFineness { core: 0.04, ..COARSE },
    LatticeFineness { core: 0.16, ..COARSE },
];
/// On the wing of 24 strips, where a hinge that twists is closed within a third of the width.
const MANY: LatticeFineness = LatticeFineness { strips: 24, parts: 2, ..FINE };

/// A cycle extrapolated from the coarse and the fine lattice.
fn endless(coarse: &[InstantLoads], fine: &[InstantLoads]) -> Vec<InstantLoads> {
    extrapolated(coarse, fine, COARSE.chordwise as f64 / FINE.chordwise as f64)
}

/// Share of the strokes at which the flow is attached.
const GENTLE: f64 = 0.15;

/// Largest error of the mean lift of a replay by the law that found the orbit, over the weight.
const OWN: f64 = 1e-4;

/// Law `linear`, no profile drag.
fn attached(spec: &mut ScenarioSpec) {
    spec.aero.law = LiftLaw::Linear;
    for surface in &mut spec.robot.surfaces {
        (surface.cd0, surface.cd90) = (0.0, Some(0.0));
    }
}

/// The same with 24 strips.
fn finely(spec: &mut ScenarioSpec) {
    attached(spec);
    spec.aero.full.strips = 24;
}

/// What is found of an orbit by strips: the means by the law that found it, cycles by [`LINEAR`].
struct StripCycles {
    motion: OrbitMotion,
    own: CycleMeans,
    linear: [Vec<InstantLoads>; LINEAR.len()],
}

impl StripCycles {
    fn of(shipped: &Shipped) -> Result<Self, Error> {
        let motion = OrbitMotion::of(shipped)?;
        let own = CycleMeans::of(&motion.strips(&motion.driven(|_| ())?)?);
        let mut linear: [Vec<InstantLoads>; LINEAR.len()] = Default::default();
        for (cycle, change) in linear.iter_mut().zip(LINEAR) {
            *cycle = motion.strips(&motion.driven(change)?)?;
        }
        Ok(Self { motion, own, linear })
    }

    fn all() -> Result<Vec<Self>, Error> {
        parallel::map(&REPLAYED, |_, shipped| Self::of(shipped)).into_iter().collect()
    }
}

/// With the impulse of the circulation turning in place of edges' suction.
fn turned(spec: &mut ScenarioSpec) {
    attached(spec);
    spec.aero.full.turning_impulse = Some(true);
}

/// With neither.
fn neither(spec: &mut ScenarioSpec) {
    attached(spec);
    (spec.aero.full.edge_suction, spec.aero.full.turning_impulse) = (Some(false), Some(false));
}

/// Law `linear`, with the impulse of the circulation turning in place of edges' suction, and with neither; the same with 24 strips.
const LINEAR: [fn(&mut ScenarioSpec); 6] = [
    attached,
    turned,
    neither,
    finely,
    |spec| {
        finely(spec);
        turned(spec);
    },
    |spec| {
        finely(spec);
        neither(spec);
    },
];

/// What a replay by strips changes: name, words, change.
type ReplayChange = (&'static str, &'static str, fn(&mut ScenarioSpec));

/// What spanwise forces are worth.
const FINELY: [ReplayChange; 2] = [
    ("linear_24", "the same, 24 strips", finely),
    ("neither", "the same, 24 strips without edges' suction along the span", |spec| {
        finely(spec);
        neither(spec);
    }),
];

const CHANGES: [ReplayChange; 5] = [
    ("linear", "law linear without profile drag", attached),
    FINELY[0],
    FINELY[1],
    ("lev", "law lev", |spec| spec.aero.law = LiftLaw::Lev),
    ("strips_24", "24 strips", |spec| spec.aero.full.strips = 24),
];

/// The comparisons by strips.
pub(super) fn own() -> Result<Vec<ComparisonRow>, Error> {
    parallel::map(&REPLAYED, |_, shipped| by_strips(shipped))
        .into_iter()
        .collect::<Result<Vec<_>, _>>()
        .map(|rows| rows.concat())
}

fn by_strips(shipped: &Shipped) -> Result<Vec<ComparisonRow>, Error> {
    let motion = OrbitMotion::of(shipped)?;
    let replayed = |change: fn(&mut ScenarioSpec)| -> Result<CycleMeans, Error> {
        Ok(CycleMeans::of(&motion.strips(&motion.driven(change)?)?))
    };
    let own = replayed(|_| ())?;
    let id = format!("trim.replay.{}", motion.name());
    let metric = "lift of wings and body over weight less 1, the motion prescribed, twists driven as the air moves them";
    let off = (own.up + own.body_up - 1.0).abs();
    let mut rows = vec![ComparisonRow::judged(&format!("{id}.own"), "the orbit", metric, off, OWN, "")];
    for (end, words, change) in CHANGES {
        let other = replayed(change)?;
        let metric = format!(
            "{words} less the orbit's own model in its motion: lift of the wings over weight {:.3} less {:.3}; forward force {:.3}, {:.3}; power against \
             the air {:.1}, {:.1} W/kg",
            other.up, own.up, other.forward, own.forward, other.power, own.power
        );
        rows.push(ComparisonRow::shown(&format!("{id}.{end}"), "own models", &metric, other.up - own.up, ""));
    }
    Ok(rows)
}

/// A cycle of the first orbit by strips and by the lattice, with their names.
pub(crate) fn cycles() -> Result<[(&'static str, Vec<InstantLoads>); 4], Error> {
    let motion = OrbitMotion::of(REPLAYED[0])?;
    let [_, lattice] = motion.lattice(COARSE)?;
    Ok([
        ("full, law stall", motion.strips(&motion.driven(|_| ())?)?),
        ("full, law linear, no profile drag", motion.strips(&motion.driven(attached)?)?),
        ("the same, turning_impulse = true", motion.strips(&motion.driven(turned)?)?),
        ("vortex lattice", lattice),
    ])
}

/// Rms difference of the lift of a cycle by the lattice from that by `strips` over its rms.
fn lift_apart(lattice: &[InstantLoads], strips: &[InstantLoads]) -> f64 {
    let phases: Vec<f64> = (0..=strips.len()).map(|k| k as f64 / strips.len() as f64).collect();
    // The cycle closes.
    let lift: Vec<f64> = strips.iter().chain(&strips[..1]).map(|instant| instant.up).collect();
    let (mut apart, mut all) = (0.0, 0.0);
    for (k, instant) in lattice.iter().enumerate() {
        let of_strips = piecewise_linear(&phases, &lift, k as f64 / lattice.len() as f64);
        apart += (of_strips - instant.up).powi(2);
        all += instant.up.powi(2);
    }
    (apart / all).sqrt()
}

/// The comparisons with the lattice; none where they were ended.
pub(super) fn rows(watch: &mut CaseWatch<'_>) -> Result<Vec<ComparisonRow>, Error> {
    let strips = StripCycles::all()?;
    let finenesses: Vec<LatticeFineness> = [&[COARSE, FINE][..], &OTHERS, &[MANY]].concat();
    let mut crossing = Vec::new();
    for found in &strips {
        crossing.push(found.motion.passes_through_itself()?);
    }
    let clear = |orbit: &usize| crossing[*orbit] == 0.0;
    let each = |orbit: usize| finenesses.iter().map(move |fineness| (orbit, *fineness));
    let jobs: Vec<(usize, LatticeFineness)> = (0..strips.len()).filter(clear).flat_map(each).collect();
    let mut found: Vec<Option<LatticeCycles>> = vec![None; jobs.len()];
    let (mut done, mut failed) = (0, None);
    if watch(0, jobs.len()).is_break() {
        return Ok(Vec::new());
    }
    parallel::each(
        &jobs,
        |_, (orbit, fineness)| strips[*orbit].motion.lattice(*fineness),
        |job, cycles| match cycles {
            Ok(cycles) => {
                found[job] = Some(cycles);
                done += 1;
                watch(done, jobs.len())
            }
            Err(error) => {
                failed = Some(error);
                ControlFlow::Break(())
            }
        },
    );
    if let Some(error) = failed {
        return Err(error);
    }
    let Some(found) = found.into_iter().collect::<Option<Vec<LatticeCycles>>>() else {
        return Ok(Vec::new());
    };
    let mut by_orbit = found.chunks(finenesses.len());
    let mut rows = Vec::new();
    for (orbit, strips) in strips.iter().enumerate() {
        let id = format!("trim.lattice.{}", strips.motion.name());
        if !clear(&orbit) {
            let metric = "share of the cycle in which the wing beyond the elbow passes through the arm: it has no lattice";
            rows.push(ComparisonRow::shown(
                &format!("{id}.through_itself"),
                "rigid panels",
                metric,
                crossing[orbit],
                "",
            ));
            continue;
        }
        rows.extend(by_orbit.next().into_iter().flat_map(|found| beside(&id, strips, found)));
    }
    rows.extend(gentle()?);
    Ok(rows)
}

/// The last two cycles of an orbit in a lattice.
type LatticeCycles = [Vec<InstantLoads>; 2];

/// How the lift of the first orbit differs over the cycle with gentle strokes.
fn gentle() -> Result<Vec<ComparisonRow>, Error> {
    let motion = OrbitMotion::of(REPLAYED[0])?.gentler(GENTLE)?;
    let ([_, coarse], [_, fine]) = (motion.lattice(COARSE)?, motion.lattice(FINE)?);
    let lattice = endless(&coarse, &fine);
    let mut linear = Vec::new();
    for change in &LINEAR[..3] {
        linear.push(motion.strips(&motion.driven(change)?)?);
    }
    Ok(over_the_cycle(
        "trim.lattice.gentle",
        "cruise_20g, strokes of the joints times .15",
        &lattice,
        &fine,
        &linear,
    ))
}

/// How the lift differs over the cycle from that by `linear`, by the first three of [`LINEAR`].
fn over_the_cycle(
    id: &str,
    what: &str,
    lattice: &[InstantLoads],
    fine: &[InstantLoads],
    linear: &[Vec<InstantLoads>],
) -> Vec<ComparisonRow> {
    let ends = [
        ("over_the_cycle", ""),
        ("over_the_cycle.turned", ", the impulse of the circulation turning in place of edges' suction"),
        ("over_the_cycle.neither", " and edges' suction along the span"),
    ];
    let row = |((end, changed), strips): (&(&str, &str), &Vec<InstantLoads>)| {
        let metric = format!(
            "{what}, law linear without profile drag{changed}: rms difference of the lift from that of the lattice for endless panels over its \
             rms; that of 12 panels along the chord {:.3}",
            lift_apart(lattice, fine)
        );
        let apart = lift_apart(lattice, strips);
        ComparisonRow::shown(&format!("{id}.{end}"), "own vortex lattice", &metric, apart, "")
    };
    ends.iter().zip(linear).map(row).collect()
}

/// What of the means is compared: end of the row's name, words, unit, value.
type ComparedMean = (&'static str, &'static str, &'static str, fn(&CycleMeans) -> f64);

const COMPARED: [ComparedMean; 3] = [
    ("lift", "mean lift of the wings over the weight", "", |means| means.up),
    ("forward", "their mean forward force over the weight", "", |means| means.forward),
    ("power", "mean of the positive part of the power of the joints against the air", "W/kg", |means| {
        means.power
    }),
];

/// The rows of an orbit: the lattice for endless panels less law `linear`. `found` are the last two cycles at every fineness.
fn beside(
    id: &str,
    StripCycles { own, linear, .. }: &StripCycles,
    found: &[LatticeCycles],
) -> Vec<ComparisonRow> {
    let means: Vec<CycleMeans> = found.iter().map(|[_, last]| CycleMeans::of(last)).collect();
    let before = CycleMeans::of(&found[0][0]);
    let lattice = endless(&found[0][1], &found[1][1]);
    let endless = CycleMeans::of(&lattice);
    let strips = linear.each_ref().map(|cycle| CycleMeans::of(cycle));
    let mut rows = Vec::new();
    for (end, words, unit, of) in COMPARED {
        let [coarse, fine, narrow, thin, thick, many] = std::array::from_fn(|at| of(&means[at]));
        let by_strips = strips.each_ref().map(of);
        let sure = of(&endless);
        let moves = [narrow, thin, thick].iter().fold((sure - fine).abs(), |m, v| m.max((v - coarse).abs()));
        let laws = [
            ("", ""),
            (".turned", ", the impulse of the circulation turning in place of edges' suction"),
            (".neither", " and edges' suction along the span"),
        ];
        for (at, (suffix, changed)) in laws.into_iter().enumerate() {
            let value = by_strips[at];
            let apart = sure - value;
            let resolved = if moves > apart.abs() { "; not resolved" } else { "" };
            let metric = format!(
                "{words}, lattice less law linear without profile drag{changed}: {sure:.3} from {coarse:.3} and {fine:.3} with 8 and 12 panels \
                 along the chord, +-{moves:.3} (6 in place of 4 in each strip {narrow:.3}, cores of half and twice the size {thin:.3} and \
                 {thick:.3}) less {value:.3}; on the wing of 24 strips {many:.3} less {:.3}; law of the orbit {:.3}; {:+.1e} since the cycle \
                 before{resolved}",
                by_strips[at + laws.len()],
                of(own),
                coarse - of(&before),
            );
            rows.push(ComparisonRow::shown(
                &format!("{id}.{end}{suffix}"),
                "own vortex lattice",
                &metric,
                apart,
                unit,
            ));
        }
    }
    rows.extend(over_the_cycle(id, "the orbit", &lattice, &found[1][1], &linear[..3]));
    rows
}

//! The shipped orbits replayed: by the law that found them, by law `linear` without profile drag, and by the vortex lattice, which is
//! attached and without friction too. What it and `linear` differ by the lifting line misses; what `linear` and the shipped law differ
//! by do stall and drag.

use std::ops::ControlFlow;

use wingbeat::aero::LiftLaw;
use wingbeat::math::interpolation::piecewise_linear;
use wingbeat::parallel;
use wingbeat::scenario::ScenarioSpec;

use super::replay::{CycleMeans, InstantLoads, LatticeFineness, OrbitMotion, Twisted};
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

/// What the rows compare, and what its panels, steps and cores are worth.
const FINE: LatticeFineness =
    LatticeFineness { chordwise: 8, spanwise: 40, core: 0.02, twisted: Twisted::Joined(0.0) };
const OTHERS: [LatticeFineness; 3] = [
    LatticeFineness { chordwise: 4, ..FINE },
    LatticeFineness { spanwise: 24, ..FINE },
    LatticeFineness { core: 0.05, ..FINE },
];
/// Other wings than that of the strips, which know no slit: joined over 20 and 40 mm, and not at all.
const WINGS: [LatticeFineness; 3] = [
    LatticeFineness { twisted: Twisted::Joined(0.02), ..FINE },
    LatticeFineness { twisted: Twisted::Joined(0.04), ..FINE },
    LatticeFineness { twisted: Twisted::Slit, ..FINE },
];

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

/// What is found of an orbit by strips: the law that found it, `linear`.
struct StripMeans {
    motion: OrbitMotion,
    own: CycleMeans,
    linear: CycleMeans,
}

impl StripMeans {
    fn of(shipped: &Shipped) -> Result<Self, Error> {
        let motion = OrbitMotion::of(shipped)?;
        let means = |cycle: Vec<InstantLoads>| CycleMeans::of(&cycle);
        let own = means(motion.strips(&motion.driven(|_| ())?)?);
        let linear = means(motion.strips(&motion.driven(attached)?)?);
        Ok(Self { motion, own, linear })
    }

    fn all() -> Result<Vec<Self>, Error> {
        parallel::map(&REPLAYED, |_, shipped| Self::of(shipped)).into_iter().collect()
    }
}

/// What a replay by strips changes: name, words, change.
type ReplayChange = (&'static str, &'static str, fn(&mut ScenarioSpec));

/// What spanwise forces are worth.
const FINELY: [ReplayChange; 2] = [
    ("linear_24", "the same, 24 strips", finely),
    ("unturned", "the same, 24 strips without the impulse of the circulation turning", |spec| {
        finely(spec);
        spec.aero.full.turning_impulse = false;
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

/// A cycle of the first orbit by strips under both laws and by the lattice, with their names.
pub(crate) fn cycles() -> Result<[(&'static str, Vec<InstantLoads>); 3], Error> {
    let motion = OrbitMotion::of(REPLAYED[0])?;
    let [_, lattice] = motion.lattice(FINE)?;
    Ok([
        ("full, law stall", motion.strips(&motion.driven(|_| ())?)?),
        ("full, law linear, no profile drag", motion.strips(&motion.driven(attached)?)?),
        ("vortex lattice", lattice),
    ])
}

/// Rms differences of the lift by the lattice from that by strips changed by `changes`, over its rms, of the first orbit with its strokes
/// times `share`.
fn apart(share: f64, changes: &[ReplayChange]) -> Result<Vec<f64>, Error> {
    let motion = OrbitMotion::of(REPLAYED[0])?.gentler(share)?;
    let [_, lattice] = motion.lattice(FINE)?;
    let of = |(.., change): &ReplayChange| Ok(lift_apart(&lattice, &motion.strips(&motion.driven(change)?)?));
    changes.iter().map(of).collect()
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
    let strips = StripMeans::all()?;
    let finenesses: Vec<LatticeFineness> = [&[FINE][..], &OTHERS, &WINGS].concat();
    let mut crossing = Vec::new();
    for found in &strips {
        crossing.push(found.motion.passes_through_itself()?);
    }
    let clear = |orbit: &usize| crossing[*orbit] == 0.0;
    let each = |orbit: usize| finenesses.iter().map(move |fineness| (orbit, *fineness));
    let jobs: Vec<(usize, LatticeFineness)> = (0..strips.len()).filter(clear).flat_map(each).collect();
    let mut found: Vec<Option<[CycleMeans; 2]>> = vec![None; jobs.len()];
    let (mut done, mut failed) = (0, None);
    if watch(0, jobs.len()).is_break() {
        return Ok(Vec::new());
    }
    parallel::each(
        &jobs,
        |_, (orbit, fineness)| strips[*orbit].motion.lattice(*fineness),
        |job, cycles| match cycles {
            Ok(cycles) => {
                found[job] = Some(cycles.map(|cycle| CycleMeans::of(&cycle)));
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
    let Some(found) = found.into_iter().collect::<Option<Vec<[CycleMeans; 2]>>>() else {
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
    rows.extend(over_the_cycle()?);
    Ok(rows)
}

/// How the lift of the first orbit differs over the cycle.
fn over_the_cycle() -> Result<Vec<ComparisonRow>, Error> {
    let strokes = [("whole", "as it is", 1.0), ("gentle", "strokes of the joints times .15", GENTLE)];
    let changes = [&CHANGES[..1], &FINELY[..]].concat();
    let apart = parallel::map(&strokes, |_, (.., share)| apart(*share, &changes));
    let mut rows = Vec::new();
    for ((stroke, words, _), apart) in strokes.iter().zip(apart) {
        for ((end, changed, _), apart) in changes.iter().zip(apart?) {
            let id = match *end {
                "linear" => format!("trim.lattice.{stroke}"),
                end => format!("trim.lattice.{stroke}.{end}"),
            };
            let metric = format!("cruise_20g, {words}, {changed}: rms difference of the lift over its rms");
            rows.push(ComparisonRow::shown(&id, "own vortex lattice", &metric, apart, ""));
        }
    }
    Ok(rows)
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

/// The rows of an orbit: the lattice less law `linear`. `found` are the last two cycles at every fineness.
fn beside(
    id: &str,
    StripMeans { own, linear, .. }: &StripMeans,
    found: &[[CycleMeans; 2]],
) -> Vec<ComparisonRow> {
    let mut rows = Vec::new();
    for (end, words, unit, of) in COMPARED {
        let last = |at: usize| of(&found[at][1]);
        let same = 1..=OTHERS.len();
        let low = same.clone().map(last).fold(last(0), f64::min);
        let high = same.map(last).fold(last(0), f64::max);
        let [near, wide, slit] = std::array::from_fn(|wing| last(1 + OTHERS.len() + wing));
        let metric = format!(
            "{words}, lattice less law linear without profile drag: {:.3} ({low:.3} to {high:.3} by panels, steps, cores; wings joined over 20 and \
             40 mm {near:.3} and {wide:.3}, slit {slit:.3}) less {:.3}; law of the orbit {:.3}; {:+.1e} since the cycle before",
            last(0),
            of(linear),
            of(own),
            last(0) - of(&found[0][0]),
        );
        let value = last(0) - of(linear);
        rows.push(ComparisonRow::shown(&format!("{id}.{end}"), "own vortex lattice", &metric, value, unit));
    }
    rows
}

//! Mean force of the carried air over a cycle: a rate of an impulse, it vanishes.

use super::flapping::last_cycle;
use crate::lattice::flapping::{self as flapping_lattice, CORE, FoldedLift};
use crate::{ComparisonRow, Error};
use std::path::Path;
use wingbeat::aero::LiftLaw;
use wingbeat::math::Vec3;
use wingbeat::scenario::{ConfigError, Document, TetherCase};
use wingbeat::simulate::Record;
use wingbeat_lattice::WakeMotion;
use wingbeat_lattice::course::CourseRequest;

macro_rules! shipped {
    ($name:literal) => {
        ($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../cases/", $name, ".toml")))
    };
}

/// Name and text of the cases whose wings fold, and of Aerobat's on its stand.
const FOLDING: [(&str, &str); 2] = [shipped!("flap_f2"), shipped!("flap_fold")];
const STAND: (&str, &str) = shipped!("aerobat_stand");

fn no_tables(path: &Path) -> Result<Record, String> {
    Err(format!("{}: no tables here", path.display()))
}

/// Mean added-mass force and mean lift, N, in the last cycle of a case under `law`, with the keys `set`.
fn means((name, text): (&str, &str), law: LiftLaw, set: &[&str]) -> Result<(Vec3, f64), Error> {
    let refused = |e: ConfigError| Error::NoAnswer(e.to_string());
    let document = Document::text(name, text).map_err(refused)?.set(format!("aero.law={}", law.name()));
    let document = set.iter().fold(document, |document, key| document.set(*key));
    let tether = TetherCase::new(document, &no_tables).map_err(refused)?.tether;
    let along = tether.wind * (1.0 / tether.wind.norm());
    let up = Vec3::new(along[2], 0.0, -along[0]);
    let (mut carried, mut lift) = (Vec3::ZERO, 0.0);
    let instants = last_cycle(&tether)?;
    for loads in &instants {
        carried += loads.by_source().added_mass.force;
        lift += loads.wrench.force.dot(up);
    }
    let each = 1.0 / instants.len() as f64;
    Ok((carried * each, lift * each))
}

/// Cycles after which a cycle of the folding cases repeats the one before.
const SETTLED: &str = "time.cycles=6";
/// The same of the stand, whose vortices take longer: what its impulse gains from cycle to cycle is no mean of a periodic force.
const STAND_SETTLED: &str = "time.cycles=12";

/// Amplitudes of E1's shoulder and elbow, deg.
const E1: [f64; 2] = [30.0, 50.0];
/// Those of wings that fold less, and in the downstroke.
const OTHERS: [(&str, [f64; 2]); 2] = [("less", [20.0, 30.0]), ("downstroke", [-30.0, 50.0])];

/// A folding wing whose circulation has an impulse that turns, in place of edges' suction.
const TURNED: &str = "aero.full.turning_impulse=true";

/// One with neither.
const NEITHER: [&str; 2] = ["aero.full.edge_suction=false", "aero.full.turning_impulse=false"];

/// Mean added-mass force over the mean lift in the last cycle of a case under `law`.
fn share(case: (&str, &str), law: LiftLaw) -> Result<f64, Error> {
    let set: &[&str] = if case.0 == STAND.0 { &[STAND_SETTLED] } else { &[SETTLED] };
    means(case, law, set).map(|(carried, lift)| carried.norm() / lift.abs())
}

/// Deep folding: the mean lift of E1 beside that of the lattice, whose wake cores are a choice.
pub fn deep_fold() -> Result<Vec<ComparisonRow>, Error> {
    let (_, lift) = means(FOLDING[1], LiftLaw::Linear, &NEITHER)?;
    let cases = [
        ("prescribed", WakeMotion::Prescribed, CourseRequest::default().core),
        ("prescribed.thin_cores", WakeMotion::Prescribed, CORE),
        ("free", WakeMotion::Free, CORE),
    ];
    let source = "the project's own lattice, 8 x 24 panels a half, 48 steps a cycle";
    let (mut rows, mut found) = (Vec::new(), Vec::new());
    for (name, wake, core) in cases {
        let FoldedLift { joukowski: lattice, bernoulli: without, .. } =
            flapping_lattice::deep_fold(E1, wake, core)?;
        found.push([lattice, without]);
        let metric = format!(
            "E1, mean lift {lift:.4} N without edges' suction along the span over the lattice's with a {} wake of cores of {core} chords ({lattice:.4} N), less 1",
            name.split('.').next().unwrap_or(name)
        );
        let id = format!("aero.full.deep_fold.{name}");
        rows.push(ComparisonRow::shown(&id, source, &metric, (lift / lattice - 1.0).abs(), ""));
    }
    let [_, [fixed, without], [free, _]] = found[..] else { return Ok(rows) };
    rows.extend(turned_rows([free, fixed], source)?);
    let parts = [
        ("side_edges", "suction of the side edges in the lattice with a prescribed wake", fixed - without),
        ("roll_up", "what the roll-up of the wake changes", free - fixed),
    ];
    rows.extend(parts.map(|(name, what, part)| {
        let metric =
            format!("E1, mean lift of the lattice: {what} ({part:.4} N), over that of the prescribed wake");
        ComparisonRow::shown(
            &format!("aero.full.deep_fold.{name}"),
            source,
            &metric,
            (part / fixed).abs(),
            "",
        )
    }));
    Ok(rows)
}

/// E1 with edges' suction and the impulse of the circulation turning, beside the lattice's mean lift with a `free` and a prescribed (`fixed`)
/// wake, N; other folds.
fn turned_rows([free, fixed]: [f64; 2], source: &str) -> Result<Vec<ComparisonRow>, Error> {
    let (_, turned) = means(FOLDING[1], LiftLaw::Linear, &[TURNED])?;
    let id = "aero.full.deep_fold.turned";
    let metric = format!(
        "the first with the impulse of the circulation turning ({turned:.4} N), over the lattice's with a free wake, less 1"
    );
    let error = |lattice: f64| (turned / lattice - 1.0).abs();
    let mut rows = vec![ComparisonRow::judged(id, source, &metric, error(free), 0.1, "")];
    let metric =
        format!("the same over the lattice's with a prescribed wake of cores of {CORE} chords, less 1");
    rows.push(ComparisonRow::shown(&format!("{id}.prescribed"), source, &metric, error(fixed), ""));
    let (_, edges) = means(FOLDING[1], LiftLaw::Linear, &[])?;
    let error = |lattice: f64| (edges / lattice - 1.0).abs();
    let metric = format!(
        "the first with edges' suction, as by default ({edges:.4} N), over the lattice's with a free wake, less 1"
    );
    let id = "aero.full.deep_fold.edges";
    rows.push(ComparisonRow::judged(id, source, &metric, error(free), 0.1, ""));
    let metric = "the same over the lattice's with that prescribed wake, less 1";
    rows.push(ComparisonRow::shown(&format!("{id}.prescribed"), source, metric, error(fixed), ""));
    for (name, angles) in OTHERS {
        rows.extend(other_fold(name, angles, source)?);
    }
    Ok(rows)
}

/// The mean lift of another folding wing less that of the free lattice, over how far the lattice's swings.
fn other_fold(name: &str, [flap, fold]: [f64; 2], source: &str) -> Result<[ComparisonRow; 2], Error> {
    let down = 0.5 * fold;
    let shoulder = format!("wing.hinges[0].angle_deg={{fourier={{sin=[{flap:?}]}}}}");
    let elbow = format!("wing.hinges[1].angle_deg={{fourier={{mean=-{down:?},cos=[-{down:?}]}}}}");
    let lift = |set: &[&str]| Ok::<_, Error>(means(FOLDING[1], LiftLaw::Linear, set)?.1);
    let without = lift(&[&shoulder, &elbow, NEITHER[0], NEITHER[1]])?;
    let (with, edges) = (lift(&[&shoulder, &elbow, TURNED])?, lift(&[&shoulder, &elbow])?);
    let FoldedLift { joukowski, swing, .. } =
        flapping_lattice::deep_fold([flap, fold], WakeMotion::Free, CORE)?;
    let metric = format!(
        "flapping by {flap:.0}, folding by {fold:.0} deg: mean lift {with:.4} N with that impulse, {without:.4} N with neither, less the free lattice's {joukowski:.4} N, over the rms swing of that"
    );
    let of_edges = format!("the same with edges' suction, {edges:.4} N");
    let row = |end: &str, metric: &str, lift: f64| {
        let id = format!("aero.full.deep_fold.{end}.{name}");
        ComparisonRow::shown(&id, source, metric, (lift - joukowski).abs() / swing, "")
    };
    Ok([row("turned", &metric, with), row("edges", &of_edges, edges)])
}

/// The worst law of some cases.
fn worst(cases: &[(&str, &str)]) -> Result<(f64, String), Error> {
    let (mut worst, mut shares) = (0.0_f64, Vec::new());
    for case in cases {
        for law in LiftLaw::ALL {
            let share = share(*case, law)?;
            worst = worst.max(share);
            shares.push(format!("{} {} {:.2} %", case.0, law.name(), 100.0 * share));
        }
    }
    Ok((worst, shares.join(", ")))
}

/// The shipped cases under every law.
pub fn added_mass_lift() -> Result<Vec<ComparisonRow>, Error> {
    let (id, source) = ("aero.full.added_mass_lift", "Kirchhoff 1869: the rate of an impulse");
    let metric = |what: &str| format!("mean added-mass force over mean lift, worst law: {what}");
    let (folding, shares) = worst(&FOLDING)?;
    let (stand, of_stand) = worst(&[STAND])?;
    Ok(vec![
        ComparisonRow::judged(id, source, &metric(&shares), folding, 0.005, ""),
        ComparisonRow::judged(&format!("{id}.stand"), source, &metric(&of_stand), stand, 0.005, ""),
    ])
}

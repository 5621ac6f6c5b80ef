//! Mean force of the carried air over a cycle: a rate of an impulse, it vanishes.

use super::flapping::last_cycle;
use crate::lattice::flapping as flapping_lattice;
use crate::{Error, Row};
use std::path::Path;
use wingbeat::aero::LiftLaw;
use wingbeat::math::Vec3;
use wingbeat::scenario::{ConfigError, Document, TetherCase};
use wingbeat::simulate::Record;
use wingbeat_lattice::WakeMotion;

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

/// Mean added-mass force and mean lift, N, in the last cycle of a case under `law`.
fn means((name, text): (&str, &str), law: LiftLaw) -> Result<(Vec3, f64), Error> {
    let refused = |e: ConfigError| Error::NoAnswer(e.to_string());
    let document = Document::text(name, text).map_err(refused)?.set(format!("aero.law={}", law.name()));
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

/// Mean added-mass force over the mean lift in the last cycle of a case under `law`.
fn share(case: (&str, &str), law: LiftLaw) -> Result<f64, Error> {
    means(case, law).map(|(carried, lift)| carried.norm() / lift.abs())
}

/// Deep folding: the mean lift of E1 beside that of the lattice.
pub fn deep_fold() -> Result<Vec<Row>, Error> {
    let (_, lift) = means(FOLDING[1], LiftLaw::Linear)?;
    let beside =
        |wake: WakeMotion| -> Result<f64, Error> { Ok(lift / flapping_lattice::deep_fold(wake)? - 1.0) };
    let metric = |wake: &str, error: f64| {
        format!(
            "E1, mean lift {lift:.4} N over the lattice's with a {wake} wake ({:.4} N), less 1",
            lift / (1.0 + error)
        )
    };
    let rows = [("prescribed", WakeMotion::Prescribed), ("free", WakeMotion::Free)].map(|(name, wake)| {
        let error = beside(wake)?;
        let source = "the project's own lattice, 8 x 24 panels a half, 96 steps a cycle";
        let id = format!("aero.full.deep_fold.{name}");
        Ok(Row::shown(&id, source, &metric(name, error), error.abs(), ""))
    });
    rows.into_iter().collect()
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
pub fn added_mass_lift() -> Result<Vec<Row>, Error> {
    let (id, source) = ("aero.full.added_mass_lift", "Kirchhoff 1869: the rate of an impulse");
    let metric = |what: &str| format!("mean added-mass force over mean lift, worst law: {what}");
    let (folding, shares) = worst(&FOLDING)?;
    let (stand, of_stand) = worst(&[STAND])?;
    Ok(vec![
        Row::judged(id, source, &metric(&shares), folding, 0.005, ""),
        Row::shown(&format!("{id}.stand"), source, &metric(&of_stand), stand, ""),
    ])
}

//! Aerobat's planform, folded and held, in small motions up to k = 1, against a linear lattice.

use super::ComparedPreset;
use super::lattice::HarmonicLattice;
use super::linear::{Complex, RigidMotion, SmallMotion};
use super::small::{extrapolated, motion_of};
use super::wings::{self, Still};
use crate::{ComparisonRow, Error, reference_table};
use wingbeat::aero::{StripModel, StripSettings};
use wingbeat::tether::TetheredBody;

/// Dihedral of the inner and of the outer panels, degrees.
const FOLDS: [[f64; 2]; 5] = [[0.0, 0.0], [15.0, -45.0], [15.0, -60.0], [30.0, -20.0], [-15.0, -60.0]];
/// Reduced frequencies by the mean chord.
const KS: [f64; 5] = [0.1, 0.25, 0.5, 0.75, 1.0];
/// Strips of the lattice, and of that of the table.
const STATIONS: usize = 32;
const OF_TABLE: usize = 24;
const SOURCE: &str = "linear vortex lattice, 6 and 12 x 32 panels";

/// Plunge, and pitch about four axes.
fn motions(still: &Still) -> Result<Vec<RigidMotion>, Error> {
    ["plunge", "pitch0", "pitch.25", "pitch.5", "pitch.75"]
        .map(|name| motion_of(name, still))
        .into_iter()
        .collect()
}

/// Vertical force of the lattice of so many `stations` per unit of each motion, N, extrapolated from 6 and 12 panels.
fn exact(still: &Still, k: f64, stations: usize) -> Result<Vec<Complex>, Error> {
    let wing = ComparedPreset::Full.model_of(stations, still.wing.planform(), &still.hinges(), 1.0, 1e-6)?;
    let frame = TetheredBody::rest().frame();
    let edge = |arc: &f64| {
        let section = still.wing.section(*arc, &frame, &still.angles);
        [section.le, section.te]
    };
    let between = wing.arcs().windows(2).zip(wing.strip_arcs()).take(stations / 2);
    let fractions: Vec<f64> = between.map(|(ends, arc)| (ends[0] - arc) / (ends[0] - ends[1])).collect();
    let lift = |chordwise: usize| {
        let lattice = HarmonicLattice {
            chordwise,
            edges: wing.arcs().iter().map(edge).collect(),
            fractions: fractions.clone(),
            chord: still.chord,
            omega: 2.0 * k / still.chord,
        };
        lattice.lift(&motions(still)?)
    };
    Ok(extrapolated(&lift(6)?, &lift(12)?))
}

fn error(value: Complex, exact: Complex) -> f64 {
    (value.0 - exact.0).hypot(value.1 - exact.1) / exact.0.hypot(exact.1)
}

/// Worst complex errors of the force of `strips` strips over frequencies, in plunge and of those in pitch.
fn worst(
    preset: ComparedPreset,
    strips: usize,
    still: &Still,
    exact: &[Vec<Complex>],
) -> Result<[f64; 2], Error> {
    let model = preset.model_of(strips, still.wing.planform(), &still.hinges(), 1.0, 1e-6)?;
    let mut worst = [0.0_f64; 2];
    for (m, motion) in motions(still)?.into_iter().enumerate() {
        let small = SmallMotion::new(&model, still, motion);
        let of = &mut worst[usize::from(m > 0)];
        for (k, exact) in KS.iter().zip(exact) {
            let value = small.response(2.0 * k / still.chord)?[0];
            *of = of.max(error(value, exact[m]));
        }
    }
    Ok(worst)
}

/// How much less area `strips` strips have than the outline, as a share.
fn lost_area(strips: usize, still: &Still) -> Result<f64, Error> {
    let planform = still.wing.planform();
    let settings = StripSettings { strips, hinge_arcs_m: still.hinges(), ..StripSettings::default() };
    let model = StripModel::new(planform, settings)?;
    // Strips at even arcs, many enough that their sum is the area to 1e-6.
    let cells = 10_000;
    let step = planform.half_span() / f64::from(cells);
    let half: f64 = (0..cells).map(|i| planform.chord((f64::from(i) + 0.5) * step) * step).sum();
    let of_strips: f64 = model.widths().iter().zip(model.chords()).map(|(width, chord)| width * chord).sum();
    Ok(1.0 - of_strips / (2.0 * half))
}

/// Worst error of the lattice against the table of the flat wing.
fn lattice_error(flat: &Still, exact: &[Vec<Complex>]) -> Result<f64, Error> {
    let table = reference_table!("lifting_surface/other_wings.csv")?;
    let (names, motions, ks) = (table.words("wing")?, table.words("motion")?, table.column("k")?);
    let (re, im) = (table.column("Re_H")?, table.column("Im_H")?);
    let named = ["plunge", "pitch0", "pitch.25", "pitch.5", "pitch.75"];
    let mut worst: f64 = 0.0;
    for i in (0..table.len()).filter(|&i| names[i] == "aerobat_flat") {
        let Some(k) = KS.iter().position(|k| *k == ks[i]) else { continue };
        let Some(m) = named.iter().position(|name| *name == motions[i]) else { continue };
        let (scale, omega) = (0.5 * flat.area, 2.0 * ks[i] / flat.chord);
        let plunge = (-omega * scale * im[i], omega * scale * re[i]);
        let table = if m == 0 { plunge } else { (scale * re[i], scale * im[i]) };
        worst = worst.max(error(exact[k][m], table));
    }
    Ok(worst)
}

/// Vertical force of Aerobat's planform at five folds in plunge and pitch, k <= 1, of 9, 16 and 32 strips.
pub fn folded_aerobat() -> Result<Vec<ComparisonRow>, Error> {
    let wings = FOLDS.map(|[inner, outer]| wings::aerobat_folded(inner, outer));
    let wings = wings.into_iter().collect::<Result<Vec<_>, _>>()?;
    let exact_at = |still: &Still, stations| {
        KS.iter().map(|k| exact(still, *k, stations)).collect::<Result<Vec<_>, _>>()
    };
    let lattice = wings.iter().map(|still| exact_at(still, STATIONS)).collect::<Result<Vec<_>, _>>()?;
    let row = |preset: ComparedPreset, strips: usize, id: &str| -> Result<ComparisonRow, Error> {
        let errors = wings.iter().zip(&lattice).map(|(still, exact)| worst(preset, strips, still, exact));
        let errors = errors.collect::<Result<Vec<_>, _>>()?;
        let said = FOLDS.iter().zip(&errors).map(|([inner, outer], e)| {
            let [plunge, pitch] = e.map(|e| 100.0 * e);
            format!("{inner:+}, {outer:+}: {plunge:.1}, {pitch:.1} %")
        });
        let lags = if preset == ComparedPreset::Full { "" } else { ", five lags" };
        let said = said.collect::<Vec<_>>().join("; ");
        let metric = format!(
            "{strips} strips{lags}: worst complex error of force, plunge and pitch, k <= 1; panels at {said}"
        );
        Ok(ComparisonRow::shown(
            id,
            SOURCE,
            &metric,
            errors.iter().flatten().copied().fold(0.0, f64::max),
            "",
        ))
    };
    let check =
        "Aerobat, flat, k 0.1 to 1: worst error of the lattice, with the 24 strips of the table, against it";
    let id = "aero.full.folded_aerobat";
    Ok(vec![
        row(ComparedPreset::Full, 16, id)?,
        row(ComparedPreset::Full, 9, &format!("{id}.strips_9"))?,
        row(ComparedPreset::Full, 32, &format!("{id}.strips_32"))?,
        row(ComparedPreset::FiveLags, 16, &format!("{id}.five_lags"))?,
        row(ComparedPreset::FiveLags, 32, &format!("{id}.five_lags_32"))?,
        ComparisonRow::shown(
            &format!("{id}.area"),
            "the outline",
            "area of 16 strips, less that of the outline, over it",
            -lost_area(16, &wings[0])?,
            "",
        ),
        ComparisonRow::judged(
            &format!("{id}.lattice"),
            "linear lifting surface (own lattice, Richardson)",
            check,
            lattice_error(&wings[0], &exact_at(&wings[0], OF_TABLE)?)?,
            0.01,
            "",
        ),
    ])
}

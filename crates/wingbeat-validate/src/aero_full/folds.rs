//! Aerobat's planform, folded and held, in small motions up to k = 1, against a linear lattice.

use super::ComparedPreset;
use super::lattice::HarmonicLattice;
use super::linear::{Complex, RigidMotion, SmallMotion};
use super::small::{extrapolated, motion_of};
use super::wings::{self, Still};
use crate::{ComparisonRow, Error, reference_table};
use std::f64::consts::FRAC_PI_2;
use wingbeat::aero::{StripModel, StripSettings};
use wingbeat::tether::TetheredBody;

/// Dihedral of the inner and of the outer panels, degrees.
const FOLDS: [[f64; 2]; 5] = [[0.0, 0.0], [15.0, -45.0], [15.0, -60.0], [30.0, -20.0], [-15.0, -60.0]];
/// Reduced frequencies by the mean chord.
const KS: [f64; 5] = [0.1, 0.25, 0.5, 0.75, 1.0];
/// Strips of one half of the lattice where its arcs are coarsest: what [`HarmonicPanels`] multiplies.
const COARSEST: f64 = 8.0;
const SOURCE: &str = "linear vortex lattice, 8 and 16 panels x 32 strips a half";

/// Panels of a lattice.
#[derive(Clone, Copy)]
struct HarmonicPanels {
    /// Along the chord, of the coarser of both from which it is extrapolated.
    chordwise: usize,
    /// Strips over those of the coarsest lattice.
    spanwise: usize,
}

const REFERENCE: HarmonicPanels = HarmonicPanels { chordwise: 8, spanwise: 4 };
const COARSER: HarmonicPanels = HarmonicPanels { chordwise: 6, spanwise: 3 };

/// Plunge, and pitch about four axes.
const MOTIONS: [&str; 5] = ["plunge", "pitch0", "pitch.25", "pitch.5", "pitch.75"];

fn motions(still: &Still) -> Result<Vec<RigidMotion>, Error> {
    MOTIONS.map(|name| motion_of(name, still)).into_iter().collect()
}

/// Arcs from the left tip to the right one, m: even in the angle whose sine is the arc over the half span, with edges at the hinges;
/// `spanwise` times as many as the coarsest.
fn arcs(still: &Still, spanwise: usize) -> Vec<f64> {
    let half = still.wing.planform().half_span();
    let hinges = still.hinges().into_iter().filter(|arc| *arc > 0.0).map(|arc| (arc / half).asin());
    let borders: Vec<f64> = [0.0].into_iter().chain(hinges).chain([FRAC_PI_2]).collect();
    let mut right = Vec::new();
    for ends in borders.windows(2) {
        let [from, to] = [ends[0], ends[1]];
        let strips = spanwise * ((to - from) / FRAC_PI_2 * COARSEST).round().max(1.0) as usize;
        right.extend((1..=strips).map(|i| half * (from + (to - from) * i as f64 / strips as f64).sin()));
    }
    let left = right.iter().rev().copied();
    left.chain([0.0]).chain(right.iter().map(|arc: &f64| -arc)).collect()
}

/// Vertical force of the lattice per unit of each motion, N, extrapolated in the number of panels along the chord.
fn exact(still: &Still, k: f64, of: HarmonicPanels) -> Result<Vec<Complex>, Error> {
    let frame = TetheredBody::rest().frame();
    let (arcs, half) = (arcs(still, of.spanwise), still.wing.planform().half_span());
    let section = |arc: &f64| {
        let section = still.wing.section(*arc, &frame, &still.angles);
        [section.le, section.te]
    };
    let angle = |arc: f64| (arc / half).min(1.0).asin();
    let fraction = |ends: &[f64]| {
        let control = half * (0.5 * (angle(ends[0]) + angle(ends[1]))).sin();
        (ends[0] - control) / (ends[0] - ends[1])
    };
    let fractions: Vec<f64> = arcs.windows(2).take(arcs.len() / 2).map(fraction).collect();
    let lift = |chordwise: usize| {
        let lattice = HarmonicLattice {
            chordwise,
            edges: arcs.iter().map(section).collect(),
            fractions: fractions.clone(),
            chord: still.chord,
            omega: 2.0 * k / still.chord,
        };
        lattice.lift(&motions(still)?)
    };
    Ok(extrapolated(&lift(of.chordwise)?, &lift(2 * of.chordwise)?))
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

/// Worst error of the table of six wings against the lattice, for the wing `name` at the reduced frequencies `ks`.
fn table_error(name: &str, ks: &[f64], of: HarmonicPanels) -> Result<f64, Error> {
    let still = wings::other(name)?;
    let exact = ks.iter().map(|k| exact(&still, *k, of)).collect::<Result<Vec<_>, _>>()?;
    let table = reference_table!("lifting_surface/other_wings.csv")?;
    let (names, motions, k_of) = (table.words("wing")?, table.words("motion")?, table.column("k")?);
    let (re, im) = (table.column("Re_H")?, table.column("Im_H")?);
    let mut worst: f64 = 0.0;
    for i in (0..table.len()).filter(|&i| names[i] == name) {
        let Some(k) = ks.iter().position(|k| *k == k_of[i]) else { continue };
        let Some(m) = MOTIONS.iter().position(|motion| *motion == motions[i]) else { continue };
        let (scale, omega) = (0.5 * still.area, 2.0 * k_of[i] / still.chord);
        let plunge = (-omega * scale * im[i], omega * scale * re[i]);
        let table = if m == 0 { plunge } else { (scale * re[i], scale * im[i]) };
        worst = worst.max(error(table, exact[k][m]));
    }
    Ok(worst)
}

/// Vertical force of Aerobat's planform at five folds in plunge and pitch, k <= 1, of 9, 16 and 32 strips.
pub fn folded_aerobat() -> Result<Vec<ComparisonRow>, Error> {
    let wings = FOLDS.map(|[inner, outer]| wings::aerobat_folded(inner, outer));
    let wings = wings.into_iter().collect::<Result<Vec<_>, _>>()?;
    let exact_at =
        |still: &Still, of| KS.iter().map(|k| exact(still, *k, of)).collect::<Result<Vec<_>, Error>>();
    let lattice = wings.iter().map(|still| exact_at(still, REFERENCE)).collect::<Result<Vec<_>, _>>()?;
    let coarser = exact_at(&wings[0], COARSER)?;
    let six = ["rect4", "ell4", "tap.4_AR6", "swept30_AR6", "aerobat_flat", "elbow-60_rect6"];
    let tables = six.map(|name| table_error(name, &[0.1, 0.3, 0.5], COARSER));
    let tables = tables.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().fold(0.0, f64::max);
    let both = coarser.iter().flatten().zip(lattice[0].iter().flatten());
    let moved = both.map(|(coarse, fine)| error(*coarse, *fine)).fold(0.0, f64::max);
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
            "the same lattice, 6 and 12 panels x 24 strips a half",
            "Aerobat, flat, k 0.1 to 1: worst error of the coarser lattice against the finer",
            moved,
            0.005,
            "",
        ),
        ComparisonRow::shown(
            &format!("{id}.table"),
            SOURCE,
            "Aerobat, flat, k 0.1 to 1: worst error of the table of six wings, of 12 strips a half",
            table_error("aerobat_flat", &KS, REFERENCE)?,
            "",
        ),
        ComparisonRow::judged(
            &format!("{id}.tables"),
            "the same lattice, 6 and 12 panels x 24 strips a half",
            "all six wings, k 0.1 to 0.5: worst error of that table",
            tables,
            0.01,
            "",
        ),
    ])
}

//! A latex membrane on a frame of four sides, aspect ratio 2, in a wind tunnel.

use crate::aero_full::last_cycle;
use crate::{ComparisonRow, Error, reference_table};
use wingbeat::aero::{
    Aero, CD0, CD90, LiftLaw, MembraneSpec, Planform, PlanformStation, ProfileDrag, SectionSettings,
    StripModel, StripSettings, membrane_height,
};
use wingbeat::math::Vec3;
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Motion, Side, Tether, Wing};

const SOURCE: &str = "Rojratsirikul et al. 2011, measured";
const CHORD: f64 = 0.0688;
const SPAN: f64 = 0.1375;
const DENSITY: f64 = 1.208;
/// Where the fit of the prestrain begins, its first step, and its last.
const START: f64 = 0.002;
const FIRST_STEP: f64 = 0.002;
const LAST_STEP: f64 = 0.0005;
/// Incidences that are judged, degrees.
const JUDGED: std::ops::RangeInclusive<f64> = 4.0..=16.0;

/// Normal force coefficient and largest mean displacement over the chord.
#[derive(Clone, Copy)]
struct MembraneState {
    force: f64,
    height: f64,
}

/// The film as it is fitted, with or without the vortices of the side edges of its frame.
#[derive(Clone, Copy)]
struct LatexFilm {
    /// Strain of the flat membrane along chord and span.
    prestrain: [f64; 2],
    side_edges: bool,
}

/// The wing in a wind of `speed` m/s at the incidence `alpha_deg` with so many strips.
fn wing(speed: f64, alpha_deg: f64, film: LatexFilm, strips: usize) -> Result<MembraneState, Error> {
    let LatexFilm { prestrain, side_edges } = film;
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -CHORD };
    let planform = Planform::new(&[station(0.0), station(0.5 * SPAN)])?;
    let settings = StripSettings {
        strips,
        side_edges,
        regularisation_m_s: 0.004 * speed,
        section: SectionSettings {
            law: LiftLaw::Lev3d,
            drag: ProfileDrag { cd0: CD0.default, cd90: CD90.default },
            density_kg_m3: DENSITY,
            ..Default::default()
        },
        membrane: Some(MembraneSpec {
            thickness_m: 2e-4,
            modulus_pa: 2.2e6,
            density_kg_m3: 1000.0,
            prestrain: prestrain[0],
            prestrain_span: Some(prestrain[1]),
            // Rubber keeps its volume.
            poisson_ratio: 0.5,
            damping_s: 0.01,
            ribs_m: vec![0.5 * SPAN],
        }),
        ..Default::default()
    };
    let alpha = alpha_deg.to_radians();
    let reference = CoefficientScales {
        density_kg_m3: DENSITY,
        speed_m_s: speed,
        area_m2: planform.area(),
        chord_m: CHORD,
    };
    let tether = Tether {
        spar: None,
        ground: None,
        aero: Aero::Strip(StripModel::new(&planform, settings)?),
        motion: Motion { nose_up: Coordinate::Constant(alpha), ..Motion::at_rest() },
        wind: Vec3::new(-speed, 0.0, 0.0),
        side: Side::Both,
        reference,
        clock: Clock { frequency_hz: speed / CHORD / 30.0, cycles: 4, steps_per_cycle: 150 },
        wing: Wing::new(planform, Vec::new())?,
    };
    let scale = 0.5 * DENSITY * speed * speed * reference.area_m2;
    let cycle = last_cycle(&tether)?;
    let count = cycle.len() as f64;
    let mut mean = MembraneState { force: 0.0, height: 0.0 };
    let mut shapes = vec![[0.0; 2]; strips];
    for loads in &cycle {
        let force = loads.wrench.force;
        mean.force += (force[2] * alpha.cos() - force[0] * alpha.sin()) / scale / count;
        for (i, shape) in shapes.iter_mut().enumerate() {
            *shape = [shape[0] + loads.camber[i] / count, shape[1] + loads.camber_forward[i] / count];
        }
    }
    let along = |shape: &[f64; 2]| {
        (0..=40).map(|k| membrane_height(shape[0], shape[1], k as f64 / 40.0)).fold(0.0, f64::max)
    };
    mean.height = shapes.iter().map(along).fold(0.0, f64::max);
    Ok(mean)
}

/// Root of the mean square of the error over that of what was measured: normal force, displacement.
fn errors(speed: f64, film: LatexFilm, counts: impl Fn(f64) -> bool) -> Result<[f64; 2], Error> {
    let table = reference_table!("membrane/latex_ar2.csv")?;
    let (alpha, column) =
        (table.column("alpha_deg")?, |name: &str| table.column(&format!("{name}_{speed}_m_s")));
    let (force, height) = (column("cn")?, column("z")?);
    let mut sums = [[0.0; 2]; 2];
    for i in (0..alpha.len()).filter(|&i| counts(alpha[i])) {
        let state = wing(speed, alpha[i], film, 16)?;
        for (k, (value, measured)) in
            [(state.force, force[i]), (state.height, height[i])].into_iter().enumerate()
        {
            sums[k][0] += (value - measured).powi(2);
            sums[k][1] += measured.powi(2);
        }
    }
    Ok(sums.map(|[error, size]| (error / size).sqrt()))
}

/// Strain of the flat membrane along chord and span, *fitted* at 5 m/s, 4 to 16 deg, as pretension and slack are not reported: the
/// least sum of the squares of both errors among pairs that are not slack, by steps along the axes that are halved.
fn fitted(side_edges: bool) -> Result<LatexFilm, Error> {
    let miss = |prestrain: [f64; 2]| -> Result<f64, Error> {
        Ok(errors(5.0, LatexFilm { prestrain, side_edges }, |alpha| JUDGED.contains(&alpha))?
            .iter()
            .map(|e| e * e)
            .sum())
    };
    let (mut best, mut step) = ([START; 2], FIRST_STEP);
    let mut least = miss(best)?;
    while step >= LAST_STEP {
        let before = least;
        for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let mut tried = best;
            tried[axis] = f64::max(tried[axis] + sign * step, 0.0);
            if tried != best {
                let value = miss(tried)?;
                if value < least {
                    (best, least) = (tried, value);
                }
            }
        }
        if least == before {
            step *= 0.5;
        }
    }
    Ok(LatexFilm { prestrain: best, side_edges })
}

/// The rows.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let judged = |alpha: f64| JUDGED.contains(&alpha);
    let film = fitted(true)?;
    let id = |name: &str| format!("fsi.membrane.latex.{name}");
    let what = "rms error over the rms measured, law lev3d with side_edges, AR 2";
    let [force, height] = errors(10.0, film, judged)?;
    let [fit_force, fit_height] = errors(5.0, film, judged)?;
    let [late_force, late_height] = errors(10.0, film, |alpha| alpha > 16.0)?;
    let without = fitted(false)?;
    let [plain_force, plain_height] = errors(10.0, without, judged)?;
    let base = wing(10.0, 10.0, film, 16)?;
    let fine = wing(10.0, 10.0, film, 32)?;
    let row =
        |name: &str, metric: &str, value: f64| ComparisonRow::shown(&id(name), SOURCE, metric, value, "");
    let held = |name: &str, metric: &str, value: f64| {
        let metric = format!("{metric} at 10 m/s, 4 to 16 deg: {what}");
        ComparisonRow::judged(&id(name), SOURCE, &metric, value, 0.15, "")
    };
    Ok(vec![
        row("prestrain", "prestrain along the chord, fitted at 5 m/s", film.prestrain[0]),
        row("prestrain_span", "prestrain along the span, fitted at 5 m/s", film.prestrain[1]),
        held("force", "normal force", force),
        held("height", "largest displacement", height),
        row("force.fit", "normal force at 5 m/s, where the prestrain is fitted", fit_force),
        row("height.fit", "largest displacement at 5 m/s, where the prestrain is fitted", fit_height),
        row("force.stalled", "normal force at 10 m/s beyond 16 deg", late_force),
        row("height.stalled", "largest displacement at 10 m/s beyond 16 deg", late_height),
        row(
            "force.without",
            "normal force at 10 m/s, 4 to 16 deg, without side_edges, prestrains fitted anew",
            plain_force,
        ),
        row("height.without", "largest displacement, likewise", plain_height),
        row(
            "force.strips",
            "change of the normal force from 16 to 32 strips at 10 deg, over it",
            (fine.force / base.force - 1.0).abs(),
        ),
        row("height.strips", "the same of the displacement", (fine.height / base.height - 1.0).abs()),
    ])
}

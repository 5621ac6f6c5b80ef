//! Pressures on a rigid flapping wing in a wind tunnel: nine taps of Yeo, Atkins & Shyy 2011.

use super::flapping::last_cycle;
use super::{ComparedPreset, STRIPS, SectionLaw};
use crate::{ComparisonRow, Error, ReferenceTable, reference_table};
use std::f64::consts::PI;
use wingbeat::aero::{Aero, Loads, Planform, PlanformStation, SurfaceNumbers};
use wingbeat::math::Vec3;
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Hinge, HingeKind, Motion, Side, Tether, Wing};

const FREQUENCY: f64 = 3.3;
const SPEED: f64 = 2.9;
const DENSITY: f64 = 1.225;
const HALF_SPAN: f64 = 0.213;
/// Chord at the root, from which the taps are counted, m.
const ROOT: f64 = 0.072;
/// One inch of water, Pa.
const INCH_OF_WATER: f64 = 248.84;
/// Instants of the tables in a cycle.
const INSTANTS: usize = 100;
/// Model steps between two of them.
const STRIDE: usize = 2;
/// Harmonics that the measured flap angle is taken with: a choice, those that the publishers' series has above a hundredth
/// of the first. The digitised angle's third and fourth make waves in the lift that the taps do not show.
const HARMONICS: usize = 2;

/// A pressure tap and the area that the experiment gave it.
struct Tap {
    /// Behind the leading edge at the root, m.
    behind: f64,
    /// From the hinge, m.
    span: f64,
    area: f64,
    /// Pressure over the cycle, Pa.
    pressure: Vec<f64>,
}

/// Names, places (behind, span), m, and areas, m2, of the taps of each strip.
const STRIPS_OF_TAPS: [(&str, [[f64; 3]; 3]); 3] = [
    ("blue", [[0.012, 0.036, 0.072 * 0.024], [0.036, 0.036, 0.072 * 0.024], [0.060, 0.036, 0.072 * 0.024]]),
    (
        "orange",
        [[0.01308, 0.107, 0.07 * 0.02112], [0.0342, 0.107, 0.07 * 0.02112], [0.05532, 0.107, 0.07 * 0.02112]],
    ),
    (
        "green",
        [
            [0.01569, 0.1775, 0.071 * 0.015],
            [0.03069, 0.176, 0.06565 * 0.015],
            [0.04569, 0.162825, 0.04165 * 0.015],
        ],
    ),
];

fn taps() -> Result<Vec<Vec<Tap>>, Error> {
    let tables = [
        [
            reference_table!("yeo2011/blue_leading.csv")?,
            reference_table!("yeo2011/blue_middle.csv")?,
            reference_table!("yeo2011/blue_trailing.csv")?,
        ],
        [
            reference_table!("yeo2011/orange_leading.csv")?,
            reference_table!("yeo2011/orange_middle.csv")?,
            reference_table!("yeo2011/orange_trailing.csv")?,
        ],
        [
            reference_table!("yeo2011/green_leading.csv")?,
            reference_table!("yeo2011/green_middle.csv")?,
            reference_table!("yeo2011/green_trailing.csv")?,
        ],
    ];
    let tap = |([behind, span, area], table): (&[f64; 3], &ReferenceTable)| {
        let pressure = table.column_at(1)?.iter().map(|p| p * INCH_OF_WATER).collect();
        Ok(Tap { behind: *behind, span: *span, area: *area, pressure })
    };
    let strip = |((_, places), tables): (&(&str, [[f64; 3]; 3]), &[ReferenceTable; 3])| {
        places.iter().zip(tables).map(tap).collect::<Result<Vec<_>, Error>>()
    };
    STRIPS_OF_TAPS.iter().zip(&tables).map(strip).collect()
}

/// The measured outline: leading edge out, trailing edge back, at some arcs.
fn planform() -> Result<Planform, Error> {
    let table = reference_table!("yeo2011/planform.csv")?;
    let (span, forward) = (table.column_at(0)?, table.column_at(1)?);
    let tip = (0..span.len()).max_by(|&a, &b| span[a].total_cmp(&span[b])).unwrap_or_default();
    let edge = |points: Vec<usize>, arc: f64| {
        let at = points.windows(2).find(|w| span[w[0]] <= arc && arc <= span[w[1]]);
        at.map_or(forward[tip], |w| {
            let (a, b) = (w[0], w[1]);
            forward[a] + (forward[b] - forward[a]) * (arc - span[a]) / (span[b] - span[a]).max(1e-9)
        })
    };
    let station = |arc_m: f64| {
        let leading = 1e-3 * edge((0..=tip).collect(), 1e3 * arc_m) - ROOT;
        let trailing = 1e-3 * edge((tip..span.len()).rev().collect(), 1e3 * arc_m) - ROOT;
        PlanformStation { arc_m, leading_edge_m: leading, trailing_edge_m: trailing.min(leading - 0.002) }
    };
    let arcs = [0.0, 0.04, 0.08, 0.11, 0.14, 0.165, 0.185, 0.2, 0.207, 0.211, HALF_SPAN];
    Ok(Planform::new(&arcs.map(station))?)
}

/// Where the motion comes from.
#[derive(Clone, Copy)]
enum FlappingSource {
    /// The series that the publishers of the digitised data used, rad.
    Published,
    /// The measured angle by its first harmonics.
    Measured(usize),
}

fn flap(flapping: FlappingSource) -> Result<Coordinate, Error> {
    let harmonics = match flapping {
        FlappingSource::Published => {
            return Ok(Coordinate::Fourier {
                frequency_hz: FREQUENCY,
                mean: 0.0354,
                cos: vec![4.10e-5, -0.0322, -8.9e-7, 0.00046],
                sin: vec![0.3793, -1.95e-6, -0.0035, -3.6e-6],
            });
        }
        FlappingSource::Measured(harmonics) => harmonics,
    };
    let table = reference_table!("yeo2011/flap.csv")?;
    let angle: Vec<f64> = table.column_at(1)?.iter().map(|a| a.to_radians()).collect();
    let n = angle.len() as f64;
    let sum = |order: usize, wave: fn(f64) -> f64| -> f64 {
        let phase = |i: usize| 2.0 * PI * (order * i) as f64 / n;
        angle.iter().enumerate().map(|(i, a)| a * wave(phase(i))).sum::<f64>()
    };
    let of = |wave: fn(f64) -> f64| (1..=harmonics).map(|order| 2.0 / n * sum(order, wave)).collect();
    Ok(Coordinate::Fourier {
        frequency_hz: FREQUENCY,
        mean: sum(0, f64::cos) / n,
        cos: of(f64::cos),
        sin: of(f64::sin),
    })
}

/// Lift at the taps of each strip over the cycle, N, both wings: model, measured.
struct StripLift {
    model: Vec<f64>,
    measured: Vec<f64>,
}

fn strips(
    preset: ComparedPreset,
    section: SectionLaw,
    flapping: FlappingSource,
) -> Result<Vec<StripLift>, Error> {
    strips_of(preset, section, flapping, Ok)
}

/// Lift at the taps of each strip over the cycle, N: of the strip model under law `lev` with its numbers as `change` makes
/// them, and measured.
pub fn lifts(change: impl Fn(&mut SurfaceNumbers)) -> Result<Vec<[Vec<f64>; 2]>, Error> {
    let changed = |aero: Aero| {
        let mut numbers = aero.numbers().clone();
        change(&mut numbers);
        Ok(aero.with(&numbers)?)
    };
    let strips =
        strips_of(ComparedPreset::Full, SectionLaw::PLATE, FlappingSource::Measured(HARMONICS), changed)?;
    Ok(strips.into_iter().map(|strip| [strip.model, strip.measured]).collect())
}

fn strips_of(
    preset: ComparedPreset,
    section: SectionLaw,
    flapping: FlappingSource,
    change: impl Fn(Aero) -> Result<Aero, Error>,
) -> Result<Vec<StripLift>, Error> {
    let planform = planform()?;
    let aero = change(preset.model_with(section, STRIPS, &planform, &[], DENSITY, 0.02)?)?;
    let flap = flap(flapping)?;
    let hinge = Hinge { kind: HingeKind::Flap, side: Side::Both, arc_m: 0.0, to_arc_m: None, ahead_m: 0.0 };
    let (arcs, widths) = (aero.strip_arcs().to_vec(), aero.widths().to_vec());
    let tether = Tether {
        aero,
        wing: Wing::new(planform.clone(), vec![hinge])?,
        motion: Motion { hinges: vec![("root".into(), flap.clone())], ..Motion::at_rest() },
        wind: Vec3::new(-SPEED, 0.0, 0.0),
        side: Side::Both,
        reference: CoefficientScales {
            density_kg_m3: DENSITY,
            speed_m_s: SPEED,
            area_m2: planform.area(),
            chord_m: ROOT,
        },
        clock: Clock { frequency_hz: FREQUENCY, cycles: 4, steps_per_cycle: STRIDE * INSTANTS },
        spar: None,
        ground: None,
    };
    let cycle = last_cycle(&tether)?;
    let angle = |k: usize| flap.at((k as f64 / INSTANTS as f64) / FREQUENCY).x;
    let place = |tap: &Tap| {
        let chord = planform.chord(tap.span);
        (tap.span, chord, (tap.behind + planform.edges(tap.span).0) / chord)
    };
    let lift = |taps: &Vec<Tap>| {
        let instant = |k: usize| {
            let (sine, cosine) = angle(k).sin_cos();
            let normal = Vec3::new(0.0, -sine, cosine);
            let loads = &cycle[STRIDE * k];
            let model: f64 =
                taps.iter().map(|t| t.area * pressure(loads, [&arcs, &widths], normal, place(t))).sum();
            let measured: f64 = taps.iter().map(|t| t.area * t.pressure[k]).sum();
            (2.0 * cosine * model, 2.0 * cosine * measured)
        };
        let (model, measured) = (0..INSTANTS).map(instant).unzip();
        StripLift { model, measured }
    };
    Ok(taps()?.iter().map(lift).collect())
}

/// Pressure difference at the share `x` of a `chord` (m) at `span` (m) on the left wing: lift spreads as on a flat
/// plate, 2/pi sqrt((1 - x)/x), the carried air's as 8/pi sqrt(x (1 - x)), that of separated flow evenly.
fn pressure(
    loads: &Loads<f64>,
    [arcs, widths]: [&[f64]; 2],
    normal: Vec3,
    (span, chord, x): (f64, f64, f64),
) -> f64 {
    let at = |i: usize| {
        let strip = &loads.strip[i];
        let per_span = |force: Vec3| force.dot(normal) / widths[i];
        let lift = per_span(strip.circulatory.force + strip.induced_drag.force);
        let (carried, plate) = (per_span(strip.added_mass.force), per_span(strip.profile_drag.force));
        2.0 / PI * ((1.0 - x) / x).sqrt() * lift + 8.0 / PI * (x * (1.0 - x)).sqrt() * carried + plate
    };
    // Arcs fall from the left tip to the right one.
    let next = arcs.partition_point(|arc| *arc > span).clamp(1, arcs.len() - 1);
    let share = (arcs[next - 1] - span) / (arcs[next - 1] - arcs[next]);
    ((1.0 - share) * at(next - 1) + share * at(next)) / chord
}

/// Mean |difference| without the means.
fn mean_free_error(model: &[f64], measured: &[f64]) -> f64 {
    let n = model.len() as f64;
    let offset = (model.iter().sum::<f64>() - measured.iter().sum::<f64>()) / n;
    model.iter().zip(measured).map(|(a, b)| (a - b - offset).abs()).sum::<f64>() / n
}

/// What the measured lift is of the model's, by least squares without the means.
fn gain(model: &[f64], measured: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (a, b) = (mean(model), mean(measured));
    let pairs = || model.iter().zip(measured).map(|(x, y)| (x - a, y - b));
    pairs().map(|(x, y)| x * y).sum::<f64>() / pairs().map(|(x, _)| x * x).sum::<f64>()
}

fn sum_of(strips: &[StripLift], of: fn(&StripLift) -> &Vec<f64>) -> Vec<f64> {
    (0..INSTANTS).map(|k| strips.iter().map(|strip| of(strip)[k]).sum()).collect()
}

/// Lift at the taps under law `lev` with the section of a thin plate; under the other laws for comparison.
pub fn yeo() -> Result<Vec<ComparisonRow>, Error> {
    let source = "Yeo, Atkins & Shyy 2011, measured";
    let of_section = |section| strips(ComparedPreset::Full, section, FlappingSource::Measured(HARMONICS));
    let own = of_section(SectionLaw::PLATE)?;
    let (model, measured) = (sum_of(&own, |s| &s.model), sum_of(&own, |s| &s.measured));
    let error = mean_free_error(&model, &measured);
    let gain_error = (gain(&model, &measured) - 1.0).abs();
    let mut rows = vec![
        ComparisonRow::judged(
            "aero.yeo.lift",
            source,
            "mean |error| of lift at nine taps, without means",
            error,
            0.006,
            "N",
        ),
        ComparisonRow::judged(
            "aero.yeo.gain",
            source,
            "|measured over modelled lift - 1|, without means",
            gain_error,
            0.1,
            "",
        ),
    ];
    for ((name, _), strip) in STRIPS_OF_TAPS.iter().zip(&own) {
        let metric = format!("the same at the {name} strip, gain {:.2}", gain(&strip.model, &strip.measured));
        let error = mean_free_error(&strip.model, &strip.measured);
        rows.push(ComparisonRow::shown(&format!("aero.yeo.{name}"), source, &metric, error, "N"));
    }
    let others = [
        ("law_linear", "law linear", SectionLaw::PLATE.linear()),
        ("law_stall", "law stall", SectionLaw::PLATE.stall()),
        (
            "lev_edge_stall",
            "law lev with the static stall of lev3d",
            SectionLaw::PLATE.stalling_with_the_edge(),
        ),
        ("law_lev3d", "law lev3d", SectionLaw::PLATE.lev3d()),
    ];
    for (name, of, section) in others {
        let other = of_section(section)?;
        let model = sum_of(&other, |s| &s.model);
        let metric = format!("the same under {of}, gain {:.2}", gain(&model, &measured));
        let error = mean_free_error(&model, &measured);
        rows.push(ComparisonRow::shown(&format!("aero.yeo.{name}"), source, &metric, error, "N"));
    }
    let flappings = [
        ("published_angle", "the publishers' series of the angle", FlappingSource::Published),
        ("four_harmonics", "four harmonics of the measured angle", FlappingSource::Measured(4)),
    ];
    for (name, of, flapping) in flappings {
        let other = strips(ComparedPreset::Full, SectionLaw::PLATE, flapping)?;
        let model = sum_of(&other, |s| &s.model);
        let metric = format!("the same with {of}, gain {:.2}", gain(&model, &measured));
        let error = mean_free_error(&model, &measured);
        rows.push(ComparisonRow::shown(&format!("aero.yeo.{name}"), source, &metric, error, "N"));
    }
    Ok(rows)
}

//! Mean thrust of small motions: Garrick's closed form for a section, and the linear lifting surface.

use super::flapping::last_cycle;
use super::linear::Complex;
use super::wings::rectangle;
use super::{ComparedPreset, STRIPS};
use crate::{ComparisonRow, Error, reference_table};
use std::f64::consts::PI;
use wingbeat::aero::{Aero, JONES_RATES, JONES_WEIGHTS, LagSet, Planform};
use wingbeat::math::Vec3;
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Motion, Side, Tether, Wing};

/// A wing that heaves and pitches like cosines of one frequency, in a level wind.
pub(super) struct Waving {
    /// Amplitude (m up; rad nose up) and phase (rad) of each.
    pub heave: [f64; 2],
    pub pitch: [f64; 2],
    /// Place of the pitch axis behind the leading edge, m.
    pub axis: f64,
    pub frequency_hz: f64,
    pub speed: f64,
    pub density: f64,
    pub chord: f64,
    pub cycles: usize,
    pub steps_per_cycle: usize,
}

impl Waving {
    /// The wing of that planform, its leading edge on the hinge line.
    pub fn tether(&self, planform: Planform, aero: Aero) -> Result<Tether, Error> {
        let wave = |[amplitude, phase]: [f64; 2]| Coordinate::Fourier {
            frequency_hz: self.frequency_hz,
            mean: 0.0,
            cos: vec![amplitude * phase.cos()],
            sin: vec![-amplitude * phase.sin()],
        };
        Ok(Tether {
            aero,
            motion: Motion {
                heave: wave(self.heave),
                nose_up: wave(self.pitch),
                axis_ahead_m: -self.axis,
                ..Motion::at_rest()
            },
            wind: Vec3::new(-self.speed, 0.0, 0.0),
            side: Side::Both,
            reference: CoefficientScales {
                density_kg_m3: self.density,
                speed_m_s: self.speed,
                area_m2: planform.area(),
                chord_m: self.chord,
            },
            clock: Clock {
                frequency_hz: self.frequency_hz,
                cycles: self.cycles,
                steps_per_cycle: self.steps_per_cycle,
            },
            spar: None,
            ground: None,
            wing: Wing::new(planform, Vec::new())?,
        })
    }
}

/// Mean force forward over the last cycle, N.
pub(super) fn mean_thrust(tether: &Tether) -> Result<f64, Error> {
    let cycle = last_cycle(tether)?;
    Ok(cycle.iter().map(|l| l.wrench.force[0]).sum::<f64>() / cycle.len() as f64)
}

/// Aspect ratio at which a wing is a section.
const SECTION: f64 = 1e4;
const AXES: [f64; 3] = [0.25, 0.5, 0.75];

/// A small motion in chords and radians: complex amplitudes at exp(i omega t).
#[derive(Clone, Copy)]
struct Small {
    heave: Complex,
    pitch: f64,
    /// Pitch axis in chords behind the leading edge.
    axis: f64,
}

/// Semichords of travel after which what a start leaves of the lags is forgotten.
const SETTLED: f64 = 160.0;
/// Amplitude of the motions, in chords and radians: the mean is of second order in it.
const AMPLITUDE: f64 = 0.01;

/// Mean thrust over rho U^2 S by the square of the amplitude, k = omega c/(2 U).
fn thrust(preset: ComparedPreset, aspect: f64, k: f64, small: Small) -> Result<f64, Error> {
    let planform = rectangle(aspect, 1.0)?;
    let model = preset.model_of(STRIPS, &planform, &[], 1.0, 1e-6)?;
    let area = planform.area();
    let polar = |(re, im): Complex| [AMPLITUDE * re.hypot(im), im.atan2(re)];
    let waving = Waving {
        heave: polar(small.heave),
        pitch: [AMPLITUDE * small.pitch, 0.0],
        axis: small.axis,
        frequency_hz: k / PI,
        speed: 1.0,
        density: 1.0,
        chord: 1.0,
        cycles: 2 + (SETTLED * k / (2.0 * PI)).ceil() as usize,
        steps_per_cycle: if k < 0.25 { 192 } else { 96 },
    };
    Ok(mean_thrust(&waving.tether(planform, model)?)? / (area * AMPLITUDE * AMPLITUDE))
}

fn times(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// Garrick's mean thrust and the suction in it, over rho U^2 c per span, with Theodorsen's function `c_k`:
/// S = pi |w_C - b q/2|^2 / 2, T = S - Re(N conj(theta)) / 2, N = pi w_C + pi/4 dw_1/2/dt (unit chord).
///
/// Garrick 1936, NACA Rep. 567.
fn garrick(k: f64, c_k: Complex, small: Small) -> (f64, f64) {
    let rate = (0.0, 2.0 * k);
    let (down, turn) = (times(rate, small.heave), times(rate, (small.pitch, 0.0)));
    // Wash at the chord fraction x: incidence, less the speed up, with the way of the pitching.
    let wash =
        |x: f64| (small.pitch - down.0 + turn.0 * (x - small.axis), turn.1 * (x - small.axis) - down.1);
    let circulatory = times(c_k, wash(0.75));
    let edge = (circulatory.0 - 0.25 * turn.0, circulatory.1 - 0.25 * turn.1);
    let carried = times(rate, wash(0.5)).0 * PI / 4.0;
    let suction = 0.5 * PI * (edge.0 * edge.0 + edge.1 * edge.1);
    (suction - 0.5 * small.pitch * (PI * circulatory.0 + carried), suction)
}

/// Reduced frequencies of the comparisons with Garrick.
const FREQUENCIES: [f64; 6] = [0.1, 0.2, 0.3, 0.5, 0.8, 1.0];

/// Theodorsen's function, from the table.
fn theodorsen(k: f64) -> Result<Complex, Error> {
    let table = reference_table!("analytic/theodorsen_plunge_2d.csv")?;
    let (ks, re, im) =
        (table.column("k")?, table.column("Re_CL_over_alpha_e")?, table.column("Im_CL_over_alpha_e")?);
    let row = ks.iter().position(|x| *x == k);
    let row = row.ok_or_else(|| Error::NoAnswer(format!("no k = {k} in the table of Theodorsen")))?;
    Ok((re[row] / (2.0 * PI), (im[row] - PI * k) / (2.0 * PI)))
}

/// Theodorsen's function as the preset's lags have it, 1 - sum psi ik/(ik + eps).
fn lagged(preset: ComparedPreset, k: f64) -> Complex {
    let (weights, rates): (&[f64], &[f64]) = match preset {
        ComparedPreset::Paper => (&JONES_WEIGHTS, &JONES_RATES),
        ComparedPreset::Full | ComparedPreset::Turned | ComparedPreset::Neither => {
            (LagSet::Three.lags().lift, LagSet::Three.lags().rate)
        }
        ComparedPreset::FiveLags => (LagSet::Five.lags().lift, LagSet::Five.lags().rate),
    };
    let term = |(psi, eps): (&f64, &f64)| {
        let scale = psi * k / (k * k + eps * eps);
        (scale * k, scale * eps)
    };
    let sum = weights.iter().zip(rates).map(term).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    (1.0 - sum.0, -sum.1)
}

/// Motions of one kind at the reduced frequency k.
type MotionKind = fn(f64) -> Vec<Small>;

/// Pitch with a heave of twice its upwash, at the phases of the complex units `phases`.
fn heaving(k: f64, phases: &[Complex]) -> Vec<Small> {
    let at =
        |axis: f64| phases.iter().map(move |(re, im)| Small { heave: (re / k, im / k), pitch: 1.0, axis });
    AXES.iter().flat_map(|axis| at(*axis)).collect()
}

const KINDS: [(&str, &str, MotionKind); 4] = [
    ("plunge", "plunge", |_| vec![Small { heave: (1.0, 0.0), pitch: 0.0, axis: 0.25 }]),
    ("pitch", "pitch about 1/4, 1/2, 3/4 chord", |_| {
        AXES.map(|axis| Small { heave: (0.0, 0.0), pitch: 1.0, axis }).to_vec()
    }),
    ("both", "heave whose upwash is twice the pitch, with it and a quarter after", |k| {
        heaving(k, &[(1.0, 0.0), (0.0, 1.0)])
    }),
    ("feathered", "heave whose upwash the pitch halves", |k| heaving(k, &[(0.0, -1.0)])),
];

/// Worst |error| of mean thrust over the suction with Theodorsen's function, and with the preset's lags in its place.
fn worst(preset: ComparedPreset, kind: MotionKind) -> Result<[f64; 2], Error> {
    let mut worst: [f64; 2] = [0.0; 2];
    for k in FREQUENCIES {
        for small in kind(k) {
            let value = thrust(preset, SECTION, k, small)?;
            for (worst, c_k) in worst.iter_mut().zip([theodorsen(k)?, lagged(preset, k)]) {
                let (exact, suction) = garrick(k, c_k, small);
                *worst = worst.max((value - exact).abs() / suction);
            }
        }
    }
    Ok(worst)
}

/// Mean thrust against Garrick's closed form. Preset `paper` has Jones' fit of Wagner's function in its equations, of which
/// the square stands in the thrust (4 % off at k = 1): it is judged by Garrick's form with that function, and shown
/// against Theodorsen's, against which other rows judge the function itself. Strips are judged by Theodorsen's: what they
/// miss is their lags' (2.9 % off at k = 0.1 with three of them), as the rows `.own_lags` show. Where the pitch feathers the
/// wing the suction is a quarter of the heave's, and that error counts fourfold.
pub fn garrick_rows(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    for (name, of, kind) in KINDS {
        let [by_theodorsen, by_lags] = worst(preset, kind)?;
        let source = "Garrick 1936, NACA Rep. 567";
        let metric = format!("worst error of mean thrust over the suction, {of}, k 0.1 to 1, AR 1e4");
        if preset == ComparedPreset::Paper {
            let id = format!("aero.garrick.paper.{name}");
            let by_fit = format!("{metric}, with Jones' fit of Theodorsen's function");
            rows.push(ComparisonRow::judged(&id, source, &by_fit, by_lags, 0.03, ""));
            rows.push(ComparisonRow::shown(&format!("{id}.theodorsen"), source, &metric, by_theodorsen, ""));
        } else {
            let id = if preset == ComparedPreset::Full {
                format!("aero.garrick.{name}")
            } else {
                format!("aero.garrick.{}.{name}", preset.name())
            };
            let by_own = format!("{metric}, with the strips' own lags in place of Theodorsen's function");
            rows.push(ComparisonRow::shown(&format!("{id}.own_lags"), source, &by_own, by_lags, ""));
            rows.push(ComparisonRow::judged(&id, source, &metric, by_theodorsen, 0.05, ""));
        }
    }
    Ok(rows)
}

/// Mean thrust of pitching rectangles against the linear lifting surface.
pub fn pitch_thrust(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/pitch_thrust.csv")?;
    let (aspects, ks, axes) = (table.column("AR")?, table.column("k")?, table.column("x_axis")?);
    let (exact, suction) = (table.column("T")?, table.column("S")?);
    let mut worst: f64 = 0.0;
    for i in 0..table.len() {
        let small = Small { heave: (0.0, 0.0), pitch: 1.0, axis: axes[i] };
        let value = thrust(preset, aspects[i], ks[i], small)?;
        worst = worst.max((value - exact[i]).abs() / suction[i]);
    }
    let (source, metric) = (
        "linear lifting surface (own lattice, Richardson)",
        "worst error of mean thrust over the suction, pitch about 1/4, 1/2, 3/4 chord, AR 4 to 20, k <= 1",
    );
    Ok(vec![preset.row(&preset.id("pitch_thrust"), source, metric, worst, 0.03)])
}

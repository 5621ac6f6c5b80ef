//! Goland's wing: a uniform cantilever whose bending and torsion flutter.

use super::section::crossing;
use crate::{Case, Error, Row};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat::aero::{
    Aero, LiftLaw, Planform, PlanformStation, SectionMotion, SectionSettings, StripModel, StripSettings,
};
use wingbeat::math::{Jet, Mat3, Vec3};
use wingbeat::structure::{Beam, Grid, Place, Section, Setting, Station, Strain, frequencies, linear};
use wingbeat::tether::{Bent, Clock, Motion, Reference, Side, Spar, Tether, Wing};
use wingbeat_lattice::{Lattice, Layout, Scene, Sections, Settings, Spacing, Surface};

/// The comparisons.
pub const CASES: &[Case] = &[Case { id: "fsi.goland.strip", quick: false, run: strip }];

/// Those that take a minute.
pub const LONG: &[Case] = &[Case { id: "fsi.goland.lattice", quick: false, run: lattice }];

/// Goland 1945: semi-span and chord, m; elastic axis and centre of mass behind the leading edge, chords.
const SPAN: f64 = 6.096;
const CHORD: f64 = 1.8288;
const AXIS: f64 = 0.33;
const CENTRE: f64 = 0.43;
/// Bending and torsional stiffness, N m2; mass, kg/m, and inertia about the elastic axis, kg m.
const BENDING: f64 = 9.77e6;
const TORSION: f64 = 0.987e6;
const MASS: f64 = 35.71;
const INERTIA: f64 = 8.64;
/// Density with which strip theory and lattices publish their speeds (Murua et al. 2012), kg/m3.
const DENSITY: f64 = 1.02;
/// Strips of the strip model over both halves.
const STRIPS: usize = 20;

fn planform() -> Result<Planform, Error> {
    let station = |arc_m| PlanformStation {
        arc_m,
        leading_edge_m: AXIS * CHORD,
        trailing_edge_m: (AXIS - 1.0) * CHORD,
    };
    Ok(Planform::new(&[station(0.0), station(SPAN)])?)
}

/// The beam, with nodes at `arcs`; y points aft.
fn beam(arcs: Vec<f64>) -> Result<Beam, Error> {
    let offset = (CENTRE - AXIS) * CHORD;
    let own = INERTIA - MASS * offset * offset;
    // In its plane it is taken a hundred times stiffer.
    let section = Section::isotropic(1e10, [TORSION, BENDING, 100.0 * BENDING]).with_mass(
        MASS,
        Vec3::new(0.0, offset, 0.0),
        Mat3::diagonal(Vec3::new(own, 1e-6 * own, own)),
    );
    let stations = [0.0, SPAN].map(|arc_m| Station { arc_m, section });
    Ok(Beam::new(&stations, &[], &Grid { elements: 1, order: 4, strains: Strain::INEXTENSIBLE, arcs })?)
}

/// The wing in a wind of `speed` m/s; `aero` gives its model, and `arcs` the places of further nodes.
fn wing(speed: f64, aero: Aero, arcs: &[f64]) -> Result<Tether, Error> {
    let planform = planform()?;
    let all: Vec<f64> = aero.arcs().iter().chain(arcs).copied().collect();
    let beam = beam(Spar::arcs(&all, 0.0))?;
    let reference =
        Reference { density_kg_m3: DENSITY, speed_m_s: speed, area_m2: planform.area(), chord_m: CHORD };
    Ok(Tether {
        aero,
        motion: Motion::at_rest(),
        wind: Vec3::new(-speed, 0.0, 0.0),
        side: Side::Both,
        reference,
        clock: Clock { frequency_hz: 1.0, cycles: 1, steps_per_cycle: 8 },
        spar: Some(Spar {
            beam,
            finer: None,
            root_m: 0.0,
            ahead_m: 0.0,
            gravity: Vec3::ZERO,
            damping_s: 0.0,
        }),
        wing: Wing::new(planform, Vec::new())?,
    })
}

/// Strips of an infinite wing, or with the wash of the finite one.
fn strips(finite: bool, density: f64) -> Result<Aero, Error> {
    let settings = StripSettings {
        strips: STRIPS,
        wake_wash: finite,
        doublet_wash: finite,
        regularisation_m_s: 0.01,
        section: SectionSettings { density_kg_m3: density, law: LiftLaw::Linear, ..Default::default() },
        ..Default::default()
    };
    Ok(Aero::Strip(StripModel::new(&planform()?, settings)?))
}

/// Speed (m/s) and frequency (rad/s) of flutter by the eigenvalues of beam and strips.
fn flutter(finite: bool, density: f64) -> Result<[f64; 2], Error> {
    let aero = strips(finite, density)?;
    let least = |speed: f64| -> Result<[f64; 2], Error> {
        let tether = wing(speed, aero.clone(), &[])?;
        let found = tether.spar.as_ref().map(|spar| spar.steady(&tether).least_damped);
        found.ok_or_else(|| Error::NoAnswer("no spar".into()))
    };
    // The secant, kept between speeds of which one is stable.
    let (mut low, mut high) = ((120.0_f64, least(120.0)?[0]), (200.0, least(200.0)?[0]));
    if !(low.1 < 0.0 && high.1 > 0.0) {
        return Err(Error::NoAnswer(format!("no flutter between {} and {} m/s", low.0, high.0)));
    }
    for _ in 0..12 {
        let speed =
            (low.0 + 0.02 * (high.0 - low.0)).max(high.0 - high.1 * (high.0 - low.0) / (high.1 - low.1));
        let growth = least(speed)?[0];
        if growth < 0.0 {
            low = (speed, growth)
        } else {
            high = (speed, growth)
        }
        if growth.abs() < 1e-3 {
            return Ok([speed, least(speed)?[1]]);
        }
    }
    Err(Error::NoAnswer("the speed of flutter".into()))
}

fn strip() -> Result<Vec<Row>, Error> {
    let [speed, frequency] = flutter(false, DENSITY)?;
    let source = "Goland 1945, Goland & Luke 1948: exact strip theory, 137.2 m/s, 70.7 rad/s";
    let finite = flutter(true, DENSITY)?;
    let shown = |id: &str, what: &str, value, unit| {
        Row::shown(id, "Murua, Palacios & Graham 2012: 165 m/s, 69 rad/s by a lattice", what, value, unit)
    };
    Ok(vec![
        Row::judged(
            "fsi.goland.strip",
            source,
            &format!("relative error of the speed of flutter, strips of an infinite wing ({speed:.1} m/s)"),
            (speed / 137.2 - 1.0).abs(),
            0.03,
            "",
        ),
        Row::judged(
            "fsi.goland.strip.frequency",
            source,
            &format!("relative error of its frequency ({frequency:.1} rad/s)"),
            (frequency / 70.7 - 1.0).abs(),
            0.03,
            "",
        ),
        shown(
            "fsi.goland.strip.finite",
            "speed of flutter, strips with the wash of the finite wing",
            finite[0],
            "m/s",
        ),
        shown("fsi.goland.strip.finite_frequency", "its frequency", finite[1], "rad/s"),
    ])
}

/// Modes in vacuum.
const MODES: usize = 4;
/// Panels along the chord and strips of the half wing.
const PANELS: [usize; 2] = [10, 12];
/// Periods stepped, of which the last is looked at.
const PERIODS: f64 = 3.0;
/// Amplitude of the largest strain coordinate, 1/m.
const SMALL: f64 = 1e-5;
/// Reduced frequencies w c/(2 U) at which the lattice is asked.
const REDUCED: [f64; 3] = [0.33, 0.39, 0.45];

/// A wing that swings in one of its modes.
struct Swinging {
    tether: Tether,
    shape: Vec<f64>,
    omega: f64,
}

impl Swinging {
    fn bent(&self, t: f64) -> Bent {
        let (sin, cos) = (self.omega * t).sin_cos();
        let times = |f: f64| self.shape.iter().map(|x| SMALL * f * x).collect::<Vec<f64>>();
        let q = [times(sin), times(self.omega * cos), times(-self.omega * self.omega * sin)];
        Bent { q, ..Bent::default() }
    }
}

impl Sections for Swinging {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let frame = self.tether.motion.body(t).frame();
        out.clear();
        out.extend(self.tether.sections_at(arcs, &frame, &[], Some(&self.bent(t))));
    }
}

/// How each node moves per unit rate of a mode: velocity of the point at W's origin, and turn.
fn fields(beam: &Beam, shape: &[f64]) -> Vec<[Vec3; 2]> {
    let zero = vec![0.0; shape.len()];
    // The beam's axes in W: x left, y aft, z up.
    let axes =
        Mat3::from_columns(Vec3::new(0.0, 1.0, 0.0), Vec3::new(-1.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 1.0));
    let places = beam.motion(&Setting::default(), &zero, shape, &zero);
    let field = |place: &Place<Jet<f64>>| {
        let turning = place.r.each(|j| j.d) * place.r.each(|j| j.x).transpose();
        let turn = axes * Vec3::new(turning.0[2][1], turning.0[0][2], turning.0[1][0]);
        let (p, v) = (axes * place.p.each(|j| j.x), axes * place.p.each(|j| j.d));
        [v - turn.cross(p), turn]
    };
    places.iter().map(field).collect()
}

/// Generalised forces of the air on all modes per unit of the mode `which`, over rho U^2/2, at one reduced frequency.
fn forces(which: usize, reduced: f64) -> Result<Vec<Complex<f64>>, Error> {
    let [chordwise, half] = PANELS;
    let layout = Layout::of(&planform()?, &[0.0], chordwise, 2 * half, Spacing::Uniform)
        .map_err(|error| Error::NoAnswer(error.to_string()))?;
    let layout = layout.first().and_then(Layout::left_half);
    let layout = layout.ok_or_else(|| Error::NoAnswer("half a lattice".into()))?;
    let middles: Vec<f64> = layout.arcs.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let nodes: Vec<f64> = layout.arcs.iter().chain(&middles).copied().collect();
    let tether = wing(1.0, strips(false, 1.0)?, &nodes)?;
    let beam = beam(Spar::arcs(&[tether.aero.arcs(), &nodes].concat(), 0.0))?;
    let modes = frequencies(&linear(&beam, &Setting::default(), &vec![0.0; beam.coordinates()]));
    let omega = reduced * 2.0 / CHORD;
    let swinging = Swinging { tether, shape: modes[which].1.clone(), omega };
    let surface = Surface { layout, sections: Arc::new(swinging) };
    let wind = Vec3::new(-1.0, 0.0, 0.0);
    let scene = Scene { surfaces: vec![surface], wind, density_kg_m3: 1.0, symmetric: true };
    // A whole number of steps per period, as near as can be to a panel per step.
    let per_period = (PI * chordwise as f64 / reduced).round() as usize;
    let step = TAU / omega / per_period as f64;
    let failed = |error: wingbeat_lattice::Error| Error::NoAnswer(error.to_string());
    let mut lattice = Lattice::new(scene, Settings::new(step, 0.02 * CHORD)).map_err(failed)?;
    let own: Vec<Vec<[Vec3; 2]>> = modes.iter().take(MODES).map(|mode| fields(&beam, &mode.1)).collect();
    let at: Vec<usize> = middles.iter().map(|arc| beam.nearest(*arc)).collect();
    let steps = (PERIODS * per_period as f64).round() as usize;
    let mut sums = vec![Complex::new(0.0, 0.0); MODES];
    for k in 0..steps {
        let loads = lattice.step().map_err(failed)?;
        if k + per_period < steps {
            continue;
        }
        let (sin, cos) = (omega * k as f64 * step).sin_cos();
        for (sum, field) in sums.iter_mut().zip(&own) {
            let strips = loads.panels[0].strips.iter().zip(&at);
            let force: f64 = strips
                .map(|(load, node)| load.force.dot(field[*node][0]) + load.moment.dot(field[*node][1]))
                .sum();
            // F = Im(Q e^iwt): sine and cosine parts.
            *sum += Complex::new(sin, cos) * (2.0 / per_period as f64 * force / SMALL);
        }
    }
    Ok(sums.into_iter().map(|sum| sum * 2.0).collect())
}

/// The parabola through three values at [`REDUCED`].
fn parabola(values: [Complex<f64>; 3], at: f64) -> Complex<f64> {
    (0..3).fold(Complex::new(0.0, 0.0), |sum, i| {
        let others = (0..3).filter(|j| *j != i);
        sum + values[i] * others.map(|j| (at - REDUCED[j]) / (REDUCED[i] - REDUCED[j])).product::<f64>()
    })
}

fn lattice() -> Result<Vec<Row>, Error> {
    let pairs: Vec<(usize, f64)> = (0..MODES).flat_map(|mode| REDUCED.map(|k| (mode, k))).collect();
    let mut found: Vec<Option<Vec<Complex<f64>>>> = vec![None; pairs.len()];
    let mut failed = None;
    wingbeat::parallel::each(
        &pairs,
        |_, (mode, reduced)| forces(*mode, *reduced),
        |i, result| {
            match result {
                Ok(forces) => found[i] = Some(forces),
                Err(error) => failed = Some(error),
            }
            ControlFlow::Continue(())
        },
    );
    if let Some(error) = failed {
        return Err(error);
    }
    let force = |row: usize, column: usize, k: usize| {
        found[3 * column + k].as_ref().map_or(Complex::new(f64::NAN, 0.0), |f| f[row])
    };
    let beam = beam(Vec::new())?;
    let own: Vec<f64> = frequencies(&linear(&beam, &Setting::default(), &vec![0.0; beam.coordinates()]))
        .iter()
        .take(MODES)
        .map(|mode| mode.0)
        .collect();
    // (W^2 - w^2 (1 + rho b^2/(2 k^2) Q(k))) q = 0: 1/w^2 is real at flutter.
    let eigenvalues = |reduced: f64| {
        let matrix = DMatrix::from_fn(MODES, MODES, |i, j| {
            let q = parabola([0, 1, 2].map(|k| force(i, j, k)), reduced);
            let unit = if i == j { 1.0 } else { 0.0 };
            (q * (DENSITY * (CHORD / 2.0 / reduced).powi(2) / 2.0) + unit) / own[i].powi(2)
        });
        matrix.schur().unpack().1.diagonal().iter().copied().collect()
    };
    let damping = |reduced: f64| -> Result<f64, Error> {
        let all: Vec<Complex<f64>> = eigenvalues(reduced);
        // The damping that a structure would need to neither grow nor decay, where its stiffness is K (1 + i g).
        Ok(all.iter().map(|x| x.im / x.re).fold(f64::NEG_INFINITY, f64::max))
    };
    // Speed falls as the reduced frequency grows.
    let reduced = crossing(|minus: f64| damping(1.0 - minus), 1.0 - REDUCED[2], 1.0 - REDUCED[0])
        .map(|minus| 1.0 - minus)?;
    let all = eigenvalues(reduced);
    let at = all.iter().min_by(|a, b| (a.im / a.re).abs().total_cmp(&(b.im / b.re).abs()));
    let omega = at.map_or(f64::NAN, |x| x.re.recip().sqrt());
    let speed = omega * CHORD / 2.0 / reduced;
    let source = "Murua, Palacios & Graham 2012: 165 m/s, 69 rad/s; SHARPy's regression test: 166 m/s";
    Ok(vec![
        Row::judged(
            "fsi.goland.lattice",
            source,
            &format!(
                "relative error of the speed of flutter, {} x {} panels ({speed:.1} m/s)",
                PANELS[0], PANELS[1]
            ),
            (speed / 165.0 - 1.0).abs(),
            0.03,
            "",
        ),
        Row::judged(
            "fsi.goland.lattice.frequency",
            source,
            &format!("relative error of its frequency ({omega:.1} rad/s)"),
            (omega / 69.0 - 1.0).abs(),
            0.03,
            "",
        ),
    ])
}

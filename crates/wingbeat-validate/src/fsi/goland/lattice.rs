//! Goland's wing in the air of the library's lattice, which knows the finite wing and its wake.

use super::{ALOFT, AXIS, C, MODES, SEMI_CHORD, SPAN, beam, flutter};
use crate::{ComparisonRow, Error, reference_table};
use nalgebra::DMatrix;
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat::aero::{Planform, PlanformStation, SectionMotion};
use wingbeat::math::{Jet, Mat3, Scalar, Vec3};
use wingbeat::structure::{Beam, Place, Setting, Swung, frequencies, linear, turning};
use wingbeat_lattice::{
    Lattice, LatticeSettings, LatticeSurface, MovingSections, PanelLayout, Scene, Spacing,
};

/// Largest strain coordinate of a pulse, 1/m: loads are linear to its square.
const SMALL: f64 = 1e-5;
/// Width of a pulse exp(-(t - t0)^2/width^2), chords of travel: its spectrum holds the reduced frequencies to 1.
const WIDTH: f64 = 1.0;
/// Chords of travel before the middle of a pulse, and behind it.
const BEFORE: f64 = 3.5;
const BEHIND: f64 = 16.0;

/// A lattice over the half wing.
#[derive(Clone, Copy)]
struct HalfWingPanels {
    chordwise: usize,
    half: usize,
}

/// A wing that moves in the shape `shape` by a pulse, in a wind of 1 m/s.
struct Pulsed {
    beam: Arc<Beam>,
    shape: Vec<f64>,
}

impl Pulsed {
    /// The pulse at the time `t` with its rates.
    fn at(t: f64) -> [f64; 3] {
        let width = WIDTH * 2.0 * SEMI_CHORD;
        let s = (t - BEFORE * 2.0 * SEMI_CHORD) / width;
        let f = (-s * s).exp();
        [f, -2.0 * s * f / width, (4.0 * s * s - 2.0) * f / (width * width)]
    }
}

/// Axes of the beam in W: its x to the left, y aft, z up.
fn root() -> Swung {
    let axes =
        Mat3::from_columns(Vec3::new(0.0, 1.0, 0.0), Vec3::new(-1.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 1.0));
    Place { p: Vec3([Jet::ZERO; 3]), r: axes.each(Jet::constant) }
}

fn setting() -> Setting {
    Setting { root: root(), ..Setting::default() }
}

impl MovingSections for Pulsed {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let [q, v, a] = Self::at(t).map(|f| self.shape.iter().map(|x| SMALL * f * x).collect::<Vec<f64>>());
        let places = self.beam.motion(&setting(), &q, &v, &a);
        out.clear();
        out.extend(arcs.iter().map(|arc| {
            let place = &places[self.beam.nearest(*arc)];
            let aft = place.r.column(1);
            let edge = |chords: f64| place.p + aft.scaled(2.0 * SEMI_CHORD * chords);
            let (le, te) = (edge(-AXIS), edge(1.0 - AXIS));
            let part = |v: Vec3<Jet<f64>>| [v.each(|j| j.x), v.each(|j| j.d), v.each(|j| j.dd)];
            let ([le, v_le, a_le], [te, v_te, a_te]) = (part(le), part(te));
            SectionMotion { le, te, v_le, v_te, a_le, a_te, ..SectionMotion::default() }
        }));
    }
}

/// How each node moves per unit rate of a mode: velocity of the point at W's origin, and turn.
fn fields(beam: &Beam, shape: &[f64]) -> Vec<[Vec3; 2]> {
    let zero = vec![0.0; shape.len()];
    let field = |place: &Place<Jet<f64>>| {
        let turn = turning(&place.r)[0];
        let (p, v) = (place.p.each(|j| j.x), place.p.each(|j| j.d));
        [v - turn.cross(p), turn]
    };
    beam.motion(&setting(), &zero, shape, &zero).iter().map(field).collect()
}

/// Generalised forces over time of all modes under a pulse of one of them, over its size, in air of 1 kg/m3 at 1 m/s.
struct PulseResponse {
    step: f64,
    forces: Vec<Vec<f64>>,
}

fn answer(panels: HalfWingPanels, which: usize) -> Result<(Vec<f64>, PulseResponse), Error> {
    let station = |arc_m| PlanformStation {
        arc_m,
        leading_edge_m: AXIS * 2.0 * SEMI_CHORD,
        trailing_edge_m: (AXIS - 1.0) * 2.0 * SEMI_CHORD,
    };
    let planform = Planform::new(&[station(0.0), station(SPAN)])?;
    let failed = |error: wingbeat_lattice::Error| Error::NoAnswer(error.to_string());
    let layout = PanelLayout::of(&planform, &[0.0], panels.chordwise, 2 * panels.half, Spacing::Uniform);
    let layout = layout.map_err(failed)?.first().and_then(PanelLayout::left_half);
    let layout = layout.ok_or_else(|| Error::NoAnswer("half a lattice".into()))?;
    let middles: Vec<f64> = layout.arcs.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let inner = layout.arcs.iter().chain(&middles).copied().filter(|arc| *arc > 0.0 && *arc < SPAN);
    let beam = Arc::new(beam(inner.collect())?);
    let modes = frequencies(&linear(&beam, &Setting::default(), &vec![0.0; beam.coordinates()]));
    let squares = modes.iter().take(MODES).map(|mode| mode.0 * mode.0).collect();
    let moved = Pulsed { beam: beam.clone(), shape: modes[which].1.clone() };
    let surface = LatticeSurface { layout, sections: Arc::new(moved) };
    let wind = Vec3::new(-1.0, 0.0, 0.0);
    let scene = Scene { surfaces: vec![surface], wind, density_kg_m3: 1.0, symmetric: true, ground: None };
    // A panel a step.
    let step = 2.0 * SEMI_CHORD / panels.chordwise as f64;
    let mut lattice =
        Lattice::new(scene, LatticeSettings::new(step, 0.02 * 2.0 * SEMI_CHORD)).map_err(failed)?;
    let own: Vec<Vec<[Vec3; 2]>> = modes.iter().take(MODES).map(|mode| fields(&beam, &mode.1)).collect();
    let at: Vec<usize> = middles.iter().map(|arc| beam.nearest(*arc)).collect();
    let steps = ((BEFORE + BEHIND) * panels.chordwise as f64).round() as usize;
    let mut forces = vec![Vec::new(); own.len()];
    for _ in 0..steps {
        let loads = lattice.step().map_err(failed)?;
        for (forces, field) in forces.iter_mut().zip(&own) {
            let strips = loads.panels[0].strips.iter().zip(&at);
            let work =
                strips.map(|(load, node)| load.force.dot(field[*node][0]) + load.moment.dot(field[*node][1]));
            forces.push(work.sum::<f64>() / SMALL);
        }
    }
    Ok((squares, PulseResponse { step, forces }))
}

impl PulseResponse {
    /// Generalised forces per unit of a harmonic motion of the reduced frequency `k`: the transforms' quotient.
    fn at(&self, k: f64) -> Vec<C> {
        let omega = k / SEMI_CHORD;
        let wave = |n: usize| C::from_polar(1.0, -omega * n as f64 * self.step);
        let count = self.forces[0].len();
        let pulse: C = (0..count).map(|n| wave(n) * Pulsed::at(n as f64 * self.step)[0]).sum();
        let of = |forces: &Vec<f64>| forces.iter().enumerate().map(|(n, f)| wave(n) * *f).sum::<C>() / pulse;
        self.forces.iter().map(of).collect()
    }
}

/// Speed and frequency of flutter in the air of a lattice of those panels.
fn of(panels: HalfWingPanels) -> Result<[f64; 2], Error> {
    let all: Vec<usize> = (0..MODES).collect();
    let mut found: Vec<Option<PulseResponse>> = all.iter().map(|_| None).collect();
    let (mut squares, mut failed) = (Vec::new(), None);
    wingbeat::parallel::each(
        &all,
        |_, mode| answer(panels, *mode),
        |i, result| {
            match result {
                Ok((own, answer)) => (squares, found[i]) = (own, Some(answer)),
                Err(error) => failed = Some(error),
            }
            ControlFlow::Continue(())
        },
    );
    if let Some(error) = failed {
        return Err(error);
    }
    let answers: Vec<PulseResponse> = found.into_iter().flatten().collect();
    flutter(&squares, |k| {
        let columns: Vec<Vec<C>> = answers.iter().map(|answer| answer.at(k)).collect();
        // Forces grow with U^2 = (omega b/k)^2, so that omega falls out.
        let scale = ALOFT * (SEMI_CHORD / k).powi(2);
        DMatrix::from_fn(squares.len(), columns.len(), |i, j| columns[j][i] * scale)
    })
}

/// Speed (m/s) and frequency (rad/s) with endless panels, from two grids of one shape: the error falls as the size of a panel.
fn endless(coarse: [f64; 2], fine: [f64; 2], ratio: f64) -> [f64; 2] {
    [0, 1].map(|i| fine[i] + (fine[i] - coarse[i]) / (ratio - 1.0))
}

/// What another program for the same wing tends to with endless panels, and how far its two series of grids end from one another,
/// relative.
pub(super) fn apart() -> Result<([f64; 2], f64), Error> {
    let table = reference_table!("goland/surface.csv")?;
    let [inset, panels, speed, frequency] = ["inset", "chordwise", "speed_m_s", "frequency_rad_s"];
    let [inset, panels, speed, frequency] =
        [table.column(inset)?, table.column(panels)?, table.column(speed)?, table.column(frequency)?];
    let ends = (1..inset.len()).filter(|i| inset.get(i + 1) != Some(&inset[*i]));
    let found: Vec<[f64; 2]> = ends
        .map(|i| {
            let at = |i: usize| [speed[i], frequency[i]];
            endless(at(i - 1), at(i), panels[i] / panels[i - 1])
        })
        .collect();
    let [one, other] = found[..] else {
        return Err(Error::reference("goland/surface.csv", format!("{} series, not 2", found.len())));
    };
    Ok(([0, 1].map(|i| 0.5 * (one[i] + other[i])), (one[0] / other[0] - 1.0).abs()))
}

/// Published speeds beside `speed`, which differ among themselves.
fn published(speed: f64) -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("goland/published.csv")?;
    let (names, methods) = (table.words("name")?, table.words("method")?);
    let (panels, speeds) = (table.words("panels")?, table.column("speed_m_s")?);
    let row = |i: usize| {
        let panels = if panels[i] == "-" { String::new() } else { format!(", {} panels", panels[i]) };
        ComparisonRow::shown(
            &format!("fsi.goland.lattice.{}", names[i]),
            "validation/goland/published.csv",
            &format!(
                "extrapolated lattice against {}{panels}, {} m/s: relative difference (goal: 0.03)",
                methods[i], speeds[i]
            ),
            (speed / speeds[i] - 1.0).abs(),
            "",
        )
    };
    Ok((0..names.len()).map(row).collect())
}

pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let (fine, coarse) =
        (HalfWingPanels { chordwise: 9, half: 12 }, HalfWingPanels { chordwise: 6, half: 8 });
    let (found, before) = (of(fine)?, of(coarse)?);
    let limit = endless(before, found, fine.half as f64 / coarse.half as f64);
    let ([speed, frequency], spread) = apart()?;
    let HalfWingPanels { chordwise, half } = fine;
    let source = format!(
        "a lattice in the frequency domain on its own beam, extrapolated: {speed:.1} m/s, {frequency:.1} rad/s (validation/goland)"
    );
    let off = |value: f64, other: f64| (value / other - 1.0).abs();
    let judged =
        |id: &str, what: String, value: f64| ComparisonRow::judged(id, &source, &what, value, 0.03, "");
    let mut rows = vec![
        judged(
            "fsi.goland.lattice",
            format!(
                "relative error of the speed of flutter, {chordwise} x {half} panels, computed {:.1} m/s",
                found[0]
            ),
            off(found[0], speed),
        ),
        judged(
            "fsi.goland.lattice.endless",
            format!("the same, extrapolated in the size of panels, computed {:.1} m/s", limit[0]),
            off(limit[0], speed),
        ),
        judged(
            "fsi.goland.lattice.frequency",
            format!("relative error of its frequency, extrapolated (computed {:.1} rad/s)", limit[1]),
            off(limit[1], frequency),
        ),
        ComparisonRow::judged(
            "fsi.goland.lattice.series",
            &source,
            "relative difference of the limits of two series of grids of surface.py",
            spread,
            0.003,
            "",
        ),
    ];
    rows.extend(published(limit[0])?);
    Ok(rows)
}

//! Wings that flap gently, against a linear lattice: the force, and how it lies along the span.

use super::ComparedPreset;
use super::lattice::HarmonicLattice;
use super::linear::{Complex, FlapHinge, RigidMotion, SmallMotion};
use super::small::extrapolated;
use super::wings::{self, Still};
use crate::lattice::wings::harmonic;
use crate::{ComparisonRow, Error};
use std::f64::consts::PI;
use wingbeat::aero::Aero;
use wingbeat::math::Vec3;
use wingbeat::tether::{Coordinate, Hinge, HingeKind, Motion, Side, TetheredBody, Wing};
use wingbeat_lattice::{FlappingWing, Lattice, LatticeSettings, Panels, Scene, Spacing};

/// Reduced frequencies by the mean chord.
const KS: [f64; 6] = [0.1, 0.25, 0.4, 0.55, 0.73, 1.0];
/// Strips of the linear lattice, panels along its chord; it is extrapolated from half of them.
const STATIONS: usize = 32;
const CHORDWISE: usize = 12;
/// Strips of the model.
const STRIPS: usize = 16;
const SOURCE: &str = "linear vortex lattice, 6 and 12 x 32 panels";
/// Largest error of the normal force. *Choice*: half as much again as is asked of plunge.
const LIMIT: f64 = 0.03;
/// Powers of the distance from the middle that weigh the force: all of it, its moment, the tips.
const POWERS: [i32; 3] = [0, 1, 4];
/// Stroke and reduced frequency of the lattice that is stepped in time.
const STROKE_DEG: f64 = 5.0;
const STEPPED_K: f64 = 0.73;
/// Way until its start is forgotten, mean chords.
const FORGOTTEN: f64 = 12.0;
/// End of the row's name, panels along the chord, cores of the wake in mean chords.
const STEPPED: [(&str, usize, f64); 4] =
    [("lattice", 8, 0.02), ("thick_cores", 8, 0.05), ("thin_cores", 8, 0.002), ("fine", 16, 0.002)];

/// A flat wing that flaps about the first of its hinges.
struct FlappedWing {
    name: &'static str,
    words: &'static str,
    still: Still,
    /// Whether the lattice that is stepped in time is compared too.
    stepped_too: bool,
}

impl FlappedWing {
    fn rectangle(
        name: &'static str,
        words: &'static str,
        aspect: f64,
        stepped_too: bool,
    ) -> Result<Self, Error> {
        let flat = wings::rectangular(aspect)?;
        let hinge =
            Hinge { kind: HingeKind::Flap, side: Side::Both, arc_m: 0.0, to_arc_m: None, ahead_m: 0.0 };
        let wing = Wing::new(flat.wing.planform().clone(), vec![hinge])?;
        Ok(Self { name, words, still: Still { wing, angles: vec![0.0.into()], ..flat }, stepped_too })
    }

    fn all() -> Result<[Self; 4], Error> {
        let aerobat = wings::aerobat_folded(0.0, 0.0)?;
        Ok([
            Self::rectangle("ar3", "AR 3", 3.0, true)?,
            Self::rectangle("ar5", "AR 5", 5.0, false)?,
            Self::rectangle("ar8", "AR 8", 8.0, false)?,
            Self { name: "aerobat", words: "Aerobat's planform, flat", still: aerobat, stepped_too: true },
        ])
    }

    fn flapping(&self) -> RigidMotion {
        RigidMotion::Flap(FlapHinge { place: 0, arc_m: self.still.hinges()[0] })
    }

    /// Angular frequency at the reduced frequency `k`, rad/s at 1 m/s.
    fn omega(&self, k: f64) -> f64 {
        2.0 * k / self.still.chord
    }

    fn half_span(&self) -> f64 {
        self.still.wing.planform().half_span()
    }

    /// Sums of forces at the arcs `at`, weighted by the powers of their distance over the half span.
    fn weighted(&self, forces: &[Complex], at: &[f64]) -> [Complex; 3] {
        POWERS.map(|power| {
            forces.iter().zip(at).fold((0.0, 0.0), |sum, (force, arc)| {
                let weight = (arc.abs() / self.half_span()).powi(power);
                (sum.0 + weight * force.0, sum.1 + weight * force.1)
            })
        })
    }

    /// The weighted sums of the lattice.
    fn exact(&self, motion: RigidMotion, k: f64) -> Result<[Complex; 3], Error> {
        let model = self.model(STATIONS)?;
        let frame = TetheredBody::rest().frame();
        let edge = |arc: &f64| {
            let section = self.still.wing.section(*arc, &frame, &self.still.angles);
            [section.le, section.te]
        };
        let left: Vec<f64> = model.strip_arcs().iter().copied().take(STATIONS / 2).collect();
        let between = model.arcs().windows(2).zip(&left);
        let fractions: Vec<f64> = between.map(|(ends, arc)| (ends[0] - arc) / (ends[0] - ends[1])).collect();
        let strips = |chordwise: usize| {
            let lattice = HarmonicLattice {
                chordwise,
                edges: model.arcs().iter().map(edge).collect(),
                fractions: fractions.clone(),
                chord: self.still.chord,
                omega: self.omega(k),
            };
            Ok::<_, Error>(lattice.strip_lift(&[motion])?.remove(0))
        };
        let forces = extrapolated(&strips(CHORDWISE / 2)?, &strips(CHORDWISE)?);
        Ok(self.weighted(&forces, &left))
    }

    fn model(&self, strips: usize) -> Result<Aero, Error> {
        ComparedPreset::Full.model_of(strips, self.still.wing.planform(), &self.still.hinges(), 1.0, 1e-6)
    }

    /// Worst complex errors of the weighted sums over the reduced frequencies.
    fn errors(&self, motion: RigidMotion) -> Result<[f64; 3], Error> {
        let model = self.model(STRIPS)?;
        let small = SmallMotion::new(&model, &self.still, motion);
        let mut worst = [0.0_f64; 3];
        for k in KS {
            let value = self.weighted(&small.response(self.omega(k))?[1..], model.strip_arcs());
            let exact = self.exact(motion, k)?;
            for ((worst, value), exact) in worst.iter_mut().zip(value).zip(exact) {
                *worst = worst.max((value.0 - exact.0).hypot(value.1 - exact.1) / exact.0.hypot(exact.1));
            }
        }
        Ok(worst)
    }

    /// Amplitude of the normal force of the lattice that is stepped in time on so many panels along the chord, with cores of `core` mean
    /// chords, over that of the linear lattice.
    fn stepped(&self, chordwise: usize, core: f64) -> Result<f64, Error> {
        let (chord, omega, stroke) = (self.still.chord, self.omega(STEPPED_K), STROKE_DEG.to_radians());
        let cycle = (2.0 * PI / omega * chordwise as f64 / chord).round();
        let step = 2.0 * PI / (omega * cycle);
        let wave = Coordinate::Fourier {
            frequency_hz: omega / (2.0 * PI),
            mean: 0.0,
            cos: vec![stroke],
            sin: vec![0.0],
        };
        let others =
            (1..self.still.angles.len()).map(|at| (format!("hinge_{at}"), Coordinate::Constant(0.0)));
        let hinges = std::iter::once(("shoulder".to_string(), wave)).chain(others).collect();
        let wing = FlappingWing {
            wing: self.still.wing.clone(),
            motion: Motion { hinges, ..Motion::at_rest() },
            wind: Vec3::new(-1.0, 0.0, 0.0),
            density_kg_m3: 1.0,
            ground: None,
        };
        let panels = Panels { chordwise, spanwise: STATIONS, spacing: Spacing::Lan };
        let settings = LatticeSettings::new(step, core * chord);
        let mut lattice = Lattice::new(Scene::new(&wing, panels, true)?, settings)?;
        let steps = (FORGOTTEN * chord / step).round() as usize + cycle as usize;
        let normal = |_| -> Result<f64, Error> { Ok(lattice.step()?.joukowski.force[2]) };
        let normal = (0..steps).map(normal).collect::<Result<Vec<f64>, Error>>()?;
        let (re, im) = harmonic(&normal, step, omega);
        let [exact, ..] = self.exact(self.flapping(), STEPPED_K)?;
        Ok(re.hypot(im) / (stroke * exact.0.hypot(exact.1)))
    }

    /// The rows of the strips.
    fn strip_rows(&self, id: &str) -> Result<Vec<ComparisonRow>, Error> {
        let said = |motion: &str, of: &str| {
            format!("{}, {motion}, k 0.1 to 1: worst complex error of {of}", self.words)
        };
        let tips_of = "its loads weighted by the fourth power of the distance from the middle";
        let [force, moment, tips] = self.errors(self.flapping())?;
        let mut rows =
            vec![ComparisonRow::judged(id, SOURCE, &said("flapping", "the normal force"), force, LIMIT, "")];
        let mut show = |end: &str, metric: &str, error: f64| {
            rows.push(ComparisonRow::shown(&format!("{id}.{end}"), SOURCE, metric, error, ""));
        };
        show("moment", &said("flapping", "its moment about the middle"), moment);
        show("tips", &said("flapping", tips_of), tips);
        if self.name == "aerobat" {
            let [.., tips] = self.errors(RigidMotion::Plunge)?;
            show("plunge_tips", &said("plunge", tips_of), tips);
        }
        Ok(rows)
    }

    /// The rows of the lattice that is stepped in time.
    fn stepped_rows(&self, id: &str) -> Result<Vec<ComparisonRow>, Error> {
        let row = |(end, chordwise, core): (&str, usize, f64)| {
            let metric = format!(
                "{}, flapping by {STROKE_DEG} degrees, k {STEPPED_K}: amplitude of the normal force of the lattice, {chordwise} x {STATIONS} panels, cores of {core} chords, over that of the linear lattice, less 1",
                self.words
            );
            let error = self.stepped(chordwise, core)? - 1.0;
            Ok(ComparisonRow::shown(&format!("{id}.{end}"), "own vortex lattice", &metric, error, ""))
        };
        STEPPED.into_iter().map(row).collect()
    }
}

/// Forces of wings that flap gently, how they lie along the span, and the error of the lattice that is stepped in time.
pub fn small_flap() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    for wing in FlappedWing::all()? {
        let id = format!("aero.full.small_flap.{}", wing.name);
        rows.extend(wing.strip_rows(&id)?);
        if wing.stepped_too {
            rows.extend(wing.stepped_rows(&id)?);
        }
    }
    Ok(rows)
}

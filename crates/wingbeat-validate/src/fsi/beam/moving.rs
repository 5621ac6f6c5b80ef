//! Beams that move: energy, momentum, derivatives, a flapping root.

use super::{UNIFORM, apart};
use crate::{ComparisonRow, Error};
use nalgebra::DMatrix;
use wingbeat::math::{GRAVITY, Jet, Mat3, Random, Scalar, Vec3, Wrench};
use wingbeat::structure::{
    Beam, CrossSection, Grid, Implicit, Load, Place, SectionStation, Setting, Stage, StepFactors, Strain,
    Swung, hold, step, turning,
};

/// A beam whose root is where a function of time says; the state of first order is the work done at the root.
struct MovingBeam<'a> {
    beam: &'a Beam,
    setting: &'a dyn Fn(f64) -> Setting,
}

impl MovingBeam<'_> {
    /// Power of what holds the root, W.
    fn power(root: &Swung, by: &Wrench<f64>) -> f64 {
        let [rate, _] = turning(&root.r);
        by.force.dot(root.p.each(|j| j.d)) + by.moment.dot(rate)
    }
}

impl Implicit for MovingBeam<'_> {
    fn residual(&self, t: f64, at: &Stage, out: &mut [f64]) {
        let setting = (self.setting)(t);
        let n = at.q.len();
        let root = self.beam.residual(&setting, [&at.q, &at.v, &at.a], &[], &mut out[..n]);
        out[n] = at.w[0] - Self::power(&setting.root, &root);
    }
    fn tangents(&self, t: f64, at: &Stage) -> [DMatrix<f64>; 5] {
        let n = at.q.len();
        let own = self.beam.tangents(&(self.setting)(t), [&at.q, &at.v, &at.a], &[]);
        let [q, v, a] = own.map(|m| m.insert_row(n, 0.0));
        let mut w = DMatrix::zeros(n + 1, 1);
        w[(n, 0)] = 1.0;
        // The work is no part of the motion, so that its own slopes may be left out.
        [q, v, a, DMatrix::zeros(n + 1, 1), w]
    }
}

/// Steps from `at`, and hands each new state to `see`.
fn run(
    moving: &MovingBeam<'_>,
    mut at: Stage,
    h: f64,
    steps: usize,
    mut see: impl FnMut(f64, &Stage),
) -> Result<Stage, Error> {
    let mut factors: StepFactors = None;
    for k in 0..steps {
        let t = k as f64 * h;
        if !step(moving, t, h, &mut at, &mut factors).converged {
            return Err(Error::NoAnswer(format!("a step of a beam at {t} s")));
        }
        see(t + h, &at);
    }
    Ok(at)
}

fn at_rest(q: Vec<f64>) -> Stage {
    let zero = vec![0.0; q.len()];
    Stage { v: zero.clone(), a: zero, q, x: vec![0.0], w: vec![0.0] }
}

/// A root that turns by A (1 - cos(w t)) about -y: its beam rises.
fn flapping_root(amplitude: f64, omega: f64, t: f64) -> Swung {
    let phase = Jet::new(omega * t, omega, 0.0);
    let angle = (Jet::from(1.0) - phase.cos()) * -amplitude;
    Place { p: Vec3([Jet::ZERO; 3]), r: Mat3::rotation_y(angle) }
}

pub fn flapping() -> Result<Vec<ComparisonRow>, Error> {
    // Fast enough that the rotation counts, stiff enough that the tip bends by 4e-3 of the length, so that the small-deflection
    // equation holds to 1e-4.
    let swing = apart::RootSwing { amplitude: 3.0, omega: 2.0, stiffness: 600.0 };
    let numbers = [swing.stiffness, 1e6, 1.0, 1e-4];
    let of = apart::TaperedBeam { root: numbers, tip: numbers, ..UNIFORM };
    let beam = super::beam(&of, 1, 6)?;
    let root = |t: f64| flapping_root(swing.amplitude, swing.omega, t);
    let setting = |t: f64| Setting { root: root(t), ..Setting::default() };
    let (h, steps) = (5e-4, 3200);
    let mut found = Vec::new();
    let moving = MovingBeam { beam: &beam, setting: &setting };
    run(&moving, at_rest(vec![0.0; beam.coordinates()]), h, steps, |_, at| {
        found.push(beam.places(&Place::IDENTITY, &at.q)[beam.tip()].p[2]);
    })?;
    let known = apart::flapped(&swing, true, h, steps)?;
    let square = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let off = |values: &[f64]| {
        let far: Vec<f64> = values.iter().zip(&known).map(|(a, b)| a - b).collect();
        square(&far) / square(&known)
    };
    let metric = "rms error of the tip's deflection over its rms, root swings through 344 deg in 1.6 s";
    let source = "small deflection in turning axes by six polynomials and Runge-Kutta, written apart";
    let largest = known.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let shown = |id: &str, metric: &str, value| ComparisonRow::shown(id, source, metric, value, "");
    Ok(vec![
        ComparisonRow::judged("fsi.beam.flapping", source, metric, off(&found), 1e-3, ""),
        shown("fsi.beam.flapping.deflection", "largest deflection of the tip over length", largest),
        shown(
            "fsi.beam.flapping.rotation",
            "the same rms of the equation without its terms of rotation",
            off(&apart::flapped(&swing, false, h, steps)?),
        ),
    ])
}

/// A limp strip of rubber with its mass off the axis.
fn limp(order: usize) -> Result<Beam, Error> {
    let section = CrossSection::isotropic(1e4, [0.02, 0.03, 0.4]).with_mass(
        0.15,
        Vec3::new(0.0, 0.01, 0.002),
        Mat3::diagonal(Vec3::new(6e-5, 5e-6, 5.5e-5)),
    );
    let stations = [0.0, 0.5].map(|arc_m| SectionStation { arc_m, section });
    let grid = Grid { elements: 1, order, strains: Strain::INEXTENSIBLE, arcs: Vec::new() };
    Ok(Beam::new(&stations, &[], &grid)?)
}

pub fn energy() -> Result<Vec<ComparisonRow>, Error> {
    let beam = limp(4)?;
    let setting = |t: f64| Setting {
        root: flapping_root(0.6, 12.0, t),
        gravity: Vec3::new(0.0, 0.0, -GRAVITY),
        ..Setting::default()
    };
    let moving = MovingBeam { beam: &beam, setting: &setting };
    let (period, steps) = (std::f64::consts::TAU / 12.0, 800);
    let start = at_rest(hold(&beam, &setting(0.0), 4).q);
    let before = beam.energy(&setting(0.0), &start.q, &start.v).total();
    let (mut peak, mut farthest) = (0.0_f64, 0.0_f64);
    let end = run(&moving, start, period / steps as f64, steps, |_, at| {
        peak = peak.max(at.x[0].abs());
        farthest = farthest.max(-beam.places(&Place::IDENTITY, &at.q)[beam.tip()].p[2]);
    })?;
    let after = beam.energy(&setting(period), &end.q, &end.v).total();
    let source = "conservation of energy";
    Ok(vec![
        ComparisonRow::judged(
            "fsi.beam.energy",
            source,
            "work at the flapping root less change of energy, over the peak work, one cycle, 800 steps",
            (end.x[0] - (after - before)).abs() / peak,
            1e-8,
            "",
        ),
        ComparisonRow::shown(
            "fsi.beam.energy.deflection",
            source,
            "largest deflection of the tip in that cycle",
            farthest,
            "m",
        ),
    ])
}

pub fn momentum() -> Result<Vec<ComparisonRow>, Error> {
    let beam = limp(2)?;
    let setting = |_: f64| Setting { free: true, ..Setting::default() };
    let n = beam.unknowns(true);
    let mut start = at_rest(vec![0.0; n]);
    let mut random = Random::new(3);
    start.v[..3].copy_from_slice(&[0.4, -0.3, 0.2]);
    start.v[3..6].copy_from_slice(&[1.0, -2.0, 3.0]);
    start.v[6..].iter_mut().for_each(|v| *v = 2.0 * random.normal());
    let momenta = |at: &Stage| beam.momentum(&setting(0.0), &at.q, &at.v);
    let [push, turn] = momenta(&start);
    let mut worst = [0.0_f64; 2];
    let moving = MovingBeam { beam: &beam, setting: &setting };
    run(&moving, start, 2.5e-4, 1000, |_, at| {
        let [p, l] = momenta(at);
        worst =
            [worst[0].max((p - push).norm() / push.norm()), worst[1].max((l - turn).norm() / turn.norm())];
    })?;
    let source = "conservation of momentum";
    let metric = |what: &str| {
        format!("largest relative change of the {what} of a free bending beam in 0.25 s, 1000 steps")
    };
    Ok(vec![
        ComparisonRow::judged("fsi.beam.momentum", source, &metric("momentum"), worst[0], 1e-10, ""),
        ComparisonRow::judged(
            "fsi.beam.momentum.angular",
            source,
            &metric("angular momentum"),
            worst[1],
            1e-10,
            "",
        ),
    ])
}

pub fn derivatives() -> Result<Vec<ComparisonRow>, Error> {
    let beam = limp(3)?;
    let load = Load {
        moment: Vec3::new(0.01, 0.02, -0.01),
        ..Load::following(beam.tip(), Vec3::new(0.1, -0.2, 0.3))
    };
    let setting = Setting {
        root: flapping_root(0.5, 9.0, 0.13),
        loads: vec![load],
        damping_s: 0.01,
        ..Setting::default()
    };
    let n = beam.coordinates();
    let mut random = Random::new(11);
    let mut drawn = |size: f64| -> Vec<f64> { (0..n).map(|_| size * random.normal()).collect() };
    let at = [drawn(1.0), drawn(3.0), drawn(20.0)];
    let tangents = beam.tangents(&setting, [&at[0], &at[1], &at[2]], &[]);
    let mut worst = 0.0_f64;
    for (which, tangent) in tangents.iter().enumerate() {
        for j in 0..n {
            let moved = |by: f64| {
                let mut at = at.clone();
                at[which][j] += by;
                let mut out = vec![0.0; n];
                beam.residual(&setting, [&at[0], &at[1], &at[2]], &[], &mut out);
                out
            };
            let h = 1e-3;
            let [a, b, c, d] = [-2.0 * h, -h, h, 2.0 * h].map(moved);
            let scale = tangent.column(j).amax();
            for i in 0..n {
                let difference = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h);
                worst = worst.max((difference - tangent[(i, j)]).abs() / scale);
            }
        }
    }
    let metric = "max error of the derivatives of the motion by coordinates, rates and accelerations, over the column's largest";
    Ok(vec![ComparisonRow::judged(
        "fsi.beam.derivatives",
        "differences of fourth order",
        metric,
        worst,
        1e-6,
        "",
    )])
}

pub fn step_order() -> Result<Vec<ComparisonRow>, Error> {
    let beam = limp(2)?;
    let setting = |t: f64| Setting { root: flapping_root(0.6, 12.0, t), ..Setting::default() };
    let moving = MovingBeam { beam: &beam, setting: &setting };
    let end = |steps: usize| {
        let at = run(&moving, at_rest(vec![0.0; beam.coordinates()]), 0.2 / steps as f64, steps, |_, _| ())?;
        Ok::<_, Error>(beam.places(&Place::IDENTITY, &at.q)[beam.tip()].p)
    };
    let exact = end(1600)?;
    let observed = ((end(100)? - exact).norm() / (end(200)? - exact).norm()).log2();
    Ok(vec![ComparisonRow::order("fsi.beam.step_order", "its own limit, steps halved", observed, 4.0, 0.3)])
}

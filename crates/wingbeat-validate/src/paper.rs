//! The paper's equations (1) to (4), written here once more as they are printed, beside the program's forms of them.

use std::f64::consts::PI;

use wingbeat::aero::{JONES_RATES, JONES_WEIGHTS, LiftingLine, LiftingLineSettings};
use wingbeat::math::{EqualSteps, RK4, Workspace};

use crate::{Case, ComparisonRow, Error};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "paper.equations", quick: true, run: equations },
    Case { id: "paper.wagner_duhamel", quick: true, run: wagner_duhamel },
];

const NODES: usize = 12;
const SPAN: f64 = 0.4054;
const SLOPE: f64 = 2.0 * PI;
/// Flapping rate of the paper's robot, rad/s.
const RATE: f64 = 2.0 * PI * 3.5;
/// A whole cycle and a half, s.
const DURATION: f64 = 1.5 / 3.5;
const STEPS: usize = 3000;

/// Chord of a tapered wing of Aerobat's size, m.
fn chord(arc: f64) -> f64 {
    0.16 - 0.45 * arc.abs()
}

/// Airspeed over time, m/s.
type Speed = fn(f64) -> f64;

fn steady(_: f64) -> f64 {
    0.8
}

/// As the paper's runs could vary: .8 m/s, and .3 m/s at the flapping frequency.
fn varying(t: f64) -> f64 {
    0.8 + 0.3 * (RATE * t).sin()
}

/// Wash of motion of a flapping wing at the arc, m/s.
fn wash_of_motion(t: f64, arc: f64) -> f64 {
    0.2 + 18.0 * arc.abs() * (RATE * t).cos() + 2.0 * arc * (0.5 * RATE * t).sin()
}

/// The printed system: states are the coefficients a_n, then the two lags of (4) at every node.
struct Printed {
    angles: Vec<f64>,
    chords: Vec<f64>,
}

impl Printed {
    fn new() -> Self {
        let angles: Vec<f64> = (1..=NODES).map(|i| i as f64 * PI / (NODES + 1) as f64).collect();
        let chords = angles.iter().map(|t| chord(0.5 * SPAN * t.cos())).collect();
        Self { angles, chords }
    }

    fn sine(&self, n: usize, i: usize) -> f64 {
        ((n + 1) as f64 * self.angles[i]).sin()
    }

    /// Rates of the states in the stream `speed`; writes the lift per span and density by node: U^2 c c_l / 2.
    fn rates(&self, t: f64, speed: f64, x: &[f64], dx: &mut [f64], lift: &mut [f64]) {
        let root = chord(0.0);
        let mut right = [0.0; NODES];
        for i in 0..NODES {
            let (c, half) = (self.chords[i], 0.5 * self.chords[i]);
            // (2)
            let sum: f64 = (0..NODES).map(|n| (n + 1) as f64 * x[n] * self.sine(n, i)).sum();
            let induced = -SLOPE * root * speed / (4.0 * SPAN) * sum / self.angles[i].sin();
            let w = wash_of_motion(t, 0.5 * SPAN * self.angles[i].cos()) + induced;
            // (4) by its two exponentials
            let mut effective = w * (1.0 - JONES_WEIGHTS[0] - JONES_WEIGHTS[1]);
            for k in 0..2 {
                let at = (k + 1) * NODES + i;
                dx[at] = JONES_RATES[k] * speed / half * (w - x[at]);
                effective += JONES_WEIGHTS[k] * x[at];
            }
            let coefficient = SLOPE * effective / speed;
            lift[i] = 0.5 * speed * speed * c * coefficient;
            // (3), solved for sum a_n' sin(n theta)
            let series: f64 = (0..NODES).map(|n| x[n] * self.sine(n, i)).sum();
            right[i] = speed / root * (coefficient / SLOPE - root / c * series);
        }
        for (n, rate) in dx[..NODES].iter_mut().enumerate() {
            let sum: f64 = (0..NODES).map(|i| right[i] * self.sine(n, i)).sum();
            *rate = sum * 2.0 / (NODES + 1) as f64;
        }
    }
}

/// Lift per span and density over a cycle and a half from rest, at every step and node, of rates that write it.
fn history(mut rates: impl FnMut(f64, &[f64], &mut [f64], &mut [f64])) -> Result<Vec<Vec<f64>>, Error> {
    let h = DURATION / STEPS as f64;
    let (mut x, mut dx, mut lift) = (vec![0.0; 3 * NODES], vec![0.0; 3 * NODES], vec![0.0; NODES]);
    let mut work = Workspace::new(3 * NODES, 4);
    let mut history = Vec::with_capacity(STEPS);
    for k in 0..STEPS {
        let t = k as f64 * h;
        rates(t, &x, &mut dx, &mut lift);
        history.push(lift.clone());
        let mut aside = vec![0.0; NODES];
        let mut step = |t: f64, x: &[f64], dx: &mut [f64]| {
            rates(t, x, dx, &mut aside);
            Ok::<(), Error>(())
        };
        RK4.integrate(&mut step, EqualSteps::new(t, h, 1), &mut x, &mut work)?;
    }
    Ok(history)
}

/// The same of the program's line under `settings`.
fn line_history(settings: LiftingLineSettings, speed: Speed) -> Result<Vec<Vec<f64>>, Error> {
    let line = LiftingLine::with_chords(0.5 * SPAN, chord, settings)?;
    let arcs = line.node_arcs().to_vec();
    history(|t, x, dx, lift| {
        let stream = vec![speed(t); NODES];
        let wash: Vec<f64> = arcs.iter().map(|&arc| wash_of_motion(t, arc)).collect();
        line.rates_in_wash(&stream, &wash, x, dx, lift);
        for (lift, &arc) in lift.iter_mut().zip(&arcs) {
            *lift *= 0.5 * stream[0] * SLOPE * chord(arc);
        }
    })
}

fn printed_history(speed: Speed) -> Result<Vec<Vec<f64>>, Error> {
    let printed = Printed::new();
    history(|t, x, dx, lift| printed.rates(t, speed(t), x, dx, lift))
}

/// Largest difference of two histories over the largest value of the second.
fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let flat = |h: &[Vec<f64>]| h.iter().flatten().copied().collect::<Vec<f64>>();
    let (a, b) = (flat(a), flat(b));
    let largest = b.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    a.iter().zip(&b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest
}

/// Rows of both forms, in a constant and in a varying stream.
fn equations() -> Result<Vec<ComparisonRow>, Error> {
    let nodal = LiftingLineSettings { nodes: NODES, chord_floor_m: 1e-9, ..Default::default() };
    let source = "the paper's eqs. (1) to (4), written apart";
    let lift = "worst difference of lift per span over its largest, 1.5 cycles at 3.5 Hz";
    let constant = printed_history(steady)?;
    let changing = printed_history(varying)?;
    let differs = |settings, speed, printed: &[Vec<f64>]| -> Result<f64, Error> {
        Ok(difference(&line_history(settings, speed)?, printed))
    };
    let row = |id: &str, what: &str, value| {
        ComparisonRow::judged(id, source, &format!("{lift}, {what}"), value, 1e-12, "")
    };
    Ok(vec![
        row("paper.equations", "nodal form, constant U", differs(nodal, steady, &constant)?),
        row(
            "paper.equations.as_printed",
            "preset as_printed, U varying",
            differs(nodal.printed(), varying, &changing)?,
        ),
        ComparisonRow::shown(
            "paper.equations.varying",
            source,
            &format!("{lift}: what the printed form loses, U = .8 + .3 sin(2 pi 3.5 t) m/s"),
            differs(nodal, varying, &changing)?,
            "",
        ),
    ])
}

/// The program's lags in a varying stream and wash beside Duhamel's integral over the distance in semi-chords, by
/// Simpson's rule; an aspect ratio of 1e9, so that no wake interferes.
fn wagner_duhamel() -> Result<Vec<ComparisonRow>, Error> {
    let (half, duration, steps, panels) = (0.08, 0.6, 6000, 6000);
    let speed = |t: f64| 0.9 + 0.35 * (7.0 * t).sin();
    // Distance travelled in semi-chords.
    let travel = |t: f64| (0.9 * t + 0.05 * (1.0 - (7.0 * t).cos())) / half;
    let wash = |t: f64| 0.3 + 0.4 * (22.0 * t).cos() + 0.1 * (5.0 * t).sin();
    let wash_rate = |t: f64| -8.8 * (22.0 * t).sin() + 0.5 * (5.0 * t).cos();
    let wagner = |s: f64| {
        1.0 - JONES_WEIGHTS[0] * (-JONES_RATES[0] * s).exp() - JONES_WEIGHTS[1] * (-JONES_RATES[1] * s).exp()
    };
    let duhamel = |t: f64| {
        let at = |s: f64| wash_rate(s) * wagner(travel(t) - travel(s));
        let h = t / panels as f64;
        let weight = |k: usize| if k == 0 || k == panels { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
        let sum: f64 = (0..=panels).map(|k| weight(k) * at(k as f64 * h)).sum();
        wash(0.0) * wagner(travel(t)) + sum * h / 3.0
    };
    let settings = LiftingLineSettings { nodes: 3, chord_floor_m: 1e-9, ..Default::default() };
    let line = LiftingLine::with_chords(1e9 * half, |_| 2.0 * half, settings)?;
    let (mut x, mut dx, mut found) = (vec![0.0; 9], vec![0.0; 9], vec![0.0; 3]);
    let mut work = Workspace::new(9, 4);
    let h = duration / steps as f64;
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for k in 0..=steps {
        let t = k as f64 * h;
        line.rates_in_wash(&[speed(t); 3], &[wash(t); 3], &x, &mut dx, &mut found);
        if k % 300 == 0 {
            let exact = duhamel(t);
            largest = largest.max(exact.abs());
            worst = worst.max((found[1] - exact).abs());
        }
        let mut aside = [0.0; 3];
        let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| {
            line.rates_in_wash(&[speed(t); 3], &[wash(t); 3], x, dx, &mut aside);
            Ok::<(), Error>(())
        };
        RK4.integrate(&mut rates, EqualSteps::new(t, h, 1), &mut x, &mut work)?;
    }
    let metric = "worst error of the effective wash over its largest, U and wash varying";
    let source = "Duhamel's integral of Jones' fit, by quadrature; the paper's eq. (4)";
    Ok(vec![ComparisonRow::judged("paper.wagner_duhamel", source, metric, worst / largest, 1e-6, "")])
}

//! A flap on a spring in plane flow: at rest against Glauert's theory, moving against thin-aerofoil theory by series.

use super::C;
use super::membrane::SailSheet;
use super::theodorsen::deficiency;
use crate::{ComparisonRow, Error};
use std::f64::consts::{PI, TAU};
use wingbeat::aero::{
    FlapSpec, LagSet, LiftLaw, Loads, Planform, PlanformStation, ProfileDrag, SectionMotion, SectionSettings,
    StripModel, StripSettings,
};
use wingbeat::math::{RK4, Vec3, Workspace};
use wingbeat::tether::{Clock, Coordinate, Motion};

/// A flap of that share of the chord on a spring of that stiffness, N/rad; every other number is chosen.
fn flap(chord_fraction: f64, stiffness_n_rad: f64, rest_deg: f64) -> FlapSpec {
    FlapSpec {
        chord_fraction,
        stiffness_n_rad,
        areal_density_kg_m2: DENSITY,
        damping_s: DAMPING,
        rest_deg,
        from_arc_m: 0.0,
        to_arc_m: None,
    }
}

/// Mass of the flaps over their area, of the order of the air that they carry, kg/m2.
const DENSITY: f64 = 0.3;
/// Time of their springs' own damping, chords of travel.
const DAMPING: f64 = 0.05;
/// Shares of the chord.
const SHARES: [f64; 3] = [0.15, 0.3, 0.6];

/// Loads of the chord in a flow of 1 m/s and 1 kg/m3 over the half chord: lift, nose-up moment about mid chord, moment of the hinge.
struct Answer {
    lift: C,
    moment: C,
    hinge: C,
}

/// Terms of the series, and least number of points over the chord.
const TERMS: usize = 160;
const POINTS: usize = 1600;

/// A number of points that lets the hinge lie between two of them, as near to their middle as a few hundred more allow.
fn points(hinge: f64) -> usize {
    let part = (-hinge).acos() / PI;
    let off = |n: usize| (part * n as f64 - (part * n as f64).round()).abs();
    (POINTS..POINTS + 400).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(POINTS)
}

/// By the series of the wash over x = -cos t with b = 1: w = B_0 + sum B_n cos n t makes a jump of potential sum 2 B_n phi_n, phi_0 = sin t,
/// phi_1 = (sin 2t)/4, phi_n = [sin (n + 1) t/(n + 1) - sin (n - 1) t/(n - 1)]/2; it presses with its rate and its slope, and
/// Q = B_0 - B_1/2 with 2 Q [C cot(t/2) + x/sin t] (Theodorsen 1935, sections on the potentials and the wake). `k` is the reduced
/// frequency, `share` that of the flap.
fn series(k: f64, deficiency: C, share: f64, wash: impl Fn(f64) -> C) -> Answer {
    let hinge = 1.0 - 2.0 * share;
    let count = points(hinge);
    let angles: Vec<f64> = (0..count).map(|i| (i as f64 + 0.5) * PI / count as f64).collect();
    let term = |n: usize| {
        let sum: C = angles.iter().map(|t| wash(-t.cos()) * (n as f64 * t).cos()).sum();
        sum * if n == 0 { 1.0 } else { 2.0 } / count as f64
    };
    let b: Vec<C> = (0..TERMS).map(term).collect();
    let q = b[0] - b[1] * 0.5;
    let mut answer = Answer { lift: C::ZERO, moment: C::ZERO, hinge: C::ZERO };
    for t in angles {
        let (mut potential, mut slope) = (C::ZERO, C::ZERO);
        for (n, b) in b.iter().enumerate() {
            let sine = |m: usize| (m as f64 * t).sin() / m as f64;
            let cosine = |m: usize| (m as f64 * t).cos();
            let [of, by] = match n {
                0 => [t.sin(), t.cos()],
                1 => [0.5 * sine(2), 0.5 * cosine(2)],
                n => [0.5 * (sine(n + 1) - sine(n - 1)), 0.5 * (cosine(n + 1) - cosine(n - 1))],
            };
            potential += b * of;
            slope += b * by;
        }
        // Times dx = sin t dt.
        let x = -t.cos();
        let pressure = slope + C::i() * k * potential * t.sin() + q * (deficiency * (1.0 + t.cos()) + x);
        let load = pressure * (2.0 * PI / count as f64);
        answer.lift += load;
        answer.moment -= load * x;
        answer.hinge -= load * (x - hinge).max(0.0);
    }
    answer
}

/// The chord heaves with the rate cos, or pitches about its middle by cos, with a flap on its spring.
#[derive(Clone, Copy, PartialEq)]
enum FlapMotion {
    Heave,
    Pitch,
}

/// Amplitudes over that of the motion: lift, moment about mid chord, angle of the flap, in units of half chord, speed and density.
struct FlapAnswer {
    lift: C,
    moment: C,
    angle: C,
}

/// By the series and the balance of the hinge: I b'' + (motion of the sheet) + k (1 + i w tau) b = moment of the air.
fn exact(share: f64, stiffness: f64, k: f64, moved: FlapMotion, deficiency: C) -> FlapAnswer {
    let (hinge, i) = (1.0 - 2.0 * share, C::i() * k);
    let chord = |x: f64| match moved {
        // Down is positive for the wash.
        FlapMotion::Heave => C::from(-1.0),
        FlapMotion::Pitch => 1.0 + i * x,
    };
    let bent = |x: f64| if x > hinge { 1.0 + i * (x - hinge) } else { C::ZERO };
    let (of_chord, of_flap) = (series(k, deficiency, share, chord), series(k, deficiency, share, bent));
    // In half chords, as k and the loads; the sheet is 2 x share long, and its mass over rho b is twice that over rho c.
    let (length, mass) = (2.0 * share, 2.0 * DENSITY);
    let [first, second] = [mass * length * length / 2.0, mass * length.powi(3) / 3.0];
    let along = match moved {
        FlapMotion::Heave => -i * first,
        FlapMotion::Pitch => i * i * (first * hinge + second),
    };
    // Moments over rho V^2 b^2 and span: the spring's is over rho V^2 c^2 where c is 1.
    let spring = 4.0 * stiffness * (1.0 + i * 2.0 * DAMPING);
    let angle = (of_chord.hinge - along) / (spring + i * i * second - of_flap.hinge);
    // The wing bears the inertia of the sheet besides.
    let turning = i * i * angle;
    FlapAnswer {
        lift: of_chord.lift + of_flap.lift * angle + turning * first,
        moment: of_chord.moment + of_flap.moment * angle - turning * (first * hinge + second),
        angle,
    }
}

/// Rate of heave over speed, and pitch: small.
const AMPLITUDE: f64 = 1e-3;
/// Steps of a cycle.
const STEPS: usize = 400;

/// The same of preset full.
fn strips(share: f64, stiffness: f64, k: f64, moved: FlapMotion) -> Result<FlapAnswer, Error> {
    let rate = 2.0 * k;
    let clock = Clock { frequency_hz: rate / TAU, cycles: 8, steps_per_cycle: STEPS };
    let fourier =
        |cos: Vec<f64>, sin: Vec<f64>| Coordinate::Fourier { frequency_hz: rate / TAU, mean: 0.0, cos, sin };
    let motion = match moved {
        FlapMotion::Heave => {
            Motion { heave: fourier(Vec::new(), vec![AMPLITUDE / rate]), ..Motion::at_rest() }
        }
        FlapMotion::Pitch => Motion { nose_up: fourier(vec![AMPLITUDE], Vec::new()), ..Motion::at_rest() },
    };
    let flap = Some(flap(share, stiffness, 0.0));
    let (cycle, area) = SailSheet { membrane: None, flap, law: LiftLaw::Linear, motion, clock }.loads()?;
    let mut found = FlapAnswer { lift: C::ZERO, moment: C::ZERO, angle: C::ZERO };
    for (step, loads) in cycle.iter().enumerate() {
        let turn = C::from_polar(2.0 / STEPS as f64 / AMPLITUDE, -TAU * step as f64 / STEPS as f64);
        found.lift += turn * (2.0 * loads.wrench.force[2] / area);
        found.moment -= turn * (4.0 * loads.wrench.moment[1] / area);
        found.angle += turn * loads.flap[0];
    }
    Ok(found)
}

/// Wagner's lags of the strips in place of Theodorsen's function: w/2 + sum of the lags.
fn lagged(k: f64) -> C {
    let lags = LagSet::Three.lags();
    let terms = lags.rate.iter().zip(lags.lift).map(|(rate, weight)| weight * rate / (rate + C::i() * k));
    terms.sum::<C>() + 0.5
}

/// A flap that the air of a heaving and of a pitching chord turns.
pub fn moving() -> Result<Vec<ComparisonRow>, Error> {
    let source = "thin-aerofoil theory by 160 terms (Theodorsen 1935), own";
    let mut worst = [[0.0_f64; 3]; 2];
    for moved in [FlapMotion::Heave, FlapMotion::Pitch] {
        for k in [0.1, 0.3, 0.6] {
            for (share, stiffness) in [(0.15, 0.01), (0.3, 0.05), (0.3, 1.0), (0.6, 0.3)] {
                let found = strips(share, stiffness, k, moved)?;
                for (of, function) in [lagged(k), deficiency(k)].into_iter().enumerate() {
                    let exact = exact(share, stiffness, k, moved, function);
                    let pairs =
                        [(found.lift, exact.lift), (found.moment, exact.moment), (found.angle, exact.angle)];
                    for (worst, (found, exact)) in worst[of].iter_mut().zip(pairs) {
                        *worst = worst.max((found - exact).norm() / exact.norm());
                    }
                }
            }
        }
    }
    let mut rows = Vec::new();
    for (of, (function, limit)) in [("lags", 1e-3), ("theodorsen", 0.05)].into_iter().enumerate() {
        let with = if of == 0 {
            "the strips' own lags in place of Theodorsen's function"
        } else {
            "Theodorsen's function"
        };
        for (name, value) in ["lift", "moment", "angle"].into_iter().zip(worst[of]) {
            let what = if name == "angle" { "angle of the flap" } else { name };
            let metric = format!(
                "worst complex error of the {what}, chord in heave and pitch at k .1 to .6, four flaps on springs, {with}"
            );
            rows.push(ComparisonRow::judged(
                &format!("fsi.flap.moving.{name}.{function}"),
                source,
                &metric,
                value,
                limit,
                "",
            ));
        }
    }
    Ok(rows)
}

/// Slope of the lift by the angle of a stiff flap, and the angle of soft ones at an incidence.
pub fn rest() -> Result<Vec<ComparisonRow>, Error> {
    let (mut slope, mut turned) = (0.0_f64, 0.0_f64);
    let (rest_deg, incidence) = (0.05, 1e-3);
    for share in SHARES {
        let still = |stiffness: f64, rest_deg: f64, alpha: f64| -> Result<(Loads<f64>, f64), Error> {
            let motion = Motion { nose_up: Coordinate::Constant(alpha), ..Motion::at_rest() };
            let clock = Clock { frequency_hz: 1.0 / 300.0, cycles: 1, steps_per_cycle: 6000 };
            let flap = Some(flap(share, stiffness, rest_deg));
            let sheet = SailSheet { membrane: None, flap, law: LiftLaw::Linear, motion, clock };
            let (mut cycle, area) = sheet.loads()?;
            let last = cycle.pop().ok_or_else(|| Error::NoAnswer("a run without steps".into()))?;
            Ok((last, area))
        };
        let (loads, area) = still(3.0 * share * share, rest_deg, 0.0)?;
        // Glauert: 2 (pi - a + sin a), a the angle of the hinge, cos a = 2 share - 1 reversed.
        let arc = (1.0 - 2.0 * share).acos();
        let found = loads.wrench.force[2] / (0.5 * area * loads.flap[0]);
        slope = slope.max((found / (2.0 * (arc + arc.sin())) - 1.0).abs());
        for stiffness in [0.05, 0.2, 1.0] {
            let stiffness = stiffness * share * share;
            let (loads, _) = still(stiffness, 0.0, incidence)?;
            let [of_chord, of_flap] = [0.0, 1.0].map(|bent| {
                let wash = |x: f64| C::from(if bent == 0.0 || x > 1.0 - 2.0 * share { 1.0 } else { 0.0 });
                series(0.0, C::from(1.0), share, wash).hinge.re
            });
            let exact = incidence * of_chord / (4.0 * stiffness - of_flap);
            turned = turned.max((loads.flap[0] / exact - 1.0).abs());
        }
    }
    let source = "Glauert 1927, R. & M. 1095";
    Ok(vec![
        ComparisonRow::judged(
            "fsi.flap.rest.slope",
            source,
            "max relative error of the lift over the angle of a stiff flap, 15, 30 and 60 % of the chord",
            slope,
            2e-3,
            "",
        ),
        ComparisonRow::judged(
            "fsi.flap.rest.hinge",
            "thin-aerofoil theory by 160 terms, own",
            "max relative error of the angle of flaps that the lift of the chord turns against soft to stiff springs",
            turned,
            2e-3,
            "",
        ),
    ])
}

/// A wing of that mass (kg) and inertia (kg m2), free to heave and to pitch in air at rest, whose flap was let go.
fn free(model: &StripModel, x: &[f64], dx: &mut [f64]) -> f64 {
    const MASS: f64 = 6.0;
    const INERTIA: f64 = 0.9;
    let [heave, pitch] = [x[0], x[1]];
    let ends = [0.5, -0.5];
    let section = |y: &f64| {
        let [le, te] = ends.map(|along| Vec3([along, *y, 0.0]));
        let [v_le, v_te] = ends.map(|along| Vec3([0.0, 0.0, heave + pitch * along]));
        SectionMotion { le, te, span: Vec3([0.0, -1.0, 0.0]), v_le, v_te, ..Default::default() }
    };
    let sections: Vec<_> = model.arcs().iter().map(section).collect();
    let mut loads = Loads::default();
    model.evaluate(&sections, Vec3::ZERO, &x[2..], &mut dx[2..], &mut loads);
    // Nose up turns about -y.
    let m = &loads.added_mass;
    let ([a, b, d], [f, g]) =
        ([MASS + m[2][2], -m[2][4], INERTIA + m[4][4]], [loads.wrench.force[2], -loads.wrench.moment[1]]);
    let inverse = 1.0 / (a * d - b * b);
    (dx[0], dx[1]) = ((d * f - b * g) * inverse, (a * g - b * f) * inverse);
    0.5 * (MASS * heave * heave + INERTIA * pitch * pitch)
}

/// Energy of wing, flap and air that rests but for them: with the masses of thin-aerofoil theory.
pub fn energy() -> Result<Vec<ComparisonRow>, Error> {
    let (share, stiffness, span) = (0.4, 0.8, 10.0);
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
    let planform = Planform::new(&[station(0.0), station(0.5 * span)])?;
    let settings = StripSettings {
        strips: 2,
        regularisation_m_s: 1e-12,
        wake_wash: false,
        doublet_wash: false,
        section: SectionSettings {
            law: LiftLaw::Linear,
            drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
            density_kg_m3: 1.0,
            ..Default::default()
        },
        flap: Some(FlapSpec { damping_s: 0.0, ..flap(share, stiffness, 0.0) }),
        ..Default::default()
    };
    let model = StripModel::new(&planform, settings)?;
    let area: f64 = model.widths().iter().sum();
    let at = 2 + model.channels().iter().position(|c| c.name == "flap_0").unwrap_or_default();
    let mut x = vec![0.0; 2 + model.states()];
    // So small that what is of their squares is nothing.
    (x[0], x[1]) = (1e-9, -2e-9);
    x[at..at + 2].fill(5e-9);
    let masses = masses(share);
    let total = |x: &[f64]| {
        let mut dx = vec![0.0; x.len()];
        let wing = free(&model, x, &mut dx);
        // Downwards, nose up, trailing edge down.
        let rates = [-x[0], x[1], dx[at]];
        let carried: f64 = (0..3)
            .flat_map(|r| (0..3).map(move |c| (r, c)))
            .map(|(r, c)| 0.5 * masses[r][c] * rates[r] * rates[c])
            .sum();
        wing + area * (carried + 0.5 * stiffness * x[at] * x[at])
    };
    let rates = |_: f64, x: &[f64], dx: &mut [f64]| -> Result<(), std::convert::Infallible> {
        free(&model, x, dx);
        Ok(())
    };
    let (step, mut work) = (1e-3, Workspace::new(x.len(), RK4.b.len()));
    let (start, mut lacking, mut moved) = (total(&x), 0.0_f64, 0.0_f64);
    let first = x[0];
    for k in 0..4000 {
        let _ = RK4.step(rates, k as f64 * step, step, &mut x, &mut work);
        lacking = lacking.max((total(&x) - start).abs() / start);
        moved = moved.max((x[0] - first).abs());
    }
    if moved < 1e-10 {
        return Err(Error::NoAnswer("a flap that does not move its wing".into()));
    }
    let metric = "largest change of the energy of wing, flap, spring and carried air over it, free to heave and pitch in air at rest, a flap let go";
    let source = "conservation of energy; masses of Theodorsen 1935";
    Ok(vec![ComparisonRow::judged("fsi.flap.energy", source, metric, lacking, 1e-8, "")])
}

/// Masses per span of air and sheet on heave (down), pitch about mid chord and flap beyond those of the wing: chord 1 m, 1 kg/m3. Of the air by
/// T1, T3 and T7 of Theodorsen 1935.
fn masses(share: f64) -> [[f64; 3]; 3] {
    let c = 1.0 - 2.0 * share;
    let (root, arc) = ((1.0 - c * c).sqrt(), c.acos());
    let t1 = c * arc - root * (2.0 + c * c) / 3.0;
    let t3 = 0.25 * c * root * arc * (7.0 + 2.0 * c * c)
        - (1.0 - c * c) * (5.0 * c * c + 4.0) / 8.0
        - (0.125 + c * c) * arc * arc;
    let t7 = c * root * (7.0 + 2.0 * c * c) / 8.0 - (0.125 + c * c) * arc;
    let (b2, b3, b4) = (0.25, 0.125, 0.0625);
    // The sheet moves with the wing, whose mass holds its own: what the flap's turn adds.
    let [first, second] = [DENSITY * share * share / 2.0, DENSITY * share.powi(3) / 3.0];
    let (heaved, pitched) = (first - t1 * b3, second + first * 0.5 * c - (t7 + c * t1) * b4);
    [[PI * b2, 0.0, heaved], [0.0, PI / 8.0 * b4, pitched], [heaved, pitched, second - t3 / PI * b4]]
}

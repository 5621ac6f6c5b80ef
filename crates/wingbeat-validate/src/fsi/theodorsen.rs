//! Flutter of the typical section by Theodorsen's exact theory (NACA Report 496, 1935), independent of
//! the library: the k method.

use std::f64::consts::PI;

use super::C;
use super::section::{GYRATION2, TypicalSection};

/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;

/// Theodorsen's function C(k) = H1 / (H1 + i H0), dimensionless, with Hankel functions of the second kind.
pub fn deficiency(k: f64) -> C {
    let ([j0, j1], [y0, y1]) = bessel(k);
    let (h0, h1) = (C::new(j0, -y0), C::new(j1, -y1));
    h1 / (h1 + C::i() * h0)
}

/// J0, J1 and Y0, Y1 by their ascending series (Abramowitz & Stegun 9.1.10 to 9.1.13); for x up to 5.
fn bessel(x: f64) -> ([f64; 2], [f64; 2]) {
    let (quarter, half) = (0.25 * x * x, 0.5 * x);
    let (mut j, mut y) = ([0.0; 2], [0.0; 2]);
    let (mut term, mut harmonic) = (1.0, 0.0);
    for m in 0..40 {
        let next = harmonic + 1.0 / f64::from(m + 1);
        j[0] += term;
        y[0] -= 2.0 * harmonic * term;
        let odd = term * half / f64::from(m + 1);
        j[1] += odd;
        y[1] -= (harmonic + next) * odd;
        term *= -quarter / f64::from((m + 1) * (m + 1));
        harmonic = next;
    }
    let log = 2.0 * (half.ln() + EULER);
    (j, [(y[0] + log * j[0]) / PI, (y[1] + log * j[1] - 2.0 / x) / PI])
}

/// Speed U / (b omega_a) and frequency omega / omega_a of flutter.
#[derive(Clone, Copy, Debug)]
pub struct Flutter {
    /// Speed as a ratio, U / (b omega_a).
    pub speed: f64,
    /// Frequency as a ratio, omega / omega_a.
    pub frequency: f64,
}

/// Reduced frequencies omega b / U searched, from the largest down, by this factor.
const SEARCHED: (f64, f64, f64) = (4.0, 0.02, 0.998);

/// The lowest speed of flutter: where the structural damping that a harmonic motion needs turns positive.
pub fn flutter(section: &TypicalSection) -> Option<Flutter> {
    let (first, last, factor) = SEARCHED;
    let mut found: Vec<Flutter> = Vec::new();
    let mut k = first;
    let mut roots = characteristic(section, k);
    while k > last {
        let next = k * factor;
        let ahead = follow(roots, characteristic(section, next));
        for i in 0..2 {
            let turns = roots[i].im < 0.0 && ahead[i].im >= 0.0;
            if turns && ahead[i].re > 0.0 {
                found.push(refine(section, (k, roots[i]), next));
            }
        }
        (k, roots) = (next, ahead);
    }
    found.into_iter().min_by(|a, b| a.speed.total_cmp(&b.speed))
}

/// `roots` in the order in which they continue `before`.
fn follow(before: [C; 2], roots: [C; 2]) -> [C; 2] {
    let kept = (before[0] - roots[0]).norm() + (before[1] - roots[1]).norm();
    let swapped = (before[0] - roots[1]).norm() + (before[1] - roots[0]).norm();
    if kept <= swapped { roots } else { [roots[1], roots[0]] }
}

/// The crossing between `stable` and the reduced frequency `unstable`, by halving.
fn refine(section: &TypicalSection, stable: (f64, C), mut unstable: f64) -> Flutter {
    let (mut k, mut root) = stable;
    for _ in 0..60 {
        let middle = 0.5 * (k + unstable);
        let roots = characteristic(section, middle);
        let nearest = if (roots[0] - root).norm() < (roots[1] - root).norm() { roots[0] } else { roots[1] };
        if nearest.im < 0.0 { (k, root) = (middle, nearest) } else { unstable = middle }
    }
    let frequency = root.re.sqrt().recip();
    Flutter { speed: frequency / k, frequency }
}

/// Lift and nose-up moment about the axis `a` semi-chords aft of mid chord, by h and alpha, at the reduced frequency `k`. With h
/// positive down in semi-chords, over pi rho b3 omega2 and pi rho b4 omega2 they are
/// l = -h + a alpha + i alpha / k + (2 C / k) w, m = -a h + (1/8 + a2) alpha - (1/2 - a) i alpha / k
/// + (2 C / k) (1/2 + a) w, with w = i h + alpha / k + (1/2 - a) i alpha the wash at 3/4 chord.
pub fn loads(a: f64, k: f64) -> [[C; 2]; 2] {
    let i = C::i();
    let circulatory = deficiency(k) * (2.0 / k);
    let wash = [i, C::from(1.0 / k) + i * (0.5 - a)];
    let lift = [circulatory * wash[0] - 1.0, circulatory * wash[1] + a + i / k];
    let moment = [
        circulatory * wash[0] * (0.5 + a) - a,
        circulatory * wash[1] * (0.5 + a) + (0.125 + a * a) - i * ((0.5 - a) / k),
    ];
    [lift, moment]
}

/// Both X = (omega_a / omega)2 (1 + i g) at which the section oscillates harmonically at the reduced frequency `k`.
fn characteristic(section: &TypicalSection, k: f64) -> [C; 2] {
    let TypicalSection { mass_ratio: mu, unbalance: x, frequency_ratio, .. } = *section;
    let [lift, moment] = loads(section.a(), k);
    let inertia = [[lift[0] - mu, lift[1] - mu * x], [-moment[0] - mu * x, -moment[1] - mu * GYRATION2]];
    let (plunge, pitch) = (mu * frequency_ratio * frequency_ratio, mu * GYRATION2);
    let lead = C::from(plunge * pitch);
    let middle = inertia[1][1] * plunge + inertia[0][0] * pitch;
    let last = inertia[0][0] * inertia[1][1] - inertia[0][1] * inertia[1][0];
    let root = (middle * middle - lead * last * 4.0).sqrt();
    [(-middle + root) / (lead * 2.0), (-middle - root) / (lead * 2.0)]
}

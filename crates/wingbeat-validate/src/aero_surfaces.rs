//! Surfaces of preset `full` in each other's wash: biplane and tandem.

use crate::aero_full::ComparedPreset;
use crate::aero_full::lattice::downwash;
use crate::aero_full::wings::{ellipse, rectangle};
use crate::{Case, ComparisonRow, Error};
use std::f64::consts::PI;
use wingbeat::aero::{Loads, Planform, SectionMotion, Surfaces};
use wingbeat::math::Vec3;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "aero.biplane", quick: true, run: biplane },
    Case { id: "aero.tandem", quick: true, run: tandem },
];

/// Incidence of the wind, rad: small, so that lift is linear in it.
const INCIDENCE: f64 = 1e-3;
/// Gap of the biplane over its span, and Prandtl's interference factor there (1924, NACA TN 182).
const GAP: f64 = 0.2;
const PRANDTL: f64 = 0.485;
/// A distance at which surfaces no longer feel each other, chords.
const FAR: f64 = 1e4;

/// A flat surface: its outline, strips, and the place of its middle.
struct FlatSurface {
    outline: Planform,
    strips: usize,
    at: Vec3,
}

/// Steady loads of flat, parallel surfaces in a wind of 1 m/s at a small incidence.
fn steady(flat: &[FlatSurface]) -> Result<Loads<f64>, Error> {
    let mut named = Vec::new();
    for (k, f) in flat.iter().enumerate() {
        named.push((
            format!("surface{k}"),
            ComparedPreset::Full.model_of(f.strips, &f.outline, &[], 1.0, 1e-6)?,
        ));
    }
    let surfaces = Surfaces::new(named)?;
    let of = |(surface, f): (&wingbeat::aero::Surface, &FlatSurface)| -> Vec<SectionMotion<f64>> {
        let section = |&arc: &f64| {
            let (leading, trailing) = f.outline.edges(arc);
            let at = |x: f64| f.at + Vec3::new(x, arc, 0.0);
            SectionMotion { le: at(leading), te: at(trailing), ..SectionMotion::default() }
        };
        surface.aero().arcs().iter().map(section).collect()
    };
    let sections: Vec<_> = surfaces.surfaces().iter().zip(flat).flat_map(of).collect();
    let wind = Vec3::new(-INCIDENCE.cos(), 0.0, INCIDENCE.sin());
    let (mut x, mut dx) = (vec![0.0; surfaces.states()], vec![0.0; surfaces.states()]);
    let mut loads = Loads::default();
    for _ in 0..6000 {
        surfaces.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 0.04 * d);
    }
    surfaces.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
    Ok(loads)
}

/// Interference factor of two equal elliptic wings without stagger: the induced drag of both at equal lift is
/// 2 L^2 (1 + sigma) / (pi q b^2).
fn interference(aspect: f64, strips: usize) -> Result<f64, Error> {
    let span = 0.25 * aspect * PI;
    let drag_over_lift2 = |gap: f64| -> Result<f64, Error> {
        let at = |height: f64| -> Result<FlatSurface, Error> {
            Ok(FlatSurface { outline: ellipse(aspect)?, strips, at: Vec3::new(0.0, 0.0, height) })
        };
        let force = steady(&[at(0.0)?, at(gap)?])?.wrench.force;
        let wind = Vec3::new(-INCIDENCE.cos(), 0.0, INCIDENCE.sin());
        let lift = force.dot(Vec3::new(INCIDENCE.sin(), 0.0, INCIDENCE.cos()));
        Ok(force.dot(wind) / (lift * lift))
    };
    Ok(drag_over_lift2(GAP * span)? / drag_over_lift2(FAR)? - 1.0)
}

/// The same of elliptic loadings by quadrature in the plane far behind: int G w dy over int G dy,
/// G = sqrt(1 - y^2), with w the other wake's wash across the gap in units of the wake's own, which is
/// the same all over the span. With y = cos t both integrals are sums without end terms.
pub fn elliptic_interference(gap: f64) -> f64 {
    let n = 400;
    let angle = |i: i32| (f64::from(i) + 0.5) * PI / f64::from(n);
    let wash = |y: f64| -> f64 {
        // Vortices -dG = cos(t) dt at eta = cos(t).
        let of = |i: i32| {
            let apart = y - angle(i).cos();
            angle(i).cos() * apart / (apart * apart + 4.0 * gap * gap)
        };
        -(0..n).map(of).sum::<f64>() / f64::from(n)
    };
    let mutual: f64 = (0..n).map(|i| angle(i).sin().powi(2) * wash(angle(i).cos())).sum();
    let own: f64 = (0..n).map(|i| angle(i).sin().powi(2)).sum();
    (mutual / own).abs()
}

/// Interference factor of a biplane against Prandtl's.
pub fn biplane() -> Result<Vec<ComparisonRow>, Error> {
    let error = |factor: f64| (factor / PRANDTL - 1.0).abs();
    let source = "Prandtl 1924, NACA TN 182: 0.485 at gap/span 0.2";
    let metric = "error of the interference factor, ellipses of AR 20, 16 strips each";
    let shown =
        |id: &str, metric: &str, factor: f64| ComparisonRow::shown(id, source, metric, error(factor), "");
    Ok(vec![
        ComparisonRow::judged("aero.biplane", source, metric, error(interference(20.0, 16)?), 0.03, ""),
        shown("aero.biplane.coarse", "the same with 8 strips each", interference(20.0, 8)?),
        shown("aero.biplane.short", "the same at AR 6", interference(6.0, 16)?),
        shown("aero.biplane.quadrature", "elliptic loadings, by quadrature", elliptic_interference(GAP)),
    ])
}

/// Mean downwash at a tail one span behind a rectangle of AR 6, half as wide, against a linear lattice.
pub fn tandem() -> Result<Vec<ComparisonRow>, Error> {
    let (aspect, chord) = (6.0, 0.5);
    let tail_span = 0.5 * aspect;
    // 3/4 chord of the tail one span behind that of the wing.
    let behind = 0.75 + aspect;
    let exact = mean_downwash(&downwash(aspect, behind, 8, 80)?, tail_span);
    let at = Vec3::new(0.75 * chord - behind, 0.0, 0.0);
    let value = |wing: usize, tail: usize| -> Result<f64, Error> {
        let flat = [
            FlatSurface { outline: rectangle(aspect, 1.0)?, strips: wing, at: Vec3::ZERO },
            FlatSurface { outline: rectangle(tail_span, chord)?, strips: tail, at },
        ];
        let loads = steady(&flat)?;
        let edges = ComparedPreset::Full.model_of(tail, &flat[1].outline, &[], 1.0, 1e-6)?;
        let widths = edges.arcs().windows(2).map(|a| a[0] - a[1]);
        let wash = loads.wash_of_others[wing..wing + tail].iter().zip(widths);
        let (sum, span) = wash.fold((0.0, 0.0), |(sum, span), (w, width)| (sum - w * width, span + width));
        Ok(sum / span / INCIDENCE)
    };
    let source = "linear vortex lattice, 8 x 80 panels";
    let metric = "error of the mean downwash one span behind a rectangle of AR 6, tail of half its span, 16 and 8 strips";
    let error = |value: f64| (value / exact - 1.0).abs();
    Ok(vec![
        ComparisonRow::judged("aero.tandem", source, metric, error(value(16, 8)?), 0.05, ""),
        ComparisonRow::shown(
            "aero.tandem.fine",
            source,
            "the same with 22 and 10 strips",
            error(value(22, 10)?),
            "",
        ),
    ])
}

/// Mean over the middle `span` of a wash given from one tip to the middle.
fn mean_downwash(wash: &[(f64, f64)], span: f64) -> f64 {
    let inside: Vec<&(f64, f64)> = wash.iter().filter(|(y, _)| y.abs() <= 0.5 * span).collect();
    let (mut sum, mut from) = (0.0, -0.5 * span);
    for (k, (y, w)) in inside.iter().enumerate() {
        let to = inside.get(k + 1).map_or(0.0, |next| 0.5 * (y + next.0));
        sum += w * (to - from);
        from = to;
    }
    sum / (0.5 * span)
}

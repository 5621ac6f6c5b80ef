//! Wings over a ground: strip model and lattice by images.

use crate::aero_full::ComparedPreset;
use crate::aero_full::wings::{ellipse, rectangle};
use crate::aero_surfaces::elliptic_interference;
use crate::lattice::{elliptic_over, rectangle_over, rectangle_pair};
use crate::{Case, ComparisonRow, Error};
use std::f64::consts::PI;
use wingbeat::aero::{Ground, Loads, Planform, SectionMotion, Surfaces};
use wingbeat::math::Vec3;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "aero.ground.pair", quick: true, run: pairs },
    Case { id: "aero.ground.drag", quick: true, run: drag },
    Case { id: "aero.ground.lift", quick: true, run: lift },
];

/// Heights over the span.
const HEIGHTS: [f64; 3] = [0.1, 0.25, 0.5];
/// Incidence, rad, of wings whose induced drag is wanted: so small that nothing is lost of the second order.
const SMALL: f64 = 1e-3;
const STEP: f64 = 0.04;

/// A pitched wing at the height z = 0 in a wind of 1 m/s along the plane.
struct Pitched {
    outline: Planform,
    strips: usize,
    incidence: f64,
}

impl Pitched {
    fn sections(&self, surfaces: &Surfaces) -> Vec<SectionMotion<f64>> {
        let (sin, cos) = self.incidence.sin_cos();
        let section = |&arc: &f64| {
            let (leading, trailing) = self.outline.edges(arc);
            let at = |x: f64| Vec3::new(x * cos, arc, x * sin);
            SectionMotion { le: at(leading), te: at(trailing), ..SectionMotion::default() }
        };
        surfaces.surfaces()[0].aero().arcs().iter().map(section).collect()
    }

    fn surfaces(&self, count: usize) -> Result<Surfaces, Error> {
        let aero = ComparedPreset::Full.model_of(self.strips, &self.outline, &[], 1.0, 1e-6)?;
        Ok(Surfaces::new((0..count).map(|k| (format!("wing{k}"), aero.clone())))?)
    }

    /// Loads over a plane `height` m below, or without one, after `steps` from a sudden start; `see` is shown every instant.
    fn over(
        &self,
        height: Option<f64>,
        steps: usize,
        mut see: impl FnMut(&Loads<f64>),
    ) -> Result<Loads<f64>, Error> {
        let alone = self.surfaces(1)?;
        let sections = self.sections(&alone);
        let surfaces = if height.is_some() { alone.over_ground() } else { alone };
        let ground = height.map(|height| Ground { normal: Vec3::new(0.0, 0.0, 1.0), offset: -height });
        let wind = Vec3::new(-1.0, 0.0, 0.0);
        let (mut x, mut dx) = (vec![0.0; surfaces.states()], vec![0.0; surfaces.states()]);
        let mut loads = Loads::default();
        for _ in 0..=steps {
            surfaces.evaluate_over(ground, &sections, wind, &x, &mut dx, &mut loads);
            see(&loads);
            x.iter_mut().zip(&dx).for_each(|(x, d)| *x += STEP * d);
        }
        Ok(loads)
    }

    /// Lift and drag in steady flow.
    fn steady(&self, height: Option<f64>) -> Result<[f64; 2], Error> {
        let force = self.over(height, 4000, |_| ())?.wrench.force;
        Ok([force[2], -force[0]])
    }

    /// Largest difference of a strip's force over a plane from that of a mirrored pair, over the largest force, from a sudden start on.
    fn apart_from_pair(&self, height: f64) -> Result<f64, Error> {
        const STEPS: usize = 200;
        let pair = self.surfaces(2)?;
        let upper = self.sections(&pair);
        let image = |p: Vec3| Vec3::new(p[0], p[1], -2.0 * height - p[2]);
        let lower = upper.iter().map(|s| SectionMotion { le: image(s.le), te: image(s.te), ..*s });
        let sections: Vec<_> = upper.iter().copied().chain(lower).collect();
        let wind = Vec3::new(-1.0, 0.0, 0.0);
        let (mut x, mut dx) = (vec![0.0; pair.states()], vec![0.0; pair.states()]);
        let mut loads = Loads::default();
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        self.over(Some(height), STEPS, |own| {
            pair.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
            for (a, b) in own.strip[..self.strips].iter().zip(&loads.strip) {
                let [a, b] = [a, b].map(|strip| strip.total().force);
                (worst, largest) = (worst.max((a - b).norm()), largest.max(a.norm()));
            }
            x.iter_mut().zip(&dx).for_each(|(x, d)| *x += STEP * d);
        })?;
        Ok(worst / largest)
    }
}

/// Wings over a plane against the upper ones of mirrored pairs.
pub fn pairs() -> Result<Vec<ComparisonRow>, Error> {
    let wing = Pitched { outline: rectangle(4.0, 1.0)?, strips: 12, incidence: 0.1 };
    let source = "method of images";
    let metric = "largest difference of a force from that of the upper wing of a mirrored pair, over the largest, AR 4, height 0.6 chords: strips from a sudden start";
    let lattice = "the same of the panels of a lattice with a free wake";
    Ok(vec![
        ComparisonRow::judged(
            "aero.ground.pair.strips",
            source,
            metric,
            wing.apart_from_pair(0.6)?,
            1e-10,
            "",
        ),
        ComparisonRow::judged("aero.ground.pair.lattice", source, lattice, rectangle_pair(0.6)?, 1e-10, ""),
    ])
}

/// Induced drag of elliptic wings by height.
///
/// Equation: aero.ground_drag
/// `D/L^2 over that in free air = 1 - sigma(2 h/b)`
/// Source: Prandtl 1924, NACA TN 182 (biplane); Wieselsberger 1922, NACA TM 77 (ground): sigma = (1 - 1.32 h/b)/(1.05 + 7.4 h/b), h/b .033 to .25.
/// Test: `wings_over_a_ground_have_prandtls_drag`.
pub fn drag() -> Result<Vec<ComparisonRow>, Error> {
    let aspect = 20.0;
    let wing = Pitched { outline: ellipse(aspect)?, strips: 16, incidence: SMALL };
    let span = 0.25 * aspect * PI;
    let over = |height| wing.steady(height).map(|[lift, drag]| drag / (lift * lift));
    let (free, free_lattice) = (over(None)?, elliptic_over(None)?);
    let mut rows = Vec::new();
    for height in HEIGHTS {
        let exact = 1.0 - elliptic_interference(2.0 * height);
        let [strips, lattice] =
            [over(Some(height * span))? / free, elliptic_over(Some(height))? / free_lattice];
        let wieselsberger = 1.0 - (1.0 - 1.32 * height) / (1.05 + 7.4 * height);
        let source = "elliptic loadings by quadrature (Prandtl 1924)";
        let id = |of: &str| format!("aero.ground.drag.{of}.{:.0}", 100.0 * height);
        let metric = |of: &str| {
            format!(
                "error of the induced drag over its lift squared, over that in free air, at {height} spans, {of}"
            )
        };
        let error = |value: f64| (value / exact - 1.0).abs();
        rows.push(ComparisonRow::judged(
            &id("strips"),
            source,
            &metric("ellipse of AR 20, 16 strips"),
            error(strips),
            0.03,
            "",
        ));
        rows.push(ComparisonRow::judged(
            &id("lattice"),
            source,
            &metric("ellipse of AR 8, 6 x 24 panels"),
            error(lattice),
            0.03,
            "",
        ));
        if height <= 0.25 {
            let source = "Wieselsberger 1922, NACA TM 77";
            rows.push(ComparisonRow::shown(
                &id("formula"),
                source,
                &metric("by his formula"),
                error(wieselsberger),
                "",
            ));
        }
    }
    Ok(rows)
}

/// Steady lift of a rectangle of AR 4 by height, strips against the lattice.
pub fn lift() -> Result<Vec<ComparisonRow>, Error> {
    let aspect = 4.0;
    let mut rows = Vec::new();
    for incidence_deg in [1.0_f64, 8.0] {
        let incidence = incidence_deg.to_radians();
        let wing = Pitched { outline: rectangle(aspect, 1.0)?, strips: 12, incidence };
        let gain = |height: f64| Ok::<_, Error>(wing.steady(Some(height))?[0] / wing.steady(None)?[0]);
        let lattice = |height: f64| {
            Ok::<_, Error>(rectangle_over(incidence, Some(height))? / rectangle_over(incidence, None)?)
        };
        for height in [0.5, 1.0, 2.0] {
            let (strips, lattice) = (gain(height)?, lattice(height)?);
            let id = format!("aero.ground.lift.{incidence_deg:.0}deg.{:.0}", 10.0 * height);
            let metric = format!(
                "error of the lift over that in free air, AR 4 at {incidence_deg} deg, {height} chords high: 12 strips {strips:.3}, lattice {lattice:.3}"
            );
            rows.push(ComparisonRow::shown(
                &id,
                "own lattice, 6 x 24 panels",
                &metric,
                (strips / lattice - 1.0).abs(),
                "",
            ));
        }
    }
    Ok(rows)
}

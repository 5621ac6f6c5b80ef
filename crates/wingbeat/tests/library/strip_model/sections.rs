//! Steady wings whose sections have a zero-lift angle and a lift slope of their own, under both presets and all laws.

use std::f64::consts::PI;
use wingbeat::aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, Loads, Planform, PlanformStation, ProfileDrag,
    SectionMotion, SectionSettings, StripModel, StripSettings,
};
use wingbeat::math::Vec3;

/// A section: zero-lift angle, rad, and lift slope, 1/rad.
#[derive(Clone, Copy)]
struct Section(f64, f64);

/// Chord at the arc `s` of an elliptic wing of unit mean chord.
fn elliptic_chord(aspect: f64, s: f64) -> f64 {
    4.0 / PI * (1.0 - (2.0 * s / aspect).powi(2)).max(0.0).sqrt()
}

fn line(aspect: f64, law: LiftLaw, Section(zero_lift_angle_rad, section_slope): Section) -> Aero {
    let set = LiftingLineSettings {
        chord_floor_m: 1e-9,
        regularisation_m_s: 1e-6,
        section: SectionSettings {
            law,
            zero_lift_angle_rad,
            section_slope,
            drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
            density_kg_m3: 1.0,
            ..Default::default()
        },
        ..Default::default()
    };
    Aero::LiftingLine(LiftingLine::with_chords(0.5 * aspect, |s| elliptic_chord(aspect, s), set).unwrap())
}

fn strips(aspect: f64, law: LiftLaw, section: Section) -> Aero {
    so_many_strips(StripSettings::default().strips, aspect, law, section)
}

fn so_many_strips(
    strips: usize,
    aspect: f64,
    law: LiftLaw,
    Section(zero_lift_angle_rad, section_slope): Section,
) -> Aero {
    let station = |k: i32| {
        let arc_m = 0.5 * aspect * (0.5 * PI * f64::from(k) / 60.0).sin();
        let chord = elliptic_chord(aspect, arc_m).max(1e-3);
        PlanformStation { arc_m, leading_edge_m: 0.25 * chord, trailing_edge_m: -0.75 * chord }
    };
    let wing = Planform::new(&(0..=60).map(station).collect::<Vec<_>>()).unwrap();
    let set = StripSettings {
        strips,
        regularisation_m_s: 1e-6,
        section: SectionSettings {
            law,
            zero_lift_angle_rad,
            section_slope,
            drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
            density_kg_m3: 1.0,
            ..Default::default()
        },
        ..Default::default()
    };
    Aero::Strip(StripModel::new(&wing, set).unwrap())
}

/// Coefficients of lift and drag of the elliptic wing at rest in a wind at the incidence `alpha` (rad).
fn steady(model: &Aero, aspect: f64, alpha: f64) -> [f64; 2] {
    let section = |&s: &f64| {
        let chord = elliptic_chord(aspect, s);
        let at = |x: f64| Vec3::new(x * chord, s, 0.0);
        SectionMotion {
            le: at(0.25),
            te: at(-0.75),
            span: Vec3::new(0.0, -1.0, 0.0),
            ..SectionMotion::default()
        }
    };
    let sections: Vec<_> = model.arcs().iter().map(section).collect();
    let wind = Vec3::new(-alpha.cos(), 0.0, alpha.sin());
    let (mut x, mut dx) = (vec![0.0; model.states()], vec![0.0; model.states()]);
    let mut loads = Loads::default();
    for _ in 0..20_000 {
        model.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 0.02 * d);
    }
    let up = Vec3::new(alpha.sin(), 0.0, alpha.cos());
    [loads.wrench.force.dot(up), loads.wrench.force.dot(wind)].map(|force| force / (0.5 * aspect))
}

const THIN: f64 = 2.0 * PI;

#[test]
fn the_polar_shifts_by_the_zero_lift_angle_under_every_law() {
    let (aspect, angle) = (8.0, -3_f64.to_radians());
    for law in LiftLaw::ALL {
        for (build, near) in [(line as fn(f64, LiftLaw, Section) -> Aero, 1e-9), (strips, 4e-3)] {
            for alpha in [2_f64, 12.0].map(f64::to_radians) {
                let cambered = steady(&build(aspect, law, Section(angle, THIN)), aspect, alpha);
                let flat = steady(&build(aspect, law, Section(0.0, THIN)), aspect, alpha - angle);
                let error = [0, 1].map(|k| (cambered[k] - flat[k]) / flat[0]);
                assert!(error.iter().all(|e| e.abs() < near), "{law:?}: {cambered:?} and {flat:?}");
            }
        }
    }
}

#[test]
fn elliptic_wings_have_prandtls_lift_with_the_slope_of_their_section() {
    let alpha = 0.5_f64.to_radians();
    for (zero_lift, slope) in [(0.0, THIN), (-0.02, 5.0), (0.01, 7.0)] {
        let section = Section(zero_lift, slope);
        let prandtl = |aspect: f64| slope * (alpha - zero_lift) / (1.0 + slope / (PI * aspect));
        let lift = |model: Aero, aspect: f64| steady(&model, aspect, alpha)[0] / prandtl(aspect) - 1.0;
        for aspect in [6.0, 20.0] {
            let error = lift(line(aspect, LiftLaw::Linear, section), aspect);
            assert!(error.abs() < 5e-4, "lifting line, AR {aspect}, slope {slope}: {error}");
        }
        // Sections of another slope lose as much at the tips as thin ones, of which lifting-surface theory says how much.
        let strips = |n: usize| lift(so_many_strips(n, 20.0, LiftLaw::Linear, section), 20.0);
        let [few, some, many] = [8, 16, 32].map(strips);
        let surface = van_dyke(20.0) * (1.0 + 2.0 / 20.0) - 1.0;
        let off = |error: f64| (error - surface).abs();
        assert!(off(few) > off(some) && off(some) > off(many), "slope {slope}: {few}, {some}, {many}");
        assert!(off(some) < 0.01 && off(many) < 0.005, "slope {slope}: {some}, {many} for {surface}");
    }
}

/// Lift slope over 2 pi of a thin elliptic wing by lifting-surface theory, to the second order in 1/aspect: Van Dyke 1964, Perturbation
/// Methods in Fluid Mechanics, ch. 9, third approximation. At an aspect of 6.37 it gives 4.52 and Krienes 1940, without an expansion, 4.55.
fn van_dyke(aspect: f64) -> f64 {
    let (second, ratio) = (2.0 / aspect, 4.0 / (PI * aspect));
    (1.0 + second + ratio * ratio * ((PI * aspect).ln() - 9.0 / 8.0)).recip()
}

#[test]
fn law_lev3d_has_the_limits_of_attached_flow_and_of_the_plate() {
    let aspect = 2.0;
    for build in [line as fn(f64, LiftLaw, Section) -> Aero, strips] {
        let flat = Section(0.0, THIN);
        let bare = build(aspect, LiftLaw::Lev3d, flat);
        let mut numbers = bare.numbers().clone();
        numbers.cd90 = 1.98;
        let plate = bare.with(&numbers).unwrap();
        let alpha = 85_f64.to_radians();
        let [lift, drag] = steady(&plate, aspect, alpha);
        let (normal, sine) = (lift * alpha.cos() + drag * alpha.sin(), alpha.sin());
        let exact = 1.98 * sine * (1.0 / (0.56 + 0.44 * sine) - 0.41 * (1.0 - (-8.5_f64).exp()));
        assert!((normal / exact - 1.0).abs() < 0.02, "{normal} {exact}");
        let [up, down] = [20_f64, -20.0].map(|deg| steady(&plate, aspect, deg.to_radians()));
        assert!((up[0] + down[0]).abs() < 1e-9 && (up[1] - down[1]).abs() < 1e-9, "{up:?} {down:?}");
        let small = 1_f64.to_radians();
        let linear = steady(&build(aspect, LiftLaw::Linear, flat), aspect, small);
        let attached = steady(&plate, aspect, small);
        assert!((attached[0] / linear[0] - 1.0).abs() < 1e-3, "{attached:?} {linear:?}");
    }
}

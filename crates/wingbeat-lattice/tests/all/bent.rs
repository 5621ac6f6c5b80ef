//! Chord lines that are bent, by membranes and flaps.

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat::aero::{ChordBend, SectionMotion};
use wingbeat::math::{Dual, Jet, Scalar, Vec3};
use wingbeat::scenario::Scenario;
use wingbeat_lattice::course::{CourseRequest, RecordedFlight};
use wingbeat_lattice::{
    Lattice, LatticeLoads, LatticeSettings, LatticeSurface, MovingSections, PanelLayout, Scene,
};

type Bend = ChordBend<Dual<1>>;

/// A rectangle of unit chord, its leading edge along y, that is bent as `of` says at a time (s) with its derivative and an arc (m), and
/// turned about its leading edge by the angle, trailing edge down, that `pitch` says.
#[derive(Clone, Copy)]
struct BentPlate {
    of: Option<fn(Dual<1>, f64) -> Bend>,
    pitch: fn(Jet) -> Jet,
}

fn level(_: Jet) -> Jet {
    Jet::default()
}

fn seeded(t: f64) -> Dual<1> {
    Dual { re: t, eps: [1.0] }
}

impl MovingSections for BentPlate {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let pitch = (self.pitch)(Jet::new(t, 1.0, 0.0));
        let (sine, cosine) = pitch.x.sin_cos();
        let w = Vec3::new(0.0, -pitch.d, 0.0);
        out.clear();
        out.extend(arcs.iter().map(|arc| {
            let (le, chord) = (Vec3::new(0.0, *arc, 0.0), Vec3::new(-cosine, 0.0, -sine));
            let span = Vec3::new(0.0, -1.0, 0.0);
            SectionMotion { le, te: le + chord, v_te: w.cross(chord), span, w, ..SectionMotion::default() }
        }));
    }

    fn bends(&self, t: f64, arcs: &[f64], out: &mut Vec<Bend>) {
        out.clear();
        out.extend(self.of.iter().flat_map(|of| arcs.iter().map(|arc| of(seeded(t), *arc))));
    }
}

fn sail(heights: [Dual<1>; 2]) -> Bend {
    ChordBend { heights, angle: Dual::constant(0.0), hinge: 1.0 }
}

fn lattice(plate: BentPlate, span: f64, panels: [usize; 2], settings: LatticeSettings) -> Lattice {
    let [chordwise, strips] = panels;
    let arcs = (0..=strips).map(|j| span * (0.5 - j as f64 / strips as f64)).collect();
    let layout = PanelLayout { chordwise, fractions: vec![0.5; strips], arcs };
    let surfaces = vec![LatticeSurface { layout, sections: Arc::new(plate) }];
    let wind = Vec3::new(-1.0, 0.0, 0.0);
    Lattice::new(Scene { surfaces, wind, density_kg_m3: 1.0, symmetric: false, ground: None }, settings)
        .unwrap()
}

fn run(lattice: &mut Lattice, steps: usize) -> Vec<LatticeLoads> {
    (0..steps).map(|_| lattice.step().unwrap()).collect()
}

const SMALL: f64 = 1e-3;

/// z = .1 y sin^2 t of the first shape: normals along (-dz/dx, -dz/dy, 1) with x backward from the leading edge at 3/4 of each panel; the slope
/// along the chord is that mean around it which the parabola has there.
#[test]
fn normals_of_bends_that_grow_along_the_span_are_those_of_the_surface() {
    let grow: fn(Dual<1>, f64) -> Bend = |_, arc| sail([Dual::constant(0.1 * arc), Dual::constant(0.0)]);
    let plate = BentPlate { of: Some(grow), pitch: level };
    let mut lattice = lattice(plate, 2.0, [8, 6], LatticeSettings::new(1e6, 1e-6));
    run(&mut lattice, 1);
    let controls = &lattice.meshes()[0].controls;
    assert_eq!(controls.len(), 48);
    for control in controls {
        let (x, y) = (-control.at[0], control.at[1]);
        let [by_x, by_y] = [0.4 * y * (1.0 - 2.0 * x), 0.4 * x * (1.0 - x)];
        let exact = Vec3::new(by_x, -by_y, 1.0).unit();
        assert!((control.normal - exact).norm() < 2e-4, "{:?} at {x:.3}, {y:.3}: {exact:?}", control.normal);
    }
}

/// Steady lift and moment about the leading edge of a long wing of each shape of a membrane and of a flap of a quarter of the chord, by
/// both ways to the force, on 4, 8 and 16 panels; Glauert 1926, ch. 7: lift 2 pi (A0 + A1/2), moment about 1/4 chord pi/4 (A2 - A1).
#[test]
fn bent_panels_lift_as_thin_aerofoil_theory_says() {
    let (root, arc) = (0.75_f64.sqrt(), (0.5_f64).acos());
    type Case = (fn(Dual<1>, f64) -> Bend, [f64; 2], [f64; 3]);
    let cases: [Case; 3] = [
        (|_, _| sail([SMALL, 0.0].map(Dual::constant)), [4.0 * PI, -PI], [1e-3; 3]),
        (|_, _| sail([0.0, SMALL].map(Dual::constant)), [-2.0 * PI, 0.75 * PI], [0.035, 0.009, 0.003]),
        (
            |_, _| ChordBend { angle: Dual::constant(SMALL), hinge: 0.75, ..sail([Dual::constant(0.0); 2]) },
            [2.0 * (root + arc), -0.75 * root],
            [0.008, 0.004, 0.002],
        ),
    ];
    for (of, [lift, moment], within) in cases {
        for (chordwise, within) in [4, 8, 16].into_iter().zip(within) {
            let plate = BentPlate { of: Some(of), pitch: level };
            let mut lattice = lattice(plate, 1e4, [chordwise, 4], LatticeSettings::new(1e6, 1e-6));
            let loads = run(&mut lattice, 2);
            for load in [loads[1].joukowski, loads[1].bernoulli] {
                let [found, nose_down] = [load.force[2], load.moment[1]].map(|of| of / (0.5e4 * SMALL));
                assert!((found / lift - 1.0).abs() < within, "{chordwise}: lift {found} {lift}");
                let exact = 0.25 * lift - moment;
                let size = (chordwise * chordwise) as f64;
                assert!(
                    (nose_down / exact - 1.0).abs() < 0.55 / size,
                    "{chordwise}: moment {nose_down} {exact}"
                );
            }
        }
    }
}

/// Virtual work of the pressure on a long wing at a small incidence, along both shapes of a membrane and the angle of a flap of a quarter of
/// the chord, on 4, 8 and 16 panels. Of the camber aero.camber_load at rest: Q_1 = pi (a + 3 h_1 - h_2)/2, Q_2 = pi (a + 2 h_2)/8;
/// of the flap -b^2 [(T5 - T4 T10)/pi angle + T12 (2 a + T10/pi angle)/2], Theodorsen's functions of its hinge (Glauert 1927).
#[test]
fn pressure_bears_on_bends_as_thin_aerofoil_theory_says() {
    let c = 0.5_f64;
    let (root, arc) = ((1.0 - c * c).sqrt(), c.acos());
    let t4 = -arc + c * root;
    let t5 = -(1.0 - c * c) - arc * arc + 2.0 * c * root * arc;
    let (t10, t12) = (root + arc, root * (2.0 + c) - arc * (2.0 * c + 1.0));
    let held = -0.25 * ((t5 - t4 * t10) / PI + t12 * t10 / PI);
    let flat: fn(Dual<1>, f64) -> Bend =
        |_, _| ChordBend { angle: Dual::constant(0.0), hinge: 0.75, ..sail([0.0; 2].map(Dual::constant)) };
    let turned: fn(Dual<1>, f64) -> Bend =
        |_, _| ChordBend { angle: Dual::constant(SMALL), hinge: 0.75, ..sail([0.0; 2].map(Dual::constant)) };
    let inclined: fn(Jet) -> Jet = |_| Jet::new(SMALL, 0.0, 0.0);
    let nothing = f64::NAN;
    // Bend, incidence, works, and how near they are on 4 panels, over the larger of each and pi/8; the error falls by the square.
    type Case = (fn(Dual<1>, f64) -> Bend, fn(Jet) -> Jet, [f64; 3], [f64; 3]);
    let cases: [Case; 5] = [
        (
            |_, _| sail([SMALL, 0.0].map(Dual::constant)),
            level,
            [1.5 * PI, 0.0, nothing],
            [0.001, 0.22, nothing],
        ),
        (
            |_, _| sail([0.0, SMALL].map(Dual::constant)),
            level,
            [-0.5 * PI, 0.25 * PI, nothing],
            [0.25, 0.14, nothing],
        ),
        (
            |_, _| sail([0.0; 2].map(Dual::constant)),
            inclined,
            [0.5 * PI, 0.125 * PI, nothing],
            [0.04, 0.13, nothing],
        ),
        (flat, inclined, [nothing, nothing, -0.25 * t12], [nothing, nothing, 0.15]),
        (turned, level, [nothing, nothing, held], [nothing, nothing, 0.1]),
    ];
    for (of, pitch, exact, within) in cases {
        for chordwise in [4, 8, 16] {
            let settings = LatticeSettings::new(1e6, 1e-6);
            let mut lattice = lattice(BentPlate { of: Some(of), pitch }, 1e4, [chordwise, 4], settings);
            let bends = &run(&mut lattice, 2)[1].panels[0].bends;
            for k in (0..3).filter(|k| exact[*k].is_finite()) {
                let found = bends.iter().map(|strip| strip[k]).sum::<f64>() / (1e4 * SMALL);
                let size = exact[k].abs().max(if k < 2 { PI / 8.0 } else { 0.0 });
                let (off, finer) = ((found - exact[k]).abs() / size, 16.0 / (chordwise * chordwise) as f64);
                assert!(off < (1.15 * within[k] * finer).max(2e-4), "{chordwise} {k}: {found} {}", exact[k]);
            }
        }
    }
}

/// A flap hinged at the leading edge is a plate that pitches about it: places, velocities, normals and forces are the same.
#[test]
fn a_flap_from_the_leading_edge_is_a_plate_that_pitches() {
    fn angle(t: Dual<1>) -> Dual<1> {
        (t * 3.0).sin() * 0.2 + 0.1
    }
    let flap = BentPlate {
        of: Some(|t, _| ChordBend { angle: angle(t), hinge: 0.0, ..sail([Dual::constant(0.0); 2]) }),
        pitch: level,
    };
    let rigid = BentPlate {
        of: None,
        pitch: |t| {
            let angle = angle(seeded(t.x));
            Jet::new(angle.re, angle.eps[0], 0.0)
        },
    };
    let settings = LatticeSettings::new(0.125, 1e-3);
    let [one, other] = [flap, rigid].map(|plate| run(&mut lattice(plate, 3.0, [4, 6], settings), 30));
    for (a, b) in one.iter().zip(&other) {
        for (a, b) in [(a.joukowski, b.joukowski), (a.bernoulli, b.bernoulli)] {
            assert!(
                (a.force - b.force).norm() < 1e-10 && (a.moment - b.moment).norm() < 1e-10,
                "{a:?} {b:?}"
            );
        }
        assert!((a.power - b.power).abs() < 1e-10);
    }
}

fn breathing(t: Dual<1>, arc: f64) -> Bend {
    sail([(t * 3.0).sin() * (0.05 + 0.01 * arc), (t * 2.0).cos() * 0.02])
}

fn turning(t: Jet) -> Jet {
    (t * 2.0).sin() * 0.3
}

/// What a bent wing moves by is the rate of its places.
#[test]
fn points_of_bent_panels_move_as_their_places_say() {
    let step = 1e-4;
    let plate = BentPlate { of: Some(breathing), pitch: turning };
    let mut lattice = lattice(plate, 3.0, [3, 4], LatticeSettings::new(step, 1e-3));
    let seen: Vec<Vec<(Vec3, Vec3)>> = (0..3)
        .map(|_| {
            lattice.step().unwrap();
            let mesh = &lattice.meshes()[0];
            let controls = mesh.controls.iter().map(|c| (c.at, c.velocity));
            controls.chain(mesh.fronts.iter().chain(&mesh.legs).map(|e| (e.at, e.velocity))).collect()
        })
        .collect();
    for ((before, now), after) in seen[0].iter().zip(&seen[1]).zip(&seen[2]) {
        let moved = (after.0 - before.0) * (0.5 / step);
        assert!((moved - now.1).norm() < 1e-6, "{moved:?} {:?}", now.1);
    }
}

#[test]
fn both_ways_to_the_force_agree_on_bent_panels_and_mirror_images_are_alike() {
    let settings = LatticeSettings::new(0.125, 1e-3);
    let plate = BentPlate { of: Some(breathing), pitch: level };
    let image = BentPlate { of: Some(|t, arc| breathing(t, -arc)), pitch: level };
    let [own, image] = [plate, image].map(|plate| run(&mut lattice(plate, 6.0, [8, 12], settings), 60));
    let (mut apart, mut size) = (0.0, 0.0);
    for (own, image) in own.iter().zip(&image) {
        let (a, b) = (own.joukowski, image.joukowski);
        let mirrored = Vec3::new(a.force[0], -a.force[1], a.force[2]);
        assert!(
            (mirrored - b.force).norm() < 1e-9 && (a.moment[0] + b.moment[0]).abs() < 1e-9,
            "{a:?} {b:?}"
        );
        apart += (a.force[2] - own.bernoulli.force[2]).powi(2);
        size += a.force[2].powi(2);
    }
    let apart = f64::sqrt(apart / size);
    assert!(apart < 0.02, "{apart}");
}

#[test]
fn a_membrane_that_lies_flat_changes_no_bit() {
    let settings = LatticeSettings::new(0.125, 1e-3);
    let flat = BentPlate { of: Some(|_, _| sail([Dual::constant(0.0); 2])), pitch: turning };
    let rigid = BentPlate { of: None, pitch: turning };
    let [flat, rigid] = [flat, rigid].map(|plate| run(&mut lattice(plate, 3.0, [3, 4], settings), 10));
    for (a, b) in flat.iter().zip(&rigid) {
        assert_eq!((a.joukowski, a.bernoulli, a.power), (b.joukowski, b.bernoulli, b.power));
    }
}

/// The chord lines of others, straight.
struct Straight(Arc<dyn MovingSections>);

impl MovingSections for Straight {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        self.0.sections(t, arcs, out);
    }
}

/// Along the record of a glide on a sail, and on wings with flaps, the lattice lifts as the strips do, and not so without the bend.
#[test]
fn bent_wings_lift_along_a_record_as_by_strips() {
    for (name, share) in [("sail_glide", 0.025), ("flap_glide", 0.025)] {
        let path = format!("{}/../../scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let scenario = Scenario::load(path.as_ref(), &["flight.duration_s=1.0".to_owned()]).unwrap();
        let run = scenario.fly(|_| ControlFlow::Continue(())).unwrap();
        let last = |name: &str| *run.record.values(name).unwrap().last().unwrap();
        let by = |source: &str| last(&format!("force_{source}_z"));
        let strips = by("circulatory") + by("induced_drag") + by("added_mass");
        let asked =
            CourseRequest { prescribed: true, chordwise: 4, spanwise: 16, ..CourseRequest::default() };
        let flight = RecordedFlight::new(scenario, run.record.clone()).unwrap();
        let course = &flight.courses(&asked).unwrap()[0];
        let lift = |scene: Scene| {
            let settings = LatticeSettings::new(course.clock.step_s(), 0.05 * course.chord);
            let mut lattice = Lattice::new(scene, settings).unwrap();
            run_to_end(&mut lattice, course.clock.total()).joukowski.force[2] / strips
        };
        let mut straight = course.scene.clone();
        for surface in &mut straight.surfaces {
            surface.sections = Arc::new(Straight(surface.sections.clone()));
        }
        let [bent, straight] = [course.scene.clone(), straight].map(lift);
        assert!((bent - 1.0).abs() < 0.015, "{name}: {bent}");
        assert!(bent - straight > share, "{name}: {bent} {straight}");
    }
}

fn run_to_end(lattice: &mut Lattice, steps: usize) -> LatticeLoads {
    run(lattice, steps).pop().unwrap()
}

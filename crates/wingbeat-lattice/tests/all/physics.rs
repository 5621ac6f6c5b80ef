//! What must hold whatever the panels: slopes, conservation, symmetry, and runs that are finite or refused.

use std::f64::consts::PI;
use std::sync::Arc;
use wingbeat::aero::{Planform, PlanformStation, SectionMotion};
use wingbeat::math::Vec3;
use wingbeat::tether::{Coordinate, Hinge, HingeKind, Motion, Side, Wing};
use wingbeat_lattice::course::CourseRequest;
use wingbeat_lattice::{
    Error, FlappingWing, Lattice, LatticeLoads, LatticeSettings, LatticeSurface, MovingSections, PanelLayout,
    Panels, Scene, Spacing, VortexPicture, WakeMotion,
};

const ALPHA: f64 = 1e-3;

/// A rectangle of unit chord and the span `span` in a wind of 1 m/s; it flaps by `flap` and folds by `fold`, rad.
pub fn wing(span: f64, flap: f64, fold: f64) -> FlappingWing {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -1.0 };
    let planform = Planform::new(&[station(0.0), station(0.5 * span)]).unwrap();
    let hinge = |kind, arc_m| Hinge { kind, side: Side::Both, arc_m, to_arc_m: None, ahead_m: 0.0 };
    let hinges = vec![hinge(HingeKind::Flap, 0.0), hinge(HingeKind::Fold, 0.2 * span)];
    let wave = |mean, sin| Coordinate::Fourier { frequency_hz: 0.2, mean, cos: vec![], sin: vec![sin] };
    let motion = Motion {
        hinges: vec![("shoulder".into(), wave(0.0, flap)), ("elbow".into(), wave(-0.5 * fold, 0.5 * fold))],
        ..Motion::at_rest()
    };
    let wind = Vec3::new(-ALPHA.cos(), 0.0, ALPHA.sin());
    FlappingWing {
        wing: Wing::new(planform, hinges).unwrap(),
        motion,
        wind,
        density_kg_m3: 1.0,
        ground: None,
    }
}

fn run(
    wing: &FlappingWing,
    panels: Panels,
    settings: LatticeSettings,
    steps: usize,
    halved: bool,
) -> (Lattice, Vec<LatticeLoads>) {
    let mut lattice = Lattice::new(Scene::new(wing, panels, halved).unwrap(), settings).unwrap();
    let loads = (0..steps).map(|_| lattice.step().unwrap()).collect();
    (lattice, loads)
}

pub fn panels(chordwise: usize, spanwise: usize) -> Panels {
    Panels { chordwise, spanwise, spacing: Spacing::Lan }
}

#[test]
fn rectangles_have_the_slope_of_the_lifting_surface() {
    // validation/lifting_surface/steady.csv; a step of 10 000 chords makes horseshoes of the last rings.
    for (span, slope) in [(1.0, 1.460183), (4.0, 3.612014), (20.0, 5.433517)] {
        let (_, loads) = run(&wing(span, 0.0, 0.0), panels(6, 24), LatticeSettings::new(1e4, 1e-3), 2, true);
        let found = loads[1].joukowski.force[2] / (0.5 * span * ALPHA);
        assert!((found / slope - 1.0).abs() < 2e-3, "{span}: {found} {slope}");
    }
}

/// Steady drag of a wing by the forces on its vortices, by pressure and suction, and by its wake, and its span efficiency by the first.
fn drags(outline: &[[f64; 3]], panels: Panels, halved: bool) -> [f64; 4] {
    let stations: Vec<PlanformStation> = outline
        .iter()
        .map(|[arc_m, leading_edge_m, chord]| PlanformStation {
            arc_m: *arc_m,
            leading_edge_m: *leading_edge_m,
            trailing_edge_m: leading_edge_m - chord,
        })
        .collect();
    let span = 2.0 * outline[outline.len() - 1][0];
    let mut still = wing(span, 0.0, 0.0);
    still.wing = Wing::new(Planform::new(&stations).unwrap(), Vec::new()).unwrap();
    still.motion = Motion::at_rest();
    let (lattice, loads) = run(&still, panels, LatticeSettings::new(1e4, 1e-3), 2, halved);
    let force = loads[1].joukowski.force;
    let (near, far) = (force.dot(still.wind), lattice.wake_drag().unwrap());
    let lift = force.dot(Vec3::new(ALPHA.sin(), 0.0, ALPHA.cos()));
    let pressed = loads[1].bernoulli.force.dot(still.wind);
    [near, pressed, far, lift * lift / (0.5 * PI * span * span * near)]
}

#[test]
fn drag_of_pressure_and_suction_is_that_of_the_wake() {
    for span in [4.0, 8.0, 20.0] {
        let outline = [[0.0, 0.0, 1.0], [0.5 * span, 0.0, 1.0]];
        for (m, n, within) in [(2, 12, 0.08), (4, 16, 0.045), (6, 24, 0.03), (12, 24, 0.016)] {
            let [_, pressed, far, _] = drags(&outline, panels(m, n), true);
            let error = pressed / far - 1.0;
            println!("{span}, {m} x {n}: {error:.4}");
            assert!(error.abs() < within, "{span}, {m} x {n}: {error}");
        }
    }
    // At the kink of a swept wing the strips' edges have another suction than along them.
    let [_, pressed, far, _] = drags(&[[0.0, 0.0, 1.0], [4.0, -2.3, 1.0]], panels(6, 24), true);
    assert!((pressed / far - 1.0).abs() < 0.08, "{pressed} {far}");
}

#[test]
fn steady_wings_have_the_drag_of_their_wake() {
    let swept = |deg: f64| vec![[0.0, 0.0, 1.0], [4.0, -4.0 * deg.to_radians().tan(), 1.0]];
    let delta = vec![[0.0, 0.0, 1.9], [4.0, -1.8, 0.1]];
    for (outline, within) in [
        (swept(0.0), 0.002),
        (swept(30.0), 0.02),
        (swept(-20.0), 0.02),
        (swept(45.0), 0.02),
        (vec![[0.0, 0.0, 1.5], [4.0, -0.25, 0.5]], 0.005),
        (delta, 0.02),
    ] {
        let [near, _, far, efficiency] = drags(&outline, panels(6, 24), true);
        println!("{outline:?}: {near:e} {far:e} {:.2} %, {efficiency:.4}", 100.0 * (near / far - 1.0));
        assert!((near / far - 1.0).abs() < within && efficiency < 1.0, "{outline:?}: {near} {far}");
    }
    let [half, whole] = [true, false].map(|halved| drags(&swept(30.0), panels(6, 24), halved));
    assert!(half.iter().zip(whole).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{half:?} {whole:?}");
}

#[test]
fn a_long_wing_starts_as_wagner_says() {
    let long = wing(1e4, 0.0, 0.0);
    let one = Panels { chordwise: 16, spanwise: 4, spacing: Spacing::Uniform };
    let (_, loads) = run(&long, one, LatticeSettings::new(1.0 / 16.0, 1e-3), 161, true);
    for (s, wagner) in [(2.0, 0.66929), (5.0, 0.788203), (20.0, 0.936649)] {
        let lift = loads[(0.5 * s * 16.0) as usize].joukowski.force[2] / (0.5e4 * ALPHA);
        assert!((lift / (2.0 * PI * wagner) - 1.0).abs() < 0.012, "{s}: {lift}");
    }
}

/// Error of the lift of a long wing in plunge at the reduced frequency `k` against Theodorsen's, over that: of 8 panels along the chord, the
/// step a panel's chord over `parts`, and the core that is given where none is asked for.
fn plunge_error(k: f64, parts: usize, [re, im]: [f64; 2]) -> f64 {
    let omega = 2.0 * k;
    let mut long = wing(1e4, 0.0, 0.0);
    long.wind = Vec3::new(-1.0, 0.0, 0.0);
    long.motion = Motion::at_rest();
    // Speed upward ALPHA cos(w t).
    long.motion.heave =
        Coordinate::Fourier { frequency_hz: k / PI, mean: 0.0, cos: vec![], sin: vec![ALPHA / omega] };
    let cycle = (2.0 * PI / omega * (8 * parts) as f64).round();
    let step = 2.0 * PI / (omega * cycle);
    let one = Panels { chordwise: 8, spanwise: 4, spacing: Spacing::Uniform };
    let settings = LatticeSettings::new(step, CourseRequest::default().core);
    let steps = (30.0 / step) as usize + cycle as usize;
    let (_, loads) = run(&long, one, settings, steps, true);
    let (mut own, last) = ([0.0; 2], &loads[steps - cycle as usize..]);
    for loads in last {
        let (sin, cos) = (omega * loads.time).sin_cos();
        let lift = loads.joukowski.force[2] / (0.5e4 * ALPHA) * 2.0 / cycle;
        own = [own[0] + lift * cos, own[1] - lift * sin];
    }
    // -2 pi C - i pi k, for a speed of cos(w t).
    let right = [-2.0 * PI * re, -2.0 * PI * im - PI * k];
    (own[0] - right[0]).hypot(own[1] - right[1]) / right[0].hypot(right[1])
}

#[test]
fn lift_in_plunge_is_that_of_theodorsen_with_the_default_core() {
    // C(k) = H1/(H1 + i H0), Hankel's functions of the second kind.
    for (k, c) in [(0.2, [0.72758, -0.188624]), (0.5, [0.597936, -0.150709]), (1.0, [0.539435, -0.100273])] {
        let errors = [1, 2].map(|parts| plunge_error(k, parts, c));
        println!("{k}: {errors:?}");
        assert!(errors[0] < 0.01 && errors[1] < 0.015, "{k}: {errors:?}");
    }
}

#[test]
fn both_ways_to_the_force_agree() {
    let (_, loads) = run(&wing(6.0, 0.05, 0.0), panels(8, 16), LatticeSettings::new(0.125, 1e-3), 80, true);
    let (mut apart, mut size) = ([0.0; 2], [0.0; 2]);
    for loads in &loads[40..] {
        for (i, axis) in [0, 2].into_iter().enumerate() {
            let (a, b) = (loads.joukowski.force[axis], loads.bernoulli.force[axis]);
            apart[i] += (a - b).powi(2);
            size[i] += a * a;
        }
    }
    let errors: Vec<f64> = (0..2).map(|i| (apart[i] / size[i]).sqrt()).collect();
    assert!(errors[1] < 0.02 && errors[0] < 0.12, "forward, up: {errors:?}");
    assert!(loads[79].suction.force[0] > 0.0);
}

#[test]
fn circulation_is_kept_and_halves_make_the_whole() {
    for wake in [WakeMotion::Prescribed, WakeMotion::Free] {
        let settings = LatticeSettings { wake, ..LatticeSettings::new(0.1, 0.05) };
        let flapping = wing(4.0, 0.5, 0.8);
        let (half, halves) = run(&flapping, panels(3, 12), settings, 25, true);
        let (whole, wholes) = run(&flapping, panels(3, 12), settings, 25, false);
        assert!(half.scene().symmetric && !whole.scene().symmetric);
        assert!(half.circulation_error() < 1e-12 && whole.circulation_error() < 1e-12);
        for (a, b) in halves.iter().zip(&wholes) {
            let size = b.joukowski.force.norm();
            assert!((a.joukowski.force - b.joukowski.force).norm() < 1e-10 * size);
            assert!((a.joukowski.moment - b.joukowski.moment).norm() < 1e-10 * size);
            assert!((a.bernoulli.force - b.bernoulli.force).norm() < 1e-10 * size);
            assert!(b.joukowski.force[1].abs() < 1e-10 * size);
        }
    }
}

#[test]
fn the_steady_wake_of_a_free_lattice_leaves_a_flat_wing_its_lift() {
    let flat = wing(4.0, 0.0, 0.0);
    let lift = |wake| {
        let settings = LatticeSettings { wake, ..LatticeSettings::new(0.25, 0.02) };
        let (_, loads) = run(&flat, panels(4, 8), settings, 60, true);
        loads[59].joukowski.force[2]
    };
    let (prescribed, free) = (lift(WakeMotion::Prescribed), lift(WakeMotion::Free));
    assert!((free / prescribed - 1.0).abs() < 1e-3, "{free} {prescribed}");
}

#[test]
fn wakes_end_at_their_age_or_distance() {
    let flat = wing(4.0, 0.0, 0.0);
    let settings = LatticeSettings { longest_age_s: 2.0, ..LatticeSettings::new(0.25, 0.02) };
    assert_eq!(run(&flat, panels(2, 4), settings, 20, true).0.wakes()[0].rows(), 8);
    let settings = LatticeSettings { longest_distance_m: 3.0, ..LatticeSettings::new(0.25, 0.02) };
    let rows = run(&flat, panels(2, 4), settings, 40, true).0.wakes()[0].rows();
    assert!((11..=12).contains(&rows), "{rows}");
}

#[test]
fn odd_runs_are_finite_or_refused() {
    let settings = LatticeSettings { wake: WakeMotion::Free, ..LatticeSettings::new(0.05, 0.05) };
    let one = Panels { chordwise: 1, spanwise: 4, spacing: Spacing::Uniform };
    // No wind: the wing beats its own wake.
    let still = FlappingWing { wind: Vec3::ZERO, ..wing(4.0, 0.8, 1.0) };
    run(&still, one, settings, 120, true);
    // One panel on each piece.
    run(&wing(4.0, 0.3, 0.5), one, settings, 30, false);
    // A wind that blows the wake back through the wing.
    let behind = FlappingWing { wind: Vec3::new(1.0, 0.0, 0.1), ..wing(4.0, 0.2, 0.2) };
    run(&behind, panels(3, 8), settings, 40, true);
    let refused =
        Lattice::new(Scene::new(&still, one, true).unwrap(), LatticeSettings { step_s: 0.0, ..settings });
    assert_eq!(refused.err().unwrap().to_string(), "step_s = 0: allowed is above 0");
    // The same wing twice: its circulations are not determined.
    let mut twice = Scene::new(&still, panels(2, 4), false).unwrap();
    twice.surfaces.push(twice.surfaces[0].clone());
    let touching = Lattice::new(twice, settings).unwrap().step();
    assert!(matches!(touching, Err(Error::Singular { .. })), "{touching:?}");
}

/// A square plate of 1 m at rest, its leading edge in the middle at `at`, its span along `span` from left to right.
struct Plate {
    at: Vec3,
    span: Vec3,
}

impl MovingSections for Plate {
    fn sections(&self, _t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        out.clear();
        out.extend(arcs.iter().map(|arc| {
            let le = self.at - self.span * *arc;
            SectionMotion { le, te: le - Vec3::new(1.0, 0.0, 0.0), ..SectionMotion::default() }
        }));
    }
}

fn plates(plates: [Plate; 2], panels: usize) -> Result<Vec<LatticeLoads>, Error> {
    let arcs: Vec<f64> = (0..=panels).map(|j| 0.5 - j as f64 / panels as f64).collect();
    let layout = PanelLayout { chordwise: panels, fractions: vec![0.5; panels], arcs };
    let surface = |plate| LatticeSurface { layout: layout.clone(), sections: Arc::new(plate) };
    let wind = Vec3::new(-1.0, 0.0, 0.1);
    let surfaces = plates.map(surface).into();
    let scene = Scene { surfaces, wind, density_kg_m3: 1.0, symmetric: false, ground: None };
    let settings = LatticeSettings { wake: WakeMotion::Free, ..LatticeSettings::new(0.2, 0.05) };
    let mut lattice = Lattice::new(scene, settings)?;
    (0..20).map(|_| lattice.step()).collect()
}

#[test]
fn plates_that_touch_are_finite_or_refused() {
    let (right, down) = (Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.0, 0.0, -1.0));
    let plate = |x: f64, y: f64, z: f64, span: Vec3| Plate { at: Vec3::new(x, y, z), span };
    for panels in [1, 2, 4, 5] {
        let first = || plate(0.0, 0.0, 0.0, right);
        for (name, second) in [
            ("trailing edge on leading edge", plate(-1.0, 0.0, 0.0, right)),
            ("tip on tip", plate(0.0, -1.0, 0.0, right)),
            ("across each other", plate(0.0, 0.0, 0.0, down)),
            ("a wing behind in the wake", plate(-3.0, 0.1, 0.0, right)),
            ("one in the other, a panel on", plate(-0.5, 0.0, 0.0, right)),
            ("the same", plate(0.0, 0.0, 0.0, right)),
        ] {
            match plates([first(), second], panels) {
                Ok(loads) => {
                    let largest = loads.iter().map(|l| l.joukowski.force.norm()).fold(0.0, f64::max);
                    assert!(largest.is_finite(), "{name}, {panels}: {largest}");
                }
                Err(Error::Singular { .. } | Error::NotFinite { .. }) => {}
                Err(other) => panic!("{name}, {panels}: {other}"),
            }
        }
    }
    // Edge on edge they are one plate.
    let two = plates([plate(0.0, 0.5, 0.0, right), plate(0.0, -0.5, 0.0, right)], 4).unwrap();
    assert!((two[19].joukowski.force[1]).abs() < 1e-9 && two[19].joukowski.force[2] > 0.1);
}

#[test]
fn the_velocity_around_a_half_plane_is_that_of_the_vortices_through_it() {
    // A core takes of a vortex that passes near the way around; thin ones take nothing.
    let settings = LatticeSettings::new(0.1, 1e-3);
    let (lattice, _) = run(&wing(4.0, 0.5, 0.0), panels(4, 16), settings, 75, false);
    let edges = lattice.meshes().iter().flat_map(|mesh| &mesh.edges);
    let x = edges.map(|edge| edge.te[0]).fold(f64::INFINITY, f64::min) - 0.5;
    let crossings =
        VortexPicture::new(&lattice, 0.0).crossings(Vec3::new(x, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0));
    let through: f64 = crossings.iter().filter(|(place, _)| place[1] > 0.0).map(|(_, g)| g).sum();
    let corners = [[0.0, -8.0], [8.0, -8.0], [8.0, 8.0], [0.0, 8.0], [0.0, -8.0]];
    let mut around = 0.0;
    for pair in corners.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|[y, z]| Vec3::new(x, y, z));
        let step = (to - from) * 5e-4;
        let points: Vec<Vec3> = (0..2000).map(|k| from + step * (f64::from(k) + 0.5)).collect();
        around += lattice.velocities(&points).iter().map(|v| v.dot(step)).sum::<f64>();
    }
    assert!((around / through - 1.0).abs() < 0.01, "{around} {through}");
}

#[test]
fn wings_that_pass_through_each_other_are_finite() {
    // The inner wings flap by 57 deg, the outer ones fold by 143 deg: the tips meet below and pass.
    let crossing = wing(4.0, 1.0, 2.5);
    let settings =
        LatticeSettings { wake: WakeMotion::Free, crossing: 0.2, ..LatticeSettings::new(0.1, 0.05) };
    let (lattice, loads) = run(&crossing, panels(4, 16), settings, 120, false);
    let largest = loads.iter().map(|l| l.joukowski.force.norm()).fold(0.0, f64::max);
    assert!(largest < 100.0 && lattice.circulation_error() < 1e-12, "{largest}");
    // Where nothing crosses, the rounding is hardly felt.
    let flat = wing(4.0, 0.2, 0.3);
    let lift = |crossing: f64| {
        let settings = LatticeSettings { crossing, ..LatticeSettings::new(0.1, 0.05) };
        run(&flat, panels(4, 16), settings, 60, true)
            .1
            .iter()
            .map(|l| l.joukowski.force[2])
            .collect::<Vec<_>>()
    };
    let (bare, rounded) = (lift(0.0), lift(0.2));
    let size = bare.iter().map(|lift| lift * lift).sum::<f64>();
    let apart = bare.iter().zip(&rounded).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    println!("{:e}, {bare:?}", (apart / size).sqrt());
    assert!((apart / size).sqrt() < 5e-3, "{rounded:?} {bare:?}");
}

#[test]
fn fast_sums_are_close_to_direct_ones() {
    let flapping = wing(4.0, 0.4, 0.5);
    let lift = |fast_from: usize| {
        let settings =
            LatticeSettings { wake: WakeMotion::Free, fast_from, ..LatticeSettings::new(0.1, 0.05) };
        run(&flapping, panels(4, 16), settings, 80, true).1[79].joukowski.force
    };
    let (direct, fast) = (lift(usize::MAX), lift(0));
    assert!((fast - direct).norm() < 1e-3 * direct.norm(), "{fast:?} {direct:?}");
}

#[test]
fn scenes_that_cannot_be_stepped_are_refused() {
    let scene = || Scene::new(&wing(4.0, 0.0, 0.0), panels(2, 8), false).unwrap();
    let message =
        |scene: Scene| Lattice::new(scene, LatticeSettings::new(0.1, 1e-3)).err().unwrap().to_string();
    let windy = Scene { wind: Vec3::new(-1.0, f64::NAN, 0.0), ..scene() };
    assert!(message(windy).contains("wind = NaN: allowed is finite"));
    let mut cut = scene();
    cut.surfaces[0].layout.arcs.pop();
    assert!(message(cut).contains("one more than strips"));
    let mut fine = scene();
    fine.surfaces[0].layout.chordwise = usize::MAX;
    assert!(message(fine).contains("allowed is at most 4000"));
}

#[test]
fn half_wings_and_bent_ones_are_refused() {
    use wingbeat::scenario::{Document, TetherCase};
    let of_case = |name: &str, set: &[&str]| {
        let path = format!("{}/../../cases/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let document =
            set.iter().fold(Document::file(path.as_ref()).unwrap(), |document, set| document.set(*set));
        let case = TetherCase::new(document, &|_| Err("no tables here".to_owned())).unwrap();
        FlappingWing::try_from(&case.tether).map_err(|error| error.to_string())
    };
    let taken = |set: &str| of_case("flap_f1", &[set]);
    assert!(taken("wing.side=both").is_ok());
    let bent = of_case("pazy", &["wing.side=both", "spar.gravity_m_s2=[0,0,0]"]);
    assert_eq!(bent.unwrap_err(), "spar: allowed is none: the panels are rigid");
    assert!(taken("wing.side=left").unwrap_err().contains("wing.side = left: allowed is both"));
    let message = taken("wing.section.zero_lift_angle_deg=-3.0").unwrap_err();
    assert!(message.contains("zero_lift_angle_deg = -3"), "{message}");
}

/// Sections mirrored at the plane z = `height`.
struct Mirrored {
    of: Arc<dyn MovingSections>,
    height: f64,
}

impl MovingSections for Mirrored {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        self.of.sections(t, arcs, out);
        for s in out {
            for point in [&mut s.le, &mut s.te] {
                point[2] = 2.0 * self.height - point[2];
            }
            [&mut s.v_le, &mut s.v_te, &mut s.a_le, &mut s.a_te].into_iter().for_each(|v| v[2] = -v[2]);
        }
    }
}

/// A wing that flaps and folds with a free wake over a ground and under a ceiling, whole and as a half, with cores where it crosses and
/// without: it bears what the one of a mirrored pair bears, and no air crosses the plane.
#[test]
fn a_lattice_over_a_ground_is_the_upper_one_of_a_mirrored_pair() {
    for (height, crossing, halved) in [(-0.6, 0.0, false), (-0.6, 0.1, true), (1.1, 0.0, true)] {
        let motion = Motion { nose_up: Coordinate::Constant(0.1), ..wing(3.0, 0.3, 0.2).motion };
        let free = FlappingWing { motion, wind: Vec3::new(-1.0, 0.0, 0.0), ..wing(3.0, 0.3, 0.2) };
        let over = FlappingWing { ground: Some(height), ..free.clone() };
        let settings = LatticeSettings {
            wake: WakeMotion::Free,
            crossing,
            critical_suction: None,
            ..LatticeSettings::new(0.2, 0.05)
        };
        let (lattice, loads) = run(&over, panels(2, 8), settings, 15, halved);
        let mut pair = Scene::new(&free, panels(2, 8), halved).unwrap();
        let image = |surface: &LatticeSurface| LatticeSurface {
            layout: surface.layout.clone(),
            sections: Arc::new(Mirrored { of: surface.sections.clone(), height }),
        };
        let images: Vec<LatticeSurface> = pair.surfaces.iter().map(image).collect();
        pair.surfaces.extend(images);
        let mut pair = Lattice::new(pair, settings).unwrap();
        for loads in &loads {
            let both = pair.step().unwrap();
            for (own, of_pair) in loads.panels.iter().zip(&both.panels) {
                for (a, b) in own.joukowski.iter().zip(&of_pair.joukowski) {
                    assert!((*a - *b).norm() < 1e-10, "{height} {crossing}: {a:?} {b:?}");
                }
                for (a, b) in own.bernoulli.iter().zip(&of_pair.bernoulli) {
                    assert!((*a - *b).norm() < 1e-10, "{height} {crossing}: {a:?} {b:?}");
                }
            }
        }
        let on: Vec<Vec3> =
            (0..40).map(|k| Vec3::new(0.5 - 0.1 * f64::from(k), 0.7 * f64::from(k % 5), height)).collect();
        assert!(lattice.velocities(&on).iter().all(|v| v[2].abs() < 1e-14));
        assert!((lattice.wake_drag().unwrap() / (0.5 * pair.wake_drag().unwrap()) - 1.0).abs() < 1e-10);
    }
    let refused = |wind: Vec3, ground: f64| {
        let over = FlappingWing { wind, ground: Some(ground), ..wing(3.0, 0.0, 0.0) };
        Lattice::new(Scene::new(&over, panels(1, 4), false).unwrap(), LatticeSettings::new(0.2, 0.05))
            .err()
            .unwrap()
            .to_string()
    };
    assert!(refused(Vec3::new(-1.0, 0.0, 0.1), -1.0).starts_with("wind = 0.1"));
    assert!(refused(Vec3::new(-1.0, 0.0, 0.0), f64::NAN).starts_with("ground = NaN"));
}

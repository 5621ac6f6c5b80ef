//! Leading edges that shed.

use crate::physics::{panels, wing};
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat::aero::{Planform, PlanformStation, SectionMotion};
use wingbeat::math::Vec3;
use wingbeat::scenario::{Document, Scenario};
use wingbeat_lattice::{
    Error, Lattice, LatticeSettings, LatticeSurface, MovingSections, PanelLayout, Panels, Scene, Spacing,
    VortexPicture, WakeMotion,
};

#[test]
fn first_vortices_have_the_suction_of_thin_aerofoils() {
    let long = wing(1e4, 0.0, 0.0);
    for chordwise in [1, 3, 8] {
        let one = Panels { chordwise, spanwise: 4, spacing: Spacing::Uniform };
        let settings = LatticeSettings { critical_suction: Some(1e9), ..LatticeSettings::new(1e6, 1e-6) };
        let mut lattice = Lattice::new(Scene::new(&long, one, true).unwrap(), settings).unwrap();
        lattice.step().unwrap();
        lattice.step().unwrap();
        let suction = lattice.suction()[1];
        assert!((suction / 1e-3 - 1.0).abs() < 2e-3, "{chordwise}: {suction}");
        assert_eq!(lattice.shed_share(), 0.0);
    }
}

/// A wing that flaps and folds with edges that bear `critical`, whole or by its left half.
fn flapped(critical: Option<f64>, wake: WakeMotion, halved: bool) -> (Lattice, Vec<Vec3>, f64) {
    let settings = LatticeSettings {
        wake,
        critical_suction: critical,
        sheet_core_m: 0.1,
        ..LatticeSettings::new(0.125, 1e-3)
    };
    let scene = Scene::new(&wing(4.0, 0.4, 0.3), panels(4, 8), halved).unwrap();
    let mut lattice = Lattice::new(scene, settings).unwrap();
    let (mut forces, mut most) = (Vec::new(), 0.0_f64);
    for _ in 0..30 {
        forces.push(lattice.step().unwrap().joukowski.force);
        most = lattice.suction().iter().fold(most, |most, suction| most.max(suction.abs()));
        assert!(lattice.circulation_error() < 1e-12);
    }
    (lattice, forces, most)
}

#[test]
fn leading_edges_keep_the_critical_suction() {
    const CRITICAL: f64 = 0.1;
    let (_, attached, free) = flapped(Some(1e9), WakeMotion::Prescribed, true);
    assert!(free > 2.5 * CRITICAL, "{free}");
    let (_, as_today, _) = flapped(None, WakeMotion::Prescribed, true);
    let largest = as_today.iter().fold(0.0_f64, |most, force| most.max(force.norm()));
    let same = attached.iter().zip(&as_today).all(|(a, b)| (*a - *b).norm() < 1e-12 * largest);
    assert!(same, "an edge that sheds nothing changes nothing");
    for wake in [WakeMotion::Prescribed, WakeMotion::Free] {
        let (lattice, half, most) = flapped(Some(CRITICAL), wake, true);
        assert!(most < CRITICAL * (1.0 + 1e-9), "{most}");
        let shed = lattice.sheets()[0].rings.iter().fold(0.0_f64, |most, ring| most.max(ring.abs()));
        assert!(shed > 0.01, "{shed}");
        let (_, whole, _) = flapped(Some(CRITICAL), wake, false);
        assert!(half.iter().zip(&whole).all(|(a, b)| (*a - *b).norm() < 1e-6 * largest));
        let picture = VortexPicture::new(&lattice, 0.0);
        let rings = |of: &[wingbeat_lattice::Wake]| of.iter().map(|wake| wake.rings.len()).sum::<usize>();
        assert_eq!(picture.wake.len(), 2 * (rings(lattice.wakes()) + rings(lattice.sheets())));
    }
}

#[test]
fn forces_are_the_rate_of_the_impulse() {
    const STEPS: usize = 30;
    let step = 0.125;
    for (critical, within) in [(None, 0.05), (Some(0.1), 0.08)] {
        let own = LatticeSettings {
            wake: WakeMotion::Free,
            critical_suction: critical,
            ..LatticeSettings::new(step, 1e-3)
        };
        let settings = LatticeSettings { sheet_core_m: 0.1, ..own };
        for halved in [true, false] {
            let scene = Scene::new(&wing(4.0, 0.4, 0.0), panels(4, 8), halved).unwrap();
            let mut lattice = Lattice::new(scene, settings).unwrap();
            let steps: Vec<(f64, f64)> = (0..STEPS)
                .map(|_| (lattice.step().unwrap().joukowski.force[2], lattice.impulse()[2]))
                .collect();
            let (from, to) = (4, STEPS - 1);
            let inner: f64 = steps[from + 1..to].iter().map(|(force, _)| force).sum();
            let given = step * (inner + 0.5 * (steps[from].0 + steps[to].0));
            let largest = steps.iter().fold(0.0_f64, |most, (force, _)| most.max(force.abs()));
            let off = (given + steps[to].1 - steps[from].1) / (largest * step * (to - from) as f64);
            assert!(off.abs() < within, "{critical:?} {halved}: {off}");
        }
    }
}

#[test]
fn bad_critical_suctions_are_refused() {
    for value in [-0.1, f64::NAN, f64::INFINITY] {
        let settings = LatticeSettings { critical_suction: Some(value), ..LatticeSettings::new(0.1, 1e-3) };
        let scene = Scene::new(&wing(4.0, 0.1, 0.0), panels(2, 4), true).unwrap();
        let refused = Lattice::new(scene, settings).err();
        assert!(matches!(refused, Some(Error::Setting { key: "critical_suction", .. })), "{refused:?}");
    }
    let peer = LatticeSettings {
        critical_suction: Some(0.1),
        ..LatticeSettings::new(0.1, 1e-3).like_pterasoftware(1.0, 1e-5)
    };
    let scene = Scene::new(&wing(4.0, 0.1, 0.0), panels(2, 4), true).unwrap();
    let text = Lattice::new(scene, peer).err().unwrap().to_string();
    assert!(text.contains("critical_suction = 0.1") && text.contains("PteraSoftware"), "{text}");
}

#[test]
fn a_flight_in_the_lattice_sheds() {
    let glide = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/glide.toml");
    let fly = |suction: &str| {
        let document =
            Document::file(glide.as_ref()).unwrap().set("lattice.step_s=0.01").set("lattice.free_wake=true");
        let document =
            document.set("flight.duration_s=0.1").set(format!("lattice.critical_suction={suction}"));
        let scenario = Scenario::open(document, &wingbeat_lattice::doors())?;
        Ok::<_, wingbeat::scenario::ConfigError>(scenario.fly(|_| ControlFlow::Continue(())).unwrap())
    };
    let height = |run: &wingbeat::simulate::Record| *run.values("p_WB_z").unwrap().last().unwrap();
    let (attached, shed) = (fly("1.0").unwrap(), fly("0.0").unwrap());
    let way = |run: &wingbeat::scenario::Run| run.summary.lattice.unwrap().sheet_way_chords.unwrap();
    assert!((0.0..1.0).contains(&way(&shed)) && way(&shed) > 0.0, "{}", way(&shed));
    assert!((height(&attached.record) - height(&shed.record)).abs() > 1e-6);
    for (bad, says) in
        [("-0.1", "0 to 1"), ("nan", "0 to 1"), ("1e9", "0 to 1"), ("\"x\"", "critical_suction")]
    {
        let text = fly(bad).err().unwrap().to_string();
        assert!(text.contains("lattice.critical_suction") || text.contains(says), "{bad}: {text}");
    }
}

/// A plate of unit chord that is pitched to 45 degrees about its leading edge within a chord of travel at 1 m/s (Eldredge, Wang & Ol 2009).
struct Pitched;

impl MovingSections for Pitched {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        const HALF: f64 = 0.5 * std::f64::consts::FRAC_PI_4;
        let [first, last] = [0.2, 1.2].map(|at| 15.0 * (t - at));
        let angle = HALF * (1.0 + (first.cosh().ln() - last.cosh().ln()) / 15.0);
        let rate = HALF * (first.tanh() - last.tanh());
        let (sin, cos) = angle.sin_cos();
        out.clear();
        out.extend(arcs.iter().map(|arc| {
            let le = Vec3::new(0.0, *arc, 0.0);
            let te = le - Vec3::new(cos, 0.0, sin);
            let v_te = Vec3::new(sin, 0.0, -cos) * rate;
            SectionMotion { le, te, v_le: Vec3::ZERO, v_te, ..SectionMotion::default() }
        }));
    }
}

#[test]
fn both_ways_to_the_force_agree_under_a_sheet() {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -1.0 };
    let planform = Planform::new(&[station(0.0), station(2.0)]).unwrap();
    let whole = PanelLayout::of(&planform, &[0.0], 8, 16, Spacing::Lan).unwrap();
    let scene = Scene {
        surfaces: vec![LatticeSurface { layout: whole[0].left_half().unwrap(), sections: Arc::new(Pitched) }],
        wind: Vec3::new(-1.0, 0.0, 0.0),
        density_kg_m3: 1.0,
        symmetric: true,
        ground: None,
    };
    let settings = LatticeSettings {
        wake: WakeMotion::Free,
        critical_suction: Some(0.11),
        sheet_core_m: 0.1,
        ..LatticeSettings::new(1.0 / 16.0, 1e-3)
    };
    let mut lattice = Lattice::new(scene, settings).unwrap();
    let mut loads = lattice.step().unwrap();
    while loads.time < 0.87 {
        loads = lattice.step().unwrap();
    }
    let apart = loads.joukowski.force[2] / loads.bernoulli.force[2] - 1.0;
    assert!(apart.abs() < 0.04, "{apart}");
}

use wingbeat::math::Vec3;
use wingbeat_validate::orbit::replay::*;

#[test]
fn joints_at_rest_give_nothing_to_the_air() {
    let motion = OrbitMotion::of("cruise_20g").unwrap().gentler(0.0).unwrap();
    let fineness = LatticeFineness { chordwise: 2, strips: 9, parts: 1, core: 0.05 };
    let [_, lattice] = motion.lattice(fineness).unwrap();
    let strips = motion.strips(&motion.driven(|_| ()).unwrap()).unwrap();
    let most = |cycle: &[InstantLoads]| cycle.iter().fold(0.0, |most: f64, i| most.max(i.power.abs()));
    assert!(most(&strips) < 1e-9 && most(&lattice) < 1e-9, "{} {}", most(&strips), most(&lattice));
}

#[test]
fn a_way_pierces_the_triangle_that_it_passes_through() {
    let corner = |x, y| Vec3::new(x, y, 0.0);
    let triangle = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
    let way = |x, y, z| [Vec3::new(x, y, -1.0), Vec3::new(x, y, z)];
    assert!(pierces(way(0.2, 0.3, 1.0), triangle));
    assert!(!pierces(way(0.2, 0.3, -0.1), triangle) && !pierces(way(0.7, 0.7, 1.0), triangle));
}

#[test]
fn an_error_with_the_size_of_panels_is_extrapolated() {
    let cycle = |n: usize, error: f64| -> Vec<InstantLoads> {
        let up = |k: usize| 1.0 + error + 2.0 * (1.0 - 2.0 * k as f64 / n as f64).abs();
        (0..n).map(|k| InstantLoads { up: up(k), power: -error, ..InstantLoads::default() }).collect()
    };
    let endless = extrapolated(&cycle(8, 0.3), &cycle(12, 0.2), 8.0 / 12.0);
    let off = |(k, i): (usize, &InstantLoads)| (i.up - cycle(12, 0.0)[k].up).abs().max(i.power.abs());
    assert!(endless.iter().enumerate().map(off).fold(0.0, f64::max) < 1e-12 && endless.len() == 12);
}

#[test]
fn the_left_half_has_the_edges_of_the_strips() {
    let layout = left_half(3, &[0.3, 0.1, -0.1, -0.3], 2);
    let wanted = [0.3, 0.2, 0.1, 0.05, 0.0];
    assert!(layout.arcs.iter().zip(wanted).all(|(arc, wanted)| (arc - wanted).abs() < 1e-15), "{layout:?}");
    assert_eq!((layout.arcs.len(), layout.strips(), layout.panels()), (5, 4, 12));
    assert_eq!(left_half(1, &[0.2, 0.0, -0.2], 1).arcs, [0.2, 0.0]);
}

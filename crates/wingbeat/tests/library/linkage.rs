//! The linkage against the reference cycle, its own closure equations and Newton's method.

use wingbeat::body::{Directions, Linkage, LinkageDimensions, Planar};
use wingbeat::math::linear::{lu_factor, lu_solve};
use wingbeat::math::{Dual, Jet, Scalar};
use wingbeat::plant::Fault;

fn linkage() -> Linkage {
    Linkage::new(LinkageDimensions::default()).unwrap()
}

fn still<S: Scalar>(x: S) -> Jet<S> {
    Jet::new(x, S::ZERO, S::ZERO)
}

/// Residuals (m) of the three loop equations, from unit vectors alone.
fn residuals<S: Scalar>(d: &LinkageDimensions, crank: Jet<S>, e: &Directions<S>) -> [Jet<S>; 6] {
    let a3 = d.a3_deg.to_radians();
    let [p1, p5, p8] = [d.p1_m, d.p5_m, d.p8_m].map(Planar::constant);
    let pin = p1 + Planar::unit(crank).times(d.l1_m);
    let humerus = e.e5 * Planar::unit(Jet::from(-a3));
    let first = pin + e.e2.times(d.l2a_m) + humerus.turned([d.l3b_m, -d.l3c_m]) - p5;
    let second =
        pin + e.e2.turned([d.l2b_m, d.l2c_m]) + e.e3.times(d.l4_m) + e.e8.turned([d.l5a_m, -d.l5b_m]) - p8;
    let left = p8 + e.e8.turned([d.l5c_m, d.l5d_m]) + e.e9.times(d.l6_m);
    let elbow = p5 + e.e5.turned([d.l3a_m + d.l3c_m * a3.sin(), d.l3c_m * a3.cos()]);
    let third = left - elbow - e.e6.turned([d.l7b_m, d.l7c_m]);
    [first.y, first.z, second.y, second.z, third.y, third.z]
}

fn directions<S: Scalar>(angles: [S; 6]) -> Directions<S> {
    let [e2, e3, e5, e6, e8, e9] = angles.map(|a| Planar::unit(still(a)));
    Directions { e2, e3, e5, e6, e8, e9 }
}

#[test]
fn the_reference_cycle_is_met_to_a_thousandth_of_a_degree() {
    let path = format!("{}/../../validation/linkage/cycle.csv", env!("CARGO_MANIFEST_DIR"));
    let (linkage, mut rows) = (linkage(), 0);
    for line in std::fs::read_to_string(path).unwrap().lines().filter(|l| !l.starts_with('#')) {
        let [crank, humerus, radius]: [f64; 3] =
            line.split(',').map(|s| s.parse().unwrap()).collect::<Vec<_>>().try_into().unwrap();
        let pose = linkage.pose(still(crank.to_radians()), [Jet::ZERO; 3]).unwrap();
        assert!((pose.humerus.x.to_degrees() - humerus).abs() < 1e-3, "{crank}: {:?}", pose.humerus.x);
        assert!((pose.radius.x.to_degrees() - radius).abs() < 1e-3, "{crank}: {:?}", pose.radius.x);
        rows += 1;
    }
    assert!(rows > 900);
}

#[test]
fn the_loops_close_with_rates_and_accelerations() {
    let linkage = linkage();
    for k in 0..100 {
        let crank = Jet::new(0.0628 * k as f64, 22.0, 5.0);
        let pose = linkage.pose(crank, [Jet::ZERO; 3]).unwrap();
        for r in residuals(linkage.dimensions(), crank, &pose.directions) {
            assert!(r.x.abs() < 1e-14 && r.d.abs() < 1e-11 && r.dd.abs() < 1e-7, "{r:?}");
        }
    }
}

#[test]
fn newton_from_the_published_start_finds_the_same_pose() {
    let linkage = linkage();
    let start = [48.78, 87.95, -62.51, -17.34, -6.54, -91.69].map(f64::to_radians);
    let mut angles = start;
    for _ in 0..20 {
        let seeded = std::array::from_fn(|i| Dual::<6>::variable(angles[i], i));
        let found = residuals(linkage.dimensions(), Jet::from(0.0), &directions(seeded));
        let mut jacobian = found.map(|r| r.x.eps).concat();
        let (mut step, mut pivots) = (found.map(|r| -r.x.re), [0; 6]);
        assert!(lu_factor(&mut jacobian, 6, &mut pivots));
        lu_solve(&jacobian, 6, &pivots, &mut step, 1);
        angles = std::array::from_fn(|i| angles[i] + step[i]);
    }
    assert!(start.iter().zip(&angles).all(|(a, b)| (a - b).abs() < 0.01), "{angles:?}");
    let e = linkage.pose(still(0.0), [Jet::ZERO; 3]).unwrap().directions;
    for (unit, angle) in [e.e2, e.e3, e.e5, e.e6, e.e8, e.e9].iter().zip(angles) {
        assert!((unit.y.x - angle.cos()).abs() < 1e-9 && (unit.z.x - angle.sin()).abs() < 1e-9);
    }
}

#[test]
fn rates_match_nested_derivatives_with_moving_lengths() {
    let linkage = linkage();
    let t = Dual::<1, Dual<1>> { re: Dual::variable(0.013, 0), eps: [Dual::constant(1.0)] };
    fn inputs<S: Scalar>(t: S) -> (Jet<S>, [Jet<S>; 3]) {
        let time = Jet::new(t, S::ONE, S::ZERO);
        let wave = |k: f64, size: f64| (time * (20.0 * k)).sin() * size + size;
        (time * 22.0 + 0.3, [wave(1.0, 1e-3), wave(2.0, 8e-4), wave(3.0, 5e-4)])
    }
    let (crank, lengths) = inputs(t);
    let moved = linkage.pose(crank, lengths).unwrap();
    let (crank, lengths) = inputs(0.013);
    let exact = linkage.pose(crank, lengths).unwrap();
    for (a, b) in [(moved.humerus.x, exact.humerus), (moved.radius.x, exact.radius)] {
        assert!((a.re.eps[0] - b.d).abs() < 1e-9 * b.d.abs(), "{a:?} {b:?}");
        assert!((a.eps[0].eps[0] - b.dd).abs() < 1e-9 * b.dd.abs(), "{a:?} {b:?}");
    }
}

#[test]
fn lengths_stop_at_their_limits() {
    let linkage = linkage();
    let [[low, high], ..] = linkage.displacement_limits();
    let at = |x: f64| linkage.pose(Jet::new(1.0, 20.0, 0.0), [Jet::new(x, 1.0, 0.0), Jet::ZERO, Jet::ZERO]);
    assert_eq!(at(high * 2.0).unwrap().humerus.x, at(high).unwrap().humerus.x);
    let held = linkage.pose(Jet::new(1.0, 20.0, 0.0), [still(high), Jet::ZERO, Jet::ZERO]).unwrap();
    assert_eq!(at(high * 2.0).unwrap().humerus.d, held.humerus.d);
    assert!(low < 0.0 && high > 0.0);
}

#[test]
fn angles_are_smooth_over_the_cycle() {
    let linkage = linkage();
    let at = |k: i32| linkage.pose(Jet::new(f64::from(k) * 1e-3, 1.0, 0.0), [Jet::ZERO; 3]).unwrap();
    for k in -1000..8000 {
        let (a, b) = (at(k), at(k + 1));
        for (x, y) in [(a.humerus, b.humerus), (a.radius, b.radius)] {
            assert!((y.x - x.x - 0.5e-3 * (x.d + y.d)).abs() < 1e-4, "{k}");
        }
    }
}

#[test]
fn a_linkage_near_its_singularity_is_a_fault_and_one_that_cannot_close_is_refused() {
    let wide = LinkageDimensions { l3b_range: [0.5, 3.0], ..LinkageDimensions::default() };
    let linkage = Linkage::new(wide).unwrap();
    let shortened = |crank: f64| linkage.pose(still(crank), [still(-2.1e-3), Jet::ZERO, Jet::ZERO]);
    let fault = (0..360).find_map(|k| shortened(f64::from(k).to_radians()).err()).unwrap();
    assert!(matches!(fault, Fault::LinkageSingular { closure: 1, margin, .. } if margin < 0.003));

    let short = LinkageDimensions { l3b_m: 4.7e-3, ..LinkageDimensions::default() };
    let message = Linkage::new(short).unwrap_err().to_string();
    assert!(message.contains("linkage") && message.contains("loop 1"), "{message}");
    let negative = LinkageDimensions { l1_m: -1.0, ..LinkageDimensions::default() };
    assert!(Linkage::new(negative).unwrap_err().to_string().starts_with("l1_m = -1"));
}

//! Evaluating and stepping the plant allocates nothing after the first time on a thread. The allocator of all tests counts by thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::PathBuf;
use wingbeat::aero::{
    Aero, Loads, Planform, PlanformStation, SectionMotion, StripModel, StripSettings, Surfaces,
};
use wingbeat::math::{Scalar, Vec3};
use wingbeat::plant::{Early, Plant};
use wingbeat::scenario::Scenario;
use wingbeat::simulate::Stepper;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// Allocations of this thread so far.
fn allocations() -> usize {
    ALLOCATIONS.get()
}

// SAFETY: every call goes to the system allocator unchanged; only a count is added.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_plant_evaluation_allocates_nothing_after_the_first_of_a_thread() {
    for (name, preset) in [
        ("banking_turn", "paper"),
        ("banking_turn_beta", "paper"),
        ("banking_turn", "full"),
        ("bank15_20g", "full"),
    ] {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenarios/{name}.toml"));
        let scenario =
            Scenario::load(&path, &[format!("aero.preset={preset}")]).unwrap_or_else(|e| panic!("{e}"));
        let robot = scenario.robot();
        let x = scenario.start();
        let u = vec![0.0; robot.inputs().len()];
        let mut dx = x.clone();
        let dual = |v: &[f64]| v.iter().map(|&v| Early::constant(v)).collect::<Vec<_>>();
        let (xd, ud, mut dxd) = (dual(&x), dual(&u), dual(&x));
        let mut clearances = vec![Early::ZERO; robot.clearances().len()];
        let mut stepper = Stepper::new(robot, 0.0, &x);
        let mut evaluate = || {
            robot.rates_in_numbers(0.01, &x, &u, &mut dx).unwrap();
            robot.rates_in_early(0.01, &xd, &ud, &mut dxd).unwrap();
            robot.clear(Early::constant(0.01), &xd, &mut clearances).unwrap();
            (0..5).for_each(|_| stepper.step(1e-4).unwrap());
        };
        // The first evaluation of a thread makes the rooms that it keeps.
        evaluate();
        let before = allocations();
        evaluate();
        assert_eq!(allocations() - before, 0, "{name}");
        assert_ne!(before, 0);
    }
}

#[test]
fn surfaces_in_each_others_wash_allocate_nothing_after_the_first_time() {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -0.1 };
    let planform = Planform::new(&[station(0.0), station(0.3)]).unwrap();
    let settings = StripSettings { strips: 8, ..Default::default() };
    let wing = Aero::Strip(StripModel::new(&planform, settings).unwrap());
    let surfaces = Surfaces::new([("wing".to_string(), wing.clone()), ("tail".to_string(), wing)]).unwrap();
    let edge = |behind: f64, arc: f64| SectionMotion {
        le: Vec3::new(-behind, arc, 0.0),
        te: Vec3::new(-behind - 0.1, arc, 0.0),
        ..SectionMotion::default()
    };
    let sections: Vec<_> = surfaces
        .arcs()
        .iter()
        .enumerate()
        .map(|(i, &arc)| edge(if i < 9 { 0.0 } else { 0.4 }, arc))
        .collect();
    let (x, wind) = (vec![0.01; surfaces.states()], Vec3::new(-2.0, 0.0, 0.1));
    let (mut dx, mut loads) = (x.clone(), Loads::default());
    surfaces.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
    let before = allocations();
    surfaces.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
    assert_eq!(allocations() - before, 0);
    assert!(dx.iter().all(|d| d.is_finite()));
}

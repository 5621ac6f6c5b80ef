//! Evaluating and stepping the plant allocates nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::PathBuf;
use wingbeat::math::Dual;
use wingbeat::plant::Plant;
use wingbeat::scenario::Scenario;
use wingbeat::simulate::Stepper;

struct Counting;

thread_local! {
    /// Allocations of this thread: the test harness has threads of its own.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system allocator unchanged; only a count is added.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_plant_evaluation_allocates_nothing() {
    for (name, preset) in
        [("banking_turn", "paper"), ("banking_turn_beta", "paper"), ("banking_turn", "full")]
    {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenarios/{name}.toml"));
        let scenario =
            Scenario::load(&path, &[format!("aero.preset={preset}")]).unwrap_or_else(|e| panic!("{e}"));
        let robot = scenario.robot();
        let x = scenario.start();
        let u = vec![0.0; robot.inputs().len()];
        let mut dx = x.clone();
        let dual = |v: &[f64]| v.iter().map(|&v| Dual::<8>::constant(v)).collect::<Vec<_>>();
        let (xd, ud, mut dxd) = (dual(&x), dual(&u), dual(&x));
        let mut stepper = Stepper::new(robot, 0.0, &x);
        let before = ALLOCATIONS.get();
        robot.rates(0.01, &x, &u, &mut dx).unwrap();
        robot.rates(Dual::<8>::constant(0.01), &xd, &ud, &mut dxd).unwrap();
        (0..5).for_each(|_| stepper.step(1e-4).unwrap());
        assert_eq!(ALLOCATIONS.get() - before, 0, "{name}");
        assert_ne!(before, 0);
    }
}

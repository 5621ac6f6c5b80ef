//! Evaluating the plant allocates nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use wingbeat::math::Dual;
use wingbeat::plant::Plant;
use wingbeat::scenario::Scenario;

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system allocator unchanged; only a count is added.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
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
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        robot.rates(0.01, &x, &u, &mut dx).unwrap();
        robot.rates(Dual::<8>::constant(0.01), &xd, &ud, &mut dxd).unwrap();
        assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0, "{name}");
        assert_ne!(before, 0);
    }
}

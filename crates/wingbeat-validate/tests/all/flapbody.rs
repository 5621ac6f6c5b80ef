//! The real-time solver on FLAPBODY-14, problem A.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use wingbeat::ocp::realtime::{Limit, RealTime, Settings, Tracking, UpdateStatus};
use wingbeat::plant::{Channel, Fault, Plant};
use wingbeat_validate::flapbody::{self, BankTurn, FlapBody, INTERVALS, STEP};

/// Counts the allocations of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

#[allow(unsafe_code)] // an allocator has no safe interface
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

#[test]
fn all_recorded_instances_reach_their_optimal_inputs() {
    let plant = FlapBody::default();
    let mut solver = flapbody::solver(&plant).unwrap();
    for (i, instance) in flapbody::instances().unwrap().iter().enumerate() {
        solver.reset(&plant, &instance.state);
        let status = solver.solve(&plant, &instance.problem, instance.time, &instance.state, 20);
        assert_eq!(status, UpdateStatus::Solved, "instance {i}");
        let error = largest_difference(&solver.plan().u, &instance.inputs);
        assert!(error < 1e-6, "instance {i}: {error:e}");
    }
}

#[test]
fn limits_hold_on_every_iterate_and_some_bind() {
    let plant = FlapBody::default();
    let mut solver = flapbody::solver(&plant).unwrap();
    let mut most_active = 0;
    for instance in flapbody::instances().unwrap() {
        solver.reset(&plant, &instance.state);
        solver.solve(&plant, &instance.problem, instance.time, &instance.state, 3);
        for k in 1..=INTERVALS {
            let s = &solver.state(k)[9..13];
            assert!(s.iter().all(|s| s.abs() <= 1.0 + 1e-9));
            let pairs = [s[0] - s[1], s[2] - s[3]];
            assert!(pairs.iter().all(|d| d.abs() <= flapbody::DIFFERENCE + 1e-9));
        }
        assert!(solver.plan().u.iter().all(|u| u.abs() <= 1.0));
        most_active = most_active.max(solver.statistics().active);
    }
    assert!(most_active >= 5, "{most_active}");
}

#[test]
fn updates_allocate_nothing_and_repeat_exactly() {
    let plant = FlapBody::default();
    let instances = flapbody::instances().unwrap();
    let mut solver = flapbody::solver(&plant).unwrap();
    let fly = |solver: &mut RealTime| {
        solver.reset(&plant, &instances[0].state);
        for instance in &instances[..40] {
            solver.shift(&plant, 2.0 * STEP);
            solver.solve(&plant, &instance.problem, instance.time, &instance.state, 3);
        }
    };
    let mut second = solver.clone();
    let before = ALLOCATIONS.with(Cell::get);
    fly(&mut solver);
    assert_eq!(ALLOCATIONS.with(Cell::get), before);
    fly(&mut second);
    assert_eq!(solver.plan().u, second.plan().u);
}

#[test]
fn warm_starts_by_shifting_need_fewer_iterations() {
    let plant = FlapBody::default();
    let instances = flapbody::instances().unwrap();
    let mut solver = flapbody::solver(&plant).unwrap();
    let mut iterations = [0, 0];
    for pair in instances[100..150].windows(2) {
        for warm in [0, 1] {
            solver.reset(&plant, &pair[0].state);
            solver.solve(&plant, &pair[0].problem, pair[0].time, &pair[0].state, 20);
            if warm == 1 {
                solver.shift(&plant, pair[1].time - pair[0].time);
            } else {
                solver.reset(&plant, &pair[1].state);
            }
            let status = solver.solve(&plant, &pair[1].problem, pair[1].time, &pair[1].state, 20);
            assert_eq!(status, UpdateStatus::Solved);
            iterations[warm] += solver.statistics().iterations;
        }
    }
    assert!(iterations[1] < iterations[0], "{iterations:?}");
}

#[test]
fn a_state_beyond_its_limit_is_infeasible_and_named() {
    let plant = FlapBody::default();
    let mut solver = flapbody::solver(&plant).unwrap();
    let instance = &flapbody::instances().unwrap()[50];
    solver.reset(&plant, &instance.state);
    solver.solve(&plant, &instance.problem, instance.time, &instance.state, 5);
    let kept = solver.plan().u.clone();
    let mut far = instance.state.clone();
    far[9] = 1.9;
    let status = solver.solve(&plant, &instance.problem, instance.time, &far, 1);
    let UpdateStatus::Infeasible { worst } = status else { panic!("{status:?}") };
    let name = worst.name(&plant, &instance.problem);
    assert!(name == "stroke_1" || name == "stroke_1 - stroke_2", "{worst:?} {name}");
    assert!(matches!(worst, Limit::State { node: 1, .. } | Limit::Linear { node: 1, .. }));
    assert_eq!(solver.plan().u, kept);
}

/// FLAPBODY-14 that breaks at a given time.
struct Breaks(FlapBody, Break);

#[derive(Clone, Copy)]
enum Break {
    Fault,
    NotANumber,
}

impl Plant for Breaks {
    fn states(&self) -> &[Channel] {
        self.0.states()
    }
    fn inputs(&self) -> &[Channel] {
        self.0.inputs()
    }
    fn rates<S: wingbeat::math::Scalar>(&self, t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        self.0.rates(t, x, u, dx)?;
        match self.1 {
            Break::Fault if t.value() > 0.6 => Err(Fault::MassMatrix { time: t.value() }),
            Break::NotANumber if t.value() > 0.6 => {
                dx[4] = S::from(f64::NAN);
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

#[test]
fn a_broken_model_is_reported_and_leaves_the_plan() {
    let instance = &flapbody::instances().unwrap()[50];
    for broken in [Break::Fault, Break::NotANumber] {
        let plant = Breaks(FlapBody::default(), broken);
        let settings = Settings::new(INTERVALS, STEP);
        let mut solver = RealTime::new(&plant, &instance.problem, settings).unwrap();
        solver.reset(&plant, &instance.state);
        assert!(solver.solve(&plant, &instance.problem, 0.5, &instance.state, 2).updated());
        let kept = solver.plan().clone();
        for t0 in [0.58, 1.0] {
            let status = solver.solve(&plant, &instance.problem, t0, &instance.state, 2);
            assert!(matches!(status, UpdateStatus::ModelFault(_)), "{status:?}");
            assert_eq!((&kept.u, &kept.x), (&solver.plan().u, &solver.plan().x));
        }
    }
}

#[test]
fn undefined_measurements_are_refused() {
    let plant = FlapBody::default();
    let mut solver = flapbody::solver(&plant).unwrap();
    let mut state = flapbody::initial_state();
    solver.reset(&plant, &state);
    for i in 0..state.len() {
        let good = std::mem::replace(&mut state[i], f64::NAN);
        let status = solver.solve(&plant, &BankTurn::new([0.0; INTERVALS]), 0.0, &state, 1);
        state[i] = good;
        assert!(!status.updated(), "state {i}: {status:?}");
    }
    assert!(solver.plan().x.iter().all(|x| x.is_finite()));
}

#[test]
fn a_plan_that_leads_nowhere_is_made_anew() {
    let plant = FlapBody::default();
    let mut solver = flapbody::solver(&plant).unwrap();
    let instance = &flapbody::instances().unwrap()[50];
    solver.reset(&plant, &instance.state);
    solver.plan_mut().state_mut(2)[7] = f64::INFINITY;
    let status = solver.solve(&plant, &instance.problem, instance.time, &instance.state, 20);
    assert!(status == UpdateStatus::Solved && solver.statistics().restarted);
    assert!(largest_difference(&solver.plan().u, &instance.inputs) < 1e-6);
}

#[test]
fn bad_horizons_are_refused_by_name() {
    let plant = FlapBody::default();
    let problem = BankTurn::new([0.0; INTERVALS]);
    assert_eq!(problem.residuals(0), 4);
    for (intervals, step, key) in [(0, 0.005, "intervals"), (5, 0.0, "step_s"), (5, f64::NAN, "step_s")] {
        let error = RealTime::new(&plant, &problem, Settings::new(intervals, step)).unwrap_err();
        assert!(error.to_string().contains(key), "{error}");
    }
}

#[test]
fn the_comparisons_of_the_room_pass() {
    for case in wingbeat_validate::ocp::CASES {
        for row in (case.run)().unwrap() {
            assert!(row.passes(), "{row:?}");
            println!("{row:?}");
        }
    }
}

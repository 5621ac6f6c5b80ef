use wingbeat_validate::aero_full::linear::*;
use wingbeat_validate::aero_full::{ComparedPreset, wings};

#[test]
fn a_step_and_a_slow_motion_settle_on_the_steady_answer() {
    let wing = wings::rectangular(4.0).unwrap();
    let model = ComparedPreset::Full.model(wing.wing.planform(), &[], 1.0, 1e-6).unwrap();
    let small = SmallMotion::new(&model, &wing, RigidMotion::Plunge);
    let steady = small.steady(1).unwrap()[0];
    assert!((small.step(1, &[300.0])[0][0] / steady - 1.0).abs() < 1e-6);
    assert!((small.response(1e-6).unwrap()[0].1 / 1e-6 / steady - 1.0).abs() < 1e-6);
    let pitch = SmallMotion::new(&model, &wing, RigidMotion::Pitch(0.0));
    assert!((pitch.steady(0).unwrap()[0] / steady - 1.0).abs() < 1e-9);
}

#[test]
fn wide_strips_answer_as_narrow_ones() {
    let wing = wings::rectangular(20.0).unwrap();
    let response = |strips: usize| {
        let model = ComparedPreset::Full.model_of(strips, wing.wing.planform(), &[], 1.0, 1e-6).unwrap();
        SmallMotion::new(&model, &wing, RigidMotion::Plunge).response(1.0).unwrap()[0]
    };
    let (wide, narrow) = (response(6), response(24));
    let distance = (wide.0 - narrow.0).hypot(wide.1 - narrow.1);
    assert!(distance < 0.01 * narrow.0.hypot(narrow.1), "{wide:?} {narrow:?}");
}

use nalgebra::DMatrix;
use wingbeat_config::inside::{Slopes, step};

/// min -d1 + d1^2 / 2 + 2 d2 with d1 + d2 >= 0.1 from (.5, .5).
#[test]
fn a_step_is_where_its_conditions_say() {
    let slopes = Slopes { objective: vec![-1.0, 2.0], limits: vec![vec![-1.0, -1.0]] };
    let hessian = DMatrix::from_row_slice(2, 2, &[10.0, 0.0, 0.0, 10.0]);
    // Free of the limit the step is (.1, -.2); on it d = (.1 + m/10, -.2 + m/10) with the multiplier m = 1.
    let step = step(&[0.5, 0.5], (&[0.1], &slopes), &hessian, 100.0, 0.4).unwrap();
    assert!((step.d[0] - 0.2).abs() < 1e-6 && (step.d[1] + 0.1).abs() < 1e-6, "{:?}", step.d);
    assert!((step.multipliers[0] - 1.0).abs() < 1e-5, "{:?}", step.multipliers);
    // It mends the limit by .1 and costs -.2 - .2 + (.4 + .1) / 2.
    assert!((step.gain - (10.0 + 0.4 - 0.25)).abs() < 1e-5, "{}", step.gain);
}

#[test]
fn limits_beyond_reach_are_met_as_far_as_the_radius_goes() {
    let slopes = Slopes { objective: vec![0.0], limits: vec![vec![-1.0]] };
    let step = step(&[0.5], (&[1.0], &slopes), &DMatrix::identity(1, 1), 100.0, 0.1).unwrap();
    assert!((step.d[0] - 0.1).abs() < 1e-6);
}

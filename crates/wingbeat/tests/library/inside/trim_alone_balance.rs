use nalgebra::{DMatrix, Vector3};
use wingbeat_config::inside::least;

#[test]
fn a_step_takes_the_error_off_within_its_room() {
    let slopes = DMatrix::from_row_slice(3, 4, &[1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let off = Vector3::new(-1.5, 0.2, 0.0);
    let room = vec![[-1.0, 0.5], [-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0]];
    let step = least(&slopes, &off, 0.0, &room);
    assert!((step[0] - 0.5).abs() < 1e-12 && (step[3] - 1.0).abs() < 1e-12, "{step:?}");
    assert!((step[1] + 0.2).abs() < 1e-12, "{step:?}");
}

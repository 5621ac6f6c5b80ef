use std::path::Path;

use wingbeat_config::inside::{LARGEST, largest, text_of, unit};

#[test]
fn the_unit_of_the_innermost_key_counts() {
    assert_eq!(largest("robot.wing.planform_shift_m"), 1e4);
    assert_eq!(largest("body.nose_up_deg.fourier.cos[2]"), 3600.0);
    assert_eq!(largest("start.velocity_m_s[0]"), 1e4);
    assert_eq!(largest("robot.body.inertia_kg_m2[1]"), 1e6);
    assert_eq!(largest("robot.numbers.\"body.com_m[0]\""), 1e4);
    assert_eq!(largest("robot.numbers.\"body.mass_kg\""), 1e5);
    assert_eq!(largest("draws[0].low"), LARGEST);
    assert_eq!(largest("controller.weights.roll"), LARGEST);
    assert_eq!((unit("wind.speed_m_s"), unit("body.nose_up_deg.constant"), unit("cd0")), ("m/s", "deg", ""));
}

#[test]
fn what_may_have_no_end_is_not_read() {
    let why = |path: &str| text_of(Path::new(path)).unwrap_err().to_string();
    assert_eq!(why("/dev/zero"), "not a regular file");
    assert_eq!(why("/"), "not a regular file");
}

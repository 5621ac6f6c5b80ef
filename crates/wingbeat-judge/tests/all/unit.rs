//! Units of measured channels.

use wingbeat_judge::unit::{ChannelQuantity, is_load};

#[test]
fn names_are_known_however_they_are_written() {
    for name in ["Nmm", "N-mm", "N mm", "N·mm", "nmm"] {
        assert_eq!(ChannelQuantity::Moment.factor(name), Some(1e-3), "{name}");
    }
    assert_eq!(ChannelQuantity::Angle.factor("turns"), Some(std::f64::consts::TAU));
    assert_eq!((ChannelQuantity::Force.factor("Nm"), ChannelQuantity::Time.factor("")), (None, None));
    // 1 lbf ft = 12 lbf in = 12 x 0.0254 m x 4.448... N (exact by definition).
    let foot = ChannelQuantity::Moment.factor("lbf-ft").unwrap();
    assert!((foot - 12.0 * 0.0254 * 4.448_221_615_260_5).abs() < 1e-15);
}

#[test]
fn a_load_is_told_by_its_unit_and_else_by_its_name() {
    for unit in ["N", "mN", "N mm", "mN·mm", "µN", "lbf", "kgf", "gf", "lbf-in", "ozf-in"] {
        assert!(is_load("a", unit), "{unit}");
    }
    assert!(is_load("Fz", "V") && is_load("ty", "counts") && is_load("My", ""));
    for (name, unit) in [("temp", "degC"), ("temp", ""), ("Tx", "deg"), ("wind", "m/s"), ("power", "W")] {
        assert!(!is_load(name, unit), "{name} {unit}");
    }
    // 1 ozf = 1/16 lbf, 1 in = 0.0254 m (exact by definition).
    let [force, moment] =
        [ChannelQuantity::Force.factor("ozf"), ChannelQuantity::Moment.factor("ozf-in")].map(Option::unwrap);
    assert!((force - 4.448_221_615_260_5 / 16.0).abs() < 1e-15 && (moment - 0.0254 * force).abs() < 1e-15);
}

#[test]
fn no_name_means_two_quantities() {
    for (a, b) in
        [(ChannelQuantity::Force, ChannelQuantity::Moment), (ChannelQuantity::Time, ChannelQuantity::Angle)]
    {
        assert!(a.names().iter().all(|name| b.factor(name).is_none()));
    }
}

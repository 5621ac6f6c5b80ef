use wingbeat::math::GRAVITY;
use wingbeat_config::inside::Size;

#[test]
fn a_guess_follows_the_scaling_laws() {
    // A pigeon: .333 kg, .67 m, .063 m2 (Pennycuick 1996, table 1 gives 5.6 to 6 Hz observed).
    let pigeon = Size { mass: 0.333, span: 0.67, area: 0.063, wing: 0.063, density: 1.225, room: 0.02 };
    assert!((4.5..7.5).contains(&pigeon.frequency()), "{}", pigeon.frequency());
    let twice = Size { mass: 0.666, ..pigeon };
    assert!((twice.frequency() / pigeon.frequency() - 2f64.powf(0.375)).abs() < 1e-12);
    let lift = 0.5 * 1.225 * pigeon.speed().powi(2) * 0.063 * 0.6;
    assert!((lift - 0.333 * GRAVITY).abs() < 1e-12);
}

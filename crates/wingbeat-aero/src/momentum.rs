//! What the momentum of the air asks of any wing.

use std::f64::consts::PI;
use wingbeat_math::Vec3;

/// Halvings of the interval in which the induced velocity lies: to rounding.
const HALVINGS: usize = 60;

/// Least power, W, that gives air of the density `density` (kg/m3) the momentum of the mean force `force` (N) on a wing that stays within
/// `radius` (m) of a point which the air passes at the velocity `wind` (m/s): the air through that circle takes all of it at one
/// velocity. Of a wing at rest in the wind it is the induced drag of the elliptic loading times the speed, of one that hovers the
/// ideal power of the disc, and of a propeller what it takes beyond thrust times speed.
///
/// Against the force, w norm(U - w f) has a largest value where the air across is slow, u_across^2 < u_along^2/8: a turbine halves the velocity
/// there. Momentum bounds the power of a larger force by the velocity of the largest.
///
/// Equation: aero.induced_power
/// `P = F w, 2 rho pi R^2 w norm(U - w f) = F, f the unit vector of F`
/// Source: Glauert 1926 (forward flight), Rankine & Froude (axial).
/// Test: `the_induced_power_is_that_of_discs_and_elliptic_wings`.
pub fn induced_power(force: Vec3, wind: Vec3, density: f64, radius: f64) -> f64 {
    let size = force.norm();
    let flux = size / (2.0 * density * PI * radius * radius);
    if !(size > 0.0 && flux.is_finite()) {
        return 0.0;
    }
    // Along the velocity that the air is given, and across.
    let along = -wind.dot(force) / size;
    let across = (wind.dot(wind) - along * along).max(0.0).sqrt();
    let given = |w: f64| w * across.hypot(along + w);
    let falls = along * along - 8.0 * across * across;
    let most = if along >= 0.0 {
        flux.sqrt()
    } else if falls > 0.0 {
        0.25 * (-3.0 * along - falls.sqrt())
    } else {
        // Where w is twice the velocity along or more, the air through the circle is at least half as fast as w.
        (-2.0 * along).max((2.0 * flux).sqrt())
    };
    let mut bounds = [0.0, most];
    for _ in 0..HALVINGS {
        let middle = 0.5 * (bounds[0] + bounds[1]);
        bounds[usize::from(given(middle) >= flux)] = middle;
    }
    size * bounds[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_induced_power_is_that_of_discs_and_elliptic_wings() {
        let (density, radius) = (1.2, 0.5);
        let disc = PI * radius * radius;
        let up = |n: f64| Vec3::new(0.0, 0.0, n);
        let near = |value: f64, sought: f64| assert!((value / sought - 1.0).abs() < 1e-9, "{value} {sought}");
        // Hover: sqrt(F^3 / (2 rho A)).
        near(induced_power(up(2.0), Vec3::ZERO, density, radius), (8.0 / (2.0 * density * disc)).sqrt());
        // Fast forward flight: L^2 / (q pi b^2) times the speed.
        let (speed, lift) = (200.0, 1e-2);
        let drag = lift * lift / (0.5 * density * speed * speed * PI * (2.0 * radius) * (2.0 * radius));
        let wind = Vec3::new(-speed, 0.0, 0.0);
        near(induced_power(up(lift), wind, density, radius), drag * speed);
        // A propeller: w = -U/2 + sqrt(U^2/4 + T/(2 rho A)).
        let thrust = 3.0;
        let w = -1.0 + (1.0 + thrust / (2.0 * density * disc)).sqrt();
        near(
            induced_power(Vec3::new(thrust, 0.0, 0.0), Vec3::new(-2.0, 0.0, 0.0), density, radius),
            thrust * w,
        );
        // A turbine takes at most what Betz found: w = U/3 there.
        let drag = 2.0 * density * disc * (4.0 / 3.0) * (4.0 - 4.0 / 3.0);
        let taken = drag * 4.0
            - induced_power(Vec3::new(-drag, 0.0, 0.0), Vec3::new(-4.0, 0.0, 0.0), density, radius);
        near(taken, 16.0 / 27.0 * 0.5 * density * disc * 64.0);
        let level = lift * lift / (0.5 * density * speed * PI * 4.0 * radius * radius);
        // A wing that glides or is blown needs what it needs in level flight, but for the cosine of the slope.
        for slope in [-0.3_f64, -0.02, -1e-9, 0.0, 1e-9, 0.02, 0.3] {
            let wind = Vec3::new(-speed * slope.cos(), 0.0, speed * slope.sin());
            let power = induced_power(up(lift), wind, density, radius);
            assert!((power / level - 1.0).abs() < slope * slope + 1e-9, "{slope} {power}");
        }
        // Where the product rises throughout it is the flux; where it does not, at least up to its largest value.
        for (across, heavy) in [(2.0, 1.0), (0.8, 0.1), (0.8, 100.0), (0.2, 1e-3)] {
            let force = up(heavy);
            let w = induced_power(force, Vec3::new(-across, 0.0, 2.0), density, radius) / heavy;
            let flux = heavy / (2.0 * density * disc);
            near(w * across.hypot(w - 2.0), flux);
        }
        let least = |across: f64| induced_power(up(9.0), Vec3::new(-across, 0.0, 2.0), density, radius) / 9.0;
        assert!(least(0.0) == 1.0 && least(0.2) > 1.0 && least(0.2) < 1.5);
        // No force, no air.
        assert_eq!(induced_power(Vec3::ZERO, wind, density, radius), 0.0);
        assert_eq!(induced_power(up(1.0), wind, 0.0, radius), 0.0);
    }
}

//! Structure elements that bear what the wings give them: eq. (6) of the paper with loads.

use super::energy;
use crate::{ComparisonRow, Error};
use std::f64::consts::TAU;
use wingbeat::math::{Jet, Mat3, Vec3};
use wingbeat::robot::{Air, BodyMotion, Robot, Wind};
use wingbeat::scenario::Document;

/// Inertia of the link about its hinge, kg m2.
const LINK: f64 = 4.8e-6;
/// Frequency of the element by itself, Hz.
const FREQUENCY: f64 = 10.0;

/// A link on a hinge about the vertical, and its element of the inertia given, kg m2.
fn hinge(inertia: f64) -> Result<Robot, Error> {
    let text = format!(
        "name = \"hinge\"\n[body]\nmass_kg = 0.1\ninertia_kg_m2 = [1e-4, 1e-4, 1e-4]\n\
         [gait.fourier]\nfrequency_hz = 4.0\n\
         [[links]]\nname = \"arm\"\naxis = [0.0, 0.0, 1.0]\nmass_kg = 2e-3\ncom_m = [0.0, 0.03, 0.0]\n\
         inertia_kg_m2 = [3e-6, 1e-7, 3e-6]\ndriven = {{}}\n\
         [[structure.elements]]\nname = \"arm\"\nmoves = [\"arm\"]\nlow = -1.0\nhigh = 1.0\n\
         frequency_hz = {FREQUENCY}\ndamping = 0.0\ninertia = {inertia:e}\n"
    );
    let spec = Document::text("hinge", &text)
        .and_then(|d| d.robot())
        .map_err(|e| Error::reference("hinge", e.to_string()))?;
    let air = Air { density: 1.2, wind: Wind::steady(Vec3::ZERO) };
    Ok(Robot::new(&spec, Vec::new(), air, 0.0)?)
}

/// Frequency of the hinge on a body at rest, Hz, from the slope of its acceleration.
fn frequency(inertia: f64) -> Result<f64, Error> {
    let robot = hinge(inertia)?;
    let still = BodyMotion::steady(Mat3::IDENTITY, Vec3::ZERO);
    let (x, mut dx) = ([0.1, 0.0], [0.0; 2]);
    robot.carried_in_numbers(&Jet::new(0.0, 1.0, 0.0), &still, &x, &[0.0], &mut dx)?;
    Ok((-dx[1] / x[0]).sqrt() / TAU)
}

/// The rows.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut worst = 0.0_f64;
    for inertia in [1e-7, 2e-6, 1e-4] {
        let exact = FREQUENCY * (inertia / (inertia + LINK)).sqrt();
        worst = worst.max((frequency(inertia)? / exact - 1.0).abs());
    }
    let mut rows = vec![
        ComparisonRow::judged(
            "fsi.element.frequency",
            "f sqrt(m/(m + I))",
            "max relative error of the frequency of a hinge, inertia of the actuator .02 to 20 of the link's",
            worst,
            1e-9,
            "",
        ),
        ComparisonRow::judged(
            "fsi.element.driven",
            "the element by itself",
            "relative error of the frequency with an inertia of 1e6 of the link's",
            (frequency(1e6 * LINK)? / FREQUENCY - 1.0).abs(),
            1e-6,
            "",
        ),
    ];
    rows.extend(energy::element_rows()?);
    Ok(rows)
}

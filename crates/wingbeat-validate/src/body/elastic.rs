//! Frequency of a link on a spring, carried by a free body.

use wingbeat::math::{Quat, Vec3};
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::{Air, Robot, Wind};
use wingbeat::scenario::Document;

use crate::{ComparisonRow, Error};

/// Mass (kg) and moment of inertia about y (kg m2) of body and link.
const MASSES: [(f64, f64); 2] = [(0.02, 3e-5), (0.007, 4e-6)];
/// Joint on the body from the body's centre of mass, and the link's centre of mass from the joint: x and z, m.
const HINGE: [f64; 2] = [-0.03, 0.012];
const ARM: [f64; 2] = [-0.04, -0.015];
/// Direction of the slide in the plane.
const SLIDE: [f64; 2] = [0.6, 0.8];
const STIFFNESS: f64 = 0.05;

/// The two-body robot with a joint of the kind `joint` about or along `axis`.
fn robot(joint: &str, axis: [f64; 3]) -> Result<Robot, Error> {
    let [(body, body_inertia), (link, link_inertia)] = MASSES;
    let ([hx, hz], [ax, az]) = (HINGE, ARM);
    let text = format!(
        r#"
name = "two_bodies"
body = {{ mass_kg = {body}, inertia_kg_m2 = [2e-5, {body_inertia:e}, 2e-5] }}
[[links]]
name = "link"
origin_m = [{hx}, 0.0, {hz}]
joint = "{joint}"
axis = {axis:?}
mass_kg = {link}
com_m = [{ax}, 0.0, {az}]
inertia_kg_m2 = [3e-6, {link_inertia:e}, 3e-6]
elastic = {{ stiffness = {STIFFNESS}, rest = 0.0 }}
"#
    );
    let spec =
        Document::text("beam", &text).and_then(|d| d.robot()).map_err(|e| Error::NoAnswer(e.to_string()))?;
    let vacuum = Air { density: 0.0, wind: Wind::steady(Vec3::ZERO) };
    Ok(Robot::new(&spec, Vec::new(), vacuum, 0.0)?)
}

/// Frequency of the joint by the exact linearisation, rad/s.
fn frequency(robot: &Robot) -> Result<f64, Error> {
    let (n, l) = (robot.states().len(), *robot.layout());
    let mut x = vec![0.0; n];
    Quat::from_roll_pitch_yaw(0.3, -0.4, 0.5).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(1.0, -0.5, 0.2).store(&mut x[l.velocity..]);
    let mut exact = Linearisation::new(n, 0);
    exact.evaluate(robot, 0.0, &x, &[])?;
    Ok((-exact.a[(l.joints + 1) * n + l.joints]).sqrt())
}

/// Inertia that the spring of a hinge and that of a slide move, momentum and moment of momentum staying zero: with the
/// reduced mass m, r from centre to centre, J = I1 + I2 + m r2,
/// I2 + m d2 - (I2 + m r.d)2 / J and m - (m r x n)2 / J.
fn moved_inertia() -> [f64; 2] {
    let [(m1, i1), (m2, i2)] = MASSES;
    let m = m1 * m2 / (m1 + m2);
    let r = [HINGE[0] + ARM[0], HINGE[1] + ARM[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let whole = i1 + i2 + m * dot(r, r);
    let hinge = i2 + m * dot(ARM, ARM) - (i2 + m * dot(r, ARM)).powi(2) / whole;
    let slide = m - (m * (r[0] * SLIDE[1] - r[1] * SLIDE[0])).powi(2) / whole;
    [hinge, slide]
}

/// The row.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let found = [
        frequency(&robot("revolute", [0.0, 1.0, 0.0])?)?,
        frequency(&robot("prismatic", [SLIDE[0], 0.0, SLIDE[1]])?)?,
    ];
    let exact = moved_inertia().map(|inertia| (STIFFNESS / inertia).sqrt());
    let worst = found.iter().zip(exact).map(|(f, e)| (f / e - 1.0).abs()).fold(0.0, f64::max);
    let metric = "max relative error of the frequency, hinge and slide on a free body";
    Ok(vec![ComparisonRow::judged(
        "body.elastic_frequency",
        "closed form of two bodies",
        metric,
        worst,
        1e-6,
        "",
    )])
}

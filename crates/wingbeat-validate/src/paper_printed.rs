//! Preset `as_printed` on a flapping, swept wing beside the paper's definitions written apart: the reduced time by the velocity
//! of each section's quarter chord perpendicular to the sweep, the lift turned by the wash, the drag of a section.

use std::f64::consts::PI;

use wingbeat::aero::{
    JONES_RATES, JONES_WEIGHTS, LiftTilt, LiftingLine, LiftingLineSettings, Loads, Planform, PlanformStation,
    ProfileDrag, SectionMotion,
};
use wingbeat::math::Vec3;

use crate::shipped::scenario;
use crate::{Case, ComparisonRow, Error};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "paper.printed", quick: true, run: printed },
    Case { id: "paper.drag_curve", quick: true, run: drag_curve },
];

const NODES: usize = 10;
const SLOPE: f64 = 2.0 * PI;
const DENSITY: f64 = 1.225;
const DRAG: ProfileDrag = ProfileDrag { cd0: 0.39, cd90: 3.0 };

/// Stations of a wing with a kink and sweep both ways: arc, leading and trailing edge, m.
const STATIONS: [[f64; 3]; 4] =
    [[0.0, 0.06, -0.09], [0.05, 0.06, -0.1], [0.13, 0.1, -0.02], [0.2, 0.08, 0.03]];

/// Value and slope of an edge or a mean of both edges at the distance `arc` from the middle, m.
fn line(arc: f64, share: f64) -> [f64; 2] {
    let at = |k: usize| STATIONS[k][1] + share * (STATIONS[k][2] - STATIONS[k][1]);
    let k = (1..STATIONS.len() - 1).find(|&k| arc < STATIONS[k][0]).unwrap_or(STATIONS.len() - 1);
    let slope = (at(k) - at(k - 1)) / (STATIONS[k][0] - STATIONS[k - 1][0]);
    [at(k - 1) + slope * (arc - STATIONS[k - 1][0]), slope]
}

/// The wings flap about the body's axis by this angle, rad, and rate, rad/s, while the body moves and turns.
const FLAP: [f64; 2] = [0.3, 9.0];
const VELOCITY: Vec3 = Vec3([1.1, 0.2, -0.1]);
const RATE: Vec3 = Vec3([0.4, -0.7, 0.5]);

/// Outward direction of a half wing and the direction in which it flaps; `side` is 1 for the left one.
fn half(side: f64) -> [Vec3; 2] {
    let (sine, cosine) = FLAP[0].sin_cos();
    [Vec3([0.0, side * cosine, sine]), Vec3([0.0, -side * sine, cosine])]
}

/// Place and velocity of the point at `x` ahead of the hinge line and the distance `arc` from the middle of a half wing.
fn point(side: f64, arc: f64, x: f64) -> [Vec3; 2] {
    let [out, up] = half(side);
    let place = Vec3([x, 0.0, 0.0]) + out * arc;
    [place, VELOCITY + RATE.cross(place) + up * (FLAP[1] * arc)]
}

/// The same as the program is told it.
fn motion(arc: f64) -> SectionMotion<f64> {
    let (side, distance) = (if arc < 0.0 { -1.0 } else { 1.0 }, arc.abs());
    let [[le, v_le], [te, v_te]] = [0.0, 1.0].map(|share| point(side, distance, line(distance, share)[0]));
    SectionMotion { le, te, v_le, v_te, span: half(side)[0] * -side, ..SectionMotion::default() }
}

/// What is compared of a node.
struct NodeComparison {
    /// Rates of the series and of both lags.
    rates: [f64; 3],
    lift: Vec3,
    drag: Vec3,
}

/// The node at `angle`, with the series at all nodes, its own two lags, and the airspeed U.
fn apart(i: usize, series: &[f64], lags: [f64; 2], stream: f64, tilt: LiftTilt) -> NodeComparison {
    let angles: Vec<f64> = (1..=NODES).map(|i| i as f64 * PI / (NODES + 1) as f64).collect();
    let (span, angle) = (2.0 * STATIONS[3][0], angles[i]);
    let arc = 0.5 * span * angle.cos();
    let (side, distance) = (arc.signum(), arc.abs());
    let [leading, trailing] = [0.0, 1.0].map(|share| line(distance, share)[0]);
    let (chord, root) = (leading - trailing, STATIONS[0][1] - STATIONS[0][2]);
    let at = |share: f64| point(side, distance, leading - share * chord)[1];
    // Chord towards the trailing edge, the normal upwards.
    let (back, normal) = (Vec3([-1.0, 0.0, 0.0]), half(side)[1]);
    let motion = -at(0.75).dot(normal);
    // (2), with the coefficients of the series at the nodes.
    let coefficient = |n: usize| {
        let sum: f64 = (0..NODES).map(|j| series[j] * ((n + 1) as f64 * angles[j]).sin()).sum();
        sum * 2.0 / (NODES + 1) as f64
    };
    let sum: f64 = (0..NODES)
        .map(|n| (n + 1) as f64 * coefficient(n) * ((n + 1) as f64 * angle).sin() / angle.sin())
        .sum();
    let downwash = motion - SLOPE * root * stream / (4.0 * span) * sum;
    // The reduced time.
    let along = Vec3([line(distance, 0.25)[1], 0.0, 0.0]) + half(side)[0];
    let quarter = at(0.25);
    let speed = (quarter - along * (quarter.dot(along) / along.dot(along))).norm();
    let effective = downwash * (1.0 - JONES_WEIGHTS[0] - JONES_WEIGHTS[1])
        + JONES_WEIGHTS[0] * lags[0]
        + JONES_WEIGHTS[1] * lags[1];
    let lag = |k: usize| JONES_RATES[k] * speed / (0.5 * chord) * (downwash - lags[k]);
    // The lift of (4), normal to the wind with the wash that turns it; the share of suction is the program's choice.
    let width = 0.5 * span * angle.sin() * PI / (NODES + 1) as f64;
    let size = 0.5 * DENSITY * stream * chord * SLOPE * effective * width;
    let wash = if tilt == LiftTilt::Wash { effective } else { downwash };
    let headwind = -at(0.5).dot(back);
    let cosine = headwind / headwind.hypot(wash);
    let suction = 0.5 * (1.0 + (4.0 * cosine.atanh()).tanh());
    let lift = (normal * headwind.abs() - back * (wash * suction)) * (size / headwind.hypot(wash));
    // The drag, along the wind of motion at half chord; the weight of the area is Fejer's.
    let up = -at(0.5).dot(normal);
    let wind = headwind.hypot(up);
    let fejer: f64 = (1..=NODES / 2).map(|k| (2 * k - 1) as f64).map(|n| (n * angle).sin() / n).sum();
    let area = chord * 0.5 * span * fejer * 4.0 * angle.sin() / (NODES + 1) as f64;
    let drag = (back * headwind + normal * up)
        * (0.5 * DENSITY * area * wind * (DRAG.cd0 + DRAG.cd90 * (up / wind).powi(2)));
    let series_rate = effective / root - stream / chord * series[i];
    NodeComparison { rates: [series_rate, lag(0), lag(1)], lift, drag }
}

/// Largest differences of rates, lift and drag over the largest value of each.
fn differences(tilt: LiftTilt) -> Result<[f64; 3], Error> {
    let stations = STATIONS.map(|[arc_m, leading_edge_m, trailing_edge_m]| PlanformStation {
        arc_m,
        leading_edge_m,
        trailing_edge_m,
    });
    let set =
        LiftingLineSettings { nodes: NODES, regularisation_m_s: 1e-9, ..LiftingLineSettings::default() };
    let mut set = LiftingLineSettings { lift_tilt: tilt, chord_floor_m: 1e-9, ..set.printed() };
    set.section.drag = DRAG;
    let line = LiftingLine::new(&Planform::new(&stations)?, set)?;
    let motions: Vec<SectionMotion<f64>> = line.arcs().iter().map(|&arc| motion(arc)).collect();
    let x: Vec<f64> = (0..3 * NODES).map(|i| 0.4 * (1.3 * i as f64 + 0.2).sin()).collect();
    let (mut dx, mut loads) = (vec![0.0; x.len()], Loads::default());
    line.evaluate(&motions, Vec3::ZERO, &x, &mut dx, &mut loads);
    let middle = motions[NODES];
    let stream = ((middle.v_le + middle.v_te) * 0.5).norm();
    let (mut worst, mut largest) = ([0.0_f64; 3], [0.0_f64; 3]);
    for i in 0..NODES {
        let node = apart(i, &x[..NODES], [x[NODES + i], x[2 * NODES + i]], stream, tilt);
        let own = [dx[i], dx[NODES + i], dx[2 * NODES + i]];
        for (a, b) in own.into_iter().zip(node.rates) {
            (worst[0], largest[0]) = (worst[0].max((a - b).abs()), largest[0].max(b.abs()));
        }
        let strip = &loads.strip[i];
        let lift = strip.circulatory.force + strip.induced_drag.force;
        for (k, (a, b)) in [(lift, node.lift), (strip.profile_drag.force, node.drag)].into_iter().enumerate()
        {
            (worst[k + 1], largest[k + 1]) = (worst[k + 1].max((a - b).norm()), largest[k + 1].max(b.norm()));
        }
    }
    Ok([0, 1, 2].map(|k| worst[k] / largest[k]))
}

/// Rows of the rates, of the lift turned by either wash, and of the drag.
fn printed() -> Result<Vec<ComparisonRow>, Error> {
    let ([rates, lift, drag], [_, down, _]) =
        (differences(LiftTilt::Wash)?, differences(LiftTilt::Downwash)?);
    let source = "the paper's definitions, written apart";
    let metric = |what: &str| format!("{what}, over the largest, flapping swept wing");
    let row =
        |id: &str, what: &str, value| ComparisonRow::judged(id, source, &metric(what), value, 1e-12, "");
    Ok(vec![
        row(
            "paper.printed.lags",
            "worst difference of rates of series and lags, reduced time by section",
            rates,
        ),
        row("paper.printed.tilt", "worst difference of lift turned by the effective wash", lift),
        row("paper.printed.downwash", "worst difference of lift turned by the downwash of (2)", down),
        row("paper.printed.drag", "worst difference of profile drag", drag),
    ])
}

/// The drag of the sections of `paper_turn` beside the curve that it is a fit to.
fn drag_curve() -> Result<Vec<ComparisonRow>, Error> {
    let scenario = scenario("paper_turn", &[])?;
    let (_, aero) =
        scenario.robot().surfaces().next().ok_or_else(|| Error::reference("paper_turn", "no wing"))?;
    let own = aero.numbers().drag();
    let worst = (0..=900).map(|i| f64::from(i) * 0.1).fold(0.0_f64, |worst, degrees| {
        let curve = 1.92 - 1.55 * (2.04 * degrees - 9.82).to_radians().cos();
        let fit = own.cd0 + own.cd90 * degrees.to_radians().sin().powi(2);
        worst.max((fit - curve).abs())
    });
    let source = "Dickinson, Lehmann & Sane 1999, Science 284: C_D = 1.92 - 1.55 cos(2.04 a - 9.82 deg)";
    let metric = "worst difference of the drag coefficient of paper_turn, a fit, 0 to 90 deg";
    // A limit of our choice: 6 % of the curve's largest value.
    Ok(vec![ComparisonRow::judged("paper.drag_curve", source, metric, worst, 0.2, "")])
}

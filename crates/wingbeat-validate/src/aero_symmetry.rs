//! A motion that is its own mirror image makes no side force: on the tether with every kind of hinge, and in flight.

use crate::aero_full::{ComparedPreset, last_cycle};
use crate::aero_turn::turn;
use crate::{Case, ComparisonRow, Error};
use wingbeat::aero::{Planform, PlanformStation};
use wingbeat::math::{Quat, Vec3};
use wingbeat::plant::Plant;
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Hinge, HingeKind, Motion, Side, Tether, Wing};

/// The comparisons.
pub const CASES: &[Case] = &[Case { id: "aero.symmetry", quick: true, run: symmetry }];

/// Numbers of strips or nodes, even and odd.
const STRIPS: [usize; 4] = [8, 9, 13, 16];
const LIMIT: f64 = 1e-12;
const FREQUENCY: f64 = 3.5;
const SPEED: f64 = 1.5;

/// Kind, arc, end of a growing twist and place of the axis, m.
const HINGES: [(&str, HingeKind, f64, Option<f64>, f64); 8] = [
    ("flap", HingeKind::Flap, 0.0207, None, 0.0),
    ("flap_middle", HingeKind::Flap, 0.0, None, 0.0),
    ("fold", HingeKind::Fold, 0.0707, None, 0.0),
    ("twist", HingeKind::Twist, 0.0707, None, 0.01),
    ("twist_middle", HingeKind::Twist, 0.0, None, 0.01),
    ("twist_growing", HingeKind::Twist, 0.0207, Some(0.2), 0.0),
    ("sweep", HingeKind::Sweep, 0.0707, None, 0.01),
    ("sweep_middle", HingeKind::Sweep, 0.0, None, 0.0),
];

/// Aerobat's outline, coarsely.
fn outline() -> Result<Planform, Error> {
    let rows = [[0.0, 0.02, -0.14], [0.0707, 0.035, -0.153], [0.1547, 0.076, -0.025], [0.2027, 0.059, 0.039]];
    let stations = rows.map(|[arc_m, leading_edge_m, trailing_edge_m]| PlanformStation {
        arc_m,
        leading_edge_m,
        trailing_edge_m,
    });
    Ok(Planform::new(&stations)?)
}

/// A wing that flaps at the shoulder and moves by one more hinge, in a wind from ahead and below.
fn tether(
    preset: ComparedPreset,
    strips: usize,
    (_, kind, arc_m, to_arc_m, ahead_m): (&str, HingeKind, f64, Option<f64>, f64),
) -> Result<Tether, Error> {
    let wave = |mean: f64, sin: f64| Coordinate::Fourier {
        frequency_hz: FREQUENCY,
        mean,
        cos: vec![0.3 * sin],
        sin: vec![sin],
    };
    let hinge = |kind, arc_m, to_arc_m, ahead_m| Hinge { kind, side: Side::Both, arc_m, to_arc_m, ahead_m };
    let mut hinges = vec![hinge(HingeKind::Flap, 0.0207, None, 0.0), hinge(kind, arc_m, to_arc_m, ahead_m)];
    let mut angles = vec![("flap".to_string(), wave(0.1, 0.5)), ("hinge".to_string(), wave(-0.2, 0.4))];
    if arc_m < 0.0207 {
        hinges.reverse();
        angles.reverse();
    }
    let arcs: Vec<f64> = hinges.iter().map(|h| h.arc_m).filter(|arc| *arc > 0.0).collect();
    let wing = outline()?;
    Ok(Tether {
        aero: preset.model_of(strips, &wing, &arcs, 1.225, 0.05)?,
        wing: Wing::new(wing, hinges)?,
        motion: Motion { nose_up: Coordinate::Constant(0.1), hinges: angles, ..Motion::at_rest() },
        wind: Vec3::new(-SPEED, 0.0, 0.2),
        side: Side::Both,
        reference: CoefficientScales { density_kg_m3: 1.225, speed_m_s: SPEED, area_m2: 0.05, chord_m: 0.12 },
        clock: Clock { frequency_hz: FREQUENCY, cycles: 1, steps_per_cycle: 64 },
        spar: None,
        ground: None,
    })
}

/// Largest side force over the largest force.
fn side_force(tether: &Tether) -> Result<f64, Error> {
    let cycle = last_cycle(tether)?;
    let largest = |of: fn(Vec3) -> f64| cycle.iter().map(|l| of(l.wrench.force)).fold(0.0, f64::max);
    Ok(largest(|f| f[1].abs()) / largest(|f| f.norm()))
}

/// Largest sideways acceleration of the flying robot over its largest acceleration, in states that are their own
/// mirror images.
fn sideways(strips: usize) -> Result<f64, Error> {
    let scenario = turn(&[format!("aero.full.strips={strips}")])?;
    let (robot, l) = (scenario.robot(), *scenario.robot().layout());
    let mirror = robot.mirror()?;
    let (mut x, mut dx, u) = (vec![0.0; l.len], vec![0.0; l.len], vec![0.0; robot.inputs().len()]);
    let (mut side, mut largest) = (0.0_f64, 0.0_f64);
    for case in 0..200 {
        let draw = |i: usize| (1.7 * i as f64 + 0.61 * f64::from(case) * (1.0 + i as f64)).sin();
        let kept: Vec<f64> = (0..mirror.states.len()).map(|i| 0.1 * draw(i)).collect();
        mirror.expand_states(&kept, &mut x[l.structure..]);
        Quat::from_roll_pitch_yaw(0.0, draw(1), 0.0).store_wxyz(&mut x[l.attitude..]);
        Vec3::new(1.5 + draw(2), 0.0, draw(3)).store(&mut x[l.velocity..]);
        Vec3::new(0.0, 3.0 * draw(4), 0.0).store(&mut x[l.rate..]);
        robot.rates_in_numbers(0.01 * f64::from(case), &x, &u, &mut dx)?;
        side = side.max(dx[l.velocity + 1].abs());
        largest = dx[l.velocity..l.velocity + 3].iter().fold(largest, |m, a| m.max(a.abs()));
    }
    Ok(side / largest)
}

fn symmetry() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    for hinge in HINGES {
        let mut worst = 0.0_f64;
        for preset in [ComparedPreset::Full, ComparedPreset::Paper] {
            for strips in STRIPS {
                worst = worst.max(side_force(&tether(preset, strips, hinge)?)?);
            }
        }
        let id = format!("aero.symmetry.{}", hinge.0);
        let metric = "tether, presets full and paper, 8 to 16 strips: side force over the largest";
        rows.push(ComparisonRow::judged(&id, "mirror image", metric, worst, LIMIT, ""));
    }
    let worst = STRIPS.iter().try_fold(0.0_f64, |m, &strips| sideways(strips).map(|s| m.max(s)))?;
    let metric = "flight, preset full, 8 to 16 strips: sideways acceleration over the largest";
    rows.push(ComparisonRow::judged("aero.symmetry.flight", "mirror image", metric, worst, LIMIT, ""));
    Ok(rows)
}

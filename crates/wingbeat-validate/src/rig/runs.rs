//! Whole runs on the rig: limits, wrenches, processing.

use std::f64::consts::TAU;
use std::path::Path;

use wingbeat::math::{GRAVITY, Jet, Mat3, Vec3, Wrench};
use wingbeat::rig::arm::LimitProfile;
use wingbeat::rig::carrier::{ToolCarrier, carried_frames};
use wingbeat::rig::cell::{CHANNELS, six};
use wingbeat::rig::process::{Butterworth, Comparison};
use wingbeat::rig::{FrameMotion, JointTrajectory, Pose};
use wingbeat::robot::BodyMotion;
use wingbeat::scenario::{Processed, RigRun};
use wingbeat::simulate::Record;

use crate::{ComparisonRow, Error};

/// The seven runs of the paper.
const RUNS: [&str; 7] = [
    "roll10_speed08",
    "roll15_speed08",
    "roll20_speed08",
    "roll25_speed08",
    "roll15_speed07",
    "roll15_speed08b",
    "roll15_speed09",
];

fn load(name: &str, overrides: &[&str]) -> Result<RigRun, Error> {
    let file = format!("{}/../../rigs/runs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    RigRun::load(Path::new(&file), &overrides).map_err(|error| Error::NoAnswer(error.to_string()))
}

/// Differences of the 1 kHz positions against every limit: the worst of the runs, then run by run; a refused path is
/// shown with the limit it names.
pub fn limits_respected() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.limits_respected";
    let (mut worst, mut rows) = (0.0_f64, Vec::new());
    for name in RUNS {
        let run = load(name, &[])?;
        let (id, source) = (format!("{ID}.{name}"), format!("limit profile {}", run.profile.name));
        match run.plan()? {
            Ok(plan) => {
                let share = largest_share(&plan.trajectory, &run.profile);
                worst = worst.max(share);
                rows.push(ComparisonRow::judged(&id, &source, "largest share of a limit", share, 1.0, ""));
            }
            Err(refusal) => {
                rows.push(ComparisonRow::shown(&id, &source, &format!("refused: {refusal}"), f64::NAN, ""))
            }
        }
    }
    let metric = "largest share of a limit of velocity, acceleration or jerk, all runs";
    rows.insert(0, ComparisonRow::judged(ID, "limit profiles of the runs", metric, worst, 1.0, ""));
    Ok(rows)
}

/// Largest share of a limit that the positions of `trajectory` take, by differences.
fn largest_share(trajectory: &JointTrajectory, limits: &LimitProfile) -> f64 {
    let (velocity, acceleration) = trajectory.differenced().peaks();
    let jerk = trajectory.peak_jerk();
    [(velocity, &limits.velocity), (acceleration, &limits.acceleration), (jerk, &limits.jerk)]
        .iter()
        .flat_map(|(peaks, limits)| peaks.iter().zip(limits.iter()).map(|(peak, limit)| peak / limit))
        .fold(0.0, f64::max)
}

/// Weight on the cell in 24 attitudes against mass and first moment read off the momentum of a turning robot.
pub fn wrench_static() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.wrench_static";
    let run = load("roll15_speed08", &["rig.air.density_kg_m3=1e-30"])?;
    let clock = Jet::default();
    let still = |attitude: Mat3, rate: Vec3| BodyMotion {
        attitude,
        velocity: Vec3::ZERO,
        rate,
        acceleration: Vec3::ZERO,
        angular_acceleration: Vec3::ZERO,
    };
    // p = w x (m c): three turns give the first moment m c.
    let turning = |axis: usize| {
        let mut w = Vec3::ZERO;
        w[axis] = 1.0;
        run.robot.carried_momentum(&clock, &still(Mat3::IDENTITY, w), Vec3::ZERO).map(|p| p.linear)
    };
    let (px, py) = (turning(0)?, turning(1)?);
    let moment_b = Vec3([-py[2], px[2], -px[1]]);
    let x = vec![0.0; run.robot.carried_states()];
    let mut dx = x.clone();
    let u = vec![0.0; wingbeat::plant::Plant::inputs(&run.robot).len()];
    let mut worst = 0.0_f64;
    for k in 0..24 {
        let k = f64::from(k);
        let rotation = Mat3::from_roll_pitch_yaw(0.9 * k, 0.53 * k - 2.0, 0.37 * k);
        let tool = Pose::constant(&Pose { rotation, origin: Vec3([0.1, 0.2, 0.3]) });
        let (cell, body) = carried_frames(&tool, &run.mount);
        let loads = run.robot.carried_in_numbers(&clock, &BodyMotion::from(&body), &x, &u, &mut dx)?;
        let got = six(&(run.mount.to_cell(&loads.total()) + run.mount.wrench(&cell)));
        let down = cell.pose.rotation.transpose_mul(Vec3([0.0, 0.0, -GRAVITY]));
        let mass = run.robot.mass() + run.mount.mass;
        let first = run.mount.body.rotation * moment_b
            + run.mount.body.origin * run.robot.mass()
            + run.mount.com * run.mount.mass;
        let expected = six(&Wrench { force: down * mass, moment: first.cross(down) });
        for (a, b) in got.iter().zip(expected) {
            worst = worst.max((a - b).abs());
        }
    }
    Ok(vec![ComparisonRow::judged(
        ID,
        "mass and first moment from momentum",
        "largest error, 24 attitudes",
        worst,
        1e-12,
        "N, N m",
    )])
}

/// Cell wrench of the moving rig in vacuum against the rate of momentum.
pub fn newton_euler() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.newton_euler";
    let run = load("roll15_speed08", &["rig.air.density_kg_m3=1e-30"])?;
    let plan = run.plan()?.map_err(|refusal| Error::NoAnswer(refusal.to_string()))?;
    let carrier = run.carrier(Some(&plan));
    let (mut force, mut moment) = (0.0_f64, 0.0_f64);
    for k in 0..40 {
        let t = 0.0505 + 0.06 * f64::from(k);
        let (f, m) = imbalance(&run, &carrier, t)?;
        force = force.max(f);
        moment = moment.max(m);
    }
    let source = "rate of momentum, fourth-order differences";
    Ok(vec![
        ComparisonRow::judged(ID, source, "largest error of the force, 40 instants", force, 1e-8, "N"),
        ComparisonRow::judged(
            &format!("{ID}.moment"),
            source,
            "largest error of the moment, 40 instants",
            moment,
            1e-8,
            "N m",
        ),
    ])
}

/// |cell wrench + weight - rate of momentum| at `t`: force and moment about the base's origin.
fn imbalance(run: &RigRun, carrier: &ToolCarrier, t: f64) -> Result<(f64, f64), Error> {
    let clock = |t: f64| Jet::new(t, 1.0, 0.0);
    let (cell, body) = carried_frames(&carrier.tool(t), &run.mount);
    let x = vec![0.0; run.robot.carried_states()];
    let u = vec![0.0; wingbeat::plant::Plant::inputs(&run.robot).len()];
    let loads = run.robot.carried_in_numbers(&clock(t), &BodyMotion::from(&body), &x, &u, &mut x.clone())?;
    let on_cell = run.mount.to_cell(&loads.total()) + run.mount.wrench(&cell);
    let r = cell.pose.rotation;
    let on_payload = r * -on_cell.force;
    let about_base = r * -on_cell.moment + cell.pose.origin.cross(on_payload);
    // Weight with its moment about the base's origin, from the model at rest.
    let weight_b = loads.gravity;
    let weight = body.pose.rotation * weight_b.force;
    let weight_moment = body.pose.rotation * weight_b.moment + body.pose.origin.cross(weight);
    let mount_weight = Vec3([0.0, 0.0, -GRAVITY * run.mount.mass]);
    let mount_moment = cell.pose.point(run.mount.com).cross(mount_weight);
    let h = 1e-4;
    let at = |k: f64| momentum(run, carrier, &clock(t + k * h), t + k * h);
    let (a, b, c, d) = (at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?);
    let slope = |i: usize| ((a[i] - d[i]) + (c[i] - b[i]) * 8.0) * (1.0 / (12.0 * h));
    let force = on_payload + weight + mount_weight - slope(0);
    let moment = about_base + weight_moment + mount_moment - slope(1);
    Ok((force.norm(), moment.norm()))
}

/// Linear and angular momentum of robot and mount about the base's origin, in W.
fn momentum(run: &RigRun, carrier: &ToolCarrier, clock: &Jet, t: f64) -> Result<[Vec3; 2], Error> {
    let (cell, body) = carried_frames(&carrier.tool(t), &run.mount);
    let robot = run.robot.carried_momentum(clock, &BodyMotion::from(&body), body.pose.origin)?;
    let r = body.pose.rotation;
    let (linear, angular) = rigid_momentum(&cell, run.mount.mass, run.mount.com, run.mount.inertia);
    Ok([r * robot.linear + linear, r * robot.angular + angular])
}

fn rigid_momentum(frame: &FrameMotion, mass: f64, com: Vec3, inertia: Mat3) -> (Vec3, Vec3) {
    let r = frame.pose.rotation;
    let linear = (frame.velocity + frame.rate.cross(r * com)) * mass;
    let spin = r * (inertia * r.transpose_mul(frame.rate));
    (linear, frame.pose.point(com).cross(linear) + spin)
}

/// Sines at the flapping frequency, at the cut-off and above it through the filter of the pipeline.
pub fn filter() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.filter";
    const RATE: f64 = 7000.0;
    let run = load("roll15_speed08", &[])?;
    let f = run.frequency();
    let cutoff = run.spec.process.steps.cutoff_multiple * f;
    let filter = Butterworth::new(cutoff, RATE)?;
    let passed = |f: f64| {
        let x: Vec<f64> = (0..28_000).map(|k| (TAU * f * f64::from(k) / RATE).sin()).collect();
        let y = filter.apply(&x);
        let part = |g: fn(f64) -> f64| {
            (6000..22_000).map(|k| y[k] * g(TAU * f * k as f64 / RATE)).sum::<f64>() / 8000.0
        };
        [part(f64::sin), part(f64::cos)]
    };
    let [sine, cosine] = passed(f);
    let source = "a sine at the flapping frequency";
    let mut rows = vec![
        ComparisonRow::judged(ID, source, "|gain - 1|", (sine.hypot(cosine) - 1.0).abs(), 1e-3, ""),
        ComparisonRow::judged(
            &format!("{ID}.phase"),
            source,
            "|phase|",
            cosine.atan2(sine).abs(),
            1e-3,
            "rad",
        ),
    ];
    let source = "1 / (1 + (w / wc)^8), w = tan(pi f / rate): Butterworth of fourth order, both ways";
    for (name, multiple) in [("cutoff", 1.0), ("above", 1.5)] {
        let [sine, cosine] = passed(multiple * cutoff);
        let w = |f: f64| (0.5 * TAU * f / RATE).tan();
        let gain = 1.0 / (1.0 + (w(multiple * cutoff) / w(cutoff)).powi(8));
        let off = (sine - gain).hypot(cosine);
        let metric = format!("|gain - closed form| at {multiple} times the cut-off");
        rows.push(ComparisonRow::judged(&format!("{ID}.{name}"), source, &metric, off, 1e-6, ""));
    }
    Ok(rows)
}

/// Runs in a vacuum: once weight and inertia are taken away, nothing is left, whatever the phase at which the wings rest.
pub fn vacuum() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.vacuum";
    // Phase of the gait at which the wings rest, rad.
    const START: f64 = 1.3;
    let common = [
        "rig.air.density_kg_m3=1e-30",
        "rig.rest_s=2.0",
        "rig.cell.resonance_hz=3000.0",
        "rig.cell.filter_hz=3400.0",
        "process.steps.tare=true",
        "process.steps.drift=true",
        "process.steps.robot_inertia=true",
        "process.phase=\"encoder\"",
    ];
    let start = format!("rig.robot.numbers={{\"gait.phase_rad\"={START:?}}}");
    let held = ["hold.each_s=1.5", "hold.tilts_deg=[[20.0, 10.0]]"];
    let mut rows = Vec::new();
    for (name, file, also) in [("hold", "bench", &held[..]), ("turn", "roll15_speed08", &[])] {
        let run = load(file, &[&common[..], also].concat())?;
        let still = load(file, &[&common[..], also, &[start.as_str()]].concat())?;
        let plan = match run.spec.turn {
            Some(_) => Some(run.plan()?.map_err(|refusal| Error::NoAnswer(refusal.to_string()))?),
            None => None,
        };
        let carrier = run.carrier(plan.as_ref());
        // An encoder of the gait's own phase, which does not begin at 0.
        let mut columns = still.simulate(&carrier, 1, |_| ())??.record.into_columns();
        let phase = columns.iter_mut().filter(|column| column.name == "phase");
        phase.flat_map(|column| &mut column.values).for_each(|phase| *phase += START);
        let record = Record::new(columns, 0)?;
        let done = run.process(record, &carrier, run.window(plan.as_ref(), &carrier))??;
        let source = "the rig's simulation without air, whose wings rest at another phase of the gait: nothing is left";
        for (part, unit, limit, channels) in [("force", "N", 4e-3, 0..3), ("moment", "N m", 4e-4, 3..6)] {
            let most =
                done.cycles[channels].iter().flat_map(|of| &of.mean).fold(0.0, |a: f64, x| a.max(x.abs()));
            let metric = format!("largest {part} of the phase average");
            rows.push(ComparisonRow::judged(
                &format!("{ID}.{name}.{part}"),
                source,
                &metric,
                most,
                limit,
                unit,
            ));
        }
    }
    Ok(rows)
}

/// A simulated run after processing: its phase averages beside those of its noise-free wrench.
///
/// # Errors
/// [`Error`] when the run cannot be planned, simulated or processed.
pub fn processed_run() -> Result<Processed, Error> {
    let run = load("roll15_speed08", &[])?;
    let plan = run.plan()?.map_err(|refusal| Error::NoAnswer(refusal.to_string()))?;
    let carrier = run.carrier(Some(&plan));
    let outcome = run.simulate(&carrier, 1, |_| ())??;
    Ok(run.process(outcome.record, &carrier, plan.measured)??)
}

/// The processed phase average of a simulated run against its noise-free wrench.
pub fn pipeline_recovers_truth() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.pipeline_recovers_truth";
    let against =
        processed_run()?.against_truth().ok_or_else(|| Error::NoAnswer("no truth in the record".into()))?;
    let source = "noise-free wrench of the simulator";
    let row = |((name, _), c): (&(&str, &str), &Comparison)| {
        ComparisonRow::judged(&format!("{ID}.{name}"), source, "RMSE over range", c.rmse / c.range, 0.02, "")
    };
    let mut rows: Vec<ComparisonRow> = CHANNELS.iter().zip(&against).map(row).collect();
    let worst = rows.iter().map(|row| row.value).fold(0.0, f64::max);
    rows.insert(0, ComparisonRow::judged(ID, source, "RMSE over range, worst channel", worst, 0.02, ""));
    Ok(rows)
}

//! Loads of a tethered wing over time, as records.

use super::Tether;
use super::cycle::{self, CycleMean, Periodicity};
use super::power::Powers;
use super::spar::{Bent, Spar, Steady};
use crate::simulate::{AXES, Column, Ending, Record, StripRecorder, detail_columns};
use wingbeat_aero::{FROM_BEHIND, LoadSource, Loads, StallCount};
use wingbeat_math::Error;
use wingbeat_math::{Vec3, Wrench};
use wingbeat_ocp::plant::Fault;

/// What a tethered run gives.
#[derive(Clone, Debug)]
pub struct TetherRun {
    /// How it ended.
    pub ending: Ending,
    /// Steps of a cycle.
    pub steps_per_cycle: usize,
    /// Loads by time: body axes (B, about its origin), wind axes, coefficients, sources, motion, power and torques.
    pub loads: Record,
    /// Strips by time, one row per strip and instant.
    pub strips: Record,
    /// Means over the last cycle of every column of `loads` but time, phase and the coordinates of a spar.
    pub means: Vec<CycleMean>,
    /// Propulsive efficiency: mean thrust times wind speed over mean power, both of the last cycle; negative where
    /// the wing drags. None without wind, and where the motion takes no power.
    pub efficiency: Option<f64>,
    /// How far the last cycle is from the one before; none of a single cycle.
    pub periodicity: Option<Periodicity>,
    /// Strips over the last cycle by their angles of attack.
    pub stalled: StallCount,
    /// Share of strips that the wind meets from behind, at an angle of attack above 135 degrees, over the last cycle.
    pub reversed_fraction: f64,
    /// Mean separated share of the flow over the strips of the last cycle.
    pub separated_fraction: f64,
    /// Mean share of the linear leading-edge suction that law `lev` takes away, likewise.
    pub suction_lost_fraction: f64,
    /// The shape from which a wing with spars began.
    pub steady: Option<Steady>,
}

impl TetherRun {
    /// Mean of a column of `loads`, in its unit, over the last cycle.
    pub fn mean(&self, name: &str) -> Option<f64> {
        self.means.iter().find(|row| row.name == name).map(|row| row.mean)
    }

    /// Mean over the last cycle of the positive part of the power that the motion gives to the air, W.
    pub fn mean_positive_power(&self) -> Option<f64> {
        let power = self.last_cycle("power")?;
        Some(power.iter().map(|power| power.max(0.0)).sum::<f64>() / power.len() as f64)
    }

    /// The last cycle of a column of `loads`, in its unit, its end left out; none where the run ended before a cycle.
    pub fn last_cycle(&self, name: &str) -> Option<&[f64]> {
        let rows = cycle::rows_of_cycle(self.loads.rows(), self.steps_per_cycle, 0)?;
        Some(&self.loads.values(name)?[rows])
    }
}

/// Wind axes in W: along the wind, to the left, up.
#[derive(Clone, Copy, Debug)]
struct WindAxes([Vec3; 3]);

impl WindAxes {
    /// Lift stands in the plane of the wind and z; without wind the air comes from ahead.
    fn new(wind: Vec3) -> Self {
        let along = if wind.norm() > 0.0 { wind.unit() } else { Vec3::new(-1.0, 0.0, 0.0) };
        let up =
            if along[0].hypot(along[1]) > 1e-9 { Vec3::new(0.0, 0.0, 1.0) } else { Vec3::new(1.0, 0.0, 0.0) };
        let lift = (up - along * up.dot(along)).unit();
        Self([along, along.cross(lift), lift])
    }

    fn parts(&self, v: Vec3) -> [f64; 3] {
        self.0.map(|axis| axis.dot(v))
    }
}

/// Rows as they come.
pub(super) struct TetherRecorder {
    loads: Record,
    strips: StripRecorder,
    axes: WindAxes,
    weights: Vec<f64>,
    powers: Powers,
}

impl TetherRecorder {
    pub fn new(tether: &Tether) -> Self {
        let rows = tether.clock.steps() + 1;
        Self {
            loads: Record::new(load_columns(tether), rows).unwrap_or_default(),
            strips: StripRecorder::new(std::iter::once(&tether.aero), "cycles", 0).moving(rows),
            axes: WindAxes::new(tether.wind),
            weights: tether.strip_weights(),
            powers: Powers::new(tether),
        }
    }

    /// The columns of the loads, each name once.
    pub fn columns(tether: &Tether) -> Result<Record, Error> {
        Record::new(load_columns(tether), 0)
    }

    /// Appends the loads at `step`, unless one is not finite.
    pub fn sample(
        &mut self,
        tether: &Tether,
        step: usize,
        loads: &Loads<f64>,
        bent: Option<&Bent>,
    ) -> Result<(), Fault> {
        let t = step as f64 * tether.clock.step();
        let phase = tether.clock.phase(step);
        let body = tether.motion.body(t);
        let frame = body.frame();
        let back = frame.turn.each(|j| j.x).transpose();
        let origin = frame.origin.each(|j| j.x);
        let about_origin =
            |w: &Wrench<f64>| Wrench { force: w.force, moment: w.moment - origin.cross(w.force) };
        let in_body = |w: &Wrench<f64>| Wrench { force: back * w.force, moment: back * w.moment };
        let parts = self.sum_by_source(loads).map(|s| about_origin(&s));
        let total = parts.iter().fold(Wrench::ZERO, |a, b| a + *b);
        let [force, moment] = [total.force, total.moment].map(|v| self.axes.parts(v));
        let mut row = vec![t, phase];
        push(&mut row, &in_body(&total));
        row.extend(force.iter().chain(&moment));
        row.extend(coefficients(tether, force, back * total.moment));
        parts.iter().for_each(|part| push(&mut row, &in_body(part)));
        let detail = loads.detail_sum(&self.weights);
        row.extend(detail.parts().iter().flat_map(|force| (back * *force).0));
        row.extend([body.surge, body.heave, body.nose_up, body.roll].map(|j| j.x));
        row.extend(tether.motion.angles(t).iter().map(|j| j.x));
        if let (Some(spar), Some(bent)) = (&tether.spar, bent) {
            row.extend(spar.seen(tether, t, bent));
            row.extend(&bent.q[0]);
        }
        self.powers.update(tether, t, (loads, bent), &self.weights);
        row.extend([-force[0], self.powers.total, self.powers.body]);
        row.extend(self.powers.hinges.iter().flatten());
        self.loads.append_finite(&row)?;
        self.strips.append([t, phase], loads, &self.powers.strips, back, origin);
        Ok(())
    }

    /// Loads in W about W's origin, summed over the strips that count.
    fn sum_by_source(&self, loads: &Loads<f64>) -> [Wrench<f64>; LoadSource::STRIP.len()] {
        let mut sum = [Wrench::ZERO; LoadSource::STRIP.len()];
        for (strip, weight) in loads.strip[..loads.strips].iter().zip(&self.weights) {
            for (sum, part) in sum.iter_mut().zip(strip.parts()) {
                *sum += Wrench { force: part.force * *weight, moment: part.moment * *weight };
            }
        }
        sum
    }

    pub fn finish(self, tether: &Tether, ending: Ending) -> TetherRun {
        let rows = self.loads.rows();
        let steps = tether.clock.steps_per_cycle;
        let cycle = cycle::rows_of_cycle(rows, steps, 0).unwrap_or(0..rows.saturating_sub(1));
        let means = cycle::means(&self.loads, steps);
        let (strips, record) = (tether.aero.strips(), self.strips.finish());
        let last =
            |name: &str| &record.values(name).unwrap_or_default()[cycle.start * strips..cycle.end * strips];
        let mean_of = |name: &str, count: fn(f64) -> f64| {
            let covered = (0..strips).map(|i| tether.aero.covers(i)).cycle();
            let last = last(name).iter().zip(covered).filter(|(_, covered)| *covered);
            let (sum, seen) =
                last.fold((0.0, 0.0), |(sum, seen), (value, _)| (sum + count(*value), seen + 1.0));
            sum / f64::max(seen, 1.0)
        };
        let mut stalled = StallCount::default();
        stalled.see(&tether.aero, last("incidence").iter().copied());
        TetherRun {
            ending,
            steady: None,
            steps_per_cycle: steps,
            periodicity: Periodicity::of(&means, tether.wind.norm(), tether.reference.chord_m),
            efficiency: efficiency(&means, tether.wind.norm()),
            stalled,
            reversed_fraction: mean_of("incidence", |a| if a.abs() > FROM_BEHIND { 1.0 } else { 0.0 }),
            separated_fraction: mean_of("separated", |share| share),
            suction_lost_fraction: mean_of("suction_lost", |share| share),
            loads: self.loads,
            strips: record,
            means,
        }
    }
}

/// Mean thrust times wind speed over mean power.
///
/// Equation: tether.efficiency
/// `mean thrust x wind speed / mean power`
/// Source: Garrick 1936, NACA Rep. 567.
/// Test: `the_efficiency_of_a_plunging_wing_is_that_of_its_means`.
fn efficiency(means: &[CycleMean], wind: f64) -> Option<f64> {
    let mean = |name: &str| means.iter().find(|row| row.name == name).map(|row| row.mean);
    let (thrust, power) = (mean("thrust")?, mean("power")?);
    // Of a wing at rest rounding alone is left of the power.
    (power > cycle::ROUNDING * (thrust * wind).abs() && wind > 0.0).then(|| thrust * wind / power)
}

fn push(row: &mut Vec<f64>, w: &Wrench<f64>) {
    row.extend(w.force.0.iter().chain(&w.moment.0));
}

/// Lift, drag, side-force and nose-up moment coefficients.
fn coefficients(tether: &Tether, [drag, side, lift]: [f64; 3], moment: Vec3) -> [f64; 4] {
    let r = &tether.reference;
    let scale = 0.5 * r.density_kg_m3 * r.speed_m_s * r.speed_m_s * r.area_m2;
    [lift / scale, drag / scale, side / scale, -moment[1] / (scale * r.chord_m)]
}

fn load_columns(tether: &Tether) -> Vec<Column> {
    let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "cycles", "")];
    let mut wrench = |name: &str, frame: &str, axes: [&str; 3]| {
        columns.extend(axes.map(|a| Column::new(format!("force{name}_{a}"), "N", frame)));
        columns.extend(axes.map(|a| Column::new(format!("moment{name}_{a}"), "N m", frame)));
    };
    wrench("", "B", AXES);
    wrench("_wind", "wind", ["drag", "side", "lift"]);
    columns.extend(["CL", "CD", "CY", "CM"].map(|n| Column::new(n, "", "")));
    for source in LoadSource::STRIP.map(LoadSource::name) {
        columns.extend(AXES.map(|a| Column::new(format!("force_{source}_{a}"), "N", "B")));
        columns.extend(AXES.map(|a| Column::new(format!("moment_{source}_{a}"), "N m", "B")));
    }
    columns.extend(detail_columns());
    for (name, unit) in [("surge", "m"), ("heave", "m"), ("nose_up", "rad"), ("roll", "rad")] {
        columns.push(Column::new(name, unit, "W"));
    }
    columns
        .extend(tether.motion.hinges.iter().map(|(name, _)| Column::new(format!("hinge_{name}"), "rad", "")));
    columns.extend(tether.spar.iter().flat_map(Spar::columns));
    columns.push(Column::new("thrust", "N", "wind"));
    columns.extend(Powers::new(tether).columns(&tether.motion));
    columns
}

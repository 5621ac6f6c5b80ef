//! Runs on the rig as a model of cycles.

use crate::measured::MeasuredPass;
use crate::tilts::{INSTANTS, Tilts};
use crate::{CaseTarget, CycleModel, Error, HarmonicLayout, PHASES, phase_of, project};
use std::f64::consts::TAU;
use wingbeat::math::{Jet, Vec3};
use wingbeat::plant::Fault;
use wingbeat::rig::carrier::{CellMount, ToolCarrier, carried_frames};
use wingbeat::rig::cell::{CellSpec, six, wrench};
use wingbeat::rig::{Instants, JointTrajectory, Wrenches};
use wingbeat::scenario::RigRun;

/// Share of the rest at its begin that the tare leaves out, as the processing of runs does.
pub const SETTLING: f64 = 0.125;
/// Most cycles that are simulated: of a longer window the first so many stand for all.
const MOST_CYCLES: usize = 24;

/// A run on the rig with what carries it.
pub struct RigTarget {
    /// The run.
    pub run: RigRun,
    /// What the report calls it.
    pub name: String,
    carrier: ToolCarrier,
    window: (f64, f64),
    instants: Instants,
    harmonics: usize,
    cycles: usize,
    steps_per_cycle: usize,
    drawn: CellMount,
    tilts: Option<Tilts>,
}

impl RigTarget {
    /// Plans the motion of `run` and lays the instants of its simulation.
    ///
    /// # Errors
    /// A run that cannot be planned, does not flap, or has no whole cycle.
    pub fn new(run: RigRun, name: &str, harmonics: usize, steps_per_cycle: usize) -> Result<Self, Error> {
        let plan = match run.spec.turn {
            None => None,
            Some(_) => {
                let planned = run.plan()?;
                Some(planned.map_err(|refusal| Error::data(name, format!("cannot be planned: {refusal}")))?)
            }
        };
        let carrier = run.carrier(plan.as_ref());
        let window = run.spec.process.window_s.map(|[begin, end]| (begin, end));
        let window = window.unwrap_or_else(|| run.window(plan.as_ref(), &carrier));
        if run.is_weighing() {
            return Self::weighing(run, name, carrier);
        }
        let frequency = run.frequency();
        if !(frequency > 0.0) {
            let allowed = "above 0, or [hold] with tilts_deg of three attitudes or more";
            let error = wingbeat::Error::invalid("frequency_hz", frequency, allowed);
            return Err(Error::Config(run.explain(&error)));
        }
        let cycles = ((window.1 - window.0) * frequency + 1e-6).floor() as usize;
        if cycles == 0 {
            let given = (window.1 - window.0) * frequency;
            return Err(Error::data(
                name,
                format!("{given:.2} cycles in its window: at least one is needed"),
            ));
        }
        let cycles = cycles.min(MOST_CYCLES);
        let step = 1.0 / (frequency * steps_per_cycle as f64);
        // In a wind the tare holds what the air does to the wings at rest: it is simulated from where the record begins.
        let rest = if in_wind(&run) { run.spec.rig.rest_s } else { 2.0 * step };
        let before = ((window.0 + rest) / step).ceil();
        let instants = Instants {
            begin: window.0 - before * step,
            step,
            steps: before as usize + cycles * steps_per_cycle + 1,
        };
        let drawn = run.mount_as_drawn();
        Ok(Self {
            name: name.into(),
            carrier,
            window,
            instants,
            harmonics,
            cycles,
            steps_per_cycle,
            drawn,
            tilts: None,
            run,
        })
    }

    /// Static tilts.
    fn weighing(run: RigRun, name: &str, carrier: ToolCarrier) -> Result<Self, Error> {
        let held = run.spec.hold.as_ref().map(|hold| (hold.tilts_deg.len(), hold.each_s));
        let (count, each_s) = held.unwrap_or((0, 0.0));
        if count < 3 {
            let error = wingbeat::Error::invalid(
                "hold.tilts_deg",
                format!("{count} attitudes"),
                "three or more, where the wings are still",
            );
            return Err(Error::Config(run.explain(&error)));
        }
        let tilts = Tilts { count, each_s };
        let step = each_s / INSTANTS as f64;
        let before = (run.spec.rig.rest_s / step).ceil();
        let instants = Instants { begin: -before * step, step, steps: before as usize + count * INSTANTS };
        let (drawn, harmonics) = (run.mount_as_drawn(), tilts.layout().harmonics);
        Ok(Self {
            name: name.into(),
            carrier,
            window: (0.0, count as f64 * each_s),
            instants,
            harmonics,
            cycles: 1,
            steps_per_cycle: count * INSTANTS,
            drawn,
            tilts: Some(tilts),
            run,
        })
    }

    /// The attitudes of a run whose wings are still.
    pub fn tilts(&self) -> Option<Tilts> {
        self.tilts
    }

    /// Follows the joints that `passes` recorded, by the rule of `rig process`; of several passes their mean. True where it does: where a pass
    /// has none, the motion stays as planned.
    pub fn follow(&mut self, passes: &[MeasuredPass]) -> bool {
        let joints = |pass: &MeasuredPass| self.run.recorded_joints(pass.motion.as_ref()?, self.window);
        let Some(mut all) = passes.iter().map(joints).collect::<Option<Vec<JointTrajectory>>>() else {
            return false;
        };
        let Some(first) = all.pop() else { return false };
        let trajectory = mean(first, &all);
        self.carrier = ToolCarrier::Arm { arm: Box::new(self.run.arm.clone()), trajectory };
        true
    }

    /// Moves as `other`, the same run, does.
    pub fn moves_as(&mut self, other: &Self) {
        self.carrier = other.carrier.clone();
    }

    /// What carries the robot.
    pub fn carrier(&self) -> &ToolCarrier {
        &self.carrier
    }
    /// Velocity of the body's point `place`, the mount as drawn, against the mean wind at `t`, m/s in B.
    pub fn velocity(&self, place: Vec3, t: f64) -> Vec3 {
        let (_, body) = carried_frames(&self.carrier.tool(t), &self.drawn);
        body.pose.rotation.transpose_mul(body.point_velocity(place) - self.run.robot.mean_wind())
    }
    /// Begin and end of what is averaged, s.
    pub fn window(&self) -> (f64, f64) {
        self.window
    }
    /// Cycles in its window, as far as they are simulated.
    pub fn cycles(&self) -> usize {
        self.cycles
    }
    /// How its numbers lie.
    pub fn layout(&self) -> HarmonicLayout {
        HarmonicLayout { channels: 6, harmonics: self.harmonics }
    }
    /// Whether the rest before the run is taken away.
    pub fn tared(&self) -> bool {
        self.run.spec.process.steps.tare
    }

    /// A wrench on the cell in C, N and N m, as that of the body about its origin in B, the mount as drawn.
    pub fn in_body(&self, of: [f64; 6]) -> [f64; 6] {
        six(&self.drawn.to_body(&wrench(of)))
    }

    /// Numbers of a cycle in B, N and N m, as those of the wrench on the cell in C.
    pub fn in_cell(&self, cycle: &[f64]) -> Vec<f64> {
        in_cell(&self.drawn, self.layout(), cycle)
    }

    /// Largest load of a cycle in B, without what the tare takes away, in parts of the cell's range.
    pub fn load_share(&self, cycle: &[f64]) -> f64 {
        let (loads, range) = (self.in_cell(cycle), self.run.spec.rig.cell.calibration.range());
        let one = |channel: usize, k: usize| self.layout().value(&loads, channel, phase_of(k)).abs();
        let most = |channel: usize| (0..PHASES).map(|k| one(channel, k)).fold(0.0, f64::max) / range[channel];
        (0..6).map(most).fold(0.0, f64::max)
    }

    /// Mean square over the cycle, by channel in B and in the square of its unit, of what the cell's own noise and steps make
    /// of the harmonics of one cycle: of n independent samples of variance s the mean has s/n and each cosine and sine 2 s/n.
    pub fn cell_noise(&self) -> Vec<f64> {
        let (cell, layout) = (&self.run.spec.rig.cell, self.layout());
        let flapping = || cell.rate_hz / self.run.frequency();
        let samples = self.tilts.map_or_else(flapping, |tilts| tilts.samples(cell.rate_hz));
        let mut of = vec![0.0; layout.channels];
        for (i, step) in cell.calibration.resolution().iter().enumerate() {
            // A step's rounding is even over the step: 1/12 of its square.
            let variance = step * step * (cell.noise_steps.powi(2) + 1.0 / 12.0);
            let unit = std::array::from_fn(|k| f64::from(u8::from(k == i)));
            let turned = self.in_body(unit);
            let width = layout.width() as f64;
            of.iter_mut().zip(turned).for_each(|(of, by)| *of += by * by * variance * width / samples);
        }
        of
    }

    /// The mean cycle of wrenches on the cell, tared, in B, as the cell shows it.
    fn cycle(&self, rows: &Wrenches) -> Vec<f64> {
        let Instants { begin, step, .. } = self.instants;
        let time = |k: usize| begin + k as f64 * step;
        let from = -self.run.spec.rig.rest_s * (1.0 - SETTLING);
        let rest: Vec<usize> = (0..rows.len()).filter(|k| (from..-1e-9).contains(&time(*k))).collect();
        let mut offset = [0.0; 6];
        if self.tared() {
            for k in &rest {
                (0..6).for_each(|i| offset[i] += rows[*k][i] / rest.len() as f64);
            }
        }
        if let Some(tilts) = self.tilts {
            let body = |row: &[f64; 6]| self.in_body(std::array::from_fn(|i| row[i] - offset[i]));
            let bodies: Vec<[f64; 6]> = rows.iter().map(body).collect();
            return tilts.cycle(&time, &bodies).unwrap_or_else(|| vec![f64::NAN; self.layout().len()]);
        }
        let first = rows.len() - 2 - self.cycles * self.steps_per_cycle;
        // One row beside each end of the window closes its cycles.
        let from = first.saturating_sub(1);
        let phase: Vec<f64> = (from..rows.len()).map(|k| self.phase(time(k))).collect();
        let mut channels: [Vec<f64>; 6] = Default::default();
        for row in &rows[from..] {
            let body = self.in_body(std::array::from_fn(|i| row[i] - offset[i]));
            channels.iter_mut().zip(body).for_each(|(channel, x)| channel.push(x));
        }
        let begin = self.phase(time(first));
        let mut mean = vec![0.0; self.layout().len()];
        for cycle in 0..self.cycles {
            let one = project(&phase, &channels, begin + TAU * cycle as f64, self.harmonics);
            let one = one.unwrap_or_else(|| vec![f64::NAN; mean.len()]);
            mean.iter_mut().zip(one).for_each(|(m, x)| *m += x / self.cycles as f64);
        }
        respond(&self.run.spec.rig.cell, self.run.frequency(), self.layout(), &mut mean);
        mean
    }

    /// Phase that an even crank has at `t`, rad.
    fn phase(&self, t: f64) -> f64 {
        let spin_up = self.run.spec.rig.spin_up_s;
        TAU * self.run.frequency() * (t - 0.5 * spin_up)
    }

    fn named(&self, fault: Fault) -> Error {
        Error::Model { run: self.name.clone(), fault }
    }

    /// Numbers of the run's cycle, N and N m, with these numbers of robot and rig.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn predict(&self, to: &[(&str, f64)]) -> Result<Vec<f64>, Error> {
        let (robot, numbers) = self.run.adjusted(to)?;
        let experiment = self.run.experiment(&robot, numbers, &self.carrier, 0);
        let rows = experiment.wrenches(&self.instants).map_err(|fault| self.named(fault))?;
        Ok(self.cycle(&rows))
    }

    /// Derivatives of [`predict`](Self::predict) by the first `count` of the numbers, over the units of these.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn slopes(&self, to: &[(&str, f64)], count: usize) -> Result<Vec<Vec<f64>>, Error> {
        let (robot, numbers) = self.run.adjusted(to)?;
        let experiment = self.run.experiment(&robot, numbers, &self.carrier, 0);
        let keys: Vec<&str> = to[..count].iter().map(|(key, _)| *key).collect();
        let rows = experiment.differentiated(&self.instants, &keys)?.map_err(|fault| self.named(fault))?;
        Ok(rows.iter().map(|rows| self.cycle(rows)).collect())
    }
}

/// Numbers of a cycle of wrenches, N and N m, about the body's origin in B as those of the wrenches on the cell of `mount` in
/// C.
pub fn in_cell(mount: &CellMount, layout: HarmonicLayout, cycle: &[f64]) -> Vec<f64> {
    let mut turned = vec![0.0; cycle.len()];
    for part in 0..layout.width() {
        let own = std::array::from_fn(|channel| cycle[layout.at(channel, part)]);
        let cell = six(&mount.to_cell(&wrench(own)));
        (0..6).for_each(|channel| turned[layout.at(channel, part)] = cell[channel]);
    }
    turned
}

/// The mean of a motion and `others`, at the instants of the first.
fn mean(mut of: JointTrajectory, others: &[JointTrajectory]) -> JointTrajectory {
    let share = 1.0 / (1 + others.len()) as f64;
    for row in 0..of.len() {
        let t = row as f64 * of.step;
        let jets: Vec<_> = others.iter().map(|other| other.at(t)).collect();
        let add = |rows: &mut Vec<Vec<f64>>, part: fn(&Jet) -> f64| {
            for (j, value) in rows[row].iter_mut().enumerate() {
                *value = share * (*value + jets.iter().map(|jets| part(&jets[j])).sum::<f64>());
            }
        };
        add(&mut of.position, |jet| jet.x);
        add(&mut of.velocity, |jet| jet.d);
        add(&mut of.acceleration, |jet| jet.dd);
    }
    of
}

/// Whether the robot at rest stands in a wind.
pub fn in_wind(run: &RigRun) -> bool {
    run.robot.mean_wind() != Vec3::ZERO
}

/// What the cell makes of the harmonics of a load, in the units of the channels, at the frequency `frequency` in Hz: its
/// resonance and the box's filter, each a linear system.
///
/// Equation: calibrate.cell_response
/// `1/(1 - r^2 + 2 i z r), r = k f/f_0; (1 - p)/(1 - p e^(-iwT)); e^(iwT/2)`
/// Source: linear oscillator, recursive filter, held load.
/// Test: `the_cell_answers_harmonics_as_it_does_samples`.
pub fn respond(cell: &CellSpec, frequency: f64, layout: HarmonicLayout, cycle: &mut [f64]) {
    each_harmonic(layout, cycle, |k| response(cell, frequency, k));
}

/// The load before the cell, in the units of the channels, of which it shows these harmonics: [`respond`] undone.
pub fn beyond_cell(cell: &CellSpec, frequency: f64, layout: HarmonicLayout, cycle: &mut [f64]) {
    each_harmonic(layout, cycle, |k| inverse(response(cell, frequency, k)));
}

/// What the cell makes of harmonic `k`: a complex number.
fn response(cell: &CellSpec, frequency: f64, k: usize) -> [f64; 2] {
    let step = 1.0 / cell.rate_hz;
    let w = TAU * frequency * k as f64;
    let ratio = k as f64 * frequency / cell.resonance_hz;
    // 1 / (1 - r^2 + 2 i z r), and the filter's keep/(1 - keep e^-iwT) of samples.
    let resonance = inverse([1.0 - ratio * ratio, 2.0 * cell.resonance_damping * ratio]);
    let keep = (-TAU * cell.filter_hz * step).exp();
    let (sin, cos) = (w * step).sin_cos();
    let filter = inverse([(1.0 - keep * cos) / (1.0 - keep), keep * sin / (1.0 - keep)]);
    // The load is held over a step, which delays it by half of one; its sample is taken at the end of the step.
    let hold = [(0.5 * w * step).cos(), (0.5 * w * step).sin()];
    times(times(resonance, filter), hold)
}

/// Multiplies the harmonics of all channels.
fn each_harmonic(layout: HarmonicLayout, cycle: &mut [f64], factor: impl Fn(usize) -> [f64; 2]) {
    for k in 1..=layout.harmonics {
        let factor = factor(k);
        for channel in 0..layout.channels {
            let (i, j) = (layout.at(channel, 2 * k - 1), layout.at(channel, 2 * k));
            // c cos + s sin is the real part of (c - i s) e^{i phase}.
            let [re, im] = times([cycle[i], -cycle[j]], factor);
            (cycle[i], cycle[j]) = (re, -im);
        }
    }
}

fn times(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn inverse(a: [f64; 2]) -> [f64; 2] {
    let square = a[0] * a[0] + a[1] * a[1];
    [a[0] / square, -a[1] / square]
}

/// Runs on the rig, and cases of a tethered wing behind them, as a model of a fit: the values are those of the numbers called `names`,
/// then what is `held`.
pub struct RigModel {
    /// The runs.
    pub targets: Vec<RigTarget>,
    /// The cases.
    pub cases: Vec<CaseTarget>,
    /// Names of what is fitted.
    pub names: Vec<String>,
    /// Names and values of what is held, in their declared units.
    pub held: Vec<(String, f64)>,
}

impl RigModel {
    /// Names and values of all numbers, in their declared units, those that are fitted first.
    pub fn numbers<'a>(&'a self, values: &[f64]) -> Vec<(&'a str, f64)> {
        let fitted = self.names.iter().map(String::as_str).zip(values.iter().copied());
        let held = self.held.iter().map(|(name, value)| (name.as_str(), *value));
        fitted.chain(held).collect()
    }
}

impl CycleModel for RigModel {
    fn predict(&self, run: usize, values: &[f64]) -> Result<Vec<f64>, Error> {
        match self.targets.get(run) {
            Some(target) => target.predict(&self.numbers(values)),
            None => self.cases[run - self.targets.len()].predict(&self.numbers(values)),
        }
    }

    fn check(&self, values: &[f64]) -> Result<(), Error> {
        let numbers = self.numbers(values);
        self.targets.iter().try_for_each(|target| Ok(target.run.check(&numbers)?))
    }

    fn slopes(&self, run: usize, values: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        match self.targets.get(run) {
            Some(target) => target.slopes(&self.numbers(values), self.names.len()),
            None => self.cases[run - self.targets.len()].slopes(&self.numbers(values), self.names.len()),
        }
    }

    fn target(&self, run: usize) -> Option<&RigTarget> {
        self.targets.get(run)
    }

    /// What the air does: weight and inertia are known as well as their masses.
    fn in_doubt(&self, run: usize, values: &[f64]) -> Result<Option<Vec<f64>>, Error> {
        let Some(target) = self.targets.get(run) else { return self.predict(run, values).map(Some) };
        let all = self.numbers(values);
        let mut still: Vec<(&str, f64)> = all.iter().copied().filter(|(name, _)| *name != DENSITY).collect();
        still.push((DENSITY, NO_AIR));
        let (with, without) = (target.predict(&all)?, target.predict(&still)?);
        Ok(Some(with.iter().zip(&without).map(|(with, without)| with - without).collect()))
    }
}

/// The number of the air.
const DENSITY: &str = "air.density_kg_m3";
/// Density that counts as none, kg/m3.
const NO_AIR: f64 = 1e-6;

/// A wrench of forces (N) and moments (N m).
pub fn of_six(x: [f64; 6]) -> wingbeat::math::Wrench<f64> {
    wrench(x)
}

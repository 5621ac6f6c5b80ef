//! Measured loads and motions, right and wrong, as data: a cycle that repeats, and what is done to it.

use std::f64::consts::TAU;
use std::fs;
use std::process::Command;
use std::sync::OnceLock;

use serde::Deserialize;

use crate::tools;

/// Steps of the cycle from which loads are made, as the lists ask the program for them.
const STEPS: usize = 48;

/// A table of columns over time.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredSeries {
    /// Which cycle repeats.
    series: CycleSource,
    #[serde(default = "ten")]
    cycles: f64,
    /// Samples of a cycle.
    #[serde(default = "steps")]
    rate: usize,
    /// Cycles per second of its time.
    #[serde(default = "hz")]
    hz: f64,
    /// Time of the first sample, s.
    #[serde(default)]
    start_s: f64,
    /// Even noise of every column, in parts of its range.
    #[serde(default = "hundredth")]
    noise: f64,
    /// What is done to it, one after another.
    #[serde(default)]
    change: Vec<ColumnChange>,
}

fn ten() -> f64 {
    10.0
}
fn steps() -> usize {
    STEPS
}
fn hz() -> f64 {
    3.5
}
fn hundredth() -> f64 {
    0.01
}

/// The cycle.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum CycleSource {
    /// Forces and moment of `flap_f2` as the program computes them: columns `Fx`, `Fz`, `My`.
    Loads,
    /// A stroke of 35 deg with a second harmonic: column `a`.
    Stroke,
    /// The pull of a line that is slack for half of the cycle, and the angle of a crank: columns `pull_N` and `crank_deg`.
    Slack,
}

/// What is done to one column, or to all. Sizes are in parts of its range, places in parts of the file.
#[derive(Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ColumnChange {
    /// The column; all where none is named.
    to: Option<String>,
    /// Frequency over that of the file.
    ratio: Option<f64>,
    /// By how much the cycle is behind, deg.
    late_deg: f64,
    scale: Option<f64>,
    offset: f64,
    drift: f64,
    bow: f64,
    noise: f64,
    /// Sum of the noise so far.
    walk: f64,
    /// Another line at an odd frequency, with this size.
    hum: f64,
    /// Every so many samples one is off by twice the range.
    spikes: Option<usize>,
    /// Every so many samples one is zero.
    zeros: Option<usize>,
    /// It swings by this part, eleven times in three files.
    swing: f64,
    /// Within these places it stays as it was.
    stuck: Option<[f64; 2]>,
    /// It goes no higher than this part of the range.
    clip: Option<f64>,
    /// Least step.
    count: Option<f64>,
    /// It has the values of this column.
    is: Option<String>,
    /// It also has this part of the column `of`, in its own unit.
    part: f64,
    of: Option<String>,
    /// Its values grow by this part where they are as large as the range.
    bend: f64,
    /// From this place on it is zero.
    ends: Option<f64>,
    /// Rows within these places are missing.
    lost: Option<[f64; 2]>,
    /// It reads zero below this part of its range.
    dead_band: f64,
    /// This bit of seven of its converter stays zero.
    dead_bit: Option<u32>,
    /// It grows by this part with the cube of the place.
    grows: f64,
    /// Its first part of this size comes again and again.
    again: Option<f64>,
    /// From the first place on, a part of this size comes again after itself.
    copy: Option<[f64; 2]>,
    /// It is this part of itself for the first third of the file.
    third: Option<f64>,
    /// Runs of five samples are zero, each so many samples.
    drops: Option<usize>,
    /// Half of its samples, at random, lie higher by this part.
    sources: f64,
    /// Its frequency grows by this part from start to end.
    drifts: f64,
    /// It is so many times as steep, and stays at the ends of its range.
    steep: Option<f64>,
    /// Of its strokes the first so many come, and the next so many not, again and again.
    bouts: Option<[usize; 2]>,
    /// So many samples of each cycle lie higher by the range, from where it is least.
    knock: usize,
    /// Every second so many samples are 0.6 of themselves.
    turns: usize,
    /// This part of its samples, at random, has one value within its range.
    code: f64,
    /// Rows stand in pairs that are swapped.
    pairs: bool,
    /// Only its magnitude is kept.
    magnitude: bool,
    /// Instants are off by so many steps.
    jitter: f64,
}

/// Even numbers from -1 to 1.
struct EvenNoise(u64);

impl EvenNoise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A column and its cycle at even phases.
type ColumnCycle = (&'static str, Vec<f64>);

/// One cycle of loads of `flap_f2`, from the program, once.
fn loads() -> Result<&'static [ColumnCycle], String> {
    static LOADS: OnceLock<Result<Vec<ColumnCycle>, String>> = OnceLock::new();
    let found = LOADS.get_or_init(|| {
        let folder = tools::root().join("target/hostile-loads");
        let steps = format!("time.steps_per_cycle={STEPS}");
        let output = Command::new(tools::program())
            .args(["tether", "cases/flap_f2.toml", "--set", &steps, "--quiet", "--force", "--out"])
            .arg(&folder)
            .current_dir(tools::root())
            .output();
        output.map_err(|error| error.to_string())?;
        let text = fs::read_to_string(folder.join("loads.csv")).map_err(|error| error.to_string())?;
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let names = lines.next().unwrap_or_default();
        let rows: Vec<Vec<&str>> = lines.collect();
        let last = rows.len().saturating_sub(STEPS + 1)..rows.len().saturating_sub(1);
        let column = |(name, of): (&'static str, &str)| {
            let at = names.iter().position(|own| *own == of).ok_or_else(|| format!("no column {of}"))?;
            let number = |row: &Vec<&str>| row[at].parse::<f64>().map_err(|error| error.to_string());
            Ok((name, rows[last.clone()].iter().map(number).collect::<Result<_, _>>()?))
        };
        [("Fx", "force_x"), ("Fz", "force_z"), ("My", "moment_y")].into_iter().map(column).collect()
    });
    found.as_deref().map_err(Clone::clone)
}

fn stroke() -> Vec<ColumnCycle> {
    let at = |k: usize| {
        let p = TAU * k as f64 / STEPS as f64;
        35.0 * p.sin() + 4.0 * (2.0 * p + 0.3).sin()
    };
    vec![("a", (0..STEPS).map(at).collect())]
}

/// A cycle that is zero for its second half, and the turn within one.
fn slack() -> Vec<ColumnCycle> {
    let pull = |k: usize| 5.0 * (TAU * k as f64 / STEPS as f64).sin().max(0.0);
    vec![("pull_N", (0..STEPS).map(pull).collect()), (CRANK, vec![0.0; STEPS])]
}

/// The column that grows by a turn a cycle.
const CRANK: &str = "crank_deg";

/// A cycle at any phase, by straight lines.
fn at(cycle: &[f64], phase: f64) -> f64 {
    let place = phase.rem_euclid(1.0) * cycle.len() as f64;
    let (k, share) = (place.floor() as usize % cycle.len(), place.fract());
    cycle[k] + share * (cycle[(k + 1) % cycle.len()] - cycle[k])
}

fn range(of: &[f64]) -> f64 {
    of.iter().fold(f64::MIN, |m, x| m.max(*x)) - of.iter().fold(f64::MAX, |m, x| m.min(*x))
}

impl MeasuredSeries {
    /// The table as CSV.
    pub fn bytes(&self) -> Result<Vec<u8>, String> {
        let cycles = match self.series {
            CycleSource::Loads => loads()?.to_vec(),
            CycleSource::Stroke => stroke(),
            CycleSource::Slack => slack(),
        };
        let rows = (self.cycles * self.rate as f64) as usize + 1;
        let place = |k: usize| k as f64 / (rows - 1).max(1) as f64;
        let mut noise = EvenNoise(7);
        let mut columns: Vec<(&str, Vec<f64>)> = Vec::new();
        for (name, cycle) in &cycles {
            let own = self.change.iter().filter(|change| change.takes(name));
            let ratio = own.clone().filter_map(|change| change.ratio).product::<f64>();
            let late: f64 = own.map(|change| change.late_deg / 360.0).sum();
            let size = range(cycle);
            let turned = if *name == CRANK { 360.0 / self.rate as f64 } else { 0.0 };
            let drifts: f64 = self.change.iter().filter(|of| of.takes(name)).map(|of| of.drifts).sum();
            let own = || self.change.iter().filter(|of| of.takes(name));
            let bouts = own().find_map(|of| of.bouts);
            let rests =
                |k: usize| bouts.is_some_and(|[on, off]| (k / self.rate.max(1)) % (on + off).max(1) >= on);
            let knock: usize = own().map(|of| of.knock).sum();
            let least = (0..cycle.len()).min_by(|a, b| cycle[*a].total_cmp(&cycle[*b])).unwrap_or(0);
            let knocks = |k: usize| (k + self.rate - least * self.rate / STEPS) % self.rate.max(1) < knock;
            let one = |k: usize| {
                // Of a frequency that grows evenly: that of the file in the middle, and no phase in the mean.
                let bow = place(k) * (place(k) - 1.0) + 1.0 / 6.0;
                let drift = 0.5 * drifts * bow * ratio * self.cycles;
                let here = at(cycle, ratio * k as f64 / self.rate as f64 + drift - late);
                let here = if rests(k) { 0.0 } else { here } + if knocks(k) { size } else { 0.0 };
                here + turned * k as f64 + self.noise * size * noise.next()
            };
            columns.push((name, (0..rows).map(one).collect()));
        }
        let before = columns.clone();
        let (mut kept, mut jitter) = (vec![true; rows], 0.0);
        for change in &self.change {
            jitter = f64::max(jitter, change.jitter);
            if let Some([from, to]) = change.lost {
                kept.iter_mut().enumerate().for_each(|(k, kept)| *kept &= !(from..to).contains(&place(k)));
            }
            for (name, values) in columns.iter_mut().filter(|(name, _)| change.takes(name)) {
                if let Some((_, other)) = before.iter().find(|(other, _)| change.is.as_deref() == Some(other))
                {
                    values.clone_from(other);
                }
                let other = before.iter().find(|(other, _)| change.of.as_deref() == Some(other));
                for (x, other) in values.iter_mut().zip(other.map(|(_, other)| other).into_iter().flatten()) {
                    *x += change.part * other;
                }
                let size = cycles.iter().find(|(own, _)| own == name).map_or(1.0, |(_, cycle)| range(cycle));
                change.apply(values, size, &mut noise);
            }
        }
        let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        let mut text = format!("t,{}\n", names.join(","));
        for k in (0..rows).filter(|k| kept[*k]) {
            let t = self.start_s + (k as f64 + jitter * noise.next()) / (self.rate as f64 * self.hz);
            let cells: Vec<String> = columns.iter().map(|(_, values)| format!("{:e}", values[k])).collect();
            text += &format!("{t},{}\n", cells.join(","));
        }
        Ok(text.into_bytes())
    }
}

impl ColumnChange {
    fn takes(&self, name: &str) -> bool {
        self.to.as_deref().is_none_or(|to| to == name)
    }

    /// Does it to a column whose cycle has the range `size`.
    fn apply(&self, values: &mut [f64], size: f64, noise: &mut EvenNoise) {
        let last = (values.len() - 1).max(1) as f64;
        let (mut walked, mut held) = (0.0, 0.0);
        let ceiling = self.clip.map(|part| {
            let low = values.iter().fold(f64::MAX, |m, x| m.min(*x));
            low + part * range(values)
        });
        let middle = values.iter().sum::<f64>() / values.len().max(1) as f64;
        for (k, x) in values.iter_mut().enumerate() {
            let place = k as f64 / last;
            walked += noise.next();
            if let Some(steep) = self.steep {
                *x = middle + (steep * (*x - middle)).clamp(-0.5 * size, 0.5 * size);
            }
            *x = self.scale.unwrap_or(1.0) * *x
                + size * (self.offset + self.drift * place + self.bow * (2.0 * place - 1.0).powi(2))
                + size * (self.noise * noise.next() + self.walk * walked)
                + size * self.hum * (TAU * 0.137 * k as f64).sin();
            if self.spikes.is_some_and(|every| k % every == every / 2) {
                *x += 2.0 * size;
            }
            if self.zeros.is_some_and(|every| k % every == every / 2) {
                *x = 0.0;
            }
            if self.drops.is_some_and(|every| (every / 2..every / 2 + 5).contains(&(k % every))) {
                *x = 0.0;
            }
            if self.turns > 0 && k / self.turns % 2 == 1 {
                *x *= 0.6;
            }
            if self.code > 0.0 && noise.next().abs() < self.code {
                *x = 0.1 * size;
            }
            if self.sources != 0.0 && noise.next() > 0.0 {
                *x += self.sources * size;
            }
            *x *= if place < 1.0 / 3.0 { self.third.unwrap_or(1.0) } else { 1.0 };
            *x *= 1.0 + self.grows * place.powi(3);
            *x = if x.abs() < self.dead_band * size { 0.0 } else { *x };
            *x *= 1.0 + self.bend * x.abs() / size;
            *x *= 1.0 + self.swing * (TAU * 3.67 * place).sin();
            *x = if self.magnitude { x.abs() } else { *x };
            *x = ceiling.map_or(*x, |ceiling| x.min(ceiling));
            if self.ends.is_some_and(|from| place >= from) {
                *x = 0.0;
            }
            match self.stuck {
                Some([from, to]) if place > from && place < to => *x = held,
                _ => held = *x,
            }
            if let Some(count) = self.count {
                *x = (*x / (count * size)).round() * count * size;
            }
        }
        if let Some(bit) = self.dead_bit {
            let (low, step) = (values.iter().fold(f64::MAX, |m, x| m.min(*x)), range(values) / 127.0);
            let code = |x: f64| ((x - low) / step).round() as u32 & !(1 << bit);
            values.iter_mut().for_each(|x| *x = low + step * f64::from(code(*x)));
        }
        if let Some(part) = self.again {
            let length = ((part * values.len() as f64) as usize).max(1);
            (length..values.len()).for_each(|k| values[k] = values[k - length]);
        }
        if let Some([from, part]) = self.copy {
            let [from, length] = [from, part].map(|of| (of * values.len() as f64) as usize);
            values.copy_within(from..from + length, from + length);
        }
        if self.pairs {
            values.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
        }
    }
}

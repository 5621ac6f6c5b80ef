//! What is seen while a recording runs.

use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use wingbeat::rig::netft::Scale;
use wingbeat_netft::Row;

use crate::progress;

/// Bins of the live phase average.
const BINS: usize = 16;
/// Time between two lines of the display.
const REFRESH: Duration = Duration::from_millis(250);

/// The six channels and the phase-averaged Fz on one line.
pub struct Display {
    scale: Scale,
    frequency: f64,
    fz: [(f64, f64); BINS],
    shown: Instant,
    /// The line, for other messages and to be cleared.
    pub bar: ProgressBar,
    rows: u64,
}

impl Display {
    /// A line on the terminal for a gait of `frequency`, Hz, unless `quiet`.
    pub fn new(scale: Scale, frequency: f64, quiet: bool) -> Self {
        let bar = progress::bar(None, "{elapsed} {wide_msg}", quiet);
        Self { scale, frequency, fz: [(0.0, 0.0); BINS], shown: Instant::now(), bar, rows: 0 }
    }

    /// Takes a row in; draws the line now and then.
    pub fn see(&mut self, row: &Row) {
        self.rows += 1;
        let w = self.scale.wrench(row.record.counts);
        let turn = f64::from(row.record.ft_sequence) / 7000.0 * self.frequency;
        let bin = ((turn.fract() * BINS as f64) as usize).min(BINS - 1);
        let (mean, weight) = &mut self.fz[bin];
        *weight = (*weight + 1.0).min(5000.0);
        *mean += (w[2] - *mean) / *weight;
        if self.shown.elapsed() < REFRESH {
            return;
        }
        self.shown = Instant::now();
        let (low, high) =
            self.fz.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), b| (l.min(b.0), h.max(b.0)));
        let bars = self.fz.iter().map(|b| level((b.0 - low) / (high - low).max(1e-9))).collect::<String>();
        let [fx, fy, fz, tx, ty, tz] = w;
        let (rows, mm) = (self.rows, 1e3);
        self.bar.set_message(format!(
            "{rows} F {fx:7.3} {fy:7.3} {fz:7.3} N  T {:7.2} {:7.2} {:7.2} N mm  Fz/cycle {bars}",
            tx * mm,
            ty * mm,
            tz * mm
        ));
        self.bar.tick();
    }
}

fn level(share: f64) -> char {
    const LEVELS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    LEVELS[((share * 7.99) as usize).min(7)]
}

//! The bar that shows how far long work has come.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle, TermLike};
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two lines where stderr is no terminal: a log of an hour has 120. *Choice.*
const PACE: Duration = Duration::from_secs(30);

/// A bar of `length` steps, or one without an end, on stderr; hidden when `quiet`. Where stderr is no terminal it is a line at most every
/// half minute, as it moves.
pub fn bar(length: Option<u64>, template: &str, quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(length, target(quiet)).with_style(style)
}

/// Where a bar is drawn, as in [`bar`].
pub fn target(quiet: bool) -> ProgressDrawTarget {
    match (quiet, io::stderr().is_terminal()) {
        (true, _) => ProgressDrawTarget::hidden(),
        (false, true) => ProgressDrawTarget::stderr(),
        (false, false) => ProgressDrawTarget::term_like_with_hz(Box::new(LogLines::new()), 1),
    }
}

/// Writes a line above a bar, at once; none above a hidden one. An stderr that is closed takes none.
pub fn line(bar: &ProgressBar, text: &str) {
    if !bar.is_hidden() {
        let _ = bar.suspend(|| writeln!(io::stderr(), "{text}"));
    }
}

/// What takes the lines of bars to a log: the first that is drawn after each [`PACE`].
#[derive(Debug)]
struct LogLines {
    /// When the last line was written.
    last: Mutex<Instant>,
}

impl LogLines {
    fn new() -> Self {
        Self { last: Mutex::new(Instant::now()) }
    }

    /// Whether the last line is older than `pace`; then there is one now.
    fn is_due(&self, pace: Duration) -> bool {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let due = last.elapsed() >= pace;
        if due {
            *last = Instant::now();
        }
        due
    }
}

impl TermLike for LogLines {
    fn width(&self) -> u16 {
        100
    }

    fn move_cursor_up(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn write_line(&self, line: &str) -> io::Result<()> {
        self.write_str(line)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        let line = text.trim_end();
        if line.is_empty() || !self.is_due(PACE) { Ok(()) } else { writeln!(io::stderr(), "{line}") }
    }

    fn clear_line(&self) -> io::Result<()> {
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_has_a_line_for_each_pace() {
        let lines = LogLines::new();
        assert!(!lines.is_due(PACE));
        let pace = Duration::from_millis(20);
        std::thread::sleep(pace);
        assert!(lines.is_due(pace));
        assert!(!lines.is_due(PACE));
    }
}

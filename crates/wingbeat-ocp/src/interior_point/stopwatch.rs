//! Processor time of the thread that solves: other programs on the machine do not shorten a limit on it.

use cpu_time::ThreadTime;
use std::time::{Duration, Instant};

/// Counts from its start on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stopwatch {
    /// Processor time of this thread.
    Processor(ThreadTime),
    /// Wall time, on systems that do not count the other.
    Wall(Instant),
}

impl Stopwatch {
    pub fn start() -> Self {
        ThreadTime::try_now().map_or_else(|_| Self::Wall(Instant::now()), Self::Processor)
    }

    pub fn elapsed(&self) -> Duration {
        match self {
            Self::Processor(start) => start.try_elapsed().unwrap_or_default(),
            Self::Wall(start) => start.elapsed(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_takes_no_processor_time() {
        let (watch, wall) = (Stopwatch::start(), Instant::now());
        std::thread::sleep(Duration::from_millis(60));
        assert!(watch.elapsed() < wall.elapsed() / 4, "{:?} of {:?}", watch.elapsed(), wall.elapsed());
        let mut sum = 0.0_f64;
        while watch.elapsed() < Duration::from_millis(5) {
            sum += wall.elapsed().as_secs_f64().sin();
        }
        assert!(sum.is_finite());
    }
}

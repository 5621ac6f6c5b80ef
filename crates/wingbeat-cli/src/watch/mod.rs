//! A computation on a page while it goes on: `--watch`.

mod convergence;
mod flight;
mod server;

pub use convergence::{Convergence, Point};
pub use flight::FlightWatch;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use wingbeat_report::page;
use wingbeat_report::run::Run;

use crate::error::Error;
use crate::say;
use server::{Asked, Server};

/// The page is drawn and packed again after so many times the time that it took: it never takes more than a fifth of a core. *Choice.*
const REST: u32 = 4;
/// What has come is taken up after this time, whether somebody asks or not. *Choice.*
const TAKEN_UP: Duration = Duration::from_millis(500);

/// What commands take that can be watched.
#[derive(Debug, Default, Args)]
pub struct Live {
    /// Show the run on a page of this machine while it is computed: its address, which holds a secret, is printed
    #[arg(long)]
    pub watch: bool,
}

/// What a computation shows; dropped, it is shown no more.
pub struct Watch<N> {
    shared: Arc<Shared<N>>,
    _server: Server,
}

struct Shared<N> {
    /// What has come and was not yet taken up; none once there is nobody to take it.
    news: Mutex<Option<Vec<N>>>,
    ended: AtomicBool,
}

impl<N> Shared<N> {
    fn news(&self) -> MutexGuard<'_, Option<Vec<N>>> {
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A question of a browser, and where the answer goes.
type Question = (Asked, Sender<Option<Arc<str>>>);

/// Draws the page of what has come, in a thread of its own.
pub struct Painter<N> {
    shared: Arc<Shared<N>>,
    questions: Receiver<Question>,
}

impl<N: Send + 'static> Watch<N> {
    /// Begins where it is wanted: `paint` runs in a thread of its own. Nothing that a browser does is waited for.
    ///
    /// # Errors
    /// A port or a thread that cannot be had.
    pub fn begin(
        live: &Live,
        paint: impl FnOnce(Painter<N>) + Send + 'static,
    ) -> Result<Option<Self>, Error> {
        if !live.watch {
            return Ok(None);
        }
        let refused = |why: std::io::Error| Error::Input(format!("--watch: {why}"));
        let shared = Arc::new(Shared { news: Mutex::new(Some(Vec::new())), ended: AtomicBool::new(false) });
        let (sender, questions) = channel();
        let server = Server::begin(sender).map_err(refused)?;
        let painter = Painter { shared: shared.clone(), questions };
        thread::Builder::new().name("watch page".into()).spawn(|| paint(painter)).map_err(refused)?;
        say::note(&format!("watch: {}", server.address()));
        Ok(Some(Self { shared, _server: server }))
    }

    /// Adds to what is shown.
    pub fn tell(&self, news: N) {
        if let Some(there) = &mut *self.shared.news() {
            there.push(news);
        }
    }

    /// Says that nothing more comes.
    pub fn end(&self) {
        self.shared.ended.store(true, Ordering::Release);
    }
}

/// The page as it was drawn last.
struct Drawn {
    version: u64,
    page: Arc<str>,
    data: Arc<str>,
    /// Whether it shows the whole computation.
    last: bool,
}

impl Drawn {
    fn of(runs: &[Run], version: u64, last: bool) -> Self {
        let packed = page::Live::of(runs);
        Self { version, page: packed.page().into(), data: packed.data(version, last).into(), last }
    }

    /// What was asked for, where there is any.
    fn answer(&self, asked: Asked) -> Option<Arc<str>> {
        match asked {
            Asked::Page => Some(self.page.clone()),
            Asked::DataAfter(known) => (known < self.version).then(|| self.data.clone()),
        }
    }
}

impl<N> Painter<N> {
    /// Answers until nobody can ask: `add` takes what has come into the `state`, and `draw` draws it.
    pub fn run<S>(self, mut state: S, mut add: impl FnMut(&mut S, Vec<N>), draw: impl Fn(&S) -> Vec<Run>) {
        let mut drawn = Drawn::of(&draw(&state), 1, false);
        let (mut fresh, mut due) = (false, Instant::now());
        loop {
            let question = match self.questions.recv_timeout(TAKEN_UP) {
                Ok(question) => Some(question),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            // Read before what has come: where it has ended, all has come.
            let ended = self.shared.ended.load(Ordering::Acquire);
            let came = self.shared.news().as_mut().map(std::mem::take).unwrap_or_default();
            if !came.is_empty() {
                fresh = true;
                add(&mut state, came);
            }
            let Some((asked, answer)) = question else { continue };
            let begun = Instant::now();
            if (fresh && begun >= due) || (ended && !drawn.last) {
                drawn = Drawn::of(&draw(&state), drawn.version + 1, ended);
                fresh = false;
                let now = Instant::now();
                due = now + (now - begun) * REST;
            }
            // A browser that went away gets none.
            let _ = answer.send(drawn.answer(asked));
        }
    }
}

impl<N> Drop for Painter<N> {
    fn drop(&mut self) {
        *self.shared.news() = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_report::run::Axis;

    fn begun(watch: &Arc<Shared<f64>>) -> Sender<Question> {
        let (sender, questions) = channel();
        let painter = Painter { shared: watch.clone(), questions };
        thread::spawn(move || {
            let add = |values: &mut Vec<f64>, came: Vec<f64>| values.extend(came);
            painter.run(Vec::new(), add, |values| {
                let axis = Axis { label: "iteration", unit: "", values: values.clone(), joined: true };
                vec![Run { summary: values.len().into(), ..Run::blank("a", "fit", axis) }]
            });
        });
        sender
    }

    #[test]
    fn what_comes_is_taken_up_unasked_packed_once_and_dropped_when_nobody_draws() {
        let shared = Arc::new(Shared { news: Mutex::new(Some(Vec::new())), ended: AtomicBool::new(false) });
        let questions = begun(&shared);
        let ask = |asked: Asked| {
            let (sender, receiver) = channel();
            questions.send((asked, sender)).unwrap();
            receiver.recv().unwrap()
        };
        let first = ask(Asked::DataAfter(0)).unwrap();
        assert!(Arc::ptr_eq(&first, &ask(Asked::DataAfter(0)).unwrap()));
        assert!(ask(Asked::DataAfter(1)).is_none() && ask(Asked::Page).unwrap().contains("data-live"));
        shared.news().as_mut().unwrap().push(1.0);
        thread::sleep(3 * TAKEN_UP);
        assert!(shared.news().as_ref().unwrap().is_empty());
        shared.ended.store(true, Ordering::Release);
        let last = ask(Asked::DataAfter(1)).unwrap();
        assert!(last.contains("\"ended\":true") && first.contains("\"ended\":false"), "{last}");
        drop(questions);
        thread::sleep(TAKEN_UP);
        assert!(shared.news().is_none());
    }
}

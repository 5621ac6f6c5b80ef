//! A computation on a page while it goes on: `--watch`.

mod convergence;
mod flight;
mod server;

pub use convergence::{ConvergenceWatch, SearchIteration};
pub use flight::FlightWatch;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use wingbeat_report::page::Live as LivePage;
use wingbeat_report::run::ShownRun;

use crate::error::Error;
use crate::say;
use server::{PageRequest, Server};

/// The page is drawn and packed again after so many times the time that it took: it never takes more than a fifth of a core. *Choice.*
const REST: u32 = 4;
/// What has come is taken up after this time, whether somebody asks or not. *Choice.*
const TAKEN_UP: Duration = Duration::from_millis(500);

/// A page that asks again within this time, or within twice the longest that it took so far, is told that the computation has ended before
/// the program goes; [`LONGEST`] at most. *Choice.*
const ASKS_AGAIN: Duration = Duration::from_secs(1);
const LONGEST: Duration = Duration::from_secs(10);
const LOOK: Duration = Duration::from_millis(20);

/// What commands take that can be watched.
#[derive(Debug, Default, Args)]
pub struct WatchArguments {
    /// Show the run on a page of this machine while it is computed: its address, which holds a secret, is printed
    #[arg(long)]
    pub watch: bool,
}

/// What a computation shows; dropped, it is shown no more.
pub struct Watch<N> {
    shared: Arc<WatchState<N>>,
    server: Server,
}

struct WatchState<N> {
    /// What has come and was not yet taken up; none once there is nobody to take it.
    news: Mutex<Option<Vec<N>>>,
    ended: AtomicBool,
    heard: Mutex<Heard>,
}

/// What browsers have asked and were told.
#[derive(Clone, Copy, Default)]
struct Heard {
    /// When one asked for news last, and the longest time between two such questions.
    last: Option<Instant>,
    longest: Duration,
    /// Whether one was told that nothing more comes.
    end: bool,
}

impl Heard {
    fn asked(&mut self, now: Instant) {
        let since = self.last.map_or(Duration::ZERO, |last| now.saturating_duration_since(last));
        (self.last, self.longest) = (Some(now), self.longest.max(since));
    }

    /// Until when the end waits for a question.
    fn until(&self) -> Option<Instant> {
        self.last.filter(|_| !self.end).map(|last| last + (2 * self.longest).clamp(ASKS_AGAIN, LONGEST))
    }
}

impl<N> WatchState<N> {
    fn new() -> Self {
        let (news, heard) = (Mutex::new(Some(Vec::new())), Mutex::default());
        Self { news, ended: AtomicBool::new(false), heard }
    }

    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn news(&self) -> MutexGuard<'_, Option<Vec<N>>> {
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A question of a browser, and where the answer goes.
type Question = (PageRequest, Sender<Option<Arc<str>>>);

/// Draws the page of what has come, in a thread of its own.
pub struct Painter<N> {
    shared: Arc<WatchState<N>>,
    questions: Receiver<Question>,
}

impl<N: Send + 'static> Watch<N> {
    /// Begins where it is wanted: `paint` runs in a thread of its own. Nothing that a browser does is waited for.
    ///
    /// # Errors
    /// A port or a thread that cannot be had.
    pub fn begin(
        live: &WatchArguments,
        paint: impl FnOnce(Painter<N>) + Send + 'static,
    ) -> Result<Option<Self>, Error> {
        if !live.watch {
            return Ok(None);
        }
        let refused = |why: std::io::Error| Error::Input(format!("--watch: {why}"));
        let shared = Arc::new(WatchState::new());
        let (sender, questions) = channel();
        let server = Server::begin(sender).map_err(refused)?;
        let painter = Painter { shared: shared.clone(), questions };
        thread::Builder::new().name("watch page".into()).spawn(|| paint(painter)).map_err(refused)?;
        say::note(&format!("watch: {}", server.address()));
        Ok(Some(Self { shared, server }))
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

impl<N> Drop for Watch<N> {
    /// A page that follows is told the end, and its answer is sent.
    fn drop(&mut self) {
        if !self.shared.ended.load(Ordering::Acquire) {
            return;
        }
        let waits = |until: Option<Instant>| until.is_some_and(|until| Instant::now() < until);
        while waits(self.shared.heard().until()) {
            thread::sleep(LOOK);
        }
        let sent = Instant::now() + ASKS_AGAIN;
        while self.server.answers() && Instant::now() < sent {
            thread::sleep(LOOK);
        }
    }
}

/// Most versions whose rows are kept: who knows an older one gets all. *Choice.*
const VERSIONS: usize = 64;

/// What was drawn last.
struct DrawnPage {
    runs: Vec<ShownRun>,
    version: u64,
    /// Whether it shows the whole computation.
    last: bool,
    /// The versions since which the runs have only grown by rows, each with the rows of its runs; the last is this one.
    since: VecDeque<(u64, Vec<usize>)>,
    /// What was answered in this version.
    answers: Vec<(PageRequest, Arc<str>)>,
}

impl DrawnPage {
    fn new(runs: Vec<ShownRun>) -> Self {
        let mut drawn = Self { runs, version: 0, last: false, since: VecDeque::new(), answers: Vec::new() };
        drawn.changed(false);
        drawn
    }

    /// Notes that the runs are new ones, or those before with more rows.
    fn changed(&mut self, grown: bool) {
        self.version += 1;
        self.answers.clear();
        if !grown {
            self.since.clear();
        } else if self.since.len() == VERSIONS {
            self.since.pop_front();
        }
        let rows = self.runs.iter().map(|run| run.axis.values.len()).collect();
        self.since.push_back((self.version, rows));
    }

    /// What was asked for, where there is any.
    fn answer(&mut self, asked: PageRequest) -> Option<Arc<str>> {
        if let Some((_, answer)) = self.answers.iter().find(|(known, _)| *known == asked) {
            return Some(answer.clone());
        }
        let live = LivePage { runs: &self.runs, version: self.version, ended: self.last };
        let text = match asked {
            PageRequest::Page => live.page(),
            // Who has all is told only that it was all.
            PageRequest::DataAfter(known) if known >= self.version && !self.last => return None,
            PageRequest::DataAfter(known) => {
                let since = self.since.iter().find(|(version, _)| *version == known);
                live.data(since.map(|(version, rows)| (*version, rows.as_slice())))
            }
        };
        let text: Arc<str> = text.into();
        self.answers.push((asked, text.clone()));
        Some(text)
    }
}

impl<N> Painter<N> {
    /// Answers until nobody can ask: `add` takes what has come into the `state`, and `draw` draws it over what was drawn before; true
    /// where its runs have only grown by rows.
    pub fn run<S>(
        self,
        mut state: S,
        mut add: impl FnMut(&mut S, Vec<N>),
        mut draw: impl FnMut(&mut S, &mut Vec<ShownRun>) -> bool,
    ) {
        let mut first = Vec::new();
        draw(&mut state, &mut first);
        let mut drawn = DrawnPage::new(first);
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
            if asked != PageRequest::Page {
                self.shared.heard().asked(begun);
            }
            let draws = (fresh && begun >= due) || (ended && !drawn.last);
            if draws {
                let grown = draw(&mut state, &mut drawn.runs);
                drawn.last = ended;
                drawn.changed(grown);
                fresh = false;
            }
            // A browser that went away gets none.
            let _ = answer.send(drawn.answer(asked));
            self.shared.heard().end |= drawn.last && asked != PageRequest::Page;
            if draws {
                let now = Instant::now();
                due = now + (now - begun) * REST;
            }
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
    use wingbeat_report::run::PlotAxis;

    fn begun(watch: &Arc<WatchState<f64>>) -> Sender<Question> {
        let (sender, questions) = channel();
        let painter = Painter { shared: watch.clone(), questions };
        thread::spawn(move || {
            let add = |values: &mut Vec<f64>, came: Vec<f64>| values.extend(came);
            painter.run(Vec::new(), add, |values, runs| {
                let axis = PlotAxis { label: "iteration", unit: "", values: values.clone(), joined: true };
                *runs = vec![ShownRun { summary: values.len().into(), ..ShownRun::blank("a", "fit", axis) }];
                true
            });
        });
        sender
    }

    #[test]
    fn what_comes_is_taken_up_unasked_packed_once_and_dropped_when_nobody_draws() {
        let shared = Arc::new(WatchState::new());
        let questions = begun(&shared);
        let ask = |asked: PageRequest| {
            let (sender, receiver) = channel();
            questions.send((asked, sender)).unwrap();
            receiver.recv().unwrap()
        };
        let first = ask(PageRequest::DataAfter(0)).unwrap();
        assert!(Arc::ptr_eq(&first, &ask(PageRequest::DataAfter(0)).unwrap()));
        assert!(
            ask(PageRequest::DataAfter(1)).is_none() && ask(PageRequest::Page).unwrap().contains("data-live")
        );
        shared.news().as_mut().unwrap().push(1.0);
        thread::sleep(3 * TAKEN_UP);
        assert!(shared.news().as_ref().unwrap().is_empty());
        shared.ended.store(true, Ordering::Release);
        let last = ask(PageRequest::DataAfter(1)).unwrap();
        // Who has the first version gets the row behind it, who has none gets all, who has all that it was all.
        assert!(
            last.contains("\"after\":1") && !ask(PageRequest::DataAfter(0)).unwrap().contains("\"after\"")
        );
        assert!(ask(PageRequest::DataAfter(2)).unwrap().contains("\"after\":2"));
        assert!(last.contains("\"ended\":true") && first.contains("\"ended\":false"), "{last}");
        drop(questions);
        thread::sleep(TAKEN_UP);
        assert!(shared.news().is_none());
    }
}

//! A computation on a page while it goes on: `--watch`.

mod convergence;
mod flight;
mod server;

pub use convergence::{Convergence, Point};
pub use flight::FlightWatch;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use wingbeat_report::page::{live_page, news};
use wingbeat_report::run::Run;

use crate::error::Error;
use crate::say;
use server::{Asked, Server};

/// The page is drawn again after so many times the time that drawing it took: it never takes more than a fifth of a core. *Choice.*
const REST: u32 = 4;
/// Longest time between two drawings, s.
const LONGEST: Duration = Duration::from_secs(10);

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
    news: Mutex<Vec<N>>,
    ended: AtomicBool,
}

/// A question of a browser, and where the answer goes.
type Question = (Asked, Sender<String>);

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
        let shared = Arc::new(Shared { news: Mutex::new(Vec::new()), ended: AtomicBool::new(false) });
        let (sender, questions) = channel();
        let server = Server::begin(sender).map_err(refused)?;
        let painter = Painter { shared: shared.clone(), questions };
        thread::Builder::new().name("watch page".into()).spawn(|| paint(painter)).map_err(refused)?;
        say::note(&format!("watch: {}", server.address()));
        Ok(Some(Self { shared, _server: server }))
    }

    /// Adds to what is shown.
    pub fn tell(&self, news: N) {
        self.shared.news.lock().unwrap_or_else(PoisonError::into_inner).push(news);
    }

    /// Says that nothing more comes.
    pub fn end(&self) {
        self.shared.ended.store(true, Ordering::Release);
    }
}

impl<N> Painter<N> {
    /// Answers until nobody can ask: `draw` gets what has come since it was last asked.
    pub fn run(self, mut draw: impl FnMut(Vec<N>) -> Vec<Run>) {
        let mut runs = draw(Vec::new());
        let (mut version, mut last, mut due) = (1, false, Instant::now());
        while let Ok((asked, answer)) = self.questions.recv() {
            let begun = Instant::now();
            let ended = self.shared.ended.load(Ordering::Acquire);
            if begun >= due || (ended && !last) {
                let came =
                    std::mem::take(&mut *self.shared.news.lock().unwrap_or_else(PoisonError::into_inner));
                if !came.is_empty() || (ended && !last) {
                    (runs, version, last) = (draw(came), version + 1, ended);
                }
            }
            let text = match asked {
                Asked::Page => live_page(&runs),
                Asked::News(known) if known < version => news(&runs, version, last),
                Asked::News(_) => String::new(),
            };
            due = due.max(begun + (begun.elapsed() * REST).min(LONGEST));
            // A browser that went away gets none.
            let _ = answer.send(text);
        }
    }
}

//! What is wrong with the records of a stream: found while they come, and judged at the end.

use std::time::{Duration, Instant};

use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::netft::{Account, BOX_RATE, RdtRecord};
use wingbeat_judge::limits::recording::{
    DEAD, DISORDER, DUPLICATES, HELD, LOST, MALFORMED, SATURATED, SERIOUS, STANDING, UNSENT, WARNED,
};
use wingbeat_judge::{Judge, RunLimits, Verdict};
use wingbeat_netft::Row;

/// Records of which a share is at least taken, and from which loads are judged.
const FEW: u64 = 100;
/// Time between two looks at what came.
const LOOK: Duration = Duration::from_secs(1);

/// `count` as a share of `all`.
fn share(count: u64, all: u64) -> f64 {
    count as f64 / all.max(FEW) as f64
}

/// Holds what all logs say against the limits.
pub fn judge(account: &Account, judge: &mut Judge) {
    let all = account.received;
    judge.hold(&LOST, share(account.lost, all + account.lost));
    judge.hold(&SERIOUS, share(account.serious, all));
    judge.hold(&SATURATED, share(account.saturated, all));
    judge.hold(&WARNED, share(account.warnings, all));
    judge.hold(&DISORDER, share(account.reordered + account.restarts.max(account.jumps), all));
}

/// Holds what only one start of the recorder knows against the limits: what the box sent again, or not at all.
pub fn judge_stream(account: &Account, judge: &mut Judge) {
    judge.hold(&UNSENT, share(account.unsent, account.booked()));
    judge.hold(&DUPLICATES, share(account.duplicates, account.received + account.duplicates));
    judge.hold(&MALFORMED, share(account.malformed, account.received));
}

/// Signs of a box that counts or measures no more.
#[derive(Debug, Default)]
pub struct Signs {
    first: Option<RdtRecord>,
    last: Option<RdtRecord>,
    /// Records whose sample number did not grow though their own did.
    standing: u64,
    /// Which channels changed.
    alive: [bool; 6],
    /// Records in a row without a change, and the most of them, in samples of the box.
    held: u32,
    longest: u32,
}

impl Signs {
    /// Takes a record in.
    pub fn see(&mut self, row: &Row) {
        let now = row.record;
        let first = *self.first.get_or_insert(now);
        for (alive, (a, b)) in self.alive.iter_mut().zip(first.counts.into_iter().zip(now.counts)) {
            *alive |= a != b;
        }
        if let Some(last) = self.last.replace(now) {
            let step = |now: u32, then: u32| now.wrapping_sub(then) as i32;
            let samples = step(now.ft_sequence, last.ft_sequence);
            let next = step(now.rdt_sequence, last.rdt_sequence) == 1;
            self.standing += u64::from(next && samples <= 0);
            let still = now.counts == last.counts;
            self.held = if still { self.held.saturating_add(samples.clamp(1, 1000) as u32) } else { 0 };
            self.longest = self.longest.max(self.held);
        }
    }

    /// Holds them against the limits.
    pub fn judge(&self, records: u64, judge: &mut Judge) {
        judge.hold(&STANDING, share(self.standing, records));
        if records < FEW {
            return;
        }
        let dead: Vec<_> =
            CHANNELS.iter().zip(self.alive).filter(|(_, alive)| !alive).map(|((name, _), _)| *name).collect();
        judge.hold_about(&DEAD, dead.len() as f64, &names(&dead));
        judge.hold(&HELD, f64::from(self.longest) / BOX_RATE);
    }
}

fn names(dead: &[&str]) -> String {
    if dead.is_empty() { String::new() } else { format!("({})", dead.join(", ")) }
}

/// Looks at each second of a recording, and says what is wrong with it.
#[derive(Debug)]
pub struct Alarm {
    /// Of the whole recording: a stream is counted from its first record on.
    account: Account,
    /// The counts at the last look.
    before: Account,
    signs: Signs,
    since: Instant,
    told: Vec<&'static str>,
}

impl Alarm {
    /// Nothing seen yet.
    pub fn new() -> Self {
        let (account, signs) = (Account::default(), Signs::default());
        Self { before: account.clone(), account, signs, since: Instant::now(), told: Vec::new() }
    }

    /// Takes in a row, or that none came; what is newly wrong with the last second, once it is over.
    pub fn see(&mut self, row: Option<&Row>) -> Vec<String> {
        if let Some(row) = row {
            self.account.take_new(&row.record, row.arrival_ns());
            self.signs.see(row);
        }
        if self.since.elapsed() < LOOK { Vec::new() } else { self.look() }
    }

    fn look(&mut self) -> Vec<String> {
        self.since = Instant::now();
        let second = self.account.since(&self.before);
        self.before = self.account.counts();
        let signs = std::mem::take(&mut self.signs);
        if second.received == 0 {
            let told = std::mem::replace(&mut self.told, vec!["silence"]);
            let news = !told.contains(&"silence");
            return news.then(|| "alarm: no new record came in the last second".into()).into_iter().collect();
        }
        let broken = verdict(&second, &signs).judged.into_iter().filter(|judged| !judged.met);
        let (mut told, mut lines) = (Vec::new(), Vec::new());
        for judged in broken {
            if !self.told.contains(&judged.id) {
                let value = judged.value.unwrap_or(f64::NAN);
                let unit = if judged.unit.is_empty() { String::new() } else { format!(" {}", judged.unit) };
                lines.push(format!(
                    "alarm: {} is {value:.3}{unit} in the last second, allowed is at most {}",
                    judged.id, judged.limit
                ));
            }
            told.push(judged.id);
        }
        self.told = told;
        lines
    }
}

fn verdict(second: &Account, signs: &Signs) -> Verdict {
    let limits = RunLimits::default();
    let mut judge = Judge::new(&limits);
    self::judge(second, &mut judge);
    signs.judge(second.received, &mut judge);
    judge.verdict()
}

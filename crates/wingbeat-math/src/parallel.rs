//! Work shared among the cores.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Stack of a thread: an evaluation that carries derivatives or lanes holds several MB.
const STACK: usize = 16 << 20;

/// `work` on every item, on all cores; the answers in the order of the items.
///
/// ```
/// let squares = wingbeat_math::parallel::map(&[1, 2, 3], |_, n| n * n);
/// assert_eq!(squares, [1, 4, 9]);
/// ```
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(usize, &T) -> R + Sync) -> Vec<R> {
    let mut answers: Vec<Option<R>> = items.iter().map(|_| None).collect();
    each(items, work, |index, answer| {
        answers[index] = Some(answer);
        ControlFlow::Continue(())
    });
    answers.into_iter().flatten().collect()
}

/// `work` on every item, on all cores; `take` gets each answer with its item's number as soon as it is known, one
/// after another on the calling thread, and may end the work: items begun then are finished and left out. Where the system
/// starts no thread, the calling thread does the work, on its own stack.
pub fn each<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(usize, &T) -> R + Sync,
    mut take: impl FnMut(usize, R) -> ControlFlow<()>,
) {
    let answers = Mutex::new(Vec::new());
    let done = |index: usize| {
        let answer = work(index, &items[index]);
        locked(&answers).push((index, answer));
    };
    shared(items.len(), &done, &mut || {
        let new = std::mem::take(&mut *locked(&answers));
        new.into_iter().try_for_each(|(index, answer)| take(index, answer))
    });
}

/// What the threads of [`shared`] have told.
struct ThreadAnswers {
    /// Whether answers have come since they were taken.
    new: bool,
    /// Threads that work.
    working: usize,
}

/// Tells that a thread works no more, even where its work panics.
struct Leaving<'a>(&'a Mutex<ThreadAnswers>, &'a Condvar);

impl Drop for Leaving<'_> {
    fn drop(&mut self) {
        locked(self.0).working -= 1;
        self.1.notify_one();
    }
}

/// `work` on every number below `count`, on all cores; `take` takes on the calling thread what has been done since it was called last.
/// Compiled once: what is generic of [`each`] would stand in the program again for every work.
fn shared(count: usize, work: &(dyn Fn(usize) + Sync), take: &mut dyn FnMut() -> ControlFlow<()>) {
    let next = AtomicUsize::new(0);
    let (told, wake) = (Mutex::new(ThreadAnswers { new: false, working: 0 }), Condvar::new());
    let run = || {
        let _leaving = Leaving(&told, &wake);
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return;
            }
            work(index);
            locked(&told).new = true;
            wake.notify_one();
        }
    };
    let begun = thread::scope(|scope| {
        let mut begun = false;
        for _ in 0..cores(count) {
            locked(&told).working += 1;
            let starts = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run).is_ok();
            if !starts {
                locked(&told).working -= 1;
            }
            begun |= starts;
        }
        loop {
            let mut now = locked(&told);
            while !now.new && now.working > 0 {
                now = wake.wait(now).unwrap_or_else(PoisonError::into_inner);
            }
            if !std::mem::take(&mut now.new) {
                break;
            }
            drop(now);
            if take().is_break() {
                next.store(count, Ordering::Relaxed);
                break;
            }
        }
        begun
    });
    if !begun {
        let _ = (0..count).try_for_each(|index| {
            work(index);
            take()
        });
    }
}

fn locked<T>(what: &Mutex<T>) -> MutexGuard<'_, T> {
    what.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Cores that `count` items can keep busy.
fn cores(count: usize) -> usize {
    thread::available_parallelism().map_or(1, usize::from).min(count)
}

/// `work` on every item, each core a run of neighbours; on at most `most` cores where that is not 0, and on those that the
/// system has threads for.
///
/// ```
/// let mut numbers = [1, 2, 3];
/// wingbeat_math::parallel::chunks(&mut numbers, 0, |n| *n *= 2);
/// assert_eq!(numbers, [2, 4, 6]);
/// ```
pub fn chunks<T: Send>(items: &mut [T], most: usize, work: impl Fn(&mut T) + Sync) {
    let cores = cores(items.len());
    let cores = if most == 0 { cores } else { cores.min(most) };
    if cores <= 1 {
        return items.iter_mut().for_each(work);
    }
    let size = items.len().div_ceil(cores);
    let parts = Mutex::new(items.chunks_mut(size));
    let next = || locked(&parts).next();
    together(cores, &|| {
        while let Some(part) = next() {
            part.iter_mut().for_each(&work);
        }
    });
}

/// `own` on the calling thread, and `other` on one beside it where the system starts one; what `own` gives, once both have ended.
///
/// ```
/// let (tell, told) = std::sync::mpsc::channel();
/// assert_eq!(wingbeat_math::parallel::beside(move || tell.send(1).unwrap(), || told.recv().unwrap()), 1);
/// ```
pub fn beside<R>(other: impl FnOnce() + Send, own: impl FnOnce() -> R) -> R {
    thread::scope(|scope| {
        // Without a thread what `other` holds is dropped, which `own` can see.
        let _ = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, other);
        own()
    })
}

/// `run` on the calling thread and on as many others as make up `cores`, as far as the system starts them.
fn together(cores: usize, run: &(dyn Fn() + Sync)) {
    thread::scope(|scope| {
        for _ in 1..cores {
            // The others take the part of a thread that does not start.
            let _ = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run);
        }
        run();
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_come_in_the_order_of_the_items() {
        let items: Vec<usize> = (0..100).collect();
        let answers = map(&items, |index, item| {
            thread::sleep(std::time::Duration::from_micros((37 * index % 11) as u64));
            index + item
        });
        assert!(answers.iter().enumerate().all(|(i, answer)| *answer == 2 * i));
    }

    #[test]
    fn work_ends_when_it_is_told_to() {
        let begun = AtomicUsize::new(0);
        let items = [(); 1000];
        let mut seen = 0;
        let work = |_: usize, (): &()| begun.fetch_add(1, Ordering::Relaxed);
        each(&items, work, |_, _| {
            seen += 1;
            if seen == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(seen, 3);
        each(&[] as &[()], |_, ()| (), |_, ()| ControlFlow::Continue(()));
    }

    #[test]
    #[should_panic(expected = "a scoped thread panicked")]
    fn work_that_panics_ends_all() {
        let work = |index: usize, (): &()| assert!(index != 3, "the fourth");
        each(&[(); 8], work, |_, ()| ControlFlow::Continue(()));
    }
}

//! Work shared among the cores.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
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
    let next = AtomicUsize::new(0);
    let (sender, answers) = mpsc::channel();
    let cores = thread::available_parallelism().map_or(1, usize::from).min(items.len());
    let (next, work) = (&next, &work);
    let begun = thread::scope(|scope| {
        let mut begun = false;
        for _ in 0..cores {
            let sender = sender.clone();
            let run = move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { return };
                    if sender.send((index, work(index, item))).is_err() {
                        return;
                    }
                }
            };
            begun |= thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run).is_ok();
        }
        drop(sender);
        for (index, answer) in answers {
            if take(index, answer).is_break() {
                next.store(items.len(), Ordering::Relaxed);
                break;
            }
        }
        begun
    });
    if !begun {
        let answers = items.iter().enumerate().map(|(index, item)| (index, work(index, item)));
        let _ = { answers }.try_for_each(|(index, answer)| take(index, answer));
    }
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
    let cores = thread::available_parallelism().map_or(1, usize::from).min(items.len());
    let cores = if most == 0 { cores } else { cores.min(most) };
    if cores <= 1 {
        return items.iter_mut().for_each(work);
    }
    let size = items.len().div_ceil(cores);
    let parts = Mutex::new(items.chunks_mut(size));
    let next = || parts.lock().unwrap_or_else(PoisonError::into_inner).next();
    let run = || {
        while let Some(part) = next() {
            part.iter_mut().for_each(&work);
        }
    };
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
}

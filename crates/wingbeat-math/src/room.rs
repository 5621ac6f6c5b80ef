//! Filling rooms of fixed size whose elements are large: one copy of a block where a push is a call for each element. And rooms that a
//! thread keeps.

use arrayvec::ArrayVec;
use std::any::Any;
use std::cell::RefCell;

thread_local! {
    /// The rooms that no call uses now.
    static KEPT: RefCell<Vec<Box<dyn Any>>> = const { RefCell::new(Vec::new()) };
}

/// Lends `work` a room that this thread keeps from call to call, as the call before left it; the first gets a `new` one. So large
/// rooms need not be cleared each time. A call within a call gets another room.
pub fn kept<T: 'static, R>(new: impl FnOnce() -> Box<T>, work: impl FnOnce(&mut T) -> R) -> R {
    let found = KEPT.with_borrow_mut(|kept| {
        let place = kept.iter().rposition(|room| room.is::<T>())?;
        kept.swap_remove(place).downcast().ok()
    });
    let mut room: Box<T> = found.unwrap_or_else(new);
    let result = work(&mut room);
    KEPT.with_borrow_mut(|kept| kept.push(room));
    result
}

/// Elements that are copied at once.
const BLOCK: usize = 4;
/// Elements that are larger are copied one by one, bytes: a block of them is no faster, and has to be put together first.
const LARGE: usize = 1024;

/// Copies `values` behind those of `to`, which has room for them.
#[inline(always)]
pub fn append<T: Copy, const N: usize>(to: &mut ArrayVec<T, N>, values: &[T]) {
    let (count, room) = (values.len(), to.remaining_capacity());
    assert!(to.try_extend_from_slice(values).is_ok(), "{count} elements where there is room for {room}");
}

/// Puts `value` behind those of `to`, which has room for it, `count` times.
#[inline(always)]
pub fn append_copies<T: Copy, const N: usize>(to: &mut ArrayVec<T, N>, value: T, count: usize) {
    if count == 0 {
        return;
    }
    let end = to.len() + count;
    if const { size_of::<T>() > LARGE } {
        while to.len() < end {
            append(to, std::slice::from_ref(&value));
        }
        return;
    }
    let block = [value; BLOCK];
    while to.len() < end {
        append(to, &block[..BLOCK.min(end - to.len())]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_fill_the_room_and_no_more() {
        for count in [0, 1, BLOCK, 2 * BLOCK + 1, 10] {
            let mut room = ArrayVec::<u8, 12>::new();
            append(&mut room, &[1, 2]);
            append_copies(&mut room, 7, count);
            assert_eq!(&room[..2], [1, 2]);
            assert!(room.len() == 2 + count && room[2..].iter().all(|value| *value == 7));
        }
    }

    #[test]
    fn large_elements_are_copied_one_by_one() {
        let mut room = ArrayVec::<[u8; 2 * LARGE], 3>::new();
        append_copies(&mut room, [3; 2 * LARGE], 3);
        assert!(room.len() == 3 && room.iter().flatten().all(|value| *value == 3));
    }

    #[test]
    fn a_thread_keeps_a_room_of_each_type_and_a_call_within_a_call_gets_its_own() {
        let next = || kept(|| Box::new(0_u64), |room| std::mem::replace(room, *room + 1));
        assert_eq!([next(), next()], [0, 1]);
        let within =
            kept(|| Box::new(9_u64), |outer| (*outer, next(), kept(|| Box::new(5_i64), |room| *room)));
        assert_eq!(within, (2, 0, 5));
        assert_eq!(std::thread::spawn(move || kept(|| Box::new(7_u64), |room| *room)).join().unwrap(), 7);
    }

    #[test]
    #[should_panic(expected = "3 elements where there is room for 2")]
    fn more_than_there_is_room_for_is_a_fault_of_the_caller() {
        append(&mut ArrayVec::<u8, 2>::new(), &[1, 2, 3]);
    }
}

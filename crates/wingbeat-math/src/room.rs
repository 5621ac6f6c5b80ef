//! Filling rooms of fixed size whose elements are large: one copy of a block where a push is a call for each element.

use arrayvec::ArrayVec;

/// Elements that are copied at once.
const BLOCK: usize = 4;

/// Copies `values` behind those of `to`, which has room for them.
#[inline(always)]
pub(crate) fn append<T: Copy, const N: usize>(to: &mut ArrayVec<T, N>, values: &[T]) {
    let (count, room) = (values.len(), to.remaining_capacity());
    assert!(to.try_extend_from_slice(values).is_ok(), "{count} elements where there is room for {room}");
}

/// Puts `value` behind those of `to`, which has room for it, `count` times.
#[inline(always)]
pub(crate) fn append_copies<T: Copy, const N: usize>(to: &mut ArrayVec<T, N>, value: T, count: usize) {
    let (block, end) = ([value; BLOCK], to.len() + count);
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
    #[should_panic(expected = "3 elements where there is room for 2")]
    fn more_than_there_is_room_for_is_a_fault_of_the_caller() {
        append(&mut ArrayVec::<u8, 2>::new(), &[1, 2, 3]);
    }
}

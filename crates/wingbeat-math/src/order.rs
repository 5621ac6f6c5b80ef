//! Numbers in order, by IEEE 754's total order. A sort is long code that is compiled again for each comparison: this one is
//! compiled once, for places, and what is to be sorted only moves to them. The numbers are in the caller's units.

/// Sorts numbers, the least first.
#[inline(never)]
pub fn ascend(numbers: &mut [f64]) {
    numbers.sort_unstable_by(f64::total_cmp);
}

/// Sorts numbers, the greatest first.
pub fn descend(numbers: &mut [f64]) {
    ascend(numbers);
    numbers.reverse();
}

/// Sorts by a number of each item, the least first; items with equal numbers keep their order.
pub fn ascend_by<T>(items: &mut [T], number: impl FnMut(&T) -> f64) {
    let numbers: Vec<f64> = items.iter().map(number).collect();
    let mut places = places(&numbers);
    for first in 0..places.len() {
        // Once around the cycle of places that begins here: each takes from the next what belongs to it.
        let mut at = first;
        while places[at] != first {
            let from = places[at];
            items.swap(at, from);
            places[at] = at;
            at = from;
        }
        places[at] = at;
    }
}

/// Sorts by a number of each item, the greatest first; items with equal numbers keep their order.
pub fn descend_by<T>(items: &mut [T], mut number: impl FnMut(&T) -> f64) {
    // The sign turns the total order around.
    ascend_by(items, |item| -number(item));
}

/// A map or another collection of `entries`, put in one by one. What `collect` makes of an ordered map sorts a list first, by code
/// that is compiled again for every kind of iterator.
pub fn filled<M: Default + Extend<E>, E>(entries: impl IntoIterator<Item = E>) -> M {
    let mut all = M::default();
    all.extend(entries);
    all
}

/// Places of the numbers, that of the least first.
#[inline(never)]
fn places(numbers: &[f64]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..numbers.len()).collect();
    places.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the standard library sorts, equal numbers, both zeros and what is no number included.
    #[test]
    fn orders_are_those_of_a_stable_sort() {
        let mut seed = 1_u64;
        for length in 0..60 {
            let mut items = Vec::new();
            for place in 0..length {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let number =
                    [f64::NAN, -0.0, 0.0, f64::NEG_INFINITY, 2.5, -1.5, 7.0][(seed >> 33) as usize % 7];
                items.push((number, place));
            }
            let bits = |items: &[(f64, i32)]| -> Vec<(u64, i32)> {
                items.iter().map(|(number, place)| (number.to_bits(), *place)).collect()
            };
            let (mut up, mut down) = (items.clone(), items.clone());
            ascend_by(&mut up, |item| item.0);
            descend_by(&mut down, |item| item.0);
            items.sort_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(bits(&up), bits(&items));
            let mut numbers: Vec<f64> = down.iter().map(|item| item.0).collect();
            items.sort_by_key(|item| item.1);
            items.sort_by(|a, b| b.0.total_cmp(&a.0));
            assert_eq!(bits(&down), bits(&items));
            descend(&mut numbers);
            assert!(numbers.iter().zip(&items).all(|(number, item)| number.to_bits() == item.0.to_bits()));
        }
    }
}

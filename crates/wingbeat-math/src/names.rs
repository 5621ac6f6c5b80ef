//! Names that a user may have meant.

/// Names that are listed whole.
const LISTED: usize = 24;
/// Of more, how many are shown.
const SHOWN: usize = 8;

/// What is allowed where `given` is none of the names `known`: those, or of many the nearest.
pub fn one_of(given: &str, known: &[impl AsRef<str>]) -> String {
    let all: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    let meant = nearest(given, &all).map_or(String::new(), |name| format!("; did you mean {name}?"));
    if all.len() <= LISTED {
        return format!("of {}{meant}", all.join(", "));
    }
    let shown = nearest_names(given, &all, SHOWN);
    format!("of {} names, the nearest {}{meant}", all.len(), shown.join(", "))
}

/// The name that `given` was probably meant to be.
pub fn nearest<'a>(given: &str, allowed: &'a [impl AsRef<str>]) -> Option<&'a str> {
    let tolerance = (given.len() / 3).max(1);
    let begins = |name: &str| given.len() > 1 && (name.starts_with(given) || given.starts_with(name));
    let candidates = allowed.iter().map(AsRef::as_ref);
    let candidates = candidates.map(|name| (if begins(name) { 0 } else { distance(given, name) }, name));
    candidates.filter(|(distance, _)| *distance <= tolerance).min().map(|(_, name)| name)
}

/// The `count` names that are most like `given`, the nearest first: by the letters to change in the whole name or, where that is
/// less, in its last part.
pub fn nearest_names<'a>(given: &str, known: &[&'a str], count: usize) -> Vec<&'a str> {
    let last = |name: &str| name.rsplit('.').next().unwrap_or_default().to_owned();
    let apart = |name: &str| {
        let parts = 1 + distance(&last(given), &last(name));
        distance(given, name).min(parts)
    };
    let mut ranked: Vec<(usize, usize, &str)> =
        known.iter().map(|name| (apart(name), distance(given, name), *name)).collect();
    ranked.sort_unstable();
    ranked.into_iter().take(count).map(|(_, _, name)| name).collect()
}

/// Number of letters to insert, delete or replace between `a` and `b` (Levenshtein 1966).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_single_letters() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("same", "same"), 0);
    }

    #[test]
    fn only_a_near_name_is_suggested() {
        let names = ["duration_s", "step_s"];
        assert_eq!(nearest("duration", &names), Some("duration_s"));
        assert_eq!(nearest("stepp_s", &names), Some("step_s"));
        assert_eq!(nearest("wind", &names), None);
    }

    #[test]
    fn names_are_near_by_the_whole_or_by_their_last_part() {
        let known = ["body.mass_kg", "surfaces.wing.cd0", "surfaces.wing.cd90", "gait.phase_rad"];
        assert_eq!(
            nearest_names("surfaces.wing.cd9", &known, 2),
            ["surfaces.wing.cd0", "surfaces.wing.cd90"]
        );
        assert_eq!(nearest_names("wing.cd90", &known, 1), ["surfaces.wing.cd90"]);
    }

    #[test]
    fn few_names_are_listed_and_of_many_the_nearest() {
        assert_eq!(
            one_of("elevater", &["elevator", "rudder"]),
            "of elevator, rudder; did you mean elevator?"
        );
        assert_eq!(one_of("x", &["elevator", "rudder"]), "of elevator, rudder");
        let many: Vec<String> = (0..100).map(|i| format!("lag_{i}")).chain(["hand".into()]).collect();
        let told = one_of("hans", &many);
        assert!(told.starts_with("of 101 names, the nearest hand, ") && told.ends_with("did you mean hand?"));
    }
}

//! Where the flights of a sweep end, group by group.

use serde::Serialize;
use wingbeat::scenario::Sweep;
use wingbeat::simulate::Record;
use wingbeat_figures::{EndPoints, Figure};

use crate::sweep::cases::labelled;

/// The flights that share the words drawn for them: one group where there are none.
#[derive(Debug, Serialize)]
pub struct EndPointGroup {
    /// The words, as key and value.
    name: String,
    flights: usize,
    held: usize,
    completed: usize,
    /// 5, 50 and 95 % of the distance along x, m, of the flights that were flown to the end.
    distance_x_m: [Option<f64>; 3],
    /// The same along y, m; left is positive.
    distance_y_m: [Option<f64>; 3],
    /// The same of the climb, m.
    altitude_change_m: [Option<f64>; 3],
    /// The same of the distance from the published end point, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_paper_m: Option<[Option<f64>; 3]>,
}

/// Rows of the record by the words drawn for them, in the order of their names.
fn groups(record: &Record, sweep: &Sweep) -> Vec<(String, Vec<usize>)> {
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    for row in 0..record.rows() {
        let word = |draw: &wingbeat::scenario::Draw| {
            let value = record.values(&draw.key)?[row];
            Some(draw.word(value)?.to_string().trim_matches('"').to_owned())
        };
        let words: Vec<String> = sweep.draws().iter().filter_map(word).collect();
        let name = if words.is_empty() { "all".into() } else { words.join(", ") };
        match groups.iter_mut().find(|group| group.0 == name) {
            Some(group) => group.1.push(row),
            None => groups.push((name, vec![row])),
        }
    }
    groups.sort_by(|a, b| a.0.cmp(&b.0));
    groups
}

/// The published end point, y to the left: the turn of a positive roll is to the right.
fn published(sweep: &Sweep) -> Option<(f64, f64)> {
    sweep.paper().map(|paper| (paper.distance_x_m, -paper.roll_deg.signum() * paper.distance_y_m))
}

/// What each group came to.
pub fn table(record: &Record, sweep: &Sweep) -> Vec<EndPointGroup> {
    let target = published(sweep);
    let column = |name: &str| record.values(name).unwrap_or_default();
    let (x, y, z) = (column("distance_x"), column("distance_y"), column("altitude_change"));
    let group = |(name, rows): (String, Vec<usize>)| {
        let count = |name: &str| rows.iter().filter(|&&row| column(name)[row] == 1.0).count();
        let flown: Vec<usize> = rows.iter().copied().filter(|&row| column("completed")[row] == 1.0).collect();
        let of = |value: &dyn Fn(usize) -> f64| spread(flown.iter().map(|&row| value(row)));
        EndPointGroup {
            name,
            flights: rows.len(),
            held: count("held"),
            completed: count("completed"),
            distance_x_m: of(&|row| x[row]),
            distance_y_m: of(&|row| y[row]),
            altitude_change_m: of(&|row| z[row]),
            from_paper_m: target.map(|(tx, ty)| of(&|row| (x[row] - tx).hypot(y[row] - ty))),
        }
    };
    groups(record, sweep).into_iter().map(group).collect()
}

/// 5, 50 and 95 % of values, by their order.
fn spread(values: impl Iterator<Item = f64>) -> [Option<f64>; 3] {
    let mut sorted: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    wingbeat::math::order::ascend(&mut sorted);
    let at = |share: f64| sorted.get(((sorted.len() as f64 * share).ceil() as usize).max(1) - 1);
    [0.05, 0.5, 0.95].map(|share| at(share).copied())
}

/// The table in words.
pub fn text(groups: &[EndPointGroup]) -> String {
    let cell = |of: [Option<f64>; 3]| match of {
        [Some(low), Some(middle), Some(high)] => format!("{middle:.2} ({low:.2} to {high:.2})"),
        _ => "-".into(),
    };
    let published =
        if groups.iter().any(|group| group.from_paper_m.is_some()) { "from the paper's" } else { "" };
    let mut text = format!(
        "{:<22}{:>8}{:>10}{:>6}  {:<27}{:<27}{:<27}{published}\n",
        "end point",
        "flights",
        "completed",
        "held",
        "x, median (5 to 95 %) m",
        "y, left is positive",
        "climb"
    );
    for group in groups {
        text += &format!(
            "{:<22}{:>8}{:>10}{:>6}  {:<27}{:<27}{:<27}{}\n",
            group.name,
            group.flights,
            group.completed,
            group.held,
            cell(group.distance_x_m),
            cell(group.distance_y_m),
            cell(group.altitude_change_m),
            group.from_paper_m.map_or(String::new(), cell),
        );
    }
    text
}

/// The end points of all flights, and the published one.
pub fn drawn(record: &Record, sweep: &Sweep) -> Result<Figure, wingbeat_figures::Error> {
    let groups = groups(record, sweep);
    let varied = labelled(sweep).pop().filter(|_| sweep.draws().len() == 1 && groups.len() == 1);
    wingbeat_figures::end_points(record, &EndPoints { groups: &groups, published: published(sweep), varied })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_of_values_of_the_list() {
        assert_eq!(spread((1..=100).map(f64::from)), [5.0, 50.0, 95.0].map(Some));
        assert_eq!(spread([f64::NAN].into_iter()), [None; 3]);
    }
}

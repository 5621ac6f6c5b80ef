//! How membranes and flaps give way over the last cycle.

use wingbeat::simulate::Record;

use crate::panel::{FigurePanel, MOST_NAMED, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, cycle, needed, style};

/// Rise of the membrane at half of the chord on strips from the middle on, over the last cycle or, where there is none, over time.
///
/// Needs `t` and the columns `camber_<strip>`, after the name of any surface but the first.
pub fn camber(record: &Record) -> Result<Figure, Error> {
    of_strips(record, ("camber", "camber_", "rise at half of the chord [% of the chord]"), 100.0)
}

/// Angle of the flap on strips of either half, likewise.
///
/// Needs `t` and the columns `flap_<strip>`, after the name of any surface but the first.
pub fn flap(record: &Record) -> Result<Figure, Error> {
    let degrees = 1.0_f64.to_degrees();
    of_strips(record, ("flap", "flap_", "angle of the flap, trailing edge down [°]"), degrees)
}

/// Share of the largest value by which both wings may differ that are drawn as one.
const SAME: f64 = 1e-3;

/// The number of a column's strip, counted from 1.
fn number(column: &str) -> String {
    let place: Option<usize> = column.rsplit('_').next().and_then(|number| number.parse().ok());
    place.map_or(String::new(), |place| (place + 1).to_string())
}

/// Two panels for each surface with the columns that are called `kind` and a number, times `scale`: from the middle strip to the first, at the
/// left tip or end, and to the last; one where both are alike. Of many strips each second, third and so on is drawn, from the ends on.
fn of_strips(
    record: &Record,
    (name, kind, title): (&'static str, &str, &str),
    scale: f64,
) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let (rows, x, label) = match cycle::phased(record) {
        Some((rows, phases)) => (rows, phases, "share of the last cycle"),
        None => (0..t.len(), t.to_vec(), "time [s]"),
    };
    // Surface and strip of each column, in the order of the strips from the left tip to the right.
    let mut surfaces: Vec<(&str, Vec<&str>)> = Vec::new();
    for column in record.columns() {
        let Some((surface, strip)) = column.name.rsplit_once(kind) else { continue };
        if strip.is_empty() || !strip.bytes().all(|digit| digit.is_ascii_digit()) {
            continue;
        }
        match surfaces.iter_mut().find(|(known, _)| *known == surface) {
            Some((_, columns)) => columns.push(&column.name),
            None => surfaces.push((surface, vec![&column.name])),
        }
    }
    let mut panels = Vec::new();
    for (surface, columns) in &surfaces {
        // A strip in the middle belongs to both.
        let middle = columns.len() / 2;
        let (left, right) = (&columns[..columns.len() - middle], &columns[middle..]);
        let outward: [Vec<&&str>; 2] = [left.iter().rev().collect(), right.iter().collect()];
        // Where both wings do the same one panel says so.
        let mut same = outward[0].len() == outward[1].len();
        for (one, other) in outward[0].iter().zip(&outward[1]) {
            let (one, other) = (&needed(record, one)?[rows.clone()], &needed(record, other)?[rows.clone()]);
            let most = one.iter().map(|value| value.abs()).fold(0.0, f64::max);
            same &= one.iter().zip(other).all(|(a, b)| (a - b).abs() <= SAME * most);
        }
        for strips in outward.into_iter().take(if same { 1 } else { 2 }) {
            let every = strips.len().div_ceil(MOST_NAMED).max(1);
            let shown = strips.iter().rev().step_by(every).rev().enumerate();
            let curves = shown.map(|(index, column)| {
                let number = number(column);
                let values = needed(record, column)?[rows.clone()].iter().map(|value| scale * value);
                Ok(PanelCurve::new(format!("strip {number}"), &x, values.collect(), index))
            });
            let wing = surface.trim_end_matches('_').replace('_', " ");
            let (from, to) =
                (strips.first().map(|name| number(name)), strips.last().map(|name| number(name)));
            let (from, to) = (from.unwrap_or_default(), to.unwrap_or_default());
            let wing = if wing.is_empty() { wing } else { format!("{wing}, ") };
            let both = if same { ", right wing alike" } else { "" };
            let title = format!("{wing}strips {from} to {to} from the left tip{both}: {title}");
            panels.push(FigurePanel::new(title, curves.collect::<Result<_, Error>>()?));
        }
    }
    if panels.is_empty() {
        return Err(Error::Column(format!("{kind}0")));
    }
    Ok(Figure::new(name, stacked(panels, label, style::PANEL)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::simulate::Column;

    #[test]
    fn membranes_and_flaps_of_all_surfaces_are_drawn() {
        let strips = |of: &str| (0..4).map(|i| format!("{of}_{i}")).collect::<Vec<_>>();
        let membrane = [strips("camber"), strips("camber_forward"), strips("tail_camber")];
        let of = |names: Vec<String>| {
            let column = |name: String| Column { values: vec![0.0, 0.1, 0.0], ..Column::new(name, "", "") };
            Record::new(["t".to_owned()].into_iter().chain(names).map(column).collect(), 0).unwrap()
        };
        assert_eq!(camber(&of(membrane.concat())).unwrap().name, "camber");
        assert!(
            camber(&of(membrane.concat()))
                .unwrap()
                .svg()
                .contains("tail, strips 2 to 1 from the left tip, right wing alike")
        );
        assert_eq!(flap(&of(strips("flap"))).unwrap().name, "flap");
        assert!(matches!(flap(&of(strips("camber"))), Err(Error::Column(_))));
    }
}

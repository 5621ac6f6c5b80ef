//! The loads of a tethered wing over its last cycle, and their spread over the span.

use std::ops::Range;

use wingbeat::aero::{Circulation, LoadSource};
use wingbeat::math::DEGREES;
use wingbeat::simulate::Record;
use wingbeat::tether::{Spar, Steady};

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Degrees per radian.
/// Phases at which the span is shown, cycles.
const PHASES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// Lift and drag, forces by source, the pitching moment and the motion over the last cycle.
pub fn cycle_loads(record: &Record) -> Result<Figure, Error> {
    let cycle = LastCycle::of(record)?;
    let wind = vec![
        cycle.curve("lift", "force_wind_lift", 1.0, 0)?,
        cycle.curve("drag", "force_wind_drag", 1.0, 1)?,
    ];
    let mut panels = vec![
        FigurePanel::new("force in wind axes [N]", wind),
        cycle.by_source("z", "upward force by source, body axes [N]")?,
        cycle.by_source("x", "forward force by source, body axes [N]")?,
        cycle.moment()?,
    ];
    panels.extend(cycle.motion()?);
    let x_label = format!("phase of the last cycle of {:.3} s", cycle.period);
    Ok(Figure::new("loads", stacked(panels, &x_label, style::PANEL)))
}

/// Whether two curves lie within the weight of one.
fn alike(a: &[f64], b: &[f64]) -> bool {
    let most = a.iter().map(|a| a.abs()).fold(0.0, f64::max);
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-3 * most)
}

/// The last cycle of a record of loads.
struct LastCycle<'a> {
    record: &'a Record,
    rows: Range<usize>,
    phase: Vec<f64>,
    period: f64,
}

impl<'a> LastCycle<'a> {
    fn of(record: &'a Record) -> Result<Self, Error> {
        let rows = last_cycle(needed(record, "phase")?)?;
        let t = &needed(record, "t")?[rows.clone()];
        let period = t[t.len() - 1] - t[0];
        let phase = t.iter().map(|now| (now - t[0]) / period).collect();
        Ok(Self { record, rows, phase, period })
    }

    fn curve(&self, name: &str, column: &str, scale: f64, index: usize) -> Result<PanelCurve, Error> {
        let values = &needed(self.record, column)?[self.rows.clone()];
        Ok(PanelCurve::new(name, &self.phase, values.iter().map(|y| scale * y).collect(), index))
    }

    fn by_source(&self, axis: &str, title: &str) -> Result<FigurePanel, Error> {
        let mut curves = Vec::new();
        for (index, source) in LoadSource::STRIP.map(LoadSource::name).iter().enumerate() {
            curves.push(self.curve(
                &source.replace('_', " "),
                &format!("force_{source}_{axis}"),
                1.0,
                index,
            )?);
        }
        // What bears on the leading edge is part of the circulatory force. Where it is all of it one curve says so.
        let circulatory = LoadSource::STRIP.iter().position(|source| *source == LoadSource::Circulatory);
        for (index, part) in ["suction", "vortex"].into_iter().enumerate() {
            let column = format!("force_{part}_{axis}");
            if self.record.values(&column).is_some_and(|force| force.iter().any(|f| *f != 0.0)) {
                let own = self.curve("", &column, 1.0, LoadSource::STRIP.len() + index)?;
                match circulatory.map(|k| &mut curves[k]).filter(|whole| alike(&whole.y, &own.y)) {
                    Some(whole) => whole.name += &format!(", all {part}"),
                    None => curves.push(PanelCurve { name: format!("of circulatory: {part}"), ..own }),
                }
            }
        }
        let total = self.curve("", &format!("force_{axis}"), 1.0, 0)?;
        curves.push(PanelCurve::total("total", &self.phase, total.y));
        Ok(FigurePanel::new(title, curves))
    }

    /// Nose up: about the span, against the record's `moment_y`.
    fn moment(&self) -> Result<FigurePanel, Error> {
        let moment = self.curve("nose up", "moment_y", -1.0, 0)?;
        Ok(FigurePanel::new("moment about the span, nose up, body axes [N m]", vec![moment]))
    }

    /// Body and hinges, as far as they leave zero.
    fn motion(&self) -> Result<Vec<FigurePanel>, Error> {
        let body = vec![self.curve("heave", "heave", 1.0, 0)?, self.curve("surge", "surge", 1.0, 1)?];
        let mut angles =
            vec![self.curve("nose up", "nose_up", DEGREES, 0)?, self.curve("roll", "roll", DEGREES, 1)?];
        let hinges = self.record.columns().iter().filter_map(|column| column.name.strip_prefix("hinge_"));
        for (index, name) in hinges.enumerate() {
            angles.push(self.curve(name, &format!("hinge_{name}"), DEGREES, index + 2)?);
        }
        let mut panels = Vec::new();
        for (title, mut curves) in [("body [m]", body), ("angles [°]", angles)] {
            curves.retain(|curve| curve.y.iter().any(|y| *y != 0.0));
            if !curves.is_empty() {
                panels.push(FigurePanel::new(title, curves));
            }
        }
        Ok(panels)
    }
}

/// Circulation, where the model has one, angle of attack, separation and suction lost, where there are any, and force over the span at four phases of the last cycle.
/// Where `edges` bear suction, the title says that the outermost strips have that of the side edges, which leaps with their width.
pub fn span_loading(strips: &Record, edges: bool) -> Result<Figure, Error> {
    let (phase, arc) = (needed(strips, "phase")?, needed(strips, "arc")?);
    let count = 1 + needed(strips, "strip")?.iter().fold(0.0_f64, |most, strip| most.max(*strip)) as usize;
    let by_instant: Vec<f64> = phase.iter().copied().step_by(count).collect();
    let cycle = last_cycle(&by_instant)?;
    let at_phases = |column: &str, title: &str, scale: &dyn Fn(usize) -> f64| -> Result<FigurePanel, Error> {
        let values = needed(strips, column)?;
        let mut curves = Vec::new();
        for (index, wanted) in PHASES.into_iter().enumerate() {
            let instants = cycle.clone().take(cycle.len() - 1);
            let distance = |i: &usize| (by_instant[*i] - wanted).abs();
            let nearest = instants.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(cycle.start);
            let rows = nearest * count..(nearest + 1) * count;
            let y = rows.clone().map(|row| scale(row) * values[row]).collect();
            curves.push(PanelCurve::new(format!("phase {wanted}"), &arc[rows], y, index));
        }
        Ok(FigurePanel::new(title, curves))
    };
    let mut panels = Vec::new();
    let circulation = Circulation::Bound.name();
    if strips.column(circulation).is_some() {
        panels.push(at_phases(circulation, "circulation [m2/s]", &|_| 1.0)?);
    }
    panels.push(at_phases("incidence", "incidence, wash included [°]", &|_| DEGREES)?);
    for (column, title) in [
        ("separated", "separated share of the flow"),
        ("suction_lost", "share of the leading-edge suction lost"),
    ] {
        if strips.values(column).is_some_and(|shares| shares.iter().any(|share| *share != 0.0)) {
            panels.push(at_phases(column, title, &|_| 1.0)?);
        }
    }
    let width = needed(strips, "width")?;
    let title = match edges {
        true => "upward force per span, body axes [N/m]; the last strips bear all suction of the side edges",
        false => "upward force per span, body axes [N/m]",
    };
    panels.push(at_phases("force_z", title, &|row| 1.0 / width[row])?);
    Ok(Figure::new("span", stacked(panels, "arc from the middle, left wing positive [m]", style::PANEL)))
}

/// The reference line of the left half from the root outboard: unbent, and at rest in the wind; and its twist there.
pub fn bent_wing(spar: &Spar, steady: &Steady) -> Figure {
    let line = spar.line(&steady.q);
    let column = |k: usize, scale: f64| line.iter().map(|at| scale * at[k]).collect::<Vec<f64>>();
    let outboard = column(0, 1.0);
    let arcs = spar.beam.arcs();
    let unbent = PanelCurve::new("unbent", &arcs, vec![0.0; arcs.len()], 0);
    let panels = vec![
        FigurePanel::new(
            "up [m]",
            vec![unbent, PanelCurve::new("at rest in the wind", &outboard, column(2, 1.0), 1)],
        ),
        FigurePanel::new(
            "ahead [m]",
            vec![PanelCurve::new("at rest in the wind", &outboard, column(1, -1.0), 1)],
        ),
        FigurePanel::new(
            "twist, nose up [°]",
            vec![PanelCurve::new("at rest in the wind", &outboard, column(3, DEGREES), 1)],
        ),
    ];
    Figure::new("spar", stacked(panels, "outboard of the spar's root [m]", style::PANEL))
}

/// Rows from the last but one start of a cycle to the last one, both included.
fn last_cycle(phase: &[f64]) -> Result<Range<usize>, Error> {
    let starts: Vec<usize> = (0..phase.len()).filter(|&i| phase[i] == 0.0).collect();
    match starts[..] {
        [.., from, to] => Ok(from..to + 1),
        _ => Err(Error::Rows { rows: phase.len(), needed: 2 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::simulate::Column;

    #[test]
    fn the_last_cycle_closes_where_the_next_begins() {
        assert_eq!(last_cycle(&[0.0, 0.5, 0.0, 0.5, 0.0, 0.5]).unwrap(), 2..5);
        assert!(last_cycle(&[0.0, 0.5]).is_err());
    }

    #[test]
    fn span_curves_are_taken_at_their_phases() {
        let names = ["t", "phase", "strip", "arc", "circulation", "incidence", "force_z", "width"];
        let mut strips = Record::new(names.map(|name| Column::new(name, "", "")).to_vec(), 0).unwrap();
        for step in 0..=8 {
            for strip in 0..3 {
                let (phase, strip) = (f64::from(step % 4) / 4.0, f64::from(strip));
                strips.append(&[f64::from(step), phase, strip, 1.0 - strip, phase + strip, 0.1, 0.0, 0.1]);
            }
        }
        assert_eq!(span_loading(&strips, true).unwrap().name, "span");
        assert!(matches!(cycle_loads(&strips), Err(Error::Column(_))));
    }
}

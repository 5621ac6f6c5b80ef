//! A periodic flight: wing and angle of attack over the cycle, multipliers in the unit circle, orbits along a parameter.

use std::f64::consts::TAU;
use wingbeat::math::DEGREES;
use wingbeat::math::order::ascend_by;

use wingbeat::simulate::{Column, Record};

use crate::chart::{Chart, ChartAxis, ChartSeries, Look, grid};
use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, own_joints, style};

/// Angles of attack beyond which stall is counted, deg.
const LEVELS: [f64; 5] = [-20.0, -12.0, 0.0, 12.0, 20.0];
/// Size of a multiplier from which on its mode is named.
const NAMED: f64 = 0.5;
/// Most named kinds of modes: with the circle and the two of no name eight stand in the legend. *Choice.*
const MOST_NAMED: usize = 5;
/// Size of a multiplier below which it is a mark at zero, which would hide others. *Choice.*
const GONE: f64 = 0.01;
/// Name of those below.
const OTHERS: &str = "others";
/// Points of the unit circle.
const CIRCLE: usize = 181;
/// Height of a panel of a family, px.
const HEIGHT: f64 = 210.0;

/// Joint angles, angle of attack of the left wing's strips, attitude, power and clearance over the cycle.
///
/// Needs `t`, `pitch`, `joint_power`, `incidence_0`; draws the robot's joints, of pairs the left ones, and clearances where they are there.
pub fn orbit(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    if t.len() < 2 {
        return Err(Error::Rows { rows: t.len(), needed: 2 });
    }
    let period = t[t.len() - 1] - t[0];
    let x: Vec<f64> = t.iter().map(|now| (now - t[0]) / period).collect();
    let scaled = |values: &[f64], factor: f64| values.iter().map(|v| factor * v).collect::<Vec<f64>>();
    let curve = |name: String, values: &[f64], factor: f64, i: usize| {
        PanelCurve::new(name, &x, scaled(values, factor), i)
    };
    let joints = |turns: bool| -> Vec<PanelCurve> {
        let joints = own_joints::left(record).filter(|(joint, _)| joint.turns == turns).enumerate();
        joints
            .map(|(i, (joint, column))| curve(joint.name.clone(), &column.values, joint.scale(), i))
            .collect()
    };
    let (turning, sliding) = (joints(true), joints(false));
    // The power of each driven joint, its effort times the central difference of its place, beside that of all.
    let mut powers =
        vec![PanelCurve::total("all driven joints", &x, needed(record, "joint_power")?.to_vec())];
    let driven = own_joints::left(record).filter(|(joint, _)| joint.is_driven());
    powers.extend(driven.enumerate().filter_map(|(i, (joint, column))| {
        let effort = record.values(&format!("torque_{}", column.name))?;
        let rate = |k: usize| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(t.len() - 1));
            (column.values[after] - column.values[before]) / (t[after] - t[before])
        };
        let power: Vec<f64> = effort.iter().enumerate().map(|(k, effort)| effort * rate(k)).collect();
        Some(PanelCurve::new(joint.name, &x, power, i))
    }));
    let strips = (0..).map_while(|i| record.values(&format!("incidence_{i}"))).collect::<Vec<_>>();
    needed(record, "incidence_0")?;
    let left = strips.iter().take(strips.len().div_ceil(2)).enumerate();
    let incidences =
        left.map(|(i, values)| curve(format!("strip {} from the left tip", i + 1), values, DEGREES, i));
    let clearances =
        record.columns().iter().filter(|column| column.name.starts_with("clearance_")).enumerate();
    let clear: Vec<PanelCurve> = clearances
        .map(|(i, column)| {
            curve(column.name.trim_start_matches("clearance_").replace('_', " "), &column.values, 1e3, i)
        })
        .collect();
    let mut panels = vec![
        FigurePanel::new("joint angles [°], up, forward, nose up", turning),
        FigurePanel {
            levels: LEVELS.to_vec(),
            ..FigurePanel::new("angle of attack [°], lines at 0, ±12 and ±20", incidences.collect())
        },
        FigurePanel::new(
            "pitch [°], nose up",
            vec![curve("pitch".into(), needed(record, "pitch")?, -DEGREES, 0)],
        ),
        FigurePanel::new("joint power [W], of pairs the left joint", powers),
    ];
    if !sliding.is_empty() {
        panels.insert(1, FigurePanel::new("joint travel [mm]", sliding));
    }
    panels.retain(|panel| !panel.curves.is_empty());
    if !clear.is_empty() {
        panels.push(FigurePanel::new("clearance [mm]", clear));
    }
    let label = format!("share of the cycle of {period:.4} s");
    Ok(Figure::new("orbit", stacked(panels, &label, style::PANEL)))
}

/// Modes of one name: it, whether they are longitudinal, and where their multipliers are.
type ModeGroup<'a> = (&'a str, bool, Vec<(f64, f64)>);

/// Floquet multipliers in the unit circle: longitudinal ones as circles, lateral ones as crosses; those of half the unit's size
/// and more by the coordinate with the largest share in their mode.
///
/// Needs `multiplier_re`, `multiplier_im`, `lateral`; names modes by `share_*` where they are there.
pub fn multipliers(record: &Record) -> Result<Figure, Error> {
    let (re, im) = (needed(record, "multiplier_re")?, needed(record, "multiplier_im")?);
    let lateral = needed(record, "lateral")?;
    let shares: Vec<(&str, &[f64])> = record
        .columns()
        .iter()
        .filter_map(|column| Some((column.name.strip_prefix("share_")?, column.values.as_slice())))
        .collect();
    let own = |row: usize| -> &str {
        // Of both sides' equal shares the left one's name.
        let most = shares.iter().rev().max_by(|a, b| a.1[row].total_cmp(&b.1[row]));
        match most {
            Some((_, values)) if values[row] == 0.0 => "heading",
            Some((name, _)) if re[row].hypot(im[row]) >= NAMED => name,
            _ => OTHERS,
        }
    };
    // The largest first: those beyond the first few kinds have no name.
    let mut rows: Vec<usize> = (0..record.rows()).collect();
    wingbeat::math::order::descend_by(&mut rows, |item| re[*item].hypot(im[*item]));
    let seen = rows.iter().take_while(|row| re[**row].hypot(im[**row]) >= GONE).count();
    let gone = rows.split_off(seen).len();
    let mut groups: Vec<ModeGroup> = Vec::new();
    for row in rows {
        let (own, longitudinal) = (own(row), lateral[row] == 0.0);
        let known = groups.iter().any(|group| (group.0, group.1) == (own, longitudinal));
        let named = groups.iter().filter(|group| group.0 != OTHERS).count();
        let name = if known || named < MOST_NAMED { own } else { OTHERS };
        let at = groups.iter().position(|group| (group.0, group.1) == (name, longitudinal));
        let at = at.unwrap_or_else(|| {
            groups.push((name, longitudinal, Vec::new()));
            groups.len() - 1
        });
        groups[at].2.push((re[row], im[row]));
    }
    // Those of no name last, which are many.
    ascend_by(&mut groups, |group| if group.0 == OTHERS { 1.0 } else { 0.0 });
    let circle =
        (0..CIRCLE).map(|i| (TAU * i as f64 / (CIRCLE - 1) as f64).sin_cos()).map(|(s, c)| (c, s)).collect();
    let largest = re.iter().zip(im).map(|(re, im)| re.hypot(*im)).fold(1.0, f64::max);
    let reach = 1.1 * largest;
    let circle =
        ChartSeries { colour: style::INK.into(), ..ChartSeries::new("unit circle", circle, Look::Line, 0) };
    let named = groups.iter().filter(|group| group.0 != OTHERS).count();
    let modes = groups.into_iter().enumerate().map(|(i, (name, longitudinal, points))| {
        let name = match (name, longitudinal) {
            (OTHERS, true) => format!("{OTHERS}, longitudinal"),
            (OTHERS, false) => format!("{OTHERS}, lateral"),
            (name, _) => name.to_owned(),
        };
        ChartSeries::new(name, points, if longitudinal { Look::Circles } else { Look::Crosses }, i.min(named))
    });
    let left_out = if gone == 0 { String::new() } else { format!("; {gone} below {GONE} left out") };
    let across = format!("real part of the multiplier; o longitudinal, × lateral{left_out}");
    let chart = Chart {
        title: String::new(),
        x: ChartAxis::new(across).over(-reach, reach),
        y: ChartAxis::new("imaginary part").over(-reach, reach),
        series: std::iter::once(circle).chain(modes).collect(),
        passes: None,
    };
    Ok(grid("multipliers", vec![chart], 1, style::WIDTH))
}

/// Power, frequency, stall shares, multiplier, clearance and held commands over the parameter of a family: the column that is
/// named by a key of the scenario, or what of the course changes.
///
/// Needs `speed_m_s`, `climb_m_s`, `bank_deg`, `power_w_kg`, `frequency_hz`, `stall_fraction_12`, `stall_fraction_20`,
/// `largest_multiplier`.
pub fn family(record: &Record) -> Result<Figure, Error> {
    let parameters = [("speed_m_s", "speed [m/s]"), ("climb_m_s", "climb [m/s]"), ("bank_deg", "bank [°]")];
    let mut along: (&[f64], &str) = (needed(record, "speed_m_s")?, "speed [m/s]");
    for (name, label) in parameters {
        let values = needed(record, name)?;
        if values.iter().any(|v| (v - values[0]).abs() > 1e-12) {
            along = (values, label);
        }
    }
    if let Some(key) = record.columns().iter().find(|column| column.name.contains('.')) {
        along = (&key.values, &key.name);
    }
    let points = |name: &str| -> Result<Vec<(f64, f64)>, Error> {
        Ok(along.0.iter().copied().zip(needed(record, name)?.iter().copied()).collect())
    };
    let chart = |label: &str, series: Vec<ChartSeries>| Chart {
        title: String::new(),
        x: ChartAxis::new(along.1),
        y: ChartAxis::new(label),
        series,
        passes: None,
    };
    let one = |name: &str, label: &str| -> Result<Chart, Error> {
        Ok(chart(label, vec![ChartSeries::new("", points(name)?, Look::Line, 0)]))
    };
    let mut charts = vec![one("power_w_kg", "power [W/kg]")?, one("frequency_hz", "frequency [Hz]")?];
    charts.push(chart(
        "share of U²c beyond an angle of attack",
        vec![
            ChartSeries::new("beyond 12°", points("stall_fraction_12")?, Look::Line, 0),
            ChartSeries::new("beyond 20°", points("stall_fraction_20")?, Look::Dashed, 1),
        ],
    ));
    charts.push(one("largest_multiplier", "largest multiplier but the heading's")?);
    let clear = record.values("least_clearance_m").filter(|values| values.iter().any(|v| v.is_finite()));
    if let Some(values) = clear {
        let points = along.0.iter().copied().zip(values.iter().map(|v| 1e3 * v)).collect();
        charts.push(chart("least clearance [mm]", vec![ChartSeries::new("", points, Look::Line, 0)]));
    }
    let commands: Vec<&Column> = record
        .columns()
        .iter()
        .filter(|column| column.name.starts_with("command_") && column.values.iter().any(|v| v.abs() > 1e-9))
        .collect();
    let mut units: Vec<&str> = commands.iter().map(|column| column.unit.as_str()).collect();
    units.dedup();
    for (n, unit) in units.iter().enumerate().filter(|(n, unit)| !units[..*n].contains(unit)) {
        let own = commands.iter().filter(|column| column.unit == *unit).enumerate();
        let series = own.map(|(i, column)| {
            let name = column.name.trim_start_matches("command_").replace('_', " ");
            let points = along.0.iter().copied().zip(column.values.iter().copied()).collect();
            let look = if i % 2 == 0 { Look::Line } else { Look::Dashed };
            ChartSeries::new(name, points, look, 2 + n + i)
        });
        let label = if unit.is_empty() { "held commands".into() } else { format!("held commands [{unit}]") };
        charts.push(chart(&label, series.collect()));
    }
    Ok(grid("family", charts, 2, HEIGHT))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(names: &[&str]) -> Record {
        let column = |(i, name): (usize, &&str)| {
            let values = (0..3).map(|k| (k + i) as f64).collect();
            Column { values, ..Column::new(*name, "", "") }
        };
        Record::new(names.iter().enumerate().map(column).collect(), 0).unwrap()
    }

    #[test]
    fn the_figures_are_drawn_from_what_they_need_and_refuse_less() {
        let cycle =
            ["t", "pitch", "joint_power", "incidence_0", "arm_left", "torque_arm_left", "clearance_wing"];
        assert_eq!(orbit(&record(&cycle)).unwrap().name, "orbit");
        assert!(matches!(orbit(&record(&cycle[..3])), Err(Error::Column(_))));
        let modes = ["multiplier_re", "multiplier_im", "lateral"];
        assert_eq!(multipliers(&record(&modes)).unwrap().name, "multipliers");
        let orbits = [
            "climb_m_s",
            "speed_m_s",
            "bank_deg",
            "power_w_kg",
            "frequency_hz",
            "stall_fraction_12",
            "stall_fraction_20",
            "largest_multiplier",
            "command_twist_left",
        ];
        assert_eq!(family(&record(&orbits)).unwrap().name, "family");
        let told = |unit: &str| {
            let named = |column: &Column| match column.name.starts_with("command_") {
                true => Column { unit: unit.into(), ..column.clone() },
                false => column.clone(),
            };
            let columns = record(&orbits).columns().iter().map(named).collect();
            family(&Record::new(columns, 0).unwrap()).unwrap().svg()
        };
        assert!(told("rad").contains("held commands [rad]") && !told("").contains("held commands ["));
        assert!(matches!(family(&record(&modes)), Err(Error::Column(_))));
    }
}

//! The commands to the regulators with their limits.

use wingbeat::simulate::{Column, Record};

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Every `command_<element>` over time, angles in degrees, left and right of a pair in one panel, limits shaded;
/// what follows it, `displacement_<element>` or of a command to the rate `rate_<element>`, is drawn paler where it is there.
pub fn commands(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let commands: Vec<&Column> =
        record.columns().iter().filter(|column| column.name.starts_with("command_")).collect();
    if commands.is_empty() {
        return Err(Error::Column("command_<element>".into()));
    }
    let mut panels: Vec<FigurePanel> = Vec::new();
    for command in commands {
        let element = command.name.trim_start_matches("command_");
        let (group, side) = pair(element);
        let (unit, scale) = match command.unit.as_str() {
            "rad" => ("°", 1.0_f64.to_degrees()),
            "rad/s" => ("°/s", 1.0_f64.to_degrees()),
            other => (other, 1.0),
        };
        let drawn = |column: &Column| column.values.iter().map(|value| scale * value).collect::<Vec<f64>>();
        let names = ["displacement", "rate"].map(|what| format!("{what}_{element}"));
        let follows = |column: &&Column| names.contains(&column.name) && column.unit == command.unit;
        let response = record.columns().iter().find(follows);
        // An actuator beside the joint of its name.
        let title = if response.is_some() { format!("{group} regulator") } else { group };
        let panel =
            panel_of(&mut panels, &labelled(&title, unit), [command.low, command.high].map(|x| scale * x));
        let index = style::SIDES.iter().find(|(name, _)| *name == side).map_or(0, |(_, index)| *index);
        let of_side = |what: &str| if side == "command" { what.into() } else { format!("{side}, {what}") };
        if let Some(response) = response {
            let follows = PanelCurve::new(of_side("response"), t, drawn(response), index);
            panel.curves.push(PanelCurve { colour: style::tint(index), weight: style::BROAD, ..follows });
        }
        let commanded = PanelCurve::new(of_side("command"), t, drawn(command), index);
        panel.curves.push(PanelCurve { weight: style::FINE, ..commanded });
    }
    Ok(Figure::new("commands", stacked(panels, "time [s]", 0.9 * style::PANEL)))
}

/// Whether anything is commanded: a flight on an orbit holds all commands at zero.
pub fn commanded(record: &Record) -> bool {
    let mut commands = record.columns().iter().filter(|column| column.name.starts_with("command_"));
    commands.any(|column| column.values.iter().any(|value| *value != 0.0))
}

/// The panel called `title` with the command's limits; a new one when there is none.
fn panel_of<'a>(panels: &'a mut Vec<FigurePanel>, title: &str, [low, high]: [f64; 2]) -> &'a mut FigurePanel {
    let limits = (low.is_finite() && high.is_finite()).then_some((low, high));
    let found = panels.iter().position(|panel| panel.title == title && panel.limits == limits);
    let index = found.unwrap_or_else(|| {
        panels.push(FigurePanel { limits, ..FigurePanel::new(title, Vec::new()) });
        panels.len() - 1
    });
    &mut panels[index]
}

/// The element without its side, and the side; an element without one is its own.
pub(crate) fn pair(element: &str) -> (String, &str) {
    let sides = ["left", "right"];
    let found =
        sides.iter().find_map(|side| Some((element.strip_suffix(side)?.trim_end_matches('_'), *side)));
    match found {
        Some((group, side)) if !group.is_empty() => (group.replace('_', " "), side),
        _ => (element.replace('_', " "), "command"),
    }
}

fn labelled(group: &str, unit: &str) -> String {
    if unit.is_empty() { group.into() } else { format!("{group} [{unit}]") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_share_a_panel() {
        assert_eq!(pair("tip_twist_left"), ("tip twist".into(), "left"));
        assert_eq!(pair("sweep"), ("sweep".into(), "command"));
    }
}

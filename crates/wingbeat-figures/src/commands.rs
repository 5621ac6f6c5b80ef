//! The commands to the regulators with their limits.

use wingbeat::simulate::{Column, Record};

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Every `command_<element>` over time, left and right of a pair in one panel, limits shaded;
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
        let panel = panel_of(&mut panels, &labelled(&group, &command.unit), command);
        let index = style::SIDES.iter().find(|(name, _)| *name == side).map_or(0, |(_, index)| *index);
        let names = ["displacement", "rate"].map(|what| format!("{what}_{element}"));
        let follows = |column: &&Column| names.contains(&column.name) && column.unit == command.unit;
        if let Some(response) = record.columns().iter().find(follows) {
            let follows = PanelCurve::new(format!("{side}, response"), t, response.values.clone(), index);
            panel.curves.push(PanelCurve { colour: style::tint(index), weight: style::BROAD, ..follows });
        }
        let name = if side == "command" { side.into() } else { format!("{side}, command") };
        let commanded = PanelCurve::new(name, t, command.values.clone(), index);
        panel.curves.push(PanelCurve { weight: style::FINE, ..commanded });
    }
    Ok(Figure::new("commands", stacked(panels, "time [s]", 0.9 * style::PANEL)))
}

/// The panel called `title` with the command's limits; a new one when there is none.
fn panel_of<'a>(panels: &'a mut Vec<FigurePanel>, title: &str, command: &Column) -> &'a mut FigurePanel {
    let limits = (command.low.is_finite() && command.high.is_finite()).then_some((command.low, command.high));
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

//! What a run says of webs that no model has, and of twists that nothing spreads over a length of the span.

use super::HingeSpec;
use wingbeat_aero::{Aero, Preset};
use wingbeat_flight::tether::HingeKind;
use wingbeat_judge::Warning;
use wingbeat_robot::{Robot, RobotSpec};

/// The warning that a twist is open at `key`, if one of `models` has strips: without a web the shipped gaits took 6 to 30 % more power
/// with 32 strips than with 9 (`robot.web`).
fn open_twist<'a>(key: String, models: impl IntoIterator<Item = &'a Aero>) -> Option<Warning> {
    models.into_iter().find(|model| model.preset() == Preset::Full)?;
    let text = "the strip beside a twist closes it within its own width, so loads and power depend on the number of strips: without a web the shipped gaits took 6 to 30 % more power with 32 than with 9";
    Some(Warning::new("aero.open_twist", text.to_owned()).key(key))
}

/// The warning that a web of `robot`, which was built of `spec`, has no effect: nodes of preset `paper` ride on rigid panels.
pub(super) fn unheard(spec: &RobotSpec, robot: &Robot) -> Option<Warning> {
    spec.surfaces.iter().find_map(|surface| {
        let (_, aero) = robot.surfaces().find(|(name, _)| *name == surface.name)?;
        let preset = Some(aero.preset()).filter(|preset| *preset != Preset::Full)?;
        let k = surface.panels.iter().position(|panel| panel.web_m > 0.0)?;
        let key = format!("robot.surfaces.{}.panels[{k}].web_m", surface.name);
        let text = format!(
            "{key} = {} has no effect: preset `{}` lacks the term",
            surface.panels[k].web_m,
            preset.name()
        );
        Some(Warning::new("aero.unheard", text).key(key))
    })
}

/// That of a robot: a panel rides on a link that turns about the span against that of the panel before, and has no web.
pub(super) fn of_robot<'a>(robot: &RobotSpec, models: impl IntoIterator<Item = &'a Aero>) -> Option<Warning> {
    // A one-sided surface names one of a pair of links.
    let pair = |name: &str| {
        ["_left", "_right"].into_iter().find_map(|side| Some(name.strip_suffix(side)?.to_owned()))
    };
    let named = |name: &str| robot.links.iter().find(|link| link.name == name);
    let link = |name: &str| named(name).or_else(|| named(&pair(name)?));
    let key = robot.surfaces.iter().find_map(|surface| {
        let open = |k: &usize| {
            let [from, to] = [k - 1, *k].map(|k| link(&surface.panels[k].link));
            let way = std::iter::successors(to, |of| link(&of.parent));
            let about_span = |axis: [f64; 3]| axis[1].abs() > axis[0].hypot(axis[2]);
            let until = from.map(|from| &from.name);
            let turns = way.take_while(|of| Some(&of.name) != until).any(|of| about_span(of.axis));
            turns && surface.panels[*k].web_m == 0.0
        };
        let k = (1..surface.panels.len()).find(open)?;
        Some(format!("robot.surfaces.{}.panels[{k}].web_m", surface.name))
    })?;
    open_twist(key, models)
}

/// That of a tethered wing: a twist out on the half wing that does not grow along the span.
pub(super) fn of_hinges(hinges: &[HingeSpec], model: &Aero) -> Option<Warning> {
    let open =
        |hinge: &HingeSpec| hinge.kind == HingeKind::Twist && hinge.to_arc_m.is_none() && hinge.arc_m > 0.0;
    let k = hinges.iter().position(open)?;
    open_twist(format!("wing.hinges[{k}].to_arc_m"), [model])
}

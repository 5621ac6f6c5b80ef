//! The regulators of the structure: their channels, limits and reach.

use super::joints::Placed;
use super::spec::{RegulatorSpec, StructureSpec};
use wingbeat_math::Error;
use wingbeat_ocp::plant::{Channel, Role};

/// Finite limits, low below high.
pub(super) fn range(low: Option<f64>, high: Option<f64>) -> Result<[f64; 2], Error> {
    match (low, high) {
        (Some(low), Some(high)) if low < high && low.is_finite() && high.is_finite() => Ok([low, high]),
        (low, _) => {
            let given = low.map_or("missing".into(), |low| low.to_string());
            Err(Error::invalid("low", given, "a finite number below that of high").against(["high"]))
        }
    }
}

/// The regulators' channels, the only home of the stroke limits: those of the file, or without any one of
/// each element with the limits of the element.
pub(super) fn channels(spec: &StructureSpec, elements: &[Placed]) -> Result<Vec<Channel>, Error> {
    let channel = |name: &str, unit, [low, high]: [f64; 2], i| {
        Channel::limited(format!("command_{name}"), unit, "", low, high).of(Role::Command(i))
    };
    if spec.regulators.is_empty() {
        let own = |(i, e): (usize, &Placed)| {
            let limits = e.limits.map_or_else(|| range(None, None), Ok);
            let limits = limits.map_err(|error| error.within(&format!("elements[{i}]")))?;
            Ok(channel(&e.name, e.units[2], limits, i))
        };
        return elements.iter().enumerate().map(own).collect();
    }
    let placed = |(i, r): (usize, &RegulatorSpec)| {
        let moved: Vec<(&Placed, f64)> = r
            .elements
            .iter()
            .filter_map(|(name, gain)| Some((&elements[spec.place(name)?], *gain)))
            .collect();
        let limits = limits(r, &moved).map_err(|e| e.within(&format!("regulators[{i}]")))?;
        let first = elements.iter().find(|e| moved.iter().any(|(m, _)| m.name == e.name));
        Ok(channel(&r.name, first.map_or("", |e| e.units[2]), limits, i))
    };
    spec.regulators.iter().enumerate().map(placed).collect()
}

/// Limits of a regulator's command: its own, or those that keep each element it moves within its limits.
fn limits(regulator: &RegulatorSpec, moved: &[(&Placed, f64)]) -> Result<[f64; 2], Error> {
    let given = [("low", regulator.low), ("high", regulator.high)];
    let given = given.into_iter().find_map(|(key, value)| Some((key, value?)));
    let limited = || moved.iter().filter_map(|(e, gain)| Some((e, e.limits?.map(|limit| limit / gain))));
    if let (Some((key, value)), Some((element, _))) = (given, limited().next()) {
        let allowed = format!("no limits here: element {} has its own", element.name);
        return Err(Error::invalid(key, value, allowed));
    }
    if given.is_some() || moved.is_empty() || limited().count() < moved.len() {
        return range(regulator.low, regulator.high);
    }
    let tighter = |[low, high]: [f64; 2], [a, b]: [f64; 2]| [low.max(a.min(b)), high.min(a.max(b))];
    let [low, high] = limited().fold([f64::NEG_INFINITY, f64::INFINITY], |all, (_, own)| tighter(all, own));
    if low < high {
        return Ok([low, high]);
    }
    let names = moved.iter().map(|(e, _)| e.name.as_str()).collect::<Vec<_>>().join(", ");
    Err(Error::invalid("elements", names, "elements whose limits one command can keep"))
}

/// How far held commands within their limits displace each element: its own limits where it has some, by
/// the placement where not; not limited where full matrices hide it.
pub(super) fn strokes(spec: &StructureSpec, elements: &[Placed], regulators: &[Channel]) -> Vec<[f64; 2]> {
    let placement = spec.placement();
    let reach = |i: usize| match &placement {
        None => [f64::NEG_INFINITY, f64::INFINITY],
        Some(rows) => rows[i].iter().zip(regulators).fold([0.0; 2], |[low, high], (gain, channel)| {
            let (a, b) = (gain * channel.low, gain * channel.high);
            if *gain == 0.0 { [low, high] } else { [low + a.min(b), high + a.max(b)] }
        }),
    };
    elements.iter().enumerate().map(|(i, e)| e.limits.unwrap_or_else(|| reach(i))).collect()
}

//! Surfaces of a robot in the motion of a recorded flight.

use crate::layout::PanelLayout;
use crate::motion::{LatticeSurface, MovingSections, Panels, Scene, require_flat};
use crate::skin::SurfaceEdges;
use crate::{Error, RecordError};
use std::sync::Arc;
use wingbeat::aero::{ChordBend, Circulation, SectionMotion};
use wingbeat::math::interpolation::{hermite, piecewise_linear};
use wingbeat::math::{Dual, Vec3};
use wingbeat::plant::Plant;
use wingbeat::robot::{Observation, Robot, SurfaceOutline};
use wingbeat::simulate::Record;

/// A stretch of a recorded flight. Between two rows the states are the cubic through both with the rates that the robot has there.
#[derive(Clone, Debug)]
pub struct FlightStretch {
    robot: Robot,
    times: Vec<f64>,
    states: Vec<Vec<f64>>,
    rates: Vec<Vec<f64>>,
    inputs: Vec<Vec<f64>>,
}

impl FlightStretch {
    /// The flight of `robot` in `record` from `from_s` to `to_s`.
    ///
    /// # Errors
    /// A record without the robot's states and inputs, times that do not ascend, a stretch that lies outside of it, or states in
    /// which the robot cannot be.
    pub fn new(robot: &Robot, record: &Record, from_s: f64, to_s: f64) -> Result<Self, Error> {
        let column = |name: &str| record.values(name).ok_or(RecordError::Column { name: name.into() });
        let t = column("t")?;
        if !t.windows(2).all(|pair| pair[0] < pair[1]) {
            return Err(RecordError::Times.into());
        }
        let [Some(first), Some(last)] = [t.first(), t.last()] else {
            return Err(RecordError::Times.into());
        };
        // Rounding of a time must not put it outside.
        let same = 1e-9 * (last - first);
        if !(from_s >= first - same && to_s <= last + same && from_s < to_s) {
            return Err(RecordError::Outside { from_s, to_s, first: *first, last: *last }.into());
        }
        let all = |channels: &[wingbeat::plant::Channel]| -> Result<Vec<&[f64]>, RecordError> {
            channels.iter().map(|channel| column(&channel.name)).collect()
        };
        let (states, inputs) = (all(robot.states())?, all(robot.inputs())?);
        let begin = t.partition_point(|t| *t <= from_s + same).saturating_sub(1);
        let end = (t.partition_point(|t| *t < to_s - same) + 1).min(t.len());
        let row = |columns: &[&[f64]], i: usize| columns.iter().map(|column| column[i]).collect::<Vec<f64>>();
        let mut flight = Self {
            robot: robot.clone(),
            times: t[begin..end].to_vec(),
            states: (begin..end).map(|i| row(&states, i)).collect(),
            rates: Vec::with_capacity(end - begin),
            inputs: (begin..end).map(|i| row(&inputs, i)).collect(),
        };
        for ((t, x), u) in flight.times.iter().zip(&flight.states).zip(&flight.inputs) {
            let mut dx = vec![0.0; x.len()];
            robot
                .rates_in_numbers(*t, x, u, &mut dx)
                .map_err(|fault| RecordError::Fault(fault.to_string()))?;
            flight.rates.push(dx);
        }
        Ok(flight)
    }

    /// The row before `t`.
    fn row(&self, t: f64) -> usize {
        let last = self.times.len().saturating_sub(2);
        self.times.partition_point(|time| *time <= t).saturating_sub(1).min(last)
    }

    /// The states at `t` s, in the units of their channels.
    pub fn state(&self, t: f64) -> Vec<f64> {
        let i = self.row(t);
        (0..self.states[i].len()).map(|k| self.moving(t, i, k)[0]).collect()
    }

    /// The state number `k` at `t` s, after the row `i`, with its rate.
    fn moving(&self, t: f64, i: usize, k: usize) -> [f64; 2] {
        let Some(h) = self.times.get(i + 1).map(|next| next - self.times[i]) else {
            return [self.states[i][k], self.rates[i][k]];
        };
        let of = |rows: &[Vec<f64>]| [rows[i][k], rows[i + 1][k]];
        hermite(t - self.times[i], h, of(&self.states), of(&self.rates)).into()
    }

    /// What bends the chords of the surface number `surface` at `t` s, each with its rate: dimensionless and rad, 1/s and rad/s.
    fn bent(&self, t: f64, surface: usize) -> Vec<[f64; 2]> {
        let i = self.row(t);
        self.robot.bent_states_of(surface).map(|k| self.moving(t, i, k)).collect()
    }

    /// Place of the body's origin, m, and its velocity, m/s, in W at `t` s.
    pub fn body(&self, t: f64) -> (Vec3, Vec3) {
        let (x, layout) = (self.state(t), self.robot.layout());
        (Vec3::from_slice(&x[layout.position..]), Vec3::from_slice(&x[layout.velocity..]))
    }

    /// All there is to see of the robot at `t` s, its loads by the model that flew; none where it cannot be.
    pub fn observe(&self, t: f64) -> Option<Observation> {
        self.robot.observe(t, &self.state(t), &self.inputs[self.row(t)]).ok()
    }

    /// Bound circulations (m2/s) of the model that flew at `t` s, on the strips of the surfaces `layouts`; none where it cannot be.
    ///
    /// # Errors
    /// A model whose circulation is a sum of lags.
    pub fn circulations(&self, t: f64, layouts: &[(usize, PanelLayout)]) -> Result<Option<Vec<f64>>, Error> {
        if let Some((name, _)) = self.robot.surfaces().find(|(_, a)| a.circulation() == Circulation::LagSum) {
            return Err(RecordError::LagSum { surface: name.into() }.into());
        }
        let Some(seen) = self.observe(t) else { return Ok(None) };
        let (mut first, mut tables) = (0, Vec::new());
        for (_, aero) in self.robot.surfaces() {
            let places = aero.strip_arcs().iter().enumerate();
            // Nothing is bound at the tips.
            let tip = aero.arcs().iter().fold(0.0_f64, |tip, arc| tip.max(arc.abs()));
            let strips = places.map(|(i, arc)| (*arc, seen.strips.circulation[first + i]));
            let mut table: Vec<(f64, f64)> = [(-tip, 0.0), (tip, 0.0)].into_iter().chain(strips).collect();
            wingbeat::math::order::ascend_by(&mut table, |item| item.0);
            tables.push(table.into_iter().unzip::<f64, f64, Vec<f64>, Vec<f64>>());
            first += aero.strips();
        }
        let on = |(surface, layout): &(usize, PanelLayout)| {
            let (arcs, values) = &tables[*surface];
            let middles = layout.arcs.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            middles.map(|arc| piecewise_linear(arcs, values, arc)).collect::<Vec<f64>>()
        };
        Ok(Some(layouts.iter().flat_map(on).collect()))
    }
}

/// A surface of the robot in flight; its clock begins at `from_s`.
struct FlownSurface {
    flight: Arc<FlightStretch>,
    edges: SurfaceEdges,
    from_s: f64,
}

impl MovingSections for FlownSurface {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let (t, robot) = (t + self.from_s, &self.flight.robot);
        self.edges.sections(robot, &robot.stance(t, &self.flight.state(t)), arcs, out);
    }

    fn bends(&self, t: f64, _: &[f64], out: &mut Vec<ChordBend<Dual<1>>>) {
        out.clear();
        if let Some(edges) = &self.edges.bends {
            edges.bends(&self.flight.bent(t + self.from_s, self.edges.surface), out);
        }
    }
}

/// Panels of the surfaces `outlines` of `robot` as `panels` says of the first; beside each the number of its surface.
pub(crate) fn laid(
    robot: &Robot,
    outlines: &[SurfaceOutline],
    panels: Panels,
) -> Result<Vec<(usize, PanelLayout)>, Error> {
    let mut layouts = Vec::new();
    let first = outlines.first().map_or(1.0, |outline| outline.planform.half_span());
    for (number, (outline, (_, aero))) in outlines.iter().zip(robot.surfaces()).enumerate() {
        require_flat(aero)?;
        let share = outline.planform.half_span() / first;
        // A strip at least for every piece between hinges and ends.
        let hinges = outline.hinges.iter().filter(|arc| **arc > 0.0);
        let least = 2 * (hinges.count() + outline.planform.gaps().len()) + 2;
        let strips = match number {
            0 => panels.spanwise,
            _ => ((panels.spanwise as f64 * share).round() as usize).max(least),
        };
        let Panels { chordwise, spacing, .. } = panels;
        let pieces = PanelLayout::of(&outline.planform, &outline.hinges, chordwise, strips, spacing)?;
        layouts.extend(pieces.into_iter().map(|piece| (number, piece)));
    }
    Ok(layouts)
}

impl Scene {
    /// The surfaces `outlines` of the robot of `flight` from `from_s` on, in the mean wind. The first surface has the strips that
    /// `panels` says, the others as many by their span. Beside the scene stand the number of the outline and the layout of each piece.
    ///
    /// # Errors
    /// Sections that lift at no incidence, panels that cannot be laid out.
    pub fn flown(
        flight: &Arc<FlightStretch>,
        outlines: &[SurfaceOutline],
        from_s: f64,
        density_kg_m3: f64,
        panels: Panels,
    ) -> Result<(Self, Vec<(usize, PanelLayout)>), Error> {
        let layouts = laid(&flight.robot, outlines, panels)?;
        let surface = |piece: &(usize, PanelLayout)| LatticeSurface {
            layout: piece.1.clone(),
            sections: Arc::new(FlownSurface {
                flight: flight.clone(),
                edges: SurfaceEdges::new(&flight.robot, piece),
                from_s,
            }),
        };
        let surfaces = layouts.iter().map(surface).collect();
        let wind = flight.robot.mean_wind();
        let ground = flight.robot.ground();
        Ok((Self { surfaces, wind, density_kg_m3, symmetric: false, ground }, layouts))
    }
}

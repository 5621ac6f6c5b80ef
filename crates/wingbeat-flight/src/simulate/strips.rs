//! Loads of a wing's strips over time, as a record.

use super::record::{Column, Record};
use wingbeat_aero::{Aero, Circulation, ForceDetail, LoadSource, Loads, SectionMotion};
use wingbeat_math::{Mat3, Vec3};

/// Axes of a vector, as they end the names of its columns.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// One row per strip and instant: where the strip is, what it meets, what it bears.
///
/// | column | unit | |
/// |---|---|---|
/// | `t`, `phase` | s, as the run counts it | instant |
/// | `strip`, `arc` | -, m | number from the left tip; arc of the control section, left positive |
/// | `circulation` or `circulation_lag_sum` | m2/s | see [`Circulation`](wingbeat_aero::Circulation) |
/// | `wash`, `incidence` | m/s, rad | along the normal at 3/4 chord; wash included |
/// | `force_*` | N | sum over the sources, then by [`LoadSource::STRIP`], in B |
/// | `moment_*` | N m | about the point at 1/4 chord, in B |
/// | `width` | m | along the arc |
/// | `quarter_chord_*` | m | point at 1/4 chord of the control section, from the origin of B, in B |
/// | `surface` | - | number of the surface, in the robot's order |
/// | `separated`, `suction_lost` | - | shares of flow and of linear leading-edge suction that the law takes away |
/// | `force_suction_*`, `force_vortex_*`, `force_separated_*` | N | parts of those of the sources: see [`ForceDetail`]; 0 where the loads do not tell them |
/// | `camber`, `camber_forward` | - | heights of a membrane over the chord, where a surface has one |
/// | `flap` | rad | angle of a flap, trailing edge down, where a surface has one |
/// | `chord`, `velocity_*`, `power` | m, m/s, W | of a recorder of [`moving`](Self::moving) strips: see [`StripMotion`] |
#[derive(Clone, Debug)]
pub struct StripRecorder {
    record: Record,
    /// Surface, number on it, arc and width (m) of each strip.
    strips: Vec<[f64; 4]>,
    /// Whether a surface has a membrane, and whether one has a flap.
    soft: [bool; 2],
    row: Vec<f64>,
}

/// How a strip moves, and what that costs.
#[derive(Clone, Copy, Debug)]
pub struct StripMotion {
    /// Chord of the control section, m.
    pub chord: f64,
    /// Velocity relative to still ground of its point at 1/4 chord, m/s, in the frame of the loads.
    pub velocity: Vec3,
    /// Power that the strip gives to the air, W.
    pub power: f64,
}

impl StripMotion {
    /// Of a control section, with the power of its strip, W.
    pub fn of(section: &SectionMotion<f64>, power: f64) -> Self {
        let velocity = section.v_le * 0.75 + section.v_te * 0.25;
        Self { chord: (section.le - section.te).norm(), velocity, power }
    }
}

impl StripRecorder {
    /// An empty record of the strips of all surfaces, whose models may be of different kinds, with room for `instants`;
    /// where one of them has a sum of lags, the column of the circulation is called after that; `phase_unit` is that of the column `phase`.
    pub fn new<'a>(surfaces: impl Iterator<Item = &'a Aero>, phase_unit: &str, instants: usize) -> Self {
        let surfaces: Vec<&Aero> = surfaces.collect();
        let of = |(surface, aero): (usize, &&'a Aero)| {
            let places = aero.strip_arcs().iter().zip(aero.widths()).enumerate();
            places.map(move |(i, (arc, width))| [surface as f64, i as f64, *arc, *width]).collect::<Vec<_>>()
        };
        let strips: Vec<[f64; 4]> = surfaces.iter().enumerate().flat_map(of).collect();
        // A sum of lags is no bound circulation beside one that is.
        let of_lags = surfaces.iter().find(|aero| aero.circulation() == Circulation::LagSum);
        let mut columns = columns(of_lags.map_or(Circulation::Bound, |aero| aero.circulation()), phase_unit);
        let soft = [
            surfaces.iter().any(|aero| aero.membrane().is_some()),
            surfaces.iter().any(|aero| aero.flap().is_some()),
        ];
        if soft[0] {
            columns.extend(["camber", "camber_forward"].map(|name| Column::new(name, "", "")));
        }
        if soft[1] {
            columns.push(Column::new("flap", "rad", ""));
        }
        Self::with(columns, (strips, soft), instants)
    }

    fn with(columns: Vec<Column>, (strips, soft): (Vec<[f64; 4]>, [bool; 2]), instants: usize) -> Self {
        Self {
            soft,
            row: Vec::with_capacity(columns.len()),
            // Refused are only two columns of one name.
            record: Record::new(columns, instants * strips.len()).unwrap_or_default(),
            strips,
        }
    }

    /// The same, still empty, with columns of how the strips move and room for `instants`.
    #[must_use]
    pub fn moving(self, instants: usize) -> Self {
        let mut columns = self.record.into_columns();
        columns.push(Column::new("chord", "m", ""));
        columns.extend(AXES.map(|a| Column::new(format!("velocity_{a}"), "m/s", "B")));
        columns.push(Column::new("power", "W", ""));
        Self::with(columns, (self.strips, self.soft), instants)
    }

    /// Appends the strips of all surfaces at an instant: `loads` are in a frame in which
    /// B has its origin at `origin` (m), and which `to_body` turns into B. `motion` has an entry per strip where the
    /// strips are [`moving`](Self::moving), else none.
    pub fn append(
        &mut self,
        [t, phase]: [f64; 2],
        loads: &Loads<f64>,
        motion: &[StripMotion],
        to_body: Mat3,
        origin: Vec3,
    ) {
        for (i, (strip, place)) in loads.strip[..loads.strips].iter().zip(&self.strips).enumerate() {
            let [surface, number, arc, width] = *place;
            let row = &mut self.row;
            row.clear();
            row.extend([t, phase, number, arc]);
            row.extend([loads.circulation[i], loads.wash[i], loads.incidence[i]]);
            row.extend((to_body * strip.total().force).0);
            row.extend(strip.parts().iter().flat_map(|part| (to_body * part.force).0));
            let about_point = strip.total().moment - loads.quarter_chord[i].cross(strip.total().force);
            row.extend((to_body * about_point).0);
            row.push(width);
            row.extend((to_body * (loads.quarter_chord[i] - origin)).0);
            row.extend([surface, loads.separated[i], loads.suction_lost[i]]);
            let detail = loads.detail.as_ref().map(|parts| parts[i]).unwrap_or_default();
            row.extend(detail.parts().iter().flat_map(|force| (to_body * *force).0));
            if self.soft[0] {
                row.extend([loads.camber[i], loads.camber_forward[i]]);
            }
            if self.soft[1] {
                row.push(loads.flap[i]);
            }
            if let Some(StripMotion { chord, velocity, power }) = motion.get(i) {
                row.push(*chord);
                row.extend((to_body * *velocity).0);
                row.push(*power);
            }
            self.record.append(row);
        }
    }

    /// The record.
    pub fn finish(self) -> Record {
        self.record
    }
}

fn columns(circulation: Circulation, phase_unit: &str) -> Vec<Column> {
    let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", phase_unit, "")];
    columns.extend(
        [("strip", ""), ("arc", "m"), (circulation.name(), "m2/s"), ("wash", "m/s"), ("incidence", "rad")]
            .map(|(name, unit)| Column::new(name, unit, "")),
    );
    columns.extend(AXES.map(|a| Column::new(format!("force_{a}"), "N", "B")));
    for source in LoadSource::STRIP {
        columns.extend(AXES.map(|a| Column::new(format!("force_{}_{a}", source.name()), "N", "B")));
    }
    columns.extend(AXES.map(|a| Column::new(format!("moment_{a}"), "N m", "B")));
    columns.push(Column::new("width", "m", ""));
    columns.extend(AXES.map(|a| Column::new(format!("quarter_chord_{a}"), "m", "B")));
    columns.extend(["surface", "separated", "suction_lost"].map(|name| Column::new(name, "", "")));
    columns.extend(detail_columns());
    columns
}

/// Columns of the parts of the forces that the sources do not tell apart.
pub(crate) fn detail_columns() -> impl Iterator<Item = Column> {
    let of = |part| AXES.map(|a| Column::new(format!("force_{part}_{a}"), "N", "B"));
    ForceDetail::<f64>::NAMES.into_iter().flat_map(of)
}

//! Figures of records and of comparisons: PNG and SVG.
//!
//! A figure of a record needs only the columns it names; where one is missing, the figure says which.

pub mod animation;
mod attitude;
mod average;
mod bench;
pub mod calibration;
mod canvas;
pub mod chart;
mod clouds;
mod commands;
mod cycle;
mod deformation;
mod end_points;
mod error;
mod estimate;
mod followed;
mod force_moment;
mod forces;
mod gait;
mod hover;
mod joints;
mod map;
mod orbit;
mod overlaid;
mod own_joints;
mod panel;
mod path;
mod plot_frame;
mod processing;
mod raster;
mod robustness;
mod scale;
mod search;
mod show;
pub mod space;
mod starts;
mod states;
mod strokes;
mod style;
mod tether;
mod wake;
mod weight;
mod write;

pub use attitude::TurnsOfBody;
pub use average::{DEVIATION, averaged};
pub use bench::{comparison, convergence};
pub use commands::commands;
pub use deformation::{camber, flap};
pub use end_points::{EndPoints, end_points};
pub use error::Error;
pub use estimate::estimate;
pub use followed::{ground, tracking};
pub use force_moment::force_moment;
pub use forces::{drawn_forces, forces, forces_since};
pub use gait::gait;
pub use hover::hover;
pub use joints::joint_histories;
pub use map::map;
pub use orbit::{family, multipliers, orbit};
pub use overlaid::{MOST_PANELS, OverlaidQuantity, overlaid};
pub use path::path;
pub use processing::{CellOrigin, cycles, filtered};
pub use robustness::{UndrawnLimit, robustness};
pub use search::convergence_of_search;
pub use show::Drawing;
pub use starts::starts;
pub use states::{states, states_wide};
pub use tether::{bent_wing, cycle_loads, span_loading};
pub use wake::{PlaneCut, WakeSheet, around, frontal_planes, half_circulations, wake, wake_phases};
pub use write::{Figure, prepare, write, write_for_screen, write_slide};

use wingbeat::robot::Robot;
use wingbeat::scenario::{GoalSpec, PaperResults};
use wingbeat::simulate::Record;

/// What flies, what a scenario asks of it and what is published of it, where it says.
#[derive(Clone, Copy, Default)]
pub struct FigureTargets<'a> {
    /// The robot, whose lift laws name their forces.
    pub robot: Option<&'a Robot>,
    /// What counts as held.
    pub goal: Option<&'a GoalSpec>,
    /// Published numbers.
    pub paper: Option<&'a PaperResults>,
    /// Time at which a plan begins, s, before which the record shows the flight that leads to it.
    pub plan_start_s: Option<f64>,
}

/// What draws a figure of a record.
pub type FigureMaker = fn(&Record, FigureTargets) -> Result<Figure, Error>;

/// The figures of a flight.
pub const FLIGHT: [FigureMaker; 4] = [
    states,
    |record, asked| path(record, asked.paper),
    |record, _| commands(record),
    |record, asked| forces_since(record, asked.plan_start_s),
];

/// Those of what gives way, likewise.
const DEFORMATION: [(&str, FigureMaker); 2] =
    [("camber_0", |record, _| camber(record)), ("flap_0", |record, _| flap(record))];

/// With what the name of a command's column begins.
const COMMANDS: &str = "command_";

// A figure of a flight is a file of its own, its name among the modules above, and its line here.
/// Figures of flights in their order, each with what the name of a column begins with that a record must have for it, after the name of its surface where that ends in 0.
const OF_FLIGHTS: &[(&str, FigureMaker)] = &[
    ("", FLIGHT[0]),
    ("", FLIGHT[1]),
    (COMMANDS, FLIGHT[2]),
    ("", FLIGHT[3]),
    ("estimate_t", |record, _| estimate(record)),
    DEFORMATION[0],
    DEFORMATION[1],
    ("path_arc", |record, _| ground(record)),
    ("path_arc", |record, _| tracking(record)),
    ("hover_error_x", |record, _| hover(record)),
];

/// The figures of the flight that `record` is of: without commands where nothing is commanded, with an estimator
/// what it knew, along a path how it was followed, in a hover how still it was, of membranes and flaps how they gave way.
pub fn of_flight(record: &Record) -> Vec<FigureMaker> {
    can_draw(record, OF_FLIGHTS)
}

/// The figures of what gives way in the flight that `record` is of: membranes and flaps.
pub fn of_deformation(record: &Record) -> Vec<FigureMaker> {
    can_draw(record, &DEFORMATION)
}

/// Those `figures` for which `record` has a column.
fn can_draw(record: &Record, figures: &[(&str, FigureMaker)]) -> Vec<FigureMaker> {
    let of_later_surface =
        |name: &str, of: &str| name.strip_suffix(of).is_some_and(|rest| rest.ends_with('_'));
    let has = |begin: &str| {
        let mut names = record.columns().iter().map(|column| column.name.as_str());
        names.any(|name| name.starts_with(begin) || (begin.ends_with("_0") && of_later_surface(name, begin)))
    };
    let drawn = |begin: &str| has(begin) && (begin != COMMANDS || commands::commanded(record));
    figures.iter().filter(|(begin, _)| drawn(begin)).map(|(_, draw)| *draw).collect()
}

/// The figures of a planned gait.
pub const GAIT: [FigureMaker; 3] =
    [|record, _| gait(record), |record, _| commands(record), |record, _| forces(record)];

/// The numbers of a column that a figure needs.
fn needed<'a>(record: &'a Record, name: &str) -> Result<&'a [f64], Error> {
    record.values(name).ok_or_else(|| Error::Column(name.into()))
}

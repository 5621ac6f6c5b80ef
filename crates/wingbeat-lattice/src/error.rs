//! Why a lattice could not be built or stepped.

/// Why a lattice could not be built or stepped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting that is not allowed.
    #[error("{key} = {value}: allowed is {allowed}")]
    Setting {
        /// Name of the setting.
        key: &'static str,
        /// The value given, in the unit of the setting.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
    /// A part of a wing or of its sections that bends.
    #[error("{key}: allowed is none: the panels are rigid")]
    Bent {
        /// Key of the part.
        key: &'static str,
    },
    /// A flap over part of the span: panels beside its end would share its inertia with what does not turn.
    #[error(
        "flap: allowed is one from root to tip, as panels beside the end of a shorter one lose part of its inertia"
    )]
    FlapEnds,
    /// A wake of too many rings.
    #[error(
        "cycles times steps times spanwise panels are {rings} rings of the wake: allowed are at most {most}"
    )]
    Rings {
        /// How many.
        rings: usize,
        /// How many may be.
        most: usize,
    },
    /// A half of a wing, beside which the lattice has no mirror.
    #[error("wing.side = {side}: allowed is both, whose lattice is whole")]
    Half {
        /// The half.
        side: &'static str,
    },
    /// Panels cannot be laid out on the wing.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A record that tells no motion.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Panels that lie on one another, or one without area: the strengths are not determined.
    #[error(
        "at t = {time} s the panels do not determine their circulations: surfaces touch or a panel has no area"
    )]
    Singular {
        /// Time, s.
        time: f64,
    },
    /// A number that is not finite.
    #[error("at t = {time} s the {what} is not finite")]
    NotFinite {
        /// Time, s.
        time: f64,
        /// What is not finite.
        what: &'static str,
    },
}

/// What the library said when panels were laid out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct LayoutError(pub String);

impl From<wingbeat::Error> for Error {
    fn from(error: wingbeat::Error) -> Self {
        Self::Layout(LayoutError(error.to_string()))
    }
}

/// Why a record tells no motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// A column is missing.
    #[error("the record has no column {name}: needed are t, the states and the inputs of the robot")]
    Column {
        /// Its name.
        name: String,
    },
    /// There are no times, or they do not ascend.
    #[error("the record's column t does not ascend")]
    Times,
    /// A stretch that was not recorded.
    #[error("{from_s} s to {to_s} s: allowed are times within {first} s to {last} s, which the record holds")]
    Outside {
        /// Begin of the stretch, s.
        from_s: f64,
        /// Its end, s.
        to_s: f64,
        /// First time of the record, s.
        first: f64,
        /// Its last, s.
        last: f64,
    },
    /// More cycles than were recorded.
    #[error("{cycles} cycles until {to_s} s: the record holds {first} to {last} s")]
    Cycles {
        /// How many.
        cycles: usize,
        /// Where they would end, s.
        to_s: f64,
        /// First time of the record, s.
        first: f64,
        /// Its last, s.
        last: f64,
    },
    /// A state in which the robot cannot be.
    #[error("the record does not fit the robot: {0}")]
    Fault(String),
    /// A model without a bound circulation.
    #[error(
        "the model of surface {surface:?} has a sum of wash lags and no bound circulation: allowed are preset paper and preset \
         full with five lags"
    )]
    LagSum {
        /// Its surface.
        surface: String,
    },
}

//! What a controller and a simulator need to know of a system: its states and
//! inputs by name, its rates, and their exact derivatives. Nothing here knows a wing.

mod chart;
mod known;
mod linearise;

pub use chart::{GivenMotion, LocalChart};
pub use known::Known;
pub use linearise::{Early, Late, Linearisation};

use std::ops::Range;
use wingbeat_math::{Double4, Lanes, Over, Scalar, Single8, lift};

/// What a channel means, whatever its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// Nothing that others need to know.
    #[default]
    Other,
    /// Component of the position p_WB along an axis of W: 0, 1, 2.
    Position(usize),
    /// Component of the attitude quaternion q_WB: w, x, y, z.
    Attitude(usize),
    /// Component of a rotation vector in place of the quaternion, along an axis of B.
    Rotation(usize),
    /// Component of the velocity v_WB_W along an axis of W.
    Velocity(usize),
    /// Component of the angular rate w_WB_B along an axis of B.
    AngularRate(usize),
    /// Displacement of a structure element, by its number.
    Displacement(usize),
    /// Rate of a structure element's displacement, by its number.
    DisplacementRate(usize),
    /// Coordinate of an elastic or free joint, by its number among them.
    Coordinate(usize),
    /// Rate of that coordinate.
    CoordinateRate(usize),
    /// Angle of the crank under a motor.
    Crank,
    /// Rate of that crank.
    CrankRate,
    /// State of the air.
    Air,
    /// Command to a regulator of the structure, by its number.
    Command(usize),
}

impl Role {
    /// Place of the channel of this role.
    pub fn place(self, channels: &[Channel]) -> Option<usize> {
        channels.iter().position(|channel| channel.role == self)
    }
}

/// One named component of a state or input, with its meaning, unit, frame and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name, unique within its vector, e.g. `shoulder_left`.
    pub name: String,
    /// SI unit, e.g. `m/s`; empty when dimensionless.
    pub unit: &'static str,
    /// Frame in which the component is resolved, e.g. `W`; empty when it has none.
    pub frame: &'static str,
    /// Lower limit, in `unit`.
    pub low: f64,
    /// Upper limit, in `unit`.
    pub high: f64,
    /// What it means.
    pub role: Role,
}

impl Channel {
    /// A channel without limits.
    pub fn free(name: impl Into<String>, unit: &'static str, frame: &'static str) -> Self {
        Self::limited(name, unit, frame, f64::NEG_INFINITY, f64::INFINITY)
    }

    /// A channel limited to [low, high], both in `unit`.
    pub fn limited(
        name: impl Into<String>,
        unit: &'static str,
        frame: &'static str,
        low: f64,
        high: f64,
    ) -> Self {
        Self { name: name.into(), unit, frame, low, high, role: Role::Other }
    }

    /// The channel with its meaning.
    #[must_use]
    pub fn of(self, role: Role) -> Self {
        Self { role, ..self }
    }

    /// `value` limited to the channel's range, in its unit.
    #[inline]
    pub fn clamp<S: Scalar>(&self, value: S) -> S {
        value.clamped(self.low, self.high)
    }

    /// True when `value` lies on or beyond a limit, in its unit.
    pub fn saturated(&self, value: f64) -> bool {
        value <= self.low || value >= self.high
    }
}

/// Why a model could not be evaluated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A closed linkage came too close to the pose where it no longer assembles.
    #[error("linkage loop {closure}: singularity margin {margin:.5} is below {limit}")]
    LinkageSingular {
        /// Loop number, 1 to 3.
        closure: usize,
        /// 1 - |cos| of the loop's elbow, dimensionless.
        margin: f64,
        /// Smallest margin allowed, dimensionless.
        limit: f64,
    },
    /// The mass matrix is not positive definite.
    #[error("mass matrix is not positive definite at t = {time:.4} s")]
    MassMatrix {
        /// Time, s.
        time: f64,
    },
    /// The air beside the robot could not be stepped.
    #[error("at t = {time:.4} s the air beside the robot cannot be stepped: {why}")]
    Flow {
        /// Time, s.
        time: f64,
        /// Why.
        why: &'static str,
    },
    /// The equations of an elastic wing were not solved in a step.
    #[error("at t = {time:.4} s the equations of the bent wing are not solved: take more steps per cycle")]
    Structure {
        /// Time, s.
        time: f64,
    },
    /// A rate is not finite.
    #[error("state {state} has a rate that is not finite at t = {time:.4} s")]
    NotFinite {
        /// Index of the state.
        state: usize,
        /// Time, s.
        time: f64,
    },
    /// The eigenvalues of the change over a cycle were not found.
    #[error(
        "the {size} multipliers of the motion over a cycle are not found: it grows without bound, or does not settle"
    )]
    Multipliers {
        /// How many states.
        size: usize,
    },
    /// A number to be recorded is not finite.
    #[error("column {column} of the record is not finite at t = {time:.4} s")]
    NotRecorded {
        /// Index of the column.
        column: usize,
        /// Time, s.
        time: f64,
    },
}

impl Fault {
    /// True when the model went on to numbers that are none.
    pub fn is_not_finite(&self) -> bool {
        matches!(self, Self::NotFinite { .. } | Self::NotRecorded { .. })
    }
}

/// A dynamical system dx/dt = f(t, x, u).
pub trait Plant: Sync {
    /// The states, in order.
    fn states(&self) -> &[Channel];
    /// The inputs, in order. Their limits are the only copy of the stroke limits.
    fn inputs(&self) -> &[Channel];
    /// Index of the attitude quaternion q_WB (w, x, y, z) in the state, if any.
    fn attitude(&self) -> Option<usize> {
        None
    }
    /// Writes dx/dt. Pure, and allocates nothing after the first call of a thread.
    fn rates<S: Scalar>(&self, t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault>;

    /// The distances between parts that should not meet, in order; none where nothing can.
    fn clearances(&self) -> &[Channel] {
        &[]
    }
    /// Writes those distances, m, smooth in state and time and never above the true ones; negative where the parts pass through
    /// each other. Pure, and allocates nothing.
    fn clear<S: Scalar>(&self, _t: S, _x: &[S], _values: &mut [S]) -> Result<(), Fault> {
        Ok(())
    }

    /// States that no rate depends on, so that derivatives by them are zero and need no evaluation: the place of a robot in air
    /// that is alike everywhere. All of them come before the attitude and the late states.
    fn unfelt_states(&self) -> Range<usize> {
        0..0
    }

    /// States whose rates know only themselves and the inputs.
    fn driven_states(&self) -> Range<usize> {
        0..0
    }

    /// States between those and the late ones on which places depend, in ascending runs. Inputs and other states leave places
    /// as they are, so that derivatives by them need not follow what places alone decide: see
    /// [`rates_in_moving`](Self::rates_in_moving).
    fn placing_states(&self) -> [Range<usize>; 2] {
        [0..0, 0..0]
    }

    /// Writes the rates `dx` at (t, x, u), in the units of the states over s, and what is known of their derivatives without carrying them
    /// through the evaluation. False where nothing is.
    ///
    /// # Errors
    /// Those of [`rates`](Self::rates).
    fn known(
        &self,
        _t: f64,
        _x: &[f64],
        _u: &[f64],
        _dx: &mut [f64],
        _known: &mut Known,
    ) -> Result<bool, Fault> {
        Ok(false)
    }
    /// States after those that are not felt and before those that place, derivatives by which [`derive`](Self::derive) finds from others
    /// where the plant [knows](Self::known) some.
    fn derived_states(&self) -> Range<usize> {
        0..0
    }
    /// Writes the columns of the [derived](Self::derived_states) states into A (n x n, row-major), which holds those of the velocity;
    /// `f` are the rates at the state `x`, all in the units of the states and s.
    fn derive(&self, _x: &[f64], _f: &[f64], _known: &Known, _a: &mut [f64]) {}

    /// States of a plant with an attitude that move as they are given, in ascending runs behind it and beside those of these kinds; they have
    /// no rates. A [`LocalChart`] gives them as functions of time.
    fn given_states(&self) -> &[Range<usize>] {
        &[]
    }

    /// Index of the first late state. Late states enter only the end of an evaluation, so that
    /// derivatives by them need not follow the rest; all of them come after the others.
    fn late_states(&self) -> usize {
        self.states().len()
    }
    /// As [`rates`](Self::rates) where only the `late` states carry derivatives.
    ///
    /// # Panics
    /// Where a plant leaves it to `rates` and has more than [`MAX_STATES`] states or inputs.
    fn rates_by_late<S: Over<f64>>(
        &self,
        t: f64,
        early: &[f64],
        late: &[S],
        u: &[f64],
        dx: &mut [S],
    ) -> Result<(), Fault> {
        let (mut x, mut inputs) = ([S::ZERO; MAX_STATES], [S::ZERO; MAX_STATES]);
        lift(early, &mut x);
        x[early.len()..][..late.len()].copy_from_slice(late);
        lift(u, &mut inputs);
        self.rates(S::from(t), &x[..early.len() + late.len()], &inputs[..u.len()], dx)
    }

    /// [`rates`](Self::rates) in plain numbers. This and those below are what simulators and linearisations call: a plant with
    /// long equations that writes them again for its own type, as they stand here, is compiled once in its own crate and not
    /// again in each that flies it.
    ///
    /// # Errors
    /// Those of `rates`.
    fn rates_in_numbers(&self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        self.rates(t, x, u, dx)
    }
    /// [`rates`](Self::rates) with the derivatives by early states and inputs that one pass of a [`Linearisation`] carries.
    ///
    /// # Errors
    /// Those of `rates`.
    fn rates_in_early(&self, t: f64, x: &[Early], u: &[Early], dx: &mut [Early]) -> Result<(), Fault> {
        self.rates(Early::from(t), x, u, dx)
    }
    /// The same with derivatives by inputs and by such early states alone as are not [placing](Self::placing_states).
    ///
    /// # Errors
    /// Those of `rates`.
    fn rates_in_moving(&self, t: f64, x: &[Early], u: &[Early], dx: &mut [Early]) -> Result<(), Fault> {
        self.rates_in_early(t, x, u, dx)
    }
    /// [`rates_in_early`](Self::rates_in_early), or where nothing `places` [`rates_in_moving`](Self::rates_in_moving), at a point of which the
    /// plant [knows](Self::known) its accelerations and their mass matrix: rates in the units of the states over s. States and rates come
    /// in two parts, the early ones first.
    ///
    /// # Errors
    /// Those of `rates`.
    ///
    /// # Panics
    /// Where a plant leaves it to those and has more than [`MAX_STATES`] states.
    fn rates_about(
        &self,
        known: &Known,
        places: bool,
        (t, [early, late], u): PartsInEarly<'_>,
        [dx, late_dx]: [&mut [Early]; 2],
    ) -> Result<(), Fault> {
        let _ = known;
        let (mut x, mut rates) = ([Early::ZERO; MAX_STATES], [Early::ZERO; MAX_STATES]);
        let n = early.len() + late.len();
        x[..early.len()].copy_from_slice(early);
        x[early.len()..n].copy_from_slice(late);
        let (x, rates) = (&x[..n], &mut rates[..n]);
        if places { self.rates_in_early(t, x, u, rates) } else { self.rates_in_moving(t, x, u, rates) }?;
        dx.copy_from_slice(&rates[..dx.len()]);
        late_dx.copy_from_slice(&rates[dx.len()..]);
        Ok(())
    }
    /// [`rates_by_late`](Self::rates_by_late) with the derivatives by late states that one pass of a [`Linearisation`] carries.
    ///
    /// # Errors
    /// Those of `rates`.
    fn rates_in_late(
        &self,
        t: f64,
        early: &[f64],
        late: &[Late],
        u: &[f64],
        dx: &mut [Late],
    ) -> Result<(), Fault> {
        self.rates_by_late(t, early, late, u, dx)
    }
    /// [`rates`](Self::rates) of four plants in lanes of double precision.
    ///
    /// # Errors
    /// Those of `rates`.
    fn rates_in_double4(
        &self,
        t: Double4,
        x: &[Double4],
        u: &[Double4],
        dx: &mut [Double4],
    ) -> Result<(), Fault> {
        self.rates(t, x, u, dx)
    }
    /// [`rates`](Self::rates) of eight plants in lanes of single precision.
    ///
    /// # Errors
    /// Those of `rates`.
    fn rates_in_single8(
        &self,
        t: Single8,
        x: &[Single8],
        u: &[Single8],
        dx: &mut [Single8],
    ) -> Result<(), Fault> {
        self.rates(t, x, u, dx)
    }
}

/// Time (s), early and late states, and inputs, in the units of their channels.
pub type PartsInEarly<'a> = (f64, [&'a [Early]; 2], &'a [Early]);

/// Lanes in which plants are stepped, each by the rates that the crate of the plant has compiled for them.
pub trait PlantLanes: Lanes {
    /// [`Plant::rates`] in these lanes.
    ///
    /// # Errors
    /// Those of `rates`.
    fn rates_of<P: Plant>(plant: &P, t: Self, x: &[Self], u: &[Self], dx: &mut [Self]) -> Result<(), Fault>;
}

impl PlantLanes for Double4 {
    fn rates_of<P: Plant>(plant: &P, t: Self, x: &[Self], u: &[Self], dx: &mut [Self]) -> Result<(), Fault> {
        plant.rates_in_double4(t, x, u, dx)
    }
}

impl PlantLanes for Single8 {
    fn rates_of<P: Plant>(plant: &P, t: Self, x: &[Self], u: &[Self], dx: &mut [Self]) -> Result<(), Fault> {
        plant.rates_in_single8(t, x, u, dx)
    }
}

/// Most coordinates of a body's structure that its dynamics decide, beyond the six of the body.
pub const MAX_COORDINATES: usize = 16;
/// Order of the mass matrix of body and coordinates.
pub const MAX_DEGREES: usize = 6 + MAX_COORDINATES;

/// Largest state of which the parts are put together on the stack.
pub const MAX_STATES: usize = 160;

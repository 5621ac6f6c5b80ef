//! An extended Kalman filter of a flapping robot: the readings of the sensors that there are against the nominal
//! model.

mod linear;
mod observable;
mod spec;

pub use spec::EstimatorSpec;

use super::history::History;
use crate::orbit::OrbitSection;
use crate::simulate::{
    AXES, Column, Estimator, Instrument, Measurement, NoEstimate, Places, Quantity, Reading, SensorSpec,
    Stepper,
};
use linear::{ErrorRow, FeltLinearisation, Square, erring, grown};
use nalgebra::SMatrix;
use observable::ObservedFlight;
use wingbeat_math::Error;
use wingbeat_math::{Dual, Quat, Vec3};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::Robot;

/// Errors of the body: height, rotation (3), velocity (3), angular rate (3).
const BODY: usize = 10;
/// Where the biases begin, one of each instrument; they stand after the body.
const BIAS: usize = BODY;
/// What the model misses: acceleration and angular acceleration, last.
const MISSED: usize = 6;
/// Rooms for biases: the filter is compiled for each, and the least that holds the instruments is taken. A bias without an
/// instrument is 0 and stays it.
const ROOMS: [usize; 2] = [8, 16];
const FEW: usize = BODY + ROOMS[0] + MISSED;
const MANY: usize = BODY + ROOMS[1] + MISSED;

/// Longest piece of flight with one linearisation, and longest step of the model, s.
const PIECE: f64 = 2.5e-3;
const STEP: f64 = 5e-4;
/// Rounding of times, s.
const ROUNDING: f64 = 1e-9;

/// Numbers that the controller feeds back, as they are recorded: height, then the body's coordinates of the section.
const SEEN: usize = 9;
const NAMES: [(&str, &str, &str); SEEN] = [
    ("height", "m", "W"),
    ("forward", "m/s", ""),
    ("leftward", "m/s", ""),
    ("upward", "m/s", "W"),
    ("roll", "rad", "WB"),
    ("pitch", "rad", "WB"),
    ("w_WB_B_x", "rad/s", "B"),
    ("w_WB_B_y", "rad/s", "B"),
    ("w_WB_B_z", "rad/s", "B"),
];

/// What is believed at one time.
#[derive(Clone)]
struct State<const N: usize> {
    /// s.
    t: f64,
    /// State of the model; what is no body's follows the model.
    x: Vec<f64>,
    biases: Vec<f64>,
    missed: [f64; MISSED],
    /// Covariance of the errors.
    p: Square<N>,
}

/// Instruments that tell together.
struct Kind {
    name: &'static str,
    /// Squares of the newest innovations over their variances, mean over the axes.
    surprise: f64,
    /// Their sum and number while readings of one instant are taken in.
    sum: f64,
    count: f64,
}

impl Kind {
    /// The kinds of `instruments`, as they come.
    fn all(instruments: &[Instrument]) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for name in instruments.iter().map(|instrument| instrument.quantity.kind) {
            if all.iter().all(|kind| kind.name != name) {
                all.push(Self { name, surprise: 1.0, sum: 0.0, count: 0.0 });
            }
        }
        all
    }

    /// Takes in the square of an innovation over its variance.
    fn add(&mut self, square: f64) {
        self.sum += square;
        self.count += 1.0;
    }

    /// Ends an instant.
    fn close(&mut self) {
        if self.count > 0.0 {
            self.surprise = self.sum / self.count;
        }
        (self.sum, self.count) = (0.0, 0.0);
    }
}

/// The filter. Readings are taken in when all that were read before have arrived: what is believed for good lags by the
/// longest delay. From there a copy goes on to now, by what has arrived already, then by the model alone.
struct Inertial<'a, const N: usize> {
    robot: &'a Robot,
    section: OrbitSection,
    places: Places,
    instruments: Vec<Instrument>,
    /// Longest delay, s.
    delay: f64,
    spec: EstimatorSpec,
    history: History,
    model: Stepper<&'a Robot>,
    /// What is believed for good.
    behind: State<N>,
    /// Readings not yet taken in for good, in the order in which they were read.
    readings: Vec<Reading>,
    /// What is believed now.
    now: State<N>,
    /// What is told together: the kinds of the instruments.
    kinds: Vec<Kind>,
}

/// A filter of the readings of `sensors` that believes the flight to begin in the state `x` under the inputs `u`.
///
/// # Errors
/// [`Error::Invalid`] where the robot is no body in the air, where there are too many instruments, or where what is fed back cannot be
/// told from their readings.
pub(super) fn filter<'a>(
    spec: EstimatorSpec,
    sensors: &SensorSpec,
    robot: &'a Robot,
    section: &OrbitSection,
    x: Vec<f64>,
    u: &[f64],
) -> Result<Box<dyn Estimator + 'a>, Error> {
    let places = Places::of(robot.states())
        .ok_or_else(|| Error::invalid("", "given", "an estimator of a robot with a body"))?;
    let instruments = sensors.instruments();
    ObservedFlight { robot, section, places: &places, x: &x, u }.check(&spec, &instruments)?;
    match instruments.len() {
        n if n <= ROOMS[0] => {
            Ok(Box::new(Inertial::<FEW>::new(spec, instruments, places, robot, section.clone(), x)))
        }
        n if n <= ROOMS[1] => {
            Ok(Box::new(Inertial::<MANY>::new(spec, instruments, places, robot, section.clone(), x)))
        }
        n => {
            let allowed = format!("sensors of at most {} numbers", ROOMS[1]);
            Err(Error::invalid("", format!("beside sensors of {n} numbers"), allowed))
        }
    }
}

impl<'a, const N: usize> Inertial<'a, N> {
    fn new(
        spec: EstimatorSpec,
        instruments: Vec<Instrument>,
        places: Places,
        robot: &'a Robot,
        section: OrbitSection,
        x: Vec<f64>,
    ) -> Self {
        let mut deviations = [0.0; N];
        deviations[..BODY].copy_from_slice(&spec.of_body());
        for (deviation, instrument) in deviations[BIAS..].iter_mut().zip(&instruments) {
            *deviation = instrument.bias;
        }
        deviations[N - MISSED..][..3].fill(spec.missed_m_s2);
        deviations[N - MISSED + 3..].fill(spec.missed_rad_s2);
        let p = Square::from_diagonal(&ErrorRow::from_iterator(deviations.iter().map(|d| d * d)));
        let behind = State { t: 0.0, x, biases: vec![0.0; instruments.len()], missed: [0.0; MISSED], p };
        Self {
            section,
            places,
            delay: instruments.iter().map(|i| i.delay).fold(0.0, f64::max),
            kinds: Kind::all(&instruments),
            instruments,
            spec,
            history: History::default(),
            model: Stepper::new(robot, 0.0, &behind.x),
            now: behind.clone(),
            behind,
            readings: Vec::new(),
            robot,
        }
    }

    /// Flies `state` on to `until`.
    fn advance(&mut self, state: &mut State<N>, until: f64) -> Result<(), Fault> {
        while until - state.t > ROUNDING {
            let Some((commands, change)) = self.history.at(state.t + ROUNDING) else { return Ok(()) };
            let commands = commands.to_vec();
            let end = until.min(change).min(state.t + PIECE);
            self.piece(state, &commands, end)?;
        }
        Ok(())
    }

    /// A piece of it: the linearisation is that of its middle.
    ///
    /// Equation: guide.inertial_predict
    /// `x' = f(x, u) + missed, P = F P F' + Q, F = exp(A dt), Q = s^2 (1 - exp(-2 dt/tau)) of what is missed
    /// (Gauss-Markov)`
    /// Source: Kalman 1960; Gelb 1974, Applied Optimal Estimation, ch. 6.
    /// Test: `the_filter_knows_how_well_it_knows`.
    fn piece(&mut self, state: &mut State<N>, u: &[f64], end: f64) -> Result<(), Fault> {
        let length = end - state.t;
        self.fly(state, u, 0.5 * length)?;
        let linear = FeltLinearisation::new(self.robot, &self.places, state.t, &state.x, u, &state.missed)?;
        self.fly(state, u, 0.5 * length)?;
        state.t = end;
        let growth = grown(&linear.rates(self.spec.missed_s), length);
        state.p = growth * state.p * growth.transpose();
        let (stays, missed) = ((-length / self.spec.missed_s).exp(), N - MISSED);
        for i in 0..MISSED {
            let deviation = if i < 3 { self.spec.missed_m_s2 } else { self.spec.missed_rad_s2 };
            state.p[(missed + i, missed + i)] += deviation * deviation * (1.0 - stays * stays);
            state.missed[i] *= stays;
        }
        Ok(())
    }

    /// Flies the model for `length` s; what it misses is added at the end.
    fn fly(&mut self, state: &mut State<N>, u: &[f64], length: f64) -> Result<(), Fault> {
        let steps = (length / STEP - ROUNDING).ceil().max(1.0);
        self.model.reset(state.t, &state.x);
        self.model.set_inputs(u);
        (0..steps as usize).try_for_each(|_| self.model.step(length / steps).map(drop))?;
        state.t += length;
        state.x.copy_from_slice(self.model.state());
        let attitude = Quat::from_wxyz(&state.x[self.places.attitude..]).matrix();
        let velocity = attitude * Vec3::from_slice(&state.missed) * length;
        for i in 0..3 {
            state.x[self.places.velocity + i] += velocity[i];
            state.x[self.places.rate + i] += state.missed[3 + i] * length;
        }
        Ok(())
    }

    /// Takes in `readings` of one instant, one after another about one linearisation.
    ///
    /// Equation: guide.inertial_update
    /// `K = P h/(h'P h + r), x = x + K (z - z_x), P = P - K h'P, one reading after another`
    /// Source: Kalman 1960; sequential processing, Maybeck 1979, ch. 5.
    /// Test: `the_filter_knows_how_well_it_knows`.
    fn take_in(&mut self, state: &mut State<N>, readings: &[Reading]) -> Result<(), Fault> {
        let Some((commands, _)) = self.history.at(state.t + ROUNDING) else { return Ok(()) };
        let linear =
            FeltLinearisation::new(self.robot, &self.places, state.t, &state.x, commands, &state.missed)?;
        let mut errors = ErrorRow::<N>::zeros();
        for reading in readings {
            let (i, instrument) = (reading.instrument, &self.instruments[reading.instrument]);
            let (expected, by_errors): (f64, ErrorRow<N>) = linear.reading(i, instrument, state.biases[i]);
            let innovation = reading.value - expected - by_errors.dot(&errors);
            let spread = state.p * by_errors;
            let variance = by_errors.dot(&spread) + instrument.noise * instrument.noise;
            if variance > 0.0 {
                errors += spread * (innovation / variance);
                state.p -= spread * spread.transpose() / variance;
                let kind = self.kinds.iter_mut().find(|kind| kind.name == instrument.quantity.kind);
                kind.into_iter().for_each(|kind| kind.add(innovation * innovation / variance));
            }
        }
        state.p = (state.p + state.p.transpose()) * 0.5;
        state.correct(&self.places, &errors);
        self.kinds.iter_mut().for_each(Kind::close);
        Ok(())
    }

    /// Takes in all `readings`, which come in the order of time, each when it was read.
    fn follow(&mut self, state: &mut State<N>, readings: &[Reading]) -> Result<(), Fault> {
        for together in readings.chunk_by(|a, b| b.taken - a.taken < ROUNDING) {
            self.advance(state, together[0].taken)?;
            self.take_in(state, together)?;
        }
        Ok(())
    }

    /// What is believed at `t`.
    fn believe(&mut self, t: f64, arrived: &[Reading]) -> Result<State<N>, Fault> {
        self.readings.extend(arrived);
        wingbeat_math::order::ascend_by(&mut self.readings, |item| item.taken);
        let mut readings = std::mem::take(&mut self.readings);
        let settled = readings.partition_point(|r| r.taken <= t - self.delay + ROUNDING);
        let mut behind = self.behind.clone();
        self.follow(&mut behind, &readings[..settled])?;
        let mut now = behind.clone();
        self.follow(&mut now, &readings[settled..])?;
        self.advance(&mut now, t)?;
        self.history.forget(behind.t);
        readings.drain(..settled);
        (self.behind, self.readings) = (behind, readings);
        Ok(now)
    }

    /// The numbers of the state that are fed back, and their standard deviations.
    fn seen(&self) -> ([f64; SEEN], [f64; SEEN]) {
        let x = erring::<BODY>(&self.places, &self.now.x);
        let mut coordinates = vec![Dual::constant(0.0); self.section.len()];
        self.section.coordinates(&x, &mut coordinates);
        let all: [Dual<BODY>; SEEN] =
            std::array::from_fn(|i| if i == 0 { x[self.places.height] } else { coordinates[i - 1] });
        let of_body: SMatrix<f64, BODY, BODY> = self.now.p.fixed_view::<BODY, BODY>(0, 0).into();
        let deviation = all.map(|number| {
            let row = SMatrix::<f64, BODY, 1>::from(number.eps);
            row.dot(&(of_body * row)).max(0.0).sqrt()
        });
        (all.map(|number| number.re), deviation)
    }
}

impl<const N: usize> Estimator for Inertial<'_, N> {
    fn estimate(
        &mut self,
        t: f64,
        measurement: &Measurement,
        u: &[f64],
        x: &mut [f64],
    ) -> Result<(), NoEstimate> {
        self.history.note(t, u);
        self.now = self.believe(t, measurement.readings())?;
        x.copy_from_slice(&self.now.x);
        Ok(())
    }

    fn columns(&self) -> Vec<Column> {
        let seen = NAMES.map(|(name, unit, frame)| Column::new(format!("estimate_{name}"), unit, frame));
        let deviations =
            NAMES.map(|(name, unit, frame)| Column::new(format!("estimate_deviation_{name}"), unit, frame));
        let bias = |instrument: &Instrument| {
            let Quantity { name, unit, frame, .. } = instrument.quantity;
            Column::new(format!("estimate_bias_{name}"), unit, frame)
        };
        let missed = AXES.map(|axis| Column::new(format!("estimate_missed_{axis}"), "m/s2", "B"));
        let turning = AXES.map(|axis| Column::new(format!("estimate_missed_turning_{axis}"), "rad/s2", "B"));
        let innovation = |kind: &Kind| Column::new(format!("estimate_innovation_{}", kind.name), "", "");
        std::iter::once(Column::new("estimate_t", "s", ""))
            .chain(seen)
            .chain(deviations)
            .chain(self.instruments.iter().map(bias))
            .chain(missed)
            .chain(turning)
            .chain(self.kinds.iter().map(innovation))
            .collect()
    }

    fn diagnostics(&self, row: &mut Vec<f64>) {
        let (seen, deviations) = self.seen();
        row.push(self.now.t);
        row.extend(seen);
        row.extend(deviations);
        row.extend(&self.now.biases);
        row.extend(self.now.missed);
        row.extend(self.kinds.iter().map(|kind| kind.surprise));
    }
}

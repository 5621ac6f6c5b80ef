//! Small errors of a believed flight: how they grow and what instruments see of them.

use super::{BIAS, BODY, MISSED, State};
use crate::simulate::{Erring, FeltMotion, Instrument, Places};
use nalgebra::{SMatrix, SVector};
use wingbeat_math::{Dual, Quat, Scalar, Vec3};
use wingbeat_ocp::plant::{Early, Fault, Plant};
use wingbeat_robot::Robot;

/// `N` errors of a belief: height, rotation in B, velocity in W, angular rate; biases, as many as there is room for; acceleration and
/// angular acceleration missed by the model, in B.
pub(super) type Square<const N: usize> = SMatrix<f64, N, N>;
/// One number by those errors.
pub(super) type ErrorRow<const N: usize> = SVector<f64, N>;

/// Directions of the body's own errors, then of what is missed.
type Wide = Erring;
const _: () = assert!(Wide::LANES == BODY + MISSED);

/// What is felt at a state, with derivatives by the errors of body and what is missed.
pub(super) struct FeltLinearisation {
    motion: FeltMotion<Wide>,
    rate: Vec3,
}

/// The state `x` whose body errs along the first directions: height, rotation q exp(d), velocity, angular rate.
pub(super) fn erring<const N: usize>(places: &Places, x: &[f64]) -> Vec<Dual<N>> {
    let mut erring: Vec<Dual<N>> = x.iter().map(|x| Dual::constant(*x)).collect();
    erring[places.height].eps[0] = 1.0;
    let rotation = Vec3(std::array::from_fn(|i| Dual::variable(0.0, 1 + i)));
    let attitude = Quat::constant(Quat::from_wxyz(&x[places.attitude..])) * Quat::exp(rotation);
    attitude.store_wxyz(&mut erring[places.attitude..]);
    for i in 0..3 {
        erring[places.velocity + i].eps[4 + i] = 1.0;
        erring[places.rate + i].eps[7 + i] = 1.0;
    }
    erring
}

/// The same number with room for the directions of what is missed.
fn widened(narrow: Early) -> Wide {
    let mut wide = Wide::constant(narrow.re);
    wide.eps[..BODY].copy_from_slice(&narrow.eps[..BODY]);
    wide
}

impl FeltLinearisation {
    /// At the time `t` in the state `x` under `u`, `missed` being the accelerations missed there (m/s2 and rad/s2).
    pub fn new(
        robot: &Robot,
        places: &Places,
        t: f64,
        x: &[f64],
        u: &[f64],
        missed: &[f64; MISSED],
    ) -> Result<Self, Fault> {
        let state = erring::<{ Early::LANES }>(places, x);
        let u: Vec<Early> = u.iter().map(|u| Dual::constant(*u)).collect();
        let mut dx = vec![Dual::constant(0.0); x.len()];
        robot.rates_in_early(t, &state, &u, &mut dx)?;
        let wide = |values: &[Early]| values.iter().map(|v| widened(*v)).collect::<Vec<Wide>>();
        let mut motion = places.motion(&wide(&state), &wide(&dx), robot.mean_wind());
        let missed: [Wide; MISSED] = std::array::from_fn(|i| Wide::variable(missed[i], BODY + i));
        motion.acceleration += motion.attitude * Vec3::from_slice(&missed);
        motion.angular_acceleration += Vec3::from_slice(&missed[3..]);
        Ok(Self { rate: motion.rate.values(), motion })
    }

    /// Rates of the errors by the errors; what is missed decays over `lasting` s.
    ///
    /// Equation: guide.inertial_errors
    /// `h' = v_z, d' = dw - w x d of q exp(d), v' and w' by derivatives of the robot's rates, v' + R m_f, w' + m_w,
    /// m' = -m/tau, biases constant`
    /// Source: error-state filter, Sola 2017, arXiv:1711.02508; own derivation.
    /// Test: `errors_grow_as_their_rates_say`.
    pub fn rates<const N: usize>(&self, lasting: f64) -> Square<N> {
        let mut f = Square::<N>::zeros();
        f[(0, 6)] = 1.0;
        // d' = dw - w x d of q exp(d) about a believed attitude that turns with w.
        for (j, axis) in [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)]
            .into_iter()
            .enumerate()
        {
            let turned = axis.cross(self.rate);
            (0..3).for_each(|i| f[(1 + i, 1 + j)] = turned[i]);
            f[(1 + j, 7 + j)] = 1.0;
        }
        for i in 0..3 {
            f.set_row(4 + i, &row::<N>(&self.motion.acceleration[i]).transpose());
            f.set_row(7 + i, &row::<N>(&self.motion.angular_acceleration[i]).transpose());
        }
        for i in N - MISSED..N {
            f[(i, i)] = -1.0 / lasting;
        }
        f
    }

    /// What instrument number `i` would read, in its unit, its bias being `bias`, and its derivatives by the errors.
    pub fn reading<const N: usize>(
        &self,
        i: usize,
        instrument: &Instrument,
        bias: f64,
    ) -> (f64, ErrorRow<N>) {
        let (read, mut by_errors) = self.felt(instrument);
        by_errors[BIAS + i] = 1.0;
        (read + bias, by_errors)
    }

    /// The same of an instrument without a bias.
    pub fn felt<const N: usize>(&self, instrument: &Instrument) -> (f64, ErrorRow<N>) {
        let read = instrument.reads_erring(&self.motion);
        (read.value(), row(&read))
    }
}

/// Derivatives of a number by the errors.
fn row<const N: usize>(wide: &Wide) -> ErrorRow<N> {
    let mut row = ErrorRow::zeros();
    for (i, slope) in wide.eps.iter().enumerate() {
        row[if i < BODY { i } else { i + N - (BODY + MISSED) }] = *slope;
    }
    row
}

/// exp(F dt) to the fourth order: |F dt| is a tenth.
pub(super) fn grown<const N: usize>(f: &Square<N>, dt: f64) -> Square<N> {
    let step = f * dt;
    let mut power = Square::identity();
    let mut sum = Square::identity();
    for k in 1..=4 {
        power = power * step / f64::from(k);
        sum += power;
    }
    sum
}

impl<const N: usize> State<N> {
    /// Takes in the errors `d`.
    pub fn correct(&mut self, places: &Places, d: &ErrorRow<N>) {
        let at = |first: usize| Vec3::new(d[first], d[first + 1], d[first + 2]);
        self.x[places.height] += d[0];
        let attitude = Quat::from_wxyz(&self.x[places.attitude..]) * Quat::exp(at(1));
        attitude.normalized().store_wxyz(&mut self.x[places.attitude..]);
        for i in 0..3 {
            self.x[places.velocity + i] += d[4 + i];
            self.x[places.rate + i] += d[7 + i];
        }
        for (i, bias) in self.biases.iter_mut().enumerate() {
            *bias += d[BIAS + i];
        }
        for (i, missed) in self.missed.iter_mut().enumerate() {
            *missed += d[N - MISSED + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::Stepper;
    use wingbeat_ocp::plant::Plant;
    use wingbeat_robot::{Air, RobotSpec, Wind};

    #[test]
    fn errors_grow_as_their_rates_say() {
        let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/aerobat_paper.toml"));
        let spec: RobotSpec = toml::from_str(text).unwrap();
        let air = Air { density: wingbeat_math::SEA_LEVEL_DENSITY, wind: Wind::steady(Vec3::ZERO) };
        let outlines = spec.outlines().unwrap();
        let aero = outlines.iter().map(|outline| {
            let settings = wingbeat_aero::StripSettings {
                strips: 9,
                hinge_arcs_m: outline.hinges.clone(),
                ..Default::default()
            };
            wingbeat_aero::StripModel::new(&outline.planform, settings)
                .map(wingbeat_aero::Aero::Strip)
                .unwrap()
        });
        let robot = Robot::new(&spec, aero.collect(), air, 0.0).unwrap();
        let places = Places::of(robot.states()).unwrap();
        let mut x = vec![0.0; robot.states().len()];
        Quat::from_roll_pitch_yaw(0.3, -0.2, 0.5).store_wxyz(&mut x[places.attitude..]);
        Vec3::new(4.0, 0.3, -0.5).store(&mut x[places.velocity..]);
        Vec3::new(1.0, -2.0, 0.5).store(&mut x[places.rate..]);
        let state = |p| State { t: 0.0, x: x.clone(), biases: vec![0.0; 8], missed: [0.0; MISSED], p };
        let u = vec![0.0; robot.inputs().len()];
        let dt = 1e-4;
        let flown = |x: &[f64]| {
            let mut model = Stepper::new(&robot, 0.0, x);
            model.step(dt).unwrap();
            model.state().to_vec()
        };
        // In the middle of the step, where the states of the air do not err.
        let middle = {
            let mut model = Stepper::new(&robot, 0.0, &x);
            model.step(0.5 * dt).unwrap();
            model.state().to_vec()
        };
        let linear = FeltLinearisation::new(&robot, &places, 0.5 * dt, &middle, &u, &[0.0; MISSED]).unwrap();
        let growth: Square<{ BODY + 8 + MISSED }> = grown(&linear.rates(0.1), dt);
        let (size, nominal) = (1e-5, flown(&x));
        for column in 0..BODY {
            let mut off = state(Square::<{ BODY + 8 + MISSED }>::identity());
            let mut error = ErrorRow::zeros();
            error[column] = size;
            off.correct(&places, &error);
            let end = flown(&off.x);
            let turned = Quat::from_wxyz(&nominal[places.attitude..]).conjugate()
                * Quat::from_wxyz(&end[places.attitude..]);
            let mut grown_to = vec![end[places.height] - nominal[places.height]];
            grown_to.extend(turned.log().0);
            grown_to.extend((0..3).map(|i| end[places.velocity + i] - nominal[places.velocity + i]));
            grown_to.extend((0..3).map(|i| end[places.rate + i] - nominal[places.rate + i]));
            for (row, to) in grown_to.iter().enumerate() {
                let expected = growth[(row, column)];
                let off = (to / size - expected).abs();
                assert!(
                    off < 2e-3 * expected.abs().max(1.0),
                    "{row} by {column}: {} for {expected}",
                    to / size
                );
            }
        }
    }
}

//! Whether instruments tell what is fed back.

use super::linear::{FeltLinearisation, Square, erring, grown};
use super::spec::EstimatorSpec;
use super::{BODY, MISSED, NAMES, PIECE, SEEN, STEP};
use crate::orbit::OrbitSection;
use crate::simulate::{Instrument, Places, SensorSpec, Stepper};
use nalgebra::{SMatrix, SVector};
use wingbeat_math::Dual;
use wingbeat_math::Error;
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::Robot;

/// Errors of the body and what the model misses: no bias, of which its data sheet says how large it is.
const ERRORS: usize = BODY + MISSED;
/// Least information of a direction, over that of the belief at the start. What a cycle of readings tells less of is not observable.
/// *Choice.*
const LEAST: f64 = 1e-3;
/// Noise of an instrument that has none, in its unit.
const FAULTLESS: f64 = 1e-6;
/// Largest share of a fed back number's deviation that may lie in directions that are not observable. *Choice.*
const HIDDEN: f64 = 0.1;

type BodyMatrix = SMatrix<f64, BODY, BODY>;

/// A flight that is to be seen: it begins in the state `x` under the inputs `u`.
pub(super) struct ObservedFlight<'a> {
    pub robot: &'a Robot,
    pub section: &'a OrbitSection,
    pub places: &'a Places,
    pub x: &'a [f64],
    pub u: &'a [f64],
}

impl ObservedFlight<'_> {
    /// Refuses `instruments` that leave a number which is fed back unobservable over a cycle; says which, and which sensor would tell it.
    ///
    /// Equation: guide.observability
    /// `W = sum of Phi' H' H Phi / r over the readings of a cycle, Phi the errors' growth since its start; a number
    /// s is observable if no more than a tenth of S P0 S' lies along eigenvectors of P0^1/2 W P0^1/2 below .001`
    /// Source: observability Gramian, Kalman 1960; limits chosen.
    /// Test: `what_no_instrument_tells_is_refused_by_its_name_with_the_sensor_that_would`.
    pub fn check(&self, spec: &EstimatorSpec, instruments: &[Instrument]) -> Result<(), Error> {
        let hidden = |instruments: &[Instrument]| {
            let broken = |fault: Fault| Error::invalid("", "given", format!("a model that flies: {fault}"));
            self.hidden(spec, instruments).map_err(broken)
        };
        let missing = hidden(instruments)?;
        if missing.is_empty() {
            return Ok(());
        }
        let mut telling = Vec::new();
        for (name, more) in SensorSpec::examples() {
            let with: Vec<Instrument> = instruments.iter().chain(&more).copied().collect();
            if hidden(&with)?.len() < missing.len() {
                telling.push(format!("[sensors.{name}]"));
            }
        }
        let names: Vec<&str> = missing.iter().map(|i| NAMES[*i].0).collect();
        let given = format!("beside sensors that do not tell {}", names.join(", "));
        let allowed = match telling.is_empty() {
            true => {
                "sensors that together tell what is fed back: [sensors.imu] and [sensors.height]".to_owned()
            }
            false => format!("what is fed back observable over a cycle: {} tells more", telling.join(" or ")),
        };
        Err(Error::invalid("", given, allowed))
    }

    /// Numbers of [`NAMES`] that the readings of a cycle do not tell.
    fn hidden(&self, spec: &EstimatorSpec, instruments: &[Instrument]) -> Result<Vec<usize>, Fault> {
        let scale = BodyMatrix::from_diagonal(&SVector::from(spec.of_body()));
        let information = (scale * self.information(spec, instruments)? * scale).symmetric_eigen();
        let numbers = self.fed_back() * scale;
        let unseen = |row: usize| {
            let along = information.eigenvectors.transpose() * numbers.row(row).transpose();
            let dark = along.iter().zip(&information.eigenvalues).filter(|(_, told)| **told < LEAST);
            let dark: f64 = dark.map(|(along, _)| along * along).sum();
            dark.sqrt() > HIDDEN * along.norm()
        };
        Ok((0..SEEN).filter(|row| unseen(*row)).collect())
    }

    /// What the readings of a cycle tell of the errors at its start: the sum of Phi' H' H Phi / r over the readings.
    fn information(&self, spec: &EstimatorSpec, instruments: &[Instrument]) -> Result<BodyMatrix, Fault> {
        let cycle = self.robot.frequency_hz().recip();
        let pieces = (cycle / PIECE).ceil();
        let length = cycle / pieces;
        let mut model = Stepper::new(self.robot, 0.0, self.x);
        model.set_inputs(self.u);
        let (mut flow, mut sum) = (BodyMatrix::identity(), BodyMatrix::zeros());
        for piece in 0..pieces as usize {
            let t = length * piece as f64;
            let linear =
                FeltLinearisation::new(self.robot, self.places, t, model.state(), self.u, &[0.0; MISSED])?;
            for instrument in instruments {
                let row = flow.transpose() * linear.felt::<ERRORS>(instrument).1.fixed_rows::<BODY>(0);
                // A piece holds that many readings of the instrument.
                let readings = length / instrument.every;
                sum += row * row.transpose() * (readings / instrument.noise.max(FAULTLESS).powi(2));
            }
            let rates: Square<ERRORS> = linear.rates(spec.missed_s);
            flow = grown(&rates, length).fixed_view::<BODY, BODY>(0, 0) * flow;
            let steps = (length / STEP).ceil();
            (0..steps as usize).try_for_each(|_| model.step(length / steps).map(drop))?;
        }
        Ok(sum)
    }

    /// The numbers that are fed back by the errors of the body.
    fn fed_back(&self) -> SMatrix<f64, SEEN, BODY> {
        let x = erring::<BODY>(self.places, self.x);
        let mut coordinates = vec![Dual::constant(0.0); self.section.len()];
        self.section.coordinates(&x, &mut coordinates);
        SMatrix::from_fn(|i, j| if i == 0 { x[self.places.height].eps[j] } else { coordinates[i - 1].eps[j] })
    }
}
